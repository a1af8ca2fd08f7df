//! X3P of ISO 25178-72: a zip with `main.xml`, the heights in it or as a binary file, in m, and checksums.

use piezotact::recording::RecordingWarning;
use std::io::{Cursor, Read as _};

use md5::{Digest as _, Md5};
use piezotact::Warning;
use roxmltree::{Document, Node, ParsingOptions};
use zip::ZipArchive;

use super::source::{Number, Order, Source};
use super::{Read, TopographyKind};
use piezotact_dataset::ReadError;

const MAIN: &str = "main.xml";
/// A longer description than this is none; one with heights has three nodes for each.
const LONGEST_XML: u64 = 32 << 20;
const MOST_NODES: u32 = 1 << 21;

struct Archive<'a> {
    source: Source<'a>,
    zip: ZipArchive<Cursor<&'a [u8]>>,
    /// Where `main.xml` is: empty, or a folder with its `/`.
    folder: String,
}

impl<'a> Archive<'a> {
    /// The archive with its `main.xml`, which some programs put into a folder.
    fn open(source: Source<'a>) -> Result<Self, ReadError> {
        let zip = ZipArchive::new(Cursor::new(source.bytes)).map_err(|error| {
            source.wrong(
                "an X3P file, a zip archive",
                error.to_string(),
                "copy or export it again",
            )
        })?;
        // macOS adds a folder of its own, with the names of the others.
        let names: Vec<String> = (zip.file_names())
            .filter_map(|name| Some(name.ok()?.into_owned()))
            .filter(|name| !name.starts_with("__MACOSX/"))
            .collect();
        let names = || names.iter().map(String::as_str);
        let mains: Vec<&str> = names()
            .filter(|name| name.rsplit('/').next() == Some(MAIN))
            .collect();
        let main = match mains.as_slice() {
            [only] => *only,
            several if several.contains(&MAIN) => MAIN,
            [] if names().any(|name| name.starts_with("xl/")) => {
                return Err(source.wrong(
                    "a topography",
                    "an Excel workbook (XLSX)",
                    "save its sheet of heights as CSV, or export the measurement as SUR or X3P",
                ));
            }
            [] => {
                let some: Vec<&str> = names().take(5).collect();
                return Err(source.wrong(
                    format!("an X3P file, a zip archive with `{MAIN}`"),
                    format!("a zip archive of {} files: {}", zip.len(), some.join(", ")),
                    "give the topography in it, or export it again as X3P or SUR",
                ));
            }
            several => {
                return Err(source.wrong(
                    format!("one `{MAIN}` in the archive"),
                    several.join(", "),
                    "put each surface into an X3P file of its own",
                ));
            }
        };
        let folder = main.trim_end_matches(MAIN).to_owned();
        Ok(Self {
            source,
            zip,
            folder,
        })
    }

    /// A file of the archive, of at most `most` bytes.
    fn file(&mut self, name: &str, most: u64) -> Result<Vec<u8>, ReadError> {
        let Self {
            source,
            zip,
            folder,
        } = self;
        let wrong = |found: String| {
            source.wrong(
                format!("`{name}` of at most {most} bytes in the archive"),
                found,
                "copy it again, or export it again as X3P or SUR",
            )
        };
        let name = format!("{folder}{}", name.trim_start_matches("./"));
        let file = zip
            .by_name(&name)
            .map_err(|error| wrong(error.to_string()))?;
        let mut bytes = Vec::new();
        file.take(most.saturating_add(1))
            .read_to_end(&mut bytes)
            .map_err(|error| wrong(error.to_string()))?;
        if bytes.len() as u64 > most {
            return Err(wrong("more".into()));
        }
        Ok(bytes)
    }

    /// The warning that `main.xml` is not the one that was written, by its checksum.
    fn changed(&mut self, description: &Description<'_, '_, '_>, main: &[u8]) -> Option<Warning> {
        let line = self
            .file(description.text("ChecksumFile")?, LONGEST_XML)
            .ok()?;
        let stated = checksum(&String::from_utf8_lossy(&line))?;
        (stated != digest(main)).then(|| {
            Warning::from(RecordingWarning::Guessed {
                what: "the checksum of `main.xml` does not match: it was changed after the file was written; its steps and units \
                     were used"
                    .into(),
            })
        })
    }

