//! Who may do what: codes that let a page in once or as long as the program runs, and the marks by which it is known afterwards.
//!
//! A page that entered a code gets a random mark as a cookie. Only its checksum is kept, in a file of the study, so that pages go on after
//! the program was started again. A page sends a second mark, derived from the first, with every request that changes something: another
//! site that makes the browser send the cookie does not know it.

use crate::WebError;
use std::fmt;
use std::net::IpAddr;
use std::sync::{Mutex, MutexGuard, PoisonError};

use piezotact_people::campaign::chain::Sha;
use serde::{Deserialize, Serialize};

use crate::password::Password;
use crate::tries::{Network, Queue, Tried, Tries, Turn};

/// The most pages of a role that are known at once.
const MOST_PAGES: usize = 32;
/// A page is known so long, in ms: a day, as its cookie.
const PAGE_MS: i64 = 24 * 3600 * 1000;
/// A participant's code is valid so long, in ms: a quarter of an hour.
const CODE_MS: i64 = 15 * 60 * 1000;
/// Letters and digits that are not taken for each other.
const ALPHABET: &[u8; 31] = b"abcdefghjkmnpqrstuvwxyz23456789";

/// Who a page is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// Leads the session.
    Experimenter,
    /// Feels and answers.
    Participant,
    /// Looks at it, as the experimenter sees it, and changes nothing.
    Viewer,
}

/// The pages that were let in, by the checksums of their marks.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Pages {
    /// The session that they belong to.
    session: String,
    /// The checksum of the password's hash with which the experimenter enters; pages let in with another one are known no more.
    password: Option<Sha>,
    pages: Vec<Known>,
}

/// A page that was let in.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Known {
    role: Role,
    mark: Sha,
    /// When it was let in, in ms since 1970-01-01 00:00 UTC.
    at_ms: i64,
}

impl Known {
    fn is_at(&self, now_ms: i64) -> bool {
        now_ms.saturating_sub(self.at_ms) < PAGE_MS
    }
}

/// Codes that are valid now.
#[derive(Clone, Debug, Default)]
struct Codes {
    /// None where a password is asked for.
    experimenter: Option<String>,
    viewer: String,
    /// Valid once, and for a quarter of an hour after the time at its side, in ms.
    participant: Option<(String, i64)>,
}

impl Codes {
    /// The participant's code that is valid at `now_ms`.
    fn of_participant(&self, now_ms: i64) -> Option<&str> {
        let (code, at_ms) = self.participant.as_ref()?;
        (now_ms.saturating_sub(*at_ms) < CODE_MS).then_some(code)
    }

    /// Whom `given` lets in at `now_ms`. A participant's code is used up.
    fn role_of(&mut self, given: &str, now_ms: i64) -> Option<Role> {
        if self
            .experimenter
            .as_deref()
            .is_some_and(|code| same(given, code))
        {
            return Some(Role::Experimenter);
        }
        if same(given, &self.viewer) {
            return Some(Role::Viewer);
        }
        let code = self.of_participant(now_ms);
        let is_it = code.is_some_and(|code| same(given, code));
        is_it.then(|| {
            self.participant = None;
            Role::Participant
        })
    }
}

/// What a page is let in with.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Key<'a> {
    /// A code.
    Code(&'a str),
    /// The experimenter's password.
    Password(&'a str),
}

impl Key<'_> {
    fn tried(self) -> Tried {
        match self {
            Self::Code(_) => Tried::Code,
            Self::Password(_) => Tried::Password,
        }
    }
}

impl fmt::Debug for Key<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // What is secret stays out of messages.
        f.write_str(match self {
            Self::Code(_) => "Code",
            Self::Password(_) => "Password",
        })
    }
}

/// Keeps the marks of pages, as JSON, where they are found after a restart.
pub type KeepPages = Box<dyn Fn(&str) -> Result<(), String> + Send + Sync>;

/// Who is let in.
pub struct Access {
    pages: Mutex<Pages>,
    codes: Mutex<Codes>,
    tries: Mutex<Tries>,
    queue: Queue,
    password: Option<Password>,
    keep: KeepPages,
}

impl fmt::Debug for Access {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Access").finish_non_exhaustive()
    }
}

impl Access {
    /// Whether `kept` is a list of pages that were let in.
    #[must_use]
    pub fn reads(kept: &str) -> bool {
        serde_json::from_str::<Pages>(kept).is_ok()
    }

