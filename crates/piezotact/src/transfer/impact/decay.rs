//! How the response to a hit decays, octave by octave: when it is at rest, and how much of it is left at the end of a segment.
//!
//! What is there before the hits as well (noise, hum, the tremor of a hand) does not decay and is no remainder of a hit: every
//! octave is judged above its own level at rest. So a weak resonance of low frequency that lasts is seen beside a strong one
//! of high frequency that does not.

use std::ops::Range;

use super::segments::{AT_REST, MOST_LEFT};
use crate::filter::Octave;
use crate::quantity::{Hertz, SampleRate};
use crate::statistics::{mean, median, rms};

/// The lowest octave begins at this many times the reciprocal of the time that is judged.
const LOWEST: f64 = 10.0;
/// The level is that of blocks of one period of the lowest frequency, of this part of the time, and of so many samples at least.
const BLOCKS: usize = 200;
const SHORTEST: usize = 16;
/// So many blocks before the first hit tell the level at rest.
const LEAST_AT_REST: usize = 4;
/// A level is that of the response above 1 + this/√n times the level at rest, where n values of a block are independent. Without
/// rest before the hits, a level that does not fall by as much from the third to the last quarter is noise.
const ABOVE_REST: f64 = 3.0;
/// An octave below this part of the level of all is too weak to spoil a hit: −30 dB.
const WEAK: f64 = 0.03;
/// An octave counts when its largest level is this many times what is taken for rest.
const COUNTS: f64 = 5.0;
/// The response is largest in this part of the time after the hit, or in the first three blocks.
const EARLY: usize = 4;
/// An octave whose neighbour has this many times its level left may show the edge of what is left there.
const EDGE: f64 = 2.5;
/// Independent values of a block over all frequencies, where hum and tremor count for most.
const OF_ALL: usize = 8;
/// The value before a hit is the mean over this part of the time.
const BEFORE: usize = 10;
/// The end of a segment is this part of it.
const END: usize = 20;

/// What the decay is judged by.
pub(super) struct Judged<'a> {
    pub(super) response: &'a [f64],
    pub(super) rate: SampleRate,
    /// Where the hits begin that are judged, and their peaks.
    pub(super) hits: &'a [(usize, f64)],
    /// For how long after each, samples.
    pub(super) reach: usize,
    /// The length of a pulse, samples.
    pub(super) pulse: usize,
    /// The part before the first hit.
    pub(super) quiet: Range<usize>,
}

/// The mean decay of the response to several hits.
pub(super) struct Decay {
    octaves: Vec<Curve>,
    /// Over all frequencies, for a response that has hardly decayed: a baseline that drifts is none of a few per cent.
    whole: Option<Curve>,
    pulse: usize,
}

/// What is left of a response.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Left {
    /// Its level re its largest, 0–1.
    pub(super) share: f64,
    /// Its level per unit of the force.
    pub(super) level: f64,
    /// In which octave; absent where it is over all frequencies.
    pub(super) octave_hz: Option<[f64; 2]>,
}

/// The level of one octave after the hits, per unit of the force.
struct Curve {
    /// From where to where; absent for all frequencies.
    octave_hz: Option<[f64; 2]>,
    levels: Vec<f64>,
    /// The length of a block, samples.
    block: usize,
    largest: f64,
    /// At this level and below it is at rest.
    rest: f64,
}

impl Decay {
    /// The decay of the response.
    pub(super) fn of(judged: &Judged<'_>) -> Self {
        let hz = judged.rate.hz();
        let rest = mean(&judged.response[judged.quiet.clone()]);
        let lowest = LOWEST * hz / judged.reach.max(1) as f64;
        let mut octaves = Vec::new();
        let mut filtered = Vec::with_capacity(judged.response.len());
        let mut low = lowest;
        while low < 0.25 * hz {
            Octave::above(Hertz(low), judged.rate).run(judged.response, rest, &mut filtered);
            let octave_hz = Some([low, (2.0 * low).min(0.5 * hz)]);
            octaves.extend(Curve::of(&filtered, judged, octave_hz));
            low *= 2.0;
        }
        let whole = Curve::of(judged.response, judged, None);
        Self {
            octaves,
            whole,
            pulse: judged.pulse,
        }
    }

