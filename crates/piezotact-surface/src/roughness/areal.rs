//! Roughness parameters of a height map.

use crate::roughness::{HeightsFault, SurfaceWarning};
use serde::{Deserialize, Serialize};

use super::autocorrelation::{CentralLobe, Correlogram, LEVEL};
use super::plausible;
use super::section::Amplitudes;
use super::texture::texture;
use super::{
    Extent as _, Form, HeightMap, RoughnessError, STEPS_PER_CUTOFF, Texture, map_mean_surface,
    mean, remove_map_form,
};
use piezotact::warning::Warning;

/// How a map is evaluated. There is no default: it is stated, and goes into the result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ArealConfig {
    /// The form that is taken away first.
    pub form: Form,
    /// The nesting index of the S-filter, which takes short waves away, in m.
    pub s_nesting_m: Option<f64>,
    /// The nesting index of the L-filter, which takes long waves away, in m.
    pub l_nesting_m: Option<f64>,
}

/// The roughness of a map: heights and lengths in m, slopes and moments dimensionless.
#[derive(Clone, Debug, PartialEq)]
pub struct ArealRoughness {
    /// Mean absolute height Sa, m.
    pub sa_m: f64,
    /// Root-mean-square height Sq, m.
    pub sq_m: f64,
    /// Height from the lowest pit to the highest peak Sz, m.
    pub sz_m: f64,
    /// Highest peak Sp, m.
    pub sp_m: f64,
    /// Deepest pit Sv, above zero, m.
    pub sv_m: f64,
    /// Skewness Ssk; absent for a flat map.
    pub ssk: Option<f64>,
    /// Kurtosis Sku, 3 for Gaussian heights; absent for a flat map.
    pub sku: Option<f64>,
    /// Root-mean-square gradient Sdq; absent when no four measured points make a square.
    pub sdq: Option<f64>,
    /// Developed area beyond the projected one Sdr, as a share of it; absent as Sdq is.
    pub sdr: Option<f64>,
    /// Autocorrelation length Sal, m: how near the autocorrelation falls to 0.2. Absent where it does not.
    pub sal_m: Option<f64>,
    /// Texture aspect ratio Str, 0–1: 1 where all directions are alike, towards 0 for ridges. Absent when
    /// the autocorrelation does not fall to 0.2 in every direction within half the map.
    pub str_ratio: Option<f64>,
    /// Whether the surface repeats itself, and how; absent for a flat map.
    pub texture: Option<Texture>,
    /// The surface that was evaluated, after form and filters.
    pub surface: HeightMap,
    /// How it was evaluated.
    pub config: ArealConfig,
    /// What a person should know before relying on it.
    pub warnings: Vec<Warning>,
}

/// The areal roughness parameters of `map`, over all measured points, heights in m.
///
/// Formula: with z about its mean, Sa = mean |z|, Sq = √mean z², Ssk = mean z³/Sq³, Sku = mean z⁴/Sq⁴,
/// Sz = Sp + Sv, Sdq = √mean (p² + q²), Sdr = mean √(1 + p² + q²) − 1 with p and q the differences between
/// neighbours in x and y over the step, in squares of four that are all measured; Sal and Str are the nearest
/// distance, and its ratio to the farthest, of the 0.2 contour round the centre of the autocorrelation.
///
/// Source: ISO 25178-2:2021 (Sdr: D.3), and ISO 16610-61:2015 for the filters.
///
/// # Errors
/// [`RoughnessError::Cutoff`] when the L-filter is shorter than five steps or longer than the map,
/// [`RoughnessError::ShortWaves`] when the S-filter is not between 0 and the L-filter,
/// [`RoughnessError::Degree`] when the form cannot be fitted, [`RoughnessError::Huge`] when the heights are beyond
/// any surface.
///
/// ```
/// use piezotact::surface::*;
/// use piezotact_surface::*;
/// let wave = |i: i32| (f64::from(i) / 50.0 * std::f64::consts::TAU).sin();
/// let heights = (0..40_000).map(|i| 1e-6 * wave(i % 200) * wave(i / 200)).collect();
/// let map = HeightMap::new(heights, 200, 1e-6, 1e-6).unwrap();
/// let config = ArealConfig { form: Form::Mean, s_nesting_m: None, l_nesting_m: None };
/// let roughness = areal_roughness(&map, &config).unwrap();
/// assert!((roughness.sq_m - 0.5e-6).abs() < 1e-12); // two sines: 1 µm / √2 / √2
/// assert!(roughness.str_ratio.unwrap() > 0.7);
/// ```
pub fn areal_roughness(
    map: &HeightMap,
    config: &ArealConfig,
) -> Result<ArealRoughness, RoughnessError> {
    check_filters(map, config)?;
    let surface = centred(&scale_limited(remove_map_form(map, config.form)?, config)?);
    let measured = surface.heights_m().iter().copied().filter(|z| !z.is_nan());
    let heights = Amplitudes::of(measured);
    let slopes = slopes(&surface);
    let correlogram = (heights.rms_m > 0.0).then(|| Correlogram::of(&surface));
    let lobe = correlogram.as_ref().map(Correlogram::lobe);
    let mut warnings = Vec::new();
    if map.missing_share() > 0.0 {
        warnings.push(Warning::from(SurfaceWarning::Heights {
            fault: HeightsFault::Missing {
                share: map.missing_share(),
            },
        }));
    }
    if let Some(CentralLobe::Open { reached_m, .. }) = lobe {
        warnings.push(Warning::from(SurfaceWarning::LongCorrelation {
            level: LEVEL,
            reached_m,
        }));
    }
    warnings.extend(slopes.and_then(|(gradient, _)| plausible::of_slope(gradient)));
    warnings.extend(plausible::of_map(map));
    Ok(ArealRoughness {
        sa_m: heights.mean_absolute_m,
        sq_m: heights.rms_m,
        sz_m: heights.range_m(),
        sp_m: heights.peak_m,
        sv_m: heights.valley_m,
        ssk: heights.skewness,
        sku: heights.kurtosis,
        sdq: slopes.map(|(gradient, _)| gradient),
        sdr: slopes.map(|(_, area)| area),
        sal_m: lobe.and_then(|lobe| lobe.nearest_m()),
        str_ratio: lobe.and_then(|lobe| lobe.aspect_ratio()),
        texture: correlogram.map(|correlogram| texture(&surface, &correlogram)),
        surface,
        config: config.clone(),
        warnings,
    })
}

