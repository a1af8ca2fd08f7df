//! The script of a fake bench: its settings and faults as a plain value.

use crate::DeviceError;
use piezotact::quantity::{QuantityError, SampleRate};
use serde::{Deserialize, Serialize};

use crate::watch::LONGEST_PAUSE;

/// Times that a script may name, s.
const LONGEST_S: f64 = 86_400.0;
/// The longest gap of a script, s: a longer one is a lost device.
const LONGEST_GAP_S: f64 = 60.0;

/// The settings of a scripted fake. Settings that are left out have default values; a fake with default values has no faults.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct FakeScript {
    /// Draws the noise.
    pub seed: u64,
    /// The rate of the output, Hz.
    pub output_hz: f64,
    /// The rate of the input by its own clock, Hz.
    pub input_hz: f64,
    /// How much faster the clock of the input runs than that of the output, parts per million.
    pub clock_ppm: f64,
    /// The lengths of the chunks, s, used in turn and repeated cyclically.
    pub chunks_s: Vec<f64>,
    /// How fast time passes.
    pub pace: Pace,
    /// The simulated device.
    pub device: FakeDevice,
    /// Samples that the input loses and reports.
    pub drop_outs: Vec<DropOut>,
    /// Chunks that come late.
    pub late: Vec<Late>,
    /// Where the output runs dry.
    pub underruns: Vec<Underrun>,
    /// The half that is lost.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lost: Option<LostHalf>,
    /// When the input runs full, s since the bench was opened.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub input_full_after_s: Option<f64>,
    /// How long it may deliver no samples before a run is ended, s.
    pub longest_pause_s: f64,
    /// A breach of the contract of a bench.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fault: Option<Fault>,
}

/// How fast time passes at a fake.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case", expecting = "\"asked\" or \"real_time\"")]
pub enum Pace {
    /// As fast as chunks are requested.
    #[default]
    Asked,
    /// In real time: a request for a chunk waits until its last sample was acquired.
    RealTime,
}

/// The device with a finger on it: a resonance, a delay and noise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(
    default,
    deny_unknown_fields,
    expecting = "settings of the device, such as { gain_m_s2 = 12 }"
)]
pub struct FakeDevice {
    /// The acceleration far above the resonance, m/s² per full scale.
    pub gain_m_s2: f64,
    /// The resonance, Hz.
    pub resonance_hz: f64,
    /// Its damping ratio.
    pub damping: f64,
    /// The delay of the acceleration, s.
    pub delay_s: f64,
    /// White noise on the acceleration, m/s² rms.
    pub noise_m_s2: f64,
    /// The normal force that is held, as a share of what was asked for.
    pub force_share: f64,
}

/// The origin of a time in the script.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case", expecting = "\"run\" or \"opened\"")]
pub enum TimeOrigin {
    /// From the start of every run: it happens in each.
    #[default]
    Run,
    /// From the opening of the bench: it happens once. Time is counted in acquired samples.
    Opened,
}

/// Samples that are lost and reported.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(
    deny_unknown_fields,
    expecting = "a drop-out, such as { at_s = 1, samples = 25 }"
)]
pub struct DropOut {
    /// When, s.
    pub at_s: f64,
    /// How many samples of each channel.
    pub samples: u64,
    /// From when on `at_s` counts.
    #[serde(default)]
    pub since: TimeOrigin,
}

/// A chunk that comes late.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(
    deny_unknown_fields,
    expecting = "a late chunk, such as { at_s = 1, by_s = 0.5 }"
)]
pub struct Late {
    /// The chunk behind this time of every run, s.
    pub at_s: f64,
    /// By how much, s; with [`Pace::Asked`] an empty chunk is delivered instead.
    pub by_s: f64,
}

/// An output that runs dry for a while: silence is played, and the rest of the drive comes later.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(
    deny_unknown_fields,
    expecting = "an output that runs dry, such as { at_s = 1, samples = 480 }"
)]
pub struct Underrun {
    /// When in the playback of every run, s.
    pub at_s: f64,
    /// How many samples of silence, at the rate of the output.
    pub samples: u64,
}

