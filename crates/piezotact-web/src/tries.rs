//! How often codes and passwords may be tried.

use std::collections::VecDeque;
use std::net::IpAddr;

/// So many wrong tries of one address are taken in [`WINDOW_MS`].
pub(crate) const MOST_WRONG: usize = 5;
/// So many of all addresses together; an address without a wrong try of its own has one all the same.
const MOST_OF_ALL: usize = 200;
/// So many are remembered.
const MOST_KNOWN: usize = 4096;
/// In ms.
pub(crate) const WINDOW_MS: i64 = 60_000;

/// What is tried. Each is counted by itself: a participant who mistypes a code does not keep the experimenter's password out, who may be
/// behind the same address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Tried {
    Code,
    Password,
}

/// The wrong tries of the last minute, by address: whoever tries codes, from however many addresses, keeps no other address out.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tries {
    wrong: VecDeque<(i64, Tried, IpAddr)>,
}

impl Tries {
    /// Counts a try from `from` at `now_ms` as wrong until [`Self::was_right`]; none is left where it gives `None`.
    pub(crate) fn count(&mut self, tried: Tried, from: IpAddr, now_ms: i64) -> Option<()> {
        let from = network(from);
        while let Some((at, _, _)) = self.wrong.front()
            && !(0..=WINDOW_MS).contains(&(now_ms - at))
        {
            self.wrong.pop_front();
        }
        let own = self.wrong.iter();
        let own = own.filter(|(_, what, other)| (*what, *other) == (tried, from));
        let own = own.count();
        if own >= MOST_WRONG || (own > 0 && self.wrong.len() >= MOST_OF_ALL) {
            return None;
        }
        if self.wrong.len() >= MOST_KNOWN {
            self.wrong.pop_front();
        }
        self.wrong.push_back((now_ms, tried, from));
        Some(())
    }

    /// The last try of `from` was right.
    pub(crate) fn was_right(&mut self, tried: Tried, from: IpAddr) {
        let from = network(from);
        let is_it = |(_, what, other): &(i64, Tried, IpAddr)| (*what, *other) == (tried, from);
        if let Some(at) = self.wrong.iter().rposition(is_it) {
            self.wrong.remove(at);
        }
    }
}

/// The network of an address: whoever has one address of version 6 has 2^64 of them.
fn network(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(six) => {
            let bits = six.to_bits() >> 64 << 64;
            IpAddr::V6(bits.into())
        }
        four @ IpAddr::V4(_) => four,
    }
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
        tries.was_right(Tried::Code, other);
        assert!(tries.count(Tried::Code, one, WINDOW_MS + 20).is_some());
    }

    #[test]
    fn many_addresses_have_few_tries_and_keep_nobody_else_out() {
        let mut tries = Tries::default();
        let taken = (0..1000u128)
            .filter(|i| {
                // Addresses of one network are one.
                let six = ((i / 100) << 64) | i;
                tries
                    .count(Tried::Code, IpAddr::V6(six.into()), 5)
                    .is_some()
            })
            .count();
        assert_eq!(taken, 10 * MOST_WRONG);
        for i in 0..100_000u128 {
            let six = IpAddr::V6(((i + 10) << 64).into());
            assert!(tries.count(Tried::Code, six, 5).is_some(), "its first");
            assert!(tries.count(Tried::Code, six, 5).is_none() || i < 200);
        }
        assert!(tries.wrong.len() <= MOST_KNOWN);
        // A clock that was set back locks nobody out for longer.
        assert!(
            tries
                .count(Tried::Code, address("10.0.0.1"), -100)
                .is_some()
        );
    }
}
