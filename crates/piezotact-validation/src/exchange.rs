//! Section 4.4 of chapter 4: two samples with their levels exchanged, each with its own spectrum.

use piezotact::Warning;
use piezotact::manipulate::{Texture, exchanged};
use piezotact::quantity::Acceleration;
use piezotact::series::Series;
use piezotact::spectrum::{WelchConfig, welch};
use piezotact::statistics::standard_deviation;

use super::ReplayError;
use super::claims::{Finding, Holds, at_most, most};
use super::figure::{Counterpart, decibels, density, frequency, line, linear};
use super::rendering::target;
use piezotact_twin::{ActTouch, ActiveProtocol, Pace, Participant, SlidingDirection};
use piezotact_volunteers::{Laboratory, run, take};

/// The pairs of *thesis* table 6, the lowest and the highest of each set of three.
const PAIRS: [[&str; 2]; 2] = [["S2", "S13"], ["S5", "S11"]];
/// Segments of the PSDs, samples: lines 4.9 Hz apart.
const SEGMENT_SAMPLES: usize = 1_024;
/// The levels of a claim that holds differ by no more than this, and the shapes by no more than that.
const SAME_LEVEL_RATIO: f64 = 1e-3;
const SAME_SHAPE_RATIO: f64 = 1e-9;
/// The stretch of a waveform that is drawn, s.
const DRAWN_S: f64 = 0.5;

