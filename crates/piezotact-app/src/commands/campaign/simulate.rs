//! `piezotact campaign simulate`: a campaign with virtual volunteers.

mod panels;
pub(super) mod settings;
pub(super) mod which;

use piezotact_volunteers::VolunteerError;
use std::collections::BTreeSet;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use anyhow::{Error, anyhow};
use clap::Args;
use piezotact::quantity::Decibels;
use piezotact_dataset::{ReadOptions, read_recording};
use piezotact_people::campaign::chain::Sha;
use piezotact_people::campaign::protocol::Protocol;
use piezotact_people::campaign::session::Stage;
use piezotact_people::judge::Judge;
use piezotact_study::store::{NewCampaign, Pseudonym, SessionLock, StudyCampaign, StudyStore};
use piezotact_volunteers::{Arrival, LevelRule, Simulated, Simulation};

use super::protocol_text;
use super::study::{Begun, Study};
use crate::failure::{Failure, Outcome, usage};
use crate::interrupt::{Between, interrupted};
use crate::output::print;
use crate::progress::{Words, Work};
use settings::Settings;
use which::which_of;

#[derive(Clone, Debug, Args)]
pub(crate) struct Arguments {
    /// The folder of the study, which is made, or gone on with.
    #[arg(value_name = "STUDY")]
    study: PathBuf,
    /// The protocol: a file, or a name of the library.
    #[arg(long)]
    protocol: PathBuf,
    /// The number of virtual volunteers; default: that of the protocol.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1000))]
    participants: Option<u32>,
    /// The seed of people, plans and noise.
    #[arg(long)]
    seed: u64,
    /// Does the campaign this often, with other people each time (the seeds that follow) and on all cores: one study for each in the
    /// folder.
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..=1000))]
    panels: Option<u32>,
    /// How the volunteers judge: thurstone (level and spectrum; period and friction of real surfaces), guesser, `level_only` or
    /// `spectrum_only`.
    #[arg(long, default_value = "thurstone", value_parser = judge)]
    judge: Judge,
    /// The level at which textures are rendered: `common`, one for all, lowered only as much as the device requires; `fit`, for each
    /// its own; or a number, in dB.
    #[arg(long, default_value = "common", value_name = "common|fit|DB", allow_negative_numbers = true, value_parser = level)]
    level: LevelRule,
    /// The largest number of corrections of each drive in a closed loop; 0 for the open loop.
    #[arg(long, default_value_t = 6, value_parser = clap::value_parser!(u16).range(0..=50))]
    iterations: u16,
    /// The people whose average transfer function is used where the protocol renders with one, by their numbers; none of them takes
    /// part.
    #[arg(long, default_value = "1001..1020", value_name = "FROM..TO", value_parser = members)]
    panel: RangeInclusive<u64>,
    /// The twin's sample that a sample of the protocol is, such as P60=S2, or a recording of strokes on it, such as
    /// velvet=velvet.parquet, which all volunteers meet; once for each. Rough, biomimetic and smooth are M8, BIO and M3.
    #[arg(long, value_name = "NAME=SAMPLE|FILE", value_parser = surface)]
    surface: Vec<(String, String)>,
}

/// The name of a sample in the protocol, and in the twin.
fn surface(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, sample)) if !name.is_empty() && !sample.is_empty() => {
            Ok((name.to_owned(), sample.to_owned()))
        }
        _ => Err(format!(
            "expected a sample of the protocol and one of the twin or a recording such as P60=S2, found `{text}`"
        )),
    }
}

/// Numbers from the first to the last, at most 1000.
fn members(text: &str) -> Result<RangeInclusive<u64>, String> {
    let ends = text.split_once("..").and_then(|(from, to)| {
        let to = to.strip_prefix('=').unwrap_or(to);
        Some((from.trim().parse().ok()?, to.trim().parse().ok()?))
    });
    match ends {
        Some((from, to)) if from > 0 && from <= to && to - from < 1000 => Ok(from..=to),
        _ => Err(format!(
            "expected the numbers of at most 1000 people such as 1001..1020, found `{text}`"
        )),
    }
}

fn judge(text: &str) -> Result<Judge, String> {
    Judge::named(text).map_err(|error| error.to_string())
}

fn level(text: &str) -> Result<LevelRule, String> {
    let stated = || text.parse().ok().filter(|db| (-120.0..=120.0).contains(db));
    match text {
        "common" => Ok(LevelRule::Common),
        "fit" => Ok(LevelRule::Fit),
        _ => stated()
            .map(|db| LevelRule::Stated(Decibels(db)))
            .ok_or_else(|| {
                format!("expected common, fit, or a level from -120 to 120 dB, found `{text}`")
            }),
    }
}

