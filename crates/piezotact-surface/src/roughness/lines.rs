//! Profiles along the rows or columns of a height map: their roughness, and the spectrum of their heights.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::profile::{ROUNDING_M, common_cutoff, few_sections};
use super::{
    Cutoff, HeightMap, HeightProfile, Parameter, ProfileConfig, ProfileRoughness, Roughness,
    RoughnessError, RoughnessOptions, SurfaceWarning, profile_roughness, usual_config,
};
use piezotact::Warning;
use piezotact::fourier::{RealTransform, hann};
use piezotact::statistics::{mean, standard_deviation};

/// Lines that are evaluated at most, evenly spread over the map.
const MOST_LINES: usize = 500;
/// Bins of the spectrum to a factor of ten in wavelength.
const BINS_PER_DECADE: f64 = 10.0;
/// A law in fewer decades of wavelength is none.
const FEWEST_DECADES: f64 = 1.0;
/// Waves shorter than so many steps are not those of the surface alone.
const STEPS_PER_WAVE: f64 = 4.0;
/// The longest waves are as wide as the main lobe of the window.
const WAVES_PER_LINE: f64 = 2.0;
/// The scatter of a bin beyond chance, decades, and the standard deviations up to which it counts as on the line.
const SCATTER: f64 = 0.02;
const MOST_DEVIATIONS: f64 = 2.5;

/// Along which axis of a map its lines run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum LineDirection {
    /// Along the rows.
    X,
    /// Along the columns.
    Y,
}

impl fmt::Display for LineDirection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::X => "x",
            Self::Y => "y",
        })
    }
}

/// A parameter of profiles over the lines of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct LineParameter {
    /// Its symbol, unit and meaning, with the mean over lines as value.
    pub mean: Parameter,
    /// The standard deviation between lines, in the unit of the parameter; absent where it has no value.
    pub deviation: Option<f64>,
}

/// A stretch of a spectrum that follows a power law.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PowerLaw {
    /// The exponent of spatial frequency in the power spectral density of a line.
    pub slope: f64,
    /// The Hurst exponent, (−slope − 1)/2; absent where that is not between 0 and 1.
    pub hurst: Option<f64>,
    /// The shortest and the longest wavelength of the fit, m.
    pub wavelengths_m: [f64; 2],
}

/// The roughness of the lines of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct LineRoughness {
    pub along: LineDirection,
    /// How many lines were evaluated.
    pub lines: usize,
    /// How many lines of the map have points that were not measured, and are not evaluated.
    pub incomplete: usize,
    /// The parameters of profiles, mean and standard deviation over lines.
    pub parameters: Vec<LineParameter>,
    /// One of the lines, which says how all were evaluated.
    pub example: ProfileRoughness,
    /// Spatial frequency in 1/m and one-sided power spectral density in m³, mean over lines, in ten bins a decade.
    pub spectrum: Vec<(f64, f64)>,
    /// The widest range of wavelengths, a decade and more, in which the spectrum follows a power law; absent without one.
    pub law: Option<PowerLaw>,
    /// What a person should know before relying on it.
    pub warnings: Vec<Warning>,
}

