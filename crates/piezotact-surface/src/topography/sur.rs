//! SUR of Digital Surf's Mountains and of many instruments: a header of 512 bytes, a comment, a private part,
//! then the heights as whole numbers of 16 or 32 bits. Read plain and compressed, written plain.

use piezotact::recording::RecordingWarning;
use std::io::{Read as _, Write as _};
use std::path::Path;

use flate2::read::ZlibDecoder;
use piezotact::Warning;
use piezotact::surface::HeightMap;

use super::source::{Number, Order, Source, unit_m};
use super::{Read, TopographyKind};
use piezotact_dataset::write_atomically;
use piezotact_dataset::{ReadError, WriteError};

pub(super) const MAGIC: &[u8] = b"DIGITAL SURF";
pub(super) const MAGIC_COMPRESSED: &[u8] = b"DSCOMPRESSED";

const HEADER: usize = 512;
const OBJECTS: usize = 14;
const TYPE: usize = 18;
const SPECIAL_POINTS: usize = 86;
const BITS: usize = 98;
const LOWEST: usize = 100;
const HIGHEST: usize = 104;
const COLUMNS: usize = 108;
const ROWS: usize = 112;
const POINTS: usize = 116;
const STEP_X: usize = 120;
const STEP_Y: usize = 124;
const STEP_Z: usize = 128;
const NAMES: usize = 132;
const STEP_UNITS: usize = 180;
const AXIS_UNITS: usize = 228;
const UNIT_RATIOS: usize = 276;
const INVERSION: usize = 290;
const COMMENT_SIZE: usize = 334;
const PRIVATE_SIZE: usize = 336;
const OFFSET_Z: usize = 474;
const NAME_LENGTH: usize = 16;

const PROFILE: u16 = 1;
const SURFACE: u16 = 2;
/// Types whose first object is a surface, followed by its pictures.
const SURFACE_WITH_PICTURE: [u16; 2] = [11, 13];
/// The stored value of a point that was not measured lies this far below the lowest.
const NOT_MEASURED_BELOW: f64 = 2.0;
/// More pieces than this are no compressed heights but a damaged file.
const MOST_PIECES: u32 = 1 << 16;

pub(super) fn read(source: Source<'_>) -> Result<Read, ReadError> {
    let (order, number) = storage(source)?;
    let kind = if source.bytes.starts_with(MAGIC_COMPRESSED) {
        TopographyKind::SurCompressed
    } else {
        TopographyKind::Sur
    };
    let mut warnings = Vec::new();
    let (object, objects) = (source.u16(TYPE, order)?, source.u16(OBJECTS, order)?);
    if SURFACE_WITH_PICTURE.contains(&object) {
        warnings.push(Warning::from(RecordingWarning::Guessed {
            what: format!("the file holds {objects} objects and the first was read as the heights"),
        }));
    } else if ![PROFILE, SURFACE].contains(&object) {
        return Err(source.wrong(
            "a profile or a surface (type 1 or 2)",
            format!("type {object}, a series or a picture"),
            "export the one surface as SUR",
        ));
    } else if objects > 1 {
        warnings.push(Warning::from(RecordingWarning::Guessed {
            what: format!("the file holds {objects} objects and the first was read"),
        }));
    }
    let count = |offset| -> Result<usize, ReadError> {
        Ok(usize::try_from(source.i32(offset, order)?).unwrap_or(0))
    };
    let (columns, rows) = (count(COLUMNS)?, count(ROWS)?);
    let points = source.points(columns, rows)?;
    let promised = source.u32(POINTS, order)? as usize;
    if promised != points {
        return Err(source.wrong(
            format!("{columns} × {rows} points"),
            format!("a header that states {promised}"),
            "its header is damaged: copy or export it again",
        ));
    }
    let start = HEADER
        + usize::from(source.u16(COMMENT_SIZE, order)?)
        + usize::from(source.u16(PRIVATE_SIZE, order)?);
    let unpacked;
    let data = if kind == TopographyKind::SurCompressed {
        unpacked = unpack(source, start, points * number.size(), order)?;
        unpacked.as_slice()
    } else {
        source.numbers(start, points, number)?
    };

    let lowest = f64::from(source.i32(LOWEST, order)?);
    let special = source.u16(SPECIAL_POINTS, order)? == 1;
    let marker = lowest - NOT_MEASURED_BELOW;
    let step_m = |axis: usize, offset: usize| -> Result<f64, ReadError> {
        Ok(source.f32(offset, order)? * unit_of_step_m(source, axis, order)?)
    };
    let step_z_m = step_m(2, STEP_Z)?;
    if !step_z_m.is_normal() {
        return Err(source.wrong(
            "a step of the heights",
            format!("{step_z_m} m"),
            "export it again",
        ));
    }
    let offset_m = source.f32(OFFSET_Z, order)? * axis_unit_m(source, 2)?.unwrap_or(step_z_m);
    let mut heights_m = number.decode(data, order);
    for z in &mut heights_m {
        *z = if special && z.to_bits() == marker.to_bits() {
            f64::NAN
        } else {
            z.mul_add(step_z_m, offset_m)
        };
    }
    turn_back(
        source.u16(INVERSION, order)?,
        &mut heights_m,
        columns,
        &mut warnings,
    );
    Ok(Read {
        kind,
        heights_m,
        columns,
        step_x_m: step_m(0, STEP_X)?,
        step_y_m: step_m(1, STEP_Y)?,
        warnings,
    })
}

