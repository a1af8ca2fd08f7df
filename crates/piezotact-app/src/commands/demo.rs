//! `piezotact demo`: the complete chain on the digital twin.

use std::path::{Path, PathBuf};

use piezotact::clipping::clipping;
use piezotact::lineage::Lineage;
use piezotact::quantity::{
    Acceleration, Band, Decibels, Drive, Hertz, Measure, Quantity, SampleRate, Seconds, Unit,
};
use piezotact::recording::{About, Annotations, Recording};
use piezotact::render::{RenderConfig, RenderError, RenderedDrive, at_fitting_level, render};
use piezotact::score::with_perceptible_difference;
use piezotact::series::Series;
use piezotact::spectrum::WelchConfig;
use piezotact::transfer::{Estimator, TransferFunction};
use piezotact::verify::{
    Compared, DemoDocument, DriveSource, JudgedVerification, Measured, ShownDrive, Verification,
    VerifyConfig, drive_beside, tones, verify,
};
use piezotact_bench::procedure::{ACCELERATION_CHANNEL, CharacteriseConfig, DRIVE_CHANNEL};
use piezotact_bench::{Bench, Excitation, ExcitationConfig};
use piezotact_dataset::sidecar::{Rendering, Sidecar};
use piezotact_dataset::wav::{SampleFormat, write_wav_with_sidecar};
use piezotact_dataset::{ReadOptions, TransferDocument, read_recording, write_transfer};
use piezotact_twin::{Participant, TwinParameters, record_texture};

use super::characterise::characterise;
use super::play::play;
use super::render::{lineage, write_drive};
use crate::benches::{NamedBench as _, TwinSpec};
use crate::cli::{Demo, Finger};
use crate::deliver::{Outputs, deliver};
use crate::failure::Outcome;
use crate::interrupt::{self, Between, interrupted};
use crate::keeping::{Earlier, Place};
use crate::output::{document_text, say, write_text};
use crate::places::outputs;
use crate::progress::{self, Words, Work};
use crate::report;
use crate::runs::run_plan;

const FINGER: Finger = Finger {
    load: Some(0.2),
    angle: Some(20.0),
};
const PARTICIPANT: u64 = 1;
const TEXTURE_RATE_HZ: u32 = 5_000;
const DRIVE_RATE_HZ: u32 = 48_000;
/// What stands in the folder at the end.
const FILES: [&str; 9] = [
    TARGET,
    "target.wav.json",
    TRANSFER,
    "drive.wav",
    "drive.wav.json",
    "measured.parquet",
    "report.html",
    "verification.json",
    "uncompensated.parquet",
];
const TARGET: &str = "target.wav";
/// The transfer function that is rendered with.
const TRANSFER: &str = "tf.json";

pub(crate) fn run(args: &Demo) -> Outcome {
    let out = &args.out;
    prepare(out)?;
    let mut bench = TwinSpec {
        participant: Some(PARTICIPANT),
        seed: args.seed,
        gain: None,
        device: None,
    }
    .open()?;
    say(&format!(
        "The complete chain on the {}, seed {}.",
        bench.player.describe().name,
        args.seed
    ));
    let chain = Chain::measured(&mut bench, out, args.seed)?;
    let path = out.join("report.html");
    let report = report::name(&path);
    let document = chain.document(&report)?;
    let verification = out.join("verification.json");
    write_text(
        &verification,
        &document_text(&document, Some(&verification))?,
    )?;
    let outputs = Outputs {
        report: Some(path),
        csv: None,
        json: args.json,
    };
    deliver(&outputs, &document)
}

/// Makes the folder, and refuses one that holds files of those names of another command.
fn prepare(out: &Path) -> Outcome {
    std::fs::create_dir_all(out).map_err(|error| {
        anyhow::anyhow!(
            "cannot create the folder {}: {error}; check the path",
            out.display()
        )
    })?;
    let written = FILES.map(|name| out.join(name));
    outputs(&[], &written.each_ref().map(PathBuf::as_path))
}

/// Everything that the chain recorded, computed and measured.
struct Chain {
    recorded: Recording,
    target: Series<Acceleration>,
    function: TransferFunction<Drive, Acceleration>,
    drive: RenderedDrive,
    rendering: Rendering,
    measured: Recording,
    verification: Verification,
    uncompensated: Uncompensated<Verification>,
}

