//! Measurements with running streams: tones, the gain of a loopback, and which output arrives at which input.

use piezotact::sound::SoundError;
use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

use piezotact::fourier::{fade, hann};
use piezotact::quantity::{Drive, Hertz, SampleRate, Seconds};
use piezotact::series::Series;
use piezotact::sound::{Tone, Wire, burst_delay, tone, tone_near, wiring};
use piezotact::statistics::peak;
use piezotact_bench::{Playback, StopHandle};

use crate::callback::Happened;
use crate::error::AudioError;
use crate::setup::SoundSetup;
use crate::streams::{Loaded, RunningStreams};

/// The tone by which the level of a loopback is checked: its frequency, level re full scale, and duration.
const CHECK_HZ: Hertz = Hertz(1_000.0);
const CHECK_LEVEL: f64 = 0.05;
const CHECK_S: f64 = 0.4;
/// The sweep before it, s, and the silence between them.
const SWEEP_S: f64 = 0.1;
const GAP: Seconds = Seconds(0.05);
/// Two clocks of one device differ by less than this share, and a calibrator from its stated frequency by less than the other.
const CLOCKS_SHARE: f64 = 1e-3;
const CALIBRATOR_SHARE: f64 = 0.03;
/// The fades of tones, s, and the part at both ends that is not measured.
const FADE_S: f64 = 0.05;
const EDGE_S: f64 = 0.08;
/// The largest number of attempts at a measurement in which samples are lost.
const ATTEMPTS: usize = 3;
/// What is recorded before and after what is played: the latency lies within it.
const LEAD: Seconds = Seconds(0.1);
const TAIL_S: f64 = 0.6;
/// A pulse: half a sine of this length and peak.
const PULSE_S: f64 = 0.001;
const PULSE_PEAK: f64 = 0.5;

/// The tone for a voltmeter: its frequency, which every meter reads right, and its rms re full scale.
pub const VOLTMETER_TONE: (Hertz, f64) = (Hertz(100.0), 0.5 * FRAC_1_SQRT_2);

/// Plays the tone for a voltmeter for `seconds`.
///
/// # Errors
/// [`AudioError::Device`] when the device fails.
pub fn play_tone(streams: &mut RunningStreams, seconds: Seconds) -> Result<(), AudioError> {
    let (hz, rms) = VOLTMETER_TONE;
    let level = rms / FRAC_1_SQRT_2;
    let samples = tone_samples(streams.rate().hz(), hz.0, level, seconds.0);
    excite(streams, &samples).map(|_recorded| ())
}

/// The frequency of the tone by which the level of a loopback is checked.
#[must_use]
pub fn check_level_hz() -> Hertz {
    CHECK_HZ
}

/// What was played and what was recorded meanwhile.
#[derive(Clone, Debug)]
pub(crate) struct Excited {
    /// The samples of every input, full scale = 1.
    pub(crate) inputs: Vec<Vec<f64>>,
    /// The recorded frame at which the first sample of the drive was handed over.
    pub(crate) onset: usize,
    /// How often samples were lost.
    pub(crate) drop_outs: u64,
}

/// Plays `samples` (full scale = 1) and records all inputs from 0.1 s before until 0.6 s after.
pub(crate) fn excite(streams: &mut RunningStreams, samples: &[f64]) -> Result<Excited, AudioError> {
    let rate = streams.rate();
    let drive = Series::<Drive>::new(samples.to_vec(), rate);
    let drive = drive.map_err(|error| AudioError::Setup(error.to_string()))?;
    let origin = streams.skip();
    let _before = streams.take_happened();
    let onset = streams.next_onset(LEAD);
    let stop = StopHandle::new();
    let _piece = streams.play_at(onset, Loaded::of(Playback::Whole(drive), &stop))?;
    let wanted = samples.len() + rate.samples_in(Seconds(LEAD.0 + TAIL_S));
    let (mut inputs, mut there): (Vec<Vec<f64>>, _) = (Vec::new(), 0);
    let mut drop_outs = 0;
    while there < wanted {
        let Some(fetched) = streams.fetch(1, wanted - there, &stop)? else {
            break;
        };
        inputs.resize(fetched.channels.len(), Vec::new());
        for (all, new) in inputs.iter_mut().zip(&fetched.channels) {
            // What was lost stands as silence, so that times hold.
            all.resize(all.len() + fetched.lost as usize, 0.0);
            all.extend(new.iter().map(|v| f64::from(*v)));
        }
        drop_outs += u64::from(fetched.lost > 0);
        there = inputs.first().map_or(0, Vec::len);
    }
    let mut began = None;
    for happened in streams.take_happened() {
        match happened {
            Happened::Onset { input, .. } => began = Some(input),
            Happened::RanDry { .. } => drop_outs += 1,
            Happened::Lost { .. } => {}
        }
    }
    let onset = began.map_or(0, |input| input.saturating_sub(origin) as usize);
    Ok(Excited {
        inputs,
        onset,
        drop_outs,
    })
}

