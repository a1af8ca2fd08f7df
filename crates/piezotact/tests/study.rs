//! A study as a value: which condition counts, which recordings belong together, and what is said of them.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use crate::known_cuts::{Kind, RATE_HZ, Random, recorded};
use piezotact::Warning;
use piezotact::compare::{CompareWarning, Mixed};
use piezotact::discrimination::Model;
use piezotact::document::Document;
use piezotact::page::{Block, Cell, Shown as _};
use piezotact::quantity::{Band, Hertz, Newtons, SampleRate, Unit};
use piezotact::recording::{
    Channel, Condition, NotUsed, Provenance, Recording, RecordingWarning, Touch,
};
use piezotact::statistics::correlation;
use piezotact::stroke::{Cut, Cuts, Judging, StrokeWarning};
use piezotact::study::{
    AnalysedRecording, AnalysisDocument, Breadth, ComparisonDocument, CutsDocument, Factor,
    Gesture, Naming, Question, Recorded, Stated, StudyAnalysis, StudyError, StudySettings, Trend,
    analyse, analyse_watched, cut, cuts_table, strokes_table,
};

/// A finger that makes `strokes` strokes, as a recording at `rate_hz`: the same samples, stamped with another rate.
fn at_rate(name: &str, strokes: usize, own: Condition, rate_hz: f64) -> Recorded {
    made_of(name, &vec![Kind::Plain; strokes], own, rate_hz)
}

fn made_of(name: &str, kinds: &[Kind], own: Condition, rate_hz: f64) -> Recorded {
    let seed = name.bytes().map(u64::from).sum();
    let made = recorded(&mut Random::new(seed), kinds);
    let channel = |name: &str, unit: Unit, samples: Vec<f64>| Channel {
        name: name.into(),
        unit,
        samples,
    };
    let channels = vec![
        channel("nail", Unit::MetrePerSecondSquared, made.acceleration),
        channel("fx", Unit::Newton, made.fx_n),
        channel("fy", Unit::Newton, made.fy_n),
        channel("fz", Unit::Newton, made.fz_n),
    ];
    let rate = SampleRate::new(rate_hz).unwrap();
    Recorded {
        file: format!("study/{name}.csv"),
        name: format!("{name}.csv"),
        recording: Recording::new(channels, rate, own, Provenance::default()).unwrap(),
        naming: Naming::default(),
        cuts: None,
        cuts_are_looked_for_in: format!("study/{name}.csv.cuts"),
    }
}

fn of(name: &str, strokes: usize, own: Condition) -> Recorded {
    at_rate(name, strokes, own, RATE_HZ)
}

fn touched(sample: &str, speed_mm_s: f64) -> Condition {
    Condition {
        sample: Some(sample.into()),
        speed_m_s: Some(speed_mm_s * 1e-3),
        ..Condition::default()
    }
}

fn by(condition: Condition, participant: &str) -> Condition {
    Condition {
        participant: Some(participant.into()),
        ..condition
    }
}

fn taken(recorded: Recorded) -> AnalysedRecording {
    cut(recorded, &Stated::nothing()).unwrap()
}

fn all(recorded: impl IntoIterator<Item = Recorded>) -> Vec<AnalysedRecording> {
    recorded.into_iter().map(taken).collect()
}

fn settings(question: Question) -> StudySettings {
    StudySettings {
        gesture: Gesture::Usual,
        segment: None,
        sets: Vec::new(),
        twin_sets: Vec::new(),
        ridge_m: None,
        question,
        breadth: Breadth::Question,
    }
}

fn changes(by: Factor) -> StudySettings {
    let band = Band::new(Hertz(20.0), Hertz(1000.0)).unwrap();
    settings(Question::Changes {
        by,
        model: Model::over(band),
    })
}

fn grouped(takes: Vec<AnalysedRecording>, by: Option<Factor>) -> StudyAnalysis {
    analyse(takes, &settings(Question::Groups(by))).unwrap()
}

fn names(study: &StudyAnalysis) -> Vec<&str> {
    study
        .groups
        .iter()
        .map(|g| g.summary.name.as_str())
        .collect()
}

fn raised<K: std::error::Error + serde::de::DeserializeOwned>(take: &AnalysedRecording) -> Vec<K> {
    take.warnings()
        .iter()
        .filter_map(|warning| warning.kind())
        .collect()
}

