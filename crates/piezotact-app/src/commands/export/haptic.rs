//! Textures and drives as haptic files.

use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use anyhow::anyhow;
use piezotact::Warning;
use piezotact::quantity::{Acceleration, Band, Drive, Hertz, Measure, Uncalibrated};
use piezotact::recording::Recording;
use piezotact::series::Series;
use piezotact_dataset::haptic::{
    HapticKind, haptic_kind_of_file, read_haptic, write_ahap, write_haptic, write_hjif,
};
use piezotact_dataset::{Contents, read_transfer};
use piezotact_haptic::envelope::EnvelopeConfig;
use piezotact_haptic::{
    HapticClip, HapticMetadata, HjifReferenceDevice, HjifTexture, ahap_of, clip_of, date_of,
    reference_device,
};

use super::{Format, Written, named};
use crate::cli::Export;
use crate::failure::{Outcome, usage};
use crate::report::name;

/// A clip as it is: nothing is played and analysed again. `None` where that is not asked for.
pub(super) fn of_clip(args: &Export, format: Format) -> Outcome<Option<Written>> {
    if !matches!(format, Format::Haptic | Format::Ahap)
        || haptic_kind_of_file(&args.input) != Some(HapticKind::Clip)
    {
        return Ok(None);
    }
    for (option, given) in [
        ("--rate", args.reading.rate.is_some()),
        ("--scale", !args.reading.scale.is_empty()),
        ("--channel", args.channel.is_some()),
    ] {
        if given {
            return Err(usage(anyhow!(
                "{} is a haptic clip, which is written without computing a waveform: leave {option} out",
                args.input.display()
            )));
        }
    }
    let mut clip = read_haptic(&args.input)?;
    let warnings = std::mem::take(&mut clip.warnings);
    write_clip(&args.out, &clip, format, warnings).map(Some)
}

fn write_clip(
    path: &Path,
    clip: &HapticClip,
    format: Format,
    mut warnings: Vec<Warning>,
) -> Outcome<Written> {
    if format == Format::Ahap {
        let pattern = ahap_of(clip);
        write_ahap(path, &pattern.content)?;
        warnings.extend(pattern.losses);
    } else {
        write_haptic(path, clip)?;
    }
    Ok(Written {
        format: format.name(),
        rate_hz: None,
        full_scale: None,
        warnings,
    })
}

/// A texture or a drive, in shares of its full scale, as HJIF, a clip, or AHAP by way of one.
pub(super) fn of_texture(
    args: &Export,
    format: Format,
    contents: &Contents,
    (shares, full_scale): (&Series<Uncalibrated>, Measure),
    mut written: Written,
) -> Outcome<Written> {
    let description = described(args, &contents.recording);
    if format == Format::Hjif {
        let texture = HjifTexture {
            description,
            date: today(),
            full_scale,
            device: device(args, contents)?,
        };
        let exported = write_hjif(&args.out, shares, &texture)?;
        written.warnings.extend(exported.losses);
        return Ok(written);
    }
    let (clip, losses) = clip_at(args, format, (shares, &full_scale), description)
        .map_err(|error| named(args, error))?;
    written.warnings.extend(losses);
    let warnings = write_clip(&args.out, &clip, format, written.warnings)?.warnings;
    Ok(Written {
        rate_hz: None,
        warnings,
        ..written
    })
}

/// The clip of a texture, and what it loses in `format`.
fn clip_at(
    args: &Export,
    format: Format,
    (shares, full_scale): (&Series<Uncalibrated>, &Measure),
    description: String,
) -> anyhow::Result<(HapticClip, Vec<Warning>)> {
    let metadata = HapticMetadata {
        editor: concat!("piezotact ", env!("CARGO_PKG_VERSION")).into(),
        source: name(&args.input),
        description,
        ..HapticMetadata::default()
    };
    let config = EnvelopeConfig::texture()?;
    let written_as = match format {
        Format::Ahap => "AHAP",
        _ => ".haptic",
    };
    let clip = clip_of(shares, full_scale, &config, metadata, written_as)?;
    Ok((clip.content, clip.losses))
}

/// The device that a file is for: of the transfer function, or as far as the drive says it.
fn device(args: &Export, contents: &Contents) -> Outcome<HjifReferenceDevice> {
    let Some(path) = &args.transfer else {
        let setup = contents.setup.as_ref();
        let band = contents
            .rendering
            .as_ref()
            .map(|made| made.config.inverse.band);
        return Ok(reference_device(setup, band, None));
    };
    let function = read_transfer(path)?.function::<Drive, Acceleration>(path)?;
    let rendered = Band::new(Hertz(20.0), Hertz(1000.0))?;
    let band = function
        .excited
        .and_then(|excited| excited.common(rendered))
        .unwrap_or(rendered);
    let setup = function.drive.as_ref();
    Ok(reference_device(
        setup,
        Some(band),
        function.strongest_hz(band),
    ))
}

/// What a texture is, in a line.
fn described(args: &Export, recording: &Recording) -> String {
    let condition = recording.about.condition.to_string();
    if condition.is_empty() {
        name(&args.input)
    } else {
        format!("{}: {condition}", name(&args.input))
    }
}

fn today() -> String {
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH);
    date_of(since_1970.map_or(0, |time| time.as_secs()))
}
