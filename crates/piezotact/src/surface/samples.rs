//! Sets of surface samples: what is known of each before anybody touches it.

use serde::{Deserialize, Serialize};

/// How far people agree in their judgement of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Judgement {
    /// They agree.
    Uniform,
    /// They nearly agree.
    NearlyUniform,
    /// They do not agree.
    NotUniform,
}

/// One sample of a set; lengths in m. What is not known is absent.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceSample {
    pub name: String,
    /// The arithmetic mean roughness Ra, m.
    pub ra_m: Option<f64>,
    /// The sandpaper it was moulded from, as its maker writes it.
    pub grit: Option<String>,
    /// The height of its dots, m.
    pub dot_height_m: Option<f64>,
    pub dot_diameter_m: Option<f64>,
    /// The gap between them, m.
    pub dot_gap_m: Option<f64>,
    /// The period along a row of dots, as published, m.
    pub wavelength_m: Option<f64>,
    /// How people describe it.
    pub perceptual_category: Option<String>,
    /// How people like it.
    pub hedonistic_category: Option<String>,
    /// How far they agree.
    pub judgement: Option<Judgement>,
}

/// A set of samples of one make.
#[derive(Clone, Debug, PartialEq)]
pub struct SampleSet {
    pub name: String,
    /// Where its numbers come from.
    pub source: String,
    /// What the samples are made of.
    pub material: String,
    /// Length, width and thickness of a plate, m.
    pub plate_m: [f64; 3],
    /// The samples, in the order of the set.
    pub samples: Vec<SurfaceSample>,
}

impl SampleSet {
    /// The sample of that name, in capital or small letters.
    #[must_use]
    pub fn sample(&self, name: &str) -> Option<&SurfaceSample> {
        self.samples
            .iter()
            .find(|sample| sample.name.eq_ignore_ascii_case(name))
    }
}

impl SurfaceSample {
    /// How far the published period is from dot diameter + gap, as a share of it; `None` when one is not known.
    #[must_use]
    pub fn wavelength_departure(&self) -> Option<f64> {
        let sum = self.dot_diameter_m? + self.dot_gap_m?;
        Some(sum / self.wavelength_m? - 1.0)
    }
}
