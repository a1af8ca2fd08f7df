//! `piezotact prepare`: from the strokes of a participant who has just touched the samples to one verified drive for each texture.

mod drives;
#[cfg(feature = "study")]
mod stimuli;
mod strokes;

use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::Args;
use piezotact::criterion::Outcome as Judged;
use piezotact::document::Content;
use piezotact::lineage::Mode;
use piezotact::page::Shown;
use piezotact::prepare::PreparedDrives;
use piezotact::quantity::{Acceleration, Band, Drive};
use piezotact::warning::Warnings;
use piezotact_dataset::read_transfer;

use crate::benches::{self, BenchSpec};
use crate::cli::{InverseName, ModeName, Takes};
use crate::deliver::{Outputs, deliver};
use crate::failure::{Failures, Outcome};
use crate::interrupt::{self, interrupted};
use drives::Drives;
#[cfg(feature = "study")]
use stimuli::Stimuli;
use strokes::Textures;

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    takes: Takes,
    /// Makes every stimulus of a protocol (a file, or a name of the library) from these strokes, under its name there. What an
    /// interrupted command has prepared is verified, and not made again.
    #[cfg(feature = "study")]
    #[arg(long, value_name = "PROTOCOL")]
    protocol: Option<PathBuf>,
    /// The transfer function of the device with this participant's finger on it.
    #[arg(long)]
    transfer: PathBuf,
    /// The bench on which the drives are played and measured; without it, they are rendered and not verified.
    #[arg(long, help = format!("{}; without it, they are rendered and not verified", benches::help("The bench on which the drives are played and measured")))]
    bench: Option<BenchSpec>,
    /// The folder to write: targets/, drives/ and measured/, with one file for each texture.
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
    /// The band that is rendered and compared, in Hz.
    #[arg(long, default_value = "20..1000")]
    band: Band,
    /// The level re the strokes: `common`, one level for all textures, lowered only as much as the device requires; `fit`, for
    /// each texture its own; or a number, in dB.
    #[arg(
        long,
        default_value = "common",
        value_name = "common|fit|DB",
        allow_negative_numbers = true
    )]
    level: LevelRule,
    /// The rate of the drives, in Hz.
    #[arg(long, default_value_t = 48_000, value_name = "HZ", value_parser = clap::value_parser!(u32).range(1_000..=768_000))]
    drive_rate: u32,
    /// How the transfer function is inverted, as in `piezotact render`.
    #[arg(long, value_enum, default_value = "constant")]
    inverse: InverseName,
    /// Corrects each drive in a closed loop on --bench: `replicate` corrects the waveform, `texture` the spectrum.
    #[arg(long, value_enum, requires = "bench")]
    mode: Option<ModeName>,
    /// Largest number of corrections, default 6.
    #[arg(long, requires = "mode", value_parser = clap::value_parser!(u16).range(1..=50))]
    iterations: Option<u16>,
    #[command(flatten)]
    outputs: Outputs,
}

impl Arguments {
    /// The file of the protocol, where one is given.
    fn protocol_file(&self) -> Option<&Path> {
        #[cfg(feature = "study")]
        let protocol = self.protocol.as_deref();
        #[cfg(not(feature = "study"))]
        let protocol: Option<&Path> = None;
        protocol.filter(|path| path.is_file())
    }
}

/// The level at which textures are rendered.
#[derive(Clone, Copy, Debug, PartialEq)]
enum LevelRule {
    /// The highest at which all fit, 0 dB or below.
    Common,
    /// For each the highest at which it fits, 0 dB or below.
    Fit,
    /// Stated, dB.
    Stated(f64),
}

impl FromStr for LevelRule {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let stated = || text.parse().ok().filter(|db| (-120.0..=120.0).contains(db));
        match text {
            "common" => Ok(Self::Common),
            "fit" => Ok(Self::Fit),
            _ => stated().map(Self::Stated).ok_or_else(|| {
                format!("expected common, fit, or a level from -120 to 120 dB, found `{text}`")
            }),
        }
    }
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    let function = read_transfer(&args.transfer)?;
    let function = function.function::<Drive, Acceleration>(&args.transfer)?;
    let bench = args.bench.as_ref().map(BenchSpec::open).transpose()?;
    #[cfg(feature = "study")]
    let protocol = args.protocol.as_deref();
    #[cfg(feature = "study")]
    let protocol = protocol.map(|protocol| Stimuli::of((protocol, args.level), &function));
    #[cfg(feature = "study")]
    let protocol = protocol.transpose()?;
    let (textures, failures) = Textures::of(
        args,
        &function,
        bench.as_ref(),
        #[cfg(feature = "study")]
        protocol.as_ref(),
    )?;
    let drives = Drives::of(args, &textures, &function, bench)?;
    let mut found = begun(args, &textures, &drives, &failures);
    #[cfg(feature = "study")]
    let pseudonym = textures.pseudonym.clone();
    found.textures = drives.prepared(textures)?;
    let found = found.concluded();
    #[cfg(feature = "study")]
    if let Some(protocol) = &protocol {
        let found = protocol.prepared(args, &pseudonym, found)?;
        return delivered(args, &found, &found.drives.sentence, &failures);
    }
    delivered(args, &found, &found.sentence, &failures)
}

/// What is prepared, before anything is.
fn begun(
    args: &Arguments,
    textures: &Textures,
    drives: &Drives,
    failures: &Failures,
) -> PreparedDrives {
    PreparedDrives {
        participant: textures.participant.clone(),
        transfer: crate::report::name(&args.transfer),
        bench: drives.bench_name.clone(),
        band_hz: args.band,
        mode: args.mode.map(|mode| match mode {
            ModeName::Replicate => Mode::Replicate,
            ModeName::Texture => Mode::Texture,
        }),
        level_db: drives.level_db(),
        level_set_by: drives.level_set_by.clone(),
        outcome: Judged::NotDecided,
        sentence: String::new(),
        not_good_enough: Vec::new(),
        textures: Vec::new(),
        failed: failures.files().to_vec(),
        warnings: Warnings::default(),
    }
}

/// Hands out what was prepared, and says what failed or was interrupted before the verdict.
fn delivered<T: Shown + Content>(
    args: &Arguments,
    found: &T,
    sentence: &str,
    failures: &Failures,
) -> Outcome {
    let delivered = deliver(&args.outputs, found);
    if let Err(failure) = &delivered
        && !failure.is_verdict()
    {
        return delivered;
    }
    failures.outcome()?;
    if interrupted() {
        return Err(interrupt::failure(
            sentence,
            "what is done stays; give the same command again: all textures are prepared, at one level",
        ));
    }
    delivered
}

/// The file of the texture called `name` in the part `part` of the folder.
fn file(out: &Path, part: &str, name: &str, ending: &str) -> PathBuf {
    out.join(part).join(format!("{name}.{ending}"))
}
