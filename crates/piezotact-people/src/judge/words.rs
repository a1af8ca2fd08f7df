//! Which judge it was, in one sentence.

use piezotact::criterion::Outcome;

use super::which::{Verdict, VerdictCriterion, Which};

impl Which {
    /// The verdict with what it rests on.
    #[must_use]
    pub fn sentence(&self) -> String {
        let people = self.participants.len();
        let of = format!("{} answers of {people} participants", self.answers);
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
        let open = self.criteria.iter();
        let open = open.filter(|criterion| criterion.outcome != Outcome::Met);
        open.map(|criterion| {
            let found = criterion.found.unwrap_or(f64::NAN);
            match criterion.what {
                VerdictCriterion::Participants => format!("there are only {found} participants"),
                VerdictCriterion::Weight => format!("its weight is {found:.3}"),
                VerdictCriterion::HeldOut { than } => format!(
                    "it does not predict participants who were held out surely better than {} does",
                    than.name()
                ),
                VerdictCriterion::AtBounds => {
                    "a free parameter lies at the bound within which it was sought".to_owned()
                }
                VerdictCriterion::Misfits => "its fit is doubtful".to_owned(),
            }
        })
        .collect()
    }
}
