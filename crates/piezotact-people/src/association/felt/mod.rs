//! What was felt in confused pairs: the spectra of both side by side, and whether level, spectrum or time course separates them.

mod pair;
mod warning;

use std::collections::{BTreeMap, BTreeSet};

use piezotact::Warning;
use piezotact::compare::plain_name;
use piezotact::discrimination::Model;
use piezotact::lineage::Lineage;
use piezotact::page::{Cell as TableCell, Column, Table};
use piezotact::quantity::{Acceleration, Drive, Hertz};
use piezotact::recording::{Condition, Recording, RecordingError};
use piezotact::score::sliding_part;
use piezotact::series::Series;
use piezotact::spectrum::welch;
use piezotact::stroke::played_part;
use serde::{Deserialize, Serialize};

pub use pair::{FeltComparison, FeltCriterion, FeltPair, Separates};
pub use warning::{FeltUnknown, FeltWarning};

use super::answer::Stimulus;
use super::confused::{ConfusedPair, PairOutcome};
use pair::{compared, welch_for};

/// Levels of nothing are this, dB.
const NOTHING_DB: f64 = -300.0;

/// A texture as a finger felt it.
#[derive(Clone, Debug, PartialEq)]
pub struct FeltRecording {
    /// Whose finger, by pseudonym; `None` where it stands for everybody.
    pub participant: Option<String>,
    /// The texture, by the name that it has in the answers.
    pub sample: String,
    /// The acceleration of the fingernail, m/s²; or why the recording cannot be used, in words.
    pub vibration: Result<Series<Acceleration>, String>,
}

/// The spectrum of a texture as it was felt.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct FeltSpectrum {
    /// Whose finger; absent where it stands for everybody.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub participant: Option<String>,
    /// The texture.
    pub sample: String,
    /// The frequency of the first line, Hz.
    pub first_hz: f64,
    /// The step between lines, Hz.
    pub resolution_hz: f64,
    /// The segments averaged.
    pub segments: usize,
    /// The PSD over the band, dB re 1 (m/s²)²/Hz, to 0.01 dB.
    pub psd_db: Vec<f64>,
}

impl FeltSpectrum {
    /// Frequencies in Hz with the PSD in dB re 1 (m/s²)²/Hz.
    #[must_use]
    pub fn points(&self) -> Vec<(f64, f64)> {
        let lines = self.psd_db.iter().enumerate();
        lines
            .map(|(i, db)| (self.first_hz + i as f64 * self.resolution_hz, *db))
            .collect()
    }
}

/// What was felt in the pairs that somebody confused and that are not shown to be told apart.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Felt {
    /// The perceptual model, and the band over which they are compared.
    pub model: Model,
    /// The spectrum of each texture of these pairs.
    pub spectra: Vec<FeltSpectrum>,
    /// The pairs, the most confused first.
    pub pairs: Vec<FeltPair>,
}

/// The acceleration that was felt in `recording` of `sample`, m/s²: while the drive plays ([`played_part`]), where a drive was recorded
/// beside it; of a recording of touch its strokes, with a warning that says so (as [`sliding_part`]); or else all of it.
///
/// Source: docs/decisions/answers.md.
///
/// # Errors
/// [`RecordingError`] where there is no acceleration, or several.
pub fn felt_part(
    sample: &str,
    recording: &Recording,
) -> Result<(Series<Acceleration>, Option<Warning>), RecordingError> {
    if recording.series::<Drive>(None).is_err() {
        return sliding_part(sample, recording, None);
    }
    let vibration = recording.series::<Acceleration>(None)?;
    let part = played_part(recording).and_then(|part| {
        let felt = vibration.samples().get(part.start..part.end)?;
        Series::new(felt.to_vec(), vibration.rate()).ok()
    });
    Ok((part.unwrap_or(vibration), None))
}