/// The order of bytes and the size of a height: the size is 16 or 32 in only one of the two orders.
fn storage(source: Source<'_>) -> Result<(Order, Number), ReadError> {
    for order in [Order::Little, Order::Big] {
        match source.u16(BITS, order)? {
            16 => return Ok((order, Number::I16)),
            32 => return Ok((order, Number::I32)),
            _ => {}
        }
    }
    Err(source.wrong(
        "heights of 16 or 32 bits",
        format!("{}", source.u16(BITS, Order::Little)?),
        "its header is damaged: copy or export it again",
    ))
}

fn axis_unit_m(source: Source<'_>, axis: usize) -> Result<Option<f64>, ReadError> {
    Ok(unit_m(
        &source.text(AXIS_UNITS + axis * NAME_LENGTH, NAME_LENGTH)?,
    ))
}

/// What a step of 1 is in m: its own unit, or else the axis' unit over the ratio of the two.
fn unit_of_step_m(source: Source<'_>, axis: usize, order: Order) -> Result<f64, ReadError> {
    let name = source.text(STEP_UNITS + axis * NAME_LENGTH, NAME_LENGTH)?;
    if let Some(unit) = unit_m(&name) {
        return Ok(unit);
    }
    let ratio = source.f32(UNIT_RATIOS + axis * 4, order)?;
    axis_unit_m(source, axis)?
        .filter(|_| name.is_empty() && ratio.is_normal())
        .map(|unit| unit / ratio)
        .ok_or_else(|| {
            source.wrong(
                "units of length on all three axes",
                format!("`{name}`"),
                "export heights, not another quantity",
            )
        })
}

/// Heights that the writer turned over are turned back.
fn turn_back(flag: u16, heights_m: &mut [f64], columns: usize, warnings: &mut Vec<Warning>) {
    let how = match flag {
        1 => "",
        2 => " and mirrored left to right",
        3 => " and mirrored top to bottom",
        _ => return,
    };
    warnings.push(Warning::from(RecordingWarning::Guessed {
        what: format!("the header says that the heights were inverted{how}, and this was undone"),
    }));
    for z in heights_m.iter_mut() {
        *z = -*z;
    }
    match flag {
        2 => heights_m
            .chunks_exact_mut(columns.max(1))
            .for_each(<[f64]>::reverse),
        3 => {
            heights_m.reverse();
            heights_m
                .chunks_exact_mut(columns.max(1))
                .for_each(<[f64]>::reverse);
        }
        _ => {}
    }
}

/// The heights of a compressed file: the number of pieces, for each its length unpacked and packed, then the
/// pieces, each a zlib stream.
fn unpack(
    source: Source<'_>,
    start: usize,
    expected: usize,
    order: Order,
) -> Result<Vec<u8>, ReadError> {
    let damaged = |found: String| {
        source.wrong(
            format!("{expected} bytes of compressed heights"),
            found,
            "copy it again, or save it without compression",
        )
    };
    let pieces = source.u32(start, order)?;
    if pieces > MOST_PIECES {
        return Err(damaged(format!("{pieces} pieces")));
    }
    let directory = start.saturating_add(4);
    let mut at = directory.saturating_add(pieces as usize * 8);
    let mut data = Vec::new();
    for piece in 0..pieces as usize {
        let packed = source.u32(directory + piece * 8 + 4, order)? as usize;
        let stream = source.slice("compressed heights", at, packed)?;
        let room = expected.saturating_sub(data.len()) as u64;
        // One byte more than fits shows a piece that is too long.
        ZlibDecoder::new(stream)
            .take(room + 1)
            .read_to_end(&mut data)
            .map_err(|error| damaged(error.to_string()))?;
        if data.len() > expected {
            return Err(damaged("more".into()));
        }
        at = at.saturating_add(packed);
    }
    if data.len() != expected {
        return Err(damaged(format!("{}", data.len())));
    }
    Ok(data)
}

