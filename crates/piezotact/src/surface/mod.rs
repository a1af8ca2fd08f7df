//! Surfaces: sample sets, the duplex theory of texture perception, and height maps.
//!
//! Heights and steps are in m. A point that was not measured is NaN in a height map, and nothing else is. Roughness is in
//! `piezotact-surface`.

mod duplex;
mod samples;

pub use duplex::{Duplex, PeriodBasis, TextureClass, mean_particle_m};
pub use samples::{Judgement, SampleSet, SurfaceSample};

use crate::number::rounded;
use serde::{Deserialize, Serialize};

/// Heights on a regular grid: `rows` × `columns` values, row by row, in m. NaN where nothing was measured. Documents leave the heights
/// out, which have a file of their own.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct HeightMap {
    #[serde(skip)]
    heights_m: Vec<f64>,
    /// The number of rows.
    rows: usize,
    /// Points in a row.
    columns: usize,
    /// The distance of two points in a row, m.
    step_x_m: f64,
    /// The distance of two rows, m.
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

    /// The same grid with other heights, in m: as many as it has, row by row.
    #[must_use]
    pub fn with_heights(&self, heights_m: Vec<f64>) -> Self {
        debug_assert_eq!(heights_m.len(), self.heights_m.len());
        Self { heights_m, ..*self }
    }
}

fn valid_step(step_m: f64) -> Result<(), SurfaceError> {
    if step_m > 0.0 && step_m.is_finite() {
        Ok(())
    } else {
        Err(SurfaceError::Step { found_m: step_m })
    }
}

/// The mean; 0 of nothing.
fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0usize), |(sum, count), v| (sum + v, count + 1));
    sum / count.max(1) as f64
}

/// Heights that make no surface.
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
}
