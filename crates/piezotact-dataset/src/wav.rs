//! WAV files, in and out: 16-, 24- and 32-bit integers, 32- and 64-bit floats.
//!
//! Full scale is 1 in the samples. What full scale means in physical units stands in the
//! [`sidecar`](crate::sidecar), never in this file.

mod chunks;

use std::io::Write;
use std::path::Path;

use piezotact::Warning;
use piezotact::recording::StartTime;

use crate::atomic::Prepared;
use crate::error::{ReadError, WriteError};
use crate::sidecar::{Sidecar, Written, prepare_json, sidecar_path};
use crate::version::Versioned;
use chunks::samples_in;

/// How samples are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleFormat {
    /// 16-bit integers.
    Pcm16,
    /// 24-bit integers.
    Pcm24,
    /// 32-bit integers.
    Pcm32,
    /// 32-bit floats.
    Float32,
    /// 64-bit floats.
    Float64,
}

impl SampleFormat {
    fn bytes(self) -> usize {
        match self {
            Self::Pcm16 => 2,
            Self::Pcm24 => 3,
            Self::Pcm32 | Self::Float32 => 4,
            Self::Float64 => 8,
        }
    }

    /// One step of the converter relative to full scale; absent for floats.
    #[must_use]
    pub fn step_ratio(self) -> Option<f64> {
        match self {
            Self::Pcm16 => Some(2f64.powi(-15)),
            Self::Pcm24 => Some(2f64.powi(-23)),
            Self::Pcm32 => Some(2f64.powi(-31)),
            Self::Float32 | Self::Float64 => None,
        }
    }
}

impl std::fmt::Display for SampleFormat {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Pcm16 => "16-bit integer",
            Self::Pcm24 => "24-bit integer",
            Self::Pcm32 => "32-bit integer",
            Self::Float32 => "32-bit float",
            Self::Float64 => "64-bit float",
        })
    }
}

/// What a WAV file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Wav {
    /// One list of samples a channel, full scale = 1.
    pub channels: Vec<Vec<f64>>,
    /// The rate in Hz.
    pub rate_hz: u32,
    /// How the samples were stored.
    pub format: SampleFormat,
    /// What the header does not say, or says otherwise than the file is.
    pub warnings: Vec<Warning>,
}

/// More channels than this are no recording.
const MOST_CHANNELS: u16 = 4096;
const PCM: u16 = 1;
const FLOAT: u16 = 3;
const EXTENSIBLE: u16 = 0xFFFE;

/// Reads the bytes of a WAV file; `path` only names it in errors.
///
/// # Errors
/// [`ReadError::Content`] when it is no WAV file, holds no sample, or stores its samples in another way.
pub fn parse_wav(path: &Path, bytes: &[u8]) -> Result<Wav, ReadError> {
    let (layout, data, warnings) = samples_in(path, bytes)?;
    Ok(Wav {
        warnings,
        ..layout.decode(&data)
    })
}

/// The fingerprint of the samples in the bytes of a WAV file, as its sidecar keeps it.
pub(crate) fn fingerprint(path: &Path, bytes: &[u8]) -> Result<String, ReadError> {
    let (_, data, _) = samples_in(path, bytes)?;
    let mut fingerprint = Fingerprint::new();
    fingerprint.add(&data);
    Ok(fingerprint.text())
}

/// The running fingerprint of samples as they are stored: as FNV-1a, but over words of eight bytes (and over the bytes of a
/// rest), with the upper half folded onto the lower after each.
struct Fingerprint(u64);

impl Fingerprint {
    fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    /// Adds bytes, in blocks of whole words until the last.
    fn add(&mut self, bytes: &[u8]) {
        let (words, rest) = bytes.as_chunks::<8>();
        let words = words.iter().map(|word| u64::from_le_bytes(*word));
        for word in words.chain(rest.iter().map(|byte| u64::from(*byte))) {
            self.0 = (self.0 ^ word).wrapping_mul(0x0000_0100_0000_01b3);
            // Down again: multiplied alone, the highest bit, a sign, would reach no other.
            self.0 ^= self.0 >> 32;
        }
    }

    fn text(&self) -> String {
        format!("fold64:{:016x}", self.0)
    }
}

