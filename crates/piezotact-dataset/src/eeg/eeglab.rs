//! Data sets of EEGLAB: the structure `EEG` in a MATLAB file, or its fields as variables; samples inside or in a `.fdt` file.
//!
//! Source of the layout: S. Makeig and A. Delorme, *EEGLAB Data Structures*. Samples are in µV by the convention of the program.

use std::path::Path;

use piezotact::Warning;
use piezotact::quantity::{SampleRate, Unit};
use piezotact::recording::{Channel, Losses, RecordingWarning};

use super::content::{Content, Line, Marked, Part, Place};
use super::{EegFile, EegKind, StatedPosition, in_folder_of};
use crate::error::ReadError;
use crate::matlab::{MatFile, MatNumbers, MatValue, looks_like_mat, parse_mat};
use crate::stored::{ByteOrder, Stored};

const WHAT_TO_DO: &str = "save it again in EEGLAB as one .set file";
/// V in one µV.
const MICRO: f64 = 1e-6;

/// Whether `path` has the ending of EEGLAB and `bytes` are a MATLAB file.
pub(crate) fn is_called_set(path: &Path, bytes: &[u8]) -> bool {
    let ending = path.extension();
    ending.is_some_and(|ending| ending.eq_ignore_ascii_case("set")) && looks_like_mat(bytes)
}

/// The fields of the data set, wherever they stand.
struct Fields<'m>(Vec<(&'m str, &'m MatValue)>);

impl<'m> Fields<'m> {
    fn of(file: &'m MatFile) -> Self {
        if let Some(MatValue::Struct { fields, values, .. }) = file.get("EEG") {
            let named = fields.iter().map(String::as_str).zip(values);
            return Self(named.collect());
        }
        let variables = file.variables.iter();
        Self(variables.map(|v| (v.name.as_str(), &v.value)).collect())
    }

    fn get(&self, name: &str) -> Option<&'m MatValue> {
        let found = self.0.iter().find(|(field, _)| *field == name);
        found.map(|(_, value)| *value)
    }

    /// A whole number from 1 on; `None` where the field is absent or empty.
    fn count(&self, path: &Path, name: &str) -> Result<Option<usize>, ReadError> {
        match self.get(name).and_then(MatValue::vector) {
            None | Some([]) => Ok(None),
            Some(&[value]) if value >= 1.0 && value.fract() == 0.0 && value < 1e12 => {
                Ok(Some(value as usize))
            }
            Some(other) => Err(ReadError::content(
                path,
                format!("a whole number from 1 on in EEG.{name}"),
                format!("{other:?}").chars().take(60).collect::<String>(),
                WHAT_TO_DO,
            )),
        }
    }
}

/// Reads the data set at `path`, with `bytes`.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<EegFile, ReadError> {
    let file = parse_mat(path, bytes)?;
    let fields = Fields::of(&file);
    let wrong =
        |expected: String, found: String| ReadError::content(path, expected, found, WHAT_TO_DO);
    let Some(data) = fields.get("data") else {
        return Err(wrong(
            "the data set `EEG` of EEGLAB, or its fields".into(),
            "a MATLAB file without `data`".into(),
        ));
    };
    let rate_hz = fields.get("srate").and_then(MatValue::scalar);
    let rate_hz = rate_hz.ok_or_else(|| wrong("a rate in EEG.srate".into(), "none".into()))?;
    let rate = SampleRate::new(rate_hz).map_err(ReadError::of(path))?;
    let stated = (
        fields.count(path, "nbchan")?,
        fields.count(path, "pnts")?,
        fields.count(path, "trials")?.unwrap_or(1),
    );
    let samples = samples_of(path, &fields, data, stated)?;
    let (trials, points) = (stated.2, samples.points / stated.2);
    let names = names_of(path, &fields, samples.channels)?;
    let positions = positions_of(&fields, &names);
    let (events, boundaries, mut warnings) = events_of(path, &fields, rate)?;
    let parts = if trials > 1 {
        let what = format!(
            "the data set holds {trials} epochs: each is a segment, and the file does not say when it was recorded; starts are counted as if they followed each other"
        );
        warnings.push(Warning::from(RecordingWarning::Guessed { what }));
        let each = (0..trials).map(|trial| Part {
            from: trial * points,
            start_s: rate.duration_of(trial * points).0,
        });
        each.collect()
    } else {
        parts_of(&boundaries, rate, points, &mut warnings)
    };
    let lines = names
        .into_iter()
        .zip(samples.values)
        .map(|(name, samples)| Line {
            channel: Channel {
                name,
                unit: Unit::Volt,
                samples,
            },
            rate,
            per_unit: 1,
            // The format has none.
            stated_unit: String::new(),
        });
    let content = Content {
        losses: Losses::default(),
        kind: EegKind::Eeglab,
        lines: lines.collect(),
        parts,
        events,
        started_at: None,
        warnings,
        bench: None,
    };
    Ok(EegFile {
        positions,
        ..content.into_file(path)?
    })
}

