//! One pair: how far apart what was felt is in level, and in spectrum at equal level.

use piezotact::warning::{Few, FewWarning, Scatter, ScatterWarning};
use std::fmt;

use piezotact::Warning;
use piezotact::criterion::{Criterion, Limit, Outcome};
use piezotact::discrimination::Model;
use piezotact::integrity::copied;
use piezotact::perception::{Contribution, Feature};
use piezotact::quantity::{Decibels, SampleRate};
use piezotact::resample::to_common_rate;
use piezotact::score::{Difference, Extent, Score, ScoreConfig, ScoreModel, not_felt, score};
use piezotact::spectrum::{RECOMMENDED_SEGMENTS, WelchConfig};
use serde::{Deserialize, Serialize};

use super::super::confused::PairOutcome;
use super::FeltRecording;

/// Lines are at most this far apart, so that the lowest third octaves, 5 Hz wide at 20 Hz, have one of their own.
const COARSEST_HZ: f64 = 5.0;

/// What separates a pair, in the order of all arrays.
const QUESTIONS: [&str; 3] = ["level", "spectrum", "time course"];

/// "a", "a and b", "a, b and c".
fn listed(names: &[&str], last: &str) -> String {
    match names {
        [] => String::new(),
        [one] => (*one).into(),
        [most @ .., one] => format!("{} {last} {one}", most.join(", ")),
    }
}

/// What a pair is judged by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum FeltCriterion {
    /// The difference in sensation level against the just-noticeable difference.
    Level,
    /// The same against how far the halves of one recording lie apart.
    LevelWithin,
    /// The difference in spectrum at equal sensation level against the just-noticeable difference.
    Spectrum,
    /// The same against how far the halves of one recording lie apart.
    SpectrumWithin,
    /// The difference over time and channels at equal sensation level, without level and pitch, against 1 JND and against how far the halves
    /// of one recording lie apart.
    TimeCourse,
}

impl fmt::Display for FeltCriterion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Level => "difference in level below the just-noticeable difference",
            Self::LevelWithin => {
                "difference in level below the difference between the halves of one recording"
            }
            Self::Spectrum => {
                "difference in spectrum, at equal level, below the just-noticeable difference"
            }
            Self::SpectrumWithin => {
                "difference in spectrum, at equal level, below the difference between the halves of one recording"
            }
            Self::TimeCourse => "difference in time course, at equal level, below the just-noticeable difference",
        })
    }
}

/// Whether level, or spectrum, separates a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Separates {
    /// The whole interval lies above the published range of the just-noticeable difference, and above what the halves of one recording
    /// differ by.
    Yes,
    /// The whole interval lies below the just-noticeable difference.
    No,
    /// The recordings are compatible with both.
    NotDecided,
}

impl Separates {
    /// "yes", "no" or "not decided".
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Yes => "yes",
            Self::No => "no",
            Self::NotDecided => "not decided",
        }
    }

    /// What follows from the outcome against the just-noticeable difference and that against the halves of one recording.
    fn of(jnd: Outcome, within: Option<Outcome>) -> Self {
        match (jnd, within) {
            (Outcome::Met, _) => Self::No,
            (Outcome::NotMet, None | Some(Outcome::NotMet)) => Self::Yes,
            _ => Self::NotDecided,
        }
    }
}

/// How far two textures are apart, as one finger felt them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct FeltComparison {
    /// Whose finger; absent where it stands for everybody.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub participant: Option<String>,
    /// The sensation level of the second less that of the first, dB.
    pub level_db: f64,
    /// Whether level separates them.
    pub by_level: Separates,
    /// Whether the spectrum, at equal sensation level, separates them.
    pub by_spectrum: Separates,
    /// Whether the time course (modulation, rhythm, onset, dips), at equal sensation level, separates them.
    pub by_time: Separates,
    /// The features of the time course in which they differ most.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub differ_in: Vec<Contribution>,
    /// The criteria that say so, in JND.
    pub criteria: Vec<Criterion<FeltCriterion>>,
    /// The segments averaged, of the one that has fewer.
    pub segments: usize,
}

impl FeltComparison {
    /// The criterion on `what`.
    #[must_use]
    pub fn criterion(&self, what: FeltCriterion) -> Option<&Criterion<FeltCriterion>> {
        self.criteria.iter().find(|c| c.what == what)
    }

