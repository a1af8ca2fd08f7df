//! The experimenter's password on a network. Only its hash is kept.

use std::sync::{Mutex, PoisonError};

use argon2::Argon2;
use argon2::password_hash::phc::PasswordHash;
use argon2::password_hash::{PasswordHasher as _, PasswordVerifier as _};
use piezotact_people::campaign::text::{SecretError, check_secret};

/// The most bytes.
const LONGEST: usize = 1024;

/// A password that is not accepted.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PasswordError {
    /// Too easy to guess.
    #[error("the password: {0}")]
    Weak(#[from] SecretError),
    /// Too long to be typed.
    #[error("expected a password of at most 1024 bytes")]
    Long,
    /// The text is no hash of a password.
    #[error(
        "expected the hash of a password (Argon2), found something else; delete it, and set a password again"
    )]
    NoHash,
    /// No random numbers, or no memory.
    #[error("the password could not be hashed: {0}; try again")]
    NotHashed(String),
}

/// The hash of a password: Argon2id, as a PHC string.
#[derive(Debug)]
pub struct Password {
    phc: String,
    /// One check at a time: each takes 19 MiB.
    one: Mutex<()>,
}

impl Password {
    /// The hash of a new password.
    ///
    /// # Errors
    /// [`PasswordError`].
    pub fn new(password: &str) -> Result<Self, PasswordError> {
        check_secret(password)?;
        if password.len() > LONGEST {
            return Err(PasswordError::Long);
        }
        let hash = Argon2::default().hash_password(password.as_bytes());
        let hash = hash.map_err(|error| PasswordError::NotHashed(error.to_string()))?;
        Self::of_hash(&hash.to_string())
    }

    /// The password with the hash `phc`.
    ///
    /// # Errors
    /// [`PasswordError::NoHash`].
    pub fn of_hash(phc: &str) -> Result<Self, PasswordError> {
        let phc = phc.trim();
        let hash = PasswordHash::new(phc).map_err(|_error| PasswordError::NoHash)?;
        match hash.algorithm.as_str() {
            "argon2id" => Ok(Self {
                phc: phc.to_owned(),
                one: Mutex::new(()),
            }),
            _ => Err(PasswordError::NoHash),
        }
    }

    /// Its hash, to be kept.
    #[must_use]
    pub fn hash(&self) -> &str {
        &self.phc
    }

    /// Whether it is `given`. Takes a tenth of a second and more.
    #[must_use]
    pub fn is(&self, given: &str) -> bool {
        if given.len() > LONGEST {
            return false;
        }
        let _one = self.one.lock().unwrap_or_else(PoisonError::into_inner);
        PasswordHash::new(&self.phc).is_ok_and(|hash| {
            Argon2::default()
                .verify_password(given.as_bytes(), &hash)
                .is_ok()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_password_is_known_by_its_hash_alone() {
        let password = Password::new("four words of wood").unwrap();
        assert!(!password.hash().contains("wood"));
        let kept = Password::of_hash(&format!("{}\n", password.hash())).unwrap();
        assert!(kept.is("four words of wood"));
        assert!(!kept.is("four words of woo"));
        assert!(!kept.is(""));
        assert!(!kept.is(&"w".repeat(1 << 20)));
        let same = Password::new("four words of wood").unwrap();
        assert_ne!(password.hash(), same.hash(), "each has its own salt");
    }

    #[test]
    fn short_passwords_and_foreign_hashes_are_refused() {
        let short = Password::new("éàü éàü éàü").unwrap_err();
        assert_eq!(short, PasswordError::Weak(SecretError::Short { found: 11 }));
        for (even, found) in [("            ", 1), ("abcdabcdabcdabcd", 4)] {
            let refused = Password::new(even).unwrap_err();
            assert_eq!(
                refused,
                PasswordError::Weak(SecretError::Even { found }),
                "{even}"
            );
        }
        for phc in [
            "",
            "four words of wood",
            "$argon2id$",
            "$2b$12$abcdefghijklmnopqrstuv",
        ] {
            assert_eq!(
                Password::of_hash(phc).unwrap_err(),
                PasswordError::NoHash,
                "{phc}"
            );
        }
    }
}
