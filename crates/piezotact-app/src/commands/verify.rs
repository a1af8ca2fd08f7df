//! `piezotact verify`: how close a measurement came to its target.

use piezotact::Doubt;
use piezotact::quantity::{Acceleration, Decibels, Drive};
use piezotact::resample::{CommonRate, to_common_rate};
use piezotact::verify::{self, Measured, Verification, VerifyConfig, VerifyError};
use piezotact_bench::procedure::DRIVE_CHANNEL;
use piezotact_dataset::read_transfer;
use serde_json::Value;

use super::{read, texture};
use crate::cli::Verify;
use crate::failure::{Failure, Outcome, usage};
use crate::output::{doubts_json, print, print_json, say_doubts, write_text};
use crate::report::{self, Page};

pub(crate) fn run(args: &Verify) -> Outcome {
    let target = read(&args.target, &args.reading)?;
    let measured = read(&args.measured, &args.reading)?;
    let function = args
        .transfer
        .as_ref()
        .map(|path| read_transfer(path)?.function::<Drive, Acceleration>(path))
        .transpose()?;
    let mut wanted = texture(&args.target, &target.recording, args.channel.as_deref())?;
    let response = texture(&args.measured, &measured.recording, None)?;
    let mut doubts: Vec<Doubt> = target
        .recording
        .doubts
        .iter()
        .chain(&measured.recording.doubts)
        .cloned()
        .collect();
    let rendering = measured.rendering.as_ref();
    if let Some(level_db) = rendering
        .map(|rendering| rendering.level_db)
        .filter(|level_db| *level_db != 0.0)
    {
        wanted = wanted.amplified(Decibels(level_db));
        doubts.push(Doubt::LevelChanged { level_db });
    }
    let CommonRate {
        first: wanted,
        second: response,
        doubt,
    } = to_common_rate(("the target", wanted), ("the measurement", response))?;
    doubts.extend(doubt);
    let mut config = VerifyConfig::over(args.band, wanted.rate().hz());
    if let Some(rendering) = rendering {
        config.achievable.clone_from(&rendering.achievable_band_hz);
        doubts.extend(
            rendering
                .doubts
                .iter()
                .filter(|doubt| !doubts.contains(doubt))
                .cloned()
                .collect::<Vec<_>>(),
        );
    }
    let drive = measured.recording.series::<Drive>(Some(DRIVE_CHANNEL)).ok();
    let limit = measured
        .setup
        .as_ref()
        .map_or(1.0, |setup| setup.drive_limit());
    let compared = Measured {
        response: &response,
        drive: drive.as_ref().map(|drive| (drive, limit)),
    };
    let mut verification =
        verify::verify(&wanted, compared, &config).map_err(|error| match error {
            VerifyError::BandAboveNyquist { .. } => usage(error),
            _ => Failure::from(error),
        })?;
    verification.doubts.splice(0..0, doubts);
    if let Some(path) = &args.report {
        let page = Page {
            title: format!("Verification of {}", report::name(&args.target)),
            verification: &verification,
            target: &wanted,
            function: function.as_ref(),
            drive: drive.as_ref().map(|drive| (drive, limit)),
            rendering,
            provenance: &measured.recording.provenance,
            condition: &measured.recording.condition,
            straight: None,
        };
        write_text(path, &report::render(&page)?)?;
    }
    if args.json {
        return print_json(&verification_json(&verification)?);
    }
    say_doubts(&verification.doubts);
    if let Some(path) = &args.report {
        print(&format!("report: {}", path.display()))?;
    }
    print(&verification.verdict())
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