/// Writes a height map as SUR with 32-bit heights in µm, whole or not at all. Points that were not measured
/// are marked as the format has it. Heights keep 1/2³⁰ of their range, steps 7 decimals.
///
/// # Errors
/// [`WriteError`] when the map is too large for the format or the operating system refuses.
pub fn write_sur(path: &Path, map: &HeightMap) -> Result<(), WriteError> {
    let too_large = |what: &str, found: String| {
        WriteError::content(path, what, found, "cut the map, or check its units")
    };
    let size = |count: usize| {
        i32::try_from(count)
            .ok()
            .ok_or_else(|| too_large("fewer than 2³¹ points to a side", format!("{count}")))
    };
    let (columns, rows) = (size(map.columns())?, size(map.rows())?);
    let points = u32::try_from(map.heights_m().len()).ok().ok_or_else(|| {
        too_large(
            "fewer than 2³² points",
            format!("{}", map.heights_m().len()),
        )
    })?;
    let um = |value_m: f64| {
        let value = (value_m * 1e6) as f32;
        if value.is_finite() {
            Ok(value)
        } else {
            Err(too_large("lengths below 1e32 m", format!("{value_m} m")))
        }
    };
    let measured = map.heights_m().iter().filter(|z| !z.is_nan());
    let (low, high) = measured.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), z| {
        (low.min(*z), high.max(*z))
    });
    // Heights count from the offset as the file has it, so that its rounding costs nothing; one ulp lower,
    // so that none is below.
    let offset = um(low)?.next_down();
    let range = high * 1e6 - f64::from(offset);
    let step = ((range / f64::from(1 << 30)) as f32).max(f32::MIN_POSITIVE);
    um(range * 1e-6)?;
    let stored = |z_m: f64| -> i32 {
        if z_m.is_nan() {
            -NOT_MEASURED_BELOW as i32
        } else {
            ((z_m * 1e6 - f64::from(offset)) / f64::from(step)).round() as i32
        }
    };

    let mut header = [0_u8; HEADER];
    let mut put = |offset: usize, bytes: &[u8]| {
        for (to, from) in header.iter_mut().skip(offset).zip(bytes) {
            *to = *from;
        }
    };
    put(0, MAGIC);
    for (offset, value) in [
        (OBJECTS, 1_u16),
        (16, 1),
        (TYPE, SURFACE),
        (SPECIAL_POINTS, u16::from(map.missing_share() > 0.0)),
        (88, 1),
        (BITS, 32),
    ] {
        put(offset, &value.to_le_bytes());
    }
    put(20, &[b' '; 60]);
    for (offset, value) in [
        (LOWEST, 0),
        (HIGHEST, stored(high)),
        (COLUMNS, columns),
        (ROWS, rows),
    ] {
        put(offset, &value.to_le_bytes());
    }
    put(POINTS, &points.to_le_bytes());
    for (offset, value) in [
        (STEP_X, um(map.step_x_m())?),
        (STEP_Y, um(map.step_y_m())?),
        (STEP_Z, step),
        (UNIT_RATIOS, 1.0),
        (UNIT_RATIOS + 4, 1.0),
        (UNIT_RATIOS + 8, 1.0),
        (OFFSET_Z, offset),
    ] {
        put(offset, &value.to_le_bytes());
    }
    for (axis, name) in [b'X', b'Y', b'Z'].into_iter().enumerate() {
        let at = axis * NAME_LENGTH;
        put(NAMES + at, &[b' '; NAME_LENGTH]);
        put(NAMES + at, &[name]);
        for units in [STEP_UNITS, AXIS_UNITS] {
            put(units + at, &[b' '; NAME_LENGTH]);
            // Latin-1, as the format has it.
            put(units + at, &[0xB5, b'm']);
        }
    }
    write_atomically(path, |file| {
        let mut write = |bytes: &[u8]| file.write_all(bytes).map_err(WriteError::io(path));
        write(&header)?;
        for z in map.heights_m() {
            write(&stored(*z).to_le_bytes())?;
        }
        Ok(())
    })
}
