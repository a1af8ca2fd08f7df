//! The counterparts of the figures of chapter 3.

use piezotact::compare::Summary;
use piezotact::figure::Line;
use piezotact::quantity::{Acceleration, Hertz};

use super::findings::friction_of;
use super::{Touched, named};
use crate::ReplayError;
use crate::figure::{
    Counterpart, decibels, density, frequency, line, linear, logarithmic, names, over_names,
    share_scales,
};
use piezotact_bench::ProcedureError;

/// How far up the spectrograms go: where the first lines of a fingerprint are.
const FIRST_LINES_OF_RIDGES: Hertz = Hertz(300.0);

/// Mean PSDs in one frame.
fn spectra<'a>(
    number: &'static str,
    caption: &str,
    groups: impl Iterator<Item = (String, &'a Summary)>,
) -> Counterpart {
    Counterpart::chart(
        number,
        caption,
        (frequency(), density()),
        groups
            .map(|(label, s)| {
                let points = decibels(&s.psd.mean, s.psd.resolution_hz, 10.0, 600.0);
                line(label, points)
            })
            .collect(),
    )
}

fn passive_at<'a>(
    samples: &'a [Touched],
    names: &'a [&'a str],
    speed: usize,
) -> impl Iterator<Item = (String, &'a Summary)> {
    samples
        .iter()
        .filter(|s| names.contains(&s.name.as_str()))
        .map(move |s| (s.name.clone(), &s.passive[speed]))
}

fn active_of<'a>(
    samples: &'a [Touched],
    names: &'a [&'a str],
) -> impl Iterator<Item = (String, &'a Summary)> {
    samples
        .iter()
        .filter(|s| names.contains(&s.name.as_str()))
        .map(|s| (s.name.clone(), &s.active_summary))
}

/// Values of all samples by name.
fn by_sample(
    number: &'static str,
    caption: &str,
    label: &str,
    samples: &[Touched],
    lines: Vec<Line>,
) -> Counterpart {
    Counterpart::chart(
        number,
        caption,
        (
            names("sample", samples.iter().map(|s| s.name.clone())),
            logarithmic(label),
        ),
        lines,
    )
}

pub(super) fn figures(samples: &[Touched]) -> Result<Vec<Counterpart>, ReplayError> {
    let all: Vec<&str> = samples.iter().map(|s| s.name.as_str()).collect();
    let values = |value: fn(&Touched) -> f64| samples.iter().map(value);
    let mut figures = Vec::new();
    if let Some(s8) = named(samples, "S8") {
        figures.extend(strokes_of(s8)?);
    }
    figures.push(spectra(
        "31",
        "Active touch of the 14 isotropic samples: mean PSDs.",
        active_of(samples, &all),
    ));
    figures.push(spectra(
        "32",
        "Passive touch of the 14 isotropic samples at 30 mm/s and 0.2 N: mean PSDs.",
        passive_at(samples, &all, 2),
    ));
    figures.push(by_sample(
        "33a",
        "Roughness of the samples.",
        "Ra, µm",
        samples,
        vec![over_names("", values(|s| s.ra_m * 1e6))],
    ));
    figures.push(by_sample(
        "33b",
        "Level of passive touch at 30 mm/s.",
        "rms, m/s²",
        samples,
        vec![over_names("", values(Touched::level))],
    ));
    figures.push(by_sample(
        "34",
        "Friction coefficient of passive touch at 30 mm/s; the level stands in the counterpart of figure 33b.",
        "friction coefficient",
        samples,
        vec![over_names("", values(friction_of))],
    ));
    for (number, name) in [("35a", "S1"), ("35b", "S2"), ("35c", "S3")] {
        if let Some(sample) = named(samples, name) {
            let speeds = ["10 mm/s", "20 mm/s", "30 mm/s"];
            let groups = speeds.map(str::to_owned).into_iter().zip(&sample.passive);
            figures.push(spectra(number, &format!("{name} at three speeds."), groups));
        }
    }
    if let Some((_, vibrations)) = named(samples, "S1").and_then(|s| s.shown.as_ref()) {
        let titles = ["S1, 10 mm/s", "S1, 20 mm/s", "S1, 30 mm/s"];
        let panels: Vec<_> = titles.into_iter().zip(vibrations).collect();
        figures.push(Counterpart::spectrograms(
            "35",
            "The same in time: strokes over S1 at each speed, one after the other. The fingerprint's comb moves with speed.",
            &panels,
            FIRST_LINES_OF_RIDGES,
        )?);
    }
    let coarse = ["S1", "S2", "S3"];
    for (number, speed, text) in [
        ("36a", 0, "10 mm/s"),
        ("36b", 1, "20 mm/s"),
        ("36c", 2, "30 mm/s"),
    ] {
        let caption = format!("S1, S2 and S3 at {text}.");
        figures.push(spectra(
            number,
            &caption,
            passive_at(samples, &coarse, speed),
        ));
    }
    figures.push(by_sample(
        "37",
        "Level of passive touch at three speeds.",
        "rms, m/s²",
        samples,
        vec![
            over_names("10 mm/s", values(|s| s.passive[0].rms.mean)),
            over_names("20 mm/s", values(|s| s.passive[1].rms.mean)),
            over_names("30 mm/s", values(|s| s.passive[2].rms.mean)),
        ],
    ));
    let sets: [(&str, &str, &[&str]); 3] = [
        ("38a", "38b", &["S4", "S5", "S6", "S7", "S8"]),
        ("39a", "39b", &["S2", "S3"]),
        ("40a", "40b", &["S9", "S10", "S11", "S12", "S13"]),
    ];
    for (passive, active, names) in sets {
        let listed = names.join(", ");
        figures.push(spectra(
            passive,
            &format!("Passive touch: {listed}."),
            passive_at(samples, names, 2),
        ));
        figures.push(spectra(
            active,
            &format!("Active touch: {listed}."),
            active_of(samples, names),
        ));
    }
    share_scales(&mut figures);
    Ok(figures)
}

