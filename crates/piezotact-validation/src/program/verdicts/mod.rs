//! `piezotact-validation verdicts`: verdicts against the truth. Renderings on the twin that are known to be right or wrong, and the verdicts
//! of `verify` on their recordings.

#![allow(clippy::print_stdout, reason = "it prints a table")]

mod coil;
mod faults;
mod kinds;
mod parts;
mod scene;
mod truth;

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::{Result, bail, ensure};
use piezotact::lineage::Mode;
use piezotact::score::with_perceptible_difference;
use piezotact::verify::{Measured, Verdict, verify};

use super::signal;
use faults::Case;
use kinds::{Kind, Size};
use scene::{Actuator, Device, Scene, Texture, series};
use truth::{Fact, Figure, RIGHT_TO, Truth, WRONG_FROM, truth};

const MODES: [Mode; 2] = [Mode::Replicate, Mode::Texture];
/// The targets: false failures among what is right, and not decided among all that is judged.
const MOST_FALSE_FAILURES: f64 = 0.02;
const MOST_NOT_DECIDED: f64 = 0.1;

/// What of the benchmark is run.
struct Part {
    devices: Vec<Actuator>,
    textures: Vec<Texture>,
    seeds: Vec<u64>,
    modes: Vec<Mode>,
    kinds: Vec<Kind>,
    /// Every case is listed, not those alone whose verdict is wrong.
    listed: Listed,
}

/// Which cases are listed one by one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Listed {
    Offending,
    All,
}

impl Part {
    fn all() -> Self {
        Self {
            devices: Actuator::ALL.to_vec(),
            textures: Texture::ALL.to_vec(),
            seeds: (1..=5).collect(),
            modes: MODES.to_vec(),
            kinds: Kind::all(),
            listed: Listed::Offending,
        }
    }

    /// `devices=coil textures=taps,tonal seeds=2 modes=texture kinds=drop,hum`: those whose name holds one of the words; seeds from 1 up to
    /// the number.
    fn of(words: &[&str]) -> Result<Self> {
        let mut part = Self::all();
        for word in words {
            let Some((what, which)) = word.split_once('=') else {
                bail!(
                    "expected devices=…, textures=…, seeds=…, modes=…, kinds=… or list=all, found {word}"
                );
            };
            let asked = |name: &str| which.split(',').any(|which| name.contains(which));
            match what {
                "devices" => part.devices.retain(|device| asked(device.name())),
                "textures" => part.textures.retain(|texture| asked(texture.name())),
                "seeds" => part.seeds = (1..=which.parse()?).collect(),
                "modes" => part.modes.retain(|mode| asked(mode.name())),
                "kinds" => part.kinds.retain(|kind| asked(&kind.name())),
                "list" if which == "all" => part.listed = Listed::All,
                _ => bail!(
                    "expected devices, textures, seeds, modes, kinds or list=all, found {word}"
                ),
            }
        }
        Ok(part)
    }
}

/// One rendering judged.
struct Judged {
    device: Actuator,
    texture: Texture,
    seed: u64,
    mode: Mode,
    kind: Kind,
    truth: Truth,
    verdict: Verdict,
    /// What `verify` says of it.
    sentence: String,
    part: bool,
}

impl Judged {
    fn of(scene: &Scene, kind: Kind, mode: Mode) -> Result<Option<Self>> {
        let Some(case) = Case::of(scene, kind, mode)? else {
            return Ok(None);
        };
        let (target, response) = (series(scene.target.clone())?, series(case.seen.clone())?);
        let (verdict, sentence) = match verify(&target, Measured::alone(&response), &case.config)
            .map(with_perceptible_difference)
        {
            Ok(verification) => (verification.verdict, verification.sentence()),
            // No verdict at all is none.
            Err(error) => (Verdict::NotDecided, error.to_string()),
        };
        Ok(Some(Self {
            device: scene.device.actuator,
            texture: scene.texture,
            seed: scene.seed,
            mode,
            kind,
            truth: truth(&case, kind, mode, scene.band),
            verdict,
            sentence,
            part: case.part,
        }))
    }

    fn gross(&self) -> bool {
        let gross = match self.kind.size() {
            // Of a decaying noise the second half holds little, and a spectrum of one segment scatters.
            Size::Gross if self.texture.is_short() && self.mode == Mode::Texture => {
                self.kind != Kind::SecondHalfSilent
            }
            Size::Gross => true,
            Size::GrossWaveform => self.mode == Mode::Replicate,
            Size::Usual => false,
        };
        gross && self.truth.fact == Fact::Wrong
    }