/// The roughness of the lines of `map` in a direction: every line by itself as [`profile_roughness`] evaluates a profile, with one
/// cut-off for all; heights in m. Lines with points that were not measured are left out.
///
/// Formula: the cut-off of ISO 4288 is entered with the mean over lines. The spectrum is that of each line without its
/// least-squares line, under a Hann window. Its law is fitted to the logarithms of the bins, weighted by the inverse of their variance
/// 0.02² + 0.189/n, with n the frequencies in a bin times the width of the map in wavelengths.
///
/// Source: docs/decisions/roughness.md; of the Hurst exponent B. N. J. Persson et al., J. Phys. Condens. Matter 17, R1 (2005).
///
/// # Errors
/// [`RoughnessError::NoLine`] when no line is complete or a line has fewer than 8 points, and as [`profile_roughness`].
pub fn line_roughness(
    map: &HeightMap,
    along: LineDirection,
    wish: &RoughnessOptions,
) -> Result<LineRoughness, RoughnessError> {
    let (step_m, across_m, count) = match along {
        LineDirection::X => (map.step_x_m(), map.length_y_m(), map.rows()),
        LineDirection::Y => (map.step_y_m(), map.length_x_m(), map.columns()),
    };
    let complete =
        (0..count).filter_map(|at| HeightProfile::new(line(map, along, at), step_m).ok());
    let complete: Vec<HeightProfile> = complete.collect();
    let incomplete = count - complete.len();
    let every = complete.len().div_ceil(MOST_LINES).max(1);
    let lines: Vec<HeightProfile> = complete.into_iter().step_by(every).collect();
    let Some(first) = lines.first() else {
        return Err(RoughnessError::NoLine {
            along,
            points: map.heights_m().len() / count,
        });
    };
    let wanted = usual_config(first, wish);
    let (cutoff, is_settled) = common_cutoff(&lines, &wanted)?;
    let config = ProfileConfig {
        cutoff,
        ..wanted.clone()
    };
    let evaluated = lines.iter().map(|line| profile_roughness(line, &config));
    let mut evaluated = evaluated.collect::<Result<Vec<_>, _>>()?;
    let parameters = of_all(&evaluated);
    let spectrum = Spectrum::of(&lines);
    // The spectrum of rounding is none of the surface.
    let is_rough = evaluated.iter().any(|line| line.rq_m > ROUNDING_M);
    let law = is_rough
        .then(|| spectrum.law(across_m, lines.len()))
        .flatten();
    let mut example = evaluated.swap_remove(evaluated.len() / 2);
    example.config.cutoff = wanted.cutoff;
    example.cutoff_settled = is_settled;
    let mut warnings: Vec<Warning> = few_sections(example.sections, example.cutoff_m)
        .into_iter()
        .collect();
    if let (false, Cutoff::Stated(used_m)) = (is_settled, cutoff) {
        let ra_m = example.ra_m;
        warnings.push(SurfaceWarning::CutoffUnsettled { used_m, ra_m }.into());
    }
    Ok(LineRoughness {
        along,
        lines: lines.len(),
        incomplete,
        parameters,
        example,
        spectrum: spectrum
            .bins
            .iter()
            .map(|bin| (bin.frequency, bin.power))
            .collect(),
        law,
        warnings,
    })
}

/// The heights of a row or a column, m.
fn line(map: &HeightMap, along: LineDirection, at: usize) -> Vec<f64> {
    let (z, columns) = (map.heights_m(), map.columns());
    match along {
        LineDirection::X => z[at * columns..(at + 1) * columns].to_vec(),
        LineDirection::Y => z.iter().skip(at).step_by(columns).copied().collect(),
    }
}

/// Mean and standard deviation over lines; a parameter that a line lacks is left out of both.
fn of_all(evaluated: &[ProfileRoughness]) -> Vec<LineParameter> {
    let all: Vec<Vec<Parameter>> = (evaluated.iter())
        .map(|line| Roughness::Profile(Box::new(line.clone())).parameters())
        .collect();
    let of = |(at, parameter): (usize, &Parameter)| {
        let values: Vec<f64> = all.iter().filter_map(|of_line| of_line[at].value).collect();
        let has_any = !values.is_empty();
        LineParameter {
            mean: Parameter {
                value: has_any.then(|| mean(&values)),
                ..parameter.clone()
            },
            deviation: has_any.then(|| standard_deviation(&values)),
        }
    };
    all.first()
        .map_or_else(Vec::new, |first| first.iter().enumerate().map(of).collect())
}

/// Frequencies of one bin of the spectrum.
struct Bin {
    /// The geometric mean of its frequencies, 1/m.
    frequency: f64,
    /// The mean power spectral density, m³.
    power: f64,
    /// How many frequencies.
    count: usize,
}

struct Spectrum {
    bins: Vec<Bin>,
    step_m: f64,
    length_m: f64,
}

impl Spectrum {
    fn of(lines: &[HeightProfile]) -> Self {
        let (points, step_m) = (lines[0].heights_m().len(), lines[0].step_m());
        let window: Vec<f64> = (0..points)
            .map(|i| hann(i as f64 / points as f64))
            .collect();
        let squares: f64 = window.iter().map(|w| w * w).sum();
        let mut transform = RealTransform::new(points);
        let mut powers = vec![0.0; points.div_ceil(2)];
        for line in lines {
            let Ok(level) = super::remove_profile_form(line, super::Form::Level) else {
                continue;
            };
            let heights = level.heights_m().iter().zip(&window);
            let windowed: Vec<f64> = heights.map(|(z, w)| z * w).collect();
            for (sum, bin) in powers.iter_mut().zip(transform.forward(&windowed)) {
                *sum += bin.norm_sqr();
            }
        }
        let scale = 2.0 * step_m / squares / lines.len() as f64;
        let length_m = points as f64 * step_m;
        let mut bins: Vec<Bin> = Vec::new();
        let mut last = None;
        for (k, sum) in powers.iter().enumerate().skip(1) {
            let logarithm = (k as f64).log10();
            let number = (logarithm * BINS_PER_DECADE).round() as i64;
            let power = scale * sum;
            match bins.last_mut() {
                Some(bin) if last == Some(number) => {
                    bin.frequency += logarithm;
                    bin.power += power;
                    bin.count += 1;
                }
                _ => bins.push(Bin {
                    frequency: logarithm,
                    power,
                    count: 1,
                }),
            }
            last = Some(number);
        }
        for bin in &mut bins {
            let count = bin.count as f64;
            bin.frequency = 10f64.powf(bin.frequency / count) / length_m;
            bin.power /= count;
        }
        Self {
            bins,
            step_m,
            length_m,
        }
    }