    /// Lets in whom `kept` names for the session named `session`, and whoever has one of the new codes.
    ///
    /// # Errors
    /// [`WebError::NotKept`] without random numbers.
    pub fn new(session: &str, kept: Option<&str>, keep: KeepPages) -> Result<Self, WebError> {
        let known: Option<Pages> = kept.and_then(|kept| serde_json::from_str(kept).ok());
        // Pages of another session stay outside.
        let known = known.filter(|pages| pages.session == session);
        let pages = known.unwrap_or_else(|| Pages {
            session: session.to_owned(),
            password: None,
            pages: Vec::new(),
        });
        Ok(Self {
            pages: Mutex::new(pages),
            codes: Mutex::new(Codes {
                experimenter: Some(code()?),
                viewer: code()?,
                participant: None,
            }),
            tries: Mutex::default(),
            queue: Queue::default(),
            password: None,
            keep,
        })
    }

    /// The same, where the experimenter is let in by `password` alone, as on a network. Pages that were let in where another password was
    /// asked for, or none, are known no more.
    #[must_use]
    pub fn with_password(mut self, password: Password) -> Self {
        let own = Some(Sha::of(password.hash().as_bytes()));
        let mut pages = locked(&self.pages);
        if pages.password != own {
            pages.pages.clear();
            pages.password = own;
        }
        drop(pages);
        self.password = Some(password);
        locked(&self.codes).experimenter = None;
        self
    }

    /// Whether the experimenter is let in by a password.
    pub(crate) fn has_password(&self) -> bool {
        self.password.is_some()
    }

    /// The code of `role` that is valid at `now_ms`; none of a participant before one was made, and of the experimenter where there is a
    /// password.
    #[must_use]
    pub fn code(&self, role: Role, now_ms: i64) -> Option<String> {
        let codes = locked(&self.codes);
        match role {
            Role::Experimenter => codes.experimenter.clone(),
            Role::Viewer => Some(codes.viewer.clone()),
            Role::Participant => codes.of_participant(now_ms).map(str::to_owned),
        }
    }

    /// The name of the cookie of `role`: one browser may hold pages of several roles, and of sessions on several ports, which share cookies.
    pub(crate) fn cookie(&self, role: Role) -> String {
        let role = match role {
            Role::Experimenter => "experimenter",
            Role::Participant => "participant",
            Role::Viewer => "viewer",
        };
        let session = Sha::of(locked(&self.pages).session.as_bytes()).to_string();
        format!("piezotact_{role}_{}", &session[..8])
    }

    /// A new code for the participant's device, valid once and for a quarter of an hour from `now_ms` on; an earlier one that was not used
    /// is valid no more.
    ///
    /// # Errors
    /// [`WebError::NotKept`] without random numbers.
    pub fn new_participant_code(&self, now_ms: i64) -> Result<String, WebError> {
        let new = code()?;
        locked(&self.codes).participant = Some((new.clone(), now_ms));
        Ok(new)
    }

    /// Whether a device of the participant is let in at `now_ms`.
    #[must_use]
    pub fn has_participant(&self, now_ms: i64) -> bool {
        let pages = locked(&self.pages);
        let mut known = pages.pages.iter();
        known.any(|page| page.role == Role::Participant && page.is_at(now_ms))
    }

    /// Lets a page at the address `from` in with `key` at `now_ms`: its role and its mark. A second device of the participant takes the
    /// place of the first. A password takes a tenth of a second and more.
    ///
    /// # Errors
    /// [`WebError`].
    pub fn enter(
        &self,
        key: Key<'_>,
        from: IpAddr,
        now_ms: i64,
    ) -> Result<(Role, String), WebError> {
        let _network = self.counts(key.tried(), from, now_ms)?;
        self.checks(key, from, now_ms)
    }

    /// Counts a try as wrong, until it is found right.
    fn counts(&self, tried: Tried, from: IpAddr, now_ms: i64) -> Result<Network, WebError> {
        let counted = locked(&self.tries).count(tried, from, now_ms);
        counted.ok_or(WebError::TooMany)
    }

    /// The turn of `from` to have a password checked, when it comes. It is counted as a wrong one.
    ///
    /// # Errors
    /// [`WebError`] at once where `from` may try none now.
    pub(crate) async fn turn(&self, from: IpAddr, now_ms: i64) -> Result<Turn, WebError> {
        let network = self.counts(Tried::Password, from, now_ms)?;
        let turn = self.queue.turn(from, network).await;
        turn.ok_or_else(|| {
            locked(&self.tries).takes_back(Tried::Password, from);
            WebError::Busy
        })
    }

    /// As [`Self::enter`], for a password whose turn it is.
    pub(crate) fn enter_in_turn(
        &self,
        password: &str,
        from: IpAddr,
        now_ms: i64,
        turn: Turn,
    ) -> Result<(Role, String), WebError> {
        let entered = self.checks(Key::Password(password), from, now_ms);
        drop(turn);
        entered
    }

