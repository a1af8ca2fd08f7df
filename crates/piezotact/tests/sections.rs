//! Recordings that are cut and analysed in sections, as those larger than memory are, against the same recordings read whole.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use crate::known_cuts::{Kind, RATE_HZ, Random, recorded};
use piezotact::document::Document;
use piezotact::quantity::{SampleRate, Unit};
use piezotact::recording::{Channel, Condition, Provenance, Recording};
use piezotact::stroke::{Judging, Reason};
use piezotact::study::{
    AnalysedRecording, AnalysisDocument, Breadth, Cutting, Gesture, Naming, Question, Recorded,
    Stated, StudyAnalysis, StudyError, StudySettings, analyse, cut,
};

const NAMES: [&str; 4] = ["nail", "fx", "fy", "fz"];
/// The size of a section: about 10 s.
const SECTION_BYTES: usize = 8 * 4 * 50_000;

/// The acceleration of a nail, m/s², and three forces, N.
type Signals = [Vec<f64>; 4];

fn touched(strokes: usize, seed: u64) -> Signals {
    let made = recorded(&mut Random::new(seed), &vec![Kind::Plain; strokes]);
    [made.acceleration, made.fx_n, made.fy_n, made.fz_n]
}

fn of(names: &[&str], signals: &[Vec<f64>]) -> Recorded {
    let channels = names.iter().zip(signals).map(|(name, samples)| Channel {
        name: (*name).into(),
        unit: match *name {
            "nail" => Unit::MetrePerSecondSquared,
            _ => Unit::Newton,
        },
        samples: samples.clone(),
    });
    let rate = SampleRate::new(RATE_HZ).unwrap();
    let (condition, provenance) = (Condition::default(), Provenance::default());
    let recording = Recording::new(channels.collect(), rate, condition, provenance);
    Recorded {
        file: "day.parquet".into(),
        name: "day.parquet".into(),
        recording: recording.unwrap(),
        naming: Naming::default(),
        cuts: None,
        cuts_are_looked_for_in: "day.parquet.cuts".into(),
    }
}

fn settings(breadth: Breadth) -> StudySettings {
    StudySettings {
        gesture: Gesture::Usual,
        segment: None,
        sets: Vec::new(),
        twin_sets: Vec::new(),
        ridge_m: None,
        question: Question::Groups(None),
        breadth,
    }
}

fn whole(recorded: Recorded) -> StudyAnalysis {
    let take = cut(recorded, &Stated::nothing()).unwrap();
    analyse(vec![take], &settings(Breadth::Report)).unwrap()
}

/// The parts of `recorded` of `length` samples, and itself without samples.
fn parts(recorded: &Recorded, length: usize) -> (Recorded, Vec<Recording>) {
    let recording = &recorded.recording;
    let part = |from: usize, to: usize| {
        let channels = recording.channels().iter().map(|channel| Channel {
            samples: channel.samples[from..to].to_vec(),
            ..channel.clone()
        });
        let (condition, provenance) = (Condition::default(), Provenance::default());
        Recording::new(channels.collect(), recording.rate(), condition, provenance).unwrap()
    };
    let samples = recording.len();
    let starts = (0..samples).step_by(length);
    let all = starts.map(|from| part(from, (from + length).min(samples)));
    let empty = Recorded {
        recording: part(0, 0),
        ..recorded.clone()
    };
    (empty, all.collect())
}

fn in_sections(recorded: &Recorded, length: usize) -> Result<StudyAnalysis, StudyError> {
    stated_in_sections(recorded, length, &Stated::nothing())
}

fn stated_in_sections(
    recorded: &Recorded,
    length: usize,
    stated: &Stated,
) -> Result<StudyAnalysis, StudyError> {
    let (empty, parts) = parts(recorded, length);
    let mut cutting = Cutting::new(empty, stated, SECTION_BYTES)?;
    for part in &parts {
        cutting.add(part)?;
    }
    let mut measuring = cutting.cut([])?.measuring(&settings(Breadth::Report))?;
    for part in &parts {
        measuring.add(part)?;
    }
    measuring.finish()
}

fn take(study: &StudyAnalysis) -> &AnalysedRecording {
    &study.takes[0]
}