/// When the first sample was taken, as a broadcast WAV file says it in its `bext` chunk: without a zone, as the format states
/// none; `None` where it says no date or no time.
///
/// Source: EBU Tech 3285, *Specification of the Broadcast Wave Format*, section 2.3.
pub(crate) fn start_in(bytes: &[u8]) -> Option<StartTime> {
    /// The date, `yyyy-mm-dd`, stands behind description, originator and reference; the time, `hh:mm:ss`, behind it.
    const DATE: std::ops::Range<usize> = 320..330;
    const TIME: std::ops::Range<usize> = 330..338;
    let mut at = 12usize;
    while let Some(head) = bytes.get(at..at.checked_add(8)?) {
        let body = at + 8;
        let size = u32_at(head, 4) as usize;
        if &head[..4] == b"bext" {
            let content = bytes.get(body..body.checked_add(size)?)?;
            // Programs write other signs between the numbers.
            let joined = |range: std::ops::Range<usize>, sign: &str| {
                let text = std::str::from_utf8(content.get(range)?).ok()?;
                let parts = text.split(|c: char| !c.is_ascii_digit());
                Some(parts.collect::<Vec<_>>().join(sign))
            };
            let (date, time) = (joined(DATE, "-")?, joined(TIME, ":")?);
            return StartTime::try_from(format!("{date}T{time}")).ok();
        }
        at = body.checked_add(size)?.checked_add(size % 2)?;
    }
    None
}

/// How samples lie in their bytes.
#[derive(Clone, Copy)]
struct Layout {
    channels: usize,
    rate_hz: u32,
    format: SampleFormat,
}

impl Layout {
    fn parse(path: &Path, fmt: &[u8]) -> Result<Self, ReadError> {
        if fmt.len() < 16 {
            return Err(ReadError::content(
                path,
                "a `fmt ` chunk of 16 bytes or more",
                format!("{} bytes", fmt.len()),
                "the file is damaged: export it again",
            ));
        }
        let tag = match u16_at(fmt, 0) {
            EXTENSIBLE if fmt.len() >= 26 => u16_at(fmt, 24),
            tag => tag,
        };
        let (channels, rate_hz, bits) = (u16_at(fmt, 2), u32_at(fmt, 4), u16_at(fmt, 14));
        let format = match (tag, bits) {
            (PCM, 16) => SampleFormat::Pcm16,
            (PCM, 24) => SampleFormat::Pcm24,
            (PCM, 32) => SampleFormat::Pcm32,
            (FLOAT, 32) => SampleFormat::Float32,
            (FLOAT, 64) => SampleFormat::Float64,
            _ => {
                return Err(ReadError::content(
                    path,
                    "samples of 16, 24 or 32 bits (integer) or 32 or 64 bits (float)",
                    format!("{bits} bits of format {tag}"),
                    "convert the file to one of these",
                ));
            }
        };
        if channels > MOST_CHANNELS {
            return Err(ReadError::content(
                path,
                format!("at most {MOST_CHANNELS} channels"),
                format!("{channels}"),
                "if the header is right, save fewer channels in each file",
            ));
        }
        if channels == 0 || rate_hz == 0 {
            return Err(ReadError::content(
                path,
                "a channel and a rate above zero",
                format!("{channels} channels at {rate_hz} Hz"),
                "the header is damaged: export the file again",
            ));
        }
        Ok(Self {
            channels: usize::from(channels),
            rate_hz,
            format,
        })
    }

    fn decode(self, data: &[u8]) -> Wav {
        let bytes = self.format.bytes();
        let mut channels =
            vec![Vec::with_capacity(data.len() / bytes / self.channels); self.channels];
        for frame in data.chunks_exact(bytes * self.channels) {
            for (channel, sample) in channels.iter_mut().zip(frame.chunks_exact(bytes)) {
                channel.push(match self.format {
                    SampleFormat::Pcm16 => f64::from(u16_at(sample, 0) as i16) / 32_768.0,
                    SampleFormat::Pcm24 => {
                        f64::from(i32::from_le_bytes([0, sample[0], sample[1], sample[2]]) >> 8)
                            / 8_388_608.0
                    }
                    SampleFormat::Pcm32 => f64::from(u32_at(sample, 0) as i32) / 2_147_483_648.0,
                    SampleFormat::Float32 => f64::from(f32::from_bits(u32_at(sample, 0))),
                    SampleFormat::Float64 => f64::from_bits(
                        u64::from(u32_at(sample, 4)) << 32 | u64::from(u32_at(sample, 0)),
                    ),
                });
            }
        }
        Wav {
            channels,
            rate_hz: self.rate_hz,
            format: self.format,
            warnings: Vec::new(),
        }
    }
}