/// What came of it.
pub(super) struct Exchange {
    pub(super) finding: Finding,
    pub(super) measured: String,
    pub(super) figures: Vec<Counterpart>,
    pub(super) warnings: Vec<(&'static str, Warning)>,
}

/// One sample that took the level of another.
struct Inverted {
    level_off: f64,
    shape_off: f64,
    told: String,
}

/// Both pairs, stroked by participant 1 at 30 mm/s and 0.2 N, with their levels exchanged.
pub(super) fn exchanged_levels(laboratory: &Laboratory) -> Result<Exchange, ReplayError> {
    let (mut all, mut figures, mut warnings) = (Vec::new(), Vec::new(), Vec::new());
    for pair in PAIRS {
        let [first, second] = pair.map(|sample| touched(laboratory, sample, &mut warnings));
        let before = [first?, second?];
        let [first, second] = before.clone();
        let after = exchanged(first, second)?;
        for (texture, own, other) in [(0, 0, 1), (1, 1, 0)] {
            all.push(inverted(&after[texture], &before[own], &before[other])?);
        }
        if figures.is_empty() {
            figures = drawn(&before, &after)?;
        }
    }
    let level_off = most(all.iter().map(|one| one.level_off));
    let shape_off = most(all.iter().map(|one| one.shape_off));
    let told: Vec<&str> = all.iter().map(|one| one.told.as_str()).collect();
    let finding = Finding::of(
        23,
        Holds::all([
            at_most(
                level_off,
                SAME_LEVEL_RATIO,
                "",
                "a level differs by more than 0.1 %",
            ),
            at_most(
                shape_off,
                SAME_SHAPE_RATIO,
                "",
                "a line of a normalised PSD differs by more than 1e-9",
            ),
        ]),
        format!(
            "{}; levels equal to {level_off:.1e}, normalised PSDs to {shape_off:.1e}",
            told.join(", ")
        ),
    );
    Ok(Exchange {
        finding,
        measured: "Participant 1 stroked S2, S13, S5 and S11 at 30 mm/s and 0.2 N; the rms levels of S2 and S13 were exchanged, \
            and those of S5 and S11.".into(),
        figures,
        warnings,
    })
}

/// One stroke on `sample`, freed of the gesture.
fn touched(
    laboratory: &Laboratory,
    sample: &'static str,
    warnings: &mut Vec<(&'static str, Warning)>,
) -> Result<Texture<Acceleration>, ReplayError> {
    let person = Participant::of(1, laboratory.seed, &laboratory.parameters);
    let protocol = ActiveProtocol {
        strokes: 3,
        movement: SlidingDirection::Proximal,
        pace: Pace::Metronome {
            speed_m_s: 0.03,
            stroke_s: None,
        },
    };
    let of = laboratory.parameters.sample(sample)?;
    let acttouch = ActTouch::new(&laboratory.parameters, person, of, protocol)?;
    let plan = run(laboratory, "exchanged levels", Some(0.2));
    let (taken, recording) = take(acttouch.into_acquirer(), &plan, SEGMENT_SAMPLES)?;
    warnings.extend(
        taken
            .warnings
            .iter()
            .map(|warning| (sample, warning.clone())),
    );
    Ok(Texture::of(sample, target(&taken, &recording)?))
}

fn level(texture: &Texture<Acceleration>) -> f64 {
    standard_deviation(texture.series.samples())
}

fn psd(series: &Series<Acceleration>) -> Result<(Vec<f64>, f64), ReplayError> {
    let psd = welch(series, &WelchConfig::hann(SEGMENT_SAMPLES))?;
    Ok((psd.values, psd.resolution_hz))
}

fn inverted(
    texture: &Texture<Acceleration>,
    own: &Texture<Acceleration>,
    other: &Texture<Acceleration>,
) -> Result<Inverted, ReplayError> {
    let normalised = |series| -> Result<Vec<f64>, ReplayError> {
        let (values, _) = psd(series)?;
        let sum: f64 = values.iter().sum();
        Ok(values.iter().map(|value| value / sum).collect())
    };
    let (shape, expected) = (normalised(&texture.series)?, normalised(&own.series)?);
    let off = shape
        .iter()
        .zip(&expected)
        .map(|(a, b)| (a / b - 1.0).abs());
    Ok(Inverted {
        level_off: (level(texture) / level(other) - 1.0).abs(),
        shape_off: most(off),
        told: format!(
            "{} with exchanged level {:.3} m/s² ({} {:.3})",
            own.lineage.source,
            level(texture),
            other.lineage.source,
            level(other)
        ),
    })
}

/// Figure 62: waveforms and PSDs, before and after.
fn drawn(
    before: &[Texture<Acceleration>; 2],
    after: &[Texture<Acceleration>; 2],
) -> Result<Vec<Counterpart>, ReplayError> {
    let mut figures = Vec::new();
    let label = |texture: &Texture<Acceleration>| {
        let inverted = if texture.lineage.steps.is_empty() {
            ""
        } else {
            ", level exchanged"
        };
        let name = &texture.lineage.source;
        format!("{name}{inverted}, {:.2} m/s² rms", level(texture))
    };
    for (number, textures, what) in [
        ("62a", before, "as recorded"),
        ("62b", after, "with their levels exchanged"),
    ] {
        let wave = |texture: &Texture<Acceleration>| {
            let rate_hz = texture.series.rate().hz();
            let shown = texture.series.samples().iter().enumerate();
            let shown = shown.map(|(i, v)| (i as f64 / rate_hz, *v));
            let points = shown.take((DRAWN_S * rate_hz) as usize).collect();
            line(label(texture), points).thin()
        };
        figures.push(Counterpart::chart(
            number,
            format!("The vibrations of S2 and S13 {what}: half a second of each."),
            (linear("time, s"), linear("acceleration, m/s²")),
            textures.iter().map(wave).collect(),
        ));
    }
    for (number, textures, what) in [
        ("62c", before, "as recorded"),
        (
            "62d",
            after,
            "with their levels exchanged: the spectral shapes do not change",
        ),
    ] {
        let mut lines = Vec::new();
        for texture in textures {
            let (values, step_hz) = psd(&texture.series)?;
            let points = decibels(&values, step_hz, 10.0, 600.0);
            lines.push(line(label(texture), points));
        }
        figures.push(Counterpart::chart(
            number,
            format!("The spectra of S2 and S13 {what}."),
            (frequency(), density()),
            lines,
        ));
    }
    Ok(figures)
}
