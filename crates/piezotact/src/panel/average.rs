//! Averages over people by both means, the penalty that they cost a new person, and the verdict on whether they are acceptable.

use num_complex::Complex;
use serde::{Deserialize, Serialize};
use statrs::distribution::{Beta, ContinuousCDF};

use super::levels::{Levels, Mean, Own, left_out_db};
use super::prediction::new_person_db;
use super::together::Sign;
use super::{Cell, Panel, PanelError, PanelWarning, SameResponse};
use crate::criterion::{Criterion as Rule, Limit, Outcome};
use crate::document::Content;
use crate::quantity::{Band, Quantity, Unit};
use crate::statistics::{mean, rms};
use crate::transfer::{BundleAverage, TransferFunction, average};
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

/// Both averages over people of every cell with two or more, with what they cost a new person.
///
/// Formula: [`left_out_db`] over each person's own average. A complex mean over phases of the standard deviation σ
/// (radians, normal) is exp(−σ²/2) of the magnitude, 4.34·σ² dB less; over magnitudes whose logarithm has the standard
/// deviation τ (normal) it is exp(τ²/2) of their geometric mean, 4.34·τ² dB more.
///
/// Source: L. Felicetti's thesis (2024), section 5.2; K. V. Mardia and P. E. Jupp, *Directional Statistics*, 2000, for
/// the wrapped normal distribution; the mean of the log-normal distribution.
///
/// # Errors
/// [`PanelError::Transfer`] when people cancel.
pub(super) fn averages(
    levels: &Levels,
    criterion: Criterion,
) -> Result<Vec<CellAverage>, PanelError> {
    let mut found = Vec::new();
    for (i, cell) in levels.cells.iter().enumerate() {
        let people = levels.in_cell(i);
        if people.len() < 2 {
            continue;
        }
        let own = || people.iter().map(|(_, own)| *own);
        let level = |averaging| Mean::of(averaging, own()).levels_db();
        let log_magnitude_db = level(BundleAverage::LogMagnitude)?;
        let complex_db = level(BundleAverage::Complex)?;
        let own: Vec<&Own> = own().collect();
        found.push(CellAverage {
            cell: *cell,
            frequencies_hz: levels.frequencies_hz.clone(),
            difference: difference(&own, &levels.frequencies_hz, &log_magnitude_db, &complex_db),
            log_magnitude_db,
            complex_db,
            penalties: [
                costs(&people, BundleAverage::LogMagnitude, criterion)?,
                costs(&people, BundleAverage::Complex, criterion)?,
            ],
        });
    }
    Ok(found)
}

fn costs(
    people: &[(&str, &Own)],
    averaging: BundleAverage,
    criterion: Criterion,
) -> Result<CellPenalties, PanelError> {
    let own: Vec<&Own> = people.iter().map(|(_, own)| *own).collect();
    let off_db = left_out_db(&own, averaging)?;
    let people: Vec<ParticipantPenalty> = people
        .iter()
        .zip(&off_db)
        .map(|((who, _), off)| ParticipantPenalty {
            participant: (*who).to_owned(),
            db_rms: rms(off),
            db_max: off.iter().fold(0.0, |most: f64, db| most.max(db.abs())),
        })
        .collect();
    let penalties_db: Vec<f64> = people.iter().map(|p| p.db_rms).collect();
    let worst = people
        .iter()
        .max_by(|a, b| a.db_rms.total_cmp(&b.db_rms))
        .cloned()
        .ok_or(PanelError::Nothing)?;
    Ok(CellPenalties {
        averaging,
        mean_db_rms: mean(&penalties_db),
        new_person_db_rms: new_person_db(&penalties_db),
        mean_db_max: mean(&people.iter().map(|p| p.db_max).collect::<Vec<_>>()),
        worst,
        verdict: verdict(&own, &penalties_db, averaging, criterion),
        people,
    })
}

