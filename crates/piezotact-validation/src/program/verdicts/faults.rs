//! Renderings with known faults: the delivered vibration without noise, and its recording.

use std::f64::consts::TAU;
use std::ops::Range;

use anyhow::Result;
use num_complex::Complex;
use piezotact::feature::Weighting;
use piezotact::lineage::Mode;
use piezotact::quantity::{Band, Decibels, Hertz};
use piezotact::verify::{RenderedBand, VerifyConfig};

use super::kinds::Kind;
use super::parts::{ThirdOctaves, Which, line, within, within_band};
use super::scene::{
    FingerPlacement, LEAD, Scene, TAP_S, TAPS, TICK_S, TRAIN_S, Texture, strike, tap_at,
};
use super::signal::{
    Draws, RATE_HZ, amplitude, at_times, bins_of, decibels, delayed, energy, filtered, shaped,
    signal_of,
};

/// Whether what is delivered is the recorded realisation of the texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Realisation {
    Same,
    /// Its times are moved.
    Moved,
    /// Another draw of the same process.
    Another,
}

/// A missing part: silence where a good rendering has signal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gap {
    pub(super) lasts_s: f64,
    /// The level that is missing, dB re the level of the whole.
    pub(super) level_db: f64,
}

/// One rendering: the truth about it, and what `verify` sees.
pub(super) struct Case {
    /// The target, without the silence around it, m/s².
    pub(super) meant: Vec<f64>,
    /// What reaches the nail, framed, free of noise, m/s².
    pub(super) delivered: Vec<f64>,
    /// How much later it is on purpose, samples.
    pub(super) delay: f64,
    pub(super) realisation: Realisation,
    pub(super) gaps: Vec<Gap>,
    pub(super) clipped_share: f64,
    /// The share of the texture that the recording lacks, 0–1.
    pub(super) uncovered_share: f64,
    /// Something is missing that `verify` was told of or can see missing: to pass in part is right.
    pub(super) part: bool,
    /// What the sensor recorded.
    pub(super) seen: Vec<f64>,
    pub(super) config: VerifyConfig,
}

/// `x` with raised-cosine fades of `fade_s` at both ends.
pub(super) fn faded(x: &[f64], fade_s: f64) -> Vec<f64> {
    let n = fade_s * RATE_HZ;
    let last = x.len() as f64 - 1.0;
    let weight = |i: usize| {
        let inside = (i as f64).min(last - i as f64) / n;
        piezotact::fourier::fade(inside)
    };
    x.iter().enumerate().map(|(i, v)| v * weight(i)).collect()
}

/// `x` with a random phase in every line.
fn with_random_phases(x: &[f64], draws: &mut Draws) -> Vec<f64> {
    let mut bins = bins_of(x, x.len());
    for bin in bins.iter_mut().skip(1) {
        *bin = Complex::from_polar(bin.norm(), TAU * draws.uniform());
    }
    signal_of(bins, x.len())
}

impl Case {
    /// The rendering of `scene` in which there is `kind`; `None` where a texture has nothing that it could happen to.
    pub(super) fn of(scene: &Scene, kind: Kind, mode: Mode) -> Result<Option<Self>> {
        let mut draws = Draws::of(
            scene.seed,
            &format!("{} {}", scene.texture.name(), kind.name()),
        );
        if !kind.happens_to(scene.texture, scene.target.len()) {
            return Ok(None);
        }
        // To have the spectrum, a rendering may have any phases: with every other seed it has others, where the texture is
        // the same all the time.
        let steady = !scene.texture.is_short()
            && !matches!(scene.texture, Texture::Taps | Texture::Modulated);
        let played = if mode == Mode::Texture && steady && scene.seed.is_multiple_of(2) {
            with_random_phases(&scene.target, &mut draws)
        } else {
            scene.target.clone()
        };
        let config = VerifyConfig {
            mode,
            rendered: Some(RenderedBand {
                band: scene.band,
                edge_ratio: 0.1,
            }),
            ..VerifyConfig::over(scene.band, RATE_HZ)
        };
        let moved = matches!(
            kind,
            Kind::Faster(_)
                | Kind::Wander(_)
                | Kind::RandomWalk
                | Kind::FirstHalfTwice
                | Kind::Pause(_)
                | Kind::TickLate
        );
        let mut making = Making {
            case: Self {
                meant: scene.target.clone(),
                delivered: scene.good(&played),
                delay: 0.0,
                realisation: if moved {
                    Realisation::Moved
                } else {
                    Realisation::Same
                },
                gaps: Vec::new(),
                clipped_share: 0.0,
                uncovered_share: 0.0,
                part: false,
                seen: Vec::new(),
                config,
            },
            scene,
            played,
            recorded: None,
            noise: scene.noise(scene.frame_samples(), "sensor"),
        };
        making.happen(kind, &mut draws)?;
        let Making {
            mut case,
            recorded,
            noise,
            ..
        } = making;
        let recorded = recorded.unwrap_or_else(|| case.delivered.clone());
        case.seen = recorded.iter().zip(&noise).map(|(r, n)| r + n).collect();
        sensor(kind, scene, &mut case, &mut draws);
        Ok(Some(case))
    }
}

