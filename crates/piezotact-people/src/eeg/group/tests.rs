use super::*;
use crate::eeg::cluster::Tried;
use crate::eeg::epochs::{Criterion as Rejecting, CutConfig};
use crate::eeg::erd::Order;
use crate::eeg::person::{Change, ChangeMap, NamedBand, Region, Smear, Trace};
use crate::eeg::prepare::{ChannelChoice, EpochCounts, PrepareConfig, Reference};
use crate::eeg::reference::Montage;
use crate::eeg::source::Subject;
use crate::eeg::tfr::TfrConfig;
use crate::eeg::warning::code_and_cause;
use crate::eeg::{EegWarning, ElectrodesFault, MarkersFault};
use piezotact::Warning;
use piezotact::page::Shown as _;
use piezotact::quantity::{Band, Hertz, SampleRate};
use piezotact::statistics::random::Random;

const CHANNELS: [&str; 9] = ["C3", "C1", "Cz", "C2", "C4", "FC3", "FC4", "CP3", "CP4"];

/// The power in the baseline of all people.
const BASELINE_V2: f64 = 1e-10;

/// Epochs of a person that are those of no other one.
fn trace(participant: usize, task: &str) -> Trace {
    let mut random = Random::stream(participant as u64, 0, task);
    let mut levels = || {
        (0..100)
            .map(|_| (20.0 * random.normal()).round() as i16)
            .collect()
    };
    Trace {
        step_s: 0.02,
        epochs: (0..12).map(|_| levels()).collect(),
    }
}

/// Sets the change of `change`, %, at the same power in the baseline.
fn set(change: &mut Change, percent: f64) {
    change.percent = percent;
    change.window_power_v2 = BASELINE_V2 * (1.0 + percent / 100.0);
}

/// The document of a person whose alpha falls by `percent` in the window at C3 and its neighbours.
fn document(participant: usize, task: &str, percent: f64) -> EegErd {
    let names: Vec<String> = CHANNELS.map(String::from).to_vec();
    let montage = Montage::ten_ten(&names).unwrap();
    let surfaces = vec!["S1".to_owned(), "S2".to_owned()];
    let own = |place: &str, surface: &str| {
        let left = ["C3", "C1", "FC3", "CP3"].contains(&place);
        let offset = if surface == "S2" { 2.0 } else { 0.0 };
        let percent = if left { percent + offset } else { -1.0 };
        Change {
            surface: surface.into(),
            band: "alpha".into(),
            place: place.into(),
            percent,
            percent_interval: None,
            decibels: 10.0 * (1.0 + percent / 100.0).log10(),
            baseline_power_v2: BASELINE_V2,
            window_power_v2: BASELINE_V2 * (1.0 + percent / 100.0),
            bias_points: 0.1,
            epochs: 40,
        }
    };
    let times_s: Vec<f64> = (-10..=10).map(|i| f64::from(i) * 0.1).collect();
    let hz = [8.0, 10.0, 12.0, 20.0];
    let map = |surface: &String| {
        let mut decibels = Vec::new();
        for name in &names {
            for (f, _) in hz.iter().enumerate() {
                for (i, t) in times_s.iter().enumerate() {
                    let inside = f < 3 && *t > 0.0;
                    let wobble = 0.3 * ((participant * 7 + f * 3 + i) as f64).sin();
                    decibels.push(
                        wobble
                            + if inside {
                                own(name, surface).decibels
                            } else {
                                0.0
                            },
                    );
                }
            }
        }
        ChangeMap {
            surface: surface.clone(),
            decibels,
            baselines_db: vec![20.0; names.len() * hz.len()],
        }
    };
    EegErd {
        file: format!("P{participant:02}_{task}.vhdr"),
        subject: Subject {
            participant: format!("P{participant:02}"),
            task: task.into(),
        },
        preparation: PrepareConfig {
            markers: Vec::new(),
            task: None,
            extent: CutConfig {
                start_s: -2.0,
                end_s: 1.5,
            },
            channels: ChannelChoice::AllBut(Vec::new()),
            filters: Vec::new(),
            eog: Vec::new(),
            interpolated: Vec::new(),
            reference: Reference::Average,
            criteria: vec![Rejecting::PeakToPeak { above_v: 1e-4 }],
            min_epochs: 10,
        },
        config: PersonConfig {
            power: TfrConfig {
                frequencies_hz: hz.to_vec(),
                cycles: hz.map(|f| f / 2.0).to_vec(),
                decimation: 1,
            },
            step_s: 0.1,
            bands: vec![NamedBand {
                name: "alpha".into(),
                hz: Band::new(Hertz(8.0), Hertz(12.0)).unwrap(),
            }],
            regions: vec![Region {
                name: "C3".into(),
                channels: vec!["C3".into()],
            }],
            baseline_s: [-1.0, -0.4],
            window_s: [0.0, 0.8],
            order: Order::PowerFirst,
            min_epochs: 10,
        },
        rate_hz: SampleRate::new(500.0).unwrap(),
        counts: EpochCounts {
            conditions: Vec::new(),
            not_whole: Vec::new(),
            rejected: Vec::new(),
        },
        smears: vec![Smear {
            band: "alpha".into(),
            smear_s: 0.08,
        }],
        regions: surfaces.iter().map(|s| own("C3", s)).collect(),
        electrodes: surfaces
            .iter()
            .flat_map(|s| names.iter().map(|n| own(n, s)).collect::<Vec<_>>())
            .collect(),
        positions: names
            .iter()
            .zip(montage.positions)
            .map(|(name, position)| Electrode {
                name: name.clone(),
                position,
            })
            .collect(),
        channels: names.clone(),
        maps: surfaces.iter().map(map).collect(),
        surfaces,
        times_s,
        trace: trace(participant, task),
        warnings: Vec::new(),
    }
}

