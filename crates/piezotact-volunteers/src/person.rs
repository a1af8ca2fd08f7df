//! A virtual volunteer: the strokes on the real samples, the transfer function, the drives, and the sense of touch.

use crate::VolunteerError;
use std::collections::BTreeMap;

use piezotact::correct::CorrectConfig;
use piezotact::feature::vibrations;
use piezotact::filter::HighPass;
use piezotact::lineage::{Level, Mode};
use piezotact::manipulate::Texture;
use piezotact::prepare::{State, common_level};
use piezotact::quantity::{
    Acceleration, Band, Decibels, Degrees, Drive, Hertz, Newtons, SampleRate, Unit,
};
use piezotact::recording::{Channel, Condition, Recording};
use piezotact::render::{RenderConfig, RenderError, Rendering, at_fitting_level, render};
use piezotact::run::Discard;
use piezotact::series::Series;
use piezotact::statistics::random::Random;
use piezotact::transfer::TransferFunction;
use piezotact_bench::procedure::{ACCELERATION_CHANNEL, LoopConfig, closed_loop};
use piezotact_bench::{Bench, GateConfig, ProcedureError};
use piezotact_people::campaign::chain::Sha;
use piezotact_people::campaign::protocol::Protocol;
use piezotact_people::judge::{Cues, OnSurface, Pattern, Touch};
use piezotact_study::session::PreparedDrive;
use piezotact_twin::{
    ActTouch, ActiveProtocol, Pace, Participant, Relief, Sample, SlidingDirection,
};

use crate::sitting::delivered;
use crate::{
    Laboratory, LevelRule, STROKE_SEGMENT, Simulation, Taken, characterised, resting, run, take,
};

/// The band in which textures are rendered and felt, Hz.
const BAND_HZ: [f64; 2] = [20.0, 1000.0];
/// The normal force, N, and the angle between finger and surface (*thesis* 5.1.2).
pub(super) const LOAD_N: f64 = 0.2;
pub(super) const ANGLE_DEG: f64 = 20.0;
/// The rate of the drives, Hz.
const DRIVE_RATE_HZ: f64 = 48_000.0;
/// A closed loop keeps its drives this much below the limit of the device.
const LOOP_MARGIN: Decibels = Decibels(0.3);
/// How often a drive is measured whose measurement is not reliable.
const MOST_ATTEMPTS: u32 = 5;
/// The speed of the strokes, m/s (*thesis* 3.2).
const SPEED_M_S: f64 = 0.03;

/// Whose transfer function the drives are rendered with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Whose {
    /// The one that the protocol says: the volunteer's own, or the average of a panel.
    Own,
    /// That of another volunteer: what a mistake in the laboratory does.
    Of(u64),
}

/// A virtual volunteer, ready for the sessions of a campaign.
#[derive(Debug)]
pub struct VirtualVolunteer {
    /// The number under the seed.
    pub number: u64,
    pub pseudonym: String,
    /// The sense of touch.
    pub touch: Touch,
    /// What the fingernail says of each real sample, by its name in the protocol; the volunteer gets the cues alone.
    pub real: BTreeMap<String, Cues>,
    /// The lasting bias of each real sample's level, in the natural logarithm of rms.
    pub bias: BTreeMap<String, f64>,
    /// The drives of all stimuli.
    pub drives: BTreeMap<String, PreparedDrive>,
    /// How much lower the rendered textures are felt than the real samples as a whole, in the natural logarithm of rms: by the
    /// measurements with which the drives were verified. A person who has felt both discounts it.
    pub offset: f64,
    /// The level at which all textures are rendered, dB; absent where each has its own.
    pub level_db: Option<f64>,
}

/// What was touched of a sample.
struct Touched {
    cues: Cues,
    target: Series<Acceleration>,
    recording: Recording,
}

