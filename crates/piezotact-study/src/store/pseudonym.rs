//! Pseudonyms: names of participants that are names of folders on every file system.

use crate::store::error::StudyError;
use piezotact::compare::plain_name;
use std::fmt;

/// The longest pseudonym, in characters.
const LONGEST: usize = 32;

/// What Windows does not allow as a name, in any case; with a digit from 1 to 9 for the last two.
const RESERVED: [&str; 4] = ["CON", "PRN", "AUX", "NUL"];
const RESERVED_WITH_DIGIT: [&str; 2] = ["COM", "LPT"];

/// The name of a participant in a study: 1 to 32 ASCII letters, digits, `-` and `_`, not beginning with `-`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Pseudonym(String);

impl Pseudonym {
    /// The pseudonym `text`.
    ///
    /// # Errors
    /// [`StudyError::Pseudonym`], [`StudyError::PseudonymReserved`].
    pub fn new(text: &str) -> Result<Self, StudyError> {
        let allowed = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        let found = || text.to_owned();
        if text.is_empty()
            || text.len() > LONGEST
            || text.starts_with('-')
            || !text.chars().all(allowed)
        {
            return Err(StudyError::Pseudonym { found: found() });
        }
        let upper = text.to_ascii_uppercase();
        let with_digit = |name: &str| {
            let rest = upper.strip_prefix(name).map(str::as_bytes);
            matches!(rest, Some([b'1'..=b'9']))
        };
        if RESERVED.contains(&upper.as_str()) || RESERVED_WITH_DIGIT.into_iter().any(with_digit) {
            return Err(StudyError::PseudonymReserved { found: found() });
        }
        Ok(Self(text.to_owned()))
    }

    /// Checks that none of `existing` differs from it in capital letters or leading zeros only; the same name is accepted.
    ///
    /// # Errors
    /// [`StudyError::PseudonymCase`].
    pub fn check_among<'a>(
        &self,
        existing: impl IntoIterator<Item = &'a str>,
    ) -> Result<(), StudyError> {
        let own = plain_name(&self.0);
        let alike = |name: &&str| plain_name(name) == own && *name != self.0;
        match existing.into_iter().find(alike) {
            None => Ok(()),
            Some(existing) => Err(StudyError::PseudonymCase {
                found: self.0.clone(),
                existing: existing.to_owned(),
            }),
        }
    }

    /// Its text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for Pseudonym {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_folders_on_every_file_system_are_accepted_and_others_refused() {
        for good in [
            "P01",
            "a",
            "_x",
            "7",
            "A-b_9",
            "CONSTANCE",
            "COM",
            "COM0",
            "COM10",
            &"x".repeat(32),
        ] {
            assert!(Pseudonym::new(good).is_ok(), "{good}");
        }
        for bad in [
            "",
            ".",
            "..",
            "a.b",
            "a/b",
            "a\\b",
            "a b",
            "é",
            "-x",
            "a\n",
            "a\0",
            &"x".repeat(33),
        ] {
            assert!(
                matches!(Pseudonym::new(bad), Err(StudyError::Pseudonym { .. })),
                "{bad:?}"
            );
        }
        for bad in ["con", "NUL", "Aux", "prn", "com1", "LPT9"] {
            assert!(
                matches!(
                    Pseudonym::new(bad),
                    Err(StudyError::PseudonymReserved { .. })
                ),
                "{bad}"
            );
        }
    }

    #[test]
    fn a_name_that_differs_in_case_or_zeros_only_is_refused() {
        let name = Pseudonym::new("p01").unwrap();
        assert!(name.check_among(["P02", "p01"]).is_ok());
        assert!(matches!(
            name.check_among(["P02", "P01"]),
            Err(StudyError::PseudonymCase { existing, .. }) if existing == "P01"
        ));
        assert!(matches!(
            name.check_among(["P02", "P1"]),
            Err(StudyError::PseudonymCase { existing, .. }) if existing == "P1"
        ));
        assert!(name.check_among(["P10", "P001x"]).is_ok());
    }
}
