//! Comparisons by load and by direction of sliding: what is concluded, and what is left open.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use crate::known_cuts::{Kind, RATE_HZ, Random, recorded};
use piezotact::compare::{CompareWarning, Contrast, ContrastUnit, Mixed};
use piezotact::discrimination::Model;
use piezotact::document::Document;
use piezotact::page::Shown as _;
use piezotact::quantity::{Band, Hertz, Newtons, SampleRate, Unit};
use piezotact::recording::{Channel, Condition, Provenance, Recording, SlidingDirection, Touch};
use piezotact::study::{
    AnalysedRecording, Breadth, ComparisonDocument, Factor, Gesture, Naming, Question, Recorded,
    Stated, StudyAnalysis, StudyError, StudySettings, Trend, analyse, cut, label_by,
};

/// A recording to be made: how loud it is re the others, and by what factor it presses harder.
struct Made {
    name: String,
    gain: f64,
    force: f64,
    kinds: Vec<Kind>,
    condition: Condition,
}

fn made(name: &str, gain: f64, force: f64, condition: Condition) -> Made {
    Made {
        name: name.into(),
        gain,
        force,
        kinds: vec![Kind::Plain; 4],
        condition,
    }
}

fn condition(sample: &str, load_n: f64, direction: Option<SlidingDirection>) -> Condition {
    Condition {
        sample: Some(sample.into()),
        load_n: Some(Newtons(load_n)),
        speed_m_s: Some(0.03),
        direction,
        ..Condition::default()
    }
}

fn taken(made: &Made) -> AnalysedRecording {
    // One surface for each sample; its level differs by up to 2 % from recording to recording.
    let sum = |text: &str| text.bytes().map(u64::from).sum::<u64>();
    let plain = made.kinds.iter().all(|kind| matches!(kind, Kind::Plain));
    let surface = made.condition.sample.as_deref().filter(|_| plain);
    let seed = sum(surface.unwrap_or(&made.name));
    let gain = made.gain * (0.98 + 0.01 * (sum(&made.name) % 5) as f64);
    let mut one = recorded(&mut Random::new(seed), &made.kinds);
    // What the sensor adds is each recording's own: they are no copies.
    let places = (1..).zip(made.name.bytes());
    let mut noise = Random::new(
        places
            .map(|(place, byte): (u64, u8)| place * u64::from(byte))
            .sum(),
    );
    for value in &mut one.acceleration {
        *value += 0.005 * noise.normal();
    }
    let channel = |name: &str, unit: Unit, samples: &[f64], gain: f64| Channel {
        name: name.into(),
        unit,
        samples: samples.iter().map(|v| v * gain).collect(),
    };
    let channels = vec![
        channel("nail", Unit::MetrePerSecondSquared, &one.acceleration, gain),
        channel("fx", Unit::Newton, &one.fx_n, made.force),
        channel("fy", Unit::Newton, &one.fy_n, made.force),
        channel("fz", Unit::Newton, &one.fz_n, made.force),
    ];
    let rate = SampleRate::new(RATE_HZ).unwrap();
    let own = made.condition.clone();
    let recorded = Recorded {
        file: made.name.clone(),
        name: made.name.clone(),
        recording: Recording::new(channels, rate, own, Provenance::default()).unwrap(),
        naming: Naming::default(),
        cuts: None,
        cuts_are_looked_for_in: String::new(),
    };
    cut(recorded, &Stated::nothing()).unwrap()
}

fn settings(by: Factor) -> StudySettings {
    let band = Band::new(Hertz(20.0), Hertz(1000.0)).unwrap();
    StudySettings {
        gesture: Gesture::Usual,
        segment: None,
        sets: Vec::new(),
        twin_sets: Vec::new(),
        ridge_m: None,
        question: Question::Changes {
            by,
            model: Model::over(band),
        },
        breadth: Breadth::Question,
    }
}

fn compared(made: &[Made], by: Factor) -> Result<StudyAnalysis, StudyError> {
    analyse(made.iter().map(taken).collect(), &settings(by))
}

fn warnings(study: &StudyAnalysis) -> Vec<CompareWarning> {
    let all = study.warnings_of_comparison(0);
    all.iter().filter_map(piezotact::Warning::kind).collect()
}

const SLID: [SlidingDirection; 2] = [SlidingDirection::Transversal, SlidingDirection::Proximal];

