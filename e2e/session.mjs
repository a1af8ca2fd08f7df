// A whole session on two pages: node session.mjs PROGRAM [FOLDER for pictures]. What was answered on the pages must be what is stored.
import { execFileSync, spawn } from "node:child_process";
import { copyFileSync, existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { inflateRawSync } from "node:zlib";
import { chromium } from "playwright-core";

const [given, pictures] = process.argv.slice(2);
if (!given) {
  console.error("usage: node session.mjs PROGRAM [FOLDER for pictures]");
  process.exit(2);
}
const program = resolve(given);
const shots = pictures ? resolve(pictures) : undefined;
if (shots) mkdirSync(shots, { recursive: true });
// Of the experimenter and of the participant.
const locales = (process.env.LOCALES ?? "en-GB,fr-FR").split(",");
const offlineS = Number(process.env.OFFLINE_S ?? 5);
// So often the program is killed at random moments, beside the kill of every run.
const kills = Number(process.env.KILLS ?? 0);
const folder = mkdtempSync(join(tmpdir(), "piezotact-session-"));
const run = (line) => execFileSync(program, line.split(" "), { cwd: folder, encoding: "utf8", stdio: ["ignore", "pipe", "pipe"] });

/// What fails here leaves no server behind.
const servers = new Set();
process.on("exit", () => servers.forEach((child) => child.kill("SIGKILL")));

/// The server of the session, and its addresses.
async function serve(line) {
  const child = spawn(program, line.split(" "), { cwd: folder, stdio: ["ignore", "pipe", "pipe"] });
  servers.add(child);
  let out = "";
  let err = "";
  child.stderr.on("data", (text) => { err += text; });
  await new Promise((found, lost) => {
    child.stdout.on("data", (text) => { out += text; if (out.includes("Ctrl-C ends")) found(); });
    child.on("exit", () => lost(new Error(`the server ended: ${out}${err}`)));
  });
  const [experimenter, viewer] = [...out.matchAll(/http\S+/g)].map((all) => all[0]);
  return { child, experimenter, viewer, ended: new Promise((ended) => child.on("exit", (code) => ended({ code, err }))) };
}

const expect = (is, what) => { if (!is) throw new Error(what); };
const sleep = (ms) => new Promise((done) => setTimeout(done, ms));
/// The same numbers in every run.
let seed = 7;
const drawn = (n) => { seed = (seed * 1103515245 + 12345) % 2147483648; return Math.floor((seed / 2147483648) * n); };

async function enter(browser, address, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1366, height: 768 }, ...options });
  const page = await context.newPage();
  page.on("pageerror", (error) => { console.error(`page: ${error.message}`); process.exitCode = 1; });
  page.on("console", (message) => { if (/Content Security Policy/.test(message.text())) { console.error(message.text()); process.exitCode = 1; } });
  await page.goto(address);
  await page.click("button[type=submit]");
  await page.waitForSelector("#page [data-mark]");
  return { context, page };
}

const mark = (page) => page.getAttribute("[data-mark]", "data-mark");
/// Waits until the page shows another step than `before`, has shown it for a while, and takes keys again.
const moved = async (page, before, timeout = 120_000) => {
  try {
    await page.waitForFunction((before) => document.querySelector("[data-mark]").dataset.mark !== before, before, { timeout });
  } catch (error) {
    throw new Error(`${error.message}; the page shows: ${await page.evaluate(() => document.body.innerText).catch(() => "nothing")}`);
  }
  // What follows by itself is waited for too: a page takes no press at once after its step changed.
  let shown;
  do {
    shown = await mark(page);
    await sleep(500);
  } while (shown !== (await mark(page)));
};
/// Presses the first large button as a person does: twice where it asks for that.
const pressMain = async (page) => {
  const main = page.locator(".step > button.main").first();
  const isTwice = await main.getAttribute("data-twice");
  await main.click();
  if (isTwice) { await sleep(450); await main.click(); }
};

