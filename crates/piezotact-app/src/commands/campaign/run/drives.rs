//! The drives of a session: compared with their targets once more, taken into the study, and ready to be played.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, anyhow};
use piezotact::checksum::Checksum;
use piezotact::criterion::Outcome;
use piezotact::prepare::State;
use piezotact::quantity::{Band, Drive};
use piezotact::recording::{Recording, StartTime};
use piezotact::render::Rendering;
use piezotact_bench::procedure::faults_of_prepared;
use piezotact_bench::{Bench, DeviceError};
use piezotact_dataset::sidecar::{read_rendering, sidecar_path, states_its_samples};
use piezotact_dataset::{
    Contents, ReadOptions, keep_before, read_input, read_recording, texture_file_name,
};
use piezotact_people::campaign::chain::Sha;
use piezotact_people::campaign::protocol::Protocol;
use piezotact_people::campaign::readiness::{
    MeasuredDrive, Origin, RenderingFacts, Whose, changed_since,
};
use piezotact_study::session::PreparedDrive;

use crate::commands::manipulate::before_manipulation;
use crate::commands::verify::verified;
use crate::failure::{Failure, sentence};
use crate::output::write_bytes;
use crate::reading::texture;

/// The parts of a folder of drives, with the endings of their files.
const PARTS: [(&str, &str); 3] = [
    ("targets", "wav"),
    ("drives", "wav"),
    ("measured", "parquet"),
];

/// The drives that are there, what is known of each, and the band in which they are compared.
pub(in crate::commands) struct Drives {
    pub(super) ready: BTreeMap<String, PreparedDrive>,
    pub(in crate::commands) facts: Vec<RenderingFacts>,
    /// The stimuli of which some files are there, with those that are not.
    pub(in crate::commands) incomplete: Vec<(String, String)>,
    pub(super) band: Option<Band>,
    /// The files to take into the study, stimulus by stimulus.
    pub(super) given: Vec<(String, [PathBuf; 3])>,
}

/// Copies the drives that were `given` into the session in `folder`.
pub(super) fn keep(given: &[(String, [PathBuf; 3])], folder: &Path) -> Result<(), Failure> {
    for (stimulus, given) in given {
        take_over(given, &files(folder, stimulus))?;
    }
    Ok(())
}

/// The files of one stimulus in a folder of drives.
fn files(folder: &Path, stimulus: &str) -> [PathBuf; 3] {
    let name = texture_file_name(stimulus);
    PARTS.map(|(part, ending)| folder.join(part).join(format!("{name}.{ending}")))
}

fn are_there(files: &[PathBuf; 3]) -> bool {
    files.iter().all(|file| file.is_file())
}

