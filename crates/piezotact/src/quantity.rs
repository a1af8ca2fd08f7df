//! Units, and the physical quantities that a series of samples can hold.
//!
//! Inside, everything is SI. People's units (g, mm/s², kHz, µV) are turned into SI once, by
//! [`Unit::parse`], when a file is read.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// Standard gravity in m/s², exact by definition.
///
/// Source: 3rd CGPM (1901), value kept by ISO 80000-3.
pub const STANDARD_GRAVITY_M_S2: f64 = 9.806_65;

macro_rules! scalar {
    ($(#[$doc:meta])* $name:ident, $unit:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize, Deserialize)]
        #[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
        #[serde(transparent)]
        pub struct $name(pub f64);

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                fmt::Display::fmt(&self.0, f)?;
                f.write_str(concat!(" ", $unit))
            }
        }
    };
}

scalar!(
    /// A frequency in Hz.
    Hertz, "Hz"
);
scalar!(
    /// A duration in s.
    Seconds, "s"
);
scalar!(
    /// A force in N.
    Newtons, "N"
);
scalar!(
    /// A ratio of amplitudes in dB, 20·log10.
    Decibels, "dB"
);
scalar!(
    /// A potential in V (peak, where an amplitude is meant).
    Volts, "V"
);
scalar!(
    /// An angle between the finger and the surface, in degrees.
    Degrees, "°"
);

impl Decibels {
    /// The amplitude ratio that this level stands for, 10^(dB/20).
    #[must_use]
    pub fn amplitude_ratio(self) -> f64 {
        10f64.powf(self.0 / 20.0)
    }

    /// The level of an amplitude ratio, 20·log10(ratio) in dB; −∞ for 0.
    #[must_use]
    pub fn from_amplitude_ratio(ratio: f64) -> Self {
        Self(20.0 * ratio.log10())
    }

    /// The level of a power, 10·log10(power) in dB re 1; −∞ for 0.
    #[must_use]
    pub fn from_power(power: f64) -> Self {
        Self(10.0 * power.log10())
    }
}

/// A sampling rate in Hz, from one sample in a quarter of an hour to 10 MHz: beyond that it is a mistake.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(try_from = "f64", into = "f64")]
pub struct SampleRate(f64);

impl SampleRate {
    /// A rate of `rate_hz` samples per second.
    ///
    /// # Errors
    /// [`QuantityError::Rate`] when the rate is not a number from 0.001 to 1e7 Hz.
    pub fn new(rate_hz: f64) -> Result<Self, QuantityError> {
        if (1e-3..=1e7).contains(&rate_hz) {
            Ok(Self(rate_hz))
        } else {
            Err(QuantityError::Rate { found: rate_hz })
        }
    }

    /// The rate in Hz.
    #[must_use]
    pub fn hz(self) -> f64 {
        self.0
    }

    /// Half the rate: the highest frequency that the samples can hold, in Hz.
    #[must_use]
    pub fn nyquist(self) -> Hertz {
        Hertz(self.0 / 2.0)
    }

    /// The number of samples in `duration`, rounded to the nearest.
    #[must_use]
    pub fn samples_in(self, duration: Seconds) -> usize {
        (duration.0 * self.0).round().max(0.0) as usize
    }

    /// The time that `samples` take, in s.
    #[must_use]
    pub fn duration_of(self, samples: usize) -> Seconds {
        Seconds(samples as f64 / self.0)
    }
}

impl TryFrom<f64> for SampleRate {
    type Error = QuantityError;
    fn try_from(rate_hz: f64) -> Result<Self, QuantityError> {
        Self::new(rate_hz)
    }
}

impl From<SampleRate> for f64 {
    fn from(rate: SampleRate) -> Self {
        rate.0
    }
}

impl fmt::Display for SampleRate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // A rate from time stamps has more digits than its clock.
        write!(f, "{} Hz", (self.0 * 1e6).round() / 1e6)
    }
}

/// A band of frequencies, both ends included, 0 ≤ low < high.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(try_from = "[f64; 2]", into = "[f64; 2]")]
pub struct Band {
    low_hz: f64,
    high_hz: f64,
}

