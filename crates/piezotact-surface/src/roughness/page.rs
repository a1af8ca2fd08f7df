//! The report on a surface.

use std::path::Path;

use super::{
    ArealRoughness, EvaluatedSurface, HeightDistribution, HeightProfile, LineRoughness,
    ProfileFilter, ProfileRoughness, Roughness, Texture, distribution_of, height_span_m,
    length_text, short_number, unit_for,
};
use piezotact::figure::{Axis, Chart, Drawn, Figure, Heatmap, Line, Mark, Scale, Tone};
use piezotact::number::digits_that_count;
use piezotact::page::{Block, Cell, Column, Number, Page, Section, Shown, Table};
use piezotact::surface::HeightMap;

const SURFACE: Tone = Tone::Signal;
const MEAN: Tone = Tone::Accent;
const BORDER: Tone = Tone::Border;

/// Points along a side of the image of a map, at most.
const PIXELS: usize = 400;
/// The parameters that stand large at the top.
const FIRST: [&str; 8] = ["Ra", "Rq", "Rz", "RSm", "Sa", "Sq", "Sz", "Sdr"];

impl Shown for EvaluatedSurface {
    fn page(&self) -> Page {
        let page = Page::new(format!("Roughness of {}", file_name(&self.file)), "");
        let first = self.roughness.parameters().into_iter();
        let first = first.filter(|parameter| FIRST.contains(&parameter.symbol));
        let numbers = first.map(|parameter| {
            let unit = parameter.value.map_or("", |_| parameter.unit);
            let value = format!("{} {} {unit}", parameter.symbol, parameter.number());
            Number::new(value.trim_end(), parameter.meaning)
        });
        let conclusion = format!(
            "{}: {} ({}). {}.",
            file_name(&self.file),
            self.roughness.size_text(),
            self.format,
            self.roughness.method_text()
        );
        let mut first = vec![Block::conclusion(conclusion, None)];
        first.extend(self.instrument.as_ref().map(|stated| {
            let stated = format!(
                "Instrument ({}): {}.",
                file_name(&stated.file),
                stated.text()
            );
            Block::conclusion(stated, None)
        }));
        if let Roughness::Map(roughness) = &self.roughness {
            let texture = roughness.texture.iter().map(Texture::text);
            let lines = self.lines.iter().map(LineRoughness::text);
            first.extend(
                texture
                    .chain(lines)
                    .map(|text| Block::conclusion(text, None)),
            );
        }
        first.push(Block::numbers(numbers));
        let mut page = page.section("", first).warnings(&self.warnings);
        page.sections.extend(match &self.roughness {
            Roughness::Profile(roughness) => profile_figures(roughness),
            Roughness::Map(roughness) => map_figures(roughness),
        });
        let note = "A dash means that the parameter has no value for this surface. If a warning above concerns it, it gives the reason.";
        let all = [self.parameters_table().into(), Block::note(note)];
        let mut page = page.section("All parameters", all);
        match &self.roughness {
            Roughness::Profile(roughness) => page.rows(roughness.points_table()),
            Roughness::Map(roughness) => {
                let texture = roughness.texture.as_ref().map(texture_section);
                let lines = self.lines.as_ref().map(line_section);
                page.sections.extend(texture.into_iter().chain(lines));
                page
            }
        }
    }
}

impl EvaluatedSurface {
    fn parameters_table(&self) -> Table {
        let stated = self.instrument.as_ref();
        let mut columns = vec![
            Column::new("parameter", "parameter"),
            Column::new("value", "value"),
            Column::new("unit", "unit"),
            Column::new("meaning", "meaning"),
        ];
        if stated.is_some() {
            columns.insert(2, Column::new("instrument", "instrument"));
        }
        let mut table = Table::new(columns);
        let rows = self.roughness.parameters().into_iter().map(|parameter| {
            let value = parameter
                .value
                .map_or(Cell::Missing(()), |value| Cell::Rounded {
                    value,
                    text: parameter.number(),
                });
            let unit = parameter.value.map_or("", |_| parameter.unit);
            let mut row = vec![
                Cell::from(parameter.symbol),
                value,
                Cell::from(unit),
                Cell::from(parameter.meaning),
            ];
            if let Some(stated) = stated {
                let value = stated.value_of(&parameter).map(|value| Cell::Rounded {
                    value,
                    text: digits_that_count(value, 4),
                });
                row.insert(2, value.unwrap_or(Cell::Missing(())));
            }
            row
        });
        table.rows = rows.collect();
        table
    }
}

/// The name of a file without its folder.
pub(super) fn file_name(path: &Path) -> String {
    path.file_name()
        .unwrap_or(path.as_os_str())
        .to_string_lossy()
        .into_owned()
}

