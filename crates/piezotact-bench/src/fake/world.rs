//! What stands between the halves of a fake: a drive on one clock, a device, and channels on another clock.

use std::f64::consts::{PI, TAU};

use piezotact::Series;
use piezotact::quantity::{Drive, SampleRate};

use super::script::{FakeDevice, Underrun};
use crate::plan::{DriveSource, Playback};
use crate::random::Random;

/// Half of the length of the interpolating kernel, in samples of the slower clock.
const HALF_WIDTH: f64 = 16.0;
/// Where the kernel falls to a half, as a share of the slower rate.
const CUTOFF: f64 = 0.45;
/// Places of the kernel that are tabulated for each sample of the output.
const PLACES: usize = 64;
/// The force at rest scatters by this, N rms.
const FORCE_NOISE_N: f64 = 0.0005;

/// A drive that is there as a whole, handed out as one that is made.
struct WholeDrive {
    drive: Series<Drive>,
    at: usize,
}

impl DriveSource for WholeDrive {
    fn rate(&self) -> SampleRate {
        self.drive.rate()
    }

    fn next_samples(&mut self, count: usize) -> Vec<f64> {
        let samples = self.drive.samples();
        let to = (self.at + count).min(samples.len());
        let next = samples[self.at..to].to_vec();
        self.at = to;
        next
    }
}

/// What leaves the output: the drive with the silence where it ran dry.
pub(super) struct Output {
    source: Box<dyn DriveSource>,
    /// Where silences begin, in samples of the drive, with their length.
    silences: Vec<(u64, u64)>,
    /// What left it, from sample `first` on.
    samples: Vec<f64>,
    first: u64,
    /// Samples of the drive that were fetched.
    fetched: u64,
    /// What left it in all, where the drive has ended.
    length: Option<u64>,
    kernel: Kernel,
}

impl Output {
    pub(super) fn new(
        playback: Playback,
        underruns: &[Underrun],
        [output_hz, input_hz]: [f64; 2],
    ) -> Self {
        let source: Box<dyn DriveSource> = match playback {
            Playback::Whole(drive) => Box::new(WholeDrive { drive, at: 0 }),
            Playback::Made(source) => source,
        };
        let begins = |u: &Underrun| ((u.at_s * output_hz).round() as u64, u.samples);
        let mut silences: Vec<(u64, u64)> = underruns.iter().map(begins).collect();
        silences.sort_unstable();
        Self {
            source,
            silences,
            samples: Vec::new(),
            first: 0,
            fetched: 0,
            length: None,
            kernel: Kernel::new(output_hz, input_hz),
        }
    }

    /// Fetches what leaves the output up to, not including, sample `to`.
    fn fetch(&mut self, to: u64) {
        while self.length.is_none() && self.first + (self.samples.len() as u64) < to {
            let next = self.silences.iter().find(|(at, _)| *at >= self.fetched);
            let wanted = match next {
                Some((at, silence)) if *at == self.fetched => {
                    let silence = *silence as usize;
                    self.silences.retain(|(other, _)| *other != self.fetched);
                    self.samples.resize(self.samples.len() + silence, 0.0);
                    continue;
                }
                Some((at, _)) => (at - self.fetched).min(4_096),
                None => 4_096,
            } as usize;
            let new = self.source.next_samples(wanted);
            self.fetched += new.len() as u64;
            let ended = new.len() < wanted;
            self.samples
                .extend(new.into_iter().map(|v| v.clamp(-1.0, 1.0)));
            if ended {
                self.length = Some(self.first + self.samples.len() as u64);
            }
        }
    }

    /// What leaves the output at `position`, in its samples.
    pub(super) fn at(&mut self, position: f64) -> f64 {
        let half = self.kernel.half as i64;
        let middle = position.floor() as i64;
        if middle + half < 0 {
            return 0.0;
        }
        self.fetch((middle + half + 1) as u64);
        if self
            .length
            .is_some_and(|length| middle - half > length as i64)
        {
            return 0.0;
        }
        let behind = (middle - half).max(0) as u64;
        if behind > self.first + 65_536 {
            self.samples.drain(..(behind - self.first) as usize);
            self.first = behind;
        }
        (middle - half + 1..=middle + half)
            .filter_map(|k| {
                let at = u64::try_from(k).ok()?.checked_sub(self.first)?;
                let sample = self.samples.get(usize::try_from(at).ok()?)?;
                Some(sample * self.kernel.at((position - k as f64).abs()))
            })
            .sum()
    }

