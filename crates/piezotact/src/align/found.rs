//! From the places of blocks and bursts to an alignment with its doubts.

use super::anchored::{Burst, seen};
use super::burst::Bursts;
use super::line::{Found, Line, converged, robust, step};
use super::search::{Blocks, Lead, Placed};
use super::{AlignDoubt, AlignError, AlignedBy, Alignment, BlockPlace, BurstPlace, Prepared, Span};
use crate::quantity::Seconds;
use crate::statistics::median;

/// Less certain times are doubted, s.
const CERTAIN_S: f64 = 1e-4;
/// So many neighbouring blocks that are not where they should be are doubted, and so is a share of one in [`MANY`].
const RUN: usize = 2;
/// Where half of the blocks correlate by this or more, a single one that does not is doubted.
const CLEAR: f64 = 0.7;
/// One in so many is many.
const MANY: usize = 5;
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

    fn left_out(&self) -> usize {
        self.used.iter().filter(|used| !**used).count()
    }
}

pub(super) fn by_blocks(both: &Prepared) -> Result<Alignment, AlignError> {
    let found = ByBlocks::of(both, None)?;
    let missed = missed(&found.placed, both, &[]);
    let line = (AlignedBy::Blocks, found.line);
    Ok(alignment(both, line, Some(&found), &[], missed))
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
        let missed = missed(&found.placed, both, &spans);
        let line = (AlignedBy::Blocks, found.line);
        return Ok(alignment(both, line, Some(&found), &seen.bursts, missed));
    };
    let worst = |line: &Line| line.half_at(0.0).max(line.half_at(both.recorded_length_s));
    let blocks = blocks.ok();
    let apart = blocks
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
    let mut doubts: Vec<AlignDoubt> = apart.into_iter().collect();
    if let Ok((placed, phases)) = &placed {
        doubts.extend(missed(placed, both, &spans));
        doubts.extend(
            phases
                .iter()
                .filter_map(|run| wandering(run))
                .reduce(|one, other| match (&one, &other) {
                    (AlignDoubt::Uneven { by_s: a }, AlignDoubt::Uneven { by_s: b }) if b > a => {
                        other
                    }
                    _ => one,
                }),
        );
    } else {
        doubts.push(AlignDoubt::BetweenNotSeen {});
    }
    Ok(alignment(
        both,
        (by, line),
        blocks.as_ref(),
        &seen.bursts,
        doubts,
    ))
}

/// Blocks that are not where they should be, where there are many or several neighbouring ones. Bursts are in every drive that has
/// them, so that blocks with one count neither way.
fn missed(placed: &Placed, both: &Prepared, bursts: &[Span]) -> Vec<AlignDoubt> {
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
    let doubt = match (missed.first(), missed.last()) {
        (Some(first), Some(last)) if is_clear || longest >= RUN || MANY * missed.len() > of => {
            Some(AlignDoubt::NotThere {
                missed: missed.len(),
                of,
                from_s: first - 0.5 * block_s,
                to_s: last + 0.5 * block_s,
            })
        }
        _ => None,
    };
    doubt.into_iter().collect()
}

/// Where the lines of blocks and of bursts disagree.
fn apart(both: &Prepared, blocks: &Line, bursts: &Line) -> Option<AlignDoubt> {
    let ends_s = [0.0, both.recorded_length_s];
    let far = ends_s.map(|at_s| {
        let by_s = (blocks.at(at_s) - bursts.at(at_s)).abs();
        // 95 % intervals of both, and once more, as what a device delays differs between them.
        let sure_s = 2.0 * (blocks.half_at(at_s) + bursts.half_at(at_s));
        (by_s > CERTAIN_S + sure_s).then_some(by_s)
    });
    let far = far.into_iter().flatten().reduce(f64::max);
    far.map(|by_s| AlignDoubt::Apart { by_s })
}

/// Phases that move against the line.
fn wandering(run: &[[f64; 2]]) -> Option<AlignDoubt> {
    let times = || run.iter().map(|[time_s, _]| *time_s);
    let by_s = times().fold(f64::MIN, f64::max) - times().fold(f64::MAX, f64::min);
    let error_s = run.iter().map(|[_, error_s]| *error_s).fold(0.0, f64::max);
    (by_s > CERTAIN_S.max(PHASE_ERRORS * error_s)).then_some(AlignDoubt::Uneven { by_s })
}

/// The alignment along `line`, which was drawn by blocks or by bursts.
fn alignment(
    both: &Prepared,
    (by, line): (AlignedBy, Line),
    blocks: Option<&ByBlocks>,
    bursts: &[Burst],
    more: Vec<AlignDoubt>,
) -> Alignment {
    let length_s = both.recorded_length_s;
    let half = |at_s: f64| line.half_at(at_s);
    let uncertainty_s = half(0.0).max(half(length_s));
    let (offset_s, drift_ppm) = (line.at(0.0), line.drift_ppm());
    let covered_s = [
        offset_s.max(0.0),
        line.at(length_s).min(both.drive_length_s),
    ];
    let mut doubts = more;
    if covered_s[0] > CERTAIN_S || covered_s[1] < both.drive_length_s - CERTAIN_S {
        doubts.push(AlignDoubt::PartCovered {
            from_s: covered_s[0],
            to_s: covered_s[1],
            length_s: both.drive_length_s,
        });
    }
    if uncertainty_s > CERTAIN_S {
        doubts.push(AlignDoubt::Uncertain {
            uncertainty_s,
            blocks: match (by, blocks) {
                (AlignedBy::Blocks, Some(found)) => found.used.len() - found.left_out(),
                _ => 0,
            },
        });
    }
    if let Some(found) = blocks {
        let step = step(&found.placed.found);
        doubts.extend(step.map(|[at_s, by_s]| AlignDoubt::Step { at_s, by_s }));
        let (left_out, of) = (found.left_out(), found.used.len());
        if by == AlignedBy::Blocks && MANY * left_out > of {
            doubts.push(AlignDoubt::ManyLeftOut { left_out, of });
        }
    }
    if drift_ppm.abs() > 0.8 * both.config.most_drift_ppm {
        doubts.push(AlignDoubt::DriftAtLimit {
            drift_ppm,
            most_ppm: both.config.most_drift_ppm,
        });
    }
    let times = (0..=STEPS).map(|i| length_s * i as f64 / STEPS as f64);
    Alignment {
        config: both.config,
        by,
        offset_s: Seconds(offset_s),
        offset_interval_s: [-1.0, 1.0].map(|side| Seconds(offset_s + side * half(0.0))),
        drift_ppm,
        drift_interval_ppm: line.drift_interval_ppm(),
        uncertainty_s: Seconds(uncertainty_s),
        intervals_s: times
            .map(|at_s| (Seconds(at_s), Seconds(half(at_s))))
            .collect(),
        spread_s: (by == AlignedBy::Blocks).then_some(Seconds(line.spread)),
        covered_s: covered_s.map(Seconds),
        drive_length_s: Seconds(both.drive_length_s),
        blocks: blocks.map_or(Vec::new(), |found| found.places(by)),
        bursts: bursts.iter().map(burst_place).collect(),
        doubts: doubts.into_iter().map(Into::into).collect(),
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
