//! Removes narrow resonances of the bench, identified in a control measurement without a finger, from the transfer functions of
//! fingers.

use crate::panel::PanelError;
use crate::panel::PanelWarning;
use std::f64::consts::PI;

use num_complex::Complex;
use serde::{Deserialize, Serialize};

use crate::quantity::{Band, Hertz, Quantity};
use crate::transfer::{TransferFunction, level_db, unwrapped};
use crate::warning::Warning;

/// The straight lines on both sides of an artefact hold at least this many lines each.
const LEAST_LINES: usize = 3;
/// An artefact is the lowest line within this ratio of its frequency.
const ALONE_RATIO: f64 = 1.15;
/// The depth of a dip in a finger is measured against the levels at these ratios of its frequency, where fingers vary little.
const NEAR_RATIO: [f64; 2] = [1.15, 1.25];

/// Within this ratio of its frequency the structure of the control is taken as the artefact …
const INNER_RATIO: f64 = 1.6;
/// … and from there to this one its factor fades to 1, and the trend of the control is fitted.
const OUTER_RATIO: f64 = 2.5;
/// How deep an artefact must be, dB.
const LEAST_DEPTH_DB: f64 = 3.0;
/// A warning is raised when the coherence of the control is below this.
const LEAST_COHERENCE: f64 = 0.8;

/// The factor of a narrow structure of a bench, without the bench's level and trend: 1 at frequencies without structure.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Artefact {
    /// Where it is lowest, Hz.
    pub at_hz: f64,
    /// How far below the trend it reaches, dB.
    pub depth_db: f64,
    /// The band in which the factor differs from 1.
    pub window_hz: Band,
    /// What a person should know before relying on it.
    #[serde(skip)]
    pub warnings: Vec<Warning>,
    #[serde(skip)]
    factor: Vec<Complex<f64>>,
    #[serde(skip)]
    resolution_hz: f64,
}

/// A dip in a transfer function at an artefact, measured against the straight line between the levels on both sides.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Dip {
    /// The lowest line within ±15 % of the artefact, Hz.
    pub at_hz: f64,
    /// How far it lies below the straight line in dB over log f between the mean levels 15–25 % below and above, dB.
    pub depth_db: f64,
    /// The largest departure from that line, either way, within ±15 %, dB.
    pub largest_db: f64,
}

/// A transfer function with an artefact removed.
#[derive(Clone, Debug, PartialEq)]
pub struct Removed<I: Quantity, O: Quantity> {
    /// The transfer function after the removal.
    pub function: TransferFunction<I, O>,
    /// The dip at the artefact before the removal.
    pub before: Dip,
    /// The dip at the artefact after the removal.
    pub after: Dip,
}

/// A straight line.
#[derive(Clone, Copy)]
struct Straight {
    middle: f64,
    slope: f64,
    about: f64,
}

impl Straight {
    fn at(self, x: f64) -> f64 {
        self.middle + self.slope * (x - self.about)
    }

    /// The one nearest to `points` by least squares.
    fn through(points: impl Iterator<Item = (f64, f64)>) -> Self {
        let points: Vec<(f64, f64)> = points.collect();
        let n = points.len().max(1) as f64;
        let about = points.iter().map(|p| p.0).sum::<f64>() / n;
        let middle = points.iter().map(|p| p.1).sum::<f64>() / n;
        let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
            points.iter().map(|(x, y)| of(x - about, y - middle)).sum()
        };
        let (xy, xx) = (sum(&|x, y| x * y), sum(&|x, _| x * x));
        Self {
            middle,
            slope: if xx > 0.0 { xy / xx } else { 0.0 },
            about,
        }
    }
}

/// The lines on both sides of `at_hz` from `inner` to `outer` times away; `None` when one side has too few.
fn shoulders(
    at_hz: f64,
    [inner, outer]: [f64; 2],
    lines: usize,
    resolution_hz: f64,
) -> Option<Vec<usize>> {
    let hz = |line: usize| line as f64 * resolution_hz;
    let side = |low: f64, high: f64| -> Vec<usize> {
        (1..lines)
            .filter(|line| (low..=high).contains(&hz(*line)))
            .collect()
    };
    let below = side(at_hz / outer, at_hz / inner);
    let above = side(at_hz * inner, at_hz * outer);
    (below.len() >= LEAST_LINES && above.len() >= LEAST_LINES).then(|| [below, above].concat())
}

