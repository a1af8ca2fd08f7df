//! `piezotact twin plant`: the device with a finger on it behind a JACK server, in a process of its own.

use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context as _, anyhow};
use clap::Args;
use piezotact::quantity::{Degrees, Newtons, Seconds};
use piezotact_audio::{AudioError, ForceReading, JackPlant, PlantSettings, SoundSetup};
use piezotact_bench::{Placement, Plant, RunPlan, Until};
use piezotact_dataset::read_input_text;
use piezotact_twin::{Participant, TwinPlant};

use super::super::twin::twin_parameters;
use crate::benches::audio::device_of;
use crate::cli::twin::Who;
use crate::failure::bench_failure;
use crate::failure::{Failure, Outcome, usage};
use crate::interrupt::{Between, interrupted};
use crate::output::print;

/// How often ports and readings are looked for.
const LOOK: Duration = Duration::from_millis(20);
/// A server that passes no buffers for so long has gone.
const GONE: Duration = Duration::from_secs(5);

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The set-up of the sound device that plays and records, with host = "jack".
    setup: PathBuf,
    #[command(flatten)]
    who: Who,
    /// The normal force with which the finger lies, in N.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0.2,
        allow_negative_numbers = true
    )]
    load: f64,
    /// The angle between finger and surface, in degrees.
    #[arg(
        long,
        value_name = "DEG",
        default_value_t = 20.0,
        allow_negative_numbers = true
    )]
    angle: f64,
    /// The recorded value per played value of the loopback.
    #[arg(
        long,
        value_name = "RATIO",
        default_value_t = 0.5,
        allow_negative_numbers = true
    )]
    loopback_gain: f64,
    /// The potential of the inputs at full scale, V peak.
    #[arg(
        long,
        value_name = "V",
        default_value_t = 2.0,
        allow_negative_numbers = true
    )]
    input_volts: f64,
    /// A name of this placement of the finger; another one gives another placement, and other noise.
    #[arg(long, default_value = "plant")]
    label: String,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    let _ends_between = Between::items("buffer");
    checked(args)?;
    let called = || args.setup.display().to_string();
    let setup = SoundSetup::from_toml(&read_input_text(&args.setup)?).with_context(called)?;
    let parameters = twin_parameters(args.who.twin.as_deref())?;
    let participant = Participant::of(args.who.participant, args.who.seed, &parameters);
    let device = device_of(&setup)?;
    let run = RunPlan {
        label: args.label.clone(),
        load: Some(Newtons(args.load)),
        angle: Degrees(args.angle),
        placement: Placement::New,
        until: Until::Stopped,
    };
    let settings = PlantSettings {
        name: "piezotact_plant".into(),
        gain: args.loopback_gain,
        input_v_per_full_scale: args.input_volts,
    };
    let started = JackPlant::start(&setup, &settings, |rate| {
        let plant = TwinPlant::new(&parameters, &participant, &device, &run, rate)?;
        Ok(Box::new(plant) as Box<dyn Plant>)
    });
    let mut plant = started.map_err(|error| match error {
        AudioError::Device(error) => bench_failure(error),
        error => Failure::Data(anyhow::Error::new(error).context(called())),
    })?;
    let cell = setup.force.as_ref().and_then(|force| force.file.as_ref());
    let mut cell = cell
        .map(|file| ForceFile::new(Path::new(file)))
        .transpose()?;
    print(&format!(
        "the twin's finger (participant {}, {} N) waits at the JACK server for {}; Ctrl-C ends it",
        args.who.participant,
        args.load,
        called()
    ))?;
    serve(&mut plant, &mut cell)
}

fn checked(args: &Arguments) -> Outcome {
    let possible =
        args.loopback_gain.abs() <= 10.0 && args.input_volts > 0.0 && args.input_volts <= 1e3;
    match possible {
        true => Ok(()),
        false => Err(usage(anyhow!(
            "expected --loopback-gain from -10 to 10 and --input-volts above 0 and up to 1000, found {} and {}",
            args.loopback_gain,
            args.input_volts
        ))),
    }
}

/// Connects programs and writes the readings of the force cell, until a signal comes or the server goes.
fn serve(plant: &mut JackPlant, cell: &mut Option<ForceFile>) -> Outcome {
    let (mut ran, mut since) = (plant.ran(), Instant::now());
    while !interrupted() {
        for port in plant.connect() {
            print(&format!("connected to {port}"))?;
        }
        let readings = plant.readings();
        if let Some(cell) = cell {
            cell.append(&readings)?;
        }
        if plant.ran() != ran {
            (ran, since) = (plant.ran(), Instant::now());
        } else if since.elapsed() > GONE {
            return Err(anyhow!(
                "expected buffers of the JACK server, found none for {} s, after {:.1}: it was stopped; start it again",
                GONE.as_secs(),
                Seconds(ran.0)
            )
            .into());
        }
        std::thread::sleep(LOOK);
    }
    Ok(())
}

/// The file of the force cell, in the lines of `docs/guide/force-cell.md`.
struct ForceFile {
    path: PathBuf,
    file: File,
}

impl ForceFile {
    fn new(path: &Path) -> Outcome<Self> {
        let file = File::options().create(true).append(true).open(path);
        let mut cell = Self {
            file: file.with_context(|| path.display().to_string())?,
            path: path.to_owned(),
        };
        cell.write("# unit=mN rate=80\n")?;
        Ok(cell)
    }

    fn append(&mut self, readings: &[ForceReading]) -> Outcome {
        let lines: String = readings
            .iter()
            .map(|reading| format!("F {} {:.2}\n", reading.at_ms, 1e3 * reading.force_n))
            .collect();
        match lines.is_empty() {
            true => Ok(()),
            false => self.write(&lines),
        }
    }

    fn write(&mut self, text: &str) -> Outcome {
        let written = self.file.write_all(text.as_bytes());
        Ok(written.with_context(|| self.path.display().to_string())?)
    }
}