/// Figures 27–30: the signals of active strokes over one sample, one of them, and all spectra with their mean.
fn strokes_of(sample: &Touched) -> Result<Vec<Counterpart>, ReplayError> {
    const SHOWN_S: f64 = 9.0;
    let Some((recording, _)) = &sample.shown else {
        return Ok(Vec::new());
    };
    let rate_hz = recording.rate().hz();
    let shown = (SHOWN_S * rate_hz) as usize;
    let mut figures = Vec::new();
    for (number, label, names) in [
        ("27a", "acceleration, m/s²", &["acceleration"][..]),
        ("27b", "force, N", &["force_x", "force_y", "force_z"][..]),
    ] {
        let channels = recording
            .channels()
            .iter()
            .filter(|c| names.contains(&c.name.as_str()));
        let lines = channels
            .map(|channel| {
                let points = channel.samples.iter().take(shown).step_by(4).enumerate();
                let points = points
                    .map(|(i, v)| (4.0 * i as f64 / rate_hz, *v))
                    .collect();
                let label = if names.len() > 1 {
                    channel.name.as_str()
                } else {
                    ""
                };
                line(label, points).thin()
            })
            .collect();
        figures.push(Counterpart::chart(
            number,
            format!("The first strokes over {}, as recorded.", sample.name),
            (linear("time, s"), linear(label)),
            lines,
        ));
    }
    if let Some(stroke) = sample.active.segmentation.strokes.first() {
        let vibration = recording
            .series::<Acceleration>(None)
            .map_err(ProcedureError::from)?;
        let points = stroke.steady.of(vibration.samples()).iter().enumerate();
        figures.push(Counterpart::chart(
            "29a",
            format!("The steady part of one stroke over {}.", sample.name),
            (linear("time, s"), linear("acceleration, m/s²")),
            vec![line("", points.map(|(i, v)| (i as f64 / rate_hz, *v)).collect()).thin()],
        ));
    }
    let analysis = &sample.active.analysis;
    let psd = &analysis.psd;
    let step = psd.resolution_hz;
    let mut lines: Vec<Line> = psd
        .each
        .iter()
        .map(|each| line("", decibels(each, step, 10.0, 600.0)).thin())
        .collect();
    let mean = decibels(&psd.mean, step, 10.0, 600.0);
    let label = format!("mean of {} strokes", psd.each.len());
    lines.push(line(label, mean));
    figures.push(Counterpart::chart(
        "30",
        format!("PSDs of all strokes over {} and their mean.", sample.name),
        (frequency(), density()),
        lines,
    ));
    Ok(figures)
}
