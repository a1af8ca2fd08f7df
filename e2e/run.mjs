// Measures in a browser that nothing overflows in any report and that it shuts nobody out: node run.mjs PROGRAM [FOLDER]; piezotact-validation stands beside PROGRAM
import { mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, relative, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

import { barriers } from "./barriers.mjs";
import { faults } from "./measure.mjs";
import { makeReports } from "./reports.mjs";

const WIDTHS = [1366, 800, 390];
const here = new URL(".", import.meta.url).pathname;
const [program, given] = process.argv.slice(2);
if (!program) {
  console.error("usage: node run.mjs PROGRAM [FOLDER with reports]");
  process.exit(2);
}

const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  headless: true,
  args: ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking"],
});

/// The faults of one page at every width, each with the widths that show it.
async function measured(file, shots) {
  const page = await browser.newPage();
  const seen = new Map();
  // A figure that stands alone has the size that it says.
  if (file.endsWith(".svg")) await page.setContent(`<!DOCTYPE html><html lang="en"><title>${name(file)}</title><main>${readFileSync(file, "utf8")}</main>`);
  else await page.goto(pathToFileURL(file).href);
  for (const width of file.endsWith(".svg") ? [WIDTHS[0]] : WIDTHS) {
    await page.setViewportSize({ width, height: 900 });
    for (const fault of await page.evaluate(faults)) seen.set(fault, [...(seen.get(fault) ?? []), width]);
    if (shots) await page.screenshot({ path: join(shots, `${name(file)}-${width}.png`), fullPage: true, timeout: 120_000 });
  }
  await page.setViewportSize({ width: WIDTHS[0], height: 900 });
  for (const barrier of await barriers(page)) seen.set(barrier, [WIDTHS[0]]);
  await page.close();
  return [...seen].map(([fault, widths]) => `${widths.join(", ")} px: ${fault}`);
}

let made;
const name = (file) => relative(made, file).replace(/\.(html|svg)$/, "").replaceAll("/", "-");
const pages = (folder) =>
  readdirSync(folder, { recursive: true }).filter((file) => /\.(html|svg)$/.test(file)).sort().map((file) => join(folder, file));

/// A page that has every fault: what does not find them proves nothing.
async function requireFaults() {
  const expected = ["scrolls sideways", "leaves its card", "too narrow for", "texts of 6.0 px", "leaves the figure", "texts overlap", "again", "svg-img-alt", "zero with a sign", "spread of zero", "no number", "without a text"];
  const found = (await measured(join(here, "faulty.html"))).join("\n");
  const missed = expected.filter((fault) => !found.includes(fault));
  if (missed.length > 0) throw new Error(`the measurement does not find: ${missed.join(", ")}\n${found}`);
}

try {
  await requireFaults();
  made = given ? resolve(given) : mkdtempSync(join(tmpdir(), "piezotact-e2e-"));
  const began = Date.now();
  if (!given) await makeReports(resolve(program), made);
  const reports = pages(made);
  if (reports.length === 0) throw new Error(`no report in ${made}`);
  const after = Date.now();
  const shots = process.env.SHOTS ? resolve(process.env.SHOTS) : undefined;
  if (shots) mkdirSync(shots, { recursive: true });
  let total = 0;
  for (const file of reports) {
    const all = await measured(file, shots);
    total += all.length;
    for (const fault of all) console.log(`${name(file)}: ${fault}`);
  }
  const seconds = (from, to) => `${Math.round((to - from) / 1000)} s`;
  console.log(`${reports.length} reports made in ${seconds(began, after)}, measured at ${WIDTHS.join(", ")} px in ${seconds(after, Date.now())}: ${total} faults`);
  if (!given && total === 0) rmSync(made, { recursive: true });
  else console.log(`the reports are in ${made}`);
  process.exitCode = total === 0 ? 0 : 1;
} catch (error) {
  console.error(error.message);
  process.exitCode = 1;
} finally {
  await browser.close();
}
