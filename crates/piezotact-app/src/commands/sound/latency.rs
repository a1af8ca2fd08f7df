//! `piezotact sound latency`: from output to input, over restarts of the streams.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use clap::Args;
use piezotact::sound::LatencySummary;
use piezotact_audio::latency_run;
use piezotact_bench::ProcedureError;

use super::keep;
use crate::benches::audio::{SoundDevice, latency_path};
use crate::deliver::{Outputs, deliver_and};
use crate::failure::Outcome;
use crate::interrupt::interrupted;
use crate::invocation::today;
use crate::output::counted;
use crate::places::outputs;
use crate::progress::{Words, Work};

const RESTARTS: Words = Words {
    doing: "starting",
    done: "started",
    item: "time",
    then: "writing the latency",
};

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The set-up of the sound device.
    setup: PathBuf,
    /// How often the streams are started.
    #[arg(long, default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    restarts: u32,
    /// Writes the latency here; default: beside the set-up, where every later recording finds it.
    #[arg(long, value_name = "OUT.json")]
    out: Option<PathBuf>,
    #[command(flatten)]
    outputs: Outputs,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    let out = args
        .out
        .clone()
        .unwrap_or_else(|| latency_path(&args.setup));
    let written: Vec<&Path> = std::iter::once(out.as_path())
        .chain(args.outputs.files())
        .collect();
    outputs(&[&args.setup], &written)?;
    let device = SoundDevice::read(&args.setup)?;
    let (setup, rate) = (&device.setup, device.setup.rate()?);
    let work = Work::of_steps(RESTARTS, args.restarts as usize);
    let mut runs = Vec::new();
    for number in 0..args.restarts {
        if interrupted() {
            return Err(stopped().into());
        }
        let mut streams = setup.open_streams(device.io(None)?.as_mut())?;
        runs.push(latency_run(&mut streams, setup, u64::from(number))?);
        work.one_more();
    }
    let found = LatencySummary::of(&setup.called(), &today(), rate, setup.buffer_frames, runs);
    if found.latency.is_none() {
        return Err(anyhow!(
            "expected the burst in the loopback, found it in none of {}; check cable, level and channel of the loopback; nothing was written",
            counted(found.runs.len(), "restart")
        )
        .into());
    }
    keep((&out, "the earlier latency"), &found)?;
    deliver_and(&args.outputs, &found, &[&out])
}

fn stopped() -> ProcedureError {
    ProcedureError::Stopped {
        label: "latency".into(),
        after_s: 0.0,
    }
}