/// Samples touched in two directions, the first with `gain`.
fn directions(samples: &[&str], gain: f64) -> Vec<Made> {
    let one = |sample: &&str, direction: SlidingDirection| {
        let gain = match direction {
            SlidingDirection::Transversal => gain,
            _ => 1.0,
        };
        let condition = condition(sample, 0.2, Some(direction));
        made(&format!("{sample} {direction}"), gain, 1.0, condition)
    };
    let all = samples.iter();
    all.flat_map(|sample| SLID.map(|direction| one(sample, direction)))
        .collect()
}

fn contrast(study: &StudyAnalysis) -> &Contrast {
    let [contrast] = study.contrasts(Factor::Direction) else {
        panic!("{:?}", study.contrasts(Factor::Direction));
    };
    contrast
}

/// Half the level over four samples is a lower level; the same level is no difference, and one sample decides nothing.
#[test]
fn directions_differ_where_several_settings_show_it() {
    let samples = ["S1", "S2", "S3", "S4"];
    let study = compared(&directions(&samples, 0.5), Factor::Direction).unwrap();
    assert_eq!(study.comparisons().len(), 4);
    let found = contrast(&study);
    assert_eq!(
        (found.value.as_str(), found.reference.as_str()),
        ("transversal", "proximal")
    );
    let level = found.level.as_ref().unwrap();
    assert!((level.mean + 6.02).abs() < 0.3, "{level:?}");
    let said = found.conclusion();
    assert!(
        said.starts_with("transversal has a lower level than proximal")
            && said.contains("4 settings"),
        "{said}"
    );
    assert!(study.conclusions().contains(&said));

    let same = compared(&directions(&samples, 1.0), Factor::Direction).unwrap();
    let said = contrast(&same).conclusion();
    assert!(said.contains("no difference in level shown"), "{said}");

    let alone = compared(&directions(&samples[..1], 0.5), Factor::Direction).unwrap();
    assert_eq!(
        contrast(&alone).conclusion(),
        "transversal and proximal: the difference in level is not decided from 1 setting"
    );
    let document = serde_json::to_value(Document::of(&ComparisonDocument::of(&alone))).unwrap();
    assert_eq!(document["by"], "direction");
    assert_eq!(document["values"][0]["value"], "proximal");
    assert_eq!(document["contrasts"][0]["settings"], 1);
    assert!(document["contrasts"][0].get("level").is_none());
}

/// Strokes with stick-slip are counted for each direction, and enter no level.
#[test]
fn stick_slip_is_counted() {
    let mut all = directions(&["S1"], 1.0);
    all[0].kinds = [[Kind::StickSlip; 3], [Kind::Plain; 3]].concat();
    let study = compared(&all, Factor::Direction).unwrap();
    let Trend::Values(trend) = &study.comparisons()[0].trend else {
        panic!("directions are compared");
    };
    let [proximal, transversal] = trend.values.as_slice() else {
        panic!("{trend:?}");
    };
    assert_eq!(
        (proximal.contacts.stick_slip, proximal.contacts.all),
        (0, 4)
    );
    assert_eq!(
        (transversal.contacts.stick_slip, transversal.contacts.all),
        (3, 6)
    );
    assert!(trend.lines()[1].ends_with("stick-slip in 3 of 6 strokes"));

    // A direction with nothing but stick-slip has no level, and is said all the same; of another sample it is not.
    let mut circular = made(
        "S1 circular",
        1.0,
        1.0,
        condition("S1", 0.2, Some(SlidingDirection::Circular)),
    );
    circular.kinds = vec![Kind::StickSlip; 4];
    let mut other = made(
        "S9",
        1.0,
        1.0,
        condition("S9", 0.2, Some(SlidingDirection::Distal)),
    );
    other.kinds = vec![Kind::StickSlip; 4];
    all.extend([circular, other]);
    let study = compared(&all, Factor::Direction).unwrap();
    let Trend::Values(trend) = &study.comparisons()[0].trend else {
        panic!("directions are compared");
    };
    let [_, _, circular] = trend.values.as_slice() else {
        panic!("{trend:?}");
    };
    assert_eq!(circular.level_difference_db, None);
    assert_eq!(
        (circular.contacts.stick_slip, circular.contacts.all),
        (4, 4)
    );
    assert_eq!(study.contrasts(Factor::Direction).len(), 1);
}

