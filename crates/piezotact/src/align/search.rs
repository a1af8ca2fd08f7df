//! Blocks of a recording, and where each is in the drive.

use super::line::{FEWEST_BLOCKS, Found};
use super::matched::{Place, Searched, peaks};
use super::place::stretched;
use super::{AlignError, Prepared};
use crate::quantity::Seconds;
use crate::statistics::median;

/// So many blocks are looked for in the whole drive; the others near where these lead.
const ANYWHERE: usize = 12;
/// A smaller correlation of envelopes is no place.
pub(super) const LEAST: f64 = 0.35;
/// Another place with this share of the support of the best one makes it undecided.
pub(super) const ALIKE: f64 = 0.85;
/// Places nearer to each other than this are one, s; so far from its neighbours' line may a block be.
pub(super) const NEAR_S: f64 = 0.004;
/// A block with less than this share of the median energy is silent.
const SILENT: f64 = 0.05;
/// A part of the drive with more than this share of its mean power is loud.
const LOUD: f64 = 0.25;
/// A block whose envelope does not fall below this share within [`FAR_S`] has no place of its own.
const NARROW: f64 = 0.7;
/// How far, s.
pub(super) const FAR_S: f64 = 0.02;

/// Drive and recording in the band at one rate, the recording by a clock that is corrected for a drift.
pub(super) struct Blocks<'a> {
    both: &'a Prepared,
    /// A time by the clock of the recording over that by the corrected one.
    stretch: f64,
    recorded: Vec<f64>,
    length: usize,
    /// The first sample of each block.
    starts: Vec<usize>,
    /// Which of them are not silent.
    loud: Vec<bool>,
}

/// A time that is known on both clocks, s.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lead {
    pub(super) recorded_s: f64,
    pub(super) drive_s: f64,
}

/// What became of a block.
#[derive(Clone, Copy, Debug)]
pub(super) enum Looked {
    /// It has a place.
    At(Place),
    /// It is there, and the drive repeats around it so that it has no place of its own.
    Repeats,
    /// The drive is loud where it should be, and the block is not like it.
    Missed,
    /// It lies outside the drive, or where the drive is silent.
    Outside,
}

/// What became of each block, in the order of time.
#[derive(Clone, Debug, Default)]
pub(super) struct Placed {
    pub(super) found: Vec<Found>,
    /// The middles of blocks that are not where they should be, by the clock of the recording, s.
    pub(super) missed_s: Vec<f64>,
    /// The first samples of blocks in which the drive repeats, by the corrected clock.
    pub(super) repeating: Vec<usize>,
    /// The first samples of blocks that are not silent and have no place near where their neighbours lead, by the corrected clock.
    pub(super) lost: Vec<usize>,
}

impl<'a> Blocks<'a> {
    /// Blocks of the recording by a clock corrected for `drift_ppm`.
    pub(super) fn of(both: &'a Prepared, drift_ppm: f64) -> Result<Self, AlignError> {
        let length = both.rate.samples_in(both.config.block_s).max(16);
        let stretch = 1.0 + 1e-6 * drift_ppm;
        let recorded = stretched(&both.recorded, stretch);
        let count = recorded.len() / length;
        if count < FEWEST_BLOCKS || both.drive.len() < length {
            return Err(AlignError::FewBlocks { found: count });
        }
        let energies: Vec<f64> = recorded
            .chunks_exact(length)
            .map(|block| block.iter().map(|v| v * v).sum())
            .collect();
        let mut positive: Vec<f64> = energies.iter().copied().filter(|e| *e > 0.0).collect();
        let usual = median(&mut positive).unwrap_or(0.0);
        let loud = energies.iter();
        let loud: Vec<bool> = loud.map(|e| usual > 0.0 && *e >= SILENT * usual).collect();
        let found = loud.iter().filter(|loud| **loud).count();
        if found < FEWEST_BLOCKS {
            return Err(AlignError::FewBlocks { found });
        }
        Ok(Self {
            both,
            stretch,
            recorded,
            length,
            starts: (0..count).map(|i| i * length).collect(),
            loud,
        })
    }

    fn rate_hz(&self) -> f64 {
        self.both.rate.hz()
    }