/// What a person states counts before the recording, and the recording before its name; what nobody says stays open.
#[test]
fn a_person_counts_before_the_recording_and_the_recording_before_its_name() {
    let said = |sample: Option<&str>, load_n: Option<f64>, speed_m_s: Option<f64>| Condition {
        sample: sample.map(str::to_owned),
        load_n: load_n.map(Newtons),
        speed_m_s,
        ..Condition::default()
    };
    let mut recorded = of("a", 2, said(Some("S1"), Some(0.3), None));
    recorded.recording.annotations.labels = [("repeat".to_owned(), "7".to_owned())].into();
    recorded.naming = Naming {
        condition: said(Some("S9"), Some(0.9), Some(0.05)),
        labels: [("repeat", "1"), ("board", "B2")]
            .map(|(name, value)| (name.to_owned(), value.to_owned()))
            .into(),
        warnings: vec![
            RecordingWarning::Guessed {
                what: "the collection".into(),
            }
            .into(),
        ],
    };
    let stated = Stated {
        condition: Condition {
            touch: Some(Touch::Active),
            ..said(None, Some(0.2), None)
        },
        ..Stated::nothing()
    };
    let take = cut(recorded, &stated).unwrap();
    let found = take.condition();
    assert_eq!(found.load_n, Some(Newtons(0.2)), "a person's");
    assert_eq!(found.sample.as_deref(), Some("S1"), "the recording's");
    assert_eq!(found.speed_m_s, Some(0.05), "the name's");
    assert_eq!(found.touch, Some(Touch::Active));
    assert_eq!(found.participant, None);
    assert_eq!(take.labels["repeat"], "7");
    assert_eq!(take.labels["board"], "B2");
    assert!(!raised::<RecordingWarning>(&take).is_empty());
    // What is expected of the strokes is the condition that counts.
    assert!(take.segmentation.rule.sentence().contains("of 0.2 N"));
}

#[test]
fn stated_channels_count_before_guessed_ones_and_must_be_there() {
    let with = |change: &dyn Fn(&mut Stated)| {
        let mut stated = Stated::nothing();
        change(&mut stated);
        cut(of("a", 2, Condition::default()), &stated)
    };
    let guessed = with(&|_| ()).unwrap().segmentation.roles;
    assert_eq!(guessed.tangential_force, ["fx", "fy"]);
    let roles = with(&|stated| stated.normal_force = Some("fx".into()));
    let roles = roles.unwrap().segmentation.roles;
    // A force named normal is not tangential.
    assert_eq!(roles.normal_force.as_deref(), Some("fx"));
    assert_eq!(roles.tangential_force, ["fy"]);
    let missing = with(&|stated| stated.vibration = vec!["finger".into()]);
    assert!(
        matches!(&missing, Err(StudyError::Recording { file, .. }) if file == "study/a.csv"),
        "{missing:?}"
    );
    let three = with(&|stated| stated.tangential_force = vec!["fx".into(); 3]);
    assert_eq!(three.err(), Some(StudyError::TangentialForces { found: 3 }));
    for load_n in [0.0, -0.2, f64::NAN] {
        let refused = with(&|stated| stated.condition.load_n = Some(Newtons(load_n)));
        assert!(matches!(refused, Err(StudyError::Load { .. })), "{load_n}");
    }
    let every = with(&|stated| stated.judging = Judging::ContactOnly).unwrap();
    assert!(every.segmentation.rule.sentence().contains("slides or not"));
}

/// The recording of [`of`] with what vibrates as the velocity of a laser vibrometer.
fn by_vibrometer(called: &str) -> Recorded {
    let mut recorded = of("a", 3, Condition::default());
    let rate = recorded.recording.rate();
    let mut channels = recorded.recording.channels().to_vec();
    let mut velocity = 0.0;
    for value in &mut channels[0].samples {
        velocity += *value / rate.hz();
        *value = velocity;
    }
    channels[0].name = called.into();
    channels[0].unit = Unit::MetrePerSecond;
    let (own, provenance) = (Condition::default(), Provenance::default());
    recorded.recording = Recording::new(channels, rate, own, provenance).unwrap();
    recorded
}

