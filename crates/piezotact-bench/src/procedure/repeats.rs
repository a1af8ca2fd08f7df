//! Repeats of a characterisation, each judged while it runs and asked for again when it does not pass.

use std::fmt;

use piezotact::Doubt;
use piezotact::device::DriveSetup;
use piezotact::quantity::{Acceleration, Band, Drive};
use piezotact::recording::Recording;
use piezotact::transfer::{BundleError, TransferFunction, farthest_apart_db, pooled};

use super::characterise::{LEAST_COHERENCE, judged_band};
use super::{
    ACCELERATION_CHANNEL, Characterisation, CharacteriseConfig, DRIVE_CHANNEL, FORCE_CHANNEL,
    transfer_of,
};
use crate::gate::{Breach, Gate, GateConfig, GateRoles};
use crate::traits::{Bench, BenchError, Lying, RunPlan};

/// How often a device is characterised, and what every repeat must keep to.
#[derive(Clone, Debug, PartialEq)]
pub struct RepeatConfig {
    /// How many repeats, with the finger lying as it lies.
    pub repeats: usize,
    /// How often each may be tried.
    pub attempts: usize,
    /// What it must keep to.
    pub gating: Gating,
}

/// Whether measurements are judged while they run.
#[derive(Clone, Debug, PartialEq)]
pub enum Gating {
    /// Everything is taken.
    Open,
    /// What does not keep to this is asked for again.
    Judged(GateConfig),
}

/// A measurement that was asked for again.
#[derive(Clone, Debug, PartialEq)]
pub struct Refused {
    /// Which repeat, from 1.
    pub repeat: usize,
    /// Which attempt at it, from 1.
    pub attempt: usize,
    /// Why.
    pub breach: Breach,
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            repeat,
            attempt,
            breach,
        } = self;
        write!(
            f,
            "repeat {repeat}, attempt {attempt} was refused: {breach}"
        )
    }
}

/// Repeats of one characterisation.
#[derive(Clone, Debug)]
pub struct Repeated {
    /// Each.
    pub each: Vec<Characterisation>,
    /// What was asked for again.
    pub refused: Vec<Refused>,
    /// All as one estimate.
    pub function: TransferFunction<Drive, Acceleration>,
    /// How far the two that differ most lie apart over the driven band from 20 Hz up, dB rms; `None` for one.
    pub apart_db: Option<f64>,
}

/// One attempt at one repeat.
#[derive(Clone, Debug, PartialEq)]
pub struct Attempt {
    /// Which repeat, from 1.
    pub repeat: usize,
    /// Which attempt at it, from 1.
    pub attempt: usize,
    /// What is asked of the bench.
    pub run: RunPlan,
}

/// What plays and records one attempt.
pub type Measure<'a, E> =
    &'a mut dyn FnMut(&mut Bench, &Attempt, Option<&mut Gate>) -> Result<Recording, E>;

