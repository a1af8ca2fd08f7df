//! Events from the trigger bits of a status channel.

use piezotact::Warning;
use piezotact::recording::{EventValue, RecordingWarning};

use super::content::{Marked, Place};

/// Trigger bits of a status channel; those above tell of battery, range and speed.
const TRIGGER_BITS: u32 = 0xFFFF;

/// Whether a channel of this name holds triggers, as MNE 1.13.2 has it.
pub(super) fn is_trigger(name: &str) -> bool {
    name.eq_ignore_ascii_case("Status") || name.eq_ignore_ascii_case("Trigger")
}

/// The rises of the trigger bits of `codes`, each with its new code. A code that is there from the first sample is no event, nor is a
/// rise from 0 that lasts to the end: MNE's `find_events` with its defaults and a mask of 16 bits. A warning says so of the latter.
pub(super) fn events(
    channel: &str,
    codes: impl Iterator<Item = i32>,
) -> (Vec<Marked>, Option<Warning>) {
    let codes = codes.map(|code| code.cast_unsigned() & TRIGGER_BITS);
    let mut found: Vec<Marked> = Vec::new();
    let mut before = None;
    // The last step that ends a code: a fall to 0, or a change from one code to a higher one.
    let mut last_end = None;
    for (at, code) in codes.enumerate() {
        let Some(from) = before.replace(code) else {
            continue;
        };
        if code == from {
            continue;
        }
        if (code > from || code == 0) && from > 0 {
            last_end = Some(at);
        }
        if code > from {
            found.push(Marked {
                place: Place::Sample(at as f64),
                duration_s: 0.0,
                kind: channel.to_owned(),
                value: Some(EventValue::Number(f64::from(code))),
            });
        }
    }
    if let Some(Marked {
        place: Place::Sample(at),
        ..
    }) = found.last()
        && last_end.is_none_or(|end| *at > end as f64)
    {
        let what = format!(
            "the trigger of `{channel}` that rises at sample {at} lasts to the end of the file, and is not counted as an event"
        );
        found.pop();
        return (
            found,
            Some(Warning::from(RecordingWarning::Guessed { what })),
        );
    }
    (found, None)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(codes: &[i32]) -> Vec<(f64, f64)> {
        let (each, _) = events("Status", codes.iter().copied());
        each.into_iter()
            .map(|event| match (event.place, event.value) {
                (Place::Sample(at), Some(EventValue::Number(code))) => (at, code),
                other => unreachable!("{other:?}"),
            })
            .collect()
    }

    /// As `mne.find_events` of MNE 1.13.2 finds them.
    #[test]
    fn rises_are_events() {
        assert_eq!(found(&[0, 5, 5, 0, 3, 0]), [(1.0, 5.0), (4.0, 3.0)]);
        assert_eq!(found(&[0, 1, 3, 1, 0]), [(1.0, 1.0), (2.0, 3.0)]);
        assert_eq!(found(&[4, 4, 0, 6, 0]), [(3.0, 6.0)]);
        assert_eq!(found(&[0, 5, 5]), []);
        assert_eq!(found(&[]), []);
        // Bits above 15 are no triggers.
        assert_eq!(found(&[0x10_0000, 0x11_0002, 0x10_0000]), [(1.0, 2.0)]);
        assert_eq!(found(&[-1 << 16, (-1 << 16) | 7, -1 << 16]), [(1.0, 7.0)]);
    }
}