/// People in three tasks: control is most desynchronised, natural least; imagery is between them with a spread of its own.
fn documents(people: usize) -> Vec<EegErd> {
    (0..people)
        .flat_map(|i| {
            let own = 4.0 * ((i * 5) as f64).sin();
            let spread = 3.0 * ((i * 11) as f64).cos();
            [
                document(i, "control", -50.0 + own),
                document(i, "imagery", -38.0 + own + spread),
                document(i, "natural", -25.0 + own - spread),
            ]
        })
        .collect()
}

fn config() -> GroupConfig {
    GroupConfig {
        unit: Mode::Percent,
        gradient: ["control", "imagery", "natural"].map(String::from).to_vec(),
        margin: None,
        neighbours_deg: 35.0,
        flips: 1024,
        seed: 7,
    }
}

#[test]
fn a_gradient_of_tasks_is_found() {
    let found = compare(&documents(10), &config()).unwrap();
    assert_eq!((found.participants.len(), found.tasks.len()), (10, 3));
    let of_mean: Vec<_> = found.first_contrasts().collect();
    assert_eq!(of_mean.len(), 3);
    let first = of_mean[0];
    assert_eq!(first.tasks, ["control", "imagery"]);
    let difference = first.contrast.unwrap().difference;
    assert!(
        (difference.mean - 12.0).abs() < 2.0 && difference.pairs == 10,
        "{difference:?}"
    );
    assert_eq!(first.outcome(), Outcome::Met);
    assert!(first.p_holm.unwrap() >= difference.p_value);
    assert_eq!(found.gradients[0].outcome(), Outcome::Met);
    let clusters = &found.clusters[1];
    assert_eq!(clusters.tasks, ["control", "natural"]);
    // 2⁹ flips, all of them.
    assert_eq!((clusters.tried, clusters.flips), (Tried::All, 512));
    let largest = &clusters.clusters[0];
    assert!(largest.p_value < 0.05 && largest.mass > 0.0, "{largest:?}");
    assert_eq!(largest.hz, [8.0, 12.0]);
    assert!(
        largest.electrodes.contains(&"C3".to_owned())
            && !largest.electrodes.contains(&"C4".to_owned())
    );
    // Nothing is tested within the baseline.
    assert!(clusters.time_s[0] > -0.4);
    assert!(found.clusters[1].sentence().contains("all 512 sign flips"));
    let maps = found
        .scalps
        .iter()
        .filter(|one| matches!(one.shown, Shown::Difference(_)));
    assert_eq!(maps.count(), 3);
    assert!(found.warnings.is_empty(), "{:?}", found.warnings);
    let text = serde_json::to_string(&found).unwrap();
    assert_eq!(serde_json::from_str::<EegStats>(&text).unwrap(), found);
    assert!(found.page().sections.len() > 6);
}

