//! `piezotact render`: the drive that makes a finger feel a texture.

use std::path::Path;

use anyhow::anyhow;
use piezotact::correct::{CorrectConfig, Mode};
use piezotact::manipulate::{Lineage, Operation, Step};
use piezotact::quantity::{Acceleration, Decibels, Drive, Measure, SampleRate, Unit};
use piezotact::recording::Recording;
use piezotact::render::{
    self, Clipping, Headroom, Inverse, PhaseForm, RenderConfig, RenderError, RenderedDrive,
    gains_for, headroom, require_gain,
};
use piezotact::series::Series;
use piezotact::transfer::TransferFunction;
use piezotact_bench::procedure::{Iteration, LoopConfig, Looped, closed_loop};
use piezotact_bench::{BenchError, BenchSpec, GateConfig};
use piezotact_dataset::sidecar::{Rendering, Sidecar, sidecar_path};
use piezotact_dataset::wav::{SampleFormat, write_wav_with_sidecar};
use piezotact_dataset::{ReadOptions, read_recording, read_transfer};
use serde_json::{Value, json};

use super::{bench_failure, open_bench, outputs, rate_option, run_plan, texture};
use crate::cli::{InverseName, ModeName, PhaseName, Render};
use crate::failure::{Failure, Outcome, usage};
use crate::output::{doubts_json, headroom_text, print, print_json, say, say_doubts};
use crate::report::name;

pub(crate) fn run(args: &Render) -> Outcome {
    let read: Vec<&Path> = [args.target.as_path(), &args.transfer]
        .into_iter()
        .chain(args.bench.as_ref().and_then(BenchSpec::file))
        .collect();
    outputs(&read, &[&args.out, &sidecar_path(&args.out)])?;
    if !(-120.0..=120.0).contains(&args.level) {
        return Err(usage(anyhow!(
            "expected a level from -120 to 120 dB, found {}; 0 is the texture's own",
            args.level
        )));
    }
    let document = read_transfer(&args.transfer)?;
    let function = document.function::<Drive, Acceleration>(&args.transfer)?;
    if let Some(gain) = args.gain {
        require_gain(function.drive.as_ref(), gain)?;
    }
    let options = ReadOptions {
        scale: args.scale.clone(),
        rate: rate_option(args.target_rate)?,
    };
    let contents = read_recording(&args.target, &options)?;
    let recording = &contents.recording;
    let target =
        texture(&args.target, recording, args.channel.as_deref())?.amplified(Decibels(args.level));
    let mut config = RenderConfig::over(
        args.band,
        SampleRate::new(f64::from(args.rate)).map_err(usage)?,
    );
    if args.allow_clipping {
        config.clipping = Clipping::Allow;
    }
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
    let looped = args
        .mode
        .zip(args.bench.as_ref())
        .map(|(mode, bench)| in_a_loop(args, &target, &function, &config, (mode, bench)))
        .transpose()?;
    let mut drive = match &looped {
        Some(looped) => looped.rendered.clone(),
        None => render::render(&target, &function, &config)
            .map_err(|error| refused(args, &function, error))?,
    };
    drive.doubts.splice(0..0, recording.doubts.iter().cloned());
    drive
        .provenance
        .steps
        .insert(0, format!("target {}", args.target.display()));
    drive.provenance.lineage = Some(lineage(args, recording, &target, &drive));
    let rendering = Rendering::of(&drive, &name(&args.target), args.level);
    write_drive(&args.out, &drive, args.rate, rendering)?;
    if args.json {
        return print_json(&json!({
            "out": args.out,
            "rate_hz": args.rate,
            "headroom": drive.headroom,
            "achievable_band_hz": drive.achievable,
            "given_up_band_hz": drive.given_up,
            "drive_setup": drive.setup,
            "gains": drive.setup.as_ref().map(|setup| gains_for(&drive.headroom, setup)),
            "loop": looped.as_ref().map(loop_json),
            "doubts": doubts_json(&drive.doubts)?,
        }));
    }
    say_doubts(&drive.doubts);
    let bands: Vec<String> = drive.achievable.iter().map(ToString::to_string).collect();
    print(&format!(
        "wrote {}: {}; achievable {}",
        args.out.display(),
        headroom_text(&drive.headroom),
        bands.join(", ")
    ))
}

