//! The transfer function between two channels of a recording that is read part by part, as often as it is needed.

#[cfg(test)]
mod tests;

use std::ops::Range;

use super::between::{describe, excited, require_lines, warning};
use super::change::Change;
use super::clock::{BlockSums, Blocks, Drifting};
use super::cross::CrossInParts;
use super::related::repeats_itself;
use super::{
    BetweenChannels, BetweenConfig, CrossSpectra, Estimate, Excitation, Known, Swapped,
    TransferError, TransferWarning, Transient, few_left, of_spectra, pulses_in, touches, transient,
};
use crate::device::DriveSetup;
use crate::integrity::{BrokenInParts, InParts, Pair};
use crate::quantity::{Band, SampleRate, Seconds, Uncalibrated, Unit};
use crate::recording::Recording;
use crate::resample::{REACH, at_places};
use crate::roles::Roles;
use crate::series::Series;
use crate::spectrum::EstimateError;
use crate::warning::Warning;

/// Gives the parts of the channels of these names, one after the other.
type Parts<'a, E> = &'a mut dyn FnMut(&[&str], &mut dyn FnMut(&Recording)) -> Result<(), E>;

/// As [`super::between_channels`], of a recording of so many `samples` whose channels, `empty` of samples, are given part by part: `each`
/// gives the parts of the channels that are named, and may be called several times. `None` where the drive is taken for hits, of which the
/// whole recording is needed.
///
/// The spectra, the clocks and the change are those of the whole recording, bit for bit where the clocks agree. Of the first part alone are:
/// whether the drive is one of pulses or repeats itself, and the delay of signals that are unrelated or out of step. Every part is inspected
/// as a recording of its own ([`InParts`]).
///
/// Source: as [`super::between_channels`].
///
/// # Errors
/// Those of `each`; within, those of [`super::between_channels`].
pub fn between_in_parts<E>(
    empty: &Recording,
    samples: usize,
    config: &BetweenConfig<'_>,
    each: Parts<'_, E>,
) -> Result<Result<Option<BetweenChannels>, TransferError>, E> {
    if !matches!(config.excitation, Excitation::Found | Excitation::Lasting) {
        return Ok(Ok(None));
    }
    let mut first = match First::new(empty, samples, config) {
        Ok(first) => first,
        Err(error) => return Ok(Err(error)),
    };
    let names = empty.channels().iter().map(|channel| channel.name.as_str());
    let names: Vec<&str> = names.collect();
    each(&names, &mut |part| first.add(part, config))?;
    let pass = |course: &Drifting, mean: f64, lost_s: &[[f64; 2]]| {
        let mut sums = match Sums::new(samples, empty.rate(), config) {
            Ok(sums) => sums,
            Err(error) => return Ok(Err(error)),
        };
        let mut places = Places::new(course, mean, empty.rate());
        each(&[config.drive, config.response], &mut |part| {
            // What is wrong with a part was said in the first pass.
            if let Ok(next) = Signals::of(part, config) {
                places.add(&next.drive, &next.response);
                places.take(places.ready(), &mut |x, y| sums.add(x, y, lost_s));
            }
        })?;
        places.take(places.drive.len(), &mut |x, y| sums.add(x, y, lost_s));
        Ok(Ok(sums))
    };
    let (estimated, change) = match first.estimated(samples, config, pass)? {
        Ok(Some(found)) => found,
        Ok(None) => return Ok(Ok(None)),
        Err(error) => return Ok(Err(error)),
    };
    let force = Roles::guess(empty).0.normal_force;
    let change = match (change, force) {
        (Some(change), Some(force)) => {
            let mut sums = [(0.0, 0_usize); 2];
            let mut from = 0;
            each(&[&force], &mut |part| {
                for value in part.channels().iter().flat_map(|channel| &channel.samples) {
                    let (sum, count) = &mut sums[usize::from(!change.holds(from, part.rate()))];
                    *sum += value;
                    *count += 1;
                    from += 1;
                }
            })?;
            let means = sums.map(|(sum, count)| sum / count as f64);
            Some(change.with_mean_forces(means))
        }
        (change, _) => change,
    };
    let found = first.finished(empty, samples, config, (estimated, change));
    Ok(found.map(Some))
}