fn tone_samples(rate_hz: f64, hz: f64, level: f64, length_s: f64) -> Vec<f64> {
    let count = (length_s * rate_hz) as usize;
    let length = (FADE_S * rate_hz).max(1.0);
    let edge = |i: usize| fade(i.min(count - 1 - i) as f64 / length);
    let sample = |i: usize| level * edge(i) * (TAU * hz * i as f64 / rate_hz).sin();
    (0..count).map(sample).collect()
}

/// What a loopback does to a signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loopback {
    /// Recorded per played value at 1 kHz; negative where the polarity is inverted.
    pub gain: f64,
    /// From the sample handed to the output to the sample taken in.
    pub latency: Seconds,
}

/// The gain of the loopback of `setup` at 1 kHz, and its latency. A quiet sweep and a tone of 0.4 s are
/// played, up to three times where samples are lost or the tone does not arrive: a sound server connects its clients in the first moments.
///
/// # Errors
/// [`AudioError::Sound`] when the loopback does not hold the tone; [`AudioError::Losses`] when samples were lost in each attempt;
/// [`AudioError::Device`] when the device fails.
pub fn measured_loopback(
    streams: &mut RunningStreams,
    setup: &SoundSetup,
) -> Result<Loopback, AudioError> {
    let Some(loopback) = setup.loopback() else {
        return Err(AudioError::Setup(
            "expected an input that records what is played, found none; add one with measures = \"drive\"".into(),
        ));
    };
    let rate = streams.rate();
    let sweep = sweep_samples(rate.hz());
    let gap = rate.samples_in(GAP);
    let mut played = sweep.clone();
    played.resize(sweep.len() + gap, 0.0);
    let steady = played.len();
    played.extend(tone_samples(rate.hz(), CHECK_HZ.0, CHECK_LEVEL, CHECK_S));
    let check = Check {
        rate,
        sweep: &sweep,
        tone: &played[steady..],
        steady,
    };
    let mut last = AudioError::Losses { attempts: ATTEMPTS };
    for _ in 0..ATTEMPTS {
        let excited = excite(streams, &played)?;
        let recorded = &excited.inputs[loopback.channel as usize - 1];
        match check.loopback(recorded, excited.onset) {
            // A level with a gap in it is none.
            Ok(_) if excited.drop_outs > 0 => last = AudioError::Losses { attempts: ATTEMPTS },
            Ok(found) => return Ok(found),
            Err(error) => last = error,
        }
    }
    Err(last)
}

/// What a loopback is checked with: a sweep, which says where it is and with which polarity, and a tone behind it, which has the level.
struct Check<'a> {
    rate: SampleRate,
    sweep: &'a [f64],
    tone: &'a [f64],
    /// The first sample of the tone.
    steady: usize,
}

