//! A list of warnings without duplicates.

use std::ops::Deref;

use serde::{Deserialize, Serialize};

use super::{Merged, Warning, merged};

/// A list of warnings without duplicates: a warning equal to one already in the list is not added.
/// Its written form has those of one kind as one.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(
    feature = "schemas",
    derive(schemars::JsonSchema),
    schemars(with = "Vec<Merged>")
)]
#[serde(into = "Vec<Merged>", from = "Vec<Warning>")]
pub struct Warnings(Vec<Warning>);

impl Warnings {
    /// No warnings.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a warning that is not yet in the list.
    pub fn push(&mut self, warning: impl Into<Warning>) {
        let warning = warning.into();
        if !self.0.iter().any(|known| known.is_equivalent_to(&warning)) {
            self.0.push(warning);
        }
    }

    /// Inserts `first` before the others, without duplicates.
    pub fn put_first(&mut self, first: impl IntoIterator<Item = Warning>) {
        let later = std::mem::replace(self, first.into_iter().collect());
        self.extend(later);
    }

    /// Merges warnings of one kind into one.
    ///
    /// Source: docs/decisions/house.md.
    #[must_use]
    pub fn merged(&self) -> Vec<Merged> {
        merged(&self.0)
    }
}

impl From<Warnings> for Vec<Merged> {
    fn from(warnings: Warnings) -> Self {
        warnings.merged()
    }
}

impl From<Vec<Warning>> for Warnings {
    fn from(warnings: Vec<Warning>) -> Self {
        Self(warnings)
    }
}

impl From<Warnings> for Vec<Warning> {
    fn from(warnings: Warnings) -> Self {
        warnings.0
    }
}

impl Deref for Warnings {
    type Target = [Warning];

    fn deref(&self) -> &[Warning] {
        &self.0
    }
}

impl<D: Into<Warning>> Extend<D> for Warnings {
    fn extend<I: IntoIterator<Item = D>>(&mut self, warnings: I) {
        for warning in warnings {
            self.push(warning);
        }
    }
}

impl<D: Into<Warning>> FromIterator<D> for Warnings {
    fn from_iter<I: IntoIterator<Item = D>>(warnings: I) -> Self {
        let mut all = Self::new();
        all.extend(warnings);
        all
    }
}

impl IntoIterator for Warnings {
    type Item = Warning;
    type IntoIter = std::vec::IntoIter<Warning>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter()
    }
}

impl<'a> IntoIterator for &'a Warnings {
    type Item = &'a Warning;
    type IntoIter = std::slice::Iter<'a, Warning>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter()
    }
}

/// Those of `stored` of which `fresh` has none of the same code: what was found again is not said twice, and nothing else goes.
pub(crate) fn not_found_again(stored: &[Warning], fresh: &[Warning]) -> Vec<Warning> {
    let is_again = |warning: &Warning| fresh.iter().any(|found| found.code == warning.code);
    let others = stored.iter().filter(|warning| !is_again(warning));
    others.cloned().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::panel::PanelWarning;
    use crate::quantity::{Band, Hertz};
    use crate::transfer::TransferWarning;

    fn low_coherence(share: f64) -> Warning {
        let (asked, lowest, at_hz) = (0.8, 0.3, 25.0);
        Warning::from(TransferWarning::LowCoherence {
            asked,
            lowest,
            at_hz,
            share,
        })
    }

    /// A doubt that is not found again stays: that of a member of an average whose own coherence is high, and one about the band of
    /// the estimate where nothing is found in that of a rendering.
    #[test]
    fn only_what_is_found_again_is_left_out() {
        let of_member = Warning::from(PanelWarning::OfMembers {
            count: 1,
            of: 4,
            measurement: "P03 at 20°, 0.2 N".to_owned().into(),
            example: low_coherence(0.5),
        });
        let stored = [low_coherence(0.5), of_member.clone()];
        assert_eq!(not_found_again(&stored, &[]), stored);
        let bands = vec![Band::new(Hertz(10.0), Hertz(20.0)).unwrap()];
        let other = Warning::from(TransferWarning::NotExcited { bands, share: 0.1 });
        assert_eq!(not_found_again(&stored, &[other]), stored);
        assert_eq!(not_found_again(&stored, &[low_coherence(0.2)]), [of_member]);
    }
}
