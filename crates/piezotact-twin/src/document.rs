//! What the twin made, as it is handed out.

use piezotact::document::Content;
use piezotact::surface::HeightMap;
use serde::Serialize;

/// The height map of a sample of the twin.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct SimulatedSurface {
    #[serde(flatten)]
    pub map: HeightMap,
    /// The sample.
    pub sample: String,
    /// What it was drawn with.
    pub seed: u64,
    /// The parameters of the twin that were changed.
    pub twin: String,
}

impl Content for SimulatedSurface {
    const SCHEMA: &'static str = "twin_surface";
    const VERSION: u32 = 2;
}
