//! Windows for spectral estimates.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

/// The shape of a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Window {
    /// Hann: the field's default for random vibration.
    Hann,
    /// Hamming.
    Hamming,
    /// Blackman.
    Blackman,
    /// Four-term Blackman–Harris, 92 dB side lobes.
    BlackmanHarris,
    /// Flat top, for the amplitude of single tones.
    FlatTop,
    /// No window.
    Rectangular,
}

impl std::str::FromStr for Window {
    type Err = UnknownWindow;
    fn from_str(text: &str) -> Result<Self, UnknownWindow> {
        Self::ALL
            .into_iter()
            .find(|window| window.name() == text)
            .ok_or_else(|| UnknownWindow { found: text.into() })
    }
}

/// A window that is not known here.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "expected a window hann, hamming, blackman, blackman-harris, flat-top or rectangular, found `{found}`; hann is usual"
)]
pub struct UnknownWindow {
    pub found: String,
}

/// Which of its two forms a window takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Symmetry {
    /// One period of the cosine sum (SciPy's `sym=False`): for spectra.
    Periodic,
    /// Both ends equal (SciPy's `sym=True`): for filters, and what some FRF programs use.
    Symmetric,
}

impl Window {
    /// All windows.
    pub const ALL: [Self; 6] = [
        Self::Hann,
        Self::Hamming,
        Self::Blackman,
        Self::BlackmanHarris,
        Self::FlatTop,
        Self::Rectangular,
    ];

    /// The name as it is written on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Hann => "hann",
            Self::Hamming => "hamming",
            Self::Blackman => "blackman",
            Self::BlackmanHarris => "blackman-harris",
            Self::FlatTop => "flat-top",
            Self::Rectangular => "rectangular",
        }
    }

    /// The window's `length` coefficients, dimensionless.
    ///
    /// Source: cosine sums of F. J. Harris (1978), flat top of D'Antona and Ferrero (2006), as in SciPy.
    ///
    /// ```
    /// use piezotact::spectrum::{Symmetry, Window};
    /// let hann = Window::Hann.coefficients(4, Symmetry::Periodic);
    /// assert!(hann.iter().zip([0.0, 0.5, 1.0, 0.5]).all(|(w, expected)| (w - expected).abs() < 1e-15));
    /// ```
    #[must_use]
    pub fn coefficients(self, length: usize, symmetry: Symmetry) -> Vec<f64> {
        let terms: &[f64] = match self {
            Self::Hann => &[0.5, 0.5],
            Self::Hamming => &[0.54, 0.46],
            Self::Blackman => &[0.42, 0.5, 0.08],
            Self::BlackmanHarris => &[0.358_75, 0.488_29, 0.141_28, 0.011_68],
            Self::FlatTop => &[
                0.215_578_95,
                0.416_631_58,
                0.277_263_158,
                0.083_578_947,
                0.006_947_368,
            ],
            Self::Rectangular => &[1.0],
        };
        let period = match symmetry {
            Symmetry::Periodic => length.max(1),
            Symmetry::Symmetric => length.saturating_sub(1).max(1),
        };
        (0..length)
            .map(|i| {
                let phase = TAU * i as f64 / period as f64;
                terms
                    .iter()
                    .enumerate()
                    .map(|(k, a)| {
                        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
                        sign * a * (k as f64 * phase).cos()
                    })
                    .sum()
            })
            .collect()
    }
}
