"use strict";
const find = id => document.getElementById(id);
const here = location.pathname.replace(/\/?$/, "/");
let sending = false, next = null, pulling = "", shown = [], last = [];

async function send(value) {              // one at a time; of those that wait only the last
  next = value;
  if (sending) return;
  sending = true;
  while (next !== null) {
    const body = JSON.stringify(next);
    next = null;
    try {
      await fetch(here + "pull", { method: "POST", headers: { "Content-Type": "application/json" }, body });
    } catch { break; }
  }
  sending = false;
}

function list(id, lines) {
  find(id).replaceChildren(...lines.map(line => {
    const item = document.createElement("li");
    item.textContent = line;
    return item;
  }));
}

function row(slider) {
  const line = document.createElement("div"), label = document.createElement("label");
  const input = document.createElement("input"), output = document.createElement("output");
  line.className = "slider";
  input.type = "range";
  input.id = "slider-" + slider.name;
  label.htmlFor = input.id;
  label.textContent = slider.name;
  input.addEventListener("input", () => {
    pulling = slider.name;
    send({ name: slider.name, value: Number(input.value) });
  });
  input.addEventListener("change", () => { pulling = ""; sliders(last); });   // where it could not go it is not
  line.append(label, input, output);
  return line;
}

function sliders(found) {
  last = found;
  const names = JSON.stringify(found.map(one => one.name));
  if (names !== JSON.stringify(shown)) {
    shown = found.map(one => one.name);
    find("sliders").replaceChildren(...found.map(row));
  }
  found.forEach((one, k) => {
    const [, input, output] = find("sliders").children[k].children;
    input.min = one.low;
    input.max = one.high;
    input.step = (one.high - one.low) / 1000 || "any";
    if (pulling !== one.name) input.value = one.value;
    output.textContent = `${Number(one.value.toPrecision(4))} ${one.unit === "1" ? "" : one.unit}`;
  });
  find("back").hidden = !found.length;
}

const events = new EventSource(here + "events");
events.addEventListener("sheet", event => {
  const sheet = JSON.parse(event.data), faulty = sheet.faults.length > 0;
  document.title = sheet.title;
  find("title").textContent = sheet.title;
  list("faults", sheet.faults);
  list("notes", sheet.notes);
  document.body.classList.toggle("stale", faulty);
  find("state").classList.toggle("bad", faulty);
  find("state").textContent = !faulty ? "follows the file" : sheet.picture ? "the last picture without a fault" : "";
  if (sheet.picture) {
    const image = document.createElement("img");
    image.alt = `picture of ${sheet.title}`;
    image.src = "data:image/svg+xml;charset=utf-8," + encodeURIComponent(sheet.picture);
    image.decode().catch(() => {}).then(() => find("picture").replaceChildren(image));
  }
  sliders(sheet.sliders);
});
events.addEventListener("equations", event => { find("equations").innerHTML = JSON.parse(event.data); });
events.addEventListener("error", () => {
  find("state").classList.add("bad");
  find("state").textContent = "symdyn has ended; what is shown follows no file";
});
find("back").addEventListener("click", () => send({ back: true }));
