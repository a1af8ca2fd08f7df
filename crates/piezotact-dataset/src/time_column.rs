//! Time columns, whatever file holds them: the rate that they stand for, the samples that are missing in them, and how far their
//! time stamps lie from the even grid on which the samples are read.

use std::ops::Range;
use std::path::Path;

use piezotact::Warning;
use piezotact::number::digits;
use piezotact::quantity::SampleRate;
use piezotact::recording::{LostBy, Recording, RecordingWarning, Stated, Steps};
use piezotact::series::is_sample;
use piezotact::statistics::median;

use crate::columns::Column;
use crate::error::ReadError;
use crate::open::{ReadOptions, no_part};
pub(crate) use even::EvenTimes;
use grid::Rows;
pub use units::is_time_unit;
use units::seconds_per_unit;
pub(crate) use units::{is_time, named_unit, seconds_of, state_unit};

mod even;
mod grid;
mod units;

/// Repeated time stamps up to this share of all rows are slips of the clock.
const MOST_REPEATED: f64 = 1e-3;
/// The tolerance for evenly spaced time steps, as a share of the usual step.
const EVEN: f64 = 0.01;
/// A step that differs by more than this share from the usual one is no jitter in any file.
const GAP: f64 = 0.25;
/// Missing samples between two time stamps up to this number are filled; more are a pause between two parts.
const MOST_FILLED: usize = 10;
/// More than this share of those that are there is not filled.
const MOST_MISSING: f64 = 0.5;
/// More missing samples than this are no pause, but a wrong clock.
pub(crate) const LONGEST_PAUSE: f64 = 1e9;
/// How far a rate from rounded time stamps may lie from a whole number to be taken for it.
const ROUNDED: f64 = 2e-6;
/// The rate that a file states and that of its times may differ by this share: times in single precision do.
const SAME_RATE: f64 = 1e-3;
/// Time stamps farther than this from their grid are a warning, in samples.
const FAR: f64 = 0.5;

/// The rate of steps of `step_s`: a whole number where it is one but for rounding.
pub(crate) fn rate_of_step(path: &Path, step_s: f64) -> Result<SampleRate, ReadError> {
    let hz = 1.0 / step_s;
    let is_whole = (hz.round() / hz - 1.0).abs() < 1e-12;
    SampleRate::new(if is_whole { hz.round() } else { hz }).map_err(ReadError::of(path))
}

/// How many time stamps of so many may be repeated.
pub(crate) fn most_repeated(stamps: usize) -> usize {
    ((stamps as f64 * MOST_REPEATED) as usize).max(1)
}

/// The even grid on which the rows of a table lie.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TimeBase {
    pub(crate) rate: SampleRate,
    /// Rows before which samples are missing, and how many.
    gaps: Vec<(usize, usize)>,
    /// The largest distance of a time stamp from the grid, in samples.
    residual: f64,
    rows: usize,
    /// The rows of the part that is read; all of them where there is one.
    span: Option<Range<usize>>,
    /// The time of the first row of that part, s since the first of all.
    pub(crate) offset_s: f64,
}

impl TimeBase {
    /// Rows without a gap.
    pub(crate) fn even(rate: SampleRate) -> Self {
        Self::with_gaps(rate, Vec::new(), 0)
    }

    /// So many rows, before some of which samples are missing, so many of each.
    pub(crate) fn with_gaps(rate: SampleRate, mut gaps: Vec<(usize, usize)>, rows: usize) -> Self {
        // A damaged file may state a gap before its first row or behind its last one.
        gaps.retain(|(row, _)| (1..rows).contains(row));
        Self {
            rate,
            rows: if gaps.is_empty() { 0 } else { rows },
            gaps,
            residual: 0.0,
            span: None,
            offset_s: 0.0,
        }
    }

