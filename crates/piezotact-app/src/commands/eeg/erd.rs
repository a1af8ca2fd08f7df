//! `piezotact eeg erd`: desynchronisation of one person in one task.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use clap::Args;
use piezotact_dataset::eeg::{EegSource, read_electrodes};
use piezotact_people::eeg::person::{EegErd, PersonConfig, PersonError, Positions, Region, person};
use piezotact_people::eeg::reference::{FEWEST_OF_A_SPHERE, Montage};
use piezotact_people::eeg::source::is_lettered;
use piezotact_people::eeg::tfr::TfrConfig;

use super::epochs::prepared;
use super::options::{
    BandOption, CyclesOption, OrderOption, Preparing, RegionOption, Span, covering,
};
use super::{Source, of_file, outputs_beside, subject};
use crate::deliver::{Outputs, deliver_and};
use crate::failure::{Outcome, usage};
use crate::output::{document_text, write_text};
use crate::places::has_ending;

/// Regions where none is stated: those of these that were recorded.
const USUAL_REGIONS: [&str; 3] = ["C3", "Cz", "C4"];

/// From one frequency of the wavelets to the next, Hz.
const STEP_HZ: f64 = 1.0;

/// From one time of the maps to the next, s: at most the smear of the usual wavelets, as a cluster test needs maps without holes.
const STEP_S: f64 = 0.05;

/// Measured electrodes are hardly further from the places of their names, degrees.
const MOST_OFF_DEG: f64 = 40.0;

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// An EEG file of one task.
    file: PathBuf,
    /// The baseline relative to the marker, s: at rest, before a movement is planned.
    #[arg(
        long,
        value_name = "FROM,TO",
        default_value = "-1.5,-0.5",
        allow_hyphen_values = true
    )]
    baseline: Span,
    /// The window relative to the marker, s.
    #[arg(
        long,
        value_name = "FROM,TO",
        default_value = "0,0.8",
        allow_hyphen_values = true
    )]
    window: Span,
    /// Start and end of the epochs relative to the marker, s; default: baseline and window, extended by the reach of the wavelets.
    #[arg(long, value_name = "FROM,TO", allow_hyphen_values = true)]
    epoch: Option<Span>,
    /// A band; several are allowed.
    #[arg(long, value_name = "NAME=LOW..HIGH", default_value = "alpha=8..12")]
    band: Vec<BandOption>,
    /// A region, and the electrodes whose changes are averaged; several are allowed. Default: C3, Cz and C4, those of them that were recorded.
    #[arg(long, value_name = "NAME=ELECTRODES")]
    region: Vec<RegionOption>,
    /// The cycles of the wavelets: a number, or f/2 for half the frequency in Hz (80 ms SD at every frequency).
    #[arg(long, value_name = "CYCLES", default_value = "f/2")]
    cycles: CyclesOption,
    /// What is averaged before the baseline is divided.
    #[arg(long, value_enum, default_value = "power-first")]
    order: OrderOption,
    /// The fewest epochs of a surface.
    #[arg(long, value_name = "COUNT", default_value_t = 10)]
    min_epochs: usize,
    /// Measured positions of electrodes: a table with columns name, x (to the right), y (to the front) and z (up). Default: those of the
    /// names of the 10-10 system, or those inside an EEGLAB file.
    #[arg(long, value_name = "TABLE.tsv")]
    electrodes: Option<PathBuf>,
    #[command(flatten)]
    preparing: Preparing,
    /// Writes the result for `piezotact eeg stats`.
    #[arg(long, value_name = "OUT.json")]
    out: Option<PathBuf>,
    #[command(flatten)]
    outputs: Outputs,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    let out: Vec<&Path> = args.out.iter().map(PathBuf::as_path).collect();
    let written = [out.clone(), args.outputs.files()].concat();
    let mut read = vec![args.file.as_path()];
    read.extend(args.electrodes.as_deref());
    read.extend(args.preparing.events.as_deref());
    outputs_beside(&read, &written)?;
    if let Some(path) = &args.out {
        has_ending(path, &["json"])?;
    }
    let found = found(args)?;
    if let Some(path) = &args.out {
        write_text(path, &(document_text(&found, Some(path))? + "\n"))?;
    }
    deliver_and(&args.outputs, &found, &out)
}