impl Check<'_> {
    /// What `recorded` says, of which frame `onset` was recorded when the sweep was handed over.
    fn loopback(&self, recorded: &[f64], onset: usize) -> Result<Loopback, AudioError> {
        let found = burst_delay(self.sweep, recorded)?;
        let edge = (EDGE_S * self.rate.hz()) as usize;
        let part = |samples: &[f64], from: i64| -> Vec<f64> {
            let from = usize::try_from(from).unwrap_or(0) + edge;
            let to = (from + self.tone.len() - 2 * edge).min(samples.len());
            samples[from.min(to)..to].to_vec()
        };
        let sent = tone(&part(self.tone, 0), self.rate, CHECK_HZ)?;
        let came = part(recorded, found.samples + self.steady as i64);
        let (_, came) = tone_near(&came, self.rate, CHECK_HZ, CLOCKS_SHARE)?;
        let frames = found.samples as f64 + found.fraction - onset as f64;
        Ok(Loopback {
            gain: came.rms / sent.rms * found.gain.signum(),
            latency: Seconds(frames / self.rate.hz()),
        })
    }
}

/// A linear sweep over [`SWEEP_S`] from 200 Hz to a fifth of the rate, 4 kHz at most, in a Hann window.
fn sweep_samples(rate_hz: f64) -> Vec<f64> {
    let count = (SWEEP_S * rate_hz) as usize;
    let [low, high] = [200.0, (0.2 * rate_hz).min(4_000.0)];
    let sample = |i: usize| {
        let t = i as f64 / rate_hz;
        let window = hann((i as f64 + 0.5) / count as f64);
        let phase = TAU * (low * t + 0.5 * (high - low) / SWEEP_S * t * t);
        CHECK_LEVEL * window * phase.sin()
    };
    (0..count).map(sample).collect()
}

/// The tone nearest to `frequency`, within 3 %, on the input `channel` (from 1) in `seconds` of recording, with its peak; full scale = 1. Nothing is played.
///
/// # Errors
/// [`AudioError::Sound`] when the recording is too short; [`AudioError::Losses`] when samples were lost in each of three attempts;
/// [`AudioError::Device`] when the device fails.
pub fn record_tone(
    streams: &mut RunningStreams,
    channel: u32,
    seconds: Seconds,
    frequency: Hertz,
) -> Result<(Tone, f64), AudioError> {
    let rate = streams.rate();
    let wanted = rate.samples_in(seconds);
    streams.skip();
    let mut samples = Vec::with_capacity(wanted);
    let stop = StopHandle::new();
    let mut losses = 0;
    while samples.len() < wanted {
        let Some(fetched) = streams.fetch(1, wanted - samples.len(), &stop)? else {
            break;
        };
        if fetched.lost > 0 && !samples.is_empty() {
            // A tone with a gap has another level.
            samples.clear();
            losses += 1;
            if losses == ATTEMPTS {
                return Err(AudioError::Losses { attempts: ATTEMPTS });
            }
        }
        let new = fetched.channels.get(channel as usize - 1);
        samples.extend(new.into_iter().flatten().map(|v| f64::from(*v)));
        if new.is_none() {
            return Err(AudioError::Setup(format!(
                "expected an input channel that the set-up names, found {channel}; name one of them"
            )));
        }
    }
    let (_, found) = tone_near(&samples, rate, frequency, CALIBRATOR_SHARE)?;
    Ok((found, peak(&samples)))
}

/// Which input each output of the drive arrives at: a pulse on each in its turn, on streams that `open` opens for a set-up with that output alone.
///
/// # Errors
/// [`AudioError`] when a device fails. An output that arrives on no input or on several is a finding, not an error.
pub fn wires<E: From<AudioError>>(
    setup: &SoundSetup,
    open: &mut dyn FnMut(&SoundSetup) -> Result<RunningStreams, E>,
) -> Result<Vec<Result<Wire, SoundError>>, E> {
    let mut found = Vec::new();
    for output in &setup.play.drive {
        let mut alone = setup.clone();
        alone.play.channels = Some(setup.output_channels() as u32);
        alone.play.drive = vec![*output];
        let mut streams = open(&alone)?;
        let rate = streams.rate();
        let count = ((PULSE_S * rate.hz()) as usize).max(2);
        let pulse: Vec<f64> = (0..count)
            .map(|i| PULSE_PEAK * (PI * i as f64 / count as f64).sin())
            .collect();
        let excited = excite(&mut streams, &pulse)?;
        let inputs: Vec<&[f64]> = excited.inputs.iter().map(Vec::as_slice).collect();
        found.push(wiring(*output, PULSE_PEAK, &inputs, excited.onset));
    }
    Ok(found)
}
