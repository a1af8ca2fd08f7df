//! `piezotact verify`: how close a measurement came to its target.

use std::path::Path;

use anyhow::anyhow;
use piezotact::Doubt;
use piezotact::quantity::{Acceleration, Decibels, Drive};
use piezotact::resample::{CommonRate, to_common_rate};
use piezotact::verify::{self, Measured, Verification, VerifyConfig, VerifyError, clipping};
use piezotact_bench::procedure::DRIVE_CHANNEL;
use piezotact_dataset::sidecar::Rendering;
use piezotact_dataset::{ReadOptions, read_recording, read_transfer};
use serde_json::Value;

use super::{outputs, rate_option, read, texture};
use crate::cli::Verify;
use crate::failure::{Failure, Outcome, usage};
use crate::output::{doubts_json, print, print_json, say_doubts, write_text};
use crate::report;
use crate::report::verify::Page;

pub(crate) fn run(args: &Verify) -> Outcome {
    let inputs = [
        Some(&args.target),
        Some(&args.measured),
        args.transfer.as_ref(),
        args.drive.as_ref(),
    ];
    let inputs: Vec<_> = inputs
        .into_iter()
        .flatten()
        .map(std::path::PathBuf::as_path)
        .collect();
    let written: Vec<_> = args
        .report
        .iter()
        .map(std::path::PathBuf::as_path)
        .collect();
    outputs(&inputs, &written)?;
    let target = read(&args.target, &args.reading)?;
    let scale = args
        .measured_scale
        .clone()
        .or_else(|| args.reading.scale.clone());
    let measured = read_recording(
        &args.measured,
        &ReadOptions {
            scale,
            rate: rate_option(args.reading.rate)?,
        },
    )?;
    let function = args
        .transfer
        .as_ref()
        .map(|path| read_transfer(path)?.function::<Drive, Acceleration>(path))
        .transpose()?;
    let wanted = texture(&args.target, &target.recording, args.channel.as_deref())?;
    let response = texture(
        &args.measured,
        &measured.recording,
        args.measured_channel.as_deref(),
    )?;
    let stated = args
        .drive
        .as_ref()
        .map(|path| rendering_of(path))
        .transpose()?;
    let rendering = stated.as_ref().or(measured.rendering.as_ref());

    let mut doubts: Vec<Doubt> = target.recording.doubts.clone();
    let mut add = |new: Vec<Doubt>| {
        for doubt in new {
            if !doubts.contains(&doubt) {
                doubts.push(doubt);
            }
        }
    };
    add(measured.recording.doubts.clone());
    add(function
        .iter()
        .flat_map(|function| function.doubts.clone())
        .collect());
    if let Some(rendering) = rendering {
        add(rendering
            .condition
            .doubts_when_measured(&measured.recording.condition));
        let compared = report::name(&args.target);
        if !rendering.target.is_empty() && rendering.target != compared {
            add(vec![Doubt::OtherTarget {
                rendered: rendering.target.clone(),
                compared,
            }]);
        }
        add(rendering.doubts.clone());
    }
    // Clipping is looked for at the rate it was acquired with.
    let drive = measured.recording.series::<Drive>(Some(DRIVE_CHANNEL)).ok();
    let limit = measured
        .setup
        .as_ref()
        .map_or(1.0, |setup| setup.drive_limit());
    let drive = drive.as_ref().map(|drive| (drive, limit));
    let clipping = clipping(
        &response,
        drive,
        rendering.map(|rendering| &rendering.headroom),
    );
    let CommonRate {
        first: wanted,
        second: response,
        doubt,
    } = to_common_rate(("the target", wanted), ("the measurement", response))?;
    add(doubt.into_iter().collect());
    let mut config = VerifyConfig::over(args.band, wanted.rate().hz());
    if let Some(rendering) = rendering {
        config.achievable.clone_from(&rendering.achievable_band_hz);
        config.level = Decibels(rendering.level_db);
    }
    let compared = Measured {
        response: &response,
        clipping,
    };
    let mut verification =
        verify::verify(&wanted, compared, &config).map_err(|error| match error {
            VerifyError::BandAboveNyquist { .. } | VerifyError::NoLine { .. } => usage(error),
            _ => Failure::from(error),
        })?;
    // What clipped is said by the verification, with what was measured of it.
    let said = |what: &str| {
        verification
            .doubts
            .iter()
            .any(|doubt| matches!(doubt, Doubt::Clipped { what: other, .. } if other == what))
    };
    doubts.retain(|doubt| !matches!(doubt, Doubt::Clipped { what, .. } if what.starts_with("the drive") || said(what)));
    verification.doubts.splice(0..0, doubts);
    if let Some(path) = &args.report {
        let page = Page {
            title: format!("Verification of {}", report::name(&args.target)),
            target: &target.recording,
            verification: &verification,
            function: function.as_ref(),
            drive,
            rendering,
            provenance: &measured.recording.provenance,
            condition: &measured.recording.condition,
            straight: None,
        };
        write_text(path, &report::verify::render(&page)?)?;
    }
    if args.json {
        print_json(&verification_json(&verification)?)?;
    } else {
        say_doubts(&verification.doubts);
        if let Some(path) = &args.report {
            print(&format!("report: {}", path.display()))?;
        }
        print(&verification.verdict())?;
    }
    verdict(&verification)
}

/// How the drive in `path` was rendered.
fn rendering_of(path: &Path) -> Outcome<Rendering> {
    let contents = read_recording(path, &ReadOptions::default())?;
    contents.rendering.ok_or_else(|| {
        Failure::Data(anyhow!(
            "{}: expected a drive that `piezotact render` wrote, with its sidecar, found none; leave --drive out, or give the drive",
            path.display()
        ))
    })
}

/// Whether a verification passed, as an outcome.
pub(crate) fn verdict(verification: &Verification) -> Outcome {
    if verification.passed {
        Ok(())
    } else {
        Err(Failure::NotPassed)
    }
}

/// A verification as JSON, with the sentences of its doubts and its verdict.
pub(crate) fn verification_json(verification: &Verification) -> Outcome<Value> {
    let mut value = serde_json::to_value(verification)?;
    if let Some(fields) = value.as_object_mut() {
        fields.insert("doubts".into(), doubts_json(&verification.doubts)?);
        fields.insert("verdict".into(), verification.verdict().into());
    }
    Ok(value)
}
