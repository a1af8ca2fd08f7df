//! Which mechanoreceptors the vibration of a group of strokes excites.

use std::collections::BTreeMap;
use std::fmt;

use serde::Serialize;

use crate::criterion::Outcome;
use crate::feature::{Analysis, Receptor, StrokeFeatures};
use crate::number::plus;
use crate::quantity::{Band, Hertz, Unit};
use crate::recording::Condition;
use crate::statistics::{mean, mean_interval};

/// What the interval of a level is over: what was repeated independently.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum LevelUnit {
    /// The strokes of one recording, which share its placement.
    Strokes,
    /// The recordings of one participant, each the mean of its strokes.
    Recordings,
    /// Participants, each the mean of their recordings.
    Participants,
}

impl LevelUnit {
    /// So many of them, in words.
    fn counted(self, count: usize) -> String {
        match self {
            Self::Strokes => format!("{count} strokes of one recording, so of one placement"),
            Self::Recordings => format!("{count} recordings"),
            Self::Participants => format!("{count} participants"),
        }
    }
}

/// The level of a vibration in the band of a mechanoreceptor re its threshold.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ReceptorLevel {
    /// The receptor.
    pub receptor: Receptor,
    /// The mean over units, dB re threshold; absent where the recordings do not hold enough of its band.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level_db: Option<f64>,
    /// The 95 % confidence interval of the mean (Student), dB; absent for one unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval_db: Option<[f64; 2]>,
    /// What the interval is over.
    pub over: LevelUnit,
    /// How many of them there are.
    pub units: usize,
    /// The part of the band of the receptor that the level is over, Hz. Below it are the gesture and what short strokes do not resolve.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub band_hz: Option<Band>,
    /// The level with all that the unfiltered recordings hold in the rest of the band, gesture or vibration, and the upper end of its
    /// interval, dB: the level of the whole band is no higher. Absent where all of it is covered.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_most_db: Option<[f64; 2]>,
    /// The highest frequency of the recordings, Hz, where they do not hold enough of the band.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ends_at_hz: Option<f64>,
    /// Whether the level lies above the threshold: the whole interval does; or below it, with what the rest of the band may hold; or
    /// neither.
    pub excited: Outcome,
}

/// The levels of the strokes of `members`, each a recording with its condition, for the receptors whose threshold is known as an
/// acceleration at the frequencies of textures: those of Meissner and Pacini. Those of Merkel and Ruffini adapt slowly and are not
/// judged. Empty for what is no acceleration.
///
/// Strokes of one recording share its placement: the interval is over participants where there are several, else over recordings, and over
/// strokes only where there is one recording.
///
/// Formula: 10·lg of the power over the squared threshold in the band of the receptor; mean over the strokes of a recording, over the
/// recordings of a participant, and over participants.
///
/// Source: bands of L. Felicetti's thesis (2024), Table 1; thresholds after S. J. Bolanowski et al. (1988), J. Acoust. Soc. Am. 84(5);
/// docs/decisions/strokes.md for units and the band.
#[must_use]
pub fn receptor_levels(members: &[(&Analysis, &Condition)]) -> Vec<ReceptorLevel> {
    let highest = |a: &Analysis| a.psd.resolution_hz * a.psd.mean.len().saturating_sub(1) as f64;
    let ends_at_hz = members.iter().map(|(a, _)| highest(a));
    let ends_at_hz = ends_at_hz.fold(f64::INFINITY, f64::min);
    let acceleration = |(a, _): &(&Analysis, &Condition)| a.unit == Unit::MetrePerSecondSquared;
    if members.is_empty() || !members.iter().all(acceleration) {
        return Vec::new();
    }
    let strokes: Vec<(&[StrokeFeatures], Option<&str>)> = members
        .iter()
        .map(|(a, c)| (a.strokes.as_slice(), c.participant.as_deref()))
        .collect();
    [Receptor::Meissner, Receptor::Pacini]
        .map(|receptor| level_of(receptor, &strokes, ends_at_hz))
        .into()
}

