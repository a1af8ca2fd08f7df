//! One texture for one person: the target, and what a good rendering of it delivers, free of noise.

use std::f64::consts::TAU;
use std::sync::Arc;

use anyhow::Result;
use num_complex::Complex;
use piezotact::device::DeviceDescription;
use piezotact::quantity::{
    Acceleration, Band, Degrees, Drive, Hertz, Newtons, SampleRate, Seconds,
};
use piezotact::run::Discard;
use piezotact::series::Series;
use piezotact::spectrum::WelchConfig;
use piezotact::statistics::rms;
use piezotact::transfer::{Estimator, TransferFunction};
use piezotact_bench::procedure::{CharacteriseConfig, characterise};
use piezotact_bench::{Excitation, ExcitationConfig, RunPlan, Until};
use piezotact_twin::{
    OutputStage, Participant, Placement, TwinBench, TwinParameters, record_texture,
};

use super::coil;
use super::signal::{Draws, RATE_HZ, decibels, filtered, shaped};

/// How long a target is.
pub(super) const SECONDS: f64 = 3.0;
/// Silence before and after it, samples: 0.3 s.
pub(super) const LEAD: usize = 1_500;
/// The load and the angle that everybody is asked for.
const LOAD_N: f64 = 0.2;
const ANGLE_DEG: f64 = 20.0;
const SPEED_M_S: f64 = 0.03;

/// The band that is rendered and judged.
pub(super) fn band() -> Result<Band> {
    Ok(Band::new(Hertz(20.0), Hertz(1_000.0))?)
}

/// A kind of texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Texture {
    /// The smooth sample at a third of its level, 0.05 m/s²: its highest lines lie 10 dB above the sensor's noise.
    Faint,
    /// S6, 1 m/s²: noise of a broad spectrum.
    Broad,
    /// M8, 2 m/s²: a comb of harmonics of 42 Hz.
    Comb,
    /// A tone of 150 Hz and 2 m/s² over the smooth sample's noise.
    Tonal,
    /// Twenty taps, 150 ms apart, and silence between them.
    Taps,
    /// S2, its level modulated by ±6 dB at 0.7 Hz.
    Modulated,
    /// 5 ms of a decaying oscillation. This and those that follow begin at full level in their first sample.
    Click,
    /// 30 ms of one.
    Tick,
    /// 80 ms of a tone.
    Burst,
    /// 300 ms of decaying noise.
    Attack,
    /// Eight ticks at unequal distances, with silence between them.
    Train,
}

impl Texture {
    pub(super) const ALL: [Self; 11] = [
        Self::Faint,
        Self::Broad,
        Self::Comb,
        Self::Tonal,
        Self::Taps,
        Self::Modulated,
        Self::Click,
        Self::Tick,
        Self::Burst,
        Self::Attack,
        Self::Train,
    ];

    /// Shorter than a second, with an abrupt beginning.
    pub(super) fn is_short(self) -> bool {
        self as usize >= Self::Click as usize
    }

