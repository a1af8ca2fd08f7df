//! The stimuli of a protocol: made of the strokes of a participant, kept where they were prepared before, and judged as a session would.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Error, anyhow};
use piezotact::checksum::Checksum;
use piezotact::lineage::{self, Mode};
use piezotact::manipulate::Texture as Made;
use piezotact::prepare::{Prepared, PreparedDrives, State};
use piezotact::quantity::{Acceleration, Drive};
use piezotact::recording::{BenchKind, Condition};
use piezotact::series::Series;
use piezotact::statistics::peak;
use piezotact::transfer::TransferFunction;
use piezotact_bench::Bench;
use piezotact_dataset::sidecar::read_rendering;
use piezotact_dataset::{ReadOptions, read_recording, texture_file_name};
use piezotact_people::campaign::protocol::{Protocol, Stimulus, TransferFunctionUse};
use piezotact_people::campaign::readiness::{
    self, BenchNow, PreparedStimuli, before_rendering, changed_since, prepared_stimuli,
};

use super::drives::finger_of;
use super::strokes::Texture;
use super::{Arguments, LevelRule, file};
use crate::cli::{Level, ModeName, Render};
use crate::commands::campaign::protocol_of;
use crate::commands::campaign::run::Drives;
use crate::commands::campaign::study::now_ms;
use crate::commands::render::config_of;
use crate::commands::verify::verified;
use crate::failure::{Failure, Outcome, usage};
use crate::manipulations::Speed;
use crate::output::say;
use crate::report::name;
use crate::runs::run_plan;
use piezotact::study::AnalysedRecording;

/// Samples of two files are the same within this share of their peak: a file states them with 24 bits.
const SAME_SAMPLE: f64 = 1e-6;

/// The stimuli of a protocol that are rendered with one transfer function.
pub(super) struct Stimuli {
    protocol: Protocol,
    /// Those that are made, plain ones among them.
    wanted: Vec<Stimulus>,
}

impl Stimuli {
    /// Those of the protocol `named` that are rendered with the participant's own or with an averaged transfer function, as `function`
    /// is one.
    pub(super) fn of(
        (named, level): (&Path, LevelRule),
        function: &TransferFunction<Drive, Acceleration>,
    ) -> Outcome<Self> {
        if level == LevelRule::Fit {
            return Err(usage(anyhow!(
                "expected one level for all stimuli of a protocol, found --level fit, which changes their levels among each other; give common, or a level in dB"
            )));
        }
        let protocol = protocol_of(named)?;
        let is_average = function.about.provenance.averaged_people.is_some();
        let (mut wanted, mut left) = (Vec::new(), Vec::new());
        for name in protocol.rendered() {
            let Some(stimulus) = protocol.stimulus(name).map(|one| one.into_owned()) else {
                continue;
            };
            let whose = protocol.transfer_function_of(&stimulus);
            match matches!(whose, Some(TransferFunctionUse::Average { .. })) == is_average {
                true => wanted.push(stimulus),
                false => left.push(name),
            }
        }
        let other = match is_average {
            true => "the participant's own transfer function",
            false => "an averaged transfer function",
        };
        if wanted.is_empty() {
            return Err(usage(match left.is_empty() {
                true => anyhow!(
                    "the protocol {} renders nothing: nothing is to be prepared",
                    protocol.name
                ),
                false => anyhow!(
                    "the protocol {} renders with {other}: give it by --transfer",
                    protocol.name
                ),
            }));
        }
        let states_level = wanted.iter().any(|one| one.rms_db.is_some());
        if states_level && !matches!(level, LevelRule::Stated(db) if db.abs() < 0.005) {
            return Err(usage(anyhow!(
                "expected --level 0, as the protocol {} states levels in dB re 1 m/s²",
                protocol.name
            )));
        }
        // In the order of the protocol.
        let place = |one: &Stimulus| {
            let samples = protocol.samples.iter();
            let names = samples.chain(protocol.stimuli.iter().map(|made| &made.name));
            names.into_iter().position(|name| *name == one.name)
        };
        wanted.sort_by_key(place);
        if !left.is_empty() {
            say(&format!(
                "{}: rendered with {other}; give the same command with it, and with --level, for these",
                left.join(", ")
            ));
        }
        Ok(Self { protocol, wanted })
    }

