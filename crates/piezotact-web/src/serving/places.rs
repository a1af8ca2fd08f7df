//! The connections there are, and which of them makes room for a new one.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::net::IpAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::task::AbortHandle;
use tokio::time::Instant;

use crate::tries::network;

/// Connections at once.
const MOST: usize = 256;
/// Those of one network that are not kept.
const MOST_OF_NETWORK: usize = 128;
/// Those of one address that are not kept.
const MOST_OF_ONE: usize = 32;
/// Connections of pages that were let in and are kept: a browser opens six to one address, and several may be behind one.
const MOST_KEPT: usize = 192;
/// Those of one address.
const MOST_KEPT_OF_ONE: usize = 64;

/// So many of a browser are not held against its address.
const BROWSER: usize = 6;

/// What a connection has shown, in the order in which connections make room.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Standing {
    /// No request yet.
    Silent,
    /// Waits after an answer.
    Answered,
    /// Its request is being answered.
    Asking,
    /// A page that was let in, where there are enough of them.
    LetIn,
    /// A page that was let in: makes room for nobody.
    Kept,
}

#[derive(Debug)]
struct Connection {
    from: IpAddr,
    standing: Standing,
    /// When it came to this.
    at: Instant,
    task: Option<AbortHandle>,
}

type All = BTreeMap<u64, Connection>;

/// All connections, by a number.
#[derive(Clone, Debug, Default)]
pub(super) struct Places(Arc<Mutex<All>>);

impl Places {
    fn all(&self) -> MutexGuard<'_, All> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A place for a connection of `from`. Where there are too many of its address, of its network or of all, another one ends; `None` where
    /// all of them are kept.
    pub(super) fn take(&self, from: IpAddr) -> Option<Place> {
        let from = from.to_canonical();
        let near = network(from);
        let mut all = self.all();
        let loose = |other: &&Connection| other.standing != Standing::Kept;
        let own = all.values().filter(loose);
        if own.filter(|other| other.from == from).count() >= MOST_OF_ONE {
            make_room(&mut all, |other| other == from)?;
        }
        let own = all.values().filter(loose);
        if own.filter(|other| network(other.from) == near).count() >= MOST_OF_NETWORK {
            make_room(&mut all, |other| network(other) == near)?;
        }
        if all.len() >= MOST {
            make_room(&mut all, |_| true)?;
        }
        let number = all.last_key_value().map_or(0, |(last, _)| last + 1);
        all.insert(
            number,
            Connection {
                from,
                standing: Standing::Silent,
                at: Instant::now(),
                task: None,
            },
        );
        drop(all);
        Some(Place(self.clone(), number))
    }
}

/// Ends a connection of the addresses `of`: of the network that has most, of its address that has most, the one that has shown least and
/// for the longest time. So a network, or an address, that opens many takes the places of its own.
fn make_room(all: &mut All, of: impl Fn(IpAddr) -> bool) -> Option<()> {
    let mut counts: BTreeMap<(IpAddr, Option<IpAddr>), usize> = BTreeMap::new();
    let loose = |other: &Connection| other.standing != Standing::Kept && of(other.from);
    for other in all.values().filter(|other| loose(other)) {
        *counts.entry((network(other.from), None)).or_default() += 1;
        let own = (network(other.from), Some(other.from));
        *counts.entry(own).or_default() += 1;
    }
    let count = |near, own| {
        let count = counts.get(&(near, own)).copied().unwrap_or_default();
        count.saturating_sub(BROWSER)
    };
    let first = all.iter().filter(|(_, other)| loose(other));
    let (number, _) = first.max_by_key(|(_, other)| {
        let near = network(other.from);
        let counts = (count(near, None), count(near, Some(other.from)));
        (counts, Reverse((other.standing, other.at)))
    })?;
    let number = *number;
    let gone = all.remove(&number)?;
    if let Some(task) = gone.task {
        task.abort();
    }
    Some(())
}

/// The place of a connection, as long as it lives.
#[derive(Debug)]
pub(crate) struct Place(Places, u64);

impl Place {
    /// The connection is held by `task`, which ends where it has to make room.
    pub(super) fn held_by(&self, task: AbortHandle) {
        if let Some(own) = self.0.all().get_mut(&self.1) {
            own.task = Some(task);
        }
    }

    /// A request came.
    pub(super) fn asks(&self) {
        self.comes_to(Standing::Asking);
    }

    /// A request was answered.
    pub(super) fn answered(&self) {
        self.comes_to(Standing::Answered);
    }

    fn comes_to(&self, standing: Standing) {
        if let Some(own) = self.0.all().get_mut(&self.1) {
            own.at = Instant::now();
            if own.standing < Standing::LetIn {
                own.standing = standing;
            }
        }
    }

