//! Readings of a force on the clock of a sound device.

use crate::force::ForceError;
use piezotact::recording::{Clocks, LostBy, RecordingWarning};
use std::collections::VecDeque;
use std::time::Instant;

use piezotact::Warning;
use piezotact::quantity::SampleRate;

use super::ForceReading;
use super::late::{ClockSkewEstimator, Mapping};

/// A larger uncertainty of times is a warning, s: a hand moves by 3 Hz, so that within 20 ms its force changes by a few mN.
const MOST_UNCERTAIN_S: f64 = 0.02;
/// A longer time without readings is a warning, s.
const LONGEST_WITHOUT_WARNING_S: f64 = 0.1;
/// Readings that wait for their frames; the oldest go first.
const MOST_WAITING: usize = 65_536;
/// How often it is noted where frames were placed, s, and after how many notes it is looked at again, with what is known then.
const NOTED_EVERY_S: f64 = 0.005;
const LOOKED_AGAIN_AFTER: usize = 4096;
/// Intervals between arrivals that are kept to say how far apart they are.
const ARRIVALS: usize = 64;

/// How a force is joined.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JoinerConfig {
    /// The rate of the frames.
    pub rate: SampleRate,
    /// The longest time without readings that is interpolated, s.
    pub longest_pause_s: f64,
    /// How much later than measured a reading arrives at the least, s: what the amplifier averages over and the port takes. It cannot be
    /// found from the readings; it moves all of them.
    pub least_delay_s: f64,
    /// The same of a frame of the sound device: what its converters and buffers take at the least, s.
    pub least_frame_delay_s: f64,
}

/// Puts readings of a force on the clock of a sound device: the force at every frame, by linear interpolation.
///
/// Both clocks are seen through arrivals that are late by a delay that varies: those of frames by the callback, those of readings by
/// port and system. Each clock is the line through its least late arrivals over the last minute. Readings without a time of their device
/// are taken as measured when they arrived; of several that arrive at once, evenly since the arrival before.
///
/// The force of a frame is known when readings on both sides of it have come.
/// Memory is bounded: of the readings that wait for frames the oldest go first.
#[derive(Debug)]
pub struct ForceJoiner {
    config: JoinerConfig,
    origin: Option<Instant>,
    frames: ClockSkewEstimator,
    /// Frames that arrived, and when the last of them did, s.
    arrived: u64,
    arrived_s: f64,
    given: u64,
    clock: ClockSkewEstimator,
    clock_number: u32,
    waiting: VecDeque<Waiting>,
    /// Readings without device time of the last arrival, which are not placed yet.
    together: Vec<f64>,
    last_reading_s: Option<f64>,
    /// The last time of the device, and when the one that was later than all before came, s.
    last_device_s: Option<f64>,
    went_on_s: Option<f64>,
    before_together_s: Option<f64>,
    intervals_s: VecDeque<f64>,
    has_device_times: bool,
    /// Readings without device time came several at once.
    has_batches: bool,
    /// The uncertainty of the clocks: the largest since they were settled, else the last one.
    uncertainty_s: Option<f64>,
    settled: bool,
    noted: VecDeque<Noted>,
    /// How far frames were placed from where they lie by what was known later, s.
    moved_s: f64,
    gaps: Gaps,
}

/// Where a frame was placed: its time by the clock of the frames, and by that of the device, s.
#[derive(Clone, Copy, Debug)]
struct Noted {
    frame_s: f64,
    device_s: f64,
}

/// A reading that waits for its frames.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    place: Place,
    force_n: f64,
    /// The gap before it was counted.
    counted: bool,
}

/// When a reading was measured.
#[derive(Clone, Copy, Debug)]
enum Place {
    /// By the clock of the device, s.
    Device(f64),
    /// By that of the computer, s since the origin.
    Computer(f64),
}

impl Noted {
    /// How far it lies from where it was placed, by these clocks, s.
    fn moved_s(&self, frames: &Mapping, device: &Mapping) -> f64 {
        (frames.at(self.frame_s) - device.at(self.device_s)).abs()
    }
}

#[derive(Clone, Copy, Debug, Default)]
struct Gaps {
    count: usize,
    longest_s: f64,
    total_s: f64,
}

impl Gaps {
    fn add(&mut self, gap_s: f64) {
        if gap_s > LONGEST_WITHOUT_WARNING_S {
            self.count += 1;
            self.total_s += gap_s;
            self.longest_s = self.longest_s.max(gap_s);
        }
    }
}

