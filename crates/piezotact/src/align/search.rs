//! Blocks of a recording, and where each is in the drive.

use super::{AlignConfig, AlignError};
use crate::fourier::{Complex, ComplexPlanner, RealTransform, fast_length};
use crate::quantity::{Band, SampleRate};

/// So many blocks are looked for in the whole drive; the others near where these lead.
const ANYWHERE: usize = 12;
/// So many places of a block are kept.
const PLACES: usize = 6;
/// A smaller correlation of envelopes is no place.
const LEAST: f64 = 0.35;
/// Another place with this share of the support of the best one makes it undecided.
const ALIKE: f64 = 0.85;
/// Places nearer to each other than this are one, s; so far from its neighbours' line may a block be.
const NEAR_S: f64 = 0.004;
/// A block with less than this share of the median energy is silent.
const SILENT: f64 = 0.05;

/// One block where it was found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    /// The middle of the block, by the clock of the recording, s.
    pub(super) recorded_s: f64,
    /// The same by the clock of the drive, s.
    pub(super) drive_s: f64,
    pub(super) correlation: f64,
}

/// Drive and recording in the band, at one rate.
pub(super) struct Blocks<'a> {
    config: &'a AlignConfig,
    rate_hz: f64,
    drive: Vec<f64>,
    /// Sums of squares of the drive before each sample.
    energy: Vec<f64>,
    recorded: Vec<f64>,
    length: usize,
    /// The first sample of each block that is not silent.
    starts: Vec<usize>,
}

/// A place of a block in the drive: the sample of its start, between samples, and the correlation.
#[derive(Clone, Copy, Debug)]
struct Place {
    at: f64,
    correlation: f64,
}

impl<'a> Blocks<'a> {
    pub(super) fn of(
        drive: &[f64],
        recorded: &[f64],
        rate: SampleRate,
        config: &'a AlignConfig,
    ) -> Result<Self, AlignError> {
        let length = rate.samples_in(config.block_s).max(16);
        let count = recorded.len() / length;
        if count < super::FEWEST_BLOCKS || drive.len() < length {
            return Err(AlignError::FewBlocks { found: count });
        }
        let drive = within(drive, rate, config.band);
        let recorded = within(recorded, rate, config.band);
        let mut energy = Vec::with_capacity(drive.len() + 1);
        let mut sum = 0.0;
        energy.push(0.0);
        for value in &drive {
            sum += value * value;
            energy.push(sum);
        }
        let energies: Vec<f64> = recorded
            .chunks_exact(length)
            .map(|block| block.iter().map(|v| v * v).sum())
            .collect();
        let mut sorted: Vec<f64> = energies.iter().copied().filter(|e| *e > 0.0).collect();
        sorted.sort_by(f64::total_cmp);
        let usual = sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
        let loud = |(i, energy): (usize, &f64)| {
            (usual > 0.0 && *energy >= SILENT * usual).then_some(i * length)
        };
        let starts: Vec<usize> = energies.iter().enumerate().filter_map(loud).collect();
        if starts.len() < super::FEWEST_BLOCKS {
            return Err(AlignError::FewBlocks {
                found: starts.len(),
            });
        }
        Ok(Self {
            config,
            rate_hz: rate.hz(),
            drive,
            energy,
            recorded,
            length,
            starts,
        })
    }

    /// Each block that was found, in the order of time.
    pub(super) fn places(&self) -> Result<Vec<Found>, AlignError> {
        let anchor = self.anchor()?;
        let mut found: Vec<Option<Place>> = vec![None; self.starts.len()];
        found[anchor.0] = Some(anchor.1);
        let (before, behind) = ((0..anchor.0).rev(), anchor.0 + 1..self.starts.len());
        self.follow(before, anchor.0, &mut found);
        self.follow(behind, anchor.0, &mut found);
        let half = 0.5 * self.length as f64;
        let placed = self.starts.iter().zip(found);
        let placed = placed.filter_map(|(start, place)| {
            let place = place?;
            Some(Found {
                recorded_s: (*start as f64 + half) / self.rate_hz,
                drive_s: (place.at + half) / self.rate_hz,
                correlation: place.correlation,
            })
        });
        Ok(placed.collect())
    }