/// What the sensor itself does, noise and all.
fn sensor(kind: Kind, scene: &Scene, case: &mut Case, draws: &mut Draws) {
    let texture = LEAD..LEAD + scene.target.len();
    match kind {
        Kind::SensorClips(share) => {
            let limit = limit_for(&case.seen[texture.clone()], share);
            case.clipped_share = share_beyond(&case.seen[texture], limit);
            case.seen
                .iter_mut()
                .for_each(|v| *v = v.clamp(-limit, limit));
        }
        Kind::SensorFrozen => {
            let gap = place(scene, 0.3, draws);
            case.gaps.push(Gap::of(&case.delivered, gap.clone()));
            let held = case.seen[gap.start];
            case.seen[gap.clone()].fill(held);
            // Nothing is known of what was delivered.
            case.delivered[gap].fill(0.0);
        }
        Kind::Copy => case.seen.clone_from(&scene.target),
        Kind::CutStart => drop(case.seen.drain(..LEAD)),
        Kind::RecordingStops => {
            case.seen.truncate(LEAD + scene.target.len() / 2);
            case.uncovered_share = 0.5;
            case.part = true;
        }
        _ => {}
    }
}

/// The amplitude that a `share` of samples exceed.
fn limit_for(x: &[f64], share: f64) -> f64 {
    let mut sizes: Vec<f64> = x.iter().map(|v| v.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    sizes[((1.0 - share) * sizes.len() as f64) as usize]
}

/// The share of samples of which a limit takes 5 % (0.4 dB) or more: the peaks of a tone are alike, and lose less.
fn share_beyond(x: &[f64], limit: f64) -> f64 {
    x.iter().filter(|v| v.abs() > 1.05 * limit).count() as f64 / x.len() as f64
}

/// Where a gap of `lasts_s` falls, framed: anywhere, and for taps with odd seeds on one of them.
fn place(scene: &Scene, lasts_s: f64, draws: &mut Draws) -> Range<usize> {
    let n = (lasts_s * RATE_HZ) as usize;
    let room = scene.target.len() - n - 1_000;
    let mut from = LEAD + 500 + (draws.uniform() * room as f64) as usize;
    if scene.texture == Texture::Taps && !scene.seed.is_multiple_of(2) {
        let tap = LEAD + tap_at(2 + (draws.uniform() * 12.0) as usize);
        from = (tap - n / 5).min(LEAD + 500 + room);
    }
    from..from + n
}

impl Gap {
    fn of(without_it: &[f64], gap: Range<usize>) -> Self {
        let texture = &without_it[LEAD..without_it.len() - LEAD];
        let overall = energy(texture) / texture.len() as f64;
        let lost = energy(&without_it[gap.clone()]) / gap.len().max(1) as f64;
        Self {
            lasts_s: gap.len() as f64 / RATE_HZ,
            level_db: decibels(lost / overall),
        }
    }
}

/// A case that is being made.
struct Making<'a> {
    case: Case,
    scene: &'a Scene,
    /// What is rendered: the target, in texture mode with phases of its own.
    played: Vec<f64>,
    /// What a recorder makes of what is delivered, where that is not the same.
    recorded: Option<Vec<f64>>,
    noise: Vec<f64>,
}

