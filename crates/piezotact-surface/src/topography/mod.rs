//! Topographies that instruments and their programs write, read into heights in m.
//!
//! [`read_topography`] is the one door: what a file is stands in its content, not in its name. Points that
//! were not measured become NaN, whatever marks them in the file. A text that does not state its scale is
//! refused until a person states it: a wrong guess would be wrong by a factor of a thousand, and look right.

mod al3d;
mod array;
mod bcr;
mod grid;
mod plu;
mod sdf;
mod source;
mod sur;
mod surfcom;
mod table;
mod text;
mod x3p;

use crate::roughness::{
    HeightProfile, HeightsFault, InstrumentSettings, ProfileKind, SurfaceWarning, Topography,
};
use std::path::Path;

use piezotact::Warning;
use piezotact::surface::{HeightMap, SurfaceError};

use piezotact_dataset::ReadError;
use piezotact_dataset::format::{self, Format, Recognition};
use piezotact_dataset::is_npy;
use piezotact_dataset::matlab::looks_like_mat;
use source::Source;

pub use sur::write_sur;

/// Heights beyond this, in m, are a marker for points that were not measured, or a wrong unit.
const HIGHEST_M: f64 = 10.0;
/// Points further apart than this, in m, have a wrong unit.
const WIDEST_STEP_M: f64 = 1.0;
/// Files beyond this many bytes are not read into memory.
const LARGEST_FILE: u64 = 4 << 30;

/// What a person adds to a text or an array that does not state its scale. Other binary formats state theirs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TopographyOptions {
    /// The step between points in m, for heights without coordinates.
    pub step_m: Option<f64>,
    /// What a coordinate of 1 stands for, in m, for columns of coordinates that name no unit.
    pub coordinate_unit_m: Option<f64>,
    /// What a height of 1 stands for, in m, for heights that name no unit.
    pub height_unit_m: Option<f64>,
}

/// What kind of file a topography was read from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TopographyKind {
    /// Digital Surf, plain.
    Sur,
    /// Digital Surf, compressed.
    SurCompressed,
    /// ISO 25178-72.
    X3p,
    /// Sensofar.
    Plu,
    /// Alicona.
    Al3d,
    /// BCR-STM, whole numbers.
    BcrStm,
    /// BCRF, floating point.
    Bcrf,
    /// ISO 25178-71, text.
    SdfText,
    /// ISO 25178-71, binary.
    SdfBinary,
    /// Columns x, y, z.
    PointText,
    /// Heights row by row.
    MatrixText,
    /// Columns x, z.
    ProfileText,
    /// One column of heights.
    HeightText,
    /// Surfcom: length, number, heights.
    Surfcom,
    /// An array of NumPy.
    Npy,
    /// A matrix in a MATLAB file.
    Mat,
}

impl std::fmt::Display for TopographyKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Sur => "SUR (Digital Surf)",
            Self::SurCompressed => "SUR (Digital Surf), compressed",
            Self::X3p => "X3P (ISO 25178-72)",
            Self::Plu => "PLU (Sensofar)",
            Self::Al3d => "AL3D (Alicona)",
            Self::BcrStm => "BCR-STM",
            Self::Bcrf => "BCRF",
            Self::SdfText => "SDF (ISO 25178-71), text",
            Self::SdfBinary => "SDF (ISO 25178-71), binary",
            Self::PointText => "text with columns x, y, z",
            Self::MatrixText => "text with a matrix of heights",
            Self::ProfileText => "text with columns x, z",
            Self::HeightText => "text with one column of heights",
            Self::Surfcom => "Surfcom profile",
            Self::Npy => "NPY (NumPy)",
            Self::Mat => "MAT (MATLAB)",
        })
    }
}

/// A topography, the kind of file it came from, and its warnings.
#[derive(Clone, Debug, PartialEq)]
pub struct TopographyFile {
    /// The heights in m. The first row of a map is the first in the file; of x-y-z columns, that of the
    /// smallest y.
    pub topography: Topography,
    /// The kind of file.
    pub kind: TopographyKind,
    /// What kind of profile it is, where the file says.
    pub profile_kind: Option<ProfileKind>,
    /// What the instrument states of it in a file beside it (`.tx3`).
    pub instrument: Option<InstrumentSettings>,
    /// What a person should know before relying on it.
    pub warnings: Vec<Warning>,
}

/// Reads the height map or profile in `path`, in m, whatever kind of file it is.
///
/// # Errors
/// [`ReadError`] naming the file, what was expected, what was found, and what to do.
pub fn read_topography(
    path: &Path,
    options: &TopographyOptions,
) -> Result<TopographyFile, ReadError> {
    let length = std::fs::metadata(path)
        .map_err(|error| ReadError::io(path, &error))?
        .len();
    if length > LARGEST_FILE {
        return Err(ReadError::content(
            path,
            "a topography of at most 4 GiB",
            format!("{length} bytes"),
            "cut the map into parts",
        ));
    }
    let bytes = piezotact_dataset::read_input(path)?;
    surfcom::with_settings(parse_topography(path, &bytes, options)?, path, options)
}

/// The topography in `bytes`; `path` is only named in errors.
///
/// # Errors
/// As [`read_topography`].
pub fn parse_topography(
    path: &Path,
    bytes: &[u8],
    options: &TopographyOptions,
) -> Result<TopographyFile, ReadError> {
    let source = Source { path, bytes };
    if bytes.is_empty() {
        return Err(source.wrong("a topography", "an empty file", "copy or export it again"));
    }
    match format::recognise_bytes(&TOPOGRAPHIES, path, bytes) {
        Some(format) => (format.read)(source, options)?.finish(source),
        None => text::read(source, options)?.finish(source),
    }
}

