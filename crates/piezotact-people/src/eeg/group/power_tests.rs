//! Tasks whose baselines, windows or both differ: own EEG, whose power is known at every time.

use super::*;
use crate::eeg::epochs::Epochs;
use crate::eeg::erd::Order;
use crate::eeg::person::tests::{config as of_person, prepared};
use crate::eeg::person::{Positions, person};
use crate::eeg::prepare::Prepared;
use crate::eeg::source::Subject;
use piezotact::page::Shown as _;
use piezotact::statistics::random::Random;

const CHANNELS: [&str; 3] = ["C3", "Cz", "C4"];
const EPOCHS: usize = 14;
const PEOPLE: u64 = 10;

/// Epochs of alpha whose level over the time from the marker is `level_db`, in noise; the same generator of chance for one `seed`.
fn epochs(level_db: &dyn Fn(f64) -> f64, seed: u64) -> Prepared {
    let made = prepared(&CHANNELS, EPOCHS, seed);
    let (own, mut random) = (&made.epochs, Random::stream(seed, 0, "own EEG"));
    let mut volts = Vec::new();
    for _ in 0..CHANNELS.len() * EPOCHS {
        let (mut re, mut im) = (0.0, 0.0);
        for sample in 0..own.samples() + 200 {
            // An amplitude that wanders over about 0.3 s, settled before the epoch begins.
            re = 0.975 * re + 0.22 * random.normal();
            im = 0.975 * im + 0.22 * random.normal();
            let noise = random.normal();
            if let Some(at) = sample.checked_sub(200) {
                let t = own.time_s(at);
                let gain = 10f64.powf(level_db(t) / 20.0);
                let phase = std::f64::consts::TAU * 10.0 * t;
                volts.push(
                    1e-5 * gain * (re * phase.cos() - im * phase.sin()) + 1e-6 * gain * noise,
                );
            }
        }
    }
    let names = own.channels().to_vec();
    let conditions = own.conditions().to_vec();
    let epochs = Epochs::new(names, conditions, own.rate(), own.first_s(), volts).unwrap();
    Prepared { epochs, ..made }
}

/// The level over time of one task, dB.
type Level = fn(f64) -> f64;

fn flat(_: f64) -> f64 {
    0.0
}

/// The document of a person in a task.
fn document(participant: &str, task: &str, prepared: &Prepared) -> EegErd {
    let subject = Subject {
        participant: participant.into(),
        task: task.into(),
    };
    let (name, config) = (subject.to_string(), of_person(Order::PowerFirst));
    person(&name, &subject, prepared, &Positions::OfNames, &config).unwrap()
}

/// A study of ten people in two tasks, whose levels scatter by 4 dB over people, and by `own_db` in each baseline and window.
fn study(levels: [Level; 2], own_db: f64, seed: u64) -> Vec<EegErd> {
    let mut documents = Vec::new();
    for who in 0..PEOPLE {
        let mut random = Random::stream(seed, who, "people");
        let of_person_db = 4.0 * random.normal();
        for (task, level) in ["control", "natural"].into_iter().zip(levels) {
            let [before, after] = [0, 1].map(|_| own_db * random.normal());
            let at = |t: f64| of_person_db + level(t) + if t < -0.1 { before } else { after };
            let number = 1000 * seed + 2 * who + u64::from(task == "natural");
            documents.push(document(&format!("P{who:02}"), task, &epochs(&at, number)));
        }
    }
    documents
}

fn compared(documents: &[EegErd], unit: Mode) -> EegStats {
    let config = GroupConfig {
        unit,
        gradient: ["control", "natural"].map(String::from).to_vec(),
        margin: None,
        neighbours_deg: 35.0,
        flips: 512,
        seed: 1,
    };
    compare(documents, &config).unwrap()
}

/// How often in the contrasts of a study the changes differ, and how often this is decided.
fn counts(found: &EegStats) -> [usize; 2] {
    let differ = |one: &&TaskContrast| one.p_holm.unwrap() <= LEVEL;
    let decided = |one: &&TaskContrast| one.outcome() == Outcome::Met;
    [
        found.contrasts.iter().filter(differ).count(),
        found.contrasts.iter().filter(decided).count(),
    ]
}

