//! What `segment`, `analyse` and `compare` share: recordings read, named, cut and analysed.

pub(crate) mod analyse;
pub(crate) mod compare;
pub(crate) mod discrimination;
mod grouping;
pub(crate) mod segment;
mod tables;

use piezotact::doubt::Doubts;
use piezotact::stroke::StrokeDoubt;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::anyhow;
use indicatif::{ProgressBar, ProgressStyle};
use piezotact::Doubt;
use piezotact::doubt::merged_of;
use piezotact::feature::{self, Analysis, FeatureConfig};
use piezotact::filter::HighPass;
use piezotact::quantity::{Newtons, Unit};
use piezotact::recording::{Condition, Recording, Touch};
use piezotact::roles::{Motion, Roles};
use piezotact::stroke::{Expected, Judging, Segmentation, segment};
use piezotact::surface::SampleSet;
use piezotact_dataset::{
    Naming, cuts_path, known_naming, known_sample_sets, read_cuts, read_sample_set,
};

use super::{place, read};
use crate::advice::text;
use crate::cli::{Computing, Takes, TouchName};
use crate::failure::{Failure, Outcome, usage};
use crate::output::say;
use crate::report::name;

pub(crate) use grouping::{
    Cell, Comparison, both_ways, cells, comparisons, differ_in, left_out, lines_of_all,
};

/// One recording with its strokes.
pub(crate) struct Take {
    pub(crate) path: PathBuf,
    /// The file's name.
    pub(crate) name: String,
    pub(crate) recording: Recording,
    /// Those of the recording and of its name.
    pub(crate) labels: BTreeMap<String, String>,
    pub(crate) segmentation: Segmentation,
    /// Absent until it is analysed, and for a recording without strokes.
    pub(crate) analysis: Option<Analysis>,
}

impl Take {
    pub(crate) fn condition(&self) -> &Condition {
        &self.recording.about.condition
    }

    /// Everything that is in doubt about it.
    pub(crate) fn doubts(&self) -> Vec<Doubt> {
        let analysis = self.analysis.iter().flat_map(|a| &a.doubts);
        let all = self
            .recording
            .about
            .doubts
            .iter()
            .chain(&self.segmentation.doubts);
        let doubts: Doubts = all.chain(analysis).cloned().collect();
        doubts.into()
    }
}

