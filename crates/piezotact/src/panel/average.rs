//! Averages over people by both means, the penalty that they cost a new person, and the verdict on whether they are acceptable.

use crate::panel::PanelWarning;
use serde::{Deserialize, Serialize};
use statrs::distribution::{Beta, ContinuousCDF};

use super::levels::Levels;
use super::prediction::new_person_db;
use super::together::Sign;
use super::{Cell, Panel, PanelError, SameResponse};
use crate::criterion::{Criterion as Rule, Limit, Outcome};
use crate::document::Content;
use crate::quantity::{Band, Quantity, Unit};
use crate::statistics::{mean, rms};
use crate::transfer::{BundleAverage, TransferFunction, average, leave_one_out, level_db};
use crate::warning::{Example, Few, FewWarning, Warning};

/// The fewest people for an interval of the share within the criterion: two people have one penalty, twice.
const ENOUGH_FOR_SHARE: usize = 3;
/// In an average of fewer people than this, one outlier shifts the average by more than a tenth of the outlier's distance.
const SMALL_AVERAGE_PEOPLE: usize = 12;
/// The largest number of people that is recommended.
const MOST_PEOPLE: usize = 300;

/// The criterion for an average over people to be acceptable for a new person.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Criterion {
    /// The limit of a person's penalty, dB rms.
    pub db_rms: f64,
    /// The least share of people whose penalty is within that limit, 0–1.
    pub least_share: f64,
}

impl Criterion {
    /// 3 dB rms, within which a texture that is rendered with the average is "slightly less performing", for nine of ten
    /// people.
    ///
    /// Source: the first number, L. Felicetti's thesis (2024), figure 79; the second is ours.
    #[must_use]
    pub fn thesis_2024() -> Self {
        Self {
            db_rms: 3.0,
            least_share: 0.9,
        }
    }
}

/// The criteria for an average to be acceptable for a new person.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum AverageCriterion {
    /// The share of people whose own penalty is within the criterion.
    ShareWithin,
    /// The share of people who were excited over all of the band.
    Excited,
    /// The share of people who are nobody else in the average, by their responses; absent where all are.
    Distinct,
}

/// The verdict on an average over people: whether it is acceptable for a new person.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Verdict {
    /// Whether the average is acceptable: met, not met, or not decided by the data.
    pub outcome: Outcome,
    /// By which criterion.
    pub criterion: Criterion,
    /// The share of people whose penalty is within it, 0–1.
    pub share_within: f64,
    /// The criterion's parts.
    pub criteria: Vec<Rule<AverageCriterion>>,
    /// The number of people needed for a decision, assuming the same scatter; absent when it is decided, or when up to
    /// 300 people would not decide it.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub people_needed: Option<usize>,
}

/// The penalty of rendering with the average of the others for one person.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ParticipantPenalty {
    /// The pseudonym.
    pub participant: String,
    /// The rms over the band of the difference of the levels, dB.
    pub db_rms: f64,
    /// The largest difference, dB.
    pub db_max: f64,
}

/// The leave-one-out penalties of one kind of average in one cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct CellPenalties {
    /// Which average.
    pub averaging: BundleAverage,
    /// Everybody.
    pub people: Vec<ParticipantPenalty>,
    /// The mean of the rms penalties, dB.
    pub mean_db_rms: f64,
    /// The interval that holds the rms error of one new person with a probability of 95 %, dB; absent for fewer than four people.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub new_person_db_rms: Option<[f64; 2]>,
    /// The mean of the largest differences, dB.
    pub mean_db_max: f64,
    /// The person with the largest penalty.
    pub worst: ParticipantPenalty,
    /// Whether the average is acceptable for a new person.
    pub verdict: Verdict,
}

impl CellPenalties {
    /// The criterion on `what`.
    #[must_use]
    pub fn criterion(&self, what: AverageCriterion) -> Option<&Rule<AverageCriterion>> {
        self.verdict.criteria.iter().find(|rule| rule.what == what)
    }

