#!/usr/bin/env node
// The pictures of `ricochet view` in the documentation: screenshot.mjs RICOCHET ATLAS OUT.png, and beside it OUT-section.png and OUT-force.png
import { spawn, execFileSync } from "node:child_process";
import { createInterface } from "node:readline";
import { chromium } from "../web/node_modules/playwright-core/index.mjs";

const [ricochet, atlas, out] = process.argv.slice(2);
const browserPath = process.env.CHROMIUM || execFileSync("sh", ["-c", "command -v chromium-headless-shell || command -v chromium || command -v chromium-browser || command -v google-chrome"], { encoding: "utf8" }).trim();
const server = spawn(ricochet, ["view", atlas, "--no-browser", "--port", "0"], { stdio: ["ignore", "pipe", "ignore"] });
const url = await new Promise((resolve) => createInterface({ input: server.stdout }).once("line", resolve));
const browser = await chromium.launch({ executablePath: browserPath, args: ["--disable-gpu", ...(process.getuid?.() === 0 ? ["--no-sandbox"] : [])] });
const page = await browser.newPage({ viewport: { width: 1200, height: 740 }, colorScheme: "light" });
const branch = JSON.parse(execFileSync(ricochet, ["branches", atlas, "--json"], { encoding: "utf8" })).find((b) => b.label === "S2+[01]").id;
await page.goto(`${url}#e=0.5,210&w=0.86,3.6&dup=2&b=${branch}&s=3.1`);
await page.waitForFunction(() => window.ricochet?.().orbit(), null, { timeout: 30000 });
await page.evaluate(() => document.getElementById("content").scrollTo(0, 0));
await page.waitForTimeout(1500);
await page.screenshot({ path: out });
const also = (name) => page.screenshot({ path: out.replace(/\.png$/, `-${name}.png`) });
const look = async (hash) => {
  await page.evaluate((to) => {
    location.hash = to;
    dispatchEvent(new PopStateEvent("popstate"));
  }, hash);
  await page.waitForTimeout(1500);
};
await look(`e=0.5,210&w=0.86,3.6&b=${branch}&s=2`);
await page.click("[data-tab=section]");
await page.waitForFunction(() => window.ricochet().section.starts > 0, null, { timeout: 60000 });
await page.waitForTimeout(500);
await also("section");
await page.click("[data-tab=force]");
await page.click(".force .primary");
await page.waitForFunction(() => window.ricochet().force.branches > 0 && !window.ricochet().force.busy, null, { timeout: 300000 });
await page.evaluate(() => {
  const level = document.querySelector(".level input");
  level.value = "0.37";
  level.dispatchEvent(new Event("input"));
});
await page.waitForTimeout(500);
await also("force");
await browser.close();
server.kill("SIGINT");
