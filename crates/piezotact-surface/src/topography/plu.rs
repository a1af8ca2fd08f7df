//! PLU of Sensofar's profilers: a fixed header without a magic word, then layers of 32-bit floats in µm.

use piezotact::Warning;
use piezotact::recording::RecordingWarning;

use super::source::{Number, Order, Source};
use super::{Read, TopographyKind};
use piezotact_dataset::ReadError;

const STEP_X: usize = 404;
const STEP_Y: usize = 408;
const TYPE: usize = 428;
const LAYERS: usize = 489;
const ROWS: usize = 500;
const COLUMNS: usize = 504;
const HEIGHTS: usize = 508;
/// Stands for a point that was not measured.
const NOT_MEASURED: f64 = 1_000_001.0;
const TOPOGRAPHY: u32 = 3;

/// A date such as `Fri Mar 10 16:35:59 2023`, padded with NUL to 128 bytes, opens the file.
pub(super) fn is_plu(source: Source<'_>) -> bool {
    let Ok(date) = source.slice("", 0, 128) else {
        return false;
    };
    let word = |at: usize| {
        date.get(at..at + 3)
            .is_some_and(|word| word.iter().all(u8::is_ascii_alphabetic))
            && date.get(at + 3) == Some(&b' ')
    };
    word(0) && word(4) && date.get(24..).is_some_and(|rest| rest.contains(&0))
}

pub(super) fn read(source: Source<'_>) -> Result<Read, ReadError> {
    let little = Order::Little;
    let kind = source.u32(TYPE, little)?;
    if kind != TOPOGRAPHY {
        return Err(source.wrong(
            "a Sensofar file of type 3, a topography",
            format!("type {kind}"),
            "export it as SUR, SDF or text",
        ));
    }
    let layers = source.u8(LAYERS)?;
    if layers == 0 {
        return Err(source.wrong(
            "a layer of heights",
            "none",
            "export it with its topography",
        ));
    }
    let mut warnings = Vec::new();
    if layers > 1 {
        warnings.push(Warning::from(RecordingWarning::Guessed {
            what: format!("the file holds {layers} layers and the first was read"),
        }));
    }
    let columns = source.u32(COLUMNS, little)? as usize;
    let points = source.points(columns, source.u32(ROWS, little)? as usize)?;
    let data = source.numbers(HEIGHTS, points, Number::F32)?;
    let mut heights_m = Number::F32.decode(data, little);
    for z in &mut heights_m {
        *z = if z.to_bits() == NOT_MEASURED.to_bits() {
            f64::NAN
        } else {
            *z * 1e-6
        };
    }
    Ok(Read {
        kind: TopographyKind::Plu,
        heights_m,
        columns,
        step_x_m: source.f32(STEP_X, little)? * 1e-6,
        step_y_m: source.f32(STEP_Y, little)? * 1e-6,
        warnings,
    })
}