/// The drive and the response of a part.
struct Signals {
    drive: Vec<f64>,
    response: Vec<f64>,
    drive_unit: Unit,
    response_unit: Unit,
}

impl Signals {
    fn of(part: &Recording, config: &BetweenConfig<'_>) -> Result<Self, TransferError> {
        let (drive, drive_unit) = excited(part, config)?;
        let (channel, response) = part.raw(Some(config.response))?;
        Ok(Self {
            drive: drive.into_samples(),
            response: response.into_samples(),
            drive_unit,
            response_unit: channel.unit.clone(),
        })
    }
}

/// The sums over the segments of two signals on one clock.
struct Sums {
    blocks: Option<BlockSums>,
    cross: CrossInParts,
    rate: SampleRate,
    /// The first part of both.
    first: Option<[Vec<f64>; 2]>,
}

impl Sums {
    fn new(
        samples: usize,
        rate: SampleRate,
        config: &BetweenConfig<'_>,
    ) -> Result<Self, TransferError> {
        config.welch.fits(samples)?;
        Ok(Self {
            blocks: BlockSums::new(samples, &config.welch, rate),
            cross: CrossInParts::new(&config.welch, rate)?,
            rate,
            first: None,
        })
    }

    fn add(&mut self, drive: &[f64], response: &[f64], lost_s: &[[f64; 2]]) {
        if let Some(blocks) = &mut self.blocks {
            blocks.add(drive, response);
        }
        let rate = self.rate;
        (self.cross).add(drive, response, &|cut| !touches(cut, lost_s, rate));
        if self.first.is_none() {
            self.first = Some([drive.to_vec(), response.to_vec()]);
        }
    }
}

/// The delay of a response goes back by less than this where samples are missing: by twelve times 50 ms at most.
const BACK: Seconds = Seconds(1.0);

/// A response at the places at which its drive was, as it comes part by part.
struct Places<'a> {
    course: &'a Drifting,
    /// The mean of the response.
    mean: f64,
    back: f64,
    drive: Vec<f64>,
    response: Vec<f64>,
    /// The numbers of the first samples of both that are kept.
    from: usize,
    response_from: usize,
}

impl<'a> Places<'a> {
    fn new(course: &'a Drifting, mean: f64, rate: SampleRate) -> Self {
        Self {
            course,
            mean,
            back: BACK.0 * rate.hz() + 2.0 * REACH as f64,
            drive: Vec::new(),
            response: Vec::new(),
            from: 0,
            response_from: 0,
        }
    }

    fn add(&mut self, drive: &[f64], response: &[f64]) {
        self.drive.extend_from_slice(drive);
        (self.response).extend(response.iter().map(|v| v - self.mean));
    }

    /// Where the response to the sample `k` of the kept drive lies in the kept response.
    fn place(&self, k: usize) -> f64 {
        let i = (self.from + k) as f64;
        i + self.course.delay_at(i) - self.response_from as f64
    }

    /// The samples of the drive whose response is there.
    fn ready(&self) -> usize {
        let last = self.response.len() as f64 - REACH as f64 - 1.0;
        let mut all = 0..self.drive.len();
        all.find(|k| self.place(*k) >= last)
            .unwrap_or(self.drive.len())
    }

    /// Gives the next `count` samples of the drive with their response to `take`; beyond its end the response is 0.
    fn take(&mut self, count: usize, take: &mut dyn FnMut(&[f64], &[f64])) {
        let mut corrected = at_places(&self.response, count, |k| self.place(k));
        corrected.iter_mut().for_each(|v| *v += self.mean);
        let unused = (self.place(count) - self.back).max(0.0) as usize;
        take(&self.drive[..count], &corrected);
        self.drive.drain(..count);
        self.from += count;
        let unused = unused.min(self.response.len());
        self.response.drain(..unused);
        self.response_from += unused;
    }
}

/// What the first pass gives.
struct First {
    sums: Option<Sums>,
    inspection: InParts,
    broken: BrokenInParts,
    units: Option<(Unit, Unit)>,
    /// The sum of the response, for its mean.
    sum: f64,
    limit: f64,
    driven: Option<Band>,
    wrong: Option<TransferError>,
}