    fn checks(&self, key: Key<'_>, from: IpAddr, now_ms: i64) -> Result<(Role, String), WebError> {
        let role = match key {
            Key::Code(given) => locked(&self.codes).role_of(&given.trim().to_lowercase(), now_ms),
            Key::Password(given) => {
                let is_it = self.password.as_ref().is_some_and(|own| own.is(given));
                is_it.then_some(Role::Experimenter)
            }
        };
        let role = role.ok_or(WebError::WrongCode)?;
        locked(&self.tries).takes_back(key.tried(), from);
        let mark = hex(&random::<32>()?);
        let mut pages = locked(&self.pages);
        let mut after = pages.clone();
        let is_replaced = |known: &Known| role == Role::Participant && known.role == role;
        let stays = |known: &Known| known.is_at(now_ms) && !is_replaced(known);
        after.pages.retain(stays);
        after.pages.push(Known {
            role,
            mark: Sha::of(mark.as_bytes()),
            at_ms: now_ms,
        });
        // The oldest of the same role goes: whoever looks on throws nobody else out.
        let of_role = after.pages.iter().filter(|known| known.role == role);
        if of_role.count() > MOST_PAGES
            && let Some(oldest) = after.pages.iter().position(|known| known.role == role)
        {
            after.pages.remove(oldest);
        }
        let json =
            serde_json::to_string(&after).map_err(|error| WebError::NotKept(error.to_string()))?;
        (self.keep)(&json).map_err(WebError::NotKept)?;
        *pages = after;
        Ok((role, mark))
    }

    /// The role of the page with `mark` at `now_ms`; none of one that was never let in, or longer than a day ago, or is replaced.
    #[must_use]
    pub fn role(&self, mark: &str, now_ms: i64) -> Option<Role> {
        let sha = Sha::of(mark.as_bytes());
        let pages = locked(&self.pages);
        let found = pages.pages.iter().find(|known| known.mark == sha);
        found
            .filter(|known| known.is_at(now_ms))
            .map(|known| known.role)
    }
}

/// The second mark of the page with `mark`.
pub(crate) fn second_mark(mark: &str) -> String {
    Sha::of(format!("request of {mark}").as_bytes()).to_string()
}

/// Whether `mark` is the second one of the page with the cookie `cookie`.
pub(crate) fn is_second_mark(mark: &str, cookie: &str) -> bool {
    same(mark, &second_mark(cookie))
}

/// Whether both are the same, in a time that does not say where they differ.
fn same(a: &str, b: &str) -> bool {
    a.len() == b.len()
        && a.bytes()
            .zip(b.bytes())
            .fold(0, |all, (x, y)| all | (x ^ y))
            == 0
}

fn random<const N: usize>() -> Result<[u8; N], WebError> {
    let mut bytes = [0; N];
    getrandom::fill(&mut bytes).map_err(|error| WebError::NotKept(error.to_string()))?;
    Ok(bytes)
}

