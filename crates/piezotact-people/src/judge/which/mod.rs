//! Which judge answers show: the likelihood of each, a check on participants who were held out, and whether the best explains them
//! at all.

mod fit;
mod likelihood;

use std::collections::BTreeSet;

use piezotact::criterion::{Criterion, Limit, Outcome};
use piezotact::statistics::{mean, mean_interval, t_quantile};
use serde::{Deserialize, Serialize};

use super::answer::{JudgeError, Look, Moment, Recall};
use super::cues::Cues;
use super::{Judge, Touch};
use likelihood::{Best, Surface};

pub use fit::{FIT_NATS, FIT_SHARE, FitCriterion};
pub use likelihood::Parameters;

/// A judge is named from this Akaike weight on.
pub const NAMED_WEIGHT: f64 = 0.99;
/// Over fewer participants nothing is decided.
pub const MIN_PEOPLE: usize = 4;

/// A texture as it was touched.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct TouchedTexture {
    /// What was delivered.
    pub cues: Cues,
    /// In how many looks.
    pub looks: f64,
}

impl TouchedTexture {
    /// `cues` at leisure.
    #[must_use]
    pub fn of(cues: Cues) -> Self {
        Self {
            cues,
            looks: Look::AT_LEISURE,
        }
    }

    fn look(&self) -> Look<'_> {
        Look {
            cues: &self.cues,
            looks: self.looks,
            bias: 0.0,
        }
    }
}

/// A choice among alternatives: an element of an association, or an identification.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ChoiceAnswer {
    /// The participant's pseudonym.
    pub participant: String,
    /// When.
    pub moment: Moment,
    /// What was presented.
    pub presented: TouchedTexture,
    /// The alternatives.
    pub alternatives: Vec<TouchedTexture>,
    /// Whether they could be touched.
    pub recall: Recall,
    /// The place of the one that was chosen.
    pub chosen: usize,
}

impl ChoiceAnswer {
    fn looks(&self) -> (Look<'_>, Vec<Look<'_>>) {
        let alternatives = self.alternatives.iter().map(TouchedTexture::look);
        (self.presented.look(), alternatives.collect())
    }
}

/// Textures in order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct OrderAnswer {
    /// The participant's pseudonym.
    pub participant: String,
    /// When.
    pub moment: Moment,
    /// The textures.
    pub textures: Vec<TouchedTexture>,
    /// Their places, the roughest first.
    pub order: Vec<usize>,
}

impl OrderAnswer {
    fn looks(&self) -> Vec<Look<'_>> {
        self.textures.iter().map(TouchedTexture::look).collect()
    }
}

/// The answers of a campaign, with what was delivered.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Answers {
    /// Choices.
    pub choices: Vec<ChoiceAnswer>,
    /// Orders.
    pub orders: Vec<OrderAnswer>,
}

impl Answers {
    /// How many.
    #[must_use]
    pub fn len(&self) -> usize {
        self.choices.len() + self.orders.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The participants, in alphabetical order.
    fn people(&self) -> Vec<&String> {
        let all: BTreeSet<&String> = self.participants().collect();
        all.into_iter().collect()
    }

    /// Who gave each answer.
    fn participants(&self) -> impl Iterator<Item = &String> {
        let choices = self.choices.iter().map(|choice| &choice.participant);
        choices.chain(self.orders.iter().map(|order| &order.participant))
    }
}

/// Between which values free parameters are sought.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Bounds {
    /// Of the noise of a look over the assumed one.
    pub noise_ratio: [f64; 2],
    /// Of the weight of spectrum, for who goes by level and spectrum. Its lower end is above 0: there the judge would be the one who
    /// goes by level alone, and no answers could tell the two apart.
    pub spectrum_weight: [f64; 2],
    /// Of the share of lapses.
    pub lapse_share: [f64; 2],
}

impl Bounds {
    /// Noise from a quarter to four times the assumed one, a weight from an eighth to 16, up to a fifth of lapses.
    #[must_use]
    pub fn of_campaigns() -> Self {
        Self {
            noise_ratio: [0.25, 4.0],
            spectrum_weight: [0.125, 16.0],
            lapse_share: [0.0, 0.2],
        }
    }

    fn checked(&self) -> Result<(), JudgeError> {
        for (what, [low, high], least) in [
            ("noise_ratio", self.noise_ratio, 1e-3),
            ("spectrum_weight", self.spectrum_weight, 1e-3),
            ("lapse_share", self.lapse_share, 0.0),
        ] {
            let most = if what == "lapse_share" { 1.0 } else { 1e3 };
            if !(low >= least && low <= high && high <= most) {
                return Err(JudgeError::Answers {
                    why: format!("the bounds of {what} are {low} to {high}"),
                });
            }
        }
        Ok(())
    }
}

