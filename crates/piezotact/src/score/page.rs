//! The report of a score: whether a finger could tell, and where.

use serde::Serialize;

use super::literature::LevelCurve;
use super::{BandScore, Difference, Extent, Perceived, Score, Verdict};
use crate::criterion::Outcome;
use crate::document::Content;
use crate::figure::{Axis, Chart, Figure, Line, Mark, Tone, range};
use crate::page::{Block, Cell, Column, Fact, Number, Page, Shown, Table, fixed};
use crate::perception::Sensitivity;
use crate::quantity::{Decibels, Hertz};
use crate::recording::{BenchKind, Provenance};

const REFERENCE: Tone = Tone::Reference;
const TEST: Tone = Tone::Main;
const THRESHOLD: Tone = Tone::Second;
const UNFELT: Tone = Tone::Pale;

/// The perceptual distance of two recordings with its verdict, and further measures of their difference.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ScoredRecordings {
    /// The names of A, the reference, and of B.
    #[serde(skip)]
    pub names: [String; 2],
    #[serde(skip)]
    pub provenance: [Provenance; 2],
    /// What the perceived difference depends on, the parameter that changes it most first; for the report alone.
    #[serde(skip)]
    pub sensitivity: Vec<Sensitivity>,
    #[serde(flatten)]
    pub score: Score,
}

impl Content for ScoredRecordings {
    const SCHEMA: &'static str = "score";
    const VERSION: u32 = 3;
}

impl Shown for ScoredRecordings {
    fn page(&self) -> Page {
        let [a, b] = &self.names;
        let s = &self.score;
        let origin = ["A", "B"].into_iter().zip(&self.provenance);
        let origin = origin.map(|(what, one)| Fact::new(what, &one.source).steps(&one.steps));
        let made = ["A was made of", "B was made of"]
            .into_iter()
            .zip(&self.provenance);
        let made = made.filter_map(|(what, one)| {
            let lineage = one.lineage.as_ref()?;
            Some(Fact::new(what, &lineage.source).steps(&lineage.steps))
        });
        let origin = origin.chain(made);
        Page::new(
            format!("Score of {b} against {a}"),
            format!("A, the reference: {a}. B, the test: {b}."),
        )
        .simulated(BenchKind::simulated(
            self.provenance.iter().map(|one| one.bench),
        ))
        .section("", s.head())
        .section("What the difference depends on", self.depends_on())
        .section(
            "Criteria",
            [s.criteria_table().into(), Block::note(CRITERIA)],
        )
        .section(
            "Third-octave levels and perceptual differences",
            [s.levels(), s.differences()].map(Block::Figure),
        )
        .section("Difference of the spectra", s.spectra())
        .section("Other measures, not part of the score", s.other_measures())
        .warnings(&s.warnings)
        .section("Methods", s.methods())
        .section("Origin of the data", [Block::facts(origin)])
        .rows(s.table())
    }
}

const CRITERIA: &str = "“Below the just-noticeable difference”: the whole interval of the difference is below it. “Distinguishable”: within its \
    limits the difference is above the limits of both criteria. Otherwise “not decided”. The interval of a perceived difference holds the \
    published ranges of the parameters and the scatter of the estimate; that of spectra is a 95 % interval.";
const FEATURES: &str = "Two channels of receptors that do not mask each other, resolved in time: their parts add up as squares (d′ in \
    quadrature). What the estimate of a feature scatters by is taken off, so that two realisations of one texture are equal. The limits \
    hold the published ranges of the parameters (docs/decisions/perception.md).";
const SENSITIVITY: &str = "The difference with each parameter of the model at the ends of its published range, the others unchanged; those \
    that change it most, of all of each recording.";
/// So many parameters are shown.
const SHOWN_PARAMETERS: usize = 8;
const COLUMNS: &str = "Levels in dB re 1 m/s² rms. Sensation: the difference B − A of the sensation levels (levels above the detection \
    threshold), spread over neighbouring bands whose frequencies cannot be distinguished. A band below the threshold has none.";

impl ScoredRecordings {
    fn depends_on(&self) -> Vec<Block> {
        if self.sensitivity.is_empty() {
            return Vec::new();
        }
        let shown = &self.sensitivity[..self.sensitivity.len().min(SHOWN_PARAMETERS)];
        let blocks = [Sensitivity::table(shown).into(), Block::note(SENSITIVITY)];
        vec![Block::folded(
            "Sensitivity to the parameters of the model",
            blocks,
        )]
    }
}

