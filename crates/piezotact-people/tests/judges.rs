//! Which judge it was: campaigns of ten people who judge thirteen sandpapers, answered by a known judge.

use std::collections::BTreeMap;

use piezotact::quantity::{Band, Hertz};
use piezotact::statistics::random::Random;
use piezotact_people::judge::{
    Answers, Bounds, CUE_BANDS, ChoiceAnswer, Cues, Judge, Look, Moment, OnSurface, OrderAnswer,
    Pattern, Person, Recall, Touch, TouchedTexture, Verdict, Which, which_judge,
};

/// The sets of three of the thesis' Table 5, from 0 = S1.
const SETS: [[usize; 3]; 13] = [
    [1, 3, 7],
    [4, 6, 8],
    [5, 10, 9],
    [0, 2, 12],
    [4, 7, 11],
    [4, 8, 9],
    [1, 2, 3],
    [0, 7, 12],
    [0, 6, 11],
    [3, 12, 9],
    [3, 7, 8],
    [9, 10, 8],
    [12, 11, 9],
];
/// rms in m/s² and mean grain in µm: levels of the twin's S1 to S13, FEPA grains.
const PAPERS: [(f64, f64); 13] = [
    (2.00, 425.0),
    (1.63, 269.0),
    (1.60, 201.0),
    (1.47, 125.0),
    (1.24, 82.0),
    (1.05, 58.5),
    (0.90, 35.0),
    (0.74, 25.8),
    (0.70, 21.8),
    (0.65, 5.5),
    (0.61, 10.3),
    (0.63, 8.4),
    (0.60, 18.3),
];

/// Who answers.
#[derive(Clone, Copy, PartialEq)]
enum By {
    Judge(Judge),
    /// By the sum of absolute steps in level and bands, with double-exponential noise on every distance.
    CityBlock,
    /// The first alternative in half of the choices, else as `Thurstone`.
    FirstOften,
    /// The alternative that is farthest in level.
    Farthest,
    /// The strongest alternative, whatever was presented.
    Strongest,
}

struct World {
    people: usize,
    /// The standard deviation of a paper's own level in each band, dB.
    shapes_db: f64,
}

const TWIN_LIKE: World = World {
    people: 10,
    shapes_db: 1.2,
};

fn real(cues: Cues, grain_um: f64) -> Cues {
    cues.on(OnSurface {
        period_m: grain_um * 1e-6,
        pattern: Pattern::Random,
        friction: Some(0.7),
    })
}

/// A campaign: for each person one order of all, then for each set an order and a sequence of three or four.
fn campaign(world: &World, by: By, seed: u64) -> Answers {
    let mut answers = Answers::default();
    let mut common = Random::stream(seed, 0, "papers");
    // The finger's ridges and the broad spectrum, and what is the paper's own.
    let broad = [-10.0, -6.2, -4.6, -7.0, -12.0];
    let papers: Vec<[f64; CUE_BANDS]> = (0..13)
        .map(|s| {
            let ridges = if s < 4 { 1.0 } else { 0.3 };
            let step = [-1.5, 1.8, -0.3, -1.0, -1.5].map(|db| ridges * db);
            std::array::from_fn(|b| broad[b] + step[b] + world.shapes_db * common.normal())
        })
        .collect();
    for number in 1..=world.people as u64 {
        let mut own = Random::stream(seed, number, "person");
        let finger: [f64; CUE_BANDS] = std::array::from_fn(|_| 1.5 * own.person());
        let loudness = 0.15 * own.person();
        let felt: Vec<Cues> = (0..13)
            .map(|s| Cues {
                band: Band::new(Hertz(20.0), Hertz(1000.0)).unwrap(),
                ln_rms: PAPERS[s].0.ln() + loudness + 0.05 * own.person(),
                bands_db: std::array::from_fn(|b| papers[s][b] + finger[b] + 0.4 * own.normal()),
                ln_centroid: 0.0,
                surface: None,
            })
            .map(with_centroid)
            .collect();
        let reals: Vec<Cues> = (0..13)
            .map(|s| real(felt[s].clone(), PAPERS[s].1))
            .collect();
        let rendered: Vec<Cues> = felt
            .iter()
            .map(|cues| Cues {
                ln_rms: cues.ln_rms + 0.05 * own.normal(),
                bands_db: cues.bands_db.map(|db| db + 0.4 * own.normal()),
                ..cues.clone()
            })
            .map(with_centroid)
            .collect();
        let touch = Touch {
            lapse_share: 0.01 + 0.01 * own.uniform(),
            ..Touch::mean_person().with_noise((0.2 * own.person()).exp())
        };
        let bias: Vec<f64> = (0..13).map(|_| touch.texture_bias * own.person()).collect();
        let judge = match by {
            By::Judge(judge) => judge,
            _ => Judge::Thurstone,
        };
        let person = Person { judge, touch };
        let participant = format!("P{number:02}");
        let mut noise = Random::stream(seed, number, "answers");
        let mut judgement = 0;
        let mut order_of = |set: &[usize], answers: &mut Answers, moment: u32| {
            let looks: Vec<Look<'_>> = set
                .iter()
                .map(|s| Look {
                    bias: bias[*s],
                    ..Look::of(&reals[*s])
                })
                .collect();
            let moment = Moment { judgement: moment };
            let mut draw = || noise.normal();
            answers.orders.push(OrderAnswer {
                participant: participant.clone(),
                moment,
                textures: set
                    .iter()
                    .map(|s| TouchedTexture::of(reals[*s].clone()))
                    .collect(),
                order: person.order(&looks, moment, &mut draw).unwrap(),
            });
        };
        order_of(&(0..13).collect::<Vec<usize>>(), &mut answers, 0);
        for (i, set) in SETS.iter().enumerate() {
            order_of(set, &mut answers, 1 + i as u32);
        }
        let mut sequences = Random::stream(seed, number, "sequences");
        for set in SETS {
            let length = if sequences.uniform() < 0.5 { 3 } else { 4 };
            for _ in 0..length {
                let s = set[((sequences.uniform() * 3.0) as usize).min(2)];
                let looks = set.map(|s| Look {
                    bias: bias[s],
                    ..Look::of(&reals[s])
                });
                let moment = Moment {
                    judgement: 14 + judgement,
                };
                judgement += 1;
                let presented = Look::of(&rendered[s]);
                let mut draw = || noise.normal();
                let chosen = match by {
                    By::Judge(_) => person
                        .associate(presented, &looks, (Recall::Touched, moment), &mut draw)
                        .unwrap(),
                    By::FirstOften if draw() < 0.0 => 0,
                    By::FirstOften => person
                        .associate(presented, &looks, (Recall::Touched, moment), &mut draw)
                        .unwrap(),
                    By::CityBlock => smallest(|j| {
                        let level = (presented.cues.ln_rms - looks[j].cues.ln_rms).abs() / 0.085;
                        let bands: f64 = (0..CUE_BANDS)
                            .map(|b| {
                                (presented.cues.bands_db[b] - looks[j].cues.bands_db[b]).abs() / 2.5
                            })
                            .sum();
                        let (sign, size) = (draw(), draw());
                        // Double exponential: the logarithm of a uniform number, with a sign.
                        let size = -(1.0 - 0.5 * (1.0 + erf(size))).max(1e-12).ln();
                        level + bands + 0.8 * size * sign.signum()
                    }),
                    By::Farthest => {
                        smallest(|j| -(presented.cues.ln_rms - looks[j].cues.ln_rms).abs())
                    }
                    By::Strongest => smallest(|j| -looks[j].cues.ln_rms),
                };
                answers.choices.push(ChoiceAnswer {
                    participant: participant.clone(),
                    moment,
                    presented: TouchedTexture::of(rendered[s].clone()),
                    alternatives: set
                        .iter()
                        .map(|s| TouchedTexture::of(reals[*s].clone()))
                        .collect(),
                    recall: Recall::Touched,
                    chosen,
                });
            }
        }
    }
    answers
}

