//! The report of a transfer function.

use super::{
    Bias, CrossSpectra, Distortion, DistortionLevels, Estimator, ImpactTraces, Limits,
    TransferFunction,
};
use crate::criterion::Outcome;
use crate::figure::{Axis, Chart, Figure, Line, Mark, Panels, Scale, Tone, range};
use crate::number::digits;
use crate::page::{Block, Cell, Column, Fact, Number, Page, Table, fixed};
use crate::quantity::{Band, Decibels, Hertz, Quantity, Unit};
use crate::warning::words::percent;

const UNDER: Tone = Tone::Pale;
const MEASURED: Tone = Tone::Main;
const OTHER: Tone = Tone::Second;
const THIRD: Tone = Tone::Signal;

/// A level below any that can be measured, dB.
const NOTHING_DB: f64 = -300.0;

/// What a report of a transfer function shows.
#[derive(Clone, Debug)]
pub struct TransferReport<'a, I: Quantity, O: Quantity> {
    pub title: String,
    pub function: &'a TransferFunction<I, O>,
    /// The unit of its values.
    pub unit: String,
    /// The unit of the drive.
    pub drive_unit: String,
    /// The unit of the response.
    pub response_unit: String,
    /// Noise and distortion; absent where nothing told them apart.
    pub distortion: Option<&'a Distortion>,
    /// How many repeats there are, and how far the two that differ most lie apart, dB rms.
    pub repeats: Option<(usize, f64)>,
    /// What was refused, and why.
    pub refused: Vec<String>,
    /// Forces, responses and windows of an impact test; absent for other drives.
    pub traces: Option<&'a ImpactTraces>,
    /// The spectra it was estimated from; absent where they are not at hand.
    pub spectra: Option<&'a CrossSpectra<I, O>>,
}

impl<'a, I: Quantity, O: Quantity> TransferReport<'a, I, O> {
    /// A transfer function between channels in these units: drive, response.
    ///
    /// Source: house rule.
    #[must_use]
    pub fn of(
        title: String,
        function: &'a TransferFunction<I, O>,
        [drive_unit, response_unit]: [&Unit; 2],
    ) -> Self {
        Self {
            title,
            function,
            unit: format!("({response_unit})/{drive_unit}"),
            drive_unit: drive_unit.to_string(),
            response_unit: response_unit.to_string(),
            distortion: None,
            repeats: None,
            refused: Vec::new(),
            traces: None,
            spectra: None,
        }
    }

    /// The report.
    ///
    /// Source: thesis 2.5.3.
    #[must_use]
    pub fn page(&self) -> Page {
        let function = self.function;
        let judged = function.tactile_band();
        let conclusion = format!(
            "{} from {}: {} lines {:.2} Hz apart, from {} to {}",
            function.estimator,
            averaged(function),
            function.response().len(),
            function.resolution_hz(),
            self.drive_unit,
            self.response_unit
        );
        let (conclusion, outcome) = match &function.change {
            Some(change) => (
                format!(
                    "The response changed during the measurement, over {} of it: this is a mean of several states. {conclusion}",
                    percent(change.share)
                ),
                Some(Outcome::NotMet),
            ),
            None => (conclusion, None),
        };
        let page = Page::new(&self.title, bench_line(function)).section(
            "",
            [
                Block::conclusion(conclusion, outcome),
                Block::numbers(self.numbers(judged)),
            ],
        );
        let mut page = page.warnings(&function.about.warnings);
        if !self.refused.is_empty() {
            let steps = self.refused.clone();
            page = page.section("Refused measurements", [Block::Steps { steps }]);
        }
        let shown = figure(function, judged, &self.unit);
        page = page.section("Transfer function", shown.map(Block::Figure));
        if let Some(spectra) = self.spectra {
            let blocks = super::in_time::blocks(self, spectra);
            page = page.section("Impulse response and correlation", blocks);
        }
        #[cfg(feature = "modal")]
        if let Some(hits) = super::impact_page::blocks(self) {
            page = page.section("Hits", hits);
        }
        if let Some(distortion) = self.distortion {
            page = page.section("Is the device linear?", self.linearity(distortion));
        }
        page.section("Origin of the data", [Block::facts(origin(function))])
            .rows(self.lines())
    }