    /// The connection is that of a page that was let in.
    pub(crate) fn let_in(&self) {
        let mut all = self.0.all();
        let Some(own) = all.get(&self.1) else {
            return;
        };
        let (from, before) = (own.from, own.standing);
        let kept = all.values().filter(|one| one.standing == Standing::Kept);
        let (mut of_all, mut of_one) = (0, 0);
        for one in kept {
            of_all += 1;
            of_one += usize::from(one.from == from);
        }
        if let Some(own) = all.get_mut(&self.1)
            && before != Standing::Kept
        {
            own.standing = match of_all < MOST_KEPT && of_one < MOST_KEPT_OF_ONE {
                true => Standing::Kept,
                false => Standing::LetIn,
            };
        }
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.0.all().remove(&self.1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(network: u8, own: u8) -> IpAddr {
        IpAddr::from([10, 0, network, own])
    }

    fn is_there(place: &Place) -> bool {
        place.0.all().contains_key(&place.1)
    }

    #[test]
    fn the_oldest_without_a_request_makes_room_first() {
        let places = Places::default();
        let all: Vec<Place> = (0..MOST_OF_ONE)
            .map(|_| places.take(at(0, 1)).unwrap())
            .collect();
        all[0].asks();
        all[1].asks();
        all[1].answered();
        all[2].let_in();
        let _place_of_the_kept = places.take(at(0, 1)).unwrap();
        let first: Vec<Place> = (3..MOST_OF_ONE)
            .map(|i| {
                assert!(is_there(&all[i]));
                let new = places.take(at(0, 1)).unwrap();
                assert!(!is_there(&all[i]), "{i}");
                new.asks();
                new
            })
            .collect();
        assert!([0, 1, 2].iter().all(|i| is_there(&all[*i])));
        let _of_the_silent_one = places.take(at(0, 1)).unwrap();
        let answered = places.take(at(0, 1)).unwrap();
        answered.asks();
        assert!(is_there(&all[0]) && first.iter().all(is_there));
        let _more = places.take(at(0, 1)).unwrap();
        assert!(!is_there(&all[1]), "it was answered");
        assert!(is_there(&all[2]), "it is kept");
    }

    #[test]
    fn whoever_opens_many_takes_the_places_of_its_own() {
        let places = Places::default();
        let few: Vec<Place> = (0..6).map(|_| places.take(at(9, 9)).unwrap()).collect();
        // One address, one network, many networks.
        let taken: Vec<Place> = (0..3000_u32)
            .filter_map(|i| {
                let [low, high] = [(i % 250) as u8, (i / 250) as u8];
                let from = match i / 1000 {
                    0 => at(0, 1),
                    1 => at(1, low),
                    _ => at(10 + high, low),
                };
                places.take(from)
            })
            .collect();
        assert_eq!(taken.len(), 3000, "there is always room");
        assert!(few.iter().all(is_there));
        let all = places.all();
        assert!(all.len() <= MOST);
        let of_one = all.values().filter(|one| one.from == at(0, 1));
        assert!(of_one.count() <= MOST_OF_ONE);
        let near = all.values().filter(|one| network(one.from) == at(1, 0));
        assert!(near.count() <= MOST_OF_NETWORK);
    }

    #[test]
    fn a_browser_among_many_addresses_is_served() {
        let places = Places::default();
        let all = |of: std::ops::Range<u8>| -> Vec<Place> {
            of.map(|own| places.take(at(1, own)).unwrap()).collect()
        };
        let before = all(0..128);
        let browser: Vec<Place> = (0..BROWSER)
            .map(|_| places.take(at(1, 250)).unwrap())
            .collect();
        let after = all(128..228);
        assert!(browser.iter().chain(&after).all(is_there));
        let left = before.iter().filter(|one| is_there(one)).count();
        assert_eq!(left, MOST_OF_NETWORK - BROWSER - 100, "the oldest go");
    }

    #[test]
    fn pages_are_kept_and_leave_room() {
        let places = Places::default();
        let pages: Vec<Place> = (0..400_u32)
            .map(|i| {
                let place = places.take(at(0, (i / 100) as u8)).unwrap();
                place.let_in();
                place
            })
            .collect();
        let kept = || {
            let all = places.all();
            let kept = all.values().filter(|one| one.standing == Standing::Kept);
            kept.count()
        };
        assert_eq!(kept(), MOST_KEPT);
        let _others: Vec<Place> = (0..1000_u32)
            .map(|i| places.take(at((i % 200) as u8, 7)).unwrap())
            .collect();
        assert_eq!(kept(), MOST_KEPT);
        drop(pages);
        assert_eq!(kept(), 0);
    }
}
