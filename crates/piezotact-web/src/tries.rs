//! How often codes and passwords may be tried, and who waits for the check of a password.

use std::collections::VecDeque;
use std::net::IpAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::{OwnedSemaphorePermit, Semaphore};

/// So many wrong tries of one address are taken in [`WINDOW_MS`].
pub(crate) const MOST_WRONG: usize = 5;
/// So many of all addresses of a network together.
const MOST_OF_NETWORK: usize = 20;
/// So many of all networks together; a network with fewer than [`FEW`] of its own has one all the same.
const MOST_OF_ALL: usize = 200;
const FEW: usize = 2;
/// So many are remembered.
const MOST_KNOWN: usize = 4096;
/// In ms.
pub(crate) const WINDOW_MS: i64 = 60_000;
/// The most passwords of one address, of one network and of all that wait for their check.
const WAITING: [usize; 3] = [2, 4, 32];
/// So many more may wait of networks that gave no wrong one in the last minute.
const WAITING_FIRST: usize = 32;

/// What is tried. Each is counted by itself: a participant who mistypes a code does not keep the experimenter's password out, who may be
/// behind the same address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Tried {
    Code,
    Password,
}

/// Whether a network has tried before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Network {
    /// No wrong try in the last minute.
    New,
    /// One at least.
    Known,
}

/// The wrong tries of the last minute, by address and network: whoever tries codes, from however many addresses, keeps no other network out.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tries {
    wrong: VecDeque<Wrong>,
}

/// A wrong try.
#[derive(Clone, Copy, Debug)]
struct Wrong {
    at_ms: i64,
    tried: Tried,
    network: IpAddr,
    from: IpAddr,
}

impl Tries {
    /// Counts a try from `from` at `now_ms` as wrong until [`Self::takes_back`]; none is left where it gives `None`.
    pub(crate) fn count(&mut self, tried: Tried, from: IpAddr, now_ms: i64) -> Option<Network> {
        let (from, network) = (from.to_canonical(), network(from));
        while let Some(first) = self.wrong.front()
            && !(0..=WINDOW_MS).contains(&(now_ms - first.at_ms))
        {
            self.wrong.pop_front();
        }
        let (mut own, mut near) = (0, 0);
        for wrong in &self.wrong {
            if wrong.tried == tried && wrong.network == network {
                near += 1;
                own += usize::from(wrong.from == from);
            }
        }
        let is_busy = self.wrong.len() >= MOST_OF_ALL && near >= FEW;
        if own >= MOST_WRONG || near >= MOST_OF_NETWORK || is_busy {
            return None;
        }
        if self.wrong.len() >= MOST_KNOWN {
            self.wrong.pop_front();
        }
        self.wrong.push_back(Wrong {
            at_ms: now_ms,
            tried,
            network,
            from,
        });
        Some(match near {
            0 => Network::New,
            _ => Network::Known,
        })
    }

    /// The last try of `from` was right, or was not looked at.
    pub(crate) fn takes_back(&mut self, tried: Tried, from: IpAddr) {
        let from = from.to_canonical();
        let is_it = |wrong: &Wrong| (wrong.tried, wrong.from) == (tried, from);
        if let Some(at) = self.wrong.iter().rposition(is_it) {
            self.wrong.remove(at);
        }
    }
}

/// The network of an address: the first 24 bits of version 4, 64 of version 6. Whoever has one address of version 6 has 2^64 of them.
pub(crate) fn network(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(six) => IpAddr::V6((six.to_bits() >> 64 << 64).into()),
        IpAddr::V4(four) => IpAddr::V4((four.to_bits() >> 8 << 8).into()),
    }
}

/// Those who wait for the check of a password: one is checked at a time, in the order in which they came. They wait without a thread, so
/// that reports do not wait for passwords.
#[derive(Clone, Debug)]
pub(crate) struct Queue {
    one: Arc<Semaphore>,
    waiting: Waiting,
}

type Waiting = Arc<Mutex<Vec<IpAddr>>>;

impl Default for Queue {
    fn default() -> Self {
        Self {
            one: Arc::new(Semaphore::new(1)),
            waiting: Arc::default(),
        }
    }
}

/// The turn of somebody, as long as it lives.
#[derive(Debug)]
pub(crate) struct Turn {
    _one: OwnedSemaphorePermit,
    _place: Place,
}

impl Queue {
    /// The turn of `from`, when it comes; `None` at once where too many wait.
    pub(crate) async fn turn(&self, from: IpAddr, of: Network) -> Option<Turn> {
        let place = Place::of(&self.waiting, from, of)?;
        let one = Arc::clone(&self.one).acquire_owned().await.ok()?;
        Some(Turn {
            _one: one,
            _place: place,
        })
    }
}

