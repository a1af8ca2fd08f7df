//! From the places of blocks and bursts to an alignment with its warnings.

use super::anchored::{Burst, seen};
use super::burst::Bursts;
use super::line::{Found, LEAST_STEP_S, Line, converged, robust, step};
use super::search::{Blocks, Lead, NEAR_S, Placed};
use super::{
    AlignError, AlignFault, AlignWarning, AlignedBy, Alignment, BlockPlace, BurstPlace, Prepared,
    Span,
};
use crate::quantity::Seconds;
use crate::statistics::median;

/// Less certain times give a warning, s.
const CERTAIN_S: f64 = 1e-4;
/// So many neighbouring blocks that are not where they should be give a warning, and so is a share of one in [`MANY`].
const RUN: usize = 2;
/// Where half of the blocks correlate by this or more, a single one that does not gives a warning.
const CLEAR: f64 = 0.7;
/// One in so many is many.
const MANY: usize = 5;
/// Blocks that correlate by less than this share of the usual are looked at in halves, so many of them.
const SUSPECT: f64 = 0.8;
const SUSPECTS: usize = 10;
/// A half that is at another place than the line leads to correlates by this share of the usual.
const STRAY: f64 = 0.75;
/// Blocks that lie so many times further from the line than white noise explains scatter (coloured noise: up to six times), and by at least this, s.
const SCATTER: f64 = 10.0;
const LEAST_SCATTER_S: f64 = 1e-5;
/// Times at which intervals are given, less 1.
const STEPS: usize = 60;
/// Phases that wander by more standard errors than this do so.
const PHASE_ERRORS: f64 = 6.0;

/// The line through blocks, and what it was drawn with.
struct ByBlocks {
    line: Line,
    used: Vec<bool>,
    placed: Placed,
}

impl ByBlocks {
    /// The line through blocks, led by a time that is known on both clocks, if one is.
    fn of(both: &Prepared, lead: Option<Lead>) -> Result<Self, AlignError> {
        let (found, gain) = converged(|drift_ppm, before: Option<&Self>| {
            let middle = before.and_then(|before| before.middle());
            let placed = Blocks::of(both, drift_ppm)?.placed(middle.or(lead))?;
            let (line, used) = robust(&placed.found)?;
            let found = Self { line, used, placed };
            Ok((found, line.drift_ppm()))
        })?;
        let line = found.line.with_gain(gain);
        Ok(Self { line, ..found })
    }

    /// The block in the middle of those that the line was drawn with.
    fn middle(&self) -> Option<Lead> {
        let used = self.placed.found.iter().zip(&self.used);
        let used: Vec<&Found> = used.filter_map(|(one, used)| used.then_some(one)).collect();
        let one = used.get(used.len() / 2)?;
        Some(Lead {
            recorded_s: one.recorded_s,
            drive_s: one.drive_s,
        })
    }

    /// The step of the half of a block that is furthest in the drive from where the line leads, if there is one, and when, s: samples are missing
    /// between it and the blocks of the line.
    fn stray_step(&self, both: &Prepared) -> Result<Option<[f64; 2]>, AlignError> {
        let blocks = Blocks::of(both, self.line.drift_ppm())?;
        let own = self.placed.found.iter().zip(&self.used);
        let used: Vec<&Found> = own.filter_map(|(one, used)| used.then_some(one)).collect();
        let Some(usual) = median(&mut used.iter().map(|one| one.correlation).collect::<Vec<_>>())
        else {
            return Ok(None);
        };
        let found = self.placed.found.iter();
        let weak = found.filter(|one| one.correlation < SUSPECT * usual);
        let weak = weak.map(|one| blocks.start_of(one.recorded_s));
        let mut suspects: Vec<usize> = self.placed.lost.iter().copied().chain(weak).collect();
        suspects.sort_unstable();
        // The first and the last, and others between.
        let last = suspects.len().saturating_sub(1);
        let steps = last.min(SUSPECTS - 1);
        let chosen = (0..=steps).map(|i| i * last / steps.max(1));
        let chosen: Vec<usize> = chosen.filter_map(|i| suspects.get(i).copied()).collect();
        let far_s = LEAST_STEP_S.max(6.0 * self.line.spread);
        let halves = blocks.halves_anywhere(&chosen, STRAY * usual);
        let strays: Vec<(f64, f64)> = halves
            .iter()
            .map(|one| (one.recorded_s, self.line.residual(one)))
            .filter(|(_, by_s)| by_s.abs() > far_s)
            .collect();
        let middle_s = median(&mut used.iter().map(|one| one.recorded_s).collect::<Vec<_>>());
        let quarter_s = 0.25 * both.config.block_s.0;
        let furthest = strays
            .iter()
            .copied()
            .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        Ok(furthest.zip(middle_s).map(|((at_s, by_s), middle_s)| {
            let strays = strays.iter().map(|(at_s, _)| *at_s);
            match at_s < middle_s {
                // The line is that of what comes behind.
                true => {
                    let last_s = strays.filter(|at_s| *at_s < middle_s).fold(at_s, f64::max);
                    [last_s + quarter_s, -by_s]
                }
                false => {
                    let first_s = strays.filter(|at_s| *at_s >= middle_s).fold(at_s, f64::min);
                    [first_s - quarter_s, by_s]
                }
            }
        }))
    }

