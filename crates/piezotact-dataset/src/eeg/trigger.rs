//! Events from the trigger bits of a status channel.

use piezotact::recording::EventValue;

use super::content::{Marked, Place};

/// Trigger bits of a status channel; those above tell of battery, range and speed.
const TRIGGER_BITS: u32 = 0xFFFF;

/// Whether a channel of this name holds triggers, as MNE 1.13.2 has it.
pub(super) fn is_trigger(name: &str) -> bool {
    name.eq_ignore_ascii_case("Status") || name.eq_ignore_ascii_case("Trigger")
}

/// The changes of the trigger bits of `codes` to another code than 0, each with its new code: a code that is held until the next one comes is an
/// event as one is that returns to 0. A code that is there from the first sample is none, nor is one of a single sample on the way down, while
/// the bits of the code before it fall one after the other.
pub(super) fn events(channel: &str, codes: impl Iterator<Item = i32>) -> Vec<Marked> {
    let codes = codes.map(|code| code.cast_unsigned() & TRIGGER_BITS);
    let mut found: Vec<Marked> = Vec::new();
    let mut before = None;
    // Where a code began that has some of the bits of the one before it.
    let mut falls = None;
    for (at, code) in codes.enumerate() {
        let Some(from) = before.replace(code) else {
            continue;
        };
        if code == from {
            continue;
        }
        let is_fall = code & !from == 0;
        if is_fall && falls == Some(at - 1) {
            found.pop();
        }
        falls = (is_fall && code > 0).then_some(at);
        if code > 0 {
            found.push(Marked {
                place: Place::Sample(at as f64),
                duration_s: 0.0,
                kind: channel.to_owned(),
                value: Some(EventValue::Number(f64::from(code))),
            });
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(codes: &[i32]) -> Vec<(f64, f64)> {
        let each = events("Status", codes.iter().copied());
        each.into_iter()
            .map(|event| match (event.place, event.value) {
                (Place::Sample(at), Some(EventValue::Number(code))) => (at, code),
                other => unreachable!("{other:?}"),
            })
            .collect()
    }

    /// As `mne.find_events` of MNE 1.13.2 finds them with `consecutive=True`, but for a code that lasts to the end.
    #[test]
    fn changes_are_events() {
        assert_eq!(found(&[0, 5, 5, 0, 3, 0]), [(1.0, 5.0), (4.0, 3.0)]);
        assert_eq!(found(&[0, 1, 3, 1, 0]), [(1.0, 1.0), (2.0, 3.0)]);
        assert_eq!(found(&[4, 4, 0, 6, 0]), [(3.0, 6.0)]);
        assert_eq!(found(&[0, 5, 5]), [(1.0, 5.0)]);
        let held = [0, 2, 2, 8, 8, 2, 2, 8, 8, 8, 8, 2, 2, 2, 2, 8, 8];
        let codes = [2.0, 8.0, 2.0, 8.0, 2.0, 8.0];
        assert_eq!(
            found(&held)
                .iter()
                .map(|(_, code)| *code)
                .collect::<Vec<_>>(),
            codes
        );
        assert_eq!(found(&[0, 3, 3, 1, 1, 0]), [(1.0, 3.0), (3.0, 1.0)]);
        // Bits that fall one after the other: 7, 6, 4, 0.
        assert_eq!(found(&[0, 7, 7, 6, 4, 0, 0, 1]), [(1.0, 7.0), (7.0, 1.0)]);
        assert_eq!(found(&[]), []);
        // Bits above 15 are no triggers.
        assert_eq!(found(&[0x10_0000, 0x11_0002, 0x10_0000]), [(1.0, 2.0)]);
        assert_eq!(found(&[-1 << 16, (-1 << 16) | 7, -1 << 16]), [(1.0, 7.0)]);
    }
}
