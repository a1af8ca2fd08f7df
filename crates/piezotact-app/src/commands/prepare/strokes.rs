//! The strokes of each texture, and the one of them that is rendered.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::anyhow;
use piezotact::Warning;
use piezotact::lineage::{Lineage, Operation};
use piezotact::manipulate::{Manipulated, textures_of_strokes};
use piezotact::prepare::{ChosenStroke, TextureStrokes, typical_stroke, warnings_of_conditions};
use piezotact::quantity::{Acceleration, Drive};
use piezotact::recording::Condition;
use piezotact::series::Series;
use piezotact::study::AnalysedRecording;
use piezotact::transfer::TransferFunction;

use super::drives::finger_of;
use super::{Arguments, file};
use crate::commands::manipulate::Written;
use crate::commands::render::folders;
use crate::commands::touch::take_all;
use crate::failure::{Failure, Failures, Outcome, usage};
use crate::keeping::{Earlier, runs_in};
use crate::places::{outputs, recording_files};
use crate::reading::texture;
use crate::report::name;
use crate::runs::run_plan;
use piezotact_bench::Bench;
use piezotact_dataset::sidecar::sidecar_path;
use piezotact_dataset::{RunFolder, texture_file_name};

/// The textures that a participant touched.
pub(super) struct Textures {
    pub(super) participant: Option<String>,
    /// Their name alone, as a session has it.
    #[cfg(feature = "study")]
    pub(super) pseudonym: String,
    pub(super) all: Vec<Texture>,
    /// The folder of measurements, for this command alone.
    _held: RunFolder,
}

/// One texture with its stroke.
pub(super) struct Texture {
    /// The name of its files.
    pub(super) called: String,
    pub(super) strokes: TextureStrokes,
    pub(super) target: PathBuf,
    /// What is written there.
    pub(super) made: Written,
    pub(super) warnings: Vec<Warning>,
}

impl Texture {
    pub(super) fn series(&self) -> &Series<Acceleration> {
        &self.made.texture.series
    }

    /// Writes its target. What stood at the places of its files is of an earlier command, and is kept: target, drive and measurement are of
    /// one command.
    pub(super) fn written(&self, out: &Path) -> Outcome<Vec<Earlier>> {
        let places = [
            self.target.clone(),
            file(out, "drives", &self.called, "wav"),
            file(out, "measured", &self.called, "parquet"),
        ];
        let earlier = places
            .iter()
            .map(|place| Earlier::at(place, "what an earlier command left"))
            .collect::<Outcome<Vec<_>>>()?;
        self.made.write(&self.target)?;
        Ok(earlier)
    }
}

/// A stroke with the take that it is of.
struct Found<'a> {
    take: &'a AnalysedRecording,
    number: usize,
    cut: Manipulated<Acceleration>,
}

impl Textures {
    /// The textures of the recordings that `args` names, each with its chosen stroke, and those that a protocol makes of them; and the
    /// recordings that failed. Nothing is written.
    pub(super) fn of(
        args: &Arguments,
        function: &TransferFunction<Drive, Acceleration>,
        bench: Option<&Bench>,
        #[cfg(feature = "study")] protocol: Option<&super::stimuli::Stimuli>,
    ) -> Outcome<(Self, Failures)> {
        let (takes, mut failures) = take_all(&args.takes)?;
        let participant = one_participant(&takes)?;
        require_same_participant(participant.as_ref(), function)?;
        if let Some(bench) = bench {
            require_same_finger(participant.as_ref(), function, bench)?;
        }
        let groups = by_texture(&takes);
        let called = file_names(groups.iter().map(|(texture, _)| texture.as_str()));
        #[cfg(feature = "study")]
        let made = match protocol {
            Some(protocol) => {
                protocol.require_strokes_of(&groups, participant.as_deref())?;
                protocol.file_names().collect()
            }
            None => Vec::new(),
        };
        #[cfg(not(feature = "study"))]
        let made = Vec::new();
        let written: Vec<String> = called.iter().cloned().chain(made).collect();
        check_outputs(args, &written)?;
        let held = runs_in(&args.out.join("measured"))?;
        let mut all = Vec::new();
        for ((texture, takes), called) in groups.into_iter().zip(called) {
            let mut found = Vec::new();
            for take in &takes {
                let strokes = strokes_of(take);
                let strokes = failures.unless_failed(Path::new(&take.file), strokes)?;
                found.extend(strokes.unwrap_or_default());
            }
            if !found.is_empty() {
                let condition = &function.about.condition;
                all.push(chosen(args, condition, (texture, called), &takes, found)?);
            }
        }
        if all.is_empty() {
            failures.outcome()?;
        }
        #[cfg(feature = "study")]
        if let Some(protocol) = protocol {
            protocol.make_of(&mut all, args)?;
        }
        let textures = Self {
            participant,
            #[cfg(feature = "study")]
            pseudonym: (takes.iter())
                .find_map(|take| take.condition().participant.clone())
                .unwrap_or_default(),
            all,
            _held: held,
        };
        Ok((textures, failures))
    }
}

