//! The tables of groups: their numbers, and how they are felt.

use crate::compare::Summary;
use crate::feature::{STROKE_COLUMNS, Statistics};
use crate::number::digits;
use crate::page::{Block, Cell, Column, Table};
use crate::study::words::GROUPS_FELT;
use crate::study::{Group, StudyAnalysis, warnings_of};

/// A group with the setting that it is compared in.
type Placed<'s> = (&'s str, &'s Group);

/// The groups that are compared, with all recordings by group where these are others.
pub(super) fn blocks(study: &StudyAnalysis) -> Vec<Block> {
    let pooled: Vec<Placed<'_>> = study.groups.iter().map(|group| ("", group)).collect();
    let comparisons = study.comparisons();
    let compared: Vec<Placed<'_>> = comparisons
        .iter()
        .flat_map(|one| one.groups.iter().map(|group| (one.setting.as_str(), group)))
        .collect();
    let mut configs = (study.takes.iter()).filter_map(|take| Some(&take.analysis.as_ref()?.config));
    let bands = configs.next().map_or_else(String::new, |config| {
        let from = match config.high_pass {
            Some(_) => "all frequencies that the high-pass leaves",
            None => "all frequencies",
        };
        format!(
            " Rms, crest factor and kurtosis: of {from}; centroid, strongest line and powers: of {}.",
            config.band
        )
    });
    let mut blocks = vec![Block::note(format!(
        "Mean ± standard deviation over strokes.{bands}"
    ))];
    if comparisons.is_empty() {
        blocks.extend(tables(&pooled));
        return blocks;
    }
    blocks.extend(tables(&compared));
    if comparisons.len() > 1 || study.left_out.is_some() {
        let mut all = tables(&pooled);
        all.push(Block::warnings("", warnings_of(&[], &study.groups)));
        blocks.push(Block::folded(
            format!("All recordings, by {}", study.by),
            all,
        ));
    }
    blocks
}

