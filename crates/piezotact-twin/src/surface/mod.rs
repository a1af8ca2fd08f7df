//! The relief of the twin's samples: height maps, in m, as a topography instrument would measure them.
//!
//! Rough samples follow the self-affine spectrum that many worn and broken surfaces have (Persson et al. 2005);
//! dots and ridges follow their drawing. Lengths are in m throughout.

mod field;
mod pattern;
#[cfg(test)]
mod tests;

use crate::error::{TwinError, wrong};
use piezotact::surface::HeightMap;

use field::{Grid, SHORTEST_WAVE_M, SelfAffine, skew};
use pattern::{Dot, from_centre, ridge_m};

use piezotact_bench::random::Random;

/// The shortest step of a map, m (*chosen*: the sampling of a microscope; the relief has no finer detail).
const SHORTEST_STEP_M: f64 = 0.1e-6;
/// The fewest and the most steps along a side of a patch (*chosen*: 4096 × 4096 heights fill 134 MB).
const STEPS: (f64, f64) = (8.0, 4096.0);
/// The longest step, as a share of the wavelength or the correlation length.
const LONGEST_STEP_SHARE: f64 = 0.25;
/// The longer side of a rough patch has at least so many correlation lengths: a smaller one says little of
/// how rough a sample is (*chosen*).
const LEAST_LENGTHS: f64 = 4.0;

/// The most steps along a side of a usual patch (*chosen*).
const USUAL_STEPS: f64 = 1024.0;
/// Correlation lengths across a usual patch, and steps to one (*chosen*: about 10⁴ independent heights).
const USUAL_LENGTHS: f64 = 32.0;
const STEPS_PER_LENGTH: f64 = 32.0;
/// Wavelengths across a usual patch, steps to a wavelength, and steps across a dot (*chosen*).
const USUAL_WAVES: f64 = 12.0;
const STEPS_PER_WAVE: f64 = 64.0;
const STEPS_PER_DOT: f64 = 32.0;
/// The height of a usual patch of dots in pairs of rows, each √3 wavelengths: whole cells each way.
const USUAL_ROW_PAIRS: f64 = 7.0;

/// The correlation length of plain resin, m (*chosen*: as the thesis' plain plate, whose relief is the resin's
/// crystalline structure).
const RESIN_CORRELATION_M: f64 = 20e-6;
/// The correlation length of a printed plate's roughness, m (*chosen*: the usual height of a printed layer).
const LAYER_CORRELATION_M: f64 = 100e-6;
/// The Hurst exponent of the roughness on dots and ridges (*chosen*: the middle of 0.7–0.9).
const ROUGHNESS_HURST: f64 = 0.8;
/// The roughness of a pattern is finer than its wavelength by this, and no finer than so many steps (*chosen*).
const LENGTHS_PER_WAVE: f64 = 4.0;
const STEPS_PER_ROUGHNESS: f64 = 4.0;

/// The relief of a sample, lengths in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Relief {
    /// Randomly rough and self-affine, the same in all directions: sandpaper cast in silicone, then in resin.
    Isotropic {
        /// The mean absolute height Ra of a profile, m (*thesis*, Table 3).
        ra_m: f64,
        /// The mean grain of the sandpaper, m (FEPA 43-1).
        grain_m: f64,
        /// The roll-off wavelength Lc in grains; 1 to 2 for sandpaper.
        correlation_per_grain: f64,
        /// The Hurst exponent H, from 0 (jagged) to 1 (smooth); 0.7 to 0.9 for sandpaper.
        hurst: f64,
        /// The skewness of the heights, −3 to 3; above zero for peaks on a plain.
        skewness: f64,
    },
    /// Cylindrical dots in a hexagonal pattern on a plain of height 0, rows along x.
    Dots {
        /// The height of a dot, m.
        height_m: f64,
        /// The diameter of a dot at half its height, m.
        diameter_m: f64,
        /// The distance between the centres of neighbours, m: diameter and gap (*thesis*, Table 2).
        wavelength_m: f64,
        /// The radius of a dot's edge and of its foot, m; about 2 µm, 0 for none.
        edge_m: f64,
        /// The rms roughness of the resin on and between the dots, m; 0 for none.
        roughness_m: f64,
    },
    /// Parallel ridges of rounded (cosine) profile along y about height 0: a printed biomimetic plate.
    Ridges {
        /// The distance between ridges, m.
        wavelength_m: f64,
        /// The height from groove to ridge, m.
        depth_m: f64,
        /// The rms roughness that layers of print leave, m; 0 for none.
        roughness_m: f64,
    },
}

