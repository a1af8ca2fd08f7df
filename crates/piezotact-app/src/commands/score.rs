//! `piezotact score`: whether two vibrations are distinguishable by touch.

use anyhow::anyhow;
use piezotact::Warning;
use piezotact::discrimination::Model;
use piezotact::perception::Sensitivity;
use piezotact::quantity::{Acceleration, Band, Decibels, Unit};
use piezotact::recording::Recording;
use piezotact::resample::{CommonRate, to_common_rate};
use piezotact::score::{self, LiteratureConfig, ScoreConfig, ScoreError, ScoredRecordings};
use piezotact::series::Series;
use piezotact_dataset::read_contact_map;

use crate::cli::{Feeling, Score};
use crate::deliver::deliver;
use crate::failure::{Failure, Outcome, usage};
use crate::memory::fits;
use crate::places::outputs;
use crate::reading::{read, read_beside, sliding};
use crate::report;

pub(crate) fn run(args: &Score) -> Outcome {
    outputs(&[&args.reference, &args.test], &args.outputs.files())?;
    if args.full_scale.unit != Unit::MetrePerSecondSquared {
        return Err(usage(anyhow!(
            "expected --full-scale in m/s², found {}; give an acceleration, such as \"1 m/s2\"",
            args.full_scale
        )));
    }
    let [reference, test] = [reference(args)?, test(args)?];
    let (score, sensitivity) = scored(args, &reference, &test)?;
    let scored = ScoredRecordings {
        names: [&args.reference, &args.test].map(|path| report::name(path)),
        provenance: [reference, test].map(|read| read.recording.about.provenance),
        sensitivity,
        score,
    };
    deliver(&args.outputs, &scored)
}

/// A recording with the vibration that is scored, and what was left out of it.
struct Scored {
    recording: Recording,
    vibration: Series<Acceleration>,
    left_out: Option<Warning>,
}

fn reference(args: &Score) -> Outcome<Scored> {
    let recording = read(&args.reference, &args.reading)?.recording;
    let channel = args.channel.as_deref();
    let (vibration, left_out) = sliding(&args.reference, "the reference", &recording, channel)?;
    Ok(Scored {
        recording,
        vibration,
        left_out,
    })
}

fn test(args: &Score) -> Outcome<Scored> {
    let recording = read_beside(&args.test, args.test_scale.as_ref(), &args.reading)?.recording;
    let channel = args.test_channel.as_ref().or(args.channel.as_ref());
    let channel = channel.map(String::as_str);
    let (vibration, left_out) = sliding(&args.test, "the test", &recording, channel)?;
    Ok(Scored {
        recording,
        vibration,
        left_out,
    })
}

/// The score of the two, with what their recordings give a warning for before what it gives a warning for itself; for a report with what
/// it depends on.
fn scored(
    args: &Score,
    reference: &Scored,
    test: &Scored,
) -> Outcome<(score::Score, Vec<Sensitivity>)> {
    let CommonRate {
        first: a,
        second: b,
        warning,
    } = to_common_rate(
        ("the reference", reference.vibration.clone()),
        ("the test", test.vibration.clone()),
    )?;
    let samples = a.samples().len().max(b.samples().len());
    fits("the score", samples, score::MEMORY_BYTES_A_SAMPLE)?;
    let felt = model(&args.feeling, args.band)?;
    let config = ScoreConfig {
        judged_by: args.model.into(),
        level_jnd: felt.level_jnd,
        level_jnd_high: felt.level_jnd_high,
        frequency_jnd_share: felt.frequency_jnd_share,
        contact: felt.contact,
        literature: LiteratureConfig {
            curve: args.curve.into(),
            full_scale_m_s2: args.full_scale.value,
        },
        ..ScoreConfig::over(args.band, a.rate().hz())
    };
    let mut score = score::score(&a, &b, &config).map_err(|error| match error {
        ScoreError::BandAboveNyquist { .. }
        | ScoreError::NoBand { .. }
        | ScoreError::Lines(_)
        | ScoreError::Jnd { .. } => usage(error),
        _ => Failure::from(error),
    })?;
    let known = [&reference.recording, &test.recording];
    let known = known.into_iter().flat_map(|read| &read.about.warnings);
    let left_out = [&reference.left_out, &test.left_out].into_iter().flatten();
    let known = known.chain(left_out).cloned();
    score.warnings.put_first(known.chain(warning));
    let sensitivity = match (&args.outputs.report, &score.perceived) {
        (Some(_), Some(_)) => score.sensitivity([&a, &b])?,
        _ => Vec::new(),
    };
    Ok((score, sensitivity))
}

/// What a finger feels over `band`, as it was asked for.
pub(crate) fn model(args: &Feeling, band: Band) -> Outcome<Model> {
    score::require_jnd(Decibels(args.jnd), args.frequency_jnd).map_err(usage)?;
    Ok(Model {
        level_jnd: Decibels(args.jnd),
        frequency_jnd_share: args.frequency_jnd,
        contact: args
            .contact_map
            .as_deref()
            .map(read_contact_map)
            .transpose()?,
        ..Model::over(band)
    })
}
