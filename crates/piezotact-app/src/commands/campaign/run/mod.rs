//! `piezotact campaign run`: a session with a participant on the terminal.

mod clock;
mod drives;
mod shown;
mod terminal;
mod touches;
mod typed;
mod words;

use piezotact_study::session::RunError;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, anyhow};
use clap::{Args, ValueEnum};
use piezotact::quantity::{Acceleration, Band, Drive, Hertz};
use piezotact::recording::{BenchKind, StartTime};
use piezotact::render::Rendering;
use piezotact::run::{RunStart, Sink, SinkError};
use piezotact::transfer::{TransferFunction, at_rest};
use piezotact_bench::procedure::RunKeeper;
use piezotact_bench::{Bench, RunPlan};
use piezotact_dataset::{JournalSink, read_transfer};
use piezotact_people::campaign::chain::{Salt, Sha};
use piezotact_people::campaign::plan::Plan;
use piezotact_people::campaign::protocol::Playing;
use piezotact_people::campaign::readiness::{
    BenchNow, EarlierSession, Known, NotReady, SensorNow, not_ready, stimuli_of,
};
use piezotact_people::campaign::session::{Command, Event, Participant, Stage};
use piezotact_people::campaign::store::Purpose;
use piezotact_people::campaign::text::check_short;
use piezotact_study::session::{
    BenchStimulator, Outside, PlayStop, Played, Runner, Stimulator, Stimuli, TouchBench,
};

use super::plan::planned;
use super::study::{Begun, Study, now_ms, said};
use crate::benches::{self, BenchSpec};
use crate::cli::Finger;
use crate::failure::{Failure, Outcome, usage};
use crate::interrupt::stops;
use crate::invocation;
use crate::keeping::began;
use crate::live::Showing;
use crate::output::say;
use crate::runs::run_plan;
pub(in crate::commands) use drives::Drives;
pub(super) use drives::require_names;
use touches::{run_name, touches};
use typed::Typing;

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The folder of the study.
    #[arg(value_name = "STUDY")]
    pub(crate) study: PathBuf,
    /// The participant's pseudonym.
    pub(crate) participant: String,
    /// The session, by its name in the protocol.
    pub(crate) session: String,
    #[command(flatten)]
    pub(crate) leading: Leading,
}

/// How a session is led.
#[derive(Clone, Debug, Args)]
pub(crate) struct Leading {
    /// The tag of the experimenter, kept with the session.
    #[arg(long, value_name = "TAG", default_value = "experimenter", value_parser = short)]
    experimenter: String,
    /// The bench on which rendered textures are played.
    #[arg(long, help = benches::help("The bench on which rendered textures are played"))]
    pub(crate) bench: Option<BenchSpec>,
    /// Rendered textures are played by hand, on another system: nothing is known of what was felt.
    #[arg(long, conflicts_with_all = ["bench", "drives"])]
    pub(crate) by_hand: bool,
    /// The folder of the participant's drives that `piezotact prepare` wrote; it is copied into the study.
    #[arg(long, value_name = "FOLDER")]
    drives: Option<PathBuf>,
    /// Checks the sensor, which the loopback does not: the response of the device with nobody on it, as it was stored when the sensor was
    /// calibrated and as it was measured today, both by `piezotact characterise`.
    #[arg(long, num_args = 2, value_names = ["STORED", "TODAY"], requires = "bench")]
    at_rest: Vec<PathBuf>,
    /// A rehearsal: it is kept, marked, and never analysed; what a session with a volunteer would be refused for is said only.
    #[arg(long)]
    rehearsal: bool,
    /// The participant's sex, as stated.
    #[arg(long, value_parser = short)]
    sex: Option<String>,
    /// The participant's age in years.
    #[arg(long, value_name = "YEARS", value_parser = clap::value_parser!(u32).range(1..=120))]
    age: Option<u32>,
    /// The participant's handedness.
    #[arg(long)]
    handedness: Option<Handedness>,
    /// The finger that touches; default: that of the protocol.
    #[arg(long, value_parser = short)]
    finger: Option<String>,
    /// The language of the instructions, such as fr.
    #[arg(long, value_parser = short)]
    language: Option<String>,
}

/// A text that stands in tables.
fn short(text: &str) -> Result<String, String> {
    check_short(text).map_err(|error| error.to_string())?;
    Ok(text.to_owned())
}

/// Which hand is preferred.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Handedness {
    /// The right hand.
    Right,
    /// The left hand.
    Left,
    /// Both alike.
    Both,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    lead(args, &mut Typing)
}

