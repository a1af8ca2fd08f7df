//! `piezotact panel run`: a whole campaign on a bench.

use std::path::PathBuf;

use anyhow::anyhow;
use piezotact::document::Kept;
use piezotact::panel::{Cell, Filing};
use piezotact::quantity::{Acceleration, Degrees, Drive, Newtons, Quantity, Seconds};
use piezotact::spectrum::WelchConfig;
use piezotact::transfer::Estimator;
use piezotact_bench::procedure::{
    CharacteriseConfig, GatePolicy, RepeatConfig, excite, repeated, usual_segment,
};
use piezotact_bench::{
    Bench, ExcitationConfig, GateConfig, Placement, ProcedureError, RunPlan, Until,
};
use piezotact_dataset::document::{PanelRun, PanelRunCounts};
use piezotact_dataset::{Adopted, BenchFile, PanelFolder, RunFolder, TransferDocument};

use super::open_or_begin;
use crate::cli::OnOff;
use crate::cli::panel::Run;
use crate::commands::characterise::gating;
use crate::deliver::{Outputs, deliver_and};
use crate::failure::bench_failure;
use crate::failure::{Failure, Outcome, usage};
use crate::keeping::{Keeper, Place, Shown, runs_in};
use crate::output::{counted, say};
use crate::progress;

/// The folder of the raw recordings in that of a panel.
const RAW: &str = "raw";

/// A participant with what is to be measured.
struct Person {
    number: u64,
    filings: Vec<Filing>,
}

pub(crate) fn run(args: &Run) -> Outcome {
    let people = planned(args)?;
    let mut session = Session::begin(args, &people)?;
    let raw = runs_in(&args.out.join(RAW))?;
    for person in &people {
        session.measure(person, &raw)?;
    }
    if session.reused > 0 {
        say(&format!(
            "{} of them were recorded before the command was interrupted: taken from {}",
            session.reused,
            raw.path().display()
        ));
    }
    if args.discard_raw {
        say(&discarded(&raw, &session.recorded)?);
    }
    let index = &session.folder.index;
    let done = PanelRun {
        counts: session.counts,
        measurements: index.entries.len(),
        index,
    };
    let done = Kept {
        out: &args.out,
        value: &done,
    };
    let outputs = Outputs {
        json: args.json,
        ..Outputs::default()
    };
    deliver_and(&outputs, &done, &[&args.out])?;
    if !args.json {
        say(&format!(
            "analyse them with `piezotact panel analyse {}`",
            args.out.display()
        ));
    }
    Ok(())
}

/// A panel while it is measured.
struct Session<'a> {
    args: &'a Run,
    gating: GatePolicy,
    campaign: String,
    folder: PanelFolder,
    counts: PanelRunCounts,
    /// How many measurements were not there when the command began.
    left: usize,
    /// How many were taken from the recordings of an interrupted command.
    reused: usize,
    /// The recordings of this command.
    recorded: Vec<PathBuf>,
}

impl<'a> Session<'a> {
    /// Opens the folder, lists what is planned, and counts what is there already.
    fn begin(args: &'a Run, people: &[Person]) -> Outcome<Self> {
        let gating = gating(&args.gate)?;
        let mut folder = open_or_begin(&args.out)?;
        let campaign = campaign(args);
        let made_of = args.bench.file().map(BenchFile::of).transpose()?;
        folder
            .begin(&campaign, made_of.into_iter().collect())
            .map_err(usage)?;
        let all: Vec<Filing> = people.iter().flat_map(|p| p.filings.clone()).collect();
        for unreadable in folder.set_aside_unreadable(&all)? {
            say(&unreadable);
        }
        folder.plan(&all)?;
        let mut there_already = 0;
        for filing in &all {
            if folder.holds(filing) || folder.adopt(filing)? == Adopted::Listed {
                there_already += 1;
            }
        }
        let left = all.iter().filter(|filing| !folder.holds(filing)).count();
        if there_already > 0 {
            say(&format!(
                "{there_already} of {} measurements already exist",
                all.len()
            ));
        }
        Ok(Self {
            args,
            gating,
            campaign,
            folder,
            counts: PanelRunCounts {
                measured: 0,
                there_already,
            },
            left,
            reused: 0,
            recorded: Vec::new(),
        })
    }

