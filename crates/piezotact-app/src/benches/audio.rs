//! `audio:setup.toml`, `audio:setup.toml,participant=2`: a sound device.

use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};
use piezotact::device::{DeviceAtGain, DeviceDescription, GainName};
use piezotact::document;
use piezotact::quantity::{Degrees, Newtons};
use piezotact::recording::BenchKind;
use piezotact::sound::{LatencySummary, SoundCalibration};
use piezotact_audio::{AudioBench, AudioIo, HardwareIo, LoopIo, PlantMaker, SoundSetup};
use piezotact_bench::{Bench, DeviceError, Placement, Plant, RunPlan, Until};
use piezotact_dataset::{read_device, read_input_text};
use piezotact_twin::{Participant, TwinParameters, TwinPlant};

use super::twin::{TwinSpec, spec};
use super::{BenchEntry, BenchSpec, NamedBench, file_and_participant, wrong};
use crate::failure::{Failure, Outcome, usage};
use crate::invocation::day;
use crate::made::Made;

/// The line of the table of benches.
pub(super) const ENTRY: BenchEntry = BenchEntry {
    name: "audio",
    example: "audio:setup.toml",
    help: "audio:SETUP.toml,participant=K, a sound device",
    help_with_turns: Some("audio:SETUP.toml, a sound device"),
    parse,
};

/// A sound device by the file of its set-up, with the number of the participant.
#[derive(Clone, Debug, PartialEq, Eq)]
struct AudioSpec {
    file: PathBuf,
    participant: Option<u64>,
}

/// A sound device that was read from its files, and can be opened.
pub(crate) struct SoundDevice {
    pub(crate) setup: SoundSetup,
    /// The simulated person in front of a loop.
    finger: Option<TwinSpec>,
    pub(crate) calibration: Option<SoundCalibration>,
    latency: Option<LatencySummary>,
}

/// The file beside the set-up at `file` that holds its calibration.
pub(crate) fn calibration_path(file: &Path) -> PathBuf {
    beside(file, ".calibration.json")
}

/// The file beside the set-up at `file` that holds its latency.
pub(crate) fn latency_path(file: &Path) -> PathBuf {
    beside(file, ".latency.json")
}

fn beside(file: &Path, ending: &str) -> PathBuf {
    let mut name = file.as_os_str().to_owned();
    name.push(ending);
    name.into()
}

impl SoundDevice {
    /// The device that the set-up at `file` describes, with the calibration and the latency beside it.
    pub(crate) fn read(file: &Path) -> Outcome<Self> {
        let called = || file.display().to_string();
        let setup = SoundSetup::from_toml(&read_input_text(file)?).with_context(called)?;
        let finger = setup
            .looped
            .as_ref()
            .and_then(|looped| looped.finger.as_deref());
        let finger = finger.map(|named| match named.split_once(':').unwrap_or((named, "")) {
            ("twin", settings) => spec(settings),
            _ => Err(wrong("a finger such as `twin:participant=1,seed=7`", named)),
        });
        Ok(Self {
            finger: finger.transpose().map_err(usage)?,
            calibration: beside_it(&calibration_path(file))?,
            latency: beside_it(&latency_path(file))?,
            setup,
        })
    }

    /// The sound system, with whoever is simulated in front of a loop.
    pub(crate) fn io(&self, participant: Option<u64>) -> Outcome<Box<dyn AudioIo>> {
        self.io_of(&self.setup, participant)
    }

    /// The same for `setup`, which may name other channels.
    pub(crate) fn io_of(
        &self,
        setup: &SoundSetup,
        participant: Option<u64>,
    ) -> Outcome<Box<dyn AudioIo>> {
        if setup.looped.is_none() {
            return Ok(Box::new(HardwareIo::of(setup)?));
        }
        let plant = match &self.finger {
            Some(finger) => Some(plants(finger, participant)?),
            None => None,
        };
        Ok(Box::new(LoopIo::new(setup, plant)?))
    }

    fn kind(&self) -> BenchKind {
        match (&self.setup.looped, &self.finger) {
            (None, _) if self.setup.simulated => BenchKind::Twin,
            (None, _) => BenchKind::Hardware,
            (Some(_), Some(_)) => BenchKind::Twin,
            (Some(_), None) => BenchKind::Scripted,
        }
    }
}