    /// The same beside people who may be one: an average that holds somebody twice is not decided.
    pub(super) fn beside_same(mut self, same: &[SameResponse]) -> Self {
        let is_in = |who: &str| self.people.iter().any(|one| one.participant == who);
        let twice = same
            .iter()
            .filter(|found| is_in(&found.one.participant) && is_in(&found.other.participant));
        let twice = twice.count();
        if twice > 0 {
            let people = self.people.len() as f64;
            let all = Limit::AtLeast {
                met: 1.0,
                not_met: 0.0,
            };
            let distinct = (people - twice as f64) / people;
            let what = AverageCriterion::Distinct;
            let verdict = &mut self.verdict;
            verdict
                .criteria
                .push(Rule::new(what, "", distinct, None, all));
            verdict.outcome = Outcome::NotDecided;
            verdict.people_needed = None;
        }
        self
    }
}

/// The difference between the complex mean and the mean of log magnitudes, and its causes: differences in level between people
/// raise the complex mean, since larger magnitudes weigh more, and differences in phase lower it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct AverageDifference {
    /// The complex mean's level less the other's, mean over the band, dB.
    pub mean_db: f64,
    /// The same at the line where it is lowest, dB.
    pub lowest_db: f64,
    /// Where it is, Hz.
    pub lowest_at_hz: f64,
    /// The rms over people and band of the phases about their mean, degrees.
    pub phase_rms_deg: f64,
    /// The rms over people at the line where the difference is lowest, degrees.
    pub phase_rms_there_deg: f64,
    /// The part explained by the spread of the phases, assuming a normal distribution, mean over the band, dB: zero or less.
    pub by_phases_db: f64,
    /// The part explained by the spread of the levels, assuming a normal distribution in dB, mean over the band, dB: zero or
    /// more.
    pub by_levels_db: f64,
}

/// The averages over people in one cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct CellAverage {
    /// Load and angle.
    pub cell: Cell,
    /// The lines of the band, Hz.
    pub frequencies_hz: Vec<f64>,
    /// The level of the mean of log magnitudes, dB.
    pub log_magnitude_db: Vec<f64>,
    /// The level of the complex mean, dB.
    pub complex_db: Vec<f64>,
    /// How they differ.
    pub difference: AverageDifference,
    /// The penalties of each average: first the mean of log magnitudes, then the complex mean.
    pub penalties: [CellPenalties; 2],
}

impl CellAverage {
    /// As [`CellPenalties::beside_same`], for both averages.
    pub(super) fn beside_same(mut self, same: &[SameResponse]) -> Self {
        self.penalties = self.penalties.map(|costs| costs.beside_same(same));
        self
    }

    /// The penalties of the average `averaging`.
    #[must_use]
    pub fn penalties_of(&self, averaging: BundleAverage) -> &CellPenalties {
        match averaging {
            BundleAverage::LogMagnitude => &self.penalties[0],
            BundleAverage::Complex => &self.penalties[1],
        }
    }
}

/// Both averages over people of every cell with two or more, with what they cost a new person over `band`.
///
/// Formula: [`leave_one_out`] over each person's own average. A complex mean over phases of the standard deviation σ
/// (radians, normal) is exp(−σ²/2) of the magnitude, 4.34·σ² dB less; over magnitudes whose logarithm has the standard
/// deviation τ (normal) it is exp(τ²/2) of their geometric mean, 4.34·τ² dB more.
///
/// Source: L. Felicetti's thesis (2024), section 5.2; K. V. Mardia and P. E. Jupp, *Directional Statistics*, 2000, for
/// the wrapped normal distribution; the mean of the log-normal distribution.
///
/// # Errors
/// [`PanelError::Empty`] when no line lies in the band, [`PanelError::Transfer`] when people cannot be averaged.
pub(super) fn averages<I: Quantity, O: Quantity>(
    levels: &Levels<I, O>,
    band: Band,
    criterion: Criterion,
) -> Result<Vec<CellAverage>, PanelError> {
    let mut found = Vec::new();
    for (i, cell) in levels.cells.iter().enumerate() {
        let inside = levels.in_cell(i);
        if inside.len() < 2 {
            continue;
        }
        let people: Vec<&str> = inside
            .iter()
            .map(|(p, _)| levels.people[*p].as_str())
            .collect();
        let functions: Vec<&TransferFunction<I, O>> =
            inside.iter().map(|(_, own)| &own.function).collect();
        let log = average(&functions, BundleAverage::LogMagnitude)?;
        let complex = average(&functions, BundleAverage::Complex)?;
        let costs = |averaging| costs(&functions, &people, averaging, band, criterion);
        found.push(CellAverage {
            cell: *cell,
            frequencies_hz: levels.frequencies_hz.clone(),
            log_magnitude_db: super::levels::levels_db(&log, band),
            complex_db: super::levels::levels_db(&complex, band),
            difference: difference(&functions, &log, &complex, band),
            penalties: [
                costs(BundleAverage::LogMagnitude)?,
                costs(BundleAverage::Complex)?,
            ],
        });
    }
    Ok(found)
}

