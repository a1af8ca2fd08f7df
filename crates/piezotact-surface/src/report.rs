//! The report on a surface.

use crate::roughness::{
    ArealRoughness, EvaluatedSurface, HeightDistribution, HeightProfile, ProfileFilter,
    ProfileRoughness, Roughness, distribution_of, height_span_m, length_text, short_number,
    unit_for,
};
use maud::{Markup, html};
use piezotact::document::Words;
use piezotact::figure::{Axis, Chart, Heatmap, Line, Mark, Tone};
use piezotact::number::digits_that_count;

use piezotact_report::chart::HEIGHT;
use piezotact_report::report::warnings_section;
use piezotact_report::{Draw, DrawError, document, figure, file_name};

const SURFACE: Tone = Tone::Signal;
const MEAN: Tone = Tone::Accent;
const BORDER: Tone = Tone::Border;

/// Points along a side of the image of a map, at most.
const PIXELS: usize = 400;
/// The parameters that stand large at the top.
const FIRST: [&str; 8] = ["Ra", "Rq", "Rz", "RSm", "Sa", "Sq", "Sz", "Sdr"];

/// The report as HTML, with warnings in `words`.
///
/// # Errors
/// [`DrawError`] where a figure cannot be drawn.
pub fn html(surface: &EvaluatedSurface, words: &dyn Words) -> Result<String, DrawError> {
    let title = format!("Roughness of {}", file_name(&surface.file));
    let figures = match &surface.roughness {
        Roughness::Profile(roughness) => profile_figures(roughness)?,
        Roughness::Map(roughness) => map_figures(roughness)?,
    };
    let body = html! {
        h1 { (title) }
        p.soft { (surface.format) ": " (surface.roughness.size_text()) "." }
        (numbers(surface))
        (warnings_section(&surface.warnings.merged(), words))
        (figures)
        (table(surface))
    };
    Ok(document(&title, &body))
}

fn numbers(surface: &EvaluatedSurface) -> Markup {
    html! {
        section class="verdict" {
            strong { (surface.roughness.method_text()) }
            div.numbers {
                @for parameter in surface.roughness.parameters().iter().filter(|p| FIRST.contains(&p.symbol)) {
                    div {
                        b { (parameter.symbol) " " (parameter.number()) " " (parameter.value.map_or("", |_| parameter.unit)) }
                        span { (parameter.meaning) }
                    }
                }
            }
        }
    }
}

fn table(surface: &EvaluatedSurface) -> Markup {
    let stated = surface.instrument.as_ref();
    html! {
        section {
            h2 { "All parameters" }
            table {
                tr {
                    th { "parameter" } th.n { "value" }
                    @if stated.is_some() { th.n { "instrument" } }
                    th { "unit" } th { "meaning" }
                }
                @for parameter in surface.roughness.parameters() {
                    tr {
                        td { b { (parameter.symbol) } }
                        td.n { (parameter.number()) }
                        @if let Some(stated) = stated {
                            td.n { (stated.value_of(&parameter).map_or_else(|| "–".into(), |value| digits_that_count(value, 4))) }
                        }
                        td { @if parameter.value.is_some() { (parameter.unit) } }
                        td { (parameter.meaning) }
                    }
                }
            }
            p.soft { "A dash: this parameter has no value for this surface; if that is a warning, the reason is listed above." }
            @if let Some(stated) = stated {
                p.soft { "Instrument (" (file_name(&stated.file)) "): " (stated.text()) "." }
            }
            p.soft { (concat!("piezotact ", env!("CARGO_PKG_VERSION"))) }
        }
    }
}

/// The unit of heights on an axis: the one in which the largest is neither tiny nor huge.
fn height_unit(heights_m: &[f64]) -> (&'static str, f64) {
    let measured = heights_m.iter().filter(|z| !z.is_nan());
    match measured.fold(0.0f64, |most, z| most.max(z.abs())) {
        m if m < 0.2e-6 => ("nm", 1e9),
        m if m < 5e-3 => ("µm", 1e6),
        _ => ("mm", 1e3),
    }
}

/// The unit of places along a line.
fn place_unit(length_m: f64) -> (&'static str, f64) {
    unit_for(length_m / 10.0)
}

