//! `piezotact campaign plan`: the trials of a session before it begins.

use std::path::PathBuf;

use anyhow::anyhow;
use clap::Args;
use piezotact_people::campaign::plan::{AnswerForm, Plan, PlanRequest, Presented, plan};
use piezotact_study::store::Pseudonym;

use super::study::Study;
use crate::failure::{Failure, Outcome, usage};
use crate::output::print;

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The folder of the study.
    #[arg(value_name = "STUDY")]
    study: PathBuf,
    /// The participant's pseudonym.
    participant: String,
    /// The session, by its name in the protocol.
    session: String,
    /// Prints the plan as JSON: the bytes that are written when the session begins.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    let study = Study::open(&args.study)?;
    let participant = study.participant(&args.participant)?;
    let plan = planned(&study, &participant, &args.session)?;
    if args.json {
        let bytes = plan.bytes();
        return print(String::from_utf8_lossy(&bytes).trim_end());
    }
    print(&format!(
        "{} of {}: {} trials, plan {:.12}",
        plan.session,
        plan.participant,
        plan.trials.len(),
        plan.sha().to_string()
    ))?;
    for (i, trial) in plan.trials.iter().enumerate() {
        print(&format!(
            "{:>4}  {}: {}",
            i + 1,
            trial.name,
            presented(&trial.presented, &trial.answer)
        ))?;
    }
    Ok(())
}

fn presented(presented: &Presented, answer: &AnswerForm) -> String {
    match (presented, answer) {
        (Presented::Tray { samples }, _) => format!("tray {}", samples.join(" ")),
        (Presented::Sample { sample }, _) => format!("sample {sample}"),
        (Presented::Chosen { run, .. }, _) => format!("played, chosen by {run}"),
        _ => format!("played {}", presented.names().join(", ")),
    }
}

/// The plan of `session` of `participant`: the one that was written when it began, else the one that is due now.
pub(super) fn planned(study: &Study, participant: &Pseudonym, session: &str) -> Outcome<Plan> {
    let begun = study.sessions()?;
    let is_it = |entry: &super::study::Begun| {
        entry.entry.key.participant == participant.as_str() && entry.entry.key.session == session
    };
    if let Some(written) = begun.into_iter().find(is_it) {
        if let Some(why) = written.unreadable {
            return Err(why);
        }
        let written = written.plan.ok_or_else(|| {
            usage(anyhow!(
                "{participant} has withdrawn: nothing can be added; use another pseudonym for another person"
            ))
        })?;
        return unchanged(study, written);
    }
    let request = PlanRequest {
        seed: study.campaign.seed,
        participant: participant.as_str(),
        session,
        completed: &study.completed()?,
    };
    let plan = plan(
        &study.campaign.protocol,
        study.campaign.protocol_sha,
        request,
    );
    plan.map_err(usage)
}

/// `written`, unless it was changed before the first event of its session, which keeps its checksum from then on.
fn unchanged(study: &Study, written: Plan) -> Outcome<Plan> {
    if study.state(&written)?.events() > 0 {
        return Ok(written);
    }
    let request = PlanRequest {
        seed: study.campaign.seed,
        participant: &written.participant,
        session: &written.session,
        completed: &written.completed,
    };
    let again = plan(
        &study.campaign.protocol,
        study.campaign.protocol_sha,
        request,
    );
    match again.map_err(usage)? == written {
        true => Ok(written),
        false => Err(Failure::Data(anyhow!(
            "the plan of session {} of {} is not the one that follows from protocol, seed and completed sessions: it was changed after it \
             was written, and before the session began; restore it from a copy of the study, or use another pseudonym",
            written.session,
            written.participant
        ))),
    }
}