    /// The stored numbers of a grid of `columns` × `rows`, from the binary file or else the XML.
    fn heights(
        &mut self,
        description: &Description<'_, '_, '_>,
        [columns, rows]: [usize; 2],
        number: Number,
    ) -> Result<Vec<f64>, ReadError> {
        let source = self.source;
        let points = source.points(columns, rows)?;
        let Some(link) = description.text("PointDataLink") else {
            return description.heights(points);
        };
        let expected = points * number.size();
        let data = self.file(link, expected as u64)?;
        if data.len() != expected {
            return Err(source.wrong(
                format!("{expected} bytes of heights ({columns} × {rows})"),
                format!("{}", data.len()),
                "copy or export it again",
            ));
        }
        if let Some(stated) = description.text("MD5ChecksumPointData").and_then(checksum)
            && stated != digest(&data)
        {
            return Err(source.wrong(
                format!("heights with the checksum {stated}"),
                digest(&data),
                "they are not the heights that were written: copy or export it again",
            ));
        }
        Ok(number.decode(&data, Order::Little))
    }

    /// Points that the mask `link` of the archive calls not measured become NaN.
    fn mark_unmeasured(&mut self, link: &str, heights_m: &mut [f64]) -> Result<(), ReadError> {
        let length = heights_m.len().div_ceil(8);
        let valid = self.file(link, length as u64)?;
        if valid.len() != length {
            return Err(self.source.wrong(
                format!("{length} bytes that say which points were measured"),
                format!("{}", valid.len()),
                "copy or export it again",
            ));
        }
        let bits = valid
            .iter()
            .flat_map(|byte| (0..8).map(move |bit| byte >> bit & 1));
        for (z, bit) in heights_m.iter_mut().zip(bits) {
            if bit == 0 {
                *z = f64::NAN;
            }
        }
        Ok(())
    }
}

pub(super) fn read(source: Source<'_>) -> Result<Read, ReadError> {
    let mut archive = Archive::open(source)?;
    let main = archive.file(MAIN, LONGEST_XML)?;
    let text = String::from_utf8_lossy(&main);
    let options = ParsingOptions {
        nodes_limit: MOST_NODES,
        ..ParsingOptions::default()
    };
    let document = Document::parse_with_options(text.trim_start_matches('\u{feff}'), options)
        .map_err(|error| {
            source.wrong(
                "`main.xml` to be XML",
                error.to_string(),
                "copy or export it again",
            )
        })?;
    let description = Description {
        source,
        root: document.root_element(),
    };

    let warnings = archive.changed(&description, &main).into_iter().collect();
    let feature = description.text("FeatureType").unwrap_or("SUR");
    if !["SUR", "PRF"].contains(&feature) {
        return Err(source.wrong(
            "a surface or profile (feature type SUR or PRF)",
            format!("`{feature}`"),
            "export it as a surface on a grid",
        ));
    }
    let size = |name| -> Result<usize, ReadError> { description.number(name) };
    let (columns, rows, layers) = (size("SizeX")?, size("SizeY")?, size("SizeZ")?);
    if layers != 1 {
        return Err(source.wrong("one layer", format!("{layers}"), "export one surface"));
    }
    let step_x_m = description.step("CX")?;
    let step_y_m = if rows == 1 {
        step_x_m
    } else {
        description.step("CY")?
    };
    let height = description.axis("CZ")?;
    let number = number_of(source, height)?;
    let [scale_m, offset_m] = scale_of(source, height)?;

    let mut heights_m = archive.heights(&description, [columns, rows], number)?;
    for z in &mut heights_m {
        *z = z.mul_add(scale_m, offset_m);
    }
    if let Some(link) = description.text("ValidPointsLink") {
        archive.mark_unmeasured(link, &mut heights_m)?;
    }
    Ok(Read {
        kind: TopographyKind::X3p,
        heights_m,
        columns,
        step_x_m,
        step_y_m,
        warnings,
    })
}

/// How the heights are stored.
fn number_of(source: Source<'_>, height: Node<'_, '_>) -> Result<Number, ReadError> {
    match child(height, "DataType").unwrap_or("") {
        "I" => Ok(Number::I16),
        "L" => Ok(Number::I32),
        "F" => Ok(Number::F32),
        "D" => Ok(Number::F64),
        other => Err(source.wrong(
            "heights of data type I, L, F or D",
            format!("`{other}`"),
            "export it again",
        )),
    }
}