fn costs<I: Quantity, O: Quantity>(
    functions: &[&TransferFunction<I, O>],
    people: &[&str],
    averaging: BundleAverage,
    band: Band,
    criterion: Criterion,
) -> Result<CellPenalties, PanelError> {
    let left = leave_one_out(functions, averaging, band)?;
    let people: Vec<ParticipantPenalty> = people
        .iter()
        .zip(&left.penalties)
        .map(|(who, penalty)| ParticipantPenalty {
            participant: (*who).to_owned(),
            db_rms: penalty.db_rms,
            db_max: penalty.db_max,
        })
        .collect();
    let worst = people
        .iter()
        .max_by(|a, b| a.db_rms.total_cmp(&b.db_rms))
        .cloned()
        .ok_or(PanelError::Nothing)?;
    let penalties: Vec<f64> = people.iter().map(|p| p.db_rms).collect();
    let verdict = verdict(functions, &penalties, averaging, band, criterion)?;
    Ok(CellPenalties {
        averaging,
        mean_db_rms: left.mean_db_rms,
        new_person_db_rms: new_person_db(&penalties),
        mean_db_max: mean(&people.iter().map(|p| p.db_max).collect::<Vec<_>>()),
        worst,
        verdict,
        people,
    })
}

/// The verdict on the average, from the leave-one-out `penalties` of all people.
fn verdict<I: Quantity, O: Quantity>(
    functions: &[&TransferFunction<I, O>],
    penalties: &[f64],
    averaging: BundleAverage,
    band: Band,
    criterion: Criterion,
) -> Result<Verdict, PanelError> {
    let n = penalties.len();
    let within = penalties
        .iter()
        .filter(|db| **db <= criterion.db_rms)
        .count();
    let share_within = within as f64 / n as f64;
    let what = AverageCriterion::ShareWithin;
    let least = Limit::at_least(criterion.least_share);
    let share_rule = if n < ENOUGH_FOR_SHARE {
        Rule::unmeasured(what, "", least)
    } else {
        let [low, mut high] = share_interval(within, n);
        if high < criterion.least_share && n < SMALL_AVERAGE_PEOPLE {
            // In a small average one outlier puts everybody beyond the limit.
            let within = within_without_odd(functions, penalties, averaging, band, criterion)?;
            high = share_interval(within, n)[1];
        }
        Rule::new(what, "", share_within, Some([low, high]), least)
    };
    // Where nothing was excited nothing is known, even if the numbers there agree.
    let excited = functions
        .iter()
        .filter(|f| f.unexcited_share(band) <= 0.0)
        .count();
    let all = Limit::AtLeast {
        met: 1.0,
        not_met: 0.0,
    };
    let excited_rule = Rule::new(
        AverageCriterion::Excited,
        "",
        excited as f64 / n as f64,
        None,
        all,
    );
    let outcome = match excited_rule.outcome {
        Outcome::Met => share_rule.outcome,
        _ => Outcome::NotDecided,
    };
    let undecided = outcome == Outcome::NotDecided && excited == n;
    Ok(Verdict {
        outcome,
        criterion,
        share_within,
        criteria: vec![share_rule, excited_rule],
        people_needed: undecided
            .then(|| people_needed(share_within, criterion))
            .flatten()
            .filter(|needed| *needed > n),
    })
}

/// The 95 % confidence interval of a share of which `k` of `n` were counted, 0–1.
///
/// Formula: quantiles of the beta distribution, B(0.025; k, n − k + 1) and B(0.975; k + 1, n − k).
///
/// Source: C. J. Clopper and E. S. Pearson (1934), Biometrika 26(4); as SciPy's `binomtest(k, n).proportion_ci()`.
///
/// ```
/// // Nobody of 36 beyond is the fewest that says 90 %.
/// let low = |n| piezotact::panel::share_interval(n, n)[0];
/// assert!(low(35) < 0.9 && low(36) > 0.9);
/// ```
#[must_use]
pub fn share_interval(k: usize, n: usize) -> [f64; 2] {
    let quantile = |q: f64, a: usize, b: usize| {
        Beta::new(a as f64, b as f64).map_or(f64::NAN, |beta| beta.inverse_cdf(q))
    };
    let low = match k {
        0 => 0.0,
        k => quantile(0.025, k, n + 1 - k),
    };
    let high = match n - k.min(n) {
        0 => 1.0,
        beyond => quantile(0.975, k + 1, beyond),
    };
    [low, high]
}