#[test]
fn a_difference_of_baselines_alone_is_not_decided() {
    baselines_alone_are_not_decided_in(1);
}

#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_a_difference_of_baselines_alone_is_not_decided() {
    baselines_alone_are_not_decided_in(4);
}

fn baselines_alone_are_not_decided_in(studies: u64) {
    let of_natural: [(&str, Level); 4] = [
        ("above", |t| if t < -0.1 { 3.0 } else { 0.0 }),
        ("below", |t| if t < -0.1 { -3.0 } else { 0.0 }),
        // Ramps that end where the window begins.
        ("falling", |t| 4.0 * (-t).clamp(0.0, 2.0)),
        ("rising", |t| -4.0 * (-t).clamp(0.0, 2.0)),
    ];
    for (name, level) in of_natural {
        let (mut contrasts, mut clusters) = (0, 0);
        for seed in 0..studies {
            let documents = study([flat, level], 0.4, seed);
            for unit in [Mode::Percent, Mode::Decibels] {
                let found = compared(&documents, unit);
                let [differ, decided] = counts(&found);
                assert_eq!(differ, 2, "{name}");
                contrasts += decided;
                for one in &found.contrasts {
                    assert!(one.baseline.unwrap().difference.p_value < 0.001);
                    let open = one.outcome() == Outcome::NotDecided;
                    assert_eq!(one.may_be_of_baselines(), open, "{name}");
                    assert_eq!(one.criteria[0].outcome, one.outcome());
                    // A step of an order is as certain as its contrast.
                    let mut steps = found.gradients.iter();
                    let step = steps.find(|step| step.region == one.region).unwrap();
                    assert!(!open || step.outcome() == Outcome::NotDecided, "{name}");
                }
                let one = &found.clusters[0];
                assert!(one.p_holm <= LEVEL, "{name}: {}", one.p_holm);
                clusters += usize::from(one.outcome() == Outcome::Met);
                let page = format!("{:?}", found.page());
                let said =
                    page.contains("the baselines, or noise in one task, may be all that differs");
                assert!(said || decided > 0, "{name}");
            }
        }
        // Of four contrasts of each study, in two units, and two clusters: chance of a window, at 5 %.
        assert!(
            contrasts <= studies as usize && 2 * clusters <= studies as usize,
            "{name}: {contrasts} {clusters}"
        );
    }
}

#[test]
fn noise_in_one_task_alone_is_no_difference() {
    noise_in_one_task_alone_is_no_difference_in(4);
}

#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_noise_in_one_task_alone_is_no_difference() {
    noise_in_one_task_alone_is_no_difference_in(12);
}

fn noise_in_one_task_alone_is_no_difference_in(studies: usize) {
    // The same desynchronisation of alpha in both tasks; background of 3.5 times its amplitude is added in one.
    let level: Level = |t| if t < -0.1 { 0.0 } else { -4.0 };
    let (mut differ, mut decided, mut clusters) = (0, 0, 0);
    for seed in (100..).take(studies) {
        let mut documents = Vec::new();
        for who in 0..PEOPLE {
            let mut random = Random::stream(seed, who, "background");
            let [quiet, other] = [0, 100].map(|task| epochs(&level, 5000 * seed + task + who));
            let noisy = changed(&other, |_, volts| {
                let background = volts.iter_mut();
                background.for_each(|v| *v += 3.5e-5 * random.normal());
            });
            for (task, made) in [("control", quiet), ("natural", noisy)] {
                documents.push(document(&format!("P{who:02}"), task, &made));
            }
        }
        let found = compared(&documents, Mode::Percent);
        let [one, other] = counts(&found);
        (differ, decided) = (differ + one, decided + other);
        clusters += usize::from(found.clusters[0].outcome() == Outcome::Met);
    }
    // Of two contrasts of each study.
    assert!(differ >= studies, "{differ}");
    assert!(
        4 * decided <= studies && 6 * clusters <= studies,
        "{decided} {clusters}"
    );
}

