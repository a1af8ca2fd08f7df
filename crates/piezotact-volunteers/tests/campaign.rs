//! Campaigns with virtual volunteers.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use piezotact::criterion::Outcome;
use piezotact::quantity::Decibels;
use piezotact_people::association::Answer;
use piezotact_people::campaign::chain::{Link, Sha};
use piezotact_people::campaign::plan::{Plan, PlanRequest, plan};
use piezotact_people::campaign::protocol::{LIBRARY, Protocol, from_library, read};
use piezotact_people::campaign::store::{
    MemoryStore, NewEvent, Purpose, SessionEntry, SessionKey, Store, StoreError,
};
use piezotact_people::judge::Judge;
use piezotact_study::session::state_of;
use piezotact_volunteers::VolunteerError;
use piezotact_volunteers::{
    Arrival, LevelRule, Playings, Simulated, Simulation, Whose, sit, volunteer,
};

/// The isotropic protocol of the library with four samples in two sets, played for 8 s.
fn two_sets() -> Protocol {
    let (_, library) = LIBRARY
        .iter()
        .find(|(name, _)| *name == "isotropic_triplets")
        .unwrap();
    let (head, _) = library.split_once("[[sets]]").unwrap();
    let (_, tasks) = library.split_once("[[tasks]]").unwrap();
    let (start, samples) = head.split_once("samples = [").unwrap();
    let (_, end) = samples.split_once(']').unwrap();
    let sets = "[[sets]]\nname = \"A\"\nsamples = [\"S2\", \"S5\", \"S8\"]\n\n[[sets]]\nname = \"M\"\nsamples = [\"S5\", \"S8\", \"S12\"]\n\n[[tasks]]";
    let playing = "playing = { how = \"repeated\", pause_s = 0.5, duration_s = 30 }";
    let text = format!("{start}samples = [\"S2\", \"S5\", \"S8\", \"S12\"]{end}{sets}{tasks}");
    assert!(text.contains(playing));
    let shorter = playing.replace("30", "8");
    read(&text.replace(playing, &shorter)).unwrap()
}

fn quick(protocol: &Protocol, judge: Judge) -> Simulation<'_> {
    Simulation {
        judge,
        excitation_s: 10.0,
        iterations: 1,
        ..Simulation::usual(protocol, Sha::of(b"protocol"), 7)
    }
}

fn run(simulation: &Simulation<'_>, people: u64, store: &mut MemoryStore) -> Simulated {
    simulation
        .run::<VolunteerError>(1..=people, store, &mut |_| Ok(()))
        .unwrap()
}

fn answers(simulation: &Simulation<'_>, store: &dyn Store, plans: &[Plan]) -> Vec<Answer> {
    simulation.answers(store, plans).unwrap().1
}

#[test]
fn a_campaign_is_done_to_its_end_and_the_same_seed_gives_the_same_bytes() {
    let protocol = two_sets();
    let simulation = quick(&protocol, Judge::Thurstone);
    let (mut one, mut other) = (MemoryStore::new(), MemoryStore::new());
    let done = run(&simulation, 2, &mut one);
    assert_eq!(done.plans.len(), 4);
    for plan in &done.plans {
        assert!(state_of(&one, &protocol, plan).unwrap().is_complete());
    }
    // Another thread, as several panels are simulated at once.
    let again = std::thread::scope(|scope| {
        scope
            .spawn(|| run(&simulation, 2, &mut other))
            .join()
            .unwrap()
    });
    assert_eq!(again.plans, done.plans);
    for plan in &done.plans {
        let key = SessionKey::new(&plan.participant, &plan.session);
        assert_eq!(one.head(&key).unwrap(), other.head(&key).unwrap());
    }
    // What is complete is not done again.
    let taken_up = run(&simulation, 2, &mut one);
    assert_eq!((taken_up.taken_up, taken_up.answers.len()), (4, 0));
    // Textures three JNDs apart are put in their order and associated, and every playing left its evidence.
    let answers = answers(&simulation, &one, &done.plans);
    let right = answers.iter().filter(|one| one.presented == one.answered);
    let share = right.count() as f64 / answers.len() as f64;
    assert!(share > 0.8, "{share}");
    let state = state_of(&one, &protocol, &done.plans[1]).unwrap();
    let warnings = state.warnings();
    let of_volunteers = warnings
        .iter()
        .any(|one| one.code == "simulated" && one.fields.get("by") == Some(&"volunteers".into()));
    assert!(of_volunteers, "{warnings:?}");
    let associated = state.trials().filter(|(trial, _)| trial.task == "task3");
    for (trial, of) in associated {
        assert!(of.evidence.len() >= trial.presented.names().len());
    }
}