/// Where the experimenter leads a session: the terminal, or a page.
pub(crate) trait Front {
    /// The bench, whose playing is shown.
    fn shown(&self, bench: TouchBench<'static>) -> Box<dyn Stimulator>;

    /// The session of `runner` from where it stands, until it is left.
    fn lead(&mut self, runner: Runner<'_>, args: &Arguments, about: About<'_>) -> Outcome;
}

/// What a front end shows of a session beside its state.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(
    not(feature = "web"),
    expect(dead_code, reason = "only pages show all of it")
)]
pub(crate) struct About<'a> {
    /// What is to be said of the clock of the computer, where it is behind what is stored.
    pub(crate) clock: Option<&'a str>,
    /// The text that consent is given to.
    pub(crate) consent: Option<&'a str>,
    /// The folder of the session.
    pub(crate) folder: &'a Path,
    /// Stops what is played.
    pub(crate) stop: &'a PlayStop,
}

/// The session that `args` name, led at `front`.
pub(crate) fn lead(args: &Arguments, front: &mut dyn Front) -> Outcome {
    let mut study = Study::open(&args.study)?;
    let participant = study.participant(&args.participant)?;
    study.require_people()?;
    if study.not_erased()?.contains(participant.as_str()) {
        return Err(Failure::Data(anyhow!(withdrawn(args))));
    }
    let clock = clock::check(&study.store)?;
    let plan = planned(&study, &participant, &args.session)?;
    let folder = study.store.session_folder(&participant, &args.session)?;
    let given = args.leading.drives.as_deref();
    let mut drives = Drives::of(
        (&study.campaign.protocol, participant.as_str()),
        stimuli_of(&plan),
        &folder,
        given,
    )?;
    let before = begun(&study, &plan)?;
    let is_begun = before.is_some();
    let mut bench = args
        .leading
        .bench
        .as_ref()
        .map(|bench| bench.open())
        .transpose()?;
    if let Some(bench) = &mut bench {
        drives.compare_with(bench)?;
    }
    let here = bench.as_ref().map(|bench| bench_now(&drives, bench));
    let here = here.filter(|_| !stimuli_of(&plan).is_empty());
    ready((&study, &plan), &drives, args, before, here.as_ref())?;
    let _alone = study.store.run_alone(&participant, &args.session)?;
    if !is_begun {
        study.store.write_plan(&plan)?;
    }
    let here = (folder.as_path(), clock.as_deref());
    played((&mut study, &plan), args, (bench, drives, here), front)
}

/// The session of `plan` with its stimuli on `bench`.
fn played(
    (study, plan): (&mut Study, &Plan),
    args: &Arguments,
    (bench, drives, (folder, clock)): (Option<Bench>, Drives, (&Path, Option<&str>)),
    front: &mut dyn Front,
) -> Outcome {
    let taken = drives.given.clone();
    let mut bench = match bench {
        Some(bench) => Some(front.shown(on_bench((study, plan), args, (bench, drives), folder)?)),
        None => None,
    };
    let stimuli = match (&mut bench, args.leading.by_hand) {
        (Some(bench), _) => Stimuli::On(bench.as_mut()),
        (None, true) => Stimuli::ByHand,
        (None, false) => Stimuli::Nowhere,
    };
    let consent = study.campaign.consent.clone();
    let (mut now, mut salted) = (now_ms, salt);
    let stop = PlayStop::default();
    // Ctrl-C ends a texture at once, and the session with it.
    stops(stop.for_good());
    let outside = Outside {
        now_ms: &mut now,
        salt: &mut salted,
        stop: stop.clone(),
    };
    let campaign = &study.campaign.protocol;
    let runner = Runner::open(
        &mut study.store,
        (campaign, plan),
        purpose(args),
        stimuli,
        outside,
    )?;
    drives::keep(&taken, folder)?;
    let consent = consent.as_deref();
    let about = About {
        clock,
        consent,
        folder,
        stop: &stop,
    };
    front.lead(runner, args, about)
}

fn purpose(args: &Arguments) -> Purpose {
    match args.leading.rehearsal {
        true => Purpose::Rehearsal,
        false => Purpose::Volunteer,
    }
}

/// Fresh entropy of the system.
fn salt() -> Result<Salt, RunError> {
    let mut salt = Salt::default();
    getrandom::fill(&mut salt).map_err(|error| RunError::Salt(error.to_string()))?;
    Ok(salt)
}