    /// What became of each block, led by a time that is known on both clocks, else by blocks that are found anywhere.
    pub(super) fn placed(&self, lead: Option<Lead>) -> Result<Placed, AlignError> {
        let (first, lag) = match lead {
            Some(lead) => self.led(lead),
            None => {
                let (block, place) = self.anchor()?;
                (block, place.at - self.starts[block] as f64)
            }
        };
        let mut looked = vec![Looked::Outside; self.starts.len()];
        self.follow(first..self.starts.len(), (first, lag), &mut looked);
        self.follow((0..first).rev(), (first, lag), &mut looked);
        let half = 0.5 * self.length as f64;
        let mut placed = Placed::default();
        for ((start, looked), loud) in self.starts.iter().zip(looked).zip(&self.loud) {
            let recorded_s = self.stretch * (*start as f64 + half) / self.rate_hz();
            if *loud && matches!(looked, Looked::Missed | Looked::Outside) {
                placed.lost.push(*start);
            }
            match looked {
                Looked::At(place) => placed.found.push(Found {
                    recorded_s,
                    drive_s: (place.at + half) / self.rate_hz(),
                    correlation: place.correlation,
                }),
                Looked::Missed => placed.missed_s.push(recorded_s),
                Looked::Repeats => placed.repeating.push(*start),
                Looked::Outside => {}
            }
        }
        Ok(placed)
    }

    /// The block nearest to a time, and how much later blocks are in the drive, in samples.
    fn led(&self, lead: Lead) -> (usize, f64) {
        let at = lead.recorded_s / self.stretch * self.rate_hz();
        let block = (at / self.length as f64).floor().max(0.0) as usize;
        let last = self.starts.len() - 1;
        (block.min(last), lead.drive_s * self.rate_hz() - at)
    }

    /// Looks for blocks one after the other, each near where the last one that was found leads.
    fn follow(
        &self,
        order: impl Iterator<Item = usize>,
        lead: (usize, f64),
        looked: &mut [Looked],
    ) {
        let mut last = lead;
        for block in order {
            let far_s = self.starts[block].abs_diff(self.starts[last.0]) as f64 / self.rate_hz();
            let reach_s = NEAR_S + 1e-6 * self.both.config.most_drift_ppm * far_s;
            let expected = self.starts[block] as f64 + last.1;
            let reach = (reach_s * self.rate_hz()).ceil() as usize;
            let found = match self.loud[block] {
                true => self.near(block, expected, reach),
                false if self.drive_power(expected) >= LOUD => Looked::Missed,
                false => Looked::Outside,
            };
            if let Looked::At(place) = found {
                last = (block, place.at - self.starts[block] as f64);
            }
            looked[block] = found;
        }
    }

    /// The power of the drive where a block begins at `at`, over its mean; 0 where it lies partly outside.
    fn drive_power(&self, at: f64) -> f64 {
        let (from, to) = (at, at + self.length as f64);
        if from < 0.0 || to > self.both.drive.len() as f64 {
            return 0.0;
        }
        let part = &self.both.drive[from as usize..to as usize];
        let power = part.iter().map(|v| v * v).sum::<f64>() / self.length as f64;
        match self.both.usual > 0.0 {
            true => power / self.both.usual,
            false => 0.0,
        }
    }

    /// The block that is most certain, and where: by the support that the places of other blocks give.
    fn anchor(&self) -> Result<(usize, Place), AlignError> {
        let loud: Vec<usize> = (0..self.starts.len()).filter(|i| self.loud[*i]).collect();
        let step = loud.len().div_ceil(ANYWHERE);
        let chosen: Vec<usize> = loud.into_iter().step_by(step).collect();
        let everywhere = self.everywhere(&chosen);
        let lag = |at: usize, place: &Place| place.at - self.starts[chosen[at]] as f64;
        let tolerance = |a: usize, b: usize| {
            let far = self.starts[chosen[a]].abs_diff(self.starts[chosen[b]]) as f64;
            NEAR_S * self.rate_hz() + 1e-6 * self.both.config.most_drift_ppm * far
        };
        let mut hypotheses: Vec<(f64, usize, Place)> = Vec::new();
        for (at, places) in everywhere.iter().enumerate() {
            for place in places {
                let support = everywhere.iter().enumerate().map(|(other, others)| {
                    let fits = others.iter().filter(|one| {
                        (lag(other, one) - lag(at, place)).abs() <= tolerance(at, other)
                    });
                    fits.map(|one| one.correlation).fold(0.0, f64::max)
                });
                hypotheses.push((support.sum(), at, *place));
            }
        }
        let largest = |one: &(f64, usize, Place)| one.0;
        let best = hypotheses
            .iter()
            .copied()
            .max_by(|a, b| largest(a).total_cmp(&largest(b)))
            .ok_or(AlignError::NotThere { correlation: 0.0 })?;
        // Of the blocks that lead to the same place the one that fits best.
        let same = |one: &&(f64, usize, Place)| {
            let away = (lag(one.1, &one.2) - lag(best.1, &best.2)).abs();
            away <= tolerance(one.1, best.1)
        };
        let own = hypotheses.iter().filter(same);
        let anchor = own
            .max_by(|a, b| a.2.correlation.total_cmp(&b.2.correlation))
            .unwrap_or(&best);
        if anchor.2.correlation < LEAST {
            return Err(AlignError::NotThere {
                correlation: anchor.2.correlation,
            });
        }
        // As far apart as the largest drift makes them over the whole recording: nearer ones support each other.
        let widest = tolerance(0, chosen.len() - 1);
        let is_other =
            |one: &&(f64, usize, Place)| (lag(one.1, &one.2) - lag(best.1, &best.2)).abs() > widest;
        let other = hypotheses.iter().filter(is_other);
        if let Some(other) = other.max_by(|a, b| largest(a).total_cmp(&largest(b)))
            && other.0 >= ALIKE * best.0
        {
            return Err(AlignError::SeveralPlaces {
                first_s: lag(best.1, &best.2) / self.rate_hz(),
                second_s: lag(other.1, &other.2) / self.rate_hz(),
            });
        }
        Ok((chosen[anchor.1], anchor.2))
    }

