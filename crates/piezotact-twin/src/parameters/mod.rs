//! The parameters of the twin: read from a documented file that gives each with its range and its origin.

mod sections;

use crate::error::{TwinError, wrong};
use std::collections::BTreeMap;

use serde::Deserialize;
use serde::de::DeserializeOwned;
use toml::{Table, Value};

pub use sections::*;

use super::surface::Relief;

/// The file that comes with the program.
pub const PARAMETERS: &str = include_str!("../../parameters.toml");

/// A list of numbers is no longer than this.
const MOST_VALUES: usize = 12;
/// The possible origins of a parameter.
const ORIGINS: [&str; 4] = ["thesis", "source", "chosen", "measured"];

/// All parameters of the twin, in SI units. The meaning, range and origin of each are given in the file
/// `crates/piezotact-twin/parameters.toml`, which `piezotact twin parameters` prints.
#[derive(Clone, Debug, PartialEq)]
pub struct TwinParameters {
    /// The variation between people.
    pub person: PersonParameters,
    /// A finger as a chain of masses and springs.
    pub finger: FingerParameters,
    /// The variation between placements of a finger.
    pub placement: PlacementParameters,
    /// How a hand moves and presses.
    pub hand: HandParameters,
    /// The vibration of a sliding finger.
    pub texture: TextureModel,
    /// The friction of a fingertip.
    pub friction: FrictionModel,
    /// The heights of the samples.
    pub relief: ReliefParameters,
    /// The stiffness and damping that hold the fingertip.
    pub drag: DragParameters,
    /// The sensor on the nail.
    pub accelerometer: AccelerometerParameters,
    pub force_cell: ForceCellParameters,
    /// The piezoelectric cells of the tribometer.
    pub piezo_cells: PiezoCellParameters,
    pub triboair: TriboAirParameters,
    /// The sound output and the actuator.
    pub output: OutputParameters,
    /// The membrane under the finger.
    pub actuator: ActuatorParameters,
    pub shaker: ShakerParameters,
    pub eeg: EegParameters,
    samples: BTreeMap<String, Sample>,
    /// The changes made by a laboratory's own file, one line each.
    changes: Vec<String>,
}

/// What a sample is made of.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum SampleKind {
    /// Randomly rough.
    Isotropic,
    /// Dots in a hexagonal pattern.
    Dots,
    /// Parallel ridges.
    Ridges,
}

/// A sample: its relief, and the vibration and friction of a finger that slides over it.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    pub name: String,
    pub relief: Relief,
    /// The length of its plate, m.
    pub plate_m: f64,
    /// The rms acceleration of the nail at 30 mm/s and 0.2 N, m/s².
    pub rms_m_s2: f64,
    /// The share of its power in the peaks of the fingerprint, 0–1.
    pub ridge_share: f64,
    /// The share of its power in the texture's own peaks, 0–1.
    pub comb_share: f64,
    /// The wavelength of the texture's own peaks, m; none for a random surface.
    pub comb_wavelength_m: Option<f64>,
    /// The friction coefficient at 0.2 N while sliding.
    pub friction: f64,
    /// Static over kinetic friction.
    pub static_ratio: f64,
    /// The standard deviation of the log level from person to person, for this sample.
    pub loudness_spread: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SampleRow {
    kind: SampleKind,
    ra_m: Option<f64>,
    grain_m: Option<f64>,
    correlation_per_grain: Option<f64>,
    dot_height_m: Option<f64>,
    dot_diameter_m: Option<f64>,
    wavelength_m: Option<f64>,
    depth_m: Option<f64>,
    rms_m_s2: Option<f64>,
    #[serde(default)]
    ridge_share: f64,
    #[serde(default)]
    comb_share: f64,
    common_peak_hz: Option<f64>,
    friction: Option<f64>,
    static_ratio: Option<f64>,
    loudness_spread: Option<f64>,
}

