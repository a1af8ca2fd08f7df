//! Topographies as text: x-y-z columns, a matrix, x-z columns, one column of heights, and Surfcom profiles.
//! How many numbers stand in a row says which; a matrix of two or three columns must say so in its header.

use piezotact::Warning;
use piezotact::recording::{RecordingWarning, Steps};

use super::grid::{Axis, EVEN, GAP};
use super::source::{Source, unit_m};
use super::table::Table;
use super::{Read, TopographyKind, TopographyOptions};
use piezotact_dataset::ReadError;

/// A grid with more places than this for each point is no grid.
const PLACES_PER_POINT: usize = 4;
/// Two scales that differ by less than this are one.
const SAME: f64 = 1e-6;

pub(super) fn read(source: Source<'_>, options: &TopographyOptions) -> Result<Read, ReadError> {
    let table = Table::read(source)?;
    let stated = Stated::of(&table.header);
    let scale = Scale {
        source,
        options: *options,
    };
    match table.width {
        width if width >= 4 || stated.is_matrix() => matrix(&scale, table, &stated),
        3 => points(&scale, &table),
        2 => profile(&scale, &table),
        _ => heights(&scale, table),
    }
}

/// What the header of a matrix states.
#[derive(Default)]
struct Stated {
    columns: Option<usize>,
    rows: Option<usize>,
    step_m: Option<f64>,
    width_m: Option<f64>,
    height_m: Option<f64>,
    unit_m: Option<f64>,
}

impl Stated {
    fn of(header: &[String]) -> Self {
        let mut stated = Self::default();
        for line in header {
            let line = line.trim_start_matches(['#', '%', ' ']);
            for word in line.split_whitespace() {
                match word.split_once('=') {
                    Some(("w", count)) => stated.columns = count.parse().ok(),
                    Some(("h", count)) => stated.rows = count.parse().ok(),
                    _ => {}
                }
            }
            let Some((key, value)) = line.split_once(['=', ':']) else {
                continue;
            };
            let key = key.trim().to_lowercase();
            match key.as_str() {
                "pixel size" => stated.step_m = length_m(value),
                // Gwyddion writes them in the language of the computer.
                "width" | "breite" | "largeur" | "larghezza" => stated.width_m = length_m(value),
                "height" | "höhe" | "hauteur" | "altezza" => stated.height_m = length_m(value),
                "value units" | "height unit" | "z unit" => stated.unit_m = unit_m(value),
                _ => {
                    if let Some(unit) = key.strip_prefix("height conversion factor (->")
                        && let (Some(unit), Ok(factor)) =
                            (unit_m(unit), value.trim().parse::<f64>())
                    {
                        stated.unit_m = Some(factor * unit);
                    }
                }
            }
        }
        stated
    }

    fn is_matrix(&self) -> bool {
        (self.columns.is_some() && self.rows.is_some()) || self.width_m.is_some()
    }
}

/// `3.6e-7 m`, in m.
fn length_m(text: &str) -> Option<f64> {
    let (value, unit) = text.trim().split_once(char::is_whitespace)?;
    Some(value.parse::<f64>().ok()? * unit_m(unit)?)
}

/// Where the scale of a text comes from: the file, or else the person.
struct Scale<'a> {
    source: Source<'a>,
    options: TopographyOptions,
}

impl Scale<'_> {
    /// The file's own scale, or the person's; a person's that the file contradicts is left unused, and said.
    fn choose(
        &self,
        (what, option): (&str, &str),
        file: Option<f64>,
        person: Option<f64>,
        warnings: &mut Vec<Warning>,
    ) -> Result<f64, ReadError> {
        let Some(scale) = file.or(person) else {
            return Err(self.source.wrong(
                format!("the {what}"),
                "a text file that does not state it",
                format!(
                    "state it with {option}, or name units in a header such as `x (mm),y (mm),z (um)`"
                ),
            ));
        };
        if !scale.is_normal() || scale < 0.0 {
            return Err(self.source.wrong(
                format!("a {what} above zero"),
                format!("{scale} m"),
                "correct it",
            ));
        }
        if let Some(person) = person
            && (person / scale - 1.0).abs() > SAME
        {
            warnings.push(Warning::from(RecordingWarning::Guessed {
                what: format!(
                    "the given {what} of {person:e} m was not used: the file states {scale:e} m"
                ),
            }));
        }
        Ok(scale)
    }

    fn coordinate(&self, file: Option<f64>, warnings: &mut Vec<Warning>) -> Result<f64, ReadError> {
        let person = self.options.coordinate_unit_m;
        self.choose(
            ("unit of the coordinates", "--x-unit mm"),
            file,
            person,
            warnings,
        )
    }

    fn height(&self, file: Option<f64>, warnings: &mut Vec<Warning>) -> Result<f64, ReadError> {
        let person = self.options.height_unit_m;
        self.choose(
            ("unit of the heights", "--z-unit um"),
            file,
            person,
            warnings,
        )
    }

    fn step(&self, file: Option<f64>, warnings: &mut Vec<Warning>) -> Result<f64, ReadError> {
        let person = self.options.step_m;
        self.choose(
            ("step between points", "--step 1um"),
            file,
            person,
            warnings,
        )
    }
}

