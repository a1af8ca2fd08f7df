// A page of a session: shows the steps that the server sends, and sends what is pressed. It decides nothing.
"use strict";

const page = document.getElementById("page");
const meta = (name) => document.querySelector(`meta[name="piezotact-${name}"]`).content;
const alerts = (name, shown) => { document.getElementById(name).hidden = !shown; };

// ---- What is being sent. It is kept until the server has stored or refused it, also when the page is loaded again. It is of this page alone:
// another tab has its own.

// Of this page in this session: yesterday's is not sent today.
const own = meta("mark").slice(0, 16);
const PENDING = `piezotact pending ${own}`;
// What makes a sound begins when it is pressed, or not at all: it is not sent again.
const isKept = (one) => !one.sounds && one.do !== "silence";
let pending = JSON.parse(sessionStorage.getItem(PENDING) || "[]").filter(isKept);
let waiting = null;
let pairing = false;
// What is on its way now, by id.
const onItsWay = new Set();
// What ends a texture: it needs no turn, and nothing holds it up.
const STOPS = ["silence", "pause", "stop", "withdraw"];
// What fits any step. All else is asked at the step that is shown, one at a time.
const fitsAnyStep = (one) => [...STOPS, "note", "correct"].includes(one.do);

function keep(next) {
  pending = next;
  sessionStorage.setItem(PENDING, JSON.stringify(pending.filter(isKept)));
  page.classList.toggle("busy", pending.some((one) => !fitsAnyStep(one)));
  // What is stored within a moment needs no word.
  if (pending.some((one) => STOPS.includes(one.do))) sayPending();
  else setTimeout(sayPending, 100);
}

// That a press was taken is to be seen, also where its answer takes as long as a texture plays.
function sayPending() {
  const shown = document.getElementById("sending");
  const isPlaying = Boolean(page.querySelector("[data-playing]"));
  const late = pending.filter((one) => !(isPlaying && one.sounds));
  shown.hidden = late.length === 0;
  if (!shown.hidden) shown.textContent = shown.dataset[late.some((one) => STOPS.includes(one.do)) ? "stopping" : isPlaying ? "playing" : "sending"];
}

const mark = () => page.querySelector("[data-mark]").dataset.mark;

// Asks for `what`. What is bound to a step comes one at a time: what is pressed meanwhile at the same step is a second press. The next step
// can be shown before the answer to the request is here: what is pressed then waits for it.
function ask(what, form) {
  const bound = pending.find((one) => !fitsAnyStep(one));
  if (bound && !fitsAnyStep(what)) {
    if (bound.at !== mark()) waiting = { at: mark(), what };
    return;
  }
  // A second press of what is on its way sends it at once.
  const same = pending.find((one) => one.do === what.do && STOPS.includes(what.do));
  if (same) {
    send(same, form);
    return;
  }
  for (const one of ["moved-on", "refused"]) alerts(one, false);
  const id = [...crypto.getRandomValues(new Uint8Array(12))].map((b) => b.toString(16).padStart(2, "0")).join("");
  const { events } = page.querySelector("[data-mark]").dataset;
  const sounds = what.do === "play" || (what.do.startsWith("present") && Boolean(page.querySelector("[data-sounds]")));
  const one = { id, at: mark(), sounds, pressedAt: performance.now(), ...(events ? { seen: Number(events) } : {}), ...what };
  keep([...pending, one]);
  send(one, form);
}

// The form named `form`, which asked, is emptied once that is stored.
async function send(one, form) {
  if (onItsWay.has(one.id)) return;
  onItsWay.add(one.id);
  const done = () => keep(pending.filter((other) => other.id !== one.id));
  let again = 0;
  // A texture that is shown to play was begun: nothing more is waited for, and the connection is free for a stop.
  const begun = new AbortController();
  if (one.sounds) begins.set(one.id, begun);
  try {
    const reply = await fetch("/ask", {
      method: "POST",
      headers: { "content-type": "application/json", "x-piezotact-mark": meta("mark") },
      body: JSON.stringify(one),
      signal: begun.signal,
    });
    alerts("not-connected", false);
    alerts("not-stored", false);
    if (reply.status === 204) {
      if (one.do === "answer") sessionStorage.removeItem(DRAFT);
      done();
      for (const field of inForms()) if (field.form.className === form && (field.tagName === "INPUT" || form === "correct")) field.value = "";
    } else if (reply.status === 409) {
      done();
      alerts("moved-on", true);
    } else if (reply.status === 507) {
      document.querySelector("#not-stored span").textContent = await reply.text();
      alerts("not-stored", true);
      again = 2000;
    } else if (reply.status >= 500 || reply.status === 408 || reply.status === 429) {
      again = 1000;
    } else if (reply.status === 401 || reply.status === 403) {
      done();
      alerts("not-yours", true);
    } else {
      done();
      const why = document.getElementById("refused");
      why.textContent = (await reply.text()) || why.dataset.plain;
      alerts("refused", true);
    }
  } catch (_) {
    if (begun.signal.aborted) done();
    else {
      alerts("not-connected", true);
      again = 1000;
    }
  }
  onItsWay.delete(one.id);
  begins.delete(one.id);
  // A silence that found no way for so long: the program has ended the texture by itself.
  if (again && (one.sounds || (one.do === "silence" && performance.now() - one.pressedAt > 3000))) {
    again = 0;
    done();
    alerts("moved-on", true);
  }
  if (again) setTimeout(() => send(one, form), again);
  else if (waiting && !pending.some((other) => !fitsAnyStep(other))) {
    const { at, what } = waiting;
    waiting = null;
    if (at === mark()) ask(what);
  }
}

