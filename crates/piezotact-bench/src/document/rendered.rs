//! The report of rendered textures, in open loop or corrected in a closed loop.

use std::collections::BTreeSet;

use piezotact::correct::{CorrectedRendering, RenderingSums};
use piezotact::criterion::Outcome;
use piezotact::lineage::Mode;
use piezotact::number::{digits, plus, signed};
use piezotact::page::{Block, Cell, Column, Fact, Number, Page, Shown, Table};
use piezotact::quantity::Band;
use piezotact::recording::BenchKind;
use piezotact::verify::{CLOSE_DB, open_and_closed};
use serde::Serialize;

use super::{RenderBatchDocument, RenderDocument};

const UNKNOWN_BENCH: &str = "The measurement does not say which bench it comes from.";
const COLUMNS: &str = "Before the arrow: the open-loop drive. After the arrow: the drive that is kept, from a confirmation measurement \
    that was used neither to correct nor to select it, unless the last column states that there is none. Improvement: how much \
    smaller the error of the best corrected drive is than that of the open loop, in the quantity that the loop minimises (spectrum, or \
    normalised mean square error (NMSE) of the waveform), with its 95 % interval from the scatter of the measurements; if this interval is not entirely above zero, \
    the open-loop drive is kept. Error and largest error of a line: over the part of the band that the drive reaches; bands that were \
    attenuated so that the drive fits are left out. Within the limits: at most 1 dB rms and 3 dB on every line, and not worse than with \
    the open loop. Level: relative to the texture. Correlation: of the waveforms. Samples at a limit: the share of samples at which the \
    device or the sensor clips. Corrections: the number up to the best drive. Stopped: after the requested number of corrections, when \
    there was no improvement in two iterations, when the error became clearly larger, or when a measurement was invalid.";

/// The columns of drives.
const OF_DRIVES: [(&str, &str); 7] = [
    ("texture and finger", "texture"),
    ("level, dB", "level_db"),
    ("peak, full scale", "peak_fs"),
    ("headroom, dB", "headroom_db"),
    ("limited by", "limited_by"),
    ("achievable band", "achievable_band"),
    ("drive", "drive"),
];
/// The columns of CSV for closed loops.
const OF_LOOPS: [&str; 16] = [
    "error_open_db_rms",
    "error_db_rms",
    "line_error_open_db",
    "line_error_db",
    "within_limits",
    "level_error_db",
    "correlation_open",
    "correlation",
    "band_reached_share",
    "at_limit_share",
    "improvement_db",
    "improvement_low_db",
    "improvement_high_db",
    "corrections",
    "drive_kept",
    "stopped",
];

/// What a report shows of rendered textures, gathered as they are done: of each what it says, not its samples.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderedTextures {
    band: Band,
    asked: usize,
    aim: Option<Mode>,
    /// How each that is done is said in one sentence, and of those of a closed loop which drive is kept and why.
    done: Vec<String>,
    kept: Vec<String>,
    first: Option<String>,
    benches: BTreeSet<&'static str>,
    sums: RenderingSums,
    /// How many have no confirmation measurement.
    unconfirmed: usize,
    drives: Table,
    errors: Table,
    /// What both tables hold, as numbers.
    rows: Table,
    sections: Vec<(String, Vec<Block>)>,
    origins: Vec<Fact>,
    refused: Vec<Fact>,
}

impl<R: Serialize> Shown for RenderBatchDocument<R> {
    fn page(&self) -> Page {
        self.shown.page()
    }
}

impl Shown for RenderDocument<'_> {
    fn page(&self) -> Page {
        let mut shown = RenderedTextures::of(self.drive.config.inverse.band, 1);
        shown.add(self);
        shown.page()
    }
}

impl Shown for RenderedTextures {
    fn page(&self) -> Page {
        let benches: Vec<&str> = self.benches.iter().copied().collect();
        let mut page = Page::new(self.title(), benches.join(" ")).section("", self.summary());
        if !self.errors.rows.is_empty() {
            let notes = [self.errors.clone().into(), Block::note(COLUMNS)];
            page = page.section("Error of each rendering", notes);
        }
        if !self.drives.rows.is_empty() {
            page = page.section("Drives", [self.drives.clone().into()]);
        }
        if !self.refused.is_empty() {
            page = page.section("Not rendered", [Block::facts(self.refused.clone())]);
        }
        for (called, blocks) in &self.sections {
            page = page.section(called, blocks.clone());
        }
        page.rows(self.rows.clone())
            .section("Methods", [Block::text(self.method())])
            .section("Origin of the data", [Block::facts(self.origins.clone())])
    }
}

