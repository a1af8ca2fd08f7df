//! The command line of `piezotact score`.

use std::path::PathBuf;

use clap::Args;
use piezotact::quantity::{Band, Measure};
use piezotact::score::ScoreModel;
use piezotact::score::literature::LevelCurve;

use super::Reading;
use crate::deliver::Outputs;

/// Which published threshold curve the literature's indices take, dB re full scale.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub(crate) enum CurveName {
    /// That of the Python package vibromaf.
    Vibromaf,
    /// That of MPEG haptic coding.
    Mpeg,
}

impl From<CurveName> for LevelCurve {
    fn from(name: CurveName) -> Self {
        match name {
            CurveName::Vibromaf => Self::Vibromaf,
            CurveName::Mpeg => Self::Mpeg,
        }
    }
}

/// Which difference decides.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub(crate) enum ModelName {
    Perceived,
    Spectral,
}

impl From<ModelName> for ScoreModel {
    fn from(name: ModelName) -> Self {
        match name {
            ModelName::Perceived => Self::PerceivedDifference,
            ModelName::Spectral => Self::Spectral,
        }
    }
}

/// What a finger feels, and what of a difference.
#[derive(Debug, Args)]
pub(crate) struct Feeling {
    /// The just-noticeable difference (JND) in level between spectra, in dB: smaller differences are not noticed; between it and 2.5 dB, the
    /// upper end of the published range, the result is not decided.
    #[arg(
        long,
        default_value_t = 1.58,
        value_name = "DB",
        allow_negative_numbers = true
    )]
    pub(crate) jnd: f64,
    /// The just-noticeable difference in frequency between spectra, as a fraction of the frequency.
    #[arg(
        long,
        default_value_t = 0.2,
        value_name = "SHARE",
        allow_negative_numbers = true
    )]
    pub(crate) frequency_jnd: f64,
    /// The measured ratio of skin to nail vibration: a table of frequency (Hz) and skin over nail (dB, or ratio). By default,
    /// skin and nail are assumed to move equally.
    #[arg(long, value_name = "MAP.csv")]
    pub(crate) contact_map: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct Score {
    /// The reference: what should be felt.
    #[arg(value_name = "A")]
    pub(crate) reference: PathBuf,
    /// The vibration that is compared with A.
    #[arg(value_name = "B")]
    pub(crate) test: PathBuf,
    /// The channel of A; optional if there is only one, or only one of acceleration.
    #[arg(long)]
    pub(crate) channel: Option<String>,
    /// The channel of B, if it differs from --channel.
    #[arg(long)]
    pub(crate) test_channel: Option<String>,
    /// What the number 1 in B means, if it differs from --scale.
    #[arg(long, value_name = "VALUE UNIT")]
    pub(crate) test_scale: Option<Measure>,
    /// The band in which A and B are compared, in Hz.
    #[arg(long, default_value = "20..1000")]
    pub(crate) band: Band,
    /// Which difference decides: the perceived one, or that of long-time spectra, which --jnd and --frequency-jnd concern.
    #[arg(long, value_enum, default_value = "perceived")]
    pub(crate) model: ModelName,
    #[command(flatten)]
    pub(crate) feeling: Feeling,
    /// The full scale that ST-SIM and SPQI assume, which neither paper states.
    #[arg(long, default_value = "1 m/s2", value_name = "VALUE UNIT")]
    pub(crate) full_scale: Measure,
    /// The threshold curve of ST-SIM and SPQI.
    #[arg(long, value_enum, default_value = "vibromaf")]
    pub(crate) curve: CurveName,
    #[command(flatten)]
    pub(crate) reading: Reading,
    #[command(flatten)]
    pub(crate) outputs: Outputs,
}
