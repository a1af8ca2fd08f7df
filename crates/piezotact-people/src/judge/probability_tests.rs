//! Probabilities against SciPy, and against the frequencies of drawn answers.

use piezotact::quantity::{Band, Hertz};
use piezotact::statistics::random::Random;
use serde_json::Value;

use super::super::{Cues, Judge, OnSurface, Pattern, Touch};
use super::*;

const AT: Moment = Moment { judgement: 25 };

fn golden() -> Value {
    serde_json::from_str(include_str!("../../tests/golden/judge.json")).unwrap()
}

fn rendered(ln_rms: f64, bands_db: [f64; CUE_BANDS]) -> Cues {
    Cues {
        band: Band::new(Hertz(20.0), Hertz(1000.0)).unwrap(),
        ln_rms,
        bands_db,
        ln_centroid: 5.0,
        surface: None,
    }
}

fn real(cues: Cues) -> Cues {
    cues.on(OnSurface {
        period_m: 50e-6,
        pattern: Pattern::Random,
        friction: Some(0.6),
    })
}

fn numbers(value: &Value) -> Vec<f64> {
    let all = value.as_array().unwrap().iter();
    all.map(|v| v.as_f64().unwrap()).collect()
}

fn cues(value: &Value) -> Cues {
    let row = numbers(value);
    rendered(row[0], std::array::from_fn(|i| row[i + 1]))
}

fn person(judge: Judge) -> Person {
    Person {
        judge,
        touch: Touch::mean_person(),
    }
}

