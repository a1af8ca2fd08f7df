//! Rendering with the average transfer function of a panel for people who are not in it (*thesis* 5.2, figure 79).

use piezotact::Warning;
use piezotact::quantity::{Acceleration, Decibels, Drive};
use piezotact::statistics::mean;
use piezotact::transfer::TransferFunction;
use piezotact::verify::Verification;

use super::ReplayError;
use super::claims::{Finding, Holds, above, at_most, least, most};
use super::figure::{Counterpart, density, frequency, line};
use super::rendering::{compared, played, rendered, target};
use piezotact_twin::{ActTouch, ActiveProtocol, Pace, Participant, SlidingDirection};
use piezotact_volunteers::{Laboratory, characterised, resting, run, take};

/// Whose fingers are new to the panel of twenty.
const NEW: std::ops::RangeInclusive<u64> = 21..=25;
/// The texture of figure 79.
const TEXTURE: &str = "S7";
const SECONDS: f64 = 30.0;

/// What comes of the average.
pub(super) struct Averaged {
    pub(super) finding: Finding,
    pub(super) figure: Option<Counterpart>,
    pub(super) warnings: Vec<Warning>,
    pub(super) measured: String,
}

/// S7 rendered for new people with their own transfer function and with `average`.
pub(super) fn with_average(
    laboratory: &Laboratory,
    average: &TransferFunction<Drive, Acceleration>,
) -> Result<Averaged, ReplayError> {
    let (mut own, mut averaged, mut figure, mut warnings) =
        (Vec::new(), Vec::new(), None, Vec::new());
    let sample = laboratory.parameters.sample(TEXTURE)?;
    let protocol = ActiveProtocol {
        strokes: 3,
        movement: SlidingDirection::Proximal,
        pace: Pace::Metronome {
            speed_m_s: 0.03,
            stroke_s: None,
        },
    };
    for participant in NEW {
        let mut bench = laboratory.device(participant);
        let asked = resting("characterise", 0.2, 20.0);
        let function = characterised(&mut bench, asked, SECONDS, laboratory.seed)?;
        let person = Participant::of(participant, laboratory.seed, &laboratory.parameters);
        let acttouch = ActTouch::new(&laboratory.parameters, person, sample, protocol)?;
        let (taken, recording) = take(
            acttouch.into_acquirer(),
            &run(laboratory, "chapter 5", Some(0.2)),
            1_024,
        )?;
        let target = target(&taken, &recording)?;
        let mut felt = |function: &TransferFunction<Drive, Acceleration>,
                        what: &str|
         -> Result<Verification, ReplayError> {
            let (drive, level) = rendered(&target, function)?;
            let measured = played(
                &mut bench,
                &drive.drive,
                &resting(&format!("play {what}"), 0.2, 20.0),
            )?;
            warnings.extend(
                drive
                    .about
                    .warnings
                    .iter()
                    .chain(&measured.about.warnings)
                    .cloned(),
            );
            compared(&target, &measured, level)
        };
        let (individual, common) = (felt(&function, "own")?, felt(average, "averaged")?);
        figure.get_or_insert_with(|| drawn(&individual, &common));
        own.push(individual.error_db_rms);
        averaged.push(common.error_db_rms);
    }
    let worse = own
        .iter()
        .zip(&averaged)
        .filter(|(own, averaged)| own < averaged)
        .count();
    let finding = Finding::of(
        22,
        Holds::all([
            above(
                least(
                    own.iter()
                        .zip(&averaged)
                        .map(|(own, averaged)| averaged - own),
                ),
                0.0,
                "dB",
                "for some participant, the own transfer function gives no smaller error than the average: a finger close to the average gains less by its \
                    own than the force of the hand changes from one measurement to the next",
            ),
            at_most(
                most(averaged.iter().copied()),
                3.0,
                "dB",
                "for some participant, the average gives an error above 3 dB rms: fingers differ most at 0.2 N, and the edge of a bundle of 6 to 8 dB lies \
                    3 to 4 dB from its average",
            ),
        ]),
        format!(
            "S7 over 30–500 Hz for {} participants outside the panel: {:.2} dB rms with their own transfer function (at \
                most {:.2}), {:.2} with the average of twenty (at most {:.2}); worse for {worse} of them",
            own.len(),
            mean(&own),
            most(own.iter().copied()),
            mean(&averaged),
            most(averaged.iter().copied())
        ),
    );
    Ok(Averaged {
        finding,
        figure,
        warnings,
        measured: format!(
            "Participants {} to {}, who are not in the panel, were presented with one stroke of {TEXTURE} rendered with their \
                own transfer function and with the average of the panel at 20° and 0.2 N.",
            NEW.start(),
            NEW.end()
        ),
    })
}

fn drawn(own: &Verification, averaged: &Verification) -> Counterpart {
    let psd = |label: &str, v: &Verification, values: &[f64]| {
        let shown = v
            .frequency_hz
            .iter()
            .copied()
            .zip(values.iter().map(|p| Decibels::from_power(*p).0));
        line(
            label,
            shown
                .filter(|(hz, _)| (10.0..=1000.0).contains(hz))
                .collect(),
        )
    };
    Counterpart::chart(
        "79",
        "S7 as recorded, and as measured on a new participant when rendered with the own and with the averaged \
            transfer function.",
        (frequency(), density()),
        vec![
            psd("touched", own, &own.target_psd),
            psd("own transfer function", own, &own.measured_psd),
            psd("averaged", averaged, &averaged.measured_psd),
        ],
    )
}