#[test]
fn few_people_decide_nothing() {
    let found = compare(&documents(2), &config()).unwrap();
    assert!(
        found
            .contrasts
            .iter()
            .all(|one| one.outcome() == Outcome::NotDecided)
    );
    assert_eq!(found.gradients[0].outcome(), Outcome::NotDecided);
    assert!(
        found.contrasts[0]
            .sentence(Mode::Percent)
            .contains("at least 3 are needed")
    );
    let four = compare(&documents(4), &config()).unwrap();
    let cluster = &four.clusters[0].criteria[0];
    assert_eq!(cluster.outcome, Outcome::NotDecided);
    assert!(
        four.warnings
            .iter()
            .any(|warning| code_and_cause(warning) == "few/participants_of_clusters")
    );
}

#[test]
fn a_margin_shows_that_tasks_are_alike() {
    let mut documents = documents(10);
    // Two tasks that differ by a scatter of 0.4 points alone.
    for (i, document) in documents.iter_mut().enumerate() {
        for change in &mut document.regions {
            set(change, -40.0 + 0.4 * ((i / 3) as f64).sin());
        }
    }
    let of = |margin| {
        let asked = GroupConfig { margin, ..config() };
        compare(&documents, &asked).unwrap()
    };
    let first = |found: &EegStats| {
        let one = found.first_contrasts().next().unwrap();
        (one.outcome(), one.within_margin())
    };
    // Both tasks have the same number of each person: no spread, so nothing is decided, and why is said.
    assert_eq!(first(&of(None)), (Outcome::NotDecided, None));
    assert_eq!(first(&of(Some(5.0))).1, Some(Outcome::NotDecided));
    let said = of(Some(5.0)).contrasts[0].sentence(Mode::Percent);
    assert!(
        said.contains("the difference is the same in all 10 participants"),
        "{said}"
    );
    // A difference of 1 point that is certain, and of no interest.
    for (i, document) in documents.iter_mut().enumerate() {
        let is_imagery = document.subject.task == "imagery";
        for change in &mut document.regions {
            let more = f64::from(u8::from(is_imagery)) + 0.3 * (1.7 * i as f64).sin();
            set(change, change.percent + more);
        }
    }
    let of = |margin| {
        let asked = GroupConfig { margin, ..config() };
        compare(&documents, &asked).unwrap()
    };
    assert_eq!(first(&of(Some(5.0))), (Outcome::Met, Some(Outcome::Met)));
    let said = of(Some(5.0))
        .first_contrasts()
        .next()
        .unwrap()
        .sentence(Mode::Percent);
    assert!(
        said.contains("they differ, by less than the margin"),
        "{said}"
    );
    assert_eq!(first(&of(Some(0.2))), (Outcome::Met, Some(Outcome::NotMet)));
    // Control and natural do not differ.
    let apart = of(Some(5.0));
    let other = apart
        .first_contrasts()
        .find(|one| one.tasks == ["control", "natural"]);
    let other = other.unwrap();
    assert_eq!(
        (other.outcome(), other.within_margin()),
        (Outcome::NotDecided, Some(Outcome::Met))
    );
}

