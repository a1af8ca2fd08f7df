//! Universal File Format, dataset 58 (text) and 58b (binary): the functions that modal analysers and their
//! programs exchange.
//!
//! Source of the layout: SDRC, *Universal File Datasets Summary*, dataset 58 "Function at Nodal DOF".

mod convert;
mod read;
mod write;
mod write_time;

use std::fmt;

use num_complex::Complex;

pub use read::{looks_like_uff, parse_uff};
pub use write::{UffEncoding, write_uff};
pub use write_time::write_uff_recording;

pub(crate) use convert::{holds_transfer, recording_of, transfer_of};

/// What a function of dataset 58 is: field 1 of its record 6.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UffKind {
    /// 0, general or unknown.
    Unknown,
    /// 1, a time response.
    Time,
    /// 2, an auto spectrum.
    AutoSpectrum,
    /// 3, a cross spectrum.
    CrossSpectrum,
    /// 4, a frequency response function.
    FrequencyResponse,
    /// 5, a transmissibility.
    Transmissibility,
    /// 6, a coherence.
    Coherence,
    /// 9, a power spectral density.
    Psd,
    /// 12, a spectrum.
    Spectrum,
    /// Any other number.
    Other(i64),
}

impl UffKind {
    /// The kind of that number.
    #[must_use]
    pub fn of(number: i64) -> Self {
        match number {
            0 => Self::Unknown,
            1 => Self::Time,
            2 => Self::AutoSpectrum,
            3 => Self::CrossSpectrum,
            4 => Self::FrequencyResponse,
            5 => Self::Transmissibility,
            6 => Self::Coherence,
            9 => Self::Psd,
            12 => Self::Spectrum,
            other => Self::Other(other),
        }
    }

    /// Its number in a file.
    #[must_use]
    pub fn number(self) -> i64 {
        match self {
            Self::Unknown => 0,
            Self::Time => 1,
            Self::AutoSpectrum => 2,
            Self::CrossSpectrum => 3,
            Self::FrequencyResponse => 4,
            Self::Transmissibility => 5,
            Self::Coherence => 6,
            Self::Psd => 9,
            Self::Spectrum => 12,
            Self::Other(number) => number,
        }
    }
}

impl fmt::Display for UffKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown => f.write_str("function of no stated kind"),
            Self::Time => f.write_str("time response"),
            Self::AutoSpectrum => f.write_str("auto spectrum"),
            Self::CrossSpectrum => f.write_str("cross spectrum"),
            Self::FrequencyResponse => f.write_str("frequency response"),
            Self::Transmissibility => f.write_str("transmissibility"),
            Self::Coherence => f.write_str("coherence"),
            Self::Psd => f.write_str("power spectral density"),
            Self::Spectrum => f.write_str("spectrum"),
            Self::Other(number) => write!(f, "function of type {number}"),
        }
    }
}

/// Where and which way something was measured: an entity, its node, and a direction (0 scalar, ±1 X, ±2 Y, ±3 Z,
/// ±4 to ±6 rotations about them).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct UffPoint {
    /// The name of the entity; empty where the file says `NONE`.
    pub entity: String,
    pub node: i64,
    pub direction: i64,
}

impl fmt::Display for UffPoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = if self.entity.is_empty() {
            "node"
        } else {
            &self.entity
        };
        write!(f, "{name}:{}", self.node)?;
        let sign = if self.direction < 0 { '-' } else { '+' };
        match self.direction.unsigned_abs() {
            0 => Ok(()),
            axis @ 1..=3 => write!(f, ":{sign}{}", ["X", "Y", "Z"][axis as usize - 1]),
            axis @ 4..=6 => write!(f, ":{sign}R{}", ["X", "Y", "Z"][axis as usize - 4]),
            other => write!(f, ":{sign}{other}"),
        }
    }
}

/// What an axis holds, as the file names it; empty where it says `NONE`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct UffAxis {
    /// The number of its quantity: 0 unknown, 12 acceleration, 13 force, 17 time, 18 frequency …
    pub quantity: i64,
    pub label: String,
    /// The label of its unit.
    pub unit: String,
}

/// Where the values of a function lie.
#[derive(Clone, Debug, PartialEq)]
pub enum UffAbscissa {
    /// Evenly from `start` in steps of `step`, in the unit of the axis.
    Even {
        /// The place of the first value.
        start: f64,
        /// From one value to the next.
        step: f64,
    },
    /// One place for each value.
    List(Vec<f64>),
}

/// The values of a function.
#[derive(Clone, Debug, PartialEq)]
pub enum UffData {
    /// Real ones.
    Real(Vec<f64>),
    /// Complex ones.
    Complex(Vec<Complex<f64>>),
}

impl UffData {
    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Real(values) => values.len(),
            Self::Complex(values) => values.len(),
        }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// One function of dataset 58, as it stands in the file.
#[derive(Clone, Debug, PartialEq)]
pub struct UffFunction {
    /// The five lines of free text; the third is by custom the date. Empty where the file says `NONE`.
    pub id_lines: [String; 5],
    pub kind: UffKind,
    /// Where the response was measured.
    pub response: UffPoint,
    /// Where it was excited.
    pub reference: UffPoint,
    /// Where its values lie.
    pub abscissa: UffAbscissa,
    /// What the abscissa is.
    pub abscissa_axis: UffAxis,
    /// What the ordinate is, or its numerator.
    pub ordinate_axis: UffAxis,
    /// What the denominator of the ordinate is.
    pub denominator_axis: UffAxis,
    pub data: UffData,
    /// How many values its header promises; text that was cut short holds fewer.
    pub promised: usize,
}

impl UffFunction {
    /// When it was made, as the file writes it; empty when it does not say.
    #[must_use]
    pub fn date(&self) -> &str {
        &self.id_lines[2]
    }

    /// The place of every value, in the unit of the abscissa.
    #[must_use]
    pub fn places(&self) -> Vec<f64> {
        match &self.abscissa {
            UffAbscissa::Even { start, step } => (0..self.data.len())
                .map(|k| start + k as f64 * step)
                .collect(),
            UffAbscissa::List(places) => places.clone(),
        }
    }
}
