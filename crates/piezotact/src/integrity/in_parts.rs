//! The inspection of a recording that comes part by part, as one larger than memory does.

use super::copied::Copy;
use super::level::RESTS;
use super::pair::{Beyond, Broken, Pair, copied_pairs};
use super::{Defects, ROUNDING, Span, defects_of, holds_codes};
use crate::clipping::step;
use crate::quantity::Unit;
use crate::recording::Recording;
use crate::warning::{Warning, Warnings};

/// An extreme this close to that of the whole channel, as a share of its range, is the same limit.
const SAME_LIMIT: f64 = 1e-9;

/// What is found in the parts of a recording.
///
/// Each part is inspected as a recording of its own. Of the whole channel, it is dead where all parts are; clipped are the samples of those
/// parts at a limit that is the extreme of the channel; it hums where most parts do; a value that is held in several parts is its rest; and
/// channels are copies that are so in every part, with one delay.
///
/// Source: as [`super::warnings_of`]; docs/decisions/signals.md.
#[derive(Clone, Debug, Default)]
pub struct InParts {
    channels: Vec<OfChannel>,
    copies: Option<Vec<Copied>>,
    limit_fraction: f64,
    samples: usize,
}

/// A channel, in its parts.
#[derive(Clone, Debug)]
struct OfChannel {
    name: String,
    unit: Unit,
    beyond: Beyond,
    parts: Vec<Part>,
}

#[derive(Clone, Debug)]
struct Part {
    from: usize,
    low: f64,
    high: f64,
    /// The step of the converter, and the value of each frozen part.
    step: f64,
    held: Vec<f64>,
    defects: Defects,
}

#[derive(Clone, Debug)]
struct Copied {
    names: [String; 2],
    copy: Copy,
    rate_hz: f64,
}

impl InParts {
    /// Nothing yet; `limit_fraction` is the largest drive that can be played, of full scale.
    #[must_use]
    pub fn new(limit_fraction: f64) -> Self {
        Self {
            limit_fraction,
            ..Self::default()
        }
    }

    /// Inspects the next part, of the same channels.
    pub fn add(&mut self, part: &Recording) {
        let from = self.samples;
        self.samples += part.len();
        let mut channels = part.channels_with_clocks();
        if self.channels.is_empty() {
            let of = part.channels().iter().map(|channel| OfChannel {
                name: channel.name.clone(),
                unit: channel.unit.clone(),
                beyond: Beyond::default(),
                parts: Vec::new(),
            });
            self.channels = of.collect();
        }
        for of in &mut self.channels {
            let Some((channel, clock)) = channels.next() else {
                return;
            };
            if holds_codes(&channel.name) {
                continue;
            }
            let samples = &channel.samples;
            let defects = defects_of(part, channel, clock);
            let ends = samples.iter().copied();
            let held = defects.frozen.iter().map(|span| samples[span.from]);
            of.parts.push(Part {
                from,
                low: ends.clone().fold(f64::INFINITY, f64::min),
                high: ends.fold(f64::NEG_INFINITY, f64::max),
                held: held.collect(),
                step: match defects.frozen.is_empty() {
                    true => 0.0,
                    false => step(samples),
                },
                defects,
            });
            if channel.unit == Unit::FullScale {
                of.beyond.add(samples, self.limit_fraction);
            }
        }
        self.add_copies(part);
    }

    /// Keeps the copies that are copies in this part too; where one of the two is dead, nothing is known.
    fn add_copies(&mut self, part: &Recording) {
        let is_dead = |name: &str| {
            let mut channels = self.channels.iter();
            let of = channels.find(|of| of.name == name);
            of.and_then(|of| of.parts.last())
                .is_some_and(|part| part.defects.dead)
        };
        let found = || {
            let found = copied_pairs(part, None).into_iter();
            found.map(|(names, copy, clock)| Copied {
                names: names.map(str::to_owned),
                copy,
                rate_hz: clock.rate_hz.hz(),
            })
        };
        let Some(copies) = &mut self.copies else {
            // A part in which channels rest says nothing of all.
            let changes = !part.channels().iter().any(|channel| is_dead(&channel.name));
            self.copies = changes.then(|| found().collect());
            return;
        };
        if copies.is_empty() {
            return;
        }
        let found: Vec<Copied> = found().collect();
        copies.retain(|known| {
            let mut found = found.iter();
            known.names.iter().any(|name| is_dead(name))
                || found.any(|one| one.names == known.names && one.copy.later == known.copy.later)
        });
    }

    /// The warnings about all channels, of each and of pairs.
    #[must_use]
    pub fn warnings(&self) -> Warnings {
        self.warnings_but(|_, defects| defects, None, None)
    }

