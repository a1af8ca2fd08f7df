//! Chapter 4: rendering on the device, with everybody's own transfer function.

use piezotact::Warning;
use piezotact::figure::Line;
use piezotact::quantity::{Acceleration, Decibels, Drive};
use piezotact::spectrum::amplitude_spectrum;
use piezotact::statistics::mean;
use piezotact::transfer::TransferFunction;
use piezotact::verify::{UncompensatedPrediction, Verification, predict_uncompensated};

use super::claims::{Finding, Holds, at_least, at_most, below, least as least_of, most};
use super::figure::{Counterpart, decibels, density, frequency, line, linear};
use super::rendering::{compared, judged_as, played, rendered, sent_uncompensated, target};
use super::{Chapter, ReplayError, campaigns, exchange, said_once};
use piezotact_bench::Bench;
use piezotact_twin::{ActTouch, ActiveProtocol, Pace, Participant, SlidingDirection};
use piezotact_volunteers::{Laboratory, characterised, resting, run, take};

/// Who takes part (*thesis* 4.3.2 has ten; five are enough for a rendering).
const PARTICIPANTS: u64 = 5;
/// One periodic and one isotropic texture, as figures 47 and 48.
const TEXTURES: [&str; 2] = ["M8", "S8"];
const SECONDS: f64 = 60.0;

/// One texture on one finger.
struct Felt {
    participant: u64,
    texture: &'static str,
    rendered: Verification,
    /// Sent as it stands, and turned down until nothing clips: against the target as it stands, and turned down as much.
    uncompensated: [Verification; 2],
    /// Sent as it stands, by the transfer function.
    predicted: UncompensatedPrediction,
    /// Whether the device clips it as it stands.
    clips: bool,
    level: Decibels,
    warnings: Vec<Warning>,
    figures: Vec<Counterpart>,
}

pub(super) fn chapter4(laboratory: &Laboratory) -> Result<Chapter, ReplayError> {
    let mut felt = Vec::new();
    for participant in 1..=PARTICIPANTS {
        let mut bench = laboratory.device(participant);
        let seed = laboratory.seed;
        let function = characterised(
            &mut bench,
            resting("characterise", 0.2, 20.0),
            SECONDS,
            seed,
        )?;
        for texture in TEXTURES {
            felt.push(felt_on_finger(
                laboratory,
                &mut bench,
                participant,
                texture,
                &function,
            )?);
        }
    }
    let exchange = exchange::exchanged_levels(laboratory)?;
    let campaigns = campaigns::of_chapter_4(laboratory)?;
    let mut findings = vec![wrong_strategy(&felt), overlaps(&felt), exchange.finding];
    findings.extend(campaigns.findings);
    let softest = felt.iter().map(|f| f.level.0).fold(0.0, f64::min);
    Ok(Chapter {
        number: 4,
        title: "Rendering textures on the device",
        measured: vec![
            format!(
                "Participants 1 to {PARTICIPANTS} stroked M8 (periodic) and S8 (isotropic) at 30 mm/s and 0.2 N; one stroke of \
                    each was rendered with their own transfer function (20°, 0.2 N, {SECONDS} s of random drive) and played to \
                    the finger, which had been lifted and repositioned."
            ),
            format!(
                "Textures that exceeded the limits of a device were rendered at a lower level, by at most {:.1} dB.",
                softest.abs()
            ),
            exchange.measured,
        ]
        .into_iter()
        .chain(campaigns.measured)
        .collect(),
        findings,
        warnings: said_once(
            felt.iter()
                .flat_map(|f| f.warnings.iter().map(|d| (f.texture, d)))
                .chain(exchange.warnings.iter().map(|(sample, d)| (*sample, d))),
        ),
        figures: felt
            .into_iter()
            .flat_map(|f| f.figures)
            .chain(exchange.figures)
            .chain(campaigns.figures)
            .collect(),
        missing: vec![
            "Figures 50 and 56–58 (photographs); figures 51 and 59, which show the matrices of figures 52 and 55 once more; figures 53, 54, 60, 61, 64 and 65, spectra and levels of which figures 31 to 33 and 62 are counterparts.".into(),
        ],
    })
}

