//! The sound systems of this machine, through cpal: ALSA and JACK on Linux, `PipeWire` where it was built in; WASAPI on Windows and Core Audio on macOS
//! compile from the same code and were not tried.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use cpal::traits::{DeviceTrait, HostTrait, StreamTrait};
use cpal::{
    BufferSize, Device, ErrorKind, FromSample, HostId, I24, Sample, SampleFormat, SizedSample,
    StreamConfig, SupportedBufferSize, SupportedStreamConfigRange,
};
use piezotact::sound::{Answers, DeviceListing, Offer, SoundHost};
use piezotact_bench::StopHandle;

use crate::board::{Board, Side};
use crate::callback::{InputCallback, OutputCallback};
use crate::error::AudioError;
use crate::error::wrong;
use crate::io::{AudioIo, StreamPlan, Streams};
use crate::plant;
use crate::setup::SoundSetup;

/// The frames that are converted at a time.
const SCRATCH_FRAMES: usize = 4_096;
/// The formats that are served, the best first.
const FORMATS: [SampleFormat; 4] = [
    SampleFormat::F32,
    SampleFormat::I32,
    SampleFormat::I24,
    SampleFormat::I16,
];
/// A device that does not open within this time fails.
const OPENS_WITHIN: Duration = Duration::from_secs(10);

/// The names of the sound systems that this program was built with, and whether each answers.
#[must_use]
pub fn hosts() -> Vec<SoundHost> {
    let _quiet = Quiet::begin();
    let available = cpal::available_hosts();
    let of = |id: &HostId| {
        // JACK says that it is there when its library is; its devices are there when its server runs.
        let devices = |host: cpal::Host| {
            host.devices()
                .is_ok_and(|mut devices| devices.next().is_some())
        };
        let answers = available.contains(id) && cpal::host_from_id(*id).is_ok_and(devices);
        SoundHost {
            name: id.to_string(),
            answers: if answers { Answers::Yes } else { Answers::No },
        }
    };
    cpal::ALL_HOSTS.iter().map(of).collect()
}

/// A sound system of this machine.
#[derive(Debug)]
pub struct HardwareIo {
    id: HostId,
}

/// One direction of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Direction {
    Output,
    Input,
}

impl Direction {
    fn word(self) -> &'static str {
        match self {
            Self::Output => "output",
            Self::Input => "input",
        }
    }

    fn offers(self, device: &Device) -> Vec<SupportedStreamConfigRange> {
        match self {
            Self::Output => device.supported_output_configs().map(Iterator::collect),
            Self::Input => device.supported_input_configs().map(Iterator::collect),
        }
        .unwrap_or_default()
    }
}

/// Keeps ALSA from writing its messages on the terminal, in this thread, as long as it lives.
struct Quiet {
    #[cfg(target_os = "linux")]
    _handler: Option<std::rc::Rc<std::cell::RefCell<alsa::Output>>>,
}

impl Quiet {
    fn begin() -> Self {
        Self {
            #[cfg(target_os = "linux")]
            _handler: alsa::Output::local_error_handler().ok(),
        }
    }
}

impl HardwareIo {
    /// The sound system called `name`.
    ///
    /// # Errors
    /// [`AudioError::NoHost`] when this program was built without it.
    pub fn new(name: &str) -> Result<Self, AudioError> {
        let known = || {
            cpal::ALL_HOSTS
                .iter()
                .map(HostId::to_string)
                .chain(["loop".into()])
        };
        match cpal::ALL_HOSTS.iter().find(|id| id.to_string() == name) {
            Some(id) => Ok(Self { id: *id }),
            None => Err(AudioError::NoHost {
                known: known().collect::<Vec<_>>().join(", "),
                found: name.into(),
            }),
        }
    }

    /// The sound system that `setup` names.
    ///
    /// # Errors
    /// As [`Self::new`]; [`AudioError::Setup`] where a simulated finger answers behind the JACK server and the set-up does not state it.
    pub fn of(setup: &SoundSetup) -> Result<Self, AudioError> {
        let io = Self::new(&setup.host)?;
        if setup.host == "jack" && !setup.simulated && plant::is_behind_the_server() {
            return Err(wrong(
                "simulated = true in the set-up, as a simulated device answers behind this JACK server (`twin plant`), or another server",
                "a set-up of a real device",
            ));
        }
        Ok(io)
    }

    fn host(&self) -> Result<cpal::Host, AudioError> {
        cpal::host_from_id(self.id).map_err(|error| self.unavailable(&error))
    }