    /// Where blocks lie further from the line than noise explains.
    ///
    /// Formula: the error of the envelope's maximum is √((1 − ρ²)/(B·T·ρ²))/(2π·B/√12) for the band B, the block T and the correlation ρ.
    fn scatter(&self, both: &Prepared) -> Option<Scatter> {
        let width_hz = both.config.band.high().0 - both.config.band.low().0;
        let cells = width_hz * both.config.block_s.0;
        let own = self.placed.found.iter().zip(&self.used);
        let (mut squares, mut expected, mut largest_s, mut count) = (0.0, 0.0, 0.0_f64, 0.0);
        let (mut variation_s, mut before) = (0.0, None);
        for (one, _) in own.filter(|(_, used)| **used) {
            let off_s = self.line.residual(one);
            let share = one.correlation.clamp(0.05, 0.9999).powi(2);
            let turn = std::f64::consts::TAU * width_hz / 12.0_f64.sqrt();
            squares += off_s * off_s;
            expected += (1.0 - share) / (cells * share) / (turn * turn);
            largest_s = largest_s.max(off_s.abs());
            variation_s += before.map_or(0.0, |before: f64| (off_s - before).abs());
            before = Some(off_s);
            count += 1.0;
        }
        let [spread_s, expected_s] = [squares, expected].map(|sum| (sum / count).sqrt());
        let limit_s = LEAST_SCATTER_S.max(SCATTER * expected_s);
        (spread_s > limit_s).then_some(Scatter {
            spread_s,
            expected_s,
            largest_s,
            variation_s,
        })
    }

    fn left_out(&self) -> usize {
        self.used.iter().filter(|used| !**used).count()
    }
}

pub(super) fn by_blocks(both: &Prepared) -> Result<Alignment, AlignError> {
    let found = ByBlocks::of(both, None)?;
    let more = missed(&found.placed, both, &[]);
    let off = Off {
        step: found.stray_step(both)?,
        ..Off::default()
    };
    let line = (AlignedBy::Blocks, found.line);
    Ok(alignment(both, line, Some(&found), &[], (off, more)))
}

pub(super) fn by_bursts(both: &Prepared, bursts: &Bursts) -> Result<Alignment, AlignError> {
    let seen = seen(both, bursts)?;
    let Some(burst) = seen.bursts.first() else {
        return by_blocks(both);
    };
    let lead = Lead {
        recorded_s: burst.found.recorded_s,
        drive_s: burst.found.drive_s,
    };
    let blocks = ByBlocks::of(both, Some(lead));
    let spans = [bursts.first, bursts.last];
    let Some(line) = seen.line() else {
        let found = blocks.map_err(|error| match error {
            AlignError::FewBlocks { .. } => AlignError::OneBurst { which: burst.which },
            other => other,
        })?;
        let more = missed(&found.placed, both, &spans);
        let off = Off {
            step: found.stray_step(both)?,
            ..Off::default()
        };
        let line = (AlignedBy::Blocks, found.line);
        return Ok(alignment(
            both,
            line,
            Some(&found),
            &seen.bursts,
            (off, more),
        ));
    };
    let worst = |line: &Line| line.half_at(0.0).max(line.half_at(both.recorded_length_s));
    let blocks = blocks.ok();
    let apart_s = blocks
        .as_ref()
        .and_then(|found| apart(both, &found.line, &line));
    let (by, line) = match &blocks {
        Some(found) if worst(&found.line) < worst(&line) => (AlignedBy::Blocks, found.line),
        _ => (AlignedBy::Bursts, line),
    };
    // By the clock that is corrected for the drift that was found.
    let placed = Blocks::of(both, line.drift_ppm()).and_then(|blocks| {
        let placed = blocks.placed(Some(lead))?;
        let offset = Seconds(line.at(0.0));
        let phases = blocks.phase_times(&placed.repeating, offset);
        Ok((placed, phases))
    });
    let (more, uneven_s) = match &placed {
        Ok((placed, phases)) => {
            let runs = phases.iter().filter_map(|run| wandering(run));
            (missed(placed, both, &spans), runs.reduce(f64::max))
        }
        Err(_not_placed) => (
            vec![AlignWarning::Doubtful {
                fault: AlignFault::BetweenNotSeen,
            }],
            None,
        ),
    };
    let off = Off {
        apart_s,
        uneven_s,
        ..Off::default()
    };
    Ok(alignment(
        both,
        (by, line),
        blocks.as_ref(),
        &seen.bursts,
        (off, more),
    ))
}