impl Chain {
    /// The chain on `bench`, its files written to the folder `out`.
    fn measured(bench: &mut Bench, out: &Path, seed: u64) -> Outcome<Self> {
        let steps = Steps::begin(out);
        say("1/5 recording a texture: a finger slides over sample S8 at 30 mm/s");
        let (recorded, target) = texture(&out.join(TARGET), seed)?;
        steps.done()?;
        say("2/5 characterising the device with the finger on it");
        let function = transfer_function(bench, seed, &out.join(TRANSFER))?;
        steps.done()?;
        say(
            "3/5 rendering: computing the drive that reproduces this texture on the resting finger",
        );
        let (drive, level) = rendered(&target, &function, &out.join("drive.wav"))?;
        let rendering = Rendering::of(&drive, TARGET, level.0);
        steps.done()?;
        say("4/5 playing the drive and measuring again, after repositioning the finger");
        let (made, path) = (Some(rendering.clone()), out.join("measured.parquet"));
        let measured = played(bench, "play", &drive.drive, made, &path)?;
        say(
            "    negative control: the texture played directly, at its own level and attenuated until nothing clips",
        );
        let uncompensated = sent_uncompensated(bench, &target, out)?;
        steps.done()?;
        say("5/5 comparing");
        let limit = drive.headroom.limit;
        let mut verification = compared(&target, &measured, limit, level, Some(&rendering))?;
        let warnings = drive.about.warnings.iter().chain(&measured.about.warnings);
        verification.warnings.put_first(warnings.cloned());
        let control = |sent: &Recording| compared(&target, sent, limit, Decibels(0.0), None);
        let uncompensated = Uncompensated {
            as_it_stands: control(&uncompensated.as_it_stands)?,
            turned_down: control(&uncompensated.turned_down)?,
        };
        Ok(Self {
            recorded,
            target,
            function,
            drive,
            rendering,
            measured,
            verification,
            uncompensated,
        })
    }

    fn document<'a>(&'a self, report: &'a str) -> Outcome<DemoDocument<'a>> {
        let (verification, drive) = (&self.verification, &self.drive);
        let rendering = Some(&self.rendering);
        let source = (&drive.drive, DriveSource::Rendered);
        Ok(DemoDocument {
            report,
            verification: JudgedVerification::of(verification),
            uncompensated: JudgedVerification::of(&self.uncompensated.as_it_stands),
            uncompensated_level_matched: JudgedVerification::of(&self.uncompensated.turned_down),
            compared: Compared {
                title: "A texture rendered end to end".into(),
                target: &self.recorded,
                texture: &self.target,
                measured: "measured.parquet",
                about: &self.measured.about,
                rendering,
                drive: Some(ShownDrive {
                    series: &drive.drive,
                    limit: drive.headroom.limit,
                    beside: drive_beside(verification, source, rendering),
                }),
                function: Some(&self.function),
                tones: tones(verification)?,
            },
        })
    }
}

/// The negative control: the texture sent directly to the device, without its transfer function.
struct Uncompensated<T> {
    /// One unit of texture as full scale.
    as_it_stands: T,
    /// Turned down until nothing clips.
    turned_down: T,
}

const STEPS: Words = Words {
    doing: "measuring",
    done: "done",
    item: "step",
    then: "writing the report",
};

/// The steps of the chain, between which a signal ends it.
struct Steps<'a> {
    out: &'a Path,
    work: Work,
    _between: Between,
}

impl<'a> Steps<'a> {
    fn begin(out: &'a Path) -> Self {
        Self {
            out,
            work: Work::of_steps(STEPS, 5),
            _between: Between::items(STEPS.item),
        }
    }

    /// One more step is done; an error where a signal came.
    fn done(&self) -> Outcome {
        self.work.one_more();
        if !interrupted() {
            return Ok(());
        }
        let done = progress::done().unwrap_or_default();
        let done = format!("{done}, whose files are in {}", self.out.display());
        Err(interrupt::failure(
            &done,
            "give the same command again, which starts from the beginning",
        ))
    }
}

fn band(low_hz: f64, high_hz: f64) -> Outcome<Band> {
    Ok(Band::new(Hertz(low_hz), Hertz(high_hz))?)
}

/// The band that is judged: where the textures of the thesis hold most of their power.
fn judged_band() -> Outcome<Band> {
    band(30.0, 500.0)
}

/// The band that is rendered.
fn rendered_band() -> Outcome<Band> {
    band(20.0, 1000.0)
}

/// The texture of the demo, as a WAV file with its sidecar.
fn texture(path: &Path, seed: u64) -> Outcome<(Recording, Series<Acceleration>)> {
    let twin = TwinParameters::built_in();
    let participant = Participant::of(PARTICIPANT, seed, &twin);
    let (series, condition, provenance) =
        record_texture(&twin, &participant, twin.sample("S8")?, 0.03, Seconds(10.0))?;
    let sidecar = Sidecar {
        full_scale: Some(Measure {
            value: 1.0,
            unit: Unit::MetrePerSecondSquared,
        }),
        channels: vec![ACCELERATION_CHANNEL.into()],
        about: About::new(condition, provenance),
        annotations: Annotations::default(),
        rendering: None,
    };
    let earlier = Earlier::at(path, "the earlier recording")?;
    write_wav_with_sidecar(
        path,
        &[series.samples()],
        TEXTURE_RATE_HZ,
        SampleFormat::Float32,
        &sidecar,
    )?;
    earlier.settle()?;
    let contents = read_recording(path, &ReadOptions::default())?;
    let series = contents.recording.series(None)?;
    Ok((contents.recording, series))
}

