//! Tests: measurements that do not belong in a panel are refused or reported by name.

use crate::warning::{Scatter, ScatterWarning};
use num_complex::Complex;

use super::*;
use crate::criterion::Outcome;
use crate::quantity::{Acceleration, Band, Force, Hertz, SampleRate};
use crate::recording::{BenchKind, RecordingWarning, ReversedSign};
use crate::transfer::{Estimator, TransferWarning};

type Entries = Vec<Entry<Force, Acceleration>>;

fn band() -> Band {
    Band::new(Hertz(20.0), Hertz(1000.0)).unwrap()
}

fn at() -> Cell {
    Cell {
        load_n: Newtons(0.2),
        angle_deg: Degrees(20.0),
    }
}

fn of(who: &str, repeat: u32, level_db: f64) -> Entry<Force, Acceleration> {
    let rate = SampleRate::new(2_000.0).unwrap();
    let lines = vec![Complex::from(10f64.powf(level_db / 20.0)); 201];
    let mut function =
        TransferFunction::from_lines(lines, vec![0.99; 201], 5.0, rate, Estimator::H1, 100)
            .unwrap();
    function.about.condition.participant = Some(who.into());
    function.about.condition.load_n = Some(at().load_n);
    function.about.condition.angle_deg = Some(at().angle_deg);
    let filing = Filing {
        participant: who.into(),
        cell: at(),
        placement: 1,
        repeat,
    };
    Entry { filing, function }
}

fn turned(entry: Entry<Force, Acceleration>) -> Entry<Force, Acceleration> {
    let Entry { filing, function } = entry;
    let minus = function.response().iter().map(|h| -h).collect();
    let mut other = TransferFunction::from_lines(
        minus,
        function.coherence().to_vec(),
        function.resolution_hz(),
        function.rate,
        function.estimator,
        function.averages,
    )
    .unwrap();
    other.about.condition = function.about.condition;
    Entry {
        filing,
        function: other,
    }
}

fn four() -> Entries {
    let people = [("a", 0.0), ("b", 0.3), ("c", -0.2), ("d", 0.1)];
    people.map(|(who, db)| of(who, 1, db)).into()
}

fn warnings(entries: Entries) -> Warnings {
    let panel = Panel::new(entries).unwrap();
    analyse(&panel, &PanelConfig::usual(band(), 1))
        .unwrap()
        .warnings
}

#[test]
fn a_turned_sign_is_named() {
    assert!(warnings(four()).is_empty());
    let mut entries = four();
    entries.push(turned(of("e", 1, 0.2)));
    let said: Vec<String> = warnings(entries.clone())
        .iter()
        .filter(|d| {
            matches!(
                d.kind(),
                Some(RecordingWarning::Sign {
                    of: ReversedSign::Member { .. }
                })
            )
        })
        .map(ToString::to_string)
        .collect();
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(
        said[0].contains("participant e at 20°") && said[0].contains("4 of the 4 others"),
        "{said:?}"
    );
    let panel = Panel::new(entries).unwrap();
    let log = BundleAverage::LogMagnitude;
    let averaged = average_of_panel(&panel, at(), log, band())
        .unwrap()
        .function;
    let opposite = |d: &Warning| {
        matches!(
            d.kind(),
            Some(RecordingWarning::Sign {
                of: ReversedSign::Member { .. }
            })
        )
    };
    assert!(averaged.about.warnings.iter().any(opposite));
    // Two measurements that cancel: the error must not claim that the device does not respond.
    let cancel = Panel::new(vec![of("a", 1, 0.0), turned(of("b", 1, 0.0))]).unwrap();
    let mut config = PanelConfig::usual(band(), 1);
    config.averaging = BundleAverage::Complex;
    let errors = [
        analyse(&cancel, &config).unwrap_err().to_string(),
        average_of_panel(&cancel, at(), BundleAverage::Complex, band())
            .unwrap_err()
            .to_string(),
    ];
    for said in errors {
        assert!(
            said.contains("participant a") && said.contains("opposite sign"),
            "{said}"
        );
    }
}

#[test]
fn other_benches_and_estimators_are_told_apart() {
    let refused = |change: &dyn Fn(&mut Entry<Force, Acceleration>)| {
        let mut entries = four();
        entries[0].function.about.provenance.bench = Some(BenchKind::Twin);
        change(&mut entries[2]);
        Panel::new(entries).unwrap_err().to_string()
    };
    let said = refused(&|e| e.function.estimator = Estimator::H2);
    assert!(said.contains("estimator") && said.contains("H2"), "{said}");
    let said = refused(&|e| e.function.about.provenance.bench = Some(BenchKind::Hardware));
    assert!(said.contains("twin") && said.contains("real"), "{said}");
    let mut entries = four();
    for (seed, entry) in [7, 7, 8, 7].into_iter().zip(&mut entries) {
        entry.function.about.provenance.bench = Some(BenchKind::Twin);
        entry.function.about.provenance.seed = Some(seed);
    }
    let said = warnings(entries)[0].to_string();
    assert!(
        said.contains("participant c") && said.contains("seed 8"),
        "{said}"
    );
}

