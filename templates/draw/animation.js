"use strict";
(() => {
  const motion = JSON.parse(document.getElementById("motion").textContent);
  const svg = document.querySelector("svg.symdyn");
  const moving = [...svg.querySelectorAll("[data-k]")].map(element => ({
    element, at: Number(element.dataset.k), kind: element.dataset.kind,
    parts: (element.dataset.parts || "").split(" ").map(Number), end: element.dataset.closed ? "Z" : ""
  }));
  const groups = new Map([...svg.querySelectorAll("[data-item]")].map(g => [Number(g.dataset.item), g]));
  const top = document.createComment("marks");
  const last = [...groups.values()].pop();
  if (last) last.after(top);
  const play = document.getElementById("play"), slider = document.getElementById("time");
  const clock = document.getElementById("clock"), speed = document.getElementById("speed");
  const t = motion.t, n = t.length, length = t[n - 1];
  let now = 0, before = null, running = false, shownOrder = 0, shown = 0;
  slider.max = n - 1;

  const path = (m, x) => {
    let d = "", k = m.at;
    for (const count of m.parts) {
      for (let i = 0; i < count; i++, k += 2) d += (i ? "L" : "M") + x[k] / 10 + " " + x[k + 1] / 10;
      d += m.end;
    }
    return d;
  };
  const draw = {
    path: (m, x) => m.element.setAttribute("d", path(m, x)),
    dot: (m, x) => {
      m.element.setAttribute("cx", x[m.at] / 10);
      m.element.setAttribute("cy", x[m.at + 1] / 10);
    },
    disc: (m, x) => {
      const place = `translate(${x[m.at] / 10} ${x[m.at + 1] / 10}) rotate(${x[m.at + 3] / 10})`;
      m.element.setAttribute("transform", place);
      m.element.setAttribute("ry", x[m.at + 2] / 10);
    },
    sign: (m, x) => m.element.setAttribute("transform", `translate(${x[m.at] / 10} ${x[m.at + 1] / 10})`),
    label: (m, x) => m.element.setAttribute("transform", `translate(${x[m.at] / 10} ${x[m.at + 1] / 10})`)
  };

  const sorted = frame => {
    let k = motion.order.length - 1;
    while (k > 0 && motion.order[k][0] > frame) k--;
    if (k === shownOrder) return;
    shownOrder = k;
    for (const item of motion.order[k][1]) top.before(groups.get(item));
  };
  const show = frame => {
    shown = frame;
    for (const m of moving) draw[m.kind](m, motion.x[frame]);
    if (motion.view) svg.setAttribute("viewBox", motion.view[frame]);
    sorted(frame);
    slider.value = frame;
    const text = "t = " + (motion.first + t[frame]).toFixed(2) + " s";
    slider.setAttribute("aria-valuetext", text);
    clock.textContent = text;
  };
  const frameAt = time => {
    let low = 0, high = n - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (t[middle] <= time) low = middle; else high = middle - 1;
    }
    return low;
  };
  const go = frame => { now = t[Math.min(n - 1, Math.max(0, frame))]; show(frameAt(now)); };
  const tick = stamp => {
    if (!running) return;
    if (before !== null) now += (stamp - before) / 1000 * Number(speed.value);
    before = stamp;
    const over = now > length;
    if (over) now = motion.once ? length : length > 0 ? now % length : 0;
    show(frameAt(now));
    if (over && motion.once) run(false);
    else requestAnimationFrame(tick);
  };
  const run = on => {
    running = on && n > 1;
    before = null;
    if (running && motion.once && now >= length) now = 0;
    play.textContent = running ? "Pause" : "Play";
    if (running) requestAnimationFrame(tick);
  };

  play.addEventListener("click", () => run(!running));
  slider.addEventListener("input", () => { run(false); go(Number(slider.value)); });
  document.addEventListener("keydown", event => {
    if (event.altKey || event.ctrlKey || event.metaKey || event.target === speed) return;
    const steps = { ArrowLeft: -1, ArrowRight: 1, PageDown: -10, PageUp: 10 };
    if (event.key === " " && event.target !== play) run(!running);
    else if (event.key in steps) { run(false); go(shown + steps[event.key]); }
    else if (event.key === "Home") { run(false); go(0); }
    else if (event.key === "End") { run(false); go(n - 1); }
    else return;
    event.preventDefault();
  });
  show(0);
  run(!matchMedia("(prefers-reduced-motion: reduce)").matches);
})();
