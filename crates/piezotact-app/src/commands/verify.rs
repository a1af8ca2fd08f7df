//! `piezotact verify`: how close a measurement came to its target.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use piezotact::Warning;
use piezotact::device::DriveSetup;
use piezotact::quantity::{Acceleration, Band, Drive, Hertz, Quantity, Unit};
use piezotact::recording::{Recording, RecordingError};
use piezotact::render::Rendering;
use piezotact::resample::to_common_rate;
use piezotact::score::{JudgedMeasurement, Measurement, Target, judged_measurement};
use piezotact::series::Series;
use piezotact::transfer::TransferFunction;
use piezotact::verify::{
    self, Changed, Compared, DriveSource, FurtherVerification, JudgedVerification, ShownDrive,
    TextureBefore, UncompensatedOutcome, Verification, VerifyConfig, VerifyDocument, VerifyError,
    drive_beside, predict_uncompensated, tones,
};
use piezotact_bench::procedure::DRIVE_CHANNEL;
use piezotact_dataset::sidecar::read_sidecar;
use piezotact_dataset::{Contents, ReadOptions, read_recording, read_transfer};

use super::manipulate;
use super::manipulate::Chosen;
use crate::cli::{Reading, Verify};
use crate::deliver::{Outputs, deliver};
use crate::failure::{Failure, Outcome, usage};
use crate::memory::fits;
use crate::output::difference_db;
use crate::places::outputs;
use crate::progress::{Words, Work};
use crate::reading::{read, read_beside, texture};
use crate::report;

const COMPARING: Words = Words {
    doing: "comparing",
    done: "compared",
    item: "recording",
    then: "comparing",
};

pub(crate) fn run(args: &Verify) -> Outcome {
    let found = found(args)?;
    deliver(&args.outputs, &found.document(args)?)
}

/// How close the measurement in `measured` came to the target in `target` over `band`, as this command says it.
pub(super) fn verified(target: &Path, measured: &Path, band: Band) -> Outcome<Verification> {
    let args = Verify {
        target: target.to_owned(),
        measured: measured.to_owned(),
        channel: None,
        measured_channel: None,
        measured_scale: None,
        drive: None,
        band: Some(band),
        transfer: None,
        also: Vec::new(),
        before: Vec::new(),
        before_channel: None,
        before_stroke: None,
        reading: Reading {
            scale: Vec::new(),
            rate: None,
            part: None,
        },
        outputs: Outputs {
            report: None,
            csv: None,
            json: false,
        },
    };
    Ok(found(&args)?.judged.found.verification)
}

/// What every measurement is compared with.
struct Asked<'a> {
    args: &'a Verify,
    target: &'a Recording,
    wanted: &'a Series<Acceleration>,
    /// The band that was asked for; of what is compared later, that of the measurement that decides.
    band: Option<Band>,
}

/// A measurement with how close it came.
struct Judged {
    found: JudgedMeasurement,
    /// What was recorded of the drive, and the level at which the device clips.
    drive: Option<(Series<Drive>, f64)>,
    rendering: Option<Rendering>,
    recording: Recording,
}

impl Judged {
    /// The warnings about it and not of its target alone.
    fn warnings_of_its_own<'a>(
        &'a self,
        target: &'a Recording,
    ) -> impl Iterator<Item = &'a Warning> {
        let all = self.found.verification.warnings.iter();
        all.filter(|warning| !target.about.warnings.contains(warning))
    }
}

/// All that was asked for: the measurement that decides, others, textures before the target, and what they are shown with.
struct Found {
    target: Recording,
    function: Option<TransferFunction<Drive, Acceleration>>,
    /// The drive that `--drive` names, and how it was rendered.
    stated: Option<(Rendering, Series<Drive>)>,
    judged: Judged,
    also: Vec<Judged>,
    before: Vec<Earlier>,
    predicted: Option<UncompensatedOutcome>,
    /// The names of the measurements, that of the one that decides first, and of the textures before.
    names: [Vec<String>; 2],
}

