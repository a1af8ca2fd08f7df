//! Panels of which everything is known.

use crate::panel::PanelWarning;
use num_complex::Complex;

use super::average::averages;
use super::learning::curves;
use super::levels::Levels;
use super::*;
use crate::criterion::Outcome;
use crate::quantity::{Acceleration, Band, Force, Hertz, Potential, SampleRate};
use crate::transfer::Estimator;

type H = TransferFunction<Force, Acceleration>;
type Fingers = Panel<Force, Acceleration>;

const LINES: usize = 201;
const STEP_HZ: f64 = 5.0;

fn band() -> Band {
    Band::new(Hertz(20.0), Hertz(1000.0)).unwrap()
}

fn function(line: impl Fn(f64) -> Complex<f64>) -> H {
    let rate = SampleRate::new(2_000.0).unwrap();
    let lines = (0..LINES).map(|k| line(k as f64 * STEP_HZ)).collect();
    H::from_lines(lines, vec![0.99; LINES], STEP_HZ, rate, Estimator::H1, 100).unwrap()
}

fn cell(load_n: f64, angle_deg: f64) -> Cell {
    Cell {
        load_n: Newtons(load_n),
        angle_deg: Degrees(angle_deg),
    }
}

fn filed(
    who: &str,
    cell: Cell,
    [placement, repeat]: [u32; 2],
    mut function: H,
) -> Entry<Force, Acceleration> {
    function.about.condition.participant = Some(who.into());
    function.about.condition.load_n = Some(cell.load_n);
    function.about.condition.angle_deg = Some(cell.angle_deg);
    let filing = Filing {
        participant: who.into(),
        cell,
        placement,
        repeat,
    };
    Entry { filing, function }
}

fn db(level_db: f64) -> Complex<f64> {
    Complex::from(10f64.powf(level_db / 20.0))
}