    fn unavailable(&self, error: &cpal::Error) -> AudioError {
        AudioError::HostUnavailable {
            host: self.id.to_string(),
            why: error.to_string(),
        }
    }

    /// The device with this id, and no other.
    fn device(&self, wanted: &str, direction: Direction) -> Result<Device, AudioError> {
        let devices: Vec<Device> = self
            .host()?
            .devices()
            .map_err(|error| self.unavailable(&error))?
            .collect();
        if devices.is_empty() {
            return Err(AudioError::HostUnavailable {
                host: self.id.to_string(),
                why: "it has no devices".into(),
            });
        }
        let id = |device: &Device| device.id().ok().map(|id| id.id().to_owned());
        let found = devices.iter().find(|device| {
            id(device).as_deref() == Some(wanted) && !direction.offers(device).is_empty()
        });
        let ids = || {
            devices
                .iter()
                .filter(|device| !direction.offers(device).is_empty())
                .filter_map(id)
                .collect::<Vec<_>>()
        };
        found.cloned().ok_or_else(|| AudioError::NoDevice {
            direction: direction.word(),
            wanted: wanted.into(),
            found: match ids() {
                ids if ids.is_empty() => "none".into(),
                ids => ids.join(", "),
            },
        })
    }
}

fn offer(range: &SupportedStreamConfigRange) -> Offer {
    Offer {
        channels: range.channels(),
        rates_hz: [range.min_sample_rate(), range.max_sample_rate()],
        buffer_frames: match range.buffer_size() {
            SupportedBufferSize::Range { min, max } => Some([*min, *max]),
            SupportedBufferSize::Unknown => None,
        },
        format: range.sample_format().to_string(),
    }
}

impl AudioIo for HardwareIo {
    fn devices(&self) -> Result<Vec<DeviceListing>, AudioError> {
        let _quiet = Quiet::begin();
        let devices = self
            .host()?
            .devices()
            .map_err(|error| self.unavailable(&error))?;
        let offers = |device: &Device, direction: Direction| {
            direction
                .offers(device)
                .iter()
                .map(offer)
                .collect::<Vec<_>>()
        };
        let listed = devices.filter_map(|device| {
            let id = device.id().ok()?;
            let name = device
                .description()
                .map_or_else(|_| String::new(), |about| about.name().to_owned());
            Some(DeviceListing {
                host: self.id.to_string(),
                id: id.id().to_owned(),
                name,
                outputs: offers(&device, Direction::Output),
                inputs: offers(&device, Direction::Input),
            })
        });
        Ok(listed.collect())
    }

    fn open(
        &mut self,
        plan: &StreamPlan,
        output: OutputCallback,
        input: InputCallback,
        board: &Arc<Board>,
    ) -> Result<Box<dyn Streams>, AudioError> {
        let _quiet = Quiet::begin();
        let [plays, records] = [
            (&plan.output, Direction::Output),
            (&plan.input, Direction::Input),
        ];
        let out_device = self.device(plays.0, plays.1)?;
        let in_device = self.device(records.0, records.1)?;
        let out_opened = Opened::of(&out_device, plan, output.channels(), Direction::Output)?;
        let in_opened = Opened::of(&in_device, plan, input.channels(), Direction::Input)?;
        let input = in_opened.input(&in_device, input, board)?;
        let output = out_opened.output(&out_device, output, board)?;
        for (stream, opened) in [(&input, &in_opened), (&output, &out_opened)] {
            stream.play().map_err(|error| opened.failed(&error))?;
        }
        Ok(Box::new(HardwareStreams {
            _output: output,
            _input: input,
        }))
    }
}

/// Streams of a device; dropping them closes it.
struct HardwareStreams {
    _output: cpal::Stream,
    _input: cpal::Stream,
}

impl Streams for HardwareStreams {
    fn wait(&mut self, at_most: Duration, stop: &StopHandle) {
        let _stopped = stop.wait(at_most);
    }

    fn run_by_themselves(&self) -> bool {
        true
    }
}

/// How one direction of a device is opened.
struct Opened {
    direction: Direction,
    device: String,
    config: StreamConfig,
    format: SampleFormat,
    rate_hz: f64,
}

