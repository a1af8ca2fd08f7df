//! `piezotact render`: the drives that make a finger feel textures.

mod batch;
mod looped;

use std::cell::OnceCell;
use std::path::{Path, PathBuf};

use crate::benches::BenchSpec;
use anyhow::anyhow;
use piezotact::checksum::Checksum;
use piezotact::device::{DeviceDescription, DriveSetup};
use piezotact::lineage::{Lineage, Operation, Step};
use piezotact::quantity::{Acceleration, Decibels, Drive, Measure, SampleRate, Seconds, Unit};
use piezotact::recording::{About, Annotations};
use piezotact::render::{
    self, Inverse, Overload, PhaseForm, RenderConfig, RenderError, RenderedDrive, gains_for,
    require_device, require_gain,
};
use piezotact::series::{Series, SeriesError};
use piezotact::transfer::TransferFunction;
use piezotact_bench::document::{RenderDocument, RenderNames};
use piezotact_bench::{Bench, ProcedureError, RunPlan};
use piezotact_dataset::sidecar::{Rendering, Sidecar, sidecar_path};
use piezotact_dataset::wav::{SampleFormat, write_wav_with_sidecar};
use piezotact_dataset::{RunFolder, read_device, read_transfer};

use crate::cli::{InverseName, Level, PhaseName, Render};
use crate::failure::bench_failure;
use crate::failure::{Failure, Outcome, usage};
use crate::interrupt::{Between, interrupted};
use crate::keeping::{Earlier, Purpose, go_on, runs_of};
use crate::memory::fits;
use crate::places::{folder_of, outputs, recording_files};
use crate::progress::{Words, Work};
use crate::reading::{read, texture};
use crate::report::name;
use batch::Batch;
use looped::Corrected;

/// Softer than this a texture is not made to fit, dB: the softest `--level`.
const SOFTEST_DB: f64 = -120.0;

const RENDERING: Words = Words {
    doing: "rendering",
    done: "rendered",
    item: "texture",
    then: "rendering",
};

pub(crate) fn run(args: &Render) -> Outcome {
    let jobs = jobs(args)?;
    let mut batch = Batch::new(args, &jobs);
    let targets: Vec<&Path> = jobs.iter().map(|job| job.target).collect();
    let rendering = Work::of_files(RENDERING, &targets);
    let between = (jobs.len() > 1).then(|| Between::items(RENDERING.item));
    for job in &jobs {
        if interrupted() {
            break;
        }
        batch.add(job)?;
        rendering.one_more();
    }
    drop((rendering, between));
    batch.tidy()?;
    batch.deliver()?;
    batch.outcome()
}

/// One texture for one finger.
pub(super) struct Job<'a> {
    target: &'a Path,
    transfer: &'a Path,
    bench: Option<&'a BenchSpec>,
    /// What it is called beside others.
    called: String,
    pub(super) out: PathBuf,
    record: Option<PathBuf>,
    /// Where the measurements of a closed loop are kept; none where nothing is measured.
    pub(super) runs: Option<RunFolder>,
}

/// The jobs that are asked for, one participant after the other, with every output checked before the first is begun.
pub(super) fn jobs(args: &Render) -> Outcome<Vec<Job<'_>>> {
    possible(args)?;
    let mut jobs = listed(args);
    check_outputs(args, &jobs)?;
    if jobs.len() == 1 && !ends_in(&args.out, "wav") {
        return Err(usage(anyhow!(
            "{}: expected the name of a WAV file, ending in .wav",
            args.out.display()
        )));
    }
    if args.mode.is_some() {
        for job in &mut jobs {
            job.runs = Some(runs_of(&job.out)?);
        }
    }
    Ok(jobs)
}

