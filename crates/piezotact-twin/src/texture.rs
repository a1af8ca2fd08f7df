//! How a fingernail vibrates while the finger slides: a broad spectrum, the comb of the fingerprint, and the
//! texture's own comb.
//!
//! a(t) = RMS·(w/v₀)^α·(N/N₀)^β·[√(1 − η)·b(t) + √η·p(x(t))], with the slip speed w, the normal force N, a broad
//! stationary noise b and a random profile p along the path x. Peaks are fixed in space, so their frequencies scale with speed;
//! the broad part depends on speed only slightly.

use std::f64::consts::TAU;
use std::sync::Arc;

use num_complex::Complex;
use piezotact_fourier::{ComplexToReal, RealPlanner};

use super::parameters::{Sample, TextureModel, TwinParameters};
use super::participant::Participant;
use super::protocol::SlidingDirection;
use piezotact_bench::random::Random;

/// The fastest that peaks of a comb are made for, Hz at the reference speed: nothing beyond is felt.
const HIGHEST_TOOTH_HZ: f64 = 1_500.0;
/// Nothing above this passes the acquisition, Hz.
const HIGHEST_HZ: f64 = 2_200.0;
/// Points of the way for the shortest wave of the profile.
const POINTS_PER_WAVE: f64 = 8.0;
/// Samples of the broad noise that are discarded at its start, until its filters have settled.
const WARM_UP: usize = 1_000;

/// One finger on one sample.
#[derive(Clone)]
pub(crate) struct Texture {
    level_m_s2: f64,
    broad_share: f64,
    /// Peaks along the way: waves per metre, width (standard deviation) in waves per metre, share of the power.
    teeth: Vec<[f64; 3]>,
    model: TextureModel,
    rate_hz: f64,
    plan: Option<(usize, Arc<dyn ComplexToReal<f64>>)>,
}

impl std::fmt::Debug for Texture {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Texture")
            .field("level_m_s2", &self.level_m_s2)
            .field("broad_share", &self.broad_share)
            .field("teeth", &self.teeth)
            .finish_non_exhaustive()
    }
}

impl Texture {
    pub(crate) fn of(
        parameters: &TwinParameters,
        participant: &Participant,
        sample: &Sample,
        movement: SlidingDirection,
        rate_hz: f64,
    ) -> Self {
        let model = parameters.texture.clone();
        let (level, widening) = match movement {
            SlidingDirection::Proximal => (1.0, 1.0),
            SlidingDirection::Distal => (model.distal_level, 1.0),
            SlidingDirection::Transversal | SlidingDirection::Circular => {
                (model.direction_level, model.direction_width)
            }
        };
        let mut teeth = Vec::new();
        let all: f64 = model.ridge_teeth.iter().sum();
        for (power, n) in model.ridge_teeth.iter().zip(1..) {
            let waves = f64::from(n) / participant.skin.ridge_wavelength_m;
            let share = sample.ridge_share * power / all.max(f64::MIN_POSITIVE);
            teeth.push([waves, model.ridge_width * widening * waves, share]);
        }
        if let Some(wavelength_m) = sample.comb_wavelength_m {
            let fits = HIGHEST_TOOTH_HZ * wavelength_m / model.reference_speed_m_s;
            let count = model.comb_teeth.min(fits).max(1.0) as i32;
            let power = |n: i32| f64::from(n).powf(-model.comb_decay);
            let all: f64 = (1..=count).map(power).sum();
            for n in 1..=count {
                let waves = f64::from(n) / wavelength_m;
                let share = sample.comb_share * power(n) / all;
                teeth.push([waves, model.comb_width * widening * waves, share]);
            }
        }
        teeth.retain(|[_, _, share]| *share > 0.0);
        Self {
            level_m_s2: level * participant.level_m_s2(sample),
            broad_share: 1.0 - teeth.iter().map(|[_, _, share]| share).sum::<f64>(),
            teeth,
            model,
            rate_hz,
            plan: None,
        }
    }