/// What is over of a simulation.
enum Over {
    /// So many steps of the volunteer who is here.
    Steps(usize),
    /// The volunteer is gone.
    Volunteer,
}

const SIMULATING: Words = Words {
    doing: "simulating",
    done: "simulated",
    item: "step",
    then: "comparing judges",
};

pub(crate) fn run(args: &Arguments) -> Outcome {
    if let Some(count) = args.panels {
        return panels::run(args, count);
    }
    let (mut study, _alone) = study(args)?;
    let participants = args
        .participants
        .unwrap_or(study.campaign.protocol.panel.participants);
    let campaign = study.campaign.clone();
    let simulation = asked(args, &campaign, participants)?;
    let done = shown(args, &simulation, participants, &mut study)?;
    print(&format!(
        "{}: {participants} virtual volunteers who judge as {}, {} sessions ({} of them were complete before)",
        args.study.display(),
        args.judge.name(),
        done.plans.len(),
        done.taken_up
    ))?;
    match which_of(&study)? {
        None => {}
        Some(Ok(which)) => print(&which.sentence())?,
        Some(Err(why)) => print(&format!(
            "which judge the answers show is not compared: {why}"
        ))?,
    }
    let study_at = args.study.display();
    match study.associations()?.is_empty() && study.places()?.is_empty() {
        false => print(&format!(
            "see what they answered: piezotact answers {study_at}"
        )),
        true => print(&format!(
            "see what they answered: piezotact campaign export {study_at} --out FOLDER"
        )),
    }
}

/// The campaign, with its progress.
fn shown(
    args: &Arguments,
    simulation: &Simulation<'_>,
    participants: u32,
    study: &mut Study,
) -> Outcome<Simulated> {
    let steps = simulation.steps()?;
    let each = steps.len();
    let work = Work::of_sizes(SIMULATING, steps.repeat(participants as usize));
    let _between = Between::items("volunteer");
    let mut gone = 0;
    simulated(
        args,
        simulation,
        participants,
        study,
        &mut |over| match over {
            Over::Steps(steps) => work.up_to(gone * each + steps),
            Over::Volunteer => {
                gone += 1;
                work.up_to(gone * each);
            }
        },
    )
}

/// What is to be simulated, with the average of its panel where it is rendered with one.
fn asked<'a>(
    args: &Arguments,
    campaign: &'a StudyCampaign,
    participants: u32,
) -> Outcome<Simulation<'a>> {
    let protocol = &campaign.protocol;
    let simulation = simulation(args, protocol, campaign.protocol_sha)?;
    let Some(panel) = simulation.panel() else {
        return Ok(simulation);
    };
    let _measuring = Work::one(format!("measuring the panel `{panel}`"));
    let numbers = 1..=u64::from(participants);
    let measured = simulation.with_panel(args.panel.clone(), numbers);
    measured.map_err(|error| match error {
        VolunteerError::Overlap { .. } => usage(error),
        error => Failure::from(error),
    })
}

fn simulation<'a>(
    args: &Arguments,
    protocol: &'a Protocol,
    protocol_sha: Sha,
) -> Outcome<Simulation<'a>> {
    let mut simulation = Simulation {
        judge: args.judge,
        level: args.level,
        iterations: usize::from(args.iterations),
        ..Simulation::usual(protocol, protocol_sha, args.seed)
    };
    for (name, sample) in &args.surface {
        let path = Path::new(sample);
        if is_recording(sample) {
            let recording = read_recording(path, &ReadOptions::default())?.recording;
            simulation = simulation.with_recorded(name, recording)?;
        } else {
            simulation.surfaces.insert(name.clone(), sample.clone());
        }
    }
    Ok(simulation)
}

/// Whether a surface is a file: the samples of the twin have names without a dot.
fn is_recording(sample: &str) -> bool {
    sample.contains('.') || Path::new(sample).is_file()
}