impl ForceJoiner {
    /// A joiner before the first frame.
    #[must_use]
    pub fn new(config: JoinerConfig) -> Self {
        Self {
            config,
            origin: None,
            frames: ClockSkewEstimator::default(),
            arrived: 0,
            arrived_s: 0.0,
            given: 0,
            clock: ClockSkewEstimator::default(),
            clock_number: 0,
            waiting: VecDeque::new(),
            together: Vec::new(),
            last_reading_s: None,
            last_device_s: None,
            went_on_s: None,
            before_together_s: None,
            intervals_s: VecDeque::new(),
            has_device_times: false,
            has_batches: false,
            uncertainty_s: None,
            settled: false,
            noted: VecDeque::new(),
            moved_s: 0.0,
            gaps: Gaps::default(),
        }
    }

    /// The callback of the input ran at `at`, after which `frames` had arrived since its start.
    pub fn frames(&mut self, at: Instant, frames: u64) {
        if frames <= self.arrived {
            return;
        }
        let at_s = self.seconds(at);
        self.arrived = frames;
        self.arrived_s = at_s;
        self.frames
            .event(frames as f64 / self.config.rate.hz(), at_s);
    }

    /// A reading, in the order of arrival.
    pub fn reading(&mut self, reading: &ForceReading) {
        let at_s = self.seconds(reading.at);
        if reading.clock != self.clock_number {
            self.place_by_computer();
            self.clock = ClockSkewEstimator::default();
            self.clock_number = reading.clock;
            self.last_device_s = None;
        }
        match reading.device_s {
            Some(device_s) => {
                self.has_device_times = true;
                self.place_together();
                if self.last_device_s.is_none_or(|last_s| device_s > last_s) {
                    self.last_device_s = Some(device_s);
                    self.went_on_s = Some(at_s);
                }
                self.clock.event(device_s, at_s);
                self.wait(Place::Device(device_s), reading.force_n);
            }
            None => {
                if self.last_reading_s.is_some_and(|last_s| last_s < at_s) {
                    self.place_together();
                }
                self.together.push(reading.force_n);
            }
        }
        if let Some(last_s) = self.last_reading_s
            && at_s > last_s
        {
            if self.intervals_s.len() == ARRIVALS {
                self.intervals_s.pop_front();
            }
            self.intervals_s.push_back(at_s - last_s);
            self.before_together_s = Some(last_s);
        }
        self.last_reading_s = Some(at_s);
    }

    /// The force, N, at the next frames, `most` of them at most; fewer where readings on both sides have not come yet, and none
    /// before both clocks were seen for half a second.
    ///
    /// # Errors
    /// [`ForceError::Stale`] when no reading came for longer than the longest pause.
    pub fn next(&mut self, most: usize) -> Result<Vec<f64>, ForceError> {
        let (Some(frames), Some(device)) = (
            self.frames.mapping(),
            self.device(ClockSkewEstimator::mapping),
        ) else {
            self.check_pause()?;
            return Ok(Vec::new());
        };
        self.state_uncertainty(&frames, device.as_ref());
        if let Some(device) = &device {
            self.note(&frames, device);
        }
        let force_n = self.interpolate(most, &frames, device.as_ref())?;
        // Within a batch one line holds, so that its ends are furthest off.
        if let Some(device) = device.as_ref().filter(|_| !force_n.is_empty()) {
            self.note(&frames, device);
        }
        if force_n.is_empty() && self.given < self.arrived {
            self.check_pause()?;
        }
        Ok(force_n)
    }

    /// The force, N, at the frames that are left, up to `frames` since the start, after the last reading; behind it the force stays.
    ///
    /// # Errors
    /// [`ForceError::Stale`] when the readings end earlier than the longest pause before the last frame; [`ForceError::Nothing`] when there
    /// are none at all, or no frame arrived.
    pub fn finish(&mut self, frames: u64) -> Result<Vec<f64>, ForceError> {
        self.place_together();
        self.arrived = frames.max(self.given);
        let frames = self.frames.mapping_by_any().ok_or(ForceError::Nothing {
            expected: "frames of sound",
        })?;
        let device =
            self.device(ClockSkewEstimator::mapping_by_any)
                .ok_or(ForceError::Nothing {
                    expected: "readings of the force",
                })?;
        self.state_uncertainty(&frames, device.as_ref());
        let mut force_n = self.interpolate(usize::MAX, &frames, device.as_ref())?;
        let Some(last) = self.waiting.front().copied() else {
            return Err(ForceError::Nothing {
                expected: "readings of the force",
            });
        };
        let left = self.arrived - self.given;
        if left > 0 {
            let end_s = self.frame_s(&frames, self.arrived - 1);
            self.allow(end_s - self.place_s(last.place, device.as_ref()))?;
            force_n.extend((0..left).map(|_| last.force_n));
            self.given = self.arrived;
        }
        Ok(force_n)
    }