fn found(args: &Verify) -> Outcome<Found> {
    check_outputs(args)?;
    let target = read(&args.target, &args.reading)?.recording;
    let read_function = |path: &PathBuf| read_transfer(path)?.function::<Drive, Acceleration>(path);
    let function = args.transfer.as_ref().map(read_function).transpose()?;
    let wanted = texture(&args.target, &target, args.channel.as_deref())?;
    let stated = args.drive.as_deref().map(rendered_in).transpose()?;
    let mut asked = Asked {
        args,
        target: &target,
        wanted: &wanted,
        band: args.band,
    };
    let about_function = function.as_ref().map(|f| f.about.warnings.as_slice());
    let rendering = stated.as_ref().map(|(rendering, _)| rendering);
    let comparing = Work::of_steps(COMPARING, 1 + args.also.len() + args.before.len());
    let mut judged = judge(
        &asked,
        &args.measured,
        rendering,
        about_function.unwrap_or_default(),
    )?;
    asked.band = Some(judged.found.config.band);
    comparing.one_more();
    let also = (args.also.iter())
        .map(|path| judge(&asked, path, None, &[]).inspect(|_| comparing.one_more()));
    let also = also.collect::<Outcome<_>>()?;
    let before = (args.before.iter())
        .map(|path| textures_before(&asked, path).inspect(|_| comparing.one_more()));
    let before = before.collect::<Outcome<Vec<Earlier>>>()?;
    drop(comparing);
    for earlier in &before {
        let warnings = &mut judged.found.verification.warnings;
        warnings.extend(earlier.warnings.iter().cloned());
    }
    let predicted = (function.as_ref()).map(|function| {
        predict_uncompensated(&judged.found.texture, function, &judged.found.config).into()
    });
    if let Some(function) = &function {
        let measured = &judged.recording.about.condition;
        let differs = function.about.condition.warnings_beside(measured);
        judged.found.verification.warnings.extend(differs);
    }
    let measurements = [&args.measured].into_iter().chain(&args.also);
    let names = [
        apart(measurements.map(PathBuf::as_path)),
        apart(args.before.iter().map(PathBuf::as_path)),
    ];
    Ok(Found {
        target,
        function,
        stated,
        judged,
        also,
        before,
        predicted,
        names,
    })
}

/// Refuses a report that would replace an input.
fn check_outputs(args: &Verify) -> Outcome {
    let named = [Some(&args.target), Some(&args.measured)].into_iter();
    let named = named.chain([args.transfer.as_ref(), args.drive.as_ref()]);
    let inputs: Vec<&Path> = named
        .flatten()
        .chain(&args.also)
        .chain(&args.before)
        .map(PathBuf::as_path)
        .collect();
    outputs(&inputs, &args.outputs.files())
}

impl Found {
    /// Further measurements with their names.
    fn also(&self) -> impl Iterator<Item = (&Judged, &str)> {
        let names = self.names[0].iter().skip(1).map(String::as_str);
        self.also.iter().zip(names)
    }

    /// The textures before, with their names.
    fn before(&self) -> impl Iterator<Item = (&Earlier, &str)> {
        let names = self.names[1].iter().map(String::as_str);
        self.before.iter().zip(names)
    }