#[test]
fn the_order_of_documents_changes_nothing() {
    let all = documents(6);
    let mut turned = all.clone();
    turned.reverse();
    turned.swap(2, 9);
    assert_eq!(
        compare(&all, &config()).unwrap(),
        compare(&turned, &config()).unwrap()
    );
    // Without a claim tasks stand by name.
    let asked = GroupConfig {
        gradient: Vec::new(),
        ..config()
    };
    let found = compare(&turned, &asked).unwrap();
    assert_eq!(found.tasks, ["control", "imagery", "natural"]);
    // In the claimed order where there is a claim: the wrong one does not hold.
    let asked = GroupConfig {
        gradient: ["natural", "imagery", "control"].map(String::from).to_vec(),
        ..config()
    };
    let wrong = compare(&all, &asked).unwrap();
    assert_eq!(wrong.tasks[0], "natural");
    assert_eq!(wrong.gradients[0].outcome(), Outcome::NotMet);
}

#[test]
fn a_step_of_a_gradient_is_as_certain_as_its_contrast() {
    // Differences whose interval is above 0 alone, and which Holm does not decide beside the other pairs.
    let mut all = documents(10);
    for (i, document) in all.iter_mut().enumerate() {
        let person = (i / 3) as f64;
        let scatter = 4.0 * (2.3 * person).sin();
        for change in &mut document.regions {
            let percent = match document.subject.task.as_str() {
                "control" => -40.0,
                "imagery" => -37.9 + scatter,
                _ => -37.2 - 0.9 * scatter,
            };
            set(change, percent);
        }
    }
    let found = compare(&all, &config()).unwrap();
    for (contrast, step) in found
        .first_contrasts()
        .zip(&found.gradients[0].criteria)
        .take(1)
    {
        let difference = contrast.contrast.unwrap().difference;
        assert!(difference.interval[0] > 0.0, "{difference:?}");
        assert!(contrast.p_holm.unwrap() > LEVEL, "{contrast:?}");
        assert_eq!(step.outcome, contrast.outcome());
        assert_eq!(step.outcome, Outcome::NotDecided);
    }
    // Clusters are adjusted over the three pairs.
    let least: Vec<f64> = found
        .clusters
        .iter()
        .map(|one| one.clusters.first().map_or(1.0, |largest| largest.p_value))
        .collect();
    let adjusted: Vec<f64> = found.clusters.iter().map(|one| one.p_holm).collect();
    assert_eq!(adjusted, piezotact::statistics::holm(&least));
}

#[test]
fn one_person_or_recording_is_there_once() {
    let of = |change: &dyn Fn(&mut Vec<EegErd>)| {
        let mut all = documents(3);
        change(&mut all);
        compare(&all, &config()).map(|found| found.participants)
    };
    let named = |name: &'static str| {
        of(&move |all| {
            for document in &mut all[3..6] {
                document.subject.participant = name.into();
            }
        })
    };
    assert_eq!(named("sub-P01").unwrap(), ["P00", "P01", "P02"]);
    let said = named("p-2").unwrap_err().to_string();
    assert!(said.contains("P02 and p-2 differ only"), "{said}");
    let said = of(&|all| all[4].trace = all[1].trace.clone());
    let said = said.unwrap_err().to_string();
    assert!(
        said.contains("P00_imagery.vhdr") && said.contains("are the same recording"),
        "{said}"
    );
}

