//! The EEG of one session, channel by channel.

use std::f64::consts::TAU;

use piezotact::quantity::Unit;
use piezotact::recording::{BenchKind, Channel, Condition, Provenance, Recording, Touch};
use piezotact_bench::random::Random;

use super::brain::background_v;
use super::head::{HEOG, Mixture, VEOG, between, gain, place};
use super::protocol::{EegProtocol, Schedule, Task};
use super::session::{Courses, muscle_planning_s};
use super::spectrum::{Amplitudes, Noise, background, muscle};
use crate::error::TwinError;
use crate::{Participant, TwinParameters};

/// The EEG of `participant` in the session of `protocol`, V against an ideal reference: one channel for each that the protocol names.
/// Each trial is an event of the kind of the task with the name of its surface, each rest one of the kind `rest`. Another `label` gives another
/// recording of the same person.
///
/// Formula: background 1/f^β + Σ g·A·α(t)·√(1 + c·r(t)) + evoked response + eyes + muscles + mains, with c the change of the source's power
/// at the plateau and r(t) a logistic rise after the onset and fall after the end.
///
/// Source: *thesis* chapter 6 for the order of tasks; G. Pfurtscheller and F. H. Lopes da Silva (1999), Clin. Neurophysiol. 110, for sources
/// that lose power; amplitudes as the parameter file states.
///
/// # Errors
/// [`TwinError`] for a protocol with a number outside its range, a surface or channel that the twin does not have, or more samples than
/// 2 GiB hold.
pub fn record(
    parameters: &TwinParameters,
    participant: &Participant,
    protocol: &EegProtocol,
    label: &str,
) -> Result<Recording, TwinError> {
    protocol.check(parameters)?;
    let streams = Streams::of(participant, protocol.task, label);
    let schedule = Schedule::of(protocol, streams.random("schedule"));
    let mut noise = Noise::of(schedule.length, protocol.rate.hz());
    let courses = Courses::of(
        (parameters, participant),
        protocol,
        &schedule,
        &streams,
        &mut noise,
    );
    let person = (parameters, participant);
    let mut samples = backgrounds(person, protocol, &streams, &mut noise);
    let muscles = noise.amplitudes(muscle(&parameters.eeg.muscle));
    for (name, channel) in protocol.channels.iter().zip(&mut samples) {
        add_courses(parameters, name, &courses, channel);
        add_muscles(
            parameters,
            name,
            (&streams, &courses.effort),
            (&mut noise, &muscles),
            channel,
        );
        add_mains(person, name, (&streams, protocol.rate.hz()), channel);
    }
    let channels = protocol.channels.iter().zip(samples);
    let channels = channels.map(|(name, samples)| Channel {
        name: name.clone(),
        unit: Unit::Volt,
        samples,
    });
    let mut recording = Recording::new(
        channels.collect(),
        protocol.rate,
        condition(participant, protocol.task),
        provenance(parameters, participant, protocol, label),
    )?;
    let planning_s = muscle_planning_s(parameters, protocol.task);
    recording.annotations.events = schedule.events(protocol, planning_s);
    Ok(recording)
}

/// The random numbers of one recording, by what they are for.
pub(super) struct Streams<'a> {
    participant: &'a Participant,
    recording: String,
}

impl<'a> Streams<'a> {
    fn of(participant: &'a Participant, task: Task, label: &str) -> Self {
        Self {
            participant,
            recording: format!("eeg {task} {label}"),
        }
    }

    /// Those of `what`.
    pub(super) fn random(&self, what: &str) -> Random {
        self.participant
            .random(&format!("{} {what}", self.recording))
    }
}

/// The background of each channel, V. Independent backgrounds are drawn one after the other, so that no more than one is kept.
fn backgrounds(
    (parameters, participant): (&TwinParameters, &Participant),
    protocol: &EegProtocol,
    streams: &Streams<'_>,
    noise: &mut Noise,
) -> Vec<Vec<f64>> {
    let mixture = Mixture::of(&parameters.eeg);
    let amplitudes = noise.amplitudes(background(&parameters.eeg.background));
    let channels = protocol.channels.iter();
    let rows: Vec<(f64, &[f64])> = channels
        .map(|name| {
            let level_v = background_v(parameters, participant, name);
            (level_v, mixture.row(name).unwrap_or_default())
        })
        .collect();
    let length = noise.length();
    let mut samples = vec![vec![0.0; length]; rows.len()];
    let most = rows.iter().map(|(_, row)| row.len()).max().unwrap_or(0);
    for k in 0..most {
        let stream = streams.random(&format!("background {}", mixture.stream(k)));
        let drawn = noise.draw(stream, &amplitudes);
        for ((level_v, row), channel) in rows.iter().zip(&mut samples) {
            if let Some(share) = row.get(k) {
                add(channel, level_v * share, drawn);
            }
        }
    }
    // What is not on the scalp has a background of its own.
    for ((name, (level_v, row)), channel) in protocol.channels.iter().zip(rows).zip(&mut samples) {
        if row.is_empty() {
            let stream = streams.random(&format!("background {name}"));
            add(channel, level_v, noise.draw(stream, &amplitudes));
        }
    }
    samples
}

