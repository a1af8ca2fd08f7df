//! Drives for a participant who has just touched the samples: the stroke of each texture that is rendered, one level for all of
//! them, and what of it is not good enough.

mod document;
mod page;
mod warning;

pub use document::{ChosenStroke, NotGoodEnough, Prepared, PreparedDrives, State, TextureStrokes};
pub use warning::PrepareWarning;

use crate::compare::{CompareWarning, Mixed};
use crate::feature::band_power;
use crate::number::rounded;
use crate::quantity::{Acceleration, Band, Decibels, Drive, Hertz, Seconds};
use crate::recording::{Condition, Reached, RecordingWarning};
use crate::render::{RenderConfig, RenderError, at_fitting_level, render};
use crate::series::Series;
use crate::spectrum::{EstimateError, WelchConfig, WelchPlan};
use crate::statistics::{mean, median, rms};
use crate::stroke::{StrokeWarning, Unusual};
use crate::transfer::TransferFunction;
use crate::warning::{Few, FewWarning, Scatter, ScatterWarning, Warning};

/// A shorter stroke is compared with others only where all are as short.
const SHORTEST: Seconds = Seconds(0.25);
/// Strokes of one texture whose median distance from the median stroke is larger raise a warning, dB.
const STROKES_DIFFER_DB: f64 = 6.0;
/// How many times the width of a spectral line a third octave must be wide to be compared.
const LINES_A_BAND: f64 = 2.0;
/// Loads that differ by more than this share are others.
const OTHER_LOAD: f64 = 0.1;
/// The power that counts as the smallest, (m/s²)².
const SMALLEST_POWER: f64 = 1e-30;

/// The stroke of a texture that stands for the others.
#[derive(Clone, Debug, PartialEq)]
pub struct TypicalStroke {
    /// Which of the strokes, from 0.
    pub index: usize,
    /// How far each stroke lies from the median of all, dB rms over the bands; none for a stroke too short to be compared.
    pub distances_db: Vec<Option<f64>>,
    /// The bands that were compared.
    pub bands: Vec<Band>,
}

impl TypicalStroke {
    /// How far strokes of this texture usually lie from their median, dB: the median of the distances.
    #[must_use]
    pub fn spread_db(&self) -> f64 {
        let mut known: Vec<f64> = self.distances_db.iter().copied().flatten().collect();
        median(&mut known).unwrap_or(0.0)
    }

    /// What the strokes leave open, for the texture called `texture`, of which the chosen one lasts `chosen`.
    #[must_use]
    pub fn warnings(&self, texture: &str, chosen: Seconds) -> Vec<Warning> {
        let texture = texture.to_owned();
        let mut warnings = Vec::new();
        if self.distances_db.len() == 1 {
            warnings.push(Warning::from(FewWarning::Few {
                found: 1,
                recommended: 3,
                what: Few::StrokesOfTexture {
                    texture: texture.clone(),
                },
            }));
        }
        let spread_db = self.spread_db();
        if spread_db > STROKES_DIFFER_DB {
            warnings.push(Warning::from(ScatterWarning::Scatter {
                of: Scatter::StrokesOfTexture {
                    texture: texture.clone(),
                    spread_db,
                },
            }));
        }
        if chosen.0 < 2.0 * SHORTEST.0 {
            warnings.push(Warning::from(StrokeWarning::UnusualStroke {
                what: Unusual::Short {
                    texture,
                    duration_s: chosen.0,
                },
            }));
        }
        warnings
    }
}

