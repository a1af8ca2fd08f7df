//! What a Surfcom instrument writes beside a profile: `.tx1` is the primary and `.tx2` the roughness profile, `.tx3` the settings
//! and the parameters, a label and a value in each line.

use std::path::{Path, PathBuf};

use crate::roughness::{
    HeightProfile, InstrumentSettings, InstrumentStates, InstrumentValue, ProfileKind,
    SurfaceWarning, Topography,
};
use piezotact::Warning;
use piezotact::recording::RecordingWarning;

use super::source::unit_m;
use super::table::decode;
use super::{TopographyFile, TopographyKind, TopographyOptions};
use piezotact_dataset::ReadError;

/// Settings are a few kB; more is another file.
const LARGEST_SETTINGS: u64 = 1 << 20;
/// The step of the profiles of such instruments that we have seen: 10 mm in 28 087 points.
const USUAL_STEP_M: f64 = 10e-3 / 28_087.0;
/// Two steps or lengths that differ by less than this share are one: lengths are rounded to 0.1 mm.
const SAME_LENGTH: f64 = 0.01;
/// Places of the settings after that of the length, where the labels are in an unknown language.
const PLACES: [(Setting, usize); 3] = [
    (Setting::Cutoff, 1),
    (Setting::LambdaS, 10),
    (Setting::Evaluated, 11),
];

/// A length among the settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Setting {
    Set,
    Cutoff,
    LambdaS,
    Evaluated,
}

/// The labels of a setting in small letters without signs, as far as they are known: Spanish, English, German, French, Italian.
const LABELS: [(Setting, &[&str]); 4] = [
    (
        Setting::LambdaS,
        &[
            "longitudondacortels",
            "ondadecortels",
            "cutoffwavelengthls",
            "cutoffvaluels",
            "lscutoffwavelength",
            "lscutoffvalue",
            "lscutoff",
            "grenzwellenlangels",
            "longueurdondedecoupurels",
            "lunghezzadondacutoffls",
        ],
    ),
    (
        Setting::Cutoff,
        &[
            "ondadecorte",
            "longituddeondadecorte",
            "longitudondacorte",
            "cutoff",
            "cutoffvalue",
            "cutoffwavelength",
            "cutofflength",
            "grenzwellenlange",
            "longueurdondedecoupure",
            "lunghezzadondacutoff",
            "lunghezzacutoff",
        ],
    ),
    (
        Setting::Set,
        &[
            "longitudmedicion",
            "longituddemedicion",
            "measurementlength",
            "measuringlength",
            "measurelength",
            "messlange",
            "longueurdemesure",
            "longueurmesure",
            "lunghezzamisura",
            "lunghezzadimisura",
        ],
    ),
    (
        Setting::Evaluated,
        &[
            "longitudevaluacion",
            "longituddeevaluacion",
            "evaluationlength",
            "evaluatedlength",
            "auswertelange",
            "auswertungslange",
            "longueurdevaluation",
            "longueurevaluation",
            "lunghezzavalutazione",
            "lunghezzadivalutazione",
        ],
    ),
];

/// The symbols of parameters that are shown beside ours, as the instrument and as we write them, and the unit of ours, m.
const SYMBOLS: [(&str, &str, f64); 16] = [
    ("ra", "Ra", 1e-6),
    ("rq", "Rq", 1e-6),
    ("rz", "Rz", 1e-6),
    ("rt", "Rt", 1e-6),
    ("rp", "Rp", 1e-6),
    ("rv", "Rv", 1e-6),
    ("rsm", "RSm", 1e-6),
    ("rsk", "Rsk", 1.0),
    ("rku", "Rku", 1.0),
    ("rdq", "Rdq", 1.0),
    ("rk", "Rk", 1e-6),
    ("rpk", "Rpk", 1e-6),
    ("rvk", "Rvk", 1e-6),
    ("mr1", "Mr1", 1.0),
    ("mr2", "Mr2", 1.0),
    ("rmr1", "Mr1", 1.0),
];