/// One judge against the answers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct JudgeFit {
    /// The judge.
    pub judge: Judge,
    /// Its free parameters where the answers are most probable.
    pub parameters: Parameters,
    /// The logarithm of the largest likelihood.
    pub log_likelihood: f64,
    /// Akaike's criterion for small samples, −2 ln L + 2k + 2k(k + 1)/(n − k − 1).
    pub aicc: f64,
    /// Its Akaike weight among the judges, 0–1.
    pub weight: f64,
    /// The mean logarithm of the probability of an answer, for each participant by the parameters of all others.
    pub held_out: Vec<f64>,
}

/// A rule of the verdict.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "is", rename_all = "snake_case")]
pub enum VerdictCriterion {
    /// The number of participants.
    Participants,
    /// The Akaike weight of the best judge.
    Weight,
    /// How much better it predicts participants who were held out than another judge does, over the standard error of that mean.
    HeldOut {
        /// The other judge.
        than: Judge,
    },
    /// How many of its free parameters lie at the bounds within which they were sought.
    AtBounds,
    /// How many of the criteria of its fit are not met.
    Misfits,
}

/// Which judge it was.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "is", rename_all = "snake_case")]
pub enum Verdict {
    /// This one.
    Named {
        /// The judge.
        judge: Judge,
    },
    /// None of these: the best does not explain the answers.
    NoneFits,
    /// The answers do not say; the criteria that are not met say why.
    NotDecided,
}

/// Which judge answers show.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Which {
    /// How many answers there are.
    pub answers: usize,
    /// The participants.
    pub participants: Vec<String>,
    /// The judges, the most probable first.
    pub judges: Vec<JudgeFit>,
    /// Whether the first of them explains the answers.
    pub fit: Vec<Criterion<FitCriterion>>,
    /// The rules of the verdict.
    pub criteria: Vec<Criterion<VerdictCriterion>>,
    /// The verdict.
    pub verdict: Verdict,
}

/// Which of the judges `answers` show. Parameters that are not free are those of `touch`; free ones are sought within `bounds` by
/// maximum likelihood over all answers.
///
/// A judge is named where its Akaike weight is at least 0.99, it predicts participants who were held out better than every other
/// on average, no free parameter lies at a bound, and the fit is not refuted. Where the best judge's fit is
/// refuted, none of them fits.
///
/// Source: H. Akaike (1974), IEEE Trans. Autom. Control 19:716; C. M. Hurvich and C.-L. Tsai (1989), Biometrika 76:297;
/// docs/decisions/twin.md.
///
/// # Errors
/// [`JudgeError`] where there are no answers, or one of them cannot be judged.
pub fn which_judge(answers: &Answers, touch: &Touch, bounds: Bounds) -> Result<Which, JudgeError> {
    bounds.checked()?;
    touch.checked()?;
    if answers.is_empty() {
        return Err(JudgeError::NoAnswers);
    }
    for (place, choice) in answers.choices.iter().enumerate() {
        if choice.chosen >= choice.alternatives.len() {
            return Err(JudgeError::Answers {
                why: format!(
                    "answer {place} chose place {} of {} alternatives",
                    choice.chosen,
                    choice.alternatives.len()
                ),
            });
        }
    }
    let people = answers.people();
    let who: Vec<usize> = answers
        .participants()
        .map(|name| people.iter().position(|other| *other == name).unwrap_or(0))
        .collect();
    let mut judges = Vec::new();
    for judge in Judge::ALL {
        let surface = Surface::of(judge, answers, touch, bounds)?;
        let best = surface.best(|_| true);
        judges.push((
            fitted(judge, &surface, &best, &who, people.len()),
            surface,
            best,
        ));
    }
    let least = judges
        .iter()
        .map(|j| j.0.aicc)
        .fold(f64::INFINITY, f64::min);
    let relative = |aicc: f64| (-0.5 * (aicc - least)).exp();
    let sum: f64 = judges.iter().map(|j| relative(j.0.aicc)).sum();
    for (fit, ..) in &mut judges {
        fit.weight = relative(fit.aicc) / sum;
    }
    judges.sort_by(|a, b| a.0.aicc.total_cmp(&b.0.aicc));
    let person = judges[0].1.person(&judges[0].2, touch);
    let fit = fit::fit(&person, answers)?;
    let judges: Vec<JudgeFit> = judges.into_iter().map(|(fit, ..)| fit).collect();
    let criteria = criteria(&judges, &fit, bounds);
    Ok(Which {
        answers: answers.len(),
        participants: people.into_iter().cloned().collect(),
        verdict: verdict(&judges[0], &criteria),
        judges,
        fit,
        criteria,
    })
}