/// What a recording of `condition` and `lineage`, felt by `participant`, is instead of `stimulus`; `None` where nothing that it states
/// contradicts its name.
///
/// Source: docs/decisions/answers.md.
#[must_use]
pub fn felt_otherwise(
    stimulus: &Stimulus,
    participant: Option<&str>,
    (condition, lineage): (&Condition, Option<&Lineage>),
) -> Option<String> {
    let of_lineage = lineage.and_then(|lineage| lineage.sample.as_ref());
    let sample = of_lineage.or(condition.sample.as_ref().filter(|_| lineage.is_none()));
    if let Some(found) = sample.filter(|found| **found != stimulus.source) {
        let source = &stimulus.source;
        return Some(format!(
            "expected a texture of {source}, found one of {found}"
        ));
    }
    match lineage.map(Lineage::is_manipulated) {
        Some(true) if stimulus.is_plain() => {
            return Some(format!(
                "expected {} as it was touched, found a manipulated texture",
                stimulus.source
            ));
        }
        Some(false) if !stimulus.is_plain() => {
            return Some(format!(
                "expected a texture made of {}, found it as it was touched",
                stimulus.source
            ));
        }
        _ => {}
    }
    let finger = condition.participant.as_deref().zip(participant);
    finger
        .filter(|(found, expected)| plain_name(found) != plain_name(expected))
        .map(|(found, expected)| {
            format!("expected the finger of {expected}, found that of {found}")
        })
}

/// The names of the textures in those of `pairs` that are looked at: somebody confused them, and they are not shown to be told apart.
///
/// Source: docs/decisions/answers.md.
#[must_use]
pub fn felt_samples(pairs: &[ConfusedPair]) -> BTreeSet<String> {
    let names = pairs.iter().filter(|pair| is_looked_at(pair));
    names.flat_map(|pair| pair.pair.iter().cloned()).collect()
}

fn is_looked_at(pair: &ConfusedPair) -> bool {
    let open = matches!(
        pair.outcome,
        PairOutcome::Confused | PairOutcome::NotDecided
    );
    open && pair.declared.iter().sum::<usize>() > 0
}

/// What was felt in each of `pairs` that somebody confused and that is not shown to be told apart, by `model`, with the warnings.
/// Recordings of each participant are compared with each other; those of people who are not among `people` are left out.
///
/// Formula: PSD by Welch, Hann segments with half overlap of about 1.2 Hz, or shorter where two of them do not fit; level and spectrum as
/// [`piezotact::score::score`] has them, the spectrum at equal sensation level.
///
/// Source: docs/decisions/answers.md; thesis figures 53, 54, 60, 64 and 65.
#[must_use]
pub fn felt_pairs(
    pairs: &[ConfusedPair],
    recordings: &[FeltRecording],
    people: &BTreeSet<String>,
    model: &Model,
) -> (Felt, Vec<Warning>) {
    let mut warnings = Vec::new();
    let wanted = felt_samples(pairs);
    let fingers = fingers(recordings, &wanted, people, &mut warnings);
    let missing = missing(&wanted, &fingers);
    if !missing.is_empty() {
        warnings.push(
            FeltWarning::NotKnown {
                why: FeltUnknown::NoRecording { samples: missing },
            }
            .into(),
        );
    }
    let used = fingers.values().flat_map(BTreeMap::values);
    let shortest_s = used.filter_map(|of| usable_s(of)).fold(f64::MAX, f64::min);
    let mut spectra = Vec::new();
    for (person, samples) in &fingers {
        for recording in samples.values() {
            match spectrum(recording, model, shortest_s) {
                Ok(found) => spectra.push(found),
                Err(reason) => warnings.push(
                    FeltWarning::NotKnown {
                        why: FeltUnknown::Unusable {
                            sample: of_person(&recording.sample, *person),
                            reason,
                        },
                    }
                    .into(),
                ),
            }
        }
    }
    let mut found = Vec::new();
    for pair in pairs.iter().filter(|pair| is_looked_at(pair)) {
        let mut comparisons = Vec::new();
        for (person, samples) in &fingers {
            let [Some(a), Some(b)] = [0, 1].map(|i| samples.get(pair.pair[i].as_str())) else {
                continue;
            };
            // A warning names what has no spectrum already.
            let drawn = |of: &&&FeltRecording| {
                let is =
                    |s: &FeltSpectrum| s.sample == of.sample && s.participant == of.participant;
                spectra.iter().any(is)
            };
            if ![a, b].iter().all(drawn) {
                continue;
            }
            match compared(*person, [a, b], model) {
                Ok((comparison, of_it)) => {
                    comparisons.push(comparison);
                    warnings.extend(of_it);
                }
                Err(reason) => warnings.push(
                    FeltWarning::NotKnown {
                        why: FeltUnknown::NotCompared {
                            pair: of_person(&pair.pair.join(" – "), *person),
                            reason,
                        },
                    }
                    .into(),
                ),
            }
        }
        found.push(FeltPair {
            pair: pair.pair.clone(),
            outcome: pair.outcome,
            comparisons,
        });
    }
    let felt = Felt {
        model: model.clone(),
        spectra,
        pairs: found,
    };
    (felt, warnings)
}