/// The number of people within the criterion, by the average of the others, with all of them or without any single one.
fn within_without_odd<I: Quantity, O: Quantity>(
    functions: &[&TransferFunction<I, O>],
    penalties: &[f64],
    averaging: BundleAverage,
    band: Band,
    criterion: Criterion,
) -> Result<usize, PanelError> {
    let people = functions.len();
    let mut within = 0;
    for (i, own) in functions.iter().enumerate() {
        let own_db = super::levels::levels_db(own, band);
        let mut found = penalties[i] <= criterion.db_rms;
        for odd in (0..people).filter(|j| *j != i) {
            if found {
                break;
            }
            let others: Vec<&TransferFunction<I, O>> = (0..people)
                .filter(|j| *j != i && *j != odd)
                .map(|j| functions[j])
                .collect();
            let averaged_db = super::levels::levels_db(&average(&others, averaging)?, band);
            let off = averaged_db.iter().zip(&own_db).map(|(a, own)| a - own);
            found = rms(&off.collect::<Vec<f64>>()) <= criterion.db_rms;
        }
        within += usize::from(found);
    }
    Ok(within)
}

/// The fewest people needed for a decision where `share` of them is within the criterion; `None` when no number up to
/// [`MOST_PEOPLE`] decides.
fn people_needed(share: f64, criterion: Criterion) -> Option<usize> {
    (ENOUGH_FOR_SHARE..=MOST_PEOPLE).find(|people| {
        let within = (share * *people as f64).round() as usize;
        let [low, high] = share_interval(within, *people);
        low >= criterion.least_share || high < criterion.least_share
    })
}

fn difference<I: Quantity, O: Quantity>(
    functions: &[&TransferFunction<I, O>],
    log: &TransferFunction<I, O>,
    complex: &TransferFunction<I, O>,
    band: Band,
) -> AverageDifference {
    let half_db = 10.0 * std::f64::consts::LOG10_E;
    let (mut differences, mut phases, mut levels) = (Vec::new(), Vec::new(), Vec::new());
    for (line, hz) in log.lines_in(band) {
        let middle = log.response()[line];
        let off: Vec<f64> = functions
            .iter()
            .map(|f| (f.response()[line] * middle.conj()).arg().to_degrees())
            .collect();
        phases.push(rms(&off));
        let ratios = functions
            .iter()
            .map(|f| level_db(f.response()[line]) - level_db(middle));
        levels.push(rms(&ratios.collect::<Vec<f64>>()) / (2.0 * half_db));
        differences.push((level_db(complex.response()[line]) - level_db(middle), hz));
    }
    let lowest =
        (0..differences.len()).min_by(|a, b| differences[*a].0.total_cmp(&differences[*b].0));
    let (lowest_db, lowest_at_hz) = lowest.map_or((0.0, f64::NAN), |line| differences[line]);
    let mean_square = |radians: &mut dyn Iterator<Item = f64>| {
        mean(&radians.map(|r| r * r).collect::<Vec<f64>>())
    };
    AverageDifference {
        mean_db: mean(&differences.iter().map(|(db, _)| *db).collect::<Vec<_>>()),
        lowest_db,
        lowest_at_hz,
        phase_rms_deg: rms(&phases),
        phase_rms_there_deg: lowest.map_or(0.0, |line| phases[line]),
        by_phases_db: -half_db * mean_square(&mut phases.iter().map(|deg| deg.to_radians())),
        by_levels_db: half_db * mean_square(&mut levels.iter().copied()),
    }
}

/// The average of the people of one load and angle.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(
    feature = "schemas",
    derive(schemars::JsonSchema),
    schemars(bound = "")
)]
#[serde(bound = "")]
pub struct PanelAverage<I: Quantity, O: Quantity> {
    /// Who is in it.
    pub participants: Vec<String>,
    /// How it was averaged.
    pub average: BundleAverage,
    /// What it holds for, in its condition, and what limits it.
    #[serde(flatten)]
    pub function: TransferFunction<I, O>,
    /// The load and angle.
    #[serde(skip)]
    pub cell: Cell,
    /// What it costs a new person; absent where only one person was measured.
    #[serde(skip)]
    pub costs: Option<CellPenalties>,
    /// The units of the drive and of the response.
    #[serde(skip)]
    pub units: [Unit; 2],
}