    /// Measures what is open of a person, keeping the recordings in `raw`.
    fn measure(&mut self, person: &Person, raw: &RunFolder) -> Outcome {
        let open = person.filings.iter().filter(|f| !self.folder.holds(f));
        let open: Vec<&Filing> = open.collect();
        let Some(first) = open.first() else {
            return Ok(());
        };
        let what = format!(
            "{} ({} of {} measured)",
            first.participant, self.counts.measured, self.left
        );
        let bar = progress::of_run(&what, Some(Seconds(self.args.seconds * open.len() as f64)));
        let mut bench = bench_of(self.args, person.number)?;
        let mut keeper = Keeper::new(Place::Continued(raw.clone()), Shown::Together(&bar));
        let outcome = self.measure_all(&mut bench, &open, &mut keeper);
        bar.finish_and_clear();
        self.reused += keeper.reused;
        self.recorded.append(&mut keeper.files);
        outcome
    }

    fn measure_all(
        &mut self,
        bench: &mut Bench,
        open: &[&Filing],
        keeper: &mut Keeper<'_>,
    ) -> Outcome {
        for filing in open {
            let asked = (self.args, self.campaign.as_str());
            measure(bench, asked, &self.gating, filing, &mut self.folder, keeper)?;
            self.counts.measured += 1;
        }
        Ok(())
    }
}

/// Discards what this command recorded in the folder `raw`, and says how many recordings that were; those of before stay.
fn discarded(raw: &RunFolder, recorded: &[PathBuf]) -> Outcome<String> {
    let (removed, left) = raw.discard_these(recorded)?;
    let removed = counted(removed, "raw recording");
    Ok(match left {
        0 => format!("discarded {removed} of this command"),
        left => format!(
            "discarded {removed} of this command; {left} of earlier commands {} kept in {}",
            if left == 1 { "is" } else { "are" },
            raw.path().display()
        ),
    })
}

/// Who is to be measured how, refused before a file is begun where a bench cannot do it.
fn planned(args: &Run) -> Outcome<Vec<Person>> {
    if let Some(number) = args.bench.participant() {
        return Err(usage(anyhow!(
            "expected a bench without participant, because --participants gives them, found participant={number}; leave it out \
             of --bench"
        )));
    }
    let mut people: Vec<Person> = Vec::new();
    for &number in &args.participants.0 {
        let mut bench = bench_of(args, number)?;
        let description = bench.acquirer.describe();
        let participant = description.condition.participant.ok_or_else(|| {
            anyhow!(
                "expected a bench that names its participant, found {}; give participants pseudonyms",
                description.name
            )
        })?;
        let filings = filings_of(args, &participant)?;
        if people.is_empty() {
            probe(args, &mut bench, &filings)?;
        }
        people.push(Person { number, filings });
    }
    Ok(people)
}

/// All measurements of one participant.
fn filings_of(args: &Run, participant: &str) -> Outcome<Vec<Filing>> {
    let mut filings: Vec<Filing> = Vec::new();
    for (angle, load) in args
        .angles
        .iter()
        .flat_map(|angle| args.loads.iter().map(move |load| (*angle, *load)))
    {
        let cell = Cell {
            load_n: Newtons(load),
            angle_deg: Degrees(angle),
        };
        if filings.iter().any(|f| f.cell.is(cell)) {
            return Err(usage(anyhow!(
                "expected each load and angle once, found {cell} twice; leave one out"
            )));
        }
        for placement in 1..=args.placements {
            filings.extend((1..=args.repeats).map(|repeat| Filing {
                participant: participant.to_owned(),
                cell,
                placement,
                repeat,
            }));
        }
    }
    Ok(filings)
}

/// Refuses conditions that the bench cannot measure, before anything is measured: the last filing of each.
fn probe(args: &Run, bench: &mut Bench, filings: &[Filing]) -> Outcome {
    let each = filings.chunk_by(|a, b| a.cell.is(b.cell));
    for filing in each.filter_map(<[Filing]>::last) {
        let probe = config(args, filing, bench);
        excite(bench, &probe).map_err(bench_failure)?;
        let stop = bench.stop.clone();
        let ready = bench.acquirer.ready(&probe.run, &stop);
        ready.map_err(bench_failure)?;
        bench.acquirer.stop();
    }
    Ok(())
}