impl Score {
    fn conclusion(&self) -> Block {
        let outcome = match self.verdict {
            Verdict::BelowJnd => Outcome::Met,
            Verdict::Distinguishable { .. } => Outcome::NotMet,
            Verdict::NotDecided { .. } => Outcome::NotDecided,
        };
        Block::conclusion(&self.sentence, outcome)
    }

    fn criteria_table(&self) -> Table {
        let mut table = Table::of_criteria(&self.criteria);
        for column in &mut table.columns {
            if column.name == "interval" {
                column.heading = "interval".into();
            }
        }
        table
    }

    /// The conclusion with its numbers, and the features where the perceived difference decides.
    fn head(&self) -> Vec<Block> {
        let Some(Perceived { difference, .. }) = &self.perceived else {
            return vec![self.conclusion(), Block::numbers(self.numbers())];
        };
        let parts = difference.blocks();
        let parts = parts
            .into_iter()
            .filter(|block| !matches!(block, Block::Conclusion { .. }));
        let head = std::iter::once(self.conclusion()).chain(parts);
        head.chain([Block::note(FEATURES)]).collect()
    }

    /// What the spectra differ by, by band; with its numbers where it is not what decides.
    fn spectra(&self) -> Vec<Block> {
        let numbers = self.perceived.is_some().then(|| self.numbers());
        let numbers = numbers.map(Block::numbers);
        let table = [self.table().into(), Block::note(COLUMNS)];
        numbers.into_iter().chain(table).collect()
    }

    fn numbers(&self) -> Vec<Number> {
        let jnd = |d: Difference, what: &str| {
            let limits = format!("{:.2}–{:.2}", d.low_jnd, d.high_jnd);
            Number::new(
                format!("{:.2} JND", d.jnd),
                format!("{what} (95 %: {limits})"),
            )
        };
        let [a_db, b_db] = [self.reference_sensation_db, self.test_sensation_db];
        let [a_hz, b_hz] = [self.reference_centroid_hz, self.test_centroid_hz];
        vec![
            jnd(
                self.spectral,
                "difference of the spectra: the largest of the next three",
            ),
            jnd(self.spectrum, "mean over the bands, weighted by excitation"),
            jnd(self.level, "overall sensation level"),
            jnd(self.balance, "balance of low and high frequencies"),
            Number::new(
                format!("{} and {} dB", fixed(a_db, 1), fixed(b_db, 1)),
                format!(
                    "sensation levels of A and B (re the detection threshold){}",
                    self.summation()
                ),
            ),
            Number::new(
                format!("{a_hz:.0} and {b_hz:.0} Hz"),
                "mean frequencies of the excitation by A and B",
            ),
        ]
    }

    /// The strongest third octave of each where it is below the threshold although all third octaves together are above it, in words.
    fn summation(&self) -> String {
        let strongest_db = |level_db: &dyn Fn(&BandScore) -> f64| {
            let levels = self.bands.iter();
            let levels = levels.map(|band| level_db(band) - band.threshold_db);
            levels.fold(f64::NEG_INFINITY, f64::max)
        };
        let each = [
            (
                "A",
                self.reference_sensation_db,
                strongest_db(&|b| b.reference_db),
            ),
            ("B", self.test_sensation_db, strongest_db(&|b| b.test_db)),
        ];
        let summed = each
            .into_iter()
            .filter(|(_, all, strongest)| *all > 0.0 && *strongest <= 0.0);
        let summed = summed.map(|(name, all, strongest)| {
            format!(
                "; {name}: the strongest third octave has {} dB, and the power of all over their thresholds adds up to {} dB",
                fixed(strongest, 1),
                fixed(all, 1)
            )
        });
        summed.collect()
    }

    /// The frequencies that figures show, Hz.
    fn span(&self) -> (f64, f64) {
        let band = self.config.band;
        (band.low().0 * 0.8, band.high().0 * 1.25)
    }

    fn levels(&self) -> Figure {
        let (from, to) = self.span();
        let of = |level: &dyn Fn(&BandScore) -> f64| -> Vec<(f64, f64)> {
            self.bands.iter().map(|b| (b.centre_hz, level(b))).collect()
        };
        let (a, b) = (of(&|b| b.reference_db), of(&|b| b.test_db));
        let threshold: Vec<(f64, f64)> = (0..=240)
            .map(|i| from * (to / from).powf(f64::from(i) / 240.0))
            .map(|hz| {
                let threshold_m_s2 = self.config.weighting.threshold_m_s2(Hertz(hz));
                (hz, Decibels::from_amplitude_ratio(threshold_m_s2).0)
            })
            .collect();
        let (low, high) = range(&[&a, &b], from, to, 10.0, 70.0);
        // As much of the threshold as there is room for: it rises far above what anything here reaches.
        let lowest = threshold.iter().map(|(_, db)| *db).fold(f64::MAX, f64::min);
        let high = (high + 10.0).max((lowest / 10.0).ceil() * 10.0 + 10.0);
        let low = low.min((lowest / 10.0).floor() * 10.0);
        let shown = threshold.into_iter().filter(|(_, db)| *db <= high);
        let lines = vec![
            Line::new("A", REFERENCE, a).marked(Mark::Joined),
            Line::new("B", TEST, b).marked(Mark::Joined),
            Line::new("threshold", THRESHOLD, shown.collect()).marked(Mark::Dashed),
        ];
        Chart::new(
            Axis::log("frequency, Hz", from, to),
            Axis::new("level, dB re 1 m/s² rms", low, high),
            lines,
        )
        .beside()
        .captioned(
            "Levels of third octaves, rms; the first and the last are cut at the ends of the band. Dashed: the detection threshold of a \
             tone at that frequency.",
        )
    }

