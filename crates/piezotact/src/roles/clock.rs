//! A motion on a clock of its own, as of a camera or an encoder, placed on the clock of what vibrates.

use std::ops::Range;

use super::{Motion, Roles};
use crate::quantity::{SampleRate, Unit};
use crate::recording::{Clock, Clocks, Recording, RecordingError, RecordingWarning};
use crate::warning::Warning;

impl Roles {
    /// The channels of `recording` on the clock of those that play a part, and the samples in which the motion was measured, in one
    /// range or several: all of them where there is none, or where it has their clock.
    ///
    /// A motion with a clock of its own is placed on that of vibration and forces, with a warning that states its rate and how much later
    /// it begins. Up to one of its own periods before its first and behind its last sample it stays where it is; farther away nothing
    /// moves. Where more than ten samples of it were lost, it was not measured.
    ///
    /// Formula: x(t) = x₀ + (x₁ − x₀)(t − t₀)/(t₁ − t₀) between the samples x₀ and x₁ around t.
    ///
    /// Source: docs/decisions/strokes.md.
    ///
    /// # Errors
    /// [`RecordingError::Clocks`] where vibration and forces have no clock in common, and where nothing of the motion was measured while
    /// they were.
    pub fn on_one_clock(
        &self,
        mut recording: Recording,
    ) -> Result<(Recording, Vec<Range<usize>>), RecordingError> {
        let others = Self {
            motion: None,
            ..self.clone()
        };
        let mut measured = None;
        if let (Some(motion), Some(other)) = (&self.motion, others.channels().next()) {
            recording.require_one_clock(others.channels())?;
            let clocks = [motion.channel(), other].map(|name| recording.clock_of(name));
            if clocks[0] != clocks[1] {
                let within = place(&mut recording, (motion, clocks[0]), (other, clocks[1]))?;
                measured = Some(without_lost(within, &recording, clocks));
            }
        }
        let recording = recording.on_the_clock_of(self.channels())?;
        let all = 0..recording.len();
        let measured = measured.unwrap_or_else(|| vec![all]);
        Ok((recording, measured))
    }
}

/// As many samples of a motion are needed to say that a finger stood or turned between them.
const LONGEST_LOSS: f64 = 10.0;

/// `within`, in samples of the second clock, without the stretches in which more than ten samples of the first one were lost.
fn without_lost(
    within: Range<usize>,
    recording: &Recording,
    [motion, clock]: [Clock; 2],
) -> Vec<Range<usize>> {
    let longest_s = LONGEST_LOSS / motion.rate_hz.hz();
    let sample = |s: f64| ((s - clock.start_s.0) * clock.rate_hz.hz()).max(0.0);
    let mut measured = Vec::new();
    let mut start = within.start;
    for &[from_s, to_s] in &recording.about.provenance.losses.stretches_s {
        if to_s - from_s > longest_s {
            let lost = [
                sample(from_s).floor() as usize,
                sample(to_s).ceil() as usize,
            ];
            measured.push(start..lost[0].min(within.end));
            start = start.max(lost[1]);
        }
    }
    measured.push(start..within.end);
    measured.retain(|range| !range.is_empty());
    measured
}

/// Places `motion` on the clock of `other`; gives the samples there in which it was measured.
fn place(
    recording: &mut Recording,
    (motion, own): (&Motion, Clock),
    (other, clock): (&str, Clock),
) -> Result<Range<usize>, RecordingError> {
    let name = motion.channel();
    let count = recording.pick(Some(other), &Unit::Newton)?.samples.len();
    let moved = &recording.pick(Some(name), &Unit::Metre)?.samples;
    let later_s = own.start_s.0 - clock.start_s.0;
    let (mut samples, measured) = placed(moved, (own.rate_hz, later_s), (clock.rate_hz, count));
    if matches!(motion, Motion::Speed(_)) {
        samples[..measured.start].fill(0.0);
        samples[measured.end..].fill(0.0);
    }
    if measured.is_empty() {
        return Err(RecordingError::Clocks {
            first: other.into(),
            of_first: clock,
            channel: name.into(),
            found: own,
        });
    }
    let [from_s, to_s] =
        [measured.start, measured.end].map(|sample| clock.rate_hz.duration_of(sample).0);
    let of = Clocks::Motion {
        channel: name.into(),
        rate_hz: own.rate_hz.hz(),
        later_s,
        onto: other.into(),
        onto_hz: clock.rate_hz.hz(),
        outside: (measured.len() < count).then_some([from_s, to_s]),
    };
    recording.put_on_clock(name, samples, clock);
    let warning = Warning::from(RecordingWarning::ClocksDiffer { of });
    recording.about.warnings.push(warning);
    Ok(measured)
}