impl Opened {
    /// The configuration that `device` offers for `plan`.
    fn of(
        device: &Device,
        plan: &StreamPlan,
        channels: usize,
        direction: Direction,
    ) -> Result<Self, AudioError> {
        let name = match direction {
            Direction::Output => &plan.output,
            Direction::Input => &plan.input,
        };
        let rate = plan.rate.hz() as u32;
        let offers = direction.offers(device);
        let fits = |range: &&SupportedStreamConfigRange| {
            let buffer = match range.buffer_size() {
                SupportedBufferSize::Range { min, max } => {
                    (*min..=*max).contains(&plan.buffer_frames)
                }
                SupportedBufferSize::Unknown => true,
            };
            let rates = range.min_sample_rate()..=range.max_sample_rate();
            usize::from(range.channels()) >= channels && rates.contains(&rate) && buffer
        };
        // The fewest channels that are enough: a sound server mixes channels that a device has not.
        let fitting = offers.iter().filter(fits);
        let place = |range: &SupportedStreamConfigRange| {
            FORMATS
                .iter()
                .position(|format| *format == range.sample_format())
        };
        let best = fitting
            .filter_map(|range| Some((range.channels(), place(range)?, range)))
            .min_by_key(|(channels, place, _)| (*channels, *place));
        let Some((channels_offered, _, range)) = best else {
            let offered = offered(&offers);
            return Err(AudioError::NotOffered {
                direction: direction.word(),
                device: name.clone(),
                wanted: format!(
                    "{rate} Hz, {channels} channels, buffers of {} frames",
                    plan.buffer_frames
                ),
                offered,
            });
        };
        Ok(Self {
            direction,
            device: name.clone(),
            config: StreamConfig {
                channels: channels_offered,
                sample_rate: rate,
                buffer_size: BufferSize::Fixed(plan.buffer_frames),
            },
            format: range.sample_format(),
            rate_hz: plan.rate.hz(),
        })
    }

    fn failed(&self, error: &cpal::Error) -> AudioError {
        let (direction, device) = (self.direction.word(), self.device.clone());
        match error.kind() {
            ErrorKind::DeviceBusy => AudioError::Busy { direction, device },
            _ => AudioError::Backend {
                direction,
                device,
                why: error.to_string(),
            },
        }
    }

    fn output(
        &self,
        device: &Device,
        callback: OutputCallback,
        board: &Arc<Board>,
    ) -> Result<cpal::Stream, AudioError> {
        match self.format {
            SampleFormat::F32 => self.output_of::<f32>(device, callback, board),
            SampleFormat::I32 => self.output_of::<i32>(device, callback, board),
            SampleFormat::I24 => self.output_of::<I24>(device, callback, board),
            _ => self.output_of::<i16>(device, callback, board),
        }
    }

    fn output_of<T: SizedSample + FromSample<f32>>(
        &self,
        device: &Device,
        mut callback: OutputCallback,
        board: &Arc<Board>,
    ) -> Result<cpal::Stream, AudioError> {
        let (narrow, wide) = (
            callback.channels().max(1),
            usize::from(self.config.channels),
        );
        let mut scratch = vec![0.0_f32; SCRATCH_FRAMES * narrow];
        let losses = Losses::new(self.rate_hz);
        let (mut timed, reported) = (losses.timed(), losses);
        let fills = move |data: &mut [T], info: &cpal::OutputCallbackInfo| {
            let frames = data.len() / wide;
            if let Some(skipped) = timed.lost(info.timestamp().playback.as_nanos(), frames) {
                callback.skipped(skipped);
            }
            for part in data.chunks_mut(SCRATCH_FRAMES * wide) {
                let frames = part.len() / wide;
                let filled = &mut scratch[..frames * narrow];
                callback.fill(filled);
                for (to, from) in part.chunks_exact_mut(wide).zip(filled.chunks_exact(narrow)) {
                    for (channel, to) in to.iter_mut().enumerate() {
                        *to = T::from_sample(from.get(channel).copied().unwrap_or(0.0));
                    }
                }
            }
        };
        let board = Arc::clone(board);
        let said = move |error: cpal::Error| reported.heard(&error, &board.output);
        device
            .build_output_stream(self.config, fills, said, Some(OPENS_WITHIN))
            .map_err(|error| self.failed(&error))
    }

    fn input(
        &self,
        device: &Device,
        callback: InputCallback,
        board: &Arc<Board>,
    ) -> Result<cpal::Stream, AudioError> {
        match self.format {
            SampleFormat::F32 => self.input_of::<f32>(device, callback, board),
            SampleFormat::I32 => self.input_of::<i32>(device, callback, board),
            SampleFormat::I24 => self.input_of::<I24>(device, callback, board),
            _ => self.input_of::<i16>(device, callback, board),
        }
    }