/// P02 of the twin of seed 7 and P02 of the twin of seed 8 are two people, and no repeats of one.
#[test]
fn two_twins_under_one_name_are_refused() {
    let mut entries = four();
    entries.push(of("a", 2, 0.15));
    for (seed, entry) in [7, 7, 7, 7, 8].into_iter().zip(&mut entries) {
        entry.function.about.provenance.bench = Some(BenchKind::Twin);
        entry.function.about.condition.twin_seed = Some(seed);
    }
    let said = Panel::new(entries).unwrap_err().to_string();
    assert!(
        said.contains("a is a (twin of seed 7)") && said.contains("a (twin of seed 8)"),
        "{said}"
    );
}

#[test]
fn a_measurement_of_somebody_else_is_refused() {
    let mut entries = four();
    entries[1].function.about.condition.participant = Some("P02".into());
    let said = Panel::new(entries).unwrap_err().to_string();
    assert!(
        said.contains("participant b") && said.contains("P02"),
        "{said}"
    );
}

#[test]
fn one_response_is_one_measurement() {
    let said = Panel::new(vec![of("a", 1, 0.5), of("b", 2, 0.5)])
        .unwrap_err()
        .to_string();
    assert!(
        said.contains("participant a")
            && said.contains("and participant b")
            && said.contains("bit-identical response"),
        "{said}"
    );
}

#[test]
fn impossible_filings_are_refused() {
    type Change = fn(&mut Filing);
    let changes: [(Change, &str); 12] = [
        (|f| f.participant = " ".into(), "participant"),
        (|f| f.participant = "a\nb".into(), "participant"),
        (|f| f.participant = "../a".into(), "participant"),
        (|f| f.participant = "a\\b".into(), "participant"),
        (|f| f.cell.load_n = Newtons(0.0), "load"),
        (|f| f.cell.load_n = Newtons(f64::INFINITY), "load"),
        (|f| f.cell.load_n = Newtons(f64::NAN), "load"),
        (|f| f.cell.load_n = Newtons(101.0), "load"),
        (|f| f.cell.angle_deg = Degrees(-1.0), "angle"),
        (|f| f.cell.angle_deg = Degrees(91.0), "angle"),
        (|f| f.placement = 0, "placement"),
        (|f| f.repeat = 0, "repeat"),
    ];
    for (change, what) in changes {
        let mut entry = of("a", 1, 0.0);
        change(&mut entry.filing);
        let said = Panel::new(vec![entry]).unwrap_err().to_string();
        assert!(said.contains(&format!("expected the {what}")), "{said}");
    }
}

/// A part of the band that was not excited for one person leaves the verdict undecided, and low coherence raises a warning.
#[test]
fn what_was_not_driven_is_reported() {
    let verdict = |entries: Entries| {
        let said = analyse(
            &Panel::new(entries).unwrap(),
            &PanelConfig::usual(band(), 1),
        )
        .unwrap();
        (said.averages[0].penalties[0].verdict.clone(), said.warnings)
    };
    let excited = |verdict: &Verdict| verdict.criteria.last().map(|c| (c.what, c.outcome));
    let is = |outcome| Some((AverageCriterion::Excited, outcome));
    assert_eq!(excited(&verdict(four()).0), is(Outcome::Met));
    let mut entries = four();
    entries[1].function.excited = Band::new(Hertz(100.0), Hertz(1000.0)).ok();
    let (unsure, said) = verdict(entries.clone());
    assert_eq!(excited(&unsure), is(Outcome::NotDecided));
    assert_eq!(
        (unsure.outcome, unsure.people_needed),
        (Outcome::NotDecided, None)
    );
    let named = |said: &[Warning]| said.iter().any(|d| d.to_string().contains("participant b"));
    assert!(
        matches!(said[0].kind(), Some(TransferWarning::NotExcited { .. })) && named(&said),
        "{said:?}"
    );
    let panel = Panel::new(entries).unwrap();
    let averaged = average_of_panel(&panel, at(), BundleAverage::Complex, band())
        .unwrap()
        .function;
    assert_eq!(
        averaged.excited,
        Band::new(Hertz(100.0), Hertz(1000.0)).ok()
    );
    let not_excited = |d: &Warning| matches!(d.kind(), Some(TransferWarning::NotExcited { .. }));
    assert!(averaged.about.warnings.iter().any(not_excited));
    let mut entries = four();
    let loud = &entries[3].function;
    let mut faint = TransferFunction::from_lines(
        loud.response().to_vec(),
        vec![0.4; 201],
        5.0,
        loud.rate,
        loud.estimator,
        100,
    )
    .unwrap();
    faint.about.condition = loud.about.condition.clone();
    entries[3].function = faint;
    let said = verdict(entries).1;
    assert!(
        matches!(said[0].kind(), Some(TransferWarning::LowCoherence { .. })),
        "{said:?}"
    );
}

