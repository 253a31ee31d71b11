// Pages of lessons in Firefox, by WebDriver BiDi: prints what was seen of each. node THIS PUPPETEER FIREFOX ADDRESS...

import { pathToFileURL } from "node:url";

const [, , puppeteer, executablePath, ...addresses] = process.argv;
const { launch } = await import(pathToFileURL(`${puppeteer}/lib/esm/puppeteer/puppeteer-core.js`).href);
const browser = await launch({ browser: "firefox", executablePath, headless: true, protocolTimeout: 300000 });

try {
  for (const address of addresses) {
    const page = await browser.newPage(), said = [];
    page.on("console", message => said.push(message.text()));
    page.on("pageerror", fault => said.push(String(fault)));
    await page.goto(address);
    const seen = [];
    for (const width of [1280, 390]) {
      await page.setViewport({ width, height: 800 });
      seen.push(await page.evaluate(async () => {
        const play = document.querySelector("[data-do=play]"), time = document.querySelector("[data-out=t]");
        const before = time?.textContent;
        play?.click();
        for (let k = 0; play && time.textContent === before && k < 600; k++) await new Promise(requestAnimationFrame);
        play?.click();
        return {
          moved: !play || time.textContent !== before,
          over: document.documentElement.scrollWidth - innerWidth,
          short: [...document.querySelectorAll("mo:has(+ mtable)")].filter(one => one.checkVisibility() && one.getBoundingClientRect().height < 0.8 * one.nextElementSibling.getBoundingClientRect().height).length,
          flat: [...document.querySelectorAll("math")].filter(one => one.checkVisibility() && !one.getBoundingClientRect().height).length,
        };
      }));
    }
    console.log(JSON.stringify({ seen, said }));
    await page.close();
  }
} finally {
  await browser.close();
}