/// The verdict on the average, from the leave-one-out `penalties_db` of all people.
fn verdict(
    people: &[&Own],
    penalties_db: &[f64],
    averaging: BundleAverage,
    criterion: Criterion,
) -> Verdict {
    let n = people.len();
    let is_within = |db: &f64| *db <= criterion.db_rms;
    let within = penalties_db.iter().filter(|db| is_within(db)).count();
    let share_within = within as f64 / n as f64;
    let what = AverageCriterion::ShareWithin;
    let least = Limit::at_least(criterion.least_share);
    let share_rule = if n < ENOUGH_FOR_SHARE {
        Rule::unmeasured(what, "", least)
    } else {
        let [low, mut high] = share_interval(within, n);
        if high < criterion.least_share && n < SMALL_AVERAGE_PEOPLE {
            // In a small average one outlier puts everybody beyond the limit: whoever is within without any single one counts.
            let without_odd = (0..n).filter(|i| {
                is_within(&penalties_db[*i])
                    || (0..n).filter(|odd| odd != i).any(|odd| {
                        let others = (0..n).filter(|j| j != i && *j != odd);
                        let average = Mean::of(averaging, others.map(|j| people[j]));
                        is_within(&average.off_db_rms(people[*i]))
                    })
            });
            high = share_interval(without_odd.count(), n)[1];
        }
        Rule::new(what, "", share_within, Some([low, high]), least)
    };
    // Where nothing was excited nothing is known, even if the numbers there agree.
    let excited = people.iter().filter(|own| own.excited).count();
    let all = Limit::AtLeast {
        met: 1.0,
        not_met: 0.0,
    };
    let share = excited as f64 / n as f64;
    let excited_rule = Rule::new(AverageCriterion::Excited, "", share, None, all);
    let outcome = match excited_rule.outcome {
        Outcome::Met => share_rule.outcome,
        _ => Outcome::NotDecided,
    };
    let undecided = outcome == Outcome::NotDecided && excited == n;
    Verdict {
        outcome,
        criterion,
        share_within,
        criteria: vec![share_rule, excited_rule],
        people_needed: undecided
            .then(|| people_needed(share_within, criterion))
            .flatten()
            .filter(|needed| *needed > n),
    }
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

/// The fewest people needed for a decision where `share` of them is within the criterion; `None` when no number up to
/// [`MOST_PEOPLE`] decides.
fn people_needed(share: f64, criterion: Criterion) -> Option<usize> {
    (ENOUGH_FOR_SHARE..=MOST_PEOPLE).find(|people| {
        let within = (share * *people as f64).round() as usize;
        let [low, high] = share_interval(within, *people);
        low >= criterion.least_share || high < criterion.least_share
    })
}

/// How the complex mean of `people` differs from the mean of log magnitudes, and why.
fn difference(
    people: &[&Own],
    frequencies_hz: &[f64],
    log_db: &[f64],
    complex_db: &[f64],
) -> AverageDifference {
    let half_db = 10.0 * std::f64::consts::LOG10_E;
    let lines = 0..frequencies_hz.len();
    // About the phase of the sum and the mean of the phases relative to it, as `transfer::average` has them.
    let phases: Vec<f64> = lines
        .clone()
        .map(|line| {
            let responses = || people.iter().map(move |own| own.response[line]);
            let sum: Complex<f64> = responses().sum();
            let relative: Vec<f64> = responses().map(|h| (h * sum.conj()).arg()).collect();
            let middle = Complex::from_polar(1.0, sum.arg() + mean(&relative));
            let off = responses().map(|h| (h * middle.conj()).arg());
            rms(&off.collect::<Vec<f64>>())
        })
        .collect();
    let levels: Vec<f64> = lines
        .clone()
        .map(|line| {
            let off = people.iter().map(|own| own.db[line] - log_db[line]);
            rms(&off.collect::<Vec<f64>>()) / (2.0 * half_db)
        })
        .collect();
    let differences = complex_db
        .iter()
        .zip(log_db)
        .map(|(complex, log)| complex - log);
    let differences: Vec<f64> = differences.collect();
    let lowest = lines
        .min_by(|a, b| differences[*a].total_cmp(&differences[*b]))
        .unwrap_or(0);
    let mean_square = |values: &[f64]| rms(values).powi(2);
    AverageDifference {
        mean_db: mean(&differences),
        lowest_db: differences[lowest],
        lowest_at_hz: frequencies_hz[lowest],
        phase_rms_deg: rms(&phases).to_degrees(),
        phase_rms_there_deg: phases[lowest].to_degrees(),
        by_phases_db: -half_db * mean_square(&phases),
        by_levels_db: half_db * mean_square(&levels),
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
    if functions[0].lines_in(band).next().is_none() {
        return Err(PanelError::Empty { band });
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
        let own: Vec<Own> = functions.iter().map(|f| Own::of(*f, band)).collect();
        let own: Vec<(&str, &Own)> = people.iter().copied().zip(&own).collect();
        let costs = costs(&own, averaging, Criterion::thesis_2024()).map_err(named)?;
        let costs = costs.beside_same(panel.same_people());
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
