//! Chapter 3: vibrations of active and passive touch of the isotropic samples, by the reference participant.

mod figures;
mod findings;

use figures::figures;
use findings::{
    active_as_passive, broad_and_similar, close_levels, fingerprint, friction, hard_samples,
    level_falls, repeatable, same_roughness, speed, stick_slip, transversal_touch,
};
use piezotact::Warning;
use piezotact::compare::{Periods, Summary};
use piezotact::feature::band_power;
use piezotact::quantity::{Acceleration, Band, Hertz, Seconds};
use piezotact::recording::Recording;
use piezotact::series::Series;

use super::measured::summary;
use super::{Chapter, ReplayError, said_once};
use piezotact_bench::ProcedureError;
use piezotact_twin::{
    ActTouch, ActiveProtocol, Pace, Participant, Relief, SlidingDirection, TriboAir,
};
use piezotact_volunteers::{Laboratory, Taken, run, take};

/// Speeds of passive touch, m/s.
const SPEEDS_M_S: [f64; 3] = [0.01, 0.02, 0.03];
/// Strokes of passive touch: at least 6 in the thesis, 10 for an average.
const PASSIVE_STROKES: usize = 12;
/// Strokes of active touch: at least 15.
const ACTIVE_STROKES: usize = 15;
/// Samples in a segment at each speed: a fingerprint's peak is as many lines wide at all of them.
const SEGMENTS: [usize; 3] = [4_096, 2_048, 1_024];
const SEGMENT: usize = SEGMENTS[2];
/// The ends of the third octaves around 20 to 500 Hz, 10^1.25 and 10^2.75 Hz, rounded inwards.
const THIRD_OCTAVES_HZ: [f64; 2] = [17.79, 562.3];
/// The samples on which the fingerprint shows.
const COARSE: [&str; 4] = ["S1", "S2", "S3", "S4"];

/// What was measured of one sample.
struct Touched {
    name: String,
    ra_m: f64,
    /// At the three speeds.
    passive: Vec<Summary>,
    warnings: Vec<Warning>,
    active: Taken,
    active_summary: Summary,
    /// What transversal strokes say, on the coarse samples.
    transversal: Option<(Taken, Summary)>,
    /// The recording of active touch, and of passive touch at each speed, where a figure shows them.
    shown: Option<(Recording, Vec<Series<Acceleration>>)>,
}

impl Touched {
    /// The level of passive touch at 30 mm/s, m/s².
    fn level(&self) -> f64 {
        self.passive[2].rms.mean
    }
}

/// Chapter 3 on the twin.
///
/// # Errors
/// [`ReplayError`] where the analysis refuses what the benches gave.
pub(super) fn chapter3(laboratory: &Laboratory) -> Result<Chapter, ReplayError> {
    let samples = touched(laboratory)?;
    let findings = vec![
        broad_and_similar(&samples, band(10.0, 600.0)?),
        level_falls(&samples),
        close_levels(&samples),
        same_roughness(&samples),
        hard_samples(&samples),
        friction(&samples),
        speed(&samples),
        fingerprint(&samples, laboratory.parameters.person.reference_ridge_m),
        active_as_passive(&samples, band(20.0, 500.0)?),
        repeatable(&samples, band(THIRD_OCTAVES_HZ[0], THIRD_OCTAVES_HZ[1])?),
        transversal_touch(&samples, laboratory.parameters.person.reference_ridge_m),
    ];
    let slipped = stick_slip(&samples);
    Ok(Chapter {
        number: 3,
        title: "Vibrations of active and passive touch",
        measured: vec![
            format!(
                "The reference participant (ridges {:.3} mm apart) touched the 14 isotropic samples at 0.2 N: passively {PASSIVE_STROKES} times at each of 10, 20 and 30 mm/s, actively in {ACTIVE_STROKES} proximal strokes at 30 mm/s, and S1–S4 in as many transversal strokes.",
                laboratory.parameters.person.reference_ridge_m * 1e3
            ),
            slipped,
        ],
        findings,
        figures: figures(&samples)?,
        warnings: said_once(
            samples
                .iter()
                .flat_map(|s| s.warnings.iter().map(|d| (s.name.as_str(), d))),
        ),
        missing: Vec::new(),
    })
}