    /// Finds blocks one after the other, each near where the last two that were found lead.
    fn follow(
        &self,
        order: impl Iterator<Item = usize>,
        anchor: usize,
        found: &mut [Option<Place>],
    ) {
        let lag = |block: usize, place: &Place| place.at - self.starts[block] as f64;
        let mut last = (
            anchor,
            found[anchor].map_or(0.0, |place| lag(anchor, &place)),
        );
        for block in order {
            let far_s = self.starts[block].abs_diff(self.starts[last.0]) as f64 / self.rate_hz;
            let reach_s = NEAR_S + 1e-6 * self.config.most_drift_ppm * far_s;
            let expected = self.starts[block] as f64 + last.1;
            let reach = (reach_s * self.rate_hz).ceil() as usize;
            if let Some(place) = self.near(block, expected, reach) {
                last = (block, lag(block, &place));
                found[block] = Some(place);
            }
        }
    }

    /// The block that is most certain, and where: by the support that the places of other blocks give.
    fn anchor(&self) -> Result<(usize, Place), AlignError> {
        let step = self.starts.len().div_ceil(ANYWHERE);
        let chosen: Vec<usize> = (0..self.starts.len()).step_by(step).collect();
        let everywhere = self.everywhere(&chosen);
        let lag = |at: usize, place: &Place| place.at - self.starts[chosen[at]] as f64;
        let tolerance = |a: usize, b: usize| {
            let far = self.starts[chosen[a]].abs_diff(self.starts[chosen[b]]) as f64;
            NEAR_S * self.rate_hz + 1e-6 * self.config.most_drift_ppm * far
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
            .max_by(|a, b| largest(a).total_cmp(&largest(b)));
        let Some(best) = best else {
            return Err(AlignError::NotThere { correlation: 0.0 });
        };
        // Of those that mean the same line, the block that correlates best.
        let same = |one: &&(f64, usize, Place)| {
            (lag(one.1, &one.2) - lag(best.1, &best.2)).abs() <= tolerance(one.1, best.1)
        };
        let own = hypotheses.iter().filter(same);
        let anchor = own
            .max_by(|a, b| a.2.correlation.total_cmp(&b.2.correlation))
            .unwrap_or(best);
        if anchor.2.correlation < LEAST {
            return Err(AlignError::NotThere {
                correlation: anchor.2.correlation,
            });
        }
        let other = hypotheses.iter().filter(|one| !same(one));
        if let Some(other) = other.max_by(|a, b| largest(a).total_cmp(&largest(b)))
            && other.0 >= ALIKE * best.0
        {
            return Err(AlignError::SeveralPlaces {
                first_s: lag(best.1, &best.2) / self.rate_hz,
                second_s: lag(other.1, &other.2) / self.rate_hz,
            });
        }
        Ok((chosen[anchor.1], anchor.2))
    }

    /// The best places of each of these blocks in the whole drive.
    fn everywhere(&self, chosen: &[usize]) -> Vec<Vec<Place>> {
        let n = fast_length(self.drive.len() + 2 * self.length);
        let mut planner = ComplexPlanner::new();
        let (forward, inverse) = (planner.plan_fft_forward(n), planner.plan_fft_inverse(n));
        // A block before the drive holds its beginning too: `length` samples of silence come first.
        let transformed = |samples: &[f64], at: usize| {
            let mut bins = vec![Complex::default(); n];
            for (bin, value) in bins[at..].iter_mut().zip(samples) {
                *bin = Complex::from(*value);
            }
            forward.process(&mut bins);
            bins
        };
        let drive = transformed(&self.drive, self.length);
        let of = |block: &usize| {
            let own = self.block(*block);
            let mut bins = transformed(own, 0);
            analytic_product(&drive, &mut bins);
            inverse.process(&mut bins);
            let squares: f64 = own.iter().map(|v| v * v).sum();
            let lags = self.drive.len() + self.length;
            let correlations: Vec<f64> = (0..lags)
                .map(|at| {
                    let envelope = 2.0 * bins[at].norm() / n as f64;
                    self.correlation(envelope, at as i64 - self.length as i64, squares)
                })
                .collect();
            let near = (NEAR_S * self.rate_hz) as usize;
            peaks(&correlations, near)
                .into_iter()
                .map(|(at, correlation)| Place {
                    at: at - self.length as f64,
                    correlation,
                })
                .collect()
        };
        chosen.iter().map(of).collect()
    }

    fn block(&self, block: usize) -> &[f64] {
        let start = self.starts[block];
        &self.recorded[start..start + self.length]
    }

    /// An envelope over the energies of a block, `squares`, and of the drive where the block begins at `at`.
    fn correlation(&self, envelope: f64, at: i64, squares: f64) -> f64 {
        let within = |at: i64| at.clamp(0, self.drive.len() as i64) as usize;
        let (from, to) = (within(at), within(at + self.length as i64));
        let own = self.energy[to] - self.energy[from];
        // Less than a part in a thousand of the usual energy is silence.
        let usual = self.energy[self.drive.len()] * self.length as f64 / self.drive.len() as f64;
        envelope / (own.max(1e-3 * usual) * squares).sqrt()
    }

    /// The place of a block within `reach` samples of `expected`.
    fn near(&self, block: usize, expected: f64, reach: usize) -> Option<Place> {
        let first = expected.round() as i64 - reach as i64;
        let wide = self.length + 2 * reach;
        if first + wide as i64 <= 0 || first >= self.drive.len() as i64 {
            return None;
        }
        let part: Vec<f64> = (first..first + wide as i64)
            .map(|at| {
                let at = usize::try_from(at).ok();
                at.and_then(|at| self.drive.get(at)).copied().unwrap_or(0.0)
            })
            .collect();
        let n = fast_length(wide + self.length);
        let mut planner = ComplexPlanner::new();
        let forward = planner.plan_fft_forward(n);
        let transformed = |samples: &[f64]| {
            let mut bins = vec![Complex::default(); n];
            for (bin, value) in bins.iter_mut().zip(samples) {
                *bin = Complex::from(*value);
            }
            forward.process(&mut bins);
            bins
        };
        let own = self.block(block);
        let drive = transformed(&part);
        let mut bins = transformed(own);
        analytic_product(&drive, &mut bins);
        planner.plan_fft_inverse(n).process(&mut bins);
        let squares: f64 = own.iter().map(|v| v * v).sum();
        let correlations: Vec<f64> = (0..=2 * reach)
            .map(|at| {
                let envelope = 2.0 * bins[at].norm() / n as f64;
                self.correlation(envelope, first + at as i64, squares)
            })
            .collect();
        let (at, correlation) = peaks(&correlations, reach.max(1)).first().copied()?;
        let at_edge = at < 0.5 || at > 2.0 * reach as f64 - 0.5;
        (correlation >= LEAST && !at_edge).then_some(Place {
            at: first as f64 + at,
            correlation,
        })
    }
}

/// The product with the conjugate of `own`, at positive frequencies alone: the transform of half the analytic correlation.
fn analytic_product(drive: &[Complex<f64>], own: &mut [Complex<f64>]) {
    let half = own.len() / 2;
    for (i, (own, drive)) in own.iter_mut().zip(drive).enumerate() {
        *own = match i {
            0 => Complex::default(),
            i if i < half => drive * own.conj(),
            _ => Complex::default(),
        };
    }
}

/// The largest maxima that are at least `near` apart, the largest first; each between samples by the parabola through three.
fn peaks(values: &[f64], near: usize) -> Vec<(f64, f64)> {
    let is_peak = |at: &usize| {
        let value = values[*at];
        (*at == 0 || values[at - 1] <= value) && values.get(at + 1).is_none_or(|next| *next < value)
    };
    let mut order: Vec<usize> = (0..values.len()).filter(is_peak).collect();
    order.sort_by(|a, b| values[*b].total_cmp(&values[*a]));
    let mut found: Vec<usize> = Vec::new();
    for at in order {
        if found.len() == PLACES {
            break;
        }
        if found.iter().all(|other| other.abs_diff(at) >= near) {
            found.push(at);
        }
    }
    let between = |at: usize| {
        let value = values[at];
        if at == 0 || at + 1 >= values.len() {
            return (at as f64, value);
        }
        let (before, behind) = (values[at - 1], values[at + 1]);
        let bend = before - 2.0 * value + behind;
        let shift = if bend < 0.0 {
            (0.5 * (before - behind) / bend).clamp(-0.5, 0.5)
        } else {
            0.0
        };
        (at as f64 + shift, value)
    };
    found.into_iter().map(between).collect()
}

/// The signal within the band, whose edges fall over a tenth of its width.
fn within(samples: &[f64], rate: SampleRate, band: Band) -> Vec<f64> {
    let n = fast_length(samples.len() + rate.hz() as usize);
    let mut transform = RealTransform::new(n);
    let mut bins = transform.forward(samples);
    let (low, high) = (band.low().0, band.high().0);
    let edge = 0.1 * (high - low);
    for (line, bin) in bins.iter_mut().enumerate() {
        let hz = line as f64 * rate.hz() / n as f64;
        let inside = (hz - low).min(high - hz) / edge;
        *bin *= inside.clamp(0.0, 1.0);
    }
    let mut found = transform.inverse(bins);
    found.truncate(samples.len());
    found
}