/// The recordings of the `wanted` samples by finger, of `people` alone.
fn fingers<'a>(
    recordings: &'a [FeltRecording],
    wanted: &BTreeSet<String>,
    people: &BTreeSet<String>,
    warnings: &mut Vec<Warning>,
) -> BTreeMap<Option<&'a str>, BTreeMap<&'a str, &'a FeltRecording>> {
    let mut fingers: BTreeMap<Option<&str>, BTreeMap<&str, &FeltRecording>> = BTreeMap::new();
    let mut others = BTreeSet::new();
    for recording in recordings {
        let person = recording.participant.as_deref();
        if let Some(person) = person.filter(|person| !people.contains(*person)) {
            others.insert(person.to_owned());
            continue;
        }
        let of = fingers.entry(person).or_default();
        if wanted.contains(&recording.sample) {
            of.insert(&recording.sample, recording);
        }
    }
    if !others.is_empty() {
        let people = others.into_iter().collect();
        warnings.push(
            FeltWarning::NotKnown {
                why: FeltUnknown::OfOthers { people },
            }
            .into(),
        );
    }
    if fingers.contains_key(&None) && people.len() > 1 {
        let participants = people.len();
        warnings.push(
            FeltWarning::NotKnown {
                why: FeltUnknown::OneForAll { participants },
            }
            .into(),
        );
    }
    fingers
}

fn of_person(name: &str, person: Option<&str>) -> String {
    person.map_or_else(|| name.to_owned(), |person| format!("{name} of {person}"))
}

/// The textures of `wanted` that have no recording, by finger.
fn missing(
    wanted: &BTreeSet<String>,
    fingers: &BTreeMap<Option<&str>, BTreeMap<&str, &FeltRecording>>,
) -> Vec<String> {
    if fingers.is_empty() {
        return wanted.iter().cloned().collect();
    }
    let of_one = fingers.iter().flat_map(|(person, samples)| {
        let not_there = wanted.iter().filter(|name| !samples.contains_key(&***name));
        not_there.map(|name| of_person(name, *person))
    });
    of_one.collect()
}

/// How long a recording is, s; `None` for one that cannot be used.
fn usable_s(of: &FeltRecording) -> Option<f64> {
    let vibration = of.vibration.as_ref().ok()?;
    let count = vibration.samples().len();
    let long_enough = welch_for(count, vibration.rate()).is_ok();
    long_enough.then_some(vibration.duration().0)
}

