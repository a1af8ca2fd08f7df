// What a bench acquires, as it comes: for the console, and as a gauge of the normal force on the pages of a session.
"use strict";

// Follows `address` and calls `on[name]` with what each event holds; goes on by itself after an interruption.
function followLive(address, on) {
  const source = new EventSource(address);
  for (const [name, take] of Object.entries(on)) {
    if (name === "open" || name === "lost") continue;
    source.addEventListener(name, (event) => take(JSON.parse(event.data)));
  }
  source.onopen = () => on.open?.();
  source.onerror = () => {
    on.lost?.();
    // A browser gives up where the server answers with an error: a page that is replaced asks once in a while.
    if (source.readyState === EventSource.CLOSED) setTimeout(() => followLive(address, on), 2000);
  };
  return source;
}

// A tone that rises above the target and falls below it: an octave for half the target.
class ForceTone {
  start() {
    this.audio = new AudioContext();
    this.tone = this.audio.createOscillator();
    this.level = this.audio.createGain();
    this.level.gain.value = 0;
    this.tone.connect(this.level).connect(this.audio.destination);
    this.tone.start();
  }
  stop() { this.audio?.close(); this.audio = null; }
  sound(share, inBand) {
    if (!this.audio) return;
    const now = this.audio.currentTime;
    this.tone.frequency.setTargetAtTime(440 * 2 ** Math.max(-1.5, Math.min(1.5, 2 * (share - 1))), now, 0.05);
    this.level.gain.setTargetAtTime(inBand ? 0.03 : 0.12, now, 0.05);
  }
  silence() { this.level?.gain.setTargetAtTime(0, this.audio?.currentTime ?? 0, 0.05); }
}

const gauge = document.getElementById("gauge");
if (gauge) {
  const tone = new ForceTone();
  const [now, word, meter, button] = ["now", "word", "meter", "tone"].map((name) => document.getElementById(`gauge-${name}`));
  button.addEventListener("click", () => {
    const on = button.getAttribute("aria-pressed") !== "true";
    button.setAttribute("aria-pressed", on);
    if (on) tone.start(); else tone.stop();
  });
  const show = (force, runs) => {
    // Between two textures there is no force to be held.
    gauge.hidden = !force || !runs;
    if (gauge.hidden) { tone.silence(); return; }
    now.textContent = `${force.now_n.toFixed(2)} N` + (force.target_n ? ` / ${force.target_n.toFixed(2)} N` : "");
    if (!force.target_n) { meter.hidden = true; word.textContent = ""; return; }
    const share = force.now_n / force.target_n;
    const [low, high] = force.band_n;
    const inBand = force.now_n >= low && force.now_n <= high;
    meter.value = Math.min(2, Math.max(0, share));
    word.textContent = inBand ? gauge.dataset.good : force.now_n < low ? gauge.dataset.low : gauge.dataset.high;
    gauge.classList.toggle("bad-force", !inBand);
    tone.sound(share, inBand);
  };
  // They come with the steps of the session.
  document.addEventListener("fast", ({ detail }) => show(detail.force_now, detail.label && !detail.ended));
  document.addEventListener("force", ({ detail }) => show(detail.now, detail.runs));
}
