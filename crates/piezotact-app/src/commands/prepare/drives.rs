//! The drives: rendered at one level, played, measured and compared with their strokes.

use std::path::{Path, PathBuf};

use piezotact::prepare::{Prepared, State, common_level};
use piezotact::quantity::{Acceleration, Decibels, Drive};
use piezotact::render::Rendering;
use piezotact::transfer::TransferFunction;
use piezotact::verify::Verification;
use piezotact::warning::Warnings;
use piezotact_bench::Bench;
use piezotact_dataset::read_input;

use super::strokes::{Texture, Textures};
use super::{Arguments, LevelRule, file};
use crate::benches::BenchSpec;
use crate::cli::{Finger, Level, Reading, Render};
use crate::commands::play::played;
use crate::commands::render::{self, Done};
use crate::commands::verify::verified;
use crate::deliver::Outputs;
use crate::failure::{Failure, Outcome, sentence};
use crate::interrupt::{Between, interrupted};
use crate::keeping::{Earlier, Raw, done};
use crate::output::{say, write_bytes};
use crate::progress::{Words, Work};
use crate::report::name;
use crate::runs::run_plan;

const PREPARING: Words = Words {
    doing: "preparing",
    done: "prepared",
    item: "texture",
    then: "preparing",
};
/// A closed loop keeps its drives this much below the limit of the device.
const LOOP_MARGIN: Decibels = Decibels(0.3);

/// How often a drive that misses its target is measured.
const TURNS: usize = 3;

/// What is asked for all drives.
pub(super) struct Drives<'a> {
    args: &'a Arguments,
    render: Render,
    finger: Finger,
    bench: Option<Bench>,
    pub(super) bench_name: Option<String>,
    pub(super) level_set_by: Option<String>,
    /// What drives that were prepared before are compared with.
    #[cfg(feature = "study")]
    known: super::stimuli::Known,
}

impl<'a> Drives<'a> {
    /// The drives of `textures`, at the level that is stated or at which all fit.
    pub(super) fn of(
        args: &'a Arguments,
        textures: &Textures,
        function: &TransferFunction<Drive, Acceleration>,
        bench: Option<Bench>,
    ) -> Outcome<Self> {
        let mut render = request(args);
        let mut level_set_by = None;
        render.level = match args.level {
            LevelRule::Fit => Level::Fit,
            LevelRule::Stated(level_db) => Level::Stated(level_db),
            LevelRule::Common => {
                let config = render::config_of(&Render {
                    level: Level::Fit,
                    ..request(args)
                })?;
                let targets: Vec<_> = textures
                    .all
                    .iter()
                    .map(|one| one.series().clone())
                    .collect();
                let margin = args.mode.map_or(Decibels(0.0), |_| LOOP_MARGIN);
                let level = common_level(&targets, function, &config, margin);
                let by = level.limited_by.map(|i| &textures.all[i].strokes.texture);
                level_set_by = by.cloned();
                Level::Stated(level.level_db)
            }
        };
        let bench_name = bench.as_ref();
        let bench_name = bench_name.map(|bench| bench.acquirer.describe().name.clone());
        #[cfg(feature = "study")]
        let known = super::stimuli::Known::of(function, bench.as_ref());
        // A closed loop opens it by itself.
        let bench = bench.filter(|_| args.mode.is_none());
        Ok(Self {
            args,
            render,
            finger: finger_of(function),
            bench,
            bench_name,
            level_set_by,
            #[cfg(feature = "study")]
            known,
        })
    }

    /// The level of all textures, dB; none where each has its own.
    pub(super) fn level_db(&self) -> Option<f64> {
        match self.render.level {
            Level::Stated(level_db) => Some(level_db),
            Level::Fit => None,
        }
    }