/// One picture for each kind of step, on every width.
const seen = new Set();
const axe = readFileSync(new URL("node_modules/axe-core/axe.min.js", import.meta.url), "utf8");
let checked = 0;
async function picture(page, name) {
  if (seen.has(name)) return;
  seen.add(name);
  for (const [width, height] of [[1366, 768], [1024, 600], [390, 844]]) {
    await page.setViewportSize({ width, height });
    // On the smallest screen that a laboratory has, whatever the step needs is in view.
    if (height === 600 && !["matrix", "study", "viewer"].includes(name)) {
      const below = await page.evaluate(() => {
        scrollTo(0, 0);
        const all = [...document.querySelectorAll(".step > button, .step .draft button, main > button, main > .draft button, .always button")];
        return all.filter((one) => one.checkVisibility() && one.getBoundingClientRect().bottom > innerHeight).map((one) => `${one.textContent.trim()} at ${Math.round(one.getBoundingClientRect().bottom)} px`);
      });
      expect(below.length === 0, `${name}: out of view at 1024 × 600: ${below.join(", ")}`);
    }
    const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    // Reports are measured by run.mjs.
    if (name !== "matrix") expect(wide <= 0, `${name} scrolls sideways at ${width} px, by ${wide} px`);
    if (shots) await page.screenshot({ path: join(shots, `${name}-${width}.png`), fullPage: true });
  }
  if (name !== "matrix") {
    await page.evaluate(axe);
    for (const [width, height] of [[1366, 768], [1024, 600], [390, 844]]) {
      await page.setViewportSize({ width, height });
      const found = await page.evaluate(async () => (await globalThis.axe.run(document)).violations.map((one) => `${one.impact}: ${one.help}: ${one.nodes[0].html}`));
      for (const fault of found) { console.error(`${name} at ${width} px: ${fault}`); process.exitCode = 1; }
    }
    checked += 1;
  }
  await page.setViewportSize({ width: 1366, height: 768 });
}

/// What is answered to the draft that `page` shows.
async function words(page) {
  const choices = await page.$$eval(".draft [data-choice]", (all) => all.map((one) => one.dataset.choice));
  const [most, once] = await page.$eval(".draft", (draft) => [Number(draft.dataset.most), draft.dataset.choose === "once"]);
  const left = [...choices];
  return Array.from({ length: most }, () => {
    const at = drawn(left.length);
    return once ? left.splice(at, 1)[0] : left[at];
  });
}

/// Goes to `button` by arrows and presses it by Enter, with the four keys of a participant; a press that bounces does nothing more.
async function press(page, button) {
  for (let steps = 0; steps < 80; steps += 1) {
    if (await button.evaluate((one) => one === document.activeElement)) {
      await page.keyboard.press("Enter");
      return;
    }
    await page.keyboard.press("ArrowRight");
  }
  throw new Error("a button is not reached by arrows");
}

/// Chooses `all` one after the other, by keys or by pointer, and sends them.
async function answer(page, all, how) {
  const before = await mark(page);
  // What was noted is there to be changed.
  for (const undo = page.locator("[data-undo]:visible").first(); await undo.isEnabled(); ) await undo.click();
  for (const word of all) {
    const choice = page.locator(`.draft [data-choice="${word}"]:visible`).first();
    const own = await choice.getAttribute("data-key");
    if (how === "keys" && own) await page.keyboard.press(own);
    else if (how === "keys") await press(page, choice);
    else await choice.click();
  }
  const send = page.locator("[data-send]:visible").first();
  if (how === "keys") await press(page, send);
  else await send.dblclick();
  await moved(page, before);
}

/// The study with its measurement session, and a verified drive for each of its thirteen textures.
function prepare() {
  run("campaign protocol isotropic_triplets --out library.toml");
  // Both sessions on one day.
  const protocol = readFileSync(join(folder, "library.toml"), "utf8");
  expect(protocol.includes('when = "another_day"'), "the protocol has no session on another day");
  writeFileSync(join(folder, "own.toml"), protocol.replace('when = "another_day"', 'when = "any_time"'));
  run("campaign new study --protocol own.toml --seed 7");
  const samples = Array.from({ length: 13 }, (_, i) => `S${i + 1}`);
  for (const sample of samples) run(`twin record --bench acttouch --sample ${sample} --participant 1 --seed 7 --strokes 3 --stroke-time 1s --out ${sample}.parquet`);
  run("characterise --bench twin:participant=1,seed=7 --out tf.json");
  run(`prepare ${samples.map((sample) => `${sample}.parquet`).join(" ")} --transfer tf.json --bench twin:participant=1,seed=7 --mode texture --out drives`);
  const typed = `yes\n${"\n".repeat(100)}`;
  execFileSync(program, ["campaign", "run", "study", "P01", "measurement"], { cwd: folder, input: typed, stdio: ["pipe", "pipe", "pipe"] });
}