/// erf(x/√2) by Abramowitz and Stegun 7.1.26, to 1.5e-7.
fn erf(x: f64) -> f64 {
    let z = x.abs() / std::f64::consts::SQRT_2;
    let t = 1.0 / (1.0 + 0.327_591_1 * z);
    let poly = ((((1.061_405_429 * t - 1.453_152_027) * t + 1.421_413_741) * t - 0.284_496_736)
        * t
        + 0.254_829_592)
        * t;
    (1.0 - poly * (-z * z).exp()) * x.signum()
}

fn with_centroid(cues: Cues) -> Cues {
    let power = cues.bands_db.map(|db| 10f64.powf(db / 10.0));
    let sum: f64 = power.iter().sum();
    let centre = |b: usize| (31.25 * std::f64::consts::SQRT_2 * 2f64.powi(b as i32)).ln();
    let ln_centroid = (0..CUE_BANDS).map(|b| power[b] / sum * centre(b)).sum();
    Cues {
        ln_centroid,
        ..cues
    }
}

fn smallest(mut of: impl FnMut(usize) -> f64) -> usize {
    let all = [of(0), of(1), of(2)];
    (0..3).min_by(|a, b| all[*a].total_cmp(&all[*b])).unwrap()
}

fn verdict(world: &World, by: By, seed: u64) -> Which {
    let answers = campaign(world, by, seed);
    which_judge(&answers, &Touch::mean_person(), Bounds::of_campaigns()).unwrap()
}

/// How often each verdict comes in `campaigns` campaigns.
fn counted(world: &World, by: By, campaigns: u64) -> BTreeMap<String, usize> {
    let mut counts = BTreeMap::new();
    for seed in 1..=campaigns {
        let which = verdict(world, by, seed);
        let name = match which.verdict {
            Verdict::Named { judge } => judge.name().to_owned(),
            other => format!("{other:?}"),
        };
        if std::env::var("JUDGES").is_ok() {
            let best = &which.judges[0];
            println!(
                "{seed} {name}: best {:?} {:?} weight {:.3}",
                best.judge, best.parameters, best.weight
            );
            for c in &which.criteria {
                println!(
                    "   {:?} {:?} {:?} {:?}",
                    c.what, c.found, c.interval, c.outcome
                );
            }
            for c in &which.fit {
                println!(
                    "      {:?} {:.3?} {:.3?} {:?}",
                    c.what, c.found, c.interval, c.outcome
                );
            }
        }
        *counts.entry(name).or_default() += 1;
    }
    counts
}

#[test]
#[ignore]
fn look() {
    let n: u64 = std::env::var("N").map_or(4, |n| n.parse().unwrap());
    let shapes_db: f64 = std::env::var("SHAPES").map_or(1.2, |n| n.parse().unwrap());
    let world = World {
        shapes_db,
        ..TWIN_LIKE
    };
    for judge in Judge::ALL {
        println!("{judge:?} {:?}", counted(&world, By::Judge(judge), n));
    }
    for (name, by) in [
        ("city", By::CityBlock),
        ("first", By::FirstOften),
        ("farthest", By::Farthest),
        ("strongest", By::Strongest),
    ] {
        println!("{name} {:?}", counted(&world, by, n));
    }
}
