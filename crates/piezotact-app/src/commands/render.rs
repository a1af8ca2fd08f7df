//! `piezotact render`: the drive that makes a finger feel a texture.

use std::path::Path;

use anyhow::anyhow;
use piezotact::manipulate::{Lineage, Operation, Step};
use piezotact::quantity::{Acceleration, Decibels, Drive, Measure, SampleRate, Unit};
use piezotact::recording::Recording;
use piezotact::render::{self, Clipping, RenderConfig, RenderError, RenderedDrive, require_gain};
use piezotact::series::Series;
use piezotact_dataset::sidecar::{Rendering, Sidecar, sidecar_path};
use piezotact_dataset::wav::{SampleFormat, write_wav_with_sidecar};
use piezotact_dataset::{ReadOptions, read_recording, read_transfer};
use serde_json::json;

use super::{outputs, rate_option, texture};
use crate::cli::Render;
use crate::failure::{Failure, Outcome, usage};
use crate::output::{doubts_json, headroom_text, print, print_json, say_doubts};
use crate::report::name;

pub(crate) fn run(args: &Render) -> Outcome {
    outputs(
        &[&args.target, &args.transfer],
        &[&args.out, &sidecar_path(&args.out)],
    )?;
    if !(-120.0..=120.0).contains(&args.level) {
        return Err(usage(anyhow!(
            "expected a level from -120 to 120 dB, found {}; 0 is the texture's own",
            args.level
        )));
    }
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
        RenderError::BandAboveNyquist { .. }
        | RenderError::NoLine { .. }
        | RenderError::Rate(_) => usage(error),
        RenderError::ExceedsFullScale { fits_at, .. } => {
            let level = args.level + fits_at.0;
            Failure::Data(anyhow!(
                "{}: {error}: --level {level:.1} fits, --allow-clipping plays it as it is",
                args.target.display()
            ))
        }
        _ => Failure::Data(anyhow::Error::new(error).context(args.target.display().to_string())),
    })?;
    drive.doubts.splice(0..0, recording.doubts.iter().cloned());
    drive
        .provenance
        .steps
        .insert(0, format!("target {}", args.target.display()));
    drive.provenance.lineage = Some(lineage(args, recording, &target, &drive));
    let rendering = Rendering::of(&drive, &name(&args.target), args.level);
    write_drive(&args.out, &drive, args.rate, rendering)?;
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
        "wrote {}: {}; achievable {}",
        args.out.display(),
        headroom_text(&drive.headroom),
        bands.join(", ")
    ))
}

/// What the texture was made from, with its rendering as the last step.
fn lineage(
    args: &Render,
    recording: &Recording,
    target: &Series<Acceleration>,
    drive: &RenderedDrive,
) -> Lineage {
    let so_far = recording.provenance.lineage.clone();
    let operation = Operation::Rendered {
        transfer: name(&args.transfer),
        gain: drive.setup.as_ref().map(|setup| setup.gain),
        level_db: args.level,
        band_hz: args.band,
    };
    so_far
        .unwrap_or_else(|| Lineage::of(name(&args.target)))
        .then(Step::between(operation, target, &drive.drive))
}

/// Writes a drive with its sidecar.
pub(crate) fn write_drive(
    path: &Path,
    drive: &RenderedDrive,
    rate_hz: u32,
    rendering: Rendering,
) -> Outcome {
    let sidecar = Sidecar {
        full_scale: Some(Measure {
            value: 1.0,
            unit: Unit::FullScale,
        }),
        channels: vec!["drive".into()],
        condition: drive.condition.clone(),
        provenance: drive.provenance.clone(),
        rendering: Some(rendering),
    };
    write_wav_with_sidecar(
        path,
        &[drive.drive.samples()],
        rate_hz,
        SampleFormat::Float32,
        &sidecar,
    )?;
    Ok(())
}