/// The amplifier and the actuator that `setup` names, at the gain that it states.
pub(crate) fn device_of(setup: &SoundSetup) -> Outcome<DeviceAtGain> {
    let device = match &setup.device {
        None => DeviceDescription::drv2667().clone(),
        Some(named) => read_device(named)?,
    };
    match &setup.gain {
        None => Ok(device.at_usual_gain()),
        Some(gain) => device.at(&GainName::new(gain)).map_err(usage),
    }
}

/// The document at `path`, where there is one.
fn beside_it<T: document::Content + serde::de::DeserializeOwned>(
    path: &Path,
) -> Outcome<Option<T>> {
    if !path.exists() {
        return Ok(None);
    }
    let text = read_input_text(path)?;
    let called = || path.display().to_string();
    // A number that is changed by hand would be taken for a measured one.
    if Made::of(&text).is_none_or(|made| !made.untouched) {
        return Err(Failure::Data(anyhow!(
            "{}: expected the file as `piezotact sound calibrate` or `piezotact sound latency` wrote it, found that it was changed since; remove it, and measure again",
            called()
        )));
    }
    Ok(Some(document::read(&text).with_context(called)?))
}

/// Makes the finger of `twin`, or of `participant` in its place, for each run.
fn plants(twin: &TwinSpec, participant: Option<u64>) -> Outcome<PlantMaker> {
    let parameters = TwinParameters::built_in();
    let number = participant.or(twin.participant).unwrap_or(1);
    let participant = Participant::of(number, twin.seed, &parameters);
    let set = twin.set()?;
    Ok(Box::new(move |run, rate| {
        let resting = RunPlan {
            label: "at rest".into(),
            load: Some(Newtons(0.2)),
            angle: Degrees(20.0),
            placement: Placement::New,
            until: Until::Stopped,
        };
        // A force that the participant chooses is the usual one.
        let run = RunPlan {
            load: run.and_then(|run| run.load).or(resting.load),
            ..run.unwrap_or(&resting).clone()
        };
        let plant = TwinPlant::new(&parameters, &participant, &set, &run, rate)?;
        Ok(Box::new(plant) as Box<dyn Plant>)
    }))
}

impl NamedBench for AudioSpec {
    fn open(&self) -> Outcome<Bench> {
        let device = SoundDevice::read(&self.file)?;
        let mut io = device.io(self.participant)?;
        let number = self
            .participant
            .or(device.finger.as_ref().and_then(|finger| finger.participant));
        let bench = AudioBench {
            device: device_of(&device.setup)?,
            kind: device.kind(),
            participant: number.map(|number| format!("P{number:02}")),
            twin_seed: device.finger.as_ref().map(|finger| finger.seed),
            calibration: device.calibration,
            latency: device.latency,
            setup: device.setup,
            today: day(),
        };
        Ok(bench.open(io.as_mut())?)
    }

    fn file(&self) -> Option<&Path> {
        Some(&self.file)
    }

    fn participant(&self) -> Option<u64> {
        self.participant
    }

    fn with_participant(&self, number: u64) -> Result<BenchSpec, DeviceError> {
        Ok(BenchSpec::of(Self {
            participant: Some(number),
            ..self.clone()
        }))
    }

    fn apart_from_participant(&self) -> String {
        format!("audio:{}", self.file.display())
    }
}

fn parse(text: &str) -> Result<BenchSpec, DeviceError> {
    let (form, holds) = ("audio:SETUP.toml", "the set-up of a sound device");
    let (file, participant) = file_and_participant(text, form, holds)?;
    Ok(BenchSpec::of(AudioSpec { file, participant }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sound_device_is_a_file_and_a_participant() {
        let spec: BenchSpec = "audio:lab/setup.toml,participant=4".parse().unwrap();
        assert_eq!(spec.participant(), Some(4));
        assert_eq!(spec.apart_from_participant(), "audio:lab/setup.toml");
        assert_eq!(spec.file(), Some(Path::new("lab/setup.toml")));
        for bad in [
            "audio",
            "audio:",
            "audio:setup.toml,seed=1",
            "audio:setup.toml,participant=x",
        ] {
            assert!(bad.parse::<BenchSpec>().is_err(), "{bad}");
        }
    }
}
