//! Group commit: one thread owns the store of a study, and stores in one transaction what waits for it.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use std::thread::JoinHandle;

use piezotact_people::campaign::chain::{Link, Salt};
use piezotact_people::campaign::store::{
    NewEvent, Purpose, SessionEntry, SessionKey, Store, StoreError,
};

use super::database::Database;
use super::sessions;
use super::store::{Changed, StudyStore};

/// How many requests one transaction takes: more wait for the next.
const MOST: usize = 512;

/// A handle to a study that many threads write to. Each request is acknowledged when the transaction that holds it is on the disk.
/// The study is closed when its last handle is dropped.
#[derive(Clone, Debug)]
pub struct GroupStore {
    owner: Arc<Owner>,
}

#[derive(Debug)]
struct Owner {
    /// `None` only while it is dropped.
    requests: Option<Sender<Request>>,
    thread: Option<JoinHandle<()>>,
}

impl Drop for Owner {
    fn drop(&mut self) {
        drop(self.requests.take());
        if let Some(thread) = self.thread.take() {
            // What went wrong in it was told to whoever asked.
            let _ended = thread.join();
        }
    }
}

/// Where an answer goes.
type Reply<T> = SyncSender<Result<T, StoreError>>;

/// A change that waits for its transaction.
enum Change {
    Begin {
        key: SessionKey,
        purpose: Purpose,
    },
    Append {
        key: SessionKey,
        known: u64,
        at_ms: i64,
        json: String,
        salt: Salt,
    },
}

/// What a change has stored: a link where it was an event.
type Done = Option<Link>;

enum Request {
    Change(Change, Reply<Done>),
    Events(SessionKey, Reply<Vec<Link>>),
    Sessions(Reply<Vec<SessionEntry>>),
    Erase(String, i64, Reply<usize>),
    Verify(Reply<usize>),
}

impl GroupStore {
    /// Hands `store` to a thread of its own.
    ///
    /// # Errors
    /// The operating system gives no thread.
    pub fn new(store: StudyStore) -> std::io::Result<Self> {
        let (requests, waiting) = channel();
        let thread = std::thread::Builder::new().name("study".into());
        let thread = thread.spawn(move || serve(store, &waiting))?;
        Ok(Self {
            owner: Arc::new(Owner {
                requests: Some(requests),
                thread: Some(thread),
            }),
        })
    }

    fn ask<T>(&self, request: impl FnOnce(Reply<T>) -> Request) -> Result<T, StoreError> {
        let (reply, answer) = sync_channel(1);
        let sent = self.owner.requests.as_ref().map(|requests| {
            let request = request(reply);
            requests.send(request).is_ok()
        });
        match (sent, answer.recv()) {
            (Some(true), Ok(answer)) => answer,
            _ => Err(StoreError::Place {
                why: "the thread of the study has ended".into(),
                advice: "open the study again",
            }),
        }
    }
}

/// Answers requests until nobody is left to ask.
fn serve(mut store: StudyStore, waiting: &Receiver<Request>) {
    while let Ok(first) = waiting.recv() {
        let mut group = Vec::new();
        let mut others = Vec::new();
        for request in std::iter::once(first).chain(waiting.try_iter().take(MOST - 1)) {
            match request {
                Request::Change(change, reply) => group.push((change, reply)),
                other => others.push(other),
            }
        }
        let (changes, replies): (Vec<Change>, Vec<Reply<Done>>) = group.into_iter().unzip();
        for (reply, done) in replies.into_iter().zip(store.change_together(&changes)) {
            // Whoever asked may be gone.
            let _gone = reply.send(done);
        }
        for request in others {
            answer(&mut store, request);
        }
    }
}

/// Answers what is no part of a group.
fn answer(store: &mut StudyStore, request: Request) {
    let _gone = match request {
        Request::Change(change, reply) => {
            let done = store.change_together(&[change]).pop();
            reply.send(done.unwrap_or(Ok(None))).is_ok()
        }
        Request::Events(key, reply) => reply.send(store.events(&key)).is_ok(),
        Request::Sessions(reply) => reply.send(store.sessions()).is_ok(),
        Request::Erase(participant, at_ms, reply) => {
            reply.send(store.erase(&participant, at_ms)).is_ok()
        }
        Request::Verify(reply) => reply.send(store.verify()).is_ok(),
    };
}