    /// What is wrong with the verdict, if anything.
    fn offence(&self) -> Option<Offence> {
        match (self.truth.fact, self.verdict) {
            (Fact::Wrong, Verdict::Passed) => Some(Offence::FalsePass),
            (Fact::Wrong, Verdict::PassedInPart { .. }) if !self.part => Some(Offence::FalsePass),
            (Fact::Right, Verdict::NotPassed) => Some(Offence::FalseFailure),
            (Fact::Wrong, Verdict::NotDecided) if self.gross() => Some(Offence::GrossNotDecided),
            (Fact::Right | Fact::Wrong, Verdict::NotDecided) => Some(Offence::NotDecided),
            _ => None,
        }
    }
}

impl fmt::Display for Judged {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}, {}, {} {} {}: {}; verify: {}",
            self.kind.name(),
            self.mode.name(),
            self.device.name(),
            self.texture.name(),
            self.seed,
            self.truth,
            self.sentence
        )
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Offence {
    FalsePass,
    FalseFailure,
    GrossNotDecided,
    NotDecided,
}

/// Runs the part that `words` name and prints the table.
pub(crate) fn run(words: &[&str]) -> Result<()> {
    let part = Part::of(words)?;
    limits();
    let judged = judge(&part)?;
    table(&part, &judged);
    offences(&part, &judged);
    let missed = totals(&judged);
    ensure!(missed.is_empty(), "not reached: {}", missed.join("; "));
    println!("  every target is reached");
    Ok(())
}

/// Does `work` for every index below `count`, on all cores.
pub(super) fn in_threads<T: Send>(
    count: usize,
    work: impl Fn(usize) -> Result<T> + Sync,
) -> Result<Vec<T>> {
    let next = AtomicUsize::new(0);
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let one_thread = || -> Result<Vec<(usize, T)>> {
        let mut done = Vec::new();
        loop {
            let i = next.fetch_add(1, Ordering::Relaxed);
            if i >= count {
                return Ok(done);
            }
            done.push((i, work(i)?));
        }
    };
    let mut done = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(one_thread)).collect();
        let mut all = Vec::with_capacity(count);
        for worker in workers {
            match worker.join() {
                Ok(done) => all.extend(done?),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        anyhow::Ok(all)
    })?;
    done.sort_by_key(|(i, _)| *i);
    Ok(done.into_iter().map(|(_, one)| one).collect())
}

fn judge(part: &Part) -> Result<Vec<Judged>> {
    let people: Vec<(Actuator, u64)> = part
        .devices
        .iter()
        .flat_map(|device| part.seeds.iter().map(|seed| (*device, *seed)))
        .collect();
    let devices = in_threads(people.len(), |i| {
        let (actuator, seed) = people[i];
        Ok(Arc::new(Device::of(seed, actuator)?))
    })?;
    let scenes = in_threads(part.textures.len() * people.len(), |i| {
        let (texture, person) = (part.textures[i / people.len()], i % people.len());
        Scene::new(texture, people[person].1, &devices[person])
    })?;
    let works: Vec<(&Scene, Kind, Mode)> = scenes
        .iter()
        .flat_map(|scene| {
            let both = |kind: &Kind| {
                part.modes
                    .iter()
                    .map(|mode| (*kind, *mode))
                    .collect::<Vec<_>>()
            };
            let all: Vec<(Kind, Mode)> = part.kinds.iter().flat_map(both).collect();
            all.into_iter().map(move |(kind, mode)| (scene, kind, mode))
        })
        .collect();
    let judged = in_threads(works.len(), |i| {
        let (scene, kind, mode) = works[i];
        Judged::of(scene, kind, mode)
    })?;
    Ok(judged.into_iter().flatten().collect())
}

fn limits() {
    println!(
        "\nV1 verdicts against the truth, which is computed from the noise-free delivered signal and never shown to verify:"
    );
    println!(
        "right up to {RIGHT_TO} of every limit, wrong from {WRONG_FROM} times one on; what lies between is left out and counted\n"
    );
    for figure in Figure::ALL {
        println!(
            "  {:<32}{:>7}   {}",
            figure.name(),
            figure.limit(),
            figure.meaning()
        );
    }
}

/// How often each verdict was found: passed, in part, not passed, not decided.
fn counts<'a>(judged: impl Iterator<Item = &'a Judged>) -> [usize; 4] {
    let mut counts = [0; 4];
    for one in judged {
        let place = match one.verdict {
            Verdict::Passed => 0,
            Verdict::PassedInPart { .. } => 1,
            Verdict::NotPassed => 2,
            Verdict::NotDecided => 3,
        };
        counts[place] += 1;
    }
    counts
}