impl RenderedTextures {
    /// A report of renderings over `band`, of which `asked` are asked for.
    #[must_use]
    pub fn of(band: Band, asked: usize) -> Self {
        let columns = |all: &[(&str, &str)]| {
            let columns = all.iter();
            Table::new(columns.map(|(heading, name)| Column::new(heading, name)))
        };
        Self {
            band,
            asked,
            aim: None,
            done: Vec::new(),
            kept: Vec::new(),
            first: None,
            benches: BTreeSet::new(),
            sums: RenderingSums::default(),
            unconfirmed: 0,
            drives: columns(&OF_DRIVES),
            errors: columns(&[
                ("texture and finger", "texture"),
                ("level, dB", "level_db"),
                ("error, dB rms", "error_db_rms"),
                ("largest error of a line, dB", "line_error_db"),
                ("within the limits", "within_limits"),
                ("level error, dB", "level_error_db"),
                ("correlation", "correlation"),
                ("band reached", "band_reached"),
                ("samples at a limit", "samples_at_limit"),
                ("improvement, dB (95 %)", "improvement_db"),
                ("corrections", "corrections"),
                ("drive kept", "drive_kept"),
                ("stopped", "stopped"),
            ]),
            rows: Table::new(
                (OF_DRIVES.iter().map(|(_, name)| name))
                    .chain(&OF_LOOPS)
                    .map(|name| Column::new(name, name)),
            ),
            sections: Vec::new(),
            origins: Vec::new(),
            refused: Vec::new(),
        }
    }

    /// Adds a texture that was rendered.
    pub fn add(&mut self, one: &RenderDocument<'_>) {
        let (called, drive) = (one.names.called, one.drive);
        let headroom = one.headroom;
        let reached = bands(one.achievable_band_hz);
        let level = match one.level_db {
            0.0 => String::new(),
            level_db => format!(" at {} dB", plus(level_db, 1)),
        };
        self.first.get_or_insert_with(|| called.into());
        self.done.push(format!(
            "{called}{level}: {}; achievable band {reached}.",
            headroom.text()
        ));
        let of_drive = vec![
            Cell::from(called),
            Cell::rounded(one.level_db, 1),
            Cell::rounded(headroom.peak, 3),
            headroom
                .headroom_db
                .map_or(Cell::Missing(()), |db| Cell::rounded(db, 1)),
            Cell::from(headroom.limited_by.as_str()),
            Cell::from(reached),
            Cell::from(one.names.out.display().to_string()),
        ];
        let mut of_loop = vec![Cell::Missing(()); OF_LOOPS.len()];
        let mut said = format!("{}. ", capital(&headroom.text()));
        let mut figure = None;
        if let Some(looped) = one.looped {
            let row = looped.summary(called, one.level_db, drive);
            self.aim = drive.aim;
            let bench = row.bench.map_or(UNKNOWN_BENCH, BenchKind::sentence);
            self.benches.insert(bench);
            self.sums.add(&row);
            self.kept.push(row.kept.clone());
            self.unconfirmed += usize::from(!row.is_confirmed);
            self.errors.rows.push(errors_of(&row));
            of_loop = numbers_of(&row).to_vec();
            said += &format!("{}. ", capital(&row.kept));
            figure = Some(open_and_closed(row.open, row.closed).captioned(
                "Power spectral densities of the target and of the measured responses in open and closed loop, and below the remaining \
                 error in the closed loop at each spectral line. Shaded: the bands that the inverse reaches. Red: the limit for the rms \
                 of the error.",
            ));
        }
        said += &match one.given_up_band_hz {
            [] => "No part of the band is given up.".into(),
            some => format!("Given up: {}.", bands(some)),
        };
        let mut blocks = vec![Block::text(said)];
        blocks.extend(figure.map(Block::Figure));
        if !one.warnings.is_empty() {
            let about = if self.asked == 1 { "" } else { called };
            blocks.push(Block::warnings(about, one.warnings.clone()));
        }
        self.sections.push((called.into(), blocks));
        self.rows.rows.push([of_drive.clone(), of_loop].concat());
        self.drives.rows.push(of_drive);
        let steps = &drive.about.provenance.steps;
        self.origins.push(Fact::new(called, "").steps(steps));
    }