    /// One row for each line.
    fn lines(&self) -> Table {
        let function = self.function;
        let mut table = Table::new([
            Column::new("frequency, Hz", "frequency_hz"),
            Column::new(&format!("magnitude, {}", self.unit), "magnitude"),
            Column::new("phase, °", "phase_deg"),
            Column::new("coherence", "coherence"),
        ]);
        let lines = function.frequencies_hz().into_iter().enumerate();
        table.rows = lines
            .map(|(line, hz)| {
                let value = function.response()[line];
                let coherence = function.coherence().get(line).copied();
                let coherence = coherence.filter(|_| function.has_coherence());
                let values = [Some(hz), Some(value.norm()), Some(value.arg().to_degrees())];
                values
                    .into_iter()
                    .chain([coherence])
                    .map(Cell::from)
                    .collect()
            })
            .collect();
        table
    }

    fn numbers(&self, judged: Band) -> Vec<Number> {
        let function = self.function;
        let mut numbers = Vec::new();
        let impact = function.impact.as_ref();
        if let Some(test) = impact.filter(|test| test.added_damping_per_s > 0.0) {
            numbers.push(Number::new(
                format!("{} 1/s", digits(test.added_damping_per_s)),
                format!(
                    "damping σ added by the exponential window: half-power bandwidths are {} Hz wider",
                    digits(test.added_bandwidth_hz())
                ),
            ));
        }
        if !function.has_coherence() {
            numbers.push(Number::new("none", "coherence: one average has none"));
        }
        if let Some(reach_db) = function.median_reach_db(judged) {
            let reach = match reach_db.is_finite() {
                true => format!("± {reach_db:.2} dB"),
                false => "no lower limit".into(),
            };
            let limits = limits_name(function.limits());
            numbers.push(Number::new(
                reach,
                format!("{limits} of the median line over {judged}"),
            ));
        }
        if let Some(bias) = function.bias(judged) {
            let median = bias.median_db.map(|db| format!("{} dB", fixed(db, 2)));
            numbers.push(Number::new(
                median.unwrap_or_else(|| "unknown".into()),
                bias_text(&bias),
            ));
        }
        if let Some(coherence) = function.coherence_in(judged) {
            numbers.push(Number::new(
                format!("{:.3}", coherence.median),
                "median coherence",
            ));
            numbers.push(Number::new(
                format!("{:.3}", coherence.lowest),
                format!("lowest coherence, at {:.0} Hz", coherence.lowest_at_hz),
            ));
        }
        if let Some(delay) = function.delay().filter(|_| impact.is_none()) {
            let half_ms = delay.ci_half_width_s * 1e3;
            numbers.push(Number::new(
                format!("{} ± {half_ms:.2} ms", fixed(delay.delay_s * 1e3, 2)),
                "from the drive to the response, within a segment",
            ));
        }
        if let Some((repeats, apart_db)) = self.repeats {
            numbers.push(Number::new(
                format!("{apart_db:.2} dB"),
                format!("largest rms difference between two of {repeats} repeats"),
            ));
        }
        if let Some((level_db, band)) = self.distortion.and_then(Distortion::worst) {
            // Where none stands above the noise its level is that of nothing.
            numbers.push(match level_db < NOTHING_DB {
                true => Number::new("none", "distortion above the noise"),
                false => Number::new(
                    format!("{} dB", fixed(level_db, 0)),
                    format!("largest distortion relative to the response, {band}"),
                ),
            });
        }
        numbers
    }

    fn linearity(&self, distortion: &Distortion) -> Vec<Block> {
        let note = format!(
            "{} realisations of {} periods; lines {:.2} Hz apart. Noise: the part that differs between periods. Distortion: the \
             part that repeats at lines that are not excited.",
            distortion.realisations, distortion.periods, distortion.resolution_hz
        );
        vec![
            Block::text(linear_words(distortion)),
            distortion_chart(distortion, &self.response_unit)
                .captioned(
                    "Levels of single spectral lines: the square root of their mean power within third octaves. Distortion that \
                     is not above the noise is not drawn.",
                )
                .into(),
            distortion_table(distortion).into(),
            Block::note(note),
        ]
    }
}

/// Noise and distortion re the response, one row a band.
fn distortion_table(distortion: &Distortion) -> Table {
    let mut table = Table::new([
        Column::new("band", "band"),
        Column::new("noise relative to response, dB", "noise_db"),
        Column::new("even, dB", "even_db"),
        Column::new("odd, dB", "odd_db"),
    ]);
    let cell = |level_db: Option<f64>| match level_db {
        Some(db) if db.is_finite() => Cell::rounded(db, 1),
        Some(_) => Cell::from("in noise"),
        None => Cell::Missing(()),
    };
    table.rows = (distortion.levels.iter())
        .map(|level| {
            let mut row = vec![Cell::Text(level.band_hz.to_string())];
            row.extend(level.re_answer_db().map(cell));
            row
        })
        .collect();
    table
}

