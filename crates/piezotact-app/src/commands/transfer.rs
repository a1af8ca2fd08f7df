//! `piezotact transfer`: the transfer function between two channels of a recording.

use std::path::Path;

use anyhow::anyhow;
use piezotact::device::{DeviceDescription, DriveSetup, ImpossibleSetup};
use piezotact::document::Kept;
use piezotact::quantity::Volts;
use piezotact::recording::Recording;
use piezotact::spectrum::{EstimateError, WelchConfig};
use piezotact::transfer::{
    BetweenChannels, BetweenConfig, Estimator, Excitation, ForceWindow, ImpactConfig,
    ImpactSegment, TransferError, between_channels, between_in_parts,
};
use piezotact_bench::procedure::usual_segment;
use piezotact_dataset::{Contents, TransferDocument, TransferFormat, read_device, write_transfer};

use crate::cli::{EstimatorName, ExcitationName, ForceWindowName, Transfer};
use crate::deliver::deliver_and;
use crate::failure::{Failure, Outcome, usage};
use crate::keeping::Earlier;
use crate::large::{LARGE_BYTES, Large};
use crate::places::outputs;
use crate::reading::read_uninspected;

pub(crate) fn run(args: &Transfer) -> Outcome {
    let out = std::iter::once(args.out.as_path());
    let written: Vec<&Path> = out.chain(args.outputs.files()).collect();
    outputs(&[&args.recording], &written)?;
    let large = Large::open(&args.recording, &args.reading, LARGE_BYTES)?;
    let in_parts = large.map(|large| of_large(args, &large)).transpose()?;
    let mut found = match in_parts.flatten() {
        Some(found) => found,
        None => {
            let contents = read_uninspected(&args.recording, &args.reading)?;
            let found = between_channels(&contents.recording, &config(args, &contents)?);
            found.map_err(|error| refused(args, error))?
        }
    };
    let [drive_unit, response_unit] = [found.drive_unit.clone(), found.response_unit.clone()];
    let stored = TransferDocument::of(&found.function, drive_unit, response_unit);
    let earlier = Earlier::at(&args.out, "the earlier file")?;
    write_transfer(&args.out, &stored)?;
    earlier.settle()?;
    let lost = TransferFormat::of_ending(&args.out).losses();
    found.function.about.warnings.extend(lost);
    let found = Kept {
        out: &args.out,
        value: &found,
    };
    deliver_and(&args.outputs, &found, &[&args.out])
}

/// The transfer function of a recording that is read part by part; `None` where the whole recording is needed.
fn of_large(args: &Transfer, large: &Large) -> Outcome<Option<BetweenChannels>> {
    let contents = large.contents();
    let config = config(args, contents)?;
    let mut each = |channels: &[&str], take: &mut dyn FnMut(&Recording)| {
        large.each(channels, |_, part| {
            take(part);
            Ok(())
        })
    };
    let found = between_in_parts(&contents.recording, large.samples(), &config, &mut each)?;
    found.map_err(|error| refused(args, error))
}

/// What the options ask for of the recording in `contents`.
fn config<'a>(args: &'a Transfer, contents: &Contents) -> Outcome<BetweenConfig<'a>> {
    Ok(BetweenConfig {
        drive: &args.drive,
        response: &args.response,
        welch: WelchConfig::hann(
            args.segment
                .unwrap_or_else(|| usual_segment(contents.recording.rate())),
        ),
        excitation: excitation(args)?,
        impact: ImpactConfig {
            segment: (args.segment).map_or(ImpactSegment::Fitted, ImpactSegment::Samples),
            force_window: match args.force_window {
                Some(ForceWindowName::Off) => ForceWindow::None,
                Some(ForceWindowName::On) | None => ForceWindow::OverPulse,
            },
            exponential: args.exponential.unwrap_or_default(),
            ..ImpactConfig::usual()
        },
        estimator: estimator(args)?,
        known_input: args.known_input,
        volts_per_full_scale: args.volts_per_full_scale.map(Volts),
        setup: setup(args, contents.setup.as_ref())?,
        lost_s: (contents.recording.about.provenance.losses)
            .stretches_s
            .clone(),
    })
}

/// The estimator of the options.
fn estimator(args: &Transfer) -> Outcome<Estimator> {
    match (args.estimator, args.noise_ratio) {
        (EstimatorName::H1, None) => Ok(Estimator::H1),
        (EstimatorName::H2, None) => Ok(Estimator::H2),
        (EstimatorName::Hv, None) => Ok(Estimator::Hv),
        (EstimatorName::Hv, Some(ratio)) => Estimator::hv_at(ratio).ok_or_else(|| {
            usage(anyhow!(
                "expected a --noise-ratio from 1e-30 to 1e30, found {ratio:?}; without noise on the drive use --estimator h1, without noise on \
                    the response --estimator h2"
            ))
        }),
        (EstimatorName::H1 | EstimatorName::H2, Some(_)) => Err(usage(anyhow!(
            "expected --estimator hv with --noise-ratio, found another; H1 and H2 assume noise on one channel only"
        ))),
    }
}