/// Every doubt about the recordings and about their groups in words, those of one kind once and with all whom they are about.
pub(crate) fn doubts_once(takes: &[Take], groups: &[Cell<'_>]) -> Vec<String> {
    let of_takes: Vec<(Option<&str>, Vec<Doubt>)> = takes
        .iter()
        .map(|take| (Some(take.name.as_str()), take.doubts()))
        .collect();
    let of_takes = of_takes
        .iter()
        .flat_map(|(name, doubts)| doubts.iter().map(|doubt| (*name, doubt)));
    let of_groups = groups
        .iter()
        .flat_map(|group| group.summary.doubts.iter().map(|doubt| (None, doubt)));
    merged_of(of_takes.chain(of_groups))
        .iter()
        .map(|doubt| doubt.text_of((takes.len(), "recordings"), &text))
        .collect()
}

/// A bar over many recordings; on anything but a terminal a line at its start.
fn many(what: &str, count: usize) -> ProgressBar {
    use std::io::IsTerminal as _;
    if count < 2 {
        return ProgressBar::hidden();
    }
    if !std::io::stderr().is_terminal() {
        say(&format!("{what} {count} recordings …"));
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(count as u64);
    // The template is a constant; were it wrong, the plain bar serves.
    if let Ok(style) = ProgressStyle::with_template("{msg} [{bar:30}] {pos}/{len} {eta}") {
        bar.set_style(style.progress_chars("=> "));
    }
    bar.set_message(what.to_owned());
    bar
}

/// Reads and cuts every recording.
pub(crate) fn take_all(args: &Takes) -> Outcome<Vec<Take>> {
    if args.cuts.is_some() && args.recordings.len() > 1 {
        return Err(usage(anyhow!(
            "--cuts is for one recording, found {}: put RECORDING.cuts beside each of several",
            args.recordings.len()
        )));
    }
    let bar = many("reading", args.recordings.len());
    let mut takes: Vec<Take> = Vec::with_capacity(args.recordings.len());
    for path in &args.recordings {
        if takes.iter().any(|take| place(&take.path) == place(path)) {
            return Err(usage(anyhow!(
                "{} is given twice: name every recording once",
                path.display()
            )));
        }
        takes.push(take(path, args)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(takes)
}

fn take(path: &Path, args: &Takes) -> Outcome<Take> {
    if args.tangential_force.len() > 2 {
        return Err(usage(anyhow!(
            "expected one or two channels for --tangential-force, found {}: forces along one axis have to be added first",
            args.tangential_force.len()
        )));
    }
    let at = |error: anyhow::Error| Failure::Data(error.context(path.display().to_string()));
    let mut recording = read(path, &args.reading)?.recording;
    let naming = match &args.meta {
        Some(pattern) => pattern.read(path).map_err(usage)?,
        None => known_naming(path),
    };
    let Naming {
        condition: named,
        mut labels,
        doubts,
    } = naming;
    // What the recording says counts before its name.
    labels.extend(recording.annotations.labels.clone());
    recording.about.doubts.extend(doubts);
    complete(&mut recording.about.condition, named, args)?;
    let (guessed, doubts) = Roles::guess(&recording);
    let roles = stated_roles(guessed, args, &recording).map_err(at)?;
    if args.vibration.is_empty() {
        recording.about.doubts.extend(doubts);
    }
    let recording = recording
        .on_the_clock_of(roles.channels())
        .map_err(|e| at(e.into()))?;
    let expected = Expected {
        load_n: recording.about.condition.load_n,
        speed_m_s: recording.about.condition.speed_m_s,
        judging: if args.every_contact {
            Judging::ContactOnly
        } else {
            Judging::Sliding
        },
    };
    let mut segmentation = segment(&recording, &roles, expected).map_err(|e| at(e.into()))?;
    let beside = cuts_path(path);
    let cuts = match &args.cuts {
        Some(file) => Some(read_cuts(file)?),
        None if beside.exists() => Some(read_cuts(&beside)?),
        None => None,
    };
    if let Some(cuts) = cuts {
        let (cut, outside) = cuts.apply(segmentation, recording.len(), recording.rate());
        segmentation = cut;
        if !outside.is_empty() {
            segmentation
                .doubts
                .push(Doubt::from(StrokeDoubt::CutsNotApplied {
                    file: cuts.source.clone(),
                    count: outside.len(),
                }));
        }
    }
    segmentation.doubts.extend(segmentation.rejection_doubt());
    Ok(Take {
        path: path.into(),
        name: name(path),
        recording,
        labels,
        segmentation,
        analysis: None,
    })
}

/// What the command line says of the condition counts, then the recording itself, then its name.
fn complete(condition: &mut Condition, named: Condition, args: &Takes) -> Outcome {
    let speed_m_s = match &args.speed {
        Some(speed) if speed.unit != Unit::MetrePerSecond => {
            return Err(usage(anyhow!(
                "expected a speed such as \"30 mm/s\" for --speed, found {speed}; correct its unit"
            )));
        }
        speed => speed.as_ref().map(|speed| speed.value),
    };
    if let Some(load) = args.load
        && !(load > 0.0 && load.is_finite())
    {
        return Err(usage(anyhow!(
            "expected a load above 0 N for --load, found {load}; give it in N"
        )));
    }
    let touch = args.touch.map(|touch| match touch {
        TouchName::Active => Touch::Active,
        TouchName::Passive => Touch::Passive,
    });
    let own = std::mem::take(condition);
    *condition = Condition {
        sample: own.sample.or(named.sample),
        participant: own.participant.or(named.participant),
        load_n: args.load.map(Newtons).or(own.load_n).or(named.load_n),
        angle_deg: own.angle_deg.or(named.angle_deg),
        speed_m_s: speed_m_s.or(own.speed_m_s).or(named.speed_m_s),
        touch: touch.or(own.touch).or(named.touch),
        twin_seed: own.twin_seed,
    };
    Ok(())
}

fn stated_roles(guessed: Roles, args: &Takes, recording: &Recording) -> anyhow::Result<Roles> {
    let motion = match &args.motion {
        None => guessed.motion,
        Some(name) => {
            let channel = recording.pick(Some(name), &Unit::MetrePerSecond)?;
            Some(match channel.unit {
                Unit::Metre => Motion::Position(name.clone()),
                _ => Motion::Speed(name.clone()),
            })
        }
    };
    let stated = |names: &[String], guessed: Vec<String>| {
        if names.is_empty() {
            guessed
        } else {
            names.to_vec()
        }
    };
    let roles = Roles {
        vibration: stated(&args.vibration, guessed.vibration),
        normal_force: args.normal_force.clone().or(guessed.normal_force),
        tangential_force: stated(&args.tangential_force, guessed.tangential_force),
        motion,
    };
    for name in roles.vibration.iter().chain(&roles.tangential_force) {
        recording.pick(Some(name), &Unit::Newton)?;
    }
    Ok(Roles {
        // A force named normal is not tangential, whatever its name suggests.
        tangential_force: roles
            .tangential_force
            .into_iter()
            .filter(|name| roles.normal_force.as_ref() != Some(name))
            .collect(),
        ..roles
    })
}

/// Computes the features of every recording that has strokes.
pub(crate) fn analyse_all(takes: &mut [Take], computing: &Computing) -> Outcome {
    let bar = many("analysing", takes.len());
    // Lines must be the same for all recordings of one rate, so that they can be averaged.
    let mut longest: BTreeMap<u64, Vec<usize>> = BTreeMap::new();
    for take in takes.iter() {
        let lengths = take.segmentation.strokes.iter().map(|s| s.steady.len());
        longest
            .entry(nominal_rate(take))
            .or_default()
            .extend(lengths.max());
    }
    for take in takes.iter_mut() {
        bar.inc(1);
        if take.segmentation.strokes.is_empty() {
            continue;
        }
        let at =
            |error: anyhow::Error| Failure::Data(error.context(take.path.display().to_string()));
        let longest = longest
            .get(&nominal_rate(take))
            .map_or(&[][..], Vec::as_slice);
        let high_pass = match computing.high_pass {
            Some(stated) => stated.0,
            None => usual_high_pass(take),
        };
        let mut config = FeatureConfig::usual(take.recording.rate(), longest, high_pass)
            .map_err(|error| at(error.into()))?;
        if let Some(segment) = computing.segment {
            config.welch.segment = segment;
        }
        take.analysis = Some(
            feature::analyse(&take.recording, &take.segmentation, &config)
                .map_err(|error| at(error.into()))?,
        );
    }
    bar.finish_and_clear();
    if takes.iter().all(|take| take.analysis.is_none()) {
        for doubt in doubts_once(takes, &[]) {
            say(&format!("doubt: {doubt}"));
        }
        let first = takes.iter().flat_map(Take::doubts).find(|doubt| {
            matches!(
                doubt.kind(),
                Some(StrokeDoubt::NoContact { .. } | StrokeDoubt::Rejected { .. })
            )
        });
        return Err(anyhow!(
            "expected strokes, found none in {}{}",
            match takes {
                [only] => only.name.clone(),
                all => format!("all {} recordings", all.len()),
            },
            first.map_or(String::new(), |doubt| format!(": {}", text(&doubt)))
        )
        .into());
    }
    Ok(())
}

/// Time stamps give rates that differ in the last digits: recordings of one instrument share lines.
fn nominal_rate(take: &Take) -> u64 {
    (take.recording.rate().hz() * 10.0).round() as u64 / 2
}

/// The gesture is taken away from accelerations; what another signal holds below 5 Hz is not known to be one.
fn usual_high_pass(take: &Take) -> Option<HighPass> {
    let vibration = take.segmentation.roles.vibration.first()?;
    let channel = take
        .recording
        .pick(Some(vibration), &Unit::MetrePerSecondSquared)
        .ok()?;
    (channel.unit == Unit::MetrePerSecondSquared).then(HighPass::gesture)
}

/// The sample sets: those of the program, and the one stated.
pub(crate) fn sample_sets(computing: &Computing) -> Outcome<Vec<SampleSet>> {
    let mut sets = known_sample_sets()?;
    if let Some(path) = &computing.set {
        // A laboratory's own set goes before ours where both name a sample.
        sets.insert(0, read_sample_set(path)?);
    }
    Ok(sets)
}

/// The wavelength of the finger's ridges, m.
pub(crate) fn ridge_m(computing: &Computing) -> Outcome<Option<f64>> {
    match &computing.ridge {
        Some(ridge) if ridge.unit != Unit::Metre || !(1e-5..1e-2).contains(&ridge.value) => {
            Err(usage(anyhow!(
                "expected a length such as 0.5mm for --ridge, found {ridge}; give it in mm or um"
            )))
        }
        ridge => Ok(ridge.as_ref().map(|ridge| ridge.value)),
    }
}