/// The campaign, from where the study has it.
fn simulated(
    args: &Arguments,
    simulation: &Simulation<'_>,
    participants: u32,
    study: &mut Study,
    over: &mut dyn FnMut(Over),
) -> Outcome<Simulated> {
    let mut before = 0;
    let mut plans = StudyStore::open(&args.study)?;
    // Only where something is still to be done; what was answered is kept first.
    let goes_on = || match interrupted() {
        true => Err(Failure::Data(anyhow!(
            "the simulation is not over; what was done is stored, and the same command goes on with it"
        ))),
        false => Ok(()),
    };
    let mut step = |arrival: Arrival<'_>| -> Outcome {
        match arrival {
            Arrival::Measured { pseudonym: _ } => goes_on()?,
            Arrival::Ready => over(Over::Steps(before + 1)),
            Arrival::Trial { trials } => over(Over::Steps(before + 1 + trials)),
            Arrival::Planned { plan, .. } => {
                goes_on()?;
                plans.write_plan(plan)?;
            }
            Arrival::Answered {
                plan,
                answers,
                whole: true,
            } => {
                let participant = Pseudonym::new(&plan.participant)?;
                plans.write_judged(&participant, &plan.session, answers)?;
                before += plan.trials.len();
            }
            Arrival::Answered { plan, .. } | Arrival::TakenUp { plan } => {
                before += plan.trials.len();
            }
            Arrival::Gone => {
                before = 0;
                over(Over::Volunteer);
            }
        }
        Ok(())
    };
    simulation.run::<Failure>(1..=u64::from(participants), &mut study.store, &mut step)
}

/// The study in the folder: a new one, or the one of the same simulation, with the exclusive right to simulate it.
fn study(args: &Arguments) -> Outcome<(Study, SessionLock)> {
    let (protocol, text) = protocol_text(&args.protocol)?;
    let mut stated = BTreeSet::new();
    if let Some((name, _)) = args.surface.iter().find(|(name, _)| !stated.insert(name)) {
        return Err(usage(anyhow!(
            "--surface: expected {name} once, found it twice; state one sample of the twin for it"
        )));
    }
    let mut names = args.surface.iter().map(|(name, _)| name);
    if let Some(name) = names.find(|name| !protocol.samples.contains(name)) {
        return Err(usage(anyhow!(
            "--surface: expected a sample of the protocol ({}), found `{name}`",
            protocol.samples.join(", ")
        )));
    }
    if !piezotact_dataset::reads::is_there(&args.study.join("campaign.json")) {
        let wanted = simulation(args, &protocol, Sha::of(text.as_bytes()))?;
        let not_recorded = |name: &&String| !wanted.recorded.contains_key(*name);
        for name in protocol.samples.iter().filter(not_recorded) {
            wanted.surface(name).map_err(|error| {
                let todo = format!(
                    "the twin has no surface for {name} of the protocol, and no strokes on it are given; state one of both, such as --surface {name}=S8 or --surface {name}={name}.parquet"
                );
                Failure::Data(Error::new(error).context(todo))
            })?;
        }
        let participants = args.participants.unwrap_or(protocol.panel.participants);
        let both = 1..=u64::from(participants);
        if wanted.panel().is_some()
            && let Some(number) = args.panel.clone().find(|number| both.contains(number))
        {
            return Err(usage(VolunteerError::Overlap { number }));
        }
        let panels = protocol.panel.disjoint_from.iter();
        let new = NewCampaign {
            protocol: &text,
            seed: args.seed,
            consent: None,
            panels: panels.map(|name| (name.clone(), [].into())).collect(),
            program: crate::invocation::PROGRAM,
        };
        StudyCampaign::create(&args.study, &new)?;
    }
    let study = Study::open(&args.study)?;
    let alone = study.store.simulate_alone()?;
    if study.campaign.seed != args.seed || study.campaign.protocol != protocol {
        return Err(usage(anyhow!(
            "{}: expected a study of this protocol with the seed {}, found another; name another folder",
            args.study.display(),
            args.seed
        )));
    }
    let sessions = study.sessions()?;
    let people = sessions.iter().map(|begun| &begun.entry.key.participant);
    let people = people.collect::<BTreeSet<_>>().len();
    let wanted = args.participants.unwrap_or(protocol.panel.participants);
    if people > wanted as usize {
        return Err(usage(anyhow!(
            "{}: expected at least the {people} volunteers that this study has, found {wanted}; state --participants {people} or more, or name another folder",
            args.study.display()
        )));
    }
    for Begun {
        entry,
        plan,
        unreadable,
    } in sessions
    {
        if let Some(why) = unreadable {
            return Err(why);
        }
        let Some(plan) = plan else { continue };
        let state = study.state(&plan)?;
        let judge = state.participant().judge;
        if state.stage() != Stage::New && judge != Some(args.judge) {
            return Err(usage(anyhow!(
                "{}: expected sessions of virtual volunteers who judge as {}, found session {} of {} with {}; name another folder",
                args.study.display(),
                args.judge.name(),
                entry.key.session,
                entry.key.participant,
                judge.map_or("a person", |judge| judge.name())
            )));
        }
    }
    Settings::of(args, &protocol)?.keep(&study)?;
    Ok((study, alone))
}