/// What the drive is taken for: stated windows of impacts state that it is one.
fn excitation(args: &Transfer) -> Outcome<Excitation> {
    let option = match (args.force_window, args.exponential) {
        (Some(_), _) => Some("--force-window"),
        (None, Some(_)) => Some("--exponential"),
        (None, None) => None,
    };
    match (args.excitation, option) {
        (ExcitationName::Random, Some(option)) => Err(usage(anyhow!(
            "expected {option} with --excitation impact, found --excitation random; a random drive has no such window, leave \
                {option} out"
        ))),
        (ExcitationName::Random, None) => Ok(Excitation::Lasting),
        (ExcitationName::Auto, None) => Ok(Excitation::Found),
        #[cfg(feature = "modal")]
        (ExcitationName::Impact, _) | (ExcitationName::Auto, Some(_)) => Ok(Excitation::Impact),
        #[cfg(not(feature = "modal"))]
        (ExcitationName::Impact, _) | (ExcitationName::Auto, Some(_)) => Err(
            super::lacking::without(option.unwrap_or("--excitation impact")),
        ),
    }
}

/// What is refused because of the options is a matter of the command line; else the file is named.
fn refused(args: &Transfer, error: TransferError) -> Failure {
    let file = args.recording.display().to_string();
    match error {
        TransferError::SameChannel { .. } => usage(error),
        TransferError::NotVolts { .. } => usage(anyhow!(
            "{error}; state its unit in the header, or leave --volts-per-full-scale out"
        )),
        TransferError::Estimate(EstimateError::Config { .. })
        | TransferError::Segment { .. }
        | TransferError::Damping { .. } => usage(error),
        TransferError::Recording(error) => Failure::Data(anyhow::Error::new(error).context(file)),
        TransferError::Series(error) => Failure::Data(error.into()),
        error => Failure::Data(anyhow::Error::new(error).context(file)),
    }
}

/// The device that the recording states or the options describe, which have to be the same where both do.
fn setup(args: &Transfer, stated: Option<&DriveSetup>) -> Outcome<Option<DriveSetup>> {
    match (stated, described(args, stated)?) {
        (Some(stated), Some(asked)) => {
            require_same(args, stated, &asked)?;
            Ok(Some(stated.clone()))
        }
        (stated, asked) => Ok(asked.or_else(|| stated.cloned())),
    }
}

/// The device that the options describe, if they do; what they leave out is as the recording has `stated` it.
fn described(args: &Transfer, stated: Option<&DriveSetup>) -> Outcome<Option<DriveSetup>> {
    let Some(volts) = args.volts_per_full_scale else {
        return Ok(None);
    };
    let device = match (&args.device, stated) {
        (Some(named), _) => read_device(named)?,
        (None, Some(stated)) => stated.device().clone(),
        (None, None) => DeviceDescription::drv2667().clone(),
    };
    let as_stated = stated.map(|stated| &stated.gain.name);
    let as_stated = as_stated.filter(|_| args.device.is_none());
    let set = match (args.gain.as_ref().or(as_stated), device.only_gain()) {
        (Some(gain), _) => device.at(gain).map_err(usage)?,
        (None, Some(_)) => device.at_usual_gain(),
        (None, None) => {
            return Err(usage(anyhow!(
                "expected --gain with --volts-per-full-scale, found none; state which gain of the {} was set, {}",
                device.name(),
                device.gain_names()
            )));
        }
    };
    let stated_f = args.load_nf.map(|load_nf| load_nf * 1e-9);
    let load_f = stated_f.or(device.actuator().capacitance_f);
    DriveSetup::new(set, Volts(volts), load_f)
        .map(Some)
        .map_err(usage::<ImpossibleSetup>)
}

/// Refuses options that describe another device than the one that the recording states.
fn require_same(args: &Transfer, stated: &DriveSetup, asked: &DriveSetup) -> Outcome {
    let close = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-6;
    let load = args.load_nf.is_none()
        || stated
            .load_f
            .zip(asked.load_f)
            .is_some_and(|(a, b)| close(a, b));
    let device = args.device.is_none() || stated.device() == asked.device();
    if stated.amplifies_like(asked)
        && device
        && close(stated.volts_per_full_scale, asked.volts_per_full_scale)
        && load
    {
        return Ok(());
    }
    let told = |setup: &DriveSetup| {
        format!(
            "the {}, {:.4} V at full scale and {}",
            setup.amplification(),
            setup.volts_per_full_scale,
            match setup.load_f {
                Some(load_f) => format!("{:.4} nF", load_f * 1e9),
                None => setup.load(),
            }
        )
    };
    Err(Failure::Data(anyhow!(
        "{}: expected the device that the recording states, {}, found options for {}; leave --device, --gain, --volts-per-full-scale and --load-nf out",
        args.recording.display(),
        told(stated),
        told(asked)
    )))
}