#[test]
fn the_velocity_of_a_vibrometer_is_differentiated_and_stated() {
    let is_stated = |take: &AnalysedRecording| {
        let guessed = |warning: &Warning| match warning.kind() {
            Some(RecordingWarning::Guessed { what }) => what.contains("velocity of the vibration"),
            _ => false,
        };
        take.warnings().iter().any(guessed)
    };
    let usual = cut(of("a", 3, Condition::default()), &Stated::nothing()).unwrap();
    assert!(!is_stated(&usual));
    let take = cut(by_vibrometer("LDV"), &Stated::nothing()).unwrap();
    assert!(is_stated(&take));
    assert_eq!(take.segmentation.roles.motion, None);
    assert_eq!(
        take.segmentation.strokes.len(),
        usual.segmentation.strokes.len()
    );
    let channel = &take.recording.channels()[0];
    assert_eq!(channel.unit, Unit::MetrePerSecondSquared);
    // Slow parts are those of the acceleration: sums of 50 samples.
    let slow = |take: &AnalysedRecording| {
        let samples = take.recording.channels()[0].samples.chunks_exact(50);
        samples.map(|part| part.iter().sum()).collect::<Vec<f64>>()
    };
    assert!(correlation(&slow(&take), &slow(&usual)) > 0.95);
    // Under another name it is a speed, unless a person names it.
    let other = cut(by_vibrometer("velocity"), &Stated::nothing()).unwrap();
    assert!(other.segmentation.roles.motion.is_some() && !is_stated(&other));
    let stated = Stated {
        vibration: vec!["velocity".into()],
        ..Stated::nothing()
    };
    let named = cut(by_vibrometer("velocity"), &stated).unwrap();
    assert!(is_stated(&named));
    assert_eq!(named.segmentation.roles.motion, None);
}

#[test]
fn a_persons_cuts_are_applied_and_those_outside_are_reported() {
    let from = |from_s: f64, to_s: f64| Cut::Stroke {
        from_s: piezotact::quantity::Seconds(from_s),
        to_s: piezotact::quantity::Seconds(to_s),
    };
    let mut recorded = of("a", 2, Condition::default());
    recorded.cuts = Some(Cuts {
        source: "a.cuts".into(),
        cuts: vec![from(0.1, 0.6), from(900.0, 901.0)],
    });
    let take = taken(recorded);
    assert_eq!(take.segmentation.strokes[0].steady.start, 500);
    let page = CutsDocument::of(std::slice::from_ref(&take), &[]).page();
    assert!(
        matches!(&page.sections[0].blocks[0], Block::Conclusion { text, .. } if text.contains("with the cuts in a.cuts: 1 stroke as it states"))
    );
    let warnings = raised::<RecordingWarning>(&take);
    assert!(
        warnings.iter().any(|warning| matches!(
            warning,
            RecordingWarning::NotUsed { what: NotUsed::Cuts { file, count: 1 } } if file == "a.cuts"
        )),
        "{warnings:?}"
    );
}

/// Time stamps of one instrument give rates that differ in the last digits. Lines are as fine as the shortest of the longest
/// strokes of every recording at that rate allows, and only of that rate.
#[test]
fn recordings_of_one_rate_share_their_lines() {
    let short = |mut recorded: Recorded, to_s: f64| {
        let (from_s, to_s) = (0.1, to_s);
        recorded.cuts = Some(Cuts {
            source: "cuts".into(),
            cuts: vec![
                Cut::LeaveOut {
                    from_s: piezotact::quantity::Seconds(0.0),
                    to_s: piezotact::quantity::Seconds(100.0),
                    note: String::new(),
                },
                Cut::Stroke {
                    from_s: piezotact::quantity::Seconds(from_s),
                    to_s: piezotact::quantity::Seconds(to_s),
                },
            ],
        });
        recorded
    };
    let takes = all([
        of("a", 2, touched("S1", 30.0)),
        short(at_rate("b", 2, touched("S2", 30.0), RATE_HZ + 0.004), 0.2),
        at_rate("c", 2, touched("S3", 30.0), 4000.0),
    ]);
    let study = grouped(takes, None);
    let segments: Vec<usize> = study
        .takes
        .iter()
        .map(|take| take.analysis.as_ref().unwrap().config.welch.segment)
        .collect();
    // 0.1 s at 5 kHz; the recording at 4 kHz keeps lines about 5 Hz apart.
    assert_eq!(segments, [500, 500, 1024]);
    let band = study.band_hz.unwrap();
    assert!(
        (band[0] - 10.0).abs() < 1e-9 && (band[1] - 1000.0).abs() < 1e-9,
        "{band:?}"
    );
    // A stated length counts.
    let stated = StudySettings {
        segment: Some(256),
        gesture: Gesture::Stated(None),
        ..settings(Question::Groups(None))
    };
    let study = analyse(all([of("a", 2, touched("S1", 30.0))]), &stated).unwrap();
    let config = &study.takes[0].analysis.as_ref().unwrap().config;
    assert_eq!((config.welch.segment, config.high_pass), (256, None));
}

