// The console of a bench on a page: node console.mjs PROGRAM [FOLDER for pictures]. What is shown while it runs must be what the commands
// say of the recordings afterwards.
import { execFileSync, spawn } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { chromium } from "playwright-core";

const [given, pictures] = process.argv.slice(2);
if (!given) {
  console.error("usage: node console.mjs PROGRAM [FOLDER for pictures]");
  process.exit(2);
}
const program = resolve(given);
const shots = pictures ? resolve(pictures) : undefined;
if (shots) mkdirSync(shots, { recursive: true });
const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const folder = mkdtempSync(join(tmpdir(), "piezotact-console-"));
const run = (...words) => execFileSync(program, words, { cwd: folder, encoding: "utf8", stdio: ["ignore", "pipe", "pipe"] });
const expect = (is, what) => { if (!is) throw new Error(what); };

/// What fails here leaves no server behind.
const servers = new Set();
process.on("exit", () => servers.forEach((child) => child.kill("SIGKILL")));

async function serve() {
  const child = spawn(program, "serve --bench twin:participant=2,seed=7 --port 0".split(" "), { cwd: folder, stdio: ["ignore", "pipe", "pipe"] });
  servers.add(child);
  let out = "";
  let err = "";
  child.stderr.on("data", (text) => { err += text; });
  await new Promise((found, lost) => {
    child.stdout.on("data", (text) => { out += text; if (out.includes("Ctrl-C ends")) found(); });
    child.on("exit", () => lost(new Error(`the console ended: ${out}${err}`)));
  });
  const [experimenter, viewer] = [...out.matchAll(/http\S+/g)].map((all) => all[0]);
  return { child, experimenter, viewer, ended: new Promise((ended) => child.on("exit", (code) => ended(code))) };
}

async function enter(browser, address, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1366, height: 768 }, ...options });
  const page = await context.newPage();
  page.on("pageerror", (error) => { console.error(`page: ${error.message}`); process.exitCode = 1; });
  page.on("console", (message) => { if (/Content Security Policy/.test(message.text())) { console.error(message.text()); process.exitCode = 1; } });
  await page.goto(address);
  await page.click("button[type=submit]");
  await page.waitForSelector("#page.console");
  return page;
}

let faults = 0;
/// Pictures on every width, and what axe-core finds.
async function look(page, name) {
  for (const [width, height] of [[1366, 768], [1024, 768], [390, 844]]) {
    await page.setViewportSize({ width, height });
    await page.waitForTimeout(150);
    const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    if (wide > 0) { faults += 1; console.error(`${name} at ${width}: ${wide} px too wide`); }
    if (shots) await page.screenshot({ path: join(shots, `console-${name}-${width}.png`), fullPage: width === 390 });
  }
  await page.setViewportSize({ width: 1366, height: 768 });
  await page.evaluate(axe);
  const found = await page.evaluate(() => window.axe.run());
  for (const violation of found.violations) {
    faults += 1;
    console.error(`${name}: ${violation.impact} ${violation.id}: ${violation.nodes.map((node) => node.target).join(", ")}`);
  }
}

const text = (page, id) => page.textContent(`#${id}`);
const number = async (page, id) => Number.parseFloat(await text(page, id));
const idle = (page) => page.waitForFunction(() => document.getElementById("stop").disabled, null, { timeout: 240_000 });
const fill = async (page, procedure, values) => {
  await page.locator(`form[data-procedure=${procedure}]`).evaluate((form) => { form.closest("details").open = true; });
  for (const [name, value] of Object.entries(values)) {
    const field = page.locator(`form[data-procedure=${procedure}] [name=${name}]`);
    if (await field.evaluate((one) => one.tagName) === "SELECT") await field.selectOption(value); else await field.fill(value);
  }
};
/// How many pixels of a chart are drawn in the colour of a line.
const drawn = (page, id) => page.evaluate((id) => {
  const canvas = document.querySelector(`#${id} canvas`);
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let count = 0;
  for (let i = 0; i < data.length; i += 4) if (data[i] < 60 && data[i + 2] > 100 && data[i + 3] > 200) count += 1;
  return count;
}, id);

