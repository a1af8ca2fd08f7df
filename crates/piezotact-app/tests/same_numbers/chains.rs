//! The chains of commands whose values are stored, and what stands in their folder before the first command.
//!
//! Commands of a chain run in one folder, each on what those before it wrote; `> FILE` keeps what a command prints.

use std::fmt::Write as _;

use crate::support::session::two_sets;
use crate::support::{Folder, noise, wav};

/// Touch on the twin: recordings, strokes, comparisons, a surface.
pub(crate) const TOUCH: &[&str] = &[
    "twin record --bench acttouch --sample S4 --participant 3 --speed 30mm/s --strokes 3 --out S4.parquet",
    "twin record --bench acttouch --sample S8 --participant 3 --speed 30mm/s --strokes 3 --out S8.parquet",
    "twin record --bench acttouch --sample M8 --participant 2 --free --strokes 2 --seed 5 --out M8.wav",
    "twin record --bench triboair --sample S4 --participant 3 --speed 20mm/s --strokes 2 --out T4_20.parquet",
    "twin record --bench triboair --sample S4 --participant 3 --speed 30mm/s --strokes 2 --out T4_30.parquet",
    "twin record --bench acttouch --sample S4 --participant 4 --speed 30mm/s --strokes 3 --out P4.parquet",
    "info S4.parquet",
    "info M8.wav",
    "strokes S4.parquet --write-cuts S4.cuts --csv cuts.csv --cuts-only",
    "strokes T4_20.parquet --cuts-only",
    "strokes S4.parquet S8.parquet --by sample --csv strokes.csv",
    "strokes T4_20.parquet --high-pass none --segment 2048 --ridge 0.545mm",
    "compare S4.parquet S8.parquet --by sample",
    "compare T4_20.parquet T4_30.parquet --by speed",
    "compare S4.parquet P4.parquet --by participant",
    "compare S4.parquet T4_30.parquet --by touch",
    "spectrum S4.parquet --channel acceleration",
    "spectrum S4.parquet --channel acceleration --segment 2048 --window blackman-harris --median",
    "manipulate S8.parquet --stroke 2 --band 50..100:+6dB --loop 2s --out stroke.wav",
    "twin surface S4 --size 3mm --step 10um --out S4.sur",
    "twin surface M8 --size 3mm --step 20um --seed 2 --out M8.sur",
    "roughness S4.sur",
    "roughness M8.sur --cutoff 0.8mm --form poly2",
];

/// A device on the twin: transfer functions, drives open and closed, playback, verification, manipulation, export.
pub(crate) const DEVICE: &[&str] = &[
    "characterise --bench twin:participant=1,seed=7 --seconds 10 --out tf.json --record raw.parquet",
    "characterise --bench twin:participant=2,seed=7 --seconds 10 --repeats 2 --out tf2.json",
    "characterise --bench twin:participant=1,seed=7 --seconds 6 --excitation sweep --out sweep.json",
    "characterise --bench twin:participant=1,seed=7 --seconds 10 --excitation multisine --out multisine.json",
    "info tf.json",
    "transfer raw.parquet --drive drive --response acceleration --estimator h2 --out h2.json",
    "transfer raw.parquet --drive drive --response acceleration --estimator hv --segment 1024 --out hv.json",
    "twin record --bench shaker --participant 3 --load 0.4 --seconds 5 --out finger.parquet",
    "twin record --bench shaker --control --seconds 5 --out control.parquet",
    "transfer finger.parquet --drive force --response acceleration --out finger.json",
    "render texture.wav --scale 200m/s2 --transfer tf.json --level fit --inverse plain --out plain.wav",
    "render texture.wav --scale 200m/s2 --transfer tf.json --level fit --inverse constant --out constant.wav",
    "render texture.wav --scale 200m/s2 --transfer tf.json --level fit --inverse coherence --out coherence.wav",
    "render texture.wav --scale 200m/s2 --transfer tf.json --level fit --inverse drive-limited --out limited.wav",
    "render texture.wav --scale 200m/s2 --transfer tf.json --level -3 --phase minimum --band 30..500 --out minimum.wav",
    "play plain.wav --bench twin:participant=1,seed=7 --record measured.parquet",
    "info measured.parquet",
    "verify --target texture.wav --scale 200m/s2 --measured measured.parquet --transfer tf.json",
    "score texture.wav measured.parquet --scale 200m/s2",
    "play plain.wav --bench measured:tf2.json,seed=7 --record rehearsed.parquet",
    "verify --target texture.wav --scale 200m/s2 --measured rehearsed.parquet --also measured.parquet",
    "render texture.wav --scale 200m/s2 --transfer tf.json --mode texture --bench twin:participant=1,seed=7 --iterations 2 --level fit --out loop_t.wav --record loop_t.parquet",
    "render texture.wav --scale 200m/s2 --transfer tf.json --mode replicate --bench twin:participant=1,seed=7 --iterations 2 --level fit --out loop_r.wav --record loop_r.parquet",
    "render texture.wav --scale 200m/s2 --transfer tf.json --mode replicate --inverse drive-limited --bench measured:tf2.json,seed=7 --iterations 1 --level fit --out loop_m.wav",
    "manipulate texture.wav --scale 200m/s2 --band 50..100:+6dB --tilt 3dB/oct@200Hz --gain -3dB --loop 2s --out m1.wav",
    "manipulate texture.wav --scale 200m/s2 --shift 20Hz --warp 1.25:keep-length --randomise-phases --seed 7 --out m2.wav",
    "manipulate texture.wav --scale 200m/s2 --rms-of m1.wav --spectrum-of m2.wav --out m3.wav",
    "verify --target m1.wav --measured measured.parquet --before texture.wav --scale 200m/s2",
    "render m1.wav m2.wav --transfer tf.json --transfer tf2.json --level fit --out batch",
    "export texture.wav --scale 200m/s2 --out texture.haptic",
    "export texture.wav --scale 200m/s2 --out texture.ahap",
    "export plain.wav --transfer tf.json --out plain.hjif",
    "export tf.json --out tf.uff",
    "info tf.uff",
];