/// By sample where all name one, else by file; names in the order in which people count.
#[test]
fn recordings_are_grouped_by_what_they_say() {
    let three = || {
        all([
            of("x", 2, touched("S10", 30.0)),
            of("y", 2, touched("S2", 30.0)),
            of("z", 3, touched("S10", 5.0)),
        ])
    };
    let study = grouped(three(), None);
    assert_eq!(
        (study.by, names(&study)),
        (Factor::Sample, vec!["S2", "S10"])
    );
    assert_eq!(study.groups[1].takes, [0, 2]);
    assert_eq!(study.groups[1].summary.strokes, 5);
    assert_eq!(study.strokes(), 7);
    let pooled = &study.groups[1].summary.warnings;
    assert!(
        pooled.iter().any(|warning| matches!(
            warning.kind(),
            Some(CompareWarning::Mixed {
                how: Mixed::Pooled { .. }
            })
        )),
        "{pooled:?}"
    );
    let speeds = grouped(three(), Some(Factor::Speed));
    assert_eq!(names(&speeds), ["5 mm/s", "30 mm/s"]);
    let mut nameless = three();
    nameless.push(taken(of("n", 2, Condition::default())));
    let study = grouped(nameless.clone(), None);
    assert_eq!((study.by, study.groups.len()), (Factor::File, 4));
    assert!(study.asked.is_none() && study.comparisons().is_empty());
    let unknown = analyse(nameless, &settings(Question::Groups(Some(Factor::Sample))));
    assert_eq!(
        unknown.err(),
        Some(StudyError::Unknown {
            by: Factor::Sample,
            recording: "n.csv".into()
        })
    );
}

/// Recordings that differ in two things stand in no comparison, and are named.
#[test]
fn recordings_that_differ_in_two_things_are_left_out_and_named() {
    let takes = all([
        of("a", 3, by(touched("S1", 30.0), "P1")),
        of("b", 3, by(touched("S2", 30.0), "P1")),
        of("c", 3, by(touched("S3", 10.0), "P2")),
    ]);
    let study = analyse(takes, &changes(Factor::Sample)).unwrap();
    let [comparison] = study.comparisons() else {
        panic!("{:?}", study.comparisons().len());
    };
    // The setting is said only where comparisons differ in it.
    assert_eq!(comparison.setting, "");
    assert_eq!(comparison.groups.len(), 2);
    let warnings = study.warnings_of_comparison(0);
    let left_out = study.left_out.as_ref().unwrap();
    assert!(warnings.contains(left_out));
    assert!(
        matches!(
            left_out.kind(),
            Some(CompareWarning::Mixed { how: Mixed::LeftOut { recordings } }) if recordings == "c.csv"
        ),
        "{left_out}"
    );
    let said: Vec<String> = study.warnings().iter().map(ToString::to_string).collect();
    assert!(
        said.iter().any(|sentence| sentence.contains("c.csv")),
        "{said:?}"
    );
    let Trend::Samples(trend) = &comparison.trend else {
        panic!("samples are compared");
    };
    assert_eq!((trend.single_strokes, trend.samples), (0, 2));
    let discrimination = study.discrimination.as_ref().unwrap();
    let found = discrimination.groups(0).unwrap();
    assert_eq!(found.names, ["S1", "S2"]);
    assert!(study.conclusions().contains(&discrimination.line()));
}

#[test]
fn nothing_to_compare_names_what_recordings_differ_in() {
    let takes = all([
        of("a", 2, by(touched("S1", 30.0), "P1")),
        of("b", 2, by(touched("S2", 10.0), "P1")),
    ]);
    let refused = analyse(takes, &changes(Factor::Sample)).err().unwrap();
    assert_eq!(
        refused,
        StudyError::NothingToCompare {
            by: Factor::Sample,
            differ_in: vec![Factor::Speed],
            rejected: Vec::new(),
        }
    );
    assert!(refused.to_string().contains("(they differ in speed)"));
    let alone = all([of("a", 2, by(touched("S1", 30.0), "P1"))]);
    let refused = analyse(alone, &changes(Factor::Sample)).err().unwrap();
    let recording = taken(of("a", 2, by(touched("S1", 30.0), "P1"))).name;
    let by = Factor::Sample;
    assert_eq!(refused, StudyError::OneRecording { by, recording });
}

