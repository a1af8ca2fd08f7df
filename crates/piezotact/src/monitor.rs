//! What a run shows while it is acquired: the last seconds of vibration and force, the spectrum, the coherence and the strokes until now.
//!
//! The view is for the person at the bench. Results are computed from the whole recording, never from here.

use serde::Serialize;

use crate::criterion::Outcome;
use crate::fourier::fast_length;
use crate::quantity::{Acceleration, Band, Drive, Hertz, Quantity, Seconds, Unit};
use crate::recording::{Channel, Clock, Recording};
use crate::roles::Roles;
use crate::run::{Judged, RunDocument, RunEnd, RunStart};
use crate::series::Series;
use crate::spectrum::{WelchConfig, welch};
use crate::statistics::mean;
use crate::study::{Naming, Recorded, Stated, cut};
use crate::transfer::{Estimator, estimate};

/// What is shown as present is the mean of so much, s, and what a gate judges of so much (docs/decisions/transfer-functions.md).
const NOW_S: f64 = 0.5;
const MEAN_S: f64 = 10.0;

/// How much a monitor keeps and shows.
#[derive(Clone, Debug, PartialEq)]
pub struct MonitorConfig {
    /// The length of the traces, s.
    pub window_s: f64,
    /// The number of points of a trace: of each stretch between two the smallest and the largest sample.
    pub points: usize,
    /// The stretch from which the spectrum is estimated, s.
    pub spectrum_s: f64,
    /// The length of a segment of the spectrum, s.
    pub spectrum_segment_s: f64,
    /// The length of a segment of the coherence, s: shorter than the answer of the device, it would show too little.
    pub coherence_segment_s: f64,
    /// The band over which the coherence is summed up, Hz.
    pub coherence_hz: [f64; 2],
    /// The share by which the force may depart from its target.
    pub force_share: f64,
    /// Runs with more samples of a channel are shown without coherence and strokes: memory and time stay bounded.
    pub longest_samples: usize,
}

impl MonitorConfig {
    /// Ten seconds in 400 points, 2 s of spectrum in segments of 0.2 s, coherence in segments of 0.41 s over 20–1000 Hz, ±10 % of the force,
    /// and 15 min at 5 kHz.
    ///
    /// Source: docs/decisions/campaigns.md; the tolerance of the force is that of thesis 2.5.1.
    #[must_use]
    pub fn console() -> Self {
        Self {
            window_s: 10.0,
            points: 400,
            spectrum_s: 2.0,
            spectrum_segment_s: 0.2048,
            coherence_segment_s: 0.4096,
            coherence_hz: [20.0, 1000.0],
            force_share: 0.1,
            longest_samples: 4_500_000,
        }
    }
}

/// The smallest and the largest sample of each of consecutive stretches.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Trace {
    pub channel: String,
    /// The time at the end of each stretch, s since the start of the run.
    pub at_s: Vec<f64>,
    /// The smallest sample, in the SI unit of the channel.
    pub low: Vec<f64>,
    pub high: Vec<f64>,
}

/// The level of the vibration, over the last half second about its mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct LevelNow {
    /// Rms, m/s².
    pub rms_m_s2: f64,
    /// The largest magnitude, m/s².
    pub peak_m_s2: f64,
}

/// The normal force against its target.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ForceNow {
    /// The mean of the last half second, N.
    pub now_n: f64,
    /// The mean of the last ten seconds, or of the run where it is shorter, N: this is what a gate judges.
    pub mean_n: f64,
    /// How long that is, s.
    pub mean_over_s: f64,
    /// The target, N; absent where the participant chooses the force.
    pub target_n: Option<f64>,
    /// The accepted range about the target, N.
    pub band_n: Option<[f64; 2]>,
}

/// The figures of a run at one moment.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FiguresNow {
    /// How much was acquired, s.
    pub acquired_s: f64,
    /// How much is left, s; absent where the end is not known.
    pub left_s: Option<f64>,
    /// The level of the vibration.
    pub level: Option<LevelNow>,
    pub force: Option<ForceNow>,
}

/// Values over frequency.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Lines {
    pub frequency_hz: Vec<f64>,
    /// The value of each.
    pub value: Vec<f64>,
    /// The number of segments averaged.
    pub averages: usize,
}