/// The positions in `EEG.chanlocs`, of those of the channels that have one.
///
/// Source: as MNE-Python reads them: X is to the front and Y to the left.
fn positions_of(fields: &Fields<'_>, names: &[String]) -> Vec<StatedPosition> {
    let Some(locations) = fields.get("chanlocs") else {
        return Vec::new();
    };
    let [x, y, z] = ["X", "Y", "Z"].map(|axis| elements(locations, axis));
    let of = |(at, name): (usize, &String)| {
        let value = |axis: &[Option<&MatValue>]| {
            let value = axis.get(at).copied().flatten()?.scalar()?;
            value.is_finite().then_some(value)
        };
        let (front, left, up) = (value(&x)?, value(&y)?, value(&z)?);
        let is_place = front != 0.0 || left != 0.0 || up != 0.0;
        is_place.then(|| StatedPosition {
            name: name.clone(),
            position: [-left, front, up],
        })
    };
    names.iter().enumerate().filter_map(of).collect()
}

/// The samples of each channel in V, all epochs one after the other.
struct Samples {
    channels: usize,
    points: usize,
    values: Vec<Vec<f64>>,
}

fn samples_of(
    path: &Path,
    fields: &Fields<'_>,
    data: &MatValue,
    (nbchan, pnts, trials): (Option<usize>, Option<usize>, usize),
) -> Result<Samples, ReadError> {
    let wrong =
        |expected: String, found: String| ReadError::content(path, expected, found, WHAT_TO_DO);
    let stated = nbchan.zip(pnts.and_then(|pnts| pnts.checked_mul(trials)));
    let numbers = match data {
        MatValue::Numbers(numbers) => numbers,
        MatValue::Text(_) => {
            let name = fields.get("datfile").and_then(MatValue::text);
            let name = name.filter(|name| !name.is_empty()).or(data.text());
            let (channels, points) = stated
                .ok_or_else(|| wrong("numbers in EEG.nbchan and EEG.pnts".into(), "none".into()))?;
            return from_fdt(path, name.unwrap_or_default(), channels, points);
        }
        _ => {
            return Err(wrong(
                "samples, or the name of a .fdt file, in EEG.data".into(),
                "another value".into(),
            ));
        }
    };
    if numbers.imaginary.is_some() {
        return Err(wrong(
            "real samples in EEG.data".into(),
            "complex ones".into(),
        ));
    }
    let (channels, points) = shape(numbers).filter(|found| stated.is_none_or(|s| s == *found)).ok_or_else(|| {
        wrong(
            match stated {
                Some((channels, points)) => format!(
                    "{channels} channels of {points} samples in EEG.data, as EEG.nbchan, pnts and trials state"
                ),
                None => "channels × samples (× epochs) in EEG.data".into(),
            },
            format!("{:?}", numbers.dims),
        )
    })?;
    if points % trials != 0 {
        return Err(wrong(
            format!("{trials} epochs of one length"),
            format!("{points} samples"),
        ));
    }
    let mut values = vec![Vec::with_capacity(points); channels];
    for frame in numbers.real.chunks_exact(channels) {
        for (own, value) in values.iter_mut().zip(frame) {
            own.push(value * MICRO);
        }
    }
    Ok(Samples {
        channels,
        points,
        values,
    })
}

/// Channels, and samples over all epochs; `None` for an empty array or one of another shape.
fn shape(numbers: &MatNumbers) -> Option<(usize, usize)> {
    let (channels, points) = match *numbers.dims.as_slice() {
        [channels, points] => (channels, points),
        [channels, points, epochs] => (channels, points.checked_mul(epochs)?),
        _ => return None,
    };
    let all = channels.checked_mul(points)?;
    (all > 0 && all == numbers.real.len()).then_some((channels, points))
}