    /// The first rows of the parts.
    fn starts(&self) -> Vec<usize> {
        let short = self.gaps.iter().filter(|(_, count)| *count <= MOST_FILLED);
        let filled: usize = short.map(|(_, count)| count).sum();
        let most = match filled as f64 > MOST_MISSING * self.rows as f64 {
            true => 0,
            false => MOST_FILLED,
        };
        let pauses = self.gaps.iter().filter(|(_, count)| *count > most);
        let later = pauses.map(|(row, _)| *row);
        std::iter::once(0).chain(later).collect()
    }

    /// How many parts lie between pauses.
    pub(crate) fn parts(&self) -> usize {
        self.starts().len()
    }

    /// The part of this number, the first where none is given, with a warning: parts lie between pauses of more than
    /// [`MOST_FILLED`] samples.
    fn part(
        mut self,
        path: &Path,
        part: Option<usize>,
        rows: usize,
        warnings: &mut Vec<Warning>,
    ) -> Result<Self, ReadError> {
        let starts = self.starts();
        let number = part.unwrap_or(1);
        let Some(start) = number.checked_sub(1).and_then(|at| starts.get(at).copied()) else {
            return Err(no_part(path, number, starts.len()));
        };
        if starts.len() == 1 {
            return Ok(self);
        }
        let ends = |at: usize| starts.get(at + 1).copied().unwrap_or(rows);
        let lasts_s = |from: usize, end: usize| {
            self.time_of(end.saturating_sub(1)) - self.time_of(from) + 1.0 / self.rate.hz()
        };
        let end = ends(number - 1);
        if part.is_none() {
            let all = starts
                .iter()
                .enumerate()
                .map(|(at, from)| lasts_s(*from, ends(at)));
            warnings.push(Warning::from(RecordingWarning::OneSegment {
                count: starts.len(),
                lasts_s: lasts_s(start, end),
                all_s: all.sum(),
            }));
        }
        self.offset_s = self.time_of(start);
        self.gaps.retain(|(row, _)| start < *row && *row < end);
        for (row, _) in &mut self.gaps {
            *row -= start;
        }
        self.span = Some(start..end);
        Ok(self)
    }

    /// Leaves the samples of the part that is read.
    pub(crate) fn cut(&self, samples: &mut Vec<f64>) {
        if let Some(span) = &self.span {
            samples.truncate(span.end);
            samples.drain(..span.start.min(samples.len()));
        }
    }

    /// The time of a row since the first, s.
    pub(crate) fn time_of(&self, row: usize) -> f64 {
        let before = self.gaps.iter().take_while(|(at, _)| *at <= row);
        let missing: usize = before.map(|(_, count)| count).sum();
        self.rate.duration_of(row + missing).0
    }

    fn missing(&self) -> usize {
        self.gaps.iter().map(|(_, count)| count).sum()
    }

    /// Puts straight lines in the place of the missing samples of a channel.
    pub(crate) fn fill(&self, samples: &mut Vec<f64>) {
        if self.gaps.is_empty() {
            return;
        }
        let mut filled = Vec::with_capacity(samples.len() + self.missing());
        let mut from = 0;
        for &(row, count) in &self.gaps {
            let (Some(part), Some(next)) = (samples.get(from..row), samples.get(row)) else {
                break;
            };
            filled.extend_from_slice(part);
            let last = part.last().copied().unwrap_or(*next);
            let line = |k: usize| last + (next - last) * k as f64 / (count + 1) as f64;
            filled.extend((1..=count).map(line));
            from = row;
        }
        filled.extend_from_slice(&samples[from..]);
        *samples = filled;
    }

