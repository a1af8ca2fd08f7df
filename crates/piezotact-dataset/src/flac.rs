//! FLAC as instruments and recorders write it, decoded by `symphonia` (MPL-2.0).
//!
//! Source of the layout: RFC 9639. The checksum of the samples (MD5) is verified where the file has one.

use std::io::{Cursor, ErrorKind};
use std::path::Path;

use piezotact::Warning;
use piezotact::recording::RecordingWarning;
use symphonia::core::codecs::audio::{AudioDecoder as _, AudioDecoderOptions};
use symphonia::core::errors::Error;
use symphonia::core::formats::{FormatOptions, FormatReader as _, TrackType};
use symphonia::core::io::MediaSourceStream;
use symphonia::default::codecs::FlacDecoder;
use symphonia::default::formats::FlacReader;

use crate::error::ReadError;
use crate::wav::{SampleFormat, Wav};

/// How a FLAC file begins.
pub(crate) const MAGIC: &[u8] = b"fLaC";
/// More samples than this, of all channels, are not decoded into memory.
const MOST_SAMPLES: usize = 1 << 28;

/// What a FLAC file holds.
pub(crate) struct Flac {
    /// Its samples; the format of WAV is the narrowest that holds them.
    pub(crate) wav: Wav,
    /// The bits of a sample.
    pub(crate) bits: u32,
}

/// The samples of a FLAC file, full scale = 1.
pub(crate) fn parse_flac(path: &Path, bytes: &[u8]) -> Result<Flac, ReadError> {
    let wrong = |found: String| {
        ReadError::content(
            path,
            "a FLAC file",
            found,
            "copy it again, or convert it to WAV",
        )
    };
    let damaged = |error: Error| wrong(error.to_string());
    let stream =
        without_pictures(bytes).ok_or_else(|| wrong("no STREAMINFO at its beginning".into()))?;
    let stream = MediaSourceStream::new(Box::new(Cursor::new(stream)), Default::default());
    let mut reader = FlacReader::try_new(stream, FormatOptions::default()).map_err(|error| {
        match is_end(&error) {
            true => wrong("no block that fits its header".into()),
            false => damaged(error),
        }
    })?;
    let track = reader.first_track(TrackType::Audio);
    let promised = track.and_then(|track| track.num_frames);
    let parameters = track.and_then(|track| track.codec_params.as_ref()?.audio().cloned());
    // Whole blocks are kept.
    let cut = |frames: usize| {
        let what = match promised {
            Some(promised) => format!(
                "the header states {promised} samples of each channel, and the file holds {frames} in whole blocks: {} are missing; it was cut short",
                promised.saturating_sub(frames as u64)
            ),
            None => format!(
                "the file ends within a block, after {frames} samples of each channel: it was cut short"
            ),
        };
        match frames {
            0 => Err(wrong("no whole block of samples: it was cut short".into())),
            _ => Ok(Warning::from(RecordingWarning::Guessed { what })),
        }
    };
    let parameters = parameters.ok_or_else(|| wrong("no description of its samples".into()))?;
    let (Some(rate_hz), Some(bits)) = (parameters.sample_rate, parameters.bits_per_sample) else {
        return Err(wrong("no rate, or no number of bits".into()));
    };
    let options = AudioDecoderOptions::default().verify(true);
    let mut decoder = FlacDecoder::try_new(&parameters, &options).map_err(damaged)?;
    let (mut channels, mut other) = (Vec::<Vec<f64>>::new(), None);
    let (mut block, mut is_cut) = (Vec::new(), false);
    loop {
        let packet = match reader.next_packet() {
            Ok(Some(packet)) => packet,
            Ok(None) => break,
            Err(error) if is_end(&error) => {
                is_cut = true;
                break;
            }
            Err(error) => return Err(damaged(error)),
        };
        let decoded = decoder.decode(&packet).map_err(damaged)?;
        block.clear();
        decoded.copy_to_vecs_planar::<f64>(&mut block);
        channels.resize(channels.len().max(block.len()), Vec::new());
        if block.len() != channels.len() {
            return Err(wrong("blocks with other numbers of channels".into()));
        }
        for (channel, samples) in channels.iter_mut().zip(&block) {
            channel.extend(samples);
        }
        // The decoder skips what does not fit the header of the file, such as blocks of another rate.
        if other.is_none() && holds_the_next(&packet.data, block.first().map_or(0, Vec::len)) {
            other = channels.first().map(Vec::len);
        }
        if channels.iter().map(Vec::len).sum::<usize>() > MOST_SAMPLES {
            return Err(wrong(format!(
                "more than {MOST_SAMPLES} samples: cut it into parts"
            )));
        }
    }
    let frames = channels.first().map_or(0, Vec::len);
    is_cut |= promised.is_some_and(|promised| promised > frames as u64);
    // The checksum is that of all samples.
    let verified = decoder.finalize().verify_ok.filter(|_| !is_cut);
    if verified == Some(false) {
        return Err(wrong(
            "samples whose checksum (MD5) is not the one in its header".into(),
        ));
    }
    if let Some(at) = other.filter(|_| verified.is_none()) {
        return Err(wrong(format!(
            "a block that does not fit its header after {at} samples: its rate, channels or bits change"
        )));
    }
    let mut warnings = Vec::new();
    match promised {
        _ if is_cut => warnings.push(cut(frames)?),
        Some(promised) if promised < frames as u64 => {
            warnings.push(Warning::from(RecordingWarning::Guessed {
                what: format!(
                    "the header of the FLAC file states {promised} samples and {frames} follow: all were read"
                ),
            }));
        }
        _ => {}
    }
    let format = match bits {
        ..=16 => SampleFormat::Pcm16,
        17..=24 => SampleFormat::Pcm24,
        _ => SampleFormat::Pcm32,
    };
    Ok(Flac {
        wav: Wav {
            channels,
            rate_hz,
            format,
            warnings,
        },
        bits,
    })
}

