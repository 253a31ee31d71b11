// The playground in Firefox, by WebDriver BiDi: prints what was seen. node THIS PUPPETEER FIREFOX ADDRESS

import { pathToFileURL } from "node:url";

const [, , puppeteer, executablePath, address] = process.argv;
const { launch } = await import(pathToFileURL(`${puppeteer}/lib/esm/puppeteer/puppeteer-core.js`).href);
const browser = await launch({ browser: "firefox", executablePath, headless: true, protocolTimeout: 300000 });
const said = [];

try {
  const page = await browser.newPage();
  await page.setViewport({ width: 700, height: 900 });
  page.on("console", message => said.push(message.text()));
  page.on("pageerror", fault => said.push(String(fault)));

  async function until(isTrue, ...given) {
    for (const begun = Date.now(); !(await page.evaluate(isTrue, ...given));) {
      if (Date.now() - begun > 120000) throw new Error(String(isTrue));
      await new Promise(done => setTimeout(done, 50));
    }
  }

  function written(text) {
    const field = document.getElementById("text");
    field.value = text;
    field.dispatchEvent(new InputEvent("input", { bubbles: true }));
    return document.body.dataset.shown;
  }

  const shown = before => document.body.dataset.shown !== before;
  const pictured = before => document.querySelector("#picture img")?.src !== before;
  await page.goto(address);
  await until(() => document.body.dataset.shown);
  await until(() => document.documentElement.dataset.python);
  const text = await page.evaluate(() => document.getElementById("text").value);
  await page.evaluate(written, text.replace("axis =", "axi ="));
  await until(() => document.querySelectorAll("#faults li").length);
  const faults = await page.evaluate(() => document.getElementById("faults").textContent.includes("did you mean axis?"));
  await until(shown, await page.evaluate(written, text.replace('"-h2"', '"-3*h2"')));
  const equations = await page.evaluate(() => document.getElementById("equations").textContent.includes("9"));
  const wide = await page.evaluate(() => [...document.querySelectorAll("#equations .flow")]
    .filter(one => one.scrollWidth > one.clientWidth + 1).length);
  const before = await page.evaluate(() => {
    document.getElementById("pull").open = true;
    const slider = document.querySelector("#sliders input");
    slider.value = 0.2;
    slider.dispatchEvent(new Event("input", { bubbles: true }));
    return document.querySelector("#picture img").src;
  });
  await until(pictured, before);
  console.log(JSON.stringify({ equations, faults, pulled: true, wide, said }));
} finally {
  await browser.close();
}