/// A stroke of `texture`, rendered for the finger on `bench` with its own transfer function, and sent uncompensated.
fn felt_on_finger(
    laboratory: &Laboratory,
    bench: &mut Bench,
    participant: u64,
    texture: &'static str,
    function: &TransferFunction<Drive, Acceleration>,
) -> Result<Felt, ReplayError> {
    let sample = laboratory.parameters.sample(texture)?;
    let person = Participant::of(participant, laboratory.seed, &laboratory.parameters);
    let protocol = ActiveProtocol {
        strokes: 3,
        movement: SlidingDirection::Proximal,
        pace: Pace::Metronome {
            speed_m_s: 0.03,
            stroke_s: None,
        },
    };
    let acttouch = ActTouch::new(&laboratory.parameters, person, sample, protocol)?;
    let (taken, recording) = take(
        acttouch.into_acquirer(),
        &run(laboratory, "chapter 4", Some(0.2)),
        1_024,
    )?;
    let target = target(&taken, &recording)?;
    let (drive, level) = rendered(&target, function)?;
    let label = |what: &str| resting(&format!("{what} {texture}"), 0.2, 20.0);
    let measured = played(bench, &drive.drive, &label("play"))?;
    let verification = compared(&target, &measured, level)?;
    let sent = sent_uncompensated(bench, &target)?;
    let loud = played(bench, &sent.drive, &label("straight"))?;
    let loud = compared(&target, &loud, Decibels(0.0))?;
    let soft = played(bench, &sent.softer, &label("turned down"))?;
    let uncompensated = [loud, compared(&target, &soft, sent.level)?];
    let predicted = predict_uncompensated(&target, function, &judged_as(&target)?)?;
    let mut figures = Vec::new();
    if participant == 1 {
        figures = figures_of(texture, &verification, &uncompensated);
        if texture == "S8" {
            figures.extend(processing(&target, &drive, function));
        }
    }
    let warnings: [&[Warning]; 4] = [
        &taken.warnings,
        &drive.about.warnings,
        &measured.about.warnings,
        &verification.warnings,
    ];
    let warnings = warnings.into_iter().flatten().cloned().collect();
    Ok(Felt {
        warnings,
        participant,
        texture,
        rendered: verification,
        uncompensated,
        predicted,
        clips: sent.clips,
        level,
        figures,
    })
}

fn wrong_strategy(felt: &[Felt]) -> Finding {
    // Turned down until nothing clips, and multiplied back: what the device would do were it linear.
    let measured = |f: &Felt| {
        let error = &f.uncompensated[1].error_db;
        Sent {
            level_db: mean(error),
            shape_db: f.uncompensated[1].error_db_rms_level_matched,
            correlation: f.uncompensated[1].waveform_correlation,
        }
    };
    let predicted = |f: &Felt| Sent {
        level_db: f.predicted.level_difference_db,
        shape_db: f.predicted.error_db_rms_level_matched,
        correlation: f.predicted.waveform_correlation,
    };
    let both: Vec<(&Felt, Sent)> = felt
        .iter()
        .flat_map(|f| [(f, measured(f)), (f, predicted(f))])
        .collect();
    let level = least_of(both.iter().map(|(_, sent)| sent.level_db.abs()));
    let ratio = least_of(
        both.iter()
            .map(|(f, sent)| sent.shape_db / f.rendered.error_db_rms_level_matched),
    );
    let alike = most(both.iter().map(|(_, sent)| sent.correlation));
    let each_alike = TEXTURES.map(|texture| {
        let theirs = both.iter().filter(|(f, _)| f.texture == texture);
        let highest = most(theirs.map(|(_, sent)| sent.correlation));
        format!("{highest:.2} on {texture}")
    });
    let shapes = || both.iter().map(|(_, sent)| sent.shape_db);
    let clipping = felt.iter().filter(|f| f.clips).count();
    Finding::of(
        20,
        Holds::all([
            at_least(
                level,
                10.0,
                "dB",
                "some texture sent directly comes out within 10 dB of its level, at the scale of the device",
            ),
            at_least(
                ratio,
                3.0,
                "",
                "the shape error of some texture sent directly is less than three times that of its rendering",
            ),
            below(
                alike,
                0.75,
                "",
                "the waveform of some texture sent directly correlates with its target: from 50 to 500 Hz the response of the device with a finger rises \
                    by few dB, so a broad texture keeps much of its waveform once the delay is aligned",
            ),
        ]),
        format!(
            "measured below clipping and predicted from the transfer function, {} cases: level off by at least {level:.1} dB at \
                1 m/s² as full scale; level-matched error {:.1} to {:.1} dB rms, at least {ratio:.1} times that of the rendering; \
                correlation at most {}; as it stands, the signal exceeds the limits of the device in {clipping} cases",
            felt.len(),
            least_of(shapes()),
            most(shapes()),
            each_alike.join(", ")
        ),
    )
}