    /// One of the same length, about.
    fn other(self) -> Self {
        let alike =
            Self::ALL.map(|texture| (texture.is_short() == self.is_short()).then_some(texture));
        let alike: Vec<Self> = alike.into_iter().flatten().collect();
        let place = alike.iter().position(|t| *t == self).unwrap_or(0);
        alike[(place + 2) % alike.len()]
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Faint => "faint",
            Self::Broad => "broad",
            Self::Comb => "comb",
            Self::Tonal => "tonal",
            Self::Taps => "taps",
            Self::Modulated => "modulated",
            Self::Click => "click",
            Self::Tick => "tick",
            Self::Burst => "burst",
            Self::Attack => "attack",
            Self::Train => "train",
        }
    }

    /// A realisation of it, m/s²: another one for every `seed`.
    pub(super) fn draw(self, parameters: &TwinParameters, seed: u64) -> Result<Vec<f64>> {
        let passage = |name: &str| -> Result<Vec<f64>> {
            let person = Participant::of(0, seed, parameters);
            let sample = parameters.sample(name)?;
            let (series, ..) =
                record_texture(parameters, &person, sample, SPEED_M_S, Seconds(SECONDS))?;
            Ok(series.into_samples())
        };
        let mut draws = Draws::of(seed, self.name());
        Ok(match self {
            Self::Faint => passage("NO")?.iter().map(|v| v / 3.0).collect(),
            Self::Broad => passage("S6")?,
            Self::Comb => passage("M8")?,
            Self::Tonal => {
                let turn = draws.uniform();
                let tone = |i: usize| 2.0 * (TAU * (150.0 * i as f64 / RATE_HZ + turn)).sin();
                let noise = passage("NO")?;
                noise.iter().enumerate().map(|(i, v)| v + tone(i)).collect()
            }
            Self::Taps => taps(&mut draws),
            Self::Click => {
                let mut samples = silence(0.005);
                strike(
                    &mut samples,
                    draws.between(250.0, 400.0),
                    draws.between(5.0, 10.0),
                    0.0015,
                );
                samples
            }
            Self::Tick => {
                let mut samples = silence(0.03);
                strike(
                    &mut samples,
                    draws.between(150.0, 250.0),
                    draws.between(2.0, 8.0),
                    0.008,
                );
                samples
            }
            Self::Burst => {
                let mut samples = silence(0.08);
                strike(
                    &mut samples,
                    draws.between(100.0, 300.0),
                    2.0,
                    f64::INFINITY,
                );
                samples
            }
            Self::Attack => {
                let white = draws.white((0.3 * RATE_HZ) as usize);
                let decay = |i: usize| 3.0 * (-(i as f64) / RATE_HZ / 0.1).exp();
                white
                    .iter()
                    .enumerate()
                    .map(|(i, v)| v * decay(i))
                    .collect()
            }
            Self::Train => {
                let mut samples = silence(0.9);
                for at_s in TRAIN_S {
                    let tick =
                        &mut samples[(at_s * RATE_HZ) as usize..][..(TICK_S * RATE_HZ) as usize];
                    strike(
                        tick,
                        draws.between(180.0, 300.0),
                        draws.between(3.0, 6.0),
                        0.003,
                    );
                }
                samples
            }
            Self::Modulated => {
                let turn = draws.uniform();
                let level = |i: usize| {
                    let swing = (TAU * (0.7 * i as f64 / RATE_HZ + turn)).sin();
                    10f64.powf(6.0 * swing / 20.0)
                };
                let steady = passage("S2")?;
                steady
                    .iter()
                    .enumerate()
                    .map(|(i, v)| v * level(i))
                    .collect()
            }
        })
    }
}

/// Where the ticks of a train begin, s, and how long they last.
pub(super) const TRAIN_S: [f64; 8] = [0.0, 0.06, 0.2, 0.245, 0.42, 0.58, 0.64, 0.8];
pub(super) const TICK_S: f64 = 0.012;

fn silence(seconds: f64) -> Vec<f64> {
    vec![0.0; (seconds * RATE_HZ) as usize]
}

/// Adds an oscillation that begins at its full height, m/s², in the first sample.
pub(super) fn strike(samples: &mut [f64], hz: f64, high: f64, decay_s: f64) {
    for (i, sample) in samples.iter_mut().enumerate() {
        let t_s = i as f64 / RATE_HZ;
        *sample += high * (-t_s / decay_s).exp() * (TAU * hz * t_s).cos();
    }
}

/// The number of taps, and the time from one to the next.
pub(super) const TAPS: usize = 20;
const TAP_EVERY_S: f64 = 0.15;
/// How long a tap lasts until 60 dB are gone.
pub(super) const TAP_S: f64 = 0.07;

/// Where tap `n` begins on the target, samples, but for a jitter of up to 5 ms.
pub(super) fn tap_at(n: usize) -> usize {
    ((0.03 + TAP_EVERY_S * n as f64) * RATE_HZ) as usize
}

/// Decaying oscillations of 150–250 Hz, 2–5 m/s² high.
fn taps(draws: &mut Draws) -> Vec<f64> {
    let mut samples = vec![0.0; (SECONDS * RATE_HZ) as usize];
    for n in 0..TAPS {
        let at = tap_at(n) + (draws.uniform() * 0.005 * RATE_HZ) as usize;
        let (hz, high) = (draws.between(150.0, 250.0), draws.between(2.0, 5.0));
        let lasting = (TAP_S * RATE_HZ) as usize;
        for (i, sample) in samples[at..].iter_mut().take(lasting).enumerate() {
            let t_s = i as f64 / RATE_HZ;
            *sample += high * (-t_s / 0.010).exp() * (TAU * hz * t_s).sin();
        }
    }
    samples
}

/// What moves the finger.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Actuator {
    /// The twin's.
    Piezo,
    VoiceCoil,
}