/// The level of one receptor in recordings, each its strokes and its participant.
fn level_of(
    receptor: Receptor,
    recordings: &[(&[StrokeFeatures], Option<&str>)],
    ends_at_hz: f64,
) -> ReceptorLevel {
    let level: fn(&StrokeFeatures) -> Option<f64> = match receptor {
        Receptor::Meissner => |stroke| stroke.meissner_level_db,
        _ => |stroke| stroke.pacini_level_db,
    };
    let at_most: fn(&StrokeFeatures) -> Option<f64> = match receptor {
        Receptor::Meissner => |stroke| stroke.meissner_level_at_most_db,
        _ => |_| None,
    };
    let (over, levels_db) = by_unit(recordings, level);
    let (_, highest_db) = by_unit(recordings, |stroke| {
        at_most(stroke).or_else(|| level(stroke))
    });
    let interval_db = mean_interval(&levels_db);
    let upper_db = mean_interval(&highest_db).map_or(f64::INFINITY, |[_, high]| high);
    let all = || recordings.iter().flat_map(|(strokes, _)| *strokes);
    let covered = || {
        let own = receptor.band().ok()?;
        let from = all().filter_map(|stroke| stroke.meissner_from_hz);
        match receptor {
            Receptor::Meissner => Band::new(Hertz(from.fold(0.0, f64::max)), own.high()).ok(),
            _ => Some(own),
        }
    };
    let measured = !levels_db.is_empty();
    ReceptorLevel {
        receptor,
        level_db: measured.then(|| mean(&levels_db)),
        interval_db,
        over,
        units: levels_db.len(),
        band_hz: covered().filter(|_| measured),
        at_most_db: (all().any(|stroke| at_most(stroke).is_some()) && upper_db.is_finite())
            .then(|| [mean(&highest_db), upper_db]),
        ends_at_hz: (!measured).then_some(ends_at_hz),
        excited: match interval_db {
            Some([low, _]) if low > 0.0 => Outcome::Met,
            Some([_, high]) if high < 0.0 && upper_db < 0.0 => Outcome::NotMet,
            _ => Outcome::NotDecided,
        },
    }
}

/// The units of recordings, and the mean of `value` for each of them.
fn by_unit(
    recordings: &[(&[StrokeFeatures], Option<&str>)],
    value: impl Fn(&StrokeFeatures) -> Option<f64>,
) -> (LevelUnit, Vec<f64>) {
    let each = recordings.iter().map(|(strokes, participant)| {
        let levels: Vec<f64> = strokes.iter().filter_map(&value).collect();
        (levels, *participant)
    });
    let each: Vec<(Vec<f64>, Option<&str>)> = each.filter(|(l, _)| !l.is_empty()).collect();
    let mut participants: BTreeMap<Option<&str>, Vec<f64>> = BTreeMap::new();
    for (levels, participant) in &each {
        participants
            .entry(*participant)
            .or_default()
            .push(mean(levels));
    }
    // Where it is not known whose a recording is, all may be one person's.
    let people = if participants.contains_key(&None) {
        1
    } else {
        participants.len()
    };
    match (people, each.as_slice()) {
        (_, [(strokes, _)]) => (LevelUnit::Strokes, strokes.clone()),
        (0 | 1, _) => (
            LevelUnit::Recordings,
            participants.into_values().flatten().collect(),
        ),
        _ => (
            LevelUnit::Participants,
            participants.values().map(|levels| mean(levels)).collect(),
        ),
    }
}

/// A frequency in Hz with one decimal at most.
fn hz(value: f64) -> f64 {
    (10.0 * value).round() / 10.0
}