    fn input_of<T: SizedSample>(
        &self,
        device: &Device,
        mut callback: InputCallback,
        board: &Arc<Board>,
    ) -> Result<cpal::Stream, AudioError>
    where
        f32: FromSample<T>,
    {
        let (narrow, wide) = (
            callback.channels().max(1),
            usize::from(self.config.channels),
        );
        let mut scratch = vec![0.0_f32; SCRATCH_FRAMES * narrow];
        let losses = Losses::new(self.rate_hz);
        let (mut timed, reported) = (losses.timed(), losses);
        let takes = move |data: &[T], info: &cpal::InputCallbackInfo| {
            let frames = data.len() / wide;
            if let Some(lost) = timed.lost(info.timestamp().capture.as_nanos(), frames) {
                callback.lost(lost);
            }
            for part in data.chunks(SCRATCH_FRAMES * wide) {
                let frames = part.len() / wide;
                let taken = &mut scratch[..frames * narrow];
                for (to, from) in taken.chunks_exact_mut(narrow).zip(part.chunks_exact(wide)) {
                    for (to, from) in to.iter_mut().zip(from) {
                        *to = f32::from_sample(*from);
                    }
                }
                callback.take(taken);
            }
        };
        let board = Arc::clone(board);
        let said = move |error: cpal::Error| reported.heard(&error, &board.input);
        device
            .build_input_stream(self.config, takes, said, Some(OPENS_WITHIN))
            .map_err(|error| self.failed(&error))
    }
}

/// What `offers` hold, those that differ by their channels in one.
fn offered(offers: &[SupportedStreamConfigRange]) -> String {
    let mut kinds: Vec<(String, [u16; 2])> = Vec::new();
    for range in offers {
        let (kind, channels) = (described(range), range.channels());
        match kinds.iter_mut().find(|(known, _)| *known == kind) {
            Some((_, [low, high])) => (*low, *high) = ((*low).min(channels), (*high).max(channels)),
            None => kinds.push((kind, [channels; 2])),
        }
    }
    let texts = kinds.iter().map(|(kind, [low, high])| match low == high {
        true => format!("{kind}, {low} channels"),
        false => format!("{kind}, {low} to {high} channels"),
    });
    match kinds.is_empty() {
        true => "nothing".into(),
        false => texts.collect::<Vec<_>>().join("; "),
    }
}

/// Rates, buffers and format of an offer.
fn described(range: &SupportedStreamConfigRange) -> String {
    let [low, high] = [range.min_sample_rate(), range.max_sample_rate()];
    let rates = if low == high {
        format!("{low} Hz")
    } else {
        format!("{low} to {high} Hz")
    };
    let buffers = match range.buffer_size() {
        SupportedBufferSize::Range { min, max } if min == max => {
            format!(", buffers of {min} frames")
        }
        SupportedBufferSize::Range { min, max } => format!(", buffers of {min} to {max} frames"),
        SupportedBufferSize::Unknown => String::new(),
    };
    format!("{rates}{buffers}, {}", range.sample_format())
}

/// Losses that the system reports, and how long each was by its time stamps.
struct Losses {
    pending: Arc<AtomicU64>,
    rate_hz: f64,
}

/// The half of [`Losses`] in a callback.
struct TimedLosses {
    pending: Arc<AtomicU64>,
    rate_hz: f64,
    /// The time stamp that comes next where nothing is lost, ns.
    expected_ns: Option<f64>,
}

impl Losses {
    fn new(rate_hz: f64) -> Self {
        Self {
            pending: Arc::new(AtomicU64::new(0)),
            rate_hz,
        }
    }

    fn timed(&self) -> TimedLosses {
        TimedLosses {
            pending: Arc::clone(&self.pending),
            rate_hz: self.rate_hz,
            expected_ns: None,
        }
    }

    fn heard(&self, error: &cpal::Error, side: &Side) {
        match error.kind() {
            ErrorKind::Xrun => {
                self.pending.fetch_add(1, Ordering::AcqRel);
            }
            // The priority of its thread; what it costs shows as losses.
            ErrorKind::RealtimeDenied => {}
            _ => side.gone.store(true, Ordering::Release),
        }
    }
}

impl TimedLosses {
    /// The frames that were lost before a buffer of `frames` stamped `at_ns`, where the system reported a loss; by its time stamps it may be none.
    fn lost(&mut self, at_ns: u128, frames: usize) -> Option<u64> {
        let at_ns = at_ns as f64;
        let reported = self.pending.swap(0, Ordering::AcqRel) > 0;
        let late = self
            .expected_ns
            .map_or(0.0, |expected| (at_ns - expected) * 1e-9 * self.rate_hz);
        self.expected_ns = Some(at_ns + frames as f64 / self.rate_hz * 1e9);
        reported.then(|| late.round().max(0.0) as u64)
    }
}