impl Actuator {
    pub(super) const ALL: [Self; 2] = [Self::Piezo, Self::VoiceCoil];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Piezo => "piezo",
            Self::VoiceCoil => "coil",
        }
    }
}

/// The response of a device over frequency in Hz.
type Response = Box<dyn Fn(f64) -> Complex<f64> + Send + Sync>;

/// One person's device: what its transfer function was measured as, and what it is.
pub(super) struct Device {
    pub(super) actuator: Actuator,
    person: Participant,
    parameters: TwinParameters,
    measured: Response,
    /// Other people, those first who differ most.
    others: Vec<u64>,
}

/// How a finger lies on the device.
#[derive(Clone, Copy, Debug)]
pub(super) struct FingerPlacement {
    /// The name of the run that it was put down for.
    pub(super) run: &'static str,
    pub(super) load_n: f64,
}

impl FingerPlacement {
    pub(super) fn anew(run: &'static str) -> Self {
        Self {
            run,
            load_n: LOAD_N,
        }
    }
}

/// The transfer function that a characterisation of this person's device on the twin finds.
fn characterised(
    parameters: &TwinParameters,
    person: &Participant,
) -> Result<TransferFunction<Drive, Acceleration>> {
    let config = CharacteriseConfig {
        excitation: ExcitationConfig {
            kind: Excitation::Random,
            band: Band::new(Hertz(2.0), Hertz(1_200.0))?,
            duration: Seconds(30.0),
            peak: 0.8,
            seed: person.seed,
        },
        welch: WelchConfig::hann(2_048),
        estimator: Estimator::H1,
        run: RunPlan {
            label: "characterise".into(),
            load: Some(Newtons(LOAD_N)),
            angle: Degrees(ANGLE_DEG),
            placement: piezotact_bench::Placement::New,
            until: Until::PlaybackEnded,
        },
    };
    let mut bench = TwinBench::new(
        parameters,
        person.clone(),
        &DeviceDescription::drv2667().at_usual_gain(),
    )
    .into_bench();
    Ok(characterise(&mut bench, &config, &mut Discard)?.function)
}

impl Device {
    /// Of a participant under `seed`; the twin's is characterised as `piezotact characterise` does it.
    pub(super) fn of(seed: u64, actuator: Actuator) -> Result<Self> {
        let (number, seed) = (seed, 40 + seed);
        let mut parameters = TwinParameters::built_in();
        // Everything here is in what the sensor reads: with one and the same sensor its sensitivity is without effect.
        parameters.accelerometer.sensitivity_spread = 0.0;
        let person = Participant::of(number, seed, &parameters);
        let measured: Response = match actuator {
            Actuator::Piezo => {
                let function = characterised(&parameters, &person)?;
                Box::new(move |hz| function.at(hz))
            }
            Actuator::VoiceCoil => Box::new(coil::response(
                number,
                seed,
                FingerPlacement::anew("characterise"),
            )),
        };
        let mut device = Self {
            actuator,
            person,
            parameters,
            measured,
            others: Vec::new(),
        };
        device.others = device.by_difference()?;
        Ok(device)
    }

    /// The other 19 of 20 people, those first whose devices differ most from this one's over the band.
    fn by_difference(&self) -> Result<Vec<u64>> {
        let (band, own) = (band()?, self.own(FingerPlacement::anew("play")));
        let mut others: Vec<(f64, u64)> = (1..=20)
            .filter(|number| *number != self.person.number)
            .map(|number| {
                let other = self.true_at(number, FingerPlacement::anew("characterise"));
                let differs = |k: u32| {
                    let hz = band.low().0 + 10.0 * f64::from(k);
                    decibels((own(hz) / other(hz)).norm_sqr()).powi(2)
                };
                ((0..98).map(differs).sum(), number)
            })
            .collect();
        others.sort_by(|a, b| b.0.total_cmp(&a.0));
        Ok(others.into_iter().map(|(_, number)| number).collect())
    }

    /// The number of the person whose device differs most but for `but`.
    pub(super) fn differing(&self, but: usize) -> u64 {
        self.others[but.min(self.others.len() - 1)]
    }