fn scaled(mut heights: Vec<f64>, unit_m: f64) -> Vec<f64> {
    for z in &mut heights {
        *z *= unit_m;
    }
    heights
}

fn matrix(scale: &Scale<'_>, table: Table, stated: &Stated) -> Result<Read, ReadError> {
    let columns = table.width;
    let rows = table.values.len() / columns.max(1);
    for (what, stated, found) in [
        ("columns", stated.columns, columns),
        ("rows", stated.rows, rows),
    ] {
        if let Some(stated) = stated
            && stated != found
        {
            return Err(scale.source.wrong(
                format!("{stated} {what}, as the header says"),
                format!("{found}"),
                "it was cut short: copy or export it again",
            ));
        }
    }
    let mut warnings = Vec::new();
    let share = |length: Option<f64>, count: usize| length.map(|length| length / count as f64);
    let x = stated.step_m.or(share(stated.width_m, columns));
    let y = stated.step_m.or(share(stated.height_m, rows)).or(x);
    let step_x_m = scale.step(x, &mut warnings)?;
    let step_y_m = y.unwrap_or(step_x_m);
    let unit = scale.height(stated.unit_m, &mut warnings)?;
    Ok(Read {
        kind: TopographyKind::MatrixText,
        heights_m: scaled(table.values, unit),
        columns,
        step_x_m,
        step_y_m,
        warnings,
    })
}

/// Refuses coordinates that are no numbers.
fn coordinates(source: Source<'_>, table: &Table, at: usize) -> Result<Vec<f64>, ReadError> {
    let values = table.column(at);
    match values.iter().position(|value| !value.is_finite()) {
        None => Ok(values),
        Some(row) => Err(source.wrong(
            "coordinates for every point",
            format!("none for point {}", row + 1),
            "repair or cut that row",
        )),
    }
}

fn points(scale: &Scale<'_>, table: &Table) -> Result<Read, ReadError> {
    let source = scale.source;
    let units = table.column_units_m(source)?;
    let unit = |at: usize| units.as_ref().and_then(|units| units.get(at).copied());
    let mut warnings = Vec::new();
    let unit_x = scale.coordinate(unit(0), &mut warnings)?;
    let unit_y = match unit(1) {
        Some(unit) => unit,
        None => unit_x,
    };
    let unit_z = scale.height(unit(2), &mut warnings)?;
    let (xs, ys) = (
        coordinates(source, table, 0)?,
        coordinates(source, table, 1)?,
    );
    let axis = |name: &str, values: &[f64]| {
        Axis::of(values).map_err(|found| {
            source.wrong(
                format!("points on a grid with even steps in {name}"),
                found,
                "resample the map on a grid before the export",
            )
        })
    };
    let (x, y) = (axis("x", &xs)?, axis("y", &ys)?);
    let places = source.points(x.count, y.count)?;
    if places / PLACES_PER_POINT > xs.len() {
        return Err(source.wrong(
            format!("a complete grid of {} × {} points", x.count, y.count),
            format!("{} points", xs.len()),
            "resample the map on a grid before the export",
        ));
    }
    let mut heights_m = vec![f64::NAN; places];
    let mut taken = vec![false; places];
    for (row, ((px, py), z)) in xs.iter().zip(&ys).zip(table.column(2)).enumerate() {
        let place = y.place(*py) * x.count + x.place(*px);
        let (Some(height), Some(taken)) = (heights_m.get_mut(place), taken.get_mut(place)) else {
            continue;
        };
        if std::mem::replace(taken, true) {
            return Err(source.wrong(
                "one height for each position",
                format!("a second one at ({px}, {py}), point {}", row + 1),
                "export one scan, or cut what was measured twice",
            ));
        }
        *height = z * unit_z;
    }
    let worst = x.worst.max(y.worst);
    if worst > EVEN {
        warnings.push(Warning::from(RecordingWarning::UnevenSteps {
            worst,
            of: Steps::Place,
        }));
    }
    Ok(Read {
        kind: TopographyKind::PointText,
        heights_m,
        columns: x.count,
        step_x_m: x.step * unit_x,
        step_y_m: y.step * unit_y,
        warnings,
    })
}