/// A page with faults: what does not find them proves nothing.
async function requireFaults(browser) {
  const page = await browser.newPage();
  await page.setContent("<title>x</title><button></button><p style='color:#ccc;background:#fff'>pale</p><img src='x'>");
  await page.evaluate(axe);
  const found = await page.evaluate(async () => (await globalThis.axe.run(document)).violations.map((one) => one.id));
  for (const fault of ["button-name", "color-contrast", "image-alt"]) expect(found.includes(fault), `axe does not find ${fault}`);
  await page.close();
}

/// A trial of touch on a bench with sensors: strokes that are missing are shown on both pages, and a double click does not accept them.
async function touches(browser) {
  const server = await serve("serve study P02 measurement --bench twin:participant=2,seed=7 --real-time --port 0");
  const { context, page } = await enter(browser, server.experimenter, { locale: "en-GB" });
  const awaited = () => page.$(".step > button.main[data-ask*='confirm']");
  while (!(await awaited())) {
    const before = await mark(page);
    await pressMain(page);
    await moved(page, before);
  }
  const before = await mark(page);
  await picture(page, "experimenter-touch");
  // The time of ten strokes, not the strokes.
  await sleep(2500);
  const done = page.locator(".step > button.main").first();
  await done.dblclick();
  await page.waitForSelector(".notice:has-text('NOT COMPLETE')");
  await sleep(300);
  expect((await mark(page)) === before, "a double click accepted missing strokes");
  await picture(page, "experimenter-touch-not-complete");
  await sleep(1200);
  await done.click();
  await moved(page, before);
  expect(/NOT COMPLETE.* \/ 10/.test(await page.locator(".notice").first().textContent()), "the strokes that were found are not shown");
  await context.close();
  server.child.kill("SIGKILL");
  await server.ended;
}

