// How soon a texture ends after a stop arrives at the server: node stops.mjs PROGRAM [REPETITIONS]. A part of ./x bench; no browser is needed.
// Measured is from the moment at which the request is sent to the time of the event that stores the end, which comes after the last sound:
// an upper limit of the time to the first silent sample. The bench is the twin in real time, with the journal on the disk.
import { execFileSync, spawn } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { request } from "node:http";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";

const [given, times] = process.argv.slice(2);
if (!given) {
  console.error("usage: node stops.mjs PROGRAM [REPETITIONS]");
  process.exit(2);
}
const program = resolve(given);
const repetitions = Number(times ?? 50);
const LIMIT_MS = 100;
const folder = mkdtempSync(join(tmpdir(), "piezotact-stops-"));
const run = (line) => execFileSync(program, line.split(" "), { cwd: folder, encoding: "utf8", stdio: ["ignore", "pipe", "pipe"] });
const sleep = (ms) => new Promise((done) => setTimeout(done, ms));

/// One request; `cut` closes the connection once it is sent.
function send(origin, method, path, headers, body, cut) {
  return new Promise((done, lost) => {
    const sent = request(origin + path, { method, headers: { origin, ...headers } }, (reply) => {
      let text = "";
      reply.on("data", (part) => { text += part; });
      reply.on("end", () => done({ status: reply.statusCode, text, cookie: reply.headers["set-cookie"]?.[0]?.split(";")[0] }));
    });
    sent.on("error", (error) => (cut ? done({ status: 0 }) : lost(error)));
    sent.end(body, () => { if (cut) setTimeout(() => sent.destroy(), 20); });
  });
}

/// A page that was let in, which follows the session and answers its beats.
async function enter(origin, code) {
  const { cookie } = await send(origin, "POST", "/enter", { "content-type": "application/x-www-form-urlencoded" }, `code=${code}`);
  const isParticipant = (await send(origin, "GET", "/participant", { cookie })).status === 200;
  const role = isParticipant ? "participant" : "experimenter";
  const html = (await send(origin, "GET", `/${role}`, { cookie })).text;
  const headers = { cookie, "content-type": "application/json", "x-piezotact-mark": html.match(/piezotact-mark" content="([^"]+)"/)[1] };
  const page = { at: html.match(/data-mark="([^"]+)"/)[1], isPlaying: false };
  const stream = request(`${origin}/${role}/stream`, { headers: { cookie } }, (reply) => {
    let rest = "";
    reply.on("data", (part) => {
      rest += part;
      const events = rest.split("\n\n");
      rest = events.pop();
      for (const event of events) {
        if (/^event: beat$/m.test(event)) send(origin, "POST", "/beat", headers).catch(() => {});
        if (!/^event: step$/m.test(event)) continue;
        page.at = event.match(/data-mark="([^"]+)"/)[1];
        page.isPlaying = event.includes("data-playing");
      }
    });
    reply.on("error", () => {});
  });
  stream.on("error", () => {});
  stream.end();
  let ids = 0;
  page.ask = (what, cut) => send(origin, "POST", "/ask", headers, JSON.stringify({ id: `${ids += 1}`, at: page.at, ...what }), cut);
  page.post = (path) => send(origin, "POST", path, headers);
  page.html = () => send(origin, "GET", `/${role}`, { cookie });
  return page;
}

run("campaign new study --protocol roughness_jnd --seed 3");
run("twin record --bench acttouch --sample S8 --participant 1 --seed 7 --strokes 3 --stroke-time 1s --out S8.parquet");
run("characterise --bench twin:participant=1,seed=7 --out tf.json");
const PREPARED = "--transfer tf.json --bench twin:participant=1,seed=7 --mode texture";
run(`prepare S8.parquet ${PREPARED} --out first`);
// The levels of the protocol: S8 with an increment of so many dB re its own amplitude.
const levels = Array.from({ length: 14 }, (_, i) => 2 * i - 26);
for (const level of levels) run(`manipulate first/targets/S8.wav --gain ${(20 * Math.log10(1 + 10 ** (level / 20))).toFixed(3)}dB --out S8_increment_${level}.wav`);
run(`prepare S8.parquet ${levels.map((level) => `S8_increment_${level}.wav`).join(" ")} ${PREPARED} --out drives`);
const child = spawn(program, "serve study P01 discrimination --rehearsal --real-time --drives drives --bench twin:participant=1,seed=7 --port 0".split(" "), { cwd: folder, stdio: ["ignore", "pipe", "inherit"] });
process.on("exit", () => child.kill("SIGKILL"));
let out = "";
await new Promise((found, failed) => {
  child.stdout.on("data", (text) => { out += text; if (out.includes("Ctrl-C ends")) found(); });
  child.on("exit", (code) => failed(new Error(`the session did not begin: exit code ${code}`)));
});
const { origin, searchParams } = new URL(out.match(/http\S+/)[0]);
const page = await enter(origin, searchParams.get("code"));
const second = await enter(origin, searchParams.get("code"));
await page.post("/pairing");
const code = (await page.html()).text.match(/enter\?code=([^<"]+)/)[1];
const participant = await enter(origin, code);
for (const what of ["consent", "check", "check"]) { await sleep(100); const { status, text } = await page.ask({ do: what }); if (status !== 204) throw new Error(`${what}: ${status} ${text}`); }

const ways = {
  "an experimenter's page": () => page.ask({ do: "silence" }),
  "a second tab": () => second.ask({ do: "silence" }),
  "the participant's page": () => participant.ask({ do: "pause" }),
  "a page that closes at once": () => page.ask({ do: "silence" }, true),
};
const sent = [];
for (const way of Object.keys(ways)) {
  for (let i = 0; i < repetitions; i += 1) {
    await sleep(60);
    if (page.at.startsWith("paused")) await page.ask({ do: "go_on" });
    for (let waited = 0; !page.at.startsWith("running") && waited < 5000; waited += 5) await sleep(5);
    const over = page.ask({ do: "present" }).catch(() => {});
    for (let waited = 0; !page.isPlaying && waited < 5000; waited += 5) await sleep(5);
    await sleep(150 + 600 * Math.random());
    if (!page.isPlaying) throw new Error(`${way}: nothing plays: ${JSON.stringify(page)}`);
    sent.push([way, Date.now()]);
    await ways[way]();
    await over;
    // The next step is shown, and where it is a pause that too.
    await sleep(150);
    for (let waited = 0; page.isPlaying && waited < 5000; waited += 5) await sleep(5);
  }
}
const ended = new Promise((done) => child.on("exit", done));
child.kill("SIGINT");
await ended;
run("campaign export study --out tables");
const events = readFileSync(join(folder, "tables/events/P01_discrimination.jsonl"), "utf8").trim().split("\n").map((line) => JSON.parse(line));
const voided = events.filter((one) => JSON.stringify(one).includes('"voided"'));
if (voided.length !== sent.length) throw new Error(`${voided.length} void trials after ${sent.length} stops`);
let isMet = true;
for (const way of Object.keys(ways)) {
  const each = sent.map(([of, at], i) => [of, voided[i].at_ms - at]).filter(([of]) => of === way).map(([, ms]) => ms).sort((a, b) => a - b);
  const within = each.filter((ms) => ms <= LIMIT_MS).length;
  isMet &&= within === each.length;
  console.log(`stop by ${way}: its end is stored after ${each[Math.floor(each.length / 2)]} ms (median), ${each.at(-1)} ms (largest); ${within} of ${each.length} within ${LIMIT_MS} ms`);
}
rmSync(folder, { recursive: true });
process.exit(isMet ? 0 : 1);