/// Numbers that look normal: sums of twelve uniform ones.
struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn next(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

/// Flat curves: a level of one's own, times what the load does, and a step at 40°.
fn flat_panel(offsets_db: &[f64]) -> Fingers {
    let mut entries = Vec::new();
    for (i, offset) in offsets_db.iter().enumerate() {
        for (load, scale) in [(0.2, 1.0), (0.4, 0.5), (0.6, 0.25)] {
            for (angle, step) in [(20.0, 0.0), (40.0, if i % 2 == 0 { 0.3 } else { -0.3 })] {
                let widest = if angle > 30.0 { 0.9 } else { 1.0 };
                // No two are the same bit by bit, as no two measurements are.
                let own = entries.len() as f64 * 1e-12;
                let level = offset * scale * widest + 10.0 * load + step + own;
                entries.push(filed(
                    &format!("P{i}"),
                    cell(load, angle),
                    [1, 1],
                    function(|_| db(level)),
                ));
            }
        }
    }
    Panel::new(entries).unwrap()
}

fn config() -> PanelConfig {
    PanelConfig::usual(band(), 1)
}

#[test]
fn known_offsets_come_back() {
    let offsets = [-3.0, -1.0, 0.0, 1.0, 2.0, 3.0];
    let panel = flat_panel(&offsets);
    let said = analyse(&panel, &config()).unwrap();
    assert!(said.warnings.is_empty(), "{:?}", said.warnings);
    let light = &said.spreads[0];
    assert!(light.cell.is(cell(0.2, 20.0)));
    assert!((light.bundle.max_deviation_db - 6.0).abs() < 1e-9);
    // Of the offsets, n − 1 in the denominator.
    assert!(
        (light.spread_rms_db - (70.0_f64 / 3.0 / 5.0).sqrt()).abs() < 1e-9,
        "{}",
        light.spread_rms_db
    );
    assert!((light.people[5].db_rms - (3.0 - 1.0 / 3.0)).abs() < 1e-9);
    let worst = said.worst.as_ref().unwrap();
    assert!(worst.cell.is(cell(0.2, 20.0)) && worst.people == 6);
    // Every draw of people has its cells in the same order but for the angle's step.
    assert!(worst.share.unwrap() > 0.5 && worst.share.unwrap() < 1.0);
    // At 20° whoever is drawn; at 40° two people alike may be told apart by the angle's step alone.
    let shares: Vec<f64> = said.falls.iter().filter_map(|f| f.share).collect();
    assert!(
        said.falls.iter().all(|f| f.falls) && shares[0] == 1.0 && shares[1] > 0.95,
        "{shares:?}"
    );
    let [_, first, second] = [0, 1, 2].map(|i| &said.load_steps[i]);
    assert_eq!(
        (said.load_steps.len(), first.from_n.0, second.to_n.0),
        (6, 0.2, 0.6)
    );
    // 2 dB by load; the offset of the lightest falls by half.
    assert!((first.people[0].mean_db - (2.0 + 1.5)).abs() < 1e-9);
    assert!((first.mean_db - (2.0 - 0.5 / 3.0)).abs() < 1e-9);
    assert_eq!((first.rising, first.least_rising_share), (6, 1.0));
    assert!((first.sign_test_p.unwrap() - 0.03125).abs() < 1e-9);
    // The whole step comes first.
    assert!((said.load_steps[0].to_n.0 - said.load_steps[0].from_n.0 - 0.4).abs() < 1e-9);
    let over_all = &said.angle_effects[0];
    assert!(over_all.load_n.is_none() && over_all.people.len() == 6);
    let at_heavy = said.angle_effects.last().unwrap();
    assert_eq!((at_heavy.louder, at_heavy.sign_test_p), (3, Some(1.0)));
    assert!((at_heavy.people[2].db_rms - 0.3).abs() < 1e-9);
    // Without repeats no share is known: what lies between people holds the rest.
    assert!(said.repeatability.lying.is_none() && said.repeatability.put_back.is_none());
    let whole = &said.repeatability.components[0];
    assert_eq!(
        (whole.placements_db, whole.repeats_db, whole.persons_share),
        (None, None, None)
    );
}

/// For flat curves the penalty of a person is how far the mean of the others' offsets is from the own one; the parts of the band agree.
#[test]
fn penalties_and_learning_follow_the_offsets() {
    let offsets = [-2.0, 0.0, 1.0, 5.0];
    let panel = flat_panel(&offsets);
    let said = analyse(&panel, &config()).unwrap();
    let costs = said.penalties_at(cell(0.2, 20.0)).unwrap();
    let expected = [4.0, 4.0 / 3.0, 0.0, 16.0 / 3.0];
    for (person, expected) in costs.people.iter().zip(expected) {
        assert!((person.db_rms - expected).abs() < 1e-9 && (person.db_max - expected).abs() < 1e-9);
    }
    let mean = expected.iter().sum::<f64>() / 4.0;
    assert!((costs.mean_db_rms - mean).abs() < 1e-9 && costs.worst.participant == "P3");
    assert_eq!(costs.verdict.outcome, Outcome::NotDecided);
    assert!((costs.verdict.share_within - 0.5).abs() < 1e-12);
    for part in &said.spreads[0].bands {
        assert!((part.penalty_db_rms - mean).abs() < 1e-9);
    }
    let curve = &said.learning[0];
    assert_eq!((curve.points.len(), curve.orders), (3, 0));
    // One other: the mean over ordered pairs of |difference|.
    let one: f64 = offsets
        .iter()
        .flat_map(|a| offsets.iter().map(move |b| (a - b).abs()))
        .sum::<f64>()
        / 12.0;
    assert!((curve.points[0].mean_db_rms - one).abs() < 1e-9);
    assert!((curve.points[2].mean_db_rms - mean).abs() < 1e-9);
    // By random orders the ends are the same as by all subsets, and the middle is near.
    let many: Vec<f64> = (0..12).map(|i| f64::from(i % 4)).collect();
    let config = PanelConfig {
        orders: 400,
        ..PanelConfig::usual(band(), 3)
    };
    let levels = Levels::of(&flat_panel(&many), band(), config.averaging).unwrap();
    let drawn = curves(&levels, &config);
    let (all, points) = (&drawn[0], &drawn[0].points);
    assert_eq!((points.len(), all.orders), (11, 400));
    let pairs = many
        .iter()
        .flat_map(|a| many.iter().map(move |b| (a - b).abs()))
        .sum::<f64>()
        / 132.0;
    assert!(
        (points[0].mean_db_rms - pairs).abs() < 0.03,
        "{} {pairs}",
        points[0].mean_db_rms
    );
    // 0 to 3, three times each, are 12/11 of 1.5 and 0.5 dB off the mean of the others: enough where e·(√(1 + 1/n) − 1) ≤ 0.1 dB.
    let root = f64::midpoint(1.5_f64.sqrt(), 0.5_f64.sqrt());
    let typical = 12.0 / 11.0 * root * root * (11.0_f64 / 12.0).sqrt();
    let n = all.enough.found.unwrap();
    let gained = |n: f64| typical * ((1.0 + 1.0 / n).sqrt() - 1.0);
    assert!(gained(n) <= 0.1 && gained(n - 1.0) > 0.1, "{n}");
}

/// Phases of ±60°: the complex mean is cos 60° of the magnitude, 6.02 dB less.
#[test]
fn the_complex_mean_loses_what_phases_spread() {
    let turned = |who: &str, deg: f64| {
        let h = Complex::from_polar(1.0, f64::to_radians(deg));
        filed(who, cell(0.2, 20.0), [1, 1], function(|_| h))
    };
    let panel = Panel::new(vec![turned("a", -60.0), turned("b", 60.0)]).unwrap();
    let found = averages(
        &Levels::of(&panel, band(), BundleAverage::LogMagnitude).unwrap(),
        Criterion::thesis_2024(),
    )
    .unwrap();
    let difference = &found[0].difference;
    assert!((difference.mean_db + 6.0206).abs() < 1e-3);
    assert!((difference.phase_rms_deg - 60.0).abs() < 1e-9);
    // exp(−σ²/2) is for normal phases; ±60° are not.
    assert!(
        (difference.by_phases_db + 4.7625).abs() < 1e-3,
        "{difference:?}"
    );
    assert!(difference.by_levels_db.abs() < 1e-9);
    let log = average_of_panel(&panel, cell(0.2, 20.0), BundleAverage::LogMagnitude, band());
    let PanelAverage {
        participants,
        function: log,
        ..
    } = log.unwrap();
    assert_eq!(participants, ["a", "b"]);
    assert_eq!(log.about.provenance.averaged_people, Some(2));
    assert!((log.response()[100].norm() - 1.0).abs() < 1e-12);
    assert!(
        log.about.condition.participant.is_none()
            && log.about.condition.load_n == Some(Newtons(0.2))
    );
    assert!(
        log.about
            .provenance
            .steps
            .last()
            .unwrap()
            .contains("participants a, b")
    );
    assert!(log.about.warnings.iter().any(|d| matches!(
        d.kind(),
        Some(PanelWarning::Averaged {
            participants: 2,
            ..
        })
    )));
}

/// Levels of ±1 dB in phase: the mean of amplitudes is cosh(ln 10/20) of their geometric mean, 0.0575 dB more.
#[test]
fn the_complex_mean_gains_what_levels_spread() {
    let at = cell(0.2, 20.0);
    let of = |who: &str, level: f64| filed(who, at, [1, 1], function(|_| db(level)));
    let panel = Panel::new(vec![of("a", -1.0), of("b", 1.0)]).unwrap();
    let found = averages(
        &Levels::of(&panel, band(), BundleAverage::LogMagnitude).unwrap(),
        Criterion::thesis_2024(),
    );
    let difference = found.unwrap()[0].difference;
    assert!((difference.mean_db - 0.0574).abs() < 1e-4, "{difference:?}");
    assert!(
        (difference.by_levels_db - 0.0576).abs() < 1e-4 && difference.by_phases_db.abs() < 1e-9
    );
}

/// Persons, placements and repeats with standard deviations 2, 1 and 0.5 dB, independent on every line: over 200 lines
/// and 12 people the estimates come within a tenth.
#[test]
fn known_variance_components_come_back() {
    let (mut noise, mut entries) = (Noise(5), Vec::new());
    for person in 0..12 {
        let own: Vec<f64> = (0..LINES).map(|_| 2.0 * noise.next()).collect();
        for placement in 1..=3 {
            let placed: Vec<f64> = own.iter().map(|v| v + noise.next()).collect();
            // Not as many for everybody.
            for repeat in 1..=(2 + (person + placement) % 2) {
                let curve: Vec<f64> = placed.iter().map(|v| v + 0.5 * noise.next()).collect();
                let at = |hz: f64| db(curve[(hz / STEP_HZ).round() as usize]);
                entries.push(filed(
                    &format!("P{person:02}"),
                    cell(0.2, 20.0),
                    [placement, repeat],
                    function(at),
                ));
            }
        }
    }
    let panel = Panel::new(entries).unwrap();
    let (found, warnings) = repeatability(&panel, band(), &[]).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    let whole = &found.components[0];
    let close = |found: f64, expected: f64| (found / expected - 1.0).abs() < 0.1;
    assert!(
        close(whole.persons_db, 2.0) && close(whole.placements_db.unwrap(), 1.0),
        "{whole:?}"
    );
    assert!(
        close(whole.repeats_db.unwrap(), 0.5) && close(whole.persons_share.unwrap(), 4.0 / 5.25),
        "{whole:?}"
    );
    let (lying, put_back) = (found.lying.unwrap(), found.put_back.unwrap());
    // √2 times what varies.
    assert!(close(lying.median_db_rms, 0.5 * 2f64.sqrt()) && close(lying.spread_rms_db, 0.5));
    assert!(close(put_back.median_db_rms, (2.0_f64 * 1.25).sqrt()));
    assert_eq!((lying.groups, put_back.groups), (36, 12));
}

/// One person 8 dB off is named; another whose third repeat is somebody else's too.
#[test]
fn who_does_not_belong_is_named() {
    let (mut noise, mut entries) = (Noise(9), Vec::new());
    for person in 0..8 {
        let own: Vec<f64> = (0..LINES).map(|_| noise.next()).collect();
        for repeat in 1..=3 {
            let off = match (person, repeat) {
                (6, _) => 8.0,
                (2, 3) => 2.5,
                _ => 0.0,
            };
            let curve: Vec<f64> = own.iter().map(|v| v + off + 0.1 * noise.next()).collect();
            let at = |hz: f64| db(curve[(hz / STEP_HZ).round() as usize]);
            entries.push(filed(
                &format!("P{person}"),
                cell(0.2, 20.0),
                [1, repeat],
                function(at),
            ));
        }
    }
    let said = analyse(&Panel::new(entries).unwrap(), &config()).unwrap();
    let text: Vec<String> = said.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(text.len(), 2, "{text:?}");
    assert!(
        text[0].contains("repeats of P2 at 20°, 0.2 N") && text[1].contains("P6 at 20°, 0.2 N"),
        "{text:?}"
    );
}

#[test]
fn what_is_missing_is_a_warning_and_pairs_are_complete() {
    let whole = flat_panel(&[-2.0, -1.0, 0.0, 1.0, 2.0]);
    let mut entries = whole.entries().to_vec();
    entries.retain(|e| !(e.filing.participant == "P4" && e.filing.cell.is(cell(0.4, 40.0))));
    let panel = Panel::new(entries).unwrap();
    assert_eq!(panel.complete(), ["P0", "P1", "P2", "P3"]);
    let text = panel.warnings[0].to_string();
    assert!(
        text.contains("4 of 5") && text.contains("P4 at 40°, 0.4 N"),
        "{text}"
    );
    let said = analyse(&panel, &config()).unwrap();
    assert_eq!((said.complete, said.worst.unwrap().people), (4, 4));
    let pairs = |step: &LoadStep| step.people.len();
    assert_eq!(
        said.load_steps.iter().map(pairs).collect::<Vec<_>>(),
        [5, 5, 5, 5, 4, 4]
    );
    assert_eq!(
        said.angle_effects
            .iter()
            .map(|e| e.people.len())
            .collect::<Vec<_>>(),
        [4, 5, 4, 5]
    );
}

#[test]
fn what_does_not_belong_together_is_refused_by_name() {
    let at = cell(0.2, 20.0);
    let good = || filed("a", at, [1, 1], function(|_| db(0.0)));
    let refused = |change: &dyn Fn(&mut Entry<Force, Acceleration>)| {
        let mut other = filed("b", at, [1, 1], function(|_| db(0.0)));
        change(&mut other);
        Panel::new(vec![good(), other]).unwrap_err().to_string()
    };
    type Change<'a> = &'a dyn Fn(&mut Entry<Force, Acceleration>);
    let cases: [(Change<'_>, &[&str]); 8] = [
        (
            &|e| e.function.about.condition.participant = Some("c".into()),
            &["participant b", "participant c"],
        ),
        (
            &|e| e.function.about.condition.participant = None,
            &["participant", "no statement of it"],
        ),
        (
            &|e| e.function.about.condition.load_n = None,
            &["load", "state it"],
        ),
        (
            &|e| e.function.about.condition.angle_deg = None,
            &["angle", "state it"],
        ),
        (
            &|e| e.function.about.condition.load_n = Some(Newtons(0.4)),
            &["measured at 20°, 0.4 N"],
        ),
        (
            &|e| e.filing.cell.load_n = Newtons(f64::NAN),
            &["load", "as a number"],
        ),
        (
            &|e| {
                let setup = crate::device::DriveSetup::new(
                    crate::device::DeviceDescription::drv2667().at_usual_gain(),
                    crate::quantity::Volts(1.4),
                    Some(80e-9),
                );
                e.function.drive = Some(setup.unwrap());
            },
            &["device", "gain B3", "not described"],
        ),
        (
            &|e| e.function.rate = SampleRate::new(4_000.0).unwrap(),
            &["rate", "2000 Hz", "4000 Hz"],
        ),
    ];
    for (change, parts) in cases {
        let text = refused(change);
        assert!(parts.iter().all(|part| text.contains(part)), "{text}");
    }
    let twice = Panel::new(vec![good(), good()]).unwrap_err().to_string();
    assert!(
        twice.contains("placement 1, repeat 1 is there twice"),
        "{twice}"
    );
    assert_eq!(Fingers::new(Vec::new()), Err(PanelError::Nothing));
    let rate = SampleRate::new(2_000.0).unwrap();
    let short = H::from_lines(
        vec![db(0.0); 101],
        vec![1.0; 101],
        10.0,
        rate,
        Estimator::H1,
        9,
    )
    .unwrap();
    let lines = Panel::new(vec![good(), filed("b", at, [1, 1], short)])
        .unwrap_err()
        .to_string();
    assert!(
        lines.contains("201 lines every 5.0000 Hz") && lines.contains("101 lines"),
        "{lines}"
    );
    let alone = analyse(&Panel::new(vec![good()]).unwrap(), &config())
        .unwrap_err()
        .to_string();
    assert!(alone.contains("at least 2 participants"), "{alone}");
    let far = Band::new(Hertz(2_000.0), Hertz(3_000.0)).unwrap();
    let two = Panel::new(vec![good(), filed("b", at, [1, 1], function(|_| db(1.0)))]).unwrap();
    assert!(matches!(
        analyse(&two, &PanelConfig::usual(far, 1)),
        Err(PanelError::Empty { .. })
    ));
}

/// The dip of the shaker bench: (s² + 2·0.03·ω0·s + ω0²)/(s² + 2·0.12·ω0·s + ω0²), 12 dB at 265 Hz.
fn notch(hz: f64) -> Complex<f64> {
    let s = Complex::new(0.0, hz / 265.0);
    (s * s + 0.06 * s + 1.0) / (s * s + 0.24 * s + 1.0)
}

fn plate(
    line: impl Fn(f64) -> Complex<f64>,
    coherence: f64,
) -> TransferFunction<Potential, Acceleration> {
    let rate = SampleRate::new(2_000.0).unwrap();
    let lines = (0..LINES).map(|k| line(k as f64 * STEP_HZ)).collect();
    TransferFunction::from_lines(
        lines,
        vec![coherence; LINES],
        STEP_HZ,
        rate,
        Estimator::H1,
        100,
    )
    .unwrap()
}

/// A control with a level, a slope and a delay of its own: only the notch is taken out, magnitude and phase.
#[test]
fn a_known_notch_is_taken_out_and_nothing_else() {
    let own = |hz: f64| Complex::from_polar(30.0 * (hz.max(1.0) / 265.0).powf(0.3), -hz * 0.002);
    let artefact = artefact_of(&plate(|hz| own(hz) * notch(hz), 0.99), band()).unwrap();
    assert!((artefact.at_hz - 265.0).abs() < 1e-9, "{}", artefact.at_hz);
    // 12.04 dB, less the 0.2 dB by which the wings of the notch lower the line.
    assert!(
        (artefact.depth_db - 11.85).abs() < 0.1,
        "{}",
        artefact.depth_db
    );
    assert!(artefact.warnings.is_empty());
    let finger = |hz: f64| Complex::from_polar(5.0 / (1.0 + hz / 400.0), -hz * 0.004);
    let mut measured = function(|hz| finger(hz) * notch(hz));
    (measured.excited, measured.effective_averages) = (Some(band()), 33.0);
    let removed = artefact.remove_from(&measured).unwrap();
    assert_eq!(removed.function.excited, measured.excited);
    assert!((removed.function.effective_averages - 33.0).abs() < 1e-12);
    for (k, h) in removed.function.response().iter().enumerate().skip(1) {
        let ratio = h / finger(k as f64 * STEP_HZ);
        let off = 20.0 * ratio.norm().log10();
        assert!(
            off.abs() < 0.35 && ratio.arg().abs() < 0.12,
            "{} Hz: {off} dB, {}",
            k * 5,
            ratio.arg()
        );
    }
    assert!(removed.before.depth_db > 8.0 && (removed.before.at_hz - 265.0).abs() <= 5.0);
    assert!(removed.after.largest_db < 0.1, "{:?}", removed.after);
    assert!(
        removed
            .function
            .about
            .provenance
            .steps
            .last()
            .unwrap()
            .contains("265.0 Hz")
    );
}

#[test]
fn a_control_that_says_nothing_is_refused_or_reported() {
    let flat = artefact_of(&plate(|_| db(3.0), 0.99), band())
        .unwrap_err()
        .to_string();
    assert!(
        flat.contains("no dip") && flat.contains("without a finger"),
        "{flat}"
    );
    let reported = artefact_of(&plate(notch, 0.4), band()).unwrap();
    assert!(
        matches!(&reported.warnings[..], [warning] if matches!(warning.kind(), Some(PanelWarning::ControlIncoherent { .. })))
    );
    let rate = SampleRate::new(2_000.0).unwrap();
    let other = H::from_lines(
        vec![db(0.0); 101],
        vec![1.0; 101],
        10.0,
        rate,
        Estimator::H1,
        9,
    )
    .unwrap();
    let refused = reported.remove_from(&other).unwrap_err().to_string();
    assert!(
        refused.contains("201 lines") && refused.contains("101 lines"),
        "{refused}"
    );
}

#[test]
fn one_seed_gives_one_answer() {
    let panel = flat_panel(&[-3.0, 1.0, 0.3, 1.0, 2.0, 3.0, 0.2, -0.7, 1.9, -2.0, 0.6]);
    let said = |seed| analyse(&panel, &PanelConfig::usual(band(), seed)).unwrap();
    assert_eq!(said(1), said(1));
    assert_ne!(said(1).learning, said(2).learning);
}