fn profile(scale: &Scale<'_>, table: &Table) -> Result<Read, ReadError> {
    let source = scale.source;
    let units = table.column_units_m(source)?;
    let unit = |at: usize| units.as_ref().and_then(|units| units.get(at).copied());
    let mut warnings = Vec::new();
    let unit_x = scale.coordinate(unit(0), &mut warnings)?;
    let unit_z = scale.height(unit(1), &mut warnings)?;
    let mut xs = coordinates(source, table, 0)?;
    let mut heights = table.column(1);
    let (first, last) = match xs.as_slice() {
        [first, .., last] => (*first, *last),
        _ => return Err(source.wrong("two points or more", "one", "measure a longer line")),
    };
    // Measured towards smaller x: turned round, so that x rises.
    if last < first {
        xs.reverse();
        heights.reverse();
    }
    let step = (last - first).abs() / (xs.len() - 1) as f64;
    let mut worst: f64 = 0.0;
    for pair in xs.windows(2) {
        let [a, b] = pair else { continue };
        let off = ((b - a) / step - 1.0).abs();
        if off > GAP || off.is_nan() {
            return Err(source.wrong(
                format!("x to change by about {step} from row to row"),
                format!("a step from {a} to {b}"),
                "resample the profile in even steps before the export, or cut it there",
            ));
        }
        worst = worst.max(off);
    }
    if worst > EVEN {
        warnings.push(Warning::from(RecordingWarning::UnevenSteps {
            worst,
            of: Steps::Place,
        }));
    }
    let columns = heights.len();
    Ok(Read {
        kind: TopographyKind::ProfileText,
        heights_m: scaled(heights, unit_z),
        columns,
        step_x_m: step * unit_x,
        step_y_m: step * unit_x,
        warnings,
    })
}

/// One column. A Surfcom profile has its length in mm and then a whole number, that of its heights in µm,
/// where a column of heights would have another height with decimals.
fn heights(scale: &Scale<'_>, table: Table) -> Result<Read, ReadError> {
    let whole = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    let decimals = table.values.iter().skip(2).any(|z| z.fract() != 0.0);
    if table.header.is_empty()
        && decimals
        && whole(&table.second)
        && let Ok(count) = table.second.parse::<usize>()
    {
        return surfcom(scale, &table, count);
    }
    let mut warnings = Vec::new();
    let units = table.column_units_m(scale.source)?;
    let unit = units.and_then(|units| units.first().copied());
    let unit_z = scale.height(unit, &mut warnings)?;
    let step_m = scale.step(None, &mut warnings)?;
    let columns = table.values.len();
    Ok(Read {
        kind: TopographyKind::HeightText,
        heights_m: scaled(table.values, unit_z),
        columns,
        step_x_m: step_m,
        step_y_m: step_m,
        warnings,
    })
}

/// The stated length is that of the evaluation: each of the N heights stands for length / N. Length / (N − 1)
/// would be 1/N longer, 36 parts in a million of a usual profile, and the data do not distinguish the two. A person's step goes
/// before it, since the length may be the one that was set.
fn surfcom(scale: &Scale<'_>, table: &Table, count: usize) -> Result<Read, ReadError> {
    let found = table.values.len().saturating_sub(2);
    if count != found {
        return Err(scale.source.wrong(
            format!("{count} heights, as its second line says"),
            format!("{found}"),
            "it was cut short: copy or export it again",
        ));
    }
    let length_m = table.values.first().copied().unwrap_or(f64::NAN) * 1e-3;
    let of_header_m = length_m / count as f64;
    let mut warnings = Vec::new();
    let stated_m = scale.options.step_m.unwrap_or(of_header_m);
    if (stated_m / of_header_m - 1.0).abs() > SAME {
        warnings.push(Warning::from(RecordingWarning::Guessed {
            what: format!(
                "the given step of {stated_m:e} m was used: the header would give {of_header_m:e} m"
            ),
        }));
    }
    let step_m = scale.step(Some(stated_m), &mut warnings)?;
    let unit_m = scale.height(Some(1e-6), &mut warnings)?;
    let heights: Vec<f64> = table.values.iter().skip(2).copied().collect();
    Ok(Read {
        kind: TopographyKind::Surfcom,
        heights_m: scaled(heights, unit_m),
        columns: count,
        step_x_m: step_m,
        step_y_m: step_m,
        warnings,
    })
}