fn found(args: &Arguments) -> Outcome<EegErd> {
    let source = Source::read(&args.file, args.preparing.events.as_deref())?;
    let options = &args.preparing;
    let [participant, task] = source.subject(&args.file, options)?;
    let config = config(args, &source.source)?;
    let extent = match args.epoch {
        Some(extent) => extent.into(),
        None => config.extent(),
    };
    // Fewer epochs are named by surface.
    let preparing = options.config(extent, task, &source.stated, args.min_epochs);
    let positions = positions(args, &source.source)?;
    let measured = match &positions {
        Positions::OfNames => None,
        Positions::Measured(montage) => Some(montage),
    };
    let prepared = prepared(&args.file, &source.segments(), &preparing, measured)?;
    let subject = subject(&args.file, participant, &prepared.task)?;
    let name = crate::report::name(&args.file);
    person(&name, &subject, &prepared, &positions, &config).map_err(|error| match error {
        PersonError::Region { .. } | PersonError::Nothing => usage(error),
        error => of_file(&args.file)(error),
    })
}

fn config(args: &Arguments, source: &EegSource) -> Outcome<PersonConfig> {
    let range = covering(args.band.iter().map(|option| option.0.hz)).map_err(usage)?;
    let power = TfrConfig::over(range, STEP_HZ, args.cycles.0).map_err(usage)?;
    let channels = source.segments[0].recording.channels().iter();
    let names: Vec<String> = channels.map(|channel| channel.name.clone()).collect();
    let regions = match args.region.is_empty() {
        false => args.region.iter().map(|option| option.0.clone()).collect(),
        true if is_lettered(&names) => {
            return Err(usage(anyhow!(
                "{}: expected --region, as its channels are called by letters and numbers (A1 to B32 and on), whose C3 is not that of the 10-10 \
                 system; state the electrodes over the sensorimotor cortex by these names, and --electrodes for maps",
                args.file.display()
            )));
        }
        true => {
            let there = |name: &&str| names.iter().any(|own| own == name);
            // Those that the table beside the file calls bad are not analysed.
            let bad = |name: &&str| {
                source
                    .channels
                    .iter()
                    .any(|row| row.name == *name && row.is_bad())
            };
            let recorded = USUAL_REGIONS.into_iter().filter(there);
            let recorded: Vec<&str> = recorded.filter(|name| !bad(name)).collect();
            match recorded.is_empty() {
                // Named as what is missing.
                true => Region::single(&USUAL_REGIONS[..1]),
                false => Region::single(&recorded),
            }
        }
    };
    Ok(PersonConfig {
        power,
        step_s: STEP_S,
        bands: args.band.iter().map(|option| option.0.clone()).collect(),
        regions,
        baseline_s: args.baseline.0,
        window_s: args.window.0,
        order: args.order.into(),
        min_epochs: args.min_epochs,
    })
}

/// Where electrodes are: in the table that is given, else in the file, else where the 10-10 system has their names.
fn positions(args: &Arguments, source: &EegSource) -> Outcome<Positions> {
    let (path, stated) = match &args.electrodes {
        Some(path) => (path, read_electrodes(path)?),
        None if source.positions.len() < FEWEST_OF_A_SPHERE => return Ok(Positions::OfNames),
        None => (&args.file, source.positions.clone()),
    };
    let (names, places) = stated
        .into_iter()
        .map(|one| (one.name, one.position))
        .unzip::<_, _, Vec<String>, Vec<[f64; 3]>>();
    let montage = Montage::measured(names, &places).map_err(of_file(path))?;
    if let Some(off) = montage.off_ten_ten_deg().filter(|off| *off > MOST_OFF_DEG) {
        return Err(of_file(path)(anyhow!(
            "expected x to the right, y to the front and z up, found electrodes {off:.0}° (median) from where the 10-10 system has their names; \
             exchange the axes (EEGLAB has x to the front), or give a table with --electrodes"
        )));
    }
    Ok(Positions::Measured(montage))
}
