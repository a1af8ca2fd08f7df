//! Conditions encoded in file names: `{sample}_F{load:N}_V-{speed:mm/s}mmps_{repeat}`.

use crate::error::ReadError;
use piezotact::recording::RecordingWarning;
use std::path::Path;
use std::str::FromStr;

use piezotact::Warning;
use piezotact::quantity::{Degrees, Newtons, Unit};
use piezotact::recording::{SlidingDirection, Touch};
pub use piezotact::study::Naming;

/// The patterns that are tried when none is given: those of public collections, strict enough to fit nothing else.
const KNOWN: [(&str, &str); 3] = [
    (
        "FabricSlide",
        "Board{board:mm}mm_F{force}_V-{speed:mm/s}mmps_{repeat}",
    ),
    (
        "FabricSlide",
        "{sample}_F{force:#}_V{speed:mm/s}mmps_{repeat:#}",
    ),
    (
        "Cluster Haptic Texture",
        "{sample:#}_{direction:°}_{speed:mm/s}_{load:mN}_{repeat:#}",
    ),
];

/// How names say conditions: text that stands as it is, and fields in braces.
#[derive(Clone, Debug, PartialEq)]
pub struct NamePattern {
    text: String,
    parts: Vec<Part>,
}

#[derive(Clone, Debug, PartialEq)]
enum Part {
    Literal(String),
    Field { name: String, unit: String },
}

impl FromStr for NamePattern {
    type Err = ReadError;

    fn from_str(text: &str) -> Result<Self, ReadError> {
        let wrong = |why: &str| ReadError::Pattern {
            pattern: text.into(),
            why: why.into(),
        };
        let mut parts: Vec<Part> = Vec::new();
        let mut rest = text;
        while !rest.is_empty() {
            let Some(open) = rest.find('{') else {
                parts.push(Part::Literal(rest.into()));
                break;
            };
            if open > 0 {
                parts.push(Part::Literal(rest[..open].into()));
            } else if matches!(parts.last(), Some(Part::Field { .. })) {
                return Err(wrong("two fields with nothing between them"));
            }
            let close = rest.find('}').filter(|close| *close > open);
            let close = close.ok_or_else(|| wrong("a brace that is not closed"))?;
            let (name, unit) = match rest[open + 1..close].split_once(':') {
                Some((name, unit)) => (name.trim(), unit.trim()),
                None => (rest[open + 1..close].trim(), ""),
            };
            if name.is_empty() {
                return Err(wrong("a field without a name"));
            }
            let known = |unit: &str| match name {
                "load" => Unit::parse(unit).0 == Unit::Newton,
                "speed" => Unit::parse(unit).0 == Unit::MetrePerSecond,
                "angle" => ["°", "deg"].contains(&unit),
                _ => true,
            };
            if !unit.is_empty() && !known(unit) {
                return Err(wrong(&format!("`{unit}` is no unit of {name}")));
            }
            let twice = parts
                .iter()
                .any(|part| matches!(part, Part::Field { name: other, .. } if other == name));
            if twice {
                return Err(wrong(&format!("`{name}` twice")));
            }
            parts.push(Part::Field {
                name: name.into(),
                unit: unit.into(),
            });
            rest = &rest[close + 1..];
        }
        if !parts.iter().any(|part| matches!(part, Part::Field { .. })) {
            return Err(wrong("no field"));
        }
        Ok(Self {
            text: text.into(),
            parts,
        })
    }
}