/// What the measurements of one campaign have in common: the bench, and every setting that changes what is filed.
fn campaign(args: &Run) -> String {
    let gate = match args.gate.gating {
        OnOff::Off => "no gate".into(),
        OnOff::On => {
            let usual = GateConfig::usual();
            format!(
                "force within {}, coherence from {}, {} attempts",
                args.gate.force_tolerance.unwrap_or(usual.force_share),
                args.gate.least_coherence.unwrap_or(usual.least_coherence),
                args.gate.attempts
            )
        }
    };
    format!(
        "{}: {}, {} s over {}, peak {}, {}, drives from seed {}, {gate}",
        args.bench.apart_from_participant(),
        args.excitation.name(),
        args.seconds,
        args.band,
        args.peak,
        match args.segment {
            // As it was called when that was the default.
            None => "segments of 2048 samples".into(),
            Some(samples) => format!("segments of {samples} samples"),
        },
        args.seed
    )
}

fn bench_of(args: &Run, participant: u64) -> Outcome<Bench> {
    let spec = args.bench.clone().with_participant(participant);
    spec.map_err(bench_failure)?.open()
}

/// How one measurement is made: the finger is placed for the first repeat of a placement and left there.
fn config(args: &Run, filing: &Filing, bench: &Bench) -> CharacteriseConfig {
    let Cell { load_n, angle_deg } = filing.cell;
    let first = format!(
        "panel {} {} placement {}",
        angle_deg.0, load_n.0, filing.placement
    );
    let (label, placement) = match filing.repeat {
        1 => (first, Placement::New),
        repeat => (format!("{first} repeat {repeat}"), Placement::SameAs(first)),
    };
    CharacteriseConfig {
        excitation: ExcitationConfig {
            kind: args.excitation,
            band: args.band,
            duration: Seconds(args.seconds),
            peak: args.peak,
            seed: args.seed.wrapping_add(u64::from(filing.repeat - 1)),
        },
        welch: WelchConfig::hann(
            args.segment
                .unwrap_or_else(|| usual_segment(bench.acquirer.describe().rate)),
        ),
        estimator: Estimator::H1,
        run: RunPlan {
            label,
            load: Some(load_n),
            angle: angle_deg,
            placement,
            until: Until::PlaybackEnded,
        },
    }
}

/// Measures once, or again where the gate refuses.
fn measure(
    bench: &mut Bench,
    (args, campaign): (&Run, &str),
    gating: &GatePolicy,
    filing: &Filing,
    folder: &mut PanelFolder,
    keeper: &mut Keeper<'_>,
) -> Outcome {
    let once = RepeatConfig {
        repeats: 1,
        attempts: usize::from(args.gate.attempts),
        gating: gating.clone(),
    };
    let config = config(args, filing, bench);
    let done = repeated(bench, &config, &once, keeper, &mut |refused| {
        say(&format!(
            "{filing}: attempt {} was refused: {}",
            refused.attempt, refused.refusal
        ));
    })
    .map_err(|error| not_measured(filing, error))?;
    let mut document = TransferDocument {
        distortion: done.distortion.clone(),
        attempts: done.attempts,
        measured_for: Some(PanelFolder::measured_for(campaign, filing)),
        ..TransferDocument::of(&done.function, Drive::UNIT, Acceleration::UNIT)
    };
    let step = format!("measured for a panel with {campaign}, as {filing}");
    document.about.provenance.steps.push(step);
    Ok(folder.file(filing, &document)?)
}

/// Why one filing could not be measured, and what is kept.
fn not_measured(filing: &Filing, error: ProcedureError) -> Failure {
    const GO_ON: &str = "earlier measurements are kept; give the same command again to continue";
    match error {
        ProcedureError::RepeatRefused {
            attempts, refusal, ..
        } => Failure::Data(anyhow!(
            "{filing}: refused in all {attempts} attempts; in the last one, {refusal}; {GO_ON}"
        )),
        error if error.continues() => Failure::Data(anyhow!("{filing}: {error}; {GO_ON}")),
        other => bench_failure(other),
    }
}
