//! Surfaces: what a topography instrument measured, and what it says of roughness.
//!
//! Heights and steps are in m. A point that the instrument could not measure is NaN in a height map and
//! nothing else is; a profile has no such points.

mod samples;

use serde::{Deserialize, Serialize};

pub use samples::{Judgement, SampleSet, SurfaceSample};

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

/// Heights that make no surface, or a surface that lacks what is asked of it.
#[derive(Clone, Debug, PartialEq, thiserror::Error, Serialize, Deserialize)]
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
    #[error("expected a step between heights above zero, found {found_m} m; state it")]
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
}
