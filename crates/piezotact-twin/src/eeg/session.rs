//! What the sources of an EEG do over one session.

use std::f64::consts::TAU;

use piezotact_bench::random::Random;

use super::brain::plateau;
use super::generate::Streams;
use super::protocol::{EegProtocol, Schedule, Task};
use super::spectrum::{Noise, alpha};
use crate::parameters::EegEyes;
use crate::{Participant, TwinParameters};

/// So many scales from its middle a logistic function has arrived: all but 2e-9.
const ARRIVED: f64 = 20.0;

/// The course of each source, one value for each sample. All are in V at their centre, apart from the effort.
pub(super) struct Courses {
    /// Mu over the left sensorimotor cortex.
    pub(super) mu: Vec<f64>,
    /// The same over the SMA.
    pub(super) sma: Vec<f64>,
    /// Alpha of the occiput.
    pub(super) occiput: Vec<f64>,
    pub(super) evoked: Vec<f64>,
    /// Blinks, at Fp1.
    pub(super) blinks: Vec<f64>,
    /// Horizontal movements of the eyes, right minus left.
    pub(super) gaze: Vec<f64>,
    /// The amplitude of muscles relative to rest.
    pub(super) effort: Vec<f64>,
}

impl Courses {
    pub(super) fn of(
        (parameters, participant): (&TwinParameters, &Participant),
        protocol: &EegProtocol,
        schedule: &Schedule,
        streams: &Streams<'_>,
        noise: &mut Noise,
    ) -> Self {
        let (eeg, brain) = (&parameters.eeg, &participant.brain);
        let rate_hz = protocol.rate.hz();
        let changing = amplitude((parameters, participant), protocol, schedule);
        let rhythm = noise.amplitudes(alpha(brain.alpha_hz, eeg.alpha.bandwidth_hz));
        let mut source = |name: &str, rms_v: f64| -> Vec<f64> {
            let drawn = noise.draw(streams.random(name), &rhythm);
            drawn.iter().map(|value| rms_v * value).collect()
        };
        let mut mu = source("mu", brain.mu_v);
        let mut sma = source("sma", brain.mu_v * eeg.alpha.sma_share);
        let occiput = source("occiput", brain.occipital_v);
        for source in [&mut mu, &mut sma] {
            for (value, factor) in source.iter_mut().zip(&changing) {
                *value *= factor;
            }
        }
        Self {
            mu,
            sma,
            occiput,
            evoked: evoked((parameters, participant), protocol, schedule),
            blinks: blinks(
                &eeg.eyes,
                streams.random("blinks"),
                schedule.length,
                rate_hz,
            ),
            gaze: gaze(&eeg.eyes, streams.random("gaze"), schedule.length, rate_hz),
            effort: effort(parameters, protocol, schedule),
        }
    }
}

/// From when before the contact on a movement is planned in `task`, s; 0 where none is made.
pub(super) fn muscle_planning_s(parameters: &TwinParameters, task: Task) -> f64 {
    match task {
        Task::Natural => parameters.eeg.muscle.planning_s,
        Task::Control | Task::Imagery => 0.0,
    }
}

/// A logistic rise at `from_s` and fall at `to_s`, both of the scale `width_s`, at `time_s`; 1 between them.
pub(super) fn between_s(time_s: f64, [from_s, to_s]: [f64; 2], width_s: f64) -> f64 {
    let step = |at_s: f64| 1.0 / (1.0 + (-(time_s - at_s) / width_s).exp());
    step(from_s) - step(to_s)
}

/// Adds `value` of the time from the onset, s, to each sample of `course` from `from_s` to `to_s` about the onset.
fn add_around(
    course: &mut [f64],
    (onset, rate_hz): (usize, f64),
    [from_s, to_s]: [f64; 2],
    value: impl Fn(f64) -> f64,
) {
    let first = (onset as f64 + (from_s * rate_hz).floor()).max(0.0) as usize;
    let last = (onset as f64 + (to_s * rate_hz).ceil()).max(0.0) as usize;
    let end = (last + 1).min(course.len());
    for (i, sample) in course[..end].iter_mut().enumerate().skip(first) {
        *sample += value((i as f64 - onset as f64) / rate_hz);
    }
}

/// Adds a plateau of `height` from `from_s` to `to_s` about each onset.
fn add_plateau(
    course: &mut [f64],
    onset: (usize, f64),
    (plateau_s, width_s): ([f64; 2], f64),
    height: f64,
) {
    let reach_s = ARRIVED * width_s;
    let around_s = [plateau_s[0] - reach_s, plateau_s[1] + reach_s];
    add_around(course, onset, around_s, |time_s| {
        height * between_s(time_s, plateau_s, width_s)
    });
}