/// Refuses options that do not fit each other.
fn possible(args: &Render) -> Outcome {
    if args.mode.is_none() && (args.finger.load.is_some() || args.finger.angle.is_some()) {
        return Err(usage(anyhow!(
            "expected --mode with --load and --angle, found none; without a closed loop, a drive is for the load and angle of \
             its transfer function: characterise at other ones"
        )));
    }
    let people = args.transfer.len();
    if !matches!(args.bench.len(), 0 | 1) && args.bench.len() != people {
        return Err(usage(anyhow!(
            "expected one --bench, or one for each of {people} --transfer, found {}",
            args.bench.len()
        )));
    }
    Ok(())
}

/// Every texture for every transfer function, each with the names of its files.
fn listed(args: &Render) -> Vec<Job<'_>> {
    let people = args.transfer.len();
    let stem = |path: &Path| {
        path.file_stem()
            .map_or_else(|| name(path), |stem| stem.to_string_lossy().into_owned())
    };
    let several = args.targets.len() * people > 1;
    let within = |folder: &Path, called: &str, ending: &str| {
        if several {
            folder.join(format!("{called}.{ending}"))
        } else {
            folder.to_path_buf()
        }
    };
    let mut jobs = Vec::new();
    for (i, transfer) in args.transfer.iter().enumerate() {
        for target in &args.targets {
            let called = if people == 1 {
                stem(target)
            } else {
                format!("{}-{}", stem(target), stem(transfer))
            };
            let record = args.record.as_ref();
            jobs.push(Job {
                target,
                transfer,
                bench: args.bench.get(i).or(args.bench.first()),
                out: within(&args.out, &called, "wav"),
                record: record.map(|record| within(record, &called, "parquet")),
                called,
                runs: None,
            });
        }
    }
    jobs
}

