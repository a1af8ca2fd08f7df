//! Repeats of a characterisation, each judged while it runs and measured again if it does not pass.

use crate::DeviceError;
use piezotact::warning::{Scatter, ScatterWarning};
use std::fmt;

use piezotact::Warning;
use piezotact::criterion::{Criterion, Limit, Outcome};
use piezotact::document::{Content, in_words};
use piezotact::page::{Page, Shown};
use piezotact::quantity::{Acceleration, Band, Drive, Quantity};
use piezotact::run::{Attempt, Judged, RunCriterion};
use piezotact::transfer::{
    Bias, Distortion, Limits, TransferFunction, TransferReport, max_pair_difference_db, pooled,
};
use serde::{Serialize, Serializer};

use super::characterise::{judged_band, low_coherence};
use super::run::excite_and_record;
use super::{
    ACCELERATION_CHANNEL, Characterisation, CharacteriseConfig, DRIVE_CHANNEL, FORCE_CHANNEL,
    RunKeeper, excite, transfer_of,
};
use crate::error::{ProcedureError, Refusal};
use crate::gate::{Gate, GateConfig, GateRoles};
use crate::plan::{Placement, RunPlan};
use crate::traits::Bench;

/// The number of repeats of a characterisation, and the limits for each.
#[derive(Clone, Debug, PartialEq)]
pub struct RepeatConfig {
    /// The number of repeats, without lifting the finger.
    pub repeats: usize,
    /// The largest number of attempts at each repeat.
    pub attempts: usize,
    /// The limits for each repeat.
    pub gating: GatePolicy,
}

impl RepeatConfig {
    /// The repeat and the attempt of `plan` to which the run `label` belongs, both from 1; (1, 1) if it belongs to none.
    #[must_use]
    pub fn attempt_of(&self, plan: &RunPlan, label: &str) -> (usize, usize) {
        (1..=self.repeats.max(1))
            .flat_map(|repeat| (1..=self.attempts.max(1)).map(move |attempt| (repeat, attempt)))
            .find(|(repeat, attempt)| run_of(plan, "", *repeat, *attempt).label == label)
            .unwrap_or((1, 1))
    }
}

/// Whether measurements are judged while they run.
#[derive(Clone, Debug, PartialEq)]
pub enum GatePolicy {
    /// Every measurement is accepted.
    Open,
    /// A measurement that does not keep these limits is repeated.
    Judged(GateConfig),
}

/// A refused measurement, which was repeated.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Refused {
    /// Which repeat, from 1.
    pub repeat: usize,
    /// Which attempt at it, from 1.
    pub attempt: usize,
    /// Why.
    #[serde(rename = "reason", serialize_with = "in_words")]
    #[cfg_attr(feature = "schemas", schemars(with = "String"))]
    pub refusal: Refusal,
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            repeat,
            attempt,
            refusal,
        } = self;
        write!(
            f,
            "repeat {repeat}, attempt {attempt} was refused: {refusal}"
        )
    }
}

/// Repeats of one characterisation.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct RepeatedCharacterisation {
    /// Each of them; in documents their number.
    #[serde(rename = "repeats", serialize_with = "number_of")]
    #[cfg_attr(feature = "schemas", schemars(with = "usize"))]
    pub each: Vec<Characterisation>,
    /// What was refused.
    pub refused: Vec<Refused>,
    /// All attempts with their judgements, in order; none if nothing was judged.
    pub attempts: Vec<Attempt>,
    /// The band of the excitation.
    pub band_hz: Band,
    /// Noise and distortion of all repeats together; absent where the excitation cannot separate them.
    pub distortion: Option<Distortion>,
    /// What the confidence limits hold.
    pub limits: Limits,
    /// How far H2 lies above H1 from 20 Hz on; absent where no line lies there.
    pub bias: Option<Bias>,
    /// The transfer function of all repeats together.
    #[serde(flatten)]
    pub function: TransferFunction<Drive, Acceleration>,
    /// How far the two that differ most lie apart over the excited band from 20 Hz up, dB rms; absent for one.
    #[serde(rename = "repeats_apart_db_rms")]
    pub apart_db: Option<f64>,
}

impl Content for RepeatedCharacterisation {
    const SCHEMA: &'static str = "characterise";
}

impl Shown for RepeatedCharacterisation {
    fn page(&self) -> Page {
        let title = format!(
            "Transfer function: {}",
            self.function.about.provenance.source
        );
        TransferReport {
            distortion: self.distortion.as_ref(),
            repeats: self.apart_db.map(|db| (self.each.len(), db)),
            refused: self.refused.iter().map(ToString::to_string).collect(),
            ..TransferReport::of(title, &self.function, [&Drive::UNIT, &Acceleration::UNIT])
        }
        .page()
    }
}

fn number_of<S: Serializer>(each: &[Characterisation], serializer: S) -> Result<S::Ok, S::Error> {
    each.len().serialize(serializer)
}

