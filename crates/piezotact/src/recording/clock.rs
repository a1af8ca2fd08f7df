//! The clocks of a recording: channels sampled together by one device share a clock.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::{About, Channel, Condition, Provenance, Recording, RecordingError};
use crate::quantity::{SampleRate, Seconds};

/// The sampling clock of a channel: a constant rate from a start time on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Clock {
    /// The rate.
    pub rate_hz: SampleRate,
    /// The time of its first sample, from the first sample of the recording.
    pub start_s: Seconds,
}

impl Clock {
    /// A clock that begins with the recording.
    #[must_use]
    pub fn at(rate_hz: SampleRate) -> Self {
        Self {
            rate_hz,
            start_s: Seconds(0.0),
        }
    }
}

impl Clock {
    /// The distinct clocks of a list, in order of first appearance, and for each entry of the list the index of its clock.
    #[must_use]
    pub fn numbered(each: &[Self]) -> (Vec<Self>, Vec<usize>) {
        let (mut clocks, mut numbers) = (Vec::<Self>::new(), Vec::with_capacity(each.len()));
        for clock in each {
            let known = clocks.iter().position(|known| known == clock);
            numbers.push(known.unwrap_or(clocks.len()));
            if known.is_none() {
                clocks.push(*clock);
            }
        }
        (clocks, numbers)
    }
}

impl fmt::Display for Clock {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.rate_hz)?;
        if self.start_s.0 > 0.0 {
            // Whole µs: differences of times have more digits than any clock.
            write!(f, " from {} s on", (self.start_s.0 * 1e6).round() / 1e6)?;
        }
        Ok(())
    }
}

impl Recording {
    /// A recording whose channels have the clocks of `clocks`, one for each; none where all run at `rate` from the start.
    ///
    /// # Errors
    /// Those of [`Self::with_clocks`]; [`RecordingError::ClocksOf`] where there is not one for each channel.
    pub fn on_clocks(
        channels: Vec<Channel>,
        rate: SampleRate,
        clocks: &[Clock],
        about: About,
    ) -> Result<Self, RecordingError> {
        if !clocks.is_empty() && clocks.len() != channels.len() {
            return Err(RecordingError::ClocksOf {
                channels: channels.len(),
                found: clocks.len(),
            });
        }
        let mut recording = if clocks.is_empty() {
            Self::new(channels, rate, about.condition, about.provenance)?
        } else {
            let channels = channels.into_iter().zip(clocks.iter().copied()).collect();
            Self::with_clocks(channels, about.condition, about.provenance)?
        };
        recording.about.warnings = about.warnings;
        Ok(recording)
    }

    /// The clock of each channel, as documents keep them; none where all channels share one.
    #[must_use]
    pub fn stated_clocks(&self) -> Vec<Clock> {
        match self.clocks() {
            [_] => Vec::new(),
            _ => self
                .channels_with_clocks()
                .map(|(_, clock)| clock)
                .collect(),
        }
    }

    /// A recording of channels that have clocks of their own, at least one of them: those of one clock are of one length.
    /// Starts are counted from any common moment; the earliest becomes 0.
    ///
    /// # Errors
    /// Those of [`Recording::new`]; [`RecordingError::Start`] for a start that is no number.
    pub fn with_clocks(
        channels: Vec<(Channel, Clock)>,
        condition: Condition,
        provenance: Provenance,
    ) -> Result<Self, RecordingError> {
        if let Some((channel, clock)) = channels.iter().find(|(_, c)| !c.start_s.0.is_finite()) {
            return Err(RecordingError::Start {
                channel: channel.name.clone(),
                found_s: clock.start_s.0,
            });
        }
        let starts = channels.iter().map(|(_, clock)| clock.start_s.0);
        let earliest_s = starts.fold(f64::INFINITY, f64::min);
        let (channels, each): (Vec<Channel>, Vec<Clock>) = channels
            .into_iter()
            .map(|(channel, clock)| {
                let start_s = Seconds(clock.start_s.0 - earliest_s);
                (channel, Clock { start_s, ..clock })
            })
            .unzip();
        let (clocks, clock_of) = Clock::numbered(&each);
        Self::of_parts(channels, clocks, clock_of, condition, provenance)
    }

    /// The clocks, each once, in the order of the channels; one where all channels were taken together.
    #[must_use]
    pub fn clocks(&self) -> &[Clock] {
        &self.clocks
    }

    /// The number of the clock of each channel in [`Self::clocks`].
    #[must_use]
    pub fn clock_numbers(&self) -> &[usize] {
        &self.clock_of
    }

    /// The channels, each with its clock.
    pub fn channels_with_clocks(&self) -> impl Iterator<Item = (&Channel, Clock)> {
        let clocks = self.clock_of.iter().map(|number| self.clocks[*number]);
        self.channels.iter().zip(clocks)
    }

    /// The clock of a channel of the recording; the first one for a channel that it does not hold.
    #[must_use]
    pub fn clock_of(&self, name: &str) -> Clock {
        let mut found = self.channels_with_clocks();
        found
            .find(|(channel, _)| channel.name == name)
            .map_or(self.clocks[0], |(_, clock)| clock)
    }