/// Heights over their place; one line for each stretch that was measured.
fn stretches(heights_m: &[f64], step: f64, per_m: f64) -> Vec<Vec<(f64, f64)>> {
    let points: Vec<(f64, f64)> = heights_m
        .iter()
        .enumerate()
        .map(|(i, z)| (i as f64 * step, z * per_m))
        .collect();
    points
        .split(|(_, z)| z.is_nan())
        .filter(|stretch| !stretch.is_empty())
        .map(<[(f64, f64)]>::to_vec)
        .collect()
}

/// An axis for all lines, with room for a legend above them where they have labels.
fn height_axis(unit: &str, lines: &[Line]) -> Axis {
    let values = || lines.iter().flat_map(|l| l.points.iter().map(|p| p.1));
    let low = values().fold(f64::MAX, f64::min);
    let high = values().fold(f64::MIN, f64::max);
    let (low, high) = if low <= high { (low, high) } else { (0.0, 0.0) };
    let room = 0.06 * (high - low).max(1e-3 * high.abs()).max(0.1);
    let labels = lines.iter().filter(|line| !line.label.is_empty()).count();
    let above = if labels == 0 {
        1.0
    } else {
        2.0 + 2.5 * labels as f64
    };
    Axis::new(format!("height, {unit}"), low - room, high + above * room)
}

fn along(profile: &HeightProfile, label: &str, colour: Tone, per_m: (f64, f64)) -> Line {
    let step = profile.step_m() * per_m.0;
    let points = stretches(profile.heights_m(), step, per_m.1).concat();
    Line::new(label, colour, points)
}

/// The axis along a profile, and how many of its unit make a metre.
fn position_axis(profile: &HeightProfile) -> (Axis, f64) {
    let (unit, per_m) = place_unit(profile.length_m());
    let label = format!("position, {unit}");
    (Axis::new(label, 0.0, profile.length_m() * per_m), per_m)
}

/// The profile before the filter, with its mean line.
fn before_filter(r: &ProfileRoughness) -> Result<String, DrawError> {
    let primary = r.primary();
    let (x, per_place) = position_axis(&primary);
    let (unit, per_m) = height_unit(primary.heights_m());
    let lines = vec![
        along(&primary, "primary profile", SURFACE, (per_place, per_m)).thin(),
        along(&r.mean_line, "mean line", MEAN, (per_place, per_m)),
    ];
    Chart::new(x, height_axis(unit, &lines), lines).svg(HEIGHT)
}

fn profile_figures(r: &ProfileRoughness) -> Result<Markup, DrawError> {
    let (x, per_place) = position_axis(&r.roughness);
    let (unit, per_m) = height_unit(r.roughness.heights_m());
    let rough = along(&r.roughness, "", SURFACE, (per_place, per_m)).thin();
    let y = height_axis(unit, std::slice::from_ref(&rough));
    let borders: Vec<f64> = r
        .section_borders()
        .iter()
        .map(|point| *point as f64 * r.roughness.step_m() * per_place)
        .collect();
    let mut lines: Vec<Line> = borders
        .iter()
        .map(|x| {
            Line::new("", BORDER, vec![(*x, y.low), (*x, y.high)])
                .marked(Mark::Dashed)
                .thin()
        })
        .collect();
    lines.push(rough);
    let mut chart = Chart::new(x, y, lines);
    chart.shaded = borders
        .first()
        .copied()
        .zip(borders.last().copied())
        .into_iter()
        .collect();
    let rough = chart.svg(HEIGHT)?;

    let evaluated = &r.roughness.heights_m()[r.evaluated.clone()];
    let filtered = r.config.filter == ProfileFilter::Gauss;
    Ok(html! {
        @if filtered {
            section {
                h2 { "Profile" }
                (figure(&before_filter(r)?, "The primary profile, without its form, and its mean line."))
            }
        }
        section {
            h2 { @if filtered { "Roughness profile" } @else { "Profile without its form" } }
            (figure(&rough, "Shaded: the evaluation length. Dashed: the limits of its sections."))
        }
        (distribution(evaluated)?)
    })
}