/// The stream without its blocks of pictures, tables and comments, whose lengths the decoder would believe.
fn without_pictures(bytes: &[u8]) -> Option<Vec<u8>> {
    const LAST: u8 = 0x80;
    let mut rest = bytes.strip_prefix(MAGIC)?;
    let mut kept = MAGIC.to_vec();
    loop {
        let &[kind, a, b, c, ref more @ ..] = rest else {
            return None;
        };
        let (body, frames) = more.split_at_checked(u32::from_be_bytes([0, a, b, c]) as usize)?;
        if kept.len() == MAGIC.len() {
            (kind & !LAST == 0).then_some(())?;
            kept.extend([LAST, a, b, c]);
            kept.extend(body);
        }
        rest = frames;
        if kind & LAST != 0 {
            kept.extend(frames);
            return Some(kept);
        }
    }
}

fn is_end(error: &Error) -> bool {
    matches!(error, Error::IoError(error) if error.kind() == ErrorKind::UnexpectedEof)
}

/// Whether the block that follows a block of `samples` begins within its bytes.
fn holds_the_next(block: &[u8], samples: usize) -> bool {
    let Some(number) = block_number(block) else {
        return false;
    };
    // Blocks of one length are counted, others say at which sample they begin.
    let step = match block.get(1) {
        Some(0xF8) => 1,
        _ => samples as u64,
    };
    (1..block.len()).any(|at| {
        block[at] == 0xFF && block_number(&block[at..]) == Some(number.saturating_add(step))
    })
}

/// The number in the header of a block, which a checksum ends.
fn block_number(bytes: &[u8]) -> Option<u64> {
    let (&[0xFF, 0xF8 | 0xF9, sizes, _], rest) = bytes.split_first_chunk::<4>()? else {
        return None;
    };
    // As in UTF-8: the first byte says how many follow, with six bits each.
    let (first, rest) = rest.split_first()?;
    let more = match first.leading_ones() {
        0 => 0,
        ones @ 2..=7 => ones as usize - 1,
        _ => return None,
    };
    let (following, rest) = rest.split_at_checked(more)?;
    let number = following.iter().fold(
        u64::from(first & (0x7F >> (more + usize::from(more > 0)))),
        |number, byte| number << 6 | u64::from(byte & 0x3F),
    );
    // An unusual length and an unusual rate stand in bytes of their own.
    let length = match sizes >> 4 {
        6 => 1,
        7 => 2,
        _ => 0,
    };
    let rate = match sizes & 0xF {
        12 => 1,
        13 | 14 => 2,
        _ => 0,
    };
    let (_, rest) = rest.split_at_checked(length + rate)?;
    let header = &bytes[..bytes.len() - rest.len()];
    let checksum = header.iter().fold(0, |checksum: u8, byte| {
        (0..8).fold(checksum ^ byte, |crc, _| (crc << 1) ^ (0x07 * (crc >> 7)))
    });
    (*rest.first()? == checksum).then_some(number)
}