/// Volunteer `number` of `simulation`, after the measurement session and with all drives, each verified.
///
/// # Errors
/// [`VolunteerError`] with the first thing that the twin does not have or cannot do.
pub fn volunteer(
    simulation: &Simulation<'_>,
    number: u64,
    whose: Whose,
) -> Result<VirtualVolunteer, VolunteerError> {
    let laboratory = Laboratory {
        parameters: simulation.parameters.clone(),
        seed: simulation.seed,
    };
    let protocol = simulation.protocol;
    if let (Some(panel), None) = (simulation.panel(), &simulation.average) {
        let panel = panel.to_owned();
        return Err(VolunteerError::Average { panel });
    }
    let mut touched = BTreeMap::new();
    for name in &protocol.samples {
        touched.insert(name.clone(), touch(simulation, &laboratory, number, name)?);
    }
    let mut bench = laboratory.device(number);
    let drives = match &protocol.rendering {
        None => (BTreeMap::new(), None),
        Some(_) => {
            let function = function(simulation, &laboratory, number, whose)?;
            prepared(simulation, &touched, &function, &mut bench)?
        }
    };
    let (drives, level_db) = drives;
    let person = Participant::of(number, simulation.seed, &simulation.parameters);
    let mut bias = BTreeMap::new();
    for name in touched.keys() {
        let mut random = Random::stream(simulation.seed, number, &format!("touch of {name}"));
        bias.insert(
            name.clone(),
            simulation.touch.texture_bias * random.normal(),
        );
    }
    let offset = offset(&touched, &drives);
    Ok(VirtualVolunteer {
        number,
        pseudonym: person.pseudonym(),
        touch: simulation.touch,
        real: touched
            .into_iter()
            .map(|(name, touched)| (name, touched.cues))
            .collect(),
        bias,
        drives: drives
            .into_iter()
            .map(|(name, (drive, _))| (name, drive))
            .collect(),
        offset,
        level_db,
    })
}

/// The transfer function that drives for volunteer `number` are rendered with.
fn function(
    simulation: &Simulation<'_>,
    laboratory: &Laboratory,
    number: u64,
    whose: Whose,
) -> Result<TransferFunction<Drive, Acceleration>, VolunteerError> {
    let of = match (whose, simulation.panel(), &simulation.average) {
        (Whose::Of(other), ..) => other,
        (Whose::Own, Some(_), Some(average)) => return Ok(average.clone()),
        (Whose::Own, ..) => number,
    };
    let asked = resting("characterise", LOAD_N, ANGLE_DEG);
    characterised(
        &mut laboratory.device(of),
        asked,
        simulation.excitation_s,
        simulation.seed,
    )
}

/// The band in which textures are rendered and felt.
pub(super) fn band() -> Result<Band, VolunteerError> {
    Ok(Band::new(Hertz(BAND_HZ[0]), Hertz(BAND_HZ[1]))?)
}

/// The strokes of volunteer `number` on the sample `name`.
fn touch(
    simulation: &Simulation<'_>,
    laboratory: &Laboratory,
    number: u64,
    name: &str,
) -> Result<Touched, VolunteerError> {
    let person = Participant::of(number, simulation.seed, &simulation.parameters);
    let what = || format!("{name}, touched by {}", person.pseudonym());
    let protocol = ActiveProtocol {
        strokes: simulation.strokes as usize,
        movement: SlidingDirection::Proximal,
        pace: Pace::Metronome {
            speed_m_s: SPEED_M_S,
            stroke_s: None,
        },
    };
    let (sample, taken, recording) = match simulation.recorded.get(name) {
        Some((taken, recording)) => {
            let mut recording = recording.clone();
            // The volunteer stands for whoever touched it.
            recording.about.condition.participant = Some(person.pseudonym());
            (None, taken.clone(), recording)
        }
        None => {
            let sample = simulation.surface(name)?;
            let acttouch = ActTouch::new(&laboratory.parameters, person.clone(), sample, protocol);
            let asked = run(laboratory, "measurement session", Some(LOAD_N));
            let (taken, recording) = take(acttouch?.into_acquirer(), &asked, STROKE_SEGMENT)?;
            (Some(sample), taken, recording)
        }
    };
    let strokes = strokes(&taken, &recording)?;
    let cues = strokes.iter().map(|stroke| {
        Cues::of(stroke, band()?).map_err(|error| VolunteerError::Cues {
            what: what(),
            error: Box::new(error),
        })
    });
    let cues: Vec<Cues> = cues.collect::<Result<_, VolunteerError>>()?;
    let target = typical(&strokes, &cues);
    let (Some(cues), Some(target)) = (mean(&cues), target) else {
        return Err(VolunteerError::NoStroke { what: what() });
    };
    Ok(Touched {
        cues: cues.on(surface(sample, &taken)),
        target,
        recording,
    })
}