    /// The widest law of `lines` of a map that is `across_m` wide: lines nearer than a wavelength say the same of it.
    fn law(&self, across_m: f64, lines: usize) -> Option<PowerLaw> {
        let (from, to) = (
            WAVES_PER_LINE / self.length_m,
            1.0 / (STEPS_PER_WAVE * self.step_m),
        );
        // Logarithms of frequency and power, and the weight of each bin.
        let points: Vec<[f64; 3]> = (self.bins.iter())
            .filter(|bin| bin.frequency >= from && bin.frequency <= to)
            .map(|bin| {
                let independent =
                    bin.count as f64 * (across_m * bin.frequency).clamp(1.0, lines as f64);
                let variance = SCATTER * SCATTER + 0.189 / independent;
                [bin.frequency.log10(), bin.power.log10(), 1.0 / variance]
            })
            .collect();
        if points.iter().any(|point| !point[1].is_finite()) {
            return None;
        }
        let mut widest: Option<(f64, PowerLaw)> = None;
        for first in 0..points.len() {
            for last in first + 1..points.len() {
                let decades = points[last][0] - points[first][0];
                if decades < FEWEST_DECADES || widest.as_ref().is_some_and(|(w, _)| decades <= *w) {
                    continue;
                }
                if let Some(slope) = straight(&points[first..=last]) {
                    let hurst = (-slope - 1.0) / 2.0;
                    let wave_m = |at: usize| 10f64.powf(-points[at][0]);
                    let law = PowerLaw {
                        slope,
                        hurst: (hurst > 0.0 && hurst < 1.0).then_some(hurst),
                        wavelengths_m: [wave_m(last), wave_m(first)],
                    };
                    widest = Some((decades, law));
                }
            }
        }
        widest.map(|(_, law)| law)
    }
}

/// The slope of points with weights, where they follow a line: none is further off than chance, nor are all together, nor do
/// both halves have slopes of their own.
fn straight(points: &[[f64; 3]]) -> Option<f64> {
    let (slope, at_zero, variance) = fitted(points);
    let off = |[x, y, weight]: &[f64; 3]| (y - at_zero - slope * x).powi(2) * weight;
    let squares: f64 = points.iter().map(off).sum();
    let degrees = points.len() as f64 - 2.0;
    let (left, right) = points.split_at(points.len() / 2);
    let ((left, _, left_variance), (right, _, right_variance)) = (fitted(left), fitted(right));
    let bend = (left - right).abs() / (left_variance + right_variance).sqrt();
    let is_straight = points
        .iter()
        .all(|point| off(point) <= MOST_DEVIATIONS * MOST_DEVIATIONS)
        && squares <= degrees + 2.0 * (2.0 * degrees).sqrt()
        && bend <= MOST_DEVIATIONS;
    (is_straight && variance.is_finite()).then_some(slope)
}

/// Slope, value at zero and variance of the slope of the weighted least-squares line.
fn fitted(points: &[[f64; 3]]) -> (f64, f64, f64) {
    let sum = |of: &dyn Fn(&[f64; 3]) -> f64| points.iter().map(of).sum::<f64>();
    let weights = sum(&|p| p[2]);
    let (x, y) = (
        sum(&|p| p[0] * p[2]) / weights,
        sum(&|p| p[1] * p[2]) / weights,
    );
    let squares = sum(&|p| (p[0] - x).powi(2) * p[2]);
    let slope = sum(&|p| (p[0] - x) * (p[1] - y) * p[2]) / squares;
    (slope, y - slope * x, 1.0 / squares)
}
