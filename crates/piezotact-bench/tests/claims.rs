//! scratch
#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "a test")]
use piezotact_bench::replay::Replay;
use piezotact_bench::twin::TwinParameters;
#[test]
fn scratch() {
    let number: u8 = std::env::var("CHAPTER").unwrap().parse().unwrap();
    let seeds: u64 = std::env::var("SEEDS").unwrap().parse().unwrap();
    for seed in 1..=seeds {
        let replay = Replay {
            parameters: TwinParameters::built_in(),
            seed,
        };
        let chapter = replay.chapter(number).unwrap().unwrap();
        for line in &chapter.measured {
            eprintln!("{line}");
        }
        for f in &chapter.findings {
            eprintln!(
                "seed {} claim {} {:?}\n    {}",
                seed, f.claim, f.verdict, f.measured
            );
        }
    }
}