/// Samples in a file of 32-bit numbers beside the data set: all channels of a sample, then those of the next.
fn from_fdt(path: &Path, name: &str, channels: usize, points: usize) -> Result<Samples, ReadError> {
    let plain = Path::new(name).file_name().and_then(|file| file.to_str()) == Some(name);
    let named = Some(in_folder_of(path, name)).filter(|file| plain && file.is_file());
    // A data set that was renamed still has its samples under its own name.
    let own = path.with_extension("fdt");
    let file = named
        .or_else(|| own.is_file().then_some(own))
        .ok_or_else(|| {
            ReadError::content(
                path,
                format!(
                    "the file with its samples, `{}`, beside it",
                    name.chars().take(60).collect::<String>().escape_debug()
                ),
                "none there",
                "put it beside the data set, or save the data set as one file",
            )
        })?;
    let bytes = crate::input::read_input(&file)?;
    let needed = channels
        .checked_mul(points)
        .and_then(|all| all.checked_mul(4));
    if needed != Some(bytes.len()) || bytes.is_empty() {
        return Err(ReadError::content(
            &file,
            format!("{channels} channels of {points} samples in 4 bytes each"),
            format!("{} bytes", bytes.len()),
            "copy it again together with its .set file",
        ));
    }
    let numbers = Stored::F32
        .values(&bytes, ByteOrder::Little)
        .into_iter()
        .map(|value| value * MICRO);
    // The older `.dat` has one channel after the other.
    let is_dat = file
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("dat"));
    let mut values = vec![Vec::with_capacity(points); channels];
    for (at, value) in numbers.enumerate() {
        let channel = if is_dat { at / points } else { at % channels };
        values[channel].push(value);
    }
    Ok(Samples {
        channels,
        points,
        values,
    })
}

/// The names of the channels in `EEG.chanlocs.labels`; `E1`, `E2`, … where there are none.
fn names_of(path: &Path, fields: &Fields<'_>, channels: usize) -> Result<Vec<String>, ReadError> {
    let labels = fields
        .get("chanlocs")
        .map(|locations| elements(locations, "labels"));
    let labels = labels.unwrap_or_default();
    if labels.is_empty() {
        return Ok((1..=channels).map(|k| format!("E{k}")).collect());
    }
    if labels.len() != channels {
        return Err(ReadError::content(
            path,
            format!("{channels} names of channels in EEG.chanlocs"),
            format!("{}", labels.len()),
            WHAT_TO_DO,
        ));
    }
    let named = labels.into_iter().enumerate();
    Ok(named
        .map(|(k, label)| text_of(label).unwrap_or_else(|| format!("E{}", k + 1)))
        .collect())
}

/// The values of `field` in all elements of a structure array, whether it is one, a structure of lists, or a list of structures.
fn elements<'m>(value: &'m MatValue, field: &str) -> Vec<Option<&'m MatValue>> {
    if let MatValue::Cell { values, .. } = value {
        let own = values.iter().map(|one| elements(one, field));
        return own.map(|of| of.first().copied().flatten()).collect();
    }
    let MatValue::Struct {
        dims,
        fields,
        values,
        ..
    } = value
    else {
        return Vec::new();
    };
    let count = values.len().checked_div(fields.len()).unwrap_or(0);
    let Some(at) = fields.iter().position(|name| name == field) else {
        return vec![None; count];
    };
    let own = values.iter().skip(at).step_by(fields.len().max(1));
    match (dims.iter().product::<usize>(), values.get(at)) {
        (1, Some(MatValue::Cell { values, .. })) => values.iter().map(Some).collect(),
        _ => own.map(Some).collect(),
    }
}

/// The one value of a list of one.
fn alone(value: &MatValue) -> &MatValue {
    match value {
        MatValue::Cell { values, .. } if values.len() == 1 => &values[0],
        _ => value,
    }
}

/// A text, or a number as text.
fn text_of(value: Option<&MatValue>) -> Option<String> {
    let value = alone(value?);
    match (value.text(), value.scalar()) {
        (Some(text), _) if !text.is_empty() => Some(text.to_owned()),
        (_, Some(number)) => Some(number.to_string()),
        _ => None,
    }
}

/// A discontinuity: the sample before which it is, and the samples that were removed there, if that is known.
struct Boundary {
    sample: f64,
    removed: Option<f64>,
}

