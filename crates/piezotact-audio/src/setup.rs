//! The set-up of a sound device: which device, which channels, which sensors, which amplifier. A file in TOML.

use piezotact::quantity::{Acceleration, Drive, Force, Quantity, SampleRate, Unit};
use piezotact_bench::procedure::{ACCELERATION_CHANNEL, DRIVE_CHANNEL, FORCE_CHANNEL};
use serde::{Deserialize, Serialize};

use crate::error::{AudioError, wrong};
use crate::loop_settings::{LoopPace, LoopSettings};

/// The rates of sound devices, Hz.
const RATES_HZ: [f64; 2] = [8_000.0, 384_000.0];
/// The frames of a buffer.
const BUFFERS: [u32; 2] = [16, 16_384];
/// More channels has no device.
const MOST_CHANNELS: u32 = 128;

/// The set-up of a sound device.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SoundSetup {
    /// The sound system: `alsa`, `jack`, `pipewire`, `wasapi`, or `loop` for a loop within the program, with no device.
    pub host: String,
    /// The id of the output device, as `piezotact sound devices` lists it.
    #[serde(default)]
    pub output: String,
    /// The id of the input device.
    #[serde(default)]
    pub input: String,
    /// The rate of both, Hz.
    pub rate_hz: f64,
    /// The frames of a buffer. Below 1024, systems with a sound server lose samples under load.
    #[serde(default = "usual_buffer")]
    pub buffer_frames: u32,
    /// The amplifier and the actuator behind the output: a device by name or by its file; absent for that of the thesis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub device: Option<String>,
    /// The gain set on the amplifier; absent for its usual one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gain: Option<String>,
    /// What stands behind the device is simulated, as by `piezotact twin plant`: recordings say so.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub simulated: bool,
    /// What leaves the device.
    pub play: PlayChannels,
    pub record: Vec<RecordedChannel>,
    /// Where the normal force comes from, when it is not an input of the device.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<ForceSettings>,
    /// The loop within the program, for the host `loop`.
    #[serde(default, rename = "loop", skip_serializing_if = "Option::is_none")]
    pub looped: Option<LoopSettings>,
}

fn usual_buffer() -> u32 {
    1024
}

/// The channels of the output, from 1.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlayChannels {
    /// The channels that carry the drive: that of the amplifier, and those that are connected back to an input.
    pub drive: Vec<u32>,
    /// The channel that gives a pulse when a drive begins.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trigger: Option<u32>,
    /// The channels of the output stream; absent for as many as are named.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub channels: Option<u32>,
}

/// One channel of the input.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordedChannel {
    /// The channel, from 1.
    pub channel: u32,
    pub measures: Measures,
    /// The sensitivity of an accelerometer with its conditioner, mV per m/s².
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mv_per_m_s2: Option<f64>,
    /// The sensitivity of a force sensor with its amplifier, mV per N.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mv_per_n: Option<f64>,
}

/// What a channel of the input records.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(
    rename_all = "snake_case",
    expecting = "\"drive\", \"acceleration\" or \"force\""
)]
pub enum Measures {
    /// The loopback: what the output plays.
    Drive,
    /// The acceleration of the fingernail.
    Acceleration,
    /// The changes of the normal force.
    Force,
}

impl Measures {
    /// The name of the channel in recordings.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Drive => DRIVE_CHANNEL,
            Self::Acceleration => ACCELERATION_CHANNEL,
            Self::Force => FORCE_CHANNEL,
        }
    }

    /// Its SI unit.
    #[must_use]
    pub fn unit(self) -> Unit {
        match self {
            Self::Drive => Drive::UNIT,
            Self::Acceleration => Acceleration::UNIT,
            Self::Force => Force::UNIT,
        }
    }
}