/// A panel of the twin's people, and what is rendered with its averages and placements.
pub(crate) const PANEL: &[&str] = &[
    "panel run --bench twin:seed=7 --participants 1..3 --loads 0.2,0.6 --angles 20 --repeats 2 --seconds 4 --out panel",
    "panel analyse panel --csv panel.csv",
    "panel analyse panel --average complex --band 30..500 --criterion 1",
    "panel average panel --load 0.2 --average complex --out complex.json",
    "panel average panel --load 0.6 --out average.json",
    "characterise --bench twin:participant=9,seed=7 --seconds 6 --out tf.json",
    "panel add filed tf.json",
    "render texture.wav --scale 200m/s2 --transfer complex.json --level fit --out drive.wav",
    "play drive.wav --bench measured:tf.json,seed=7,panel=panel,placement=2 --record placed.parquet",
    "verify --target texture.wav --scale 200m/s2 --measured placed.parquet",
];

/// The demo.
pub(crate) const THESIS: &[&str] = &["demo --out demo --seed 3"];

/// Measured files of others; `DATA` is their folder.
pub(crate) const FILES: &[&str] = &[
    "info DATA/vibration/textsense/text3_v1.wav --scale 1m/s2",
    "spectrum DATA/vibration/textsense/text3_v1.wav --scale 1m/s2",
    "strokes DATA/vibration/textsense/text3_v1.wav DATA/vibration/textsense/text9_v1.wav --scale 1m/s2 --by file",
    "score DATA/vibration/textsense/text3_v2.wav DATA/vibration/textsense/text9_v2.wav --scale 100m/s2",
    "manipulate DATA/vibration/textsense/text3_v2.wav --scale 100m/s2 --gain 3dB --out louder.wav",
    "strokes DATA/vibration/fabricslide/Board2mm_F135_V-10mmps_0.csv --cuts-only",
    "compare DATA/vibration/fabricslide/Board2mm_F135_V-5mmps_0.csv DATA/vibration/fabricslide/Board2mm_F135_V-10mmps_0.csv DATA/vibration/fabricslide/Board2mm_F135_V-20mmps_0.csv --meta {sample}_F{load:N}_V-{speed:mm/s}mmps_{repeat} --by speed",
    "info DATA/vibration/hapmat/fabric_1.csv",
    "spectrum DATA/vibration/hapmat/fabric_1.csv --channel accel_x",
    "info DATA/frf/vibrationtesting/case1.mat",
    "info DATA/frf/uff/Sample_UFF58b_bin.uff",
    "info DATA/frf/uff/Sample_UFF58_ascii.uff",
    "spectrum DATA/frf/uff/Sample_UFF58b_bin.uff",
    "info DATA/frf/lvm/short.lvm",
    "info DATA/frf/lvm/long_single_header_multi_ch.lvm",
    "roughness DATA/topography/surfcom/specimen_1_primary.tx1",
    "roughness DATA/topography/surfcom/specimen_1_primary.tx1 --standard iso21920 --cutoff 2.5mm",
    "roughness DATA/topography/surfacetopography/plu-1.plu",
    "roughness DATA/topography/surfacetopography/al3d-1.al3d",
    "roughness DATA/topography/surfacetopography/x3p-2.x3p",
    "roughness DATA/topography/nanovea/test1.txt --x-unit mm --z-unit um",
    "info DATA/haptic/haptic/3_points.haptic --scale 1m/s2",
    "info DATA/haptic/hjif/0.hmpg --scale 1m/s2",
    "spectrum DATA/haptic/haptic/long_clip.haptic --scale 1m/s2",
];

