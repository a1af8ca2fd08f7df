//! The claims of the thesis on the twin, each as a test of its own, on the panel of seed 1. What is tested is what
//! `piezotact-validation replay` reports; a claim that an honest twin does not meet is tested to be reported so.
#![allow(
    clippy::expect_used,
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a test fails where it cannot go on, and prints what it measured"
)]

use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

use piezotact::criterion::Outcome;
use piezotact_twin::TwinParameters;
use piezotact_validation::count::{CountSettings, CountedPanels, PanelCount, PanelFindings};
use piezotact_validation::{CLAIMS, Chapter, Finding, Verdict};
use piezotact_volunteers::Laboratory;

const SEED: u64 = 1;

fn measured(number: u8, seed: u64) -> Chapter {
    let laboratory = Laboratory {
        parameters: TwinParameters::built_in(),
        seed,
    };
    piezotact_validation::chapter(&laboratory, number)
        .unwrap()
        .unwrap()
}

/// Every chapter is measured once.
fn chapter(number: u8) -> &'static Chapter {
    static CHAPTERS: [OnceLock<Chapter>; 7] = [const { OnceLock::new() }; 7];
    CHAPTERS[usize::from(number)].get_or_init(|| measured(number, SEED))
}

fn finding(claim: u8) -> &'static Finding {
    let at = CLAIMS.iter().find(|c| c.number == claim).unwrap().chapter;
    // What chapter 2 says of touch is measured with chapter 3.
    let at = if claim == 35 { 3 } else { at };
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