impl fmt::Display for ReceptorLevel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = self.receptor.name();
        let own = self.receptor.band().ok();
        let Some(level_db) = self.level_db else {
            let ends_at = self.ends_at_hz.unwrap_or_default();
            let needed_hz = own.map_or(0.0, |band| band.high().0);
            return write!(
                f,
                "{name} not computed: the recordings end at {} Hz or the strokes are too short, and its band reaches to {} Hz",
                hz(ends_at),
                hz(needed_hz)
            );
        };
        match self.excited {
            Outcome::Met => write!(f, "{name} above its threshold")?,
            Outcome::NotMet => write!(f, "{name} below its threshold")?,
            Outcome::NotDecided => write!(f, "{name} not decided")?,
        }
        write!(f, " ({} dB", plus(level_db, 1))?;
        let part = self.band_hz.filter(|band| Some(*band) != own);
        if let Some(part) = part {
            write!(f, " at {} to {} Hz", hz(part.low().0), hz(part.high().0))?;
        }
        match self.interval_db {
            Some([low, high]) => write!(
                f,
                ", 95 % {} to {} over {}",
                plus(low, 1),
                plus(high, 1),
                self.over.counted(self.units)
            )?,
            None => write!(f, ", one stroke")?,
        }
        if let (Some([at_most_db, upper_db]), Some(part)) = (self.at_most_db, part)
            && self.excited != Outcome::Met
            && self.interval_db.is_some_and(|[_, high]| high < 0.0)
        {
            let low_hz = own.map_or(0.0, |own| own.low().0);
            write!(
                f,
                "; with all that was recorded at {} to {} Hz, gesture or vibration, {} dB or less (95 % up to {})",
                hz(low_hz),
                hz(part.low().0),
                plus(at_most_db, 1),
                plus(upper_db, 1)
            )?;
        }
        write!(f, ")")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strokes(levels_db: &[f64]) -> Vec<StrokeFeatures> {
        let stroke = |level_db: &f64| StrokeFeatures {
            pacini_level_db: Some(*level_db),
            ..StrokeFeatures::default()
        };
        levels_db.iter().map(stroke).collect()
    }

    fn pacini(recordings: &[(&[StrokeFeatures], Option<&str>)]) -> ReceptorLevel {
        level_of(Receptor::Pacini, recordings, 2000.0)
    }

    #[test]
    fn a_level_is_decided_only_by_a_whole_interval() {
        for (levels_db, expected) in [
            (&[3.0, 4.0, 5.0, 4.0][..], Outcome::Met),
            (&[-3.0, -4.0, -5.0, -4.0], Outcome::NotMet),
            // The mean is above the threshold, and its interval is not.
            (&[6.0, -4.0, 5.0, -3.0], Outcome::NotDecided),
            // One stroke says nothing of the next.
            (&[20.0], Outcome::NotDecided),
        ] {
            let found = pacini(&[(&strokes(levels_db), None)]);
            assert_eq!(found.excited, expected, "{levels_db:?}");
            assert_eq!(found.over, LevelUnit::Strokes);
            let said = found.to_string();
            assert!(
                levels_db.len() == 1 || said.contains("one placement"),
                "{said}"
            );
        }
        assert!(receptor_levels(&[]).is_empty());
    }

    /// Three placements 5 dB apart, each with five strokes that hardly differ: fifteen strokes taken for independent were "above".
    #[test]
    fn the_unit_of_several_recordings_is_the_recording() {
        let placements = [3.8, 1.9, -1.4]
            .map(|level: f64| strokes(&[-0.4, -0.2, 0.0, 0.2, 0.4].map(|more: f64| level + more)));
        let together: Vec<StrokeFeatures> = placements.concat();
        assert_eq!(pacini(&[(&together, None)]).excited, Outcome::Met);
        let recordings = placements
            .each_ref()
            .map(|own| (own.as_slice(), Some("P1")));
        let found = pacini(&recordings);
        assert_eq!(found.excited, Outcome::NotDecided, "{found:?}");
        assert_eq!((found.over, found.units), (LevelUnit::Recordings, 3));
        assert!(found.to_string().contains("over 3 recordings"), "{found}");
        // Of two participants with three recordings each, the participants are the units.
        let near: Vec<Vec<StrokeFeatures>> = [3.0, 3.1, 3.2, 0.3, 0.4, 0.5]
            .map(|level: f64| strokes(&[level - 0.1, level + 0.1]))
            .into();
        let people = near.iter().enumerate();
        let people: Vec<(&[StrokeFeatures], Option<&str>)> = people
            .map(|(i, own)| (own.as_slice(), Some(["P1", "P2"][i / 3])))
            .collect();
        let found = pacini(&people);
        assert_eq!((found.over, found.units), (LevelUnit::Participants, 2));
        assert_eq!(found.excited, Outcome::NotDecided, "{found:?}");
        let one: Vec<_> = people.iter().map(|(own, _)| (*own, Some("P1"))).collect();
        assert_eq!(pacini(&one).excited, Outcome::Met);
    }

    /// What is not covered may hold the power that changes "below".
    #[test]
    fn below_is_said_where_the_rest_of_the_band_cannot_change_it() {
        let strokes = |at_most_db: f64| -> Vec<StrokeFeatures> {
            let stroke = |level_db: f64| StrokeFeatures {
                meissner_level_db: Some(level_db),
                meissner_from_hz: Some(7.5),
                meissner_level_at_most_db: Some(at_most_db),
                ..StrokeFeatures::default()
            };
            [-9.0, -10.0, -11.0].map(stroke).into()
        };
        let found =
            |at_most_db: f64| level_of(Receptor::Meissner, &[(&strokes(at_most_db), None)], 2000.0);
        assert_eq!(found(-3.0).excited, Outcome::NotMet);
        let open = found(4.0);
        assert_eq!(open.excited, Outcome::NotDecided);
        let said = open.to_string();
        assert!(
            said.contains("at 7.5 to 40 Hz") && said.contains("3 to 7.5 Hz, gesture or vibration"),
            "{said}"
        );
    }
}
