//! One clock by another, from events that are seen late.

use piezotact::statistics::median;
use std::collections::VecDeque;

/// Of the events within this time only the one that was least late counts, s.
const SPAN_S: f64 = 0.5;
/// Spans that are kept: a bit more than a minute.
const MOST_SPANS: usize = 128;
/// Two clocks do not differ by more: quartz is within 1e-4, ceramic resonators of microcontrollers within 5e-3.
const MOST_DRIFT: f64 = 0.01;
/// From so many spans on the least late events say how late they are.
const ENOUGH_SPANS: usize = 8;

/// Pairs of a device's time and the time at which the computer saw it, which is later by a delay that varies and is never below zero.
///
/// The line through the least late events: among all lines below the events the one with the least sum of distances, which is the edge of
/// their lower convex hull at the middle of their times.
///
/// Source: S. B. Moon, P. Skelly and D. Towsley (1999), Estimation and removal of clock skew from network delay measurements, INFOCOM.
#[derive(Clone, Debug, Default)]
pub(super) struct ClockSkewEstimator {
    spans: VecDeque<Span>,
}

/// The events of one span.
#[derive(Clone, Copy, Debug)]
struct Span {
    number: i64,
    /// The least late one: by the device, and how much later it was seen, s.
    device_s: f64,
    late_s: f64,
    latest_s: f64,
}

/// The computer's time of a device's time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mapping {
    from_s: f64,
    late_s: f64,
    drift: f64,
    /// How far a time may be off, s, besides what all events are late.
    pub(super) uncertainty_s: f64,
    /// Whether there were enough events to know how late the least late ones are.
    pub(super) settled: bool,
}

impl Mapping {
    /// When the computer would have seen `device_s`, had it been seen as early as possible, s.
    pub(super) fn at(&self, device_s: f64) -> f64 {
        device_s + self.late_s + self.drift * (device_s - self.from_s)
    }

    /// The device's time that the computer would have seen at `seen_s`.
    pub(super) fn of(&self, seen_s: f64) -> f64 {
        (seen_s - self.late_s + self.drift * self.from_s) / (1.0 + self.drift)
    }
}

impl ClockSkewEstimator {
    /// An event at `device_s`, not before the one before, that was seen at `seen_s`.
    pub(super) fn event(&mut self, device_s: f64, seen_s: f64) {
        let number = (device_s / SPAN_S).floor() as i64;
        let late_s = seen_s - device_s;
        match self.spans.back_mut() {
            Some(last) if last.number == number => {
                last.latest_s = last.latest_s.max(late_s);
                if late_s < last.late_s {
                    (last.device_s, last.late_s) = (device_s, late_s);
                }
            }
            Some(last) if last.number > number => {}
            _ => {
                if self.spans.len() == MOST_SPANS {
                    self.spans.pop_front();
                }
                self.spans.push_back(Span {
                    number,
                    device_s,
                    late_s,
                    latest_s: late_s,
                });
            }
        }
    }

    /// The mapping by the events so far; none before there are two spans.
    pub(super) fn mapping(&self) -> Option<Mapping> {
        if self.spans.len() < 2 {
            return None;
        }
        self.mapping_by_any()
    }

    /// The same from whatever there is.
    pub(super) fn mapping_by_any(&self) -> Option<Mapping> {
        let middle_s =
            self.spans.iter().map(|span| span.device_s).sum::<f64>() / self.spans.len() as f64;
        let drift = self.edge(middle_s)?.clamp(-MOST_DRIFT, MOST_DRIFT);
        let above = |span: &Span, late_s: f64| late_s - drift * (span.device_s - middle_s);
        let late_s = self
            .spans
            .iter()
            .map(|span| above(span, span.late_s))
            .fold(f64::INFINITY, f64::min);
        let mut rest: Vec<f64> = match self.spans.len() {
            ENOUGH_SPANS.. => (self.spans.iter())
                .map(|span| above(span, span.late_s) - late_s)
                .collect(),
            // Too few to know how late the least late ones are: as late as any.
            _ => (self.spans.iter())
                .map(|span| above(span, span.latest_s) - late_s)
                .collect(),
        };
        let uncertainty_s = match rest.len() {
            ENOUGH_SPANS.. => median(&mut rest)?,
            _ => rest.into_iter().max_by(f64::total_cmp)?,
        };
        Some(Mapping {
            from_s: middle_s,
            late_s,
            drift,
            uncertainty_s,
            settled: self.spans.len() >= ENOUGH_SPANS,
        })
    }