/// The stroke of `strokes` whose levels in third octaves of `band` lie closest to the median of all, dB rms; of equally close ones
/// the longest. Strokes shorter than 0.25 s are left out where there are longer ones.
///
/// Formula: argmin over strokes of the rms over bands of L(stroke, band) − median over strokes of L(·, band), L = 10·log10 of the
/// power in the band from a Hann periodogram of the whole stroke; bands narrower than two lines of the shortest stroke are left
/// out.
///
/// Source: the medoid of L. Kaufman and P. J. Rousseeuw, Finding Groups in Data, Wiley 1990, chapter 2, with the median in place
/// of the other objects; third octaves of IEC 61260-1:2014, base two.
///
/// # Errors
/// [`EstimateError`] where there is no stroke, or one has too few samples for a spectrum.
pub fn typical_stroke(
    strokes: &[Series<Acceleration>],
    band: Band,
) -> Result<TypicalStroke, EstimateError> {
    let long_enough = |stroke: &Series<Acceleration>| stroke.duration().0 >= SHORTEST.0;
    let any_long = strokes.iter().any(long_enough);
    let compared: Vec<usize> = (0..strokes.len())
        .filter(|i| !any_long || long_enough(&strokes[*i]))
        .collect();
    let durations = compared.iter().map(|i| strokes[*i].duration().0);
    let nyquist = compared.iter().map(|i| strokes[*i].rate().hz() / 2.0);
    let bands = bands(
        band,
        durations.fold(f64::INFINITY, f64::min),
        nyquist.fold(f64::INFINITY, f64::min),
    );
    let levels = compared.iter().map(|i| levels_db(&strokes[*i], &bands));
    let levels = levels.collect::<Result<Vec<_>, _>>()?;
    let middle: Vec<f64> = (0..bands.len())
        .map(|b| {
            let mut all: Vec<f64> = levels.iter().map(|of| of[b]).collect();
            median(&mut all).unwrap_or(0.0)
        })
        .collect();
    let mut distances_db = vec![None; strokes.len()];
    for (i, of) in compared.iter().zip(&levels) {
        let off: Vec<f64> = of.iter().zip(&middle).map(|(l, m)| l - m).collect();
        distances_db[*i] = Some(rms(&off));
    }
    let closest = compared.into_iter().min_by(|a, b| {
        let key = |i: usize| {
            (
                distances_db[i].unwrap_or(f64::INFINITY),
                -strokes[i].duration().0,
            )
        };
        let ((a_db, a_s), (b_db, b_s)) = (key(*a), key(*b));
        a_db.total_cmp(&b_db).then(a_s.total_cmp(&b_s))
    });
    Ok(TypicalStroke {
        index: closest.ok_or(EstimateError::TooShort {
            expected: 1,
            found: 0,
        })?,
        distances_db,
        bands,
    })
}

/// The third octaves within `band` that are wide enough for strokes of `shortest_s` and end below `nyquist_hz`; all of the band
/// where there is none.
fn bands(band: Band, shortest_s: f64, nyquist_hz: f64) -> Vec<Band> {
    let edge = |k: i32| 1000.0 * ((f64::from(k) - 0.5) / 3.0).exp2();
    let least_hz = LINES_A_BAND / shortest_s;
    let (low, high) = (band.low().0, band.high().0.min(nyquist_hz));
    let thirds = (-40..60).filter_map(|k| {
        let (from, to) = (edge(k).max(low), edge(k + 1).min(high));
        (to - from >= least_hz).then(|| Band::new(Hertz(from), Hertz(to)).ok())?
    });
    let thirds: Vec<Band> = thirds.collect();
    if thirds.is_empty() {
        vec![band]
    } else {
        thirds
    }
}

/// The level of `stroke` in each of `bands`, dB re 1 m/s².
fn levels_db(stroke: &Series<Acceleration>, bands: &[Band]) -> Result<Vec<f64>, EstimateError> {
    let config = WelchConfig::hann(stroke.samples().len());
    let about = mean(stroke.samples());
    let samples: Vec<f64> = stroke.samples().iter().map(|v| v - about).collect();
    let spectrum = WelchPlan::new(&config, stroke.rate())?.estimate::<Acceleration>(&[&samples])?;
    let level = |band: &Band| {
        let power = band_power(&spectrum.values, spectrum.resolution_hz, *band);
        10.0 * power.max(SMALLEST_POWER).log10()
    };
    Ok(bands.iter().map(level).collect())
}