    /// Renders, plays and measures the drive of each of `textures`.
    pub(super) fn prepared(mut self, textures: Textures) -> Outcome<Vec<Prepared>> {
        let (args, mut all) = (self.args, Vec::new());
        let request = Render {
            finger: match args.mode {
                Some(_) => Finger { ..self.finger },
                None => Finger {
                    load: None,
                    angle: None,
                },
            },
            ..self.render
        };
        #[cfg(feature = "study")]
        let before = |texture: &Texture| super::stimuli::held(args, &request, &self.known, texture);
        #[cfg(not(feature = "study"))]
        let before = |_: &Texture| None;
        let held: Vec<Option<Prepared>> = textures.all.iter().map(before).collect();
        let made: Vec<&Texture> = (textures.all.iter().zip(&held))
            .filter_map(|(texture, held)| held.is_none().then_some(texture))
            .collect();
        // Each with what stood at the places of its files.
        let earlier = made.iter().map(|texture| texture.written(&args.out));
        let earlier: Vec<Vec<Earlier>> = earlier.collect::<Outcome<_>>()?;
        let request = places(args, &made, request);
        let jobs = match made.is_empty() {
            true => Vec::new(),
            false => render::jobs(&request)?,
        };
        let preparing = Work::of_steps(PREPARING, jobs.len());
        let between = Between::items(PREPARING.item);
        let mut to_do = jobs.iter().zip(earlier);
        for (texture, held) in textures.all.into_iter().zip(held) {
            let target = name(&texture.target);
            if let Some(held) = held {
                say(&format!(
                    "{}: prepared before, and verified again",
                    texture.strokes.texture
                ));
                all.push(held);
                continue;
            }
            let Some((job, earlier)) = to_do.next() else {
                continue;
            };
            say(&format!("{}:", texture.strokes.texture));
            if interrupted() {
                let why = "interrupted before it was begun";
                earlier.into_iter().try_for_each(Earlier::put_back)?;
                all.push(Prepared::not_rendered(texture.strokes, target, why));
                continue;
            }
            let rendered = job.done(&request);
            all.push(match rendered {
                Ok(done) => {
                    let found = measured(args, &self.finger, self.bench.as_mut(), texture, &done)?;
                    earlier.into_iter().try_for_each(Earlier::settle)?;
                    found
                }
                Err(Failure::Data(error) | Failure::Usage(error)) => {
                    earlier.into_iter().try_for_each(Earlier::put_back)?;
                    Prepared::not_rendered(texture.strokes, target, &sentence(&error))
                }
                Err(other) => return Err(other),
            });
            preparing.one_more();
        }
        drop((preparing, between));
        let runs = jobs.iter().filter_map(|job| job.runs.as_ref());
        if !interrupted() {
            runs.map(|runs| done(runs, Raw::Kept))
                .collect::<Outcome<Vec<()>>>()?;
        }
        Ok(all)
    }
}

/// A texture that was rendered, with what its measurement on `bench` showed.
fn measured(
    args: &Arguments,
    finger: &Finger,
    bench: Option<&mut Bench>,
    texture: Texture,
    done: &Done,
) -> Outcome<Prepared> {
    let drive = &done.drive;
    let mut prepared = Prepared {
        strokes: texture.strokes,
        target: name(&texture.target),
        drive: Some(name(&file(&args.out, "drives", &texture.called, "wav"))),
        measured: None,
        level_db: Some(done.level_db),
        headroom_db: drive.headroom.headroom_db,
        achievable_band_hz: drive.coverage.reached.clone(),
        state: State::NotMeasured,
        sentence: "not measured: play the drive, record the response, and compare it with its target by `piezotact verify`".into(),
        verification: None,
        warnings: texture.warnings.into_iter().chain(drive.about.warnings.iter().cloned()).collect::<Warnings>(),
    };
    if args.bench.is_none() {
        return Ok(prepared);
    }
    let record = file(&args.out, "measured", &texture.called, "parquet");
    let rendering = Rendering::of(drive, &prepared.target, done.level_db);
    let play = |bench: &mut Bench, label: &str, record: &Path| -> Outcome {
        let run = run_plan(label, finger, bench.acquirer.as_ref());
        let setup = drive.setup.as_ref();
        let drive = (&drive.drive, Some(&rendering));
        played(bench, drive, setup, &run, record).map(|_recording| ())
    };
    let mut bench = bench;
    if let Some(bench) = bench.as_deref_mut() {
        // Each is a placement of the finger of its own.
        match play(bench, &format!("prepare {}", texture.called), &record) {
            Ok(()) => {}
            Err(Failure::Data(error)) => {
                prepared.sentence = format!("not measured: {}", sentence(&error));
                return Ok(prepared);
            }
            Err(other) => return Err(other),
        }
    }
    let first = verified(&texture.target, &record, args.band)?;
    let mut middle = None;
    if State::of(&first) != State::Passed {
        // A closed loop measured it on a bench that it opened by itself.
        let mut own = match bench {
            Some(_) => None,
            None => args.bench.as_ref().map(BenchSpec::open).transpose()?,
        };
        if let Some(bench) = bench.or(own.as_mut()) {
            let mut again = |turn: usize, place: &Path| {
                play(
                    bench,
                    &format!("prepare {}, turn {turn}", texture.called),
                    place,
                )?;
                verified(&texture.target, place, args.band)
            };
            middle = middle_of_turns(&record, &first, &mut again)?;
        }
    }
    let of_turns = middle.is_some();
    let mut prepared = prepared.measured(name(&record), middle.unwrap_or(first));
    if of_turns {
        prepared.sentence +=
            &format!("; the middle one of {TURNS} measurements by its spectrum error");
    }
    if let Some(why) = done.unfinished() {
        prepared.sentence += &format!("; the closed loop did not come to its end: {why}");
    }
    Ok(prepared)
}