type Events = (Vec<Marked>, Vec<Boundary>, Vec<Warning>);

fn events_of(path: &Path, fields: &Fields<'_>, rate: SampleRate) -> Result<Events, ReadError> {
    let Some(table) = fields.get("event") else {
        return Ok((Vec::new(), Vec::new(), Vec::new()));
    };
    let (kinds, latencies, durations) = (
        elements(table, "type"),
        elements(table, "latency"),
        elements(table, "duration"),
    );
    let (mut events, mut boundaries, mut without) = (Vec::new(), Vec::new(), 0);
    for (k, latency) in latencies.into_iter().enumerate() {
        let kind = text_of(kinds.get(k).copied().flatten()).unwrap_or_else(|| "event".into());
        let latency = latency
            .and_then(|latency| alone(latency).scalar())
            .filter(|at| at.is_finite());
        let Some(latency) = latency.filter(|at| at.abs() < 1e15) else {
            without += 1;
            continue;
        };
        let duration = durations
            .get(k)
            .copied()
            .flatten()
            .and_then(|duration| alone(duration).scalar());
        let duration = duration.filter(|samples| samples.is_finite() && *samples >= 0.0);
        let is_boundary = kind == "boundary";
        // A boundary stands half a sample before the first one behind it.
        let place = match is_boundary {
            true => (latency - 1.0).ceil(),
            false => latency - 1.0,
        };
        if is_boundary {
            boundaries.push(Boundary {
                sample: place,
                removed: duration.filter(|samples| *samples > 0.0),
            });
        }
        events.push(Marked {
            place: Place::Sample(place),
            // What a boundary says to last is what was removed, and no part of the samples.
            duration_s: duration.filter(|_| !is_boundary).unwrap_or(0.0) / rate.hz(),
            kind,
            value: None,
        });
    }
    let mut warnings = Vec::new();
    if without > 0 {
        let what = format!(
            "{without} event(s) of {} have no latency, and are left out",
            path.file_name().unwrap_or_default().to_string_lossy()
        );
        warnings.push(Warning::from(RecordingWarning::Guessed { what }));
    }
    Ok((events, boundaries, warnings))
}

/// The parts between boundaries.
fn parts_of(
    boundaries: &[Boundary],
    rate: SampleRate,
    points: usize,
    warnings: &mut Vec<Warning>,
) -> Vec<Part> {
    let mut parts = vec![Part {
        from: 0,
        start_s: 0.0,
    }];
    let inside = |boundary: &&Boundary| 0.0 < boundary.sample && boundary.sample < points as f64;
    let mut sorted: Vec<&Boundary> = boundaries.iter().filter(inside).collect();
    sorted.sort_by(|a, b| a.sample.total_cmp(&b.sample));
    for boundary in sorted {
        let from = boundary.sample as usize;
        let Some(last) = parts.last().copied() else {
            continue;
        };
        if boundary.removed.is_none() {
            let what = format!(
                "the file does not say how much was removed at the boundary before sample {from}: the start of what follows is counted as if nothing was"
            );
            warnings.push(Warning::from(RecordingWarning::Guessed { what }));
        }
        let gap_s = boundary.removed.unwrap_or(0.0) / rate.hz();
        let start_s = last.start_s + rate.duration_of(from - last.from).0 + gap_s;
        match parts.last_mut() {
            // Two boundaries at one place.
            Some(part) if part.from == from => part.start_s = start_s,
            _ => parts.push(Part { from, start_s }),
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matlab::NumberClass;

    #[test]
    fn a_list_of_structures_is_an_array_of_them() {
        let number = |value: f64| {
            MatValue::Numbers(MatNumbers {
                dims: vec![1, 1],
                class: NumberClass::Double,
                real: vec![value],
                imaginary: None,
                exact: true,
            })
        };
        let event = |latency: f64| MatValue::Struct {
            dims: vec![1, 1],
            fields: vec!["latency".into()],
            values: vec![number(latency)],
            class: None,
        };
        let table = MatValue::Cell {
            dims: vec![1, 3],
            values: vec![event(251.0), number(1.0), event(1251.0)],
        };
        let found = elements(&table, "latency");
        let found: Vec<Option<f64>> = found.into_iter().map(|one| one?.scalar()).collect();
        assert_eq!(found, [Some(251.0), None, Some(1251.0)]);
    }
}
