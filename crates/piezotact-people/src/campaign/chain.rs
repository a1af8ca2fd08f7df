//! The chain of checksums over the events of a session: a changed, removed or exchanged event is found.
//!
//! Each event has a salt of its own. The chain holds the SHA-256 of salt and payload, not the payload: where payload and salt are
//! erased after a withdrawal, the chain still verifies, and nobody can try out which payload gives the checksum.

use crate::campaign::store::StoreError;
use std::fmt;

use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

/// A SHA-256. In files 64 hexadecimal digits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(try_from = "String", into = "String")]
#[cfg_attr(feature = "schemas", schemars(with = "String"))]
pub struct Sha([u8; 32]);

impl Sha {
    /// The SHA-256 of `bytes`.
    #[must_use]
    pub fn of(bytes: &[u8]) -> Self {
        Self(Sha256::digest(bytes).into())
    }

    /// The SHA-256 of several parts, each behind its length as 8 bytes, so that no two lists of parts have the same.
    #[must_use]
    pub fn of_parts(parts: &[&[u8]]) -> Self {
        let mut sum = Sha256::new();
        for part in parts {
            sum.update((part.len() as u64).to_le_bytes());
            sum.update(part);
        }
        Self(sum.finalize().into())
    }

    /// Its 32 bytes.
    #[must_use]
    pub fn bytes(&self) -> &[u8; 32] {
        &self.0
    }
}

impl fmt::Display for Sha {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl From<Sha> for String {
    fn from(sum: Sha) -> Self {
        sum.to_string()
    }
}

/// A text that is no SHA-256.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "expected the 64 hexadecimal digits of a SHA-256, found `{found}`; copy the whole checksum"
)]
pub struct NoSha {
    found: String,
}

impl TryFrom<String> for Sha {
    type Error = NoSha;

    fn try_from(text: String) -> Result<Self, NoSha> {
        let digit = |byte: u8| char::from(byte).to_digit(16);
        let mut bytes = [0; 32];
        let mut pairs = text.as_bytes().chunks_exact(2);
        let fits = text.len() == 64
            && bytes.iter_mut().zip(&mut pairs).all(|(byte, pair)| {
                match (digit(pair[0]), digit(pair[1])) {
                    (Some(high), Some(low)) => {
                        *byte = (high * 16 + low) as u8;
                        true
                    }
                    _ => false,
                }
            });
        match fits {
            true => Ok(Self(bytes)),
            false => Err(NoSha { found: text }),
        }
    }
}

/// The salt of one event, from the operating system's entropy.
pub type Salt = [u8; 16];

/// What an event holds beside its place in the chain; gone after a withdrawal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Payload {
    /// The event as JSON.
    pub json: String,
    pub salt: Salt,
}

impl Payload {
    /// The checksum that the chain holds.
    #[must_use]
    pub fn sha(&self) -> Sha {
        Sha::of_parts(&[&self.salt, self.json.as_bytes()])
    }
}

/// One event in the chain of its session.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Link {
    /// Its number in the session, from 0 without gaps.
    pub number: u64,
    /// When it was stored, in milliseconds since 1970-01-01 00:00 UTC, by the clock of the computer.
    pub at_ms: i64,
    /// The checksum of payload and salt.
    pub payload_sha: Sha,
    /// The checksum of this link and all before it.
    pub sha: Sha,
    /// The payload, unless it was erased.
    pub payload: Option<Payload>,
}

/// The checksum before the first event of a session: it names the session, so that chains cannot be exchanged.
#[must_use]
fn root(participant: &str, session: &str) -> Sha {
    Sha::of_parts(&[
        b"piezotact session",
        participant.as_bytes(),
        session.as_bytes(),
    ])
}

fn link_sha(before: Sha, number: u64, at_ms: i64, payload_sha: Sha) -> Sha {
    Sha::of_parts(&[
        before.bytes(),
        &number.to_le_bytes(),
        &at_ms.to_le_bytes(),
        payload_sha.bytes(),
    ])
}

