//! How the skin under a fingertip moves when its nail moves.

use serde::{Deserialize, Serialize};

use crate::quantity::{Band, Hertz};

/// The largest plausible ratio for a finger, in either direction, dB.
const LARGEST_DB: f64 = 80.0;

/// The ratio of the skin's acceleration to the nail's over frequency, as it was measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ContactMap {
    /// Where it was measured, Hz, ascending.
    frequency_hz: Vec<f64>,
    /// 20·log10 of skin over nail there, dB.
    ratio_db: Vec<f64>,
    /// Where it comes from.
    source: String,
}

impl ContactMap {
    /// The map through `points`: frequencies in Hz, 20·log10 of skin over nail in dB.
    ///
    /// Source: none; it checks and keeps what was measured.
    ///
    /// # Errors
    /// [`ContactMapError`] for fewer than two points, frequencies that do not ascend above 0 Hz, and ratios that are no numbers
    /// or beyond ±80 dB.
    ///
    /// ```
    /// use piezotact::discrimination::ContactMap;
    /// use piezotact::quantity::Hertz;
    /// let map = ContactMap::new(&[(50.0, -6.0), (200.0, -12.0)], "laser, 3 fingers").unwrap();
    /// assert!((map.ratio_db(Hertz(100.0)) + 9.0).abs() < 1e-12);
    /// ```
    pub fn new(points: &[(f64, f64)], source: &str) -> Result<Self, ContactMapError> {
        if points.len() < 2 {
            return Err(ContactMapError::TooFew {
                found: points.len(),
            });
        }
        let mut last_hz = 0.0;
        for (row, &(frequency_hz, ratio_db)) in points.iter().enumerate() {
            if !(frequency_hz > last_hz && frequency_hz.is_finite()) {
                return Err(ContactMapError::Frequency {
                    row: row + 1,
                    found_hz: frequency_hz,
                    last_hz,
                });
            }
            if ratio_db.is_nan() || ratio_db.abs() > LARGEST_DB {
                return Err(ContactMapError::Ratio {
                    row: row + 1,
                    found_db: ratio_db,
                });
            }
            last_hz = frequency_hz;
        }
        Ok(Self {
            frequency_hz: points.iter().map(|p| p.0).collect(),
            ratio_db: points.iter().map(|p| p.1).collect(),
            source: source.into(),
        })
    }

    /// 20·log10 of skin over nail at `frequency`, dB: straight lines over log frequency between the points, held at both ends.
    ///
    /// Source: linear interpolation.
    #[must_use]
    pub fn ratio_db(&self, frequency: Hertz) -> f64 {
        let after = self.frequency_hz.partition_point(|f| *f <= frequency.0);
        let (Some(&first), Some(&last)) = (self.ratio_db.first(), self.ratio_db.last()) else {
            return 0.0;
        };
        if after == 0 {
            return first;
        }
        let (Some(&high_hz), Some(&high_db)) =
            (self.frequency_hz.get(after), self.ratio_db.get(after))
        else {
            return last;
        };
        let (low_hz, low_db) = (self.frequency_hz[after - 1], self.ratio_db[after - 1]);
        let share = (frequency.0 / low_hz).ln() / (high_hz / low_hz).ln();
        low_db + share * (high_db - low_db)
    }

    /// Where it comes from.
    #[must_use]
    pub fn source(&self) -> &str {
        &self.source
    }

    /// From the first to the last frequency measured, Hz.
    #[must_use]
    pub fn measured_hz(&self) -> [f64; 2] {
        [
            self.frequency_hz.first().copied().unwrap_or(0.0),
            self.frequency_hz.last().copied().unwrap_or(0.0),
        ]
    }

    /// Whether it was measured over all of `band`.
    #[must_use]
    pub fn covers(&self, band: Band) -> bool {
        let [low_hz, high_hz] = self.measured_hz();
        low_hz <= band.low().0 && high_hz >= band.high().0
    }
}

/// Why points make no map.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ContactMapError {
    /// Fewer than two points.
    #[error(
        "expected a nail-to-skin map of two frequencies or more, found {found}; give one row for each frequency"
    )]
    TooFew { found: usize },
    /// Frequencies that do not ascend.
    #[error(
        "expected frequencies above 0 Hz that ascend, found {found_hz} Hz in row {row} after {last_hz} Hz; sort the rows"
    )]
    Frequency {
        /// The row, from 1.
        row: usize,
        /// What was found, Hz.
        found_hz: f64,
        /// The frequency before, Hz.
        last_hz: f64,
    },
    /// A ratio that cannot be.
    #[error(
        "expected ratios of skin to nail within ±80 dB, found {found_db} dB in row {row}; check the column and whether it holds dB or amplitudes"
    )]
    Ratio {
        /// The row, from 1.
        row: usize,
        /// What was found, dB.
        found_db: f64,
    },
}
