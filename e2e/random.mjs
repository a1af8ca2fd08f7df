// Random presses on both pages of a session, beside a book of what was confirmed: node random.mjs PROGRAM [PROTOCOL …].
// PRESSES (1000) keys and clicks for each protocol, and a kill of the program after every KILL_EVERY (50). What is stored must be what the book says.
import { execFileSync, spawn } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { chromium } from "playwright-core";

const [given, ...wanted] = process.argv.slice(2);
if (!given) {
  console.error("usage: node random.mjs PROGRAM [PROTOCOL …]");
  process.exit(2);
}
const program = resolve(given);
const presses = Number(process.env.PRESSES ?? 1000);
const every = Number(process.env.KILL_EVERY ?? 50);
let seed = Number(process.env.SEED ?? 11);
const drawn = (n) => { seed = (seed * 1103515245 + 12345) % 2147483648; return Math.floor((seed / 2147483648) * n); };
const sleep = (ms) => new Promise((done) => setTimeout(done, ms));
const expect = (is, what) => { if (!is) throw new Error(what); };
const sessions = {
  isotropic_triplets: "discrimination", amplitude_inversion: "discrimination", periodic_pilot: "discrimination",
  touch_control_imagery: "feedback", roughness_jnd: "discrimination",
};
const servers = new Set();
process.on("exit", () => servers.forEach((child) => child.kill("SIGKILL")));

async function serve(folder, line) {
  const child = spawn(program, line.split(" "), { cwd: folder, stdio: ["ignore", "pipe", "pipe"] });
  servers.add(child);
  let [out, err] = ["", ""];
  child.stderr.on("data", (text) => { err += text; });
  await new Promise((found, lost) => {
    child.stdout.on("data", (text) => { out += text; if (out.includes("Ctrl-C ends")) found(); });
    child.on("exit", () => lost(new Error(`the server ended: ${out}${err}`)));
  });
  return { child, experimenter: out.match(/http\S+/)[0], ended: new Promise((ended) => child.on("exit", ended)) };
}

async function enter(browser, address) {
  const page = await (await browser.newContext({ viewport: { width: 1366, height: 900 } })).newPage();
  page.on("pageerror", (error) => { console.error(`page: ${error.message}`); process.exitCode = 1; });
  await page.goto(address);
  await page.click("button[type=submit]");
  await page.waitForSelector("#page [data-mark]");
  return page;
}

/// What the experimenter's page says: the trial, what is noted for it, how many are confirmed.
const state = (page) => page.evaluate(() => {
  const main = document.querySelector("[data-mark]");
  const noted = document.querySelector(".step [data-ask*='confirm']") && document.querySelector(".step > .big b")?.textContent;
  const done = [...document.querySelectorAll(".tasks li")].reduce((sum, one) => sum + Number(one.querySelector("progress").value), 0);
  return { mark: main.dataset.mark, trial: document.querySelector(".step h2")?.dataset.trial, noted: noted || null, done, isOver: main.dataset.mark === "over", isOn: document.getElementById("not-connected").hidden };
});

/// What a press on `page` would choose, where one press is an answer.
const chosenBy = (page, key) => page.evaluate((key) => {
  const draft = document.querySelector("[data-final]");
  if (!draft) return null;
  const one = key === "Enter" ? document.activeElement.closest("[data-choice]") : draft.querySelector(`[data-key="${key}"]`);
  return one?.dataset.choice ?? null;
}, key);

const KEYS = ["Enter", "Enter", "Enter", "Enter", "Enter", "ArrowRight", "ArrowLeft", "Tab", ..."0123456789abcdefghijklmn", ..."123abc"];
// Pause and "take back" are pressed rarely: otherwise few trials would be confirmed.
const RARE = ["Backspace", "Escape"];

async function pressed(page) {
  if (drawn(4) === 0) {
    const key = drawn(25) ? KEYS[drawn(KEYS.length)] : RARE[drawn(RARE.length)];
    const choice = await chosenBy(page, key);
    await page.keyboard.press(key);
    return choice;
  }
  // Every button but those that end the session or make a code, and every list that opens.
  const all = await page.$$(`button:visible:not([data-post]):not(.grave):not([data-ask*=refuse_consent])${drawn(10) ? ":not([data-ask*=pause]):not([data-undo])" : ""}:not([data-ask*=stop]):not([type=submit]), summary:visible`);
  if (all.length === 0) return null;
  // What takes the session on is drawn more often: else it does not get far.
  const main = await page.$$("button.main:visible:not(:disabled)");
  const choices = await page.$$(".choice:visible:not([aria-disabled=true])");
  const from = choices.length ? [main, choices, choices, choices, choices, choices, main, all][drawn(8)] : [main, main, main, all][drawn(4)];
  const one = from.length ? from[drawn(from.length)] : all[drawn(all.length)];
  const choice = await one.evaluate((one) => (one.closest("[data-final]") ? one.dataset.choice ?? null : null)).catch(() => null);
  await one.click({ timeout: 1000, force: true, noWaitAfter: true }).catch(() => {});
  return choice;
}