    fn differences(&self) -> Figure {
        let (from, to) = self.span();
        // Half of what counts most counts much.
        let most = self.bands.iter().map(|b| b.share).fold(0.0, f64::max);
        let much = |b: &BandScore| b.share >= 0.25 * most;
        let of = |label: &str, tone: Tone, is_of: &dyn Fn(&BandScore) -> bool| -> Line {
            let chosen: Vec<&BandScore> = self.bands.iter().filter(|b| is_of(b)).collect();
            let points = chosen.iter().map(|b| (b.centre_hz, b.felt_jnd));
            let reach = chosen.iter().map(|b| {
                let (low, high) = (
                    b.felt_jnd - b.ci_half_width_jnd,
                    b.felt_jnd + b.ci_half_width_jnd,
                );
                (b.centre_hz, low, high)
            });
            Line::new(label, tone, points.collect())
                .marked(Mark::Dots)
                .spread(reach.collect())
        };
        let zone = Line::new("", TEST, Vec::new()).ribbon(vec![(from, -1.0, 1.0), (to, -1.0, 1.0)]);
        let lines = vec![
            zone,
            of("large weight", TEST, &|b| b.share > 0.0 && much(b)),
            of("small weight", THRESHOLD, &|b| b.share > 0.0 && !much(b)),
            of("below threshold", UNFELT, &|b| b.share <= 0.0),
        ];
        let ends = self.bands.iter();
        let ends = ends.map(|b| b.felt_jnd.abs() + b.ci_half_width_jnd);
        let reach = ends.fold(1.5, f64::max).min(20.0) * 1.1;
        let chart = Chart {
            levels: vec![0.0],
            ..Chart::new(
                Axis::log("frequency, Hz", from, to),
                Axis::new("B over A, JND", -reach, reach),
                lines,
            )
            .beside()
        };
        chart.captioned(format!(
            "Perceptual differences, B relative to A, with their 95 % limits. Shaded: below one JND of {} dB; differences up to {} dB \
             are not decided. Grey: below the detection threshold.",
            self.config.level_jnd.0,
            self.not_decided_up_to_db()
        ))
    }

    fn not_decided_up_to_db(&self) -> f64 {
        self.config.level_jnd_high.0.max(self.config.level_jnd.0)
    }

    /// Levels and differences of third octaves: one row a band.
    fn table(&self) -> Table {
        let mut table = Table::new([
            Column::new("band", "band_hz"),
            Column::new("A, dB", "a_db"),
            Column::new("B, dB", "b_db"),
            Column::new("threshold, dB", "threshold_db"),
            Column::new("B − A, dB", "difference_db"),
            Column::new("sensation, dB", "sensation_db"),
            Column::new("sensation, JND", "sensation_jnd"),
            Column::new("± (95 %), JND", "ci_half_width_jnd"),
            Column::new("weight, %", "weight_percent"),
        ]);
        let rows = self.bands.iter().map(|b| {
            let felt = |value: f64, decimals: usize| match b.share > 0.0 {
                true => Cell::rounded(value, decimals),
                false => Cell::Missing(()),
            };
            vec![
                Cell::Text(b.band_hz.to_string()),
                Cell::rounded(b.reference_db, 1),
                Cell::rounded(b.test_db, 1),
                Cell::rounded(b.threshold_db, 1),
                Cell::rounded(b.difference_db, 2),
                felt(b.felt_db, 2),
                felt(b.felt_jnd, 2),
                felt(b.ci_half_width_jnd, 2),
                felt(b.share * 100.0, 1),
            ]
        });
        table.rows = rows.collect();
        table
    }