impl Band {
    /// The band from `low` to `high`.
    ///
    /// # Errors
    /// [`QuantityError::Band`] unless 0 ≤ low < high and both are finite.
    pub fn new(low: Hertz, high: Hertz) -> Result<Self, QuantityError> {
        if low.0 >= 0.0 && low.0 < high.0 && high.0.is_finite() {
            Ok(Self {
                low_hz: low.0,
                high_hz: high.0,
            })
        } else {
            Err(QuantityError::Band {
                found: format!("{}..{}", low.0, high.0),
            })
        }
    }

    /// The band from 0 Hz to `high`, which is above zero and finite.
    pub(crate) fn up_to(high: Hertz) -> Self {
        Self {
            low_hz: 0.0,
            high_hz: high.0.max(f64::MIN_POSITIVE),
        }
    }

    /// The lower end.
    #[must_use]
    pub fn low(self) -> Hertz {
        Hertz(self.low_hz)
    }

    /// The upper end.
    #[must_use]
    pub fn high(self) -> Hertz {
        Hertz(self.high_hz)
    }

    /// Whether `frequency_hz` lies in the band.
    #[must_use]
    pub fn contains(self, frequency_hz: f64) -> bool {
        self.low_hz <= frequency_hz && frequency_hz <= self.high_hz
    }

    /// The part that two bands share; `None` when they share nothing.
    #[must_use]
    pub fn common(self, other: Self) -> Option<Self> {
        let (low_hz, high_hz) = (
            self.low_hz.max(other.low_hz),
            self.high_hz.min(other.high_hz),
        );
        (low_hz < high_hz).then_some(Self { low_hz, high_hz })
    }

    /// The third-octave bands that lie in this one, cut at its ends; from the lowest up. Below 1 Hz there are none.
    ///
    /// Formula: centres 10^(n/10) Hz, ends 10^(±1/20) of a centre.
    ///
    /// Source: IEC 61260-1:2014, base 10.
    ///
    /// ```
    /// use piezotact::quantity::{Band, Hertz};
    /// let bands = Band::new(Hertz(20.0), Hertz(1000.0)).unwrap().third_octaves();
    /// assert_eq!(bands.len(), 18);
    /// assert!((bands[1].low().0 - 22.387).abs() < 1e-3 && bands[17].high().0 == 1000.0);
    /// ```
    #[must_use]
    pub fn third_octaves(self) -> Vec<Self> {
        let edge = |n: i32| 10f64.powf((f64::from(n) - 0.5) / 10.0);
        (0..=60)
            .filter_map(|n| {
                self.common(Self {
                    low_hz: edge(n),
                    high_hz: edge(n + 1),
                })
            })
            .collect()
    }

    /// The weight of a frequency: 1 in the band, 0 outside, with raised-cosine edges that lie *outside*
    /// the band and are `edge_ratio` of the band's end wide, so that the band itself is untouched.
    ///
    /// ```
    /// use piezotact::quantity::{Band, Hertz};
    /// let band = Band::new(Hertz(20.0), Hertz(1000.0)).unwrap();
    /// assert_eq!(band.weight(500.0, 0.1), 1.0);
    /// assert!((band.weight(1050.0, 0.1) - 0.5).abs() < 1e-12);
    /// assert_eq!(band.weight(17.9, 0.1), 0.0);
    /// ```
    #[must_use]
    pub fn weight(self, frequency_hz: f64, edge_ratio: f64) -> f64 {
        let outer_low_hz = self.low_hz * (1.0 - edge_ratio);
        let outer_high_hz = self.high_hz * (1.0 + edge_ratio);
        if self.contains(frequency_hz) {
            1.0
        } else if frequency_hz > outer_low_hz && frequency_hz < self.low_hz {
            let inside = (frequency_hz - outer_low_hz) / (self.low_hz - outer_low_hz);
            piezotact_fourier::fade(inside)
        } else if frequency_hz > self.high_hz && frequency_hz < outer_high_hz {
            let outside = (frequency_hz - self.high_hz) / (outer_high_hz - self.high_hz);
            piezotact_fourier::fade(1.0 - outside)
        } else {
            0.0
        }
    }
}

impl fmt::Display for Band {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let digits = |hz: f64| if hz.fract().abs() < 1e-9 { 0 } else { 1 };
        write!(
            f,
            "{:.*}–{:.*} Hz",
            digits(self.low_hz),
            self.low_hz,
            digits(self.high_hz),
            self.high_hz
        )
    }
}