    /// After how many samples the response is at rest, 40 dB below its largest level or in its noise; nothing where no octave
    /// stands out.
    pub(super) fn until_rest(&self) -> Option<usize> {
        let ends = self.octaves.iter().map(|curve| {
            let limit = curve.rest.max(AT_REST * curve.largest);
            let moving = curve.levels.iter().rposition(|level| *level > limit);
            self.pulse + moving.map_or(0, |last| last + 1) * curve.block
        });
        ends.max()
    }

    /// The level that is left `after` so many samples re the largest, of the octave that has decayed least.
    pub(super) fn left(&self, after: usize) -> Left {
        self.most(after, 0.0)
    }

    /// The same of the octaves that are not weak.
    pub(super) fn spoils(&self, after: usize) -> Left {
        let levels = self.octaves.iter().map(|curve| curve.largest);
        self.most(after, WEAK * levels.fold(0.0, f64::max))
    }

    fn most(&self, after: usize, least: f64) -> Left {
        let until = after.saturating_sub(self.pulse);
        // Nothing can be told of a few samples.
        if until < LEAST_AT_REST * SHORTEST {
            return Left {
                share: 1.0,
                ..Left::default()
            };
        }
        let octaves = self.octaves.iter().filter(|curve| {
            let neighbours = self.octaves.iter().filter(|other| other.borders(curve));
            let beside = neighbours
                .map(|other| other.level_at(until))
                .fold(0.0, f64::max);
            curve.tells(until) && curve.largest >= least && beside <= EDGE * curve.level_at(until)
        });
        let whole = self
            .whole
            .iter()
            .filter(|curve| curve.left(until) > MOST_LEFT);
        let lefts = octaves.chain(whole).map(|curve| Left {
            share: curve.left(until),
            level: curve.level_at(until),
            octave_hz: curve.octave_hz,
        });
        lefts.fold(Left::default(), |most, left| {
            if left.share > most.share { left } else { most }
        })
    }
}