/// Answers of participants: matrices by task and set, orders, comparisons, and what was felt in confused pairs.
pub(crate) const ANSWERS: &[&str] = &[
    "answers answers.csv --by task --csv tasks.csv",
    "answers answers.csv --by set --task 3 --samples S1,S2,S8,S11,S13",
    "answers answers.csv --by participant --csv participants.csv",
    "answers orders.csv --ordering 1,2",
    "answers answers.csv --compare samples:S1,S11 --compare samples:S2,S13 --compare tasks:1,3",
    "answers answers.csv --compare people:others.csv --compare again:later.csv",
    "answers answers.csv --without-flagged",
    "twin record --bench acttouch --sample S1 --participant 2 --seed 7 --strokes 2 --stroke-time 1s --out S1.parquet",
    "twin record --bench acttouch --sample S11 --participant 2 --seed 7 --strokes 2 --stroke-time 1s --out S11.parquet",
    "characterise --bench twin:participant=2,seed=7 --seconds 10 --out tf.json",
    "prepare S1.parquet S11.parquet --transfer tf.json --bench twin:participant=2,seed=7 --out felt",
    "answers answers.csv --felt felt --csv felt.csv > felt.json",
    "rerun felt.json",
];

/// Campaigns: the design of every protocol of the library, and one of two sets from its plan to its tables, with two virtual
/// volunteers.
pub(crate) const CAMPAIGN: &[&str] = &[
    "campaign design periodic_pilot",
    "campaign design isotropic_triplets",
    "campaign design isotropic_triplets --power samples:S2,S3 --shares 75,20",
    "campaign design amplitude_inversion",
    "campaign design averaged_transfer_function",
    "campaign design touch_control_imagery",
    "campaign design roughness_jnd",
    "campaign protocol isotropic_triplets",
    "campaign protocol isotropic_triplets --dictionary",
    "campaign protocol roughness_jnd --dictionary",
    "campaign new study --protocol protocol.toml --seed 11",
    "campaign plan study P01 measurement",
    "campaign plan study P07 measurement",
    "campaign simulate simulated --protocol protocol.toml --participants 2 --seed 7 --iterations 0",
    "campaign simulate guessed --protocol protocol.toml --participants 2 --seed 8 --iterations 1 --judge guesser --level fit",
    "campaign status simulated",
    "campaign verify simulated",
    "campaign export simulated --out exported",
    "campaign export guessed --out guessed-tables",
    "answers simulated --by task",
    "answers guessed --by set",
];

/// The simulated study of [`CAMPAIGN`] as a data set, with strokes, a transfer function and EEG, and back; then a volunteer withdraws.
pub(crate) const BIDS: &[&str] = &[
    "twin record --bench acttouch --sample S2 --participant 1 --seed 7 --strokes 3 --stroke-time 1s --out S2.parquet",
    "twin record --bench acttouch --sample S4 --participant 1 --seed 7 --strokes 3 --stroke-time 1s --out S4.parquet",
    "twin record --bench acttouch --sample S8 --participant 2 --seed 7 --strokes 3 --stroke-time 1s --out S8.parquet",
    "characterise --bench twin:participant=1,seed=7 --seconds 10 --out tf.json",
    "twin record --bench eeg --task control --participant 1 --trials 2 --out P01_task3.vhdr",
    "bids export simulated --recordings S2.parquet S4.parquet S8.parquet --transfer tf.json --eeg P01_task3.vhdr --eeg-reference ideal --line 50Hz --license CC0 --out bids",
    "bids check bids --second-opinion none",
    "bids import bids --out imported",
    "campaign withdraw simulated P02",
    "campaign export simulated --out left",
    "answers simulated",
];