/// Directions that were pressed differently, or moved at a speed that nobody knows, leave open what made the difference.
#[test]
fn what_differs_beside_the_direction_is_a_warning() {
    let clean = compared(&directions(&["S1"], 0.5), Factor::Direction).unwrap();
    let confounds = |warning: &CompareWarning| {
        matches!(
            warning,
            CompareWarning::Mixed {
                how: Mixed::Confounded { .. }
            } | CompareWarning::Mixed {
                how: Mixed::Unknown { .. }
            }
        )
    };
    assert!(
        !warnings(&clean).iter().any(confounds),
        "{:?}",
        warnings(&clean)
    );

    let mut pressed = directions(&["S1"], 0.5);
    pressed[0].force = 1.5;
    let study = compared(&pressed, Factor::Direction).unwrap();
    let found = warnings(&study);
    let load = found.iter().find(|warning| confounds(warning)).unwrap();
    assert!(
        load.to_string().contains("differ in load")
            && load.to_string().contains("not from the direction"),
        "{load}"
    );

    let mut free = directions(&["S1"], 0.5);
    for one in &mut free {
        one.condition.speed_m_s = None;
    }
    let study = compared(&free, Factor::Direction).unwrap();
    let unknown = |warning: &CompareWarning| matches!(warning, CompareWarning::Mixed { how: Mixed::Unknown { what, .. } } if what == "speed");
    assert!(
        warnings(&study).iter().any(unknown),
        "{:?}",
        warnings(&study)
    );
}

/// Recordings that state no direction cannot be grouped by it, and those of other loads stand in comparisons of their own.
#[test]
fn directions_are_compared_at_one_load() {
    let mut all = directions(&["S1"], 0.5);
    all[0].condition.load_n = Some(Newtons(0.4));
    let refused = compared(&all, Factor::Direction).err().unwrap();
    assert_eq!(
        refused,
        StudyError::NothingToCompare {
            by: Factor::Direction,
            differ_in: vec![Factor::Load],
            rejected: Vec::new(),
        }
    );
    all[0].condition.direction = None;
    assert!(matches!(
        compared(&all, Factor::Direction).err().unwrap(),
        StudyError::Unknown {
            by: Factor::Direction,
            ..
        }
    ));
}

/// Loads of which the heavier is the louder.
fn loads(all_n: &[f64], exponent: f64) -> Vec<Made> {
    let one = |load_n: &f64| {
        let ratio = load_n / 0.2;
        let condition = condition("S1", *load_n, None);
        made(
            &format!("{load_n} N"),
            ratio.powf(exponent),
            ratio,
            condition,
        )
    };
    all_n.iter().map(one).collect()
}

/// The level follows the load where it does over several loads; two loads decide nothing, nor does a level that stays.
#[test]
fn the_level_follows_the_load_where_several_loads_show_it() {
    let of = |made: &[Made]| {
        let study = compared(made, Factor::Load).unwrap();
        let Trend::Loads(trend) = study.comparisons()[0].trend.clone() else {
            panic!("loads are compared");
        };
        let names: Vec<String> = study.comparisons()[0]
            .summaries()
            .iter()
            .map(|s| s.name.clone())
            .collect();
        (names, trend)
    };
    let (names, rising) = of(&loads(&[0.6, 0.2, 0.25, 1.2, 0.4], 0.8));
    // As numbers count, not as text does.
    assert_eq!(names, ["0.2 N", "0.25 N", "0.4 N", "0.6 N", "1.2 N"]);
    let fit = rising.rms_on_load.unwrap();
    assert!((fit.slope - 0.8).abs() < 0.05, "{fit:?}");
    assert!(fit.slope_interval.unwrap()[0] > 0.0, "{fit:?}");
    assert!(rising.lines()[0].contains("rises"), "{:?}", rising.lines());

    let (_, flat) = of(&loads(&[0.2, 0.4, 0.8], 0.0));
    assert!(!flat.lines()[0].contains("rises"), "{:?}", flat.lines());
    let (_, two) = of(&loads(&[0.2, 0.8], 0.8));
    assert!(two.lines()[0].contains("not decided"), "{:?}", two.lines());
}

/// A comparison by load does not take samples or directions together.
#[test]
fn loads_are_compared_in_one_direction() {
    let mut all = loads(&[0.2, 0.4], 0.5);
    all[0].condition.direction = Some(SlidingDirection::Proximal);
    all[1].condition.direction = Some(SlidingDirection::Distal);
    assert_eq!(
        compared(&all, Factor::Load).err().unwrap(),
        StudyError::NothingToCompare {
            by: Factor::Load,
            differ_in: vec![Factor::Direction],
            rejected: Vec::new(),
        }
    );
    all[1].condition.direction = Some(SlidingDirection::Proximal);
    assert!(compared(&all, Factor::Load).is_ok());
    all[1].condition.load_n = None;
    assert!(matches!(
        compared(&all, Factor::Load).err().unwrap(),
        StudyError::Unknown {
            by: Factor::Load,
            ..
        }
    ));
}