/// Characterises a device several times with the finger lying as it lies, asking for a measurement again whose force or
/// coherence leaves what was agreed. `measure` plays and records one attempt and hands every chunk to the gate, when there
/// is one, ending when that refuses; `told` hears of every refusal.
///
/// # Errors
/// [`BenchError::Refused`] when a repeat does not pass in as many attempts as it has; those of [`transfer_of`] and of
/// `measure`.
pub fn repeated<E: From<BenchError>>(
    bench: &mut Bench,
    (config, setup): (&CharacteriseConfig, Option<&DriveSetup>),
    repeats: &RepeatConfig,
    measure: Measure<'_, E>,
    told: &mut dyn FnMut(&Refused),
) -> Result<Repeated, E> {
    let first_label = config.run.put_down_for().to_owned();
    let band = judged_band(config);
    let (mut each, mut refused) = (Vec::<Characterisation>::new(), Vec::<Refused>::new());
    let (mut repeat, mut attempt) = (1, 1);
    while repeat <= repeats.repeats.max(1) {
        let tried = Attempt {
            repeat,
            attempt,
            run: run_of(&config.run, &first_label, repeat, attempt),
        };
        let mut gate = match &repeats.gating {
            Gating::Open => None,
            Gating::Judged(gate) => Some(gate_of(bench, config, gate)?),
        };
        let recording = measure(bench, &tried, gate.as_mut());
        let mut breach = gate.as_mut().and_then(|gate| {
            // A run that broke off for another reason is not the finger's fault.
            if recording.is_ok() {
                gate.finish();
            }
            gate.breach().cloned()
        });
        if breach.is_none() {
            let done = transfer_of(recording?, setup, config)?;
            breach = each
                .first()
                .filter(|_| repeats.gating != Gating::Open)
                .zip(band)
                .and_then(|(first, band)| opposite(&first.function, &done.function, band));
            if breach.is_none() {
                each.push(done);
                (repeat, attempt) = (repeat + 1, 1);
                continue;
            }
        }
        if let Some(breach) = breach {
            let refusal = Refused {
                repeat,
                attempt,
                breach,
            };
            told(&refusal);
            if attempt >= repeats.attempts.max(1) {
                return Err(BenchError::Refused {
                    repeat,
                    attempts: attempt,
                    breach: refusal.breach,
                }
                .into());
            }
            refused.push(refusal);
            attempt += 1;
        }
    }
    let functions: Vec<&TransferFunction<Drive, Acceleration>> =
        each.iter().map(|c| &c.function).collect();
    let mut function = pooled(&functions).map_err(|error| match error {
        BundleError::Transfer(error) => BenchError::Transfer(error),
        other => BenchError::Impossible {
            expected: "repeats that go together".into(),
            found: other.to_string(),
            todo: "measure again".into(),
        },
    })?;
    let apart_db = band.and_then(|band| farthest_apart_db(&functions, band));
    if each.len() > 1 {
        function
            .doubts
            .extend(band.and_then(|band| function.low_coherence(band, LEAST_COHERENCE)));
    }
    function.doubts.extend(
        apart_db
            .filter(|db| *db > MOST_APART_DB)
            .map(|db_rms| Doubt::RepeatsScatter { db_rms }),
    );
    if !refused.is_empty() {
        function.provenance = function.provenance.then(format!(
            "{} measurements refused and repeated",
            refused.len()
        ));
    }
    Ok(Repeated {
        each,
        refused,
        function,
        apart_db,
    })
}

/// Repeats of one placement that lie further apart than this are a doubt, dB rms (claim 6: at most 1 dB).
const MOST_APART_DB: f64 = 1.0;

/// The run of one attempt: the first keeps the plan's own label, so that one repeat is what a single run is.
fn run_of(plan: &RunPlan, put_down_for: &str, repeat: usize, attempt: usize) -> RunPlan {
    if (repeat, attempt) == (1, 1) {
        return plan.clone();
    }
    RunPlan {
        label: format!("{}, repeat {repeat}, attempt {attempt}", plan.label),
        lying: Lying::AsIn(put_down_for.into()),
        ..plan.clone()
    }
}

fn gate_of(
    bench: &Bench,
    config: &CharacteriseConfig,
    gate: &GateConfig,
) -> Result<Gate, BenchError> {
    let description = bench.acquirer.describe();
    let place = |name: &str| {
        let found = description
            .channels
            .iter()
            .position(|(channel, _)| channel == name);
        found.ok_or_else(|| BenchError::Impossible {
            expected: format!("a bench with a channel `{name}`"),
            found: description.name.clone(),
            todo: "turn the gate off".into(),
        })
    };
    let roles = GateRoles {
        drive: place(DRIVE_CHANNEL)?,
        acceleration: place(ACCELERATION_CHANNEL)?,
        // A bench without one says so in what it records.
        force: place(FORCE_CHANNEL).ok(),
    };
    let run = description.rate.samples_in(config.excitation.duration);
    Gate::new(
        gate,
        config.run.load,
        description.rate,
        roles,
        run,
        config.welch.segment,
    )
}

/// The breach of a repeat that answers with the opposite sign of the first.
fn opposite(
    first: &TransferFunction<Drive, Acceleration>,
    other: &TransferFunction<Drive, Acceleration>,
    band: Band,
) -> Option<Breach> {
    let (mut shared, mut powers) = (0.0, [0.0; 2]);
    for (line, _) in first.lines_in(band) {
        let (a, b) = (first.response()[line], other.response()[line]);
        shared += (a * b.conj()).re;
        powers[0] += a.norm_sqr();
        powers[1] += b.norm_sqr();
    }
    let correlation = shared / (powers[0] * powers[1]).sqrt();
    (correlation < 0.0).then_some(Breach::Polarity { correlation })
}