/// What reads a topography.
type Reader = fn(Source<'_>, &TopographyOptions) -> Result<Read, ReadError>;

/// The formats of topographies, in the order in which they are looked for; a kind is the usual one of its format.
static TOPOGRAPHIES: [Format<TopographyKind, Reader>; 9] = [
    Format {
        kind: TopographyKind::Sur,
        label: "SUR",
        endings: &["sur", "pro"],
        sniff: Recognition::Head(|head| {
            head.starts_with(sur::MAGIC) || head.starts_with(sur::MAGIC_COMPRESSED)
        }),
        read: |source, _| sur::read(source),
    },
    Format {
        kind: TopographyKind::X3p,
        label: "X3P",
        endings: &["x3p"],
        sniff: Recognition::Head(|head| head.starts_with(b"PK\x03\x04")),
        read: |source, _| x3p::read(source),
    },
    Format {
        kind: TopographyKind::Al3d,
        label: "AL3D",
        endings: &["al3d"],
        sniff: Recognition::Head(|head| head.starts_with(al3d::MAGIC)),
        read: |source, _| al3d::read(source),
    },
    Format {
        kind: TopographyKind::BcrStm,
        label: "BCR",
        endings: &["bcr", "bcrf"],
        sniff: Recognition::Head(bcr::is_bcr),
        read: |source, _| bcr::read(source),
    },
    Format {
        kind: TopographyKind::SdfText,
        label: "SDF",
        endings: &["sdf"],
        sniff: Recognition::Head(sdf::is_sdf),
        read: |source, _| sdf::read(source),
    },
    Format {
        kind: TopographyKind::Plu,
        label: "PLU",
        endings: &["plu"],
        sniff: Recognition::Whole(|path, bytes| plu::is_plu(Source { path, bytes })),
        read: |source, _| plu::read(source),
    },
    Format {
        kind: TopographyKind::Npy,
        label: "NPY",
        endings: &["npy"],
        sniff: Recognition::Head(is_npy),
        read: array::npy,
    },
    Format {
        kind: TopographyKind::Mat,
        label: "MAT",
        endings: &["mat"],
        sniff: Recognition::Whole(|_, bytes| looks_like_mat(bytes)),
        read: array::mat,
    },
    // A text that is nothing else, with a point, a row or a height in each line: this row stays the last one.
    Format {
        kind: TopographyKind::PointText,
        label: "text",
        endings: &["txt", "csv", "xyz", "tx1", "tx2"],
        sniff: Recognition::Head(|_| true),
        read: text::read,
    },
];

/// The formats of topographies that can be read, for people: `SUR, X3P, text`.
#[must_use]
pub fn topography_formats() -> String {
    format::list(&TOPOGRAPHIES, ", ")
}

/// What a reader found, before it is known to make a surface.
struct Read {
    kind: TopographyKind,
    heights_m: Vec<f64>,
    /// Points to a row; a file with one row is a profile.
    columns: usize,
    step_x_m: f64,
    step_y_m: f64,
    warnings: Vec<Warning>,
}

impl Read {
    fn finish(self, source: Source<'_>) -> Result<TopographyFile, ReadError> {
        let Self {
            kind,
            mut heights_m,
            columns,
            step_x_m,
            step_y_m,
            mut warnings,
        } = self;
        // Some instruments store a point that was not measured as an infinite height.
        for z in heights_m.iter_mut().filter(|z| z.is_infinite()) {
            *z = f64::NAN;
        }
        if let Some((at, found)) = heights_m
            .iter()
            .enumerate()
            .find(|(_, z)| z.is_finite() && z.abs() > HIGHEST_M)
        {
            return Err(source.wrong(
                format!("heights within ±{HIGHEST_M} m"),
                format!("{found:e} m at point {at}"),
                "if it stands for a point that was not measured, export such points as NaN; else check the unit of the heights",
            ));
        }
        if let Some(step_m) = [step_x_m, step_y_m]
            .into_iter()
            .find(|step_m| *step_m > WIDEST_STEP_M)
        {
            return Err(source.wrong(
                format!("steps between points of at most {WIDEST_STEP_M} m"),
                format!("{step_m:e} m"),
                "check the unit of the steps",
            ));
        }
        let surface = |error: SurfaceError| ReadError::of(source.path)(error);
        let topography = if heights_m.len() == columns {
            if let Some(at) = heights_m.iter().position(|z| z.is_nan()) {
                return Err(source.wrong(
                    "a profile without gaps",
                    format!("point {at} not measured"),
                    "fill its gaps before the export, or cut it there",
                ));
            }
            Topography::Profile(HeightProfile::new(heights_m, step_x_m).map_err(surface)?)
        } else {
            let map = HeightMap::new(heights_m, columns, step_x_m, step_y_m).map_err(surface)?;
            let share = map.missing_share();
            if share > 0.0 {
                warnings.push(Warning::from(SurfaceWarning::Heights {
                    fault: HeightsFault::Missing { share },
                }));
            }
            Topography::Map(map)
        };
        Ok(TopographyFile {
            topography,
            kind,
            profile_kind: None,
            instrument: None,
            warnings,
        })
    }
}