fn bench_line<I: Quantity, O: Quantity>(function: &TransferFunction<I, O>) -> String {
    let kind = (function.about.provenance.bench).map_or(
        "The recording does not say which bench it comes from.",
        |bench| bench.sentence(),
    );
    match function.about.condition.to_string() {
        nothing if nothing.is_empty() => kind.into(),
        known => format!("{kind} Measured with {known}."),
    }
}

/// What the figure of a transfer function over `band` shows.
fn caption<I: Quantity, O: Quantity>(function: &TransferFunction<I, O>, band: Band) -> String {
    let scatter = match function.limits() {
        _ if function.confidence().is_none() => "Magnitude and phase; their scatter is unknown.",
        Limits::BestLinear => {
            "Magnitude and phase. Area behind the curve: 95 % confidence interval at each spectral line, of the best linear \
                approximation at the level of this drive, if device and finger did not change. H2 is above H1 by the noise on the \
                response and by the distortion."
        }
        Limits::Scatter => {
            "Magnitude and phase. Area behind the curve: scatter of the estimate, that is its random error only. Other area: from \
                H1 to H2. Noise on the drive makes H1 too small, noise on the response makes H2 too large: for a linear system the \
                true magnitude lies between them, apart from the scatter."
        }
    };
    let coherence = match function.has_coherence() {
        true => " Coherence: the share of the response power that the drive explains linearly.",
        false => "",
    };
    format!(
        "{scatter} The phase includes the delay and is unwrapped.{coherence} Drawn: the excited band from {} to {}.",
        band.low(),
        band.high()
    )
}

/// What limits are called.
fn limits_name(limits: Limits) -> &'static str {
    match limits {
        Limits::BestLinear => "95 % confidence interval",
        Limits::Scatter => "scatter (random error only)",
    }
}

fn bias_text(bias: &Bias) -> String {
    match bias.largest_db {
        Some(db) => format!(
            "|H2|/|H1|, median over lines; at most {db:.1} dB, at {:.0} Hz",
            bias.largest_at_hz
        ),
        None => format!(
            "|H2|/|H1|, median over lines; infinite at {:.0} Hz",
            bias.largest_at_hz
        ),
    }
}

/// What was averaged.
fn averaged<I: Quantity, O: Quantity>(function: &TransferFunction<I, O>) -> String {
    match &function.impact {
        Some(test) => format!("{} of {} hits", test.used(), test.hits.len()),
        None => format!("{} averages", function.averages),
    }
}

fn linear_words(distortion: &Distortion) -> String {
    match distortion.worst() {
        Some((level_db, band)) if level_db > -200.0 => format!(
            "At the level of this drive, distortion reaches −{:.0} dB re the response at {band}; even lines show even-order \
                distortion, odd lines odd-order distortion.",
            -level_db
        ),
        _ => "At the level of this drive, no distortion is above the noise.".into(),
    }
}

fn origin<I: Quantity, O: Quantity>(function: &TransferFunction<I, O>) -> Vec<Fact> {
    let provenance = &function.about.provenance;
    let mut facts = vec![Fact::new("source", provenance.source.as_str()).steps(&provenance.steps)];
    facts.extend(function.drive.as_ref().map(|setup| {
        Fact::new(
            "device",
            format!(
                "gain {}, {:.3} V at full scale, {}",
                setup.gain,
                setup.volts_per_full_scale,
                setup.load()
            ),
        )
    }));
    facts
}