/// Blocks that are not where they should be, where there are many or several neighbouring ones. Bursts are in every drive that has
/// them, so that blocks with one count neither way.
fn missed(placed: &Placed, both: &Prepared, bursts: &[Span]) -> Vec<AlignWarning> {
    let block_s = both.config.block_s.0;
    let with_burst = |drive_s: f64| {
        bursts.iter().any(|span| {
            let (from_s, to_s) = (span.from_s.0, span.from_s.0 + span.length_s.0);
            drive_s + 0.5 * block_s > from_s && drive_s - 0.5 * block_s < to_s
        })
    };
    let found = placed.found.iter();
    let found = found.filter(|one| !with_burst(one.drive_s));
    let mut found: Vec<f64> = found.map(|one| one.correlation).collect();
    let is_clear = median(&mut found).is_some_and(|usual| usual >= CLEAR);
    let found = found.len();
    let missed = &placed.missed_s;
    let of = found + missed.len() + placed.repeating.len();
    let mut run = 0;
    let mut longest = 0;
    for (i, at_s) in missed.iter().enumerate() {
        let joins = i > 0 && at_s - missed[i - 1] < 1.5 * block_s;
        run = if joins { run + 1 } else { 1 };
        longest = longest.max(run);
    }
    let warning = match (missed.first(), missed.last()) {
        (Some(first), Some(last)) if is_clear || longest >= RUN || MANY * missed.len() > of => {
            Some(AlignWarning::Doubtful {
                fault: AlignFault::DriveNotThere {
                    missed: missed.len(),
                    of,
                    from_s: first - 0.5 * block_s,
                    to_s: last + 0.5 * block_s,
                },
            })
        }
        _ => None,
    };
    warning.into_iter().collect()
}

/// By how much the lines of blocks and of bursts disagree, s.
fn apart(both: &Prepared, blocks: &Line, bursts: &Line) -> Option<f64> {
    let ends_s = [0.0, both.recorded_length_s];
    let far = ends_s.map(|at_s| {
        let by_s = (blocks.at(at_s) - bursts.at(at_s)).abs();
        // 95 % intervals of both, and once more, as what a device delays differs between them.
        let sure_s = 2.0 * (blocks.half_at(at_s) + bursts.half_at(at_s));
        (by_s > CERTAIN_S + sure_s).then_some(by_s)
    });
    far.into_iter().flatten().reduce(f64::max)
}

/// By how much phases move against the line, s.
fn wandering(run: &[[f64; 2]]) -> Option<f64> {
    let times = || run.iter().map(|[time_s, _]| *time_s);
    let by_s = times().fold(f64::MIN, f64::max) - times().fold(f64::MAX, f64::min);
    let error_s = run.iter().map(|[_, error_s]| *error_s).fold(0.0, f64::max);
    (by_s > CERTAIN_S.max(PHASE_ERRORS * error_s)).then_some(by_s)
}

/// By what times are off, as far as it was found.
#[derive(Default)]
struct Off {
    /// When the places of blocks step, and by how much, s.
    step: Option<[f64; 2]>,
    scatter: Option<Scatter>,
    /// By how much blocks and bursts disagree, s.
    apart_s: Option<f64>,
    /// By how much phases move against the line, s.
    uneven_s: Option<f64>,
}

/// How blocks scatter about their line, s.
struct Scatter {
    spread_s: f64,
    expected_s: f64,
    largest_s: f64,
    variation_s: f64,
}

impl Off {
    /// By how much times may be off, s.
    fn wider_s(&self) -> f64 {
        let step_s = self.step.map(|[_, by_s]| by_s.abs());
        // Of a staircase the ends lie twice as far from its line as its steps.
        let scatter_s = self.scatter.as_ref().map(|found| 2.0 * found.largest_s);
        let parts = [step_s, self.apart_s, self.uneven_s, scatter_s];
        parts.into_iter().flatten().fold(0.0, f64::max)
    }

    /// By how much the line may bend over the recording, s.
    fn bent_s(&self) -> f64 {
        let step_s = self.step.map(|[_, by_s]| by_s.abs());
        // Blocks behind a larger step are not followed, and the line is not drawn with them.
        let near_s = step_s.filter(|by_s| *by_s <= NEAR_S);
        // Blocks that hold a lost sample show a part of its step.
        let scatter_s = self.scatter.as_ref().map(|found| found.variation_s);
        let parts = [near_s, self.apart_s, self.uneven_s, scatter_s];
        1.5 * parts.into_iter().flatten().fold(0.0, f64::max)
    }