/// Those of chapters 4 to 6, whose panels take minutes.
macro_rules! soak_claims {
    ($($name:ident => $number:literal),* $(,)?) => {
        $(#[test] #[ignore = "chapters 4 to 6 take minutes: ./x soak runs it"] fn $name() { holds($number); })*
    };
}

claims! {
    claim_10_isotropic_spectra_are_broad_and_similar => 10,
    claim_11_level_falls_to_s9_and_fluctuates_beyond => 11,
    claim_12_s2_to_s4_have_close_levels => 12,
    claim_13_s7_and_s8_differ_in_level => 13,
    claim_14_hard_samples_lie_below_0_7 => 14,
    claim_15_friction_follows_roughness_and_level => 15,
    claim_16_level_rises_with_speed => 16,
    claim_17_fingerprint_at_v_over_lambda => 17,
    claim_18_active_and_passive_touch_agree => 18,
    claim_19_strokes_repeat => 19,
}

soak_claims! {
    soak_claim_01_shaker_bundle_max_deviation => 1,
    soak_claim_02_deviation_falls_with_load => 2,
    soak_claim_03_gain_rises_with_load => 3,
    soak_claim_04_angle_makes_a_slight_difference => 4,
    soak_claim_05_antiresonance_belongs_to_the_bench => 5,
    soak_claim_06_transfer_functions_repeat => 6,
    soak_claim_07_coherence_is_close_to_one => 7,
    soak_claim_08_light_touch_at_20_degrees_spreads_most => 8,
    soak_claim_09_average_lies_inside_the_bundle => 9,
    soak_claim_26_averaged_transfer_function_does_as_well => 26,
    soak_claim_21_rendered_overlaps_touched => 21,
    soak_claim_23_exchanged_levels_keep_the_shape => 23,
    soak_claim_29_m8_shows_harmonics_for_everybody => 29,
    soak_claim_30_m3_is_fainter_and_higher => 30,
    soak_claim_31_forces_of_free_touch => 31,
    soak_claim_33_desynchronisation_in_three_tasks => 33,
    soak_claim_37_tasks_differ_over_the_sensorimotor_cortex => 37,
}

/// Level and shape come out otherwise; on S8, whose spectrum is broad, the waveforms correlate a little too much.
#[test]
#[ignore = "chapters 4 to 6 take minutes: ./x soak runs it"]
fn soak_claim_20_sent_straight_comes_out_otherwise_but_for_a_correlation() {
    not_met(20, "correlates with its target");
    let Verdict::DoesNot { reason } = &finding(20).verdict else {
        unreachable!("just tested")
    };
    assert!(
        !reason.contains("level") && !reason.contains("shape"),
        "{reason}"
    );
}

/// For one of these five people the contact loses so much that the average is 4.3 dB rms off.
#[test]
#[ignore = "chapters 4 to 6 take minutes: ./x soak runs it"]
fn soak_claim_22_averaged_transfer_function_is_slightly_worse_for_most() {
    not_met(22, "above 3 dB rms");
}

/// Levels are lower and strokes stick and slip, but all strokes over S1–S3 do: no peak is left whose width could be compared.
#[test]
fn claim_35_transversal_touch_is_softer_and_sticks_but_leaves_no_peak() {
    not_met(35, "no wider peak");
    let Verdict::DoesNot { reason } = &finding(35).verdict else {
        unreachable!("just tested")
    };
    assert!(
        !reason.contains("lower level") && !reason.contains("more strokes"),
        "{reason}"
    );
}

/// The smooth sample has none, and most people show one on the others: a comb whose peaks lie below and above the band has none in it.
#[test]
#[ignore = "chapters 4 to 6 take minutes: ./x soak runs it"]
fn soak_claim_36_a_peak_on_rough_and_biomimetic_for_most() {
    not_met(36, "on M8");
}

/// The plate without texture is always recognised, but neighbours among S4 to S7 are confused. That four of five errors on S9 to S13 lie
/// among them holds in 18 of forty panels (docs/decisions/thesis.md): this one, with 83, 89 and 78 % in the three tasks, says nothing of it.
#[test]
#[ignore = "chapters 4 to 6 take minutes: ./x soak runs it"]
fn soak_claim_24_confusions_are_those_of_the_thesis_and_more() {
    not_met(24, "one of S4 to S7 is taken for a neighbour");
    let Verdict::DoesNot { reason } = &finding(24).verdict else {
        unreachable!("just tested")
    };
    assert!(!reason.contains("without texture"), "{reason}");
}

/// Ten people make too few errors of each kind for their cells to agree.
#[test]
#[ignore = "chapters 4 to 6 take minutes: ./x soak runs it"]
fn soak_claim_25_real_and_simulated_matrices_agree_less() {
    not_met(25, "errors on rendered textures lie in other cells");
}

/// More than 80 % choose by level; volunteers have lapses in real textures too, and none takes S11 INVERTED for S8.
#[test]
#[ignore = "chapters 4 to 6 take minutes: ./x soak runs it"]
fn soak_claim_27_people_choose_by_level_but_err_elsewhere() {
    not_met(27, "not always put in their order");
    let Verdict::DoesNot { reason } = &finding(27).verdict else {
        unreachable!("just tested")
    };
    assert!(!reason.contains("fewer than 80 %"), "{reason}");
}

/// One participant is right nearly always: half of all samples have 100 %, and so have some of the four.
#[test]
#[ignore = "chapters 4 to 6 take minutes: ./x soak runs it"]
fn soak_claim_28_periodic_samples_are_told_apart_all_alike() {
    not_met(28, "recognised as often as half of all samples");
    let Verdict::DoesNot { reason } = &finding(28).verdict else {
        unreachable!("just tested")
    };
    assert!(!reason.contains("M4 and M8"), "{reason}");
}

/// The volunteers imagine nothing: no source gives a number for it.
#[test]
#[ignore = "chapters 4 to 6 take minutes: ./x soak runs it"]
fn soak_claim_32_imagery_helps_nobody_on_the_twin() {
    not_met(
        32,
        "between imagery and control over participants contains zero",
    );
}

/// How many of forty panels meet each claim of `chapters`.
fn forty(chapters: &[u8]) -> PanelCount {
    let laboratory = Laboratory {
        parameters: TwinParameters::built_in(),
        seed: SEED,
    };
    let mut counted = CountedPanels::none(CountSettings::of(&laboratory, chapters));
    let seeds = counted.missing(40);
    let found = |seed: u64| {
        let measured: Vec<Chapter> = chapters.iter().map(|n| measured(*n, seed)).collect();
        PanelFindings::of(seed, &measured)
    };
    // On all cores: a panel knows nothing of another.
    let next = AtomicUsize::new(0);
    let all: Vec<PanelFindings> = std::thread::scope(|scope| {
        let work = || {
            let take = || seeds.get(next.fetch_add(1, Ordering::Relaxed));
            std::iter::from_fn(take).map(|seed| found(*seed)).collect()
        };
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let working: Vec<_> = (0..cores).map(|_| scope.spawn(work)).collect();
        let done = working.into_iter().map(|one| one.join().unwrap());
        done.flat_map(|found: Vec<PanelFindings>| found).collect()
    });
    for findings in all {
        counted.add(findings);
    }
    let counts = counted.counts(40);
    for claim in &counts.claims {
        println!(
            "claim {}: {} of {} {:?}",
            claim.claim, claim.held, claim.of, claim.misses
        );
    }
    counts
}

/// All but those that have less margin than a panel scatters: docs/decisions/thesis.md says which, by how much, and why.
fn at_least_nine_in_ten(counts: &PanelCount, but: &[u8]) {
    for claim in counts
        .claims
        .iter()
        .filter(|claim| !but.contains(&claim.claim))
    {
        assert_eq!(claim.share.outcome, Outcome::Met, "{claim:?}");
    }
}

/// The table of six claims in docs/decisions/thesis.md: claim, how its rule begins, mean, range of 95 % of panels, and how many of forty
/// panels meet the rule.
const SIX_CLAIMS: [(u8, &str, f64, [f64; 2], usize); 11] = [
    (20, "the waveform", 0.77, [0.73, 0.81], 9),
    (24, "one of S4 to S7", 50.0, [33.0, 67.0], 0),
    (24, "S2 and S3", 10.9, [2.5, 21.0], 24),
    (24, "of the errors on S9 to S13", 79.0, [68.0, 90.0], 18),
    (25, "errors on rendered", 0.65, [0.38, 0.84], 28),
    (27, "real textures", 0.7, [0.0, 4.0], 30),
    (27, "in one of the sets", 4.5, [2.0, 10.0], 1),
    (27, "S11 with the level", 0.3, [0.0, 2.0], 13),
    (27, "another error", -1.2, [-4.0, 1.0], 11),
    (28, "one of M5, M7", 3.0, [0.0, 20.0], 0),
    (32, "without imagery, the smooth", 99.0, [90.0, 100.0], 36),
];

/// Means within four standard errors, shares within 15 of 100 panels, and the range of these panels within that of the table, widened by a third. The
/// table's is of 400 panels: of forty an end is their second, which lies further in where most panels give one number.
fn are_those_of_the_table(counts: &PanelCount) {
    for (number, rule, mean, [low, high], met) in SIX_CLAIMS {
        let claim = counts.claims.iter().find(|claim| claim.claim == number);
        let miss = claim.and_then(|claim| {
            let mut misses = claim.misses.iter();
            misses.find(|miss| miss.unless_met.starts_with(rule))
        });
        let miss = miss.expect(rule);
        let (found, sd) = (miss.mean.unwrap(), miss.sd.unwrap());
        assert!((found - mean).abs() <= 4.0 * sd / 40f64.sqrt(), "{miss:?}");
        let (reach, [lowest, highest]) = ((high - low) / 3.0, miss.range.unwrap());
        let is_within = lowest >= low - reach && highest <= high + reach;
        assert!(is_within, "{miss:?}");
        assert!((40 - miss.panels).abs_diff(met) <= 6, "{miss:?}");
    }
}

/// How many of forty panels meet each claim that can be measured: `./x soak panels`.
#[test]
#[ignore = "forty panels take minutes: ./x soak runs it"]
fn soak_panels_of_chapters_3_4_6() {
    let counts = forty(&[3, 4, 6]);
    at_least_nine_in_ten(&counts, &[20, 21, 24, 25, 27, 28, 32, 35, 36]);
    are_those_of_the_table(&counts);
}

/// The same for chapter 5 alone, which takes most of the time.
#[test]
#[ignore = "forty panels take minutes: ./x soak runs it"]
fn soak_panels5_of_chapter_5() {
    at_least_nine_in_ten(&forty(&[5]), &[1, 22]);
}