impl RecordedChannel {
    /// The stated sensitivity, V per SI unit.
    #[must_use]
    pub fn v_per_unit(&self) -> Option<f64> {
        let mv = match self.measures {
            Measures::Drive => None,
            Measures::Acceleration => self.mv_per_m_s2,
            Measures::Force => self.mv_per_n,
        };
        mv.map(|mv| mv * 1e-3)
    }
}

/// A force cell that is no input of the sound device.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ForceSettings {
    /// The serial port, such as `/dev/ttyUSB0`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub serial: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub baud: Option<u32>,
    /// A text file to which another program appends readings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// The unit of lines with a number alone: `N`, `mN` or `g`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// How much later than the force its reading is, at the least, s: 0.025 for an HX711 at 80 readings a second.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub least_delay_s: Option<f64>,
}

impl SoundSetup {
    /// The set-up that `text` holds, in TOML.
    ///
    /// # Errors
    /// [`AudioError::Setup`] with the line, what was expected and what was found.
    pub fn from_toml(text: &str) -> Result<Self, AudioError> {
        let setup: Self = toml::from_str(text).map_err(|error| {
            let said = error.to_string();
            AudioError::Setup(format!(
                "expected the set-up of a sound device in TOML, found {}",
                said.trim_end()
            ))
        })?;
        setup.checked()
    }

    /// The rate of its streams.
    ///
    /// # Errors
    /// [`AudioError::Setup`] for a rate that no sound device has.
    pub fn rate(&self) -> Result<SampleRate, AudioError> {
        let within =
            (RATES_HZ[0]..=RATES_HZ[1]).contains(&self.rate_hz) && self.rate_hz.fract() == 0.0;
        let rate = SampleRate::new(self.rate_hz).ok().filter(|_| within);
        rate.ok_or_else(|| {
            wrong(
                &format!(
                    "a rate_hz from {} to {}, a whole number",
                    RATES_HZ[0], RATES_HZ[1]
                ),
                &self.rate_hz.to_string(),
            )
        })
    }

    /// The device by host, ids, for calibrations.
    #[must_use]
    pub fn called(&self) -> String {
        match self.host.as_str() {
            "loop" => "loop within the program".into(),
            host if self.output == self.input => format!("{host} {}", self.output),
            host => format!("{host} {} and {}", self.output, self.input),
        }
    }

    /// The channels of the output stream.
    #[must_use]
    pub fn output_channels(&self) -> usize {
        let named = self.play.drive.iter().copied().chain(self.play.trigger);
        self.play.channels.or(named.max()).unwrap_or(1) as usize
    }

    /// The channels of the input stream.
    #[must_use]
    pub fn input_channels(&self) -> usize {
        let named = self.record.iter().map(|recorded| recorded.channel);
        named.max().unwrap_or(1) as usize
    }

    /// The channel of the input that records what is played, from 1.
    #[must_use]
    pub fn loopback(&self) -> Option<&RecordedChannel> {
        self.record
            .iter()
            .find(|recorded| recorded.measures == Measures::Drive)
    }

    fn checked(self) -> Result<Self, AudioError> {
        self.rate()?;
        if !(BUFFERS[0]..=BUFFERS[1]).contains(&self.buffer_frames) {
            return Err(wrong(
                &format!("buffer_frames from {} to {}", BUFFERS[0], BUFFERS[1]),
                &self.buffer_frames.to_string(),
            ));
        }
        let is_loop = self.host == "loop";
        if !is_loop && (self.output.is_empty() || self.input.is_empty()) {
            return Err(wrong(
                "the ids of an output and an input, as `piezotact sound devices` lists them",
                "none",
            ));
        }
        if is_loop != self.looped.is_some() {
            return Err(wrong(
                "a part [loop] with the host \"loop\", and with no other",
                &format!("host = \"{}\"", self.host),
            ));
        }
        if self.play.drive.is_empty() {
            return Err(wrong(
                "a channel for the drive, such as drive = [1]",
                "none",
            ));
        }
        self.check_channels()?;
        self.check_scales()?;
        self.check_force()?;
        if let Some(looped) = &self.looped {
            looped.check()?;
        }
        Ok(self)
    }