#[test]
fn a_study_without_strokes_says_why() {
    let still = made_of("still", &[Kind::TouchOnly; 2], touched("S1", 30.0), RATE_HZ);
    let mut done = 0;
    let takes = all([still]);
    let refused = analyse_watched(takes, &settings(Question::Groups(None)), &mut || done += 1);
    let Err(StudyError::NoStrokes { found }) = refused else {
        panic!("{refused:?}");
    };
    assert_eq!(found.recordings, ["still.csv"]);
    let because = found.because.as_ref().unwrap();
    assert!(
        matches!(because.kind(), Some(StrokeWarning::Rejected { .. })),
        "{because}"
    );
    assert!(!found.warnings.is_empty());
    let sentence = found.sentence_with(&|_| "nothing slides".into());
    assert_eq!(
        sentence,
        "expected strokes, found none in still.csv: nothing slides"
    );
    assert_eq!(done, 1);
}

/// A report has what changes with sample and speed besides what is asked, and one stroke as an example; a question alone has not.
#[test]
fn a_report_has_what_is_not_asked_as_well() {
    let takes = || {
        let touch = |condition: Condition, touch: Touch| Condition {
            touch: Some(touch),
            ..condition
        };
        all([
            of("a", 2, touch(touched("S1", 30.0), Touch::Active)),
            of("b", 2, touch(touched("S2", 30.0), Touch::Active)),
            of("c", 2, touch(touched("S1", 10.0), Touch::Active)),
            of("d", 2, touch(touched("S1", 30.0), Touch::Passive)),
        ])
    };
    let asked = changes(Factor::Sample);
    let study = analyse(takes(), &asked).unwrap();
    assert!(study.across(Factor::Speed).is_empty() && study.example.is_none());
    assert!(study.both_ways.is_none());
    let whole = StudySettings {
        breadth: Breadth::Report,
        ..asked
    };
    let study = analyse(takes(), &whole).unwrap();
    assert_eq!(study.across(Factor::Sample).len(), 1);
    let [speeds] = study.across(Factor::Speed) else {
        panic!("{}", study.across(Factor::Speed).len());
    };
    assert_eq!(speeds.groups.len(), 2);
    assert!(matches!(&speeds.trend, Trend::Speeds(trend) if trend.rms_on_speed.is_some()));
    let both = study.both_ways.as_ref().unwrap();
    let pairs: Vec<&str> = both.found.pairs.iter().map(|p| p.sample.as_str()).collect();
    assert_eq!(pairs, ["S1"]);
    // The recording at another speed is no counterpart.
    assert_eq!(both.active[0].takes, [0]);
    let example = study.example.as_ref().unwrap();
    let stroke = &study.takes[example.take].segmentation.strokes[0];
    assert_eq!(example.samples.as_ref().unwrap().len(), stroke.steady.len());
    // Active and passive touch are what is asked: pairs and conclusions are said.
    let study = analyse(takes(), &changes(Factor::Touch)).unwrap();
    assert!(
        study
            .conclusions()
            .iter()
            .any(|line| line.starts_with("S1: active and passive PSDs"))
    );
}

/// The document of a comparison names its form, has one comparison at the top and several in a list, and warnings once.
#[test]
fn a_study_is_handed_out_as_a_document() {
    let people = |names: &[&str]| -> Vec<AnalysedRecording> {
        let recorded = names.iter().flat_map(|person| {
            ["S1", "S2"].map(|sample| {
                let name = format!("{person}{sample}");
                of(&name, 2, by(touched(sample, 30.0), person))
            })
        });
        all(recorded)
    };
    let document = |takes: Vec<AnalysedRecording>| {
        let study = analyse(takes, &changes(Factor::Sample)).unwrap();
        serde_json::to_value(Document::of(&ComparisonDocument::of(&study))).unwrap()
    };
    let one = document(people(&["P1"]));
    assert_eq!(
        (&one["schema"], &one["version"]),
        (&"comparison".into(), &3.into())
    );
    assert_eq!(one["by"], "sample");
    assert_eq!(one["groups"][1]["files"][0], "P1S2.csv");
    assert_eq!(one["groups"][0]["psd"]["unit"], "(m/s²)²/Hz");
    assert!(one["below_jnd"].is_array() && one.get("setting").is_none());
    let two = document(people(&["P1", "P5"]));
    assert!(two.get("groups").is_none());
    let settings: Vec<&str> = two["comparisons"]
        .as_array()
        .unwrap()
        .iter()
        .map(|comparison| comparison["setting"].as_str().unwrap())
        .collect();
    assert_eq!(settings, ["P1", "P5"]);
    assert_eq!(two["discrimination"]["settings"][1]["setting"], "P5");
    // Four groups of two strokes each: one warning, seen four times.
    let warnings = two["warnings"].as_array().unwrap().iter();
    let few = warnings.filter(|one| one["code"] == "few" && one["what"] == "strokes");
    assert_eq!(few.count(), 1);

    let takes = people(&["P1"]);
    let cut = serde_json::to_value(Document::of(&CutsDocument::of(&takes, &[]))).unwrap();
    assert_eq!(cut["schema"], "segmentation");
    let strokes = cut["recordings"][0]["cuts"].as_array().unwrap();
    let stroke = &takes[0].segmentation.strokes[0];
    assert_eq!(strokes.len(), 2);
    assert_eq!(strokes[0]["start_s"], stroke.steady.start as f64 / RATE_HZ);
    let study = grouped(takes, None);
    let analysis = serde_json::to_value(Document::of(&AnalysisDocument::of(&study))).unwrap();
    assert_eq!(analysis["schema"], "analysis");
    let recording = &analysis["recordings"][0];
    assert_eq!(recording["cuts"], cut["recordings"][0]["cuts"]);
    assert!(recording["strokes"][0]["rms"].as_f64().unwrap() > 0.0);
}