/// The second task desynchronises by 2 dB more, and background hides it.
#[test]
fn noise_in_one_task_makes_tasks_not_alike() {
    let lower: Level = |t| if t < -0.1 { 0.0 } else { -4.0 };
    let lowest: Level = |t| if t < -0.1 { 0.0 } else { -6.0 };
    for (level, noise_v) in [(lower, 0.0), (lowest, 2e-5)] {
        let mut documents = Vec::new();
        for who in 0..PEOPLE {
            let mut random = Random::stream(7, who, "background");
            let other = epochs(&level, 900 + who);
            let noisy = changed(&other, |_, volts| {
                volts
                    .iter_mut()
                    .for_each(|v| *v += noise_v * random.normal());
            });
            for (task, made) in [("control", epochs(&lower, 700 + who)), ("natural", noisy)] {
                documents.push(document(&format!("P{who:02}"), task, &made));
            }
        }
        let config = GroupConfig {
            unit: Mode::Decibels,
            gradient: Vec::new(),
            margin: Some(3.0),
            neighbours_deg: 35.0,
            flips: 64,
            seed: 1,
        };
        let found = compare(&documents, &config).unwrap();
        for one in &found.contrasts {
            // The interval lies within the margin, and the baselines differ where noise was added.
            let [low, high] = one.contrast.unwrap().difference.interval;
            assert!(-3.0 < low && high < 3.0, "{noise_v}: {low} {high}");
            let differ = one.baseline.unwrap().difference.p_value <= LEVEL;
            assert!(differ || noise_v == 0.0);
            let expected = match differ {
                true => Outcome::NotDecided,
                false => Outcome::Met,
            };
            assert_eq!(one.within_margin(), Some(expected), "{noise_v}");
        }
    }
}

#[test]
fn a_difference_of_windows_holds_as_often_as_before() {
    let lower: Level = |t| if t < -0.1 { 0.0 } else { -2.8 };
    let mut sums = [0; 2];
    let mut clusters = 0;
    for seed in 20..30 {
        let found = compared(&study([lower, flat], 1.0, seed), Mode::Percent);
        for (sum, count) in sums.iter_mut().zip(counts(&found)) {
            *sum += count;
        }
        let one = &found.clusters[0];
        clusters += i32::from(one.outcome() == Outcome::Met) - i32::from(one.p_holm <= LEVEL);
    }
    // Nine in ten of those that differed without looking at the power.
    assert!(sums[0] >= 10 && 10 * sums[1] >= 9 * sums[0], "{sums:?}");
    assert!(clusters >= -1, "{clusters}");
}

#[test]
fn tasks_that_are_alike_seldom_differ() {
    tasks_that_are_alike_seldom_differ_in(4);
}

#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_tasks_that_are_alike_seldom_differ() {
    tasks_that_are_alike_seldom_differ_in(12);
}

fn tasks_that_are_alike_seldom_differ_in(studies: usize) {
    let mut sums = [0; 2];
    for seed in (40..).take(studies) {
        let found = compared(&study([flat, flat], 1.0, seed), Mode::Percent);
        for (sum, count) in sums.iter_mut().zip(counts(&found)) {
            *sum += count;
        }
        assert!(
            found.clusters[0].outcome() == Outcome::NotDecided || found.clusters[0].p_holm <= LEVEL
        );
    }
    // Of 24 contrasts, at 5 % more than 4 have a probability below 1 %; of 8, more than 2 one of 1 %.
    assert!(3 * sums[0] <= studies + 2 && sums[1] <= sums[0], "{sums:?}");
}

#[test]
fn power_stands_beside_the_changes() {
    let documents = study([flat, flat], 0.4, 60);
    let change = &documents[0].regions[0];
    let ratio = change.window_power_v2 / change.baseline_power_v2;
    assert!((10.0 * ratio.log10() - change.decibels).abs() < 1e-9);
    let found = compared(&documents, Mode::Decibels);
    let own = &found.changes[0];
    let levels: Vec<f64> = own.people.iter().map(|one| one.baseline_db).collect();
    assert_eq!(own.baseline, PowerLevel::of(&levels));
    // People were made to differ by 4 dB.
    assert!((2.0..7.0).contains(&own.baseline.sd_db.unwrap()));
    // A contrast of changes in dB is that of the windows less that of the baselines.
    for one in &found.contrasts {
        let of = |found: Option<Contrast>| found.unwrap().difference.mean;
        let difference = of(one.window) - of(one.baseline);
        assert!((of(one.contrast) - difference).abs() < 1e-9);
    }
}