fn section(heading: &str, blocks: impl IntoIterator<Item = Block>) -> Section {
    Section {
        heading: heading.into(),
        blocks: blocks.into_iter().collect(),
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
fn before_filter(r: &ProfileRoughness) -> Figure {
    let primary = r.primary();
    let (x, per_place) = position_axis(&primary);
    let (unit, per_m) = height_unit(primary.heights_m());
    let lines = vec![
        along(&primary, "primary profile", SURFACE, (per_place, per_m)).thin(),
        along(&r.mean_line, "mean line", MEAN, (per_place, per_m)),
    ];
    Chart::new(x, height_axis(unit, &lines), lines)
        .captioned("The primary profile, without its form, and its mean line.")
}

fn profile_figures(r: &ProfileRoughness) -> Vec<Section> {
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
    let rough =
        chart.captioned("Shaded: the evaluation length. Dashed: the limits of its sections.");
    let mut sections = Vec::new();
    let heading = match r.config.filter {
        ProfileFilter::Gauss => {
            sections.push(section("Profile", [before_filter(r).into()]));
            "Roughness profile"
        }
        _ => "Profile without its form",
    };
    sections.push(section(heading, [rough.into()]));
    let evaluated = &r.roughness.heights_m()[r.evaluated.clone()];
    sections.extend(distribution(evaluated));
    sections
}

fn map_figures(r: &ArealRoughness) -> Vec<Section> {
    let map = &r.surface;
    let (place, per_place) = place_unit(map.length_x_m().max(map.length_y_m()));
    let coarse = map.coarser(PIXELS);
    let (low, high) = height_span_m(map.heights_m());
    let (unit, per_m) = height_unit(&[low, high]);
    let values: Vec<f64> = coarse.heights_m().iter().map(|z| z * per_m).collect();
    let grey = match map.missing_share() > 0.0 {
        true => " Grey: not measured.",
        false => "",
    };
    let image = Figure {
        drawn: Drawn::Heatmap(Heatmap {
            values,
            columns: coarse.columns(),
            size: (map.length_x_m() * per_place, map.length_y_m() * per_place),
            length_unit: place.into(),
            scale: (low * per_m, high * per_m),
            label: format!("height, {unit}"),
        }),
        caption: format!(
            "The surface that was evaluated, its first row at the top. The colours span 99 % of the heights.{grey}"
        ),
    };
    let mut sections = vec![
        section("Heights", [image.into()]),
        section(
            "Profile through the middle",
            [middle(map, (place, per_place))],
        ),
    ];
    sections.extend(distribution(map.heights_m()));
    sections
}

fn texture_section(texture: &Texture) -> Section {
    let table = Table::of_criteria(&texture.criteria);
    section("Period", [table.into()])
}

fn line_section(lines: &LineRoughness) -> Section {
    let mut table = Table::new(vec![
        Column::new("parameter", "parameter"),
        Column::new("mean", "mean"),
        Column::new("standard deviation", "standard_deviation"),
        Column::new("unit", "unit"),
        Column::new("meaning", "meaning"),
    ]);
    let rounded = |value: Option<f64>| {
        let text = |value| digits_that_count(value, 4);
        value.map_or(Cell::Missing(()), |value| Cell::Rounded {
            value,
            text: text(value),
        })
    };
    table.rows = (lines.parameters.iter())
        .map(|parameter| {
            vec![
                Cell::from(parameter.mean.symbol),
                rounded(parameter.mean.value),
                rounded(parameter.deviation),
                Cell::from(parameter.mean.unit),
                Cell::from(parameter.mean.meaning),
            ]
        })
        .collect();
    let density = (lines.spectrum.iter()).map(|(per_m, m3)| (per_m * 1e-3, m3 * 1e15));
    let points: Vec<(f64, f64)> = density.filter(|point| point.1 > 0.0).collect();
    let mut blocks = Vec::new();
    if let (Some(first), Some(last)) = (points.first(), points.last()) {
        let x = Axis::log("spatial frequency, 1/mm", first.0, last.0);
        let densities = points.iter().map(|point| point.1);
        let y = Axis::around(
            "power spectral density, µm²·mm",
            Scale::Logarithmic,
            densities,
        );
        let line = Line::new("", SURFACE, points.clone()).marked(Mark::Dots);
        let caption =
            "The power spectral density of the lines, mean over lines, in ten bins a decade.";
        blocks.push(Chart::new(x, y, vec![line]).captioned(caption).into());
    }
    blocks.push(table.into());
    section(&format!("Lines along {}", lines.along), blocks)
}

/// The row through the middle of a map, where anything of it was measured.
fn middle(map: &HeightMap, (place, per_place): (&str, f64)) -> Block {
    let row = map.rows() / 2;
    let heights_m = &map.heights_m()[row * map.columns()..(row + 1) * map.columns()];
    let at = short_number(row as f64 * map.step_y_m() * per_place);
    let (unit, per_m) = height_unit(heights_m);
    let lines: Vec<Line> = stretches(heights_m, map.step_x_m() * per_place, per_m)
        .into_iter()
        .map(|points| Line::new("", SURFACE, points).thin())
        .collect();
    if lines.is_empty() {
        return Block::note(format!(
            "Row {row}, at y = {at} {place}: nothing was measured there."
        ));
    }
    let gaps = match heights_m.iter().any(|z| z.is_nan()) {
        true => " Gaps: not measured.",
        false => "",
    };
    let x = Axis::new(format!("x, {place}"), 0.0, map.length_x_m() * per_place);
    Chart::new(x, height_axis(unit, &lines), lines)
        .captioned(format!("Row {row}, at y = {at} {place}.{gaps}"))
        .into()
}

fn distribution(heights_m: &[f64]) -> Option<Section> {
    let found = distribution_of(heights_m)?;
    let classes = found.shares.len();
    let (unit, per_m) = height_unit(&found.borders_m);
    let class = length_text(found.borders_m[1] - found.borders_m[0]);
    let shares = shares(&found, unit, per_m).captioned(format!(
        "Histogram of the heights of the evaluated points, in {classes} classes of {class}. The axis spans 99 % of the heights."
    ));
    let material = material(&found, unit, per_m).captioned(
        "The material ratio (Abbott) curve: the share of the surface above each height.",
    );
    Some(section(
        "Distribution of heights",
        [shares.into(), material.into()],
    ))
}

fn shares(found: &HeightDistribution, unit: &str, per_m: f64) -> Chart {
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
}

fn material(found: &HeightDistribution, unit: &str, per_m: f64) -> Chart {
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
