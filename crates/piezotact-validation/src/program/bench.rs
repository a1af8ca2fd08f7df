//! `piezotact-validation bench`: compares this program with its peers on the same inputs, alternating, in one run.

mod blocks;

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use serde::Deserialize;
use serde::de::DeserializeOwned;

/// Times every contestant has its turn.
const ROUNDS: usize = 5;

/// One piece of work: repetitions in a turn, how exactly results must agree, and the peers with the ratio to
/// reach.
struct Work {
    name: &'static str,
    what: &'static str,
    repetitions: usize,
    agreement: Agreement,
    peers: &'static [(&'static str, f64)],
    /// The duration of the generated signal, s, and the least speed as a multiple of real time.
    real_time: Option<(f64, f64)>,
    /// The same work of ours on one core, and how many times faster than it this is to be by the clock on the wall.
    one_core: Option<(&'static str, f64)>,
}

/// How the results of two programs are compared.
#[derive(Clone, Copy)]
enum Agreement {
    /// Every value, relative to itself.
    Relative(f64),
    /// Relative to the largest value.
    OfLargest(f64),
}

const WORKS: [Work; 17] = [
    Work {
        name: "W1a",
        what: "Welch PSD, one channel of 10 min at 5 kHz",
        repetitions: 15,
        agreement: Agreement::Relative(1e-10),
        peers: &[("scipy", 13.0), ("fftw", 1.0)],
        real_time: None,
        one_core: None,
    },
    Work {
        name: "W1b",
        what: "mean PSD of 4 channels × 1000 strokes of 1 s",
        repetitions: 7,
        agreement: Agreement::Relative(1e-10),
        peers: &[("scipy", 8.0), ("numpy", 8.0)],
        real_time: None,
        one_core: None,
    },
    Work {
        name: "W2a",
        what: "H1, H2, coherence of one pair of 60 s",
        repetitions: 15,
        // Lines above the drive's band are rounding: 1e-16 of its power.
        agreement: Agreement::OfLargest(1e-6),
        peers: &[("scipy", 12.0), ("numpy", 1.0)],
        real_time: None,
        one_core: None,
    },
    Work {
        name: "W2b",
        what: "the same, 360 pairs of 30 s",
        repetitions: 2,
        agreement: Agreement::OfLargest(1e-6),
        peers: &[("scipy", 35.0), ("numpy", 4.0)],
        real_time: None,
        one_core: None,
    },
    Work {
        name: "W2b2",
        what: "the same on two cores, by the clock on the wall",
        repetitions: 4,
        agreement: Agreement::OfLargest(0.0),
        peers: &[],
        real_time: None,
        one_core: Some(("W2b", 1.8)),
    },
    Work {
        name: "W3",
        what: "render 10 s to a 48 kHz WAV",
        repetitions: 25,
        // Two resamplers that both keep the band to 1e-4, the first and last milliseconds left out.
        agreement: Agreement::OfLargest(1e-3),
        peers: &[("soxr", 3.0)],
        real_time: None,
        one_core: None,
    },
    Work {
        name: "W5",
        what: "strokes and features, 4 channels of 1 h",
        repetitions: 3,
        // Our cuts fall on frames of 2 ms, the peer's on samples: strokes of 1 s differ by 1 ms at each end, and
        // the nine segments of their spectra by as much.
        agreement: Agreement::Relative(0.06),
        peers: &[("scipy", 12.0)],
        real_time: None,
        one_core: None,
    },
    Work {
        name: "W5j",
        what: "the same, and each contact judged: sliding, stick-slip",
        repetitions: 3,
        agreement: Agreement::Relative(0.06),
        peers: &[("scipy", 1.0)],
        real_time: None,
        one_core: None,
    },
    Work {
        name: "W6",
        what: "prepare 3 textures: 3 min of strokes to drives, each compared with its stroke",
        repetitions: 3,
        agreement: Agreement::Relative(0.0),
        peers: &[],
        real_time: Some((180.0, 500.0)),
        one_core: None,
    },
    Work {
        name: "W9a",
        what: "a table of text, time and 4 channels of 2 min at 5 kHz",
        repetitions: 3,
        agreement: Agreement::Relative(1e-9),
        peers: &[("polars", 1.0)],
        real_time: None,
        one_core: None,
    },
    Work {
        name: "W9b",
        what: "MATLAB 5, 4 channels of 30 min at 5 kHz",
        repetitions: 5,
        agreement: Agreement::Relative(1e-9),
        peers: &[("mapped", 0.83), ("scipy", 1.0)],
        real_time: None,
        one_core: None,
    },
    Work {
        name: "W9c",
        what: "TDMS, the same channels",
        repetitions: 5,
        agreement: Agreement::Relative(1e-9),
        peers: &[("mapped", 0.83), ("nptdms", 1.0)],
        real_time: None,
        one_core: None,
    },
    Work {
        name: "W9d",
        what: "universal file 58, binary, 4 channels of 2 min at 5 kHz",
        repetitions: 5,
        agreement: Agreement::Relative(1e-9),
        peers: &[("pyuff", 4.0)],
        real_time: None,
        one_core: None,
    },
    Work {
        name: "W9e",
        what: "EDF, 32 channels of 10 min at 1 kHz",
        repetitions: 5,
        agreement: Agreement::Relative(1e-9),
        peers: &[("edfio", 2.0)],
        real_time: None,
        one_core: None,
    },
    Work {
        name: "E1",
        what: "power of 100 single trials, 64 channels of 2 s at 1 kHz: Morlet at 37 frequencies, two windows",
        repetitions: 1,
        agreement: Agreement::Relative(1e-9),
        peers: &[("mne", 4.0)],
        real_time: None,
        one_core: None,
    },
    Work {
        name: "E2",
        what: "clusters over 100 times and 64 sensors of 10 people, all 512 sign flips",
        repetitions: 5,
        agreement: Agreement::Relative(1e-9),
        peers: &[("mne", 5.0)],
        real_time: None,
        one_core: None,
    },
    Work {
        name: "T1",
        what: "the twin makes an hour of active touch, 4 channels at 5 kHz",
        repetitions: 1,
        agreement: Agreement::Relative(0.0),
        peers: &[],
        real_time: Some((3600.0, 200.0)),
        one_core: None,
    },
];