    /// Checks that the channels of these names share a clock, as required wherever samples with the same index are related.
    ///
    /// # Errors
    /// [`RecordingError::Clocks`] naming the first two channels that do not.
    pub fn require_one_clock<'a>(
        &self,
        names: impl IntoIterator<Item = &'a str>,
    ) -> Result<(), RecordingError> {
        let mut names = names.into_iter();
        let Some(first) = names.next() else {
            return Ok(());
        };
        let of_first = self.clock_of(first);
        match names.find(|name| self.clock_of(name) != of_first) {
            None => Ok(()),
            Some(other) => Err(RecordingError::Clocks {
                first: first.into(),
                of_first,
                channel: other.into(),
                found: self.clock_of(other),
            }),
        }
    }

    /// Gives the channel `name` other samples, on `clock`.
    pub(crate) fn put_on_clock(&mut self, name: &str, samples: Vec<f64>, clock: Clock) {
        let mut each: Vec<Clock> = self.channels_with_clocks().map(|(_, of)| of).collect();
        let named = self.channels.iter().position(|one| one.name == name);
        if let Some(at) = named {
            self.channels[at].samples = samples;
            each[at] = clock;
            (self.clocks, self.clock_of) = Clock::numbered(&each);
        }
    }

    /// The part of the recording that holds the channels of the clock that those of these names share; the whole of it
    /// where it has one clock. Its annotations are counted from the first sample of that clock.
    ///
    /// # Errors
    /// [`RecordingError::Clocks`] when these channels have no clock in common.
    pub fn on_the_clock_of<'a>(
        self,
        names: impl IntoIterator<Item = &'a str> + Clone,
    ) -> Result<Self, RecordingError> {
        self.require_one_clock(names.clone())?;
        if self.clocks.len() == 1 {
            return Ok(self);
        }
        let clock = names
            .into_iter()
            .next()
            .map_or(self.clocks[0], |name| self.clock_of(name));
        let shared = self.clock_of.iter().map(|number| self.clocks[*number]);
        let channels: Vec<Channel> = self
            .channels
            .into_iter()
            .zip(shared)
            .filter_map(|(channel, of)| (of == clock).then_some(channel))
            .collect();
        let length_s = channels.first().map_or(0.0, |channel| {
            clock.rate_hz.duration_of(channel.samples.len()).0
        });
        let about = self.about;
        let mut part = Self::new(channels, clock.rate_hz, about.condition, about.provenance)?;
        part.about.warnings = about.warnings;
        part.annotations = self.annotations.cut(clock.start_s, Seconds(length_s));
        Ok(part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::{Acceleration, Unit};
    use crate::recording::Event;

    fn two_clocks() -> Recording {
        let channel = |name: &str, count: usize| Channel {
            name: name.into(),
            unit: Unit::MetrePerSecondSquared,
            samples: vec![1.0; count],
        };
        let clock = |hz: f64, start_s: f64| Clock {
            rate_hz: SampleRate::new(hz).unwrap(),
            start_s: Seconds(start_s),
        };
        Recording::with_clocks(
            vec![
                (channel("nail", 1000), clock(1000.0, 2.0)),
                (channel("arm", 50), clock(100.0, 2.25)),
                (channel("tip", 1000), clock(1000.0, 2.0)),
            ],
            Condition::default(),
            Provenance::default(),
        )
        .unwrap()
    }

    #[test]
    fn every_channel_is_read_at_its_own_rate() {
        let recording = two_clocks();
        assert_eq!(recording.clock_numbers(), [0, 1, 0]);
        assert_eq!(recording.clocks()[1].start_s, Seconds(0.25));
        assert_eq!(recording.duration(), Seconds(1.0));
        let arm = recording.series::<Acceleration>(Some("arm")).unwrap();
        assert!((arm.rate().hz() - 100.0).abs() < 1e-12);
        assert!((arm.duration().0 - 0.5).abs() < 1e-12);
    }

    #[test]
    fn channels_of_two_clocks_are_refused_with_both() {
        let recording = two_clocks();
        recording.require_one_clock(["nail", "tip"]).unwrap();
        let said = recording
            .require_one_clock(["nail", "arm"])
            .unwrap_err()
            .to_string();
        for part in ["`nail`", "1000 Hz", "`arm`", "100 Hz", "0.25 s"] {
            assert!(said.contains(part), "no {part} in {said}");
        }
        assert!(recording.on_the_clock_of(["arm", "tip"]).is_err());
    }

    #[test]
    fn a_part_counts_from_its_own_first_sample() {
        let mut recording = two_clocks();
        recording.annotations.events = [0.1, 0.5]
            .map(|onset_s| Event {
                onset_s: Seconds(onset_s),
                duration_s: Seconds(0.0),
                kind: "mark".into(),
                value: None,
            })
            .into();
        let part = recording.on_the_clock_of(["arm"]).unwrap();
        assert_eq!((part.channels().len(), part.clocks().len()), (1, 1));
        assert_eq!(part.annotations.events.len(), 1);
        assert!((part.annotations.events[0].onset_s.0 - 0.25).abs() < 1e-12);
    }

    #[test]
    fn lengths_are_compared_within_a_clock() {
        let rate = SampleRate::new(10.0).unwrap();
        let of = |name: &str, count| {
            let channel = Channel {
                name: name.into(),
                unit: Unit::Newton,
                samples: vec![0.0; count],
            };
            (channel, Clock::at(rate))
        };
        let short = vec![of("a", 3), of("b", 2)];
        let made = Recording::with_clocks(short, Condition::default(), Provenance::default());
        assert!(matches!(made, Err(RecordingError::Length { .. })));
    }
}