    /// Samples of the drive that left the output up to `position`, how often it ran dry, and whether that is all.
    pub(super) fn played(
        &self,
        position: f64,
        underruns: &[Underrun],
        output_hz: f64,
    ) -> (u64, usize, bool) {
        let position = position.max(0.0) as u64;
        let left = self.length.map_or(position, |length| position.min(length));
        let (mut silent, mut dry) = (0, 0);
        let mut begins: Vec<(u64, u64)> = underruns
            .iter()
            .map(|u| ((u.at_s * output_hz).round() as u64, u.samples))
            .filter(|(at, _)| *at < self.fetched)
            .collect();
        begins.sort_unstable();
        for (at, silence) in begins {
            let here = at + silent;
            if here < left {
                silent += silence.min(left - here);
                dry += 1;
            }
        }
        let ended = self.length.is_some_and(|length| position >= length);
        (left - silent, dry, ended)
    }
}

/// A low-pass between two rates, tabulated: a sinc under a Blackman window.
struct Kernel {
    half: usize,
    table: Vec<f64>,
}

impl Kernel {
    fn new(output_hz: f64, input_hz: f64) -> Self {
        let slower = output_hz.min(input_hz);
        let half = (HALF_WIDTH * output_hz / slower).ceil();
        let cutoff = CUTOFF * slower / output_hz;
        let table = (0..=(half as usize + 1) * PLACES)
            .map(|i| {
                let x = i as f64 / PLACES as f64;
                if x >= half {
                    return 0.0;
                }
                let w = 0.42 + 0.5 * (PI * x / half).cos() + 0.08 * (TAU * x / half).cos();
                let t = TAU * cutoff * x;
                let sinc = if t == 0.0 { 1.0 } else { t.sin() / t };
                2.0 * cutoff * sinc * w
            })
            .collect();
        Self {
            half: half as usize,
            table,
        }
    }

    fn at(&self, distance: f64) -> f64 {
        let place = distance * PLACES as f64;
        let below = place as usize;
        match self.table.get(below..below + 2) {
            Some(pair) => pair[0] + (pair[1] - pair[0]) * (place - below as f64),
            None => 0.0,
        }
    }
}

/// The device with a finger on it, at the rate of the input.
pub(super) struct Device {
    /// A second-order high-pass: b, −2b, b over 1, a1, a2.
    b: f64,
    a: [f64; 2],
    state: [f64; 2],
    /// The drive on its way.
    line: Vec<f64>,
    at: usize,
    noise_m_s2: f64,
    force_n: f64,
    random: Random,
}

impl Device {
    pub(super) fn new(device: &FakeDevice, input_hz: f64, load_n: f64, random: Random) -> Self {
        let k = (PI * device.resonance_hz / input_hz).tan();
        let norm = 1.0 / (1.0 + 2.0 * device.damping * k + k * k);
        Self {
            b: device.gain_m_s2 * norm,
            a: [
                2.0 * (k * k - 1.0) * norm,
                (1.0 - 2.0 * device.damping * k + k * k) * norm,
            ],
            state: [0.0; 2],
            line: vec![0.0; ((device.delay_s * input_hz).round() as usize).max(1)],
            at: 0,
            noise_m_s2: device.noise_m_s2,
            force_n: device.force_share * load_n,
            random,
        }
    }

    /// Acceleration and normal force for the next sample of the drive.
    pub(super) fn next(&mut self, drive: f64) -> [f64; 2] {
        let late = std::mem::replace(&mut self.line[self.at], drive);
        self.at = (self.at + 1) % self.line.len();
        let out = self.b * late + self.state[0];
        self.state[0] = -2.0 * self.b * late - self.a[0] * out + self.state[1];
        self.state[1] = self.b * late - self.a[1] * out;
        [
            out + self.noise_m_s2 * self.random.normal(),
            self.force_n + FORCE_NOISE_N * self.random.normal(),
        ]
    }
}