#[derive(Deserialize)]
struct Turn {
    cpu_s: Vec<f64>,
    /// Ours alone say it.
    #[serde(default)]
    wall_s: Vec<f64>,
    peak_mb: f64,
    input_mb: f64,
}

/// Runs the works named in `only`, or all, with the peers in the virtual environment of `python`.
#[allow(clippy::print_stdout, reason = "its result is a table")]
pub(crate) fn run(python: &str, only: &[&str]) -> Result<()> {
    if only == ["R1"] {
        return super::rendering::run();
    }
    if let ["V1", part @ ..] = only {
        return super::verdicts::run(part);
    }
    if let ["V2", part @ ..] = only {
        return super::conclusions::run(part);
    }
    if only == ["I1"] {
        return super::intervals::run();
    }
    if let ["I2", part @ ..] = only {
        return super::people::run(part);
    }
    if only == ["C1"] {
        return super::discrimination::run();
    }
    if only == [super::pairs::NAME] {
        return super::pairs::run(python);
    }
    if only == [super::stops::NAME] {
        return super::stops::run();
    }
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../bench/peers.py");
    if only == [blocks::NAME] {
        let folder = inputs(python, &script, only)?;
        let mut missed = Vec::new();
        blocks::run(python, &script, &folder, &mut missed)?;
        say(&missed);
        return Ok(());
    }
    let folder = inputs(python, &script, only)?;
    println!(
        "CPU time on one core, or wall time where it says so, {ROUNDS} turns each, median (quartiles); ratio = peer's median / ours, or what is made over the time it takes\n"
    );
    println!(
        "{:<5}{:<11}{:>26}{:>9}{:>11}   peak MB (input)",
        "work", "program", "CPU ms", "ratio", "to reach"
    );
    let mut missed = Vec::new();
    for work in WORKS
        .iter()
        .filter(|work| only.is_empty() || only.contains(&work.name))
    {
        let mut ours: Vec<Turn> = Vec::new();
        let mut on_one_core: Vec<Turn> = Vec::new();
        let mut theirs: Vec<Vec<Turn>> = work.peers.iter().map(|_| Vec::new()).collect();
        for _ in 0..ROUNDS {
            ours.push(our_turn(work.name, &folder, work.repetitions)?);
            if let Some((name, _)) = work.one_core {
                on_one_core.push(our_turn(name, &folder, work.repetitions)?);
            }
            for ((peer, _), turns) in work.peers.iter().zip(&mut theirs) {
                let name = format!("{}-{peer}", work.name);
                turns.push(turn(
                    Command::new(python).arg(&script).arg(name).arg(&folder),
                    work.repetitions,
                )?);
            }
        }
        println!("{} {}", work.name, work.what);
        if let Some((name, to_reach)) = work.one_core {
            // On a machine that is shared the wall says little: beside it stands what both threads computed.
            row("CPU of two", &ours, None);
            row("CPU of one", &on_one_core, None);
            for turn in ours.iter_mut().chain(&mut on_one_core) {
                turn.cpu_s.clone_from(&turn.wall_s);
            }
            let ratio = quartiles(&on_one_core)[1] / quartiles(&ours)[1];
            row("two cores", &ours, None);
            row("one core", &on_one_core, Some((ratio, to_reach)));
            if ratio < to_reach {
                missed.push(format!(
                    "{} against {name}: {ratio:.2}×, to reach {to_reach}×",
                    work.name
                ));
            }
            agree(&folder, work, &format!("{name}-piezotact"))?;
            continue;
        }
        let our_median = quartiles(&ours)[1];
        let made = work
            .real_time
            .map(|(lasts_s, to_reach)| (lasts_s / our_median, to_reach));
        row("piezotact", &ours, made);
        if let Some((ratio, to_reach)) = made
            && ratio < to_reach
        {
            missed.push(format!(
                "{}: {ratio:.0}× real time, to reach {to_reach}×",
                work.name
            ));
        }
        let allowed = 1.2 * ours[0].input_mb + 64.0;
        if ours.iter().any(|turn| turn.peak_mb > allowed) {
            missed.push(format!(
                "{}: peak memory above 1.2 × input + 64 MB = {allowed:.0} MB",
                work.name
            ));
        }
        for ((peer, to_reach), turns) in work.peers.iter().zip(&theirs) {
            let ratio = quartiles(turns)[1] / our_median;
            row(peer, turns, Some((ratio, *to_reach)));
            if ratio < *to_reach {
                missed.push(format!(
                    "{} against {peer}: {ratio:.1}×, to reach {to_reach}×",
                    work.name
                ));
            }
            agree(&folder, work, &format!("{}-{peer}", work.name))?;
        }
    }
    if only.is_empty() || only.contains(&blocks::NAME) {
        blocks::run(python, &script, &folder, &mut missed)?;
    }
    say(&missed);
    if only.is_empty() {
        super::pairs::run(python)?;
        super::rendering::run()?;
        super::verdicts::run(&[])?;
        super::conclusions::run(&[])?;
        super::stops::run()?;
    }
    Ok(())
}

