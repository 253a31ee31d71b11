"use strict";
// Answers in two dimensions: a field of MathLive stands for each box, which keeps what is typed, in LaTeX, for the judge.
(() => {
  if (window !== window.top && window.origin === "null") return; // in a sandbox, where MathLive fails: typed as text
  const {letters, words, keys} = EDITOR, {commands} = QUESTIONS.grammar;
  const read = name => Object.hasOwn(commands, name) ? commands[name][0] : "";

  // \theta_1 and its rates by theta1, theta1', theta1'', where the scene has no such letter but the judge knows it
  function greek() {
    const found = {};
    for (const typed of Object.keys(QUESTIONS.symbols)) {
      const [, head, index] = /^([A-Za-z]+?)([0-9]+)$/.exec(typed) || [];
      if (!head || read(head) !== "word" || letters[typed]) continue;
      for (const [prime, latex] of [["", `\\${head}`], ["'", `\\dot{\\${head}}`], ["''", `\\ddot{\\${head}}`]]) {
        found[typed + prime] = `${latex}_{${index}}`;
      }
    }
    return found;
  }

  // Of MathLive's own those that the judge reads: Greek letters and functions by their names
  const shortcuts = own => ({
    ...Object.fromEntries(Object.entries(own).filter(([typed, latex]) => latex === `\\${typed}` && read(typed))),
    ...greek(), ...letters, sqrt: "\\sqrt{#?}", "*": "\\cdot",
  });

  const open = latex => latex.split("(").length - latex.split(")").length;

  // What stands before the caret in its fraction, root or exponent: where that begins, and its LaTeX
  function before(field) {
    const at = field.position;
    field.executeCommand("extendToGroupStart");
    const [from] = field.selection.ranges[0], latex = field.getValue(from, at, "latex");
    field.position = at;
    return [from, latex];
  }

  // Brackets as in a line of text: one that closes leaves what has none open, and all of a bracket goes over a "/"
  function bracketed(field, key) {
    if (key !== ")" && key !== "/") return; // a caret that is moved ends what is typed of a name
    if (key === ")") for (let k = 0; k < 9 && open(before(field)[1]) <= 0; k++) field.executeCommand("moveAfterParent");
    const [first, latex] = before(field), at = field.position;
    if (key === ")" || !latex.endsWith(")")) return;
    let from = at - 1;
    while (from > first && open(field.getValue(from, at, "latex"))) from--;
    if (from > first && /^\\(?!cdot)[a-z]+ *$/.test(field.getValue(from - 1, from, "latex"))) from--;
    field.selection = {ranges: [[from, at]]};
  }

  function begin() {
    Object.assign(MathfieldElement, {fontsDirectory: null, soundsDirectory: null, locale: document.documentElement.lang});
    for (const box of document.querySelectorAll('form.blank input[type="text"]')) edited(box);
    const all = [...new Set(Object.values(letters))], rows = Array.from({length: Math.ceil(all.length / 8)}, (_, k) => all.slice(8 * k, 8 * k + 8));
    mathVirtualKeyboard.layouts = [{label: words.letters, rows}, {label: "+ ( )", rows: keys}];
  }

  function edited(box) {
    const field = new MathfieldElement(), change = document.createElement("button");
    change.type = "button";
    const shown = typed => {
      box.classList.toggle("covered", !typed);
      box.tabIndex = typed ? 0 : -1;
      field.hidden = typed;
      change.textContent = typed ? words.formula : words.text;
      if (!typed) field.value = box.value;
    };
    field.setAttribute("aria-label", box.labels[0].textContent);
    field.addEventListener("input", () => {
      box.value = field.value.replaceAll("\\placeholder", ""); // what is left empty is missing
      box.dispatchEvent(new Event("input"));
    });
    field.addEventListener("keydown", event => {
      if (event.key === "Enter") box.form.requestSubmit();
      if (field.selectionIsCollapsed) bracketed(field, event.key);
    }, {capture: true});
    box.addEventListener("focus", () => { if (!field.hidden) field.focus(); });
    change.addEventListener("click", () => {
      shown(!field.hidden);
      (field.hidden ? box : field).focus();
    });
    box.after(field);
    box.parentElement.append(" ", change);
    field.menuItems = [];
    field.smartFence = false; // it would close a bracket behind the first letter that a shortcut makes
    field.inlineShortcuts = shortcuts(field.inlineShortcuts);
    shown(false);
  }

  const script = document.createElement("script"), text = document.getElementById("mathlive").textContent;
  script.src = URL.createObjectURL(new Blob([text], {type: "text/javascript"}));
  script.addEventListener("load", begin);
  document.head.append(script);
})();