fn check_filters(map: &HeightMap, config: &ArealConfig) -> Result<(), RoughnessError> {
    let (step_m, side_m) = (map.shorter_step_m(), map.longer_side_m());
    if let Some(l_m) = config.l_nesting_m
        && !(STEPS_PER_CUTOFF * step_m..=side_m).contains(&l_m)
    {
        return Err(RoughnessError::cutoff(l_m, step_m, side_m));
    }
    let below_m = config.l_nesting_m.unwrap_or(side_m);
    match config.s_nesting_m {
        Some(found_m) if !(found_m > 0.0 && found_m < below_m) => {
            Err(RoughnessError::ShortWaves { found_m })
        }
        _ => Ok(()),
    }
}

/// The surface between the S-filter and the L-filter.
fn scale_limited(map: HeightMap, config: &ArealConfig) -> Result<HeightMap, RoughnessError> {
    let smooth = match config.s_nesting_m {
        Some(s_m) => map_mean_surface(&map, s_m)?,
        None => map,
    };
    let Some(l_m) = config.l_nesting_m else {
        return Ok(smooth);
    };
    let long = map_mean_surface(&smooth, l_m)?;
    let heights = smooth.heights_m().iter().zip(long.heights_m());
    Ok(smooth.with_heights(heights.map(|(z, mean)| z - mean).collect()))
}

fn centred(map: &HeightMap) -> HeightMap {
    let measured = map.heights_m().iter().copied().filter(|z| !z.is_nan());
    let mean_m = mean(measured);
    map.with_heights(map.heights_m().iter().map(|z| z - mean_m).collect())
}

/// Sdq and Sdr over the squares of four measured neighbours: each corner with the differences along its two
/// sides stands for one triangle, so that Sdr is that of the mean of the two triangulations.
fn slopes(map: &HeightMap) -> Option<(f64, f64)> {
    let (z, columns) = (map.heights_m(), map.columns());
    let (mut squared, mut area, mut corners) = (0.0, 0.0, 0usize);
    for row in 0..map.rows() - 1 {
        for i in row * columns..(row + 1) * columns - 1 {
            let square = [z[i], z[i + 1], z[i + columns], z[i + columns + 1]];
            if square.iter().any(|z| z.is_nan()) {
                continue;
            }
            let along_x = [square[1] - square[0], square[3] - square[2]];
            let along_y = [square[2] - square[0], square[3] - square[1]];
            for x in along_x.map(|d| d / map.step_x_m()) {
                for y in along_y.map(|d| d / map.step_y_m()) {
                    let steepness = x * x + y * y;
                    squared += steepness;
                    // √(1 + s) − 1 without the loss of digits where s is small
                    area += steepness / ((1.0 + steepness).sqrt() + 1.0);
                    corners += 1;
                }
            }
        }
    }
    let count = corners as f64;
    (corners > 0).then(|| ((squared / count).sqrt(), area / count))
}