/// Refuses the strokes of several people.
fn one_participant(takes: &[AnalysedRecording]) -> Outcome<Option<String>> {
    let people = takes.iter().filter_map(|take| take.condition().person());
    let people: BTreeSet<String> = people.collect();
    if people.len() > 1 {
        let people: Vec<String> = people.into_iter().collect();
        return Err(usage(anyhow!(
            "expected strokes of one participant, found those of {}; prepare each with their own transfer function, or state by --meta what strokes of one person do not state alike (participant, twin_seed)",
            people.join(", ")
        )));
    }
    Ok(people.into_iter().next())
}

/// Refuses the transfer function of somebody else.
fn require_same_participant(
    strokes: Option<&String>,
    function: &TransferFunction<Drive, Acceleration>,
) -> Outcome {
    match (strokes, function.about.condition.person()) {
        (Some(strokes), Some(function)) if *strokes != function => Err(usage(anyhow!(
            "expected strokes and a transfer function of one participant, found strokes of {strokes} and a transfer function \
             measured with {function}; give those of one session"
        ))),
        _ => Ok(()),
    }
}

/// Refuses a bench with somebody else at it.
fn require_same_finger(
    strokes: Option<&String>,
    function: &TransferFunction<Drive, Acceleration>,
    bench: &Bench,
) -> Outcome {
    let run = run_plan("prepare", &finger_of(function), bench.acquirer.as_ref());
    let here = bench.acquirer.condition(&run).person();
    let wanted = strokes.cloned().or(function.about.condition.person());
    match (wanted, here) {
        (Some(wanted), Some(here)) if wanted != here => Err(usage(anyhow!(
            "expected {wanted} at the bench, whose strokes and transfer function are given, found {here}; let {wanted} put the finger \
             on the device, or give the strokes and the transfer function of {here}"
        ))),
        _ => Ok(()),
    }
}

/// The recordings of each texture, in the order in which they were given. A manipulated one is a texture of its own.
fn by_texture(takes: &[AnalysedRecording]) -> Vec<(String, Vec<&AnalysedRecording>)> {
    let mut groups: Vec<(String, Vec<&AnalysedRecording>)> = Vec::new();
    for take in takes {
        let lineage = take.recording.about.provenance.lineage.as_ref();
        let is_manipulated = lineage.is_some_and(Lineage::is_manipulated);
        let sample = take.condition().sample.clone();
        let sample = sample.filter(|_| !is_manipulated);
        let known = groups
            .iter_mut()
            .find(|(known, _)| Some(&**known) == sample.as_deref());
        match (known, sample) {
            (Some((_, takes)), _) => takes.push(take),
            (None, Some(sample)) => groups.push((sample, vec![take])),
            // Files of one name in two folders are two textures.
            (None, None) => groups.push((free_name(take, &groups), vec![take])),
        }
    }
    groups
}

/// The name of the file of `take` without its ending, with its folder where another texture is called so.
fn free_name(take: &AnalysedRecording, groups: &[(String, Vec<&AnalysedRecording>)]) -> String {
    let path = Path::new(&take.file);
    let part = |part: Option<&std::ffi::OsStr>| {
        part.map_or(String::new(), |part| part.to_string_lossy().into_owned())
    };
    let stem = part(path.file_stem());
    let folder = part(path.parent().and_then(Path::file_name));
    let taken = |name: &String| groups.iter().any(|(known, _)| known == name);
    let names = [stem.clone(), format!("{folder}/{stem}"), take.file.clone()];
    names.into_iter().find(|name| !taken(name)).unwrap_or(stem)
}

/// A name for the files of each texture; each name occurs once.
fn file_names<'a>(textures: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for texture in textures {
        let plain = texture_file_name(texture);
        let mut name = plain.clone();
        let mut number = 2;
        // Some file systems do not tell capitals from small letters.
        let known = |name: &str, names: &[String]| {
            names
                .iter()
                .any(|other| other.to_lowercase() == name.to_lowercase())
        };
        while known(&name, &names) {
            name = format!("{plain}-{number}");
            number += 1;
        }
        names.push(name);
    }
    names
}