    /// The drive that is shown: the recorded one, else the one that is stated.
    fn drive(&self) -> Option<ShownDrive<'_>> {
        let recorded = self.judged.drive.as_ref();
        let recorded = recorded.map(|(drive, limit)| (drive, *limit, DriveSource::Recorded));
        let stated = self.stated.as_ref();
        let stated = stated
            .map(|(rendering, drive)| (drive, rendering.headroom.limit, DriveSource::Rendered));
        let (drive, limit, source) = recorded.or(stated)?;
        let judged = &self.judged;
        let beside = drive_beside(
            &judged.found.verification,
            (drive, source),
            judged.rendering.as_ref(),
        );
        Some(ShownDrive {
            series: drive,
            limit,
            beside,
        })
    }

    fn document(&self, args: &Verify) -> Outcome<VerifyDocument<'_>> {
        let judged = &self.judged;
        let verification = &judged.found.verification;
        let also = self.also().map(|(also, file)| FurtherVerification {
            file,
            verification: JudgedVerification::of(&also.found.verification),
            rendered_at_db: also.rendering.as_ref().map(|made| made.level_db),
            warnings: also.warnings_of_its_own(&self.target).cloned().collect(),
        });
        let before = self.before().map(|(earlier, file)| TextureBefore {
            file,
            changed: &earlier.changed,
            series: &earlier.series,
        });
        Ok(VerifyDocument {
            verification: JudgedVerification::of(verification),
            uncompensated_predicted: self.predicted.as_ref(),
            also: also.collect(),
            before: before.collect(),
            compared: Compared {
                title: format!("Verification of {}", report::name(&args.target)),
                target: &self.target,
                texture: &judged.found.texture,
                measured: &self.names[0][0],
                about: &judged.recording.about,
                rendering: judged.rendering.as_ref(),
                drive: self.drive(),
                function: self.function.as_ref(),
                tones: tones(verification)?,
            },
        })
    }
}

/// How close the measurement in `path` came to its target; `stated` counts before what it says itself of its rendering.
fn judge(
    asked: &Asked<'_>,
    path: &Path,
    stated: Option<&Rendering>,
    more_warnings: &[Warning],
) -> Outcome<Judged> {
    let args = asked.args;
    let measured = read_beside(path, args.measured_scale.as_ref(), &args.reading)?;
    require_measurement(path, &measured)?;
    let channel = args.measured_channel.as_deref();
    let response = texture(path, &measured.recording, channel)?;
    let samples = response.samples().len().max(asked.wanted.samples().len());
    fits("the verification", samples, verify::MEMORY_BYTES_A_SAMPLE)?;
    if let (Some(stated), Some(own)) = (stated, &measured.rendering) {
        require_same_drive(path, stated, own)?;
    }
    let rendering = stated.or(measured.rendering.as_ref());
    let band = band(asked, rendering)?;
    let limit = measured.setup.as_ref().map_or(1.0, DriveSetup::drive_limit);
    let drive = recorded_drive(&measured.recording, channel);
    let drive = drive.map_err(|error| of_file(path, error))?;
    let name = report::name(&args.target);
    let target = Target {
        name: &name,
        recording: asked.target,
        texture: asked.wanted,
    };
    let measurement = Measurement {
        recording: &measured.recording,
        response,
        drive: drive.as_ref().map(|drive| (drive, limit)),
        rendering,
    };
    let found = judged_measurement(target, measurement, band, more_warnings);
    let found = found.map_err(|error| refused(path, error))?;
    Ok(Judged {
        found,
        drive: drive.map(|drive| (drive, limit)),
        rendering: rendering.cloned(),
        recording: measured.recording,
    })
}

/// The band that is compared where no option says one, Hz; a drive that was rendered in a wider one extends it.
const BAND_HZ: (f64, f64) = (20.0, 1000.0);

/// The band in which something is compared: the one that was asked for, or the usual one with that of the drive. A drive that was rendered in a narrower band
/// has to answer for all of it.
fn band(asked: &Asked<'_>, rendering: Option<&Rendering>) -> Outcome<Band> {
    if let Some(band) = asked.band {
        return Ok(band);
    }
    let rendered = rendering.map(|rendering| rendering.config.inverse.band);
    let (low_hz, high_hz) = rendered.map_or(BAND_HZ, |band| {
        let (low, high) = (band.low().0, band.high().0);
        (BAND_HZ.0.min(low), BAND_HZ.1.max(high))
    });
    Band::new(Hertz(low_hz), Hertz(high_hz)).map_err(usage)
}