fn assert_near(what: &str, found: f64, expected: f64, share: f64) {
    let off = (found - expected).abs();
    assert!(
        off <= share * expected.abs(),
        "{what}: {found} against {expected}"
    );
}

/// Strokes, features, spectra and their scatter over strokes are those of the whole recording, whatever the length of parts: zeros of forces
/// and usual levels of a section move ends by milliseconds.
#[test]
fn sections_say_what_the_whole_recording_says() {
    let recorded = of(&NAMES, &touched(60, 3));
    let whole = whole(recorded.clone());
    for length in [7_001, 60_000] {
        let found = in_sections(&recorded, length).unwrap();
        let (one, other) = (take(&whole), take(&found));
        assert!(other.sections > 5, "{}", other.sections);
        assert_eq!(one.samples, other.samples);
        assert_eq!(one.duration(), other.duration());
        let (a, b) = (&one.segmentation, &other.segmentation);
        assert_eq!(a.strokes.len(), b.strokes.len());
        assert_eq!(a.rejected.len(), b.rejected.len());
        for (a, b) in a.strokes.iter().zip(&b.strokes) {
            assert!(a.steady.start.abs_diff(b.steady.start) <= 50, "{a:?} {b:?}");
            assert!(a.steady.end.abs_diff(b.steady.end) <= 50, "{a:?} {b:?}");
        }
        let (a, b) = (&whole.groups[0].summary, &found.groups[0].summary);
        assert_eq!((a.strokes, a.recordings), (b.strokes, b.recordings));
        assert_near("rms", b.rms.mean, a.rms.mean, 2e-3);
        assert_near("scatter of rms", b.rms.sd, a.rms.sd, 0.02);
        let friction = |of: &piezotact::compare::Summary| of.friction_coefficient.unwrap().mean;
        assert_near("friction", friction(b), friction(a), 5e-3);
        let power = |values: &[f64]| values[4..200].iter().sum::<f64>();
        assert_near("PSD", power(&b.psd.mean), power(&a.psd.mean), 5e-3);
        assert_near("scatter of PSDs", power(&b.psd.sd), power(&a.psd.sd), 0.03);
        let each = |study| {
            let analysis: &piezotact::feature::Analysis = take(study).analysis.as_ref().unwrap();
            analysis
                .strokes
                .iter()
                .map(|s| s.start_s)
                .collect::<Vec<_>>()
        };
        for (a, b) in each(&whole).iter().zip(each(&found)) {
            assert!((a - b).abs() < 0.011, "{a} {b}");
        }
        // It can be handed out, and single spectra are not kept.
        let document = AnalysisDocument::of(&found);
        let value = serde_json::to_value(Document::of(&document)).unwrap();
        assert_eq!(value["recordings"][0]["sections"], other.sections);
        assert!(b.psd.each.is_empty());
    }
}

/// The samples that are kept end within the longest stroke, in which copies are looked for.
#[test]
fn what_is_kept_may_end_within_a_stroke() {
    let (recorded, middle) = (1..)
        .find_map(|seed| {
            let recorded = of(&NAMES, &touched(14, seed));
            let take = cut(recorded.clone(), &Stated::nothing()).unwrap();
            let strokes = take.segmentation.strokes.iter().map(|s| s.steady);
            let longest = strokes.max_by_key(|part| part.len()).unwrap();
            let middle = longest.start.midpoint(longest.end);
            (middle > SECTION_BYTES / 32).then_some((recorded, middle))
        })
        .unwrap();
    let found = in_sections(&recorded, middle).unwrap();
    let take = take(&found);
    assert!(take.sections > 1 && take.recording.len() == middle);
    assert_eq!(take.segmentation.strokes.len(), 14);
}