    /// Adds a texture that could not be rendered, and why.
    pub fn refuse(&mut self, called: &str, why: &str) {
        self.refused.push(Fact::new(called, why));
    }

    fn title(&self) -> String {
        match (&self.first, self.aim.is_some()) {
            (Some(only), looped) if self.asked == 1 => match looped {
                true => format!("Rendering of {only} in a closed loop"),
                false => format!("Rendering of {only}"),
            },
            (_, true) => format!(
                "Rendering in a closed loop: {} textures and fingers",
                self.asked
            ),
            (_, false) => format!("Rendering: {} textures and fingers", self.asked),
        }
    }

    fn summary(&self) -> Vec<Block> {
        let mut blocks = Vec::new();
        if self.aim.is_some() {
            blocks.push(self.verdict());
        }
        match (self.done.as_slice(), self.asked) {
            ([only], 1) => blocks.push(Block::conclusion(only, None)),
            (done, all) if self.aim.is_none() => {
                let text = format!("{} of {all} textures are rendered.", done.len());
                blocks.push(Block::conclusion(text, None));
            }
            _ => {}
        }
        if self.unconfirmed > 0 && self.asked > 1 {
            blocks.push(Block::text(format!(
                "Of {} the confirmation measurement failed: it is not decided whether they are close.",
                self.unconfirmed
            )));
        }
        let kept = self.sums.open_kept;
        match (self.kept.as_slice(), self.asked) {
            _ if kept == 0 => {}
            ([kept], 1) => blocks.push(Block::text(format!("{}.", capital(kept)))),
            (_, all) => blocks.push(Block::text(format!(
                "In {kept} of {all} the open-loop drive is kept."
            ))),
        }
        if self.sums.count > 0 {
            blocks.push(Block::numbers(self.numbers()));
        }
        let done = self.done.len() + self.refused.len();
        if done < self.asked {
            blocks.push(Block::text(format!(
                "This report was written before the run was complete: {done} of {} done.",
                self.asked
            )));
        }
        blocks
    }

    fn verdict(&self) -> Block {
        let within = format!(
            "within {} dB rms and {} dB on every line",
            CLOSE_DB.0, CLOSE_DB.1
        );
        let (close, open) = (self.sums.close, self.unconfirmed);
        let text = match (self.asked, close) {
            (1, 0) if open > 0 => format!(
                "It is not decided whether the result is {within} of its target: the confirmation measurement failed."
            ),
            (1, 1) => format!(
                "The result is {within} of its target, over the part of the band that is reached."
            ),
            (1, _) => format!(
                "The result is not {within} of its target, over the part of the band that is reached."
            ),
            (all, _) => format!(
                "{close} of {all} results are {within} of their target, over the part of the band that is reached."
            ),
        };
        let outcome = match self.asked - close.min(self.asked) {
            0 => Outcome::Met,
            rest if rest == open => Outcome::NotDecided,
            _ => Outcome::NotMet,
        };
        Block::conclusion(text, outcome)
    }

    fn numbers(&self) -> Vec<Number> {
        let sums = &self.sums;
        let db = |value: f64, what: &str| Number::new(format!("{value:.2} dB"), what);
        let largest = Number::new(
            format!("{:.1} dB", sums.line_db_largest),
            "largest error of a spectral line",
        );
        if sums.count > 1 {
            return vec![
                db(sums.open_db_mean, "rms error, open loop, mean"),
                db(sums.closed_db_mean, "rms error of the kept drive, mean"),
                db(
                    sums.closed_db_largest,
                    "rms error of the kept drive, largest",
                ),
                largest,
            ];
        }
        let loop_of = match sums.open_kept {
            0 => "closed loop",
            _ => "open loop",
        };
        let measured = match self.unconfirmed {
            0 => "confirmation measurement",
            _ => "measurement in the loop",
        };
        vec![
            db(sums.open_db_mean, "rms error, open loop"),
            db(
                sums.closed_db_mean,
                &format!("rms error, {loop_of}, {measured}"),
            ),
            largest,
        ]
    }

    fn method(&self) -> String {
        let Some(aim) = self.aim else {
            return format!(
                "Rendered over {}: the texture divided by the transfer function inside the band.",
                self.band
            );
        };
        format!(
            "Aim: {}. Evaluated over {}. Every drive was played twice without moving the finger: the second measurement was used to \
             evaluate it, and both together to correct it. The loop stops after the requested number of corrections, or when there was \
             no improvement in two iterations. The best drive was then measured once more (confirmation measurement). It is kept if its \
             error is smaller than that of the open loop beyond the scatter of the measurements; otherwise the open-loop drive is kept.",
            aim.text(),
            self.band
        )
    }
}