/// The steady parts of all strokes, freed of the gesture.
fn strokes(
    taken: &Taken,
    recording: &Recording,
) -> Result<Vec<Series<Acceleration>>, VolunteerError> {
    let what = recording.about.condition.to_string();
    let freed = vibrations(recording, &taken.segmentation, Some(HighPass::gesture()));
    let freed = freed.map_err(|error| VolunteerError::Feature {
        what,
        error: Box::new(error),
    })?;
    let Some(channel) = freed.channels.first() else {
        return Ok(Vec::new());
    };
    let strokes = taken.segmentation.strokes.iter();
    let strokes = strokes.map(|stroke| {
        let samples = stroke.steady.of(channel).to_vec();
        Ok(Series::new(samples, recording.rate())?)
    });
    strokes.collect()
}

/// The cues of all strokes together: the means of power, of bands in dB, and of the logarithm of the centroid.
fn mean(cues: &[Cues]) -> Option<Cues> {
    let first = cues.first()?;
    let count = cues.len() as f64;
    let of = |value: &dyn Fn(&Cues) -> f64| cues.iter().map(value).sum::<f64>() / count;
    Some(Cues {
        ln_rms: 0.5 * of(&|one| (2.0 * one.ln_rms).exp()).ln(),
        bands_db: std::array::from_fn(|i| of(&|one| one.bands_db[i])),
        ln_centroid: of(&|one| one.ln_centroid),
        ..first.clone()
    })
}

/// The stroke whose level is the median.
fn typical(strokes: &[Series<Acceleration>], cues: &[Cues]) -> Option<Series<Acceleration>> {
    let mut places: Vec<usize> = (0..strokes.len()).collect();
    places.sort_by(|a, b| cues[*a].ln_rms.total_cmp(&cues[*b].ln_rms));
    let middle = places.get(places.len() / 2)?;
    strokes.get(*middle).cloned()
}

/// What a real surface tells beside its vibration: its elements, where they are known, and the friction that was measured.
fn surface(sample: Option<&Sample>, taken: &Taken) -> OnSurface {
    let known = sample.map(|sample| (&sample.relief, sample.comb_wavelength_m));
    let (period_m, pattern) = match known {
        Some((_, Some(period_m))) => (period_m, Pattern::Regular),
        Some((Relief::Isotropic { grain_m, .. }, None)) => (*grain_m, Pattern::Random),
        Some((_, None)) | None => (0.0, Pattern::Random),
    };
    let strokes = &taken.analysis.strokes;
    let friction = strokes.iter().filter_map(|one| one.friction_coefficient);
    let friction: Vec<f64> = friction.map(|friction| friction.median).collect();
    let count = friction.len() as f64;
    OnSurface {
        period_m,
        pattern,
        friction: (count > 0.0).then(|| friction.iter().sum::<f64>() / count),
    }
}

/// A drive with the cues of the measurement that it was verified with.
type Verified = (PreparedDrive, Option<Cues>);