async function main(browser) {
  await requireFaults(browser);
  prepare();
  await touches(browser);
  const line = "serve study P01 discrimination --drives drives --bench twin:participant=1,seed=7 --port 0";
  let server = await serve(line);
  const { page } = await enter(browser, server.experimenter, { locale: locales[0] });
  // The participant's own device.
  await page.click("details:has([data-post='/pairing']) > summary");
  await picture(page, "experimenter-consent");
  await page.click("[data-post='/pairing']");
  const address = await page.locator(".facts code").textContent();
  await picture(page, "experimenter-pairing");
  const { context: away, page: participant } = await enter(browser, address, { locale: locales[1] });
  await picture(participant, "participant-wait");

  // The server's end, and its next beginning on the same port.
  const port = new URL(server.experimenter).port;
  const killed = async () => { const end = server.ended; server.child.kill("SIGKILL"); await end; };
  const begunAgain = async () => { server = await serve(line.replace("--port 0", `--port ${port}`)); };
  // Where something is looked at that a kill would disturb, none comes.
  let calm = false;
  let restarting = Promise.resolve();
  let isOver = false;
  let killedAt = 0;
  const killing = (async () => {
    while (killedAt < kills && !isOver) {
      await sleep(1500 + 3000 * Math.random());
      if (calm || isOver) continue;
      restarting = (async () => {
        await killed();
        await begunAgain();
        // The pages find the new server by themselves, and show where the session is now.
        await Promise.all([page, participant].map((one) => one.waitForSelector("#not-connected", { state: "hidden" })));
        await sleep(300);
        killedAt += 1;
      })();
      await restarting;
    }
  })().catch((error) => { console.error(error); process.exitCode = 1; });

  const said = [];
  let tray;
  const done = { reload: false, offline: false, pause: false, change: false, step: false, folded: false, keys: false };
  for (let steps = 0; steps < 2000; steps += 1) {
    const before = await mark(page);
    if (before === "over") break;
    if (before.startsWith("paused")) {
      await participant.waitForFunction((before) => document.querySelector("[data-mark]").dataset.mark === before, before);
      await picture(participant, "participant-pause");
      await picture(page, "experimenter-pause");
      await page.click("[data-ask*='go_on']");
      await moved(page, before);
      continue;
    }
    const draft = await page.$(".step > .draft");
    const heading = await page.evaluate(() => document.querySelector(".step h2")?.dataset.trial ?? "");
    if (await page.$(".step .places")) tray = await page.$$eval(".step .places li", (all) => all.map((one) => one.textContent));
    if (!draft) {
      const main = page.locator(".step > button.main").first();
      const asked = JSON.parse(await main.getAttribute("data-ask")).do;
      const kind = asked === "present" ? ((await page.$(".tray")) ? "layout" : "present") : asked;
      await picture(page, `experimenter-${kind}`);
      if (!done.keys && asked === "present") {
        // Keys between trials, on both pages, do nothing.
        done.keys = true;
        for (const key of ["1", "a", "Backspace", "x", "ArrowRight"]) { await participant.keyboard.press(key); }
        expect((await mark(page)) === before, "a key between trials did something");
      }
      if (await main.getAttribute("data-twice")) {
        await main.dblclick();
        expect((await mark(page)) === before, "a double click confirmed what has to be confirmed twice");
        await sleep(450);
        await main.click();
      } else await main.dblclick();
      // A press that a kill came between is pressed again.
      if (kills) await moved(page, before, 8000).catch(() => {}); else await moved(page, before);
      continue;
    }
    // While an answer is entered no kill comes: `soak_serve_kill` has those.
    calm = true;
    await restarting;
    if ((await mark(page)) !== before || !(await page.$(".step > .draft"))) { calm = false; continue; }
    // Now the participant answers, now the experimenter enters what is said aloud.
    const other = await participant.waitForFunction((before) => document.querySelector("[data-mark]").dataset.mark === before, before);
    expect(other, "the participant's page follows");
    await sleep(500);
    const own = said.length % 3 === 2 ? page : participant;
    const all = await words(own);
    await picture(page, `experimenter-answer-${all.length}`);
    await picture(participant, `participant-answer-${all.length}`);
    const asked = { fr: "échantillons", it: "campioni" }[locales[1].slice(0, 2)];
    if (asked) expect((await participant.textContent(".instruction")).includes(asked), `the participant does not read in ${locales[1]} what is asked`);
    if (!done.reload) {
      // Both pages are loaded again in the middle of an answer: it is still there.
      done.reload = true;
      await own.locator(`.draft [data-choice="${all[0]}"]:visible`).first().click();
      // What the participant has chosen is seen by the experimenter, and is not on another page of the same role.
      if (own === participant) await page.waitForSelector(`.drafted:has-text("${all[0]}")`, { timeout: 2000 });
      await Promise.all([page.reload(), participant.reload()]);
      await own.waitForSelector(".draft");
      expect((await own.locator("[data-slot='0']").first().textContent()) === all[0], "an answer that was begun is lost by a reload");
      await own.click("[data-undo]");
    }
    if (!done.offline && own === participant) {
      done.offline = true;
      for (const word of all) await own.locator(`.draft [data-choice="${word}"]:visible`).first().click();
      await away.setOffline(true);
      await own.locator("[data-send]:visible").first().dblclick();
      await own.waitForSelector("#not-connected:not([hidden])");
      await picture(own, "participant-offline");
      await sleep(1000 * offlineS);
      expect((await mark(page)) === before, "an answer was stored without a connection");
      await away.setOffline(false);
      await moved(page, before);
    } else await answer(own, all, said.length % 2 ? "keys" : "pointer");
    await moved(page, before);
    const noted = await mark(page);
    await participant.waitForFunction((noted) => document.querySelector("[data-mark]").dataset.mark === noted, noted);
    await sleep(500);
    await picture(page, `experimenter-noted-${all.length}`);
    await picture(participant, `participant-noted-${all.length}`);
    let final = all;
    if (!done.folded) {
      // A form in a closed <details> takes no keys: no second answer is stored.
      done.folded = true;
      const events = await page.getAttribute("main", "data-events");
      for (const key of ["1", "Backspace", "2", "a"]) { await page.keyboard.press(key); await participant.keyboard.press(key); }
      await sleep(300);
      expect((await mark(page)) === noted && (await page.getAttribute("main", "data-events")) === events, "a key in a form that is folded away did something");
    }
    if (!done.step && all.length > 2 && own === participant) {
      // One item among many is changed in one step: its place, and what stands there instead.
      done.step = true;
      await own.click("summary:visible >> nth=0");
      const once = (await own.getAttribute(".draft", "data-choose")) === "once";
      expect((await own.locator("[data-ask*='confirm']:visible").count()) === 0, "what is noted can be made final while another answer is being made");
      const [was, other] = [all[1], once ? all[0] : (await own.$$eval(".draft [data-choice]", (all) => all.map((one) => one.dataset.choice))).find((one) => one !== all[1])];
      await own.locator("[data-slot='1']:visible").first().click();
      await own.locator(`.draft [data-choice="${other}"]:visible`).first().click();
      final = all.map((word, i) => (i === 1 ? other : once && word === other ? was : word));
      const before = await mark(page);
      await own.locator("[data-send]:visible").first().click();
      await moved(page, before);
    } else if (!done.change && all.length > 2) {
      done.change = true;
      await own.click("summary:visible >> nth=0");
      final = await words(own);
      await answer(own, final, "pointer");
    }
    const last = await mark(page);
    await own.locator("[data-ask*='confirm']:visible").first().dblclick();
    await moved(page, last);
    // The participant names places on the tray, the experimenter samples.
    const trial = Number(heading);
    if (own === participant && tray) final = final.map((place) => tray[place.charCodeAt(0) - 65]);
    said.push(final);
    expect(said.length === trial, `trial ${trial} after ${said.length - 1} answers`);
    tray = undefined;
    if (!done.pause && said.length === 4) {
      done.pause = true;
      const running = await mark(page);
      await page.click("[data-ask*='pause']");
      await moved(page, running);
    }
    if (said.length === 5) {
      // Misheard: the last answer is corrected.
      await page.click("details:has(form.correct) > summary");
      const right = [...final].reverse();
      await page.selectOption("form.correct select", { index: 1 });
      await page.fill("form.correct input[name=words]", right.join(", "));
      await page.fill("form.correct input[name=why]", "misheard");
      await picture(page, "experimenter-correct");
      await page.click("form.correct button");
      await page.waitForFunction((text) => document.querySelector(".answers")?.textContent.includes(text), `${right.join(", ")} *`);
      said[said.length - 1] = right;
    }
    if (said.length === 6) {
      // The program is killed, and begun again: the pages go on by themselves, where they were.
      await killed();
      await page.waitForSelector("#not-connected:not([hidden])");
      await picture(page, "experimenter-not-connected");
      await begunAgain();
      await Promise.all([page, participant].map((one) => one.waitForSelector("#not-connected", { state: "hidden" })));
    }
    calm = false;
  }
  isOver = true;
  await killing;
  expect(killedAt === kills, `${killedAt} kills of ${kills} before the session was over`);
  await picture(page, "experimenter-over");
  await picture(participant, "participant-over");
  expect(Object.values(done).every(Boolean), `not all incidents came: ${JSON.stringify(done)}`);
  const viewer = await enter(browser, server.viewer);
  expect((await viewer.page.$$(".step button, .aside")).length === 0, "who looks on can press something");
  await picture(viewer.page, "viewer");
  await page.goto(`${new URL(server.experimenter).origin}/matrix`);
  await picture(page, "matrix");
  await page.goto(`${new URL(server.experimenter).origin}/study`);
  await picture(page, "study");
  // The report opens in a window of its own.
  const [report] = await Promise.all([page.context().waitForEvent("page"), page.click("a[href$='session=discrimination']")]);
  await report.waitForSelector("h1");
  const inReport = await report.$$eval("section:nth-of-type(2) tr", (rows) => rows.length - 1);
  expect(inReport >= said.length, `${inReport} trials in the report of the session, ${said.length} answers`);
  await report.evaluate(axe);
  const faults = await report.evaluate(async () => (await globalThis.axe.run(document)).violations.map((one) => one.help));
  expect(faults.length === 0, `the report of the session: ${faults}`);
  if (shots) await report.screenshot({ path: join(shots, "session-report.png"), fullPage: true });
  const zip = await page.evaluate(async () => Array.from(new Uint8Array(await (await fetch("/tables.zip")).arrayBuffer())));
  server.child.kill("SIGINT");
  const began = Date.now();
  const { code, err } = await server.ended;
  expect(Date.now() - began < 2000, "the server takes longer than 2 s to end");
  run("campaign verify study");
  run("campaign export study --out exported");
  stored(said);
  // Its dictionary says by which command it was written.
  const packed = unpacked(Buffer.from(zip));
  for (const name of ["trials.csv", "answers.csv", "events/P01_discrimination.jsonl"]) {
    expect(packed.get(name)?.equals(readFileSync(join(folder, "exported", name))), `${name} in the downloaded tables differs from what is exported`);
  }
  const inMatrix = counted();
  if (process.exitCode) throw new Error("faults of accessibility: see above");
  console.log(`a session on two pages, ${killedAt + 1} kills: ${said.length} answers, each stored once, ${checked} steps without faults of accessibility, ${inMatrix} associations in the matrix (exit ${code}; ${err.trim().split("\n").pop()})`);
}

