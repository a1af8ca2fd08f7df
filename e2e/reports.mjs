// Makes every kind of report with the program, on the twin, in a folder; the reports are what is measured.
import { execFile } from "node:child_process";
import { mkdirSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { promisify } from "node:util";

import { answers, hits, profile, rest } from "./signals.mjs";

const run = promisify(execFile);

/// Recordings, transfer functions and textures that the reports need: each row's commands run in order.
const material = (twin) => [
  ["twin", "record", "--bench", "shaker", "--seconds", "12", "--out", "shaker.parquet"],
  ["characterise", "--bench", twin(2), "--seconds", "8", "--out", "tf.json", "--report", "characterise.html"],
  ["characterise", "--bench", twin(3), "--seconds", "4", "--out", "tf3.json"],
  ["characterise", "--bench", twin(2), "--seconds", "10", "--repeats", "2", "--excitation", "multisine", "--out", "multisine.json", "--report", "characterise-multisine.html"],
  ["panel", "run", "--bench", "twin:seed=7", "--participants", "1..4", "--loads", "0.2,0.6", "--angles", "20,40", "--repeats", "2", "--seconds", "4", "--out", "panel"],
  ["twin", "surface", "M8", "--size", "3mm", "--step", "6um", "--out", "M8.sur"],
];

/// A sound device that is a loop within the program.
const sound = `host = "loop"
rate_hz = 48000
play = { drive = [1] }
record = [{ channel = 1, measures = "drive" }, { channel = 2, measures = "acceleration", mv_per_m_s2 = 10.2 }]
[loop]
finger = "twin:participant=1,seed=7"
`;

/// One recording of the twin.
const touched = (bench, sample, name, ...more) =>
  ["twin", "record", "--bench", bench, "--sample", sample, ...more, "--out", `${name}.parquet`];

const touches = () => [
  ...["S1", "S2", "S3", "S4", "S5", "S6", "S7", "S8", "S9", "S10", "S11", "S12", "S13", "NO"].map((sample) =>
    touched("triboair", sample, `passive/${sample}`, "--participant", "0")),
  ...["S2", "S8"].flatMap((sample) => [10, 20, 30].map((speed) =>
    touched("triboair", sample, `speeds/${sample}_V${speed}`, "--speed", `${speed} mm/s`))),
  ...["S2", "S8", "S13"].map((sample) => touched("acttouch", sample, `active/${sample}`, "--strokes", "10", "--participant", "0")),
  ...[1, 2, 3].map((who) => touched("acttouch", "S4", `people/P${who}`, "--strokes", "10", "--participant", `${who}`)),
  ...[0.2, 0.4, 0.6].map((load) => touched("triboair", "S3", `loads/S3_F${load}`, "--load", `${load}`)),
  ...["proximal", "distal", "transversal", "circular"].map((direction) =>
    touched("acttouch", "S3", `directions/S3_${direction}`, "--strokes", "12", "--participant", "0", "--direction", direction)),
  // One participant's session: tf.json is of the same one.
  ...["S1", "S8", "S11"].map((sample) => touched("acttouch", sample, `session/${sample}`, "--strokes", "5", "--participant", "2", "--seed", "7")),
];

/// `files(folder)`: what was recorded into it.
const files = (folder) => touches().map((row) => row.at(-1)).filter((name) => name.startsWith(`${folder}/`));

/// EEG of two participants in two tasks, with the reports about one of them and about both.
const brains = () => {
  const sittings = [1, 2].flatMap((who) => ["natural", "control"].map((task) => [who, task]));
  const pilot = ["eeg/P1_natural.vhdr", "--participant", "P1", "--task", "natural", "--event", "natural", "--eog", "VEOG,HEOG", "--reject-above", "150"];
  return [
    ...sittings.map(([who, task]) =>
      ["twin", "record", "--bench", "eeg", "--task", task, "--participant", `${who}`, "--seed", "7", "--trials", "10", "--out", `eeg/P${who}_${task}.vhdr`]),
    ...sittings.map(([who, task]) =>
      ["eeg", "erd", `eeg/P${who}_${task}.vhdr`, "--participant", `P${who}`, "--task", task, "--event", task, "--channels", "C5,C3,C1,CP3,CP1", "--region", "hand=C3,CP3", "--out", `eeg/P${who}_${task}.json`]),
    ["eeg", "info", "eeg/P1_natural.vhdr", "--report", "eeg-info.html"],
    ["eeg", "epochs", ...pilot, "--report", "eeg-epochs.html"],
    ["eeg", "erd", ...pilot, "--out", "eeg/all.json", "--report", "eeg-erd.html"],
    ["eeg", "stats", ...sittings.map(([who, task]) => `eeg/P${who}_${task}.json`), "--unit", "db", "--report", "eeg-stats.html"],
  ];
};

/// The reports in rows of what can run after one another; rows run side by side. `piezotact export` has none.
const rows = (twin) => [
  [
    ["demo", "--out", "demo"],
    ["spectrum", "demo/target.wav", "--over-time", "--max-frequency", "500", "--report", "spectrum.html"],
    ["render", "demo/target.wav", "--transfer", "tf.json", "--level", "fit", "--out", "drive.wav"],
    ["play", "drive.wav", "--bench", twin(2), "--record", "measured.parquet"],
    ["sound", "burst", "drive.wav", "--out", "bursts.wav"],
    ["play", "bursts.wav", "--bench", twin(2), "--record", "elsewhere.parquet"],
    ["sound", "align", "bursts.wav", "elsewhere.parquet", "--channel", "acceleration", "--out", "aligned.parquet", "--report", "align.html"],
    ["manipulate", "demo/target.wav", "--band", "100..200:+6dB", "--gain", "-3dB", "--loop", "4s", "--out", "other.wav", "--report", "manipulate.html"],
    ["manipulate", "demo/target.wav", "--randomise-phases", "--rms-of", "other.wav", "--out", "swapped.wav", "--report", "manipulate-rms.html"],
    ["verify", "--target", "demo/target.wav", "--measured", "measured.parquet", "--transfer", "tf.json", "--report", "verify.html"],
    ["verify", "--target", "demo/target.wav", "--measured", "measured.parquet", "--also", "demo/measured.parquet", "--before", "other.wav", "--before", "swapped.wav", "--transfer", "tf.json", "--report", "verify-also.html"],
    ["score", "demo/target.wav", "measured.parquet", "--report", "score.html"],
    ["render", "demo/target.wav", "--transfer", "tf.json", "--level", "fit", "--mode", "texture", "--bench", twin(2), "--iterations", "2", "--out", "corrected.wav", "--report", "render.html"],
    ["render", "demo/target.wav", "other.wav", "--transfer", "tf.json", "--transfer", "tf3.json", "--level", "fit", "--mode", "replicate", "--bench", twin(2), "--bench", twin(3), "--iterations", "1", "--out", "drives", "--report", "render-several.html"],
  ],
  [
    ["prepare", ...files("session"), "--transfer", "tf.json", "--bench", twin(2), "--out", "prepared", "--report", "prepare.html"],
    ["spectrum", "--rest", "rest.csv", "--report", "noise.html"],
    ["sound", "calibrate", "sound.toml", "--input-volts", "2", "--wires", "--report", "calibrate.html"],
    ["sound", "latency", "sound.toml", "--restarts", "60", "--report", "latency.html"],
    ["transfer", "shaker.parquet", "--drive", "force", "--response", "acceleration", "--out", "shaker-tf.json", "--report", "transfer.html"],
    ["transfer", "hits.csv", "--drive", "force", "--response", "acceleration", "--out", "hits-tf.json", "--report", "transfer-hits.html"],
    ["panel", "analyse", "panel", "--report", "panel.html"],
    ["roughness", "M8.sur", "--report", "roughness-map.html"],
    ["roughness", "profile.csv", "--report", "roughness-profile.html"],
    ["roughness", "M8.sur", "profile.csv", "--report", "roughness-set.html"],
    ["strokes", "--cuts-only", "active/S2.parquet", "directions/S3_transversal.parquet", "--report", "segment.html"],
    ["strokes", ...files("passive"), "--report", "analyse.html"],
    ["strokes", "active/S8.parquet", "--report", "analyse-one.html"],
    ["compare", "--by", "sample", ...files("passive"), "--report", "compare-sample.html"],
    ["compare", "--by", "speed", ...files("speeds"), "--report", "compare-speed.html"],
    ["compare", "--by", "participant", ...files("people"), "--report", "compare-participant.html"],
    ["compare", "--by", "load", ...files("loads"), "--report", "compare-load.html"],
    ["compare", "--by", "direction", ...files("directions"), "--report", "compare-direction.html"],
    ["compare", "--by", "touch", ...files("passive"), ...files("active"), "--report", "compare-touch.html"],
  ],
  [
    ["replay", "--chapter", "6", "--out", "replay"],
    ["answers", "answers.csv", "--report", "matrix.html"],
    ["answers", "answers.csv", "--felt", "passive", "--report", "matrix-felt.html"],
    ["campaign", "design", "isotropic_triplets", "--report", "design.html"],
    ["campaign", "design", "touch_control_imagery", "--report", "design-comparison.html"],
    ...brains(),
  ],
];

/// Makes all reports in `folder` with `program`, and with the program of validation beside it; what a command printed is in the error where it fails.
export async function makeReports(program, folder, accepted = [0, 3, 4, 5]) {
  const twin = (who) => `twin:participant=${who},seed=7`;
  for (const name of ["passive", "active", "speeds", "people", "loads", "directions", "session", "eeg"]) {
    mkdirSync(join(folder, name), { recursive: true });
  }
  for (const [name, text] of [["rest.csv", rest()], ["hits.csv", hits()], ["profile.csv", profile()], ["answers.csv", answers()], ["sound.toml", sound]]) {
    writeFileSync(join(folder, name), text);
  }
  const piezotact = async (row) => {
    try {
      await run(row[0] === "replay" ? join(dirname(program), "piezotact-validation") : program, row, { cwd: folder, maxBuffer: 1 << 26 });
    } catch (error) {
      if (!accepted.includes(error.code)) {
        throw new Error(`piezotact ${row.join(" ")}: ended with ${error.code}\n${error.stderr ?? error.message}`);
      }
    }
  };
  const inOrder = async (commands) => {
    for (const row of commands) await piezotact(row);
  };
  // Two programs at a time: the machines that run this have two cores.
  await Promise.all([inOrder(material(twin)), inOrder(touches())]);
  const [first, second, last] = rows(twin);
  await Promise.all([inOrder([...first, ...second]), inOrder(last)]);
}
