//! SDF, the surface data file of ISO 25178-71, as text and binary. Lengths are in m.

use super::source::{Number, Order, Source};
use super::{Read, TopographyKind};
use piezotact_dataset::ReadError;

const TEXT: [&[u8]; 2] = [b"aISO-1.0", b"aBCR-1.0"];
const BINARY: [&[u8]; 2] = [b"bISO-1.0", b"bBCR-1.0"];
/// Where the binary heights begin: the magic word and the fields of the header.
const HEIGHTS: usize = 81;

pub(super) fn is_sdf(bytes: &[u8]) -> bool {
    TEXT.iter()
        .chain(&BINARY)
        .any(|magic| bytes.starts_with(magic))
}

/// What both forms say in their header.
struct Header {
    points: usize,
    profiles: usize,
    step_x_m: f64,
    step_y_m: f64,
    scale_m: f64,
    compression: usize,
    data_type: usize,
}

pub(super) fn read(source: Source<'_>) -> Result<Read, ReadError> {
    if BINARY.iter().any(|magic| source.bytes.starts_with(magic)) {
        let little = Order::Little;
        let header = Header {
            points: source.u16(42, little)?.into(),
            profiles: source.u16(44, little)?.into(),
            step_x_m: source.f64(46, little)?,
            step_y_m: source.f64(54, little)?,
            scale_m: source.f64(62, little)?,
            compression: source.u8(78)?.into(),
            data_type: source.u8(79)?.into(),
        };
        let (number, marker) = header.number(source)?;
        let points = source.points(header.points, header.profiles)?;
        let data = source.numbers(HEIGHTS, points, number)?;
        let heights = number.decode(data, little);
        header.scaled(source, TopographyKind::SdfBinary, heights, marker)
    } else {
        read_text(source)
    }
}

fn read_text(source: Source<'_>) -> Result<Read, ReadError> {
    let text: String = source.bytes.iter().map(|byte| char::from(*byte)).collect();
    let mut parts = text.split('*');
    let (head, body) = match (parts.next(), parts.next()) {
        (Some(head), Some(body)) => (head, body),
        _ => {
            return Err(source.wrong(
                "a header that ends with `*`",
                "no `*`",
                "copy or export it again",
            ));
        }
    };
    let value = |key: &str| -> Option<&str> {
        head.lines().find_map(|line| {
            let (name, value) = line.split_once('=')?;
            (name.trim() == key).then(|| value.trim())
        })
    };
    let missing = |key: &str| {
        source.wrong(
            format!("a number for `{key}` in the header"),
            value(key).map_or("nothing".to_owned(), |value| format!("`{value}`")),
            "export it again",
        )
    };
    let whole = |key: &str| -> Result<usize, ReadError> {
        value(key)
            .and_then(|value| value.parse().ok())
            .ok_or_else(|| missing(key))
    };
    let real = |key: &str| -> Result<f64, ReadError> {
        value(key)
            .and_then(|value| value.parse().ok())
            .ok_or_else(|| missing(key))
    };
    let header = Header {
        points: whole("NumPoints")?,
        profiles: whole("NumProfiles")?,
        step_x_m: real("Xscale")?,
        step_y_m: real("Yscale")?,
        scale_m: real("Zscale")?,
        compression: whole("Compression").unwrap_or(0),
        data_type: whole("DataType")?,
    };
    let (_, marker) = header.number(source)?;
    let points = source.points(header.points, header.profiles)?;
    let mut heights = Vec::new();
    for word in body.split_whitespace() {
        heights.push(match word.parse() {
            Ok(height) => height,
            Err(_) if word.eq_ignore_ascii_case("BAD") => f64::NAN,
            Err(_) => {
                return Err(source.wrong(
                    "a number or BAD",
                    format!("`{word}` as height {}", heights.len() + 1),
                    "repair the file or export it again",
                ));
            }
        });
    }
    if heights.len() != points {
        return Err(source.wrong(
            format!(
                "{points} heights ({} × {}), as the header says",
                header.points, header.profiles
            ),
            format!("{}", heights.len()),
            "it was cut short or its header is damaged: copy or export it again",
        ));
    }
    header.scaled(source, TopographyKind::SdfText, heights, marker)
}

impl Header {
    /// How heights are stored, and the value that stands for a point that was not measured.
    fn number(&self, source: Source<'_>) -> Result<(Number, Option<f64>), ReadError> {
        if self.compression != 0 {
            return Err(source.wrong(
                "heights that are not compressed",
                format!("compression {}", self.compression),
                "export it without compression",
            ));
        }
        Ok(match self.data_type {
            0 => (Number::U8, None),
            1 => (Number::U16, Some(f64::from(u16::MAX))),
            2 => (Number::U32, Some(f64::from(u32::MAX))),
            3 => (Number::F32, None),
            4 => (Number::I8, None),
            5 => (Number::I16, Some(f64::from(i16::MIN))),
            6 => (Number::I32, Some(f64::from(i32::MIN))),
            7 => (Number::F64, None),
            other => {
                return Err(source.wrong(
                    "a data type from 0 to 7",
                    format!("{other}"),
                    "copy or export it again",
                ));
            }
        })
    }

    fn scaled(
        self,
        source: Source<'_>,
        kind: TopographyKind,
        mut heights_m: Vec<f64>,
        marker: Option<f64>,
    ) -> Result<Read, ReadError> {
        if !self.scale_m.is_normal() {
            return Err(source.wrong(
                "a scale of the heights",
                format!("{}", self.scale_m),
                "export it again",
            ));
        }
        let marker = marker.map(f64::to_bits);
        for z in &mut heights_m {
            *z = if Some(z.to_bits()) == marker {
                f64::NAN
            } else {
                *z * self.scale_m
            };
        }
        Ok(Read {
            kind,
            heights_m,
            columns: self.points,
            step_x_m: self.step_x_m,
            step_y_m: self.step_y_m,
            warnings: Vec::new(),
        })
    }
}