    fn separates(&self) -> [Separates; 3] {
        [self.by_level, self.by_spectrum, self.by_time]
    }

    /// Whether level, spectrum or time course separates them.
    #[must_use]
    pub fn is_separated(&self) -> bool {
        self.separates().contains(&Separates::Yes)
    }

    /// "level separates them, spectrum and time course do not".
    #[must_use]
    pub fn words(&self) -> String {
        let with = |outcome| {
            let named = QUESTIONS.iter().zip(self.separates());
            let names = named.filter(|(_, found)| *found == outcome);
            names.map(|(name, _)| *name).collect::<Vec<_>>()
        };
        let (yes, no, open) = (
            with(Separates::Yes),
            with(Separates::No),
            with(Separates::NotDecided),
        );
        let verb = |names: &[&str], one: &str, several: &str| match names {
            [name] => format!("{name} {one}"),
            names => format!("{} {several}", listed(names, "and")),
        };
        let decided = match (yes.as_slice(), no.as_slice()) {
            ([], []) => String::new(),
            ([], [name]) => format!("{name} does not separate them"),
            ([], [a, b]) => format!("neither {a} nor {b} separates them"),
            ([], names) => format!("neither {} separates them", listed(names, "nor")),
            (yes, []) => verb(yes, "separates them", "separate them"),
            (yes, no) => format!(
                "{}, {}",
                verb(yes, "separates them", "separate them"),
                verb(no, "does not", "do not")
            ),
        };
        if open.is_empty() {
            return decided;
        }
        let open = listed(&open, "or");
        match decided.as_str() {
            "" => format!("whether {open} separates them is not decided"),
            decided => format!("{decided}; whether {open} does is not decided"),
        }
    }

    fn numbers(&self) -> String {
        let of = |name: &str, what| {
            let criterion = self.criterion(what)?;
            let interval = criterion.interval.map_or_else(
                || "no interval".to_owned(),
                |[low, high]| format!("95 %: {low:.2}–{high:.2}"),
            );
            Some(format!("{name} {:.2} JND ({interval})", criterion.found?))
        };
        let all = [
            of("level", FeltCriterion::Level),
            of("spectrum", FeltCriterion::Spectrum),
            of("time course", FeltCriterion::TimeCourse),
        ];
        let numbers = all.into_iter().flatten().collect::<Vec<_>>().join(", ");
        let features: Vec<String> = self.differ_in.iter().map(ToString::to_string).collect();
        match self.by_time {
            Separates::Yes => format!("{numbers}, in {}", features.join(" and ")),
            _ => numbers,
        }
    }
}

/// What was felt in one pair.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct FeltPair {
    /// The two.
    pub pair: [String; 2],
    /// Whether they are confused, by the answers.
    pub outcome: PairOutcome,
    /// How far they are apart: one for each participant, or one for everybody; none where recordings are missing.
    pub comparisons: Vec<FeltComparison>,
}

impl FeltPair {
    /// For how many fingers level separates them, for how many spectrum does, and for how many the time course.
    #[must_use]
    pub fn separated(&self) -> [usize; 3] {
        self.count(Separates::Yes)
    }

    fn count(&self, wanted: Separates) -> [usize; 3] {
        std::array::from_fn(|question| {
            let all = self.comparisons.iter();
            all.filter(|one| one.separates()[question] == wanted)
                .count()
        })
    }

    /// The median over fingers of what was found for `what`, JND; `None` where nothing was compared.
    #[must_use]
    pub fn median_jnd(&self, what: FeltCriterion) -> Option<f64> {
        let all = self.comparisons.iter();
        let found: Vec<f64> = all
            .filter_map(|one| one.criterion(what).and_then(|c| c.found))
            .collect();
        middle(found)
    }