impl Drives {
    /// Those of `stimuli`, for `participant`: of the folder `given` where they are there, else of the session in `folder`. Nothing is
    /// written.
    pub(in crate::commands) fn of<'a>(
        (protocol, participant): (&Protocol, &str),
        stimuli: impl IntoIterator<Item = &'a str>,
        folder: &Path,
        given: Option<&Path>,
    ) -> Result<Self, Failure> {
        let mut drives = Self {
            ready: BTreeMap::new(),
            facts: Vec::new(),
            incomplete: Vec::new(),
            band: None,
            given: Vec::new(),
        };
        let stimuli: Vec<&str> = stimuli.into_iter().collect();
        require_names(stimuli.iter().copied())?;
        // All faults are named at once: somebody waits.
        let mut faults: Vec<String> = Vec::new();
        let mut add = |drives: &mut Self, stimulus: &str, files: &[PathBuf; 3]| {
            match drives.add((protocol, participant), stimulus, files) {
                Err(Failure::Data(error)) => faults.push(sentence(&error)),
                other => other?,
            }
            Ok::<(), Failure>(())
        };
        for stimulus in stimuli {
            let given = given.map(|given| files(given, stimulus));
            if let Some(given) = given.clone().filter(are_there) {
                add(&mut drives, stimulus, &given)?;
                drives.given.push((stimulus.to_owned(), given));
                continue;
            }
            let kept = files(folder, stimulus);
            if are_there(&kept) {
                add(&mut drives, stimulus, &kept)?;
                continue;
            }
            let some = |files: &[PathBuf; 3]| files.iter().any(|file| file.is_file());
            if let Some(files) = given.into_iter().chain([kept]).find(some) {
                let lacking = files.iter().filter(|file| !file.is_file());
                let lacking: Vec<String> = lacking.map(|file| file.display().to_string()).collect();
                let stimulus = stimulus.to_owned();
                drives.incomplete.push((stimulus, lacking.join(", ")));
            }
        }
        match faults.is_empty() {
            true => Ok(drives),
            false => Err(Failure::Data(anyhow!("{}", faults.join("\n")))),
        }
    }

    /// Notes why `bench`, as it is now, does not play them. Nothing is played.
    pub(in crate::commands) fn compare_with(
        &mut self,
        bench: &mut Bench,
    ) -> Result<(), DeviceError> {
        for facts in &mut self.facts {
            let Some(PreparedDrive { drive, setup, .. }) = self.ready.get(&facts.stimulus) else {
                continue;
            };
            let faults = faults_of_prepared(bench, drive, setup.as_ref())?;
            facts.refused = faults.iter().map(ToString::to_string).collect();
        }
        Ok(())
    }

    fn add(
        &mut self,
        (protocol, participant): (&Protocol, &str),
        stimulus: &str,
        files: &[PathBuf; 3],
    ) -> Result<(), Failure> {
        let [target, drive, measured] = files;
        let Contents {
            recording,
            setup,
            rendering,
            ..
        } = read_recording(drive, &ReadOptions::default())?;
        let of_drive =
            |error: anyhow::Error| Failure::Data(error.context(drive.display().to_string()));
        let series = recording.series::<Drive>(None);
        let series = series.map_err(|error| of_drive(error.into()))?;
        let Some(rendering) = rendering.filter(|_| read_rendering(drive).is_some()) else {
            return Err(of_drive(anyhow!(
                "expected a drive with a sidecar that states how it was rendered and the checksum of its samples, found none; render it with piezotact"
            )));
        };
        let wanted = read_recording(target, &ReadOptions::default())?;
        if !states_its_samples(target) {
            return Err(Failure::Data(anyhow!(
                "{}: expected a target with a sidecar that states the checksum of its samples, found none; prepare {stimulus} again",
                target.display()
            )));
        }
        let band = rendering.config.inverse.band;
        let of_series = Checksum::of(series.samples().iter().copied());
        let playing = read_recording(measured, &ReadOptions::default())?;
        let alike = |played: &Rendering| played.is_alike(&rendering);
        let of_drive = match (playing.played, &playing.rendering) {
            (Some(played), _) if played == of_series => MeasuredDrive::This,
            (None, None) => MeasuredDrive::Unstated,
            (None, Some(played)) if alike(played) => MeasuredDrive::Unstated,
            _ => MeasuredDrive::Another,
        };
        let verification = verified(target, measured, band)?;
        let sha = Sha::of(&read_input(drive)?);
        let sample = wanted.recording.about.condition.sample.as_deref();
        // The plain texture of a sample has its name.
        let sample = sample.map(
            |found| match protocol.sample_of(stimulus) == Some(stimulus) {
                true => found,
                false => before_manipulation(found),
            },
        );
        let samples_of_target = texture(target, &wanted.recording, None)?;
        let played = playing.rendering.as_ref();
        // What another finger felt decides nothing.
        let felt_by = playing.recording.about.condition.participant.as_deref();
        let verified = match felt_by.is_some_and(|person| person != participant) {
            true => Outcome::NotDecided,
            false => State::of(&verification).outcome(),
        };
        self.band = Some(band);
        self.facts.push(RenderingFacts {
            stimulus: stimulus.to_owned(),
            file: drive.display().to_string(),
            sha,
            samples: of_series,
            lineage: rendering.about.provenance.lineage.clone(),
            sample: sample.map(str::to_owned),
            target_file: target.display().to_string(),
            texture: samples_of_target.clone(),
            target_lineage: wanted.recording.about.provenance.lineage.clone(),
            changed_since_measured: played.and_then(|played| changed_since(played, &rendering)),
            made_with: rendering.about.provenance.made_with.clone(),
            level_error_db: Some(verification.level_error_db),
            level_db: rendering.level_db,
            drive_s: series.duration().0,
            strokes: origin(&wanted.recording),
            transfer_function: Origin {
                bench: rendering.about.provenance.bench,
                condition: rendering.about.condition.clone(),
                at_ms: unix_ms(rendering.about.provenance.measured_at.as_ref()),
            },
            measurement: origin(&playing.recording),
            rendered_with: whose(&rendering),
            verified,
            measured: of_drive,
            refused: Vec::new(),
        });
        self.ready.insert(
            stimulus.to_owned(),
            PreparedDrive {
                sha,
                drive: series,
                setup,
                texture: samples_of_target,
                target: wanted.recording,
                rendering: Some(rendering),
                verified,
            },
        );
        Ok(())
    }
}