    pub(super) fn file_names(&self) -> impl Iterator<Item = String> {
        let made = self.wanted.iter().filter(|one| one.name != one.of);
        made.map(|stimulus| texture_file_name(&stimulus.name))
    }

    /// Refuses strokes of nobody, and of samples that the protocol does not have.
    pub(super) fn require_strokes_of(
        &self,
        groups: &[(String, Vec<&AnalysedRecording>)],
        participant: Option<&str>,
    ) -> Outcome {
        if participant.is_none() {
            return Err(usage(anyhow!(
                "expected strokes that state their participant, found none; state it with --meta, as the session compares it"
            )));
        }
        let samples = &self.protocol.samples;
        let unknown = groups.iter().find(|(sample, _)| !samples.contains(sample));
        match unknown {
            None => Ok(()),
            Some((found, _)) => Err(usage(anyhow!(
                "expected strokes on samples of the protocol {}, which are {}, found `{found}`; leave it out, or state its sample with --meta",
                self.protocol.name,
                samples.join(", ")
            ))),
        }
    }

    /// Adds to the plain textures `all` those that are made of them, and leaves out those that are rendered in no session.
    pub(super) fn make_of(&self, all: &mut Vec<Texture>, args: &Arguments) -> Outcome {
        let (out, measured) = (&args.out, lineage::Level::Within(args.band));
        let touched: BTreeMap<String, Made<Acceleration>> = (all.iter())
            .map(|one| (one.strokes.texture.clone(), one.made.texture.clone()))
            .collect();
        let mut made = Vec::new();
        for stimulus in self.wanted.iter().filter(|one| one.name != one.of) {
            let missing = stimulus
                .samples()
                .find(|sample| !touched.contains_key(*sample));
            let plain = all.iter().find(|one| one.strokes.texture == stimulus.of);
            let (None, Some(plain)) = (missing, plain) else {
                say(&format!(
                    "{}: not made: expected strokes on {}, found none; record them, and give all strokes again",
                    stimulus.name,
                    missing.unwrap_or(&stimulus.of)
                ));
                continue;
            };
            let texture = stimulus.texture(|sample| touched.get(sample), measured);
            let texture = texture
                .map_err(|error| Failure::Data(Error::new(error).context(stimulus.name.clone())))?;
            let speed = stimulus.warp.map_or(Speed::Kept, |_| Speed::Changed);
            let mut warnings = plain.warnings.clone();
            warnings.extend(texture.warnings.iter().cloned());
            let called = texture_file_name(&stimulus.name);
            let mut strokes = plain.strokes.clone();
            strokes.texture.clone_from(&stimulus.name);
            strokes.stroke.rms_m_s2 = texture.series.rms_about_mean().value;
            made.push(Texture {
                target: file(out, "targets", &called, "wav"),
                called,
                strokes,
                made: plain.made.made_into(texture, speed),
                warnings,
            });
        }
        all.retain(|one| {
            self.wanted
                .iter()
                .any(|wanted| wanted.name == one.strokes.texture)
        });
        all.extend(made);
        Ok(())
    }

    /// What is ready of them, by the same rules as before a session.
    pub(super) fn prepared(
        &self,
        args: &Arguments,
        participant: &str,
        drives: PreparedDrives,
    ) -> Outcome<PreparedStimuli> {
        let names = self.wanted.iter().map(|one| one.name.as_str());
        let mut there = Drives::of((&self.protocol, participant), names, &args.out, None)?;
        let mut bench = args.bench.as_ref().map(|bench| bench.open()).transpose()?;
        if let Some(bench) = &mut bench {
            there.compare_with(bench)?;
        }
        let function = there
            .facts
            .first()
            .map(|one| one.transfer_function.condition.clone());
        let here = bench.as_ref().map(|bench| {
            let finger = crate::cli::Finger {
                load: function
                    .as_ref()
                    .and_then(|one| one.load_n)
                    .map(|load| load.0),
                angle: function
                    .as_ref()
                    .and_then(|one| one.angle_deg)
                    .map(|angle| angle.0),
            };
            let run = run_plan("prepare", &finger, bench.acquirer.as_ref());
            BenchNow {
                kind: bench.acquirer.describe().kind,
                condition: bench.acquirer.condition(&run),
            }
        });
        let known = readiness::Known {
            renderings: &there.facts,
            incomplete: &there.incomplete,
            played: &BTreeMap::new(),
            earlier: &[],
            panels: &[],
            bench: here.as_ref(),
            sensor: None,
            now_ms: now_ms(),
        };
        Ok(prepared_stimuli(
            &self.protocol,
            (&self.wanted, participant),
            drives,
            known,
        ))
    }
}

