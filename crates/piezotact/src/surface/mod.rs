//! Surfaces: what a topography instrument measured, and what it says of roughness.
//!
//! Heights and steps are in m. A point that the instrument could not measure is NaN in a height map and
//! nothing else is; a profile has no such points.
//!
//! A measured profile goes through [`profile_roughness`], a map through [`areal_roughness`]; the steps
//! between (form, Gaussian filter) can be taken one by one.

mod areal;
mod autocorrelation;
mod cutoff;
mod description;
mod distribution;
mod document;
mod doubt;
mod duplex;
mod filter;
mod filtered;
mod form;
mod instrument;
mod material;
mod parameters;
mod plausible;
mod profile;
mod section;
mod set;

pub use areal::{ArealConfig, ArealRoughness, areal_roughness};
pub use cutoff::{Cutoff, ShortWaves};
pub use description::{length_text, short_number, unit_for};
pub use distribution::{
    HeightDistribution, distribution_of, height_distribution, height_limits_m, height_span_m,
};
pub use document::{
    EvaluatedSurface, InstrumentDocument, RoughnessDocument, RoughnessExtent, RoughnessMethod,
};
pub use doubt::SurfaceDoubt;
pub use duplex::{Duplex, PeriodBasis, TextureClass, mean_particle_m};
pub use filter::{map_mean_surface, profile_mean_line};
pub use filtered::looks_filtered;
pub use form::{Form, remove_map_form, remove_profile_form};
pub use instrument::{
    InstrumentSettings, InstrumentValue, MeasuredProfile, ProfileKind, ProfileWish,
    evaluated_profile,
};
pub use material::{MaterialRatio, material_ratio};
pub use parameters::Parameter;
pub use profile::{
    Ends, ProfileConfig, ProfileFilter, ProfileRoughness, ProfileStandard, profile_roughness,
};
pub use set::{RoughnessSet, RoughnessSetDocument};

mod samples;

use crate::number::rounded;
use serde::{Deserialize, Serialize};

pub use samples::{Judgement, SampleSet, SurfaceSample};

/// The roughness of a profile or of a height map.
#[derive(Clone, Debug, PartialEq)]
pub enum Roughness {
    /// Of a profile.
    Profile(Box<ProfileRoughness>),
    /// Of a height map.
    Map(Box<ArealRoughness>),
}

impl Roughness {
    /// What limits it.
    #[must_use]
    pub fn doubts(&self) -> &[crate::Doubt] {
        match self {
            Self::Profile(roughness) => &roughness.doubts,
            Self::Map(roughness) => &roughness.doubts,
        }
    }
}

/// Heights on a regular grid: `rows` × `columns` values, row by row, in m. NaN where nothing was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightMap {
    heights_m: Vec<f64>,
    rows: usize,
    columns: usize,
    step_x_m: f64,
    step_y_m: f64,
}

impl HeightMap {
    /// A map of `heights_m`, row by row, `columns` to a row, `step_x_m` between columns and `step_y_m`
    /// between rows.
    ///
    /// # Errors
    /// [`SurfaceError::Shape`] unless there are at least 2 × 2 heights that fill whole rows,
    /// [`SurfaceError::Step`] when a step is not above zero and finite, [`SurfaceError::NotFinite`] when a
    /// height is infinite, [`SurfaceError::NothingMeasured`] when fewer than four points were measured.
    pub fn new(
        heights_m: Vec<f64>,
        columns: usize,
        step_x_m: f64,
        step_y_m: f64,
    ) -> Result<Self, SurfaceError> {
        let rows = heights_m.len().checked_div(columns).unwrap_or(0);
        if rows < 2 || columns < 2 || rows * columns != heights_m.len() {
            return Err(SurfaceError::Shape {
                heights: heights_m.len(),
                columns,
            });
        }
        for step_m in [step_x_m, step_y_m] {
            valid_step(step_m)?;
        }
        if let Some(at) = heights_m.iter().position(|z| z.is_infinite()) {
            return Err(SurfaceError::NotFinite {
                at,
                found: heights_m[at],
            });
        }
        if heights_m.iter().filter(|z| !z.is_nan()).count() < 4 {
            return Err(SurfaceError::NothingMeasured);
        }
        Ok(Self {
            heights_m,
            rows,
            columns,
            step_x_m,
            step_y_m,
        })
    }

    /// The heights in m, row by row; NaN where nothing was measured.
    #[must_use]
    pub fn heights_m(&self) -> &[f64] {
        &self.heights_m
    }

    /// The number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The number of columns.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// The step between columns in m.
    #[must_use]
    pub fn step_x_m(&self) -> f64 {
        self.step_x_m
    }

    /// The step between rows in m.
    #[must_use]
    pub fn step_y_m(&self) -> f64 {
        self.step_y_m
    }

    /// The share of points that were not measured, 0–1.
    #[must_use]
    pub fn missing_share(&self) -> f64 {
        let missing = self.heights_m.iter().filter(|z| z.is_nan()).count();
        missing as f64 / self.heights_m.len() as f64
    }