#[allow(clippy::print_stdout, reason = "the end of the table")]
fn say(missed: &[String]) {
    println!();
    if missed.is_empty() {
        println!("every ratio and bound is reached, and all results agree");
    } else {
        println!("not reached:\n  {}", missed.join("\n  "));
    }
}

/// The folder with the inputs of the works named in `only`, or of all.
fn inputs(python: &str, script: &Path, only: &[&str]) -> Result<PathBuf> {
    let folder = std::env::temp_dir().join("piezotact-bench");
    let made = Command::new(python)
        .arg(script)
        .arg("inputs")
        .arg(&folder)
        .args(only)
        .status()
        .context(python.to_owned())?;
    ensure!(made.success(), "the inputs could not be made");
    Ok(folder)
}

/// A turn of ours, in a process of its own.
fn our_turn(name: &str, folder: &Path, repetitions: usize) -> Result<Turn> {
    turn(
        Command::new(std::env::current_exe()?)
            .args(["work", name])
            .arg(folder),
        repetitions,
    )
}

fn turn(command: &mut Command, repetitions: usize) -> Result<Turn> {
    output(command, repetitions)
}

/// What a contestant prints.
fn output<T: DeserializeOwned>(command: &mut Command, repetitions: usize) -> Result<T> {
    for limit in [
        "OMP_NUM_THREADS",
        "OPENBLAS_NUM_THREADS",
        "MKL_NUM_THREADS",
        "NUMBA_NUM_THREADS",
    ] {
        command.env(limit, "1");
    }
    let done = command.arg(repetitions.to_string()).output()?;
    ensure!(
        done.status.success(),
        "{command:?} failed: {}",
        String::from_utf8_lossy(&done.stderr)
    );
    Ok(serde_json::from_slice(&done.stdout)?)
}