/// What plays ends at once, by every way there is to stop it; every press has a visible answer.
async function stopped(browser) {
  const server = await serve("serve study P02 discrimination --rehearsal --real-time --drives drives --bench twin:participant=1,seed=7 --port 0");
  const { context, page } = await enter(browser, server.experimenter);
  await page.click("details:has([data-post='/pairing']) > summary");
  await page.click("[data-post='/pairing']");
  const { page: participant } = await enter(browser, await page.locator(".facts code").textContent());
  const main = (one) => one.locator(".step > button.main").first();
  const waits = async () => (await page.locator(".step > .big").first().textContent()).includes("Textures on the device");
  while (!(await page.$(".step > button.main[data-ask*=present]")) || !(await waits())) {
    const before = await mark(page);
    if (await page.$(".step > .draft")) await answer(page, await words(page), "keys");
    else {
      await pressMain(page);
      await moved(page, before);
    }
  }
  const second = await context.newPage();
  await second.goto(page.url());
  const silence = (one) => one.locator("[data-ask*=silence]");
  const ways = {
    "Escape on the experimenter's page": () => page.keyboard.press("Escape"),
    "a press in a second tab": () => silence(second).click(),
    "Escape on the participant's page": () => participant.keyboard.press("Escape"),
    "a press of the participant": () => participant.locator("[data-stop]").click(),
    "a pause": () => page.click("[data-ask*=pause]"),
    "Escape while a note is typed": async () => { await page.focus("form.note input"); await page.keyboard.press("Escape"); },
    "all pages closed": () => Promise.all([page.goto("about:blank"), second.goto("about:blank")]),
    "the network lost": () => context.setOffline(true),
  };
  // From a press to its visible answer, by the clock of the page.
  const answeredMs = [];
  for (const one of [page, second, participant]) {
    await one.evaluate(() => {
      globalThis.answered = [];
      const pressed = () => {
        if (!document.querySelector("#page [data-playing]")) return;
        const at = performance.now();
        const look = new MutationObserver(() => {
          if (document.getElementById("sending").hidden && document.querySelector("#page [data-playing]")) return;
          look.disconnect();
          globalThis.answered.push(performance.now() - at);
        });
        look.observe(document.body, { subtree: true, childList: true, attributes: true });
      };
      for (const kind of ["click", "keydown"]) document.addEventListener(kind, pressed, true);
    });
  }
  for (const [way, act] of Object.entries(ways)) {
    await sleep(500);
    const before = await mark(page);
    await main(page).click();
    await Promise.all([page, second, participant].map((one) => one.waitForSelector("#page [data-playing]", { timeout: 5000 })));
    await picture(page, "experimenter-playing");
    await picture(participant, "participant-playing");
    if (way === "a press in a second tab") {
      // Nothing stops it while a page is there, for longer than the program waits for one.
      await sleep(5000);
      expect(await page.$("#page [data-playing]"), "a texture ended by itself while a page was open");
    }
    if (way === "a pause") {
      // A note does not stop it, and is seen to be taken.
      await page.fill("form.note input", "quiet");
      await page.click("form.note button");
      await page.waitForSelector("#sending:not([hidden])", { timeout: 2000 });
      expect(await page.$("#page [data-playing]"), "a note ended the texture");
    }
    await act();
    const own = way.includes("participant") ? participant : way.includes("second") ? second : page;
    if (way === "all pages closed") {
      await sleep(4500);
      await Promise.all([page, second].map((one) => one.goto(new URL("/experimenter", server.experimenter).href)));
    } else if (way === "the network lost") {
      await sleep(6000);
      await context.setOffline(false);
    } else await own.waitForFunction(() => !document.getElementById("sending").hidden || !document.querySelector("#page [data-playing]"), null, { timeout: 2000 }).catch((error) => { throw new Error(`${way}: ${error.message}`); });
    answeredMs.push(...(await own.evaluate(() => globalThis.answered?.splice(0) ?? [])));
    // Longer than any stop, shorter than any texture.
    await moved(page, before, 5000);
    const shown = await page.textContent(".step");
    if (/pause/i.test(shown) && !shown.includes("VOID")) expect(["a pause", "Escape on the participant's page", "a press of the participant"].includes(way), `${way} began a pause`);
    else expect(shown.includes("VOID"), `${way}: the trial is not said to be void: ${shown}`);
    if (await page.$("[data-ask*=go_on]")) {
      const paused = await mark(page);
      await page.click("[data-ask*=go_on]");
      await moved(page, paused);
    }
  }
  const ended = server.ended;
  // A texture that plays ends with the program.
  await main(page).click();
  await page.waitForSelector("#page [data-playing]", { timeout: 5000 });
  server.child.kill("SIGINT");
  const began = Date.now();
  await ended;
  expect(Date.now() - began < 2000, "Ctrl-C waits for the texture");
  run("campaign export study --out stopped");
  const trials = readFileSync(join(folder, "stopped/trials.csv"), "utf8").trim().split("\n").map(cells);
  const [names, ...rows] = trials;
  const voided = rows.filter((row) => row[names.indexOf("participant")] === "P02").reduce((sum, row) => sum + Number(row[names.indexOf("voided")]), 0);
  expect(voided === Object.keys(ways).length + 1, `${voided} void trials after ${Object.keys(ways).length + 1} stops`);
  console.log(`a texture that plays is stopped in ${voided} ways; ${answeredMs.length} presses had a visible answer within ${Math.ceil(Math.max(...answeredMs))} ms`);
}