/// The plates' lengths, m (*thesis* 2.2: 50 mm for isotropic samples, 60 mm for periodic ones; *chosen* for ridges).
fn plate_m(kind: SampleKind) -> f64 {
    match kind {
        SampleKind::Isotropic => 0.05,
        SampleKind::Dots | SampleKind::Ridges => 0.06,
    }
}

const SEE_FILE: &str = "see `piezotact twin parameters` for the format";

impl TwinParameters {
    /// The numbers that come with the program.
    #[must_use]
    pub fn built_in() -> Self {
        // A test reads the same text.
        Self::with(&Table::new()).unwrap_or_else(|error| unreachable!("the built-in file: {error}"))
    }

    /// The built-in numbers with the changes that `text`, a laboratory's own file, states.
    ///
    /// # Errors
    /// [`TwinError`] naming the parameter, what is possible and what was found.
    pub fn changed_by(text: &str) -> Result<Self, TwinError> {
        let own: Table = text.parse().map_err(|error: toml::de::Error| {
            wrong("the parameter file", "TOML", error.message(), SEE_FILE)
        })?;
        Self::with(&own)
    }

    fn with(own: &Table) -> Result<Self, TwinError> {
        let mut all: Table = PARAMETERS.parse().map_err(|error: toml::de::Error| {
            wrong("the built-in file", "TOML", error.message(), "report this")
        })?;
        let mut changes = Vec::new();
        merge(&mut all, own, "", &mut changes)?;
        let samples = section(&mut all, "samples")?;
        let parameters = Self {
            person: read(&mut all, "person")?,
            finger: read(&mut all, "finger")?,
            placement: read(&mut all, "placement")?,
            hand: read(&mut all, "hand")?,
            texture: read(&mut all, "texture")?,
            friction: read(&mut all, "friction")?,
            relief: read(&mut all, "relief")?,
            drag: read(&mut all, "drag")?,
            accelerometer: read(&mut all, "accelerometer")?,
            force_cell: read(&mut all, "force_cell")?,
            piezo_cells: read(&mut all, "piezo_cells")?,
            triboair: read(&mut all, "triboair")?,
            output: read(&mut all, "output")?,
            actuator: read(&mut all, "actuator")?,
            shaker: read(&mut all, "shaker")?,
            eeg: read(&mut all, "eeg")?,
            samples: BTreeMap::new(),
            changes,
        };
        parameters.check_order()?;
        let mut known = BTreeMap::new();
        for (name, row) in samples {
            known.insert(name.clone(), parameters.sample_of(&name, row)?);
        }
        Ok(Self {
            samples: known,
            ..parameters
        })
    }

    /// The sample called `name`.
    ///
    /// # Errors
    /// [`TwinError::Sample`] listing those there are.
    pub fn sample(&self, name: &str) -> Result<&Sample, TwinError> {
        self.samples.get(name).ok_or_else(|| TwinError::Sample {
            known: self.sample_names().join(", "),
            found: name.into(),
        })
    }

