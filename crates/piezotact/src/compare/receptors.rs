//! Which mechanoreceptors the vibration of a group of strokes excites.

use std::fmt;

use serde::Serialize;

use crate::criterion::Outcome;
use crate::feature::{Receptor, StrokeFeatures};
use crate::statistics::{mean, mean_interval};

/// The level of a vibration in the band of a mechanoreceptor re its threshold, over strokes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ReceptorLevel {
    /// The receptor.
    pub receptor: Receptor,
    /// The mean over strokes, dB re threshold.
    pub level_db: f64,
    /// The 95 % confidence interval of the mean (Student), dB; absent for one stroke.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval_db: Option<[f64; 2]>,
    /// Whether the vibration excites it: the whole interval lies above the threshold, below it, or neither.
    pub excited: Outcome,
}

/// The levels of `strokes` for the receptors whose threshold is known as an acceleration at the frequencies of textures: those of
/// Meissner and Pacini. Those of Merkel and Ruffini adapt slowly and are not judged.
///
/// Formula: 10·lg of the power over the squared threshold in the band of the receptor, mean over strokes.
///
/// Source: bands of L. Felicetti's thesis (2024), Table 1; thresholds after S. J. Bolanowski et al. (1988), J. Acoust. Soc. Am. 84(5).
#[must_use]
pub fn receptor_levels(strokes: &[&StrokeFeatures]) -> Vec<ReceptorLevel> {
    let of = |receptor: Receptor, level: fn(&StrokeFeatures) -> Option<f64>| {
        let levels_db: Vec<f64> = strokes.iter().filter_map(|stroke| level(stroke)).collect();
        let interval_db = mean_interval(&levels_db);
        (!levels_db.is_empty()).then(|| ReceptorLevel {
            receptor,
            level_db: mean(&levels_db),
            interval_db,
            excited: match interval_db {
                Some([low, _]) if low > 0.0 => Outcome::Met,
                Some([_, high]) if high < 0.0 => Outcome::NotMet,
                _ => Outcome::NotDecided,
            },
        })
    };
    let both = [
        of(Receptor::Meissner, |stroke| stroke.meissner_level_db),
        of(Receptor::Pacini, |stroke| stroke.pacini_level_db),
    ];
    both.into_iter().flatten().collect()
}

impl fmt::Display for ReceptorLevel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, level_db) = (self.receptor.name(), self.level_db);
        match self.excited {
            Outcome::Met => write!(f, "{name} above its threshold")?,
            Outcome::NotMet => write!(f, "{name} below its threshold")?,
            Outcome::NotDecided => write!(f, "{name} not decided")?,
        }
        match self.interval_db {
            Some([low, high]) => {
                write!(f, " ({level_db:+.1} dB, 95 % {low:+.1} to {high:+.1})")
            }
            None => write!(f, " ({level_db:+.1} dB, one stroke)"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strokes(levels_db: &[f64]) -> Vec<StrokeFeatures> {
        let stroke = |level_db: &f64| StrokeFeatures {
            meissner_level_db: None,
            pacini_level_db: Some(*level_db),
            ..StrokeFeatures::default()
        };
        levels_db.iter().map(stroke).collect()
    }

    #[test]
    fn an_excitation_is_decided_only_by_a_whole_interval() {
        for (levels_db, expected) in [
            (&[3.0, 4.0, 5.0, 4.0][..], Outcome::Met),
            (&[-3.0, -4.0, -5.0, -4.0], Outcome::NotMet),
            // The mean is above the threshold, and its interval is not.
            (&[6.0, -4.0, 5.0, -3.0], Outcome::NotDecided),
            // One stroke says nothing of the next.
            (&[20.0], Outcome::NotDecided),
        ] {
            let strokes = strokes(levels_db);
            let found = receptor_levels(&strokes.iter().collect::<Vec<_>>());
            assert_eq!(found.len(), 1);
            assert_eq!(found[0].excited, expected, "{levels_db:?}");
        }
        assert!(receptor_levels(&[]).is_empty());
    }
}