/// Makes the folders of several jobs and refuses outputs that would replace an input or each other; what was made is then
/// removed again.
fn check_outputs(args: &Render, jobs: &[Job<'_>]) -> Outcome {
    let read: Vec<&Path> = jobs
        .iter()
        .flat_map(|job| [job.target, job.transfer])
        .chain(args.bench.iter().filter_map(|bench| bench.file()))
        .collect();
    let written: Vec<PathBuf> = jobs
        .iter()
        .flat_map(|job| {
            let record = job.record.iter();
            [job.out.clone(), sidecar_path(&job.out)]
                .into_iter()
                .chain(record.flat_map(|record| recording_files(record)))
        })
        .chain(args.outputs.files().into_iter().map(Path::to_path_buf))
        .collect();
    let made = if jobs.len() > 1 {
        folders(&[Some(args.out.as_path()), args.record.as_deref()])?
    } else {
        Vec::new()
    };
    let written: Vec<&Path> = written.iter().map(PathBuf::as_path).collect();
    let checked = outputs(&read, &written);
    if checked.is_err() {
        for folder in made {
            // Only one that holds nothing goes.
            let _kept = std::fs::remove_dir(folder);
        }
    }
    checked
}

fn ends_in(path: &Path, ending: &str) -> bool {
    path.extension()
        .is_some_and(|found| found.eq_ignore_ascii_case(ending))
}

/// Makes the folders for several drives and recordings; those that were not there.
pub(super) fn folders(wanted: &[Option<&Path>]) -> Outcome<Vec<PathBuf>> {
    let mut made = Vec::new();
    for folder in wanted.iter().flatten() {
        if ends_in(folder, "wav") || ends_in(folder, "parquet") || folder.is_file() {
            return Err(usage(anyhow!(
                "{} names a file: several textures or participants need a folder",
                folder.display()
            )));
        }
        if !folder.is_dir() {
            std::fs::create_dir_all(folder).map_err(|error| {
                anyhow!(
                    "cannot create the folder {}: {error}; check the path",
                    folder.display()
                )
            })?;
            made.push(folder.to_path_buf());
        }
    }
    Ok(made)
}

/// One texture rendered for one finger.
pub(super) struct Done {
    out: PathBuf,
    pub(super) level_db: f64,
    pub(super) drive: RenderedDrive,
    corrected: Option<Corrected>,
}

impl Job<'_> {
    pub(super) fn done(&self, args: &Render) -> Outcome<Done> {
        let function = self.function(args)?;
        let contents = read(self.target, &args.reading)?;
        let texture = texture(self.target, &contents.recording, args.channel.as_deref())?;
        let response = function.response().iter().flat_map(|h| [h.re, h.im]);
        let asked = Asked {
            target: Checksum::of(texture.samples().iter().copied()),
            transfer: Checksum::of(response),
            runs: OnceCell::new(),
            args,
            job: self,
            function: &function,
            config: &config_of(args)?,
        };
        // What was corrected on a bench is a measurement. The best drive of a loop that goes on is replaced by a better one.
        let completed = self.runs.as_ref().filter(|runs| !runs.is_interrupted());
        let earlier = completed.map(|_| Earlier::at(&self.out, "the earlier drive"));
        let earlier = earlier.transpose()?;
        let (level, (mut drive, corrected)) = asked.at_its_level(&texture)?;
        self.trace(
            &mut drive,
            &contents.recording.about,
            (texture.amplified(Decibels(level)), level),
        );
        let rendering = Rendering {
            target_samples: Some(asked.target),
            ..Rendering::of(&drive, &name(self.target), level)
        };
        write_drive(&self.out, &drive, args.drive_rate, rendering.clone())?;
        earlier.map_or(Ok(()), Earlier::settle)?;
        if let (Some(path), Some(corrected)) = (&self.record, &corrected) {
            corrected.keep(path, rendering, &drive.drive)?;
        }
        Ok(Done {
            out: self.out.clone(),
            level_db: level,
            drive,
            corrected,
        })
    }

    /// The transfer function, measured with the device and at the gain that are stated.
    fn function(&self, args: &Render) -> Outcome<TransferFunction<Drive, Acceleration>> {
        let document = read_transfer(self.transfer)?;
        let function = document.function::<Drive, Acceleration>(self.transfer)?;
        let measured_with = function.drive.as_ref();
        let stated = args.device.as_deref().map(read_device).transpose()?;
        if let Some(stated) = &stated {
            require_device(measured_with, stated)?;
        }
        if let Some(gain) = &args.gain {
            let stated = stated.as_ref();
            let device = stated.or(measured_with.map(DriveSetup::device));
            let _known = device
                .unwrap_or(DeviceDescription::drv2667())
                .gain(gain)
                .map_err(usage)?;
            require_gain(measured_with, gain)?;
        }
        Ok(function)
    }

    /// Adds to `drive` the warnings about its texture, and where both come from.
    fn trace(
        &self,
        drive: &mut RenderedDrive,
        about: &About,
        (target, level_db): (Series<Acceleration>, f64),
    ) {
        let warnings = about.warnings.iter().cloned();
        drive.about.warnings.splice(0..0, warnings);
        let step = format!("target {}", self.target.display());
        drive.about.provenance.steps.insert(0, step);
        let so_far = about.provenance.lineage.clone();
        let so_far = so_far.unwrap_or_else(|| {
            Lineage::of_sample(name(self.target), about.condition.sample.clone())
        });
        let lineage = lineage(so_far, &name(self.transfer), level_db, (&target, drive));
        drive.about.provenance.lineage = Some(lineage);
    }
}

/// What a texture was made from, `so_far`, with its rendering through the transfer function of the name
/// `transfer` as the last step.
pub(crate) fn lineage(
    so_far: Lineage,
    transfer: &str,
    level_db: f64,
    (target, drive): (&Series<Acceleration>, &RenderedDrive),
) -> Lineage {
    let operation = Operation::Rendered {
        transfer: transfer.into(),
        gain: drive.setup.as_ref().map(|setup| setup.gain.to_string()),
        level_db,
        band_hz: drive.config.inverse.band,
        aim: drive.aim,
    };
    so_far.then(Step::between(
        operation,
        target.rms_about_mean(),
        drive.drive.rms_about_mean(),
    ))
}