    /// A random passage over `length_m` of the surface at about `speed_m_s`; a different one at each call.
    pub(crate) fn passage(&mut self, length_m: f64, speed_m_s: f64, mut random: Random) -> Passage {
        // Content that the acquisition's anti-alias filter would remove is not generated.
        let finest = HIGHEST_HZ / speed_m_s.max(f64::MIN_POSITIVE);
        let profile = self.profile(length_m, finest, &mut random);
        let faster =
            (speed_m_s.max(1e-4) / self.model.reference_speed_m_s).powf(self.model.shift_exponent);
        let mut broad = Broad::new(
            self.model.rise_hz * faster,
            self.model.fall_hz * faster,
            self.rate_hz,
            self.broad_share.max(0.0).sqrt(),
            random,
        );
        for _ in 0..WARM_UP {
            broad.next();
        }
        Passage {
            level_m_s2: self.level_m_s2,
            speed_exponent: self.model.speed_exponent,
            force_exponent: self.model.force_exponent,
            per_speed: 1.0 / self.model.reference_speed_m_s,
            per_load: 1.0 / self.model.reference_load_n,
            profile,
            broad,
        }
    }

    /// A random profile of the peaks along the way below `finest` waves per metre, its variance their share of the
    /// power.
    fn profile(&mut self, length_m: f64, finest: f64, random: &mut Random) -> Profile {
        let teeth = || {
            let passes = |[waves, width, _]: &&[f64; 3]| waves + 3.0 * width < finest;
            self.teeth.iter().filter(passes)
        };
        let shortest = teeth()
            .map(|[waves, width, _]| waves + 3.0 * width)
            .fold(0.0, f64::max);
        if shortest <= 0.0 {
            return Profile {
                heights: Vec::new(),
                per_step: 0.0,
            };
        }
        let step_m = 1.0 / (POINTS_PER_WAVE * shortest);
        let points = ((length_m / step_m).ceil() as usize)
            .next_power_of_two()
            .max(64);
        let plan = match &self.plan {
            Some((size, plan)) if *size == points => Arc::clone(plan),
            _ => {
                let plan = RealPlanner::new().plan_fft_inverse(points);
                self.plan = Some((points, Arc::clone(&plan)));
                plan
            }
        };
        let line = 1.0 / (points as f64 * step_m);
        let mut bins = plan.make_input_vec();
        for [waves, width, share] in teeth() {
            let reach = 4.0 * width.max(line);
            let from = (((waves - reach) / line).floor().max(1.0)) as usize;
            let to = ((((waves + reach) / line).ceil()) as usize).min(points / 2 - 1);
            let density = |k: usize| {
                let away = (k as f64 * line - waves) / width.max(line);
                (-0.5 * away * away).exp()
            };
            let all: f64 = (from..=to).map(density).sum();
            for (k, bin) in bins.iter_mut().enumerate().take(to + 1).skip(from) {
                // A real signal of bins c + conj(c) has four times their variance a component.
                let amplitude = 0.5 * (share * density(k) / all).sqrt();
                *bin += Complex::new(random.normal(), random.normal()) * amplitude;
            }
        }
        let mut heights = plan.make_output_vec();
        let done = plan.process(&mut bins, &mut heights);
        debug_assert!(done.is_ok());
        Profile {
            heights,
            per_step: 1.0 / step_m,
        }
    }
}

/// One passage of a finger over a surface.
#[derive(Clone, Debug)]
pub(crate) struct Passage {
    level_m_s2: f64,
    speed_exponent: f64,
    force_exponent: f64,
    per_speed: f64,
    per_load: f64,
    profile: Profile,
    broad: Broad,
}