fn tables(groups: &[Placed<'_>]) -> Vec<Block> {
    let mut blocks = vec![usual(groups).into(), features(groups).into()];
    let known = |group: &Group| group.duplex.is_some() || !group.summary.receptors.is_empty();
    if groups.iter().any(|(_, group)| known(group)) {
        if groups.len() > GROUPS_FELT || groups.iter().any(|(setting, _)| !setting.is_empty()) {
            blocks.push(felt(groups).into());
        }
        blocks.push(Block::note(
            "Coarse textures (spatial period above 200 µm) are perceived by a spatial sense, fine ones (below 100 µm) by vibration \
             (Hollins and Risner 2000). Thresholds after Bolanowski et al. (1988) for a large contact; published thresholds differ by \
             15 to 35 dB. Pacinian power: the power of the vibration in multiples of the power at these thresholds, summed over frequency. \
             Merkel and Ruffini are not judged.",
        ));
    }
    blocks
}

/// A column of a table of groups: its heading and name, and its cell.
struct Shown {
    heading: String,
    name: &'static str,
    cell: Box<dyn Fn(&Summary) -> Cell>,
}

impl Shown {
    fn new(
        heading: impl Into<String>,
        name: &'static str,
        cell: impl Fn(&Summary) -> Cell + 'static,
    ) -> Self {
        Self {
            heading: heading.into(),
            name,
            cell: Box::new(cell),
        }
    }
}

/// A table of `groups` with the columns of `shown` that some group has.
fn table(groups: &[Placed<'_>], shown: Vec<Shown>) -> Table {
    let measured = |column: &Shown| {
        let mut cells = groups
            .iter()
            .map(|(_, group)| (column.cell)(&group.summary));
        cells.any(|cell| cell != Cell::Missing(()))
    };
    let shown: Vec<Shown> = shown.into_iter().filter(measured).collect();
    let several = groups.iter().any(|(setting, _)| !setting.is_empty());
    let setting = several.then(|| Column::new("setting", "setting"));
    let columns = shown.iter().map(|one| Column::new(&one.heading, one.name));
    let first = setting.into_iter().chain([Column::new("group", "group")]);
    let mut table = Table::new(first.chain(columns));
    table.rows = groups
        .iter()
        .map(|(setting, group)| {
            let setting = several.then(|| Cell::from(*setting)).into_iter();
            let name = Cell::from(group.summary.name.as_str());
            let cells = shown.iter().map(|one| (one.cell)(&group.summary));
            setting.chain([name]).chain(cells).collect()
        })
        .collect();
    table
}

/// What a person looks at first.
fn usual(groups: &[Placed<'_>]) -> Table {
    let first = groups.first();
    let unit = first.map_or(String::new(), |(_, group)| group.summary.unit.to_string());
    let of = |value: fn(&Summary) -> Option<Statistics>, scale: f64| {
        move |s: &Summary| spread(value(s), scale, s.strokes)
    };
    let shown = vec![
        Shown::new("strokes", "strokes", |s| Cell::rounded(s.strokes as f64, 0)),
        Shown::new(format!("rms, {unit}"), "rms", of(|s| Some(s.rms), 1.0)),
        Shown::new(
            "friction coefficient",
            "friction_coefficient",
            of(|s| s.friction_coefficient, 1.0),
        ),
        Shown::new(
            "normal force, N",
            "normal_force_n",
            of(|s| s.normal_force_n, 1.0),
        ),
        Shown::new("speed, mm/s", "speed_mm_s", of(|s| s.speed_m_s, 1e3)),
        Shown::new(
            "centroid, Hz",
            "centroid_hz",
            of(|s| Some(s.centroid_hz), 1.0),
        ),
        Shown::new("strongest line, Hz", "strongest_hz", |s| {
            number(Some(s.strongest_hz))
        }),
    ];
    table(groups, shown)
}

/// The other features.
fn features(groups: &[Placed<'_>]) -> Table {
    let columns = STROKE_COLUMNS.iter();
    let columns = columns.filter_map(|column| Some((column.name, column.heading?)));
    // The centroid stands among what is looked at first.
    let mut shown: Vec<Shown> = columns
        .filter(|(name, _)| *name != "centroid_hz")
        .map(|(name, heading)| {
            Shown::new(heading, name, move |s| {
                spread(s.features.get(name).copied(), 1.0, s.strokes)
            })
        })
        .collect();
    shown.extend([
        Shown::new(
            "Pacinian power, × threshold power",
            "pacinian_power",
            |s| spread(s.pacinian_power, 1.0, s.strokes),
        ),
        Shown::new("fingerprint peak, Hz", "fingerprint_hz", |s| {
            number(s.fingerprint.and_then(|f| f.found_hz))
        }),
        Shown::new("ridge wavelength, mm", "ridge_wavelength_mm", |s| {
            number(
                s.fingerprint
                    .and_then(|f| f.ridge_wavelength_m)
                    .map(|m| m * 1e3),
            )
        }),
    ]);
    table(groups, shown)
}

/// By which sense each texture is perceived, and which receptors its vibration excites.
fn felt(groups: &[Placed<'_>]) -> Table {
    let several = groups.iter().any(|(setting, _)| !setting.is_empty());
    let setting = several.then(|| Column::new("setting", "setting"));
    let mut table = Table::new(setting.into_iter().chain([
        Column::new("group", "group"),
        Column::new("texture by the duplex theory", "texture"),
        Column::new("receptors", "receptors"),
    ]));
    table.rows = groups
        .iter()
        .map(|(setting, group)| {
            let receptors = group.summary.receptors.iter();
            let receptors: Vec<String> = receptors.map(ToString::to_string).collect();
            let duplex = group.duplex.map(|duplex| duplex.to_string());
            let setting = several.then(|| Cell::from(*setting)).into_iter();
            let cells = [
                Cell::from(group.summary.name.as_str()),
                duplex.map_or(Cell::Missing(()), Cell::from),
                Cell::from(receptors.join("; ")),
            ];
            setting.chain(cells).collect()
        })
        .collect();
    table
}

fn number(value: Option<f64>) -> Cell {
    value.map_or(Cell::Missing(()), Cell::from)
}

/// Mean ± standard deviation, both with the decimals that give the mean three digits.
fn spread(value: Option<Statistics>, scale: f64, strokes: usize) -> Cell {
    let Some(s) = value else {
        return Cell::Missing(());
    };
    let value = s.mean * scale;
    let mean = digits(value);
    // What was stated for all strokes has no spread.
    let text = if strokes < 2 || s.sd <= 0.0 {
        mean
    } else if mean.contains('e') {
        format!("{mean} ± {}", digits(s.sd * scale))
    } else {
        // The spread shows one digit that counts, where one more decimal is enough for it.
        let decimals = mean.split_once('.');
        let usual = decimals.map_or(0, |(_, decimals)| decimals.len());
        let needed = (-(s.sd * scale).abs().max(1e-9).log10()).ceil().max(0.0) as usize;
        let decimals = needed.clamp(usual, usual + 1);
        if s.sd * scale < 0.5 * 0.1f64.powi(decimals as i32) {
            mean
        } else {
            format!("{value:.decimals$} ± {:.decimals$}", s.sd * scale)
        }
    };
    Cell::Rounded {
        value,
        text: text.replace('-', "−"),
    }
}
