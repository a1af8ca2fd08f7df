//! Tests of the verdicts of panels against populations with known truth.

use num_complex::Complex;

use super::average::averages;
use super::learning::curves;
use super::levels::Levels;
use super::spread::falls;
use super::*;
use crate::criterion::Outcome;
use crate::quantity::{Acceleration, Band, Force, Hertz, SampleRate};
use crate::statistics::Direction;
use crate::transfer::Estimator;

const LINES: usize = 11;

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

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

fn band() -> Band {
    Band::new(Hertz(20.0), Hertz(1000.0)).unwrap()
}

/// A panel at one angle: by person, then by load, the levels of all lines, dB.
fn panel_of(people: &[Vec<Vec<f64>>]) -> Panel<Force, Acceleration> {
    let rate = SampleRate::new(2_000.0).unwrap();
    let mut entries = Vec::new();
    for (i, loads) in people.iter().enumerate() {
        for (load, levels) in loads.iter().enumerate() {
            let lines = levels.iter().map(|db| Complex::from(10f64.powf(db / 20.0)));
            let mut function = TransferFunction::from_lines(
                lines.collect(),
                vec![0.99; LINES],
                100.0,
                rate,
                Estimator::H1,
                100,
            )
            .unwrap();
            let cell = Cell {
                load_n: Newtons(0.2 * (load + 1) as f64),
                angle_deg: Degrees(20.0),
            };
            function.about.condition.participant = Some(format!("P{i:02}"));
            function.about.condition.load_n = Some(cell.load_n);
            function.about.condition.angle_deg = Some(cell.angle_deg);
            let filing = Filing {
                participant: format!("P{i:02}"),
                cell,
                placement: 1,
                repeat: 1,
            };
            entries.push(Entry { filing, function });
        }
    }
    Panel::new(entries).unwrap()
}

/// The verdicts on `panels` panels of `n` people who are off the mean by what `person` draws, dB.
fn verdicts(n: usize, panels: u64, person: impl Fn(&mut Noise) -> f64) -> Vec<Verdict> {
    let mut noise = Noise(20_261_121 + n as u64);
    (0..panels)
        .map(|_| {
            let people: Vec<Vec<Vec<f64>>> = (0..n)
                .map(|_| {
                    let off = person(&mut noise);
                    vec![(0..LINES).map(|_| off + 0.1 * noise.normal()).collect()]
                })
                .collect();
            let averages = averages(
                &Levels::of(&panel_of(&people), band(), BundleAverage::LogMagnitude).unwrap(),
                Criterion::thesis_2024(),
            );
            averages.unwrap()[0].penalties[0].verdict.clone()
        })
        .collect()
}

fn share(verdicts: &[Verdict], outcome: Outcome) -> f64 {
    let count = verdicts.iter().filter(|v| v.outcome == outcome).count();
    count as f64 / verdicts.len() as f64
}

/// One person in eight is beyond 3 dB: a panel may accept the average for nine of ten people in at most 5 % of
/// cases, for evenly scattered people and for a few outliers. An earlier version accepted it in 55 % of panels of four.
#[test]
fn a_panel_does_not_say_that_an_average_does_that_does_not() {
    let evenly = |noise: &mut Noise| 1.95 * noise.normal();
    let few_far_off = |noise: &mut Noise| match noise.uniform() < 0.125 {
        true => 6.0,
        false => 0.3 * noise.normal(),
    };
    for (n, panels) in [(2, 100), (4, 200), (10, 100), (20, 60), (40, 40)] {
        let evenly = share(&verdicts(n, panels, evenly), Outcome::Met);
        let far_off = share(&verdicts(n, panels, few_far_off), Outcome::Met);
        assert!(evenly <= 0.05 && far_off <= 0.05, "{n}: {evenly} {far_off}");
    }
}