/// A comparison: one press for each answer, by keys of the participant or the experimenter, and the next begins by itself.
async function compared(browser) {
  const levels = Array.from({ length: 14 }, (_, i) => `S8 increment ${2 * i - 26}`);
  const names = ["S8", ...levels];
  run("campaign new jnd --protocol roughness_jnd --seed 3");
  // All drives are that of S8: what is tried here is the page.
  for (const name of names) for (const [part, ending] of [["targets", "wav"], ["drives", "wav"], ["measured", "parquet"]]) {
    mkdirSync(join(folder, "increments", part), { recursive: true });
    for (const side of ["", ".json"]) {
      const from = join(folder, `drives/${part}/S8.${ending}${side}`);
      if (existsSync(from)) copyFileSync(from, join(folder, `increments/${part}/${name.replaceAll(" ", "_")}.${ending}${side}`));
    }
  }
  const server = await serve("serve jnd P01 discrimination --rehearsal --real-time --language it --drives increments --bench twin:participant=1,seed=7 --port 0");
  const { page } = await enter(browser, server.experimenter, { locale: "fr-FR" });
  await page.click("details:has([data-post='/pairing']) > summary");
  await page.click("[data-post='/pairing']");
  const { page: participant } = await enter(browser, await page.locator(".facts code").textContent(), { locale: "en-GB" });
  await picture(participant, "compared-consent");
  const main = () => page.locator(".step > button.main").first();
  while (!(await participant.$("[data-final]"))) {
    const before = await mark(page);
    await picture(page, `compared-${JSON.parse(await main().getAttribute("data-ask")).do}`);
    await pressMain(page);
    await moved(page, before);
  }
  const answers = 4;
  for (let i = 0; i < answers; i += 1) {
    await participant.waitForSelector("[data-final]", { timeout: 60_000 });
    await sleep(600);
    await picture(participant, "compared-answer");
    await picture(page, "compared-answer-experimenter");
    const shown = await participant.textContent(".choices");
    expect(/prima/.test(shown) && /seconda/.test(shown), `choices in Italian: ${shown}`);
    const before = await mark(page);
    if (i % 2) await page.keyboard.press("1");
    else await participant.locator("[data-choice=second]").click();
    await moved(page, before);
    await picture(participant, "compared-feedback");
    expect(!(await participant.content()).includes("increment") && !(await page.content()).includes("increment"), "a page names what is played");
  }
  server.child.kill("SIGINT");
  await server.ended;
  run("campaign export jnd --out jnd-tables");
  const [head, ...rows] = readFileSync(join(folder, "jnd-tables/trials.csv"), "utf8").trim().split("\n").map(cells);
  const given = rows.map((row) => row[head.indexOf("answer")]).filter(Boolean);
  expect(given.join(" ") === "second first second first", `one press for each answer: ${given}`);
  console.log(`${answers} comparisons with one press each`);
}