fn table(part: &Part, judged: &[Judged]) {
    println!(
        "\n{} renderings; of those that are right and of those that are wrong: passed/in part/not passed/not decided",
        judged.len()
    );
    let half = "left out    right          wrong";
    println!(
        "  {:<30}cases  replicate: {half:<36}texture: {half}",
        "kind"
    );
    for kind in &part.kinds {
        let of_kind: Vec<&Judged> = judged.iter().filter(|one| one.kind == *kind).collect();
        if of_kind.is_empty() {
            continue;
        }
        let halves = MODES.map(|mode| {
            let of = |fact: Fact| {
                let of_kind = of_kind.iter().copied();
                of_kind.filter(move |one| one.mode == mode && one.truth.fact == fact)
            };
            let told = |fact: Fact| match counts(of(fact)) {
                [0, 0, 0, 0] => "–".to_owned(),
                [p, i, n, u] => format!("{p}/{i}/{n}/{u}"),
            };
            let left_out = of(Fact::LeftOut).count();
            format!(
                "{left_out:>8}    {:<15}{:<12}",
                told(Fact::Right),
                told(Fact::Wrong)
            )
        });
        println!(
            "  {:<30}{:>5}             {}         {}",
            kind.name(),
            of_kind.len(),
            halves[0],
            halves[1].trim_end()
        );
    }
}

fn offences(part: &Part, judged: &[Judged]) {
    if part.listed == Listed::All {
        println!();
        for one in judged {
            println!("  {one}");
        }
    }
    for (offence, what) in [
        (Offence::FalsePass, "false passes"),
        (Offence::FalseFailure, "false failures"),
        (Offence::GrossNotDecided, "gross faults not decided"),
        (Offence::NotDecided, "not decided"),
    ] {
        let found: Vec<&Judged> = judged
            .iter()
            .filter(|one| one.offence() == Some(offence))
            .collect();
        if found.is_empty() {
            continue;
        }
        println!("\n{what}:");
        for one in found {
            println!("  {one}");
        }
    }
}

/// Prints the totals and gives back which targets are missed.
fn totals(judged: &[Judged]) -> Vec<String> {
    let of = |fact: Fact| judged.iter().filter(move |one| one.truth.fact == fact);
    let offending = |offence: Offence| {
        judged
            .iter()
            .filter(|one| one.offence() == Some(offence))
            .count()
    };
    let (right, wrong) = (of(Fact::Right).count(), of(Fact::Wrong).count());
    let gross = judged.iter().filter(|one| one.gross()).count();
    let (passes, failures) = (
        offending(Offence::FalsePass),
        offending(Offence::FalseFailure),
    );
    let gross_not_decided = offending(Offence::GrossNotDecided);
    let not_decided = offending(Offence::NotDecided) + gross_not_decided;
    let share = |count: usize, of: usize| count as f64 / of.max(1) as f64;
    let in_part = of(Fact::Wrong)
        .filter(|one| one.part && matches!(one.verdict, Verdict::PassedInPart { .. }))
        .count();
    println!(
        "\n{} cases: {right} right, {wrong} wrong, {} left out",
        judged.len(),
        of(Fact::LeftOut).count()
    );
    println!(
        "  false passes        {passes:>5} of {wrong} wrong; beside them {in_part} passed in part what was told to lack a part (to reach 0)"
    );
    println!(
        "  false failures      {failures:>5} of {right} right, {:.1} % (to reach {:.0} %)",
        100.0 * share(failures, right),
        100.0 * MOST_FALSE_FAILURES
    );
    println!(
        "  not decided         {not_decided:>5} of {} judged, {:.1} % (to reach {:.0} %)",
        right + wrong,
        100.0 * share(not_decided, right + wrong),
        100.0 * MOST_NOT_DECIDED
    );
    println!("  gross, not decided  {gross_not_decided:>5} of {gross} gross faults (to reach 0)");
    let missed = [
        (passes > 0, format!("{passes} false passes")),
        (
            share(failures, right) > MOST_FALSE_FAILURES,
            format!("{failures} false failures"),
        ),
        (
            share(not_decided, right + wrong) > MOST_NOT_DECIDED,
            format!("{not_decided} not decided"),
        ),
        (
            gross_not_decided > 0,
            format!("{gross_not_decided} gross faults not decided"),
        ),
    ];
    missed
        .into_iter()
        .filter(|(is, _)| *is)
        .map(|(_, what)| what)
        .collect()
}

#[cfg(test)]
mod tests;
