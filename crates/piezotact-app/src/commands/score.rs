//! `piezotact score`: whether two vibrations are distinguishable by touch.

use std::fmt::Write as _;

use anyhow::anyhow;
use piezotact::discrimination::Model;
use piezotact::page::limit_text;
use piezotact::quantity::{Acceleration, Band, Decibels, Unit};
use piezotact::recording::Recording;
use piezotact::resample::{CommonRate, to_common_rate};
use piezotact::score::{self, BandScore, LiteratureConfig, ScoreConfig, ScoreError};
use piezotact::series::Series;
use piezotact_dataset::{ReadOptions, read_contact_map};
use piezotact_report::score::{Page, html};

use crate::advice::OptionWords;
use crate::cli::{Feeling, Score};
use crate::failure::{Failure, Outcome, usage};
use crate::invocation::write_report;
use crate::memory::fits;
use crate::output::{print, print_document, say_warnings};
use crate::places::outputs;
use crate::reading::{inspected, rate_option, read, texture};
use crate::report;

pub(crate) fn run(args: &Score) -> Outcome {
    let written: Vec<_> = args
        .report
        .iter()
        .map(std::path::PathBuf::as_path)
        .collect();
    outputs(&[&args.reference, &args.test], &written)?;
    if args.full_scale.unit != Unit::MetrePerSecondSquared {
        return Err(usage(anyhow!(
            "expected --full-scale in m/s², found {}; give an acceleration, such as \"1 m/s2\"",
            args.full_scale
        )));
    }
    let [reference, test] = [reference(args)?, test(args)?];
    let score = scored(args, &reference, &test)?;
    if let Some(path) = &args.report {
        let names = [report::name(&args.reference), report::name(&args.test)];
        let page = Page {
            names: [&names[0], &names[1]],
            recordings: [&reference.recording, &test.recording],
            score: &score,
        };
        write_report(path, &html(&page, &OptionWords)?)?;
    }
    if args.json {
        return print_document(&score);
    }
    print(&text(&score))?;
    if let Some(path) = &args.report {
        print(&format!("report: {}", path.display()))?;
    }
    say_warnings(&score.warnings);
    Ok(())
}

/// A recording with the vibration that is scored.
struct Scored {
    recording: Recording,
    vibration: Series<Acceleration>,
}

fn reference(args: &Score) -> Outcome<Scored> {
    let recording = read(&args.reference, &args.reading)?.recording;
    let vibration = texture(&args.reference, &recording, args.channel.as_deref())?;
    Ok(Scored {
        recording,
        vibration,
    })
}

fn test(args: &Score) -> Outcome<Scored> {
    let scale = args.test_scale.clone();
    let options = ReadOptions {
        scale: scale.or_else(|| args.reading.scale.clone()),
        rate: rate_option(args.reading.rate)?,
        ..ReadOptions::default()
    };
    let recording = inspected(&args.test, &options)?.recording;
    let channel = args.test_channel.as_ref().or(args.channel.as_ref());
    let vibration = texture(&args.test, &recording, channel.map(String::as_str))?;
    Ok(Scored {
        recording,
        vibration,
    })
}

/// The score of the two, with what their recordings give a warning for before what it gives a warning for itself.
fn scored(args: &Score, reference: &Scored, test: &Scored) -> Outcome<score::Score> {
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
    score.warnings.put_first(known.cloned().chain(warning));
    Ok(score)
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

/// The verdict first, then what it comes from.
fn text(score: &score::Score) -> String {
    let mut text = format!(
        "{}\n\n{:>16} {:>9} {:>9} {:>9} {:>8} {:>14} {:>7}\n{:>16} {:>9} {:>9} {:>9} {:>8} {:>14} {:>7}\n",
        score.sentence,
        "third octave",
        "A",
        "B",
        "threshold",
        "B − A",
        "felt",
        "share",
        "",
        "dB",
        "dB",
        "dB",
        "dB",
        "JND",
        "%",
    );
    for band in &score.bands {
        let _never_fails = writeln!(text, "{}", row(band));
    }
    text.push_str(&differences(score));
    text.push_str(&beside(score));
    text
}

/// The criteria and the differences over all bands.
fn differences(score: &score::Score) -> String {
    let e = &score.spectrum_error;
    format!(
        "levels in dB re 1 m/s² rms; felt: difference above threshold, spread over neighbouring bands, ± 95 % limits\n\n\
         {}\n\
         differences: spectrum {:.2} JND, level {:.2} JND, balance {:.2} JND (centroids {:.0} Hz and {:.0} Hz)\n\
         spectrum error: {:.2} dB rms over {}, {:.2} dB at most (at {:.0} Hz), resolution {:.2} Hz; level {:+.2} dB",
        criteria(score),
        score.spectrum.jnd,
        score.level.jnd,
        score.balance.jnd,
        score.reference_centroid_hz,
        score.test_centroid_hz,
        e.rms_db,
        score.config.band,
        e.max_db,
        e.max_at_hz,
        e.resolution_hz,
        score.level_error_db,
    )
}

/// Measures of waveforms and of the literature, where they were computed.
fn beside(score: &score::Score) -> String {
    let mut text = String::new();
    if let Some(w) = &score.waveform {
        let _never_fails = write!(
            text,
            "\nwaveform: correlation {:.3}, NMSE {:.1} dB, B {} by {:.2} ms",
            w.correlation,
            w.nmse_db,
            if w.delay_s < 0.0 { "earlier" } else { "later" },
            w.delay_s.abs() * 1e3
        );
    }
    if let Some(l) = &score.literature {
        let st_sim = l
            .st_sim
            .value
            .map_or_else(|| "no real value".into(), |v| format!("{v:.3}"));
        let _never_fails = write!(
            text,
            "\nfor comparison with the literature: ST-SIM {st_sim}, SPQI {:.3} (full scale {} m/s²)",
            l.spqi, l.config.full_scale_m_s2
        );
    }
    text
}

/// The criteria, one a line.
fn criteria(score: &score::Score) -> String {
    let lines: Vec<String> = score
        .criteria
        .iter()
        .map(|c| {
            format!(
                "criterion: {}: {}, limit {}",
                c.what,
                c.outcome.word(),
                limit_text(c.limit, &c.unit)
            )
        })
        .collect();
    lines.join("\n")
}

fn row(band: &BandScore) -> String {
    let felt = if band.share > 0.0 {
        format!("{:+.2} ± {:.2}", band.felt_jnd, band.ci_half_width_jnd)
    } else {
        "not felt".into()
    };
    format!(
        "{:>16} {:>9.1} {:>9.1} {:>9.1} {:>+8.2} {:>14} {:>7.1}",
        band.band_hz.to_string(),
        band.reference_db,
        band.test_db,
        band.threshold_db,
        band.difference_db,
        felt,
        band.share * 100.0
    )
}