impl NamePattern {
    /// The information in the name of `path`, without folder and extension.
    ///
    /// # Errors
    /// [`ReadError::Content`] when it does not fit, or when a load, speed or angle is none.
    pub fn read(&self, path: &Path) -> Result<Naming, ReadError> {
        let name = stem(path);
        let mut labels = Vec::new();
        if !fits(&self.parts, &name, &mut labels) {
            return Err(ReadError::content(
                path,
                format!("a name like `{}`", self.text),
                format!("`{name}`"),
                self.change_for(&name),
            ));
        }
        let mut naming = Naming::default();
        for (field, unit, text) in labels {
            let number = || {
                let value = text
                    .parse::<f64>()
                    .ok()
                    .filter(|v| v.is_finite() && *v >= 0.0);
                value.ok_or_else(|| {
                    ReadError::content(
                        path,
                        format!("a number for {{{field}}} in `{name}`"),
                        format!("`{text}`"),
                        "rename the file or give another --meta",
                    )
                })
            };
            let condition = &mut naming.condition;
            match field.as_str() {
                "sample" => condition.sample = Some(text.clone()),
                "participant" => condition.participant = Some(text.clone()),
                "touch" => condition.touch = touch(&text),
                "direction" => condition.direction = SlidingDirection::named(&text),
                "load" | "speed" | "angle" if unit.is_empty() => {
                    naming.warnings.push(Warning::from(RecordingWarning::Guessed {
                        what: format!(
                            "{{{field}}} in the name pattern has no unit: `{text}` is kept only as a label (write \
                             {{{field}:{}}})",
                            match field.as_str() {
                                "load" => "N",
                                "speed" => "mm/s",
                                _ => "°",
                            }
                        ),
                    }));
                }
                "load" => condition.load_n = Some(Newtons(number()? * Unit::parse(&unit).1)),
                "speed" => condition.speed_m_s = Some(number()? * Unit::parse(&unit).1),
                "angle" => condition.angle_deg = Some(Degrees(number()?)),
                _ => {}
            }
            naming.labels.insert(field, text);
        }
        Ok(naming)
    }
}

impl NamePattern {
    /// What makes a name fit that does not: the sign before a number as part of the pattern, or another name or pattern.
    fn change_for(&self, name: &str) -> String {
        if let Some((field, word, known)) = self.unknown_word(name) {
            return format!(
                "`{word}` is no {field} ({known}): rename the file, or give the field another name"
            );
        }
        let numbers = self
            .parts
            .iter()
            .enumerate()
            .filter_map(|(at, part)| match part {
                Part::Field { name, unit } if !unit.is_empty() => Some((at, name, unit)),
                _ => None,
            });
        for (at, field, unit) in numbers {
            for sign in ["-", "+"] {
                let mut parts = self.parts.clone();
                let before = match at.checked_sub(1).and_then(|at| parts.get_mut(at)) {
                    Some(Part::Literal(text)) => {
                        text.push_str(sign);
                        text.clone()
                    }
                    _ => {
                        parts.insert(at, Part::Literal(sign.into()));
                        sign.into()
                    }
                };
                if fits(&parts, name, &mut Vec::new()) {
                    return format!(
                        "the name has a `{sign}` before the number for {{{field}}}: write `{before}{{{field}:{unit}}}` in the \
                         pattern"
                    );
                }
            }
        }
        "rename the file or give another --meta".into()
    }
}

/// What a name says by the patterns of public collections, with a warning that names the collection; nothing where
/// none fits.
#[must_use]
pub fn known_naming(path: &Path) -> Naming {
    for (collection, pattern) in KNOWN {
        let Ok(Ok(mut naming)) = pattern
            .parse()
            .map(|pattern: NamePattern| pattern.read(path))
        else {
            continue;
        };
        // A slide goes in one of eight directions: a date does not.
        let direction = naming
            .labels
            .get("direction")
            .map(|text| text.parse::<u32>());
        if !matches!(
            direction,
            None | Some(Ok(0 | 45 | 90 | 135 | 180 | 225 | 270 | 315))
        ) {
            continue;
        }
        if let Some(board) = naming.labels.get("board") {
            naming.condition.sample = Some(format!("Board{board}mm"));
        }
        naming.warnings.push(Warning::from(RecordingWarning::Guessed {
            what: format!(
                "the file name is read with the pattern of the {collection} collection (give another pattern with --meta)"
            ),
        }));
        return naming;
    }
    Naming::default()
}

fn stem(path: &Path) -> String {
    path.file_stem()
        .map(|stem| stem.to_string_lossy().into_owned())
        .unwrap_or_default()
}