#[test]
fn who_guesses_and_who_goes_by_the_level_answer_otherwise() {
    let protocol = two_sets();
    let mut shares = Vec::new();
    for judge in [Judge::LevelOnly, Judge::Guesser] {
        let simulation = quick(&protocol, judge);
        let mut store = MemoryStore::new();
        let done = run(&simulation, 2, &mut store);
        let answers = answers(&simulation, &store, &done.plans);
        let associated = answers.iter().filter(|one| one.task == "task3");
        let associated: Vec<&Answer> = associated.collect();
        let right = associated
            .iter()
            .filter(|one| one.presented == one.answered);
        shares.push(right.count() as f64 / associated.len() as f64);
    }
    assert!(shares[0] > shares[1] + 0.2, "{shares:?}");
}

#[test]
fn with_somebody_elses_transfer_function_the_evidence_says_why_answers_are_wrong() {
    let protocol = two_sets();
    // A closed loop would correct it.
    let simulation = Simulation {
        iterations: 0,
        ..quick(&protocol, Judge::Thurstone)
    };
    let own = volunteer(&simulation, 1, Whose::Own).unwrap();
    let others = volunteer(&simulation, 1, Whose::Of(4)).unwrap();
    let passed = |volunteer: &piezotact_volunteers::VirtualVolunteer| {
        let drives = volunteer.drives.values();
        drives.filter(|one| one.verified == Outcome::Met).count()
    };
    assert!(
        passed(&own) > passed(&others),
        "{} {}",
        passed(&own),
        passed(&others)
    );
    let request = PlanRequest {
        seed: 7,
        participant: "P01",
        session: "discrimination",
        completed: &[],
    };
    let plan = plan(&protocol, Sha::of(b"protocol"), request).unwrap();
    let missed = |volunteer| {
        let mut store = MemoryStore::new();
        sit(&simulation, volunteer, &plan, &mut store, &mut |_| {}).unwrap();
        let state = state_of(&store, &protocol, &plan).unwrap();
        let trials = state.trials();
        let missed = trials.filter(|(_, of)| of.evidence.iter().any(|(_, one)| one.missed()));
        missed.count()
    };
    assert!(missed(&others) > missed(&own));
}

/// What is said of the progress: each trial is over once, and with the last of them all steps that were announced.
#[test]
fn the_steps_of_a_volunteer_are_announced_and_each_is_over_once() {
    let protocol = two_sets();
    let simulation = quick(&protocol, Judge::Thurstone);
    let announced = simulation.steps().unwrap();
    assert!(announced.iter().all(|size| *size > 0.0));
    let (mut store, mut over, mut sessions, mut ready) = (MemoryStore::new(), Vec::new(), 0, 0);
    simulation
        .run::<VolunteerError>(1..=1, &mut store, &mut |step| {
            match step {
                Arrival::Ready => ready += 1,
                Arrival::Trial { trials } => over.push((sessions, trials)),
                Arrival::Answered { .. } => sessions += 1,
                _ => {}
            }
            Ok(())
        })
        .unwrap();
    assert_eq!((ready, ready + over.len()), (1, announced.len()));
    over.dedup();
    assert_eq!(1 + over.len(), announced.len());
}

#[test]
fn a_simulation_that_was_stopped_goes_on() {
    let protocol = two_sets();
    let simulation = quick(&protocol, Judge::Thurstone);
    let mut store = MemoryStore::new();
    let mut steps = 0;
    let stopped = simulation.run::<VolunteerError>(1..=2, &mut store, &mut |step| {
        steps += 1;
        match step {
            Arrival::Gone => Err(VolunteerError::Stimulus {
                stimulus: "stopped".to_owned(),
            }),
            _ => Ok(()),
        }
    });
    assert!(stopped.is_err());
    let done = run(&simulation, 2, &mut store);
    assert_eq!(done.taken_up, 2);
    let mut whole = MemoryStore::new();
    let at_once = run(&simulation, 2, &mut whole);
    assert_eq!(
        answers(&simulation, &store, &done.plans),
        answers(&simulation, &whole, &at_once.plans)
    );
}

/// A store that takes so many events, and no more.
struct Stops {
    store: MemoryStore,
    left: usize,
}

impl Store for Stops {
    fn begin(&mut self, key: &SessionKey, purpose: Purpose) -> Result<(), StoreError> {
        self.store.begin(key, purpose)
    }

    fn append(
        &mut self,
        key: &SessionKey,
        known: u64,
        event: NewEvent<'_>,
    ) -> Result<Link, StoreError> {
        if self.left == 0 {
            return Err(StoreError::Place {
                why: "stopped".into(),
                advice: "go on",
            });
        }
        self.left -= 1;
        self.store.append(key, known, event)
    }

    fn events(&self, key: &SessionKey) -> Result<Vec<Link>, StoreError> {
        self.store.events(key)
    }

    fn sessions(&self) -> Result<Vec<SessionEntry>, StoreError> {
        self.store.sessions()
    }

    fn erase(&mut self, participant: &str, at_ms: i64) -> Result<usize, StoreError> {
        self.store.erase(participant, at_ms)
    }
}

