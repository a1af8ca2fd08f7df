//! The chunks of a WAV file.

use std::borrow::Cow;
use std::path::Path;

use piezotact::Warning;
use piezotact::recording::RecordingWarning;

use super::{Layout, u32_at};
use crate::error::ReadError;

/// How the samples of a WAV file lie in their bytes, these, and warnings.
type Samples<'a> = (Layout, Cow<'a, [u8]>, Vec<Warning>);

/// The samples in the `data` chunks of a WAV file: whole frames, as many as there are.
pub(super) fn samples_in<'a>(path: &Path, bytes: &'a [u8]) -> Result<Samples<'a>, ReadError> {
    let wrong =
        |expected: &str, found: String, todo: &str| ReadError::content(path, expected, found, todo);
    let whole = bytes.get(..12).filter(|head| {
        (head.starts_with(b"RIFF") || head.starts_with(b"RF64")) && head.ends_with(b"WAVE")
    });
    if whole.is_none() {
        return Err(wrong(
            "a WAV file",
            "something else".into(),
            "check the file, or export it again",
        ));
    }
    let (mut at, mut layout, mut long_data) = (12usize, None, None);
    let (mut data, mut chunks) = (Cow::Borrowed(&bytes[..0]), 0);
    let mut guesses = Vec::new();
    while let Some(head) = bytes.get(at..at + 8) {
        let size = u32_at(head, 4) as usize;
        let body = at + 8;
        let rest = bytes.len() - body;
        match &head[..4] {
            b"ds64" if rest >= 16 => {
                long_data = usize::try_from(
                    u64::from(u32_at(bytes, body + 12)) << 32 | u64::from(u32_at(bytes, body + 8)),
                )
                .ok();
            }
            b"fmt " if chunks == 0 => {
                layout = Some(Layout::parse(
                    path,
                    bytes.get(body..body + size.min(rest)).unwrap_or(&[]),
                )?)
            }
            b"data" => {
                let layout = layout.ok_or_else(|| {
                    wrong(
                        "a `fmt ` chunk before the samples",
                        "none".into(),
                        "export the file again",
                    )
                })?;
                let size = if size == u32::MAX as usize {
                    long_data.unwrap_or(size)
                } else {
                    size
                };
                let frame = layout.format.bytes() * layout.channels;
                // A program that writes to a pipe, or that was killed, leaves the size open.
                let is_filled_in =
                    !matches!(size, 0x7FFF_F000..=0x7FFF_FFFF | 0xFFFF_F000..=0xFFFF_FFFF);
                let is_open = (!is_filled_in && size > rest) || (size == 0 && is_last(bytes, body));
                let there = if is_open { rest } else { size.min(rest) };
                let whole = there / frame * frame;
                if is_open && rest > 0 {
                    guesses.push(format!(
                        "the header does not state how many samples there are: the {} up to the end of the file are read",
                        whole / frame
                    ));
                } else if size > rest {
                    guesses.push(format!(
                        "the header states {} samples of each channel, and the file holds {}: {} are missing; it was cut short",
                        size / frame,
                        whole / frame,
                        size / frame - whole / frame
                    ));
                } else if whole < there {
                    guesses.push(format!(
                        "{} bytes of an incomplete sample were left out",
                        there - whole
                    ));
                }
                let own = &bytes[body..body + whole];
                match data.is_empty() {
                    true => data = Cow::Borrowed(own),
                    false => data.to_mut().extend_from_slice(own),
                }
                chunks += 1;
                if is_open {
                    break;
                }
            }
            _ => {}
        }
        at = body.saturating_add(size).saturating_add(size % 2);
    }
    if chunks > 1 {
        guesses.push(format!(
            "the samples lie in {chunks} chunks, and are read one after the other"
        ));
    }
    match layout.filter(|_| !data.is_empty()) {
        Some(layout) => {
            let warning = |what| Warning::from(RecordingWarning::Guessed { what });
            Ok((layout, data, guesses.into_iter().map(warning).collect()))
        }
        None => Err(wrong(
            "a `data` chunk with samples",
            "none".into(),
            "check that the recording was not stopped immediately, and that the file was not cut short",
        )),
    }
}

/// Whether no other chunk begins at `at`: a name in letters, and a size that the file holds.
fn is_last(bytes: &[u8], at: usize) -> bool {
    let Some(head) = bytes.get(at..at + 8) else {
        return true;
    };
    let is_name = head[..4]
        .iter()
        .all(|byte| byte.is_ascii_graphic() || *byte == b' ');
    !is_name || u32_at(head, 4) as usize > bytes.len() - at - 8
}