    /// The names of all samples: S1, S2 … before the others of a letter.
    #[must_use]
    pub fn sample_names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.samples.keys().map(String::as_str).collect();
        let key = |name: &str| {
            let digits = name.trim_start_matches(|c: char| !c.is_ascii_digit());
            (
                name[..name.len() - digits.len()].to_owned(),
                digits.parse::<u64>().unwrap_or(u64::MAX),
            )
        };
        names.sort_by_key(|name| key(name));
        names
    }

    /// What a laboratory's own file changed, one line each; empty for the built-in numbers.
    #[must_use]
    pub fn changes(&self) -> &[String] {
        &self.changes
    }

    /// One step of a recording's provenance: the parameters of the twin.
    #[must_use]
    pub fn provenance(&self) -> String {
        if self.changes.is_empty() {
            "twin parameters: built-in".into()
        } else {
            format!("twin parameters changed: {}", self.changes.join("; "))
        }
    }

    /// Refuses a least that is above its most.
    fn check_order(&self) -> Result<(), TwinError> {
        let (person, hand, shaker) = (&self.person, &self.hand, &self.shaker);
        let muscle = &self.eeg.muscle;
        for (least, least_name, most, most_name) in [
            (
                person.least_ridge_m,
                "person.least_ridge_m",
                person.most_ridge_m,
                "person.most_ridge_m",
            ),
            (
                hand.transient_least_m_s2,
                "hand.transient_least_m_s2",
                hand.transient_most_m_s2,
                "hand.transient_most_m_s2",
            ),
            (
                hand.gesture_least_m_s2,
                "hand.gesture_least_m_s2",
                hand.gesture_most_m_s2,
                "hand.gesture_most_m_s2",
            ),
            (
                hand.least_free_speed_m_s,
                "hand.least_free_speed_m_s",
                hand.most_free_speed_m_s,
                "hand.most_free_speed_m_s",
            ),
            (
                shaker.least_drift_n,
                "shaker.least_drift_n",
                shaker.most_drift_n,
                "shaker.most_drift_n",
            ),
            (
                muscle.least_hz,
                "eeg.muscle.least_hz",
                muscle.most_hz,
                "eeg.muscle.most_hz",
            ),
        ] {
            if least > most {
                let expected = format!("at most {most_name} = {most}");
                return Err(wrong(least_name, expected, least, "correct one of them"));
            }
        }
        Ok(())
    }

    fn sample_of(&self, name: &str, row: Value) -> Result<Sample, TwinError> {
        let at = |field: &str| format!("samples.{name}.{field}");
        let row: SampleRow = row.try_into().map_err(|error: toml::de::Error| {
            wrong(
                &format!("samples.{name}"),
                "the numbers of a sample",
                error.message(),
                SEE_FILE,
            )
        })?;
        let within = |field: &str, value: Option<f64>, low: f64, high: f64| match value {
            Some(value) if (low..=high).contains(&value) => Ok(value),
            Some(value) => Err(wrong(
                &at(field),
                format!("{low} to {high}"),
                value,
                "correct it",
            )),
            None => Err(wrong(
                &at(field),
                format!("a number from {low} to {high}"),
                "none",
                "add it",
            )),
        };
        let relief = match row.kind {
            SampleKind::Isotropic => Relief::Isotropic {
                ra_m: within("ra_m", row.ra_m, 1e-8, 1e-3)?,
                grain_m: within("grain_m", row.grain_m, 1e-6, 5e-3)?,
                correlation_per_grain: match row.correlation_per_grain {
                    Some(ratio) => within("correlation_per_grain", Some(ratio), 0.2, 20.0)?,
                    None => self.relief.correlation_per_grain,
                },
                hurst: self.relief.hurst,
                skewness: self.relief.skewness,
            },
            SampleKind::Dots => {
                let wavelength_m = within("wavelength_m", row.wavelength_m, 1e-5, 5e-3)?;
                Relief::Dots {
                    height_m: within("dot_height_m", row.dot_height_m, 1e-7, 1e-3)?,
                    diameter_m: within("dot_diameter_m", row.dot_diameter_m, 1e-6, wavelength_m)?,
                    wavelength_m,
                    edge_m: self.relief.edge_m,
                    roughness_m: self.relief.resin_roughness_m,
                }
            }
            SampleKind::Ridges => Relief::Ridges {
                wavelength_m: within("wavelength_m", row.wavelength_m, 1e-5, 1e-2)?,
                depth_m: within("depth_m", row.depth_m, 1e-7, 5e-3)?,
                roughness_m: self.relief.print_roughness_m,
            },
        };
        let comb_wavelength_m = match (row.common_peak_hz, row.wavelength_m) {
            (Some(hz), _) => {
                let hz = within("common_peak_hz", Some(hz), 1.0, 1000.0)?;
                Some(self.texture.reference_speed_m_s / hz)
            }
            (None, wavelength_m) => wavelength_m,
        };
        let ridge_share = within("ridge_share", Some(row.ridge_share), 0.0, 1.0)?;
        let rms_m_s2 = match (row.rms_m_s2, row.ra_m, row.grain_m) {
            (None, Some(ra_m), Some(grain_m)) => level_of_roughness(ra_m, grain_m),
            (rms, ..) => within("rms_m_s2", rms, 1e-3, 100.0)?,
        };
        let friction = match (row.friction, row.ra_m) {
            (None, Some(ra_m)) => friction_of_roughness(ra_m),
            (friction, _) => within("friction", friction, 0.01, 5.0)?,
        };
        Ok(Sample {
            name: name.into(),
            relief,
            plate_m: plate_m(row.kind),
            rms_m_s2,
            ridge_share,
            comb_share: within("comb_share", Some(row.comb_share), 0.0, 1.0 - ridge_share)?,
            comb_wavelength_m,
            friction,
            static_ratio: match row.static_ratio {
                Some(ratio) => within("static_ratio", Some(ratio), 1.0, 3.0)?,
                None => self.friction.static_ratio,
            },
            loudness_spread: match row.loudness_spread {
                Some(spread) => within("loudness_spread", Some(spread), 0.0, 1.0)?,
                None => self.person.loudness_spread_by_sample,
            },
        })
    }
}