/// A Surfcom profile with what the file beside it states: its evaluated length gives the step. Other files as they are.
pub(super) fn with_settings(
    mut file: TopographyFile,
    path: &Path,
    options: &TopographyOptions,
) -> Result<TopographyFile, ReadError> {
    let (TopographyKind::Surfcom, Topography::Profile(profile)) = (file.kind, &file.topography)
    else {
        return Ok(file);
    };
    file.profile_kind = match ending(path).as_str() {
        "tx1" => Some(ProfileKind::Primary),
        "tx2" => Some(ProfileKind::Roughness),
        _ => None,
    };
    let found = settings_of(path, &mut file.warnings);
    if options.step_m.is_none() {
        let evaluated_m = found.as_ref().and_then(|s| s.evaluation_length_m);
        match evaluated_m {
            Some(evaluated_m) if differ(evaluated_m, profile.length_m()) => {
                let step_m = evaluated_m / profile.heights_m().len() as f64;
                let file_name = found.as_ref().and_then(|s| s.file.file_name());
                file.warnings
                    .push(Warning::from(SurfaceWarning::Instrument {
                        what: InstrumentStates::LengthSet {
                            set_m: profile.length_m(),
                            evaluated_m,
                            step_m,
                            file: file_name.unwrap_or_default().to_string_lossy().into_owned(),
                        },
                    }));
                let heights_m = profile.heights_m().to_vec();
                let profile = HeightProfile::new(heights_m, step_m);
                file.topography = Topography::Profile(profile.map_err(ReadError::of(path))?);
            }
            None if differ(profile.step_m(), USUAL_STEP_M) => {
                file.warnings
                    .push(Warning::from(SurfaceWarning::Instrument {
                        what: InstrumentStates::Length {
                            length_m: profile.length_m(),
                            points: profile.heights_m().len(),
                            step_m: profile.step_m(),
                            usual_step_m: USUAL_STEP_M,
                        },
                    }));
            }
            _ => {}
        }
    }
    file.instrument = found;
    Ok(file)
}

fn differ(one: f64, other: f64) -> bool {
    (one / other - 1.0).abs() > SAME_LENGTH
}

fn ending(path: &Path) -> String {
    let ending = path.extension().unwrap_or_default();
    ending.to_string_lossy().to_ascii_lowercase()
}

/// The settings beside `path`; a warning where there are several files, or one that cannot be read.
fn settings_of(path: &Path, warnings: &mut Vec<Warning>) -> Option<InstrumentSettings> {
    let mut guessed =
        |what: String| warnings.push(Warning::from(RecordingWarning::Guessed { what }));
    let found = beside(path);
    let file = match found.as_slice() {
        [] => return None,
        [file] => file,
        several => {
            guessed(format!(
                "none of {} files with settings (.tx3) was used: none has the name of the profile",
                several.len()
            ));
            return None;
        }
    };
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let is_small = std::fs::metadata(file).is_ok_and(|found| found.len() <= LARGEST_SETTINGS);
    let bytes = if is_small {
        piezotact_dataset::reads::read(file).ok()
    } else {
        None
    };
    let Some(text) = bytes.as_deref().and_then(decode) else {
        guessed(format!(
            "the settings in {name} were not used: they are no readable text"
        ));
        return None;
    };
    let (settings, by_place) = parsed(&text, file);
    if by_place {
        guessed(format!(
            "the labels in {name} are in an unknown language: its lengths were read by their places (λc {}, length evaluated {})",
            length_text(settings.cutoff_m),
            length_text(settings.evaluation_length_m)
        ));
    }
    Some(settings)
}

fn length_text(length_m: Option<f64>) -> String {
    length_m.map_or_else(|| "not stated".into(), crate::roughness::length_text)
}

/// The files with settings that belong to `path`: that of its own name, or else those whose names differ in the last word alone,
/// as `plate_settings.tx3` beside `plate_roughness.tx2`.
fn beside(path: &Path) -> Vec<PathBuf> {
    let folder = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    let Ok(entries) = std::fs::read_dir(folder.unwrap_or(Path::new("."))) else {
        return Vec::new();
    };
    let stem = |path: &Path| {
        path.file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned()
    };
    let own = stem(path);
    let group = |stem: &str| {
        stem.rsplit_once(['_', '-', ' '])
            .map(|(group, _)| group.to_owned())
    };
    let (mut same, mut related) = (Vec::new(), Vec::new());
    for entry in entries.flatten() {
        let other = entry.path();
        if ending(&other) != "tx3" || !other.is_file() {
            continue;
        }
        let name = stem(&other);
        if name == own {
            same.push(other);
        } else if group(&name).is_some() && (group(&name) == group(&own)) {
            related.push(other);
        }
    }
    let mut found = if same.is_empty() { related } else { same };
    found.sort();
    found
}