/// One half of a bench.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case", expecting = "\"input\" or \"output\"")]
pub enum Half {
    /// What plays.
    Output,
    /// What acquires.
    Input,
}

/// A half that is no longer there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(
    deny_unknown_fields,
    expecting = "a lost half, such as { half = \"input\", after_s = 5 }"
)]
pub struct LostHalf {
    /// Which.
    pub half: Half,
    /// When, s since the bench was opened; the time is that of what was acquired.
    pub after_s: f64,
}

/// What no bench may do, done once in every run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(
    deny_unknown_fields,
    expecting = "a fault, such as { what = \"ends_early\", at_s = 1 }"
)]
pub struct Fault {
    /// What.
    pub what: Breach,
    /// When, s since the start of the run.
    pub at_s: f64,
}

/// A way to break the contract of a bench.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(
    rename_all = "snake_case",
    expecting = "the name of a fault, such as \"ends_early\""
)]
pub enum Breach {
    /// A chunk of two and a half seconds.
    TooManySamples,
    /// A chunk without its last channel.
    ChannelMissing,
    /// A chunk whose last channel is shorter.
    UnequalChannels,
    /// A chunk whose device time is before that of the chunk before.
    TimeBackwards,
    /// A chunk that was delivered before.
    RepeatedChunk,
    /// Samples that are lost and not reported.
    UnreportedGap,
    /// A sample that is NaN.
    NotANumber,
    /// An input that reports the end of the run too early.
    EndsEarly,
    /// An input that does not end when the playback has ended.
    NeverEnds,
    /// An input that waits for samples that never come.
    DeliversNothing,
    /// An input that delivers empty chunks for ever.
    DeliversEmpty,
}

impl Default for FakeScript {
    fn default() -> Self {
        Self {
            seed: 1,
            output_hz: 48_000.0,
            input_hz: 5_000.0,
            clock_ppm: 0.0,
            chunks_s: vec![0.1],
            pace: Pace::default(),
            device: FakeDevice::default(),
            drop_outs: Vec::new(),
            late: Vec::new(),
            underruns: Vec::new(),
            lost: None,
            input_full_after_s: None,
            longest_pause_s: LONGEST_PAUSE.0,
            fault: None,
        }
    }
}

impl Default for FakeDevice {
    fn default() -> Self {
        Self {
            gain_m_s2: 12.0,
            resonance_hz: 180.0,
            damping: 0.3,
            delay_s: 0.001,
            noise_m_s2: 0.002,
            force_share: 1.0,
        }
    }
}

impl FakeScript {
    /// The script in a TOML `text`.
    ///
    /// # Errors
    /// [`DeviceError::Impossible`] when it says nothing or is no script, and those of [`Self::checked`].
    pub fn from_toml(text: &str) -> Result<Self, DeviceError> {
        let script: Self = toml::from_str(text).map_err(|error| {
            let line = |span: std::ops::Range<usize>| text[..span.start].matches('\n').count() + 1;
            let at = error.span().map(line);
            let at = at.map_or(String::new(), |line| format!(" (line {line})"));
            DeviceError::Impossible {
                expected: "a script of a fake in TOML".to_owned(),
                found: format!("{}{at}", in_words(error.message())),
                todo: "correct the script".to_owned(),
            }
        })?;
        let says = |line: &str| !matches!(line.trim().chars().next(), None | Some('#' | '['));
        if !text.lines().any(says) {
            return Err(DeviceError::Impossible {
                expected: "a script of a fake with at least one setting".to_owned(),
                found: "none".to_owned(),
                todo: "write for example `seed = 1` for a bench without faults".to_owned(),
            });
        }
        script.checked()
    }