fn transfer_function(
    bench: &mut Bench,
    seed: u64,
    path: &Path,
) -> Outcome<TransferFunction<Drive, Acceleration>> {
    let config = CharacteriseConfig {
        excitation: ExcitationConfig {
            kind: Excitation::Random,
            band: band(2.0, 1200.0)?,
            duration: Seconds(60.0),
            peak: 0.8,
            seed,
        },
        welch: WelchConfig::hann(2048),
        estimator: Estimator::H1,
        run: run_plan("characterise", &FINGER, bench.acquirer.as_ref()),
    };
    let function = characterise(bench, &config)?.function;
    let earlier = Earlier::at(path, "the earlier measurement")?;
    write_transfer(
        path,
        &TransferDocument::of(&function, Drive::UNIT, Acceleration::UNIT),
    )?;
    earlier.settle()?;
    Ok(function)
}

/// The drive, and the level it had to be rendered at to fit the device.
fn rendered(
    target: &Series<Acceleration>,
    function: &TransferFunction<Drive, Acceleration>,
    path: &Path,
) -> Outcome<(RenderedDrive, Decibels)> {
    let config = RenderConfig::over(rendered_band()?, SampleRate::new(f64::from(DRIVE_RATE_HZ))?);
    let (level, drive) = at_fitting_level(
        |level| render(&target.clone().amplified(level), function, &config),
        RenderError::fits_at,
    );
    let drive = drive?;
    if level.0 < 0.0 {
        say(&format!(
            "    at its own level it exceeds the limits of the device with this finger: rendered {:.1} dB lower",
            -level.0
        ));
    }
    let mut drive = drive;
    let softer = target.clone().amplified(level);
    drive.about.provenance.lineage = Some(lineage(
        Lineage::of(TARGET),
        TRANSFER,
        level.0,
        (&softer, &drive),
    ));
    write_drive(
        path,
        &drive,
        DRIVE_RATE_HZ,
        Rendering::of(&drive, TARGET, level.0),
    )?;
    Ok((drive, level))
}

fn played(
    bench: &mut Bench,
    label: &str,
    drive: &Series<Drive>,
    rendering: Option<Rendering>,
    path: &Path,
) -> Outcome<Recording> {
    let setup = bench.player.calibrate()?;
    let what = format!("playing the drive, {:.1}", drive.duration());
    let run = run_plan(label, &FINGER, bench.acquirer.as_ref());
    let made = rendering.as_ref().map(|made| made.about.provenance.clone());
    let place = Place::File(path, rendering.map(Box::new));
    play(
        bench,
        (drive, made.as_ref()),
        setup.as_ref(),
        &run,
        (place, &what),
    )
}

/// The negative control: the texture's samples as they are, 1 m/s² as a drive of 1, which clips; and turned
/// down until nothing clips.
fn sent_uncompensated(
    bench: &mut Bench,
    target: &Series<Acceleration>,
    out: &Path,
) -> Outcome<Uncompensated<Recording>> {
    let setup = bench.player.calibrate()?;
    let drive = piezotact::render::uncompensated(target, bench.player.describe().rate)?;
    let fitting = piezotact::render::fitting(&drive, setup.as_ref());
    Ok(Uncompensated {
        as_it_stands: played(
            bench,
            "play straight",
            &drive,
            None,
            &out.join("uncompensated.parquet"),
        )?,
        turned_down: played(
            bench,
            "play straight, turned down",
            &fitting,
            None,
            &out.join("uncompensated-fitting.parquet"),
        )?,
    })
}

fn compared(
    target: &Series<Acceleration>,
    measured: &Recording,
    limit: f64,
    level: Decibels,
    rendering: Option<&Rendering>,
) -> Outcome<Verification> {
    let response = measured.series::<Acceleration>(Some(ACCELERATION_CHANNEL))?;
    let drive = measured.series::<Drive>(Some(DRIVE_CHANNEL))?;
    let mut config = VerifyConfig {
        level,
        ..VerifyConfig::over(judged_band()?, target.rate().hz())
    };
    if let Some(rendering) = rendering {
        config = config.rendered_as(&rendering.config, rendering.mode());
    }
    let clipping = clipping(&response, Some((&drive, limit)), None);
    Ok(with_perceptible_difference(verify(
        target,
        Measured {
            response: &response,
            clipping,
        },
        &config,
    )?))
}
