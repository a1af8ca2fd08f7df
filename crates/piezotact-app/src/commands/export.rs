//! `piezotact export`: textures, drives and transfer functions for other devices and programs.

#[cfg(feature = "haptic")]
mod haptic;

use std::path::Path;

use anyhow::anyhow;
use piezotact::Warning;
use piezotact::quantity::{Measure, SampleRate, Uncalibrated, Unit};
use piezotact::recording::{About, Recording};
use piezotact::series::Series;
use piezotact::share::{Shares, shares_of_full_scale};
use piezotact_dataset::document::Written;
use piezotact_dataset::sidecar::{Sidecar, sidecar_path};
use piezotact_dataset::uff::write_uff_recording;
use piezotact_dataset::wav::{SampleFormat, write_wav_with_sidecar};
use piezotact_dataset::{
    Contents, FileKind, TransferFormat, holds_transfer, read_transfer, write_transfer,
};

use crate::cli::Export;
use crate::failure::{Failure, Outcome, usage};
use crate::output::{digits, print, print_kept, say_warnings};
use crate::places::outputs;
use crate::reading::read;
use crate::report::name;

/// The rate of files that are played through a sound output, Hz.
const AUDIO_HZ: u32 = 48_000;
/// The highest rate at which a file holds a keyframe for each sample, Hz.
const KEYFRAMES_HZ: f64 = 8000.0;

/// What a file is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Wav,
    Hjif,
    Haptic,
    Ahap,
    Uff,
}

impl Format {
    fn of_ending(path: &Path) -> Outcome<Self> {
        let kind = FileKind::of_ending(path);
        if let Some(format) = Self::ALL.into_iter().find(|all| Some(all.kind()) == kind) {
            return Ok(format);
        }
        let endings: Vec<String> = Self::ALL
            .iter()
            .filter_map(|format| Some(format!(".{}", format.kind().ending()?)))
            .collect();
        let ending = path.extension().and_then(|ending| ending.to_str());
        Err(usage(anyhow!(
            "expected a file that ends in {}, found {}; give {} one of these endings",
            match endings.as_slice() {
                [others @ .., last] if !others.is_empty() =>
                    format!("{} or {last}", others.join(", ")),
                all => all.concat(),
            },
            ending.map_or("none".into(), |ending| format!(
                ".{}",
                ending.to_ascii_lowercase()
            )),
            path.display()
        )))
    }

    const ALL: [Self; 5] = [Self::Wav, Self::Hjif, Self::Haptic, Self::Ahap, Self::Uff];

    /// What kind of file it is.
    fn kind(self) -> FileKind {
        match self {
            Self::Wav => FileKind::WAV,
            Self::Hjif => FileKind::HJIF,
            Self::Haptic => FileKind::HAPTIC_CLIP,
            Self::Ahap => FileKind::AHAP,
            Self::Uff => FileKind::UFF,
        }
    }

    /// The rate of a file with a signal of the rate `own`: another one where a sound output plays it, or where a keyframe for each
    /// sample would be more than a file should hold, or no whole number a second.
    fn rate_of(self, own: SampleRate) -> anyhow::Result<Option<SampleRate>> {
        let too_fine = own.hz() > KEYFRAMES_HZ || own.hz().fract() > 0.0;
        Ok(match self {
            Self::Wav => Some(SampleRate::new(f64::from(AUDIO_HZ))?),
            Self::Hjif if too_fine => Some(SampleRate::new(KEYFRAMES_HZ)?),
            _ => None,
        })
    }

    fn name(self) -> String {
        match self {
            Self::Wav => format!("{}, {}", FileKind::WAV, SampleFormat::Float32),
            other => other.kind().to_string(),
        }
    }
}

pub(crate) fn run(args: &Export) -> Outcome {
    let format = Format::of_ending(&args.out)?;
    let inputs: Vec<&Path> = std::iter::once(&args.input)
        .chain(&args.transfer)
        .map(|path| path.as_path())
        .collect();
    let sidecar = sidecar_path(&args.out);
    let mut writes = vec![args.out.as_path()];
    if format == Format::Wav {
        writes.push(&sidecar);
    }
    outputs(&inputs, &writes)?;
    #[cfg(not(feature = "haptic"))]
    if !matches!(format, Format::Wav | Format::Uff) {
        return super::lacking::other(&format!("--out {}", args.out.display()));
    }
    if args.transfer.is_some() && format != Format::Hjif {
        return Err(usage(anyhow!(
            "expected --transfer with a .hjif output only, found it with {}; leave it out",
            args.out.display()
        )));
    }
    let written = written(args, format)?;
    if args.json {
        return print_kept(&args.out, &written);
    }
    say_warnings(&written.warnings);
    print(&text(&written, &args.out))
}

/// Writes the file for what the input holds.
fn written(args: &Export, format: Format) -> Outcome<Written> {
    if holds_transfer(&args.input) {
        return of_transfer(args, format);
    }
    #[cfg(feature = "haptic")]
    if let Some(written) = haptic::of_clip(args, format)? {
        return Ok(written);
    }
    of_recording(args, format)
}