/// The level of a rough sample that states none: rms = e^−1.35·Ra^0.05·d^0.31 with Ra and grain d in µm (*chosen*: the
/// regression of the levels of S1 to S13).
fn level_of_roughness(ra_m: f64, grain_m: f64) -> f64 {
    (-1.35f64).exp() * (ra_m * 1e6).powf(0.05) * (grain_m * 1e6).powf(0.31)
}

/// The friction of a rough sample that states none: 0.3 + 0.55·(Ra/74.6 µm)^0.4 (*chosen*, after the thirteen samples).
fn friction_of_roughness(ra_m: f64) -> f64 {
    0.3 + 0.55 * (ra_m / 74.6e-6).powf(0.4)
}

/// Puts what `own` states into `all`, leaf by leaf.
fn merge(
    all: &mut Table,
    own: &Table,
    path: &str,
    changes: &mut Vec<String>,
) -> Result<(), TwinError> {
    for (key, value) in own {
        let here = if path.is_empty() {
            key.clone()
        } else {
            format!("{path}.{key}")
        };
        let new_sample = path == "samples" || path.starts_with("samples.");
        let known = all.keys().cloned().collect::<Vec<_>>().join(", ");
        let place = match all.entry(key.clone()) {
            toml::map::Entry::Occupied(entry) => entry.into_mut(),
            toml::map::Entry::Vacant(entry) if new_sample => {
                entry.insert(Value::Table(Table::new()))
            }
            toml::map::Entry::Vacant(_) => {
                return Err(wrong(
                    &here,
                    format!("one of {known}"),
                    format!("`{key}`"),
                    "correct the name",
                ));
            }
        };
        match (place, value) {
            (Value::Table(leaf), Value::Table(stated)) if stated.contains_key("value") => {
                let origin = stated.get("origin").and_then(Value::as_str).unwrap_or("");
                if !ORIGINS.contains(&origin) {
                    return Err(wrong(
                        &here,
                        format!("an origin ({})", ORIGINS.join(", ")),
                        format!("`{origin}`"),
                        "say where the number comes from: origin = \"measured\"",
                    ));
                }
                if leaf.get("value") != stated.get("value") {
                    changes.push(format!("{here} = {} ({origin})", stated["value"]));
                }
                for (part, part_value) in stated {
                    if part != "range" {
                        leaf.insert(part.clone(), part_value.clone());
                    }
                }
            }
            (Value::Table(table), Value::Table(stated)) if !table.contains_key("value") => {
                merge(table, stated, &here, changes)?;
            }
            (place @ Value::Table(_), Value::String(_)) if new_sample && key == "kind" => {
                *place = value.clone();
            }
            (Value::String(kind), Value::String(stated)) if kind == stated => {}
            (_, found) => {
                return Err(wrong(
                    &here,
                    "{ value = …, origin = \"measured\", note = \"…\" }",
                    found,
                    SEE_FILE,
                ));
            }
        }
    }
    Ok(())
}