    /// The first sample of the block whose middle is at a time of the recording.
    pub(super) fn start_of(&self, recorded_s: f64) -> usize {
        let at = recorded_s / self.stretch * self.rate_hz() - 0.5 * self.length as f64;
        at.round().max(0.0) as usize
    }

    /// The halves of blocks that begin at `starts` which have one place of their own in the whole drive, with at least the correlation `least`:
    /// where samples are missing, the parts before and behind are at other places than a line leads to.
    pub(super) fn halves_anywhere(&self, starts: &[usize], least: f64) -> Vec<Found> {
        let drive = &self.both.drive;
        let half = self.length / 2;
        let searched = Searched::of(drive, half, half, self.both.usual);
        let near = (NEAR_S * self.rate_hz()) as usize;
        let lags = drive.len() + half;
        let seconds = half as f64 / self.rate_hz();
        let cells = (self.both.config.band.high().0 - self.both.config.band.low().0) * seconds;
        // What the largest of so many correlations with noise reaches, and half as much again.
        let least = least.max(1.5 * ((lags as f64).ln() / cells).sqrt());
        let power = |samples: &[f64]| samples.iter().map(|v| v * v).sum::<f64>();
        let all = power(&self.recorded) / self.recorded.len() as f64;
        let of = |start: usize| {
            let own = self.recorded.get(start..start + half)?;
            if power(own) < SILENT * all * half as f64 {
                return None;
            }
            let common = searched.common(own);
            let places = peaks(&common.correlations(lags), near);
            let (first, second) = (places.first()?, places.get(1));
            let alone = second.is_none_or(|other| other.correlation < ALIKE * first.correlation);
            (first.correlation >= least && alone).then(|| Found {
                recorded_s: self.stretch * (start as f64 + 0.5 * half as f64) / self.rate_hz(),
                drive_s: (first.at - half as f64 + 0.5 * half as f64) / self.rate_hz(),
                correlation: first.correlation,
            })
        };
        let halves = starts.iter().flat_map(|start| [*start, start + half]);
        halves.filter_map(of).collect()
    }

    /// The best places of each of these blocks in the whole drive.
    fn everywhere(&self, chosen: &[usize]) -> Vec<Vec<Place>> {
        // A block before the drive holds its beginning too: `length` samples of silence come first.
        let drive = &self.both.drive;
        let searched = Searched::of(drive, self.length, self.length, self.both.usual);
        let near = (NEAR_S * self.rate_hz()) as usize;
        let of = |block: &usize| {
            let common = searched.common(self.block(self.starts[*block]));
            let places = peaks(&common.correlations(drive.len() + self.length), near);
            let places = places.into_iter().map(|place| Place {
                at: place.at - self.length as f64,
                ..place
            });
            places.collect()
        };
        chosen.iter().map(of).collect()
    }

    /// The samples of the block that begins at `start`.
    fn block(&self, start: usize) -> &[f64] {
        &self.recorded[start..start + self.length]
    }

    /// The drive from `first` on, with silence outside.
    fn drive_part(&self, first: i64, count: usize) -> Vec<f64> {
        let value = |at: i64| {
            let at = usize::try_from(at).ok();
            at.and_then(|at| self.both.drive.get(at)).copied()
        };
        (first..first + count as i64)
            .map(|at| value(at).unwrap_or(0.0))
            .collect()
    }