/// The coherence of drive and acceleration until now.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct CoherenceNow {
    /// Coherence of every line, 0–1.
    pub lines: Lines,
    /// Its median in [`MonitorConfig::coherence_hz`].
    pub median: Option<f64>,
}

/// The strokes until now. The last one may still be under way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct StrokesNow {
    pub accepted: usize,
    pub rejected: usize,
}

/// What is shown of a run, whatever its length.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct MonitorView {
    /// What the run is for; absent before the first.
    pub label: Option<String>,
    /// How much was acquired, s.
    pub acquired_s: f64,
    /// How much is left, s; absent where the end is not known.
    pub left_s: Option<f64>,
    /// The level of the vibration now.
    pub level: Option<LevelNow>,
    pub vibration: Option<Trace>,
    pub force: Option<Trace>,
    /// The normal force now.
    pub force_now: Option<ForceNow>,
    /// PSD of the vibration, (m/s²)²/Hz.
    pub spectrum: Option<Lines>,
    /// The judgements of windows until now: from when to when in s, and what came of it.
    pub judged: Vec<([f64; 2], Outcome)>,
    /// How it ended; absent while it runs.
    pub ended: Option<String>,
}

/// The run that is under way, or the last one.
#[derive(Clone, Debug)]
pub struct Monitor {
    config: MonitorConfig,
    run: Option<Watched>,
}

#[derive(Clone, Debug)]
struct Watched {
    start: RunStart,
    roles: Roles,
    /// The samples of each channel from sample `first` on.
    channels: Vec<Vec<f64>>,
    /// Samples that are kept no more.
    first: usize,
    judged: Vec<Judged>,
    end: Option<RunEnd>,
}

impl Monitor {
    /// A monitor that has seen no run.
    #[must_use]
    pub fn new(config: MonitorConfig) -> Self {
        Self { config, run: None }
    }

    /// Takes the next document.
    pub fn take(&mut self, document: &RunDocument) {
        match (document, &mut self.run) {
            (RunDocument::Start(start), _) => self.run = Some(Watched::new(start)),
            (_, None) => {}
            (RunDocument::Chunk(chunk), Some(run)) => {
                let numbers = Clock::numbered(&run.start.clocks).1;
                let of_clock =
                    run.channels.iter_mut().enumerate().filter(|(k, _)| {
                        numbers.get(*k).copied().unwrap_or(0) == chunk.clock as usize
                    });
                for ((_, channel), new) in of_clock.zip(&chunk.channels) {
                    channel.extend(new);
                }
                run.forget(&self.config);
            }
            (RunDocument::Judged(judged), Some(run)) => run.judged.push(judged.clone()),
            (RunDocument::Event(_), Some(_)) => {}
            (RunDocument::End(end), Some(run)) => run.end = Some(RunEnd::clone(end)),
        }
    }

    /// The traces, the force, the spectrum and the judgements.
    ///
    /// Source: the spectrum is that of [`welch`].
    #[must_use]
    pub fn view(&self) -> MonitorView {
        let Some(run) = &self.run else {
            return MonitorView::default();
        };
        let figures = run.figures(&self.config);
        let vibration = run.roles.vibration.first();
        let force = run.roles.normal_force.as_ref();
        let judged = run.judged.iter().rev().take(20).rev();
        MonitorView {
            label: Some(run.start.label.clone()),
            acquired_s: figures.acquired_s,
            left_s: figures.left_s,
            level: figures.level,
            vibration: vibration.and_then(|name| run.trace(name, &self.config)),
            force: force.and_then(|name| run.trace(name, &self.config)),
            force_now: figures.force,
            spectrum: vibration.and_then(|name| run.spectrum(name, &self.config)),
            judged: judged.map(|one| (one.window_s, one.outcome())).collect(),
            ended: run.end.as_ref().map(|end| end.ended.to_string()),
        }
    }

    /// The figures of the run now; `None` before the first run, and once it has ended.
    #[must_use]
    pub fn figures(&self) -> Option<FiguresNow> {
        let run = self.run.as_ref().filter(|run| run.end.is_none())?;
        Some(run.figures(&self.config))
    }

