//! The 34 claims of the thesis on the twin, each as a test of its own, on the panel of seed 1. What is tested is what
//! `piezotact replay` reports; a claim that an honest twin does not meet is tested to be reported so.
#![allow(
    clippy::expect_used,
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a test fails where it cannot go on, and prints what it measured"
)]

use std::sync::OnceLock;

use piezotact_replay::{CLAIMS, Chapter, Finding, Replay, Verdict};
use piezotact_twin::TwinParameters;

const SEED: u64 = 1;

fn measured(number: u8, seed: u64) -> Chapter {
    let replay = Replay {
        parameters: TwinParameters::built_in(),
        seed,
    };
    replay.chapter(number).unwrap().unwrap()
}

/// Every chapter is measured once.
fn chapter(number: u8) -> &'static Chapter {
    static CHAPTERS: [OnceLock<Chapter>; 7] = [const { OnceLock::new() }; 7];
    CHAPTERS[usize::from(number)].get_or_init(|| measured(number, SEED))
}

fn finding(claim: u8) -> &'static Finding {
    let at = CLAIMS.iter().find(|c| c.number == claim).unwrap().chapter;
    let found = chapter(at).findings.iter().find(|f| f.claim == claim);
    found.expect("every chapter says something of each of its claims")
}

fn holds(claim: u8) {
    let finding = finding(claim);
    println!("claim {claim}: {}", finding.measured);
    assert_eq!(finding.verdict, Verdict::Holds, "{}", finding.measured);
}

/// Reported as not met, for the reason that is known.
fn not_met(claim: u8, because: &str) {
    let finding = finding(claim);
    println!("claim {claim}: {}", finding.measured);
    match &finding.verdict {
        Verdict::DoesNot { reason } => assert!(reason.contains(because), "{reason}"),
        other => panic!("{other:?}: {}", finding.measured),
    }
}

macro_rules! claims {
    ($($name:ident => $number:literal),* $(,)?) => {
        $(#[test] fn $name() { holds($number); })*
    };
}

macro_rules! later {
    ($with:literal: $($name:ident),* $(,)?) => {
        $(#[test] #[ignore = $with] fn $name() { panic!($with) })*
    };
}

claims! {
    claim_01_shaker_bundle_max_deviation => 1,
    claim_02_deviation_falls_with_load => 2,
    claim_03_gain_rises_with_load => 3,
    claim_04_angle_makes_a_slight_difference => 4,
    claim_05_antiresonance_belongs_to_the_bench => 5,
    claim_06_transfer_functions_repeat => 6,
    claim_07_coherence_is_close_to_one => 7,
    claim_08_light_touch_at_20_degrees_spreads_most => 8,
    claim_09_average_lies_inside_the_bundle => 9,
    claim_10_isotropic_spectra_are_broad_and_similar => 10,
    claim_11_level_falls_to_s9_and_fluctuates_beyond => 11,
    claim_12_s2_to_s4_have_close_levels => 12,
    claim_13_s7_and_s8_differ_in_level => 13,
    claim_14_hard_samples_lie_below_0_7 => 14,
    claim_15_friction_follows_roughness_and_level => 15,
    claim_16_level_rises_with_speed => 16,
    claim_17_fingerprint_at_v_over_lambda => 17,
    claim_18_active_and_passive_touch_agree => 18,
    claim_21_rendered_overlaps_touched => 21,
    claim_22_averaged_transfer_function_is_slightly_worse => 22,
    claim_23_exchanged_levels_keep_the_shape => 23,
    claim_30_m3_is_fainter_and_higher => 30,
    claim_31_forces_of_free_touch => 31,
}

/// Level and centroid repeat; the highest line of a single stroke does not.
#[test]
fn claim_19_strokes_repeat_but_for_their_highest_line() {
    not_met(19, "probably random");
    let Verdict::DoesNot { reason } = &finding(19).verdict else {
        unreachable!("just tested")
    };
    assert!(!reason.contains("the level varies"), "{reason}");
}

/// S8 comes out otherwise; M8, whose power lies in a few lines, less so than the 10 dB asked for.
#[test]
fn claim_20_sent_straight_comes_out_otherwise_for_s8() {
    not_met(20, "M8");
    let Verdict::DoesNot { reason } = &finding(20).verdict else {
        unreachable!("just tested")
    };
    assert!(!reason.contains("S8"), "{reason}");
}

/// The period and the speeds do; one person of ten shows no harmonic beyond chance.
#[test]
fn claim_29_m8_shows_harmonics_for_nine_of_ten() {
    not_met(
        29,
        "no harmonic is three standard errors above the background for P10,",
    );
    let Verdict::DoesNot { reason } = &finding(29).verdict else {
        unreachable!("just tested")
    };
    assert!(
        !reason.contains("period") && !reason.contains("speed outside"),
        "{reason}"
    );
}

later! { "comes with campaigns and their virtual participants":
    claim_24_s2_s3_and_s9_to_s13_are_confused,
    claim_25_real_and_simulated_matrices_agree,
    claim_26_averaged_transfer_function_does_as_well,
    claim_27_people_choose_by_level,
    claim_28_periodic_samples_are_told_apart,
    claim_32_imagery_helps_discrimination,
    claim_34_association_is_declared_over_presented,
}
later! { "comes with the brain's answer":
    claim_33_desynchronisation_in_three_tasks,
}

/// How many of `panels` panels meet each claim of `chapters`, by claim: those that do, and those that were measured.
fn counted(panels: u64, chapters: &[u8]) -> Vec<(u64, u64)> {
    let mut counts = vec![(0, 0); 35];
    for seed in 1..=panels {
        for number in chapters {
            for finding in measured(*number, seed).findings {
                let (met, seen) = &mut counts[usize::from(finding.claim)];
                match finding.verdict {
                    Verdict::Holds => {
                        *met += 1;
                        *seen += 1;
                    }
                    Verdict::DoesNot { reason } => {
                        *seen += 1;
                        println!(
                            "seed {seed}, claim {}: {reason}: {}",
                            finding.claim, finding.measured
                        );
                    }
                    Verdict::NotYet { .. } => {}
                }
            }
        }
    }
    for (claim, (met, seen)) in counts.iter().enumerate() {
        if *seen > 0 {
            println!("claim {claim}: {met} of {seen} panels");
        }
    }
    counts
}

fn at_least_nine_in_ten(counts: &[(u64, u64)], claims: &[usize]) {
    for claim in claims {
        let (met, seen) = counts[*claim];
        assert!(
            met as f64 >= 0.9 * seen as f64,
            "claim {claim}: {met} of {seen}"
        );
    }
}

/// How many of forty panels meet each claim that can be measured: `./x soak forty_panels`.
///
/// The claims that are not named have less margin than a panel scatters: docs/decisions/0018 says which and why.
#[test]
#[ignore = "forty panels take minutes: ./x soak runs it"]
fn soak_forty_panels() {
    let counts = counted(40, &[3, 4, 6]);
    at_least_nine_in_ten(&counts, &[10, 11, 14, 15, 16, 18, 21, 23, 30, 31]);
}

/// The same for chapter 5 alone, which takes most of the time.
#[test]
#[ignore = "forty panels take minutes: ./x soak runs it"]
fn soak_forty_panels_of_chapter_5() {
    let counts = counted(40, &[5]);
    // 1, 2, 3 and 8 have less margin than a panel scatters: docs/decisions/0018 says how many meet them, and why.
    at_least_nine_in_ten(&counts, &[4, 5, 6, 7, 9]);
}