/// The drives of all stimuli, rendered with `function` and verified on `bench`, and their common level.
fn prepared(
    simulation: &Simulation<'_>,
    touched: &BTreeMap<String, Touched>,
    function: &TransferFunction<Drive, Acceleration>,
    bench: &mut Bench,
) -> Result<(BTreeMap<String, Verified>, Option<f64>), VolunteerError> {
    let rate = SampleRate::new(DRIVE_RATE_HZ)?;
    let config = RenderConfig::over(band()?, rate);
    let mut targets = BTreeMap::new();
    for stimulus in stimuli(simulation.protocol) {
        let target = target(simulation.protocol, touched, stimulus)?;
        targets.insert(stimulus, target);
    }
    // A level in dB re 1 m/s² is rendered as it is, whatever the others need.
    let is_stated = |stimulus: &str| {
        let made = simulation.protocol.stimulus(stimulus);
        made.is_some_and(|made| made.rms_db.is_some())
    };
    let relative = targets.iter().filter(|(stimulus, _)| !is_stated(stimulus));
    let all: Vec<Series<Acceleration>> = relative.map(|(_, (series, _))| series.clone()).collect();
    let common = match simulation.level {
        LevelRule::Common => Some(common_level(&all, function, &config, LOOP_MARGIN).level_db),
        LevelRule::Stated(level) => Some(level.0),
        LevelRule::Fit => None,
    };
    let mut drives = BTreeMap::new();
    for (stimulus, (series, recording)) in targets {
        let level = match common {
            _ if is_stated(stimulus) => Decibels(0.0),
            Some(level_db) => Decibels(level_db),
            None => fitting(&series, function, &config),
        };
        let drive = looped(
            simulation,
            (stimulus, &series, recording, level),
            (function, &config),
            bench,
        )?;
        drives.insert(stimulus.to_owned(), drive);
    }
    Ok((drives, common))
}

/// The highest level at which `series` fits, with the margin of a closed loop.
fn fitting(
    series: &Series<Acceleration>,
    function: &TransferFunction<Drive, Acceleration>,
    config: &RenderConfig,
) -> Decibels {
    let (level, _) = at_fitting_level(
        |level| render(&series.clone().amplified(level), function, config),
        RenderError::fits_at,
    );
    match level.0 < 0.0 {
        true => Decibels(level.0 - LOOP_MARGIN.0),
        false => level,
    }
}

/// All names that a protocol plays.
fn stimuli(protocol: &Protocol) -> impl Iterator<Item = &str> {
    let made = protocol.stimuli.iter().map(|stimulus| &*stimulus.name);
    protocol.samples.iter().map(String::as_str).chain(made)
}

/// The texture of `stimulus`, at its own level or at that of another sample, and the recording that it comes from.
fn target<'a>(
    protocol: &Protocol,
    touched: &'a BTreeMap<String, Touched>,
    stimulus: &str,
) -> Result<(Series<Acceleration>, &'a Recording), VolunteerError> {
    let unknown = || VolunteerError::Stimulus {
        stimulus: stimulus.to_owned(),
    };
    let made = protocol.stimulus(stimulus).ok_or_else(unknown)?;
    let textures: BTreeMap<&String, Texture<Acceleration>> = (made.samples())
        .filter_map(|sample| {
            let texture = Texture::of(sample, touched.get(sample)?.target.clone());
            Some((sample, texture))
        })
        .collect();
    let of = |sample: &str| textures.iter().find(|(name, _)| **name == sample);
    let measured = Level::Within(band()?);
    let texture = made.texture(|sample| of(sample).map(|(_, texture)| texture), measured);
    let texture = texture.map_err(|error| VolunteerError::Making {
        stimulus: stimulus.to_owned(),
        error: Box::new(error),
    })?;
    let own = touched.get(&made.of).ok_or_else(unknown)?;
    Ok((texture.series, &own.recording))
}