/// Refuses stimuli whose files would have one name.
pub(in crate::commands::campaign) fn require_names<'a>(
    stimuli: impl IntoIterator<Item = &'a str>,
) -> Result<(), Failure> {
    let mut named: BTreeMap<String, &str> = BTreeMap::new();
    for stimulus in stimuli {
        let name = texture_file_name(stimulus);
        if let Some(other) = named.insert(name.to_lowercase(), stimulus) {
            return Err(Failure::Data(anyhow!(
                "expected stimuli whose files have different names, found `{other}` and `{stimulus}`, both {name}; rename one in the protocol"
            )));
        }
    }
    Ok(())
}

/// Copies what is in `from` and differs from what is in `to`, with its sidecars and times; what stood there is kept as
/// `NAME.before-N`.
fn take_over(from: &[PathBuf; 3], to: &[PathBuf; 3]) -> Result<(), Failure> {
    for (from, to) in from.iter().zip(to) {
        if let Some(folder) = to.parent() {
            std::fs::create_dir_all(folder).with_context(|| {
                format!(
                    "cannot create the folder {}; check the disk",
                    folder.display()
                )
            })?;
        }
        let pairs = [
            (from.clone(), to.clone()),
            (sidecar_path(from), sidecar_path(to)),
        ];
        for (from, to) in pairs.iter().filter(|(from, _)| from.is_file()) {
            let bytes = read_input(from)?;
            if to.is_file() {
                if read_input(to)? == bytes {
                    continue;
                }
                keep_before(to)?;
            }
            write_bytes(to, &bytes)?;
            let changed = std::fs::metadata(from)?.modified()?;
            std::fs::File::options()
                .write(true)
                .open(to)?
                .set_modified(changed)?;
        }
    }
    Ok(())
}

/// With whose transfer function a drive was rendered.
fn whose(rendering: &Rendering) -> Whose {
    if rendering.about.provenance.averaged_people.is_some() {
        return Whose::Average;
    }
    let person = rendering.about.condition.participant.clone();
    person.map_or(Whose::Unknown, Whose::Of)
}

/// Where and when `recording` was made. The time of its file is not believed: a copy, or a touch, renews it.
fn origin(recording: &Recording) -> Origin {
    Origin {
        bench: recording.about.provenance.bench,
        condition: recording.about.condition.clone(),
        at_ms: unix_ms(recording.annotations.started_at.as_ref()),
    }
}

fn unix_ms(started: Option<&StartTime>) -> Option<i64> {
    started.and_then(StartTime::unix_ms)
}