pub(super) fn config_of(args: &Render) -> Outcome<RenderConfig> {
    let rate = SampleRate::new(f64::from(args.drive_rate)).map_err(usage)?;
    let mut config = RenderConfig::over(args.band, rate);
    if args.allow_clipping {
        config.clipping = Overload::Allow;
    }
    config.fade = Seconds(args.fade);
    config.inverse.inverse = match args.inverse {
        InverseName::Plain => Inverse::Plain,
        InverseName::Constant => Inverse::Constant,
        InverseName::Coherence => Inverse::Coherence,
        InverseName::DriveLimited => Inverse::DriveLimited,
    };
    config.inverse.phase = match args.phase {
        PhaseName::Linear => PhaseForm::Linear,
        PhaseName::Minimum => PhaseForm::Minimum,
    };
    Ok(config)
}

/// What is asked of one rendering.
struct Asked<'a> {
    /// The texture, whatever its level.
    target: Checksum,
    transfer: Checksum,
    /// The folder of the runs, once it is known what they are for.
    runs: OnceCell<RunFolder>,
    args: &'a Render,
    job: &'a Job<'a>,
    function: &'a TransferFunction<Drive, Acceleration>,
    config: &'a RenderConfig,
}

/// A rendering that was refused before anything played.
struct Refused {
    failure: Failure,
    /// The level re the texture at which it would fit.
    fits_at: Option<Decibels>,
}

impl From<Failure> for Refused {
    fn from(failure: Failure) -> Self {
        Self {
            failure,
            fits_at: None,
        }
    }
}