/// The patch of a sample that is mapped, lengths in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// The side along x, m.
    pub width_m: f64,
    /// The side along y, m.
    pub height_m: f64,
    /// The step between heights, both ways, m.
    pub step_m: f64,
}

impl Relief {
    /// A patch that is enough for statistics, sides and step in m: 32 correlation lengths or 12 wavelengths
    /// across, at most 1024 × 1024 heights, no step below 0.1 µm. Of a relief that
    /// [`height_map`](Self::height_map) refuses it means nothing.
    #[must_use]
    pub fn usual_patch(&self) -> Patch {
        let finest_m = match *self {
            Self::Isotropic { .. } => self.scale_m() / STEPS_PER_LENGTH,
            Self::Dots { diameter_m, .. } => {
                (self.scale_m() / STEPS_PER_WAVE).min(diameter_m / STEPS_PER_DOT)
            }
            Self::Ridges { .. } => self.scale_m() / STEPS_PER_WAVE,
        };
        let (width, height) = match self {
            Self::Isotropic { .. } => (USUAL_LENGTHS, USUAL_LENGTHS),
            Self::Dots { .. } => (USUAL_WAVES, USUAL_ROW_PAIRS * 3f64.sqrt()),
            Self::Ridges { .. } => (USUAL_WAVES, USUAL_WAVES),
        };
        let (width_m, height_m) = (width * self.scale_m(), height * self.scale_m());
        let step_m = finest_m
            .max(width_m.max(height_m) / USUAL_STEPS)
            .max(SHORTEST_STEP_M);
        Patch {
            width_m,
            height_m,
            // whole steps across
            step_m: width_m / (width_m / step_m * (1.0 + 1e-12)).floor(),
        }
    }

    /// The heights of `sample` on `patch`, in m, row by row along x; the same for the same seed.
    ///
    /// *Isotropic*: a Gaussian field with the two-dimensional PSD C(q) ∝ (1 + (q/q0)²)^−(1+H), q0 = 2π/Lc, cut
    /// at waves of 2 µm or two steps, made larger than the patch so that it has no period, skewed as asked
    /// (shifted lognormal), about mean 0. The mean absolute height Sa of the map is set to `ra_m`: the thesis
    /// states Ra of profiles only, and on an isotropic surface the mean of |z| along lines, in any direction,
    /// is that over the area, about the same mean height. A profile whose long waves are filtered away, as
    /// ISO 21920-3 has it, shows a little less.
    ///
    /// *Dots*: heights above the plain; each one is the mean over a step, so that walls do not fall between
    /// points. *Ridges*: heights about their middle. The pattern lies on the patch as chance wants it, its
    /// roughness is a field like the above with a correlation length of 20 µm (resin) or 0.1 mm (print), at
    /// most a quarter of the wavelength and at least four steps.
    ///
    /// Source: Palasantzas 1993, Phys. Rev. B 48 14472 (the spectrum with its roll-off); Persson et al. 2005,
    /// J. Phys.: Condens. Matter 17 R1 (self-affine surfaces, and making them by FFT).
    ///
    /// # Errors
    /// [`TwinError`] names what does not fit: a number of the relief that is out of its range, a step
    /// below 0.1 µm or above a quarter of the wavelength or of Lc, a side of less than 8 or more than 4096
    /// steps, or a rough patch whose longer side has less than four correlation lengths.
    pub fn height_map(
        &self,
        patch: &Patch,
        seed: u64,
        sample: &str,
    ) -> Result<HeightMap, TwinError> {
        self.check()?;
        let grid = self.grid(patch)?;
        let mut random = Random::stream(seed, 0, &format!("surface {sample}"));
        let heights_m = match *self {
            Self::Isotropic {
                ra_m,
                hurst,
                skewness,
                ..
            } => {
                let correlation_m = self.scale_m();
                let field = SelfAffine {
                    correlation_m,
                    hurst,
                };
                let mut heights = field.heights(grid, &mut random);
                skew(&mut heights, skewness);
                let absolute: f64 = heights.iter().map(|z| z.abs()).sum();
                let level_m = ra_m * heights.len() as f64 / absolute;
                scale(&mut heights, level_m);
                heights
            }
            Self::Dots {
                height_m,
                diameter_m,
                wavelength_m,
                edge_m,
                roughness_m,
            } => {
                let dot = Dot { height_m, edge_m };
                let (along, up) = (random.uniform(), random.uniform());
                let mut heights_m =
                    rough(grid, RESIN_CORRELATION_M, self, roughness_m, &mut random);
                add(&mut heights_m, grid, wavelength_m, |x, y| {
                    // anywhere in a pair of rows: the pattern's period
                    let from_centre = from_centre(x + along, y + 3f64.sqrt() * up);
                    let from_wall_m = from_centre * wavelength_m - 0.5 * diameter_m;
                    dot.mean_height_m(from_wall_m, grid.step_m)
                });
                heights_m
            }
            Self::Ridges {
                wavelength_m,
                depth_m,
                roughness_m,
            } => {
                let along = random.uniform();
                let mut heights_m =
                    rough(grid, LAYER_CORRELATION_M, self, roughness_m, &mut random);
                add(&mut heights_m, grid, wavelength_m, |x, _| {
                    ridge_m(x + along, depth_m)
                });
                heights_m
            }
        };
        let map = HeightMap::new(heights_m, grid.columns, grid.step_m, grid.step_m)?;
        Ok(map)
    }