    /// What was found in one sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let names = self.pair.join(" – ");
        let separated = self.comparisons.iter().filter(|one| one.is_separated());
        let separated = separated.count();
        let confused = match self.outcome {
            PairOutcome::Confused if separated > 0 => "confused although",
            PairOutcome::Confused => "confused;",
            PairOutcome::NotDecided => "confusion not decided;",
            outcome => &format!("by the answers {};", outcome.word()),
        };
        match self.comparisons.as_slice() {
            [] => format!(
                "{names}: {} what was felt is not known",
                confused.replace(" although", ";")
            ),
            [one] => {
                let of = one.participant.as_ref();
                let of = of.map_or(String::new(), |person| format!(" for {person}"));
                format!("{names}: {confused} {}{of}: {}", one.words(), one.numbers())
            }
            several => {
                let (yes, open) = (self.separated(), self.count(Separates::NotDecided));
                let medians = [
                    FeltCriterion::Level,
                    FeltCriterion::Spectrum,
                    FeltCriterion::TimeCourse,
                ];
                let each = QUESTIONS.iter().enumerate().map(|(i, name)| {
                    let verb = if i == 0 { " separates them" } else { "" };
                    let median = self.median_jnd(medians[i]);
                    let median = median.map_or("–".into(), |jnd| format!("{jnd:.2} JND"));
                    let (yes, open) = (yes[i], open[i]);
                    format!("{name}{verb} for {yes} (not decided for {open}, median {median})")
                });
                let each: Vec<String> = each.collect();
                let each: Vec<&str> = each.iter().map(String::as_str).collect();
                let people = several.len();
                format!(
                    "{names}: {confused} of {people} participants, {}",
                    listed(&each, "and")
                )
            }
        }
    }
}

/// How the spectrum of `count` samples is estimated: as a score does, or with shorter segments where two of them do not fit.
pub(super) fn welch_for(count: usize, rate: SampleRate) -> Result<WelchConfig, String> {
    let hz = rate.hz();
    let mut segment = 2f64.powf((hz / 1.2).log2().round()).max(16.0) as usize;
    while 2 * segment > count && segment > 16 {
        segment /= 2;
    }
    if 2 * segment > count || hz / segment as f64 > COARSEST_HZ {
        return Err(format!(
            "it is too short: expected at least {:.1} s, found {:.2} s",
            2.0 / COARSEST_HZ,
            count as f64 / hz
        ));
    }
    Ok(WelchConfig::hann(segment))
}

/// The median; `None` of nothing.
fn middle(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let half = values.len() / 2;
    let upper = *values.get(half)?;
    Some(if values.len() % 2 == 1 {
        upper
    } else {
        f64::midpoint(values[half - 1], upper)
    })
}

fn larger(a: Difference, b: Difference) -> Difference {
    Difference {
        jnd: a.jnd.max(b.jnd),
        low_jnd: a.low_jnd.max(b.low_jnd),
        high_jnd: a.high_jnd.max(b.high_jnd),
        scatter_jnd: a.scatter_jnd.max(b.scatter_jnd),
    }
}

/// The criteria on one difference, first against the just-noticeable difference, then against halves, with what follows.
fn judged(
    found: Difference,
    score: &Score,
    [jnd, within]: [FeltCriterion; 2],
) -> (Separates, Vec<Criterion<FeltCriterion>>) {
    let ends = [found.low_jnd, found.high_jnd];
    let known = ends.iter().all(|end| end.is_finite());
    let against = |what, limit| {
        let judged = if known { ends } else { [f64::NAN; 2] };
        Criterion {
            interval: known.then_some(ends),
            ..Criterion::new(what, "JND", found.jnd, Some(judged), limit)
        }
    };
    let mut criteria = vec![against(jnd, score.config.model().limit())];
    if let (Extent::WholeOfEach, Some([a, b])) = (score.extent, score.within_jnd) {
        criteria.push(against(within, Limit::at_most(a.max(b))));
    }
    let halves = criteria.get(1).map(|c| c.outcome);
    (Separates::of(criteria[0].outcome, halves), criteria)
}

/// Whether the time course separates the two of `levelled`, in which features, and the criterion that says so.
fn time_course(levelled: &Score) -> (Separates, Vec<Contribution>, Criterion<FeltCriterion>) {
    let limit = |within: f64| Limit::AtMost {
        met: 1.0,
        not_met: within.max(1.0),
    };
    let Some(found) = &levelled.perceived else {
        let unknown = Criterion::unmeasured(FeltCriterion::TimeCourse, "JND", limit(1.0));
        return (Separates::NotDecided, Vec::new(), unknown);
    };
    let jnd = found.difference.in_features(Feature::is_of_time);
    let criterion = Criterion::new(
        FeltCriterion::TimeCourse,
        "JND",
        jnd.value,
        Some([jnd.low, jnd.high]),
        limit(found.within_jnd.unwrap_or(0.0)),
    );
    let criterion = match criterion.outcome {
        Outcome::Met if found.difference.may_hide_more() => Criterion {
            outcome: Outcome::NotDecided,
            ..criterion
        },
        _ => criterion,
    };
    let mut main = found.difference.main_contributions();
    main.retain(|one| one.feature.is_of_time());
    (Separates::of(criterion.outcome, None), main, criterion)
}