    /// Notes in a recording what was filled in its channels that begin `start_s` after it.
    pub(crate) fn note(&self, recording: &mut Recording, start_s: f64) {
        if self.gaps.is_empty() {
            return;
        }
        let mut before = 0;
        let places = self.gaps.iter().map(|&(row, count)| {
            let from = row + before;
            before += count;
            [from, from + count].map(|at| start_s + self.rate.duration_of(at).0)
        });
        let places_s: Vec<[f64; 2]> = places.collect();
        let longest = self.gaps.iter().map(|(_, count)| *count).max();
        let losses = &mut recording.about.provenance.losses;
        losses.samples += self.missing() as u64;
        losses.stretches_s.extend_from_slice(&places_s);
        recording
            .about
            .warnings
            .push(Warning::from(RecordingWarning::SamplesLost {
                by: LostBy::Stamps {
                    gaps: self.gaps.len(),
                    samples: self.missing() as u64,
                    longest_s: self.rate.duration_of(longest.unwrap_or(0)).0,
                    places_s,
                },
            }));
    }

    /// Whether rows at `rate` stay within half a sample of these, or within what these are known to.
    fn agrees(&self, rate: SampleRate) -> bool {
        let off = (self.rate.hz() / rate.hz() - 1.0).abs();
        match self.rows {
            // A header states it with few digits.
            0 => off <= SAME_RATE,
            rows => off * (rows + self.missing()) as f64 <= FAR + self.residual.min(1.0),
        }
    }
}

/// The rate that is stated, or else the grid that was found; a warning where they differ.
///
/// Of a recording with pauses it is the part that `options` ask for.
pub(crate) fn choose_base(
    path: &Path,
    options: &ReadOptions,
    found: Option<Result<TimeBase, ReadError>>,
    warnings: &mut Vec<Warning>,
) -> Result<TimeBase, ReadError> {
    let base = match (options.rate, found) {
        (Some(stated), found) => {
            // Warnings about time stamps that are not used are irrelevant.
            warnings.clear();
            let said = match found {
                None => None,
                Some(Ok(found)) if !found.agrees(stated) => Some(RecordingWarning::StatedDiffers {
                    what: Stated::Rate {
                        stated_hz: stated.hz(),
                        found_hz: found.rate.hz(),
                    },
                }),
                Some(Ok(found)) if !found.gaps.is_empty() => Some(RecordingWarning::Guessed {
                    what: format!(
                        "the time stamps lack {} samples at {} places; the stated rate was used, and the rows are read as evenly sampled",
                        found.missing(),
                        found.gaps.len()
                    ),
                }),
                Some(Ok(_)) => None,
                Some(Err(error)) => Some(RecordingWarning::Guessed {
                    what: format!(
                        "the time column was not used; the stated rate was used ({})",
                        error.reason()
                    ),
                }),
            };
            warnings.extend(said.map(Warning::from));
            Ok(TimeBase::even(stated))
        }
        (None, Some(found)) => found,
        (None, None) => Err(ReadError::content(
            path,
            "a time column, or a rate",
            "neither",
            "give the rate with --rate, for example --rate 5000",
        )),
    }?;
    let rows = base.rows;
    base.part(path, options.part, rows, warnings)
}

/// The grid of a file that states a rate beside its times: at that rate where the times agree with it, with a warning at that of the
/// times where they do not.
pub(crate) fn base_beside(
    path: &Path,
    time: &Column,
    (name, stated): (&str, SampleRate),
    warnings: &mut Vec<Warning>,
) -> TimeBase {
    let mut of_time = Vec::new();
    // Time without a unit may be in s, ms, µs or ns: the one that agrees is meant.
    let units: &[f64] = match time.unit {
        None => &[1.0, 1e3, 1e6, 1e9],
        Some(_) => &[1.0],
    };
    let in_seconds = Column {
        unit: time.unit.clone().or(Some("s".into())),
        ..time.clone()
    };
    let said = match base_of(path, &in_seconds, &mut of_time) {
        Ok(found) => {
            let ratio = found.rate.hz() / stated.hz();
            let agrees = |unit: &&f64| (ratio * **unit - 1.0).abs() <= SAME_RATE;
            match units.iter().find(agrees) {
                Some(unit) => {
                    let off = (ratio * unit - 1.0).abs() * found.rows as f64;
                    if found.residual.max(off) > FAR {
                        warnings.extend(far(time, found.residual.max(off), stated));
                    }
                    return TimeBase {
                        rate: stated,
                        ..found
                    };
                }
                None => {
                    warnings.append(&mut of_time);
                    let what = format!(
                        "`{name}` states {stated}, `{}` gives {} Hz: the second was used",
                        time.name,
                        digits(found.rate.hz())
                    );
                    warnings.push(Warning::from(RecordingWarning::Guessed { what }));
                    return found;
                }
            }
        }
        Err(error) => format!(
            "the rate is that of `{name}`; `{}` was not used ({})",
            time.name,
            error.reason()
        ),
    };
    warnings.push(Warning::from(RecordingWarning::Guessed { what: said }));
    TimeBase::even(stated)
}

