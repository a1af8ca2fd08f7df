//! `piezotact verify`: how close a measurement came to its target.

use piezotact::clipping::ClippingDoubt;
use piezotact::verify::VerifyDoubt;
use std::path::{Path, PathBuf};

use anyhow::anyhow;
use piezotact::Doubt;
use piezotact::clipping::clipping;
use piezotact::doubt::Doubts;
use piezotact::quantity::{Acceleration, Decibels, Drive, Quantity, Unit};
use piezotact::recording::Recording;
use piezotact::resample::{CommonRate, to_common_rate};
use piezotact::score::with_felt_difference;
use piezotact::series::Series;
use piezotact::verify::{
    self, Changed, Measured, Verdict, Verification, VerifyConfig, VerifyError, predicted_straight,
};
use piezotact_bench::procedure::DRIVE_CHANNEL;
use piezotact_dataset::sidecar::{Rendering, read_sidecar};
use piezotact_dataset::{ReadOptions, read_recording, read_transfer};
use serde_json::{Value, json};

use super::manipulate::Chosen;
use super::{inspected, manipulate, outputs, rate_option, read, texture};
use crate::advice::text;
use crate::cli::{Reading, Verify};
use crate::failure::{Failure, Outcome, usage};
use crate::output::{difference_db, doubts_json, print, print_json, say, say_doubts, write_text};
use crate::report;
use crate::report::verify::{Also, Before, Found, Page, ShownDrive, Told};