async fn one(database: &mut Database, change: &Change) -> Result<Done, StoreError> {
    match change {
        Change::Begin { key, purpose } => {
            sessions::begin(database, key, *purpose).await?;
            Ok(None)
        }
        Change::Append {
            key,
            known,
            at_ms,
            json,
            salt,
        } => {
            let event = NewEvent {
                at_ms: *at_ms,
                json,
                salt: *salt,
            };
            let link = sessions::append(database, key, *known, event).await?;
            Ok(Some(link))
        }
    }
}

/// What all changes give in one transaction. An error of the database ends it; a change that is refused does not.
async fn all(
    database: &mut Database,
    changes: &[Change],
) -> Result<Vec<Result<Done, StoreError>>, StoreError> {
    let mut done = Vec::with_capacity(changes.len());
    for change in changes {
        match one(database, change).await {
            Err(error @ StoreError::Place { .. }) => return Err(error),
            other => done.push(other),
        }
    }
    Ok(done)
}

impl StudyStore {
    /// Does all `changes` in one transaction; gives what each has stored, or why it was refused, in their order.
    fn change_together(&mut self, changes: &[Change]) -> Vec<Result<Done, StoreError>> {
        if changes.is_empty() {
            return Vec::new();
        }
        match self.try_change(async |database| all(database, changes).await) {
            Ok(Changed::Stored(done)) => done,
            Ok(Changed::Unsure(done, error)) => match self.is_any_stored(changes, &done) {
                true => done,
                false => failed(changes, &error),
            },
            // The connection is lost: each of them would wait for it.
            Err(error) if changes.len() == 1 || self.is_cut_off() => failed(changes, &error),
            // One that the database refuses does not spoil the others.
            Err(_) => {
                let each = changes.iter();
                each.flat_map(|change| self.change_together(std::slice::from_ref(change)))
                    .collect()
            }
        }
    }

    /// Whether the transaction of `changes` is stored, behind a connection that broke: one event of it stands for all.
    fn is_any_stored(&mut self, changes: &[Change], done: &[Result<Done, StoreError>]) -> bool {
        let mut events =
            changes
                .iter()
                .zip(done)
                .filter_map(|(change, done)| match (change, done) {
                    (Change::Append { key, .. }, Ok(Some(link))) => Some((key, link)),
                    _ => None,
                });
        match events.next() {
            Some((key, link)) => self.is_stored(key, link).unwrap_or(false),
            None => false,
        }
    }
}

/// The same refusal for each of `changes`.
fn failed(changes: &[Change], error: &StoreError) -> Vec<Result<Done, StoreError>> {
    let again = || match error {
        StoreError::Place { why, advice } => StoreError::Place {
            why: why.clone(),
            advice,
        },
        other => StoreError::Place {
            why: other.to_string(),
            advice: "then do the same again",
        },
    };
    changes.iter().map(|_| Err(again())).collect()
}

impl Store for GroupStore {
    fn begin(&mut self, key: &SessionKey, purpose: Purpose) -> Result<(), StoreError> {
        let key = key.clone();
        let done = self.ask(|reply| Request::Change(Change::Begin { key, purpose }, reply));
        done.map(|_| ())
    }

    fn append(
        &mut self,
        key: &SessionKey,
        known: u64,
        event: NewEvent<'_>,
    ) -> Result<Link, StoreError> {
        let change = Change::Append {
            key: key.clone(),
            known,
            at_ms: event.at_ms,
            json: event.json.to_owned(),
            salt: event.salt,
        };
        let done = self.ask(|reply| Request::Change(change, reply))?;
        done.ok_or_else(|| super::error::damaged("an event has no link"))
    }

    fn events(&self, key: &SessionKey) -> Result<Vec<Link>, StoreError> {
        self.ask(|reply| Request::Events(key.clone(), reply))
    }

    fn sessions(&self) -> Result<Vec<SessionEntry>, StoreError> {
        self.ask(Request::Sessions)
    }

    fn erase(&mut self, participant: &str, at_ms: i64) -> Result<usize, StoreError> {
        self.ask(|reply| Request::Erase(participant.to_owned(), at_ms, reply))
    }

    fn verify(&self) -> Result<usize, StoreError> {
        self.ask(Request::Verify)
    }
}