#[test]
fn unequal_numbers_of_epochs_are_said() {
    let mut all = documents(4);
    for document in &mut all {
        let epochs = if document.subject.task == "imagery" {
            12
        } else {
            60
        };
        for change in &mut document.electrodes {
            change.epochs = epochs;
        }
    }
    let found = compare(&all, &config()).unwrap();
    assert!(
        found
            .warnings
            .iter()
            .any(|warning| code_and_cause(warning) == "eeg_epochs/unequal")
    );
    // The bias of a percentage follows the number of epochs: nothing is decided in percent, and dB are free of it.
    assert!(found.withheld_sentence().is_some());
    let undecided = |one: &TaskContrast| one.outcome() == Outcome::NotDecided;
    assert!(found.contrasts.iter().all(undecided));
    assert_eq!(found.gradients[0].outcome(), Outcome::NotDecided);
    let in_db = GroupConfig {
        unit: Mode::Decibels,
        ..config()
    };
    let decibels = compare(&all, &in_db).unwrap();
    assert!(decibels.withheld_sentence().is_none());
    assert!(!decibels.contrasts.iter().all(undecided));
    let epochs: Vec<String> = (found.numbers().into_iter())
        .map(|one| format!("{}: {}", one.name, one.value))
        .collect();
    let task = |name: &str, count: usize| {
        format!("epochs of each participant and surface, {name}: {count}")
    };
    assert_eq!(
        epochs[1..],
        [
            task("control", 60),
            task("imagery", 12),
            task("natural", 60)
        ]
    );
}

#[test]
fn a_task_that_is_short_in_one_person_is_said() {
    let mut all = documents(4);
    for change in &mut all[4].electrodes {
        change.epochs = 12;
    }
    let found = compare(&all, &config()).unwrap();
    let said: Vec<String> = found.warnings.iter().map(ToString::to_string).collect();
    assert!(
        said.iter().any(|one| one.contains("imagery of P01 has 12")),
        "{said:?}"
    );
    // The others outweigh it: contrasts in percent are decided.
    assert!(found.withheld_sentence().is_none());
}

#[test]
fn documents_that_do_not_belong_together_are_refused() {
    let refused = |documents: &[EegErd], parts: &[&str]| {
        let text = compare(documents, &config()).unwrap_err().to_string();
        for part in parts {
            assert!(text.contains(part), "expected `{part}` in: {text}");
        }
    };
    let mut all = documents(3);
    refused(
        &all[..1],
        &["at least two tasks of a participant", "found 1"],
    );
    refused(&[], &["found 0"]);
    let twice = [all.clone(), vec![all[0].clone()]].concat();
    refused(
        &twice,
        &["participant P00, task control", "P00_control.vhdr"],
    );
    refused(&all[..2], &["`natural` in the claimed order"]);
    all[4].config.baseline_s = [-0.9, -0.4];
    refused(
        &all,
        &[
            "differ in baseline",
            "P00_control.vhdr (participant P00, task control) and P01_imagery.vhdr (participant P01, task imagery)",
        ],
    );
    let mut broken = documents(3);
    broken[1].maps[0].decibels.pop();
    refused(&broken, &["P00_imagery.vhdr", "found 755"]);
}

#[test]
fn who_and_what_is_left_out_is_said() {
    let mut all = documents(7);
    all.remove(4);
    let last = all.len() - 1;
    let document = &mut all[last];
    let each = document.config.power.frequencies_hz.len() * document.times_s.len();
    document.channels.remove(2);
    document.positions.remove(2);
    document.electrodes.retain(|change| change.place != "Cz");
    for map in &mut document.maps {
        map.decibels.drain(2 * each..3 * each);
        let hz = document.config.power.frequencies_hz.len();
        map.baselines_db.drain(2 * hz..3 * hz);
    }
    let found = compare(&all, &config()).unwrap();
    let codes: Vec<String> = found.warnings.iter().map(code_and_cause).collect();
    assert_eq!(
        codes,
        [
            "eeg_not_common/tasks",
            "eeg_not_common/electrodes",
            // Six people in a pair of tasks cannot decide over three pairs.
            "few/participants_of_clusters"
        ]
    );
    assert_eq!(found.electrodes.len(), 8);
    assert_eq!(found.contrasts[0].people.len(), 6);
}