/// The section `name` with every leaf replaced by its value, which is within its range.
fn section(all: &mut Table, name: &str) -> Result<Table, TwinError> {
    match all.remove(name) {
        Some(value) => match values(value, name)? {
            Value::Table(table) => Ok(table),
            other => Err(wrong(name, "a section", other, SEE_FILE)),
        },
        None => Err(wrong(name, "a section of that name", "none", SEE_FILE)),
    }
}

fn read<T: DeserializeOwned>(all: &mut Table, name: &str) -> Result<T, TwinError> {
    Value::Table(section(all, name)?)
        .try_into()
        .map_err(|error: toml::de::Error| {
            wrong(name, "its parameters as numbers", error.message(), SEE_FILE)
        })
}

fn values(value: Value, path: &str) -> Result<Value, TwinError> {
    let Value::Table(mut table) = value else {
        return Ok(value);
    };
    if let Some(found) = table.remove("value") {
        let range = table.get("range").and_then(Value::as_array);
        let number = |value: &Value| {
            let number = value.as_float().or(value.as_integer().map(|i| i as f64));
            number.ok_or_else(|| wrong(path, "a number", value, "correct it"))
        };
        let all = match &found {
            Value::Array(several) => several
                .iter()
                .map(number)
                .collect::<Result<Vec<f64>, _>>()?,
            one => vec![number(one)?],
        };
        if all.is_empty() || all.len() > MOST_VALUES {
            let expected = format!("1 to {MOST_VALUES} numbers");
            return Err(wrong(path, expected, all.len(), "correct it"));
        }
        match range.map(Vec::as_slice) {
            Some([low, high]) => {
                let (low, high) = (number(low)?, number(high)?);
                if let Some(bad) = all.iter().find(|value| !(low..=high).contains(*value)) {
                    return Err(wrong(path, format!("{low} to {high}"), bad, "correct it"));
                }
            }
            _ => {
                if let Some(bad) = all.iter().find(|value| !value.is_finite()) {
                    return Err(wrong(path, "a number", bad, "correct it"));
                }
            }
        }
        return Ok(match found {
            Value::Array(_) => Value::Array(all.into_iter().map(Value::Float).collect()),
            _ => Value::Float(all[0]),
        });
    }
    let mut stripped = Table::new();
    for (key, value) in table {
        let here = format!("{path}.{key}");
        stripped.insert(key, values(value, &here)?);
    }
    Ok(Value::Table(stripped))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_built_in_file_has_the_samples_of_the_thesis() {
        let parameters = TwinParameters::built_in();
        let names = parameters.sample_names();
        assert_eq!(names.len(), 27);
        assert_eq!(&names[..3], ["BIO", "M1", "M2"]);
        assert_eq!(names[names.len() - 1], "S13");
        assert_eq!(
            parameters.sample("M8").unwrap().comb_wavelength_m,
            Some(716e-6)
        );
        // 30 mm/s over 95 Hz.
        let common = parameters.sample("M11").unwrap().comb_wavelength_m.unwrap();
        assert!((common - 0.03 / 95.0).abs() < 1e-12);
        assert_eq!(parameters.changes(), [] as [String; 0]);
    }

    #[test]
    fn every_number_has_an_origin() {
        fn check(value: &Value, path: &str) -> usize {
            let Value::Table(table) = value else { return 0 };
            if table.contains_key("value") {
                let origin = table.get("origin").and_then(Value::as_str).unwrap_or("");
                assert!(ORIGINS[..3].contains(&origin), "{path}: {origin}");
                assert!(
                    path.starts_with("samples") || table.contains_key("range"),
                    "{path}"
                );
                return 1;
            }
            table
                .iter()
                .map(|(key, value)| check(value, &format!("{path}{key}.")))
                .sum()
        }
        let all: Table = PARAMETERS.parse().unwrap();
        assert!(check(&Value::Table(all), "") > 200);
    }

    #[test]
    fn a_laboratory_changes_what_it_measured() {
        let own = "[hand]\nforce_spread_n = { value = 0.05, origin = \"measured\", note = \"pilot\" }\n\
                   [samples.X1]\nkind = \"isotropic\"\nra_m = { value = 2e-5, origin = \"measured\" }\n\
                   grain_m = { value = 1e-4, origin = \"measured\" }";
        let parameters = TwinParameters::changed_by(own).unwrap();
        assert!((parameters.hand.force_spread_n - 0.05).abs() < 1e-12);
        // e^-1.35·20^0.05·100^0.31
        assert!((parameters.sample("X1").unwrap().rms_m_s2 - 1.255).abs() < 2e-3);
        assert_eq!(parameters.changes().len(), 3);
        assert!(
            parameters
                .provenance()
                .contains("hand.force_spread_n = 0.05 (measured)")
        );
    }

    #[test]
    fn what_cannot_be_is_refused_with_what_can() {
        for (text, says) in [
            (
                "[hand]\nlift_s = { value = -1.0, origin = \"measured\" }",
                "hand.lift_s: expected 0.2 to 5, found -1",
            ),
            (
                "[hand]\nlift_s = { value = nan, origin = \"measured\" }",
                "hand.lift_s: expected 0.2 to 5, found NaN",
            ),
            ("[hand]\nlift_s = { value = 1.0 }", "expected an origin"),
            ("[hand]\nlift_s = 1.0", "origin = \"measured\""),
            (
                "[hand]\nlfit_s = { value = 1.0, origin = \"measured\" }",
                "expected one of",
            ),
            (
                "[texture]\nridge_teeth = { value = [1.0, 2.0], origin = \"chosen\" }",
                "texture.ridge_teeth: expected 0 to 1",
            ),
            (
                "[texture]\nrise_hz = { value = \"a\", origin = \"chosen\" }",
                "texture.rise_hz: expected a number",
            ),
            (
                "[samples.M8]\nwavelength_m = { value = 0.0, origin = \"chosen\" }",
                "samples.M8.wavelength_m: expected 0.00001 to 0.005, found 0",
            ),
            (
                "[samples.S1]\nridge_share = { value = 1.5, origin = \"chosen\" }",
                "samples.S1.ridge_share: expected 0 to 1, found 1.5",
            ),
            ("[samples.X]\nkind = \"isotropic\"", "samples.X.ra_m"),
            ("[samples.X]\nkind = \"striped\"", "samples.X"),
            (
                "[samples.X]\nra_m = { value = 1e-5, origin = \"measured\" }",
                "kind",
            ),
            (
                "[texture]\nridge_teeth = { value = [], origin = \"chosen\" }",
                "texture.ridge_teeth: expected 1 to 12 numbers, found 0",
            ),
            (
                "[samples.S4]\nfriction = { value = nan, origin = \"chosen\" }",
                "samples.S4.friction: expected a number, found NaN",
            ),
            (
                "[hand]\ngesture_least_m_s2 = { value = 9.0, origin = \"chosen\" }",
                "hand.gesture_least_m_s2: expected at most hand.gesture_most_m_s2 = 2, found 9",
            ),
            ("samples = 3", "samples"),
            ("hand = [1]", "hand"),
            ("[", "TOML"),
        ] {
            let error = TwinParameters::changed_by(text).unwrap_err().to_string();
            assert!(error.contains(says), "{text}\n{error}");
        }
        let error = TwinParameters::built_in()
            .sample("S99")
            .unwrap_err()
            .to_string();
        assert!(error.contains("S13") && error.contains("`S99`"), "{error}");
    }
}