    /// The coherence of drive and vibration until now; `None` without a drive, before four segments, or in a run that is too long.
    /// Takes time in proportion to the run.
    ///
    /// Source: [`estimate`].
    #[must_use]
    pub fn coherence(&self) -> Option<CoherenceNow> {
        let run = self.run.as_ref().filter(|run| run.first == 0)?;
        let drive = run
            .start
            .channels
            .iter()
            .find(|(_, unit)| *unit == Drive::UNIT)?;
        let vibration = run.roles.vibration.first()?;
        let (drive, response) = (run.samples(&drive.0)?, run.samples(vibration)?);
        let segment = run.segment(self.config.coherence_segment_s);
        let common = drive.len().min(response.len());
        if common < 3 * segment {
            return None;
        }
        let drive = Series::<Drive>::new(drive[..common].to_vec(), run.start.rate_hz).ok()?;
        let response =
            Series::<Acceleration>::new(response[..common].to_vec(), run.start.rate_hz).ok()?;
        let config = WelchConfig::hann(segment);
        let function = estimate(&drive, &response, &config, Estimator::H1).ok()?;
        let [low, high] = self.config.coherence_hz.map(Hertz);
        let band = Band::new(low, high).ok();
        let band = band.and_then(|band| function.coherence_in(band));
        Some(CoherenceNow {
            lines: Lines {
                frequency_hz: function.frequencies_hz(),
                value: function.coherence().to_vec(),
                averages: function.averages,
            },
            median: band.map(|summary| summary.median),
        })
    }

    /// The strokes until now; `None` where a finger rests, nothing can be cut yet, or the run is too long. Takes time in proportion to the
    /// run.
    ///
    /// Source: [`cut`].
    #[must_use]
    pub fn strokes(&self) -> Option<StrokesNow> {
        let run = self.run.as_ref().filter(|run| run.first == 0)?;
        let is_played = run
            .start
            .channels
            .iter()
            .any(|(_, unit)| *unit == Drive::UNIT);
        if is_played {
            return None;
        }
        let recorded = Recorded {
            file: run.start.label.clone(),
            name: run.start.label.clone(),
            recording: run.recording()?,
            naming: Naming::default(),
            cuts: None,
            cuts_are_looked_for_in: String::new(),
        };
        let take = cut(recorded, &Stated::nothing()).ok()?;
        Some(StrokesNow {
            accepted: take.segmentation.strokes.len(),
            rejected: take.segmentation.rejected.len(),
        })
    }
}

impl Watched {
    fn new(start: &RunStart) -> Self {
        let empty = |(name, unit): &(String, Unit)| Channel {
            name: name.clone(),
            unit: unit.clone(),
            // One sample, as a recording without any has no roles.
            samples: vec![0.0],
        };
        let channels = start.channels.iter().map(empty).collect();
        let about = start.about.clone();
        let recording = Recording::on_clocks(channels, start.rate_hz, &[], about);
        let roles = recording.map(|recording| Roles::guess(&recording).0);
        Self {
            start: start.clone(),
            roles: roles.unwrap_or_default(),
            channels: vec![Vec::new(); start.channels.len()],
            first: 0,
            judged: Vec::new(),
            end: None,
        }
    }

    fn rate_hz(&self) -> f64 {
        self.start.rate_hz.hz()
    }

    /// Samples until now.
    fn acquired(&self) -> usize {
        self.first + self.channels.iter().map(Vec::len).max().unwrap_or(0)
    }

    /// Forgets all but the last window of a run that is too long.
    fn forget(&mut self, config: &MonitorConfig) {
        let kept = self.channels.iter().map(Vec::len).max().unwrap_or(0);
        let window = (config.window_s.max(config.spectrum_s) * self.rate_hz()) as usize;
        let longest = match self.first {
            0 => config.longest_samples,
            _ => 4 * window,
        };
        if kept <= longest.max(window) {
            return;
        }
        let gone = kept - window;
        for channel in &mut self.channels {
            channel.drain(..gone.min(channel.len()));
        }
        self.first += gone;
    }

    fn samples(&self, name: &str) -> Option<&[f64]> {
        let at = self
            .start
            .channels
            .iter()
            .position(|(other, _)| other == name)?;
        self.channels.get(at).map(Vec::as_slice)
    }