const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: ["--no-sandbox", "--autoplay-policy=no-user-gesture-required"] });
const server = await serve();
try {
  const page = await enter(browser, server.experimenter);
  const viewer = await enter(browser, server.viewer, { locale: "it-IT" });
  await look(page, "idle");
  expect(await viewer.locator(".procedure, #stop").count() === 0, "who looks on has no buttons");

  // A characterisation: seen while it runs, also by who looks on and after a reload; a second one is refused.
  await fill(page, "characterise", { seconds: "14", load: "0.2" });
  await page.click("form[data-procedure=characterise] button");
  await page.waitForFunction(() => Number.parseFloat(document.getElementById("acquired").textContent) > 3, null, { timeout: 60_000 });
  const early = await number(page, "acquired");
  const left = await number(page, "left");
  expect(Math.abs(early + left - 14) < 1.5, `${early} s acquired and ${left} s left of 14 s`);
  expect(await number(page, "level") > 0, "the level of the vibration is shown");
  for (const id of ["vibration", "force", "spectrum"]) expect(await drawn(page, id) > 100, `${id} is drawn`);
  expect(await page.locator("form[data-procedure=characterise] button").isDisabled(), "nothing else is started meanwhile");
  const refused = await page.evaluate(async () => {
    const mark = document.querySelector('meta[name="piezotact-mark"]').content;
    const body = JSON.stringify({ do: "start", procedure: "characterise", values: { excitation: "random", seconds: "2", repeats: "1", load: "0.2", angle: "20" } });
    const reply = await fetch("/console/ask", { method: "POST", headers: { "content-type": "application/json", "x-piezotact-mark": mark }, body });
    return [reply.status, await reply.text()];
  });
  expect(refused[0] === 422 && refused[1].includes("runs already"), `a second start: ${refused}`);
  await page.reload();
  await page.waitForFunction((early) => Number.parseFloat(document.getElementById("acquired").textContent) > early, early, { timeout: 60_000 });
  await page.waitForFunction(() => /\d/.test(document.getElementById("coherence-now").textContent));
  const [atFirst, times] = await page.evaluate(() => document.getElementById("coherence-now").textContent.match(/[\d.]+/g).map(Number));
  await look(page, "characterising");
  await look(viewer, "viewer-it");
  await idle(page);
  // The mean that is judged: of the last ten seconds of what is kept.
  const shown = Number.parseFloat(await text(page, "force-mean"));
  const kept = run("info", "console/characterise-1.parquet").match(/normal_force\s+mean ([\d.]+)/);
  expect(Math.abs(shown / Number(kept[1]) - 1) < 0.08, `force shown ${shown} N, kept ${kept[1]} N over the whole run`);
  const [atLast, more] = await page.evaluate(() => document.getElementById("coherence-now").textContent.match(/[\d.]+/g).map(Number));
  expect(more > times && atLast > 0.9 && atFirst > 0.5, `coherence grows: ${atFirst} of ${times}, then ${atLast} of ${more}`);
  const summary = JSON.parse(run("info", "console/characterise-1.json", "--json"));
  expect(JSON.stringify(summary).length > 100, "the transfer function can be read");
  await page.waitForFunction(() => document.querySelector("#files a[href$='characterise-1.html']"));
  const report = await page.context().newPage();
  await report.goto(new URL(await page.getAttribute("#files a[href$='characterise-1.html']", "href"), page.url()).href);
  expect((await report.textContent("h1")).includes("ransfer"), "the report is shown");
  await report.close();

  // Strokes on a sample: as many as the recording holds.
  await fill(page, "touch", { sample: "S8", strokes: "5", speed: "50" });
  await page.click("form[data-procedure=touch] button");
  await page.waitForFunction(() => Number.parseInt(document.getElementById("strokes").textContent, 10) >= 2, null, { timeout: 120_000 });
  await look(page, "touching");
  await idle(page);
  const [accepted, rejected] = (await text(page, "strokes")).match(/\d+/g).map(Number);
  const { recordings } = JSON.parse(run("strokes", "--cuts-only", "console/touch-1.parquet", "--json"));
  const counted = [recordings[0].cuts.length, recordings[0].rejected.length];
  expect(`${[accepted, rejected]}` === `${counted}`, `strokes shown ${[accepted, rejected]}, in the recording ${counted}`);

  // Stopped in between: what was acquired is kept.
  await fill(page, "characterise", { seconds: "60" });
  await page.click("form[data-procedure=characterise] button");
  await page.waitForFunction(() => document.getElementById("state").textContent.includes("characterise-2") && Number.parseFloat(document.getElementById("acquired").textContent) < 2, null, { timeout: 60_000 });
  await page.waitForFunction(() => Number.parseFloat(document.getElementById("acquired").textContent) > 3, null, { timeout: 60_000 });
  await page.click("#stop");
  await idle(page);
  expect(/ [3-9]\.\d+ s/.test(run("info", "console/characterise-2.parquet")), "what was acquired is kept");
  await look(page, "stopped");

  // Values that cannot be are refused in words; files that were not made are not given.
  const values = { excitation: "random", seconds: "-3", repeats: "1", load: "0.2", angle: "20" };
  const wrong = await page.evaluate(async (values) => {
    const mark = document.querySelector('meta[name="piezotact-mark"]').content;
    const ask = (body) => fetch("/console/ask", { method: "POST", headers: { "content-type": "application/json", "x-piezotact-mark": mark }, body: JSON.stringify(body) });
    const number = await ask({ do: "start", procedure: "characterise", values });
    const unknown = await ask({ do: "start", procedure: "erase", values });
    const file = await fetch("/console/files/pages.json");
    const up = await fetch("/console/files/..%2Fpages.json");
    return [number.status, await number.text(), unknown.status, file.status, up.status];
  }, values);
  expect(wrong[0] === 422 && wrong[1].includes("from 1 to 3600") && wrong[2] === 422 && wrong[3] === 404 && wrong[4] === 404, `${wrong}`);

  // The metronome beats.
  await page.fill("#metronome input", "0.5");
  await page.click("#metronome button");
  await page.waitForSelector("#beat.on", { timeout: 5000 });
  await page.click("#metronome button");

  const began = Date.now();
  server.child.kill("SIGINT");
  await server.ended;
  expect(Date.now() - began < 2000, `the console ended after ${Date.now() - began} ms`);
  await page.waitForSelector("#not-connected:not([hidden])");
  expect(faults === 0, `${faults} faults`);
  console.log("console: a characterisation, strokes, a stop and a metronome, as shown and as kept");
} finally {
  server.child.kill("SIGKILL");
  await browser.close();
  rmSync(folder, { recursive: true, force: true });
}