impl FromStr for Band {
    type Err = QuantityError;

    /// Reads `20..1000`, in Hz.
    fn from_str(text: &str) -> Result<Self, QuantityError> {
        let wrong = || QuantityError::Band { found: text.into() };
        let (low, high) = text.split_once("..").ok_or_else(wrong)?;
        match (low.trim().parse(), high.trim().parse()) {
            (Ok(low), Ok(high)) => Self::new(Hertz(low), Hertz(high)),
            _ => Err(wrong()),
        }
    }
}

impl TryFrom<[f64; 2]> for Band {
    type Error = QuantityError;
    fn try_from([low_hz, high_hz]: [f64; 2]) -> Result<Self, QuantityError> {
        Self::new(Hertz(low_hz), Hertz(high_hz))
    }
}

impl From<Band> for [f64; 2] {
    fn from(band: Band) -> Self {
        [band.low_hz, band.high_hz]
    }
}

/// The unit of a channel, always SI once a file has been read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(from = "String", into = "String")]
pub enum Unit {
    /// m/s²
    MetrePerSecondSquared,
    /// N
    Newton,
    /// V
    Volt,
    /// Digital samples relative to full scale = 1.
    FullScale,
    /// Pa
    Pascal,
    /// m
    Metre,
    /// m/s
    MetrePerSecond,
    /// rad/s
    RadianPerSecond,
    /// s
    Second,
    /// A unit that is kept as the file wrote it and takes part in no conversion; empty when the file named none.
    Other(String),
}

impl Unit {
    /// The SI symbol, as it stands in files and on axes.
    #[must_use]
    pub fn symbol(&self) -> &str {
        match self {
            Self::MetrePerSecondSquared => "m/s²",
            Self::Newton => "N",
            Self::Volt => "V",
            Self::FullScale => "FS",
            Self::Pascal => "Pa",
            Self::Metre => "m",
            Self::MetrePerSecond => "m/s",
            Self::RadianPerSecond => "rad/s",
            Self::Second => "s",
            Self::Other(text) if text.is_empty() => "no unit",
            Self::Other(text) => text,
        }
    }

    /// The unit of a power spectral density of this unit, as it stands on axes: `(m/s²)²/Hz`, `N²/Hz`.
    #[must_use]
    pub fn of_psd(&self) -> String {
        match self {
            Self::Other(text) if text.is_empty() => "1/Hz".into(),
            simple if simple.symbol().chars().all(char::is_alphabetic) => format!("{simple}²/Hz"),
            compound => format!("({compound})²/Hz"),
        }
    }

    /// The unit of a power spectral density of this unit over wavenumbers in 1/m: `(m/s²)²·m`.
    #[must_use]
    pub fn of_psd_along_a_way(&self) -> String {
        let squared = self.of_psd();
        format!("{}·m", squared.strip_suffix("/Hz").unwrap_or("1"))
    }