    /// The length that a patch and its step must suit, m: the correlation length or the wavelength.
    fn scale_m(&self) -> f64 {
        match *self {
            Self::Isotropic {
                grain_m,
                correlation_per_grain,
                ..
            } => grain_m * correlation_per_grain,
            Self::Dots { wavelength_m, .. } | Self::Ridges { wavelength_m, .. } => wavelength_m,
        }
    }

    fn check(&self) -> Result<(), TwinError> {
        match *self {
            Self::Isotropic {
                ra_m,
                grain_m,
                correlation_per_grain,
                hurst,
                skewness,
            } => {
                above_zero("a roughness Ra", ra_m)?;
                above_zero("a grain", grain_m)?;
                if !(correlation_per_grain > 0.0 && correlation_per_grain.is_finite()) {
                    return Err(wrong(
                        "a correlation length in grains",
                        "above zero and finite",
                        correlation_per_grain,
                        "state 1 to 2 for sandpaper",
                    ));
                }
                if !(0.0..=1.0).contains(&hurst) {
                    return Err(wrong(
                        "a Hurst exponent",
                        "0 to 1",
                        hurst,
                        "state 0.7 to 0.9 for sandpaper",
                    ));
                }
                if !(-3.0..=3.0).contains(&skewness) {
                    return Err(wrong(
                        "a skewness",
                        "-3 to 3",
                        skewness,
                        "state 0 for a symmetric distribution of heights",
                    ));
                }
                let (least_m, found_m) = (2.0 * SHORTEST_WAVE_M, self.scale_m());
                if found_m < least_m {
                    return Err(TwinError::Correlation { least_m, found_m });
                }
                above_zero("a correlation length", found_m)
            }
            Self::Dots {
                height_m,
                diameter_m,
                wavelength_m,
                edge_m,
                roughness_m,
            } => {
                above_zero("a dot's height", height_m)?;
                above_zero("a dot's diameter", diameter_m)?;
                above_zero("a wavelength", wavelength_m)?;
                if diameter_m >= wavelength_m {
                    return Err(TwinError::Touching {
                        diameter_m,
                        wavelength_m,
                    });
                }
                not_negative("an edge radius", edge_m)?;
                let most_m = 0.5 * diameter_m.min(wavelength_m - diameter_m);
                if edge_m > most_m {
                    return Err(TwinError::Edge {
                        most_m,
                        found_m: edge_m,
                    });
                }
                not_negative("a roughness", roughness_m)
            }
            Self::Ridges {
                wavelength_m,
                depth_m,
                roughness_m,
            } => {
                above_zero("a wavelength", wavelength_m)?;
                above_zero("a depth", depth_m)?;
                not_negative("a roughness", roughness_m)
            }
        }
    }