/// The spectrum of a recording with lines as far apart as the shortest recording allows, or why it has none.
fn spectrum(of: &FeltRecording, model: &Model, shortest_s: f64) -> Result<FeltSpectrum, String> {
    let vibration = of.vibration.as_ref().map_err(Clone::clone)?;
    let (count, rate) = (vibration.samples().len(), vibration.rate());
    welch_for(count, rate)?;
    let config = welch_for(count.min((shortest_s * rate.hz()).round() as usize), rate)?;
    let band = model.band;
    if vibration.samples().iter().all(|v| *v == 0.0) {
        return Err("it holds no vibration".into());
    }
    let found = welch(vibration, &config).map_err(|error| error.to_string())?;
    let inside = |hz: f64| Hertz(hz) >= band.low() && Hertz(hz) <= band.high();
    let lines = found.frequencies_hz().into_iter().zip(&found.values);
    let lines: Vec<(f64, f64)> = lines
        .filter(|(hz, _)| inside(*hz))
        .map(|(hz, psd)| {
            let db = (10.0 * psd.log10()).max(NOTHING_DB);
            (hz, (100.0 * db).round() / 100.0)
        })
        .collect();
    let Some((first_hz, _)) = lines.first().copied() else {
        return Err(format!("its rate does not reach the band {band}"));
    };
    Ok(FeltSpectrum {
        participant: of.participant.clone(),
        sample: of.sample.clone(),
        first_hz,
        resolution_hz: found.resolution_hz,
        segments: found.averages,
        psd_db: lines.into_iter().map(|(_, db)| db).collect(),
    })
}

impl Felt {
    /// The spectrum of `sample` for `participant`; `None` where there is none.
    #[must_use]
    pub fn spectrum(&self, participant: Option<&str>, sample: &str) -> Option<&FeltSpectrum> {
        let mut spectra = self.spectra.iter();
        spectra.find(|s| s.sample == sample && s.participant.as_deref() == participant)
    }

    /// The comparisons as a table, a row for each pair and participant; without participants where recordings stand for everybody.
    #[must_use]
    pub fn table(&self) -> Table {
        let mut comparisons = self.pairs.iter().flat_map(|pair| &pair.comparisons);
        let people = usize::from(comparisons.any(|one| one.participant.is_some()));
        let names = [
            ("pair", "pair"),
            ("participant", "participant"),
            ("answers", "answers"),
            ("level, JND", "level_jnd"),
            ("95 %", "level_interval_jnd"),
            ("level separates", "level_separates"),
            ("spectrum, JND", "spectrum_jnd"),
            ("95 %", "spectrum_interval_jnd"),
            ("spectrum separates", "spectrum_separates"),
            ("time course, JND", "time_jnd"),
            ("range", "time_interval_jnd"),
            ("time course separates", "time_separates"),
        ];
        let names = names.iter().enumerate();
        let names = names.filter(|(i, _)| *i != 1 || people == 1);
        let mut table = Table::new(names.map(|(_, (heading, name))| Column::new(heading, name)));
        for pair in &self.pairs {
            table.rows.extend(pair.comparisons.iter().map(|one| {
                let number = |what| match one.criterion(what).and_then(|c| c.found) {
                    Some(jnd) => TableCell::from(format!("{jnd:.2}")),
                    None => TableCell::Missing(()),
                };
                let interval = |what| match one.criterion(what).and_then(|c| c.interval) {
                    Some([low, high]) => TableCell::from(format!("{low:.2} to {high:.2}")),
                    None => TableCell::Missing(()),
                };
                let person = TableCell::from(one.participant.as_deref().unwrap_or("–"));
                let rest = vec![
                    TableCell::from(pair.outcome.word()),
                    number(FeltCriterion::Level),
                    interval(FeltCriterion::Level),
                    TableCell::from(one.by_level.word()),
                    number(FeltCriterion::Spectrum),
                    interval(FeltCriterion::Spectrum),
                    TableCell::from(one.by_spectrum.word()),
                    number(FeltCriterion::TimeCourse),
                    interval(FeltCriterion::TimeCourse),
                    TableCell::from(one.by_time.word()),
                ];
                let name = TableCell::from(pair.pair.join(" – "));
                let person = std::iter::repeat_n(person, people);
                std::iter::once(name).chain(person).chain(rest).collect()
            }));
        }
        table
    }
}