impl Asked<'_> {
    /// The folder of the runs at `bench`: what is there is gone on with once, or put aside.
    fn runs_at(&self, bench: &Bench, run: &RunPlan) -> Outcome<Option<RunFolder>> {
        let Some(runs) = &self.job.runs else {
            return Ok(None);
        };
        if let Some(known) = self.runs.get() {
            return Ok(Some(known.clone()));
        }
        let here = bench.acquirer.describe();
        let settings = [
            here.seed.map(|seed| format!("seed {seed}")),
            bench.player.describe().gain.map(|gain| gain.to_string()),
            here.answers_with.map(|with| with.to_string()),
        ];
        let purpose = Purpose {
            participant: bench.acquirer.condition(run).participant,
            bench: std::iter::once(here.name)
                .chain(here.steps)
                .chain(settings.into_iter().flatten())
                .collect(),
            target: self.target,
            transfer: self.transfer,
        };
        let known = go_on(runs, &purpose)?;
        Ok(Some(self.runs.get_or_init(|| known).clone()))
    }

    /// `texture` rendered at the level that is stated, or at the highest one that fits; with that level, dB.
    fn at_its_level(
        &self,
        texture: &Series<Acceleration>,
    ) -> Outcome<(f64, (RenderedDrive, Option<Corrected>))> {
        let samples = texture.samples().len();
        fits("the rendering", samples, render::MEMORY_BYTES_A_SAMPLE)?;
        let (level_db, done) = match self.args.level {
            Level::Stated(level_db) => (level_db, self.at(texture, level_db)),
            Level::Fit => {
                let (level, done) = render::at_fitting_level(
                    |level| self.at(texture, level.0),
                    |refused| refused.fits_at,
                );
                (level.0, done)
            }
        };
        Ok((level_db, done.map_err(|refused| refused.failure)?))
    }

    /// `texture` rendered at `level_db`.
    fn at(
        &self,
        texture: &Series<Acceleration>,
        level_db: f64,
    ) -> Result<(RenderedDrive, Option<Corrected>), Refused> {
        let target = texture.clone().amplified(Decibels(level_db));
        let Some((mode, bench)) = self.args.mode.zip(self.job.bench) else {
            return match render::render(&target, self.function, self.config) {
                Ok(drive) => Ok((drive, None)),
                Err(error) => Err(self.refused(&target, level_db, error)),
            };
        };
        let corrected =
            looped::run(self, &target, (mode, bench))?.map_err(|error| match error {
                ProcedureError::Render(error) => self.refused(&target, level_db, error),
                other => bench_failure(other).into(),
            })?;
        Ok((corrected.looped.rendered.clone(), Some(corrected)))
    }

    /// Why a target is not rendered, and what would be.
    fn refused(&self, target: &Series<Acceleration>, level_db: f64, error: RenderError) -> Refused {
        let Some(fits_at) = error.fits_at() else {
            return match error {
                RenderError::BandAboveNyquist { .. }
                | RenderError::NoLine { .. }
                | RenderError::Phase
                | RenderError::Signal(
                    SeriesError::Rate(_)
                    | SeriesError::Passband { .. }
                    | SeriesError::Ratio { .. }
                    | SeriesError::TooLong { .. }
                    | SeriesError::TooShort,
                ) => usage(error),
                _ => Failure::Data(
                    anyhow::Error::new(error).context(self.job.target.display().to_string()),
                ),
            }
            .into();
        };
        // To the tenth below: rounded up it would not fit.
        let level = ((level_db + fits_at.0) * 10.0 + 1e-6).floor() / 10.0;
        if level < SOFTEST_DB {
            return Failure::Data(anyhow!(
                "{}: {error}: it would fit at {level:.1} dB, below the softest --level of {SOFTEST_DB} dB; check the scales of the \
                 texture and of the transfer function",
                self.job.target.display()
            ))
            .into();
        }
        let is_of_drive = !matches!(error, RenderError::ExceedsExcursion { .. });
        let may_pass = is_of_drive && !matches!(error, RenderError::ExceedsCurrent { .. });
        let limited = match is_of_drive {
            true => ", --inverse drive-limited reduces what needs the largest drive",
            false => "",
        };
        let allowed = match may_pass && self.args.mode.is_none() {
            true => ", --allow-clipping accepts the drive",
            false => "",
        };
        let failure = Failure::Data(anyhow!(
            "{}: {error}: --level {level:.1} fits{}, --level fit finds this level{limited}{allowed}",
            self.job.target.display(),
            self.other_gain(target).unwrap_or_default(),
        ));
        Refused {
            failure,
            fits_at: Some(Decibels(level)),
        }
    }

    /// The gain of the amplifier at which the drive for `target` would fit, in level and in slope.
    fn other_gain(&self, target: &Series<Acceleration>) -> Option<String> {
        let setup = self.function.drive.as_ref()?;
        let beyond = RenderConfig {
            clipping: Overload::Allow,
            ..self.config.clone()
        };
        let headroom = render::render(target, self.function, &beyond)
            .ok()?
            .headroom;
        let fit = gains_for(&headroom, setup)
            .into_iter()
            .find(|fit| fit.fits() && fit.gain != setup.gain.name)?;
        Some(format!(
            ", a transfer function measured at gain {} would fit",
            fit.gain
        ))
    }
}

impl Done {
    /// Why the closed loop did not come to its end; none where it did.
    pub(super) fn unfinished(&self) -> Option<&str> {
        self.corrected.as_ref()?.looped.failed.as_deref()
    }

    fn document<'a>(&'a self, job: &'a Job<'_>, args: &Render) -> RenderDocument<'a> {
        let names = RenderNames {
            called: &job.called,
            target: job.target,
            transfer: job.transfer,
            out: &self.out,
        };
        let looped = self.corrected.as_ref().map(|corrected| &corrected.looped);
        RenderDocument::of(names, &self.drive, (args.drive_rate, self.level_db), looped)
    }
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
        // The warnings about a drive stands with its rendering.
        about: About::new(
            drive.about.condition.clone(),
            drive.about.provenance.clone(),
        ),
        annotations: Annotations::default(),
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