const begins = new Map();
const sendAll = () => pending.forEach((one) => send(one));

// ---- The steps.

// When the step last changed. What is pressed within this time was meant for the step before, or is a key that bounces.
const SETTLING_MS = 450;
let changedAt = -SETTLING_MS;
const isSettling = () => performance.now() - changedAt < SETTLING_MS;

let stream;
function follow() {
  stream = new EventSource(meta("stream"));
  stream.addEventListener("step", (event) => { alerts("not-connected", false); show(event.data); });
  // What a bench acquires, for the gauge of the force.
  for (const name of ["fast", "force"]) stream.addEventListener(name, (event) => document.dispatchEvent(new CustomEvent(name, { detail: JSON.parse(event.data) })));
  stream.addEventListener("open", () => { alerts("not-connected", false); sendAll(); });
  // While a texture plays the program looks whether a page is there that can stop it. It asks, as timers of hidden pages are slow.
  stream.addEventListener("beat", () => fetch("/beat", { method: "POST", headers: { "x-piezotact-mark": meta("mark") } }).catch(() => {}));
  stream.addEventListener("error", () => {
    // Refused for good: another device took this place, or the page belongs to another session.
    if (stream.readyState === EventSource.CLOSED) {
      fetch(location.pathname, { method: "HEAD", redirect: "manual" }).then(
        (reply) => { if (reply.type === "opaqueredirect" || reply.status === 403) alerts("not-yours", true); else setTimeout(follow, 1000); },
        () => { alerts("not-connected", true); setTimeout(follow, 1000); },
      );
    } else alerts("not-connected", true);
  });
}

const inForms = () => [...page.querySelectorAll("form input, form select")];
const nameOf = (field) => `${field.form.className} ${inForms().filter((f) => f.form === field.form).indexOf(field)}`;
const summaryOf = (details) => details.querySelector("summary").textContent.replace(/\d+/g, "");

// Puts a step in its place; what a person has opened or typed stays.
function show(html) {
  const before = page.querySelector("[data-mark]")?.dataset.mark;
  const open = [...page.querySelectorAll("details[open]")].map(summaryOf);
  // The trial that is corrected stays the one that was chosen; other lists are of their step.
  const stays = (field) => field.tagName === "INPUT" || field.form.className === "correct";
  const typed = new Map(inForms().filter(stays).map((f) => [nameOf(f), f.value]));
  const active = document.activeElement;
  const focus = page.contains(active) && active.form ? nameOf(active) : null;
  page.innerHTML = html;
  const isSame = before === mark();
  if (!isSame) {
    changedAt = performance.now();
    prefix = "";
  }
  for (const details of page.querySelectorAll("details")) {
    if (open.includes(summaryOf(details)) && (isSame || !details.closest(".step, .change"))) details.open = true;
  }
  for (const field of inForms()) {
    if (stays(field) && typed.get(nameOf(field))) field.value = typed.get(nameOf(field));
    if (focus && nameOf(field) === focus) field.focus();
  }
  ready();
  if (page.querySelector("[data-playing]")) for (const begun of begins.values()) begun.abort();
  sayPending();
}

function ready() {
  for (const time of page.querySelectorAll("time[data-ms]")) {
    const at = new Date(Number(time.dataset.ms));
    time.dateTime = at.toISOString();
    time.textContent = at.toLocaleTimeString(document.documentElement.lang, { hour12: false });
  }
  for (const draft of page.querySelectorAll("[data-draft]")) drawDraft(draft);
}

// ---- The answer that is being made. It stays through a reload, until it is sent.

