//! Chapter 4: rendering on the device, with everybody's own transfer function.

use piezotact::Doubt;
use piezotact::figure::Line;
use piezotact::quantity::Decibels;
use piezotact::spectrum::amplitude_spectrum;
use piezotact::verify::Verification;

use super::claims::{Finding, Holds, above, at_least, at_most, least as least_of, most};
use super::figure::{Counterpart, decibels, density, frequency, line, linear};
use super::measured::{run, take};
use super::rendering::{
    characterised, compared, device, played, rendered, resting, sent_straight, target,
};
use super::{Chapter, Replay, ReplayError, exchange, said_once};
use piezotact_twin::{ActTouch, ActiveProtocol, Movement, Pace, Participant};

/// Who takes part (*thesis* 4.3.2 has ten; five are enough for a rendering).
const PARTICIPANTS: u64 = 5;
/// One periodic and one isotropic texture, as figures 47 and 48.
const TEXTURES: [&str; 2] = ["M8", "S8"];
const SECONDS: f64 = 60.0;
const CAMPAIGNS: &str = "discrimination experiments";

/// One texture on one finger.
struct Felt {
    participant: u64,
    texture: &'static str,
    rendered: Verification,
    /// Sent as it stands, and turned down.
    straight: [Verification; 2],
    level: Decibels,
    doubts: Vec<Doubt>,
    figures: Vec<Counterpart>,
}

pub(super) fn chapter4(replay: &Replay) -> Result<Chapter, ReplayError> {
    let mut felt = Vec::new();
    for participant in 1..=PARTICIPANTS {
        let mut bench = device(replay, participant);
        let seed = replay.seed;
        let function = characterised(
            &mut bench,
            resting("characterise", 0.2, 20.0),
            SECONDS,
            seed,
        )?;
        for texture in TEXTURES {
            let sample = replay.parameters.sample(texture)?;
            let person = Participant::of(participant, seed, &replay.parameters);
            let protocol = ActiveProtocol {
                strokes: 3,
                movement: Movement::Proximal,
                pace: Pace::Metronome {
                    speed_m_s: 0.03,
                    stroke_s: None,
                },
            };
            let acttouch = ActTouch::new(&replay.parameters, person, sample, protocol)?;
            let (taken, recording) = take(
                acttouch.into_acquirer(),
                &run(replay, "chapter 4", Some(0.2)),
                1_024,
            )?;
            let target = target(&taken, &recording)?;
            let (drive, level) = rendered(&target, &function)?;
            let label = |what: &str| resting(&format!("{what} {texture}"), 0.2, 20.0);
            let measured = played(&mut bench, &drive.drive, &label("play"))?;
            let verification = compared(&target, &measured, level)?;
            let mut straight = Vec::new();
            for (drive, what) in sent_straight(&mut bench, &target)?
                .iter()
                .zip(["straight", "turned down"])
            {
                let measured = played(&mut bench, drive, &label(what))?;
                straight.push(compared(&target, &measured, Decibels(0.0))?);
            }
            let [as_it_stands, turned_down] = [straight.swap_remove(0), straight.swap_remove(0)];
            let straight = [as_it_stands, turned_down];
            let mut figures = Vec::new();
            if participant == 1 {
                figures = figures_of(texture, &verification, &straight);
                if texture == "S8" {
                    figures.extend(processing(&target, &drive, &function));
                }
            }
            let doubts: [&[Doubt]; 4] = [
                &taken.doubts,
                &drive.about.doubts,
                &measured.about.doubts,
                &verification.doubts,
            ];
            let doubts = doubts.into_iter().flatten().cloned().collect();
            felt.push(Felt {
                doubts,
                participant,
                texture,
                rendered: verification,
                straight,
                level,
                figures,
            });
        }
    }
    let exchange = exchange::exchanged_levels(replay)?;
    let findings = vec![
        wrong_strategy(&felt),
        overlaps(&felt),
        exchange.finding,
        Finding::not_yet(24, CAMPAIGNS),
        Finding::not_yet(25, CAMPAIGNS),
        Finding::not_yet(27, CAMPAIGNS),
        Finding::not_yet(28, CAMPAIGNS),
    ];
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
        ],
        findings,
        doubts: said_once(
            felt.iter()
                .flat_map(|f| f.doubts.iter().map(|d| (f.texture, d)))
                .chain(exchange.doubts.iter().map(|(sample, d)| (*sample, d))),
        ),
        figures: felt
            .into_iter()
            .flat_map(|f| f.figures)
            .chain(exchange.figures)
            .collect(),
        missing: vec![
            "Figures 50–60: discrimination experiments, which the program does not contain yet.".into(),
            "Figures 63–65: the discrimination experiment with exchanged levels, which the program does not contain yet.".into(),
        ],
    })
}

fn wrong_strategy(felt: &[Felt]) -> Finding {
    let worst = |texture: &str| {
        let theirs = felt.iter().filter(|f| f.texture == texture);
        let errors = theirs.map(|f| f.straight[0].error_db_rms);
        least_of(errors)
    };
    let [periodic, isotropic] = TEXTURES.map(worst);
    let matched: Vec<f64> = felt
        .iter()
        .map(|f| f.straight[1].error_db_rms_level_matched)
        .collect();
    let (low, high) = (least_of(matched.iter().copied()), most(matched));
    Finding::of(
        20,
        Holds::all([
            above(
                isotropic,
                10.0,
                "dB",
                "for some participant, the error of S8 is within 10 dB rms",
            ),
            above(
                periodic,
                10.0,
                "dB",
                "for some participant, the error of M8, whose power is in a few spectral lines, is within 10 dB rms",
            ),
        ]),
        format!(
            "unscaled, S8 at least {isotropic:.1}, M8 at least {periodic:.1} dB rms over {PARTICIPANTS} participants; \
                attenuated and level-matched, {low:.1} to {high:.1} dB rms"
        ),
    )
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
            at_most(error, 1.0, "dB", "a spectrum error is above 1 dB rms"),
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
    straight: &[Verification; 2],
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
        let [loud, soft] = straight;
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
    target: &piezotact::Series<piezotact::quantity::Acceleration>,
    drive: &piezotact::render::RenderedDrive,
    function: &piezotact::transfer::TransferFunction<
        piezotact::quantity::Drive,
        piezotact::quantity::Acceleration,
    >,
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
            "45a",
            "The vibration of S8 and the drive that renders it: amplitude spectra.",
            (frequency(), linear("amplitude, dB re 1 m/s² or full scale")),
            vec![
                line("vibration, m/s²", amplitudes(amplitude_spectrum(target))),
                line(
                    "drive, full scale = 1",
                    amplitudes(amplitude_spectrum(&drive.drive)),
                ),
            ],
        ),
        Counterpart::chart(
            "45c",
            "The transfer function from the drive to the vibration: the device with the finger of participant 1.",
            (frequency(), linear("magnitude, dB re 1 (m/s²)/full scale")),
            vec![line("", magnitude)],
        ),
    ]
}