async function tried(browser, protocol) {
  const folder = mkdtempSync(join(tmpdir(), "piezotact-random-"));
  const run = (line) => execFileSync(program, line.split(" "), { cwd: folder, encoding: "utf8", stdio: ["ignore", "pipe", "pipe"] });
  run(`campaign new study --protocol ${protocol} --seed ${1 + drawn(1000)}`);
  const line = `serve study P01 ${sessions[protocol]} --rehearsal --by-hand --port`;
  let server = await serve(folder, `${line} 0`);
  const { port } = new URL(server.experimenter);
  const page = await enter(browser, server.experimenter);
  await page.click("details:has([data-post='/pairing']) > summary");
  await page.click("[data-post='/pairing']");
  const participant = await enter(browser, await page.locator(".facts code").textContent());
  const book = [];
  let [kills, resumed] = [0, 0];
  let before = await state(page);
  let i = 1;
  for (; i <= presses && !before.isOver; i += 1) {
    const own = drawn(2) ? page : participant;
    const choice = await pressed(own);
    if (i % every === 0) {
      // In the middle of what was pressed.
      const ended = server.ended;
      server.child.kill("SIGKILL");
      await ended;
      servers.delete(server.child);
      server = await serve(folder, `${line} ${port}`);
      await Promise.all([page, participant].map((one) => one.waitForSelector("#not-connected", { state: "hidden", timeout: 20_000 })));
      kills += 1;
    }
    // What was pressed is stored, or refused, and seen.
    await page.waitForSelector("#page:not(.busy)", { timeout: 10_000 });
    await participant.waitForSelector("#page:not(.busy)", { timeout: 10_000 });
    await sleep(80);
    const after = await state(page);
    expect(after.done - before.done <= 1, `${after.done - before.done} trials confirmed by one press`);
    if (after.done === before.done + 1) {
      const said = before.noted ?? choice;
      // What is only done has no answer.
      if (said !== null) book.push({ trial: before.trial, said });
    }
    expect(after.done >= before.done, "a confirmed trial is open again");
    if (before.mark !== after.mark) { resumed += 1; await sleep(400); }
    before = after;
  }
  const ended = server.ended;
  server.child.kill("SIGINT");
  await ended;
  run("campaign verify study");
  run("campaign export study --out tables");
  const [head, ...rows] = readFileSync(join(folder, "tables/trials.csv"), "utf8").trim().split("\n").map(cells);
  const of = (row, name) => row[head.indexOf(name)];
  const stored = rows.filter((row) => of(row, "answer"));
  const words = (row) => of(row, "answer").split("|");
  expect(stored.length === book.length, `${protocol}: ${stored.length} answers stored, ${book.length} in the book`);
  stored.forEach((row, i) => {
    // Letters stand for the participant's own order of the same set.
    const before = stored.slice(0, i).filter((one) => of(one, "task") === "task2" && of(one, "set") === of(row, "set"));
    const order = before.length ? words(before.at(-1)) : [];
    const letters = book[i].said.split(", ");
    const isLettered = of(row, "task") === "task3" && letters.every((one) => /^[A-Z]$/.test(one));
    const meant = isLettered ? letters.map((one) => order[one.charCodeAt(0) - 65]) : letters;
    const found = words(row).join(", ");
    expect(found === meant.join(", "), `${protocol}, ${of(row, "trial")}: ${book[i].said} in the book, ${found} stored`);
  });
  console.log(`${protocol}: ${i - 1} presses, ${kills} kills, ${resumed} steps; ${book.length} confirmed answers, all as in the book`);
  rmSync(folder, { recursive: true });
}

/// The cells of a line of CSV.
function cells(line) {
  return [...line.matchAll(/(?:^|,)(?:"((?:[^"]|"")*)"|([^,]*))/g)].map((found) => found[1]?.replaceAll('""', '"') ?? found[2]);
}

const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  headless: true,
  args: ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking"],
});
try {
  for (const protocol of wanted.length ? wanted : Object.keys(sessions)) await tried(browser, protocol);
} catch (error) {
  console.error(error.stack);
  process.exitCode = 1;
} finally {
  await browser.close();
  process.exit();
}