const DRAFT = `piezotact draft ${own}`;
function chosen(draft) {
  const kept = JSON.parse(sessionStorage.getItem(DRAFT) || "null");
  return kept && kept.at === draft.dataset.draft ? kept.words : draft.dataset.noted.split("\n").filter(Boolean);
}
// Stores the answer that is being made, or sends it where one press is the answer.
function choose(draft, words) {
  if (draft.dataset.final !== undefined && words.length > 0) {
    ask({ do: "answer", words });
    return;
  }
  sessionStorage.setItem(DRAFT, JSON.stringify({ at: draft.dataset.draft, words }));
  drawDraft(draft);
  // The experimenter sees what is being answered.
  if (page.classList.contains("participant")) {
    fetch("/draft", {
      method: "POST",
      headers: { "content-type": "application/json", "x-piezotact-mark": meta("mark") },
      body: JSON.stringify({ at: draft.dataset.draft, words }),
    }).catch(() => {});
  }
}

// The place that was pressed is filled next; where each stands once, what stood there takes the place of the other.
function chooseNext(draft, choice) {
  const words = chosen(draft);
  const { at } = draft.dataset;
  // Where there is one place, another choice takes it.
  if (Number(draft.dataset.most) === 1) {
    choose(draft, [choice]);
    return;
  }
  if (at === undefined) {
    choose(draft, [...words, choice]);
    return;
  }
  delete draft.dataset.at;
  const other = draft.dataset.choose === "once" ? words.indexOf(choice) : -1;
  if (other >= 0) words[other] = words[Number(at)];
  words[Number(at)] = choice;
  choose(draft, words);
}

function drawDraft(draft) {
  const words = chosen(draft);
  const [least, most] = [Number(draft.dataset.least), Number(draft.dataset.most)];
  const label = (word) => [...draft.querySelectorAll("[data-choice]")].find((one) => one.dataset.choice === word)?.dataset.label ?? word;
  const { at } = draft.dataset;
  draft.querySelectorAll("[data-slot]").forEach((slot, i) => {
    slot.textContent = i < words.length ? label(words[i]) : "–";
    slot.disabled = i >= words.length;
    slot.setAttribute("aria-pressed", at === String(i));
    slot.classList.toggle("next", at === undefined ? i === words.length : at === String(i));
  });
  for (const choice of draft.querySelectorAll("[data-choice]")) {
    const used = draft.dataset.choose === "once" && words.includes(choice.dataset.choice);
    // Not disabled: the focus stays where it is, so that a key that bounces chooses nothing else.
    choice.setAttribute("aria-disabled", most > 1 && at === undefined && (used || words.length >= most));
  }
  const number = draft.querySelector("[data-number]");
  if (number && document.activeElement !== number) number.value = words[0]?.replace("?", "") ?? "";
  const send = draft.querySelector("[data-send]");
  draft.querySelector("[data-undo]").disabled = words.length === 0;
  send.disabled = words.length < least;
}

// A number is typed as it is: 1 and then 0 are 10, where 10 can be chosen.
let prefix = "";
function typed(draft, digit) {
  const all = [...draft.querySelectorAll("[data-choice]")].map((one) => one.dataset.choice);
  const text = [prefix + digit, digit].find((text) => all.some((one) => one.startsWith(text)));
  if (text === undefined) return;
  prefix = text;
  choose(draft, all.includes(text) ? [text] : []);
}

page.addEventListener("input", (event) => {
  const number = event.target.closest("[data-number]");
  if (!number) return;
  const whole = /^[-−]?[0-9]+$/.test(number.value) ? Number(number.value.replace("−", "-")) : NaN;
  const isIt = whole >= Number(number.dataset.from) && whole <= Number(number.dataset.to);
  number.setAttribute("aria-invalid", number.value !== "" && !isIt);
  choose(number.closest("[data-draft]"), isIt ? [String(whole)] : []);
});

// ---- What is pressed.

page.addEventListener("click", (event) => {
  const button = event.target.closest("button");
  if (button && isSettling() && button.dataset.stop === undefined) return;
  if (!button || button.disabled || button.getAttribute("aria-disabled") === "true" || button.type === "submit") return;
  const draft = button.closest("[data-draft]");
  if (draft) prefix = "";
  if (button.dataset.choice !== undefined) chooseNext(draft, button.dataset.choice);
  else if (button.dataset.slot !== undefined) {
    if (draft.dataset.at === button.dataset.slot) delete draft.dataset.at;
    else draft.dataset.at = button.dataset.slot;
    drawDraft(draft);
  } else if (button.dataset.undo !== undefined) {
    delete draft.dataset.at;
    choose(draft, chosen(draft).slice(0, -1));
  }
  else if (button.dataset.send !== undefined) ask({ do: "answer", words: chosen(draft) });
  else if (button.dataset.post) post(button.dataset.post);
  else if (button.dataset.twice && !button.dataset.pressed) {
    // The texture stops at the first press; the second one confirms the withdrawal.
    if (button.dataset.ask?.includes("withdraw") && page.querySelector("[data-playing]")) ask({ do: "silence" });
    // A double click is one press.
    button.dataset.pressed = event.timeStamp;
    button.dataset.text = button.textContent;
    button.textContent = button.dataset.twice;
    setTimeout(() => { delete button.dataset.pressed; button.textContent = button.dataset.text; }, 5000);
  } else if (button.dataset.ask) {
    if (button.dataset.pressed && event.timeStamp - Number(button.dataset.pressed) < 400) return;
    ask(JSON.parse(button.dataset.ask));
  }
});