fn touch(text: &str) -> Option<Touch> {
    match text.to_lowercase().as_str() {
        "active" => Some(Touch::Active),
        "passive" => Some(Touch::Passive),
        "resting" => Some(Touch::Resting),
        _ => None,
    }
}

impl NamePattern {
    /// The word in `name` that is none of its field's, the field, and the words that are: where the name fits with any word there.
    fn unknown_word(&self, name: &str) -> Option<(&'static str, String, &'static str)> {
        const WORDS: [(&str, &str); 2] = [
            (
                "direction",
                "proximal, distal, transversal, circular, or an angle",
            ),
            ("touch", "active or passive"),
        ];
        WORDS.into_iter().find_map(|(field, known)| {
            let mut parts = self.parts.clone();
            let named = parts.iter_mut().find_map(|part| match part {
                Part::Field { name, .. } if name == field => Some(name),
                _ => None,
            })?;
            named.insert(0, '?');
            let wanted = named.clone();
            let mut found = Vec::new();
            let fits = fits(&parts, name, &mut found);
            let (_, _, word) = found.into_iter().find(|(name, ..)| *name == wanted)?;
            fits.then_some((field, word, known))
        })
    }
}

/// Whether `text` fits `parts` from the first on; what the fields hold is added to `found`. A field is as short as
/// the literal after it allows, and one with a unit holds a number.
fn fits(parts: &[Part], text: &str, found: &mut Vec<(String, String, String)>) -> bool {
    let Some((part, rest)) = parts.split_first() else {
        return text.is_empty();
    };
    match part {
        Part::Literal(literal) => text
            .strip_prefix(literal.as_str())
            .is_some_and(|text| fits(rest, text, found)),
        Part::Field { name, unit } => {
            let ends: Vec<usize> = text
                .char_indices()
                .map(|(i, c)| i + c.len_utf8())
                .filter(|end| unit.is_empty() || is_number(&text[..*end]))
                // A kind of touch is one of three words.
                .filter(|end| name != "touch" || touch(&text[..*end]).is_some())
                // A direction is one of four words, or an angle.
                .filter(|end| {
                    let text = &text[..*end];
                    name != "direction"
                        || SlidingDirection::named(text).is_some()
                        || is_number(text)
                })
                .collect();
            for end in ends {
                let before = found.len();
                found.push((name.clone(), unit.clone(), text[..end].into()));
                if fits(rest, &text[end..], found) {
                    return true;
                }
                found.truncate(before);
            }
            false
        }
    }
}

