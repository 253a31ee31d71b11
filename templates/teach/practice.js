// Exercises of a page: answers are judged, solutions opened; what follows is shown when all that it needs is done.
(() => {
  const {words, choices} = QUESTIONS, forms = [...document.querySelectorAll("form.blank")];
  const progress = document.querySelector(".progress"), done = new Set();
  const open = () => forms.filter(form => !done.has(form.dataset.number));
  function found(form) {
    done.add(form.dataset.number);
    for (const step of document.querySelectorAll("[data-needs][hidden]")) {
      step.hidden = !step.dataset.needs.split(" ").every(number => done.has(number));
    }
    for (const note of document.querySelectorAll(".waits")) {
      note.hidden = !note.parentElement.querySelector("[data-needs][hidden]");
    }
    counted();
  }
  function counted() {
    const text = words["answer.progress"].replace("{done}", done.size).replace("{all}", forms.length);
    const output = progress.querySelector("output");
    if (output.textContent !== text) output.textContent = text;
    progress.querySelector("button").disabled = done.size === forms.length;
  }
  // The first open question behind where the reader is, or the first of all
  function next() {
    const here = document.activeElement.closest("form.blank") || last;
    const rest = open(), behind = here && rest.find(form => here.compareDocumentPosition(form) & Node.DOCUMENT_POSITION_FOLLOWING);
    const form = behind || rest[0];
    if (!form) return;
    const fold = form.closest(".more");
    if (fold) fold.open = true;
    form.scrollIntoView({block: "center"});
    form.querySelector("input").focus({preventScroll: true});
  }
  let last = null;
  // What is chosen is right when it is all that is right; of what is wrong the reasons are told
  function chosen(form, verdict) {
    const right = choices[form.dataset.key], boxes = [...form.querySelectorAll("input")].filter(box => box.checked);
    const wrong = boxes.filter(box => !right.includes(box.value));
    const word = !boxes.length ? "fault.empty" : wrong.length ? "answer.chosen" : boxes.length < right.length ? "answer.more" : "answer.right";
    verdict.textContent = words[word];
    for (const box of wrong) {
      const reason = box.closest("p").querySelector(".why").cloneNode(true);
      reason.hidden = false;
      verdict.append(` ${box.value}) `, reason);
    }
    return {right: word === "answer.right", typed: boxes.map(box => box.value).join(", ")};
  }
  function shown(inside) {
    const math = document.createElementNS("http://www.w3.org/1998/Math/MathML", "math");
    math.innerHTML = inside;
    return math;
  }
  const LIKE = {weight: "gravity", hung: "gravity", springs: "spring", friction: "load", law: "load", force: "load", flow: "load", slope: "rates", cancelling: "rates", product: "rates", row: ""};
  // Which kinds of terms differ is told after the second try, the terms after the third
  function differing(told, tries, verdict) {
    const said = key => words["answer.kind." + key];
    const kinds = [...new Set((told.kinds || []).map(kind => said(kind) || said(LIKE[kind] ?? "inertia")))].filter(Boolean);
    if (kinds.length && tries > 1) verdict.append(" " + said("look").replace("{text}", kinds.join(", ")));
    if (tries > 2) for (const [change, term] of told.changes || []) verdict.append(` ${words.changes[change]}`, ...(term ? [": ", shown(term)] : []), ".");
  }
  for (const form of forms) {
    const solution = form.querySelector(".solution"), verdict = form.querySelector(".verdict");
    form.addEventListener("focusin", () => { last = form; });
    const echo = form.querySelector(".echo");
    if (echo) form.elements.answer.addEventListener("input", event => {
      const read = Echo.mathematics(event.target.value);
      echo.querySelector("span").replaceChildren(shown(read));
      echo.classList.toggle("read", read !== "");
    });
    let tries = 0, right = false;
    form.addEventListener("submit", event => {
      event.preventDefault();
      let told;
      if (Object.prototype.hasOwnProperty.call(choices, form.dataset.key)) told = chosen(form, verdict);
      else {
        told = {...Answers.judge(form.dataset.key, form.elements.answer.value), typed: form.elements.answer.value};
        verdict.textContent = [told.text, told.stars].filter(Boolean).join(" ");
        tries += !told.right;
        differing(told, tries, verdict);
      }
      right = told.right;
      const causes = told.rules || [told.rule].filter(Boolean);
      Log.add({event: "answer", question: form.dataset.key, typed: told.typed, right, causes, told: verdict.textContent});
      verdict.className = "verdict " + (right ? "right" : "wrong");
      if (right) solution.open = true;
    });
    solution.addEventListener("toggle", () => {
      if (!solution.open) return;
      if (!right) Log.add({event: "solution", question: form.dataset.key});
      found(form);
    });
    if (solution.open) found(form);  // as the browser keeps it
  }
  progress.querySelector("button").addEventListener("click", next);
  progress.hidden = false;
  counted();
})();