/// The drive for a texture, corrected in a closed loop and confirmed.
fn looped(
    simulation: &Simulation<'_>,
    (stimulus, series, recording, level): (&str, &Series<Acceleration>, &Recording, Decibels),
    (function, render): (&TransferFunction<Drive, Acceleration>, &RenderConfig),
    bench: &mut Bench,
) -> Result<Verified, VolunteerError> {
    let mut config = LoopConfig {
        render: render.clone(),
        correct: CorrectConfig::usual(Mode::Texture),
        judged: band()?,
        // With the average of a panel nobody's finger is on the device before the session.
        iterations: match simulation.panel() {
            Some(_) => 0,
            None => simulation.iterations,
        },
        force_share: GateConfig::usual().force_share,
        run: resting(&format!("prepare {stimulus}"), LOAD_N, ANGLE_DEG),
    };
    let wanted = series.clone().amplified(level);
    let label = config.run.label.clone();
    let looped = attempted(|attempt| {
        config.run.label = match attempt {
            1 => label.clone(),
            again => format!("{label}, attempt {again}"),
        };
        closed_loop(bench, &wanted, function, &config, &mut Discard, &mut |_| {})
    });
    let looped = looped.map_err(|error| VolunteerError::Drive {
        stimulus: stimulus.to_owned(),
        error: Box::new(error),
    })?;
    let verification = looped.best_verification().clone();
    // What cannot be compared is not felt either.
    let cues = delivered(&looped.recording, config.judged).ok();
    let rendered = looped.rendered;
    let bytes = rendered
        .drive
        .samples()
        .iter()
        .flat_map(|x| x.to_le_bytes());
    let drive = PreparedDrive {
        sha: Sha::of(&bytes.collect::<Vec<u8>>()),
        setup: rendered.setup.clone(),
        rendering: Some(Rendering::of(&rendered, stimulus, level.0)),
        drive: rendered.drive.clone(),
        target: alone(series, recording)?,
        texture: series.clone(),
        verified: State::of(&verification).outcome(),
    };
    Ok((drive, cues))
}

/// What `of` gives in the first attempt whose measurement is reliable: a finger that does not hold its force is put down once more, as in a
/// laboratory. The last refusal after [`MOST_ATTEMPTS`].
fn attempted<T>(mut of: impl FnMut(u32) -> Result<T, ProcedureError>) -> Result<T, ProcedureError> {
    let mut attempt = 1;
    loop {
        match of(attempt) {
            Err(ProcedureError::Broken(_)) if attempt < MOST_ATTEMPTS => attempt += 1,
            ended => return ended,
        }
    }
}

/// A texture as a recording of its own.
fn alone(series: &Series<Acceleration>, of: &Recording) -> Result<Recording, VolunteerError> {
    let channel = Channel {
        name: ACCELERATION_CHANNEL.into(),
        unit: Unit::MetrePerSecondSquared,
        samples: series.samples().to_vec(),
    };
    let condition = Condition {
        load_n: Some(Newtons(LOAD_N)),
        angle_deg: Some(Degrees(ANGLE_DEG)),
        ..of.about.condition.clone()
    };
    let provenance = of.about.provenance.clone();
    let alone = Recording::new(vec![channel], series.rate(), condition, provenance);
    Ok(alone.map_err(ProcedureError::from)?)
}

/// How much lower the verified drives are felt than the real samples as a whole.
fn offset(touched: &BTreeMap<String, Touched>, drives: &BTreeMap<String, Verified>) -> f64 {
    // Of the same textures on both sides.
    let both = touched.iter().filter_map(|(name, touched)| {
        let felt = drives.get(name)?.1.as_ref()?;
        Some(felt.ln_rms - touched.cues.ln_rms)
    });
    let both: Vec<f64> = both.collect();
    match both.len() {
        0 => 0.0,
        count => both.iter().sum::<f64>() / count as f64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact_bench::DeviceError;

    #[test]
    fn an_unreliable_measurement_is_repeated_and_any_other_error_is_not() {
        let broken = || ProcedureError::Broken("the force was not held".into());
        let tries = |good_from: u32| {
            let mut count = 0;
            let ended = attempted(|attempt| {
                count += 1;
                if attempt < good_from {
                    Err(broken())
                } else {
                    Ok(attempt)
                }
            });
            (ended.ok(), count)
        };
        assert_eq!(tries(1), (Some(1), 1));
        assert_eq!(tries(3), (Some(3), 3));
        assert_eq!(tries(99), (None, MOST_ATTEMPTS));
        let mut count = 0;
        let ended: Result<(), _> = attempted(|_| {
            count += 1;
            Err(ProcedureError::Device(DeviceError::Impossible {
                expected: "a".into(),
                found: "b".into(),
                todo: "c".into(),
            }))
        });
        assert!(ended.is_err() && count == 1);
    }
}