pub(crate) fn run(args: &Verify) -> Outcome {
    let named = [Some(&args.target), Some(&args.measured)].into_iter();
    let named = named.chain([args.transfer.as_ref(), args.drive.as_ref()]);
    let inputs: Vec<&Path> = named
        .flatten()
        .chain(&args.also)
        .chain(&args.before)
        .map(PathBuf::as_path)
        .collect();
    let written: Vec<&Path> = args.report.iter().map(PathBuf::as_path).collect();
    outputs(&inputs, &written)?;
    let target = read(&args.target, &args.reading)?.recording;
    let function = args
        .transfer
        .as_ref()
        .map(|path| read_transfer(path)?.function::<Drive, Acceleration>(path))
        .transpose()?;
    let wanted = texture(&args.target, &target, args.channel.as_deref())?;
    let stated = args
        .drive
        .as_ref()
        .map(|path| rendered_in(path))
        .transpose()?;
    let asked = Asked {
        args,
        target: &target,
        wanted: &wanted,
    };
    let about_function = function.iter().flat_map(|function| &function.about.doubts);
    let about_function: Vec<Doubt> = about_function.cloned().collect();
    let mut judged = judge(
        &asked,
        &args.measured,
        stated.as_ref().map(|(rendering, _)| rendering),
        &about_function,
    )?;
    let also: Vec<Judged> = args
        .also
        .iter()
        .map(|path| judge(&asked, path, None, &[]))
        .collect::<Outcome<_>>()?;
    let before = args
        .before
        .iter()
        .map(|path| textures_before(&asked, path))
        .collect::<Outcome<Vec<Earlier>>>()?;
    for earlier in &before {
        let doubts = &mut judged.verification.doubts;
        doubts.extend(earlier.doubts.iter().cloned());
    }
    let predicted = function
        .as_ref()
        .map(|function| predicted_straight(&judged.wanted, function, &judged.config));
    let measurements = [&args.measured].into_iter().chain(&args.also);
    let names = apart(measurements.map(PathBuf::as_path));
    let names_before = apart(args.before.iter().map(PathBuf::as_path));

    if let Some(path) = &args.report {
        let also: Vec<Also<'_>> = also
            .iter()
            .zip(&names[1..])
            .map(|(also, label)| Also {
                label,
                verification: &also.verification,
                doubts: also.doubts_of_its_own(&target).collect(),
                rendering: also
                    .rendering
                    .as_ref()
                    .map_or(Told::Nothing, |_| Told::Rendering),
            })
            .collect();
        let before: Vec<Before<'_>> = before
            .iter()
            .zip(&names_before)
            .map(|(earlier, label)| Before {
                label,
                series: &earlier.series,
                changed: &earlier.changed,
            })
            .collect();
        let recorded = judged.drive.as_ref().map(|(series, limit)| ShownDrive {
            series,
            limit: *limit,
            found: Found::Recorded,
        });
        let rendered = stated.as_ref().map(|(rendering, series)| ShownDrive {
            series,
            limit: rendering.headroom.limit,
            found: Found::Rendered,
        });
        let page = Page {
            title: format!("Verification of {}", report::name(&args.target)),
            target: &target,
            verification: &judged.verification,
            texture: &judged.wanted,
            measured: &names[0],
            function: function.as_ref(),
            drive: recorded.or(rendered),
            rendering: judged.rendering.as_ref(),
            provenance: &judged.recording.about.provenance,
            condition: &judged.recording.about.condition,
            predicted: predicted.as_ref(),
            also: &also,
            before: &before,
            straight: None,
        };
        write_text(path, &report::verify::render(&page)?)?;
    }
    if args.json {
        let mut value = verification_json(&judged.verification)?;
        if let Some(fields) = value.as_object_mut() {
            if let Some(predicted) = &predicted {
                let told = match predicted {
                    Ok(predicted) => serde_json::to_value(predicted)?,
                    Err(error) => json!({ "not_computed": error.to_string() }),
                };
                fields.insert("straight_predicted".into(), told);
            }
            if !also.is_empty() {
                let also = also.iter().zip(&names[1..]);
                let all = also.map(|(also, name)| named_json(name, &also.verification));
                fields.insert("also".into(), all.collect::<Outcome<Value>>()?);
            }
            if !before.is_empty() {
                let before = before.iter().zip(&names_before);
                let all = before.map(|(earlier, name)| {
                    let mut value = serde_json::to_value(&earlier.changed)?;
                    value["file"] = json!(name);
                    Ok(value)
                });
                fields.insert("before".into(), all.collect::<Outcome<Value>>()?);
            }
        }
        print_json(&value)?;
    } else {
        say_doubts(&judged.verification.doubts);
        for (also, name) in also.iter().zip(&names[1..]) {
            for doubt in also.doubts_of_its_own(&target) {
                say(&format!("{name}: doubt: {}", text(doubt)));
            }
        }
        for (earlier, name) in before.iter().zip(&names_before) {
            print(&format!(
                "from {name} to the target: level {} dB, shape {:.2} dB rms apart over {}",
                difference_db(earlier.changed.level_db),
                earlier.changed.shape_error_db_rms,
                earlier.changed.band_hz
            ))?;
        }
        if let Some(Ok(predicted)) = &predicted {
            print(&format!(
                "sent straight instead (computed, level-matched): {:.2} dB rms over {}, waveform correlation {:.3}",
                predicted.error_db_rms_level_matched,
                predicted.judged_band(&judged.verification),
                predicted.waveform_correlation
            ))?;
        }
        for (also, name) in also.iter().zip(&names[1..]) {
            print(&format!("{name}: {}", also.verification.sentence()))?;
        }
        if let Some(path) = &args.report {
            print(&format!("report: {}", path.display()))?;
        }
        print(&judged.verification.sentence())?;
    }
    verdict(&judged.verification)
}

/// What every measurement is compared with.
struct Asked<'a> {
    args: &'a Verify,
    target: &'a Recording,
    wanted: &'a Series<Acceleration>,
}

/// A measurement with how close it came.
struct Judged {
    verification: Verification,
    config: VerifyConfig,
    /// The target at the rate of the comparison.
    wanted: Series<Acceleration>,
    /// What was recorded of the drive, and the level at which the device clips.
    drive: Option<(Series<Drive>, f64)>,
    rendering: Option<Rendering>,
    recording: Recording,
}

impl Judged {
    /// What is doubted of it and not of its target alone.
    fn doubts_of_its_own(&self, target: &Recording) -> impl Iterator<Item = &Doubt> {
        let of_target = target.about.doubts.clone();
        let all = self.verification.doubts.iter();
        all.filter(move |doubt| !of_target.contains(doubt))
    }
}