/// What the `conditions` of the recordings of one texture leave open, beside each other and beside that of the transfer function: loads
/// in N that differ by more than 10 % are others.
///
/// Source: docs/decisions/rendering.md.
#[must_use]
pub fn warnings_of_conditions(
    texture: &str,
    conditions: &[&Condition],
    function: &Condition,
) -> Vec<Warning> {
    let of = |what: &str, value: fn(&Condition) -> Option<String>| {
        let mut values: Vec<String> = conditions.iter().filter_map(|c| value(c)).collect();
        values.sort();
        values.dedup();
        (values.len() > 1).then(|| {
            Warning::from(CompareWarning::Mixed {
                how: Mixed::OneTexture {
                    texture: texture.to_owned(),
                    what: what.to_owned(),
                    values: values.join(", "),
                },
            })
        })
    };
    let mut warnings: Vec<Warning> = [
        of("kinds of touch", |c| {
            c.touch.map(|touch| format!("{touch:?}").to_lowercase())
        }),
        of("directions", |c| c.direction.map(|d| d.to_string())),
        of("speeds", |c| {
            c.speed_m_s.map(|v| format!("{} mm/s", rounded(v * 1e3)))
        }),
        of("loads", |c| {
            c.load_n.map(|load| format!("{} N", rounded(load.0)))
        }),
    ]
    .into_iter()
    .flatten()
    .collect();
    let loads = conditions
        .iter()
        .filter_map(|c| c.load_n.map(|load| load.0));
    let other = loads.zip(std::iter::repeat(function.load_n));
    let other = other.filter_map(|(strokes_n, transfer)| Some((strokes_n, transfer?.0)));
    let mut other =
        other.filter(|(strokes_n, transfer_n)| (strokes_n / transfer_n - 1.0).abs() > OTHER_LOAD);
    warnings.extend(other.next().map(|(strokes_n, transfer_n)| {
        Warning::from(RecordingWarning::ConditionDiffers {
            what: Reached::StrokesLoad {
                texture: texture.to_owned(),
                strokes_n,
                transfer_n,
            },
        })
    }));
    warnings
}

/// One level for several textures.
#[derive(Clone, Debug, PartialEq)]
pub struct CommonLevel {
    /// The level re the textures, dB; 0 or below.
    pub level_db: f64,
    /// The texture that sets it, from 0; none where all fit at their own level.
    pub limited_by: Option<usize>,
}

/// The highest level, 0 dB or below and a tenth of a dB, at which the drives of all `targets` fit the device: textures that are
/// rendered at one level keep their differences in level. Targets that no level makes fit do not count.
///
/// Formula: the lowest of the levels of [`at_fitting_level`], `margin` lower where one is below 0 dB.
///
/// Source: docs/decisions/rendering.md; thesis 4.1, where the level of a texture is part of what is felt.
#[must_use]
pub fn common_level(
    targets: &[Series<Acceleration>],
    function: &TransferFunction<Drive, Acceleration>,
    config: &RenderConfig,
    margin: Decibels,
) -> CommonLevel {
    let mut found = CommonLevel {
        level_db: 0.0,
        limited_by: None,
    };
    for (i, target) in targets.iter().enumerate() {
        let (level, done) = at_fitting_level(
            |level| render(&target.clone().amplified(level), function, config),
            RenderError::fits_at,
        );
        let again = done.err().and_then(|error| error.fits_at());
        let level_db = level.0 + again.map_or(0.0, |lower| lower.0);
        if level_db < found.level_db {
            found = CommonLevel {
                level_db,
                limited_by: Some(i),
            };
        }
    }
    if found.limited_by.is_some() {
        let level_db = found.level_db - margin.0;
        // To the tenth below: rounded up it would not fit.
        found.level_db = (level_db * 10.0 + 1e-6).floor() / 10.0;
    }
    found
}