    /// The SI unit that `text` names, and the factor that turns a value in `text` into it.
    /// Text that is no unit known here comes back as [`Unit::Other`] with factor 1.
    ///
    /// ```
    /// use piezotact::quantity::Unit;
    /// assert_eq!(Unit::parse("mN"), (Unit::Newton, 1e-3));
    /// assert_eq!(Unit::parse("g"), (Unit::MetrePerSecondSquared, 9.80665));
    /// ```
    #[must_use]
    pub fn parse(text: &str) -> (Self, f64) {
        let plain = text
            .trim()
            .replace('²', "2")
            .replace('¹', "1")
            .replace(['⁻', '−'], "-")
            .replace('^', "")
            .replace("**", "")
            .replace(['*', '⋅', '∙', '•'], "·")
            .replace(['µ', 'μ'], "u")
            .replace(' ', "");
        match plain.as_str() {
            "m/s2" | "ms-2" | "m.s-2" | "m·s-2" | "m/s/s" => (Self::MetrePerSecondSquared, 1.0),
            "mm/s2" | "mm·s-2" | "mm.s-2" => (Self::MetrePerSecondSquared, 1e-3),
            "cm/s2" | "cm·s-2" | "cm.s-2" | "Gal" => (Self::MetrePerSecondSquared, 1e-2),
            "g" | "gn" | "g0" | "G" => (Self::MetrePerSecondSquared, STANDARD_GRAVITY_M_S2),
            "mg" => (Self::MetrePerSecondSquared, STANDARD_GRAVITY_M_S2 * 1e-3),
            "N" => (Self::Newton, 1.0),
            "mN" => (Self::Newton, 1e-3),
            "kN" => (Self::Newton, 1e3),
            "cN" => (Self::Newton, 1e-2),
            "uN" => (Self::Newton, 1e-6),
            // Weights: exact by the definitions of the pound and of standard gravity.
            "gf" => (Self::Newton, STANDARD_GRAVITY_M_S2 * 1e-3),
            "kgf" | "kp" => (Self::Newton, STANDARD_GRAVITY_M_S2),
            "lbf" => (Self::Newton, 0.453_592_37 * STANDARD_GRAVITY_M_S2),
            "V" => (Self::Volt, 1.0),
            "mV" => (Self::Volt, 1e-3),
            "uV" => (Self::Volt, 1e-6),
            "FS" | "fs" | "fullscale" | "1" => (Self::FullScale, 1.0),
            "Pa" => (Self::Pascal, 1.0),
            "kPa" => (Self::Pascal, 1e3),
            "m" => (Self::Metre, 1.0),
            "cm" => (Self::Metre, 1e-2),
            "mm" => (Self::Metre, 1e-3),
            "um" => (Self::Metre, 1e-6),
            "nm" => (Self::Metre, 1e-9),
            "m/s" | "m·s-1" | "m.s-1" => (Self::MetrePerSecond, 1.0),
            "cm/s" => (Self::MetrePerSecond, 1e-2),
            "mm/s" | "mm·s-1" | "mm.s-1" => (Self::MetrePerSecond, 1e-3),
            "um/s" | "um·s-1" | "um.s-1" => (Self::MetrePerSecond, 1e-6),
            "rad/s" => (Self::RadianPerSecond, 1.0),
            "deg/s" | "°/s" | "dps" => (Self::RadianPerSecond, std::f64::consts::PI / 180.0),
            "s" | "sec" => (Self::Second, 1.0),
            "ms" => (Self::Second, 1e-3),
            "us" => (Self::Second, 1e-6),
            "ns" => (Self::Second, 1e-9),
            _ => (Self::Other(text.trim().into()), 1.0),
        }
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.symbol())
    }
}

impl From<String> for Unit {
    fn from(text: String) -> Self {
        match Self::parse(&text) {
            (unit, factor) if (factor - 1.0).abs() < f64::EPSILON && unit.symbol() != "no unit" => {
                unit
            }
            _ => Self::Other(if text == "no unit" {
                String::new()
            } else {
                text
            }),
        }
    }
}

impl From<Unit> for String {
    fn from(unit: Unit) -> Self {
        unit.symbol().into()
    }
}

/// A physical value with its unit, as a person writes it: `200 m/s2`, `2.5 g`, `1 FS`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Measure {
    /// The value in `unit`.
    pub value: f64,
    /// The SI unit.
    pub unit: Unit,
}

impl FromStr for Measure {
    type Err = QuantityError;

    fn from_str(text: &str) -> Result<Self, QuantityError> {
        let wrong = || QuantityError::Measure { found: text.into() };
        let text = text.trim();
        // The longest leading part that reads as a number is the number: "2e3 g", "2g", "200 m/s2".
        let (value, rest) = (1..=text.len())
            .rev()
            .filter(|&end| text.is_char_boundary(end))
            .find_map(|end| Some((text[..end].trim().parse::<f64>().ok()?, &text[end..])))
            .ok_or_else(wrong)?;
        let (unit, factor) = Unit::parse(rest);
        let value = value * factor;
        if matches!(unit, Unit::Other(_)) || !value.is_finite() || value <= 0.0 {
            return Err(wrong());
        }
        Ok(Self { value, unit })
    }
}

impl fmt::Display for Measure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.value, self.unit)
    }
}

