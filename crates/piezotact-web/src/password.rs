//! The experimenter's password on a network. Only its hash is kept.

use crate::WebError;
use std::sync::{Mutex, PoisonError};

use argon2::password_hash::phc::{Output, ParamsString, PasswordHash, Salt};
use argon2::{ARGON2ID_IDENT, Algorithm, Argon2, Block, Params, Version};
use piezotact_people::campaign::text::check_secret;

/// The most bytes.
const LONGEST: usize = 1024;
/// The size of the memory block of a hash, in bytes; a hash uses 19 MiB of it. glibc keeps freed blocks of up to 32 MiB in each thread;
/// a larger block is returned to the system when the hash is done.
const LARGE: usize = 33 << 20;

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
    /// [`WebError`].
    pub fn new(password: &str) -> Result<Self, WebError> {
        check_secret(password)?;
        if password.len() > LONGEST {
            return Err(WebError::Long);
        }
        let failed = |error: &dyn std::fmt::Display| WebError::NotHashed(error.to_string());
        let mut salt = [0; Salt::RECOMMENDED_LENGTH];
        getrandom::fill(&mut salt).map_err(|error| failed(&error))?;
        let argon = Argon2::default();
        let output = output(&argon, (password, &salt), Params::DEFAULT_OUTPUT_LEN);
        let params = ParamsString::try_from(argon.params());
        let hash = PasswordHash {
            algorithm: ARGON2ID_IDENT,
            version: Some(Version::default().into()),
            params: params.map_err(|error| failed(&error))?,
            salt: Some(Salt::new(&salt).map_err(|error| failed(&error))?),
            hash: Some(output.map_err(|error| failed(&error))?),
        };
        Self::of_hash(&hash.to_string())
    }

    /// The password with the hash `phc`.
    ///
    /// # Errors
    /// [`WebError::NoHash`].
    pub fn of_hash(phc: &str) -> Result<Self, WebError> {
        let phc = phc.trim();
        let hash = PasswordHash::new(phc).map_err(|_error| WebError::NoHash)?;
        match hash.algorithm.as_str() {
            "argon2id" => Ok(Self {
                phc: phc.to_owned(),
                one: Mutex::new(()),
            }),
            _ => Err(WebError::NoHash),
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
        is_of(given, &self.phc).unwrap_or_default()
    }
}

/// Whether `given` has the hash `phc`; `None` of a hash that cannot be made again.
fn is_of(given: &str, phc: &str) -> Option<bool> {
    let hash = PasswordHash::new(phc).ok()?;
    let (salt, own) = (hash.salt?, hash.hash?);
    let version = hash
        .version
        .map_or(Ok(Version::default()), Version::try_from);
    let params = Params::try_from(&hash).ok()?;
    let argon = Argon2::new(Algorithm::Argon2id, version.ok()?, params);
    let found = output(&argon, (given, &salt), own.len()).ok()?;
    Some(found == own)
}

/// The hash of a password with its salt, in `len` bytes.
fn output(
    argon: &Argon2<'_>,
    (password, salt): (&str, &[u8]),
    len: usize,
) -> Result<Output, String> {
    let blocks = argon.params().block_count();
    let mut memory: Vec<Block> = Vec::new();
    let reserved = memory.try_reserve_exact(blocks.max(LARGE / Block::SIZE));
    reserved.map_err(|error| error.to_string())?;
    memory.resize(blocks, Block::new());
    let mut bytes = vec![0; len];
    argon
        .hash_password_into_with_memory(password.as_bytes(), salt, &mut bytes, memory)
        .map_err(|error| error.to_string())?;
    Output::new(&bytes).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use argon2::password_hash::{PasswordHasher as _, PasswordVerifier as _};
    use piezotact_people::campaign::text::TextError;

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
        // As it was made by `argon2` itself, which studies keep.
        let hash = Argon2::default().hash_password(b"four words of wood");
        let kept = Password::of_hash(&hash.unwrap().to_string()).unwrap();
        assert!(kept.is("four words of wood"));
        assert!(!kept.is("four words of iron"));
        let theirs = PasswordHash::new(password.hash()).unwrap();
        let verified = Argon2::default().verify_password(b"four words of wood", &theirs);
        assert!(verified.is_ok(), "{verified:?}");
    }

    #[test]
    fn short_passwords_and_foreign_hashes_are_refused() {
        let short = Password::new("éàü éàü éàü").unwrap_err();
        assert_eq!(short, WebError::Weak(TextError::Short { found: 11 }));
        for (even, found) in [("            ", 1), ("abcdabcdabcdabcd", 4)] {
            let refused = Password::new(even).unwrap_err();
            assert_eq!(refused, WebError::Weak(TextError::Even { found }), "{even}");
        }
        for phc in [
            "",
            "four words of wood",
            "$argon2id$",
            "$2b$12$abcdefghijklmnopqrstuv",
        ] {
            assert_eq!(
                Password::of_hash(phc).unwrap_err(),
                WebError::NoHash,
                "{phc}"
            );
        }
    }
}
