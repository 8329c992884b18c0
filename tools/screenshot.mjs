#!/usr/bin/env node
// The picture of `ricochet view` in the documentation: screenshot.mjs RICOCHET ATLAS OUT.png
import { spawn, execFileSync } from "node:child_process";
import { createInterface } from "node:readline";
import { chromium } from "../web/node_modules/playwright-core/index.mjs";

const [ricochet, atlas, out] = process.argv.slice(2);
const browserPath = process.env.CHROMIUM || execFileSync("sh", ["-c", "command -v chromium || command -v chromium-browser || command -v google-chrome"], { encoding: "utf8" }).trim();
const server = spawn(ricochet, ["view", atlas, "--no-browser", "--port", "0"], { stdio: ["ignore", "pipe", "ignore"] });
const url = await new Promise((resolve) => createInterface({ input: server.stdout }).once("line", resolve));
const browser = await chromium.launch({ executablePath: browserPath, args: ["--disable-gpu", ...(process.getuid?.() === 0 ? ["--no-sandbox"] : [])] });
const page = await browser.newPage({ viewport: { width: 1200, height: 740 }, colorScheme: "light" });
await page.goto(`${url}#e=0.5,210&w=0.86,3.6&dup=2&b=3&s=3.1`);
await page.waitForFunction(() => window.ricochet?.().orbit(), null, { timeout: 30000 });
await page.evaluate(() => document.getElementById("content").scrollTo(0, 0));
await page.waitForTimeout(1500);
await page.screenshot({ path: out });
await browser.close();
server.kill("SIGINT");