/// EEG of four people of the twin in two tasks, from the file to contrasts and clusters.
pub(crate) const EEG: &[&str] = &[
    "twin record --bench eeg --task control --participant 1 --trials 10 --out P01_control.vhdr",
    "twin record --bench eeg --task imagery --participant 1 --trials 10 --out P01_imagery.edf",
    "twin record --bench eeg --task control --participant 2 --trials 10 --out P02_control.vhdr",
    "twin record --bench eeg --task imagery --participant 2 --trials 10 --out P02_imagery.vhdr",
    "twin record --bench eeg --task control --participant 3 --trials 10 --out P03_control.parquet",
    "twin record --bench eeg --task imagery --participant 3 --trials 10 --out P03_imagery.vhdr",
    "twin record --bench eeg --task control --participant 4 --trials 10 --out P04_control.vhdr",
    "twin record --bench eeg --task imagery --participant 4 --trials 10 --out P04_imagery.vhdr",
    "eeg info P01_control.vhdr",
    "eeg info P01_imagery.edf",
    "eeg epochs P01_control.vhdr --participant P01 --event control --task control --low-pass 40 --reference average --reject-above 150 --csv epochs.csv",
    "eeg erd P01_control.vhdr --participant P01 --event control --task control --eog VEOG,HEOG --min-epochs 8 --out c1.json",
    "eeg erd P01_imagery.edf --participant P01 --event imagery/M8=M8 --event imagery/BIO=BIO --event imagery/M3=M3 --task imagery --eog VEOG,HEOG --min-epochs 8 --out i1.json",
    "eeg erd P02_control.vhdr --participant P02 --event control --task control --eog VEOG,HEOG --min-epochs 8 --out c2.json",
    "eeg erd P02_imagery.vhdr --participant P02 --event imagery --task imagery --eog VEOG,HEOG --min-epochs 8 --out i2.json",
    "eeg erd P03_control.parquet --participant P03 --event control --task control --eog VEOG,HEOG --min-epochs 8 --out c3.json",
    "eeg erd P03_imagery.vhdr --participant P03 --event imagery --task imagery --eog VEOG,HEOG --min-epochs 8 --out i3.json",
    "eeg erd P04_control.vhdr --participant P04 --event control --task control --eog VEOG,HEOG --min-epochs 8 --out c4.json",
    "eeg erd P04_imagery.vhdr --participant P04 --event imagery --task imagery --eog VEOG,HEOG --min-epochs 8 --out i4.json",
    "eeg erd P01_control.vhdr --participant P01 --event control --task control --min-epochs 8 --order percent-of-each-epoch --csv percent.csv",
    "eeg stats c1.json c2.json c3.json c4.json i1.json i2.json i3.json i4.json --gradient control,imagery --csv contrasts.csv",
];

/// Strokes of a session to verified drives.
pub(crate) const PREPARE: &[&str] = &[
    "twin record --bench acttouch --sample S1 --participant 2 --seed 7 --strokes 4 --stroke-time 1s --out S1.parquet",
    "twin record --bench acttouch --sample S8 --participant 2 --seed 7 --strokes 4 --stroke-time 1s --out S8.parquet",
    "characterise --bench twin:participant=2,seed=7 --seconds 10 --out tf.json",
    "prepare S1.parquet S8.parquet --transfer tf.json --bench twin:participant=2,seed=7 --out open",
    "prepare S1.parquet S8.parquet --transfer tf.json --bench twin:participant=2,seed=7 --mode texture --level -3 --out closed",
    "spectrum S1.parquet --channel acceleration --rest",
    "spectrum rest.csv --rest",
];

/// A sound device, of which the loop within the program takes the place: calibration, latency, recording, bursts and alignment.
pub(crate) const SOUND: &[&str] = &[
    "sound calibrate setup.toml --input-volts 2.8284 --wires",
    "sound calibrate calibrator.toml --exciter 2 --voltmeter 0.4999",
    "sound latency setup.toml --restarts 5",
    "characterise --bench audio:setup.toml --seconds 10 --out tf.json",
    "record --bench audio:setup.toml --sample S8 --speed 30mm/s --direction distal --load 0.2 --seconds 5 --out touched.parquet",
    "info touched.parquet",
    "spectrum touched.parquet --channel acceleration --rest",
    "sound burst drive.wav --out with.wav",
    "play with.wav --bench audio:setup.toml --gain B3 --record played.parquet",
    "sound align with.wav played.parquet --channel acceleration --out aligned.parquet > aligned.json",
    "info aligned.parquet",
    "rerun aligned.json",
];