    /// What became of a block within `reach` samples of `expected`.
    fn near(&self, block: usize, expected: f64, reach: usize) -> Looked {
        let first = expected.round() as i64 - reach as i64;
        let wide = self.length + 2 * reach;
        if first + wide as i64 <= 0 || first >= self.both.drive.len() as i64 {
            return Looked::Outside;
        }
        let missed = match self.drive_power(expected) >= LOUD {
            true => Looked::Missed,
            false => Looked::Outside,
        };
        let part = self.drive_part(first, wide);
        let searched = Searched::of(&part, self.length, 0, self.both.usual);
        let common = searched.common(self.block(self.starts[block]));
        let correlations = common.correlations(2 * reach + 1);
        let Some(coarse) = peaks(&correlations, reach.max(1)).first().copied() else {
            return missed;
        };
        if coarse.correlation < LEAST {
            return missed;
        }
        if !self.is_distinct(first + coarse.at.round() as i64) {
            return Looked::Repeats;
        }
        let (place, _) = common.refined(coarse.at);
        if place.at < 0.5 || place.at > 2.0 * reach as f64 - 0.5 {
            return missed;
        }
        Looked::At(Place {
            at: first as f64 + place.at,
            ..place
        })
    }

    /// Whether the part of the drive from `first` on has one place among those around it.
    fn is_distinct(&self, first: i64) -> bool {
        let far = (FAR_S * self.rate_hz()).ceil() as usize;
        let part = self.drive_part(first - far as i64, self.length + 2 * far);
        let searched = Searched::of(&part, self.length, 0, self.both.usual);
        let own = &part[far..far + self.length];
        let values = searched.common(own).correlations(2 * far + 1);
        let sides = [
            values[far..].to_vec(),
            values[..=far].iter().rev().copied().collect(),
        ];
        sides.iter().all(|side| {
            let fallen = side.iter().position(|value| *value < NARROW);
            fallen.is_some_and(|at| side[at..].iter().all(|value| *value < ALIKE))
        })
    }

    /// The phases of blocks in which the drive repeats against the drive at `offset`, as times since the first of neighbouring ones,
    /// and the standard error of each, s: where the clock runs evenly they are all 0. One list for each part that repeats.
    pub(super) fn phase_times(&self, repeating: &[usize], offset: Seconds) -> Vec<Vec<[f64; 2]>> {
        let mut runs: Vec<Vec<[f64; 2]>> = Vec::new();
        let mut last: Option<(usize, f64)> = None;
        for start in repeating {
            let at = *start as f64 + offset.0 * self.rate_hz();
            let margin = 8;
            let first = at.floor() as i64 - margin;
            let part = self.drive_part(first, self.length + 2 * margin as usize);
            let searched = Searched::of(&part, self.length, 0, self.both.usual);
            let common = searched.common(self.block(*start));
            let value = common.between(at - first as f64);
            let (place, _) = common.refined(at - first as f64);
            let (phase, hz) = (value.arg(), common.frequency() * self.rate_hz());
            let share = place.correlation.clamp(0.05, 0.9999).powi(2);
            let cells = self.both.config.band.high().0 - self.both.config.band.low().0;
            let cells = cells * self.length as f64 / self.rate_hz();
            let error = ((1.0 - share) / (2.0 * cells * share)).sqrt();
            let of_radian = 1.0 / (std::f64::consts::TAU * hz.max(1.0));
            let joins = last.filter(|(before, _)| {
                before + self.length == *start && self.is_continued(first + margin)
            });
            match (joins, runs.last_mut()) {
                (Some((_, before)), Some(run)) => {
                    let turn = std::f64::consts::TAU;
                    let step = phase - before;
                    let step = step - turn * (step / turn).round();
                    let sum = run.last().map_or(0.0, |[time, _]| *time) + step * of_radian;
                    run.push([sum, error * of_radian]);
                }
                _ => runs.push(vec![[0.0, error * of_radian]]),
            }
            last = Some((*start, phase));
        }
        runs
    }

    /// Whether the block of the drive before `first` is like the one that begins there.
    fn is_continued(&self, first: i64) -> bool {
        let near = (NEAR_S * self.rate_hz()).ceil() as usize;
        let before = first - self.length as i64 - near as i64;
        let part = self.drive_part(before, self.length + 2 * near);
        let searched = Searched::of(&part, self.length, 0, self.both.usual);
        let own = self.drive_part(first, self.length);
        let values = searched.common(&own).correlations(2 * near + 1);
        values.into_iter().fold(0.0, f64::max) >= ALIKE
    }
}
