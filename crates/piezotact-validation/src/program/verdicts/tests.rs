//! The truth says what was done, and a reduced benchmark.

use super::*;

fn one_scene(texture: Texture) -> Scene {
    let device = Arc::new(Device::of(1, Actuator::Piezo).unwrap());
    Scene::new(texture, 1, &device).unwrap()
}

fn true_of(scene: &Scene, kind: Kind, mode: Mode) -> Truth {
    let case = Case::of(scene, kind, mode).unwrap().unwrap();
    truth(&case, kind, mode, scene.band)
}

/// Faults whose figures are known beforehand: the figure that is farthest over its limit is the one that was made.
#[test]
fn the_truth_is_what_was_done() {
    let scene = one_scene(scene::Texture::Tonal);
    use Kind::*;
    use Mode::{Replicate, Texture};
    let far = 0.6;
    for (kind, mode, fact, worst, found) in [
        (Exact, Replicate, Fact::Right, None, 0.0),
        (Exact, Texture, Fact::Right, None, 0.0),
        (Delay(0.000_137), Replicate, Fact::Right, None, 0.0),
        (RandomPhases, Texture, Fact::Right, None, 0.0),
        (Level(3.0), Texture, Fact::Wrong, None, 3.0),
        (Level(-6.0), Replicate, Fact::Wrong, None, 6.0),
        (
            SensorClips(0.05),
            Texture,
            Fact::Wrong,
            Some(Figure::Clipped),
            0.05,
        ),
        (
            DropOut(0.2),
            Texture,
            Fact::Wrong,
            Some(Figure::DropOut),
            200.0,
        ),
        (
            DropOut(0.5),
            Replicate,
            Fact::Wrong,
            Some(Figure::DropOut),
            500.0,
        ),
        (
            RecordingStops,
            Texture,
            Fact::Wrong,
            Some(Figure::Uncovered),
            0.5,
        ),
    ] {
        let truth = true_of(&scene, kind, mode);
        assert_eq!(truth.fact, fact, "{}: {truth}", kind.name());
        if let Some(worst) = worst {
            assert_eq!(truth.worst, worst, "{}: {truth}", kind.name());
        }
        if fact == Fact::Wrong {
            assert!(
                (truth.found - found).abs() < far,
                "{}: {truth}",
                kind.name()
            );
        }
    }
    // Turned around, a spectrum is the same and a waveform is not.
    assert_eq!(true_of(&scene, Polarity, Texture).fact, Fact::Right);
}

/// A delay between samples, and a waveform upside down, of a texture that is no tone.
#[test]
fn waveforms_count_in_replicate_alone() {
    let scene = one_scene(scene::Texture::Broad);
    use Mode::{Replicate, Texture};
    for (kind, replicate, texture) in [
        (Kind::Polarity, Fact::Wrong, Fact::Right),
        (Kind::Reversed, Fact::Wrong, Fact::Right),
        (Kind::RandomPhases, Fact::Wrong, Fact::Right),
        (Kind::Delay(0.1), Fact::Right, Fact::Right),
        (Kind::StrongestBandMissing, Fact::Wrong, Fact::Wrong),
        (Kind::NoiseInstead, Fact::Wrong, Fact::Wrong),
        (Kind::Wander(1.0), Fact::Wrong, Fact::Right),
    ] {
        for (mode, fact) in [(Replicate, replicate), (Texture, texture)] {
            let truth = true_of(&scene, kind, mode);
            assert_eq!(
                truth.fact,
                fact,
                "{}, {}: {truth}",
                kind.name(),
                mode.name()
            );
        }
    }
}

/// One seed of three textures in both modes, with the kinds that are most unlike each other: the targets of the whole.
#[test]
fn no_verdict_is_wrong() {
    use scene::Texture::{Broad, Tick, Tonal};
    no_verdict_is_wrong_of(vec![Broad, Tonal, Tick]);
}

#[test]
#[ignore = "every texture: ./x soak runs it"]
fn soak_no_verdict_is_wrong() {
    no_verdict_is_wrong_of(Part::all().textures);
}

fn no_verdict_is_wrong_of(textures: Vec<Texture>) {
    use Kind::*;
    let part = Part {
        textures,
        seeds: vec![1],
        kinds: vec![
            Level(-3.0),
            Level(6.0),
            StrongestBandMissing,
            DropOut(0.1),
            TapsLost(1),
            SecondHalfSilent,
            Wander(1.0),
            Polarity,
            Conjugate,
            HumPlaying,
            SensorClips(0.05),
            WrongPerson(0),
            Good,
            RandomPhases,
            OtherPlacement("again"),
            Clock(50e-6),
            LostSamples,
            RenderedAt(-6.0),
        ],
        ..Part::all()
    };
    let judged = judge(&part).unwrap();
    let offending: Vec<String> = judged
        .iter()
        .filter(|one| {
            one.offence()
                .is_some_and(|offence| offence != Offence::NotDecided)
        })
        .map(ToString::to_string)
        .collect();
    assert!(totals(&judged).is_empty(), "{}", offending.join("\n"));
}
