//! Heights as an array without units: NumPy's `.npy`, and the matrix of a MATLAB file. Unit and step are stated by a person.

use piezotact::Warning;
use piezotact::recording::RecordingWarning;

use super::source::Source;
use super::{Read, TopographyKind, TopographyOptions};
use piezotact_dataset::matlab::{MatNumbers, MatValue, MatVariable, NumberClass, parse_mat};
use piezotact_dataset::{NumberTable, ReadError, parse_npy};

/// What heights are called where a file has several matrices.
const HEIGHTS: [&str; 6] = ["z", "height", "heights", "topography", "heightmap", "map"];

/// A variable with its numbers.
type Matrix<'a> = (&'a MatVariable, &'a MatNumbers);

pub(super) fn npy(source: Source<'_>, options: &TopographyOptions) -> Result<Read, ReadError> {
    let table = parse_npy(source.path, source.bytes)?;
    heights(source, options, (TopographyKind::Npy, table), Vec::new())
}

pub(super) fn mat(source: Source<'_>, options: &TopographyOptions) -> Result<Read, ReadError> {
    let file = parse_mat(source.path, source.bytes)?;
    let matrices: Vec<Matrix<'_>> = file
        .variables
        .iter()
        .filter_map(|variable| match &variable.value {
            MatValue::Numbers(numbers) => Some((variable, numbers)),
            _ => None,
        })
        .filter(|(_, numbers)| numbers.dims.len() == 2 && numbers.real.len() > 1)
        .collect();
    let of_two = |(_, numbers): &Matrix<'_>| !numbers.is_vector();
    let maps: Vec<Matrix<'_>> = matrices.iter().copied().filter(of_two).collect();
    let named =
        |(variable, _): &Matrix<'_>| HEIGHTS.contains(&variable.name.to_lowercase().as_str());
    let called: Vec<Matrix<'_>> = maps.iter().copied().filter(named).collect();
    let (variable, numbers) = match (maps.as_slice(), called.as_slice(), matrices.as_slice()) {
        ([only], _, _) | (_, [only], _) | ([], _, [only]) => *only,
        (_, _, all) => {
            let found = match all {
                [] => "none".to_owned(),
                all => all
                    .iter()
                    .map(|(variable, numbers)| {
                        let [rows, columns] = sides(numbers);
                        format!("`{}` ({rows} × {columns})", variable.name)
                    })
                    .collect::<Vec<_>>()
                    .join(", "),
            };
            return Err(source.wrong(
                "one matrix of heights, or one that is called `z` or `heights`",
                found,
                "save the heights alone: save('map.mat', 'z')",
            ));
        }
    };
    if numbers.imaginary.is_some() || numbers.class == NumberClass::Logical {
        let found = match numbers.class {
            NumberClass::Logical => "logical ones",
            _ => "complex ones",
        };
        return Err(source.wrong(
            format!("real numbers in `{}`", variable.name),
            found,
            "save the heights",
        ));
    }
    let others = file
        .variables
        .iter()
        .filter(|other| other.name != variable.name && !other.name.is_empty());
    let others: Vec<String> = others.map(|other| format!("`{}`", other.name)).collect();
    let warnings = (!others.is_empty()).then(|| {
        Warning::from(RecordingWarning::Guessed {
            what: format!(
                "`{}` is taken as the heights, and {} left out",
                variable.name,
                others.join(", ") + if others.len() > 1 { " were" } else { " was" }
            ),
        })
    });
    let [rows, columns] = sides(numbers);
    let table = match rows.min(columns) {
        1 => NumberTable {
            columns: numbers.real.len(),
            values: numbers.real.clone(),
        },
        _ => NumberTable::of_columns(rows, columns, &numbers.real),
    };
    heights(
        source,
        options,
        (TopographyKind::Mat, table),
        warnings.into_iter().collect(),
    )
}

fn sides(numbers: &MatNumbers) -> [usize; 2] {
    match numbers.dims.as_slice() {
        [rows, columns] => [*rows, *columns],
        _ => [1, numbers.real.len()],
    }
}

/// The heights of an array that states no unit and no step.
fn heights(
    source: Source<'_>,
    options: &TopographyOptions,
    (kind, table): (TopographyKind, NumberTable),
    warnings: Vec<Warning>,
) -> Result<Read, ReadError> {
    let stated = |value: Option<f64>, what: &str, how: &str| {
        let value = value.ok_or_else(|| {
            source.wrong(
                format!("the {what}"),
                "an array, which does not state it",
                format!("state it with {how}"),
            )
        })?;
        match value.is_normal() && value > 0.0 {
            true => Ok(value),
            false => Err(source.wrong(
                format!("a {what} above zero"),
                format!("{value} m"),
                "correct it",
            )),
        }
    };
    let unit_m = stated(
        options.height_unit_m,
        "unit of the heights",
        "--z-unit, such as um",
    )?;
    let step_m = stated(
        options.step_m,
        "step between points",
        "--step, such as 0.5um",
    )?;
    let columns = table.columns;
    let points = table.values.len();
    source.points(columns, points / columns.max(1))?;
    Ok(Read {
        kind,
        heights_m: table.values.into_iter().map(|z| z * unit_m).collect(),
        columns,
        step_x_m: step_m,
        step_y_m: step_m,
        warnings,
    })
}