/// The files of a ZIP file with their contents, by its central directory.
function unpacked(zip) {
  const files = new Map();
  let at = zip.readUInt32LE(zip.lastIndexOf("PK\x05\x06", undefined, "latin1") + 16);
  while (zip.readUInt32LE(at) === 0x02014b50) {
    const [size, long, extra, comment] = [zip.readUInt32LE(at + 20), zip.readUInt16LE(at + 28), zip.readUInt16LE(at + 30), zip.readUInt16LE(at + 32)];
    const local = zip.readUInt32LE(at + 42);
    const from = local + 30 + zip.readUInt16LE(local + 26) + zip.readUInt16LE(local + 28);
    const bytes = zip.subarray(from, from + size);
    files.set(zip.toString("utf8", at + 46, at + 46 + long), zip.readUInt16LE(at + 10) === 8 ? inflateRawSync(bytes) : bytes);
    at += 46 + long + extra + comment;
  }
  return files;
}

/// Compares the tables with what was said: trials in their order, each once.
function stored(said) {
  const lines = readFileSync(join(folder, "exported/trials.csv"), "utf8").trim().split("\n");
  const names = lines[0].split(",");
  const trials = lines.slice(1).map((line) => Object.fromEntries(cells(line).map((cell, i) => [names[i], cell])));
  const answered = trials.filter((trial) => trial.answer && trial.session === "discrimination");
  expect(answered.length === said.length, `expected ${said.length} answered trials, found ${answered.length}: ${names}`);
  const parts = (trial) => trial.answer.split(/[ ;|]+/);
  answered.forEach((trial, i) => {
    // Letters stand for the participant's own order of the same set.
    const order = answered.find((other) => other.trial === trial.trial.replace("task3", "task2"));
    const meant = said[i].map((word) => (trial.task === "task3" && word.length === 1 ? parts(order)[word.charCodeAt(0) - 65] : word));
    expect(parts(trial).join(" ") === meant.join(" "), `trial ${trial.trial}: expected ${meant.join(" ")}, found ${trial.answer}`);
  });
}