    /// The slope of the lower convex hull of the least late events at `middle_s`; 0 where there is one event.
    fn edge(&self, middle_s: f64) -> Option<f64> {
        let mut hull: Vec<(f64, f64)> = Vec::with_capacity(self.spans.len());
        for Span {
            device_s, late_s, ..
        } in &self.spans
        {
            while let [.., (x0, y0), (x1, y1)] = hull[..]
                && (x1 - x0) * (late_s - y0) <= (y1 - y0) * (device_s - x0)
            {
                hull.pop();
            }
            hull.push((*device_s, *late_s));
        }
        let slope = |pair: &[(f64, f64)]| match pair {
            [(x0, y0), (x1, y1)] if x1 > x0 => (y1 - y0) / (x1 - x0),
            _ => 0.0,
        };
        hull.first()?;
        let edge = hull.windows(2).find(|pair| pair[1].0 >= middle_s);
        Some(edge.map_or(0.0, slope))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::statistics::random::Random;

    /// A clock that is 200 ppm fast, seen 3 ms late and up to 20 ms later: the line is within 0.3 ms of the least delay after a minute,
    /// since every span of 0.5 s holds 40 delays and the least of them lies 0.5 ms above it on average.
    #[test]
    fn the_least_late_events_say_the_line() {
        let mut clock = ClockSkewEstimator::default();
        let mut random = Random::stream(3, 0, "late");
        for i in 0..4_800 {
            let true_s = f64::from(i) / 80.0;
            let device_s = true_s * (1.0 + 200e-6);
            clock.event(device_s, 100.0 + true_s + 0.003 + 0.02 * random.uniform());
        }
        let mapping = clock.mapping().unwrap();
        for true_s in [0.0, 30.0, 60.0] {
            let error_s = mapping.at(true_s * (1.0 + 200e-6)) - (100.0 + true_s + 0.003);
            assert!(error_s.abs() < 0.3e-3, "{true_s} s: {error_s:e}");
        }
        assert!(mapping.uncertainty_s < 1e-3, "{}", mapping.uncertainty_s);
    }

    /// One event a span: the values of the linear program, by `golden/force_clock.py` (SciPy 1.17.1).
    #[test]
    fn the_line_is_that_of_the_linear_program() {
        let mut clock = ClockSkewEstimator::default();
        for i in 0..60 {
            let i = f64::from(i);
            let device_s = 0.5 * i + 0.1;
            let late_s = 7.0 - 150e-6 * device_s + 0.004 * (1.0 + (0.37 * i * i).sin());
            clock.event(device_s, device_s + late_s);
        }
        let mapping = clock.mapping().unwrap();
        // The program printed twelve and seven digits.
        assert!((mapping.late_s - 6.997_831_205_027).abs() < 1e-11);
        assert!((mapping.drift + 1.471_290e-4).abs() < 1e-10);
    }

    #[test]
    fn few_events_are_uncertain() {
        let mut clock = ClockSkewEstimator::default();
        assert_eq!(clock.mapping_by_any(), None);
        clock.event(0.1, 5.0);
        clock.event(0.2, 5.108);
        assert_eq!(clock.mapping(), None);
        let mapping = clock.mapping_by_any().unwrap();
        // The second was 8 ms later than the first.
        assert!((mapping.at(0.15) - 5.05).abs() < 1e-12);
        assert!((mapping.uncertainty_s - 0.008).abs() < 1e-12);
    }

    /// Memory does not grow, and a time far off the line (here earlier than possible) moves the drift no further than clocks differ.
    #[test]
    fn it_is_bounded() {
        let mut clock = ClockSkewEstimator::default();
        for i in 0..100_000 {
            clock.event(f64::from(i), f64::from(i) + 1.0);
        }
        clock.event(100_000.0, 0.0);
        assert_eq!(clock.spans.len(), MOST_SPANS);
        assert!(clock.mapping().unwrap().drift.abs() <= MOST_DRIFT);
    }
}
