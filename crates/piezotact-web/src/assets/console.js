// The console of a bench: draws what is acquired, starts and stops procedures.
"use strict";

const by = (id) => document.getElementById(id);
const mark = document.querySelector('meta[name="piezotact-mark"]').content;

// ---- Charts.

const colour = { line: "#0b4f8a", fill: "rgba(11, 79, 138, .25)", band: "rgba(34, 120, 60, .18)", target: "#22783c" };

// A number with a few digits, also very small ones.
const shown = (v) => v === null || v === undefined ? "" : v === 0 ? "0" : Math.abs(v) < 1e-3 || Math.abs(v) >= 1e5 ? v.toExponential(0) : String(Number(v.toPrecision(3)));
const axis = { font: "13px system-ui, sans-serif", labelFont: "13px system-ui, sans-serif", labelSize: 18, stroke: "#111", grid: { stroke: "#ddd", width: 1 }, ticks: { stroke: "#999", width: 1 }, values: (_, all) => all.map(shown) };
// Of a logarithmic axis the powers of ten alone.
const decades = { filter: (_, all) => all.map((v) => Number.isInteger(Number(Math.log10(v).toFixed(6))) ? v : null) };
const logarithmic = { ...axis, ...decades, grid: { ...axis.grid, ...decades }, ticks: { ...axis.ticks, ...decades } };
const hertz = { ...logarithmic, label: "Hz", size: 34 };
const seconds = { ...axis, label: "s", size: 34 };

// The range in which the force is accepted, behind the trace.
let forceNow = null;
const bandOf = (plot) => {
  if (!forceNow?.band_n) return;
  const [low, high] = forceNow.band_n;
  const { ctx } = plot;
  const [top, bottom] = [plot.valToPos(high, "y", true), plot.valToPos(low, "y", true)];
  ctx.save();
  ctx.beginPath();
  ctx.rect(plot.bbox.left, plot.bbox.top, plot.bbox.width, plot.bbox.height);
  ctx.clip();
  ctx.fillStyle = colour.band;
  ctx.fillRect(plot.bbox.left, top, plot.bbox.width, bottom - top);
  ctx.restore();
};

function chart(id, { series, x, y, upright }) {
  const place = by(id);
  const size = () => ({ width: place.clientWidth, height: 200 });
  const options = {
    ...size(), series: [{}, ...series], cursor: { show: false }, legend: { show: false },
    scales: { x: { time: false, ...x }, y }, axes: [hertz, { ...upright, size: 64 }],
  };
  const plot = new uPlot(options, [[], ...series.map(() => [])], place);
  new ResizeObserver(() => plot.setSize(size())).observe(place);
  return plot;
}

const line = { stroke: colour.line, width: 1.5, points: { show: false } };
const range = { series: [{ ...line }, { ...line }] };
// A trace is the area between the smallest and the largest sample of each moment.
const trace = (id, y, hooks) => {
  const place = by(id);
  const size = () => ({ width: place.clientWidth, height: 200 });
  const plot = new uPlot({
    ...size(), hooks, cursor: { show: false }, legend: { show: false }, bands: [{ series: [2, 1], fill: colour.fill }],
    series: [{}, ...range.series], scales: { x: { time: false, range: [-10, 0] }, y }, axes: [seconds, { ...axis, size: 64 }],
  }, [[], [], []], place);
  new ResizeObserver(() => plot.setSize(size())).observe(place);
  return plot;
};
const plots = {
  vibration: trace("vibration", {}, {}),
  force: trace("force", { range: (_, low, high) => {
    const upper = Math.max(high ?? 0, (forceNow?.target_n ?? 0) * 1.5, 0.1);
    return [Math.min(0, low ?? 0), upper * 1.05];
  } }, { drawAxes: [bandOf] }),
  spectrum: chart("spectrum", { series: [line], x: { distr: 3, range: [10, 2500] }, y: { distr: 3 }, upright: logarithmic }),
  coherence: chart("coherence", { series: [line], x: { distr: 3, range: [10, 2500] }, y: { range: [0, 1.02] }, upright: axis }),
};

const drawTrace = (plot, of) => plot.setData(of ? [of.at_s, of.low, of.high] : [[], [], []]);
// From the first line above 10 Hz on; a logarithmic axis has no zero.
const drawLines = (plot, of, least) => {
  if (!of) { plot.setData([[], []]); return; }
  const from = of.frequency_hz.findIndex((f) => f >= 10);
  plot.setData([of.frequency_hz.slice(from), of.value.slice(from).map((v) => Math.max(v, least))]);
};