impl Passage {
    /// The nail's acceleration, m/s², where the finger slips at `slip_m_s` under `force_n`, `way_m` along.
    pub(crate) fn next(&mut self, slip_m_s: f64, force_n: f64, way_m: f64) -> f64 {
        let unit = self.broad.next() + self.profile.at(way_m);
        if slip_m_s <= 0.0 || force_n <= 0.0 {
            return 0.0;
        }
        let faster = slip_m_s * self.per_speed;
        // The exponent is almost always 1, and a power is expensive to compute.
        let louder = if self.speed_exponent == 1.0 {
            faster
        } else {
            faster.powf(self.speed_exponent)
        };
        self.level_m_s2 * louder * (force_n * self.per_load).powf(self.force_exponent) * unit
    }
}

/// Heights at equal steps along a way that closes on itself, without a unit.
#[derive(Clone, Debug)]
struct Profile {
    heights: Vec<f64>,
    per_step: f64,
}

impl Profile {
    /// Between the points by the cubic of Catmull and Rom (1974).
    fn at(&self, way_m: f64) -> f64 {
        let n = self.heights.len();
        if n == 0 {
            return 0.0;
        }
        let place = way_m * self.per_step;
        let whole = place.floor();
        let t = place - whole;
        let mask = n - 1;
        let i = whole as i64 as usize;
        let [a, b, c, d] = [i.wrapping_sub(1), i, i.wrapping_add(1), i.wrapping_add(2)]
            .map(|i| self.heights[i & mask]);
        b + 0.5 * t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)))
    }
}

/// White noise through a first-order high-pass and a second-order Butterworth low-pass.
#[derive(Clone, Debug)]
struct Broad {
    random: Random,
    gain: f64,
    high: [f64; 2],
    low: [f64; 3],
    before: [f64; 2],
    state: [f64; 2],
}

impl Broad {
    fn new(rise_hz: f64, fall_hz: f64, rate_hz: f64, rms: f64, random: Random) -> Self {
        let warp = |hz: f64| (std::f64::consts::PI * (hz / rate_hz).min(0.49)).tan();
        let k = warp(rise_hz);
        let high = [1.0 / (1.0 + k), (1.0 - k) / (1.0 + k)];
        let g = warp(fall_hz);
        let scale = 1.0 / (1.0 + std::f64::consts::SQRT_2 * g + g * g);
        let low = [
            g * g * scale,
            2.0 * (g * g - 1.0) * scale,
            (1.0 - std::f64::consts::SQRT_2 * g + g * g) * scale,
        ];
        let mut broad = Self {
            random,
            gain: 1.0,
            high,
            low,
            before: [0.0; 2],
            state: [0.0; 2],
        };
        // The mean of |H|² over the circle is the variance that white noise of variance 1 comes out with.
        const LINES: usize = 4_096;
        let power: f64 = (0..LINES)
            .map(|i| {
                broad
                    .response((i as f64 + 0.5) / (2.0 * LINES as f64))
                    .norm_sqr()
            })
            .sum::<f64>()
            / LINES as f64;
        broad.gain = rms / power.sqrt();
        broad
    }

    /// The response at a frequency as a share of the rate.
    fn response(&self, share: f64) -> Complex<f64> {
        let z = Complex::from_polar(1.0, -TAU * share);
        let high = self.high[0] * (1.0 - z) / (1.0 - self.high[1] * z);
        let [b, a1, a2] = self.low;
        high * b * (1.0 + z) * (1.0 + z) / (1.0 + a1 * z + a2 * z * z)
    }