/// How far the two are apart, with the warnings about it; or why they cannot be compared.
pub(super) fn compared(
    participant: Option<&str>,
    [a, b]: [&FeltRecording; 2],
    model: &Model,
) -> Result<(FeltComparison, Vec<Warning>), String> {
    let common = to_common_rate(
        (&a.sample, a.vibration.clone()?),
        (&b.sample, b.vibration.clone()?),
    );
    let common = common.map_err(|error| error.to_string())?;
    let (first, second) = (common.first, common.second);
    if copied(first.samples(), second.samples()).is_some() {
        return Err("both recordings are one, or a copy with another level or delay".into());
    }
    let shorter = first.samples().len().min(second.samples().len());
    let config = ScoreConfig {
        welch: welch_for(shorter, first.rate())?,
        level_jnd: model.level_jnd,
        level_jnd_high: model.level_jnd_high,
        frequency_jnd_share: model.frequency_jnd_share,
        weighting: model.weighting,
        contact: model.contact.clone(),
        ..ScoreConfig::over(model.band, first.rate().hz())
    };
    let of = |x: &_, y: &_, judged_by| {
        let config = ScoreConfig {
            judged_by,
            ..config.clone()
        };
        score(x, y, &config).map_err(|error| error.to_string())
    };
    let as_felt = of(&first, &second, ScoreModel::Spectral)?;
    // The louder at the sensation level of the softer: what is not felt of the softer separates nothing.
    let louder_by = as_felt.test_sensation_db - as_felt.reference_sensation_db;
    let levelled = if louder_by > 0.0 {
        [first, second.amplified(Decibels(-louder_by))]
    } else {
        [first.amplified(Decibels(louder_by)), second]
    };
    // Where the time course is not known, of recordings below 1 kHz, the spectra still are.
    let levelled = of(&levelled[0], &levelled[1], ScoreModel::PerceivedDifference)
        .or_else(|_| of(&levelled[0], &levelled[1], ScoreModel::Spectral))?;
    let (by_level, mut criteria) = judged(
        as_felt.level,
        &as_felt,
        [FeltCriterion::Level, FeltCriterion::LevelWithin],
    );
    let (by_spectrum, of_spectrum) = judged(
        larger(levelled.spectrum, levelled.balance),
        &levelled,
        [FeltCriterion::Spectrum, FeltCriterion::SpectrumWithin],
    );
    criteria.extend(of_spectrum);
    let (by_time, differ_in, of_time) = time_course(&levelled);
    criteria.push(of_time);
    let mut warnings = warnings_about(&as_felt, [&a.sample, &b.sample]);
    warnings.extend(common.warning);
    Ok((
        FeltComparison {
            participant: participant.map(Into::into),
            level_db: louder_by,
            by_level,
            by_spectrum,
            by_time,
            differ_in,
            criteria,
            segments: as_felt.segments,
        },
        warnings,
    ))
}

/// The warnings about the score of the samples `names` on which its verdicts depend.
fn warnings_about(found: &Score, names: [&str; 2]) -> Vec<Warning> {
    let segments = found.segments;
    let short = FewWarning::Few {
        found: segments,
        recommended: RECOMMENDED_SEGMENTS,
        what: Few::Segments,
    };
    let short = (segments < RECOMMENDED_SEGMENTS).then(|| short.into());
    let levels = [found.reference_sensation_db, found.test_sensation_db];
    let changes =
        (found.is_nonstationary).then(|| ScatterWarning::Scatter { of: Scatter::Parts }.into());
    let of_both = short.into_iter().chain(not_felt(names, levels));
    of_both
        .chain(found.config.model().warnings())
        .chain(changes)
        .collect()
}
