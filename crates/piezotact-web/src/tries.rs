//! How often codes and passwords may be tried.

use std::collections::VecDeque;
use std::net::IpAddr;

/// So many wrong tries of one address are taken in [`WINDOW_MS`].
pub(crate) const MOST_WRONG: usize = 5;
/// So many of all addresses together.
const MOST_OF_ALL: usize = 200;
/// In ms.
pub(crate) const WINDOW_MS: i64 = 60_000;

/// The wrong tries of the last minute, by address: whoever tries codes from one address keeps nobody else out.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tries {
    wrong: VecDeque<(i64, IpAddr)>,
}

impl Tries {
    /// Counts a try from `from` at `now_ms` as wrong until [`Self::was_right`]; none is left where it gives `None`.
    pub(crate) fn count(&mut self, from: IpAddr, now_ms: i64) -> Option<()> {
        let from = network(from);
        while let Some((at, _)) = self.wrong.front()
            && !(0..=WINDOW_MS).contains(&(now_ms - at))
        {
            self.wrong.pop_front();
        }
        let own = self.wrong.iter().filter(|(_, other)| *other == from);
        if own.count() >= MOST_WRONG || self.wrong.len() >= MOST_OF_ALL {
            return None;
        }
        self.wrong.push_back((now_ms, from));
        Some(())
    }

    /// The last try of `from` was right.
    pub(crate) fn was_right(&mut self, from: IpAddr) {
        let from = network(from);
        if let Some(at) = self.wrong.iter().rposition(|(_, other)| *other == from) {
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
            assert!(tries.count(one, i as i64).is_some());
        }
        assert!(tries.count(one, 10).is_none());
        assert!(tries.count(address("::ffff:192.168.1.7"), 10).is_none());
        assert!(tries.count(other, 10).is_some());
        tries.was_right(other);
        assert!(tries.count(one, WINDOW_MS + 20).is_some());
    }

    #[test]
    fn all_addresses_together_are_limited() {
        let mut tries = Tries::default();
        let taken = (0..100_000u128)
            .filter(|i| {
                // Addresses of one network are one.
                let six = ((i / 4) << 64) | (i % 4);
                tries.count(IpAddr::V6(six.into()), 5).is_some()
            })
            .count();
        assert_eq!(taken, MOST_OF_ALL);
        // A clock that was set back locks nobody out for longer.
        assert!(tries.count(address("10.0.0.1"), -100).is_some());
    }
}
