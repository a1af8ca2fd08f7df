//! Axes, ranges, and figures as documents.

use super::*;

#[test]
fn a_range_ends_on_whole_steps() {
    let line = [(1.0, -3.0), (2.0, 14.0), (9.0, 99.0)];
    assert_eq!(range(&[&line], 0.0, 5.0, 10.0, 120.0), (-10.0, 20.0));
    assert_eq!(range(&[&line], 0.0, 5.0, 10.0, 15.0), (5.0, 20.0));
    assert_eq!(range(&[&[]], 0.0, 5.0, 10.0, 15.0), (0.0, 10.0));
}

#[test]
fn an_axis_has_room_around_its_values() {
    let check = |values: &[f64], scale: Scale, expected: (f64, f64)| {
        let axis = Axis::around("x", scale, values.iter().copied());
        assert!((axis.low - expected.0).abs() < 1e-12 && (axis.high - expected.1).abs() < 1e-12);
    };
    check(&[1.0, 10.0], Scale::Linear, (0.0, 10.72));
    check(&[1.0, f64::NAN, 10.0], Scale::Logarithmic, (0.8, 12.5));
    check(&[], Scale::Linear, (0.1, 1.0));
    check(&[9.0, 10.0], Scale::Linear, (8.92, 10.08));
}

/// 7.5, 12.5 and 29.97 mm/s are what was measured; 1, 2, 5, 10 are not.
#[test]
fn ticks_stand_where_it_was_measured() {
    let speeds = [29.97, 7.5, 30.01, 12.5];
    let axis = Axis::around("speed, mm/s", Scale::Logarithmic, speeds.into_iter());
    let ticks = axis.ticks_at(speeds.into_iter()).ticks;
    assert_eq!(ticks.len(), 3);
    let expected = ticks.iter().zip([7.5, 12.5, 30.0]);
    assert!(
        expected
            .clone()
            .all(|(found, value)| (found - value).abs() < 1e-9),
        "{ticks:?}"
    );
}

#[test]
fn a_figure_comes_back_from_its_document() {
    let line = Line::new("a", Tone::Of { index: 1, count: 3 }, vec![(0.0, 1.0)])
        .thick()
        .marked(Mark::Joined)
        .spread(vec![(0.0, 0.5, 1.5)]);
    let figure = Chart::new(
        Axis::log("frequency, Hz", 1.0, 10.0),
        Axis::names("sample", vec!["S1".into()]),
        vec![line],
    )
    .beside()
    .captioned("what it shows");
    let text = serde_json::to_string(&figure).unwrap();
    assert_eq!(serde_json::from_str::<Figure>(&text).unwrap(), figure);
}

/// Where nothing limits an interval, its area has no end: JSON has none either.
#[test]
fn an_area_without_limit_survives_being_saved() {
    let ends = vec![(10.0, f64::NEG_INFINITY, 3.0), (20.0, -1.0, f64::INFINITY)];
    let line = Line::new("H1", Tone::Main, vec![(10.0, 1.0)]).ribbon(ends);
    let saved = serde_json::to_string(&line).unwrap();
    let again: Line = serde_json::from_str(&saved).unwrap();
    assert_eq!(again, line, "{saved}");
}