impl<I: Quantity, O: Quantity> Content for PanelAverage<I, O> {
    const SCHEMA: &'static str = "panel_average";
}

/// The average over the people of one cell, in units of `O` per `I`, with what it costs a new person over `band` as a
/// warning, and the people in its provenance.
///
/// Formula: [`average`] of each person's own average.
///
/// Source: L. Felicetti's thesis (2024), section 5.2.
///
/// # Errors
/// [`PanelError::Few`] when nobody was measured in the cell; [`PanelError::Empty`] when no line lies in the band;
/// [`PanelError::Transfer`] when people cannot be averaged.
pub fn average_of_panel<I: Quantity, O: Quantity>(
    panel: &Panel<I, O>,
    cell: Cell,
    averaging: BundleAverage,
    band: Band,
) -> Result<PanelAverage<I, O>, PanelError> {
    let mut opposites = panel.signs(band);
    opposites.retain(|sign| sign.is_opposite() && sign.of.cell.is(cell));
    let named = |error| super::analysis::with_opposite_names(error, opposites.first());
    let mut people = Vec::new();
    let mut functions = Vec::new();
    for who in panel.participants() {
        if let Some(own) = panel
            .person(who, cell, averaging)
            .map_err(|error| named(error.into()))?
        {
            people.push(who.as_str());
            functions.push(own);
        }
    }
    if functions.is_empty() {
        return Err(PanelError::Few {
            cell: cell.to_string(),
            expected: 1,
            found: 0,
        });
    }
    let functions: Vec<&TransferFunction<I, O>> = functions.iter().collect();
    let mut averaged = average(&functions, averaging).map_err(|error| named(error.into()))?;
    averaged.about.warnings.extend(panel.of_same_people());
    averaged
        .about
        .warnings
        .extend(panel.unsound(band, Some(cell)));
    averaged
        .about
        .warnings
        .extend(opposites.iter().filter_map(Sign::warning));
    let measured = panel.entries().iter().filter(|e| e.filing.cell.is(cell));
    averaged.about.provenance.steps.push(format!(
        "average of {} measurements at {cell} of participants {}; the measurements of each participant were averaged first",
        measured.clone().count(),
        people.join(", ")
    ));
    averaged.about.warnings.extend(of_members(
        measured.map(|e| (e.filing.to_string(), e.function.about.warnings.as_slice())),
    ));
    let costs = if functions.len() > 1 {
        let costs = costs(
            &functions,
            &people,
            averaging,
            band,
            Criterion::thesis_2024(),
        )
        .map_err(named)?
        .beside_same(panel.same_people());
        averaged.about.provenance.averaged_people = Some(people.len());
        averaged
            .about
            .warnings
            .push(Warning::from(PanelWarning::Averaged {
                participants: people.len(),
                penalty_db_rms: costs.mean_db_rms,
                new_person_db_rms: costs.new_person_db_rms,
                worst: costs.worst.participant.clone(),
                worst_db_rms: costs.worst.db_rms,
            }));
        Some(costs)
    } else {
        averaged.about.warnings.push(Warning::from(FewWarning::Few {
            found: 1,
            recommended: 3,
            what: Few::Groups {
                result: "the average over participants".into(),
            },
        }));
        None
    };
    Ok(PanelAverage {
        participants: people.into_iter().map(str::to_owned).collect(),
        average: averaging,
        function: averaged,
        cell,
        costs,
        units: [I::UNIT, O::UNIT],
    })
}

/// The warnings that single measurements carry, as one.
pub(super) fn of_members<'a>(
    members: impl Iterator<Item = (String, &'a [Warning])>,
) -> Option<Warning> {
    let (mut count, mut of, mut example) = (0, 0, None);
    for (name, warnings) in members {
        of += 1;
        if let Some(first) = warnings.first() {
            count += 1;
            example.get_or_insert_with(|| (name, first.clone()));
        }
    }
    let (measurement, example) = example?;
    let measurement = Example::from(measurement);
    Some(Warning::from(PanelWarning::OfMembers {
        count,
        of,
        measurement,
        example,
    }))
}
