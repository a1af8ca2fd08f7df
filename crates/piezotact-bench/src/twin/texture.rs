//! A recorded texture vibration: what the fingernail does while a finger slides over an isotropic surface.

use num_complex::Complex;
use piezotact::quantity::{Acceleration, Newtons, SampleRate, Seconds};
use piezotact::recording::{BenchKind, Condition, Provenance, Touch};
use piezotact::series::{Series, SeriesError, rms};
use realfft::RealFftPlanner;

use crate::random::Random;

/// An isotropic surface under a sliding finger: a broad spectrum and the comb of the fingerprint.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureParameters {
    /// The sample's name.
    pub sample: String,
    /// The rms acceleration at 30 mm/s and 0.2 N, m/s².
    pub rms_m_s2: f64,
    /// The share of the power in the fingerprint's comb, 0–1.
    pub fingerprint_share: f64,
    /// The sliding speed, m/s.
    pub speed_m_s: f64,
    /// The distance between fingerprint ridges, m.
    pub ridge_wavelength_m: f64,
}

impl TextureParameters {
    /// Sample S8 (P800 paper, Ra 5.2 µm, *thesis* Table 3) at 30 mm/s: 0.74 m/s² rms and 10 % in the comb
    /// (*chosen*: within what the thesis' text says of its level), ridges 0.545 mm apart (*thesis* 3.2.3).
    #[must_use]
    pub fn s8() -> Self {
        Self {
            sample: "S8".into(),
            rms_m_s2: 0.74,
            fingerprint_share: 0.10,
            speed_m_s: 0.03,
            ridge_wavelength_m: 0.545e-3,
        }
    }

    /// The one-sided PSD's shape at `frequency_hz`, not scaled: (1 − η)·B + η·P, both of unit power by sums.
    fn shapes(&self, frequency_hz: f64) -> (f64, f64) {
        // Corners move slightly with speed (*chosen*).
        let faster = (self.speed_m_s / 0.03).powf(0.35);
        let rise = (frequency_hz / (45.0 * faster)).powi(2);
        let broad = rise / (1.0 + rise) / (1.0 + (frequency_hz / (220.0 * faster)).powi(4));
        let ridge_hz = self.speed_m_s / self.ridge_wavelength_m;
        let comb = [1.0, 0.35, 0.15, 0.07]
            .iter()
            .zip(1..)
            .map(|(strength, n)| {
                let centre_hz = f64::from(n) * ridge_hz;
                let away = (frequency_hz - centre_hz) / (0.12 * centre_hz);
                strength * (-0.5 * away * away).exp() / centre_hz
            })
            .sum();
        (broad, comb)
    }
}

/// The acceleration that the nail shows for `duration` at `rate` while the finger slides, with its condition
/// and provenance. Random phases and χ²-distributed bins: two recordings of a surface are never the same.
///
/// # Errors
/// [`SeriesError::Empty`] when the duration holds no sample.
pub fn record_texture(
    texture: &TextureParameters,
    duration: Seconds,
    rate: SampleRate,
    participant: u64,
    seed: u64,
) -> Result<(Series<Acceleration>, Condition, Provenance), SeriesError> {
    let n = rate.samples_in(duration).max(1);
    let frequencies = (0..=n / 2).map(|k| k as f64 * rate.hz() / n as f64);
    let shapes: Vec<(f64, f64)> = frequencies.map(|f| texture.shapes(f)).collect();
    let (broad, comb) = shapes
        .iter()
        .fold((0.0, 0.0), |(b, c), (x, y)| (b + x, c + y));
    let mut random = Random::stream(seed, participant, &format!("texture {}", texture.sample));
    let share = texture.fingerprint_share;
    let mut bins: Vec<Complex<f64>> = shapes
        .iter()
        .map(|(b, c)| {
            let power = (1.0 - share) * b / broad + share * c / comb;
            Complex::new(random.normal(), random.normal()) * power.sqrt()
        })
        .collect();
    bins[0] = Complex::default();
    if n.is_multiple_of(2) {
        bins[n / 2] = Complex::default();
    }
    let plan = RealFftPlanner::new().plan_fft_inverse(n);
    let mut samples = plan.make_output_vec();
    let done = plan.process(&mut bins, &mut samples);
    debug_assert!(done.is_ok());
    let level = texture.rms_m_s2 / rms(&samples).max(f64::MIN_POSITIVE);
    for sample in &mut samples {
        *sample *= level;
    }
    let condition = Condition {
        sample: Some(texture.sample.clone()),
        participant: Some(format!("P{participant:02}")),
        load_n: Some(Newtons(0.2)),
        speed_m_s: Some(texture.speed_m_s),
        touch: Some(Touch::Passive),
        ..Condition::default()
    };
    let provenance = Provenance {
        source: "digital twin, passive touch".into(),
        bench: Some(BenchKind::Twin),
        seed: Some(seed),
        steps: vec![format!(
            "texture {} at {} mm/s, fingerprint at {:.1} Hz",
            texture.sample,
            texture.speed_m_s * 1e3,
            texture.speed_m_s / texture.ridge_wavelength_m
        )],
    };
    Ok((Series::new(samples, rate)?, condition, provenance))
}