fn band(low_hz: f64, high_hz: f64) -> Result<Band, ReplayError> {
    Ok(Band::new(Hertz(low_hz), Hertz(high_hz))?)
}

fn touched(laboratory: &Laboratory) -> Result<Vec<Touched>, ReplayError> {
    let parameters = &laboratory.parameters;
    let person = || Participant::of(0, laboratory.seed, parameters);
    let periods = Periods {
        ridge_m: Some(parameters.person.reference_ridge_m),
        texture_m: None,
    };
    let run = run(laboratory, "chapter 3", Some(0.2));
    let names = (1..=13).map(|i| format!("S{i}")).chain(["NO".to_owned()]);
    names
        .map(|name| {
            let sample = parameters.sample(&name)?;
            let (mut passive, mut vibrations, mut warnings) = (Vec::new(), Vec::new(), Vec::new());
            for (speed_m_s, segment) in SPEEDS_M_S.into_iter().zip(SEGMENTS) {
                let bench =
                    TriboAir::new(parameters, person(), sample, PASSIVE_STROKES, speed_m_s)?;
                let (taken, recording) = take(bench.into_acquirer(), &run, segment)?;
                passive.push(summary(&taken, &name, periods)?);
                warnings.extend(taken.warnings.iter().cloned());
                if name == "S1" {
                    vibrations.push(strokes_joined(&taken, &recording)?);
                }
            }
            let stroked = |movement: SlidingDirection| {
                let protocol = ActiveProtocol {
                    strokes: ACTIVE_STROKES,
                    movement,
                    pace: Pace::Metronome {
                        speed_m_s: 0.03,
                        stroke_s: None,
                    },
                };
                let bench = ActTouch::new(parameters, person(), sample, protocol)?;
                take(bench.into_acquirer(), &run, SEGMENT)
            };
            let (active, recording) = stroked(SlidingDirection::Proximal)?;
            warnings.extend(active.warnings.iter().cloned());
            let transversal = if COARSE.contains(&name.as_str()) {
                let (taken, _) = stroked(SlidingDirection::Transversal)?;
                let summary = summary(&taken, &name, periods)?;
                Some((taken, summary))
            } else {
                None
            };
            Ok(Touched {
                warnings,
                ra_m: match sample.relief {
                    Relief::Isotropic { ra_m, .. } => ra_m,
                    Relief::Dots { .. } | Relief::Ridges { .. } => 0.0,
                },
                active_summary: summary(&active, &name, periods)?,
                shown: (name == "S1" || name == "S8").then_some((recording, vibrations)),
                passive,
                active,
                transversal,
                name,
            })
        })
        .collect()
}

/// The vibration of the steady parts of the first strokes, one after the other, as long as a figure shows.
fn strokes_joined(
    taken: &Taken,
    recording: &Recording,
) -> Result<Series<Acceleration>, ReplayError> {
    const SHOWN_S: f64 = 3.0;
    let vibration = recording
        .series::<Acceleration>(None)
        .map_err(ProcedureError::from)?;
    let joined = taken
        .segmentation
        .strokes
        .iter()
        .flat_map(|stroke| stroke.steady.of(vibration.samples()).iter().copied())
        .take(recording.rate().samples_in(Seconds(SHOWN_S)))
        .collect();
    Ok(Series::new(joined, recording.rate())?)
}

fn named<'a>(samples: &'a [Touched], name: &str) -> Option<&'a Touched> {
    samples.iter().find(|sample| sample.name == name)
}

fn level(samples: &[Touched], name: &str) -> f64 {
    named(samples, name).map_or(f64::NAN, Touched::level)
}

/// The rough samples, in order.
fn rough(samples: &[Touched]) -> Vec<&Touched> {
    samples.iter().filter(|s| s.name != "NO").collect()
}

/// A PSD of power 1 within `band`.
fn shape(summary: &Summary, band: Band) -> Vec<f64> {
    let power = band_power(&summary.psd.mean, summary.psd.resolution_hz, band);
    summary.psd.mean.iter().map(|v| v / power).collect()
}