/// The average does for 95 in 100, and the others lie 12 dB off: one of them in a small average puts everybody beyond, and
/// the panel may not say that the average will not do.
#[test]
fn one_odd_person_does_not_condemn_an_average() {
    let odd = |noise: &mut Noise| match noise.uniform() < 0.05 {
        true => 12.0,
        false => 0.3 * noise.normal(),
    };
    for n in [3, 4, 5, 8, 20] {
        let refused = share(&verdicts(n, 200, odd), Outcome::NotMet);
        assert!(refused <= 0.05, "{n}: {refused}");
    }
}

/// The error of an average for somebody who is not in it lies within its interval for 93 to 97 % of people, or as many more or fewer as
/// 2000 panels scatter by, twice: where people differ in level, in shape, and where some are unusual.
#[test]
fn the_error_for_a_new_person_is_within_its_interval() {
    the_error_for_a_new_person_is_within_its_interval_of(&[4, 6]);
}

#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_the_error_for_a_new_person_is_within_its_interval() {
    the_error_for_a_new_person_is_within_its_interval_of(&[4, 6, 10, 20]);
}

fn the_error_for_a_new_person_is_within_its_interval_of(sizes: &[usize]) {
    const PANELS: usize = 2_000;
    let scatter = 2.0 * (0.05 * 0.95 / PANELS as f64).sqrt();
    let level = |noise: &mut Noise| vec![2.0 * noise.normal(); LINES];
    let shape = |noise: &mut Noise| -> Vec<f64> {
        let [own, tilt, bow] = [0.0; 3].map(|_| noise.normal());
        let line = |line: usize| {
            let place = line as f64 / (LINES - 1) as f64 - 0.5;
            2.0 * own + 3.0 * tilt * place + 4.0 * bow * (place * place - 0.1)
        };
        (0..LINES).map(line).collect()
    };
    let unusual = |noise: &mut Noise| match noise.uniform() < 0.15 {
        true => vec![6.0 * noise.normal(); LINES],
        false => vec![2.0 * noise.normal(); LINES],
    };
    type Person<'a> = &'a dyn Fn(&mut Noise) -> Vec<f64>;
    let populations: [Person<'_>; 3] = [&level, &shape, &unusual];
    for (kind, person) in populations.into_iter().enumerate() {
        for &n in sizes {
            let mut noise = Noise(49 + n as u64);
            let mut held = 0;
            for _ in 0..PANELS {
                let people: Vec<Vec<Vec<f64>>> = (0..n).map(|_| vec![person(&mut noise)]).collect();
                let levels = Levels::of(&panel_of(&people), band(), BundleAverage::LogMagnitude);
                let found = averages(&levels.unwrap(), Criterion::thesis_2024()).unwrap();
                let [low, high] = found[0].penalties[0].new_person_db_rms.unwrap();
                let new = person(&mut noise);
                // The line at 0 Hz is not in the band.
                let off = found[0].log_magnitude_db.iter().zip(&new[1..]);
                let error = crate::statistics::rms(&off.map(|(a, b)| a - b).collect::<Vec<_>>());
                held += usize::from(low <= error && error <= high);
            }
            let share = held as f64 / PANELS as f64;
            let expected = 0.93 - scatter..=0.97 + scatter;
            assert!(expected.contains(&share), "{kind} {n}: {share}");
        }
    }
}

/// What there is to be found is found: nobody beyond 3 dB by 36 people, half of all beyond by ten.
#[test]
fn large_panels_decide() {
    let alike = |noise: &mut Noise| 0.5 * noise.normal();
    let apart = |noise: &mut Noise| 5.0 * noise.normal();
    for (n, met) in [(4, 0.0), (20, 0.0), (36, 1.0), (60, 1.0)] {
        let found = verdicts(n, 20, alike);
        assert!((share(&found, Outcome::Met) - met).abs() < 1e-9, "{n}");
        let needed = found[0].people_needed;
        assert_eq!(needed, (met < 0.5).then_some(36), "{n}");
    }
    let power: Vec<f64> = [4, 6, 10, 20]
        .iter()
        .map(|n| share(&verdicts(*n, 60, apart), Outcome::NotMet))
        .collect();
    assert!(power[3] >= 0.95 && power[2] >= 0.65, "{power:?}");
    // Two people have one penalty, twice.
    let two = verdicts(2, 5, apart);
    assert!(two.iter().all(|v| v.outcome == Outcome::NotDecided));
    assert!(two[0].criteria[0].interval.is_none());
}

/// How many people are enough lies within its interval in 95 % of panels, and a panel of four decides it in few.
#[test]
fn how_many_people_are_enough_has_an_interval() {
    // The square root of a normal number, without its sign, has the mean 2^¼·Γ(¾)/√π = 0.822.
    let error_db = 1.5 * 0.822 * 0.822;
    let truth = (1..).find(|n| error_db * ((1.0 + 1.0 / f64::from(*n)).sqrt() - 1.0) <= 0.1);
    let truth = f64::from(truth.unwrap());
    let mut noise = Noise(5);
    let (mut held, mut decided, panels) = (0, 0, 200);
    for _ in 0..panels {
        let people: Vec<Vec<Vec<f64>>> = (0..4)
            .map(|_| vec![vec![1.5 * noise.normal(); LINES]])
            .collect();
        let config = PanelConfig::usual(band(), 1);
        let levels = Levels::of(&panel_of(&people), band(), config.averaging).unwrap();
        let curves = curves(&levels, &config);
        let enough = &curves[0].enough;
        let [low, high] = enough.interval.unwrap();
        held += usize::from(low <= truth && truth <= high);
        decided += usize::from(enough.outcome == Outcome::Met);
    }
    assert!(
        (184..=200).contains(&held) && decided <= 10,
        "{held} {decided}"
    );
}

/// Whether people lie closer together under load: where they do not, it is said in 5 % of panels or fewer, and where they
/// lie half as far apart, panels of twelve find it.
#[test]
fn a_trend_with_load_is_said_where_there_is_one() {
    let said = |n: usize, heavier: f64, panels: u64| -> f64 {
        let mut noise = Noise(9);
        let found = (0..panels).filter(|_| {
            let people: Vec<Vec<Vec<f64>>> = (0..n)
                .map(|_| {
                    let own = 2.0 * noise.normal();
                    [1.0, heavier]
                        .iter()
                        .map(|scale| {
                            let at_load = 0.7 * noise.normal();
                            (0..LINES)
                                .map(|_| scale * (own + at_load + 0.7 * noise.normal()))
                                .collect()
                        })
                        .collect()
                })
                .collect();
            let log = BundleAverage::LogMagnitude;
            let falls = falls(
                &Levels::of(&panel_of(&people), band(), log).unwrap(),
                200,
                1,
            );
            falls[0].direction != Direction::NotShown
        });
        found.count() as f64 / panels as f64
    };
    for n in [4, 8, 15] {
        let wrongly = said(n, 1.0, 200);
        assert!(wrongly <= 0.08, "{n}: {wrongly}");
    }
    let power = said(12, 0.4, 40);
    assert!(power >= 0.8, "{power}");
}

/// A line of 0 has no level: 6000 dB between people was a clamp.
#[test]
fn a_line_without_a_level_is_refused() {
    let mut people = vec![vec![vec![0.0; LINES]]; 3];
    for (i, person) in people.iter_mut().enumerate() {
        person[0][1] = 0.1 * i as f64;
    }
    people[1][0][4] = f64::NEG_INFINITY;
    let refused = analyse(&panel_of(&people), &PanelConfig::usual(band(), 1));
    let said = refused.unwrap_err().to_string();
    assert!(
        said.contains("participant P01") && said.contains("is 0 at 400.0 Hz"),
        "{said}"
    );
}