    /// The script with its numbers checked.
    ///
    /// # Errors
    /// [`DeviceError::Impossible`] for the first that cannot be.
    pub fn checked(self) -> Result<Self, DeviceError> {
        let mut numbers = vec![
            ("output_hz".to_owned(), self.output_hz, 200.0, 192_000.0),
            ("input_hz".into(), self.input_hz, 200.0, 192_000.0),
            (
                "longest_pause_s".into(),
                self.longest_pause_s,
                0.01,
                LONGEST_S,
            ),
            ("clock_ppm".into(), self.clock_ppm, -10_000.0, 10_000.0),
            (
                "the number of chunks_s".into(),
                self.chunks_s.len() as f64,
                1.0,
                10_000.0,
            ),
            ("gain_m_s2".into(), self.device.gain_m_s2, -1e6, 1e6),
            (
                "resonance_hz".into(),
                self.device.resonance_hz,
                1.0,
                0.49 * self.input_hz,
            ),
            ("damping".into(), self.device.damping, 0.001, 100.0),
            ("delay_s".into(), self.device.delay_s, 0.0, 1.0),
            ("noise_m_s2".into(), self.device.noise_m_s2, 0.0, 1e3),
            ("force_share".into(), self.device.force_share, 0.0, 100.0),
        ];
        let mut time = |what: &str, at_s: f64| numbers.push((what.into(), at_s, 0.0, LONGEST_S));
        self.drop_outs
            .iter()
            .for_each(|d| time("at_s of drop_outs", d.at_s));
        self.late.iter().for_each(|l| time("at_s of late", l.at_s));
        self.late.iter().for_each(|l| time("by_s of late", l.by_s));
        self.underruns
            .iter()
            .for_each(|u| time("at_s of underruns", u.at_s));
        self.lost
            .iter()
            .for_each(|l| time("after_s of lost", l.after_s));
        self.input_full_after_s
            .iter()
            .for_each(|s| time("input_full_after_s", *s));
        self.fault
            .iter()
            .for_each(|f| time("at_s of fault", f.at_s));
        let most = LONGEST_GAP_S * self.input_hz.max(self.output_hz);
        let gaps = self.drop_outs.iter().map(|d| ("drop_outs", d.samples));
        let silences = self.underruns.iter().map(|u| ("underruns", u.samples));
        for (what, samples) in gaps.chain(silences) {
            numbers.push((format!("samples of {what}"), samples as f64, 1.0, most));
        }
        for chunk_s in &self.chunks_s {
            numbers.push(("chunks_s".into(), *chunk_s, 1e-4, 1.0));
        }
        match numbers
            .into_iter()
            .find(|(_, found, low, high)| !(*low..=*high).contains(found))
        {
            None => Ok(self),
            Some((what, found, low, high)) => Err(DeviceError::Impossible {
                expected: format!("{what} from {low} to {high}"),
                found: found.to_string(),
                todo: "write another number in the script".to_owned(),
            }),
        }
    }

    /// The rates of output and input.
    pub(super) fn rates(&self) -> Result<[SampleRate; 2], QuantityError> {
        Ok([
            SampleRate::new(self.output_hz)?,
            SampleRate::new(self.input_hz)?,
        ])
    }
}

