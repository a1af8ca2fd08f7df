//! The duplex theory of texture perception: coarse textures are perceived by their shape, fine ones by the vibration while the finger slides.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::SurfaceSample;

/// The largest spatial period of a fine texture and the smallest of a coarse one, m.
const FINE_M: f64 = 100e-6;
const COARSE_M: f64 = 200e-6;

/// The sense by which a texture is perceived.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum TextureClass {
    /// Its period is above 200 µm: the spatial sense, also without sliding.
    Coarse,
    /// Its period is between 100 and 200 µm: the theory decides for neither.
    Between,
    /// Its period is below 100 µm: the vibration sense, only while sliding.
    Fine,
}

impl TextureClass {
    /// The class of a texture with the spatial period `period_m`, m.
    ///
    /// Source: M. Hollins and S. R. Risner (2000), Percept. Psychophys. 62(4); L. Felicetti's thesis (2024), section 1.2.4.
    #[must_use]
    pub fn of_period(period_m: f64) -> Self {
        // What is read in µm is not exact in m.
        let rounding = 1e-9;
        if period_m > COARSE_M * (1.0 + rounding) {
            Self::Coarse
        } else if period_m < FINE_M * (1.0 - rounding) {
            Self::Fine
        } else {
            Self::Between
        }
    }
}

impl fmt::Display for TextureClass {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Coarse => "coarse (spatial sense)",
            Self::Between => "between coarse and fine",
            Self::Fine => "fine (vibration sense)",
        })
    }
}

/// What stands for the spatial period of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum PeriodBasis {
    /// The period of its dots.
    Period,
    /// The mean particle of the sandpaper that it was moulded from.
    Particle,
}

/// The class of a sample, with the length that decides.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Duplex {
    /// The class.
    pub class: TextureClass,
    /// The length, m.
    pub length_m: f64,
    /// What that length is.
    pub basis: PeriodBasis,
}

impl fmt::Display for Duplex {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let length_um = crate::number::digits(self.length_m * 1e6);
        let basis = match self.basis {
            PeriodBasis::Period => "spatial period",
            PeriodBasis::Particle => "mean particle of the sandpaper",
        };
        write!(f, "{}: {basis} {length_um} µm", self.class)
    }
}

impl SurfaceSample {
    /// The class of the duplex theory: by the spatial period where there is one, else by the mean particle of the sandpaper; `None`
    /// where neither is known.
    ///
    /// Source: [`TextureClass::of_period`]; [`mean_particle_m`].
    #[must_use]
    pub fn duplex(&self) -> Option<Duplex> {
        let dots = || Some(self.dot_diameter_m? + self.dot_gap_m?);
        let period = self.wavelength_m.or_else(dots);
        let known = period.map(|length_m| (length_m, PeriodBasis::Period));
        let (length_m, basis) = known.or_else(|| {
            let length_m = mean_particle_m(self.grit.as_deref()?)?;
            Some((length_m, PeriodBasis::Particle))
        })?;
        Some(Duplex {
            class: TextureClass::of_period(length_m),
            length_m,
            basis,
        })
    }
}

/// Grain sizes: the number after the P, and the mean particle in µm.
const GRAINS: [(u32, f64); 28] = [
    (12, 1815.0),
    (16, 1324.0),
    (20, 1000.0),
    (24, 764.0),
    (30, 642.0),
    (36, 538.0),
    (40, 425.0),
    (50, 336.0),
    (60, 269.0),
    (80, 201.0),
    (100, 162.0),
    (120, 125.0),
    (150, 100.0),
    (180, 82.0),
    (220, 68.0),
    (240, 58.5),
    (280, 52.2),
    (320, 46.2),
    (360, 40.5),
    (400, 35.0),
    (500, 30.2),
    (600, 25.8),
    (800, 21.8),
    (1000, 18.3),
    (1200, 15.3),
    (1500, 12.6),
    (2000, 10.3),
    (2500, 8.4),
];

/// The mean particle of sandpaper of the grain size `grit`, such as "P120", m. Sizes between those of the table are interpolated
/// (logarithms of both), finer ones extrapolated by size ∝ 1/number; `None` for what is no such size.
///
/// Source: the grain sizes of coated abrasives P12 to P2500 after FEPA 43 and ISO 6344.
#[must_use]
pub fn mean_particle_m(grit: &str) -> Option<f64> {
    let number = grit.trim().strip_prefix(['P', 'p'])?.parse::<u32>().ok()?;
    let (first, last) = (GRAINS[0], GRAINS[GRAINS.len() - 1]);
    if number < first.0 {
        return None;
    }
    let at = f64::from(number);
    if number >= last.0 {
        return Some(last.1 * f64::from(last.0) / at * 1e-6);
    }
    let above = GRAINS.partition_point(|(known, _)| *known <= number);
    let [(low, coarse), (high, fine)] = [GRAINS[above - 1], GRAINS[above]];
    let [low, high] = [low, high].map(|n| f64::from(n).ln());
    let share = (at.ln() - low) / (high - low);
    Some((coarse.ln() + share * (fine / coarse).ln()).exp() * 1e-6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_class_follows_from_the_period() {
        for (um, class) in [
            (201.0, TextureClass::Coarse),
            (200.0, TextureClass::Between),
            (100.0, TextureClass::Between),
            (99.0, TextureClass::Fine),
        ] {
            assert_eq!(TextureClass::of_period(um * 1e-6), class, "{um}");
        }
    }

    #[test]
    fn grains_are_those_of_the_table_and_fall_between_them() {
        let um = |grit| mean_particle_m(grit).map(|m| (m * 1e7).round() / 10.0);
        assert_eq!(um("P40"), Some(425.0));
        assert_eq!(um("p240"), Some(58.5));
        let between = um("P70").unwrap();
        assert!(between > 201.0 && between < 269.0, "{between}");
        assert_eq!([um("P2000"), um("P2500")], [Some(10.3), Some(8.4)]);
        // No such size in the table: 5 to 6 µm by its makers.
        assert_eq!(um("P4000"), Some(5.3));
        for none in ["", "P", "120", "P8", "fine", "P-40"] {
            assert_eq!(um(none), None, "{none}");
        }
    }
}
