//! Prepared drives as a report.

use std::collections::BTreeMap;

use super::{Prepared, PreparedDrives, State};
use crate::criterion::Outcome;
use crate::figure::{Axis, Chart, Figure, Line, Tone, range};
use crate::number::{counted, digits, signed};
use crate::page::{Block, Cell, Column, Ending, Number, Page, Shown, Table};
use crate::quantity::{Band, Decibels};
use crate::verify::Verification;
use crate::warning::words::percent;

impl Shown for PreparedDrives {
    fn ending(&self) -> Ending {
        let is = |state: State| self.textures.iter().any(|one| one.state == state);
        if is(State::NotPassed) || is(State::NotRendered) {
            return Ending::NotPassed;
        }
        if is(State::NotDecided) || is(State::Rehearsed) || is(State::NotMeasured) {
            return Ending::NotDecided;
        }
        match is(State::PassedInPart) {
            true => Ending::PassedInPart,
            false => Ending::Done,
        }
    }

    fn page(&self) -> Page {
        let who = self.participant.as_ref();
        let title = match who {
            Some(who) => format!("Drives for {who}"),
            None => "Drives for one participant".into(),
        };
        let origin = match &self.bench {
            Some(bench) => format!("Measured on: {bench}. Transfer function: {}", self.transfer),
            None => format!("Not measured. Transfer function: {}", self.transfer),
        };
        let conclusion = Block::Conclusion {
            text: format!("{}.", self.sentence),
            outcome: Some(self.outcome),
        };
        let mut page = Page::new(title, origin).section(
            "",
            [
                conclusion,
                Block::Numbers {
                    numbers: self.numbers(),
                },
            ],
        );
        let mut drives = vec![Block::Table(self.table())];
        drives.push(Block::Note {
            text: "Stroke: the one that is rendered, with its duration and its rms. Level: of the rendering relative to this stroke. \
                Headroom: how far the peak of the drive is below the limit of the device. Band reached: the share of the band."
                .into(),
        });
        drives.extend(self.failed.iter().map(|failed| Block::Text {
            text: format!("{}: {}", failed.file.display(), failed.why),
        }));
        page = page.section("Drives", drives);
        for one in &self.textures {
            page = page.section(&one.strokes.texture, self.blocks(one));
        }
        let warnings: Vec<_> = self.warnings.iter().cloned().collect();
        if !warnings.is_empty() {
            page = page.warnings(&warnings);
        }
        page.section(
            "Method",
            [Block::Note {
                text: self.method(),
            }],
        )
    }
}

impl PreparedDrives {
    /// One row for each texture: the stroke, the drive and the verdict.
    #[must_use]
    pub fn table(&self) -> Table {
        let mut table = Table::new([
            Column::new("texture", "texture"),
            Column::new("result", "state"),
            Column::new("stroke", "stroke"),
            Column::new("s", "duration_s"),
            Column::new("m/s² rms", "rms_m_s2"),
            Column::new("level, dB", "level_db"),
            Column::new("headroom, dB", "headroom_db"),
            Column::new("band reached", "reached"),
            Column::new("strokes", "strokes"),
        ]);
        table.rows = self.textures.iter().map(|one| self.row(one)).collect();
        table
    }

    fn row(&self, one: &Prepared) -> Vec<Cell> {
        let (strokes, stroke) = (&one.strokes, &one.strokes.stroke);
        let width = |band: &Band| band.high().0 - band.low().0;
        let reached = one.achievable_band_hz.iter().map(width).sum::<f64>();
        let reached = reached / width(&self.band_hz);
        vec![
            Cell::from(strokes.texture.as_str()),
            Cell::from(one.state.word()),
            Cell::Text(format!("{} of {}", stroke.number, stroke.file)),
            Cell::from(stroke.to_s - stroke.from_s),
            Cell::from(stroke.rms_m_s2),
            Cell::from(one.level_db),
            Cell::from(one.headroom_db),
            match &one.drive {
                Some(_) => Cell::Text(percent(reached)),
                None => Cell::from(None),
            },
            Cell::Text(strokes.strokes.to_string()),
        ]
    }