/// Makes the folders, and refuses files that would replace what is read or what another command wrote.
fn check_outputs(args: &Arguments, called: &[String]) -> Outcome {
    let out = &args.out;
    let parts = [
        out.clone(),
        out.join("targets"),
        out.join("drives"),
        out.join("measured"),
    ];
    let wanted = parts.each_ref().map(|part| Some(part.as_path()));
    let wanted = if args.bench.is_some() {
        &wanted[..]
    } else {
        &wanted[..3]
    };
    let made = folders(wanted)?;
    let mut written: Vec<PathBuf> = args
        .outputs
        .files()
        .into_iter()
        .map(Path::to_owned)
        .collect();
    for name in called {
        for part in ["targets", "drives"] {
            let path = file(out, part, name, "wav");
            written.push(sidecar_path(&path));
            written.push(path);
        }
        if args.bench.is_some() {
            written.extend(recording_files(&file(out, "measured", name, "parquet")));
        }
    }
    let recordings = args.takes.recordings.iter().map(PathBuf::as_path);
    let read: Vec<&Path> = recordings
        .chain([args.transfer.as_path()])
        .chain(args.bench.as_ref().and_then(|bench| bench.file()))
        .chain(args.protocol_file())
        .collect();
    let written: Vec<&Path> = written.iter().map(PathBuf::as_path).collect();
    let checked = outputs(&read, &written);
    if checked.is_err() {
        for folder in made.into_iter().rev() {
            // Only one that holds nothing goes.
            let _kept = std::fs::remove_dir(folder);
        }
    }
    checked
}

/// The strokes of a recording, without the gesture.
fn strokes_of(take: &AnalysedRecording) -> Outcome<Vec<Found<'_>>> {
    let at = |error: anyhow::Error| Failure::Data(error.context(take.file.clone()));
    let segmentation = &take.segmentation;
    if segmentation.strokes.is_empty() {
        return Err(at(anyhow!(
            "expected strokes, found none ({} rejected); `piezotact strokes --cuts-only` says why",
            segmentation.rejected.len()
        )));
    }
    let vibration = segmentation.roles.vibration.first();
    let path = Path::new(&take.file);
    let whole = texture(path, &take.recording, vibration.map(String::as_str))?;
    let cuts = textures_of_strokes(&whole, (&take.recording, segmentation));
    let cuts = cuts.map_err(|error| at(error.into()))?;
    let found = cuts.into_iter().enumerate();
    let found = found.map(|(i, cut)| Found {
        take,
        number: i + 1,
        cut,
    });
    Ok(found.collect())
}

/// The typical stroke of a texture, written as its target.
fn chosen(
    args: &Arguments,
    function: &Condition,
    (texture, called): (String, String),
    takes: &[&AnalysedRecording],
    mut found: Vec<Found<'_>>,
) -> Outcome<Texture> {
    let series: Vec<Series<Acceleration>> =
        found.iter().map(|one| one.cut.series.clone()).collect();
    let typical = typical_stroke(&series, args.band)?;
    let strokes = found.len();
    let Found { take, number, cut } = found.swap_remove(typical.index);
    let (from_s, to_s) = match cut.step.operation {
        Operation::Stroke { from_s, to_s, .. } => (from_s, to_s),
        _ => (0.0, cut.series.duration().0),
    };
    let stroke = ChosenStroke {
        file: name(Path::new(&take.file)),
        number,
        from_s,
        to_s,
        rms_m_s2: cut.series.rms_about_mean().value,
        distance_db: typical.distances_db[typical.index],
    };
    let mut warnings = typical.warnings(&texture, cut.series.duration());
    let conditions: Vec<&Condition> = takes.iter().map(|take| take.condition()).collect();
    warnings.extend(warnings_of_conditions(&texture, &conditions, function));
    let target = file(&args.out, "targets", &called, "wav");
    let made = Written::stroke(take, cut)?;
    let rejected = takes.iter().map(|take| take.segmentation.rejected.len());
    Ok(Texture {
        called,
        strokes: TextureStrokes {
            texture,
            recordings: takes.len(),
            strokes,
            rejected: rejected.sum(),
            spread_db: typical.spread_db(),
            stroke,
        },
        target,
        made,
        warnings,
    })
}

#[cfg(test)]
mod tests {
    use super::file_names;

    #[test]
    fn textures_have_file_names_of_their_own() {
        let names = ["S8", "../etc", "s8", "a/b", "", "Été 3", "..."];
        assert_eq!(
            file_names(names.into_iter()),
            ["S8", "_etc", "s8-2", "a_b", "texture", "Été_3", "texture-2"]
        );
    }
}