/// Why a target is not rendered, and what would be.
fn refused(
    args: &Render,
    function: &TransferFunction<Drive, Acceleration>,
    error: RenderError,
) -> Failure {
    match error {
        RenderError::BandAboveNyquist { .. }
        | RenderError::NoLine { .. }
        | RenderError::Rate(_) => usage(error),
        RenderError::ExceedsFullScale { fits_at, peak, .. } => {
            let level = args.level + fits_at.0;
            let louder = function.drive.as_ref().and_then(|setup| {
                let headroom = Headroom {
                    peak,
                    ..headroom(&[peak], SampleRate::new(1.0).ok()?, Some(setup))
                };
                let fits = gains_for(
                    &Headroom {
                        slope_v_per_s: None,
                        ..headroom
                    },
                    setup,
                );
                let fit = fits
                    .into_iter()
                    .find(|fit| fit.headroom_db >= 0.0 && fit.gain != setup.gain)?;
                Some(format!(
                    ", a transfer function measured at gain {} would",
                    fit.gain
                ))
            });
            Failure::Data(anyhow!(
                "{}: {error}: --level {level:.1} fits{}, --inverse drive-limited turns down what costs most, --allow-clipping plays it as it is",
                args.target.display(),
                louder.unwrap_or_default()
            ))
        }
        _ => Failure::Data(anyhow::Error::new(error).context(args.target.display().to_string())),
    }
}

/// Renders in a closed loop, each drive said as it is judged.
fn in_a_loop(
    args: &Render,
    target: &Series<Acceleration>,
    function: &TransferFunction<Drive, Acceleration>,
    config: &RenderConfig,
    (mode, bench): (ModeName, &BenchSpec),
) -> Outcome<Looped> {
    let mut bench = open_bench(bench)?;
    let run = run_plan("render", &args.finger, bench.acquirer.as_ref());
    let asked = bench.acquirer.condition(&run);
    for doubt in function.condition.doubts_when_measured(&asked) {
        say(&format!("doubt: {doubt}"));
    }
    let loop_config = LoopConfig {
        render: config.clone(),
        correct: CorrectConfig::usual(match mode {
            ModeName::Replicate => Mode::Replicate,
            ModeName::Texture => Mode::Texture,
        }),
        judged: args.band,
        iterations: usize::from(args.iterations),
        force_share: GateConfig::usual().force_share,
        run,
    };
    let looped = closed_loop(
        &mut bench,
        target,
        function,
        &loop_config,
        &mut |iteration: &Iteration| {
            let v = &iteration.verification;
            say(&format!(
                "iteration {}: {:.2} dB rms, {:.1} dB at most, waveform correlation {:.3}",
                iteration.number,
                v.error_db_rms_achievable.unwrap_or(v.error_db_rms),
                v.error_db_max,
                v.waveform_correlation
            ));
        },
    )
    .map_err(|error| match error {
        BenchError::Render(error) => refused(args, function, error),
        other => bench_failure(other),
    })?;
    let error_of = |i: usize| {
        let v = &looped.iterations[i].verification;
        v.error_db_rms_achievable.unwrap_or(v.error_db_rms)
    };
    say(&format!(
        "closed loop: {:.2} dB rms open, {:.2} dB rms in iteration {}; {}",
        error_of(0),
        error_of(looped.best),
        looped.best,
        looped.end
    ));
    Ok(looped)
}

fn loop_json(looped: &Looped) -> Value {
    let each: Vec<Value> = looped
        .iterations
        .iter()
        .map(|i| {
            json!({
                "iteration": i.number,
                "error_db_rms": i.verification.error_db_rms,
                "error_db_rms_achievable": i.verification.error_db_rms_achievable,
                "error_db_max": i.verification.error_db_max,
                "level_error_db": i.verification.level_error_db,
                "waveform_correlation": i.verification.waveform_correlation,
                "held_at_limit": i.held,
            })
        })
        .collect();
    json!({ "best": looped.best, "ended": looped.end.to_string(), "iterations": each })
}

/// What the texture was made from, with its rendering as the last step.
fn lineage(
    args: &Render,
    recording: &Recording,
    target: &Series<Acceleration>,
    drive: &RenderedDrive,
) -> Lineage {
    let so_far = recording.provenance.lineage.clone();
    let operation = Operation::Rendered {
        transfer: name(&args.transfer),
        gain: drive.setup.as_ref().map(|setup| setup.gain),
        level_db: args.level,
        band_hz: args.band,
    };
    so_far
        .unwrap_or_else(|| Lineage::of(name(&args.target)))
        .then(Step::between(operation, target, &drive.drive))
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
        condition: drive.condition.clone(),
        provenance: drive.provenance.clone(),
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
