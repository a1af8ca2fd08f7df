//! `piezotact render`: the drive that makes a finger feel a texture.

use std::path::Path;

use piezotact::quantity::{Acceleration, Decibels, Drive, Measure, SampleRate, Unit};
use piezotact::render::{self, Clipping, RenderConfig, RenderError, RenderedDrive, require_gain};
use piezotact_dataset::sidecar::{Rendering, Sidecar, write_sidecar};
use piezotact_dataset::wav::{SampleFormat, write_wav};
use piezotact_dataset::{ReadOptions, read_recording, read_transfer};
use serde_json::json;

use super::{rate_option, texture};
use crate::cli::Render;
use crate::failure::{Failure, Outcome, usage};
use crate::output::{doubts_json, print, print_json, say_doubts};

pub(crate) fn run(args: &Render) -> Outcome {
    let document = read_transfer(&args.transfer)?;
    let function = document.function::<Drive, Acceleration>(&args.transfer)?;
    if let Some(gain) = args.gain {
        require_gain(function.drive.as_ref(), gain)?;
    }
    let options = ReadOptions {
        scale: args.scale.clone(),
        rate: rate_option(args.target_rate)?,
    };
    let contents = read_recording(&args.target, &options)?;
    let recording = &contents.recording;
    let target =
        texture(&args.target, recording, args.channel.as_deref())?.amplified(Decibels(args.level));
    let mut config = RenderConfig::over(
        args.band,
        SampleRate::new(f64::from(args.rate)).map_err(usage)?,
    );
    if args.allow_clipping {
        config.clipping = Clipping::Allow;
    }
    let mut drive = render::render(&target, &function, &config).map_err(|error| match error {
        RenderError::BandAboveNyquist { .. } | RenderError::Rate(_) => usage(error),
        _ => Failure::Data(anyhow::Error::new(error).context(args.target.display().to_string())),
    })?;
    drive.doubts.splice(0..0, recording.doubts.iter().cloned());
    drive
        .provenance
        .steps
        .insert(0, format!("target {}", args.target.display()));
    write_drive(&args.out, &drive, args.rate, args.level)?;
    if args.json {
        return print_json(&json!({
            "out": args.out,
            "rate_hz": args.rate,
            "headroom": drive.headroom,
            "achievable_band_hz": drive.achievable,
            "given_up_band_hz": drive.given_up,
            "drive_setup": drive.setup,
            "doubts": doubts_json(&drive.doubts)?,
        }));
    }
    say_doubts(&drive.doubts);
    let bands: Vec<String> = drive.achievable.iter().map(ToString::to_string).collect();
    print(&format!(
        "wrote {}: peak {:.3} of full scale, {:.1} dB below {}; achievable {}",
        args.out.display(),
        drive.headroom.peak,
        drive.headroom.headroom_db,
        drive.headroom.limited_by,
        bands.join(", ")
    ))
}

/// Writes a drive and its sidecar. The sidecar goes first: a drive is never there without it.
pub(crate) fn write_drive(
    path: &Path,
    drive: &RenderedDrive,
    rate_hz: u32,
    level_db: f64,
) -> Outcome {
    let sidecar = Sidecar {
        full_scale: Some(Measure {
            value: 1.0,
            unit: Unit::FullScale,
        }),
        channels: vec!["drive".into()],
        condition: drive.condition.clone(),
        provenance: drive.provenance.clone(),
        rendering: Some(Rendering::of(drive, level_db)),
    };
    write_sidecar(path, &sidecar)?;
    write_wav(
        path,
        &[drive.drive.samples()],
        rate_hz,
        SampleFormat::Float32,
    )?;
    Ok(())
}