fn add(channel: &mut [f64], factor: f64, course: &[f64]) {
    for (sample, value) in channel.iter_mut().zip(course) {
        *sample += factor * value;
    }
}

/// What of each course is seen at `name`.
fn add_courses(parameters: &TwinParameters, name: &str, courses: &Courses, channel: &mut [f64]) {
    let eeg = &parameters.eeg;
    let Some(at) = place(name) else {
        match name {
            VEOG => add(channel, eeg.eyes.eog_ratio, &courses.blinks),
            HEOG => add(channel, 1.0, &courses.gaze),
            _ => {}
        }
        return;
    };
    let seen = |source, source_m| gain(at, source, source_m, eeg.head_m);
    let named = |source: &str| between(source, source);
    let alpha_m = eeg.alpha.source_m;
    let front = |from: &str| seen(named(from), eeg.eyes.reach_m);
    let blink = seen(named("Fpz"), eeg.eyes.reach_m)
        / gain(named("Fp1"), named("Fpz"), eeg.eyes.reach_m, eeg.head_m);
    add(channel, seen(between("C3", "CP3"), alpha_m), &courses.mu);
    add(channel, seen(between("FCz", "Cz"), alpha_m), &courses.sma);
    add(channel, seen(named("Oz"), alpha_m), &courses.occiput);
    add(
        channel,
        seen(named("CP3"), eeg.evoked.source_m),
        &courses.evoked,
    );
    add(channel, blink, &courses.blinks);
    add(
        channel,
        eeg.eyes.movement_share * (front("F8") - front("F7")),
        &courses.gaze,
    );
}

/// Muscles, of their own in each channel.
fn add_muscles(
    parameters: &TwinParameters,
    name: &str,
    (streams, effort): (&Streams<'_>, &[f64]),
    (noise, amplitudes): (&mut Noise, &Amplitudes),
    channel: &mut [f64],
) {
    let model = &parameters.eeg.muscle;
    let near = place(name).map_or(0.0, |at| {
        let to = |temple: &str| {
            gain(
                at,
                between(temple, temple),
                model.reach_m,
                parameters.eeg.head_m,
            )
        };
        to("T7").max(to("T8"))
    });
    let level_v = model.rms_v * (model.everywhere + (1.0 - model.everywhere) * near);
    let drawn = noise.draw(streams.random(&format!("muscles {name}")), amplitudes);
    for ((sample, value), effort) in channel.iter_mut().zip(drawn).zip(effort) {
        *sample += level_v * effort * value;
    }
}

/// The mains, of a phase and an amplitude of its own in each channel.
fn add_mains(
    (parameters, participant): (&TwinParameters, &Participant),
    name: &str,
    (streams, rate_hz): (&Streams<'_>, f64),
    channel: &mut [f64],
) {
    let line = &parameters.eeg.line;
    let mut random = streams.random(&format!("mains {name}"));
    let (phase, own) = (TAU * random.uniform(), random.normal());
    let amplitude_v = match participant.number {
        0 => line.amplitude_v,
        _ => line.amplitude_v * (line.amplitude_spread * own).exp(),
    };
    let turn = TAU * line.frequency_hz / rate_hz;
    for (i, sample) in channel.iter_mut().enumerate() {
        *sample += amplitude_v * (turn * i as f64 + phase).sin();
    }
}

fn condition(participant: &Participant, task: Task) -> Condition {
    Condition {
        participant: Some(participant.pseudonym()),
        twin_seed: Some(participant.seed),
        touch: Some(match task {
            Task::Natural => Touch::Active,
            Task::Control | Task::Imagery => Touch::Resting,
        }),
        ..Condition::default()
    }
}

fn provenance(
    parameters: &TwinParameters,
    participant: &Participant,
    protocol: &EegProtocol,
    label: &str,
) -> Provenance {
    Provenance {
        source: "digital twin, EEG".into(),
        bench: Some(BenchKind::Twin),
        seed: Some(participant.seed),
        steps: vec![
            format!(
                "task {}, {} trials of {} s on each of {}, label {label}; ideal reference",
                protocol.task,
                protocol.trials_per_surface,
                protocol.touch_s,
                protocol.surfaces.join(", "),
            ),
            parameters.provenance(),
        ],
        ..Provenance::default()
    }
}