/// Compares the association matrix with what was said to each texture that was presented.
function counted() {
  run("answers study --csv cells.csv");
  const rows = (name) => {
    const lines = readFileSync(join(folder, name), "utf8").trim().split("\n");
    const names = cells(lines[0]);
    return lines.slice(1).map((line) => Object.fromEntries(cells(line).map((cell, i) => [names[i], cell])));
  };
  const said = new Map();
  for (const trial of rows("exported/trials.csv").filter((one) => one.task === "task3")) {
    const words = trial.answer.split(/[ ;|]+/);
    trial.presented.split("|").forEach((presented, i) => said.set(`${presented} ${words[i]}`, (said.get(`${presented} ${words[i]}`) ?? 0) + 1));
  }
  let all = 0;
  for (const cell of rows("cells.csv").filter((one) => one.group === "all")) {
    expect(Number(cell.declared) === (said.get(`${cell.presented} ${cell.answered}`) ?? 0), `${cell.presented} called ${cell.answered}: ${cell.declared} in the matrix`);
    all += Number(cell.declared);
  }
  expect(all === [...said.values()].reduce((a, b) => a + b, 0) && all >= 36, `${all} answers in the matrix`);
  return all;
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
  await main(browser);
  await stopped(browser);
  await compared(browser);
  rmSync(folder, { recursive: true });
} catch (error) {
  console.error(`${error.stack}\nthe study is in ${folder}`);
  process.exitCode = 1;
  if (shots) for (const context of browser.contexts()) for (const [i, page] of context.pages().entries()) await page.screenshot({ path: join(shots, `fault-${browser.contexts().indexOf(context)}-${i}.png`), fullPage: true }).catch(() => {});
} finally {
  await browser.close();
  process.exit();
}