fn bands(bands: &[Band]) -> String {
    match bands {
        [] => "none".into(),
        some => {
            let texts: Vec<String> = some.iter().map(ToString::to_string).collect();
            texts.join(", ")
        }
    }
}

/// A clause with its first letter as a sentence begins.
fn capital(clause: &str) -> String {
    let mut letters = clause.chars();
    letters.next().map_or(String::new(), |first| {
        first.to_uppercase().chain(letters).collect()
    })
}

fn errors_of(row: &CorrectedRendering<'_>) -> Vec<Cell> {
    let (open, closed) = (row.open, row.closed);
    let then = |open: f64, closed: f64, decimals: usize| {
        let [open, closed] = [open, closed].map(|value| signed(value, decimals));
        Cell::from(format!("{open}\u{a0}→\u{a0}{closed}"))
    };
    let gain = row
        .gain_db
        .map_or(Cell::Missing(()), |(found, [low, high])| {
            let [found, low, high] = [found, low, high].map(|db| signed(db, 2));
            Cell::from(format!("{found} ({low} to {high})"))
        });
    vec![
        Cell::from(row.called),
        Cell::from(plus(row.level_db, 1)),
        then(open.judged_error_db(), closed.judged_error_db(), 2),
        then(
            open.error_db_max_achievable(),
            closed.error_db_max_achievable(),
            1,
        ),
        Cell::from(within(row)),
        Cell::rounded(closed.level_error_db, 2),
        then(open.waveform_correlation, closed.waveform_correlation, 3),
        Cell::from(format!("{:.0} %", row.reached_share() * 100.0)),
        Cell::from(format!("{} %", digits(row.share_at_limit() * 100.0))),
        gain,
        Cell::from(row.best.to_string()),
        Cell::from(kept(row)),
        Cell::from(stopped(row)),
    ]
}

/// The cells of [`OF_LOOPS`].
fn numbers_of(row: &CorrectedRendering<'_>) -> [Cell; OF_LOOPS.len()] {
    let (open, closed) = (row.open, row.closed);
    let [gain, low, high] = match row.gain_db {
        Some((found, [low, high])) => [found, low, high].map(Cell::from),
        None => [Cell::Missing(()), Cell::Missing(()), Cell::Missing(())],
    };
    [
        Cell::from(open.judged_error_db()),
        Cell::from(closed.judged_error_db()),
        Cell::from(open.error_db_max_achievable()),
        Cell::from(closed.error_db_max_achievable()),
        Cell::from(within(row)),
        Cell::from(closed.level_error_db),
        Cell::from(open.waveform_correlation),
        Cell::from(closed.waveform_correlation),
        Cell::from(row.reached_share()),
        Cell::from(row.share_at_limit()),
        gain,
        low,
        high,
        Cell::from(row.best as f64),
        Cell::from(kept(row)),
        Cell::from(stopped(row)),
    ]
}

fn within(row: &CorrectedRendering<'_>) -> Outcome {
    match (row.is_close, row.is_confirmed) {
        (true, _) => Outcome::Met,
        (false, true) => Outcome::NotMet,
        (false, false) => Outcome::NotDecided,
    }
}

fn kept(row: &CorrectedRendering<'_>) -> &'static str {
    match row {
        row if row.is_open_kept => "open loop",
        row if row.got_worse => "corrected, spectrum worse",
        _ => "corrected",
    }
}

fn stopped(row: &CorrectedRendering<'_>) -> String {
    match row.is_confirmed {
        true => row.ended.to_owned(),
        false => format!("{}, no confirmation measurement", row.ended),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::quantity::Hertz;

    #[test]
    fn what_could_not_be_rendered_is_named_with_its_reason() {
        let band = Band::new(Hertz(20.0), Hertz(1000.0)).unwrap();
        let mut shown = RenderedTextures::of(band, 3);
        shown.refuse("silent", "the texture is silent");
        let page = shown.page();
        assert_eq!(page.title, "Rendering: 3 textures and fingers");
        let text = format!("{page:?}");
        for part in [
            "0 of 3 textures are rendered.",
            "1 of 3 done",
            "the texture is silent",
            "Rendered over 20–1000 Hz",
        ] {
            assert!(text.contains(part), "{part}: {text}");
        }
    }
}
