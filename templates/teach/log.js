// A log of answers for a trial: off until a student agrees, kept by this browser alone, never sent; see docs/teaching.
const Log = (() => {
  const box = document.querySelector(".log"), [agree, code] = box.querySelectorAll("input"), [save, forget] = box.querySelectorAll("button");
  const FORMAT = "symdyn log 1", MOST = 5000, LONGEST = 1000, key = `symdyn.log.${box.dataset.lesson}`;
  let kept = null;  // null until somebody agrees: before, no storage is read or written
  let isStored = false;
  const empty = () => ({format: FORMAT, lesson: box.dataset.lesson, language: document.documentElement.lang, code: "", events: []});
  const say = name => { for (const note of box.querySelectorAll(".note")) note.hidden = note.dataset.note !== name; };
  function stored() {
    try {
      const found = JSON.parse(localStorage.getItem(key));
      if (found && found.format === FORMAT && typeof found.code === "string" && Array.isArray(found.events)) return found;
    } catch { /* no storage here, or no log in it */ }
    return null;
  }
  function write() {
    try {
      localStorage.setItem(key, JSON.stringify(kept));
      isStored = true;
    } catch { isStored = false; }
    say(isStored ? "on" : "unkept");
  }
  // What is kept now: another window of this lesson writes, too, or has deleted it
  const now = () => stored() || (isStored ? {...empty(), code: kept.code} : kept);
  function add(event) {
    if (!agree.checked) return;
    kept = now();
    if (kept.events.length >= MOST) return say("full");
    if (event.typed) event.typed = event.typed.slice(0, LONGEST);
    kept.events.push({...event, time: new Date().toISOString()});
    write();
  }
  agree.checked = false;  // whatever the browser remembers
  agree.addEventListener("change", () => {
    if (agree.checked) {
      kept = stored() || kept || empty();
      code.value = kept.code;
      write();
    } else say("off");
    code.disabled = !agree.checked;
    save.disabled = forget.disabled = kept === null;
  });
  code.addEventListener("change", () => {
    if (!agree.checked) return;
    kept = {...now(), code: code.value};
    write();
  });
  save.addEventListener("click", () => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([JSON.stringify(kept, null, 1) + "\n"], {type: "application/json"}));
    link.download = `${["log", kept.code.replace(/[^\w-]/g, ""), box.dataset.lesson].filter(Boolean).join("-")}.json`;
    link.click();
    URL.revokeObjectURL(link.href);
  });
  forget.addEventListener("click", () => {
    try { localStorage.removeItem(key); } catch { /* it holds nothing */ }
    kept = null;
    agree.checked = false;
    code.value = "";
    code.disabled = save.disabled = forget.disabled = true;
    say("gone");
  });
  return {add};
})();