/// A place in the queue.
#[derive(Debug)]
struct Place(Waiting, IpAddr);

impl Place {
    fn of(waiting: &Waiting, from: IpAddr, of: Network) -> Option<Self> {
        let from = from.to_canonical();
        let mut all = locked(waiting);
        let own = all.iter().filter(|other| **other == from).count();
        let near = all.iter().filter(|other| network(**other) == network(from));
        let [of_one, of_network, mut of_all] = WAITING;
        if of == Network::New {
            of_all += WAITING_FIRST;
        }
        if own >= of_one || near.count() >= of_network || all.len() >= of_all {
            return None;
        }
        all.push(from);
        drop(all);
        Some(Self(Arc::clone(waiting), from))
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut all = locked(&self.0);
        if let Some(at) = all.iter().position(|other| *other == self.1) {
            all.swap_remove(at);
        }
    }
}

fn locked(waiting: &Waiting) -> MutexGuard<'_, Vec<IpAddr>> {
    waiting.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn address(text: &str) -> IpAddr {
        text.parse().unwrap()
    }

    #[test]
    fn one_address_keeps_nobody_else_out() {
        let mut tries = Tries::default();
        let (one, other) = (address("192.168.1.7"), address("192.168.1.8"));
        for i in 0..MOST_WRONG {
            assert!(tries.count(Tried::Code, one, i as i64).is_some());
        }
        let again = address("::ffff:192.168.1.7");
        assert!(tries.count(Tried::Code, one, 10).is_none());
        assert!(tries.count(Tried::Code, again, 10).is_none());
        assert!(tries.count(Tried::Password, one, 10).is_some());
        assert!(tries.count(Tried::Code, other, 10).is_some());
        tries.takes_back(Tried::Code, other);
        assert!(tries.count(Tried::Code, one, WINDOW_MS + 20).is_some());
    }

    #[test]
    fn addresses_of_one_network_do_not_multiply_tries() {
        for (first, other) in [("10.1.2.0", "10.1.3.1"), ("2001:db8::", "2001:db8:0:1::1")] {
            let mut tries = Tries::default();
            let mut addresses = (0..200u8).map(|i| match address(first) {
                IpAddr::V4(four) => IpAddr::V4((four.to_bits() | u32::from(i)).into()),
                IpAddr::V6(six) => IpAddr::V6((six.to_bits() | u128::from(i)).into()),
            });
            let taken = addresses.by_ref().take(150);
            let taken = taken.filter(|at| tries.count(Tried::Password, *at, 5).is_some());
            assert_eq!(taken.count(), MOST_OF_NETWORK, "{first}");
            let found = tries.count(Tried::Password, address(other), 5);
            assert_eq!(found, Some(Network::New), "{other}");
            let found = tries.count(Tried::Password, address(other), 6);
            assert_eq!(found, Some(Network::Known), "{other}");
        }
    }

    #[test]
    fn many_networks_have_few_tries_and_keep_nobody_else_out() {
        let mut tries = Tries::default();
        for i in 0..5000u128 {
            let six = IpAddr::V6((i << 64).into());
            for own in 0..=FEW {
                let is_taken = tries.count(Tried::Code, six, 5).is_some();
                assert!(is_taken == (own < FEW) || i < 100, "{i} {own}");
            }
        }
        assert!(tries.wrong.len() <= MOST_KNOWN);
        // A clock that was set back locks nobody out for longer.
        assert!(
            tries
                .count(Tried::Code, address("10.0.0.1"), -100)
                .is_some()
        );
    }

    #[test]
    fn the_queue_is_short_and_has_room_for_other_networks() {
        let waiting = Waiting::default();
        let places = |network: u8, of| -> Vec<Place> {
            let all = (1..=6).flat_map(|i| [i; 3]);
            all.filter_map(|i| Place::of(&waiting, IpAddr::from([10, 0, network, i]), of))
                .collect()
        };
        let one = places(0, Network::Known);
        assert_eq!(one.len(), 4, "two of each of two addresses");
        let known: Vec<_> = (1..20).map(|i| places(i, Network::Known)).collect();
        assert_eq!(locked(&waiting).len(), 32);
        let new: Vec<_> = (20..40).map(|i| places(i, Network::New)).collect();
        assert_eq!(locked(&waiting).len(), 64);
        drop((one, known, new));
        assert!(locked(&waiting).is_empty());
    }
}
