//! A rendering that is corrected on a bench.

use std::path::Path;

use crate::advice::text;
use crate::benches::BenchSpec;
use piezotact::checksum::Checksum;
use piezotact::correct::CorrectConfig;
use piezotact::lineage::Mode;
use piezotact::number::signed;
use piezotact::quantity::{Acceleration, Drive};
use piezotact::recording::About;
use piezotact::run::RunStart;
use piezotact::series::Series;
use piezotact_bench::procedure::{ClosedLoopResult, Iteration, LoopConfig, closed_loop};
use piezotact_bench::{GateConfig, ProcedureError, RunPlan};
use piezotact_dataset::sidecar::Rendering;
use piezotact_dataset::{JournalWriter, StartDocument};

use super::Asked;
use crate::cli::ModeName;
use crate::failure::Outcome;
use crate::keeping::{Keeper, Place, Shown};
use crate::output::{counted, say};
use crate::runs::run_plan;

/// How often a loop corrects unless it is stated.
const ITERATIONS: u16 = 6;

/// A drive that was corrected.
pub(super) struct Corrected {
    pub(super) looped: ClosedLoopResult,
}

/// Renders in a closed loop, each drive said as it is judged; or what the bench or the rendering refused.
pub(super) fn run(
    asked: &Asked<'_>,
    target: &Series<Acceleration>,
    (mode, bench): (ModeName, &BenchSpec),
) -> Outcome<Result<Corrected, ProcedureError>> {
    let mut bench = bench.open()?;
    let label = format!("render {}", asked.job.called);
    let run = run_plan(&label, &asked.args.finger, bench.acquirer.as_ref());
    let here = bench.acquirer.condition(&run);
    // Before anything plays.
    for warning in asked.function.about.condition.warnings_when_measured(&here) {
        say(&format!("warning: {}", text(&warning)));
    }
    let runs = asked.runs_at(&bench, &run)?;
    let config = loop_config(asked, mode, run);
    let place = runs.map_or(Place::Nowhere, Place::Continued);
    let mut keeper = Keeper::new(place, Shown::Nothing);
    let looped = closed_loop(
        &mut bench,
        target,
        asked.function,
        &config,
        &mut keeper,
        &mut |iteration| say(&progress(iteration)),
    );
    let looped = match looped {
        Ok(looped) => looped,
        Err(refused) => return Ok(Err(refused)),
    };
    if keeper.reused > 0 {
        say(&format!(
            "{} {} taken from the interrupted command",
            counted(keeper.reused, "measurement"),
            if keeper.reused == 1 { "was" } else { "were" }
        ));
    }
    say(&result(&looped));
    Ok(Ok(Corrected { looped }))
}

fn loop_config(asked: &Asked<'_>, mode: ModeName, run: RunPlan) -> LoopConfig {
    LoopConfig {
        render: asked.config.clone(),
        correct: CorrectConfig::usual(match mode {
            ModeName::Replicate => Mode::Replicate,
            ModeName::Texture => Mode::Texture,
        }),
        judged: asked.args.band,
        iterations: usize::from(asked.args.iterations.unwrap_or(ITERATIONS)),
        force_share: GateConfig::usual().force_share,
        run,
    }
}

/// What the loop came to, in words.
fn result(looped: &ClosedLoopResult) -> String {
    let [open_db, kept_db] = [
        &looped.iterations[0].verification,
        looped.best_verification(),
    ]
    .map(piezotact::verify::Verification::judged_error_db);
    let errors = match (
        looped.best == looped.iterations[0].number,
        looped.confirmed.is_some(),
    ) {
        (true, true) => format!(
            "spectrum error {open_db:.2} dB rms in open loop, whose drive is kept, and {kept_db:.2} dB rms when it was measured once more"
        ),
        (true, false) => format!(
            "spectrum error {open_db:.2} dB rms in open loop, whose drive is kept; not confirmed by a further measurement"
        ),
        (false, confirmed) => format!(
            "spectrum error {open_db:.2} dB rms in open loop, {kept_db:.2} dB rms for the kept drive (iteration {}, {} by a further measurement)",
            looped.best,
            if confirmed {
                "confirmed"
            } else {
                "not confirmed"
            }
        ),
    };
    format!("closed loop: {}; {errors}; {}", looped.kept, looped.end)
}

/// An iteration in words.
fn progress(iteration: &Iteration) -> String {
    let v = &iteration.verification;
    format!(
        "iteration {}: spectrum error {:.2} dB rms, {:.1} dB at most, waveform correlation {:.3}, NMSE {} dB",
        iteration.number,
        v.judged_error_db(),
        v.error_db_max_achievable(),
        v.waveform_correlation,
        signed(v.waveform_nmse_db, 1)
    )
}

impl Corrected {
    /// Writes what was recorded of `drive`, the best one.
    pub(super) fn keep(&self, path: &Path, rendering: Rendering, drive: &Series<Drive>) -> Outcome {
        let recording = &self.looped.recording;
        let mut journal = JournalWriter::create(path, self.start(rendering, drive))?;
        let samples: Vec<Vec<f64>> = recording
            .channels()
            .iter()
            .map(|channel| channel.samples.clone())
            .collect();
        journal.append(&samples)?;
        let kept = journal.finish(
            recording.about.provenance.clone(),
            recording.about.warnings.clone(),
        )?;
        if let Some(kept) = kept {
            say(&format!(
                "the earlier recording of that name is kept as {}",
                kept.display()
            ));
        }
        Ok(())
    }

    /// The start document of the recording of the best drive.
    fn start(&self, rendering: Rendering, drive: &Series<Drive>) -> StartDocument {
        let recording = &self.looped.recording;
        let channels = recording.channels().iter();
        let start = RunStart {
            label: "render".into(),
            rate_hz: recording.rate(),
            channels: channels.map(|c| (c.name.clone(), c.unit.clone())).collect(),
            about: About::new(
                recording.about.condition.clone(),
                recording.about.provenance.clone(),
            ),
            annotations: recording.annotations.clone(),
            clocks: recording.stated_clocks(),
            setup: None,
            drive: Some(Checksum::of(drive.samples().iter().copied())),
            expected_s: None,
        };
        StartDocument {
            setup: rendering.setup.clone(),
            rendering: Some(rendering),
            ..StartDocument::of(&start, None)
        }
    }
}