fn is_number(text: &str) -> bool {
    text.bytes().all(|b| b.is_ascii_digit() || b == b'.') && text.parse::<f64>().is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_that_is_no_direction_is_named() {
        let pattern: NamePattern = "{sample}_{speed:mm/s}mmps_{direction}".parse().unwrap();
        let said = pattern.read(Path::new("P80_20mmps_dist.csv")).unwrap_err();
        let said = said.to_string();
        assert!(
            said.contains("`dist` is no direction (proximal, distal"),
            "{said}"
        );
        let said = pattern.read(Path::new("P80-20mmps-dist.csv")).unwrap_err();
        assert!(said.to_string().contains("rename the file or"), "{said}");
    }

    #[test]
    fn names_say_conditions() {
        let pattern: NamePattern = "{sample}_F{load:mN}_V-{speed:mm/s}mmps_{repeat}"
            .parse()
            .unwrap();
        let naming = pattern
            .read(Path::new("x/Board_2mm_F135_V-10mmps_0.csv"))
            .unwrap();
        assert_eq!(naming.condition.sample.as_deref(), Some("Board_2mm"));
        assert!((naming.condition.load_n.unwrap().0 - 0.135).abs() < 1e-12);
        assert!((naming.condition.speed_m_s.unwrap() - 0.01).abs() < 1e-12);
        assert_eq!(naming.labels["repeat"], "0");
        assert!(pattern.read(Path::new("x.csv")).is_err());
        let touched: NamePattern = "{sample}_{touch}".parse().unwrap();
        assert!(touched.read(Path::new("P1_S4_active_30mmps")).is_err());
        let naming = touched.read(Path::new("P1_S4_Active.csv")).unwrap();
        assert_eq!(naming.condition.sample.as_deref(), Some("P1_S4"));
        assert_eq!(naming.condition.touch, Some(Touch::Active));
        let slid: NamePattern = "{sample}_{direction}_{repeat}".parse().unwrap();
        let naming = slid.read(Path::new("P1_S4_Transversal_2.csv")).unwrap();
        assert_eq!(naming.condition.sample.as_deref(), Some("P1_S4"));
        assert_eq!(
            naming.condition.direction,
            Some(SlidingDirection::Transversal)
        );
        let angle = slid.read(Path::new("S4_45_2.csv")).unwrap();
        assert_eq!(angle.condition.direction, None);
        assert_eq!(angle.labels["direction"], "45");
        assert!(slid.read(Path::new("S4_sideways_2.csv")).is_err());
        let loose: NamePattern = "{sample}_F{load}".parse().unwrap();
        let naming = loose.read(Path::new("S1_F135")).unwrap();
        assert_eq!((naming.condition.load_n, naming.warnings.len()), (None, 1));
    }

    #[test]
    fn public_collections_are_known() {
        let fabric = known_naming(Path::new("Board2mm_F135_V-5mmps_0.csv"));
        assert_eq!(fabric.condition.sample.as_deref(), Some("Board2mm"));
        assert_eq!(fabric.condition.speed_m_s, Some(0.005));
        assert_eq!(fabric.condition.load_n, None);
        let fabric = known_naming(Path::new("BeigeCotton_F120_V10mmps_0.csv"));
        assert_eq!(fabric.condition.sample.as_deref(), Some("BeigeCotton"));
        assert_eq!(fabric.condition.speed_m_s, Some(0.01));
        assert_eq!((fabric.condition.load_n, fabric.warnings.len()), (None, 1));
        assert_eq!(
            known_naming(Path::new("BeigeCotton_V10mmps_0.csv")),
            Naming::default()
        );
        let cluster = known_naming(Path::new("0_135_40_500_1.csv"));
        assert_eq!(cluster.condition.load_n, Some(Newtons(0.5)));
        assert_eq!(cluster.condition.speed_m_s, Some(0.04));
        assert_eq!(cluster.labels["direction"], "135");
        assert_eq!(cluster.warnings.len(), 1);
        let date = known_naming(Path::new("2024_05_13_10_30.csv"));
        assert_eq!(date, Naming::default());
        assert_eq!(known_naming(Path::new("text3_v1.wav")), Naming::default());
        assert_eq!(known_naming(Path::new("")), Naming::default());
    }

    #[test]
    fn a_sign_before_a_number_is_named_with_the_change() {
        let why = |pattern: &str, name: &str| {
            let pattern: NamePattern = pattern.parse().unwrap();
            pattern.read(Path::new(name)).unwrap_err().to_string()
        };
        let said = why(
            "{sample}_V{speed:mm/s}mmps_{repeat}",
            "Board_V-10mmps_0.csv",
        );
        assert!(
            said.contains("write `_V-{speed:mm/s}` in the pattern"),
            "{said}"
        );
        let said = why("{speed:mm/s}_{sample}", "-10_S1.csv");
        assert!(said.contains("write `-{speed:mm/s}`"), "{said}");
        let said = why("{sample}_V{speed:mm/s}", "S1.csv");
        assert!(said.contains("rename the file"), "{said}");
    }

    #[test]
    fn patterns_that_cannot_be_say_why() {
        for (bad, why) in [
            ("plain", "no field"),
            ("{sample", "not closed"),
            ("{sample}{speed:mm/s}", "nothing between"),
            ("{speed:N}", "no unit of speed"),
            ("{}", "without a name"),
            ("{a}_{a}", "twice"),
        ] {
            let error = bad.parse::<NamePattern>().unwrap_err().to_string();
            assert!(error.contains(why), "{bad}: {error}");
        }
    }
}