/// The link behind `chain` that holds `payload`.
///
/// Source: Haber and Stornetta 1991, J. Cryptology 3:99; docs/decisions/store.md.
#[must_use]
pub fn next_link(
    (participant, session): (&str, &str),
    last: Option<&Link>,
    at_ms: i64,
    payload: Payload,
) -> Link {
    let number = last.map_or(0, |link| link.number + 1);
    let before = last.map_or_else(|| root(participant, session), |link| link.sha);
    let payload_sha = payload.sha();
    Link {
        number,
        at_ms,
        payload_sha,
        sha: link_sha(before, number, at_ms, payload_sha),
        payload: Some(payload),
    }
}

/// Verifies the chain of a session; erased payloads are accepted, as the chain does not need them.
///
/// # Errors
/// [`StoreError`] with the first event that does not fit.
///
/// Source: docs/decisions/store.md.
pub fn verify<'a>(
    (participant, session): (&str, &str),
    links: impl IntoIterator<Item = &'a Link>,
) -> Result<(), StoreError> {
    let (participant_name, session_name) = (participant.to_owned(), session.to_owned());
    let mut before = root(participant, session);
    for (expected, link) in (0..).zip(links) {
        if link.number != expected {
            return Err(StoreError::Gap {
                participant: participant_name,
                session: session_name,
                expected,
                found: link.number,
            });
        }
        if link
            .payload
            .as_ref()
            .is_some_and(|payload| payload.sha() != link.payload_sha)
        {
            return Err(StoreError::Changed {
                participant: participant_name,
                session: session_name,
                number: link.number,
            });
        }
        if link_sha(before, link.number, link.at_ms, link.payload_sha) != link.sha {
            return Err(StoreError::Broken {
                participant: participant_name,
                session: session_name,
                number: link.number,
            });
        }
        before = link.sha;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const KEY: (&str, &str) = ("P01", "discrimination");

    fn chain(count: u8) -> Vec<Link> {
        let mut links: Vec<Link> = Vec::new();
        for i in 0..count {
            let payload = Payload {
                json: format!("{{\"answer\":{i}}}"),
                salt: [i; 16],
            };
            let link = next_link(KEY, links.last(), 1_000 + i64::from(i), payload);
            links.push(link);
        }
        links
    }

    #[test]
    fn the_sha_is_the_published_one_and_reads_back() {
        // FIPS 180-4, example "abc".
        let sum = Sha::of(b"abc");
        assert_eq!(
            sum.to_string(),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
        assert_eq!(Sha::try_from(sum.to_string()), Ok(sum));
        assert!(Sha::try_from("ba78".to_owned()).is_err());
        assert!(Sha::try_from("é".repeat(32)).is_err());
    }

    #[test]
    fn a_chain_verifies_and_still_does_when_payloads_are_erased() {
        let mut links = chain(5);
        assert_eq!(verify(KEY, &links), Ok(()));
        for link in &mut links {
            link.payload = None;
        }
        assert_eq!(verify(KEY, &links), Ok(()));
    }

    #[test]
    fn every_flipped_bit_of_a_payload_is_found() {
        let links = chain(3);
        let length = links[1].payload.as_ref().unwrap().json.len();
        for bit in 0..7 * length {
            let mut changed = links.clone();
            let payload = changed[1].payload.as_mut().unwrap();
            let mut bytes = payload.json.clone().into_bytes();
            bytes[bit / 7] ^= 1 << (bit % 7);
            payload.json = String::from_utf8(bytes).unwrap();
            assert!(verify(KEY, &changed).is_err(), "bit {bit}");
        }
    }

    #[test]
    fn a_removed_exchanged_or_redated_event_is_found() {
        let links = chain(4);
        let without: Vec<&Link> = links.iter().filter(|link| link.number != 1).collect();
        assert!(matches!(
            verify(KEY, without),
            Err(StoreError::Gap {
                expected: 1,
                found: 2,
                ..
            })
        ));
        let mut redated = links.clone();
        redated[2].at_ms += 1;
        assert!(matches!(
            verify(KEY, &redated),
            Err(StoreError::Broken { number: 2, .. })
        ));
        assert!(matches!(
            verify(("P02", "discrimination"), &links),
            Err(StoreError::Broken { number: 0, .. })
        ));
    }
}