#[test]
fn tasks_without_a_surface_in_common_are_refused() {
    let mut all = documents(3);
    for document in &mut all {
        let task = document.subject.task.clone();
        for surface in &mut document.surfaces {
            *surface = format!("{task} {surface}");
        }
    }
    let said = compare(&all, &config()).unwrap_err().to_string();
    assert!(
        said.contains("expected surfaces that two tasks share"),
        "{said}"
    );
    assert!(said.contains("natural: natural S1, natural S2"), "{said}");
}

#[test]
fn one_task_has_means_and_planned_contrasts_a_family_of_their_own() {
    let asked = GroupConfig {
        gradient: Vec::new(),
        ..config()
    };
    let of_one: Vec<EegErd> = documents(8)
        .into_iter()
        .filter(|one| one.subject.task == "control")
        .collect();
    let found = compare(&of_one, &asked).unwrap();
    assert!(found.contrasts.is_empty() && found.clusters.is_empty());
    let said = found.task_sentences();
    assert!(
        said[0].starts_with("control, mean of surfaces, C3, alpha: −49.7 %"),
        "{said:?}"
    );
    assert!(
        said[0].contains("(95 % −") && said[0].ends_with("n = 8"),
        "{said:?}"
    );
    assert!(!found.page().sections.is_empty());
    let document = documents(1).remove(0);
    let said = document
        .clone()
        .only(&["beta".into()], &[])
        .unwrap_err()
        .to_string();
    assert!(said.contains("among alpha, found `beta`"), "{said}");
    let same = document
        .clone()
        .only(&["alpha".into()], &["C3".into()])
        .unwrap();
    assert_eq!(same, document);
}

#[test]
fn surfaces_of_other_names_are_said() {
    let mut all = documents(5);
    for surface in &mut all[0].surfaces {
        *surface = format!("control/{surface}");
    }
    let document = &mut all[0];
    for (map, surface) in document.maps.iter_mut().zip(&document.surfaces) {
        map.surface.clone_from(surface);
    }
    let found = compare(&all, &config()).unwrap();
    let warning = found
        .warnings
        .iter()
        .find(|warning| code_and_cause(warning) == "eeg_not_common/surfaces");
    assert!(warning.is_some(), "{:?}", found.warnings);
}

#[test]
fn two_warnings_of_the_same_people_are_shown_as_two() {
    let of = |warning: EegWarning| {
        Warning::from(EegWarning::OfPeople {
            names: "P01, touch".into(),
            warning: warning.into(),
        })
    };
    let both = [
        of(EegWarning::Markers {
            fault: MarkersFault::Twice { count: 3 },
        }),
        of(EegWarning::Electrodes {
            names: "C3".into(),
            fault: ElectrodesFault::CalledBad,
        }),
    ];
    let shown = piezotact::warning::merged(&both);
    assert_eq!(shown.len(), 2, "{shown:?}");
    assert!(shown.iter().all(|one| one.warning.seen == 1), "{shown:?}");
    let twice = [both[0].clone(), both[0].clone()];
    assert_eq!(piezotact::warning::merged(&twice).len(), 1);
}

#[test]
fn a_difference_without_scatter_is_said() {
    let mut more = documents(4);
    for (person, group) in more.chunks_mut(3).enumerate() {
        for document in group {
            for change in &mut document.regions {
                let percent = match document.subject.task.as_str() {
                    "control" => -50.0,
                    "imagery" => -40.0 + 0.1 * (person as f64).sin(),
                    _ => -30.0 + 0.1 * (2.0 * person as f64).cos(),
                };
                set(change, percent);
            }
        }
    }
    let found = compare(&more, &config()).unwrap();
    let codes: Vec<&str> = found
        .warnings
        .iter()
        .map(|warning| warning.code.as_ref())
        .collect();
    assert!(
        codes.contains(&"eeg_difference_without_scatter"),
        "{codes:?}"
    );
}