/// What is stated for every stroke has no spread, and a band beyond the Nyquist frequency has no power.
#[test]
fn what_was_not_measured_is_not_shown_as_if_it_were() {
    let study = compared(&loads(&[0.2, 0.4], 0.5), Factor::Load).unwrap();
    let page = ComparisonDocument::of(&study).page();
    let table = page.first_table().unwrap();
    let speed = table
        .columns
        .iter()
        .position(|column| column.name == "speed_mm_s");
    assert_eq!(table.rows[0][speed.unwrap()].text(), "30.0");
    let mut slow = loads(&[0.2, 0.4], 0.5);
    let of = |all: &[Made]| {
        compared(all, Factor::Load).unwrap().groups[0]
            .summary
            .receptor_power
    };
    assert!(of(&slow).iter().all(Option::is_some));
    slow.truncate(2);
    let thinned: Vec<AnalysedRecording> = slow
        .iter()
        .map(|made| {
            let take = taken(made);
            let recording = &take.recording;
            let channels = recording.channels().iter().map(|channel| Channel {
                samples: channel.samples.iter().step_by(10).copied().collect(),
                ..channel.clone()
            });
            let rate = SampleRate::new(RATE_HZ / 10.0).unwrap();
            let own = made.condition.clone();
            let recording =
                Recording::new(channels.collect(), rate, own, Provenance::default()).unwrap();
            let recorded = Recorded {
                file: made.name.clone(),
                name: made.name.clone(),
                recording,
                naming: Naming::default(),
                cuts: None,
                cuts_are_looked_for_in: String::new(),
            };
            cut(recorded, &Stated::nothing()).unwrap()
        })
        .collect();
    let settings = StudySettings {
        gesture: Gesture::Usual,
        segment: None,
        sets: Vec::new(),
        twin_sets: Vec::new(),
        ridge_m: None,
        question: Question::Groups(None),
        breadth: Breadth::Question,
    };
    let study = analyse(thinned, &settings).unwrap();
    // 250 Hz: Merkel and Meissner lie below, Pacini and Ruffini reach beyond.
    let known = study.groups[0]
        .summary
        .receptor_power
        .map(|power| power.is_some());
    assert_eq!(known, [true, true, false, false]);
    let stroke = &study.takes[0].analysis.as_ref().unwrap().strokes[0];
    assert_eq!(stroke.receptor_power.map(|power| power.is_some()), known);
}

/// Recordings of `people` at four loads each in two directions, of which the first person is louder in one; the recordings state no load,
/// so that they are one setting each by their sample.
fn people(people: &[(&str, f64)]) -> Vec<Made> {
    let one = |(who, gain): &(&str, f64), sample: &str, direction: SlidingDirection| {
        let gain = match direction {
            SlidingDirection::Transversal => *gain,
            _ => 1.0,
        };
        let mut condition = condition(sample, 0.2, Some(direction));
        condition.participant = Some((*who).into());
        made(&format!("{who} {sample} {direction}"), gain, 1.0, condition)
    };
    let all = people.iter().flat_map(|who| {
        ["S1", "S2", "S3", "S4"]
            .into_iter()
            .flat_map(move |sample| SLID.map(|direction| one(who, sample, direction)))
    });
    all.collect()
}