fn u16_at(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([bytes[at], bytes[at + 1]])
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

/// Writes channels of equal length (full scale = 1) as a WAV file, whole or not at all.
///
/// # Errors
/// [`WriteError::Content`] when there is no channel, lengths differ, the file would exceed 4 GiB, or an
/// integer format is asked to hold a sample beyond full scale; [`WriteError::Io`] when the operating system
/// refuses.
pub fn write_wav(
    path: &Path,
    channels: &[&[f64]],
    rate_hz: u32,
    format: SampleFormat,
) -> Result<(), WriteError> {
    prepare_wav(path, channels, (rate_hz, format), None)?.commit()
}

/// Writes a WAV file with its sidecar: both are whole on the disk before either takes its place, the sidecar
/// first and with the fingerprint of the samples, so that samples never stand beside another file's scale unseen.
///
/// # Errors
/// Those of [`write_wav`], for either file.
pub fn write_wav_with_sidecar(
    path: &Path,
    channels: &[&[f64]],
    rate_hz: u32,
    format: SampleFormat,
    sidecar: &Sidecar,
) -> Result<(), WriteError> {
    let mut samples = Fingerprint::new();
    let wav = prepare_wav(path, channels, (rate_hz, format), Some(&mut samples))?;
    let samples = samples.text();
    let written = Written {
        sidecar,
        samples,
        rate_hz,
    };
    prepare_json(&sidecar_path(path), &Versioned::of(&written))?.commit()?;
    wav.commit()
}

/// A WAV file ready to take its place; its samples are added to `fingerprint`.
fn prepare_wav(
    path: &Path,
    channels: &[&[f64]],
    (rate_hz, format): (u32, SampleFormat),
    mut fingerprint: Option<&mut Fingerprint>,
) -> Result<Prepared, WriteError> {
    let wrong = |expected: &str, found: String, todo: &str| {
        WriteError::content(path, expected, found, todo)
    };
    let frames = channels.first().map_or(0, |first| first.len());
    if channels.is_empty() || channels.iter().any(|channel| channel.len() != frames) {
        return Err(wrong(
            "channels of equal length",
            format!("{} channels", channels.len()),
            "write them to separate files",
        ));
    }
    let width = channels.len() * format.bytes();
    if u16::try_from(width).is_err() || rate_hz.checked_mul(width as u32).is_none() {
        return Err(wrong(
            "a rate and a number of channels that a WAV file can state",
            format!("{} channels at {rate_hz} Hz", channels.len()),
            "write Parquet instead",
        ));
    }
    let size = frames * width;
    let Ok(riff_size) = u32::try_from(size + 50) else {
        return Err(wrong(
            "at most 4 GiB",
            format!("{size} bytes"),
            "write Parquet instead",
        ));
    };
    let integer = format.step_ratio().is_some();
    // Of a block that is encoded next, so that the samples are fetched once.
    let require_within = |samples: &[f64]| {
        let all = samples
            .iter()
            .fold(true, |within, v| within & (v.abs() <= 1.0));
        if all {
            return Ok(());
        }
        let beyond = samples.iter().find(|v| !(-1.0..=1.0).contains(*v));
        Err(wrong(
            "samples from −1 to 1 for an integer format",
            format!("{}", beyond.copied().unwrap_or(f64::NAN)),
            "lower the level or write floats",
        ))
    };
    let float = !integer;
    let (bytes, count) = (format.bytes() as u32, channels.len() as u32);
    let pad = size % 2;
    Prepared::new(path, |out| {
        let mut head = Vec::with_capacity(58);
        head.extend(b"RIFF");
        let fact = if float { 12 } else { 0 };
        let fmt_size: u32 = if float { 18 } else { 16 };
        head.extend((riff_size - 50 + 4 + 8 + fmt_size + fact + 8 + pad as u32).to_le_bytes());
        head.extend(b"WAVEfmt ");
        head.extend(fmt_size.to_le_bytes());
        head.extend((if float { FLOAT } else { PCM }).to_le_bytes());
        head.extend((count as u16).to_le_bytes());
        head.extend(rate_hz.to_le_bytes());
        head.extend((rate_hz * bytes * count).to_le_bytes());
        head.extend(((bytes * count) as u16).to_le_bytes());
        head.extend(((bytes * 8) as u16).to_le_bytes());
        if float {
            head.extend([0, 0]);
            head.extend(b"fact");
            head.extend(4u32.to_le_bytes());
            head.extend((frames as u32).to_le_bytes());
        }
        head.extend(b"data");
        head.extend((size as u32).to_le_bytes());
        out.write_all(&head).map_err(WriteError::io(path))?;
        let mut block = vec![0; BLOCK_FRAMES * width];
        for start in (0..frames).step_by(BLOCK_FRAMES) {
            let end = frames.min(start + BLOCK_FRAMES);
            let block = &mut block[..(end - start) * width];
            for (at, channel) in channels.iter().enumerate() {
                let samples = &channel[start..end];
                if integer {
                    require_within(samples)?;
                }
                encode(samples, format, &mut block[at * format.bytes()..], width);
            }
            if let Some(fingerprint) = fingerprint.as_deref_mut() {
                fingerprint.add(block);
            }
            out.write_all(block).map_err(WriteError::io(path))?;
        }
        out.write_all(&[0][..pad]).map_err(WriteError::io(path))
    })
}

/// Frames that are encoded before they are handed to the file: whole words, whatever their width.
const BLOCK_FRAMES: usize = 32_768;

/// Writes one channel's samples into a block of interleaved frames of `width` bytes.
fn encode(samples: &[f64], format: SampleFormat, block: &mut [u8], width: usize) {
    fn put<const N: usize>(
        samples: &[f64],
        block: &mut [u8],
        width: usize,
        bytes: impl Fn(f64) -> [u8; N],
    ) {
        for (frame, sample) in block.chunks_mut(width).zip(samples) {
            frame[..N].copy_from_slice(&bytes(*sample));
        }
    }
    match format {
        SampleFormat::Pcm16 => put(samples, block, width, |v| {
            (quantised(v, 32_768.0) as i16).to_le_bytes()
        }),
        SampleFormat::Pcm24 => {
            let bytes = |v| {
                let [a, b, c, _] = quantised(v, 8_388_608.0).to_le_bytes();
                [a, b, c]
            };
            // One channel, as every drive is: four samples at a time as three words.
            let whole = if width == 3 { samples.len() / 4 * 4 } else { 0 };
            for (words, four) in block
                .chunks_exact_mut(12)
                .zip(samples[..whole].chunks_exact(4))
            {
                let q: [u32; 4] =
                    std::array::from_fn(|i| quantised(four[i], 8_388_608.0) as u32 & 0x00FF_FFFF);
                words[..4].copy_from_slice(&(q[0] | q[1] << 24).to_le_bytes());
                words[4..8].copy_from_slice(&(q[1] >> 8 | q[2] << 16).to_le_bytes());
                words[8..].copy_from_slice(&(q[2] >> 16 | q[3] << 8).to_le_bytes());
            }
            put(&samples[whole..], &mut block[whole * width..], width, bytes);
        }
        SampleFormat::Pcm32 => put(samples, block, width, |v| {
            quantised(v, 2_147_483_648.0).to_le_bytes()
        }),
        SampleFormat::Float32 => put(samples, block, width, |v| (v as f32).to_le_bytes()),
        SampleFormat::Float64 => put(samples, block, width, f64::to_le_bytes),
    }
}

/// The nearest whole number to `value · steps`, ties to even, +full scale being one step below `steps`.
/// Added to 1.5·2⁵², a whole number stands in the lowest bits as it does in an integer.
fn quantised(value: f64, steps: f64) -> i32 {
    const ROUNDER: f64 = 6_755_399_441_055_744.0;
    let scaled = value * steps;
    let scaled = if scaled > steps - 1.0 {
        steps - 1.0
    } else {
        scaled
    };
    (scaled + ROUNDER).to_bits() as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    const FORMATS: [SampleFormat; 5] = [
        SampleFormat::Pcm16,
        SampleFormat::Pcm24,
        SampleFormat::Pcm32,
        SampleFormat::Float32,
        SampleFormat::Float64,
    ];

    #[test]
    fn every_format_comes_back_within_half_a_step() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.wav");
        let left: Vec<f64> = (0..9001).map(|i| (f64::from(i) * 0.1).sin()).collect();
        let right: Vec<f64> = left.iter().map(|v| -v * 0.5).collect();
        for format in FORMATS {
            write_wav(&path, &[&left, &right], 48_000, format).unwrap();
            let bytes = std::fs::read(&path).unwrap();
            assert_eq!(u32_at(&bytes, 4) as usize, bytes.len() - 8, "{format}");
            let wav = parse_wav(&path, &bytes).unwrap();
            assert_eq!(
                (wav.rate_hz, wav.format, wav.channels.len()),
                (48_000, format, 2)
            );
            let half = match format {
                SampleFormat::Float32 => 6e-8,
                SampleFormat::Float64 => 0.0,
                integer => 0.5 * integer.step_ratio().unwrap() * (1.0 + 1e-9),
            };
            // Full scale itself is one step out of reach for integers.
            let far = |v: &f64, got: &f64| (v - got).abs() > half && *v < 1.0 - 2.0 * half;
            assert!(
                !left
                    .iter()
                    .zip(&wav.channels[0])
                    .any(|(v, got)| far(v, got)),
                "{format}"
            );
            assert!(
                !right
                    .iter()
                    .zip(&wav.channels[1])
                    .any(|(v, got)| far(v, got)),
                "{format}"
            );
        }
    }

    #[test]
    fn a_broadcast_file_says_when_it_began() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.wav");
        write_wav(&path, &[&[0.25; 40]], 10_000, SampleFormat::Pcm24).unwrap();
        let plain = std::fs::read(&path).unwrap();
        assert_eq!(start_in(&plain), None);
        let with = |date: &str, time: &str| {
            let mut chunk = vec![0; 602];
            chunk[..7].copy_from_slice(b"texture");
            chunk[320..330].copy_from_slice(date.as_bytes());
            chunk[330..338].copy_from_slice(time.as_bytes());
            let mut bytes = plain[..12].to_vec();
            bytes.extend(b"bext");
            bytes.extend(602u32.to_le_bytes());
            bytes.extend(chunk);
            bytes.extend(&plain[12..]);
            bytes
        };
        for (date, time) in [("2024-03-01", "10:22:33"), ("2024:03:01", "10-22-33")] {
            let bytes = with(date, time);
            std::fs::write(&path, &bytes).unwrap();
            let read = crate::read_recording(&path, &crate::ReadOptions::default()).unwrap();
            let start = read.recording.annotations.started_at.clone().unwrap();
            assert_eq!(start.to_string(), "2024-03-01T10:22:33");
            assert_eq!(read.recording.len(), 40);
        }
        assert_eq!(start_in(&with("0000-00-00", "00:00:00")), None);
        assert_eq!(start_in(&with("          ", "        ")), None);
        let cut = with("2024-03-01", "10:22:33");
        for length in 0..700 {
            let _either = start_in(&cut[..length.min(cut.len())]);
        }
    }

    #[test]
    fn another_library_reads_what_we_write_and_we_what_it_writes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.wav");
        let samples: Vec<f64> = (0..777)
            .map(|i| (f64::from(i) * 0.03).sin() * 0.9)
            .collect();
        for (format, bits, float) in [
            (SampleFormat::Pcm16, 16, false),
            (SampleFormat::Pcm24, 24, false),
            (SampleFormat::Pcm32, 32, false),
            (SampleFormat::Float32, 32, true),
        ] {
            write_wav(&path, &[&samples], 44_100, format).unwrap();
            let mut theirs = hound::WavReader::open(&path).unwrap();
            assert_eq!(theirs.spec().bits_per_sample, bits);
            let ours = parse_wav(&path, &std::fs::read(&path).unwrap()).unwrap();
            if float {
                let read: Vec<f64> = theirs
                    .samples::<f32>()
                    .map(|v| f64::from(v.unwrap()))
                    .collect();
                assert_eq!(read, ours.channels[0]);
            } else {
                let steps = 2f64.powi(i32::from(bits) - 1);
                let read: Vec<f64> = theirs
                    .samples::<i32>()
                    .map(|v| f64::from(v.unwrap()) / steps)
                    .collect();
                assert_eq!(read, ours.channels[0]);
            }
        }
    }

    #[test]
    fn more_channels_than_a_recording_has_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.wav");
        write_wav(&path, &[&[0.25; 40]], 8000, SampleFormat::Pcm16).unwrap();
        let mut bytes = std::fs::read(&path).unwrap();
        let at = bytes.windows(4).position(|four| four == b"fmt ").unwrap();
        bytes[at + 10..at + 12].copy_from_slice(&4097_u16.to_le_bytes());
        let refused = parse_wav(&path, &bytes).unwrap_err().to_string();
        assert!(
            refused.contains("at most 4096 channels, found 4097"),
            "{refused}"
        );
    }

    #[test]
    fn integers_beyond_full_scale_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.wav");
        assert!(write_wav(&path, &[&[1.01]], 48_000, SampleFormat::Pcm24).is_err());
        assert!(!path.exists());
        assert!(write_wav(&path, &[&[1.01]], 48_000, SampleFormat::Float32).is_ok());
    }

    proptest::proptest! {
        /// Whatever the bytes, there is an answer: a recording or a sentence.
        #[test]
        fn damage_is_an_error_and_no_panic(at in 0usize..120, byte: u8, keep in 0usize..200) {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("a.wav");
            write_wav(&path, &[&[0.25; 40]], 10_000, SampleFormat::Pcm24).unwrap();
            let mut bytes = std::fs::read(&path).unwrap();
            bytes[at] = byte;
            bytes.truncate(keep);
            let _either = parse_wav(&path, &bytes);
        }
    }
}
