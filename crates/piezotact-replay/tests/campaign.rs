//! Campaigns with virtual volunteers.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use piezotact_people::campaign::chain::Sha;
use piezotact_people::campaign::protocol::from_library;
use piezotact_people::campaign::store::MemoryStore;
use piezotact_replay::campaign::Simulation;

#[test]
#[ignore = "a look"]
fn a_look() {
    let protocol = from_library("isotropic_triplets").unwrap().unwrap();
    let simulation = Simulation::usual(&protocol, Sha::of(b"p"), 7);
    let mut store = MemoryStore::new();
    let begun = std::time::Instant::now();
    let plans = simulation
        .run(1..=4, &mut store, &mut |one| {
            eprintln!(
                "{} {:?} {} {:?}",
                one.pseudonym,
                one.level_db,
                one.offset,
                begun.elapsed()
            );
            for (name, drive) in &one.drives {
                eprintln!("  {name} {:?} {:.3}", drive.verified, one.real[name].ln_rms);
            }
        })
        .unwrap();
    let (_, answers) = simulation.answers(&store, &plans).unwrap();
    for task in ["task1", "task2", "task3"] {
        let mut cells: std::collections::BTreeMap<(String, String), u32> = Default::default();
        for answer in answers.iter().filter(|one| one.task == task) {
            *cells
                .entry((answer.presented.clone(), answer.answered.clone()))
                .or_default() += 1;
        }
        eprintln!("{task}");
        for sample in &protocol.samples {
            let row: Vec<String> = cells
                .iter()
                .filter(|((presented, _), _)| presented == sample)
                .map(|((_, answered), n)| format!("{answered}:{n}"))
                .collect();
            eprintln!("  {sample:4} {}", row.join(" "));
        }
    }
}