/// Two alternatives to the rounding of erfc, three to SciPy's 1e-9, four to four standard errors of its count and the scatter of
/// our own points (1e-3).
#[test]
fn choices_are_those_of_scipy() {
    for row in golden()["choices"].as_array().unwrap() {
        let judge = Judge::named(row["judge"].as_str().unwrap()).unwrap();
        let presented = cues(&row["presented"]);
        let alternatives: Vec<Cues> = row["alternatives"]
            .as_array()
            .unwrap()
            .iter()
            .map(|v| real(cues(v)))
            .collect();
        let looks: Vec<Look<'_>> = alternatives.iter().map(Look::of).collect();
        let found = person(judge)
            .choice_probabilities(Look::of(&presented), &looks, (Recall::Touched, AT))
            .unwrap();
        let tolerance = [1e-9, 1e-8, 2e-3][looks.len() - 2];
        for (found, expected) in found.iter().zip(numbers(&row["probabilities"])) {
            assert!(
                (found - expected).abs() < tolerance,
                "{judge:?} of {}: {found} {expected}",
                looks.len()
            );
        }
        assert!((found.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn orders_are_those_of_scipy() {
    for row in golden()["orders"].as_array().unwrap() {
        let textures: Vec<Cues> = numbers(&row["levels"])
            .into_iter()
            .map(|level| real(rendered(level, [-7.0; CUE_BANDS])))
            .collect();
        let looks: Vec<Look<'_>> = textures.iter().map(Look::of).collect();
        let order: Vec<usize> = (0..looks.len()).collect();
        let [attentive, _] = person(Judge::Thurstone)
            .attentive_order(&looks, &order, AT)
            .unwrap();
        let expected = row["attentive"].as_f64().unwrap();
        // SciPy's own error for five is 1e-6.
        assert!(
            (attentive - expected).abs() < 3e-6,
            "{attentive} {expected}"
        );
    }
}

/// All orders of four textures of every judge sum to 1, lapses included, also where one is placed last.
#[test]
fn all_orders_together_are_certain() {
    let textures: Vec<Cues> = [0.3, 0.28, 0.2, 0.25]
        .into_iter()
        .enumerate()
        .map(|(i, level)| {
            rendered(level, [-7.0; CUE_BANDS]).on(OnSurface {
                period_m: 1e-4 * (i + 1) as f64,
                pattern: Pattern::Random,
                friction: Some(if i == 1 { 1.4 } else { 0.6 }),
            })
        })
        .collect();
    let looks: Vec<Look<'_>> = textures.iter().map(Look::of).collect();
    for judge in Judge::ALL {
        let mut sum = 0.0;
        for code in 0..256_usize {
            let order: Vec<usize> = (0..4).map(|i| code >> (2 * i) & 3).collect();
            match person(judge).order_probability(&looks, &order, AT) {
                Ok(p) => sum += p,
                Err(error) => assert!(matches!(error, JudgeError::Order { .. })),
            }
        }
        assert!((sum - 1.0).abs() < 1e-5, "{judge:?}: {sum}");
    }
}

/// Four thousand drawn answers of each judge: each share within 4.5 standard errors of its probability.
#[test]
fn drawn_answers_have_these_probabilities() {
    const DRAWN: usize = 4000;
    let golden = golden();
    let all = golden["choices"][4]["alternatives"].as_array().unwrap();
    let alternatives: Vec<Cues> = all.iter().map(|v| real(cues(v))).collect();
    let presented = cues(&golden["choices"][0]["presented"]);
    for judge in Judge::ALL {
        let person = person(judge);
        let mut random = Random::stream(3, 1, judge.name());
        let mut draw = || random.normal();
        for count in 1..=4 {
            let mut looks: Vec<Look<'_>> = alternatives[..count].iter().map(Look::of).collect();
            if count == 4 {
                // The same twice, and a bias.
                looks[3] = looks[0];
                looks[2].bias = 0.1;
            }
            let at = (Recall::Remembered, AT);
            let shares = person
                .choice_probabilities(Look::of(&presented), &looks, at)
                .unwrap();
            let mut counts = vec![0; count];
            let mut orders = 0;
            let order: Vec<usize> = (0..count).collect();
            for _ in 0..DRAWN {
                let place = person.associate(Look::of(&presented), &looks, at, &mut draw);
                counts[place.unwrap()] += 1;
                orders += usize::from(person.order(&looks, AT, &mut draw).unwrap() == order);
            }
            let of_order = person.order_probability(&looks, &order, AT).unwrap();
            let pairs = counts.into_iter().zip(shares).chain([(orders, of_order)]);
            for (found, p) in pairs {
                let reach = 4.5 * (DRAWN as f64 * p * (1.0 - p)).sqrt() + 2e-3 * DRAWN as f64;
                let expected = p * DRAWN as f64;
                assert!(
                    (found as f64 - expected).abs() <= reach,
                    "{judge:?} of {count}: {found} {expected}"
                );
            }
        }
        let pair = [Look::of(&alternatives[0]), Look::of(&alternatives[1])];
        let p = person.first_rougher_probability(pair, AT).unwrap();
        let first = (0..DRAWN)
            .filter(|_| person.rougher(pair, AT, &mut draw).unwrap() == 0)
            .count();
        let reach = 4.5 * (DRAWN as f64 * p * (1.0 - p)).sqrt();
        assert!(
            (first as f64 - p * DRAWN as f64).abs() <= reach,
            "{judge:?}"
        );
    }
}

#[test]
fn more_looks_choose_better_and_fatigue_worse() {
    let alternatives = [0.3, 0.4].map(|level| real(rendered(level, [-7.0; CUE_BANDS])));
    let presented = rendered(0.3, [-7.0; CUE_BANDS]);
    let right = |looks: f64, judgement: u32, recall: Recall| {
        let all = alternatives.each_ref().map(Look::of);
        let presented = Look {
            looks,
            ..Look::of(&presented)
        };
        let at = (recall, Moment { judgement });
        person(Judge::Thurstone)
            .choice_probabilities(presented, &all, at)
            .unwrap()[0]
    };
    let usual = right(9.0, 40, Recall::Touched);
    assert!(right(18.0, 40, Recall::Touched) > usual);
    assert!(right(9.0, 400, Recall::Touched) < usual);
    assert!(right(9.0, 40, Recall::Remembered) < usual);
    assert!(right(9.0, 0, Recall::Touched) < usual);
}

#[test]
fn what_cannot_be_judged_is_refused() {
    let usual = rendered(0.0, [-7.0; CUE_BANDS]);
    let mut draw = || 0.0;
    let one = person(Judge::LevelOnly);
    let at = (Recall::Touched, AT);
    let none = one.associate(Look::of(&usual), &[], at, &mut draw);
    assert!(matches!(none, Err(JudgeError::TooFew { .. })));
    let other = Cues {
        band: Band::new(Hertz(20.0), Hertz(500.0)).unwrap(),
        ..usual.clone()
    };
    let bands = one.associate(Look::of(&usual), &[Look::of(&other)], at, &mut draw);
    assert!(matches!(bands, Err(JudgeError::Bands { .. })));
    let silent = rendered(f64::NEG_INFINITY, [-7.0; CUE_BANDS]);
    let refused = one.order(&[Look::of(&silent)], AT, &mut draw);
    assert!(matches!(
        refused,
        Err(JudgeError::NotFinite { place: 0, .. })
    ));
    let twice = one.order_probability(&[Look::of(&usual), Look::of(&usual)], &[0, 0], AT);
    assert!(matches!(twice, Err(JudgeError::Order { .. })));
    assert!(one.categorise(Look::of(&usual), 0, AT, &mut draw).is_err());
}

/// With all draws 0 and no lapse the answers are those of the means.
#[test]
fn without_noise_answers_follow_the_cues() {
    let mut draw = || 0.0;
    let usual = [-7.0; CUE_BANDS];
    let smooth = rendered(0.9, usual).on(OnSurface {
        period_m: 1e-5,
        pattern: Pattern::Random,
        friction: Some(1.5),
    });
    let coarse = rendered(0.0, usual).on(OnSurface {
        period_m: 5e-4,
        pattern: Pattern::Random,
        friction: None,
    });
    let fine = real(rendered(0.1, usual));
    let looks = [&smooth, &fine, &coarse].map(Look::of);
    // 0.15·ln 5 = 0.24 lifts the coarse one above the fine one; the sticky one is last.
    let order = |judge| person(judge).order(&looks, AT, &mut || 0.0).unwrap();
    assert_eq!(order(Judge::Thurstone), [2, 1, 0]);
    assert_eq!(order(Judge::LevelOnly), [0, 1, 2]);
    let thurstone = person(Judge::Thurstone);
    let [_, one, other] = looks;
    assert_eq!(
        thurstone.same([one, other], AT, &mut draw),
        Ok(super::super::Sameness::Same)
    );
    assert_eq!(
        thurstone.same([Look::of(&smooth), other], AT, &mut draw),
        Ok(super::super::Sameness::Different)
    );
    // 0.1 lies at 2.1/3 of the scale from −2 to 1: 7 of 0 to 10, and the first of three categories.
    assert_eq!(thurstone.rate(one, [0, 10], AT, &mut draw), Ok(7));
    assert_eq!(thurstone.categorise(one, 3, AT, &mut draw), Ok(0));
    // Regular patterns are told apart by spectrum, random surfaces by level.
    let shifted = [-4.0, -10.0, -4.0, -10.0, -7.0];
    let presented = rendered(0.0, usual);
    let nearest = |pattern: Pattern| {
        let on = |cues: Cues| {
            cues.on(OnSurface {
                period_m: 5e-4,
                pattern,
                friction: None,
            })
        };
        let all = [on(rendered(0.15, usual)), on(rendered(0.0, shifted))];
        let looks = all.each_ref().map(Look::of);
        let at = (Recall::Touched, AT);
        thurstone.associate(Look::of(&presented), &looks, at, &mut || 0.0)
    };
    // Level: (0.15/0.085)² = 3.1; spectrum: 4/5·(3/2.5)² = 1.15, or 4.6 among patterns.
    assert_eq!(nearest(Pattern::Random), Ok(1));
    assert_eq!(nearest(Pattern::Regular), Ok(0));
}