/// The amplitude of mu and SMA relative to rest, √(1 + c·r(t)).
fn amplitude(
    (parameters, participant): (&TwinParameters, &Participant),
    protocol: &EegProtocol,
    schedule: &Schedule,
) -> Vec<f64> {
    let model = &parameters.eeg.desynchronisation;
    let surfaces = protocol.surfaces.iter();
    let changes: Vec<f64> = surfaces
        .map(|surface| plateau(parameters, participant, protocol.task, surface))
        .collect();
    let mut power = vec![1.0; schedule.length];
    let plateau_s = [model.onset_s, protocol.touch_s + model.onset_s];
    for trial in &schedule.trials {
        add_plateau(
            &mut power,
            (trial.onset, protocol.rate.hz()),
            (plateau_s, model.onset_width_s),
            changes[trial.surface],
        );
    }
    for value in &mut power {
        *value = value.max(0.0).sqrt();
    }
    power
}

fn evoked(
    (parameters, participant): (&TwinParameters, &Participant),
    protocol: &EegProtocol,
    schedule: &Schedule,
) -> Vec<f64> {
    let model = &parameters.eeg.evoked;
    let of_task = match protocol.task {
        Task::Natural => model.natural_gain,
        Task::Control => 1.0,
        Task::Imagery => model.imagery_gain,
    };
    let mut course = vec![0.0; schedule.length];
    let peaks = model.latency_s.iter().zip(&model.share).zip(&model.width_s);
    for ((latency_s, share), width_s) in peaks {
        let height_v = participant.brain.evoked_v * of_task * share;
        // Beyond 8 standard deviations there is less than 1e-13 of it.
        let around_s = [latency_s - 8.0 * width_s, latency_s + 8.0 * width_s];
        for trial in &schedule.trials {
            let onset = (trial.onset, protocol.rate.hz());
            add_around(&mut course, onset, around_s, |time_s| {
                let off = (time_s - latency_s) / width_s;
                height_v * (-0.5 * off * off).exp()
            });
        }
    }
    course
}

/// Blinks at random times, none within another; each is a raised cosine.
fn blinks(model: &EegEyes, mut random: Random, length: usize, rate_hz: f64) -> Vec<f64> {
    let mut course = vec![0.0; length];
    if model.blinks_per_min <= 0.0 {
        return course;
    }
    let between_s = (60.0 / model.blinks_per_min - model.blink_s).max(0.0);
    let mut at_s = 0.0;
    loop {
        at_s -= between_s * (1.0 - random.uniform()).ln();
        let first = (at_s * rate_hz).round() as usize;
        if first >= length {
            return course;
        }
        let peak_v = model.blink_v * (model.blink_spread * random.normal()).exp();
        add_around(
            &mut course,
            (first, rate_hz),
            [0.0, model.blink_s],
            |time_s| {
                let turn = (time_s / model.blink_s).clamp(0.0, 1.0);
                peak_v * (0.5 - 0.5 * (TAU * turn).cos())
            },
        );
        at_s += model.blink_s;
    }
}

/// The gaze: an Ornstein-Uhlenbeck process.
fn gaze(model: &EegEyes, mut random: Random, length: usize, rate_hz: f64) -> Vec<f64> {
    let kept = (-1.0 / (model.movement_memory_s * rate_hz)).exp();
    let new_v = model.movement_v * (1.0 - kept * kept).sqrt();
    let mut gaze_v = model.movement_v * random.normal();
    (0..length)
        .map(|_| {
            let now_v = gaze_v;
            gaze_v = kept * gaze_v + new_v * random.normal();
            now_v
        })
        .collect()
}

/// How much the muscles do relative to rest: more while a movement is planned and made.
fn effort(parameters: &TwinParameters, protocol: &EegProtocol, schedule: &Schedule) -> Vec<f64> {
    let mut course = vec![1.0; schedule.length];
    if protocol.task != Task::Natural {
        return course;
    }
    let (model, width_s) = (
        &parameters.eeg.muscle,
        parameters.eeg.desynchronisation.onset_width_s,
    );
    for trial in &schedule.trials {
        add_plateau(
            &mut course,
            (trial.onset, protocol.rate.hz()),
            ([-model.planning_s, protocol.touch_s], width_s),
            model.natural_ratio - 1.0,
        );
    }
    course
}