/// Any label is compared as a direction is: by setting, or over people. A label that a recording lacks is named, with those that there are.
#[test]
fn a_label_is_compared_over_people() {
    let of = |gains: &[(&str, f64)]| -> Vec<AnalysedRecording> {
        let takes = people(gains).into_iter().map(|mut made| {
            let wet = made.condition.direction == Some(SlidingDirection::Transversal);
            made.condition.direction = None;
            let mut taken = taken(&made);
            let skin = if wet { "wet" } else { "dry" };
            taken.labels.insert("skin".into(), skin.into());
            taken
        });
        takes.collect()
    };
    let all = [("P1", 0.5), ("P2", 0.55), ("P3", 0.45), ("P4", 0.52)];
    let mut takes = of(&all);
    label_by(&mut takes, "skin").unwrap();
    let study = analyse(takes, &settings(Factor::Label)).unwrap();
    let said = study.conclusions().join("; ");
    assert!(said.contains("wet has a lower level than dry"), "{said}");
    let [found] = study.contrasts(Factor::Label) else {
        panic!("{:?}", study.contrasts(Factor::Label));
    };
    assert_eq!((found.over, found.units), (ContrastUnit::Participants, 4));
    // People who do not agree, and equal ones, show nothing.
    for gains in [[0.3, 1.1, 1.6, 0.8], [1.0; 4]] {
        let people: Vec<(&str, f64)> = ["P1", "P2", "P3", "P4"].into_iter().zip(gains).collect();
        let mut takes = of(&people);
        label_by(&mut takes, "skin").unwrap();
        let study = analyse(takes, &settings(Factor::Label)).unwrap();
        let said = study.contrasts(Factor::Label)[0].conclusion();
        assert!(said.contains("no difference in level shown"), "{said}");
    }
    let mut takes = of(&all);
    takes[3].labels.clear();
    let name = takes[3].name.clone();
    assert_eq!(
        label_by(&mut takes, "skin"),
        Err(StudyError::Label {
            name: "skin".into(),
            recording: name,
            known: vec!["skin".into()],
        })
    );
}

/// Two loads have their difference in level over samples, beside the exponent.
#[test]
fn two_loads_are_compared_over_settings() {
    let of = |gain: f64| {
        let all = ["S1", "S2", "S3", "S4", "S5"]
            .into_iter()
            .flat_map(|sample| {
                [(0.2, 1.0), (0.4, gain)].map(|(load_n, gain)| {
                    let name = format!("{sample} {load_n}");
                    made(&name, gain, load_n / 0.2, condition(sample, load_n, None))
                })
            });
        compared(&all.collect::<Vec<_>>(), Factor::Load).unwrap()
    };
    let louder = of(2.0);
    let [found] = louder.contrasts(Factor::Load) else {
        panic!("{:?}", louder.contrasts(Factor::Load));
    };
    let said = found.conclusion();
    assert!(
        said.contains("0.4 N has a higher level than 0.2 N"),
        "{said}"
    );
    let same = of(1.0);
    let said = same.contrasts(Factor::Load)[0].conclusion();
    assert!(!said.contains("has a"), "{said}");
}

/// Two people in four settings each were eight independent settings, and "p < 0.001".
#[test]
fn settings_of_one_participant_are_not_independent() {
    let two = compared(&people(&[("P1", 0.5), ("P2", 0.55)]), Factor::Direction).unwrap();
    let found = contrast(&two);
    assert_eq!(
        (found.settings, found.over, found.units),
        (8, ContrastUnit::Participants, 2)
    );
    assert_eq!(
        found.conclusion(),
        "transversal and proximal: the difference in level is not decided from 2 participants"
    );
    let all = [("P1", 0.5), ("P2", 0.55), ("P3", 0.45), ("P4", 0.52)];
    let four = compared(&people(&all), Factor::Direction).unwrap();
    let said = contrast(&four).conclusion();
    assert!(
        said.starts_with("transversal has a lower level") && said.contains("over 4 participants"),
        "{said}"
    );
    // People who do not agree decide nothing, however many settings each has.
    let apart = [("P1", 0.3), ("P2", 1.1), ("P3", 1.6), ("P4", 0.8)];
    let apart = compared(&people(&apart), Factor::Direction).unwrap();
    let said = contrast(&apart).conclusion();
    assert!(said.contains("no difference in level shown"), "{said}");
}

/// What is touched actively with 0.2 N and passively with `force` times as much, the loads not being stated.
fn ways(force: f64) -> Vec<Made> {
    let one = |sample: &str, touch: Touch| {
        let (gain, force) = match touch {
            Touch::Passive => (2.0, force),
            _ => (1.0, 1.0),
        };
        let condition = Condition {
            touch: Some(touch),
            load_n: None,
            ..condition(sample, 0.2, None)
        };
        made(&format!("{sample} {touch:?}"), gain, force, condition)
    };
    ["S1", "S2", "S3", "S4", "S5"]
        .into_iter()
        .flat_map(|sample| [Touch::Active, Touch::Passive].map(|touch| one(sample, touch)))
        .collect()
}

