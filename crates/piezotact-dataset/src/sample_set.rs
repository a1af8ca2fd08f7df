//! Sample sets as TOML: the two of the thesis come with the program, a laboratory's own have the same form.

use std::path::Path;

use piezotact::surface::{Judgement, SampleSet, SurfaceSample};
use serde::Deserialize;

use crate::error::ReadError;

const ISOTROPIC: &str = include_str!("../samples/isotropic.toml");
const PERIODIC: &str = include_str!("../samples/periodic.toml");
/// The published period may differ from diameter + gap by this share, as rounding does.
const ROUNDING: f64 = 0.01;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: String,
    source: String,
    #[serde(default)]
    material: String,
    plate_mm: [f64; 3],
    sample: Vec<Row>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    name: String,
    ra_um: Option<f64>,
    grit: Option<String>,
    dot_height_um: Option<f64>,
    dot_diameter_um: Option<f64>,
    dot_gap_um: Option<f64>,
    wavelength_um: Option<f64>,
    perceptual_category: Option<String>,
    hedonistic_category: Option<String>,
    judgement: Option<Judgement>,
}

/// The sets that come with the program: `isotropic` (S1–S13 and NO) and `periodic` (M1–M12).
///
/// # Errors
/// [`ReadError`] were one of them damaged.
pub fn known_sample_sets() -> Result<Vec<SampleSet>, ReadError> {
    [("isotropic.toml", ISOTROPIC), ("periodic.toml", PERIODIC)]
        .into_iter()
        .map(|(name, text)| parse(Path::new(name), text))
        .collect()
}

/// The sample set of a name, `isotropic` or `periodic`, or in a TOML file.
///
/// # Errors
/// [`ReadError`] naming the file, the sample, what was expected and what was found.
pub fn read_sample_set(path: &Path) -> Result<SampleSet, ReadError> {
    let known = known_sample_sets()?.into_iter();
    let mut named = known.filter(|set| path == Path::new(&set.name));
    if let Some(set) = named.next() {
        return Ok(set);
    }
    let text = crate::input::read_input_text(path)?;
    parse(path, &text)
}

fn parse(path: &Path, text: &str) -> Result<SampleSet, ReadError> {
    let wrong = |expected: &str, found: String| {
        ReadError::content(
            path,
            expected,
            found,
            "see crates/piezotact-dataset/samples/isotropic.toml for the form",
        )
    };
    let file: File = toml::from_str(text).map_err(|error| {
        let found = error.message().to_owned();
        wrong("a sample set in TOML", found)
    })?;
    let positive = |sample: &str, what: &str, value_um: Option<f64>| match value_um {
        Some(value) if !(value > 0.0 && value < 1e6) => Err(wrong(
            "lengths above 0 and below 1 m in µm",
            format!("{what} = {value} for {sample}"),
        )),
        other => Ok(other.map(|value| value * 1e-6)),
    };
    if let Some(bad) = file.plate_mm.iter().find(|v| !(**v > 0.0 && **v < 1e4)) {
        return Err(wrong(
            "a plate's length, width and thickness in mm",
            bad.to_string(),
        ));
    }
    let mut samples: Vec<SurfaceSample> = Vec::with_capacity(file.sample.len());
    for row in file.sample {
        if samples.iter().any(|other| other.name == row.name) {
            return Err(wrong(
                "samples of different names",
                format!("`{}` twice", row.name),
            ));
        }
        let length = |what: &str, value: Option<f64>| positive(&row.name, what, value);
        let sample = SurfaceSample {
            ra_m: length("ra_um", row.ra_um)?,
            dot_height_m: length("dot_height_um", row.dot_height_um)?,
            dot_diameter_m: length("dot_diameter_um", row.dot_diameter_um)?,
            dot_gap_m: length("dot_gap_um", row.dot_gap_um)?,
            wavelength_m: length("wavelength_um", row.wavelength_um)?,
            grit: row.grit,
            perceptual_category: row.perceptual_category,
            hedonistic_category: row.hedonistic_category,
            judgement: row.judgement,
            name: row.name,
        };
        if let Some(departure) = sample.wavelength_departure()
            && departure.abs() > ROUNDING
        {
            return Err(wrong(
                "a wavelength equal to dot diameter + gap within 1 %",
                format!(
                    "one that differs by {:.1} % for {}",
                    departure * 100.0,
                    sample.name
                ),
            ));
        }
        samples.push(sample);
    }
    if samples.is_empty() {
        return Err(wrong("at least one [[sample]]", "none".into()));
    }
    Ok(SampleSet {
        name: file.name,
        source: file.source,
        material: file.material,
        plate_m: file.plate_mm.map(|mm| mm * 1e-3),
        samples,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sets_of_the_program_are_those_of_the_tables() {
        let sets = known_sample_sets().unwrap();
        let [isotropic, periodic] = sets.as_slice() else {
            panic!("two sets");
        };
        assert_eq!((isotropic.samples.len(), periodic.samples.len()), (14, 12));
        assert!((isotropic.sample("S13").unwrap().ra_m.unwrap() - 3.8e-6).abs() < 1e-12);
        assert_eq!(
            isotropic.sample("S10").unwrap().grit.as_deref(),
            Some("P4000")
        );
        let m8 = periodic.sample("M8").unwrap();
        assert!((m8.wavelength_m.unwrap() - 716e-6).abs() < 1e-12);
        assert_eq!(m8.judgement, Some(Judgement::NearlyUniform));
    }

    #[test]
    fn what_is_wrong_in_a_set_is_named() {
        let head = "name = \"x\"\nsource = \"y\"\nplate_mm = [50.0, 50.0, 4.0]\n";
        for (body, part) in [
            ("", "sample"),
            (
                "[[sample]]\nname = \"A\"\nra_um = -1.0\n",
                "ra_um = -1 for A",
            ),
            ("[[sample]]\nname = \"A\"\nroughness = 1.0\n", "roughness"),
            (
                "[[sample]]\nname = \"A\"\n[[sample]]\nname = \"A\"\n",
                "`A` twice",
            ),
            (
                "[[sample]]\nname = \"A\"\ndot_diameter_um = 10.0\ndot_gap_um = 10.0\nwavelength_um = 25.0\n",
                "differs by -20.0 % for A",
            ),
        ] {
            let error = parse(Path::new("t.toml"), &format!("{head}{body}"));
            let text = error.unwrap_err().to_string();
            assert!(text.contains(part), "{text}");
        }
    }
}
