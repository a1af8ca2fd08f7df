//! Eye movements and other artefacts taken out of EEG: by regression on electrodes near the eyes, or by independent components.

mod ica;
mod regression;

pub use ica::{EyeComponent, EyeComponents, Ica, IcaConfig};
pub use regression::EogRegression;