    /// The steps along a row and between rows, m.
    fn steps_m(&self) -> (f64, f64) {
        (self.step_x_m, self.step_y_m)
    }

    fn shorter_step_m(&self) -> f64 {
        self.step_x_m.min(self.step_y_m)
    }

    /// The side along x in m: the number of columns times their step.
    #[must_use]
    pub fn length_x_m(&self) -> f64 {
        self.columns as f64 * self.step_x_m
    }

    /// The side along y in m: the number of rows times their step.
    #[must_use]
    pub fn length_y_m(&self) -> f64 {
        self.rows as f64 * self.step_y_m
    }

    fn longer_side_m(&self) -> f64 {
        self.length_x_m().max(self.length_y_m())
    }

    /// The same area in at most `most` rows and `most` columns, to look at: each height is the mean of the
    /// measured points that it stands for, in m, NaN where none was measured.
    #[must_use]
    pub fn coarser(&self, most: usize) -> Self {
        let (rows, columns) = (self.rows.min(most.max(2)), self.columns.min(most.max(2)));
        let mut heights_m = Vec::with_capacity(rows * columns);
        for row in 0..rows {
            let of_row = row * self.rows / rows..(row + 1) * self.rows / rows;
            for column in 0..columns {
                let of_column =
                    column * self.columns / columns..(column + 1) * self.columns / columns;
                let block = of_row.clone().flat_map(|r| {
                    &self.heights_m[r * self.columns..][of_column.start..of_column.end]
                });
                let measured: Vec<f64> = block.copied().filter(|z| !z.is_nan()).collect();
                heights_m.push(if measured.is_empty() {
                    f64::NAN
                } else {
                    mean(measured.into_iter())
                });
            }
        }
        Self {
            heights_m,
            rows,
            columns,
            step_x_m: self.length_x_m() / columns as f64,
            step_y_m: self.length_y_m() / rows as f64,
        }
    }

    /// The same grid with other heights.
    fn with_heights(&self, heights_m: Vec<f64>) -> Self {
        debug_assert_eq!(heights_m.len(), self.heights_m.len());
        Self { heights_m, ..*self }
    }
}

/// Heights along a line at even steps, in m.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightProfile {
    heights_m: Vec<f64>,
    step_m: f64,
}

impl HeightProfile {
    /// A profile of `heights_m`, `step_m` apart.
    ///
    /// # Errors
    /// [`SurfaceError::Shape`] when there are fewer than 8 heights, [`SurfaceError::Step`] when the step is not
    /// above zero and finite, [`SurfaceError::NotFinite`] when a height is NaN or infinite.
    pub fn new(heights_m: Vec<f64>, step_m: f64) -> Result<Self, SurfaceError> {
        if heights_m.len() < 8 {
            return Err(SurfaceError::Shape {
                heights: heights_m.len(),
                columns: 1,
            });
        }
        valid_step(step_m)?;
        if let Some(at) = heights_m.iter().position(|z| !z.is_finite()) {
            return Err(SurfaceError::NotFinite {
                at,
                found: heights_m[at],
            });
        }
        Ok(Self { heights_m, step_m })
    }

    /// The heights in m.
    #[must_use]
    pub fn heights_m(&self) -> &[f64] {
        &self.heights_m
    }

    /// The step between heights in m.
    #[must_use]
    pub fn step_m(&self) -> f64 {
        self.step_m
    }

    /// The length in m: the number of heights times the step.
    #[must_use]
    pub fn length_m(&self) -> f64 {
        self.heights_m.len() as f64 * self.step_m
    }

    /// The same line with other heights.
    fn with_heights(&self, heights_m: Vec<f64>) -> Self {
        debug_assert_eq!(heights_m.len(), self.heights_m.len());
        Self { heights_m, ..*self }
    }
}

/// What a topography instrument measured.
#[derive(Clone, Debug, PartialEq)]
pub enum Topography {
    /// Heights on a grid.
    Map(HeightMap),
    /// Heights along a line.
    Profile(HeightProfile),
}

fn valid_step(step_m: f64) -> Result<(), SurfaceError> {
    if step_m > 0.0 && step_m.is_finite() {
        Ok(())
    } else {
        Err(SurfaceError::Step { found_m: step_m })
    }
}

/// A filter with a cut-off of fewer steps sees no waves.
const STEPS_PER_CUTOFF: f64 = 5.0;

/// The mean; 0 of nothing.
fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0usize), |(sum, count), v| (sum + v, count + 1));
    sum / count.max(1) as f64
}

/// Heights and slopes beyond this have lost their unit, and their fourth powers would overflow.
const LARGEST: f64 = 1e60;

/// Checks that the parameters of `heights_m` at steps of `step_m` are finite.
fn computable(heights_m: &[f64], step_m: f64) -> Result<(), SurfaceError> {
    let largest_m = heights_m.iter().fold(0.0f64, |most, z| most.max(z.abs()));
    if largest_m <= LARGEST && largest_m / step_m <= LARGEST {
        Ok(())
    } else {
        Err(SurfaceError::Huge { largest_m, step_m })
    }
}