    fn next(&mut self) -> f64 {
        let white = self.gain * self.random.normal();
        let high = self.high[0] * (white - self.before[0]) + self.high[1] * self.before[1];
        self.before = [white, high];
        let [b, a1, a2] = self.low;
        let out = b * high + self.state[0];
        self.state = [
            2.0 * b * high - a1 * out + self.state[1],
            b * high - a2 * out,
        ];
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::Series;
    use piezotact::quantity::{SampleRate, Uncalibrated};
    use piezotact::spectrum::{WelchConfig, welch};
    use piezotact::statistics::rms;

    fn slide(sample: &str, speed_m_s: f64, seconds: f64) -> Vec<f64> {
        let parameters = TwinParameters::built_in();
        let participant = Participant::of(0, 1, &parameters);
        let mut texture = Texture::of(
            &parameters,
            &participant,
            parameters.sample(sample).unwrap(),
            SlidingDirection::Proximal,
            5_000.0,
        );
        let length_m = speed_m_s * seconds;
        let mut passage = texture.passage(length_m, speed_m_s, Random::stream(1, 1, sample));
        (0..(seconds * 5_000.0) as usize)
            .map(|i| passage.next(speed_m_s, 0.2, speed_m_s * i as f64 / 5_000.0))
            .collect()
    }

    fn spectrum(x: Vec<f64>, segment: usize) -> (Vec<f64>, f64) {
        let series = Series::<Uncalibrated>::new(x, SampleRate::new(5_000.0).unwrap()).unwrap();
        let psd = welch(&series, &WelchConfig::hann(segment)).unwrap();
        (psd.values, 5_000.0 / segment as f64)
    }

    /// Forty seconds: 2·190 Hz·40 s = 15,000 degrees of freedom in the broad part, four standard errors of the rms
    /// are 2.3 %; the comb of S1 (35 % of the power, lines 6.6 Hz wide) has some 900, and four of its are 5 %.
    #[test]
    fn levels_grow_with_speed_as_stated() {
        for (sample, level) in [("S1", 2.0), ("S8", 0.74), ("NO", 0.15)] {
            for speed in [0.01, 0.02, 0.03] {
                let found = rms(&slide(sample, speed, 40.0));
                let expected = level * speed / 0.03;
                assert!(
                    (found / expected - 1.0).abs() < 0.06,
                    "{sample} {speed}: {found}"
                );
            }
        }
    }

    /// The broad part is (f/f1)²/(1+(f/f1)²)/(1+(f/f2)⁴): 290 segments, 6 % a line, over 11 lines. The bilinear
    /// transform falls faster from there on: 1.5 dB at 800 Hz.
    #[test]
    fn the_broad_part_has_its_shape() {
        let (psd, step_hz) = spectrum(slide("NO", 0.03, 60.0), 1_024);
        let shape = |f: f64| {
            let rise = (f / 45.0).powi(2);
            rise / (1.0 + rise) / (1.0 + (f / 220.0).powi(4))
        };
        let around = |f: f64| {
            let k = (f / step_hz) as usize;
            let lines = k - 5..k + 6;
            let shaped: f64 = lines.clone().map(|k| shape(k as f64 * step_hz)).sum();
            psd[lines].iter().sum::<f64>() / shaped
        };
        let reference = around(150.0);
        for f in [45.0, 80.0, 300.0, 500.0, 600.0] {
            let off_db = 10.0 * (around(f) / reference).log10();
            assert!(off_db.abs() < 0.8, "{f} Hz: {off_db} dB");
        }
    }

    /// Peaks at n·v/λ: the strongest line of a smoothed spectrum lies within a third of the peak's own width.
    #[test]
    fn combs_move_with_speed() {
        for (sample, speed, expected_hz) in [
            ("S1", 0.03, 55.05),
            ("S1", 0.01, 18.35),
            ("M8", 0.03, 41.9),
            ("M3", 0.02, 400.0),
        ] {
            let (psd, step_hz) = spectrum(slide(sample, speed, 120.0), 4_096);
            let half = ((0.03 * expected_hz / step_hz) as usize).max(1);
            let smooth = |k: usize| psd[k - half..=k + half].iter().sum::<f64>();
            let strongest = (half + 3..1_000).max_by(|a, b| smooth(*a).total_cmp(&smooth(*b)));
            let found_hz = strongest.unwrap() as f64 * step_hz;
            assert!(
                (found_hz / expected_hz - 1.0).abs() < 0.05,
                "{sample} {speed}: {found_hz}"
            );
        }
    }
}