type Estimated = (Estimate<Uncalibrated, Uncalibrated>, Option<Change>);

impl First {
    fn new(
        empty: &Recording,
        samples: usize,
        config: &BetweenConfig<'_>,
    ) -> Result<Self, TransferError> {
        if config.drive == config.response {
            return Err(TransferError::SameChannel {
                channel: config.drive.to_owned(),
            });
        }
        empty.require_one_clock([config.drive, config.response])?;
        for name in [config.drive, config.response] {
            empty.pick(Some(name), &Unit::MetrePerSecondSquared)?;
        }
        let limit = config.setup.as_ref().map_or(1.0, DriveSetup::drive_limit);
        Ok(Self {
            sums: Some(Sums::new(samples, empty.rate(), config)?),
            inspection: InParts::new(limit),
            broken: BrokenInParts::default(),
            units: None,
            sum: 0.0,
            limit,
            driven: empty.about.provenance.excited_hz,
            wrong: None,
        })
    }

    fn pair<'a>(
        &self,
        [drive, response]: [&'a [f64]; 2],
        rate: SampleRate,
        config: &BetweenConfig<'a>,
    ) -> Pair<'a> {
        let in_full_scale =
            (self.units.as_ref()).is_some_and(|(drive, _)| *drive == Unit::FullScale);
        Pair {
            drive,
            response,
            rate,
            drive_name: config.drive,
            response_name: config.response,
            drive_limit: in_full_scale.then_some(self.limit),
            lasts: true,
        }
    }

    fn add(&mut self, part: &Recording, config: &BetweenConfig<'_>) {
        if self.wrong.is_some() {
            return;
        }
        let signals = match Signals::of(part, config) {
            Ok(signals) => signals,
            Err(error) => {
                self.wrong = Some(error);
                return;
            }
        };
        let (drive, response) = (&signals.drive[..], &signals.response[..]);
        self.units = Some((signals.drive_unit.clone(), signals.response_unit.clone()));
        self.inspection.add(part);
        let pair = self.pair([drive, response], part.rate(), config);
        self.broken.add(&pair);
        self.sum += response.iter().sum::<f64>();
        if let Some(sums) = &mut self.sums {
            sums.add(drive, response, &config.lost_s);
        }
    }

    /// The estimate and how the response changes; `pass` gives the sums of a response that is corrected.
    fn estimated<E>(
        &mut self,
        samples: usize,
        config: &BetweenConfig<'_>,
        mut pass: impl FnMut(&Drifting, f64, &[[f64; 2]]) -> Result<Result<Sums, TransferError>, E>,
    ) -> Result<Result<Option<Estimated>, TransferError>, E> {
        if let Some(error) = self.wrong.take() {
            return Ok(Err(error));
        }
        let Some(mut sums) = self.sums.take() else {
            return Ok(Ok(None));
        };
        let of_first = sums.first.take().unwrap_or_default();
        for (name, signal) in [config.drive, config.response].into_iter().zip(&of_first) {
            if self.inspection.is_dead(name) {
                return Ok(Err(TransferError::Constant {
                    channel: name.to_owned(),
                    value: signal.first().copied().unwrap_or(0.0),
                }));
            }
        }
        if let Some(Transient { hits, share }) = transient(&of_first[0], sums.rate) {
            return Ok(match config.excitation == Excitation::Lasting {
                true => Err(TransferError::Transient { hits, share }),
                false => Ok(None),
            });
        }
        sums.first = Some(of_first);
        let lost_s = &config.lost_s;
        let blocks = sums.blocks.take().and_then(BlockSums::blocks);
        let mut on_one_clock = OnOneClock {
            change: blocks.as_ref().and_then(|of| Change::of(of, lost_s)),
            sums,
            missing_s: lost_s.clone(),
            warnings: Vec::new(),
        };
        let course = blocks.as_ref().and_then(Blocks::course);
        if let (Some(blocks), Some(mut course)) = (&blocks, course) {
            let mean = self.sum / samples as f64;
            let mut corrected = |course: &Drifting| {
                let (mut missing_s, warnings) = course.said(blocks);
                missing_s.extend(lost_s);
                let mut sums = match pass(course, mean, &missing_s)? {
                    Ok(sums) => sums,
                    Err(error) => return Ok(Err(error)),
                };
                let own = sums.blocks.take().and_then(BlockSums::blocks);
                Ok(Ok(OnOneClock {
                    change: own.and_then(|own| Change::of(&own, &missing_s)),
                    sums,
                    missing_s,
                    warnings,
                }))
            };
            if !course.is_none() {
                let one = match corrected(&course)? {
                    Ok(one) => one,
                    Err(error) => return Ok(Err(error)),
                };
                if one.change.is_none() || !course.keep_above_half_a_turn(blocks) {
                    on_one_clock = one;
                } else if !course.is_none() {
                    match corrected(&course)? {
                        Ok(one) => on_one_clock = one,
                        Err(error) => return Ok(Err(error)),
                    }
                }
            }
        }
        Ok(on_one_clock
            .estimated(samples, config, self.driven)
            .map(Some))
    }

    /// The result, with what the recording says and what is broken in it.
    fn finished(
        self,
        empty: &Recording,
        samples: usize,
        config: &BetweenConfig<'_>,
        (estimated, change): Estimated,
    ) -> Result<BetweenChannels, TransferError> {
        let Estimate {
            mut function,
            found,
            spectra,
        } = estimated;
        require_lines(&function, samples, config)?;
        let none: [&[f64]; 2] = [&[], &[]];
        let pair = self.pair(none, empty.rate(), config);
        let clipped = [config.drive, config.response].map(|name| self.inspection.clipped(name));
        let broken = self.broken.broken(&pair, clipped);
        function.about.warnings.extend(broken.warnings(&pair));
        let Some(units) = self.units else {
            return Err(EstimateError::TooShort {
                expected: config.welch.segment,
                found: 0,
            }
            .into());
        };
        warning(&mut function, &found, [&units.0, &units.1]);
        let mut function = function.with_change(change);
        describe(&mut function, empty, config);
        let beside = self.inspection.warnings_beside(&pair, &broken);
        function.about.add_warnings(beside);
        let drawn = (None, Some(spectra));
        Ok(BetweenChannels::of(function, units, config, drawn))
    }
}