/// What becomes of a texture that is sent directly.
struct Sent {
    /// The level re the texture when 1 m/s² is the full scale, dB.
    level_db: f64,
    /// The error of the spectral shape, dB rms.
    shape_db: f64,
    correlation: f64,
}

fn overlaps(felt: &[Felt]) -> Finding {
    let worst = felt
        .iter()
        .max_by(|a, b| a.rendered.error_db_rms.total_cmp(&b.rendered.error_db_rms));
    let loosest = least_of(felt.iter().map(|f| f.rendered.waveform_correlation));
    let error = worst.map_or(f64::NAN, |f| f.rendered.error_db_rms);
    let who = worst.map_or(String::new(), |f| {
        format!("{} on P{:02}", f.texture, f.participant)
    });
    Finding::of(
        21,
        Holds::all([
            at_most(
                error,
                1.0,
                "dB",
                "a spectrum error is above 1 dB rms: the force of the hand during one stroke differs from its mean during the characterisation, \
                    and a finger couples more of the motion when it presses harder",
            ),
            at_least(loosest, 0.95, "", "a waveform correlation is below 0.95"),
        ]),
        format!(
            "at most {error:.2} dB rms ({who}), correlation at least {loosest:.3}, {} cases",
            felt.len()
        ),
    )
}

/// The spectra of a verification as lines.
fn psd(label: &str, verification: &Verification, values: &[f64]) -> Line {
    let step = verification.frequency_hz.get(1).copied().unwrap_or(1.0);
    line(label, decibels(values, step, 10.0, 600.0))
}

fn figures_of(
    texture: &str,
    rendered: &Verification,
    uncompensated: &[Verification; 2],
) -> Vec<Counterpart> {
    let number = if texture == "M8" { "47" } else { "48" };
    let mut figures = vec![Counterpart::chart(
        number,
        format!(
            "{texture} on the finger of participant 1: recorded during touch, and rendered on the device."
        ),
        (frequency(), density()),
        vec![
            psd("touched", rendered, &rendered.target_psd),
            psd("rendered", rendered, &rendered.measured_psd),
        ],
    )];
    if texture == "S8" {
        let [loud, soft] = uncompensated;
        figures.insert(0, Counterpart::chart("42", "Negative control: the vibration of S8 sent directly to the device, unscaled and attenuated until nothing \
                clips.", (frequency(), density()), vec![
                psd("touched", loud, &loud.target_psd),
                psd("sent directly, unscaled", loud, &loud.measured_psd),
                psd("sent directly, attenuated", soft, &soft.measured_psd),
            ]));
    }
    figures
}

/// Figure 45: target and drive as spectra, and the transfer function between them.
fn processing(
    target: &piezotact::Series<Acceleration>,
    drive: &piezotact::render::RenderedDrive,
    function: &TransferFunction<Drive, Acceleration>,
) -> Vec<Counterpart> {
    let amplitudes = |(f, a): (Vec<f64>, Vec<f64>)| -> Vec<(f64, f64)> {
        f.into_iter()
            .zip(a)
            .filter(|(f, a)| (10.0..=1000.0).contains(f) && *a > 0.0)
            .map(|(f, a)| (f, 20.0 * a.log10()))
            .collect()
    };
    let magnitude = function
        .frequencies_hz()
        .into_iter()
        .zip(function.response())
        .filter(|(f, _)| (10.0..=1000.0).contains(f))
        .map(|(f, h)| (f, 20.0 * h.norm().log10()))
        .collect();
    vec![
        Counterpart::chart(
            "45a, vibration",
            "The vibration of S8: amplitude spectrum.",
            (frequency(), linear("amplitude, dB re 1 m/s²")),
            vec![line("", amplitudes(amplitude_spectrum(target)))],
        ),
        Counterpart::chart(
            "45a, drive",
            "The drive that renders it: amplitude spectrum.",
            (frequency(), linear("amplitude, dB re full scale")),
            vec![line("", amplitudes(amplitude_spectrum(&drive.drive)))],
        ),
        Counterpart::chart(
            "45c",
            "The transfer function from the drive to the vibration: the device with the finger of participant 1.",
            (frequency(), linear("magnitude, dB re 1 (m/s²)/full scale")),
            vec![line("", magnitude)],
        ),
    ]
}