/// The warning that the rows lie up to so many samples from the times at which they were taken.
fn far(time: &Column, residual: f64, rate: SampleRate) -> Option<Warning> {
    Some(Warning::from(RecordingWarning::Guessed {
        what: format!(
            "the rows are read as evenly sampled at {} Hz, and time stamps of `{}` lie up to {} samples ({} ms) from there",
            digits(rate.hz()),
            time.name,
            digits(residual),
            digits(1e3 * residual / rate.hz())
        ),
    }))
}

/// The grid that a time column stands for.
pub(crate) fn base_of(
    path: &Path,
    time: &Column,
    warnings: &mut Vec<Warning>,
) -> Result<TimeBase, ReadError> {
    let times = &time.values;
    if times.len() < 2 {
        let todo = "record longer, or give --rate";
        return Err(ReadError::content(path, "two rows or more", "one", todo));
    }
    if let Some(at) = times.iter().position(|one| !is_sample(*one)) {
        return Err(ReadError::content(
            path,
            format!("a time in every row of `{}`", time.name),
            format!("{} in row {} below the header", times[at], at + 1),
            "repair or cut that row",
        ));
    }
    let steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let repeated = repeated_stamps(path, time, &steps)?;
    let mut forward: Vec<f64> = steps.iter().copied().filter(|step| *step > 0.0).collect();
    let Some(usual) = median(&mut forward) else {
        return Err(ReadError::content(
            path,
            format!("`{}` to increase from row to row", time.name),
            format!("{} in every row", times[0]),
            "export the time with more digits, or give --rate to read the rows as evenly sampled",
        ));
    };
    warnings.extend(repeats_warning(time, &repeated));
    let times = without_slips(times, &repeated, usual);
    let steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let rows = Rows {
        times: &times,
        steps: &steps,
    };
    let is_rounded = rows.are_rounded(usual);
    let breaks = match is_rounded {
        true => Vec::new(),
        false => (rows.breaks(usual)).map_err(|at| broken(path, time, usual, at))?,
    };
    let mut grid = rows.grid(&breaks, usual);
    // No grid fits such times: that of the mean step lasts as long as they do.
    if grid.gaps.is_empty() && repeated.is_empty() && grid.residual > FAR {
        grid = rows.even();
    }
    if let Some((row, longest)) = grid.gaps.iter().max_by_key(|(_, count)| *count)
        && *longest as f64 > LONGEST_PAUSE
    {
        return Err(broken(path, time, usual, row - 1));
    }
    let to_seconds = seconds_per_unit(path, time, grid.period, warnings)?;
    let worst = steps
        .iter()
        .enumerate()
        .filter(|(_, step)| **step > 0.0)
        .map(|(at, step)| {
            let wanted = grid.gaps.iter().find(|(row, _)| *row == at + 1);
            (step / usual - wanted.map_or(1.0, |(_, count)| 1.0 + *count as f64)).abs()
        })
        .fold(0.0, f64::max);
    if worst > EVEN && !is_rounded {
        warnings.push(Warning::from(RecordingWarning::UnevenSteps {
            worst,
            of: Steps::Time,
        }));
    }
    // Time stamps are rounded to the digits of the table: a rate that close to a whole number is one.
    let found_hz = 1.0 / (grid.period * to_seconds);
    let off = (found_hz.round() / found_hz - 1.0).abs();
    let close = off <= ROUNDED && off * times.len() as f64 <= FAR;
    let of_whole = 1.0 / (found_hz.round() * to_seconds);
    let whole = close || is_rounded && off <= SAME_RATE && rows.fit(of_whole);
    let rate_hz = if whole { found_hz.round() } else { found_hz };
    let rate = SampleRate::new(rate_hz).map_err(ReadError::of(path))?;
    if grid.residual > FAR {
        warnings.extend(far(time, grid.residual, rate));
    }
    Ok(TimeBase {
        rate,
        gaps: grid.gaps,
        residual: grid.residual,
        rows: times.len(),
        span: None,
        offset_s: 0.0,
    })
}

