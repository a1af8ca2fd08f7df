//! Epochs one after the other as one recording with gaps, which other programs read.

use piezotact::quantity::{Seconds, Unit};
use piezotact::recording::{
    Channel, Condition, Event, EventValue, Provenance, Recording, RecordingError,
};

use super::Epochs;

/// Why epochs cannot be joined.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum JoinError {
    /// The marker stands on no sample of its epoch.
    #[error(
        "expected epochs that hold their marker, found epochs from {first_s} to {last_s} s; state an epoch that begins at 0 or before and ends \
            at 0 or after"
    )]
    NoMarker { first_s: f64, last_s: f64 },
    /// Channels that make no recording.
    #[error(transparent)]
    Recording(#[from] RecordingError),
}

impl Epochs {
    /// The epochs one after the other, V. Each but the first begins with an event `New Segment`; on the sample nearest to its marker
    /// stands an event `Stimulus` whose value is its condition.
    ///
    /// # Errors
    /// [`JoinError::NoMarker`] when the epochs begin after their markers or end before them.
    pub fn joined(&self) -> Result<Recording, JoinError> {
        let rate_hz = self.rate().hz();
        let marker = (-self.first_s() * rate_hz).round();
        if !(0.0..self.samples() as f64).contains(&marker) {
            return Err(JoinError::NoMarker {
                first_s: self.first_s(),
                last_s: self.last_s(),
            });
        }
        let named = self.channels().iter().enumerate();
        let channels = named.map(|(at, name)| Channel {
            name: name.clone(),
            unit: Unit::Volt,
            samples: self.channel(at).to_vec(),
        });
        let (condition, provenance) = (Condition::default(), Provenance::default());
        let mut recording = Recording::new(channels.collect(), self.rate(), condition, provenance)?;
        let event = |sample: f64, kind: &str, value: Option<&String>| Event {
            onset_s: Seconds(sample / rate_hz),
            duration_s: Seconds(0.0),
            kind: kind.into(),
            value: value.map(|text| EventValue::Text(text.clone())),
        };
        for (at, condition) in self.conditions().iter().enumerate() {
            let start = (at * self.samples()) as f64;
            let events = &mut recording.annotations.events;
            if at > 0 {
                events.push(event(start, "New Segment", None));
            }
            events.push(event(start + marker, "Stimulus", Some(condition)));
        }
        Ok(recording)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::quantity::SampleRate;

    #[test]
    fn markers_stand_on_their_samples() {
        let rate = SampleRate::new(100.0).unwrap();
        let names = |all: [&str; 2]| all.map(String::from).to_vec();
        let volts: Vec<f64> = (0..20).map(f64::from).collect();
        let of = |first_s| {
            Epochs::new(
                names(["C3", "Cz"]),
                names(["M8", "BIO"]),
                rate,
                first_s,
                volts.clone(),
            )
        };
        let joined = of(-0.02).unwrap().joined().unwrap();
        assert_eq!(joined.channels()[1].samples, volts[10..]);
        let events = joined.annotations.events.iter();
        let events = events.map(|e| {
            (
                e.onset_s.0,
                e.to_string().split(": ").last().unwrap().to_owned(),
            )
        });
        let text = |at: f64, name: &str| (at, name.to_owned());
        assert_eq!(
            events.collect::<Vec<_>>(),
            [
                text(0.02, "Stimulus M8"),
                text(0.05, "New Segment"),
                text(0.07, "Stimulus BIO")
            ]
        );
        for first_s in [0.01, -0.05] {
            let error = of(first_s).unwrap().joined().unwrap_err();
            assert!(matches!(error, JoinError::NoMarker { .. }), "{error}");
        }
    }
}