/// Characterises a device several times without lifting the finger; a measurement whose force or coherence exceeds its limits is
/// repeated. The documents of every run go to `keeper`; `refused_one` is called for every refusal.
///
/// # Errors
/// [`ProcedureError::RepeatRefused`] when a repeat does not pass in as many attempts as it has; those of [`excite`],
/// [`super::play_and_record`] and [`transfer_of`].
pub fn repeated(
    bench: &mut Bench,
    config: &CharacteriseConfig,
    repeats: &RepeatConfig,
    keeper: &mut dyn RunKeeper,
    refused_one: &mut dyn FnMut(&Refused),
) -> Result<RepeatedCharacterisation, ProcedureError> {
    let (drive, setup) = excite(bench, config)?;
    let first_label = config.run.placed_for().to_owned();
    let band = judged_band(config);
    let (mut each, mut refused) = (Vec::<Characterisation>::new(), Vec::<Refused>::new());
    let mut attempts = Vec::<Attempt>::new();
    let (mut repeat, mut attempt) = (1, 1);
    while repeat <= repeats.repeats.max(1) {
        let run = run_of(&config.run, &first_label, repeat, attempt);
        let mut gate = match &repeats.gating {
            GatePolicy::Open => None,
            GatePolicy::Judged(gate) => Some(gate_of(bench, config, gate)?),
        };
        let recorded = excite_and_record(
            bench,
            (&drive, Some(config.excitation.band)),
            setup.as_ref(),
            &run,
            keeper,
            gate.as_mut(),
        );
        let refusal = match recorded {
            Err(ProcedureError::Refused(refusal)) => refusal,
            Err(error) => return Err(error),
            Ok(recording) => {
                let done = transfer_of(recording, setup.as_ref(), config)?;
                let mut judged = gate.as_mut().map(|gate| gate.judged_of(&done.recording));
                let compared = judged.as_mut().zip(each.first().zip(band));
                let polarity = compared.map(|(judged, (first, band))| {
                    let polarity = polarity(&first.function, &done.function, band);
                    judged.criteria.push(polarity.clone());
                    polarity
                });
                let opposite = polarity.filter(|rule| rule.outcome == Outcome::NotMet);
                let Some(opposite) = opposite else {
                    attempts.extend(judged.map(|judged| Attempt {
                        repeat,
                        attempt,
                        judged,
                    }));
                    each.push(done);
                    (repeat, attempt) = (repeat + 1, 1);
                    continue;
                };
                Refusal(Judged {
                    window_s: [0.0, done.recording.duration().0],
                    target_n: None,
                    criteria: vec![opposite],
                })
            }
        };
        let refusal = Refused {
            repeat,
            attempt,
            refusal,
        };
        refused_one(&refusal);
        if attempt >= repeats.attempts.max(1) {
            return Err(ProcedureError::RepeatRefused {
                repeat,
                attempts: attempt,
                refusal: refusal.refusal,
            });
        }
        attempts.push(Attempt {
            repeat,
            attempt,
            judged: refusal.refusal.0.clone(),
        });
        refused.push(refusal);
        attempt += 1;
    }
    together(each, refused, attempts, config)
}

/// The result of all repeats.
fn together(
    each: Vec<Characterisation>,
    refused: Vec<Refused>,
    attempts: Vec<Attempt>,
    config: &CharacteriseConfig,
) -> Result<RepeatedCharacterisation, ProcedureError> {
    let functions: Vec<&TransferFunction<Drive, Acceleration>> =
        each.iter().map(|c| &c.function).collect();
    let mut function = pooled(&functions)?;
    let apart_db = judged_band(config).and_then(|band| max_pair_difference_db(&functions, band));
    let low = low_coherence(&function, config);
    function.about.warnings.extend(low);
    function
        .about
        .warnings
        .extend(apart_db.filter(|db| *db > MOST_APART_DB).map(|db_rms| {
            Warning::from(ScatterWarning::Scatter {
                of: Scatter::Repeats { db_rms },
            })
        }));
    if !refused.is_empty() {
        function.about.provenance = function.about.provenance.then(format!(
            "{} measurements refused and repeated",
            refused.len()
        ));
    }
    let distortions: Vec<Distortion> = each
        .iter()
        .filter_map(|one| one.distortion.clone())
        .collect();
    Ok(RepeatedCharacterisation {
        each,
        refused,
        attempts,
        band_hz: config.excitation.band,
        distortion: Distortion::together(&distortions),
        limits: function.limits(),
        bias: function.bias(function.tactile_band()),
        function,
        apart_db,
    })
}

/// Repeats of one placement that lie further apart than this are a warning, dB rms (claim 6: at most 1 dB).
const MOST_APART_DB: f64 = 1.0;

/// The run of one attempt: the first keeps the plan's own label, so that one repeat is what a single run is.
fn run_of(plan: &RunPlan, placed_for: &str, repeat: usize, attempt: usize) -> RunPlan {
    if (repeat, attempt) == (1, 1) {
        return plan.clone();
    }
    RunPlan {
        label: format!("{}, repeat {repeat}, attempt {attempt}", plan.label),
        placement: Placement::SameAs(placed_for.into()),
        ..plan.clone()
    }
}

fn gate_of(
    bench: &Bench,
    config: &CharacteriseConfig,
    gate: &GateConfig,
) -> Result<Gate, ProcedureError> {
    let description = bench.acquirer.describe();
    let place = |name: &str| {
        let found = description
            .channels
            .iter()
            .position(|(channel, _)| channel == name);
        found.ok_or_else(|| {
            ProcedureError::Device(DeviceError::Impossible {
                expected: format!("a bench with a channel `{name}`"),
                found: description.name.clone(),
                todo: "turn the gate off".into(),
            })
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

/// Whether a repeat answers with the sign of the first.
fn polarity(
    first: &TransferFunction<Drive, Acceleration>,
    other: &TransferFunction<Drive, Acceleration>,
    band: Band,
) -> Criterion<RunCriterion> {
    let (mut shared, mut powers) = (0.0, [0.0; 2]);
    for (line, _) in first.lines_in(band) {
        let (a, b) = (first.response()[line], other.response()[line]);
        shared += (a * b.conj()).re;
        powers[0] += a.norm_sqr();
        powers[1] += b.norm_sqr();
    }
    let correlation = shared / (powers[0] * powers[1]).sqrt();
    let limit = Limit::at_least(0.0);
    Criterion::new(RunCriterion::Polarity, "", correlation, None, limit)
}