/// While nobody touches for a while, noise, hum and the drift of a force cell are no strokes, and a force of the other sign is none of a
/// finger.
#[test]
fn a_long_pause_holds_no_strokes() {
    for (sign, seed) in [(1.0, 1), (-1.0, 2), (1.0, 3), (-1.0, 4)] {
        let mut signals = touched(20, seed);
        let mut random = Random::new(90 + seed);
        let pause = 60 * RATE_HZ as usize;
        let end = signals.each_ref().map(|signal| *signal.last().unwrap());
        for i in 0..pause {
            let t = i as f64 / RATE_HZ;
            let hum = 0.02 * (std::f64::consts::TAU * 50.0 * t).sin();
            signals[0].push(0.01 * random.normal() + hum);
            for axis in 1..4 {
                signals[axis].push(end[axis] + 0.002 * random.normal() + 1e-4 * t);
            }
        }
        let later = touched(20, 10 + seed);
        for (signal, later) in signals.iter_mut().zip(later) {
            signal.extend(later);
        }
        signals[3].iter_mut().for_each(|force| *force *= sign);
        let found = in_sections(&of(&NAMES, &signals), 20_000).unwrap();
        let take = take(&found);
        assert_eq!(take.segmentation.strokes.len(), 40, "{sign} {seed}");
        let zeros = take.segmentation.force_zeros.as_ref().unwrap();
        assert!(zeros.sign * sign > 0.0);
        let pause = signals[0].len() / 2;
        let inside = |at: usize| at.abs_diff(pause) < 20 * RATE_HZ as usize;
        assert!(
            take.segmentation
                .strokes
                .iter()
                .all(|s| !inside(s.steady.start)),
            "a stroke in the pause"
        );
    }
}

/// A finger that never lifts, and a recording without force or speed, cannot be divided; one without a touch has no strokes.
#[test]
fn what_cannot_be_divided_is_refused_with_its_place() {
    let signals = touched(40, 5);
    let held = |signal: &Vec<f64>| {
        let force = signal.iter().map(|force| 1.0 + 0.2 * force);
        force.collect::<Vec<f64>>()
    };
    let never = [
        signals[0].clone(),
        held(&signals[1]),
        held(&signals[2]),
        vec![1.0; signals[3].len()],
    ];
    let said = |names: &[&str], signals: &[Vec<f64>]| {
        in_sections(&of(names, signals), 20_000)
            .unwrap_err()
            .to_string()
    };
    let alone = said(&NAMES[..1], &signals[..1]);
    assert!(alone.contains("expected pauses without contact"), "{alone}");
    assert!(alone.contains("from 0 s on"), "{alone}");
    let dead = said(&NAMES, &never);
    assert!(dead.contains("expected"), "{dead}");
}

/// A sensor that gives one value in some sections loses their strokes, and no others, also where every contact is a stroke.
#[test]
fn a_sensor_that_fails_for_a_while_loses_the_strokes_of_that_while() {
    let mut signals = touched(60, 6);
    let half = signals[0].len() / 2;
    signals[0][half..].fill(0.25);
    let recorded = of(&NAMES, &signals);
    for judging in [Judging::Sliding, Judging::ContactOnly] {
        let stated = Stated {
            judging,
            ..Stated::nothing()
        };
        let found = stated_in_sections(&recorded, 20_000, &stated).unwrap();
        let take = take(&found);
        let kept = take.segmentation.strokes.len();
        let rejected = &take.segmentation.rejected;
        // Those of the section in which it failed are lost in part.
        assert!((25..=34).contains(&kept), "{judging:?}: {kept}");
        // No contact is lost: each of the others is rejected, with its reason.
        let starts: Vec<usize> = (take.segmentation.strokes.iter())
            .map(|stroke| stroke.contact.start)
            .chain(rejected.iter().map(|part| part.interval.start))
            .collect();
        let whole = cut(recorded.clone(), &stated).unwrap().segmentation;
        for part in whole.rejected.iter().map(|part| part.interval) {
            let near = starts.iter().any(|start| start.abs_diff(part.start) < 500);
            let mut around = starts.clone();
            around.sort_by_key(|start| start.abs_diff(part.start));
            around.truncate(3);
            assert!(near, "{judging:?}: {part:?}, found {around:?}");
        }
        let unrecorded = |reason: &Reason| matches!(reason, Reason::CutByRecording);
        let unrecorded = rejected.iter().filter(|part| unrecorded(&part.reason));
        let unrecorded = unrecorded.count();
        assert_eq!(
            unrecorded > 20,
            judging == Judging::ContactOnly,
            "{unrecorded}"
        );
        let analysis = take.analysis.as_ref().unwrap();
        assert_eq!(analysis.strokes.len(), kept);
    }
}