    /// As [`Self::warnings`], but for what is `broken` in a `pair` of channels and told of both together.
    pub(crate) fn warnings_beside(&self, pair: &Pair<'_>, broken: &Broken) -> Warnings {
        let names = [pair.drive_name, pair.response_name];
        let beside = |name: &str, defects| broken.beside(pair, name, defects);
        let beyond = broken.beyond.as_ref().map(|_| pair.drive_name);
        self.warnings_but(beside, beyond, broken.copied.map(|_| names))
    }

    fn warnings_but(
        &self,
        beside: impl Fn(&str, Defects) -> Defects,
        beyond: Option<&str>,
        copied: Option<[&str; 2]>,
    ) -> Warnings {
        let mut warnings = Warnings::new();
        for of in &self.channels {
            let Some(defects) = of.defects() else {
                continue;
            };
            warnings.extend(beside(&of.name, defects).warnings(&of.name));
            if of.unit == Unit::FullScale && beyond != Some(of.name.as_str()) {
                let beyond = of.beyond.warning(&of.name, self.limit_fraction);
                warnings.extend(beyond.map(Warning::from));
            }
        }
        for known in self.copies.iter().flatten() {
            let [copy, of] = [0, 1].map(|k| known.names[k].as_str());
            let is_told = copied.is_some_and(|told| told.contains(&copy) && told.contains(&of));
            if !is_told {
                let warning = known.copy.warning(copy, of, known.rate_hz);
                warnings.extend([Warning::from(warning)]);
            }
        }
        warnings
    }

    /// The share of the samples of the channel `name` at a limit, 0–1.
    pub(crate) fn clipped(&self, name: &str) -> f64 {
        let of = self.channels.iter().find(|of| of.name == name);
        of.and_then(OfChannel::defects)
            .map_or(0.0, |defects| defects.clipped_fraction)
    }

    /// Whether the channel `name` never changes.
    pub(crate) fn is_dead(&self, name: &str) -> bool {
        let of = self.channels.iter().find(|of| of.name == name);
        of.and_then(OfChannel::defects)
            .is_some_and(|defects| defects.dead)
    }
}