/// The middle one of several measurements by its spectrum error: the finger presses more or less each time, so that one that missed
/// decides nothing yet, and choosing the best would pass what misses on average. It is kept as `record`, of which `first` is the
/// verification, and all as `NAME.1.parquet` and so on. None where it could not be measured again.
fn middle_of_turns(
    record: &Path,
    first: &Verification,
    again: &mut dyn FnMut(usize, &Path) -> Outcome<Verification>,
) -> Outcome<Option<Verification>> {
    let place = |turn: usize| record.with_extension(format!("{turn}.parquet"));
    let mut all = vec![(first.clone(), place(1))];
    for turn in 2..=TURNS {
        if interrupted() {
            return Ok(None);
        }
        let earlier = Earlier::at(&place(turn), "an earlier measurement")?;
        match again(turn, &place(turn)) {
            Ok(found) => all.push((found, place(turn))),
            Err(Failure::Data(error)) => {
                say(&format!("not measured again: {}", sentence(&error)));
                return Ok(None);
            }
            Err(other) => return Err(other),
        }
        earlier.settle()?;
    }
    let earlier = Earlier::at(&place(1), "an earlier measurement")?;
    std::fs::rename(record, place(1))?;
    earlier.settle()?;
    all.sort_by(|(a, _), (b, _)| a.judged_error_db().total_cmp(&b.judged_error_db()));
    let (verification, chosen) = all.swap_remove(TURNS / 2);
    write_bytes(record, &read_input(&chosen)?)?;
    Ok(Some(verification))
}

/// How the finger lay when `function` was measured.
pub(super) fn finger_of(function: &TransferFunction<Drive, Acceleration>) -> Finger {
    let condition = &function.about.condition;
    Finger {
        load: condition.load_n.map(|load| load.0),
        angle: condition.angle_deg.map(|angle| angle.0),
    }
}

/// `request` for the drives of `textures`, with their files.
fn places(args: &Arguments, textures: &[&Texture], request: Render) -> Render {
    let place = |part: &str, ending: &str| -> PathBuf {
        match textures {
            [only] => file(&args.out, part, &only.called, ending),
            _ => args.out.join(part),
        }
    };
    Render {
        targets: textures.iter().map(|one| one.target.clone()).collect(),
        out: place("drives", "wav"),
        record: args.mode.map(|_| place("measured", "parquet")),
        ..request
    }
}

/// The renderings that are asked for, of no texture yet and at a level to be set.
fn request(args: &Arguments) -> Render {
    Render {
        targets: Vec::new(),
        transfer: vec![args.transfer.clone()],
        out: args.out.join("drives"),
        band: args.band,
        channel: None,
        reading: Reading {
            scale: Vec::new(),
            rate: None,
            part: None,
        },
        gain: None,
        device: None,
        level: Level::Fit,
        drive_rate: args.drive_rate,
        inverse: args.inverse,
        phase: crate::cli::PhaseName::Linear,
        mode: args.mode,
        bench: match args.mode {
            Some(_) => args.bench.iter().cloned().collect(),
            None => Vec::new(),
        },
        iterations: args.iterations,
        finger: Finger {
            load: None,
            angle: None,
        },
        record: None,
        discard_raw: false,
        allow_clipping: false,
        outputs: Outputs::default(),
        fade: 0.0,
    }
}
