//! scratch
#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "a test")]
use piezotact_bench::replay::Replay;
use piezotact_bench::twin::TwinParameters;
#[test]
fn scratch() {
    for seed in 1..=3 {
        let chapter = chapter3(&Replay {
            parameters: TwinParameters::built_in(),
            seed,
        })
        .unwrap();
        for line in &chapter.measured {
            eprintln!("{line}");
        }
        for f in &chapter.findings {
            eprintln!("{} {} {:?}\n    {}", seed, f.claim, f.verdict, f.measured);
        }
    }
}