/// Magnitude, phase and, where there is one, coherence of a transfer function in `unit` over the excited part of `band`, in one
/// figure. The first two have their limits where they are known, the first the area between H1 and H2. `None` where no line of the
/// function lies there.
///
/// Source: thesis 2.5.3.
pub fn figure<I: Quantity, O: Quantity>(
    function: &TransferFunction<I, O>,
    band: Band,
    unit: &str,
) -> Option<Figure> {
    let drawn = |excited: Band| {
        let low = excited.low().0.max(band.low().0);
        let high = excited.high().0.min(band.high().0);
        Band::new(Hertz(low), Hertz(high)).ok()
    };
    let shown = function.excited.and_then(drawn).unwrap_or(band);
    let (from, to) = (shown.low().0.max(1.0), shown.high().0);
    let db = |magnitude: f64| Decibels::from_amplitude_ratio(magnitude).0;
    let lines: Vec<(usize, f64)> = function.lines_in(shown).collect();
    if lines.is_empty() {
        return None;
    }
    let points = |value: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
        lines.iter().map(|(line, hz)| (*hz, value(*line))).collect()
    };
    let phase = function.unwrapped_phase_rad(shown).into_iter();
    let phase: Vec<(f64, f64)> = phase.map(|(hz, rad)| (hz, rad.to_degrees())).collect();
    let magnitude = points(&|line| db(function.response()[line].norm()));
    let coherence = points(&|line| function.coherence()[line]);
    let (low, high) = range(&[&magnitude], from, to, 10.0, 80.0);
    let limits = function.confidence();
    let (mut magnitudes, mut phases) = (Vec::new(), Vec::new());
    if let Some(limits) = &limits {
        for ((line, hz), (_, degrees)) in lines.iter().copied().zip(&phase) {
            magnitudes.push((hz, db(limits.low[line]), db(limits.high[line])));
            let reach = limits.phase_reach_rad[line].to_degrees();
            phases.push((hz, degrees - reach, degrees + reach));
        }
    }
    let bounds = function.bias_bounds();
    let between: Vec<(f64, f64, f64)> = lines
        .iter()
        .map(|(line, hz)| {
            (
                *hz,
                db(bounds[*line][0]),
                db(bounds[*line][1]).min(high + 40.0),
            )
        })
        .collect();
    let other = |label: &str, bound: usize| {
        let points = lines
            .iter()
            .map(|(line, hz)| (*hz, db(bounds[*line][bound])))
            .filter(|(_, db)| db.is_finite());
        Line::new(label, OTHER, points.collect()).thin()
    };
    let others = match function.estimator {
        _ if !function.has_coherence() => Vec::new(),
        Estimator::H1 => vec![other("H2", 1).ribbon(between)],
        Estimator::H2 => vec![other("H1", 0).ribbon(between)],
        Estimator::Hv | Estimator::HvAt { .. } => {
            vec![other("H1", 0).ribbon(between), other("H2", 1)]
        }
    };
    // A coherence of 0.98 and one of 0.999 are worlds apart: the axis begins below the lowest in the band.
    let lowest = function
        .coherence_in(band)
        .map_or(0.0, |summary| summary.lowest.clamp(0.0, 1.0));
    let floor = ((lowest * 10.0).floor() / 10.0).min(0.9);
    let chart =
        |y: Axis, lines: Vec<Line>| Chart::new(Axis::log("frequency, Hz", from, to), y, lines);
    let measured = |label: &str, points: Vec<(f64, f64)>| Line::new(label, MEASURED, points).thin();
    let mut all = others;
    let name = function.estimator.to_string();
    all.push(measured(&name, magnitude).ribbon(magnitudes));
    let degrees = phase.iter().map(|(_, degrees)| *degrees);
    let degrees = Axis::around("phase, °", Scale::Linear, degrees);
    let mut panels = vec![
        chart(Axis::new(format!("|H|, dB re 1 {unit}"), low, high), all),
        chart(degrees, vec![measured("", phase).ribbon(phases)]),
    ];
    if function.has_coherence() {
        let above = 1.0 + 0.05 * (1.0 - floor);
        let axis = Axis::new("coherence", floor, above);
        panels.push(chart(axis, vec![measured("", coherence)]));
    }
    Some(Panels::new(panels).captioned(caption(function, shown)))
}

/// The answer, noise and distortion by third octave.
fn distortion_chart(distortion: &Distortion, unit: &str) -> Chart {
    let levels = &distortion.levels;
    let centre = |l: &DistortionLevels| (l.band_hz.low().0 * l.band_hz.high().0).sqrt();
    let of = |value: &dyn Fn(&DistortionLevels) -> Option<f64>| -> Vec<(f64, f64)> {
        let told = levels.iter().filter_map(|l| Some((centre(l), value(l)?)));
        told.filter(|(_, v)| *v > 0.0)
            .map(|(f, v)| (f, Decibels::from_amplitude_ratio(v).0))
            .collect()
    };
    let lines = vec![
        Line::new("answer", MEASURED, of(&|l| Some(l.linear))).marked(Mark::Joined),
        Line::new("noise of one period", UNDER, of(&|l| Some(l.noise))).marked(Mark::Joined),
        Line::new("even distortion", OTHER, of(&|l| l.even)).marked(Mark::Joined),
        Line::new("odd distortion", THIRD, of(&|l| l.odd)).marked(Mark::Joined),
    ];
    let (from, to) = match (levels.first(), levels.last()) {
        (Some(first), Some(last)) => (first.band_hz.low().0, last.band_hz.high().0),
        _ => (20.0, 1000.0),
    };
    let points: Vec<&[(f64, f64)]> = lines.iter().map(|line| line.points.as_slice()).collect();
    let (low, high) = range(&points, from, to, 10.0, 120.0);
    Chart::new(
        Axis::log("frequency, Hz", from, to),
        Axis::new(
            format!("level per spectral line, dB re 1 {unit} rms"),
            low,
            high,
        ),
        lines,
    )
}