/// The settings in `text`, and whether lengths were read by their place among unknown labels.
fn parsed(text: &str, file: &Path) -> (InstrumentSettings, bool) {
    let lines: Vec<(String, Vec<&str>)> = text
        .lines()
        .map(|line| {
            let mut cells = line.split('\t');
            let label = plain(cells.next().unwrap_or_default());
            (label, cells.map(str::trim).collect())
        })
        .collect();
    let first = |cells: &[&str]| cells.first().and_then(|cell| length_m(cell));
    let mut settings = InstrumentSettings {
        file: file.to_owned(),
        ..InstrumentSettings::default()
    };
    for (label, cells) in &lines {
        let setting = LABELS
            .iter()
            .find(|(_, labels)| labels.iter().any(|known| is_label(known, label)));
        if let (Some((setting, _)), Some(length_m)) = (setting, first(cells)) {
            place(&mut settings, *setting).get_or_insert(length_m);
        }
        if let Some(value) = value(label, cells)
            && !settings.values.iter().any(|v| v.symbol == value.symbol)
        {
            settings.values.push(value);
        }
    }
    let nothing = settings.cutoff_m.or(settings.evaluation_length_m).is_none();
    let set_at = lines.iter().position(|(_, cells)| first(cells).is_some());
    let (true, Some(set_at)) = (nothing, set_at) else {
        return (settings, false);
    };
    settings.measured_length_m = lines.get(set_at).and_then(|(_, cells)| first(cells));
    for (setting, after) in PLACES {
        let found = lines.get(set_at + after);
        *place(&mut settings, setting) = found.and_then(|(_, cells)| first(cells));
    }
    let longest_m = settings.measured_length_m.unwrap_or(0.0) * (1.0 + SAME_LENGTH);
    let fits = |length_m: &Option<f64>| length_m.is_some_and(|m| m <= longest_m);
    if !(fits(&settings.cutoff_m) && fits(&settings.evaluation_length_m)) {
        let values = std::mem::take(&mut settings.values);
        let file = file.to_owned();
        return (
            InstrumentSettings {
                file,
                values,
                ..InstrumentSettings::default()
            },
            false,
        );
    }
    (settings, true)
}

fn place(settings: &mut InstrumentSettings, setting: Setting) -> &mut Option<f64> {
    match setting {
        Setting::Set => &mut settings.measured_length_m,
        Setting::Cutoff => &mut settings.cutoff_m,
        Setting::LambdaS => &mut settings.lambda_s_m,
        Setting::Evaluated => &mut settings.evaluation_length_m,
    }
}

/// A label in small letters without accents and signs; letters that were lost on the way stay lost.
fn plain(label: &str) -> String {
    let without_accent = |sign: char| match sign {
        'á' | 'à' | 'â' | 'ä' => 'a',
        'é' | 'è' | 'ê' | 'ë' => 'e',
        'í' | 'ì' | 'î' | 'ï' => 'i',
        'ó' | 'ò' | 'ô' | 'ö' => 'o',
        'ú' | 'ù' | 'û' | 'ü' => 'u',
        sign => sign,
    };
    let letters = label
        .chars()
        .flat_map(char::to_lowercase)
        .map(without_accent);
    letters.filter(char::is_ascii_alphanumeric).collect()
}

/// Whether `found` is the `known` label, or that label with one letter lost (an accent in a broken encoding).
fn is_label(known: &str, found: &str) -> bool {
    found == known
        || (found.len() + 1 == known.len()
            && known.len() > 8
            && (0..known.len()).any(|lost| {
                found.as_bytes()[..lost] == known.as_bytes()[..lost]
                    && found.as_bytes()[lost..] == known.as_bytes()[lost + 1..]
            }))
}

/// A number and the unit that follows it: `2.5mm`, `0.474um`, `12,5%`.
fn measure(cell: &str) -> Option<(f64, &str)> {
    let end = cell
        .find(|sign: char| !(sign.is_ascii_digit() || ".,-+".contains(sign)))
        .unwrap_or(cell.len());
    let number: f64 = cell[..end].replace(',', ".").parse().ok()?;
    number.is_finite().then_some((number, cell[end..].trim()))
}

