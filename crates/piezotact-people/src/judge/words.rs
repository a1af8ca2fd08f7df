//! Which judge it was, in one sentence.

use piezotact::criterion::{Criterion, Outcome};

use super::which::{MIN_PEOPLE, NAMED_WEIGHT, Verdict, VerdictCriterion, Which};

impl Which {
    /// The verdict with what it rests on.
    #[must_use]
    pub fn sentence(&self) -> String {
        let people = self.participants.len();
        let of = match people {
            1 => format!("{} answers of 1 participant", self.answers),
            _ => format!("{} answers of {people} participants", self.answers),
        };
        let best = self.judges.first();
        let (name, weight) = best.map_or(("none", 0.0), |fit| (fit.judge.name(), fit.weight));
        match self.verdict {
            Verdict::Named { judge } => format!(
                "{of} show the judge {} (Akaike weight {weight:.3}; it also predicts participants who were held out better than every \
                 other)",
                judge.name()
            ),
            Verdict::NoneFits => format!(
                "none of the judges explains {of}: {name} is the most probable of them, and its fit is refuted"
            ),
            Verdict::NotDecided => format!(
                "{of} do not decide which judge it was: {name} is the most probable (Akaike weight {weight:.3}), but {}",
                self.open().join("; ")
            ),
        }
    }

    /// What keeps the verdict open.
    fn open(&self) -> Vec<String> {
        let is_open = |criterion: &&Criterion<VerdictCriterion>| criterion.outcome != Outcome::Met;
        let few = self.criteria.iter().filter(is_open);
        let mut few = few.filter(|criterion| criterion.what == VerdictCriterion::Participants);
        if few.next().is_some() {
            return vec![format!(
                "fewer than {MIN_PEOPLE} participants decide nothing"
            )];
        }
        let open = self.criteria.iter();
        let open = open.filter(is_open);
        open.map(|criterion| {
            let found = criterion.found.unwrap_or(f64::NAN);
            match criterion.what {
                VerdictCriterion::Participants => format!("there are only {found} participants"),
                VerdictCriterion::Weight => {
                    format!("a weight of {NAMED_WEIGHT} is needed")
                }
                VerdictCriterion::HeldOut { than } => format!(
                    "it does not predict participants who were held out surely better than {} does",
                    than.name()
                ),
                VerdictCriterion::AtBounds => {
                    "a fitted parameter lies at the limit of its search range".to_owned()
                }
                VerdictCriterion::Misfits => "its fit is questionable".to_owned(),
            }
        })
        .collect()
    }
}
