//! A list of doubts without duplicates.

use std::ops::Deref;

use serde::{Deserialize, Serialize};

use super::{Doubt, Merged, merged};

/// A list of doubts without duplicates: a doubt with the code, subject and values of one already in the list is not added.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(transparent)]
pub struct Doubts(Vec<Doubt>);

impl Doubts {
    /// No doubts.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Whether the list contains a doubt with the code, subject and values of `doubt`.
    #[must_use]
    pub fn say(&self, doubt: &Doubt) -> bool {
        self.0.iter().any(|known| known.is_equivalent_to(doubt))
    }

    /// Adds a doubt that is not yet in the list.
    pub fn push(&mut self, doubt: impl Into<Doubt>) {
        let doubt = doubt.into();
        if !self.say(&doubt) {
            self.0.push(doubt);
        }
    }

    /// Inserts `first` before the others, without duplicates.
    pub fn put_first(&mut self, first: impl IntoIterator<Item = Doubt>) {
        let later = std::mem::replace(self, first.into_iter().collect());
        self.extend(later);
    }

    /// Keeps those for which `keep` holds.
    pub fn retain(&mut self, keep: impl FnMut(&Doubt) -> bool) {
        self.0.retain(keep);
    }

    /// Merges doubts of one kind into one.
    ///
    /// Source: decision 0030 of this project.
    #[must_use]
    pub fn merged(&self) -> Vec<Merged> {
        merged(&self.0)
    }
}

impl From<Doubts> for Vec<Doubt> {
    fn from(doubts: Doubts) -> Self {
        doubts.0
    }
}

impl Deref for Doubts {
    type Target = [Doubt];

    fn deref(&self) -> &[Doubt] {
        &self.0
    }
}

impl<D: Into<Doubt>> Extend<D> for Doubts {
    fn extend<I: IntoIterator<Item = D>>(&mut self, doubts: I) {
        for doubt in doubts {
            self.push(doubt);
        }
    }
}

impl<D: Into<Doubt>> FromIterator<D> for Doubts {
    fn from_iter<I: IntoIterator<Item = D>>(doubts: I) -> Self {
        let mut all = Self::new();
        all.extend(doubts);
        all
    }
}

impl IntoIterator for Doubts {
    type Item = Doubt;
    type IntoIter = std::vec::IntoIter<Doubt>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter()
    }
}

impl<'a> IntoIterator for &'a Doubts {
    type Item = &'a Doubt;
    type IntoIter = std::slice::Iter<'a, Doubt>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter()
    }
}