/// A length above zero, m: `2.5mm`, but not `0.3mm/s` or `+/-128.0um`.
fn length_m(cell: &str) -> Option<f64> {
    let (number, unit) = measure(cell)?;
    let length_m = number * unit_m(unit)?;
    (length_m > 0.0).then_some(length_m)
}

/// A parameter that is shown beside ours; the first value of its line that is a number.
fn value(label: &str, cells: &[&str]) -> Option<InstrumentValue> {
    let (_, symbol, ours_m) = SYMBOLS.iter().find(|(known, ..)| *known == label)?;
    let value = cells.iter().find_map(|cell| {
        let (number, unit) = measure(cell)?;
        match unit {
            "" | "%" => (*ours_m == 1.0).then_some(number),
            unit => (*ours_m != 1.0).then_some(number * (unit_m(unit)? / ours_m)),
        }
    })?;
    Some(InstrumentValue {
        symbol: (*symbol).to_owned(),
        value,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(text: &str) -> (InstrumentSettings, bool) {
        parsed(text, Path::new("a.tx3"))
    }

    #[test]
    fn settings_are_read_under_labels_of_several_languages() {
        let check = |labels: [&str; 4]| {
            let [set, cutoff, short, evaluated] = labels;
            let text = format!(
                "{set}\t10.0mm\n{cutoff}\t2.5mm\nRango\t+/-128.0um\nVelocidad\t0.3mm/s\n{short}\t25.0um\n{evaluated}\t5.5mm\n\
                 Ra\t1.1000000um\t*.*******um\nRDq\t0.25\t*\nMr1\t8,5%\nRz\t*.*******um\t*\nRSm\t0.12mm\n"
            );
            let (found, by_place) = settings(&text);
            assert!(!by_place, "{labels:?}");
            assert_eq!(found.cutoff_m, Some(2.5e-3), "{labels:?}");
            assert_eq!(found.evaluation_length_m, Some(5.5e-3), "{labels:?}");
            assert_eq!(found.measured_length_m, Some(10e-3), "{labels:?}");
            assert_eq!(found.lambda_s_m, Some(25.0 * 1e-6), "{labels:?}");
            let values: Vec<(&str, f64)> = (found.values.iter())
                .map(|v| (v.symbol.as_str(), (v.value * 1e6).round() / 1e6))
                .collect();
            assert_eq!(
                values,
                [("Ra", 1.1), ("Rdq", 0.25), ("Mr1", 8.5), ("RSm", 120.0)]
            );
        };
        check([
            "Longitud medición",
            "Onda de corte",
            "Longitud onda corte Ls",
            "Longitud evaluación",
        ]);
        // accents lost
        check([
            "Longitud medici\u{fffd}n",
            "Onda de corte",
            "Longitud onda corte Ls",
            "Longitud evaluaci\u{fffd}n",
        ]);
        check([
            "Measurement length",
            "Cutoff wavelength",
            "Cutoff wavelength Ls",
            "Evaluation length",
        ]);
        check([
            "Messlänge",
            "Grenzwellenlänge",
            "Grenzwellenlänge Ls",
            "Auswertelänge",
        ]);
    }

    #[test]
    fn unknown_labels_are_read_by_their_places_and_that_is_said() {
        let mut lines = vec![
            "a\t10.0mm",
            "b\t0.8mm",
            "c\t+/-128.0um",
            "d\t0.3mm/s",
            "e\tGauss",
            "f\tx",
            "g\t3.0mm/s",
            "h\tx",
            "i\tx",
            "j\t100",
            "k\t25.0um",
            "l\t4.0mm",
        ];
        let (found, by_place) = settings(&lines.join("\n"));
        assert!(by_place);
        assert_eq!(
            (found.cutoff_m, found.lambda_s_m),
            (Some(0.8e-3), Some(25.0 * 1e-6))
        );
        assert_eq!(found.evaluation_length_m, Some(4e-3));
        // a length that is longer than the one set shows that the places are others
        lines[11] = "l\t40.0mm";
        let (found, by_place) = settings(&lines.join("\n"));
        assert!(!by_place);
        assert_eq!((found.cutoff_m, found.evaluation_length_m), (None, None));
        assert_eq!(settings(""), (settings("x\ty").0, false));
    }
}