/// How close the measurement in `path` came to its target; `stated` counts before what it says itself of its rendering.
fn judge(
    asked: &Asked<'_>,
    path: &Path,
    stated: Option<&Rendering>,
    more_doubts: &[Doubt],
) -> Outcome<Judged> {
    let args = asked.args;
    let scale = args
        .measured_scale
        .clone()
        .or_else(|| args.reading.scale.clone());
    let options = ReadOptions {
        scale,
        rate: rate_option(args.reading.rate)?,
    };
    let measured = inspected(path, &options)?;
    let mut channels = measured.recording.channels().iter();
    if measured.rendering.is_some() && channels.all(|channel| channel.unit == Unit::FullScale) {
        return Err(Failure::Data(anyhow!(
            "{}: expected what was recorded while a drive was played, found the drive itself; give the recording with --measured, and the drive with --drive",
            path.display()
        )));
    }
    let response = texture(path, &measured.recording, args.measured_channel.as_deref())?;
    let rendering = stated.or(measured.rendering.as_ref());

    let mut doubts: Doubts = asked.target.about.doubts.iter().cloned().collect();
    doubts.extend(measured.recording.about.doubts.iter().cloned());
    doubts.extend(more_doubts.iter().cloned());
    if let Some(rendering) = rendering {
        doubts.extend(
            rendering
                .about
                .condition
                .doubts_when_measured(&measured.recording.about.condition),
        );
        let compared = report::name(&args.target);
        if !rendering.target.is_empty() && rendering.target != compared {
            doubts.push(VerifyDoubt::OtherTarget {
                rendered: rendering.target.clone(),
                compared,
            });
        }
        doubts.extend(rendering.about.doubts.iter().cloned());
    }
    // Clipping is looked for at the rate it was acquired with.
    let limit = measured
        .setup
        .as_ref()
        .map_or(1.0, |setup| setup.drive_limit());
    let drive = measured.recording.series::<Drive>(Some(DRIVE_CHANNEL)).ok();
    if drive.is_some() {
        let channel = args.measured_channel.as_deref();
        let response = measured.recording.pick(channel, &Acceleration::UNIT);
        let names = [DRIVE_CHANNEL, response.map_or(DRIVE_CHANNEL, |c| &c.name)];
        let shared = measured.recording.require_one_clock(names);
        shared.map_err(|error| of_file(path, error))?;
    }
    let drive = drive.map(|drive| (drive, limit));
    let clipping = clipping(
        &response,
        drive.as_ref().map(|(drive, limit)| (drive, *limit)),
        rendering.map(|rendering| rendering.headroom.clipped_fraction),
    );
    let common = to_common_rate(
        ("the target", asked.wanted.clone()),
        ("the measurement", response),
    );
    let CommonRate {
        first: wanted,
        second: response,
        doubt,
    } = common.map_err(|error| of_file(path, error))?;
    doubts.extend(doubt);
    let mut config = VerifyConfig::over(args.band, wanted.rate().hz());
    if let Some(rendering) = rendering {
        config.reached.clone_from(&rendering.achievable_band_hz);
        config.level = Decibels(rendering.level_db);
        config = config.rendered_as(&rendering.config, rendering.mode());
    }
    let compared = Measured {
        response: &response,
        clipping,
    };
    let verification = verify::verify(&wanted, compared, &config);
    let verification = verification.map_err(|error| refused(path, error))?;
    let mut verification = with_felt_difference(verification);
    let known = &measured.recording.about.doubts;
    verification = verification.with_known_losses(known, &asked.target.about.doubts);
    // What clipped is said by the verification, with what was measured of it.
    doubts.retain(|doubt| match doubt.kind() {
        Some(ClippingDoubt::Clipped { .. }) => {
            let same = |other: &Doubt| (&other.code, &other.about) == (&doubt.code, &doubt.about);
            !verification.doubts.iter().any(same)
        }
        of_the_drive => of_the_drive.is_none(),
    });
    doubts.retain(|doubt| !verification.doubts.say(doubt));
    verification.doubts.put_first(doubts);
    Ok(Judged {
        verification,
        config,
        wanted,
        drive,
        rendering: rendering.cloned(),
        recording: measured.recording,
    })
}

/// What cannot be compared, with the file where it is not the target's fault.
fn refused(path: &Path, error: VerifyError) -> Failure {
    match error {
        VerifyError::BandAboveNyquist { .. } | VerifyError::NoLine { .. } => usage(error),
        VerifyError::Silent {
            what: "the target", ..
        } => Failure::from(error),
        _ => of_file(path, error),
    }
}

fn of_file(path: &Path, error: impl Into<anyhow::Error>) -> Failure {
    Failure::Data(error.into().context(path.display().to_string()))
}