/// Where the session of `plan` stands, and the drives that it played; none where it was not begun.
fn begun(study: &Study, plan: &Plan) -> Outcome<Option<(Stage, BTreeMap<String, Sha>)>> {
    let is_it = |begun: &Begun| begun.plan.as_ref() == Some(plan);
    if !study.sessions()?.iter().any(is_it) {
        return Ok(None);
    }
    let state = study.state(plan)?;
    let evidence = state.trials().flat_map(|(_, trial)| &trial.evidence);
    let played = evidence.map(|(_, one)| (one.stimulus.clone(), one.drive));
    Ok(Some((state.stage(), played.collect())))
}

/// Refuses a session with a volunteer for which something is missing; a rehearsal says it only. One that was begun is refused for
/// its drives alone.
fn ready(
    (study, plan): (&Study, &Plan),
    drives: &Drives,
    args: &Arguments,
    begun: Option<(Stage, BTreeMap<String, Sha>)>,
    bench: Option<&BenchNow>,
) -> Outcome {
    let (stage, played) = begun.unzip();
    let played = played.unwrap_or_default();
    if matches!(
        stage,
        Some(Stage::Ended | Stage::Stopped | Stage::Withdrawn)
    ) {
        return Ok(());
    }
    let (renderings, incomplete) = match args.leading.by_hand {
        // Nothing is played here.
        true => (&[][..], &[][..]),
        false => (&drives.facts[..], &drives.incomplete[..]),
    };
    let ended = ended(study, &plan.participant)?;
    let earlier: Vec<EarlierSession<'_>> = ended
        .iter()
        .map(|(session, ended_ms)| EarlierSession {
            session,
            ended_ms: *ended_ms,
        })
        .collect();
    let sensor = sensor(&args.leading.at_rest)?;
    let known = Known {
        renderings,
        incomplete,
        played: &played,
        earlier: &earlier,
        panels: &study.campaign.panels,
        bench,
        sensor: sensor.as_ref(),
        now_ms: now_ms(),
    };
    let mut missing = not_ready(&study.campaign.protocol, plan, known);
    if args.leading.by_hand {
        missing.retain(|one| !matches!(one, NotReady::Missing { .. }));
    } else if args.leading.bench.is_none() && !stimuli_of(plan).is_empty() {
        return Err(usage(anyhow!(
            "this session plays rendered textures: name the bench with --bench, or play them on another system with --by-hand"
        )));
    }
    if stage.is_some() {
        missing.retain(|one| {
            let of_bench = matches!(
                one,
                NotReady::NoFinger { .. }
                    | NotReady::OtherFinger { .. }
                    | NotReady::Sensor(_)
                    | NotReady::SensorOld { .. }
            );
            of_bench || one.stimulus().is_some()
        });
    }
    if missing.is_empty() {
        return Ok(());
    }
    for line in merged(&missing) {
        say(&format!("not ready: {line}"));
    }
    if missing.iter().any(|one| one.stimulus().is_some()) {
        say("drives are made by: piezotact prepare --protocol PROTOCOL.toml STROKES…");
    }
    match args.leading.rehearsal {
        true => Ok(()),
        false => Err(Failure::Data(anyhow!(
            "session {} of {} cannot {}, for the {} above; nothing was stored{}",
            plan.session,
            plan.participant,
            stage.map_or("begin", |_| "go on"),
            match missing.len() {
                1 => "reason".to_owned(),
                count => format!("{count} reasons"),
            },
            stage.map_or(" (--rehearsal tries it out nevertheless)", |_| "")
        ))),
    }
}

/// What the response at rest of today, the second of `files`, says of the sensor against the stored one, the first.
fn sensor(files: &[PathBuf]) -> Outcome<Option<SensorNow>> {
    let [stored, today] = files else {
        return Ok(None);
    };
    let read = |file: &PathBuf| -> Outcome<TransferFunction<Drive, Acceleration>> {
        Ok(read_transfer(file)?.function(file)?)
    };
    let now = read(today)?;
    let against_stored = at_rest(&now, &read(stored)?, Band::new(Hertz(20.0), Hertz(1000.0))?);
    let against_stored =
        against_stored.map_err(|error| Failure::Data(anyhow!("{}: {error}", today.display())))?;
    for criterion in &against_stored.criteria {
        say(&format!("sensor at rest: {criterion}"));
    }
    let at = now.about.provenance.measured_at.as_ref();
    Ok(Some(SensorNow {
        against_stored,
        at_ms: at.and_then(StartTime::unix_ms),
    }))
}

