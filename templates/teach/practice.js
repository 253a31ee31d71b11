// Exercises of a page: answers are judged, solutions opened; what follows is shown when all that it needs is done.
(() => {
  const done = new Set();
  function found(form) {
    done.add(form.dataset.number);
    for (const step of document.querySelectorAll("[data-needs][hidden]")) {
      step.hidden = !step.dataset.needs.split(" ").every(number => done.has(number));
    }
    for (const note of document.querySelectorAll(".waits")) {
      note.hidden = !note.parentElement.querySelector("[data-needs][hidden]");
    }
  }
  for (const form of document.querySelectorAll("form.blank")) {
    const solution = form.querySelector(".solution");
    form.addEventListener("submit", event => {
      event.preventDefault();
      const verdict = form.querySelector(".verdict"), told = Answers.judge(form.dataset.key, form.elements.answer.value);
      verdict.textContent = told.text;
      verdict.className = "verdict " + (told.right ? "right" : "wrong");
      if (told.right) solution.open = true;
    });
    solution.addEventListener("toggle", () => { if (solution.open) found(form); });
    if (solution.open) found(form);  // as the browser keeps it
  }
})();
