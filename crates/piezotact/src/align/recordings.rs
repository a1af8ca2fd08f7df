//! Two files on one clock: which of their channels are compared, and the recording with all its channels on the clock of the drive.

use serde::{Deserialize, Serialize};

use super::{
    AlignConfig, AlignError, AlignFault, AlignWarning, Alignment, Bursts, align, align_with_bursts,
    place,
};
use crate::document::Content;
use crate::number::plus;
use crate::quantity::{Drive, Hertz, Quantity as _, SampleRate, Seconds, Unit};
use crate::recording::{Annotations, Channel, Clock, Event, Recording};
use crate::resample::Resampler;
use crate::warning::Warnings;

/// The label of the time of the first sample on the clock of the drive, s.
pub const FIRST_SAMPLE: &str = "first_sample_on_drive_s";
/// The channel of the drive.
const DRIVE: &str = "drive";
/// The same where the recording has one of that name.
const PLAYED: &str = "played_drive";

/// A signal of a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct SignalOf {
    /// The file.
    pub file: String,
    /// The channel.
    pub channel: String,
    /// Its rate by its own clock.
    pub rate_hz: SampleRate,
    /// Its length by its own clock, s.
    pub length_s: Seconds,
}

/// A recording on the clock of a drive, as it is handed out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct AlignedRecording {
    /// The drive.
    pub drive: SignalOf,
    /// The channel of the recording in which it was found.
    pub recording: SignalOf,
    /// How the two clocks relate.
    #[serde(flatten)]
    pub alignment: Alignment,
    /// The file with the recording on the clock of the drive, if it was asked for.
    pub out: Option<String>,
}

impl Content for AlignedRecording {
    const SCHEMA: &'static str = "align";
}

/// A file with its name.
#[derive(Clone, Copy, Debug)]
pub struct Named<'a> {
    /// The name of the file.
    pub file: &'a str,
    /// What is in it.
    pub recording: &'a Recording,
}

/// The channels of two files that are compared.
#[derive(Clone, Copy, Debug)]
pub struct Compared<'a> {
    drive: (Named<'a>, &'a Channel, Clock),
    recorded: (Named<'a>, &'a Channel, Clock),
}

impl<'a> Compared<'a> {
    /// The drive of one file, which is its channel `drive` or its only one in shares of full scale, and the channel `channel` of another, or the only one,
    /// or the only one of acceleration.
    ///
    /// # Errors
    /// [`AlignError::NoDrive`] for a file without a drive, [`AlignError::Recording`] for a channel that is not there, or that has to be named.
    pub fn of(
        drive: Named<'a>,
        recorded: Named<'a>,
        channel: Option<&str>,
    ) -> Result<Self, AlignError> {
        let all = drive.recording.channels();
        let named = all.iter().find(|one| one.name == DRIVE);
        let mut in_unit = all.iter().filter(|one| one.unit == Drive::UNIT);
        let only = in_unit.next().filter(|_| in_unit.next().is_none());
        let played = named.filter(|one| one.unit == Drive::UNIT).or(only);
        let played = played.ok_or_else(|| {
            let names = all.iter().map(|one| format!("{} [{}]", one.name, one.unit));
            AlignError::NoDrive {
                found: names.collect::<Vec<_>>().join(", "),
            }
        })?;
        let own = recorded
            .recording
            .pick(channel, &Unit::MetrePerSecondSquared)?;
        Ok(Self {
            drive: (drive, played, drive.recording.clock_of(&played.name)),
            recorded: (recorded, own, recorded.recording.clock_of(&own.name)),
        })
    }

    /// The usual settings at their rates.
    ///
    /// # Errors
    /// [`AlignError::Rate`] for a rate that leaves no band.
    pub fn usual(&self) -> Result<AlignConfig, AlignError> {
        AlignConfig::usual(self.drive.2.rate_hz, self.recorded.2.rate_hz)
    }
}