/// What stands in the folder of a chain before its first command.
pub(crate) fn write_inputs(folder: &Folder) {
    folder.write("texture.wav", wav(noise(15_000).map(|v| v * 0.01), 5_000));
    folder.write("drive.wav", wav(noise(240_000).map(|v| v * 0.1), 48_000));
    folder.write("protocol.toml", two_sets());
    folder.write("setup.toml", SETUP);
    let on_calibrator = format!("{SETUP}on_calibrator = 2\n");
    folder.write("calibrator.toml", on_calibrator);
    folder.write("answers.csv", answers("P", 6, 1, 0.3));
    folder.write("later.csv", answers("P", 6, 2, 0.6));
    folder.write("others.csv", answers("Q", 14, 3, 0.0));
    folder.write("orders.csv", orders());
    folder.write("rest.csv", rest());
}

/// A loop within the program with the twin's finger; the clock of its input runs 40 ppm faster than that of its output.
const SETUP: &str = r#"host = "loop"
rate_hz = 48000
buffer_frames = 1024
gain = "B3"
play = { drive = [1] }
record = [
  { channel = 1, measures = "drive" },
  { channel = 2, measures = "acceleration", mv_per_m_s2 = 10.2 },
  { channel = 3, measures = "force", mv_per_n = 500 },
]

[loop]
finger = "twin:participant=1,seed=7"
input_v_per_full_scale = 2.8284
clock_ppm = 40
"#;

/// `count` people in two tasks and two sets; each names the next sample of the set in a share of the trials, which differs between tasks.
fn answers(people: &str, count: usize, seed: usize, confused_share: f64) -> String {
    let mut text = String::from("participant,task,set,trial,presented,offered,answered,flags\n");
    let mut draw = noise(1_000_000).skip(1000 * seed).map(|v| v + 0.5);
    let sets = [("A", ["S1", "S8", "S11"]), ("B", ["S2", "S8", "S13"])];
    for person in 1..=count {
        for (task, (set, samples)) in [1, 3].iter().flat_map(|task| sets.map(|set| (task, set))) {
            for trial in 0..9 {
                let presented = trial % 3;
                let wrong = draw.next().unwrap() < confused_share + 0.05 * f64::from(*task);
                let answered = (presented + usize::from(wrong)) % 3;
                let flags = if draw.next().unwrap() < 0.1 {
                    "missed_target"
                } else {
                    ""
                };
                let (presented, answered) = (samples[presented], samples[answered]);
                writeln!(
                    text,
                    "{people}{person},{task},{set},{set}{trial},{presented},{},{answered},{flags}",
                    samples.join(" ")
                )
                .unwrap();
            }
        }
    }
    text
}

/// Places that four people give to three samples in two tasks.
fn orders() -> String {
    let mut text = String::from("participant,task,set,trial,position,presented,answered\n");
    let of = [
        ["S1", "S8", "S11"],
        ["S8", "S1", "S11"],
        ["S1", "S11", "S8"],
        ["S11", "S8", "S1"],
    ];
    for (person, order) in of.iter().enumerate() {
        for task in [1, 2] {
            for place in 0..3 {
                let sample = order[if task == 1 { place } else { 2 - place }];
                let expected = ["S1", "S8", "S11"][place];
                writeln!(
                    text,
                    "P{person},{task},A,{task},{},{sample},{expected}",
                    place + 1
                )
                .unwrap();
            }
        }
    }
    text
}

/// A sensor at rest for six seconds: noise, hum of the mains, a slow drift.
fn rest() -> String {
    let mut text = String::from("time (s),acceleration (m/s2)\n");
    for (i, v) in noise(12_000).enumerate() {
        let t = i as f64 / 2000.0;
        let hum = 0.004 * (std::f64::consts::TAU * 50.0 * t).sin();
        writeln!(text, "{t:.4},{:.7}", 0.01 * v + hum + 2e-4 * t).unwrap();
    }
    text
}
