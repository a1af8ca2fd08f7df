//! Units of force.

use std::fmt;
use std::str::FromStr;

/// Standard gravity, m/s²: a gram or kilogram on a scale is this times its mass.
const GRAVITY_M_S2: f64 = 9.806_65;

/// The unit in which a device states forces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ForceUnit {
    /// N.
    Newton,
    /// mN.
    Millinewton,
    /// cN.
    Centinewton,
    /// g of a scale: 9.80665 mN.
    Gram,
    /// kg of a scale: 9.80665 N.
    Kilogram,
}

impl ForceUnit {
    /// All of them.
    const ALL: [Self; 5] = [
        Self::Newton,
        Self::Millinewton,
        Self::Centinewton,
        Self::Gram,
        Self::Kilogram,
    ];

    /// How many newtons it is.
    #[must_use]
    pub fn newtons(self) -> f64 {
        match self {
            Self::Newton => 1.0,
            Self::Millinewton => 1e-3,
            Self::Centinewton => 1e-2,
            Self::Gram => 1e-3 * GRAVITY_M_S2,
            Self::Kilogram => GRAVITY_M_S2,
        }
    }
}

impl fmt::Display for ForceUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Newton => "N",
            Self::Millinewton => "mN",
            Self::Centinewton => "cN",
            Self::Gram => "g",
            Self::Kilogram => "kg",
        })
    }
}

/// A text that names no unit of force.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected a unit of force: N, mN, cN, g or kg")]
pub struct NoForceUnit;

impl FromStr for ForceUnit {
    type Err = NoForceUnit;

    fn from_str(text: &str) -> Result<Self, NoForceUnit> {
        let found = Self::ALL.into_iter().find(|unit| unit.to_string() == text);
        match text {
            "gf" => Ok(Self::Gram),
            "kgf" => Ok(Self::Kilogram),
            _ => found.ok_or(NoForceUnit),
        }
    }
}