fn broken(path: &Path, time: &Column, usual: f64, at: usize) -> ReadError {
    ReadError::content(
        path,
        format!(
            "`{}` to increase in steps of about {}",
            time.name,
            digits(usual)
        ),
        format!(
            "a step from {} to {}",
            time.values[at],
            time.values.get(at + 1).unwrap_or(&f64::NAN)
        ),
        "rows are missing or the clock changed: cut the recording there, or give --rate to read it as evenly sampled",
    )
}

/// Where `steps` repeat a time stamp; an error where the time does not increase.
fn repeated_stamps(path: &Path, time: &Column, steps: &[f64]) -> Result<Vec<usize>, ReadError> {
    if let Some(at) = steps.iter().position(|step| *step < 0.0) {
        return Err(ReadError::content(
            path,
            format!("`{}` to increase from row to row", time.name),
            format!(
                "{} after {} in row {at} below the header",
                time.values[at + 1],
                time.values[at],
                at = at + 2
            ),
            "if rows are out of order, sort them by time; if the clock was set back, cut the recording there; or give --rate to \
             read the rows as evenly sampled",
        ));
    }
    let repeated: Vec<usize> = (0..steps.len()).filter(|at| steps[*at] == 0.0).collect();
    if repeated.len() > most_repeated(time.values.len()) {
        let at = repeated[0];
        return Err(ReadError::content(
            path,
            format!("`{}` to increase from row to row", time.name),
            format!(
                "{} again in row {} below the header, and {} stamps that are repeated in all",
                time.values[at + 1],
                at + 2,
                repeated.len()
            ),
            "export the time with more digits, or give --rate to read the rows as evenly sampled",
        ));
    }
    Ok(repeated)
}

/// The times with those that repeat the one before in place of their own put back between their neighbours: a double step is beside
/// them.
fn without_slips(times: &[f64], repeated: &[usize], usual: f64) -> Vec<f64> {
    let mut mended = times.to_vec();
    for &at in repeated {
        let between = |row: usize| {
            let (before, after) = (mended.get(row.checked_sub(1)?)?, mended.get(row + 1)?);
            let room = after - before;
            ((room / (2.0 * usual) - 1.0).abs() <= GAP).then_some((row, before + 0.5 * room))
        };
        if let Some((row, time)) = between(at + 1).or_else(|| between(at)) {
            mended[row] = time;
        }
    }
    mended
}

/// What is to be said of repeated time stamps.
fn repeats_warning(time: &Column, repeated: &[usize]) -> Option<Warning> {
    let stamp = time.values.get(*repeated.first()?)?;
    Some(Warning::from(RecordingWarning::Guessed {
        what: format!(
            "{} repeated in `{}` (the first: {stamp}); the rows are read as evenly sampled",
            match repeated.len() {
                1 => "1 time stamp is".to_owned(),
                count => format!("{count} time stamps are"),
            },
            time.name
        ),
    }))
}

#[cfg(test)]
mod tests;