/// The same recording as that of `made`, with other values in its epochs of all channels (channels × epochs × samples).
fn changed(made: &Prepared, change: impl FnOnce(&Epochs, &mut Vec<f64>)) -> Prepared {
    let own = &made.epochs;
    let mut volts = own.volts().to_vec();
    change(own, &mut volts);
    let names = own.channels().to_vec();
    let count = volts.len() / names.len() / own.samples();
    let conditions = own.conditions()[..count].to_vec();
    let epochs = Epochs::new(names, conditions, own.rate(), own.first_s(), volts).unwrap();
    Prepared {
        epochs,
        ..made.clone()
    }
}

/// The epochs without the one at `without`, each shifted by `shift` samples.
fn cut_again(own: &Epochs, without: usize, shift: usize) -> Vec<f64> {
    let channels = own.volts().chunks_exact(own.count() * own.samples());
    let epochs = channels.flat_map(|channel| {
        let epochs = channel.chunks_exact(own.samples()).enumerate();
        epochs.filter(move |(at, _)| *at != without)
    });
    let shifted = epochs.flat_map(|(_, signal)| [&signal[shift..], &signal[..shift]].concat());
    shifted.collect()
}

#[test]
fn a_recording_is_found_again_however_it_was_changed() {
    let level = |_: f64| 0.0;
    let made = epochs(&level, 7000);
    let honest = study([flat, flat], 0.4, 80);
    // Twenty recordings of the same tasks: 190 pairs, none of them called a copy.
    let asked = |documents: &[EegErd]| {
        let config = GroupConfig {
            unit: Mode::Percent,
            gradient: Vec::new(),
            margin: None,
            neighbours_deg: 35.0,
            flips: 64,
            seed: 1,
        };
        compare(documents, &config)
    };
    let with = |others: Vec<EegErd>| asked(&[honest.clone(), others].concat());
    let original = document("P90", "control", &made);
    assert!(with(vec![original.clone()]).is_ok());
    let mut random = Random::stream(3, 0, "noise");
    let copies = [
        ("the same", made.clone()),
        (
            "another reference",
            changed(&made, |own, volts| {
                let each = own.count() * own.samples();
                let all = volts.clone();
                for (i, value) in volts.iter_mut().enumerate() {
                    *value -= 0.5 * (all[i % each] + all[each + i % each]);
                }
            }),
        ),
        (
            "another scale",
            changed(&made, |_, volts| volts.iter_mut().for_each(|v| *v *= 0.37)),
        ),
        (
            "10 % of noise",
            changed(&made, |_, volts| {
                volts.iter_mut().for_each(|v| *v += 1e-6 * random.normal());
            }),
        ),
        (
            "one epoch fewer",
            changed(&made, |own, volts| *volts = cut_again(own, 6, 0)),
        ),
        (
            "one epoch fewer, markers 70 ms later, rescaled",
            changed(&made, |own, volts| {
                *volts = cut_again(own, 2, 9).iter().map(|v| 2.0 * v).collect();
            }),
        ),
    ];
    for (name, copy) in copies {
        let copy = document("P91", "control", &copy);
        let likeness = original.trace.likeness(&copy.trace);
        assert!(likeness > 0.65, "{name}: {likeness}");
        let said = with(vec![original.clone(), copy]).unwrap_err().to_string();
        assert!(said.contains("P90") && said.contains("P91"), "{said}");
        assert!(said.contains("are the same recording"), "{said}");
    }
    let mut largest = 0.0f64;
    for (i, one) in honest.iter().enumerate() {
        for other in &honest[..i] {
            largest = largest.max(one.trace.likeness(&other.trace));
        }
    }
    assert!(largest < 0.45, "{largest}");
}