/// What one step of the stored numbers is, and what is added to them, m.
fn scale_of(source: Source<'_>, height: Node<'_, '_>) -> Result<[f64; 2], ReadError> {
    let real = |name: &str, otherwise: f64| -> Result<f64, ReadError> {
        child(height, name).map_or(Ok(otherwise), |text| {
            text.parse().ok().ok_or_else(|| {
                source.wrong(
                    format!("a number for the heights' {name}"),
                    format!("`{text}`"),
                    "export it again",
                )
            })
        })
    };
    let (scale_m, offset_m) = (real("Increment", 1.0)?, real("Offset", 0.0)?);
    if !scale_m.is_normal() || !offset_m.is_finite() {
        return Err(source.wrong(
            "a scale of the heights",
            format!("{scale_m}, offset {offset_m}"),
            "export it again",
        ));
    }
    Ok([scale_m, offset_m])
}

/// The 32 hexadecimal digits that a text begins with; none where a program wrote a placeholder.
fn checksum(text: &str) -> Option<String> {
    let digits: String = text
        .trim()
        .chars()
        .take_while(char::is_ascii_hexdigit)
        .collect();
    (digits.len() == 32 && digits.bytes().any(|digit| digit != b'0'))
        .then(|| digits.to_ascii_lowercase())
}

fn digest(bytes: &[u8]) -> String {
    Md5::digest(bytes)
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}

fn child<'d>(node: Node<'d, '_>, name: &str) -> Option<&'d str> {
    node.children()
        .find(|node| node.tag_name().name() == name)
        .and_then(|node| node.text())
        .map(str::trim)
        .filter(|text| !text.is_empty())
}

struct Description<'s, 'd, 'i> {
    source: Source<'s>,
    root: Node<'d, 'i>,
}

impl<'d, 'i> Description<'_, 'd, 'i> {
    fn text(&self, name: &str) -> Option<&'d str> {
        self.root.descendants().find_map(|node| child(node, name))
    }

    fn number<T: std::str::FromStr>(&self, name: &str) -> Result<T, ReadError> {
        let text = self.text(name);
        text.and_then(|text| text.parse().ok()).ok_or_else(|| {
            self.source.wrong(
                format!("a number for `{name}` in `main.xml`"),
                text.map_or("nothing".to_owned(), |text| format!("`{text}`")),
                "export it as a surface on a grid",
            )
        })
    }

    /// The heights that stand in the XML, `points` of them: an empty one was not measured.
    fn heights(&self, points: usize) -> Result<Vec<f64>, ReadError> {
        let each = (self.root.descendants()).filter(|node| node.tag_name().name() == "Datum");
        let heights = each
            .map(|node| match node.text().map_or("", str::trim) {
                "" => Ok(f64::NAN),
                text => text.parse().ok().ok_or(text),
            })
            .collect::<Result<Vec<f64>, &str>>()
            .map_err(|text| {
                self.source.wrong(
                    "a height in each `Datum` of `main.xml`",
                    format!("`{text}`"),
                    "export it as a surface on a grid",
                )
            })?;
        if heights.len() != points {
            return Err(self.source.wrong(
                format!("{points} heights, in a binary file of the archive or in `main.xml`"),
                format!("{} in `main.xml`", heights.len()),
                "copy it again, or export it with binary data",
            ));
        }
        Ok(heights)
    }

    fn axis(&self, name: &str) -> Result<Node<'d, 'i>, ReadError> {
        self.root
            .descendants()
            .find(|node| node.tag_name().name() == name)
            .ok_or_else(|| {
                self.source.wrong(
                    format!("the axis `{name}` in `main.xml`"),
                    "nothing",
                    "export it again",
                )
            })
    }

    /// The step in m of an axis whose points are evenly spaced.
    fn step(&self, name: &str) -> Result<f64, ReadError> {
        let axis = self.axis(name)?;
        let kind = child(axis, "AxisType").unwrap_or("");
        if kind != "I" {
            return Err(self.source.wrong(
                format!("evenly spaced points on the axis {name} (type I)"),
                format!("`{kind}`"),
                "export it as a surface on a grid",
            ));
        }
        let text = child(axis, "Increment");
        text.and_then(|text| text.parse().ok()).ok_or_else(|| {
            self.source.wrong(
                format!("an increment of the axis {name}"),
                text.map_or("nothing".to_owned(), |text| format!("`{text}`")),
                "export it again",
            )
        })
    }
}