/// The sums on one clock, and what is said of it.
struct OnOneClock {
    sums: Sums,
    change: Option<Change>,
    /// With the stretches that are known to be lost.
    missing_s: Vec<[f64; 2]>,
    warnings: Vec<Warning>,
}

impl OnOneClock {
    fn estimated(
        self,
        samples: usize,
        config: &BetweenConfig<'_>,
        driven: Option<Band>,
    ) -> Result<Estimated, TransferError> {
        let rate = self.sums.rate;
        let lost = |cut: &Range<usize>| touches(cut, &self.missing_s, rate);
        let cuts = config.welch.cuts(samples);
        let left = few_left(cuts.len(), cuts.iter().filter(|cut| lost(cut)).count())?;
        let spectra: CrossSpectra<Uncalibrated, Uncalibrated> = self.sums.cross.spectra(samples)?;
        let [drive, response] = self.sums.first.unwrap_or_default();
        let said = left.into_iter().chain(pulses_in(&drive, rate));
        let known_input = config.known_input && !repeats_itself(&drive, config.welch.segment);
        let pulses = transient(&response, rate).filter(|_| config.excitation == Excitation::Found);
        let signals = (Series::new(drive, rate)?, Series::new(response, rate)?);
        let known = Known {
            lost_s: &self.missing_s,
            driven,
        };
        let mut estimate = of_spectra(
            spectra,
            (&signals.0, &signals.1),
            &config.welch,
            (config.estimator, known),
            said,
        )?;
        let function = &mut estimate.function;
        function.known_input = known_input;
        function.about.warnings.extend(self.warnings);
        let pulses = pulses.map(|Transient { hits, .. }| {
            Warning::from(TransferWarning::Swapped {
                by: Swapped::Pulses { hits },
            })
        });
        function.about.warnings.extend(pulses);
        Ok((estimate, self.change))
    }
}