    fn trace(&self, name: &str, config: &MonitorConfig) -> Option<Trace> {
        let samples = self.samples(name)?;
        let stretch = (config.window_s * self.rate_hz() / config.points as f64).max(1.0) as usize;
        // Stretches begin at the same samples in every view: a trace moves, and does not flicker.
        let window = stretch * config.points;
        let acquired = self.first + samples.len();
        let from = acquired.saturating_sub(window) / stretch * stretch;
        let mut trace = Trace {
            channel: name.to_owned(),
            ..Trace::default()
        };
        let mut at = from.max(self.first);
        while at < acquired {
            let end = (at / stretch + 1) * stretch;
            let end = end.min(acquired);
            let part = &samples[at - self.first..end - self.first];
            trace.at_s.push(end as f64 / self.rate_hz());
            trace
                .low
                .push(part.iter().copied().fold(f64::INFINITY, f64::min));
            trace
                .high
                .push(part.iter().copied().fold(f64::NEG_INFINITY, f64::max));
            at = end;
        }
        (!trace.at_s.is_empty()).then_some(trace)
    }

    /// The samples of a segment of `s` seconds that transforms quickly.
    fn segment(&self, s: f64) -> usize {
        fast_length((s * self.rate_hz()).round() as usize)
    }

    /// The last `s` seconds of a channel, or all of it.
    fn last(&self, name: &str, s: f64) -> Option<&[f64]> {
        let samples = self.samples(name)?;
        let count = (s * self.rate_hz()) as usize;
        let last = &samples[samples.len().saturating_sub(count)..];
        (!last.is_empty()).then_some(last)
    }

    fn figures(&self, config: &MonitorConfig) -> FiguresNow {
        let acquired_s = self.acquired() as f64 / self.rate_hz();
        let left = |expected: Seconds| (expected.0 - acquired_s).max(0.0);
        let vibration = self.roles.vibration.first();
        let force = self.roles.normal_force.as_ref();
        FiguresNow {
            acquired_s,
            left_s: self.start.expected_s.map(left),
            level: vibration.and_then(|name| self.level_now(name)),
            force: force.and_then(|name| self.force_now(name, config)),
        }
    }

    fn level_now(&self, name: &str) -> Option<LevelNow> {
        let last = self.last(name, NOW_S)?;
        let about = mean(last);
        let squares: f64 = last.iter().map(|v| (v - about).powi(2)).sum();
        Some(LevelNow {
            rms_m_s2: (squares / last.len() as f64).sqrt(),
            peak_m_s2: last.iter().map(|v| (v - about).abs()).fold(0.0, f64::max),
        })
    }

    fn force_now(&self, name: &str, config: &MonitorConfig) -> Option<ForceNow> {
        let judged = self.last(name, MEAN_S)?;
        let target_n = self.start.about.condition.load_n.map(|load| load.0);
        let share = config.force_share;
        Some(ForceNow {
            now_n: mean(self.last(name, NOW_S)?),
            mean_n: mean(judged),
            mean_over_s: judged.len() as f64 / self.rate_hz(),
            target_n,
            band_n: target_n.map(|target| [target * (1.0 - share), target * (1.0 + share)]),
        })
    }

    fn spectrum(&self, name: &str, config: &MonitorConfig) -> Option<Lines> {
        let samples = self.samples(name)?;
        let wanted = (config.spectrum_s * self.rate_hz()) as usize;
        let last = &samples[samples.len().saturating_sub(wanted)..];
        let series = Series::<Acceleration>::new(last.to_vec(), self.start.rate_hz).ok()?;
        let spectrum = welch(
            &series,
            &WelchConfig::hann(self.segment(config.spectrum_segment_s)),
        )
        .ok()?;
        Some(Lines {
            frequency_hz: spectrum.frequencies_hz(),
            averages: spectrum.averages,
            value: spectrum.values,
        })
    }

