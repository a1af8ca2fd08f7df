//! W4: the time of single blocks of a convolution in real time, where the latest of a thousand counts as much as the usual one.

use std::path::Path;
use std::process::Command;

use anyhow::{Result, ensure};
use serde::Deserialize;

use super::ROUNDS;

pub(super) const NAME: &str = "W4";

/// Passes through the signal in a turn, after one that is not counted.
const PASSES: usize = 3;
/// Of the largest value of the offline convolution.
const ALLOWED_ERROR: f64 = 2e-7;
/// For programs that compute in single precision: that they did the same work.
const SAME_WORK: f64 = 1e-5;
/// The time that a block lasts, µs: 64 samples at 48 kHz.
const BUDGET_US: f64 = 64.0 / 0.048;

/// Who takes part, ours first.
const PROGRAMS: [Program; 4] = [
    Program {
        name: "piezotact",
        what: "f64 inside, f32 in and out",
        allowed_error: Some(ALLOWED_ERROR),
    },
    Program {
        name: "pedalboard",
        what: "Convolution, f32",
        allowed_error: Some(SAME_WORK),
    },
    Program {
        name: "numpy",
        what: "partitioned, f32",
        allowed_error: Some(SAME_WORK),
    },
    Program {
        name: "call",
        what: "pedalboard's Gain",
        allowed_error: None,
    },
];

struct Program {
    name: &'static str,
    what: &'static str,
    /// Of the largest value; none for a program that does not convolve.
    allowed_error: Option<f64>,
}

#[derive(Deserialize)]
struct Turn {
    /// The time of every block of every pass, s.
    passes_s: Vec<Vec<f64>>,
}

/// What the passes of one program say, each a list with a value for every pass.
struct Passes {
    median_us: Vec<f64>,
    late_us: Vec<f64>,
    late_ratio: Vec<f64>,
    /// The same of each block's median over all passes: without what the machine does between, which meets another block in
    /// each pass, the lateness of the program alone is left.
    own_late_ratio: f64,
    longest_us: f64,
    over_budget: usize,
    blocks: usize,
}

/// Measures all programs, alternating, and adds to `missed` what was not reached.
#[allow(clippy::print_stdout, reason = "its result is a table")]
pub(super) fn run(
    python: &str,
    script: &Path,
    folder: &Path,
    missed: &mut Vec<String>,
) -> Result<()> {
    let mut turns: [Vec<Turn>; 4] = Default::default();
    for _ in 0..ROUNDS {
        for (program, turns) in PROGRAMS.iter().zip(&mut turns) {
            turns.push(turn(python, script, folder, program)?);
        }
    }
    let passes = turns.map(|turns| Passes::of(&turns));
    println!(
        "{NAME} convolution in real time: blocks of 64 samples, 4096 taps, 48 kHz; {} blocks in each of {} passes",
        passes[0].blocks / passes[0].median_us.len(),
        passes[0].median_us.len()
    );
    println!(
        "   time of a block by the monotonic clock, µs: median over passes (quartiles); late = the 99.9th percentile of a pass"
    );
    println!(
        "     {:<11}{:>22}{:>28}{:>24}{:>6}{:>9}{:>6}{:>10}",
        "program", "p50", "late", "late/p50", "own", "longest", "over", "error"
    );
    for (program, passes) in PROGRAMS.iter().zip(&passes) {
        let error = match program.allowed_error {
            None => String::new(),
            Some(allowed) => {
                let error = error_of(folder, program.name)?;
                if error > allowed {
                    missed.push(format!(
                        "{NAME}, {}: {error:.1e} of the largest value off the offline convolution, {allowed:.0e} is allowed",
                        program.name
                    ));
                }
                format!("{error:.1e}")
            }
        };
        passes.print(program, &error);
    }
    println!(
        "     own = late/p50 of each block's median over all passes, without what the machine does between, which meets another block each time"
    );
    println!(
        "     over = blocks that took longer than they last ({BUDGET_US:.0} µs); error = largest, of the largest value of SciPy's offline convolution"
    );
    judge(&passes, missed);
    Ok(())
}