impl Making<'_> {
    fn happen(&mut self, kind: Kind, draws: &mut Draws) -> Result<()> {
        use Kind::*;
        match kind {
            Level(db) => self.amplify(|_| amplitude(db)),
            Ramp(db) => self.amplify(|t| amplitude(db * (0.5 - t))),
            Modulated(share) => {
                let seconds = self.scene.target.len() as f64 / RATE_HZ;
                let level = (1.0 + 0.5 * share * share).sqrt();
                self.amplify(|t| (1.0 + share * (TAU * 4.0 * seconds * t).sin()) / level);
            }
            StrongestLineMissing => {
                self.shape(within(line(self.scene, Which::Strongest, draws), 0.0))
            }
            WeakLineMissing => self.shape(within(line(self.scene, Which::Weak, draws), 0.0)),
            OneLine => {
                let [low, high] = line(self.scene, Which::Weak, draws);
                self.shape(within([low + 2.5, high - 2.5], amplitude(-3.0)));
            }
            StrongestBandMissing => self.shape(within(self.octaves(draws).strongest, 0.0)),
            BandMissing => self.shape(within(self.octaves(draws).another, 0.0)),
            StrongestBandBoosted(db) => {
                self.shape(within(self.octaves(draws).strongest, amplitude(db)));
            }
            BandBoosted(db) => self.shape(within(self.octaves(draws).another, amplitude(db))),
            Tilt(db) => self.tilt(db),
            LowPass => {
                let second_order = |hz: f64| {
                    let s = Complex::new(0.0, hz / 250.0);
                    1.0 / (s * s + std::f64::consts::SQRT_2 * s + 1.0)
                };
                self.case.delivered = filtered(&self.case.delivered, second_order);
            }
            Echo => {
                let late = delayed(&self.case.delivered, 0.03 * RATE_HZ);
                self.add(late.iter().map(|v| 0.6 * v).collect());
            }
            Polarity => self.amplify(|_| -1.0),
            PhasesTurned => {
                self.case.delivered = filtered(&self.case.delivered, |hz| {
                    Complex::from_polar(1.0, 2.0 * (TAU * (hz.max(1.0) / 20.0).log2()).sin())
                });
            }
            SoftSaturation => {
                let limit = 0.5 * self.rms();
                let before = energy(&self.case.delivered);
                self.each(|v| limit * (v / limit).tanh());
                self.level_to(before);
            }
            Clipped(share) => {
                let limit = limit_for(&self.case.delivered[self.texture()], share);
                self.case.clipped_share = share_beyond(&self.case.delivered[self.texture()], limit);
                self.each(|v| v.clamp(-limit, limit));
            }
            _ => return self.happen_in_time(kind, draws),
        }
        Ok(())
    }

    fn happen_in_time(&mut self, kind: Kind, draws: &mut Draws) -> Result<()> {
        use Kind::*;
        let scene = self.scene;
        let samples = scene.frame_samples();
        match kind {
            DropOut(lasts_s) => self.drop_out(lasts_s, draws),
            SecondHalfSilent => {
                let gap = LEAD + scene.target.len() / 2..samples;
                let lost = gap.start..LEAD + scene.target.len();
                self.case.gaps.push(Gap::of(&self.case.delivered, lost));
                self.case.delivered[gap].fill(0.0);
            }
            TapsLost(n) => {
                let mut played = self.played.clone();
                let from = (draws.uniform() * (TAPS - 1) as f64) as usize;
                for lost in (0..n).map(|i| (from + 3 * i) % TAPS) {
                    let tap = tap_at(lost)..tap_at(lost) + ((TAP_S + 0.005) * RATE_HZ) as usize;
                    let framed = LEAD + tap.start..LEAD + tap.end;
                    self.case.gaps.push(Gap::of(&self.case.delivered, framed));
                    let end = tap.end.min(played.len());
                    played[tap.start..end].fill(0.0);
                }
                self.case.delivered = scene.good(&played);
            }
            Pause(lasts_s) => {
                let at = place(scene, 0.02, draws);
                let mut gap = Gap::of(&self.case.delivered, at.clone());
                gap.lasts_s = lasts_s;
                self.case.gaps.push(gap);
                let silence = vec![0.0; (lasts_s * RATE_HZ) as usize];
                self.case.delivered.splice(at.start..at.start, silence);
                self.case.delivered.truncate(samples);
            }
            FirstHalfTwice => {
                let half = self.played.len() / 2;
                let first = self.played[..half].to_vec();
                self.case.delivered = scene.good(&[first.clone(), first].concat());
            }
            AttackMissing => {
                let lost = (self.played.len() / 4).min(250);
                let mut played = self.played.clone();
                played[..lost].fill(0.0);
                self.case.delivered = scene.good(&played);
            }
            AttackSmeared => {
                let rises = (self.played.len() / 3).min(300) as f64;
                let played = self.played.iter().enumerate();
                let played = played.map(|(i, v)| v * piezotact::fourier::fade(i as f64 / rises));
                self.case.delivered = scene.good(&played.collect::<Vec<f64>>());
            }
            TickLost | TickLate => {
                let tick = (draws.uniform() * TRAIN_S.len() as f64) as usize;
                let at = (TRAIN_S[tick] * RATE_HZ) as usize;
                let tick = at..at + (TICK_S * RATE_HZ) as usize;
                let mut played = self.played.clone();
                let later = played[tick.clone()].to_vec();
                played[tick.clone()].fill(0.0);
                if kind == TickLate {
                    let late = (0.01 * RATE_HZ) as usize;
                    let later = later.iter().zip(&mut played[tick.start + late..]);
                    later.for_each(|(tick, v)| *v += tick);
                } else {
                    let framed = LEAD + tick.start..LEAD + tick.end;
                    self.case.gaps.push(Gap::of(&self.case.delivered, framed));
                }
                self.case.delivered = scene.good(&played);
            }
            FadeUntold(s) => self.case.delivered = scene.good(&faded(&self.played, s)),
            Faster(share) => {
                // It begins again, so that it is as long, unless it is short.
                let n = scene.target.len();
                let (played, n) = match scene.texture.is_short() {
                    true => (self.played.clone(), (n as f64 / (1.0 + share)) as usize),
                    false => (self.played.repeat(2), n),
                };
                let times = (0..n).map(|i| i as f64 * (1.0 + share));
                self.case.delivered = scene.good(&at_times(&played, times));
            }
            Wander(ms) => {
                let turn = draws.uniform();
                let swing = ms * 1e-3 * RATE_HZ;
                self.at(|i| i - swing * (TAU * (0.7 * i / RATE_HZ + turn)).sin());
            }
            RandomWalk => {
                // Steps of 0.2 ms rms every 50 ms: some 1.5 ms after 3 s.
                let mut walk = vec![0.0];
                for _ in 0..samples / 250 + 2 {
                    walk.push(walk[walk.len() - 1] + draws.normal() * 2e-4 * RATE_HZ);
                }
                self.at(|i| {
                    let (whole, share) = ((i / 250.0) as usize, (i / 250.0).fract());
                    i - walk[whole] * (1.0 - share) - walk[whole + 1] * share
                });
            }
            Reversed => {
                let reversed: Vec<f64> = self.played.iter().rev().copied().collect();
                self.case.delivered = scene.good(&reversed);
            }
            Delay(s) => {
                self.case.delay = s * RATE_HZ;
                self.case.delivered = delayed(&self.case.delivered, s * RATE_HZ);
            }
            Clock(share) => {
                let places = (0..samples).map(|i| i as f64 * (1.0 + share));
                self.recorded = Some(at_times(&self.case.delivered, places));
            }
            LostSamples => {
                let mut recorded = self.case.delivered.clone();
                let at = LEAD + (draws.between(0.3, 0.7) * scene.target.len() as f64) as usize;
                recorded.drain(at..at + 3);
                self.recorded = Some(recorded);
            }
            _ => return self.happen_otherwise(kind, draws),
        }
        Ok(())
    }

    fn drop_out(&mut self, lasts_s: f64, draws: &mut Draws) {
        let scene = self.scene;
        let gap = place(scene, lasts_s, draws);
        self.case
            .gaps
            .push(Gap::of(&self.case.delivered, gap.clone()));
        // 2 ms of a ramp outside it, or none.
        let ramp = if scene.seed.is_multiple_of(2) {
            0.0
        } else {
            0.002 * RATE_HZ
        };
        for (i, v) in self.case.delivered.iter_mut().enumerate() {
            let outside = gap
                .start
                .saturating_sub(i)
                .max((i + 1).saturating_sub(gap.end));
            *v *= if outside == 0 {
                0.0
            } else if ramp > 0.0 {
                (outside as f64 / ramp).min(1.0)
            } else {
                1.0
            };
        }
    }

    fn happen_otherwise(&mut self, kind: Kind, draws: &mut Draws) -> Result<()> {
        use Kind::*;
        let (scene, device) = (self.scene, &self.scene.device);
        let samples = scene.frame_samples();
        let play = FingerPlacement::anew("play");
        match kind {
            DriveSaturates(share) => {
                let response = device.own(play);
                let one = |_| Complex::from(1.0);
                let mut drive = scene.delivered(&self.played, one, |hz| device.measured_at(hz));
                let limit = share * drive.iter().fold(0.0, |most: f64, v| v.abs().max(most));
                for v in &mut drive {
                    *v /= (1.0 + (*v / limit).powi(4)).powf(0.25);
                }
                self.case.delivered = filtered(&drive, response);
            }
            Exact => {
                let one = |_| Complex::from(1.0);
                self.case.delivered = scene.delivered(&self.played, one, one);
            }
            Good => {}
            OtherNoise => self.noise = scene.noise(samples, "other"),
            NoisierSensor => self.noise.iter_mut().for_each(|v| *v *= 2.0),
            Conjugate => {
                let taken = |hz: f64| device.measured_at(hz).conj();
                self.case.delivered = scene.delivered(&self.played, device.own(play), taken);
            }
            WrongPerson(but) => {
                let number = device.differing(but);
                let other = device.true_at(number, FingerPlacement::anew("characterise"));
                self.case.delivered = scene.delivered(&self.played, device.own(play), other);
            }
            PressedHarder => self.placed("play", 0.6),
            OtherPlacement(run) => self.placed(run, 0.2),
            Repeat => self.placed("repeat", draws.between(0.19, 0.21)),
            AnotherTexture => self.case.delivered = scene.good(&scene.other_texture),
            NoiseInstead => {
                let white = draws.white(scene.target.len());
                let before = energy(&self.case.delivered);
                self.case.delivered = scene.good(&white);
                self.level_to(before);
            }
            RandomPhases => {
                let phases = with_random_phases(&scene.target, draws);
                self.case.delivered = scene.good(&phases);
            }
            AnotherDraw => self.another(),
            AnotherDrawLevel(db) => {
                self.another();
                self.amplify(|_| amplitude(db));
            }
            AnotherDrawBandMissing => {
                self.another();
                self.shape(within(self.octaves(draws).strongest, 0.0));
            }
            AnotherDrawTilted => {
                self.another();
                self.tilt(3.0);
            }
            StrongestGivenUp => {
                let [low, high] = self.octaves(draws).strongest;
                self.shape(within([low, high], 0.0));
                let parts = [
                    (scene.band.low().0, low - 1.0),
                    (high + 1.0, scene.band.high().0),
                ];
                self.case.config.reached = parts
                    .iter()
                    .filter_map(|(low, high)| Band::new(Hertz(*low), Hertz(*high)).ok())
                    .collect();
                self.case.part = true;
            }
            TopGivenUp => {
                self.shape(within([700.0, 1_200.0], 0.0));
                self.case.config.reached = vec![Band::new(scene.band.low(), Hertz(695.0))?];
                self.case.part = true;
            }
            RenderedAt(db) => {
                self.amplify(|_| amplitude(db));
                self.case.meant.iter_mut().for_each(|v| *v *= amplitude(db));
                self.case.config.level = Decibels(db);
            }
            Offset => {
                let offset = 0.5 * self.rms();
                self.recorded = Some(self.case.delivered.iter().map(|v| v + offset).collect());
            }
            Baseline => {
                let swing = self.rms();
                let drifts = |i: usize| swing * (TAU * 0.3 * i as f64 / RATE_HZ).sin();
                let delivered = self.case.delivered.iter().enumerate();
                self.recorded = Some(delivered.map(|(i, v)| v + drifts(i)).collect());
            }
            _ => self.add_what(kind, draws),
        }
        Ok(())
    }

    fn add_what(&mut self, kind: Kind, draws: &mut Draws) {
        let samples = self.scene.frame_samples();
        let texture = self.texture();
        let rms = self.rms();
        let playing = |x: Vec<f64>| -> Vec<f64> {
            x.iter()
                .enumerate()
                .map(|(i, v)| if texture.contains(&i) { *v } else { 0.0 })
                .collect()
        };
        let tone = |hz: f64, rms: f64| -> Vec<f64> {
            (0..samples)
                .map(|i| rms * 2f64.sqrt() * (TAU * hz * i as f64 / RATE_HZ).sin())
                .collect()
        };
        let scaled = |x: Vec<f64>, rms: f64| -> Vec<f64> {
            let in_band = shaped(&x, within_band(self.scene.band));
            let now = (energy(&in_band) / x.len() as f64).sqrt();
            x.iter().map(|v| v * rms / now).collect()
        };
        let hum = |rms: f64| -> Vec<f64> {
            let mut all = vec![0.0; samples];
            for n in 1..=10 {
                let part = tone(50.0 * f64::from(n), 1.0 / f64::from(n));
                all.iter_mut().zip(part).for_each(|(a, p)| *a += p);
            }
            scaled(all, rms)
        };
        let added = match kind {
            Kind::WhiteNoise(db) => playing(scaled(draws.white(samples), rms * amplitude(db))),
            Kind::PinkNoise(db) => {
                let pink = shaped(&draws.white(samples), |hz| hz.max(5.0).powf(-0.5));
                playing(scaled(pink, rms * amplitude(db)))
            }
            Kind::ToneInStrongest(db) => {
                let [low, high] = self.octaves(draws).strongest;
                playing(tone(low + 0.4 * (high - low), rms * amplitude(db)))
            }
            Kind::ToneElsewhere(db) => {
                let [low, high] = self.octaves(draws).weakest;
                playing(tone(low + 0.5 * (high - low), rms * amplitude(db)))
            }
            Kind::ToneBelowBand => {
                let threshold = Weighting::DetectionThreshold.threshold_m_s2(Hertz(12.0));
                let felt = super::truth::felt_power(&self.scene.target, self.scene.band);
                playing(tone(12.0, threshold * (0.5 * felt.max(4.0)).sqrt()))
            }
            Kind::ClickAdded => {
                let after = match self.scene.texture {
                    Texture::Train => (0.33 * RATE_HZ) as usize,
                    _ => self.scene.target.len() + (0.04 * RATE_HZ) as usize,
                };
                let high = self
                    .scene
                    .target
                    .iter()
                    .fold(0.0, |most: f64, v| v.abs().max(most));
                let mut click = vec![0.0; samples];
                strike(&mut click[LEAD + after..][..25], 300.0, high, 0.0015);
                shaped(&click, within_band(self.scene.band))
            }
            Kind::HumPlaying => playing(hum(rms * amplitude(-3.0))),
            Kind::HumThroughout => hum(rms * amplitude(-3.0)),
            _ => return,
        };
        self.add(added);
    }

    fn texture(&self) -> Range<usize> {
        LEAD..LEAD + self.scene.target.len()
    }

    fn rms(&self) -> f64 {
        piezotact::statistics::rms(&self.case.delivered[self.texture()])
    }

    fn octaves(&self, draws: &mut Draws) -> ThirdOctaves {
        ThirdOctaves::of(self.scene, draws)
    }

    fn each(&mut self, f: impl Fn(f64) -> f64) {
        self.case.delivered.iter_mut().for_each(|v| *v = f(*v));
    }

    /// By a gain of time, 0 at the texture's beginning and 1 at its end.
    fn amplify(&mut self, gain: impl Fn(f64) -> f64) {
        let n = self.scene.target.len() as f64;
        for (i, v) in self.case.delivered.iter_mut().enumerate() {
            *v *= gain(((i as f64 - LEAD as f64) / n).clamp(0.0, 1.0));
        }
    }

    fn shape(&mut self, gain: impl Fn(f64) -> f64) {
        self.case.delivered = shaped(&self.case.delivered, gain);
    }

    fn tilt(&mut self, db: f64) {
        let before = energy(&self.case.delivered);
        self.shape(|hz| amplitude(db * (hz.max(10.0) / 150.0).log2()));
        self.level_to(before);
    }

    fn level_to(&mut self, wanted: f64) {
        let gain = (wanted / energy(&self.case.delivered)).sqrt();
        self.each(|v| gain * v);
    }

    fn add(&mut self, what: Vec<f64>) {
        self.case
            .delivered
            .iter_mut()
            .zip(what)
            .for_each(|(v, w)| *v += w);
    }

    fn at(&mut self, when: impl Fn(f64) -> f64) {
        let times = (0..self.case.delivered.len()).map(|i| when(i as f64));
        self.case.delivered = at_times(&self.case.delivered, times);
    }

    fn placed(&mut self, run: &'static str, load_n: f64) {
        let device = &self.scene.device;
        let is = device.own(FingerPlacement { run, load_n });
        self.case.delivered = self
            .scene
            .delivered(&self.played, is, |hz| device.measured_at(hz));
    }

    fn another(&mut self) {
        self.case.delivered = self.scene.good(&self.scene.another);
        self.case.realisation = Realisation::Another;
    }
}