fn fitted(judge: Judge, surface: &Surface, best: &Best, who: &[usize], people: usize) -> JudgeFit {
    let parameters = surface.parameters(best);
    let (n, k) = (who.len() as f64, parameters.free() as f64);
    let small = match n - k - 1.0 {
        rest if rest > 0.0 => 2.0 * k * (k + 1.0) / rest,
        _ => f64::INFINITY,
    };
    let held_out = (0..people).map(|one| {
        let others = surface.best(|i| who[i] != one);
        let logs = surface.logs(&others);
        let own = logs.iter().zip(who).filter(|(_, who)| **who == one);
        mean(&own.map(|(log, _)| *log).collect::<Vec<f64>>())
    });
    JudgeFit {
        judge,
        log_likelihood: best.log_likelihood,
        aicc: 2.0 * k - 2.0 * best.log_likelihood + if k > 0.0 { small } else { 0.0 },
        weight: 0.0,
        held_out: held_out.collect(),
        parameters,
    }
}

fn criteria(
    judges: &[JudgeFit],
    fit: &[Criterion<FitCriterion>],
    bounds: Bounds,
) -> Vec<Criterion<VerdictCriterion>> {
    use VerdictCriterion as V;
    let best = &judges[0];
    let people = Limit::at_least(MIN_PEOPLE as f64);
    let enough = best.held_out.len() >= MIN_PEOPLE;
    let mut all = vec![
        Criterion::new(
            V::Participants,
            "",
            best.held_out.len() as f64,
            None,
            people,
        ),
        Criterion::new(
            V::Weight,
            "",
            best.weight,
            None,
            Limit::at_least(NAMED_WEIGHT),
        ),
    ];
    for other in &judges[1..] {
        let what = V::HeldOut { than: other.judge };
        let better: Vec<f64> = best
            .held_out
            .iter()
            .zip(&other.held_out)
            .map(|(best, other)| best - other)
            .collect();
        let limit = Limit::at_least(0.0);
        all.push(
            match (
                mean_interval(&better),
                t_quantile(better.len().saturating_sub(1)),
            ) {
                (Some([low, high]), Some(quantile)) if enough && high > low => {
                    let error = 0.5 * (high - low) / quantile;
                    Criterion::new(what, "", mean(&better) / error, None, limit)
                }
                _ => Criterion::unmeasured(what, "", limit),
            },
        );
    }
    let Parameters {
        noise_ratio,
        spectrum_weight,
        lapse_share,
    } = best.parameters;
    // No lapses at all is no bound that stops anything.
    let at_bounds = [
        noise_ratio.is_some_and(|x| at_bound(x, bounds.noise_ratio)),
        spectrum_weight.is_some_and(|x| at_bound(x, bounds.spectrum_weight)),
        lapse_share.is_some_and(|x| x > 0.0 && at_bound(x, bounds.lapse_share)),
    ];
    let count = |of: &[bool]| of.iter().filter(|is| **is).count() as f64;
    let none = Limit::at_most(0.0);
    all.push(Criterion::new(
        V::AtBounds,
        "",
        count(&at_bounds),
        None,
        none,
    ));
    let misfits: Vec<bool> = fit
        .iter()
        .map(|criterion| criterion.outcome == Outcome::NotMet)
        .collect();
    all.push(Criterion::new(V::Misfits, "", count(&misfits), None, none));
    all
}

fn at_bound(found: f64, [low, high]: [f64; 2]) -> bool {
    found <= low * (1.0 + 1e-9) || found >= high * (1.0 - 1e-9)
}

fn verdict(best: &JudgeFit, criteria: &[Criterion<VerdictCriterion>]) -> Verdict {
    let outcome = |what: VerdictCriterion| {
        let found = criteria.iter().find(|criterion| criterion.what == what);
        found.map_or(Outcome::NotDecided, |criterion| criterion.outcome)
    };
    if outcome(VerdictCriterion::Misfits) == Outcome::NotMet {
        return Verdict::NoneFits;
    }
    match Outcome::of_all(criteria.iter().map(|criterion| criterion.outcome)) {
        Outcome::Met => Verdict::Named { judge: best.judge },
        _ => Verdict::NotDecided,
    }
}