impl OfChannel {
    /// The defects of the whole channel; `None` of one that was not inspected.
    fn defects(&self) -> Option<Defects> {
        let first = self.parts.first()?;
        let samples: usize = self.parts.iter().map(|part| part.defects.samples).sum();
        let low = self.parts.iter().map(|p| p.low).fold(f64::MAX, f64::min);
        let high = self.parts.iter().map(|p| p.high).fold(f64::MIN, f64::max);
        let mut all = Defects {
            dead: self.parts.iter().all(|part| part.defects.dead)
                && high - low <= ROUNDING * high.abs().max(low.abs()),
            frozen: Vec::new(),
            gaps: Vec::new(),
            hum: None,
            clipped_fraction: 0.0,
            samples,
            rate: first.defects.rate,
        };
        if all.dead {
            return Some(all);
        }
        let step = self.parts.iter().map(|part| part.step).fold(0.0, f64::max);
        let held = self.parts.iter().flat_map(|part| &part.held);
        let often = |value: f64| {
            let alike = held
                .clone()
                .filter(|other| (*other - value).abs() <= 1.5 * step);
            value != 0.0 && alike.count() >= RESTS
        };
        let (mut clipped, mut hums) = (0.0, Vec::new());
        for part in &self.parts {
            let later = |span: &Span| Span {
                from: span.from + part.from,
                to: span.to + part.from,
            };
            let frozen = part.defects.frozen.iter().zip(&part.held);
            let frozen = frozen.filter(|(_, value)| !often(**value));
            all.frozen.extend(frozen.map(|(span, _)| later(span)));
            all.gaps.extend(part.defects.gaps.iter().map(later));
            let near = SAME_LIMIT * (high - low);
            if part.low - low <= near || high - part.high <= near {
                clipped += part.defects.clipped_fraction * part.defects.samples as f64;
            }
            hums.extend(part.defects.hum.clone());
        }
        all.clipped_fraction = clipped / samples as f64;
        if 2 * hums.len() > self.parts.len() {
            hums.sort_by(|a, b| a.share.total_cmp(&b.share));
            all.hum = Some(hums.swap_remove(hums.len() / 2));
        }
        Some(all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrity::warnings_of;
    use crate::quantity::SampleRate;
    use crate::recording::{Channel, Condition, Provenance};
    use crate::statistics::random::Random;

    const PARTS: usize = 6;
    const LENGTH: usize = 15_000;

    /// Noise in m/s² and N and a drive, with what `change` makes of the sample `i` of each.
    fn recording(change: impl Fn(usize, &mut [f64; 3])) -> Recording {
        let mut random = Random::stream(3, 0, "parts");
        let mut samples: [Vec<f64>; 3] = Default::default();
        for i in 0..PARTS * LENGTH {
            let mut all = [random.normal(), random.normal(), 0.3 * random.normal()];
            change(i, &mut all);
            for (samples, value) in samples.iter_mut().zip(all) {
                samples.push(value);
            }
        }
        let names = ["a", "fz", "drive"];
        let units = [Unit::MetrePerSecondSquared, Unit::Newton, Unit::FullScale];
        let channels = names.into_iter().zip(units).zip(samples);
        let channels = channels.map(|((name, unit), samples)| Channel {
            name: name.into(),
            unit,
            samples,
        });
        of(channels.collect())
    }

    fn of(channels: Vec<Channel>) -> Recording {
        let rate = SampleRate::new(5000.0).unwrap();
        Recording::new(channels, rate, Condition::default(), Provenance::default()).unwrap()
    }

    fn in_parts(recording: &Recording) -> Vec<Warning> {
        let mut parts = InParts::new(10.0);
        for k in 0..PARTS {
            let part = recording.channels().iter().map(|channel| Channel {
                samples: channel.samples[k * LENGTH..(k + 1) * LENGTH].to_vec(),
                ..channel.clone()
            });
            parts.add(&of(part.collect()));
        }
        parts.warnings().into()
    }

    /// The faults that are found, and where.
    fn faults(warnings: &[Warning]) -> Vec<String> {
        let fault = |warning: &Warning| warning.fields["fault"].as_str().unwrap_or("?").to_owned();
        warnings.iter().map(fault).collect()
    }

    /// The warnings in parts, which are those of the whole.
    fn same(change: impl Fn(usize, &mut [f64; 3])) -> Vec<Warning> {
        let recording = recording(change);
        let whole: Vec<Warning> = warnings_of(&recording, 10.0).into();
        let parts = in_parts(&recording);
        assert_eq!(parts, whole);
        parts
    }

    #[test]
    fn nothing_is_found_where_nothing_is_broken() {
        assert_eq!(same(|_, _| ()), []);
        // A channel that rests in a part is no dead one, and its neighbours no copies.
        assert_eq!(
            same(|i, all| all[1] *= f64::from(u8::from(i >= LENGTH))),
            []
        );
        // Each part has extremes of its own; the largest of a part is no limit of the channel.
        let softer = |i: usize| 1.0 / (1.0 + (i / LENGTH) as f64);
        let limited = recording(|i, all| all[0] = (all[0] * softer(i)).min(1.5 * softer(i)));
        let found = in_parts(&limited);
        let share = |warning: &Warning| format!("{warning}").contains("at a limit");
        assert!(found.iter().filter(|w| share(w)).count() <= 1, "{found:?}");
    }

    #[test]
    fn what_is_broken_over_all_parts_is_found_as_in_the_whole() {
        let dead = same(|_, all| all[0] = 2.5);
        assert_eq!(faults(&dead), ["dead"]);
        let beyond = same(|_, all| all[2] *= 30.0);
        assert_eq!(beyond.len(), 1);
        // A part is held in the fourth part: its time is that in the recording.
        let at = 3 * LENGTH + 7000;
        let frozen = same(|i, all| {
            if (at..at + 800).contains(&i) {
                all[0] = 0.77;
            }
        });
        assert_eq!(frozen.len(), 1);
        let copy = in_parts(&recording(|_, all| all[1] = 0.5 * all[0]));
        assert_eq!(faults(&copy), ["copied"]);
        // In the first part alone it is none.
        let part = |i: usize, all: &mut [f64; 3]| {
            if i < LENGTH {
                all[1] = 0.5 * all[0];
            }
        };
        assert_eq!(in_parts(&recording(part)), []);
    }

    #[test]
    fn hum_of_most_parts_is_hum() {
        let hum = |from: usize| {
            move |i: usize, all: &mut [f64; 3]| {
                let t = i as f64 / 5000.0;
                let lines = [1.0, 3.0, 5.0].map(|n| (std::f64::consts::TAU * 50.0 * n * t).sin());
                if i >= from {
                    all[0] += lines.iter().sum::<f64>();
                }
            }
        };
        let found = in_parts(&recording(hum(LENGTH)));
        assert_eq!(faults(&found), ["mains_hum"]);
        assert_eq!(in_parts(&recording(hum(4 * LENGTH))), []);
    }
}