fn map_figures(r: &ArealRoughness) -> Result<Markup, DrawError> {
    let map = &r.surface;
    let (place, per_place) = place_unit(map.length_x_m().max(map.length_y_m()));
    let coarse = map.coarser(PIXELS);
    let (low, high) = height_span_m(map.heights_m());
    let (unit, per_m) = height_unit(&[low, high]);
    let values: Vec<f64> = coarse.heights_m().iter().map(|z| z * per_m).collect();
    let image = Heatmap {
        values,
        columns: coarse.columns(),
        size: (map.length_x_m() * per_place, map.length_y_m() * per_place),
        length_unit: place.into(),
        scale: (low * per_m, high * per_m),
        label: format!("height, {unit}"),
    };
    let row = map.rows() / 2;
    let heights_m = &map.heights_m()[row * map.columns()..(row + 1) * map.columns()];
    let (unit, per_m) = height_unit(heights_m);
    let lines: Vec<Line> = stretches(heights_m, map.step_x_m() * per_place, per_m)
        .into_iter()
        .map(|points| Line::new("", SURFACE, points).thin())
        .collect();
    let lines_drawn = !lines.is_empty();
    let x = Axis::new(format!("x, {place}"), 0.0, map.length_x_m() * per_place);
    let middle = Chart::new(x, height_axis(unit, &lines), lines).svg(HEIGHT - 20)?;
    let grey = if map.missing_share() > 0.0 {
        " Grey: not measured."
    } else {
        ""
    };
    let at = short_number(row as f64 * map.step_y_m() * per_place);
    let gaps = match heights_m.iter().filter(|z| z.is_nan()).count() {
        0 => "",
        _ => " Gaps: not measured.",
    };
    Ok(html! {
        section {
            h2 { "Heights" }
            (figure(&piezotact_report::heatmap::svg(&image)?, &format!(
                "The surface that was evaluated, its first row at the top. The colours span 99 % of the heights.{grey}"
            )))
        }
        section {
            h2 { "Profile through the middle" }
            @if lines_drawn {
                (figure(&middle, &format!("Row {row}, at y = {at} {place}.{gaps}")))
            } @else {
                p.soft { (format!("Row {row}, at y = {at} {place}: nothing was measured there.")) }
            }
        }
        (distribution(map.heights_m())?)
    })
}

fn distribution(heights_m: &[f64]) -> Result<Markup, DrawError> {
    let Some(found) = distribution_of(heights_m) else {
        return Ok(html! {});
    };
    let classes = found.shares.len();
    let (unit, per_m) = height_unit(&found.borders_m);
    Ok(html! {
        section {
            h2 { "Distribution of heights" }
            (figure(&shares(&found, unit, per_m)?, &format!(
                "Histogram of the heights of the evaluated points, in {classes} classes of {}. The axis spans 99 % of the \
                    heights.",
                length_text(found.borders_m[1] - found.borders_m[0])
            )))
            (figure(&material(&found, unit, per_m)?, "The material ratio (Abbott) curve: the share of the surface above each \
                height."))
        }
    })
}

fn shares(found: &HeightDistribution, unit: &str, per_m: f64) -> Result<String, DrawError> {
    let mut points: Vec<(f64, f64)> = Vec::new();
    let mut before = 0.0;
    for (border_m, share) in found
        .borders_m
        .iter()
        .zip(found.shares.iter().chain([&0.0]))
    {
        let height = border_m * per_m;
        points.extend([(height, before), (height, share * 100.0)]);
        before = share * 100.0;
    }
    let most = points.iter().fold(0.0f64, |most, p| most.max(p.1));
    let (low, high) = span(found, per_m);
    Chart::new(
        Axis::new(format!("height, {unit}"), low, high),
        Axis::new("share of points, %", 0.0, most * 1.08),
        vec![Line::new("", SURFACE, points)],
    )
    .svg(HEIGHT - 40)
}

fn material(found: &HeightDistribution, unit: &str, per_m: f64) -> Result<String, DrawError> {
    let points = found
        .material_ratio
        .iter()
        .zip(&found.borders_m)
        .map(|(ratio, height_m)| (ratio * 100.0, height_m * per_m))
        .collect();
    let (low, high) = span(found, per_m);
    Chart::new(
        Axis::new("material ratio, %", 0.0, 100.0),
        Axis::new(format!("height, {unit}"), low, high),
        vec![Line::new("", SURFACE, points)],
    )
    .svg(HEIGHT - 40)
}

/// From the lowest to the highest border, with a little room.
fn span(found: &HeightDistribution, per_m: f64) -> (f64, f64) {
    let ends = (found.borders_m.first(), found.borders_m.last());
    let (low, high) = (
        ends.0.copied().unwrap_or(0.0),
        ends.1.copied().unwrap_or(0.0),
    );
    let room = 0.03 * (high - low);
    ((low - room) * per_m, (high + room) * per_m)
}
