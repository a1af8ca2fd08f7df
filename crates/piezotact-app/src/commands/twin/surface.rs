//! `piezotact twin surface`: the height map of a sample.

use std::path::{Path, PathBuf};

use clap::Args;
use piezotact_surface::write_sur;
use piezotact_twin::document::SimulatedSurface;
use piezotact_twin::{Patch, TwinError};

use super::twin_parameters;
use crate::commands::roughness::length;
use crate::failure::{Outcome, usage};
use crate::output::{digits, print, print_kept};
use crate::places::{has_ending, outputs};

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The sample: S1–S13, NO, M1–M12, BIO, or one of --twin FILE.
    sample: String,
    /// The side length of the square map, such as 4mm; default: large enough for statistics.
    #[arg(long, value_name = "LENGTH", value_parser = length, allow_hyphen_values = true)]
    size: Option<f64>,
    /// The spacing of the points, such as 4um; default: fine enough for the sample.
    #[arg(long, value_name = "LENGTH", value_parser = length, allow_hyphen_values = true)]
    step: Option<f64>,
    /// Seed of the random surface.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// A laboratory's own parameter file.
    #[arg(long, value_name = "FILE.toml")]
    twin: Option<PathBuf>,
    /// The map to write (SUR).
    #[arg(long)]
    out: PathBuf,
    /// Prints a summary as JSON.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    let read: Vec<&Path> = args.twin.as_deref().into_iter().collect();
    outputs(&read, &[&args.out])?;
    has_ending(&args.out, &["sur"])?;
    let parameters = twin_parameters(args.twin.as_deref())?;
    let sample = parameters.sample(&args.sample).map_err(usage)?;
    let usual = sample.relief.usual_patch();
    let step_m = args.step.unwrap_or(usual.step_m);
    let patch = match args.size {
        Some(size_m) => Patch {
            width_m: size_m,
            height_m: size_m,
            step_m,
        },
        None => Patch { step_m, ..usual },
    };
    let map = sample
        .relief
        .height_map(&patch, args.seed, &sample.name)
        .map_err(usage::<TwinError>)?;
    write_sur(&args.out, &map)?;
    let surface = SimulatedSurface {
        map,
        sample: sample.name.clone(),
        seed: args.seed,
        twin: parameters.provenance(),
    };
    if args.json {
        return print_kept(&args.out, &surface);
    }
    print(&format!(
        "wrote {}: {} of the twin, {} × {} points, spacing {} µm",
        args.out.display(),
        surface.sample,
        surface.map.columns(),
        surface.map.rows(),
        digits(step_m * 1e6)
    ))
}
