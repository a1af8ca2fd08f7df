//! Textures of any duration: a passage without onset and end, at one speed and one force.

use piezotact::quantity::{Acceleration, Newtons, Seconds};
use piezotact::recording::{BenchKind, Condition, Provenance, Touch};
use piezotact::series::{Series, SeriesError};

use super::RATE_HZ;
use super::parameters::{Sample, TwinParameters};
use super::participant::Participant;
use super::protocol::SlidingDirection;
use super::session::rate;
use super::texture::Texture;

/// The acceleration of the nail of `participant` for `duration` while `sample` passes under the finger at
/// `speed_m_s`, above 0, with 0.2 N, longer than any real stroke and without the influence of the person's own finger on a
/// bench; with its condition and provenance. The profile is random: two participants or seeds never give the same.
///
/// # Errors
/// [`SeriesError::Empty`] when the duration holds no sample.
pub fn record_texture(
    parameters: &TwinParameters,
    participant: &Participant,
    sample: &Sample,
    speed_m_s: f64,
    duration: Seconds,
) -> Result<(Series<Acceleration>, Condition, Provenance), SeriesError> {
    let load_n = parameters.texture.reference_load_n;
    let mut texture = Texture::of(
        parameters,
        participant,
        sample,
        SlidingDirection::Proximal,
        RATE_HZ,
    );
    let random = participant.random(&format!("texture {}", sample.name));
    let mut passage = texture.passage(speed_m_s * duration.0, speed_m_s, random);
    let samples = (0..rate().samples_in(duration))
        .map(|i| passage.next(speed_m_s, load_n, speed_m_s * i as f64 / RATE_HZ))
        .collect();
    let condition = Condition {
        sample: Some(sample.name.clone()),
        participant: Some(participant.pseudonym()),
        twin_seed: Some(participant.seed),
        load_n: Some(Newtons(load_n)),
        speed_m_s: Some(speed_m_s),
        touch: Some(Touch::Passive),
        ..Condition::default()
    };
    let provenance = Provenance {
        source: "digital twin, passive touch".into(),
        bench: Some(BenchKind::Twin),
        seed: Some(participant.seed),
        steps: vec![
            format!(
                "texture {} at {} mm/s, fingerprint at {:.1} Hz",
                sample.name,
                speed_m_s * 1e3,
                speed_m_s / participant.skin.ridge_wavelength_m
            ),
            parameters.provenance(),
        ],
        ..Provenance::default()
    };
    Ok((Series::new(samples, rate())?, condition, provenance))
}
