//! The generator makes what its truth says, and a reduced benchmark.

use super::*;

use piezotact::feature::StrokeFeatures;
use piezotact::statistics::{mean, rms};

/// Level, forces and line of a stroke are those that a conclusion is held against.
#[test]
fn the_truth_is_what_was_made() {
    let mut draws = Draws::of(1, "test");
    let plan = Plan::usual(Texture::Medium);
    let made = generate(&plan, &mut draws);
    assert_eq!(made.len(), 9);
    for (place, one) in made.iter().enumerate() {
        let surface = one.surface.as_ref().unwrap();
        let take = cut(one.recorded(place).unwrap(), &Stated::nothing()).unwrap();
        assert_eq!(take.segmentation.strokes.len(), plan.strokes);
        let rate = take.recording.rate();
        let config = piezotact::feature::FeatureConfig::usual(rate, &[5_000], None).unwrap();
        let found =
            piezotact::feature::analyse(&take.recording, &take.segmentation, &config).unwrap();
        let over = |value: &dyn Fn(&StrokeFeatures) -> f64| {
            mean(&found.strokes.iter().map(value).collect::<Vec<_>>())
        };
        let friction = over(&|s| s.friction_coefficient.unwrap().mean);
        assert!(
            (friction / surface.friction - 1.0).abs() < 0.05,
            "{friction}"
        );
        let force_n = over(&|s| s.normal_force_n.unwrap().mean);
        assert!((force_n / one.true_load_n - 1.0).abs() < 0.05, "{force_n}");
        // Six strokes of 0.6 dB, and the gesture of 0.2 m/s² rms.
        let level = over(&|s| (s.rms * s.rms - 0.045).max(0.0)).sqrt();
        let expected = surface.level_at(one.true_speed_m_s, one.true_load_n);
        assert!((level / expected).ln().abs() < 0.15, "{level} {expected}");
        // Over whole periods of the line at v/λ it is no noise: 0.7·0.6 of the power.
        let [(period_m, _)] = surface.combs[..] else {
            panic!("{surface:?}");
        };
        let stroke = take.segmentation.strokes[0].steady;
        let [x, path_m] = [&one.acceleration, &one.path_m].map(|all| stroke.of(all));
        let product = |shift: f64| {
            let turn = |at_m: &f64| std::f64::consts::TAU * (at_m / period_m + shift);
            let each = x.iter().zip(path_m).map(|(x, at_m)| x * turn(at_m).sin());
            each.sum::<f64>() / x.len() as f64
        };
        let power = 2.0 * product(0.0).hypot(product(0.25)).powi(2);
        let share = power / rms(x).powi(2);
        assert!((0.2..0.8).contains(&share), "{place}: {share}");
    }
}

/// One seed of a texture, with the kinds that are most unlike each other: nothing false is said, and what is right is.
#[test]
fn no_conclusion_is_false() {
    no_conclusion_is_false_of(vec![Texture::Medium]);
}

#[test]
#[ignore = "a second texture: ./x soak runs it"]
fn soak_no_conclusion_is_false() {
    no_conclusion_is_false_of(vec![Texture::Medium, Texture::Rough]);
}

fn no_conclusion_is_false_of(textures: Vec<Texture>) {
    let names = [
        "three speeds",
        "motor 37, 74, 111 Hz",
        "copies as speeds",
        "copy as another sample",
        "speeds swapped",
        "no contact",
        "motor while sliding",
        "lead screw 0.9 mm",
        "in g, one sample",
    ];
    let mut part = Part {
        textures,
        seeds: vec![1],
        ..Part::all()
    };
    part.kinds.retain(|kind| names.contains(&kind.name));
    assert_eq!(part.kinds.len(), names.len());
    let judged = judge(&part).unwrap();
    let all = judged.iter().flat_map(|one| &one.conclusions);
    let false_ones = all.filter(|one| one.fact == Fact::False);
    let false_ones: Vec<String> = false_ones.map(ToString::to_string).collect();
    assert!(totals(&judged).is_empty(), "{}", false_ones.join("\n"));
}