/// Prints the ratios to the peers, and notes those that are not reached.
#[allow(clippy::print_stdout, reason = "a part of the table")]
fn judge([ours, pedalboard, numpy, call]: &[Passes; 4], missed: &mut Vec<String>) {
    let of = |list: &[f64]| quartiles(list)[1];
    let (own, own_late) = (of(&ours.median_us), of(&ours.late_us));
    for (name, peer) in [("pedalboard", pedalboard), ("numpy", numpy)] {
        println!(
            "     {name} / piezotact: p50 {:.1}×, late {:.1}×",
            of(&peer.median_us) / own,
            of(&peer.late_us) / own_late
        );
    }
    println!(
        "     pedalboard less its call (p50 of Gain, which includes the call from Python): p50 {:.1}×",
        (of(&pedalboard.median_us) - of(&call.median_us)) / own
    );
    let speed = of(&pedalboard.median_us) / own;
    if speed < 1.0 {
        missed.push(format!(
            "{NAME} against pedalboard: p50 {speed:.2}×, to reach 1×"
        ));
    }
    let (own, theirs) = (of(&ours.late_ratio), of(&pedalboard.late_ratio));
    if own > theirs {
        missed.push(format!(
            "{NAME} against pedalboard: late/p50 {own:.1}, at most pedalboard's {theirs:.1} to reach; of the programs alone {:.2} and {:.2}",
            ours.own_late_ratio, pedalboard.own_late_ratio
        ));
    }
}

fn turn(python: &str, script: &Path, folder: &Path, program: &Program) -> Result<Turn> {
    let mut command;
    if program.name == PROGRAMS[0].name {
        command = Command::new(std::env::current_exe()?);
        command.args(["work", NAME]);
    } else {
        command = Command::new(python);
        command.arg(script).arg(format!("{NAME}-{}", program.name));
    }
    super::output(command.arg(folder), PASSES)
}

impl Passes {
    fn of(turns: &[Turn]) -> Self {
        let mut all = Self {
            median_us: Vec::new(),
            late_us: Vec::new(),
            late_ratio: Vec::new(),
            own_late_ratio: f64::NAN,
            longest_us: 0.0,
            over_budget: 0,
            blocks: 0,
        };
        for pass in turns.iter().flat_map(|turn| &turn.passes_s) {
            let mut us: Vec<f64> = pass.iter().map(|s| s * 1e6).collect();
            us.sort_by(f64::total_cmp);
            let [median, late] = [0.5, 0.999].map(|share| at(&us, share));
            all.median_us.push(median);
            all.late_us.push(late);
            all.late_ratio.push(late / median);
            all.longest_us = all.longest_us.max(at(&us, 1.0));
            all.over_budget += us.iter().filter(|us| **us > BUDGET_US).count();
            all.blocks += us.len();
        }
        let passes: Vec<&[f64]> = (turns.iter())
            .flat_map(|turn| turn.passes_s.iter().map(Vec::as_slice))
            .collect();
        let blocks = passes.iter().map(|pass| pass.len()).min().unwrap_or(0);
        let mut own: Vec<f64> = (0..blocks)
            .map(|block| {
                let times: Vec<f64> = passes.iter().map(|pass| pass[block]).collect();
                quartiles(&times)[1]
            })
            .collect();
        own.sort_by(f64::total_cmp);
        all.own_late_ratio = at(&own, 0.999) / at(&own, 0.5);
        all
    }

    #[allow(clippy::print_stdout, reason = "a row of the table")]
    fn print(&self, program: &Program, error: &str) {
        let show = |list: &[f64]| {
            let [low, median, high] = quartiles(list);
            format!("{median:.2} ({low:.2}–{high:.2})")
        };
        println!(
            "     {:<11}{:>22}{:>28}{:>24}{:>6.2}{:>9.0}{:>6}{error:>10}   {}",
            program.name,
            show(&self.median_us),
            show(&self.late_us),
            show(&self.late_ratio),
            self.own_late_ratio,
            self.longest_us,
            self.over_budget,
            program.what
        );
    }
}

/// The value at a share of a sorted list.
fn at(sorted: &[f64], share: f64) -> f64 {
    let last = sorted.len().saturating_sub(1);
    sorted
        .get((last as f64 * share).round() as usize)
        .copied()
        .unwrap_or(f64::NAN)
}

fn quartiles(list: &[f64]) -> [f64; 3] {
    let mut sorted = list.to_vec();
    sorted.sort_by(f64::total_cmp);
    [0.25, 0.5, 0.75].map(|share| at(&sorted, share))
}

/// The largest difference from the offline convolution, of its largest value.
fn error_of(folder: &Path, program: &str) -> Result<f64> {
    let offline = super::numbers(folder, &format!("{NAME}-offline"))?;
    let found = super::numbers(folder, &format!("{NAME}-{program}"))?;
    ensure!(
        !offline.is_empty() && offline.len() == found.len(),
        "{NAME}, {program}: expected {} samples, found {}",
        offline.len(),
        found.len()
    );
    let largest = offline.iter().fold(0.0f64, |most, v| most.max(v.abs()));
    let errors = offline.iter().zip(&found).map(|(a, b)| (a - b).abs());
    // A value that is no number counts as wrong.
    let worst = errors.fold(0.0, |most, e| if e <= most { most } else { e });
    Ok(worst / largest)
}