/// Ten letters of 31: 2^49 codes, of which five can be tried in a minute.
fn code() -> Result<String, WebError> {
    let letters =
        random::<10>()?.map(|byte| char::from(ALPHABET[usize::from(byte) % ALPHABET.len()]));
    Ok(letters.iter().collect())
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn locked<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use std::net::Ipv4Addr;
    use std::sync::Arc;

    use super::*;
    use crate::tries::{MOST_WRONG, WINDOW_MS};

    const HERE: IpAddr = IpAddr::V4(Ipv4Addr::LOCALHOST);

    fn access(session: &str, kept: Option<&str>) -> (Access, Arc<Mutex<String>>) {
        let file = Arc::new(Mutex::new(String::new()));
        let written = Arc::clone(&file);
        let keep = Box::new(move |json: &str| {
            *locked(&written) = json.to_owned();
            Ok(())
        });
        (Access::new(session, kept, keep).unwrap(), file)
    }

    #[test]
    fn pages_are_known_after_a_restart_of_the_same_session_only() {
        let (first, file) = access("P01 discrimination", None);
        let code = first.code(Role::Experimenter, 0).unwrap();
        let (role, mark) = first
            .enter(Key::Code(&format!(" {} ", code.to_uppercase())), HERE, 0)
            .unwrap();
        assert_eq!(role, Role::Experimenter);
        let kept = locked(&file).clone();
        assert!(!kept.contains(&mark), "only its checksum is kept");
        let (again, _) = access("P01 discrimination", Some(&kept));
        assert_eq!(again.role(&mark, 0), Some(Role::Experimenter));
        let (other, _) = access("P02 discrimination", Some(&kept));
        assert_eq!(other.role(&mark, 0), None);
        // The code of an earlier start is valid no more.
        assert_eq!(
            again.enter(Key::Code(&code), HERE, 0),
            Err(WebError::WrongCode)
        );
    }

    #[test]
    fn a_code_of_a_participant_is_valid_once_and_the_last_device_counts() {
        let (access, _) = access("s", None);
        assert_eq!(access.code(Role::Participant, 0), None);
        let code = access.new_participant_code(0).unwrap();
        let (_, first) = access.enter(Key::Code(&code), HERE, 0).unwrap();
        assert_eq!(
            access.enter(Key::Code(&code), HERE, 0),
            Err(WebError::WrongCode)
        );
        let code = access.new_participant_code(0).unwrap();
        let (_, second) = access.enter(Key::Code(&code), HERE, 0).unwrap();
        assert_eq!(access.role(&first, 0), None);
        assert_eq!(access.role(&second, 0), Some(Role::Participant));
    }

    #[test]
    fn codes_cannot_be_tried_out() {
        let (access, _) = access("s", None);
        let right = access.code(Role::Experimenter, 0).unwrap();
        for _ in 0..MOST_WRONG {
            assert_eq!(
                access.enter(Key::Code("aaaaaaaaaa"), HERE, 1000),
                Err(WebError::WrongCode)
            );
        }
        assert_eq!(
            access.enter(Key::Code(&right), HERE, 2000),
            Err(WebError::TooMany)
        );
        assert!(
            access
                .enter(Key::Code(&right), HERE, 2000 + WINDOW_MS)
                .is_ok()
        );
    }

    #[test]
    fn with_a_password_the_experimenter_has_no_code() {
        let password = Password::new("four words of wood").unwrap();
        let (access, _) = access("s", None);
        let code = access.code(Role::Experimenter, 0).unwrap();
        let wrong = Err(WebError::WrongCode);
        assert_eq!(access.enter(Key::Password(""), HERE, 0), wrong);
        let access = access.with_password(password);
        assert_eq!(access.code(Role::Experimenter, 0), None);
        for key in [&code, "", "four words of wood"] {
            assert_eq!(access.enter(Key::Code(key), HERE, 0), wrong);
        }
        assert_eq!(access.enter(Key::Password("four words"), HERE, 0), wrong);
        let entered = access.enter(Key::Password("four words of wood"), HERE, WINDOW_MS + 1);
        assert_eq!(entered.unwrap().0, Role::Experimenter);
    }

    #[test]
    fn whoever_looks_on_throws_nobody_out() {
        let (access, _) = access("s", None);
        let enter = |code: &str| access.enter(Key::Code(code), HERE, 0).unwrap().1;
        let experimenter = enter(&access.code(Role::Experimenter, 0).unwrap());
        let participant = enter(&access.new_participant_code(0).unwrap());
        let code = access.code(Role::Viewer, 0).unwrap();
        let viewers: Vec<String> = (0..40).map(|_| enter(&code)).collect();
        assert_eq!(access.role(&experimenter, 0), Some(Role::Experimenter));
        assert_eq!(access.role(&participant, 0), Some(Role::Participant));
        assert_eq!(access.role(&viewers[0], 0), None);
        assert_eq!(access.role(&viewers[39], 0), Some(Role::Viewer));
    }

    #[test]
    fn pages_and_codes_of_a_participant_end_with_time() {
        let (access, _) = access("s", None);
        let code = access.new_participant_code(0).unwrap();
        assert_eq!(access.code(Role::Participant, CODE_MS), None);
        let late = access.enter(Key::Code(&code), HERE, CODE_MS);
        assert_eq!(late, Err(WebError::WrongCode));
        let (_, mark) = access.enter(Key::Code(&code), HERE, CODE_MS - 1).unwrap();
        let end = CODE_MS - 1 + PAGE_MS;
        assert_eq!(access.role(&mark, end - 1), Some(Role::Participant));
        assert!(access.has_participant(end - 1));
        assert_eq!(access.role(&mark, end), None);
        assert!(!access.has_participant(end));
    }

    #[test]
    fn a_new_password_ends_the_pages_of_the_old_one() {
        let first = Password::new("four words of wood").unwrap();
        let hash = first.hash().to_owned();
        let (before, file) = access("s", None);
        let before = before.with_password(first);
        let key = Key::Password("four words of wood");
        let (_, mark) = before.enter(key, HERE, 0).unwrap();
        let kept = locked(&file).clone();
        let with = |password| access("s", Some(&kept)).0.with_password(password);
        let same = with(Password::of_hash(&hash).unwrap());
        assert_eq!(same.role(&mark, 1), Some(Role::Experimenter));
        let other = with(Password::new("four words of iron").unwrap());
        assert_eq!(other.role(&mark, 1), None);
    }

    #[test]
    fn what_cannot_be_kept_is_not_let_in() {
        let keep = Box::new(|_: &str| Err("the disk is full".to_owned()));
        let access = Access::new("s", None, keep).unwrap();
        let code = access.code(Role::Viewer, 0).unwrap();
        let refused = access.enter(Key::Code(&code), HERE, 0).unwrap_err();
        assert!(
            refused.to_string().contains("the disk is full"),
            "{refused}"
        );
    }
}