/// The bench's narrow dip in `control`, a measurement without a finger, of any quantities.
///
/// Formula: of every line that is the lowest within ±15 % the depth below the straight line in dB over log f, fitted by
/// least squares to the levels at 1/2.5–1/1.6 and 1.6–2.5 times its frequency; the deepest is the artefact. Its factor is
/// the control over that line, with the phase over a straight line in f fitted to the same places, and fades to 1 there
/// with a raised cosine over log f. The control's own level and trend are not taken out.
///
/// Source: L. Felicetti's thesis (2024), figure 71, for the control measurement; the normalisation is ours.
///
/// # Errors
/// [`PanelError::NoDip`] when nothing is deep enough.
pub fn artefact_of<C: Quantity, R: Quantity>(
    control: &TransferFunction<C, R>,
    search: Band,
) -> Result<Artefact, PanelError> {
    let ratios = [INNER_RATIO, OUTER_RATIO];
    let no_dip = || PanelError::NoDip {
        band: search,
        least_db: LEAST_DEPTH_DB,
    };
    let resolution_hz = control.resolution_hz();
    let db: Vec<f64> = control.response().iter().map(|h| level_db(*h)).collect();
    let hz = |line: usize| line as f64 * resolution_hz;
    let log = |line: usize| hz(line).max(f64::MIN_POSITIVE).ln();
    let mut deepest: Option<(usize, Straight, f64, Vec<usize>)> = None;
    for (line, at_hz) in control.lines_in(search).filter(|(line, _)| *line > 0) {
        let range = at_hz / ALONE_RATIO..=at_hz * ALONE_RATIO;
        let mut near = (1..db.len()).filter(|other| range.contains(&hz(*other)));
        if near.any(|other| db[other] < db[line]) {
            continue;
        }
        let Some(sides) = shoulders(at_hz, ratios, db.len(), resolution_hz) else {
            continue;
        };
        let trend = Straight::through(sides.iter().map(|k| (log(*k), db[*k])));
        let depth = trend.at(log(line)) - db[line];
        let is_deeper = |(_, _, found, _): &(usize, Straight, f64, Vec<usize>)| depth > *found;
        if deepest.as_ref().is_none_or(is_deeper) {
            deepest = Some((line, trend, depth, sides));
        }
    }
    let found = deepest.filter(|(_, _, depth, _)| *depth >= LEAST_DEPTH_DB);
    let (line, trend, depth_db, sides) = found.ok_or_else(no_dip)?;
    let at_hz = hz(line);
    let phases = unwrapped(control.response().iter().copied());
    let turning = Straight::through(sides.iter().map(|k| (hz(*k), phases[*k])));
    let factor = (0..db.len())
        .map(|k| {
            let weight = fading(hz(k) / at_hz, ratios);
            if weight <= 0.0 {
                return Complex::ONE;
            }
            let level = (db[k] - trend.at(log(k))) * weight;
            Complex::from_polar(
                10f64.powf(level / 20.0),
                (phases[k] - turning.at(hz(k))) * weight,
            )
        })
        .collect();
    let around = |ratio: f64| Band::new(Hertz(at_hz / ratio), Hertz(at_hz * ratio)).ok();
    let seen = around(INNER_RATIO).and_then(|band| control.coherence_in(band));
    let seen = seen.filter(|seen| seen.lowest < LEAST_COHERENCE);
    let incoherent = seen.map(|seen| PanelWarning::ControlIncoherent {
        lowest: seen.lowest,
        at_hz: seen.lowest_at_hz,
        asked: LEAST_COHERENCE,
    });
    Ok(Artefact {
        at_hz,
        depth_db,
        window_hz: around(OUTER_RATIO).ok_or_else(no_dip)?,
        warnings: incoherent.into_iter().map(Warning::from).collect(),
        factor,
        resolution_hz,
    })
}

/// 1 within the inner ratio of 1, 0 beyond the outer one.
fn fading(ratio: f64, [inner, outer]: [f64; 2]) -> f64 {
    let away = ratio.max(f64::MIN_POSITIVE).ln().abs();
    let (from, to) = (inner.ln(), outer.ln());
    if away <= from {
        1.0
    } else if away >= to {
        0.0
    } else {
        0.5 + 0.5 * (PI * (away - from) / (to - from)).cos()
    }
}

impl Artefact {
    /// `function` divided by the artefact, magnitude and phase, with what was seen of it before and after.
    ///
    /// # Errors
    /// [`PanelError::ControlLines`] when the control had other lines.
    pub fn remove_from<I: Quantity, O: Quantity>(
        &self,
        function: &TransferFunction<I, O>,
    ) -> Result<Removed<I, O>, PanelError> {
        let [control, other] = [
            (self.factor.len(), self.resolution_hz),
            (function.response().len(), function.resolution_hz()),
        ];
        if control.0 != other.0 || (other.1 / control.1 - 1.0).abs() > 1e-9 {
            let text =
                |(lines, every_hz): (usize, f64)| format!("{lines} lines every {every_hz:.4} Hz");
            return Err(PanelError::ControlLines {
                control: text(control),
                function: text(other),
            });
        }
        let line = |hz: f64| (hz / self.resolution_hz).round() as usize;
        let mut freed = function.clone().times(|hz| self.factor[line(hz)].inv());
        freed.about.provenance = function.about.provenance.clone().then(format!(
            "divided by the dip of the bench at {:.1} Hz, {:.1} dB deep in the control",
            self.at_hz, self.depth_db
        ));
        Ok(Removed {
            before: self.dip_of(function),
            after: self.dip_of(&freed),
            function: freed,
        })
    }

    fn dip_of<I: Quantity, O: Quantity>(&self, function: &TransferFunction<I, O>) -> Dip {
        let resolution_hz = self.resolution_hz;
        let lines = function.response().len();
        let hz = |line: usize| line as f64 * resolution_hz;
        let db = |line: usize| level_db(function.response()[line]);
        let sides = shoulders(self.at_hz, NEAR_RATIO, lines, resolution_hz).unwrap_or_default();
        let trend = Straight::through(sides.iter().map(|k| (hz(*k).ln(), db(*k))));
        let range = self.at_hz / NEAR_RATIO[0]..=self.at_hz * NEAR_RATIO[0];
        let mut dip = Dip {
            at_hz: self.at_hz,
            depth_db: f64::MIN,
            largest_db: 0.0,
        };
        for line in (1..lines).filter(|line| range.contains(&hz(*line))) {
            let below = trend.at(hz(line).ln()) - db(line);
            if below > dip.depth_db {
                (dip.at_hz, dip.depth_db) = (hz(line), below);
            }
            dip.largest_db = dip.largest_db.max(below.abs());
        }
        dip
    }
}