    /// How far the force that was given is behind the frames that arrived, s.
    #[cfg(test)]
    fn held_back_s(&self) -> f64 {
        (self.arrived - self.given) as f64 / self.config.rate.hz()
    }

    /// How far the times of the force may be off, s, besides the least delays of the configuration; none before both clocks were
    /// seen. What the clocks leave open, and how far frames were placed from where they lie by what was known later.
    #[must_use]
    pub fn uncertainty_s(&self) -> Option<f64> {
        let clocks = (
            self.frames.mapping_by_any(),
            self.device(ClockSkewEstimator::mapping_by_any).flatten(),
        );
        let moved_s = match clocks {
            (Some(frames), Some(device)) => {
                let noted = self.noted.iter();
                noted
                    .map(|one| one.moved_s(&frames, &device))
                    .fold(self.moved_s, f64::max)
            }
            _ => self.moved_s,
        };
        self.uncertainty_s.map(|clocks_s| clocks_s + moved_s)
    }

    /// What the force leaves open.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        let uncertain = self.uncertainty_s().filter(|u| *u > MOST_UNCERTAIN_S);
        let uncertain = uncertain.map(|uncertainty_s| {
            Warning::from(RecordingWarning::ClocksDiffer {
                of: Clocks::Force {
                    uncertainty_s,
                    most_s: MOST_UNCERTAIN_S,
                },
            })
        });
        let Gaps {
            count,
            longest_s,
            total_s,
        } = self.gaps;
        let gaps = (count > 0).then(|| {
            Warning::from(RecordingWarning::SamplesLost {
                by: LostBy::Force {
                    gaps: count,
                    longest_s,
                    total_s,
                    longer_than_s: LONGEST_WITHOUT_WARNING_S,
                },
            })
        });
        uncertain.into_iter().chain(gaps).collect()
    }

    /// Seconds since the first event, which may be below 0.
    fn seconds(&mut self, at: Instant) -> f64 {
        let origin = *self.origin.get_or_insert(at);
        match at.checked_duration_since(origin) {
            Some(after) => after.as_secs_f64(),
            None => -origin.saturating_duration_since(at).as_secs_f64(),
        }
    }

    fn wait(&mut self, place: Place, force_n: f64) {
        if self.waiting.len() == MOST_WAITING {
            self.waiting.pop_front();
        }
        self.waiting.push_back(Waiting {
            place,
            force_n,
            counted: false,
        });
    }

    /// Places the readings of the last arrival evenly since the one before, or since a usual interval where that is shorter.
    fn place_together(&mut self) {
        let Some(at_s) = self.last_reading_s else {
            return;
        };
        let since_s = self
            .before_together_s
            .map_or(0.0, |before_s| at_s - before_s);
        let since_s = self
            .usual_interval_s()
            .map_or(since_s, |u| since_s.min(2.0 * u));
        let together = std::mem::take(&mut self.together);
        let count = together.len();
        self.has_batches |= count > 1;
        for (i, force_n) in together.into_iter().enumerate() {
            let before_s = since_s * (count - 1 - i) as f64 / count as f64;
            self.wait(Place::Computer(at_s - before_s), force_n);
        }
    }

    /// Readings of a clock that began again keep the times that they have by the computer's.
    fn place_by_computer(&mut self) {
        let mapping = self.clock.mapping_by_any();
        for waiting in &mut self.waiting {
            if let (Place::Device(device_s), Some(mapping)) = (waiting.place, &mapping) {
                waiting.place = Place::Computer(mapping.at(device_s));
            }
        }
    }

    /// The median interval between arrivals.
    fn usual_interval_s(&self) -> Option<f64> {
        self.interval_s(0.5)
    }

    /// The interval between arrivals than which `share` of them (0 to 1) are shorter.
    fn interval_s(&self, share: f64) -> Option<f64> {
        let mut intervals: Vec<f64> = self.intervals_s.iter().copied().collect();
        intervals.sort_by(f64::total_cmp);
        intervals
            .get((share * intervals.len() as f64) as usize)
            .copied()
    }

    /// How far readings without device times may be off: an interval where they come several at once, since they may have been
    /// measured at any time within it, and otherwise by how much one interval in ten is longer than usual.
    fn arrivals_uncertain_s(&self) -> f64 {
        let usual_s = self.usual_interval_s().unwrap_or(0.0);
        match self.has_batches {
            true => usual_s,
            false => self.interval_s(0.9).map_or(0.0, |long_s| long_s - usual_s),
        }
    }

    /// The mapping of the device's clock, where there is one; none while it is not known yet.
    fn device(
        &self,
        mapping: fn(&ClockSkewEstimator) -> Option<Mapping>,
    ) -> Option<Option<Mapping>> {
        match self.has_device_times {
            true => mapping(&self.clock).map(Some),
            false => self.last_reading_s.map(|_some| None),
        }
    }

    fn state_uncertainty(&mut self, frames: &Mapping, device: Option<&Mapping>) {
        let of_readings = device.map_or_else(
            || self.arrivals_uncertain_s(),
            |device| device.uncertainty_s,
        );
        let now_s = frames.uncertainty_s.hypot(of_readings);
        let settled = frames.settled && device.is_none_or(|device| device.settled);
        // Before the clocks are settled it is the latest one that holds, as frames are looked at again.
        let before = match (device, self.settled) {
            (Some(_), false) => None,
            _ => self.uncertainty_s,
        };
        self.uncertainty_s = Some(before.map_or(now_s, |u| u.max(now_s)));
        self.settled |= settled;
    }

    /// Notes where the next frame is placed, and looks again at what was noted long before.
    fn note(&mut self, frames: &Mapping, device: &Mapping) {
        let frame_s = self.given as f64 / self.config.rate.hz();
        let last = self.noted.back();
        if last.is_some_and(|last| frame_s - last.frame_s < NOTED_EVERY_S) {
            return;
        }
        self.noted.push_back(Noted {
            frame_s,
            device_s: device.of(frames.at(frame_s)),
        });
        if self.noted.len() > LOOKED_AGAIN_AFTER
            && let Some(first) = self.noted.pop_front()
        {
            self.moved_s = self.moved_s.max(first.moved_s(frames, device));
        }
    }

    fn frame_s(&self, frames: &Mapping, frame: u64) -> f64 {
        frames.at(frame as f64 / self.config.rate.hz()) - self.config.least_frame_delay_s
    }

    fn place_s(&self, place: Place, device: Option<&Mapping>) -> f64 {
        let seen_s = match (place, device) {
            (Place::Device(device_s), Some(mapping)) => mapping.at(device_s),
            (Place::Device(seen_s), None) | (Place::Computer(seen_s), _) => seen_s,
        };
        seen_s - self.config.least_delay_s
    }

    /// Refuses a time without readings that is too long.
    fn allow(&self, pause_s: f64) -> Result<(), ForceError> {
        if pause_s <= self.config.longest_pause_s {
            return Ok(());
        }
        Err(ForceError::Stale {
            pause_s,
            longest_s: self.config.longest_pause_s,
        })
    }

    /// Whether a reading came lately, by the arrivals of frames.
    fn check_pause(&self) -> Result<(), ForceError> {
        let first_s = self.arrived_s - self.arrived as f64 / self.config.rate.hz();
        let last_s = self.last_reading_s.unwrap_or(first_s);
        self.allow(self.arrived_s - last_s)?;
        let stood_s = self.went_on_s.map_or(0.0, |on_s| self.arrived_s - on_s);
        match self.has_device_times && stood_s > self.config.longest_pause_s {
            true => Err(ForceError::ClockStands { pause_s: stood_s }),
            false => Ok(()),
        }
    }

    fn interpolate(
        &mut self,
        most: usize,
        frames: &Mapping,
        device: Option<&Mapping>,
    ) -> Result<Vec<f64>, ForceError> {
        let mut force_n = Vec::new();
        while self.given < self.arrived && force_n.len() < most {
            let t_s = self.frame_s(frames, self.given);
            let [left, right] = loop {
                let next = self.waiting.get(1).copied();
                let (Some(first), Some(next)) = (self.waiting.front().copied(), next) else {
                    return Ok(force_n);
                };
                let next_s = self.place_s(next.place, device);
                if next_s > t_s {
                    break [(self.place_s(first.place, device), first), (next_s, next)];
                }
                self.waiting.pop_front();
            };
            let ((left_s, left), (right_s, right)) = (left, right);
            if t_s < left_s {
                // Before the first reading the force is as there.
                self.allow(left_s - t_s)?;
                if !left.counted {
                    self.gaps.add(left_s - t_s);
                    self.count_first();
                }
                force_n.push(left.force_n);
            } else {
                let gap_s = right_s - left_s;
                self.allow(gap_s)?;
                if !right.counted {
                    self.gaps.add(gap_s);
                    if let Some(right) = self.waiting.get_mut(1) {
                        right.counted = true;
                    }
                }
                let share = (t_s - left_s) / gap_s;
                force_n.push(left.force_n + share * (right.force_n - left.force_n));
            }
            self.given += 1;
        }
        Ok(force_n)
    }

    fn count_first(&mut self) {
        if let Some(first) = self.waiting.front_mut() {
            first.counted = true;
        }
    }
}

#[cfg(test)]
mod tests;