fn signal((named, channel, clock): (Named<'_>, &Channel, Clock)) -> SignalOf {
    SignalOf {
        file: named.file.to_owned(),
        channel: channel.name.clone(),
        rate_hz: clock.rate_hz,
        length_s: clock.rate_hz.duration_of(channel.samples.len()),
    }
}

/// The recording on the clock of the drive: offset and drift of its compared channel, by the bursts too that the file of the drive states.
/// Warnings are those of both files and of the alignment.
///
/// Source: [`align`], [`align_with_bursts`].
///
/// # Errors
/// Those of [`align_with_bursts`].
pub fn align_recordings(
    compared: &Compared<'_>,
    config: &AlignConfig,
) -> Result<AlignedRecording, AlignError> {
    let samples = |(_, channel, clock): (Named<'_>, &'_ Channel, Clock)| {
        (channel.samples.clone(), clock.rate_hz)
    };
    let (drive, recorded) = (samples(compared.drive), samples(compared.recorded));
    let both = ((&*drive.0, drive.1), (&*recorded.0, recorded.1));
    let events = on_clock(
        &compared.drive.0.recording.annotations.events,
        compared.drive.2.start_s,
    );
    let mut alignment = match Bursts::of_events(&events) {
        Some(bursts) => align_with_bursts(both.0, both.1, &bursts, config)?,
        None => align(both.0, both.1, config)?,
    };
    let of = compared.recorded;
    let others = of.0.recording.channels_with_clocks();
    let others = others.filter(|(_, clock)| *clock != of.2);
    let others: Vec<String> = others.map(|(one, _)| one.name.clone()).collect();
    if !others.is_empty() {
        alignment.warnings.push(
            AlignWarning::Doubtful {
                fault: AlignFault::OtherClocks {
                    channels: others.join(", "),
                },
            }
            .into(),
        );
    }
    let about = [compared.drive.0, of.0].map(|named| &named.recording.about.warnings);
    let before = about.into_iter().flatten();
    let warnings: Warnings = before.chain(&alignment.warnings).cloned().collect();
    alignment.warnings = warnings.into();
    Ok(AlignedRecording {
        drive: signal(compared.drive),
        recording: signal(of),
        alignment,
        out: None,
    })
}

/// Events from the start of a clock on.
fn on_clock(events: &[Event], start_s: Seconds) -> Vec<Event> {
    let moved = events.iter().map(|event| Event {
        onset_s: Seconds(event.onset_s.0 - start_s.0),
        ..event.clone()
    });
    moved.collect()
}

impl AlignedRecording {
    /// The recording with all its channels and events on the clock of the drive, each channel at its own nominal rate, in its unit; and the drive in
    /// a channel of its own at the rate of the compared one, silent outside. The events of the drive are there too, and a label says at
    /// which time of the drive the first sample is.
    ///
    /// Formula: band-limited interpolation by a sinc of 64 samples in a Kaiser window.
    ///
    /// Source: [`Alignment::placed`].
    ///
    /// # Errors
    /// [`AlignError::Series`] for rates without a common cycle; [`AlignError::Recording`] where nothing of a channel is left.
    pub fn on_drive(&self, compared: &Compared<'_>) -> Result<Recording, AlignError> {
        let alignment = &self.alignment;
        let (named, own, clock) = compared.recorded;
        let recording = named.recording;
        let mut channels: Vec<(Channel, Clock)> = Vec::new();
        let mut of_own = None;
        for (channel, of) in recording.channels_with_clocks() {
            let start_s = Seconds(of.start_s.0 - clock.start_s.0);
            let (samples, first_s) =
                place::placed(alignment, &channel.samples, of.rate_hz, start_s);
            if channel.name == own.name {
                of_own = Some((samples.len(), first_s));
            }
            let placed = Channel {
                name: channel.name.clone(),
                unit: channel.unit.clone(),
                samples,
            };
            let clock = Clock {
                rate_hz: of.rate_hz,
                start_s: first_s,
            };
            channels.push((placed, clock));
        }
        if let Some((count, first_s)) = of_own {
            let drive = drive_channel(compared, count, first_s)?;
            let clock = Clock {
                rate_hz: clock.rate_hz,
                start_s: first_s,
            };
            channels.push((drive, clock));
        }
        let firsts = channels.iter().map(|(_, clock)| clock.start_s.0);
        let first_s = firsts.fold(f64::INFINITY, f64::min);
        let mut about = recording.about.clone();
        let played = &compared.drive.0.recording.about.provenance;
        let provenance = &mut about.provenance;
        provenance.excited_hz = provenance.excited_hz.or(played.excited_hz);
        for stretch in &mut provenance.losses.stretches_s {
            *stretch = stretch.map(|at_s| self.on_drive_s(at_s, clock.start_s, first_s).max(0.0));
        }
        let step = format!(
            "placed on the clock of the drive {} by channel {}: first sample at {first_s:.6} s of the drive, drift {} ppm corrected",
            self.drive.file,
            own.name,
            plus(alignment.drift_ppm, 2)
        );
        let provenance = about.provenance.then(step);
        let mut found = Recording::with_clocks(channels, about.condition, provenance)?;
        found.about.warnings.clone_from(&alignment.warnings);
        found.annotations = self.annotations(compared, first_s);
        Ok(found)
    }

    /// When `recorded_s` of a recording whose compared clock begins at `start` is on the drive, from the first sample at `first_s` on, s.
    fn on_drive_s(&self, recorded_s: f64, start: Seconds, first_s: f64) -> f64 {
        let of_own = Seconds(recorded_s - start.0);
        self.alignment.on_drive(of_own).0 - first_s
    }

    /// What is stated of the recording and of the drive, counted from the first sample at `first_s` of the drive.
    fn annotations(&self, compared: &Compared<'_>, first_s: f64) -> Annotations {
        let (named, _, clock) = compared.recorded;
        let before = &named.recording.annotations;
        let alignment = &self.alignment;
        let on_drive = |recorded_s: f64| self.on_drive_s(recorded_s, clock.start_s, first_s);
        // The first sample is the first whole one of the drive: what happened up to one before it is at 0.
        let own = before.events.iter().map(|event| {
            let from_s = on_drive(event.onset_s.0).max(0.0);
            let to_s = on_drive(event.onset_s.0 + event.duration_s.0);
            Event {
                onset_s: Seconds(from_s),
                duration_s: Seconds((to_s - from_s).max(0.0)),
                ..event.clone()
            }
        });
        let (played, _, of) = compared.drive;
        let length_s = alignment.covered_s[1].0 - first_s;
        let of_drive = on_clock(&played.recording.annotations.events, of.start_s);
        let of_drive = on_clock(&of_drive, Seconds(first_s)).into_iter();
        let of_drive = of_drive.filter(|event| {
            event.onset_s.0 >= 0.0 && event.onset_s.0 + event.duration_s.0 <= length_s
        });
        let mut events: Vec<Event> = own.chain(of_drive).collect();
        events.sort_by(|a, b| a.onset_s.0.total_cmp(&b.onset_s.0));
        let mut labels = before.labels.clone();
        labels.insert(FIRST_SAMPLE.to_owned(), format!("{first_s:.9}"));
        let first_recorded_s = alignment.on_recording(Seconds(first_s)).0 + clock.start_s.0;
        let started_at = before.started_at.as_ref();
        Annotations {
            started_at: started_at.map(|start| start.later(Seconds(first_recorded_s))),
            labels,
            events,
        }
    }
}

/// The drive at the rate of the compared channel, `count` samples from `first_s` on, a whole sample.
fn drive_channel(
    compared: &Compared<'_>,
    count: usize,
    first_s: Seconds,
) -> Result<Channel, AlignError> {
    let (_, channel, of) = compared.drive;
    let (named, _, clock) = compared.recorded;
    let rate = clock.rate_hz;
    let samples = match of.rate_hz == rate {
        true => channel.samples.clone(),
        false => {
            let highest = 0.9 * rate.nyquist().0.min(of.rate_hz.nyquist().0);
            Resampler::new(of.rate_hz, rate, Hertz(highest))?.process(&channel.samples)
        }
    };
    let first = (first_s.0 * rate.hz()).round() as i64;
    let at = |i: usize| {
        let at = usize::try_from(first + i as i64).ok();
        at.and_then(|at| samples.get(at)).copied().unwrap_or(0.0)
    };
    let taken = named
        .recording
        .channels()
        .iter()
        .any(|one| one.name == DRIVE);
    Ok(Channel {
        name: if taken { PLAYED } else { DRIVE }.to_owned(),
        unit: Drive::UNIT,
        samples: (0..count).map(at).collect(),
    })
}