    /// Each channel is named once, and each quantity is on one of them.
    fn check_channels(&self) -> Result<(), AudioError> {
        let played: Vec<u32> = self
            .play
            .drive
            .iter()
            .copied()
            .chain(self.play.trigger)
            .collect();
        check_numbers(&played, "output")?;
        let recorded: Vec<u32> = self
            .record
            .iter()
            .map(|recorded| recorded.channel)
            .collect();
        check_numbers(&recorded, "input")?;
        if let Some(count) = self.play.channels
            && (count > MOST_CHANNELS || played.iter().any(|channel| *channel > count))
        {
            return Err(wrong(
                "an output with all channels that are named",
                &format!("channels = {count}"),
            ));
        }
        for measures in [Measures::Drive, Measures::Acceleration, Measures::Force] {
            let count = self
                .record
                .iter()
                .filter(|recorded| recorded.measures == measures)
                .count();
            if count > 1 {
                return Err(wrong(
                    "each quantity on one channel",
                    &format!("{} on {count}", measures.name()),
                ));
            }
        }
        if recorded.is_empty() {
            return Err(wrong(
                "channels to record, such as [[record]] channel = 1, measures = \"drive\"",
                "none",
            ));
        }
        Ok(())
    }

    /// A scale stands on a channel of its quantity alone.
    fn check_scales(&self) -> Result<(), AudioError> {
        for recorded in &self.record {
            let stated = [
                (recorded.mv_per_m_s2, Measures::Acceleration, "mv_per_m_s2"),
                (recorded.mv_per_n, Measures::Force, "mv_per_n"),
            ];
            for (value, of, key) in stated {
                let Some(value) = value else { continue };
                if recorded.measures != of || !value.is_finite() || value == 0.0 {
                    return Err(wrong(
                        &format!("{key} other than 0, on a channel of {}", of.name()),
                        &format!(
                            "{key} = {value} on channel {}, which measures {}",
                            recorded.channel,
                            recorded.measures.name()
                        ),
                    ));
                }
            }
        }
        Ok(())
    }

    /// The force has one source, which runs in real time.
    fn check_force(&self) -> Result<(), AudioError> {
        if let Some(force) = &self.force {
            if force.serial.is_some() == force.file.is_some() {
                return Err(wrong(
                    "a force from one source: serial = \"PORT\" or file = \"FILE\"",
                    "none or both",
                ));
            }
            if let Some(delay_s) = force.least_delay_s
                && !(0.0..=1.0).contains(&delay_s)
            {
                return Err(wrong(
                    "a least_delay_s of the force from 0 to 1",
                    &delay_s.to_string(),
                ));
            }
            if self
                .record
                .iter()
                .any(|recorded| recorded.measures == Measures::Force)
            {
                return Err(wrong(
                    "the force from one source",
                    "an input of the sound device and [force]",
                ));
            }
        }
        if let (Some(looped), Some(_)) = (&self.looped, &self.force)
            && looped.pace == LoopPace::Asked
        {
            return Err(wrong(
                "pace = \"real_time\" in [loop], as a source of force runs in real time",
                "pace = \"asked\"",
            ));
        }
        Ok(())
    }
}

/// The channels of the `what` lie in range, and each is named once.
fn check_numbers(numbers: &[u32], what: &str) -> Result<(), AudioError> {
    for (i, number) in numbers.iter().enumerate() {
        if !(1..=MOST_CHANNELS).contains(number) {
            return Err(wrong(
                &format!("channels of the {what} from 1 to {MOST_CHANNELS}"),
                &number.to_string(),
            ));
        }
        if numbers[..i].contains(number) {
            return Err(wrong(
                &format!("each channel of the {what} once"),
                &format!("channel {number} twice"),
            ));
        }
    }
    Ok(())
}