/// A texture before the target was made of it.
struct Earlier {
    series: Series<Acceleration>,
    changed: Changed,
    doubts: Vec<Doubt>,
}

/// The texture in `path` beside the target; `--scale` counts for it where it does not say its own.
fn textures_before(asked: &Asked<'_>, path: &Path) -> Outcome<Earlier> {
    let args = asked.args;
    let says_its_own = read_sidecar(path)?.is_some_and(|sidecar| sidecar.full_scale.is_some());
    let reading = Reading {
        scale: args.reading.scale.clone().filter(|_| !says_its_own),
        rate: args.reading.rate,
    };
    let channel = args.before_channel.as_deref();
    let stroke = args.before_stroke.map(|number| Chosen {
        number,
        option: "--before-stroke",
    });
    let opened = manipulate::open(path, stroke, channel, &reading)?.texture;
    let called = format!("{}, the texture before,", report::name(path));
    let common = to_common_rate(
        (&called, opened.series),
        ("the target", asked.wanted.clone()),
    );
    let common = common.map_err(|error| of_file(path, error))?;
    let config = VerifyConfig::over(args.band, common.first.rate().hz());
    let changed = verify::changed(&common.first, &common.second, &config);
    let changed = changed.map_err(|error| match error {
        VerifyError::BandAboveNyquist { .. } => {
            Failure::Usage(anyhow::Error::new(error).context(path.display().to_string()))
        }
        _ => refused(path, error),
    })?;
    let mut doubts = opened.doubts;
    doubts.extend(common.doubt);
    Ok(Earlier {
        series: common.first,
        changed,
        doubts,
    })
}

/// The names of files, each unlike the others: where two are equal, with their folder, and where those are equal too with
/// a number.
fn apart<'a>(paths: impl Iterator<Item = &'a Path>) -> Vec<String> {
    let paths: Vec<&Path> = paths.collect();
    let short: Vec<String> = paths.iter().map(|path| report::name(path)).collect();
    let alone = |name: &String| short.iter().filter(|other| *other == name).count() == 1;
    let mut names: Vec<String> = Vec::new();
    for (path, name) in paths.iter().zip(&short) {
        let folder = path.parent().map(report::name).unwrap_or_default();
        let name = match folder.as_str() {
            "" => name.clone(),
            _ if alone(name) => name.clone(),
            folder => format!("{folder}/{name}"),
        };
        let mut unlike = name.clone();
        let mut number = 2;
        while names.contains(&unlike) {
            unlike = format!("{name} ({number})");
            number += 1;
        }
        names.push(unlike);
    }
    names
}

/// The drive in `path`, and how it was rendered.
fn rendered_in(path: &Path) -> Outcome<(Rendering, Series<Drive>)> {
    let contents = read_recording(path, &ReadOptions::default())?;
    let rendering = contents.rendering.ok_or_else(|| {
        Failure::Data(anyhow!(
            "{}: expected a drive that `piezotact render` wrote, with its sidecar, found none; leave --drive out, or give the drive",
            path.display()
        ))
    })?;
    let drive = contents.recording.series::<Drive>(None);
    Ok((rendering, drive.map_err(|error| of_file(path, error))?))
}

/// A further verification as JSON, with the name of its file.
fn named_json(name: &str, verification: &Verification) -> Outcome<Value> {
    let mut value = verification_json(verification)?;
    value["file"] = json!(name);
    Ok(value)
}

/// What a verification concludes, as an outcome with its exit code.
pub(crate) fn verdict(verification: &Verification) -> Outcome {
    match verification.verdict {
        Verdict::Passed => Ok(()),
        Verdict::NotPassed => Err(Failure::NotPassed),
        Verdict::PassedInPart { .. } => Err(Failure::PassedInPart),
        Verdict::NotDecided => Err(Failure::NotDecided),
    }
}

/// A verification as JSON, with the sentences of its doubts and its verdict.
pub(crate) fn verification_json(verification: &Verification) -> Outcome<Value> {
    let mut value = serde_json::to_value(verification)?;
    if let Some(fields) = value.as_object_mut() {
        fields.insert("doubts".into(), doubts_json(&verification.doubts)?);
        fields.insert("passed".into(), verification.passed().into());
        fields.insert("sentence".into(), verification.sentence().into());
    }
    Ok(value)
}
