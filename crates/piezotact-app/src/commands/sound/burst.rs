//! `piezotact sound burst`: a drive with synchronisation bursts before and after it.

use piezotact::align::AlignError;
use std::path::{Path, PathBuf};

use anyhow::anyhow;
use clap::Args;
use piezotact::align::{BurstConfig, BurstDocument, Bursts, WithBursts, with_bursts};
use piezotact::quantity::{Band, Drive, Measure, Seconds, Unit};
use piezotact::series::Series;
use piezotact_dataset::sidecar::Sidecar;
use piezotact_dataset::wav::{SampleFormat, write_wav_with_sidecar};
use piezotact_dataset::{Contents, FileKind};

use crate::failure::{Failure, Outcome, usage};
use crate::output::{print, print_document, say_warnings};
use crate::places::{has_ending, outputs};
use crate::reading::read_drive;

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The drive: a WAV file whose samples are shares of full scale.
    drive: PathBuf,
    /// The WAV file to write, with its sidecar OUT.wav.json.
    #[arg(long, value_name = "OUT.wav")]
    out: PathBuf,
    /// The band that the bursts sweep, in Hz; default: 100..1000, as far as the rate allows.
    #[arg(long, value_name = "LOW..HIGH")]
    band: Option<Band>,
    /// How long each burst is, in s.
    #[arg(long, value_name = "S", default_value_t = 0.5)]
    duration: f64,
    /// The silence before and after each burst, in s.
    #[arg(long, value_name = "S", default_value_t = 0.25)]
    guard: f64,
    /// The peak of the bursts, of full scale; default: that of the drive.
    #[arg(long, value_name = "SHARE")]
    peak: Option<f64>,
    /// Prints the result as JSON.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    has_ending(&args.out, &["wav"])?;
    let sidecar = piezotact_dataset::sidecar::sidecar_path(&args.out);
    outputs(&[&args.drive], &[&args.out, &sidecar])?;
    let contents = read_drive(&args.drive)?;
    let drive = drive(&args.drive, &contents)?;
    let config = config(args, &drive)?;
    let made = with_bursts(&drive, &config).map_err(|error| refused(args, error))?;
    write(args, &contents, &made)?;
    let document = BurstDocument {
        drive: args.drive.display().to_string(),
        out: args.out.display().to_string(),
        rate_hz: drive.rate(),
        length_s: made.drive.duration(),
        config,
        bursts: made.bursts,
    };
    if args.json {
        return print_document(&document);
    }
    say_warnings(&contents.recording.about.warnings);
    print(&format!(
        "wrote {}: {}",
        args.out.display(),
        document.sentence()
    ))
}

/// The drive in a WAV file that has no bursts yet.
fn drive(path: &Path, contents: &Contents) -> Outcome<Series<Drive>> {
    let of_file = |error: anyhow::Error| Failure::Data(error.context(path.display().to_string()));
    if contents.kind.ending() != FileKind::WAV.ending() {
        return Err(of_file(anyhow!(
            "expected the WAV file of a drive, found a {}; export the drive as .wav",
            contents.kind
        )));
    }
    let events = &contents.recording.annotations.events;
    if Bursts::of_events(events).is_some() {
        return Err(of_file(AlignError::Already.into()));
    }
    let series = contents.recording.series::<Drive>(None);
    series.map_err(|error| of_file(error.into()))
}

fn config(args: &Arguments, drive: &Series<Drive>) -> Outcome<BurstConfig> {
    let peak = args.peak.unwrap_or_else(|| drive.peak());
    let usual = BurstConfig::usual(drive.rate(), peak);
    let band = match (args.band, usual) {
        (Some(band), _) => band,
        (None, usual) => usual.map_err(|error| refused(args, error))?.band,
    };
    Ok(BurstConfig {
        band,
        duration_s: Seconds(args.duration),
        guard_s: Seconds(args.guard),
        peak,
    })
}

fn refused(args: &Arguments, error: AlignError) -> Failure {
    match error {
        AlignError::Peak { found: 0.0 } if args.peak.is_none() => Failure::Data(anyhow!(
            "{}: expected a drive above 0 somewhere, found silence; give the drive, or state --peak",
            args.drive.display()
        )),
        AlignError::Alike { .. } | AlignError::Already | AlignError::Series(_) => {
            Failure::Data(anyhow::Error::new(error).context(args.drive.display().to_string()))
        }
        _ => usage(error),
    }
}

/// Writes the drive with bursts; what its file states is kept, events by their new times.
fn write(args: &Arguments, contents: &Contents, made: &WithBursts) -> Outcome {
    let recording = &contents.recording;
    let mut about = recording.about.clone();
    about.provenance = about.provenance.then(format!(
        "synchronisation bursts added before and after {}",
        args.drive.display()
    ));
    let channels = recording.channels().iter();
    let sidecar = Sidecar {
        full_scale: Some(Measure {
            value: 1.0,
            unit: Unit::FullScale,
        }),
        channels: channels.map(|channel| channel.name.clone()).collect(),
        about,
        annotations: made.annotations(&recording.annotations),
        rendering: contents.rendering.clone(),
    };
    let rate_hz = made.drive.rate().hz().round() as u32;
    let samples = [made.drive.samples()];
    write_wav_with_sidecar(
        &args.out,
        &samples,
        rate_hz,
        SampleFormat::Float32,
        &sidecar,
    )?;
    Ok(())
}