fn text(written: &Written, out: &Path) -> String {
    let mut text = format!("wrote {}: {}", out.display(), written.format);
    if let Some(rate) = written.rate_hz {
        text.push_str(&format!(" at {rate}"));
    }
    if let Some(full_scale) = &written.full_scale {
        text.push_str(&format!(
            ", 1 corresponds to {} {}",
            digits(full_scale.value),
            full_scale.unit
        ));
    }
    text
}

fn of_transfer(args: &Export, format: Format) -> Outcome<Written> {
    if format != Format::Uff {
        return Err(usage(anyhow!(
            "expected an output that ends in .uff for a transfer function, found {} ({}), which holds signals; give a .uff name",
            args.out.display(),
            format.name()
        )));
    }
    if args.channel.is_some() {
        return Err(usage(anyhow!(
            "{} is a transfer function and has no channels: leave --channel out",
            args.input.display()
        )));
    }
    let document = read_transfer(&args.input)?;
    write_transfer(&args.out, &document)?;
    let mut warnings = document.about.warnings;
    warnings.extend(TransferFormat::of_ending(&args.out).losses());
    Ok(Written {
        format: format.name(),
        rate_hz: None,
        full_scale: None,
        warnings,
    })
}

fn of_recording(args: &Export, format: Format) -> Outcome<Written> {
    let contents = read(&args.input, &args.reading)?;
    let recording = &contents.recording;
    if format == Format::Uff {
        return universal(args, recording);
    }
    let (channel, of_channel) =
        shares_of(args, format, recording).map_err(|error| named(args, error))?;
    let mut warnings = recording.about.warnings.clone();
    warnings.extend(of_channel.warnings(&format.name()));
    let Shares {
        shares, full_scale, ..
    } = of_channel;
    let written = Written {
        format: format.name(),
        rate_hz: Some(shares.rate()),
        full_scale: Some(full_scale.clone()),
        warnings,
    };
    #[cfg(feature = "haptic")]
    if format != Format::Wav {
        return haptic::of_texture(args, format, &contents, (&shares, full_scale), written);
    }
    audio(
        args,
        &contents,
        &channel,
        (&shares, &full_scale),
        &written.warnings,
    )?;
    Ok(written)
}

/// An error about the input.
fn named(args: &Export, error: anyhow::Error) -> Failure {
    Failure::Data(error.context(args.input.display().to_string()))
}

/// The channel that is exported, by name and in shares of its full scale at the rate of `format`.
fn shares_of(
    args: &Export,
    format: Format,
    recording: &Recording,
) -> anyhow::Result<(String, Shares)> {
    let (channel, signal) = recording.raw(args.channel.as_deref())?;
    let (what, rate) = (
        format!("`{}`", channel.name),
        format.rate_of(signal.rate())?,
    );
    let shares = shares_of_full_scale(&what, signal, &channel.unit, rate)?;
    Ok((channel.name.clone(), shares))
}

/// All channels, or the one that is named, as time responses.
fn universal(args: &Export, recording: &Recording) -> Outcome<Written> {
    let mut warnings = recording.about.warnings.clone();
    let one = match &args.channel {
        Some(channel) => {
            let (channel, _) = recording.raw(Some(channel))?;
            Some(Recording::new(
                vec![channel.clone()],
                recording.clock_of(&channel.name).rate_hz,
                recording.about.condition.clone(),
                recording.about.provenance.clone(),
            )?)
        }
        None => None,
    };
    let written = one.as_ref().unwrap_or(recording);
    warnings.extend(write_uff_recording(&args.out, written)?);
    Ok(Written {
        format: Format::Uff.name(),
        rate_hz: Some(written.rate()),
        full_scale: None,
        warnings,
    })
}

fn audio(
    args: &Export,
    contents: &Contents,
    channel: &str,
    (shares, full_scale): (&Series<Uncalibrated>, &Measure),
    warnings: &[Warning],
) -> Outcome {
    let recording = &contents.recording;
    let (about, is_drive) = (&recording.about, full_scale.unit == Unit::FullScale);
    let exported = format!("exported from {}", name(&args.input));
    let mut provenance = about.provenance.clone().then(exported);
    let clock = recording.clock_of(channel);
    provenance.losses = provenance.losses.cut(clock.start_s, shares.duration());
    let sidecar = Sidecar {
        full_scale: Some(full_scale.clone()),
        channels: vec![channel.into()],
        about: About {
            condition: about.condition.clone(),
            provenance,
            // Those of a drive stand with its rendering.
            warnings: if is_drive {
                Vec::new()
            } else {
                warnings.to_vec()
            },
        },
        annotations: match recording.clocks() {
            [_] => recording.annotations.clone(),
            _ => recording.annotations.cut(clock.start_s, shares.duration()),
        },
        rendering: contents.rendering.clone().filter(|_| is_drive),
    };
    write_wav_with_sidecar(
        &args.out,
        &[shares.samples()],
        AUDIO_HZ,
        SampleFormat::Float32,
        &sidecar,
    )?;
    Ok(())
}