    /// The points of `patch`, where it suits the relief.
    fn grid(&self, patch: &Patch) -> Result<Grid, TwinError> {
        let Patch {
            width_m,
            height_m,
            step_m,
        } = *patch;
        above_zero("a step", step_m)?;
        above_zero("a patch's width", width_m)?;
        above_zero("a patch's height", height_m)?;
        let of = match self {
            Self::Isotropic { .. } => "the correlation length",
            Self::Dots { .. } | Self::Ridges { .. } => "the wavelength",
        };
        let most_m = LONGEST_STEP_SHARE * self.scale_m();
        if !(SHORTEST_STEP_M..=most_m).contains(&step_m) {
            return Err(TwinError::Step {
                of,
                least_m: SHORTEST_STEP_M,
                most_m,
                found_m: step_m,
            });
        }
        let columns = steps("a width", width_m, step_m)?;
        let rows = steps("a height", height_m, step_m)?;
        let longer_m = width_m.max(height_m);
        let least_m = LEAST_LENGTHS * self.scale_m();
        if matches!(self, Self::Isotropic { .. }) && longer_m < least_m {
            return Err(TwinError::Small {
                least_m,
                found_m: longer_m,
            });
        }
        Ok(Grid {
            columns,
            rows,
            step_m,
        })
    }
}

/// Random roughness of `rms_m` on a pattern, with a correlation length of `correlation_m` where it fits the
/// pattern and the step.
fn rough(
    grid: Grid,
    correlation_m: f64,
    pattern: &Relief,
    rms_m: f64,
    random: &mut Random,
) -> Vec<f64> {
    let correlation_m = correlation_m
        .min(pattern.scale_m() / LENGTHS_PER_WAVE)
        .max(STEPS_PER_ROUGHNESS * grid.step_m);
    let field = SelfAffine {
        correlation_m,
        hurst: ROUGHNESS_HURST,
    };
    let mut heights = field.heights(grid, random);
    scale(&mut heights, rms_m);
    heights
}

fn scale(heights: &mut [f64], by: f64) {
    for z in heights {
        *z *= by;
    }
}

/// Adds the height, m, that `pattern` has at each point, given in wavelengths.
fn add(heights_m: &mut [f64], grid: Grid, wavelength_m: f64, pattern: impl Fn(f64, f64) -> f64) {
    let at = |i: usize| i as f64 * grid.step_m / wavelength_m;
    for (row, line) in heights_m.chunks_exact_mut(grid.columns).enumerate() {
        for (column, z) in line.iter_mut().enumerate() {
            *z += pattern(at(column), at(row));
        }
    }
}

/// The number of steps along a side.
fn steps(what: &'static str, side_m: f64, step_m: f64) -> Result<usize, TwinError> {
    let steps = (side_m / step_m).round();
    if (STEPS.0..=STEPS.1).contains(&steps) {
        Ok(steps as usize)
    } else {
        Err(TwinError::Side {
            what,
            step_m,
            found_m: side_m,
        })
    }
}

fn above_zero(what: &'static str, found_m: f64) -> Result<(), TwinError> {
    if found_m > 0.0 && found_m.is_finite() {
        Ok(())
    } else {
        Err(wrong(
            what,
            "above zero and finite",
            format!("{found_m} m"),
            "state it in m",
        ))
    }
}

fn not_negative(what: &'static str, found_m: f64) -> Result<(), TwinError> {
    if found_m >= 0.0 && found_m.is_finite() {
        Ok(())
    } else {
        Err(wrong(
            what,
            "zero or more and finite",
            format!("{found_m} m"),
            "state 0 for none",
        ))
    }
}
