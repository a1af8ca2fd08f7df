//! Files of manual cuts: text with one line per cut, in seconds from the start of the recording.
//!
//! ```text
//! # what the rule found stays unless a line says otherwise
//! # recording 0f3a5c7e91b2d4f6
//! stroke 1.20 2.35
//! leave-out 4.10 5.00 the participant sneezed
//! ```
//!
//! The line `# recording CHECKSUM` holds the checksum of the recording's file: cuts are not applied to another one.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use piezotact::Warning;
use piezotact::checksum::Checksum;
use piezotact::quantity::{SampleRate, Seconds};
use piezotact::recording::RecordingWarning;
use piezotact::stroke::{Cut, Cuts, Segmentation};

use crate::error::ReadError;

/// What the remark with the checksum of the recording begins with.
const RECORDING: &str = "recording";

/// The default file of manual cuts for a recording: beside it, with `.cuts` after its name.
#[must_use]
pub fn cuts_path(recording: &Path) -> PathBuf {
    let mut name = recording.as_os_str().to_owned();
    name.push(".cuts");
    name.into()
}

/// The cuts in a text file.
///
/// # Errors
/// [`ReadError`] naming the file and the line, what was expected and what was found.
pub fn read_cuts(path: &Path) -> Result<Cuts, ReadError> {
    // A note may be in any encoding, and editors put a mark at the start.
    let bytes = crate::input::read_input(path)?;
    let text = String::from_utf8_lossy(&bytes);
    parse(path, text.trim_start_matches('\u{feff}'))
}

/// The cuts in the text file `path`, which belong to the recording in the file `recording`, and a warning where they do not say so.
///
/// # Errors
/// Those of [`read_cuts`]; [`ReadError::Content`] where they were made for another recording.
pub fn read_cuts_of(path: &Path, recording: &Path) -> Result<(Cuts, Option<Warning>), ReadError> {
    let cuts = read_cuts(path)?;
    let text = String::from_utf8_lossy(&crate::input::read_input(path)?).into_owned();
    let found = recording_checksum(recording)?;
    let stated = text.lines().find_map(|line| {
        let line = line
            .trim_start_matches('\u{feff}')
            .trim()
            .strip_prefix('#')?;
        let (what, checksum) = line.trim().split_once(char::is_whitespace)?;
        let checksum = checksum.trim();
        (what == RECORDING && checksum.len() == 16)
            .then(|| Checksum::try_from(checksum.to_owned()).ok())?
    });
    match stated {
        Some(stated) if stated == found => Ok((cuts, None)),
        Some(stated) => Err(ReadError::content(
            path,
            format!("cuts of {}, whose checksum is {found}", recording.display()),
            format!("cuts of a recording with the checksum {stated}"),
            format!(
                "it is of an earlier recording: move it away; or check the cuts against this one and write `# {RECORDING} {found}` \
                 in that line"
            ),
        )),
        None => {
            let file = path.display().to_string();
            let warning = RecordingWarning::CutsUnconfirmed {
                file,
                checksum: found,
            };
            Ok((cuts, Some(Warning::from(warning))))
        }
    }
}

/// The checksum of the file of a recording, as cuts name it.
///
/// # Errors
/// [`ReadError::Io`] when it cannot be read.
pub fn recording_checksum(recording: &Path) -> Result<Checksum, ReadError> {
    Ok(Checksum::of_bytes(&crate::input::read_input(recording)?))
}

fn parse(path: &Path, text: &str) -> Result<Cuts, ReadError> {
    let mut cuts = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let wrong = || {
            ReadError::content(
                path,
                "`stroke FROM TO` or `leave-out FROM TO why`, times in s with FROM before TO",
                format!("`{line}` in line {}", i + 1),
                "correct that line, or begin it with # to leave it out",
            )
        };
        let mut words = line.split_whitespace();
        let act = words.next().ok_or_else(wrong)?;
        let mut time = || -> Option<f64> {
            let seconds: f64 = words.next()?.parse().ok()?;
            (seconds.is_finite() && seconds >= 0.0).then_some(seconds)
        };
        let (Some(from), Some(to)) = (time(), time()) else {
            return Err(wrong());
        };
        if from >= to {
            return Err(wrong());
        }
        let (from_s, to_s) = (Seconds(from), Seconds(to));
        let note = words.collect::<Vec<_>>().join(" ");
        cuts.push(match act {
            "stroke" => Cut::Stroke { from_s, to_s },
            "leave-out" => Cut::LeaveOut { from_s, to_s, note },
            _ => return Err(wrong()),
        });
    }
    Ok(Cuts {
        source: path.display().to_string(),
        cuts,
    })
}

/// The strokes and rejects of a segmentation as a file of cuts to be edited: strokes as they are, rejects as
/// remarks with their reason. `recording` is the checksum of the recording's file.
#[must_use]
pub fn cuts_text(segmentation: &Segmentation, rate: SampleRate, recording: Checksum) -> String {
    let seconds = |sample: usize| rate.duration_of(sample).0;
    let mut lines: Vec<(usize, String)> = segmentation
        .strokes
        .iter()
        .map(|stroke| {
            let (from, to) = (stroke.steady.start, stroke.steady.end);
            (
                from,
                format!("stroke {:.4} {:.4}", seconds(from), seconds(to)),
            )
        })
        .collect();
    lines.extend(segmentation.rejected.iter().map(|rejected| {
        let (from, to) = (rejected.interval.start, rejected.interval.end);
        (
            from,
            format!(
                "# rejected {:.4} {:.4} {}",
                seconds(from),
                seconds(to),
                rejected.reason
            ),
        )
    }));
    lines.sort();
    let mut text = String::from(
        "# Times in s. `stroke FROM TO` replaces the automatic cuts that it overlaps; `leave-out FROM TO why`\n# rejects every \
         stroke that it overlaps. Automatic cuts that no line overlaps are kept.\n",
    );
    let _never_fails = writeln!(text, "# {RECORDING} {recording}");
    for (_, line) in lines {
        let _never_fails = writeln!(text, "{line}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cuts_are_read_line_by_line() {
        let cuts = parse(
            Path::new("c"),
            "# remark\n\nstroke 1.2 2.5\nleave-out 4 5 a sneeze, loud\n",
        )
        .unwrap();
        assert_eq!(
            cuts.cuts,
            [
                Cut::Stroke {
                    from_s: Seconds(1.2),
                    to_s: Seconds(2.5)
                },
                Cut::LeaveOut {
                    from_s: Seconds(4.0),
                    to_s: Seconds(5.0),
                    note: "a sneeze, loud".into()
                }
            ]
        );
        for bad in [
            "stroke 1",
            "stroke 2 1",
            "stroke a 2",
            "cut 1 2",
            "stroke -1 2",
            "stroke nan 2",
        ] {
            let error = parse(Path::new("c"), bad).unwrap_err().to_string();
            assert!(error.contains("line 1"), "{error}");
        }
    }
}