/// What is missing, stimuli that lack the same in one line.
fn merged(missing: &[NotReady]) -> Vec<String> {
    let mut lines: Vec<(String, Vec<&str>)> = Vec::new();
    for one in missing {
        let text = one.to_string();
        let stimulus = one.stimulus();
        let about = stimulus.and_then(|name| text.strip_prefix(name));
        let about = about.unwrap_or(&text).to_owned();
        match lines.iter_mut().find(|(known, _)| *known == about) {
            Some((_, stimuli)) => stimuli.extend(stimulus),
            None => lines.push((about, stimulus.into_iter().collect())),
        }
    }
    let lines = lines.into_iter();
    lines
        .map(|(about, stimuli)| format!("{}{about}", stimuli.join(", ")))
        .collect()
}

/// How the finger lies while `drives` are played on `bench`.
fn session_run(drives: &Drives, bench: &Bench) -> RunPlan {
    let condition = drives.ready.values().find_map(|drive| {
        let rendering = drive.rendering.as_ref()?;
        Some(rendering.about.condition.clone())
    });
    let finger = Finger {
        load: condition.as_ref().and_then(|c| c.load_n).map(|load| load.0),
        angle: condition.and_then(|c| c.angle_deg).map(|angle| angle.0),
    };
    run_plan("campaign", &finger, bench.acquirer.as_ref())
}

/// What `bench` is now, with the finger as it lies in the session.
fn bench_now(drives: &Drives, bench: &Bench) -> BenchNow {
    BenchNow {
        kind: bench.acquirer.describe().kind,
        condition: bench.acquirer.condition(&session_run(drives, bench)),
    }
}

/// The sessions of `participant` with a volunteer, and when each was ended.
fn ended(study: &Study, participant: &str) -> Outcome<Vec<(String, Option<i64>)>> {
    let mut found = Vec::new();
    for Begun { entry, plan, .. } in study.sessions()? {
        let Some(plan) = plan.filter(|plan| plan.participant == participant) else {
            continue;
        };
        let state = study.state(&plan)?;
        let ended = entry.purpose == Purpose::Volunteer && state.is_complete();
        let ended_ms = state.last_ms().filter(|_| ended);
        found.push((plan.session.clone(), ended_ms));
    }
    Ok(found)
}

/// The bench with the drives of the session, which records touches too.
fn on_bench(
    (study, plan): (&Study, &Plan),
    args: &Arguments,
    (bench, drives): (Bench, Drives),
    folder: &Path,
) -> Outcome<TouchBench<'static>> {
    let spec = args.leading.bench.clone();
    let spec = spec.ok_or_else(|| anyhow!("expected a bench by its name, found none"))?;
    let of_bench = (spec, bench.acquirer.describe().kind);
    let keeper = touches(of_bench, (&study.campaign.protocol, plan), folder);
    let bench = stimulator(study, bench, drives, folder)?;
    Ok(TouchBench::new(bench, &plan.participant, keeper))
}

/// The bench with the drives of the session, whose runs are kept in `folder`.
fn stimulator(
    study: &Study,
    bench: Bench,
    drives: Drives,
    folder: &Path,
) -> Outcome<BenchStimulator<'static>> {
    let rendering = &study.campaign.protocol.rendering;
    let run = session_run(&drives, &bench);
    let folder = folder.join("runs");
    std::fs::create_dir_all(&folder).with_context(|| {
        format!(
            "cannot create the folder {}; check the disk",
            folder.display()
        )
    })?;
    let all = Band::new(Hertz(20.0), Hertz(1000.0)).map_err(usage)?;
    Ok(BenchStimulator {
        bench,
        drives: drives.ready,
        playing: rendering
            .as_ref()
            .map_or(Playing::Once, |rendering| rendering.playing),
        band: drives.band.unwrap_or(all),
        load: run.load,
        angle: run.angle,
        journal: Box::new(move |played, rendering| journal(&folder, played, rendering)),
    })
}

/// Where the run of a playing is kept.
fn journal(
    folder: &Path,
    played: &Played<'_>,
    rendering: Option<&Rendering>,
) -> (Box<dyn RunKeeper>, Option<String>) {
    let name = run_name(played);
    let kept = Kept {
        path: folder.join(&name),
        rendering: rendering.cloned(),
    };
    (Box::new(kept), Some(format!("runs/{name}")))
}

/// A run that is kept as the recording at a path.
struct Kept {
    path: PathBuf,
    rendering: Option<Rendering>,
}

impl RunKeeper for Kept {
    fn now(&self, kind: BenchKind) -> Option<StartTime> {
        began(kind)
    }

    fn sink(&mut self, _start: &RunStart) -> Result<Box<dyn Sink + '_>, SinkError> {
        let journal = JournalSink::new(&self.path, self.rendering.take());
        Ok(Box::new(Showing(journal)))
    }
}