async function post(where) {
  if (pairing) return;
  pairing = true;
  try { await fetch(where, { method: "POST", headers: { "x-piezotact-mark": meta("mark") } }); } catch (_) { alerts("not-connected", true); }
  pairing = false;
}

page.addEventListener("submit", (event) => {
  event.preventDefault();
  const form = event.target;
  const asking = form.className;
  const field = (name) => form.elements[name].value.trim();
  if (form.dataset.text) ask({ do: "note", text: field("text") }, asking);
  else if (form.dataset.why) ask({ do: "stop", why: field("text") }, asking);
  else if (form.dataset.names) ask({ do: "present_instead", names: [...form.querySelectorAll("select")].map((s) => s.value) }, asking);
  else if (form.dataset.correct !== undefined) {
    const said = field("words");
    const words = said.includes(",") ? said.split(",").map((w) => w.trim()) : said.split(/\s+/);
    ask({ do: "correct", trial: field("trial"), words: words.filter(Boolean), why: field("why") }, asking);
  }
});

// What is folded away is not to be seen, and takes no keys.
function isShown(one) {
  const folded = one.closest("details:not([open])");
  if (!folded) return true;
  return one.tagName === "SUMMARY" && one.parentElement === folded && !folded.parentElement.closest("details:not([open])");
}

// Escape stops what plays, whatever has the focus. Arrows move between what can be pressed, Enter presses, Backspace takes back; a choice has a key of its own.
document.addEventListener("keydown", (event) => {
  if (event.key === "Escape" && !event.repeat) page.querySelector("[data-stop]")?.click();
  if (event.key === "Enter" && event.target.closest("[data-number]")) event.target.closest("[data-draft]").querySelector("[data-send]").click();
  if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest("input, select, textarea")) return;
  const draft = [...page.querySelectorAll("[data-draft]")].find(isShown);
  if (event.key === "Backspace" && draft) {
    event.preventDefault();
    if (event.repeat) return;
    draft.querySelector("[data-undo]").click();
    return;
  }
  if (isSettling() && (event.key === "Enter" || event.key.length === 1)) {
    event.preventDefault();
    return;
  }
  const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
  if (step) {
    const all = [...page.querySelectorAll("button:not(:disabled):not([aria-disabled=true]), summary, a[href]")].filter(isShown);
    const those = page.classList.contains("participant") ? all : all.filter((one) => one.closest(".step"));
    // From where the focus is, also where that can be pressed no more.
    const here = document.activeElement;
    const after = those.filter((one) => here.compareDocumentPosition(one) & Node.DOCUMENT_POSITION_FOLLOWING && !here.contains(one));
    const before = those.filter((one) => here.compareDocumentPosition(one) & Node.DOCUMENT_POSITION_PRECEDING);
    const next = here === document.body ? those.at(step > 0 ? 0 : -1) : step > 0 ? after[0] ?? those[0] : before.at(-1) ?? those.at(-1);
    next?.focus();
    event.preventDefault();
    return;
  }
  if (event.repeat) { if (event.key === "Enter") event.preventDefault(); return; }
  if (event.key === "Enter" && !event.target.closest("button, summary, a")) {
    const main = draft?.querySelector("[data-send]:not(:disabled)") ?? page.querySelector(".step > button.main, main > button.main");
    // A participant goes to what is final before it is pressed: one Enter too many would confirm unread.
    const isUnread = page.classList.contains("participant") && main?.dataset.ask?.includes("confirm") && main.parentElement.querySelector(".change");
    if (main && main.checkVisibility() && !isUnread && !(draft && main.dataset.ask === undefined && main.disabled)) { event.preventDefault(); main.click(); }
    return;
  }
  if (!draft || event.key.length !== 1) return;
  const key = event.key.toLowerCase();
  const number = draft.querySelector("[data-number]");
  // A number is typed where it stands, wherever the focus was.
  if (number && /^[0-9-]$/.test(key)) number.focus();
  if (/^[0-9-]$/.test(key) && draft.querySelector("[data-numbers]")) {
    event.preventDefault();
    typed(draft, key);
    return;
  }
  const choice = [...draft.querySelectorAll("[data-key]")].find((one) => one.dataset.key === key);
  if (!choice) return;
  event.preventDefault();
  choice.click();
  // The last one is entered: Enter sends, wherever the focus was.
  const send = draft.querySelector("[data-send]");
  if (!send.disabled && chosen(draft).length >= Number(draft.dataset.most)) send.focus();
});

keep(pending);
ready();
follow();
sendAll();