    /// The warnings about it, among `more`.
    fn warnings(&self, more: Vec<AlignWarning>) -> Vec<AlignWarning> {
        let apart = self.apart_s.map(|by_s| AlignWarning::Doubtful {
            fault: AlignFault::BurstsApart { by_s },
        });
        let uneven = self.uneven_s.map(|by_s| AlignWarning::Doubtful {
            fault: AlignFault::Uneven { by_s },
        });
        let step = self.step.map(|[at_s, by_s]| AlignWarning::Doubtful {
            fault: AlignFault::Step { at_s, by_s },
        });
        let scatter = self.scatter.as_ref().map(|found| AlignWarning::Doubtful {
            fault: AlignFault::Scatter {
                spread_s: found.spread_s,
                expected_s: found.expected_s,
                largest_s: found.largest_s,
                variation_s: found.variation_s,
            },
        });
        let of_line = [uneven, step, scatter].into_iter().flatten();
        apart.into_iter().chain(more).chain(of_line).collect()
    }
}

/// The alignment along `line`, which was drawn by blocks or by bursts.
fn alignment(
    both: &Prepared,
    (by, line): (AlignedBy, Line),
    blocks: Option<&ByBlocks>,
    bursts: &[Burst],
    (mut off, more): (Off, Vec<AlignWarning>),
) -> Alignment {
    let length_s = both.recorded_length_s;
    if let Some(found) = blocks {
        off.step = off.step.or_else(|| step(&found.placed.found));
        if by == AlignedBy::Blocks {
            off.scatter = found.scatter(both);
        }
    }
    let mut warnings = off.warnings(more);
    // What is off is within the interval.
    let wider_s = off.wider_s();
    let half = |at_s: f64| line.half_at(at_s) + wider_s;
    let uncertainty_s = half(0.0).max(half(length_s));
    let (offset_s, drift_ppm) = (line.at(0.0), line.drift_ppm());
    let wider_ppm = 1e6 * off.bent_s() / length_s;
    let [low_ppm, high_ppm] = line.drift_interval_ppm();
    let covered_s = [
        offset_s.max(0.0),
        line.at(length_s).min(both.drive_length_s),
    ];
    if uncertainty_s > CERTAIN_S {
        warnings.push(AlignWarning::Doubtful {
            fault: AlignFault::Uncertain {
                uncertainty_s,
                blocks: match (by, blocks) {
                    (AlignedBy::Blocks, Some(found)) => found.used.len() - found.left_out(),
                    _ => 0,
                },
            },
        });
    }
    if let Some(found) = blocks {
        let (left_out, of) = (found.left_out(), found.used.len());
        if by == AlignedBy::Blocks && MANY * left_out > of {
            warnings.push(AlignWarning::Doubtful {
                fault: AlignFault::LeftOut { left_out, of },
            });
        }
    }
    if drift_ppm.abs() > 0.8 * both.config.most_drift_ppm {
        warnings.push(AlignWarning::Doubtful {
            fault: AlignFault::DriftAtLimit {
                drift_ppm,
                most_ppm: both.config.most_drift_ppm,
            },
        });
    }
    let times = (0..=STEPS).map(|i| length_s * i as f64 / STEPS as f64);
    Alignment {
        config: both.config,
        by,
        offset_s: Seconds(offset_s),
        offset_interval_s: [-1.0, 1.0].map(|side| Seconds(offset_s + side * half(0.0))),
        drift_ppm,
        drift_interval_ppm: [low_ppm - wider_ppm, high_ppm + wider_ppm],
        uncertainty_s: Seconds(uncertainty_s),
        intervals_s: times
            .map(|at_s| (Seconds(at_s), Seconds(half(at_s))))
            .collect(),
        spread_s: (by == AlignedBy::Blocks).then_some(Seconds(line.spread)),
        covered_s: covered_s.map(Seconds),
        drive_length_s: Seconds(both.drive_length_s),
        blocks: blocks.map_or(Vec::new(), |found| found.places(by)),
        bursts: bursts.iter().map(burst_place).collect(),
        warnings: warnings.into_iter().map(Into::into).collect(),
    }
}

impl ByBlocks {
    fn places(&self, by: AlignedBy) -> Vec<BlockPlace> {
        let place = |(one, used): (&Found, &bool)| BlockPlace {
            recorded_s: Seconds(one.recorded_s),
            drive_s: Seconds(one.drive_s),
            correlation: one.correlation,
            used: *used && by == AlignedBy::Blocks,
        };
        self.placed
            .found
            .iter()
            .zip(&self.used)
            .map(place)
            .collect()
    }
}

fn burst_place(burst: &Burst) -> BurstPlace {
    BurstPlace {
        which: burst.which,
        recorded_s: Seconds(burst.found.recorded_s),
        drive_s: Seconds(burst.found.drive_s),
        correlation: burst.found.correlation,
        error_s: Seconds(burst.error_s),
    }
}