    /// What the device of participant `number` is, from the digital drive to the nail, (m/s²) at full scale.
    pub(super) fn true_at(&self, number: u64, lies: FingerPlacement) -> Response {
        let seed = self.person.seed;
        if self.actuator == Actuator::VoiceCoil {
            return Box::new(coil::response(number, seed, lies));
        }
        let person = Participant::of(number, seed, &self.parameters);
        let placement = Placement::of(&self.parameters, number, seed, lies.run);
        let output = OutputStage::new(
            &self.parameters.output,
            &DeviceDescription::drv2667().at_usual_gain(),
        );
        let volts = output.setup().volts_per_full_scale * output.setup().gain.voltage_ratio();
        let latency_s = self.parameters.actuator.latency_s;
        Box::new(move |hz| {
            let hz = hz.max(0.5);
            person
                .finger
                .response(hz, lies.load_n, ANGLE_DEG, &placement)
                * output.high_pass(hz)
                * Complex::from_polar(volts, -TAU * hz * latency_s)
        })
    }

    pub(super) fn own(&self, lies: FingerPlacement) -> Response {
        self.true_at(self.person.number, lies)
    }

    pub(super) fn measured_at(&self, hz: f64) -> Complex<f64> {
        (self.measured)(hz)
    }
}

/// One texture for one person.
pub(super) struct Scene {
    pub(super) texture: Texture,
    pub(super) seed: u64,
    /// As it was recorded, m/s².
    pub(super) target: Vec<f64>,
    /// Another realisation, at the same rms in the band.
    pub(super) another: Vec<f64>,
    /// The other textures, at the same rms in the band.
    pub(super) other_texture: Vec<f64>,
    pub(super) device: Arc<Device>,
    pub(super) band: Band,
}

impl Scene {
    /// Texture `texture`, drawn by `seed`, for the person with this device.
    pub(super) fn new(texture: Texture, seed: u64, device: &Arc<Device>) -> Result<Self> {
        let device = Arc::clone(device);
        let band = band()?;
        let target = texture.draw(&device.parameters, seed)?;
        let in_band = |x: &[f64]| rms(&shaped(x, |hz| f64::from(u8::from(band.contains(hz)))));
        let like_target = |mut x: Vec<f64>| {
            let ratio = in_band(&target) / in_band(&x);
            x.iter_mut().for_each(|v| *v *= ratio);
            x
        };
        Ok(Self {
            texture,
            seed,
            another: like_target(texture.draw(&device.parameters, seed + 500)?),
            other_texture: like_target(texture.other().draw(&device.parameters, seed + 900)?),
            target,
            device,
            band,
        })
    }

    /// The samples of a frame: the target with silence around it.
    pub(super) fn frame_samples(&self) -> usize {
        self.target.len() + 2 * LEAD
    }

    /// `x` with silence around it.
    pub(super) fn framed(&self, x: &[f64]) -> Vec<f64> {
        let mut frame = vec![0.0; LEAD];
        frame.extend(x);
        frame.resize(self.frame_samples(), 0.0);
        frame
    }

    /// What a rendering of `x` delivers, framed, on a device that is `is` and was taken for `taken` when the drive was made:
    /// linear, so exact in the frequency domain.
    pub(super) fn delivered(
        &self,
        x: &[f64],
        is: impl Fn(f64) -> Complex<f64>,
        taken: impl Fn(f64) -> Complex<f64>,
    ) -> Vec<f64> {
        filtered(&self.framed(x), |hz| {
            // The edges of the inverse.
            match self.band.weight(hz, 0.1) {
                0.0 => Complex::default(),
                weight => weight * is(hz) / taken(hz),
            }
        })
    }

    /// What a good rendering of `x` delivers: the measured transfer function of the person, and the finger put down again.
    pub(super) fn good(&self, x: &[f64]) -> Vec<f64> {
        let is = self.device.own(FingerPlacement::anew("play"));
        self.delivered(x, is, |hz| self.device.measured_at(hz))
    }

    /// `samples` of what the accelerometer on the nail reads at rest, m/s²: white noise and flicker.
    pub(super) fn noise(&self, samples: usize, name: &str) -> Vec<f64> {
        let sensor = &self.device.parameters.accelerometer;
        let mut draws = Draws::of(self.seed, &format!("{} {name}", self.texture.name()));
        let forget = (-TAU * sensor.flicker_hz / RATE_HZ).exp();
        let kept = sensor.flicker_m_s2 * (1.0 - forget * forget).sqrt();
        let mut flicker = 0.0;
        (0..samples)
            .map(|_| {
                flicker = forget * flicker + kept * draws.normal();
                flicker + sensor.white_m_s2 * draws.normal()
            })
            .collect()
    }
}

/// Samples as a series.
pub(super) fn series(samples: Vec<f64>) -> Result<Series<Acceleration>> {
    Ok(Series::new(samples, SampleRate::new(RATE_HZ)?)?)
}