    /// What is no part of the score.
    fn other_measures(&self) -> Vec<Block> {
        let e = &self.spectrum_error;
        let mut facts = vec![
            Fact::new(
                "spectrum error",
                format!(
                    "{:.2} dB rms over {}, {:.2} dB at most, at {:.0} Hz; lines {:.2} Hz apart",
                    e.rms_db, self.config.band, e.max_db, e.max_at_hz, e.resolution_hz
                ),
            ),
            Fact::new(
                "level error",
                format!("{} dB, rms in the band", fixed(self.level_error_db, 2)),
            ),
        ];
        if let Some(w) = &self.waveform {
            let when = if w.delay_s < 0.0 { "earlier" } else { "later" };
            facts.push(Fact::new(
                "waveform",
                format!(
                    "correlation {}, error {} dB re A (NMSE), B {when} by {:.2} ms, over {:.1} s",
                    fixed(w.correlation, 3),
                    fixed(w.nmse_db, 1),
                    w.delay_s.abs() * 1e3,
                    w.compared_s
                ),
            ));
        }
        if let Some([a_db, b_db]) = self.modulation_db {
            facts.push(Fact::new(
                "level over time",
                format!("spread of the levels of 0.1 s: {a_db:.1} dB in A and {b_db:.1} dB in B"),
            ));
        }
        if let Some(l) = &self.literature {
            let value = l.st_sim.value;
            let value = value.map_or_else(|| "no real value".into(), |value| format!("{value:.3}"));
            let (temporal, spectral) = (l.st_sim.temporal, l.st_sim.spectral);
            facts.push(Fact::new(
                "ST-SIM",
                format!(
                    "{value} (temporal {}, spectral {})",
                    fixed(temporal, 3),
                    fixed(spectral, 3)
                ),
            ));
            facts.push(Fact::new("SPQI", format!("{:.3}", l.spqi)));
        }
        let mut blocks = vec![
            Block::facts(facts),
            Block::note(
                "Two realisations of one texture have different waveforms but feel the same: a low correlation, ST-SIM or SPQI does not \
                 mean that a finger could distinguish them. ST-SIM and SPQI are for comparison with the literature.",
            ),
        ];
        if let Some(l) = &self.literature {
            let curve = match l.config.curve {
                LevelCurve::Vibromaf => "vibromaf 0.0.8",
                LevelCurve::Mpeg => "MPEG haptic coding",
            };
            let aligned = match self.extent {
                Extent::SharedPart => "aligned, since one waveform follows the other",
                Extent::WholeOfEach => "not aligned, since neither waveform follows the other",
            };
            blocks.push(Block::note(format!(
                "Their thresholds are in dB re full scale, not in m/s²: {} m/s² was used as full scale, with the curve of {curve}; at 8 \
                 kHz, in blocks of 512, {aligned}.",
                l.config.full_scale_m_s2
            )));
        }
        blocks
    }

    fn methods(&self) -> Vec<Block> {
        let (c, step_hz) = (
            &self.config,
            self.rate_hz / self.config.welch.segment as f64,
        );
        let independent = match self.extent {
            Extent::SharedPart => "since B follows A, from their differences at the same instants",
            Extent::WholeOfEach => "A and B are assumed to be independent",
        };
        let of_skin = match &c.contact {
            Some(map) => format!("Nail-to-skin map: {}.", map.source()),
            None => "The thresholds are for skin displacement. No nail-to-skin map was given, so the skin is assumed to move with the nail."
                .into(),
        };
        vec![
            Block::text(format!(
                "Spectra: one just-noticeable difference (JND) is {} dB of level (a fifth in amplitude is 1.58 dB) and {:.0} % of frequency; differences up to {} dB are \
                 not decided. The excitation is the power divided by the squared detection threshold, spread over third octaves by {:.2} in \
                 ln f; values below threshold are set to the threshold. Their difference is the largest of three: the mean over \
                 the bands weighted by their excitation, the overall sensation level, and the mean frequency of the excitation.",
                c.level_jnd.0,
                c.frequency_jnd_share * 100.0,
                self.not_decided_up_to_db(),
                c.spreading()
            )),
            Block::note(format!(
                "Thresholds: {}. PSDs by Welch's method at {} Hz: {} window, segments of {} samples ({step_hz:.2} Hz), {:.0} % overlap, {} \
                 segments of the shorter one. 95 % limits: from the differences between segments, or between quarters and halves of the \
                 recording where these are larger; with fewer than ten segments, from the scatter of noise with this spectrum; \
                 {independent}.",
                c.weighting.source(),
                self.rate_hz,
                c.welch.window.name(),
                c.welch.segment,
                c.welch.overlap * 100.0,
                self.segments
            )),
            Block::note(format!("{}.", self.jnd_source)),
            Block::note(of_skin),
        ]
    }
}