/// Stopped in the middle of a session again and again, the answers are the same, and time never goes back.
#[test]
fn a_session_that_was_stopped_goes_on_after_its_last_event() {
    let protocol = two_sets();
    let simulation = quick(&protocol, Judge::Thurstone);
    let mut stops = Stops {
        store: MemoryStore::new(),
        left: 0,
    };
    let mut whole = MemoryStore::new();
    let at_once = run(&simulation, 1, &mut whole);
    let mut times = 0;
    let done = loop {
        stops.left = 15;
        times += 1;
        let step = &mut |_: Arrival<'_>| Ok(());
        if let Ok(done) = simulation.run::<VolunteerError>(1..=1, &mut stops, step) {
            break done;
        }
    };
    assert!(times > 2, "{times}");
    assert_eq!(
        answers(&simulation, &stops, &done.plans),
        answers(&simulation, &whole, &at_once.plans)
    );
    for entry in stops.sessions().unwrap() {
        let events = stops.events(&entry.key).unwrap();
        assert!(events.windows(2).all(|two| two[0].at_ms < two[1].at_ms));
    }
}

#[test]
fn what_the_twin_does_not_have_is_refused_in_one_sentence() {
    let mut protocol = two_sets();
    protocol.samples.push("S99".to_owned());
    let refused = volunteer(&quick(&protocol, Judge::Thurstone), 1, Whose::Own).unwrap_err();
    assert!(refused.to_string().contains("S99"), "{refused}");
    let average = from_library("averaged_transfer_function").unwrap().unwrap();
    let refused = volunteer(&quick(&average, Judge::Thurstone), 1, Whose::Own).unwrap_err();
    assert!(
        matches!(refused, VolunteerError::Average { .. }),
        "{refused}"
    );
    let refused = quick(&average, Judge::Thurstone).with_panel(3..=5, 1..=4);
    let refused = refused.map(|_| ()).unwrap_err().to_string();
    assert!(
        refused.contains("volunteer 3 is in the panel and takes part"),
        "{refused}"
    );
}

/// The average of others fits nobody as the own function does, and the evidence says so.
#[test]
fn an_averaged_transfer_function_is_that_of_others_and_is_not_corrected() {
    let mut protocol = two_sets();
    let own = quick(&protocol, Judge::Thurstone);
    let own = volunteer(&own, 1, Whose::Own).unwrap();
    let library = from_library("averaged_transfer_function").unwrap().unwrap();
    protocol.rendering = library.rendering;
    let averaged = quick(&protocol, Judge::Thurstone)
        .with_panel(21..=25, 1..=1)
        .unwrap();
    let with_average = volunteer(&averaged, 1, Whose::Own).unwrap();
    for (name, drive) in &with_average.drives {
        assert_ne!(drive.drive, own.drives[name].drive, "{name}");
    }
    let met =
        |drives: &std::collections::BTreeMap<String, piezotact_study::session::PreparedDrive>| {
            let drives = drives.values();
            drives
                .filter(|drive| drive.verified == Outcome::Met)
                .count()
        };
    assert!(met(&own.drives) > met(&with_average.drives));
}

/// One stroke counts as often as the protocol repeats it: the judge is as sure, and the bench plays a fraction.
#[test]
fn one_stroke_counts_as_those_that_are_repeated() {
    let protocol = two_sets();
    let whole = quick(&protocol, Judge::Thurstone);
    let short = Simulation {
        playings: Playings::OneStroke,
        ..whole.clone()
    };
    let mut shares = Vec::new();
    let mut looks = Vec::new();
    for simulation in [&whole, &short] {
        let done = run(simulation, 1, &mut MemoryStore::new());
        let choices = &done.answers.choices;
        looks.push(
            choices
                .iter()
                .map(|one| one.presented.looks)
                .fold(f64::MAX, f64::min),
        );
        shares.push(choices.len());
    }
    assert_eq!(shares[0], shares[1]);
    // 8 s hold at least three strokes of two seconds with their pauses.
    assert!(
        looks[0] >= 3.0 && (looks[0] - looks[1]).abs() <= 1.0,
        "{looks:?}"
    );
}

/// Otherwise a threshold in dB re 1 m/s² would be wrong by the level of the others.
#[test]
fn a_stated_level_is_rendered_as_it_is_whatever_the_level_of_the_others() {
    let mut protocol = from_library("detection_threshold").unwrap().unwrap();
    protocol.stimuli.retain(|one| one.rms_db == Some(-20.0));
    let simulation = Simulation {
        level: LevelRule::Stated(Decibels(-6.0)),
        ..quick(&protocol, Judge::Thurstone)
    };
    let ready = volunteer(&simulation, 1, Whose::Own).unwrap();
    let level = |name: &str| ready.drives[name].rendering.as_ref().unwrap().level_db;
    assert_eq!((level("S8"), level("S8 at -20 dB")), (-6.0, 0.0));
    // Too weak to be measured: the refusal names it.
    protocol.stimuli[0].rms_db = Some(-58.0);
    let simulation = quick(&protocol, Judge::Thurstone);
    let why = volunteer(&simulation, 1, Whose::Own)
        .unwrap_err()
        .to_string();
    assert!(
        why.starts_with("S8 at -20 dB: ") && why.contains("the level is too low"),
        "{why}"
    );
}
