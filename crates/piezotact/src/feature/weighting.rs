//! Perceptual weighting of a vibration: detection thresholds of the mechanoreceptor channels.

use serde::{Deserialize, Serialize};

use crate::quantity::{Band, Hertz, QuantityError};

/// A kind of mechanoreceptor of the fingertip.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Receptor {
    /// Merkel disks, slowly adapting, type I.
    Merkel,
    /// Meissner's corpuscles, rapidly adapting, type I.
    Meissner,
    /// Pacinian corpuscles, rapidly adapting, type II.
    Pacini,
    /// Ruffini endings, slowly adapting, type II.
    Ruffini,
}

impl Receptor {
    /// All four, in the order of the literature's tables.
    pub const ALL: [Self; 4] = [Self::Merkel, Self::Meissner, Self::Pacini, Self::Ruffini];

    /// The name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Merkel => "Merkel",
            Self::Meissner => "Meissner",
            Self::Pacini => "Pacini",
            Self::Ruffini => "Ruffini",
        }
    }

    /// The threshold that is known of it as an acceleration at the frequencies of textures; `None` for the slowly adapting ones.
    #[must_use]
    pub fn weighting(self) -> Option<Weighting> {
        match self {
            Self::Meissner => Some(Weighting::RapidlyAdapting),
            Self::Pacini => Some(Weighting::Pacinian),
            Self::Merkel | Self::Ruffini => None,
        }
    }

    /// The band it answers to (L. Felicetti's thesis, 2024, Table 1), Hz: Merkel 2–16, Meissner 3–40, Pacini 40–500, Ruffini 100–500. They overlap.
    ///
    /// # Errors
    /// Never for these bands; the type of the band demands it.
    pub fn band(self) -> Result<Band, QuantityError> {
        let (low, high) = match self {
            Self::Merkel => (2.0, 16.0),
            Self::Meissner => (3.0, 40.0),
            Self::Pacini => (40.0, 500.0),
            Self::Ruffini => (100.0, 500.0),
        };
        Band::new(Hertz(low), Hertz(high))
    }
}

/// The sensitivity by which a vibration's power is weighted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Weighting {
    /// The Pacinian channel alone.
    Pacinian,
    /// The rapidly adapting channel of Meissner's corpuscles alone.
    RapidlyAdapting,
    /// The most sensitive of the channels at each frequency: what is detected at all.
    DetectionThreshold,
}

impl Weighting {
    /// What it is and where it comes from.
    #[must_use]
    pub fn source(self) -> &'static str {
        match self {
            Self::Pacinian => {
                "power over the squared threshold of the Pacinian channel (thresholds after Bolanowski et al. 1988; use as a predictor of roughness: Bensmaïa & Hollins 2003)"
            }
            Self::RapidlyAdapting => {
                "power over the squared threshold of the rapidly adapting channel of Meissner's corpuscles (after Bolanowski et al. 1988)"
            }
            Self::DetectionThreshold => {
                "power over the squared detection threshold of the most sensitive of the Pacinian, rapidly adapting and slowly adapting I channels (after Bolanowski et al. 1988)"
            }
        }
    }

    /// The threshold at `frequency`, rms acceleration in m/s², of a sine on a large contact.
    ///
    /// Formula: displacement in dB re 1 µm peak: Pacinian −20 + 12·log2(250/f) below 250 Hz and
    /// −20 + 10·log2(f/250) above; rapidly adapting 28 − 6·log2(f/3), not below 6; slowly adapting I 28; times
    /// (2πf)²/√2.
    ///
    /// Source: straight lines through the four-channel model of S. J. Bolanowski et al. (1988), J. Acoust. Soc. Am.
    /// 84(5).
    #[must_use]
    pub fn threshold_m_s2(self, frequency: Hertz) -> f64 {
        let f = frequency.0.max(0.1);
        let pacinian_db = if f < 250.0 {
            -20.0 + 12.0 * (250.0 / f).log2()
        } else {
            -20.0 + 10.0 * (f / 250.0).log2()
        };
        let rapid_db = (28.0 - 6.0 * (f / 3.0).log2()).clamp(6.0, 28.0);
        let level_db = match self {
            Self::Pacinian => pacinian_db,
            Self::RapidlyAdapting => rapid_db,
            Self::DetectionThreshold => pacinian_db.min(rapid_db),
        };
        let displacement_m = 1e-6 * 10f64.powf(level_db / 20.0);
        displacement_m * (std::f64::consts::TAU * f).powi(2) / 2f64.sqrt()
    }

    /// What the density of each of `bins` lines, `resolution_hz` apart from 0 Hz, is multiplied by, within `band`;
    /// 0 outside.
    pub(crate) fn line_weights(self, bins: usize, resolution_hz: f64, band: Band) -> Vec<f64> {
        (0..bins)
            .map(|k| k as f64 * resolution_hz)
            .map(|f| {
                if f > 0.0 && band.contains(f) {
                    resolution_hz / self.threshold_m_s2(Hertz(f)).powi(2)
                } else {
                    0.0
                }
            })
            .collect()
    }

    /// The weighted power of a one-sided acceleration PSD in (m/s²)²/Hz with lines `resolution_hz` apart from
    /// 0 Hz, over `band`, as a multiple of threshold power: at 1 a steady vibration is just detected.
    ///
    /// Formula: Σ S(f)/a(f)²·Δf, a the threshold.
    ///
    /// Source: S. J. Bensmaïa and M. Hollins (2003), Somatosens. Mot. Res. 20(1).
    #[must_use]
    pub fn power(self, psd: &[f64], resolution_hz: f64, band: Band) -> f64 {
        let weights = self.line_weights(psd.len(), resolution_hz, band);
        psd.iter().zip(weights).map(|(p, w)| p * w).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thresholds_stand_where_the_literature_has_them() {
        // 0.1 µm peak at 250 Hz is 0.25 m/s² peak.
        let at = |hz: f64| Weighting::Pacinian.threshold_m_s2(Hertz(hz)) * 2f64.sqrt();
        assert!((at(250.0) - 0.2467).abs() < 1e-3, "{}", at(250.0));
        assert!((at(500.0) / at(250.0) - 4.0 * 10f64.powf(0.5)).abs() < 1e-9);
        // Below some 40 Hz the rapidly adapting channel is the more sensitive one.
        let both = |hz: f64| Weighting::DetectionThreshold.threshold_m_s2(Hertz(hz));
        assert!(both(10.0) < Weighting::Pacinian.threshold_m_s2(Hertz(10.0)));
        assert!((both(300.0) - Weighting::Pacinian.threshold_m_s2(Hertz(300.0))).abs() < 1e-12);
    }

    #[test]
    fn a_tone_at_threshold_has_power_one() {
        let mut psd = vec![0.0; 200];
        let a = Weighting::Pacinian.threshold_m_s2(Hertz(200.0));
        psd[40] = a * a / 5.0;
        let band = Band::new(Hertz(40.0), Hertz(500.0)).unwrap();
        assert!((Weighting::Pacinian.power(&psd, 5.0, band) - 1.0).abs() < 1e-12);
    }
}
