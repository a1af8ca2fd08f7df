// Signals that the twin has no bench for, as tables: a sensor at rest, hits of a hammer, a profile.

/// Numbers between 0 and 1 that are the same at every run (Park and Miller's generator).
function randomNumbers(seed) {
  let state = seed;
  return () => (state = (state * 48271) % 2147483647) / 2147483647;
}

function gaussian(random) {
  return () => Math.sqrt(-2 * Math.log(random())) * Math.cos(2 * Math.PI * random());
}

const table = (columns, rows) => [columns.join(","), ...rows.map((row) => row.join(","))].join("\n") + "\n";

/// 12 s of a sensor at rest with mains hum, at 2 kHz.
export function rest() {
  const noise = gaussian(randomNumbers(11));
  const rows = Array.from({ length: 24000 }, (_, i) => {
    const t = i / 2000;
    return [t.toFixed(4), (0.002 * noise() + 0.0005 * Math.sin(2 * Math.PI * 50 * t)).toExponential(5)];
  });
  return table(["time (s)", "acceleration (m/s2)"], rows);
}

/// Eight hits of a hammer on a structure that rings at 120 Hz, at 4 kHz.
export function hits() {
  const rate = 4000;
  const noise = gaussian(randomNumbers(5));
  const count = 8 * rate * 2;
  const force = new Float64Array(count);
  const response = new Float64Array(count);
  for (let hit = 0; hit < 8; hit += 1) {
    const start = hit * rate * 2 + 800;
    for (let i = 0; i < 6; i += 1) force[start + i] = 20 * Math.sin((Math.PI * (i + 1)) / 7) * (1 + 0.1 * hit);
  }
  // The response of one mode: an impulse response, summed over the pulses.
  for (let i = 0; i < count; i += 1) {
    if (force[i] === 0) continue;
    for (let k = 0; k < rate && i + k < count; k += 1) {
      response[i + k] += force[i] * 0.4 * Math.exp((-25 * k) / rate) * Math.sin((2 * Math.PI * 120 * k) / rate);
    }
  }
  const rows = Array.from({ length: count }, (_, i) => [
    (i / rate).toFixed(5), (force[i] + 0.004 * noise()).toExponential(6), (response[i] + 0.002 * noise()).toExponential(6),
  ]);
  return table(["time (s)", "force (N)", "acceleration (m/s2)"], rows);
}

/// A profile of 50 mm with a roughness of some micrometres.
export function profile() {
  const noise = gaussian(randomNumbers(7));
  let height = 0;
  const rows = Array.from({ length: 25000 }, (_, i) => {
    height = 0.98 * height + noise();
    return [(i * 0.002).toFixed(3), (height + 8 * Math.sin(i / 900)).toFixed(4)];
  });
  return table(["x (mm)", "z (um)"], rows);
}

/// Answers of eight participants over triplets of 13 samples; a neighbour is answered now and then, and some pairs are never together.
export function answers() {
  const sets = ["S2 S4 S8", "S5 S7 S9", "S6 S11 S10", "S1 S3 S13", "S5 S8 S12", "S13 S12 S10"].map((set) => set.split(" "));
  const lines = ["participant,task,set,trial,presented,answered"];
  for (let person = 1; person <= 8; person += 1) {
    sets.forEach((samples, set) => samples.forEach((presented, i) => {
      const answered = (person * 7 + set * 3 + i) % 5 === 0 ? samples[(i + 1) % 3] : presented;
      lines.push(`P0${person},task3,${"ABCDEF"[set]},${i + 1},${presented},${answered}`);
    }));
  }
  return `${lines.join("\n")}\n`;
}