function fast(view) {
  forceNow = view.force_now;
  drawTrace(plots.vibration, view.vibration);
  drawTrace(plots.force, view.force);
  drawLines(plots.spectrum, view.spectrum, 1e-15);
  by("acquired").textContent = view.label ? `${view.acquired_s.toFixed(1)} s` : "–";
  by("left").textContent = view.left_s == null || view.ended ? "–" : `${view.left_s.toFixed(0)} s`;
  by("level").textContent = view.level ? `${shown(view.level.rms_m_s2)} m/s²` : "–";
  const { now_n: now, mean_n: mean, target_n: target } = forceNow ?? {};
  const against = (force) => target ? ` (${force >= target ? "+" : "−"}${Math.abs(100 * (force / target - 1)).toFixed(0)} %)` : "";
  by("force-mean").textContent = forceNow ? `${mean.toFixed(3)} N${against(mean)}` : "–";
  by("force-now").textContent = forceNow ? `${now.toFixed(3)} N${against(now)}` : "–";
  // The mean is what is judged.
  by("force-mean").classList.toggle("bad", Boolean(forceNow?.band_n) && !view.ended && now > target / 4 && (mean < forceNow.band_n[0] || mean > forceNow.band_n[1]));
  const met = view.judged.filter(([, outcome]) => outcome === "met").length;
  by("judged").textContent = view.judged.length ? `${met} / ${view.judged.length}` : "–";
  by("ended").hidden = !view.ended;
  by("ended").textContent = view.ended ?? "";
}

function slow(view) {
  const { coherence, strokes } = view;
  drawLines(plots.coherence, coherence?.lines, 0);
  by("coherence-now").textContent = coherence?.median == null ? "–" : `${coherence.median.toFixed(3)} (${coherence.lines.averages} ×)`;
  by("strokes").textContent = strokes ? `${strokes.accepted} (${strokes.rejected})` : "–";
}

// ---- What runs, and what was made.

function show(view) {
  const state = by("state");
  state.textContent = view.running ?? state.dataset.idle;
  document.querySelectorAll(".procedure button").forEach((button) => { button.disabled = Boolean(view.running); });
  if (by("stop")) by("stop").disabled = !view.running;
  by("command").textContent = view.command ?? "";
  by("files").replaceChildren(...view.files.map((name) => {
    const [item, link] = [document.createElement("li"), document.createElement("a")];
    link.href = `/console/files/${encodeURIComponent(name)}`;
    link.textContent = name;
    if (name.endsWith(".html")) link.target = "_blank";
    item.append(link);
    return item;
  }));
  by("lines").replaceChildren(...view.lines.map(([at, text]) => {
    const item = document.createElement("li");
    item.textContent = `${new Date(at).toLocaleTimeString()} ${text}`;
    return item;
  }));
}

async function ask(what) {
  by("refused").hidden = true;
  try {
    const reply = await fetch("/console/ask", {
      method: "POST", headers: { "content-type": "application/json", "x-piezotact-mark": mark }, body: JSON.stringify(what),
    });
    if (reply.ok) return;
    by("refused").textContent = await reply.text() || `HTTP ${reply.status}`;
    by("refused").hidden = false;
    by("not-yours").hidden = reply.status !== 401;
  } catch (_) {
    by("not-connected").hidden = false;
  }
}

document.querySelectorAll("[data-procedure]").forEach((form) => form.addEventListener("submit", (event) => {
  event.preventDefault();
  ask({ do: "start", procedure: form.dataset.procedure, values: Object.fromEntries(new FormData(form)) });
}));
by("stop")?.addEventListener("click", () => ask({ do: "stop" }));

followLive("/live", { fast, slow });
followLive("/console/stream", {
  console: show,
  open: () => { by("not-connected").hidden = true; },
  lost: () => { by("not-connected").hidden = false; },
});

// ---- Metronome: planned by the clock of the sound, so that it does not drift.

let audio = null;
let next = 0;
let beats = null;
const metronome = by("metronome");
metronome.addEventListener("submit", (event) => {
  event.preventDefault();
  const button = metronome.querySelector("button");
  const on = !audio;
  button.setAttribute("aria-pressed", on);
  button.textContent = on ? button.dataset.on : button.dataset.off;
  if (!on) { clearInterval(beats); audio.close(); audio = null; by("beat").className = ""; return; }
  audio = new AudioContext();
  next = audio.currentTime + 0.1;
  beats = setInterval(() => {
    const period = Math.max(0.2, Number(metronome.elements.period.value) || 2);
    while (audio && next < audio.currentTime + 0.2) {
      const [tone, level] = [audio.createOscillator(), audio.createGain()];
      tone.frequency.value = 880;
      level.gain.setValueAtTime(0.2, next);
      level.gain.exponentialRampToValueAtTime(0.001, next + 0.08);
      tone.connect(level).connect(audio.destination);
      tone.start(next);
      tone.stop(next + 0.1);
      setTimeout(() => { by("beat").className = "on"; setTimeout(() => { by("beat").className = ""; }, 120); }, 1000 * (next - audio.currentTime));
      next += period;
    }
  }, 50);
});