    fn numbers(&self) -> Vec<Number> {
        let passed = self.textures.iter();
        let passed = passed.filter(|one| one.state == State::Passed).count();
        let mut numbers = vec![Number::new(
            format!("{passed} of {}", self.textures.len()),
            "drives passed",
        )];
        if let Some(level_db) = self.level_db {
            let name = match &self.level_set_by {
                Some(texture) => format!("level of all textures, set by {texture}"),
                None => "level of all textures relative to their strokes".into(),
            };
            numbers.push(Number::new(format!("{} dB", signed(level_db, 1)), name));
        }
        // Several stimuli can be made of one sample's strokes.
        let files = self.textures.iter().map(|one| &one.strokes);
        let of_files: BTreeMap<&str, usize> = files
            .map(|strokes| (strokes.stroke.file.as_str(), strokes.strokes))
            .collect();
        let strokes: usize = of_files.values().sum();
        numbers.push(Number::new(strokes.to_string(), "strokes found"));
        numbers
    }

    fn blocks(&self, one: &Prepared) -> Vec<Block> {
        let stroke = &one.strokes.stroke;
        let distance = stroke.distance_db.map_or(String::new(), |distance_db| {
            format!(
                ", {} dB rms from the median of its strokes",
                digits(distance_db)
            )
        });
        let conclusion = format!("{}: {}.", one.strokes.texture, one.sentence);
        let mut blocks = vec![Block::conclusion(conclusion, None)];
        blocks.push(Block::Text {
            text: format!(
                "Rendered: stroke {} of {}, {:.2} to {:.2} s{distance}. Texture: {} in {}, of which one is usually {} dB rms from \
                 the median.",
                stroke.number,
                stroke.file,
                stroke.from_s,
                stroke.to_s,
                counted(one.strokes.strokes, "stroke"),
                counted(one.strokes.recordings, "recording"),
                digits(one.strokes.spread_db),
            ),
        });
        if let Some(verification) = &one.verification {
            let open = verification.criteria.iter();
            let open: Vec<_> = open.filter(|c| c.outcome != Outcome::Met).collect();
            if !open.is_empty() {
                blocks.push(Block::Table(Table::of_criteria(open)));
            }
            blocks.push(Block::Figure(spectra(verification)));
        }
        let warnings: Vec<_> = one.warnings.iter().cloned().collect();
        if !warnings.is_empty() {
            let warnings = crate::warning::merged(&warnings);
            blocks.push(Block::warnings(&one.strokes.texture, warnings));
        }
        blocks
    }

    fn method(&self) -> String {
        let level = match self.level_db {
            Some(_) => {
                "All textures were rendered at one level relative to their strokes, so that differences in level between them are kept."
            }
            None => "Each texture was rendered at its own level.",
        };
        let measured = match (&self.bench, self.mode) {
            (None, _) => "The drives were not played.",
            (_, Some(_)) => {
                "Each drive was corrected in a closed loop; the last measurement, which was used neither to correct nor to select \
                 it, is compared with its stroke."
            }
            (_, None) => {
                "Each drive was played once and what was measured is compared with its stroke."
            }
        };
        format!(
            "Of each texture, the stroke is rendered whose levels in third octaves over {} lie closest to the median of all \
             strokes of this texture (the steady part of the stroke, high-pass filtered at 5 Hz). {level} {measured} Criteria and \
             limits are those of every verification.",
            self.band_hz
        )
    }
}

/// The spectra of the stroke and of what was measured.
fn spectra(v: &Verification) -> Figure {
    let decibels = |powers: &[f64]| -> Vec<(f64, f64)> {
        let powers = powers.iter().map(|power| Decibels::from_power(*power).0);
        v.frequency_hz.iter().copied().zip(powers).collect()
    };
    let (target, measured) = (decibels(&v.target_psd), decibels(&v.measured_psd));
    let (low_hz, high_hz) = ((v.band_hz.low().0 * 0.6).max(1.0), v.band_hz.high().0 * 1.4);
    let (low, high) = range(&[&target, &measured], low_hz, high_hz, 10.0, 80.0);
    let lines = vec![
        Line::new("stroke", Tone::Pale, target).thick(),
        Line::new("measured on the finger", Tone::Main, measured),
    ];
    let mut chart = Chart::new(
        Axis::log("frequency, Hz", low_hz, high_hz),
        Axis::new(format!("PSD, dB re 1 {}", v.psd_unit), low, high),
        lines,
    );
    chart.shaded = match v.achievable_band_hz.as_slice() {
        [] => vec![(v.band_hz.low().0, v.band_hz.high().0)],
        bands => bands.iter().map(|b| (b.low().0, b.high().0)).collect(),
    };
    chart.captioned(
        "Power spectral densities of the stroke, at the level at which it was rendered, and of what was measured while the drive \
         was played. Shaded: the bands that the drive reaches.",
    )
}
