//! The loop within the program as a part of a set-up: its finger, its pace, its faults.

use serde::{Deserialize, Serialize};

use crate::error::{AudioError, wrong};

/// The loop of a set-up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LoopSettings {
    /// Who is at it: a bench such as `twin:participant=1,seed=7`; absent where no finger is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub finger: Option<String>,
    pub pace: LoopPace,
    /// From output to input, frames.
    pub delay_frames: u32,
    /// The recorded value per played value of the loopback.
    pub gain: f64,
    /// The potential of the inputs at full scale, V peak.
    pub input_v_per_full_scale: f64,
    /// White noise on every input, rms, full scale = 1.
    pub noise: f64,
    /// The corner of the inputs' high-pass, Hz; 0 for none.
    pub corner_hz: f64,
    /// How much faster the clock of the input runs than that of the output, ppm.
    pub clock_ppm: f64,
    pub seed: u64,
    /// The input channel whose sensor is mounted on a calibrator of 159.2 Hz and 10 m/s² rms.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub on_calibrator: Option<u32>,
    /// An engine that leaves part of each buffer silent: of every so many frames so many.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub silent: Option<SilentPart>,
    /// What fails, and when.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub faults: Vec<LoopFault>,
}

impl Default for LoopSettings {
    fn default() -> Self {
        Self {
            finger: None,
            pace: LoopPace::Asked,
            delay_frames: 1_500,
            gain: 0.5,
            input_v_per_full_scale: 2.0,
            noise: 1e-6,
            corner_hz: 0.0,
            clock_ppm: 0.0,
            seed: 1,
            on_calibrator: None,
            silent: None,
            faults: Vec::new(),
        }
    }
}

/// How time passes at a loop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", expecting = "\"asked\" or \"real_time\"")]
pub enum LoopPace {
    /// As fast as samples are asked for.
    #[default]
    Asked,
    /// As fast as at a real device.
    RealTime,
}

/// An engine that leaves part of each buffer silent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(
    deny_unknown_fields,
    expecting = "a silent part, such as { of = 170, every = 682 }"
)]
pub struct SilentPart {
    /// So many frames are silent.
    pub of: u64,
    /// Of every so many.
    pub every: u64,
}

/// A fault of a loop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    deny_unknown_fields,
    expecting = "a fault, such as { what = \"stall\", at_s = 1, for_s = 0.1 }"
)]
pub struct LoopFault {
    pub what: LoopFailure,
    /// When, s since the streams were opened.
    pub at_s: f64,
    /// For how long, s; not of what is lost for good.
    #[serde(default)]
    pub for_s: f64,
}

/// What can fail at a loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(
    rename_all = "snake_case",
    expecting = "\"underrun\", \"overrun\", \"stall\", \"removed\" or \"silenced\""
)]
pub enum LoopFailure {
    /// The output is not served: silence is played instead.
    Underrun,
    /// The input loses frames.
    Overrun,
    /// Neither is served: both at once, and in real time nothing comes meanwhile.
    Stall,
    /// The device is unplugged, and the system says so.
    Removed,
    /// The device delivers nothing more, and nobody says so.
    Silenced,
}

impl LoopSettings {
    pub(crate) fn check(&self) -> Result<(), AudioError> {
        let numbers = [
            ("gain", self.gain, [-10.0, 10.0]),
            (
                "input_v_per_full_scale",
                self.input_v_per_full_scale,
                [1e-3, 1e3],
            ),
            ("noise", self.noise, [0.0, 1.0]),
            ("corner_hz", self.corner_hz, [0.0, 1e3]),
            ("clock_ppm", self.clock_ppm, [-1e4, 1e4]),
            ("delay_frames", f64::from(self.delay_frames), [0.0, 1e6]),
        ];
        for (name, value, [low, high]) in numbers {
            if !(low..=high).contains(&value) {
                return Err(wrong(
                    &format!("{name} from {low} to {high}"),
                    &value.to_string(),
                ));
            }
        }
        for fault in &self.faults {
            let possible =
                (0.0..=86_400.0).contains(&fault.at_s) && (0.0..=60.0).contains(&fault.for_s);
            if !possible {
                return Err(wrong(
                    "faults at 0 to 86400 s, for 0 to 60 s",
                    &format!("{fault:?}"),
                ));
            }
        }
        match self.silent {
            Some(silent) if silent.of >= silent.every => Err(wrong(
                "a silent part that is shorter than what it is part of",
                &format!("{silent:?}"),
            )),
            _ => Ok(()),
        }
    }
}