/// A table has a row for each stroke and a cell for each column, with labels that only some recordings have.
#[test]
fn a_table_has_a_row_for_each_stroke_and_every_label() {
    let mut first = of("a", 2, touched("S1", 30.0));
    first.naming.labels = [("board".to_owned(), "B2".to_owned())].into();
    let study = grouped(all([first, of("b", 3, touched("S2", 30.0))]), None);
    let strokes = strokes_table(&study.takes);
    let names: Vec<&str> = strokes.columns.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(strokes.rows.len(), 5);
    assert!(strokes.rows.iter().all(|row| row.len() == names.len()));
    let column = |name: &str| names.iter().position(|other| *other == name).unwrap();
    assert_eq!(strokes.rows[0][column("label_board")], Cell::from("B2"));
    assert_eq!(strokes.rows[4][column("label_board")], Cell::Missing(()));
    assert_eq!(strokes.rows[4][column("stroke")], Cell::from(3.0));
    let rms = study.takes[1].analysis.as_ref().unwrap().strokes[2].rms;
    assert_eq!(strokes.rows[4][column("rms")], Cell::from(rms));
    let cuts = cuts_table(&study.takes);
    let rejects: usize = study
        .takes
        .iter()
        .map(|t| t.segmentation.rejected.len())
        .sum();
    assert_eq!(cuts.rows.len(), 5 + rejects);
    assert!(cuts.rows.iter().all(|row| row.len() == cuts.columns.len()));
    assert!(
        cuts.columns
            .iter()
            .any(|column| column.name == "steady_part_limit")
    );
}

/// A copy is no second recording, also one that is scaled or begins later; another recording of the same kind is.
#[test]
fn a_scaled_or_shifted_copy_is_refused() {
    let compared = |other: &Recorded| {
        let takes = all([of("a", 4, touched("A", 30.0)), other.clone()]);
        analyse(takes, &changes(Factor::Sample))
    };
    for (factor, later) in [(1.0, 0), (1.001, 0), (1.0, 7), (0.9, 40)] {
        let mut copy = of("a", 4, touched("B", 30.0));
        let channels = copy.recording.channels().iter().map(|channel| {
            let mut channel = channel.clone();
            channel.samples.rotate_right(later);
            channel
                .samples
                .iter_mut()
                .for_each(|value| *value *= factor);
            channel
        });
        let rate = copy.recording.rate();
        let own = touched("B", 30.0);
        copy.recording =
            Recording::new(channels.collect(), rate, own, Provenance::default()).unwrap();
        let error = compared(&copy).err();
        assert!(
            matches!(error, Some(StudyError::Copy { .. })),
            "{factor} {later} {error:?}"
        );
    }
    assert!(compared(&of("b", 4, touched("B", 30.0))).is_ok());
}

/// Segments of a few samples show no spectrum: nothing is said of them.
#[test]
fn segments_too_short_to_compare_are_refused() {
    let takes = all([
        of("a", 3, touched("A", 30.0)),
        of("b", 3, touched("B", 30.0)),
    ]);
    let short = StudySettings {
        segment: Some(7),
        ..changes(Factor::Sample)
    };
    let refused = analyse(takes, &short).unwrap_err();
    let expected = StudyError::Coarse {
        needed: 200,
        found: 7,
    };
    assert_eq!(refused, expected);
}