/// Refuses a drive where the recording of its playing is expected.
fn require_measurement(path: &Path, measured: &Contents) -> Outcome {
    let mut channels = measured.recording.channels().iter();
    if measured.rendering.is_some() && channels.all(|channel| channel.unit == Unit::FullScale) {
        return Err(Failure::Data(anyhow!(
            "{}: expected the recording made while a drive was played, found the drive itself; give the recording with \
             --measured, and the drive with --drive",
            path.display()
        )));
    }
    Ok(())
}

/// The drive in a recording, where there is one, which has to share its clock with the response.
fn recorded_drive(
    recording: &Recording,
    channel: Option<&str>,
) -> Result<Option<Series<Drive>>, RecordingError> {
    let drive = recording.series::<Drive>(Some(DRIVE_CHANNEL)).ok();
    if drive.is_some() {
        let response = recording.pick(channel, &Acceleration::UNIT);
        let names = [DRIVE_CHANNEL, response.map_or(DRIVE_CHANNEL, |c| &c.name)];
        recording.require_one_clock(names)?;
    }
    Ok(drive)
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
    warnings: Vec<Warning>,
}

/// The texture in `path` beside the target; `--scale` counts for it where it does not say its own.
fn textures_before(asked: &Asked<'_>, path: &Path) -> Outcome<Earlier> {
    let args = asked.args;
    let says_its_own = read_sidecar(path)?.is_some_and(|sidecar| sidecar.full_scale.is_some());
    let scale = args.reading.scale().filter(|_| !says_its_own).cloned();
    let reading = args.reading.with_scale(scale);
    let channel = args.before_channel.as_deref();
    let stroke = args.before_stroke.map(|number| Chosen {
        number,
        option: "--before-stroke",
    });
    let opened = manipulate::open(path, stroke, channel, &reading)?.texture;
    let called = format!("{}, the source texture,", report::name(path));
    let common = to_common_rate(
        (&called, opened.series),
        ("the target", asked.wanted.clone()),
    );
    let common = common.map_err(|error| of_file(path, error))?;
    let config = VerifyConfig::over(band(asked, None)?, common.first.rate().hz());
    let changed = verify::changed(&common.first, &common.second, &config);
    let changed = changed.map_err(|error| match error {
        VerifyError::BandAboveNyquist { .. } => {
            Failure::Usage(anyhow::Error::new(error).context(path.display().to_string()))
        }
        _ => refused(path, error),
    })?;
    let mut warnings = opened.warnings;
    warnings.extend(common.warning);
    Ok(Earlier {
        series: common.first,
        changed,
        warnings,
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

/// Refuses a drive that was rendered otherwise than the one that the measurement in `path` says was played.
fn require_same_drive(path: &Path, stated: &Rendering, own: &Rendering) -> Outcome {
    let made_with = |rendering: &Rendering| rendering.about.provenance.made_with.clone();
    let is_made_alike = made_with(own).is_empty() || made_with(stated) == made_with(own);
    if stated.is_alike(own) && is_made_alike {
        return Ok(());
    }
    let told = |rendering: &Rendering| {
        let gain = rendering.setup.as_ref().map(|setup| setup.amplification());
        let gain = gain.map_or(String::new(), |gain| format!(", for the {gain}"));
        let function = rendering.about.provenance.made_with.first();
        let function = function
            .filter(|_| !is_made_alike)
            .map_or(String::new(), |one| {
                format!(", with the transfer function of checksum {one}")
            });
        format!(
            "{} at {} dB{gain}{function}",
            rendering.target,
            difference_db(rendering.level_db)
        )
    };
    Err(Failure::Data(anyhow!(
        "{}: expected with --drive the drive that was played, {}, found another, {}; leave --drive out, or give the drive that was \
            played",
        path.display(),
        told(own),
        told(stated)
    )))
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