/// The error of the TOML reader, in terms of the script.
fn in_words(message: &str) -> String {
    let message = message.replace("invalid length ", "invalid value: a list of ");
    let found = ["invalid type: ", "invalid value: "];
    let found = found.iter().find_map(|start| message.strip_prefix(start));
    let (found, expected) = match found.and_then(|rest| rest.split_once(", expected ")) {
        Some((found, expected)) => (found, Some(expected)),
        None => (message.as_str(), None),
    };
    let mut said = match found {
        "sequence" => "a list".to_owned(),
        "map" => "a table".into(),
        other => other.into(),
    };
    for (theirs, ours) in [
        ("floating point `", "the number `"),
        ("integer `", "the number `"),
        ("boolean `", "the word `"),
        ("string \"", "the text \""),
        ("missing field `", "a part without `"),
        ("unknown field `", "the unknown setting `"),
        ("unknown variant `", "the unknown word `"),
    ] {
        if let Some(rest) = said.strip_prefix(theirs) {
            said = format!("{ours}{rest}");
        }
    }
    // A word is read as the name of a variant.
    if said.starts_with("wanted ") {
        said = "a number, list or table in place of a word in quotes".into();
    }
    said = said.replace('\n', ", ");
    let expected = expected.map(|expected| match expected {
        "u64" | "usize" | "u32" => "a whole number from 0",
        "f64" => "a number",
        "a sequence" => "a list in brackets [ ]",
        other => other,
    });
    match expected {
        Some(expected) => format!("{said} in place of {expected}"),
        None => said,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_script_is_a_text() {
        let script = FakeScript::from_toml(
            "clock_ppm = 50\nchunks_s = [0.05, 0.011]\n\
             drop_outs = [{ at_s = 2, samples = 25 }, { at_s = 9, samples = 1, since = \"opened\" }]\n\
             lost = { half = \"input\", after_s = 12.5 }\n\
             fault = { what = \"time_backwards\", at_s = 1 }\n[device]\nresonance_hz = 200\n",
        )
        .unwrap();
        assert_eq!(script.clock_ppm, 50.0);
        assert_eq!(script.drop_outs[1].since, TimeOrigin::Opened);
        assert_eq!(script.lost.unwrap().half, Half::Input);
        assert_eq!(script.device.resonance_hz, 200.0);
        assert_eq!(
            FakeScript::from_toml("seed = 1").unwrap(),
            FakeScript::default()
        );
        for empty in ["", " \n", "# nothing yet\n[device]\n"] {
            let said = FakeScript::from_toml(empty).unwrap_err().to_string();
            assert!(said.contains("`seed = 1`"), "{empty:?}: {said}");
        }
        for (bad, part) in [
            ("colour = 1", "colour"),
            ("clock_ppm = ", "line 1"),
            (
                "seed = 1\nclock_ppm = 2e6",
                "clock_ppm from -10000 to 10000, found 2000000",
            ),
            ("chunks_s = []", "the number of chunks_s"),
            ("chunks_s = [2]", "chunks_s from 0.0001 to 1"),
            ("input_hz = nan", "input_hz"),
            ("fault = { what = \"explodes\", at_s = 1 }", "explodes"),
            ("late = [{ at_s = -1, by_s = 0 }]", "at_s of late"),
        ] {
            let said = FakeScript::from_toml(bad).unwrap_err().to_string();
            assert!(said.contains(part) && !said.contains('\n'), "{bad}: {said}");
        }
    }

    #[test]
    fn what_is_wrong_with_a_script_is_said_in_the_words_of_its_writer() {
        for (bad, part) in [
            (
                "device = 3",
                "the number `3` in place of settings of the device, such as { gain_m_s2 = 12 } (line 1)",
            ),
            (
                "seed = -1",
                "the number `-1` in place of a whole number from 0",
            ),
            (
                "seed = 1.5",
                "the number `1.5` in place of a whole number from 0",
            ),
            (
                "seed = 1\ninput_hz = \"fast\"",
                "the text \"fast\" in place of a number (line 2)",
            ),
            (
                "chunks_s = 0.1",
                "the number `0.1` in place of a list in brackets [ ]",
            ),
            (
                "fault = \"ends_early\"",
                "in place of a fault, such as { what = \"ends_early\", at_s = 1 }",
            ),
            (
                "fault = { what = 3, at_s = 1 }",
                "in place of a word in quotes",
            ),
            ("fault = { what = { a = 1, b = 2 }, at_s = 1 }", ""),
            ("pace = { a = 1, b = 2 }", "in place of a word in quotes"),
            ("pace = [1, 2]", "in place of a word in quotes"),
            ("pace = \"slow\"", "the unknown word `slow`"),
            ("fault = { what = \"ends_early\" }", "a part without `at_s`"),
            ("drop_outs = [1]", "in place of a drop-out"),
            ("drop_outs = { at_s = 1, samples = 2 }", ""),
            ("lost = true", "the word `true` in place of a lost half"),
            ("lost = []", ""),
            ("colour = 1", "the unknown setting `colour`"),
        ] {
            let said = FakeScript::from_toml(bad).unwrap_err().to_string();
            assert!(said.contains(part) && !said.contains('\n'), "{bad}: {said}");
            for theirs in [
                "struct",
                "u64",
                "f64",
                "element",
                "variant",
                "field",
                "invalid type",
                "sequence",
                " map",
            ] {
                assert!(!said.contains(theirs), "{bad}: {said}");
            }
        }
    }
}
