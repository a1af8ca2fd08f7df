//! `piezotact transfer`: the transfer function between two channels of a recording.

use piezotact::integrity::SignalDoubt;
use piezotact::transfer::TransferDoubt;
use std::path::{Path, PathBuf};

use anyhow::anyhow;
use piezotact::Doubt;
use piezotact::device::{DeviceDescription, DriveSetup, ImpossibleSetup, drive_of_potential};
use piezotact::integrity::{Pair, never_changes, said_of_a_pair, transfer_doubts};
use piezotact::quantity::{Potential, Uncalibrated, Unit, Volts};
use piezotact::recording::RecordingError;
use piezotact::run::lost_s;
use piezotact::series::Series;
use piezotact::spectrum::{EstimateError, WelchConfig};
use piezotact::transfer::{Estimator, OneClock, TransferError, estimate_without, prepared};
use piezotact_dataset::{TransferDocument, TransferFormat, read_device, write_transfer};
use serde_json::json;

use super::{drive_limit, outputs, read};
use crate::cli::{EstimatorName, Transfer};
use crate::failure::{Failure, Outcome, usage};
use crate::output::{digits, doubts_json, print, print_json, say_doubts, write_text};
use crate::report::transfer::{Page, render};

pub(crate) fn run(args: &Transfer) -> Outcome {
    let written: Vec<&Path> = std::iter::once(&args.out)
        .chain(&args.report)
        .map(PathBuf::as_path)
        .collect();
    outputs(&[&args.recording], &written)?;
    let contents = read(&args.recording, &args.reading)?;
    let recording = &contents.recording;
    let named = |error: RecordingError| {
        Failure::Data(anyhow::Error::new(error).context(args.recording.display().to_string()))
    };
    let setup = match (&contents.setup, described(args, contents.setup.as_ref())?) {
        (Some(stated), Some(asked)) => {
            require_same(args, stated, &asked)?;
            Some(stated.clone())
        }
        (stated, asked) => asked.or_else(|| stated.clone()),
    };
    if args.drive == args.response {
        return Err(usage(anyhow!(
            "expected two channels, found `{}` as both drive and response; name the one that answers",
            args.drive
        )));
    }
    recording
        .require_one_clock([args.drive.as_str(), &args.response])
        .map_err(named)?;
    let (drive_channel, drive) = recording.raw(Some(&args.drive)).map_err(named)?;
    let (response_channel, response) = recording.raw(Some(&args.response)).map_err(named)?;
    let mut drive_unit = drive_channel.unit.clone();
    let drive = match args.volts_per_full_scale {
        Some(volts) if drive_unit == Unit::Volt => {
            drive_unit = Unit::FullScale;
            let potential = recording
                .series::<Potential>(Some(&args.drive))
                .map_err(named)?;
            let drive = drive_of_potential(&potential, Volts(volts))?;
            Series::<Uncalibrated>::new(drive.into_samples(), response.rate())?
        }
        Some(_) if drive_unit != Unit::FullScale => {
            return Err(usage(anyhow!(
                "expected the drive channel in V or FS, found {drive_unit}; state its unit in the header, or leave --volts-per-full-scale out"
            )));
        }
        _ => drive,
    };
    let estimator = match args.estimator {
        EstimatorName::H1 => Estimator::H1,
        EstimatorName::H2 => Estimator::H2,
        EstimatorName::Hv => Estimator::Hv,
    };
    for (name, series) in [(&args.drive, &drive), (&args.response, &response)] {
        if never_changes(series.samples()) {
            return Err(Failure::Data(anyhow!(
                "{}: expected the channel `{name}` to hold a signal, found {} from beginning to end; check its cable, its range and its name",
                args.recording.display(),
                digits(series.samples()[0])
            )));
        }
    }
    let welch = WelchConfig::hann(args.segment);
    let OneClock {
        response,
        missing_s: lost,
        doubts: clocks,
    } = prepared(&drive, response, &welch, lost_s(&recording.about.doubts));
    let mut function = estimate_without(&drive, &response, &welch, estimator, &lost).map_err(
        |error| match error {
            TransferError::Estimate(EstimateError::Config { .. }) => usage(error),
            _ => Failure::Data(
                anyhow::Error::new(error).context(args.recording.display().to_string()),
            ),
        },
    )?;
    function.about.doubts.extend(clocks);
    if let Some(band) = recording.about.provenance.driven_hz {
        function.driven_within(band);
    }
    // The channels here have names and units, not types.
    function
        .about
        .doubts
        .retain(|doubt| doubt.kind::<SignalDoubt>().is_none());
    let limit = drive_limit(setup.as_ref());
    let broken = transfer_doubts(&Pair {
        drive: drive.samples(),
        response: response.samples(),
        rate: response.rate(),
        drive_name: &args.drive,
        response_name: &args.response,
        drive_limit: (drive_unit == Unit::FullScale).then_some(limit),
    });
    function.about.doubts.extend(broken.iter().cloned());
    let sends = |unit: &Unit| matches!(unit, Unit::FullScale | Unit::Volt);
    if drive_unit == Unit::MetrePerSecondSquared && sends(&response_channel.unit) {
        function
            .about
            .doubts
            .push(Doubt::from(TransferDoubt::SwappedUnits {
                drive: drive_unit.to_string(),
                response: response_channel.unit.to_string(),
            }));
    }
    if drive_unit == Unit::Newton && response_channel.unit == Unit::MetrePerSecondSquared {
        function.about.doubts.extend(function.inverted_polarity());
    }
    let estimated = std::mem::take(&mut function.about.provenance.steps);
    function.about.provenance = recording
        .about
        .provenance
        .clone()
        .then(format!("{} → {}", args.drive, args.response));
    // The transfer function says itself which band was driven.
    function.about.provenance.driven_hz = None;
    function.about.provenance.steps.extend(estimated);
    function.about.condition = recording.about.condition.clone();
    function.drive = setup;
    // What the transfer function says of its two channels is not said again of each.
    let of_the_file = recording.about.doubts.iter();
    let more = of_the_file.filter(|doubt| !said_of_a_pair(doubt, &broken));
    function.about.doubts.extend(more.cloned());
    let document = TransferDocument::of(&function, drive_unit, response_channel.unit.clone());
    write_transfer(&args.out, &document)?;
    function
        .about
        .doubts
        .extend(TransferFormat::of_ending(&args.out).losses());
    if let Some(report) = &args.report {
        let page = Page {
            title: format!("Transfer function: {} → {}", args.drive, args.response),
            function: &function,
            unit: format!("({})/{}", document.response_unit, document.drive_unit),
            response_unit: document.response_unit.to_string(),
            distortion: None,
            repeats: None,
            refused: Vec::new(),
        };
        write_text(report, &render(&page)?)?;
    }
    if args.json {
        return print_json(&json!({
            "out": args.out,
            "drive_unit": document.drive_unit,
            "response_unit": document.response_unit,
            "averages": function.averages,
            "driven_hz": function.driven,
            "resolution_hz": function.resolution_hz(),
            "doubts": doubts_json(&function.about.doubts)?,
        }));
    }
    say_doubts(&function.about.doubts);
    print(&format!(
        "wrote {}: {} lines in steps of {:.2} Hz from {} averages, from {} to {}",
        args.out.display(),
        function.response().len(),
        function.resolution_hz(),
        function.averages,
        document.drive_unit,
        document.response_unit
    ))
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
    let load_f = stated_f.unwrap_or(device.actuator().capacitance_f);
    DriveSetup::new(set, Volts(volts), load_f)
        .map(Some)
        .map_err(usage::<ImpossibleSetup>)
}

/// Refuses options that describe another device than the one that the recording states.
fn require_same(args: &Transfer, stated: &DriveSetup, asked: &DriveSetup) -> Outcome {
    let close = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-6;
    let load = args.load_nf.is_none() || close(stated.load_f, asked.load_f);
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
            "the {}, {:.4} V at full scale and {:.4} nF",
            setup.amplification(),
            setup.volts_per_full_scale,
            setup.load_f * 1e9
        )
    };
    Err(Failure::Data(anyhow!(
        "{}: expected the device that the recording states, {}, found options for {}; leave --device, --gain, --volts-per-full-scale and --load-nf out",
        args.recording.display(),
        told(stated),
        told(asked)
    )))
}