    fn recording(&self) -> Option<Recording> {
        let named = self.start.channels.iter().zip(&self.channels);
        let channels = named.map(|((name, unit), samples)| Channel {
            name: name.clone(),
            unit: unit.clone(),
            samples: samples.clone(),
        });
        let (rate, clocks) = (self.start.rate_hz, &self.start.clocks);
        Recording::on_clocks(channels.collect(), rate, clocks, self.start.about.clone()).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::{Newtons, SampleRate};
    use crate::recording::{About, Annotations, Condition, Provenance};
    use crate::run::RunChunk;

    const RATE_HZ: f64 = 1000.0;

    fn start() -> RunDocument {
        let condition = Condition {
            load_n: Some(Newtons(0.2)),
            ..Condition::default()
        };
        let named = |name: &str, unit| (name.to_owned(), unit);
        RunDocument::Start(Box::new(RunStart {
            label: "run".into(),
            rate_hz: SampleRate::new(RATE_HZ).unwrap(),
            channels: vec![
                named("drive", Drive::UNIT),
                named("acceleration", Acceleration::UNIT),
                named("normal_force", Unit::Newton),
            ],
            about: About::new(condition, Provenance::default()),
            annotations: Annotations::default(),
            clocks: Vec::new(),
            setup: None,
            drive: None,
            expected_s: Some(Seconds(30.0)),
        }))
    }

    /// Chunks of 50 samples up to `end_s`: a pseudo-random drive, twice of which is felt, and a force of 0.25 N.
    fn fed(monitor: &mut Monitor, end_s: f64) {
        monitor.take(&start());
        let mut state = 1u64;
        let all = (end_s * RATE_HZ) as usize;
        for first in (0..all).step_by(50) {
            let drive: Vec<f64> = (0..50)
                .map(|_| {
                    state = state
                        .wrapping_mul(6_364_136_223_846_793_005)
                        .wrapping_add(1);
                    (state >> 40) as f64 / f64::from(1 << 24) - 0.5
                })
                .collect();
            let felt = drive.iter().map(|drive| 2.0 * drive).collect();
            monitor.take(&RunDocument::Chunk(RunChunk {
                first: first as u64,
                channels: vec![drive, felt, vec![0.25; 50]],
                ..RunChunk::default()
            }));
        }
    }

    #[test]
    fn a_monitor_shows_the_last_seconds_and_what_they_say() {
        let mut monitor = Monitor::new(MonitorConfig {
            spectrum_segment_s: 0.256,
            coherence_segment_s: 0.256,
            ..MonitorConfig::console()
        });
        assert_eq!(monitor.view(), MonitorView::default());
        fed(&mut monitor, 20.0);
        let view = monitor.view();
        assert!((view.acquired_s - 20.0).abs() < 1e-9);
        let trace = view.vibration.unwrap();
        assert_eq!(
            (trace.channel.as_str(), trace.at_s.len()),
            ("acceleration", 400)
        );
        assert!((trace.at_s[0] - 10.025).abs() < 1e-9 && (trace.at_s[399] - 20.0).abs() < 1e-9);
        assert!(
            trace
                .low
                .iter()
                .zip(&trace.high)
                .all(|(low, high)| low < high)
        );
        let force = view.force_now.unwrap();
        assert!((force.now_n - 0.25).abs() < 1e-12);
        assert!((force.mean_n - 0.25).abs() < 1e-12 && (force.mean_over_s - 10.0).abs() < 1e-9);
        assert_eq!(view.left_s, Some(10.0));
        // Uniform between −1 and 1.
        let level = view.level.unwrap();
        assert!(
            (level.rms_m_s2 - 3f64.sqrt().recip()).abs() < 0.05,
            "{level:?}"
        );
        assert!(level.peak_m_s2 > 0.9 && level.peak_m_s2 < 1.05, "{level:?}");
        let [low, high] = force.band_n.unwrap();
        assert!((low - 0.18).abs() < 1e-12 && (high - 0.22).abs() < 1e-12);
        // White noise of 2·(1/12)^½ over 500 Hz.
        let spectrum = view.spectrum.unwrap();
        let level = mean(&spectrum.value[5..120]);
        assert!((level / (4.0 / 12.0 / 500.0) - 1.0).abs() < 0.1, "{level}");
        let coherence = monitor.coherence().unwrap();
        assert!(coherence.median.unwrap() > 0.999_999);
        assert_eq!(
            monitor.strokes(),
            None,
            "a finger that rests makes no strokes"
        );
    }

    #[test]
    fn a_long_run_takes_bounded_memory() {
        let mut monitor = Monitor::new(MonitorConfig {
            longest_samples: 60_000,
            ..MonitorConfig::console()
        });
        fed(&mut monitor, 300.0);
        let run = monitor.run.as_ref().unwrap();
        assert!(run.channels[0].len() <= 40_000, "{}", run.channels[0].len());
        assert_eq!(run.acquired(), 300_000);
        assert_eq!(monitor.coherence(), None);
        let trace = monitor.view().vibration.unwrap();
        assert!((trace.at_s.last().unwrap() - 300.0).abs() < 1e-9);
        // The next run is whole again.
        fed(&mut monitor, 20.0);
        assert!(monitor.coherence().is_some());
    }
}
