//! Roughness: what a topography instrument measured says of a surface.
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
mod filter;
mod filtered;
mod form;
mod instrument;
mod lines;
mod material;
mod mean_period;
mod page;
mod parameters;
mod plausible;
mod profile;
mod section;
mod set;
mod texture;
mod warning;

pub use areal::{ArealConfig, ArealRoughness, areal_roughness};
pub use cutoff::{Cutoff, ShortWaves};
pub use description::{length_text, short_number, unit_for};
pub use distribution::{
    HeightDistribution, distribution_of, height_distribution, height_limits_m, height_span_m,
};
pub use document::{
    EvaluatedSurface, LinesDocument, RoughnessDocument, RoughnessExtent, RoughnessMethod,
    TextureDocument,
};
pub use filter::{map_mean_surface, profile_mean_line};
pub use filtered::looks_filtered;
pub use form::{Form, remove_map_form, remove_profile_form};
pub use instrument::{
    InstrumentSettings, InstrumentValue, MeasuredProfile, ProfileKind, RoughnessOptions,
    evaluated_profile,
};
pub use lines::{LineDirection, LineParameter, LineRoughness, PowerLaw, line_roughness};
pub use material::{MaterialRatio, material_ratio};
pub use parameters::Parameter;
pub use profile::{
    Ends, ProfileConfig, ProfileFilter, ProfileRoughness, ProfileStandard, profile_roughness,
};
pub use set::RoughnessSet;
pub use texture::{PeriodRule, PeriodicTexture, Texture, TextureKind};
pub use warning::{FilterFault, HeightsFault, InstrumentStates, SurfaceWarning};

use instrument::usual_config;
use piezotact::Warning;
use piezotact::surface::{HeightMap, SurfaceError};
use serde::{Deserialize, Serialize};

/// The roughness of a profile or of a height map.
#[derive(Clone, Debug, PartialEq)]
pub enum Roughness {
    /// Of a profile.
    Profile(Box<ProfileRoughness>),
    /// Of a height map.
    Map(Box<ArealRoughness>),
}

impl Roughness {
    /// Whether its parameters describe one surface: false for a profile whose sections differ too much.
    #[must_use]
    pub fn is_uniform(&self) -> bool {
        match self {
            Self::Profile(roughness) => roughness.is_uniform(),
            Self::Map(_) => true,
        }
    }

    /// What limits it.
    #[must_use]
    pub fn warnings(&self) -> &[Warning] {
        match self {
            Self::Profile(roughness) => &roughness.warnings,
            Self::Map(roughness) => &roughness.warnings,
        }
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
        if !(step_m > 0.0 && step_m.is_finite()) {
            return Err(SurfaceError::Step { found_m: step_m });
        }
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

/// What filters ask of a height map.
trait Extent {
    /// The steps along a row and between rows, m.
    fn steps_m(&self) -> (f64, f64);
    fn shorter_step_m(&self) -> f64;
    fn longer_side_m(&self) -> f64;
}

impl Extent for HeightMap {
    fn steps_m(&self) -> (f64, f64) {
        (self.step_x_m(), self.step_y_m())
    }

    fn shorter_step_m(&self) -> f64 {
        self.step_x_m().min(self.step_y_m())
    }

    fn longer_side_m(&self) -> f64 {
        self.length_x_m().max(self.length_y_m())
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
fn computable(heights_m: &[f64], step_m: f64) -> Result<(), RoughnessError> {
    let largest_m = heights_m.iter().fold(0.0f64, |most, z| most.max(z.abs()));
    if largest_m <= LARGEST && largest_m / step_m <= LARGEST {
        Ok(())
    } else {
        Err(RoughnessError::Huge { largest_m, step_m })
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

/// A surface that lacks what is asked of it.
#[derive(Clone, Debug, PartialEq, thiserror::Error, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub enum RoughnessError {
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
    /// No line of a map can be evaluated.
    #[error(
        "expected a line along {along} of 8 points and more that were all measured, found none among lines of {points} points; take the other \
            direction, or measure again the areas where points are missing"
    )]
    NoLine {
        along: LineDirection,
        /// The points of a line.
        points: usize,
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

impl RoughnessError {
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
    fn profiles_are_whole_or_are_not() {
        assert!(HeightProfile::new(vec![0.0; 7], 1e-6).is_err());
        assert!(HeightProfile::new(vec![f64::NAN; 9], 1e-6).is_err());
    }

    #[test]
    fn errors_speak_in_mm() {
        let text = RoughnessError::cutoff(25e-3, 1e-6, 10e-3).to_string();
        assert!(text.contains("from 0.005 mm (5 steps) to 10 mm"), "{text}");
        assert!(text.contains("found 25 mm"), "{text}");
    }
}