/// A physical quantity that a [`Series`](crate::Series) can hold. The markers below are its only instances.
pub trait Quantity: Copy + fmt::Debug + PartialEq + Send + Sync + 'static {
    /// The name in the field, for messages and axes.
    const NAME: &'static str;
    /// The SI unit of the samples.
    const UNIT: Unit;
}

macro_rules! marker {
    ($(#[$doc:meta])* $name:ident, $text:literal, $unit:expr) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $name {}
        impl Quantity for $name {
            const NAME: &'static str = $text;
            const UNIT: Unit = $unit;
        }
    };
}

marker!(
    /// Acceleration, m/s² (of the fingernail, unless a channel says otherwise).
    Acceleration, "acceleration", Unit::MetrePerSecondSquared
);
marker!(
    /// Contact force, N.
    Force, "force", Unit::Newton
);
marker!(
    /// The digital drive that the PC sends, full scale = 1.
    Drive, "drive", Unit::FullScale
);
marker!(
    /// Electric potential, V.
    Potential, "potential", Unit::Volt
);
marker!(
    /// Samples whose physical scale is not known; never combined with a physical quantity.
    Uncalibrated, "uncalibrated signal", Unit::Other(String::new())
);

/// Invalid rate, band or measure.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum QuantityError {
    /// A sampling rate that no recording has.
    #[error("expected a sampling rate from 0.001 to 1e7 Hz, found {found}; give the rate in Hz")]
    Rate { found: f64 },
    /// A band that is not `low..high` with 0 ≤ low < high.
    #[error(
        "expected a band low..high in Hz with 0 ≤ low < high, found `{found}`; write for example 20..1000"
    )]
    Band { found: String },
    /// A value with its unit that could not be read.
    #[error(
        "expected a value above zero with a unit (m/s2, g, N, V, FS …), found `{found}`; write for example \"200 m/s2\" or \"0.5 mm\""
    )]
    Measure { found: String },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn people_write_units_in_many_ways() {
        for (text, unit, factor) in [
            ("m/s²", Unit::MetrePerSecondSquared, 1.0),
            ("m/s^2", Unit::MetrePerSecondSquared, 1.0),
            ("m·s⁻²", Unit::MetrePerSecondSquared, 1.0),
            ("m * s^-2", Unit::MetrePerSecondSquared, 1.0),
            ("mm·s⁻¹", Unit::MetrePerSecond, 1e-3),
            ("ns", Unit::Second, 1e-9),
            ("g", Unit::MetrePerSecondSquared, 9.80665),
            ("µV", Unit::Volt, 1e-6),
            ("gf", Unit::Newton, 9.80665e-3),
            ("lbf", Unit::Newton, 4.448_221_615_260_5),
            ("mm/s", Unit::MetrePerSecond, 1e-3),
            ("µm/s", Unit::MetrePerSecond, 1e-6),
            ("counts", Unit::Other("counts".into()), 1.0),
        ] {
            assert_eq!(Unit::parse(text), (unit, factor), "{text}");
        }
    }

    #[test]
    fn a_unit_survives_being_saved() {
        for unit in [
            Unit::MetrePerSecondSquared,
            Unit::FullScale,
            Unit::RadianPerSecond,
            Unit::Other("counts".into()),
            Unit::Other("mV".into()),
            Unit::Other(String::new()),
        ] {
            let text: String = unit.clone().into();
            assert_eq!(Unit::from(text), unit);
        }
    }

    #[test]
    fn measures_read_and_refuse() {
        let m: Measure = "200 m/s2".parse().unwrap();
        assert_eq!((m.value, m.unit), (200.0, Unit::MetrePerSecondSquared));
        assert_eq!("2g".parse::<Measure>().unwrap().value, 19.6133);
        for bad in [
            "",
            "200",
            "m/s2",
            "-1 g",
            "nan g",
            "2 furlongs",
            "0 N",
            "inf N",
        ] {
            assert!(bad.parse::<Measure>().is_err(), "{bad}");
        }
    }

    #[test]
    fn bands_read_and_refuse() {
        assert_eq!("20..1000".parse::<Band>().unwrap().high(), Hertz(1000.0));
        for bad in [
            "", "20", "20-1000", "1000..20", "-1..20", "a..b", "nan..3", "3..inf", "5..5",
        ] {
            assert!(bad.parse::<Band>().is_err(), "{bad}");
        }
    }
}