fn quartiles(turns: &[Turn]) -> [f64; 3] {
    let mut all: Vec<f64> = turns
        .iter()
        .flat_map(|turn| turn.cpu_s.iter().copied())
        .collect();
    all.sort_by(f64::total_cmp);
    [0.25, 0.5, 0.75].map(|q| all[((all.len() - 1) as f64 * q).round() as usize])
}

#[allow(clippy::print_stdout, reason = "a row of the table")]
fn row(name: &str, turns: &[Turn], ratio: Option<(f64, f64)>) {
    let [low, median, high] = quartiles(turns).map(|seconds| seconds * 1e3);
    let (ratio, to_reach) = match ratio {
        Some((ratio, to_reach)) => (format!("{ratio:.1}×"), format!("{to_reach}×")),
        None => (String::new(), String::new()),
    };
    let peak_mb = turns.iter().map(|turn| turn.peak_mb).fold(0.0, f64::max);
    println!(
        "     {name:<11}{:>26}{ratio:>9}{to_reach:>11}   {peak_mb:.0} ({:.0})",
        format!("{median:.2} ({low:.2}–{high:.2})"),
        turns[0].input_mb
    );
}

/// The result `name`.
fn numbers(folder: &Path, name: &str) -> Result<Vec<f64>> {
    let path = folder.join(format!("{name}.f64"));
    let bytes = std::fs::read(&path).with_context(|| path.display().to_string())?;
    Ok(bytes
        .chunks_exact(8)
        .map(|b| f64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]]))
        .collect())
}

/// Refuses a comparison of times between programs that do not agree on the result.
fn agree(folder: &Path, work: &Work, peer: &str) -> Result<()> {
    let ours = numbers(folder, &format!("{}-piezotact", work.name))?;
    let theirs = numbers(folder, peer)?;
    ensure!(
        ours.len() == theirs.len(),
        "{} and {peer} differ in length: {} and {}",
        work.name,
        ours.len(),
        theirs.len()
    );
    let ends = if work.name == "W3" { 4800 } else { 0 };
    let inner = ends..ours.len() - ends;
    let largest = theirs
        .iter()
        .fold(0.0f64, |largest, v| largest.max(v.abs()));
    let (worst, allowed) = match work.agreement {
        Agreement::Relative(allowed) => (
            inner
                .map(|i| ((ours[i] - theirs[i]) / theirs[i]).abs())
                .fold(0.0, f64::max),
            allowed,
        ),
        Agreement::OfLargest(allowed) => (
            inner
                .map(|i| (ours[i] - theirs[i]).abs() / largest)
                .fold(0.0, f64::max),
            allowed,
        ),
    };
    ensure!(
        worst <= allowed,
        "{} and {peer} disagree by {worst:e}, {allowed:e} is allowed",
        work.name
    );
    Ok(())
}