/// With what drives that were prepared before are compared.
pub(super) struct Known {
    transfer: Checksum,
    here: Option<(BenchKind, Condition)>,
}

impl Known {
    pub(super) fn of(
        function: &TransferFunction<Drive, Acceleration>,
        bench: Option<&Bench>,
    ) -> Self {
        let here = bench.map(|bench| {
            let run = run_plan("prepare", &finger_of(function), bench.acquirer.as_ref());
            (
                bench.acquirer.describe().kind,
                bench.acquirer.condition(&run),
            )
        });
        Self {
            transfer: function.checksum(),
            here,
        }
    }
}

/// The drive of `texture` that an earlier command with the same protocol prepared, where its stroke, lineage, level, transfer function,
/// way of rendering and bench are those of `request`, and it passes again.
pub(super) fn held(
    args: &Arguments,
    request: &Render,
    known: &Known,
    texture: &Texture,
) -> Option<Prepared> {
    let (Some(_), Some((kind, here)), Level::Stated(level_db)) =
        (&args.protocol, &known.here, request.level)
    else {
        return None;
    };
    let place = |part: &str, ending: &str| file(&args.out, part, &texture.called, ending);
    let (drive, record) = (place("drives", "wav"), place("measured", "parquet"));
    // An interrupted recording would be read from its journal, and a session does not take it.
    if !record.is_file() {
        return None;
    }
    let open = |path: &Path| read_recording(path, &ReadOptions::default()).ok();
    let target = open(&texture.target)?.recording;
    let stated = target
        .about
        .provenance
        .lineage
        .as_ref()
        .map(before_rendering)?;
    let lineage = before_rendering(&texture.made.texture.lineage);
    let is_target = is_same(&target.series::<Acceleration>(None).ok()?, texture.series());
    let of_drive = open(&drive)?;
    let rendering = read_rendering(&drive)?;
    let about = &rendering.about.provenance;
    let aim = args.mode.map(|mode| match mode {
        ModeName::Replicate => Mode::Replicate,
        ModeName::Texture => Mode::Texture,
    });
    let is_drive = about.lineage.as_ref().map(before_rendering).as_ref() == Some(&lineage)
        && about.made_with.first() == Some(&known.transfer)
        && (rendering.level_db - level_db).abs() < 0.005
        && rendering.aim == aim
        && config_of(request).is_ok_and(|config| config == rendering.config);
    let samples = of_drive.recording.series::<Drive>(None).ok()?;
    let measured = open(&record)?;
    let there = &measured.recording.about;
    let is_played = measured.played == Some(Checksum::of(samples.samples().iter().copied()))
        && (measured.rendering.iter()).all(|played| changed_since(played, &rendering).is_none());
    let is_measured = is_played
        && there.provenance.bench == Some(*kind)
        && there.condition.person() == here.person()
        && there.condition.twin_seed == here.twin_seed
        && there.condition.load_n == here.load_n
        && there.condition.angle_deg == here.angle_deg;
    if !(is_target && stated == lineage && is_drive && is_measured) {
        return None;
    }
    let verification = verified(&texture.target, &record, args.band).ok()?;
    (State::of(&verification) == State::Passed).then(|| {
        Prepared {
            strokes: texture.strokes.clone(),
            target: name(&texture.target),
            drive: Some(name(&drive)),
            measured: None,
            level_db: Some(level_db),
            headroom_db: rendering.headroom.headroom_db,
            achievable_band_hz: rendering.achievable_band_hz.clone(),
            state: State::NotMeasured,
            sentence: String::new(),
            verification: None,
            warnings: (texture.warnings.iter())
                .chain(rendering.about.warnings.iter())
                .cloned()
                .collect(),
        }
        .measured(name(&record), verification)
    })
}

fn is_same(a: &Series<Acceleration>, b: &Series<Acceleration>) -> bool {
    let (a, b) = (a.samples(), b.samples());
    let most = SAME_SAMPLE * peak(b);
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= most)
}