/// A length in mm, as a person reads it: to the nm.
fn mm(length_m: f64) -> f64 {
    let nm = length_m * 1e9;
    if nm.abs() < 1.0 {
        nm * 1e-6
    } else {
        nm.round() / 1e6
    }
}

/// Heights that make no surface, or a surface that lacks what is asked of it.
#[derive(Clone, Debug, PartialEq, thiserror::Error, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub enum SurfaceError {
    /// Too few heights, or rows that are not full.
    #[error(
        "expected a profile of 8 heights or a map of 2 × 2 and more in full rows, found {heights} heights in {columns} columns; check the export"
    )]
    Shape {
        /// The number of heights.
        heights: usize,
        /// The number of columns.
        columns: usize,
    },
    /// A step that cannot be.
    #[error(
        "expected a step between heights above zero, found {found_m} m; state it",
        found_m = rounded(*found_m)
    )]
    Step {
        /// What was found, m.
        found_m: f64,
    },
    /// A height that is no number.
    #[error(
        "expected finite heights, found {found} at point {at}; export points that were not measured as missing"
    )]
    NotFinite {
        /// Its index.
        at: usize,
        /// What stands there.
        found: f64,
    },
    /// A map with next to no points.
    #[error("expected measured heights, found fewer than four; measure again")]
    NothingMeasured,
    /// Heights whose powers or slopes are beyond any number.
    #[error(
        "expected heights and slopes of a surface, found heights up to {largest_m:e} m at steps of {step_m:e} m; check the units"
    )]
    Huge {
        /// The largest height, m.
        largest_m: f64,
        /// The step, m.
        step_m: f64,
    },
    /// A polynomial that is no form.
    #[error(
        "expected a polynomial of degree 1 to {most} with fewer terms than points, found degree {degree} for {points} points; \
            use a lower degree"
    )]
    Degree {
        /// The degree asked for.
        degree: usize,
        /// The highest degree.
        most: usize,
        /// The number of measured points.
        points: usize,
    },
    /// A filter that does not fit the surface.
    #[error(
        "expected a cut-off from {} mm (5 steps) to {} mm (the length measured), found {} mm; state another, or measure a longer or finer line",
        mm(*shortest_m), mm(*longest_m), mm(*found_m)
    )]
    Cutoff {
        /// Five steps, m.
        shortest_m: f64,
        /// The length, m.
        longest_m: f64,
        /// The cut-off, m.
        found_m: f64,
    },
    /// A filter for short waves that takes nothing away, or everything.
    #[error(
        "expected a filter for short waves above zero and below the cut-off, found {} mm; state a shorter one or none",
        mm(*found_m)
    )]
    ShortWaves {
        /// What was found, m.
        found_m: f64,
    },
}

impl SurfaceError {
    fn cutoff(found_m: f64, step_m: f64, longest_m: f64) -> Self {
        Self::Cutoff {
            shortest_m: STEPS_PER_CUTOFF * step_m,
            longest_m,
            found_m,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_and_profiles_are_whole_or_are_not() {
        assert!(HeightMap::new(vec![0.0; 12], 4, 1e-6, 1e-6).is_ok());
        assert!(HeightMap::new(vec![0.0; 13], 4, 1e-6, 1e-6).is_err());
        assert!(HeightMap::new(vec![0.0; 12], 0, 1e-6, 1e-6).is_err());
        assert!(HeightMap::new(vec![0.0; 12], 4, 0.0, 1e-6).is_err());
        assert!(HeightMap::new(vec![f64::NAN; 12], 4, 1e-6, 1e-6).is_err());
        assert!(HeightProfile::new(vec![0.0; 7], 1e-6).is_err());
        assert!(HeightProfile::new(vec![f64::NAN; 9], 1e-6).is_err());
        let map = HeightMap::new([vec![0.0; 9], vec![f64::NAN; 3]].concat(), 4, 1e-6, 2e-6);
        assert!((map.unwrap().missing_share() - 0.25).abs() < 1e-12);
    }
    #[test]
    fn a_coarser_map_covers_the_same_area() {
        let mut heights: Vec<f64> = (0..35).map(f64::from).collect();
        heights[0] = f64::NAN;
        let map = HeightMap::new(heights, 7, 1e-6, 2e-6).unwrap();
        let coarse = map.coarser(3);
        assert_eq!((coarse.rows(), coarse.columns()), (3, 3));
        assert!((coarse.length_x_m() - 7e-6).abs() < 1e-18);
        assert!((coarse.length_y_m() - 10e-6).abs() < 1e-18);
        // the points 0 (missing) and 1 of the first row
        assert!((coarse.heights_m()[0] - 1.0).abs() < 1e-12);
        assert_eq!(map.coarser(100).heights_m()[1..], map.heights_m()[1..]);
    }

    #[test]
    fn errors_speak_in_mm() {
        let text = SurfaceError::cutoff(25e-3, 1e-6, 10e-3).to_string();
        assert!(text.contains("from 0.005 mm (5 steps) to 10 mm"), "{text}");
        assert!(text.contains("found 25 mm"), "{text}");
    }
}
