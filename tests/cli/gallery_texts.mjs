// Whether texts of SVG pictures leave their picture or lie on one another, as a browser sets them: node tests/cli/gallery_texts.mjs CHROMIUM FILE.svg...
import { createRequire } from "node:module";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";

const { chromium } = createRequire(`${process.cwd()}/web/`)("playwright-core");
const [browserPath, ...files] = process.argv.slice(2);
const browser = await chromium.launch({ executablePath: browserPath, args: ["--disable-gpu", ...(process.getuid?.() === 0 ? ["--no-sandbox"] : [])] });
const page = await browser.newPage();
let wrong = 0;
for (const file of files) {
  await page.goto(pathToFileURL(resolve(file)).href);
  const found = await page.evaluate(() => {
    const whole = document.documentElement.getBoundingClientRect();
    const texts = [...document.querySelectorAll("text")].filter((t) => t.textContent.trim()).map((t) => ({ text: t.textContent.trim(), box: t.getBoundingClientRect() }));
    const cut = texts.filter(({ box: b }) => b.left < whole.left - 0.5 || b.right > whole.right + 0.5 || b.top < whole.top - 0.5 || b.bottom > whole.bottom + 0.5);
    const out = cut.map(({ text }) => `'${text}' is cut`);
    // Boxes of a text are higher than its letters, and a raised and a lowered text stand close: what counts is half a line and two pixels.
    texts.forEach((one, i) => texts.slice(i + 1).forEach((other) => {
      const [a, b] = [one.box, other.box];
      const [w, h] = [Math.min(a.right, b.right) - Math.max(a.left, b.left), Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top)];
      if (w > 2.5 && h > 0.45 * Math.min(a.height, b.height)) out.push(`'${one.text}' lies on '${other.text}'`);
    }));
    return out;
  });
  for (const text of found) console.log(`${file}: ${text}`);
  wrong += found.length;
}
await browser.close();
process.exit(wrong ? 1 : 0);