impl Curve {
    /// The curve of the octave in `signal`; of the signal itself about its value before each hit where there is none. None where
    /// the response does not stand out.
    fn of(signal: &[f64], judged: &Judged<'_>, octave_hz: Option<[f64; 2]>) -> Option<Self> {
        let offset = octave_hz.is_none();
        let period = octave_hz.map_or(0, |[low, _]| (judged.rate.hz() / low) as usize);
        let span = judged.reach.saturating_sub(judged.pulse);
        let block = (span / BLOCKS).max(period).max(SHORTEST);
        // Long enough for hum and the like to be nothing in the mean.
        let before = block.max(span / BEFORE);
        let levels_of = |start: usize, peak: f64| -> Vec<f64> {
            let from = (start + judged.pulse).min(signal.len());
            let part = &signal[from..(from + span).min(signal.len())];
            let about = if offset {
                mean(&signal[start.saturating_sub(before)..start.max(1)])
            } else {
                0.0
            };
            let level = |block: &[f64]| {
                let squares: f64 = block.iter().map(|v| (v - about).powi(2)).sum();
                (squares / block.len() as f64).sqrt() / peak.abs()
            };
            let blocks = part.chunks(block).filter(|part| 2 * part.len() >= block);
            blocks.map(level).collect()
        };
        let each: Vec<Vec<f64>> = judged
            .hits
            .iter()
            .map(|(start, peak)| levels_of(*start, *peak))
            .collect();
        let blocks = each.iter().map(Vec::len).min()?;
        let levels: Vec<f64> = (0..blocks)
            .filter_map(|k| median(&mut each.iter().map(|of| of[k]).collect::<Vec<f64>>()))
            .collect();
        let largest = levels.iter().copied().fold(0.0, f64::max);
        let mut peaks: Vec<f64> = judged.hits.iter().map(|(_, peak)| peak.abs()).collect();
        let peak = median(&mut peaks).unwrap_or(1.0);
        let quiet = &signal[judged.quiet.clone()];
        let about = if offset { mean(quiet) } else { 0.0 };
        let mut at_rest: Vec<f64> = quiet
            .chunks_exact(block)
            .map(|part| rms(&part.iter().map(|v| v - about).collect::<Vec<_>>()) / peak)
            .collect();
        // An octave of noise has as many independent values as its width times the time, twice.
        let independent = (2 * block).checked_div(period).unwrap_or(OF_ALL).max(1);
        let above = |blocks: usize| 1.0 + ABOVE_REST / ((blocks * independent) as f64).sqrt();
        let rest = if at_rest.len() >= LEAST_AT_REST {
            above(1) * median(&mut at_rest).unwrap_or(0.0)
        } else {
            let quarter = (levels.len() / 4).max(1);
            let last = steady(&levels, quarter, above(quarter * each.len()));
            // A response that has hardly decayed is no noise: none of an octave, which need not be excited.
            if offset && last > MOST_LEFT * largest {
                0.0
            } else {
                above(1) * last
            }
        };
        // What is largest long after the hit is no response to it.
        let early = offset
            || levels
                .iter()
                .position(|level| *level >= largest)
                .unwrap_or(0)
                <= (levels.len() / EARLY).max(2);
        (early && largest > COUNTS * rest).then_some(Self {
            octave_hz,
            levels,
            block,
            largest,
            rest,
        })
    }

    /// The level of the last blocks within the first `until` samples and the place of its largest; 0 at rest.
    fn end(&self, until: usize) -> (f64, usize) {
        let last = (until / self.block).clamp(1, self.levels.len().max(1));
        let last = last.min(self.levels.len());
        let from = last.saturating_sub((last / END).max(1));
        let end = self.levels[from..last].iter().copied().zip(from..);
        let (level, at) = end.fold((0.0, from), |a, b| if b.0 > a.0 { b } else { a });
        (if level <= self.rest { 0.0 } else { level }, at)
    }

    fn level_at(&self, until: usize) -> f64 {
        self.end(until).0
    }

    /// Whether the first `until` samples hold blocks enough to tell.
    fn tells(&self, until: usize) -> bool {
        until / self.block.max(1) >= LEAST_AT_REST && self.levels.len() >= LEAST_AT_REST
    }

    /// The level after `until` samples re that at the beginning, 0–1: as it falls from the largest block to the last, carried on to
    /// both ends.
    fn left(&self, until: usize) -> f64 {
        let (level, at) = self.end(until);
        let first = self.levels.iter().position(|level| *level >= self.largest);
        let falls = at.saturating_sub(first.unwrap_or(0));
        let ratio = (level / self.largest).min(1.0);
        if falls == 0 {
            return ratio;
        }
        ratio.powf(until as f64 / (falls * self.block) as f64)
    }

    /// Whether it is the octave above or below the other one.
    fn borders(&self, other: &Self) -> bool {
        match (self.octave_hz, other.octave_hz) {
            (Some([low, _]), Some([from, _])) => {
                let ratio = (low / from).log2().abs();
                ratio > 0.5 && ratio < 1.5
            }
            _ => false,
        }
    }
}

/// The level of the last quarter where it does not fall from the third by more than `ratio`: noise. Else 0.
fn steady(levels: &[f64], quarter: usize, ratio: f64) -> f64 {
    let Some(third) = levels.len().checked_sub(2 * quarter) else {
        return 0.0;
    };
    let (third, last) = levels[third..].split_at(quarter);
    if ratio * rms(last) > rms(third) {
        rms(last)
    } else {
        0.0
    }
}