/// Too few groups to say what is usual: repeats of one placement are expected within 1 dB.
#[test]
fn mixed_repeats_are_seen_in_small_panels_too() {
    let repeats = |level: f64| {
        vec![
            of("a", 1, 0.0),
            of("a", 2, level),
            of("b", 1, 1.0),
            of("b", 2, 1.1),
        ]
    };
    assert!(!warnings(repeats(0.9)).iter().any(|d| matches!(
        d.kind(),
        Some(ScatterWarning::Scatter {
            of: Scatter::RepeatsOfParticipant { .. }
        })
    )));
    let said = warnings(repeats(1.2));
    let mixed = said.iter().find(|d| {
        matches!(
            d.kind(),
            Some(ScatterWarning::Scatter {
                of: Scatter::RepeatsOfParticipant { .. }
            })
        )
    });
    assert!(mixed.unwrap().to_string().contains("a at 20°"), "{said:?}");
}

/// Phases of ±60° cost a complex mean, in a part of the band as in the whole.
#[test]
fn penalties_in_parts_are_of_the_average_that_was_asked_for() {
    let turn = |entry: Entry<Force, Acceleration>, degrees: f64| {
        let Entry { filing, function } = entry;
        let by = Complex::from_polar(1.0, f64::to_radians(degrees));
        let lines = function.response().iter().map(|h| h * by).collect();
        let coherence = function.coherence().to_vec();
        let rate = function.rate;
        let mut other =
            TransferFunction::from_lines(lines, coherence, 5.0, rate, Estimator::H1, 100).unwrap();
        other.about.condition = function.about.condition;
        Entry {
            filing,
            function: other,
        }
    };
    let entries = vec![
        of("a", 1, 0.0),
        turn(of("b", 1, 0.0), 60.0),
        turn(of("c", 1, 0.0), -60.0),
    ];
    let panel = Panel::new(entries).unwrap();
    let mut config = PanelConfig::usual(band(), 1);
    let part = |config: &PanelConfig| {
        let said = analyse(&panel, config).unwrap();
        let whole = said.penalties_at(at()).unwrap().mean_db_rms;
        (said.spreads[0].bands[1].penalty_db_rms, whole)
    };
    assert!(part(&config).0 < 1e-9);
    config.averaging = BundleAverage::Complex;
    let (found, whole) = part(&config);
    assert!(
        found > 1.0 && (found - whole).abs() < 1e-9,
        "{found} {whole}"
    );
}

/// Membership is a list of criteria: a difference in any refuses the panel, a warning about a member is "not decided".
#[test]
fn membership_is_a_list_of_criteria() {
    let members = |entries: Entries| {
        let panel = Panel::new(entries).unwrap();
        panel.members(&panel.signs(band()), band())
    };
    let outcomes = |members: &[Member], rule| -> Vec<Outcome> {
        let found = members.iter().map(|m| m.criterion(rule).unwrap());
        found.map(|c| c.outcome).collect()
    };
    let plain = members(four());
    assert_eq!(plain.len(), 4);
    assert!(
        plain
            .iter()
            .all(|m| m.outcome() == Outcome::Met && m.criteria.len() == 11)
    );
    let mut entries = four();
    entries.push(turned(of("e", 1, 0.2)));
    entries[1].function.excited = Band::new(Hertz(20.0), Hertz(500.0)).ok();
    let reported = members(entries.clone());
    let met = Outcome::Met;
    assert_eq!(
        outcomes(&reported, MemberCriterion::OppositeSign),
        [met, met, met, met, Outcome::NotDecided]
    );
    let excited = reported[1].criterion(MemberCriterion::Excited).unwrap();
    assert_eq!(excited.outcome, Outcome::NotDecided);
    assert!((excited.found.unwrap() - 0.5).abs() < 0.02, "{excited}");
    // The analysis holds the same list, and the participants who lack a cell.
    let said = analyse(
        &Panel::new(entries.clone()).unwrap(),
        &PanelConfig::usual(band(), 1),
    );
    assert_eq!(said.unwrap().members, reported);
    let mut heavier = of("a", 1, 0.0);
    heavier.filing.cell.load_n = Newtons(0.4);
    heavier.function.about.condition.load_n = Some(Newtons(0.4));
    heavier.function = heavier.function.times(|_| Complex::from(1.1));
    entries.push(heavier);
    let panel = Panel::new(entries).unwrap();
    let complete: Vec<Outcome> = panel
        .attendances()
        .iter()
        .map(Completeness::outcome)
        .collect();
    assert_eq!(complete[..2], [met, Outcome::NotMet]);
    assert_eq!(panel.complete(), ["a"]);
}