/// A load that differs as completely as the kind of touch may be the cause: "active has a lower level" was said without a warning.
#[test]
fn a_load_that_differs_too_leaves_the_cause_open() {
    let same = compared(&ways(1.0), Factor::Touch).unwrap();
    let concludes = |study: &StudyAnalysis| -> String {
        let all = study.both_ways.as_ref().unwrap().found.conclusions();
        all.into_iter()
            .find(|line| line.contains("lower level"))
            .unwrap()
    };
    assert!(concludes(&same).starts_with("active has a lower level"));
    let of_load = |warning: &CompareWarning| matches!(warning, CompareWarning::Mixed { how: Mixed::Confounded { what, .. } } if what == "load");
    assert!(
        !warnings(&same).iter().any(of_load),
        "{:?}",
        warnings(&same)
    );
    let other = compared(&ways(2.0), Factor::Touch).unwrap();
    assert!(
        warnings(&other).iter().any(of_load),
        "{:?}",
        warnings(&other)
    );
    let said = concludes(&other);
    assert!(
        said.starts_with("cause not decided, since the load differs too (0.2"),
        "{said}"
    );
    assert!(other.conclusions().contains(&said));
}

/// Samples, speeds and participants that were touched with other loads, measured or stated.
#[test]
fn a_load_that_differs_too_is_named_whatever_is_compared() {
    let confounded = |made: &[Made], by: Factor| {
        let study = compared(made, by).unwrap();
        let all = warnings(&study);
        let named = |warning: &&CompareWarning| matches!(warning, CompareWarning::Mixed { how: Mixed::Confounded { what, by: of, .. } } if what == "load" && *of == by.word());
        let text: String = study.conclusions().join("\n");
        (all.iter().filter(named).count(), text)
    };
    let with = |sample: &str, who: &str, speed_m_s: f64, load_n: Option<f64>, force: f64| {
        let condition = Condition {
            participant: Some(who.into()),
            speed_m_s: Some(speed_m_s),
            load_n: load_n.map(Newtons),
            ..condition(sample, 0.2, None)
        };
        made(
            &format!("{sample} {who} {speed_m_s}"),
            force,
            force,
            condition,
        )
    };
    let samples = [
        with("S1", "P1", 0.03, None, 1.0),
        with("S2", "P1", 0.03, None, 3.0),
    ];
    let (count, said) = confounded(&samples, Factor::Sample);
    assert_eq!(count, 1, "{said}");
    assert!(
        said.contains("cause not decided, since the load differs too"),
        "{said}"
    );
    let people = [
        with("S1", "P1", 0.03, Some(0.2), 1.0),
        with("S1", "P2", 0.03, Some(0.6), 3.0),
    ];
    let (count, said) = confounded(&people, Factor::Participant);
    assert_eq!(count, 1, "{said}");
    let speeds: Vec<Made> = [(0.01, 1.0), (0.02, 2.0), (0.03, 3.0), (0.04, 4.0)]
        .map(|(speed, force)| with("S1", "P1", speed, None, force))
        .into();
    let (count, said) = confounded(&speeds, Factor::Speed);
    assert_eq!(count, 1, "{said}");
    assert!(
        said.contains("cause not decided, since the load differs too")
            && said.contains("rms rises with speed"),
        "{said}"
    );
    let same = [
        with("S1", "P1", 0.03, None, 1.0),
        with("S2", "P1", 0.03, None, 1.0),
    ];
    let (count, said) = confounded(&same, Factor::Sample);
    assert_eq!(count, 0, "{said}");
    assert!(!said.contains("cause not decided"), "{said}");
}

/// Strokes whose force is not the stated load are rejected: that is why nothing is left to compare, and it is said.
#[test]
fn what_was_rejected_is_named_where_nothing_is_left_to_compare() {
    let mut all = directions(&["S1"], 1.0);
    all[0].force = 3.0;
    let refused = compared(&all, Factor::Direction).err().unwrap().to_string();
    assert!(
        refused.contains("1 recording without strokes") && refused.contains("S1 transversal"),
        "{refused}"
    );
    assert!(refused.contains("rejected"), "{refused}");
}

/// Recordings of two participants in one group: the advice was "group by participants, whose strokes are not independent".
#[test]
fn the_advice_on_pooled_participants_is_a_sentence() {
    let warning = piezotact::Warning::from(CompareWarning::Mixed {
        how: Mixed::Pooled {
            group: "S1".into(),
            what: "participants".into(),
        },
    });
    assert_eq!(
        warning.to_string().matches("not independent").count(),
        1,
        "{warning}"
    );
    assert!(
        warning
            .to_string()
            .ends_with("; group by participant, or compare the groups"),
        "{warning}"
    );
}
