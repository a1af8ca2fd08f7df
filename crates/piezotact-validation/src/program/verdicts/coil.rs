//! A device of another kind than the twin's: a voice coil with two modes and a delay.

use std::f64::consts::TAU;

use num_complex::Complex;

use super::scene::FingerPlacement;
use super::signal::Draws;

const MODES_HZ: [f64; 2] = [65.0, 310.0];
/// How much of the force each mode takes.
const SHARES: [f64; 2] = [1.0, 0.6];
const DAMPING: [f64; 2] = [0.15, 0.35];
const COIL_HZ: f64 = 700.0;
const LATENCY_S: f64 = 0.012;
const FULL_SCALE_M_S2: f64 = 20.0;

/// From the digital drive to the nail of participant `number`, (m/s²) at full scale. People differ by some 12 % in the frequencies
/// of the modes, placements by 1 %; a heavier load makes both stiffer.
///
/// Formula: `Σ aᵢ·f²/(f² − fᵢ² − 2j·ζᵢ·fᵢ·f)·exp(−2πj·f·τ)/(1 + j·f/f_c)`.
pub(super) fn response(
    number: u64,
    seed: u64,
    lies: FingerPlacement,
) -> impl Fn(f64) -> Complex<f64> + Send + Sync + use<> {
    let mut person = Draws::of(seed, &format!("coil of {number}"));
    let mut placement = Draws::of(seed, &format!("coil of {number} {}", lies.run));
    let stiffer = (lies.load_n / 0.2).powf(0.15);
    let modes: Vec<[f64; 3]> = (0..2)
        .map(|i| {
            let hz = MODES_HZ[i] * stiffer;
            let hz = hz * (1.0 + 0.12 * person.normal()) * (1.0 + 0.01 * placement.normal());
            [hz, DAMPING[i] * person.between(1.0, 1.8), SHARES[i]]
        })
        .collect();
    let gain = FULL_SCALE_M_S2 * (0.01 * placement.normal()).exp();
    move |hz| {
        let hz = hz.max(0.5);
        let moves: Complex<f64> = modes
            .iter()
            .map(|[mode_hz, damping, share]| {
                let below =
                    Complex::new(hz * hz - mode_hz * mode_hz, -2.0 * damping * mode_hz * hz);
                share * hz * hz / below
            })
            .sum();
        gain * moves * Complex::from_polar(1.0, -TAU * hz * LATENCY_S)
            / Complex::new(1.0, hz / COIL_HZ)
    }
}