/// `samples` at a rate, the first of them `later_s` after time 0, at `count` times of another rate; with those of them that lie within
/// one of their own periods of a sample.
fn placed(
    samples: &[f64],
    (own, later_s): (SampleRate, f64),
    (rate, count): (SampleRate, usize),
) -> (Vec<f64>, Range<usize>) {
    let Some(last) = samples.len().checked_sub(1) else {
        return (vec![0.0; count], 0..0);
    };
    // Places among the samples, by their index; a clock that is read from a file is right to about this.
    let place = |at: usize| (rate.duration_of(at).0 - later_s) * own.hz();
    const SLACK: f64 = 1e-6;
    let at = |at: usize| {
        let place = place(at).clamp(0.0, last as f64);
        let before = (place as usize).min(last);
        let after = (before + 1).min(last);
        let share = place - before as f64;
        samples[before] + share * (samples[after] - samples[before])
    };
    let is_within = |at: &usize| (-1.0 - SLACK..=last as f64 + 1.0 + SLACK).contains(&place(*at));
    let start = (0..count).find(is_within).unwrap_or(count);
    let end = (start..count)
        .rev()
        .find(is_within)
        .map_or(start, |at| at + 1);
    ((0..count).map(at).collect(), start..end)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::Seconds;
    use crate::recording::{Channel, Condition, Provenance};

    fn clock(hz: f64, start_s: f64) -> Clock {
        Clock {
            rate_hz: SampleRate::new(hz).unwrap(),
            start_s: Seconds(start_s),
        }
    }

    fn channel(name: &str, unit: Unit, samples: Vec<f64>) -> Channel {
        Channel {
            name: name.into(),
            unit,
            samples,
        }
    }

    /// 2 s of vibration at 5 kHz with a motion of `seconds` at 200 Hz, `later_s` after it.
    fn tracked(unit: Unit, later_s: f64, seconds: f64, x: impl Fn(f64) -> f64) -> Recording {
        let nail = channel("nail", Unit::MetrePerSecondSquared, vec![0.0; 10_000]);
        let count = (200.0 * seconds).round() as usize;
        let x = (0..count).map(|i| x(later_s + i as f64 / 200.0)).collect();
        Recording::with_clocks(
            vec![
                (nail, clock(5000.0, 0.0)),
                (channel("x", unit, x), clock(200.0, later_s)),
            ],
            Condition::default(),
            Provenance::default(),
        )
        .unwrap()
    }

    fn only(measured: &[Range<usize>]) -> Range<usize> {
        assert_eq!(measured.len(), 1);
        measured[0].clone()
    }

    #[test]
    fn position_of_a_camera_is_placed_by_time_with_its_offset() {
        for later_s in [-0.2513, -0.001, 0.0013, 0.25] {
            let way = |t: f64| 0.03 * t;
            let made = tracked(Unit::Metre, later_s, 2.5, way);
            let (roles, _) = Roles::guess(&made);
            let (placed, measured) = roles.on_one_clock(made).unwrap();
            assert_eq!((placed.clocks().len(), placed.len()), (1, 10_000));
            let x = &placed.pick(Some("x"), &Unit::Metre).unwrap().samples;
            // What is before the first sample of the camera, but for a period of 5 ms, was not measured.
            let unmeasured_s: f64 = (later_s - 0.005).max(0.0);
            let start = (unmeasured_s * 5000.0).ceil() as usize;
            assert_eq!(only(&measured), start..10_000);
            let inside = start + 30;
            for (at, found_m) in x.iter().enumerate().skip(inside) {
                let true_m = way(at as f64 / 5000.0);
                assert!(
                    (found_m - true_m).abs() < 1e-12,
                    "{at}: {found_m} for {true_m}"
                );
            }
            let said = placed.about.warnings[0].to_string();
            let offset = format!("{:.3} s", later_s.abs());
            for part in ["`x`", "200 Hz", "5000 Hz", &offset] {
                assert!(said.contains(part), "no {part} in {said}");
            }
        }
    }

    #[test]
    fn speed_that_was_not_measured_is_no_motion() {
        let made = tracked(Unit::MetrePerSecond, 0.5, 1.0, |_| 0.03);
        let (roles, _) = Roles::guess(&made);
        let (placed, measured) = roles.on_one_clock(made).unwrap();
        assert_eq!(only(&measured), 2475..7501);
        let v = &placed.pick(Some("x"), &Unit::Metre).unwrap().samples;
        let moves = |at: &usize| v[*at] > 0.0;
        assert_eq!((0..v.len()).filter(moves).count(), measured[0].len());
        let said = placed.about.warnings[0].to_string();
        assert!(said.contains("from 0.495 s to 1.500 s"), "{said}");
    }

    #[test]
    fn motion_of_another_time_is_refused_with_both_clocks() {
        let made = tracked(Unit::Metre, 10.0, 1.0, |t| t);
        let (roles, _) = Roles::guess(&made);
        let said = roles.on_one_clock(made).unwrap_err().to_string();
        for part in ["`nail`", "`x`", "10 s"] {
            assert!(said.contains(part), "no {part} in {said}");
        }
    }

    #[test]
    fn motion_on_the_same_clock_is_left_as_it_is() {
        let channels = vec![
            channel("nail", Unit::MetrePerSecondSquared, vec![1.0; 100]),
            channel("x", Unit::Metre, (0..100).map(f64::from).collect()),
        ];
        let rate = SampleRate::new(1000.0).unwrap();
        let made =
            Recording::new(channels, rate, Condition::default(), Provenance::default()).unwrap();
        let (roles, _) = Roles::guess(&made);
        let (same, measured) = roles.on_one_clock(made.clone()).unwrap();
        assert_eq!((same, only(&measured)), (made, 0..100));
    }

    #[test]
    fn motion_that_was_lost_for_ten_samples_was_not_measured_there() {
        let mut made = tracked(Unit::Metre, 0.0, 2.0, |t| t);
        // Three samples, which a line stands for, and a hundred.
        made.about.provenance.losses.stretches_s = vec![[0.4, 0.415], [1.0, 1.5]];
        let (roles, _) = Roles::guess(&made);
        let (_, measured) = roles.on_one_clock(made).unwrap();
        assert_eq!(measured, [0..5000, 7500..10_000]);
    }
}