/// The command that begins the session, or goes on with one that was cut off; none for one that is over.
pub(crate) fn first_command(runner: &mut Runner<'_>, args: &Arguments) -> Option<Command> {
    let experimenter = args.leading.experimenter.clone();
    match runner.state().stage() {
        Stage::New => Some(Command::Begin {
            experimenter,
            program: invocation::PROGRAM.to_owned(),
            purpose: purpose(args),
            participant: stated(args),
        }),
        Stage::Consent | Stage::Running | Stage::Paused => {
            say_kept(runner.state().participant(), &stated(args));
            Some(Command::Resume {
                experimenter,
                now_ms: runner.now_ms(),
            })
        }
        Stage::Stopped | Stage::Ended | Stage::Withdrawn => None,
    }
}

/// What `args` state of the participant.
fn stated(args: &Arguments) -> Participant {
    let leading = &args.leading;
    Participant {
        sex: leading.sex.clone(),
        age_years: leading.age,
        handedness: leading.handedness.map(|hand| {
            let word = hand.to_possible_value();
            word.map_or(String::new(), |word| word.get_name().to_owned())
        }),
        finger: leading.finger.clone(),
        language: leading.language.clone(),
        judge: None,
    }
}

/// Says what is `stated` now of the participant of a session that goes on, and is not what was stated when it began.
fn say_kept(kept: &Participant, stated: &Participant) {
    let age = |of: &Participant| of.age_years.map(|years| years.to_string());
    let pairs = [
        ("--sex", kept.sex.clone(), stated.sex.clone()),
        ("--age", age(kept), age(stated)),
        (
            "--handedness",
            kept.handedness.clone(),
            stated.handedness.clone(),
        ),
        ("--finger", kept.finger.clone(), stated.finger.clone()),
        ("--language", kept.language.clone(), stated.language.clone()),
    ];
    for (option, kept, stated) in pairs {
        let Some(stated) = stated.filter(|stated| kept.as_ref() != Some(stated)) else {
            continue;
        };
        let kept = kept.map_or("without it".to_owned(), |kept| format!("with {kept}"));
        say(&format!(
            "{option} {stated} is not applied: the session goes on {kept}, as it was begun"
        ));
    }
}

/// Refuses to go on with a session that was left for too long. Nothing is stored of it, as the clock may be wrong.
pub(crate) fn require_in_time(runner: &mut Runner<'_>, command: &Command) -> Outcome {
    let Ok(Event::ResumeRefused { after_hours }) = runner.state().decide(command) else {
        return Ok(());
    };
    let within = runner.state().protocol().resuming.refused_after_hours;
    let now = said(runner.now_ms());
    Err(Failure::Data(anyhow!(
        "the session was left {after_hours:.1} h ago by the clock of this computer ({now}, UTC), and the protocol lets it go on within {within} h: \
         where the clock is wrong, set it and give the same command again; else the session stays as it was left. Nothing was stored"
    )))
}

/// How far the session is, task by task.
pub(crate) fn status(runner: &Runner<'_>) -> String {
    let progress = runner.state().progress().into_iter();
    let tasks: Vec<String> = progress
        .map(|(task, (confirmed, planned))| format!("{task}: {confirmed} of {planned} trials"))
        .collect();
    tasks.join(", ")
}

/// That the session is left before its end, or how it ended.
pub(crate) fn left(runner: &Runner<'_>) -> String {
    let ended = match runner.state().stage() {
        Stage::Withdrawn => Some(
            "the participant has withdrawn: erase everything now with `piezotact campaign withdraw`",
        ),
        Stage::Stopped => Some(
            "the session was stopped before its end and does not go on; everything that was noted is stored",
        ),
        Stage::Ended => Some("the session was ended without consent"),
        Stage::New | Stage::Consent | Stage::Running | Stage::Paused => None,
    };
    if let Some(ended) = ended {
        return format!("{ended} ({})", status(runner));
    }
    let quoted = |word: String| match word.contains(char::is_whitespace) {
        true => format!("\"{word}\""),
        false => word,
    };
    let words: Vec<String> = invocation::words().into_iter().map(quoted).collect();
    format!(
        "the session is not over ({}); everything that was noted is stored, and the same command goes on with it: piezotact {}",
        status(runner),
        words.join(" ")
    )
}

fn withdrawn(args: &Arguments) -> String {
    format!(
        "The participant has withdrawn. Erase everything now: piezotact campaign withdraw {} {}",
        args.study.display(),
        args.participant
    )
}
