//! The report of a verification: how close a measurement came to its target, and why.

mod drive;
mod figures;
mod further;

use super::{
    DemoDocument, DriveBeside, Tones, Verdict, Verification, VerifyCriterion, VerifyDocument,
};
use crate::criterion::{Criterion, Outcome};
use crate::lineage::Lineage;
use crate::number::plus;
use crate::page::{Block, Cell, Column, Ending, Fact, Number, Page, Shown, Table, fixed};
use crate::quantity::{Acceleration, Drive};
use crate::recording::{About, BenchKind, Recording};
use crate::render::Rendering;
use crate::series::Series;
use crate::transfer::{self, TransferFunction};
pub use figures::open_and_closed;

/// As many criteria stand in a report without being asked for.
const MOST_CRITERIA: usize = 8;

/// What was compared and how the drive was made, which a report shows beside the verification.
#[derive(Clone, Debug)]
pub struct Compared<'a> {
    /// The title of the report.
    pub title: String,
    /// The target as it was recorded.
    pub target: &'a Recording,
    /// The target as it is compared, at its own level, m/s².
    pub texture: &'a Series<Acceleration>,
    /// What the measurement is called.
    pub measured: &'a str,
    /// Where the measurement comes from.
    pub about: &'a About,
    /// How the drive was made; absent where nothing says it.
    pub rendering: Option<&'a Rendering>,
    /// The drive; absent where none was recorded or stated.
    pub drive: Option<ShownDrive<'a>>,
    /// The transfer function that it was rendered through; absent where it is not shown.
    pub function: Option<&'a TransferFunction<Drive, Acceleration>>,
    /// The amplitude spectra of target and measurement.
    pub tones: Tones,
}

/// The drive that is shown.
#[derive(Clone, Debug)]
pub struct ShownDrive<'a> {
    /// Its samples, full scale = 1.
    pub series: &'a Series<Drive>,
    /// The level at which the device clips.
    pub limit: f64,
    /// The drive beside the texture.
    pub beside: DriveBeside,
}

impl Shown for VerifyDocument<'_> {
    fn page(&self) -> Page {
        let (v, compared) = (self.verification.verification, &self.compared);
        let page = compared.measured_sections(v);
        let page = further::also(page, (v, compared), &self.also);
        let page = further::before(page, (v, compared), &self.before);
        let page = compared.device_sections(v, page);
        let page = match self.uncompensated_predicted {
            Some(predicted) => further::predicted(page, v, predicted),
            None => page,
        };
        compared.ended(page, v)
    }

    fn ending(&self) -> Ending {
        self.verification.verification.ending()
    }
}

impl Shown for DemoDocument<'_> {
    fn page(&self) -> Page {
        let (v, compared) = (self.verification.verification, &self.compared);
        let page = compared.device_sections(v, compared.measured_sections(v));
        let loud = self.uncompensated.verification;
        let fitting = self.uncompensated_level_matched.verification;
        compared.ended(further::uncompensated(page, v, [loud, fitting]), v)
    }

    fn ending(&self) -> Ending {
        self.verification.verification.ending()
    }
}

impl Verification {
    /// The verdict as the end of a command.
    ///
    /// Source: docs/decisions/documents.md.
    #[must_use]
    pub fn ending(&self) -> Ending {
        match self.verdict {
            Verdict::Passed => Ending::Done,
            Verdict::NotPassed => Ending::NotPassed,
            Verdict::PassedInPart { .. } => Ending::PassedInPart,
            Verdict::NotDecided => Ending::NotDecided,
        }
    }

    fn conclusion(&self) -> Block {
        let outcome = match self.verdict {
            Verdict::Passed => Outcome::Met,
            Verdict::PassedInPart { .. } | Verdict::NotDecided => Outcome::NotDecided,
            Verdict::NotPassed => Outcome::NotMet,
        };
        Block::conclusion(self.sentence(), outcome)
    }

    /// The criteria: those that the verdict follows from first, of these the one that its sentence names; beyond eight folded.
    fn criteria_blocks(&self) -> Vec<Block> {
        let outcomes = [Outcome::NotMet, Outcome::NotDecided, Outcome::Met];
        let place = |c: &Criterion<VerifyCriterion>| {
            let outcome = outcomes.iter().position(|outcome| c.outcome == *outcome);
            (outcome, c.what != VerifyCriterion::FeltDifference)
        };
        let mut all: Vec<_> = self.criteria.iter().collect();
        all.sort_by_key(|c| place(c));
        let (first, rest) = all.split_at(all.len().min(MOST_CRITERIA));
        let mut blocks = vec![criteria_table(first).into()];
        if !rest.is_empty() {
            let met = match rest[0].outcome {
                Outcome::Met => ", met",
                _ => "",
            };
            let summary = format!("{}{met}", counted_more(rest.len()));
            blocks.push(Block::folded(summary, [criteria_table(rest).into()]));
        }
        blocks
    }

    /// One row for each criterion, with numbers in the unit of the criterion.
    fn rows(&self) -> Table {
        let heads = [
            "criterion",
            "unit",
            "found",
            "low",
            "high",
            "limit",
            "outcome",
        ];
        let mut table = Table::new(heads.map(|head| Column::new(head, head)));
        let rows = self.criteria.iter().map(|c| {
            let [low, high] = c.interval.map_or([None; 2], |ends| ends.map(Some));
            vec![
                Cell::Text(c.what.to_string()),
                Cell::from(c.unit.as_str()),
                Cell::from(c.found),
                Cell::from(low),
                Cell::from(high),
                Cell::from(c.limit.value()),
                Cell::from(c.outcome),
            ]
        });
        table.rows = rows.collect();
        table
    }

    fn numbers(&self, rendering: Option<&Rendering>) -> Vec<Number> {
        let number = |value: String, name: String| Number::new(value, name);
        let reached = self.error_db_rms_achievable.map(|error_db| {
            number(
                format!("{error_db:.2} dB"),
                "the same over the reached part of the band".into(),
            )
        });
        let delay = match rendering.map(|rendering| rendering.config.modelling_delay.0 * 1e3) {
            Some(modelling_ms) => format!(
                "delay removed: {modelling_ms:.0} ms of silence before the texture, plus the start delay of the devices"
            ),
            None => "delay removed".into(),
        };
        let all = [number(
            format!("{:.2} dB", self.error_db_rms),
            format!(
                "spectrum error as measured, rms over all of {}; the criterion is without sensor noise and scatter",
                self.band_hz
            ),
        )];
        let rest = [
            number(
                format!("{:.2} dB", self.error_db_max),
                format!("largest error, at {:.0} Hz", self.error_max_at_hz),
            ),
            number(
                format!("{} dB", plus(self.level_error_db, 2)),
                "level error in the band".into(),
            ),
            number(
                fixed(self.waveform_correlation, 3),
                "waveform correlation after alignment of the delay".into(),
            ),
            number(format!("{} ms", fixed(self.delay_s * 1e3, 1)), delay),
            number(
                format!("{:.2} %", self.clipped_fraction * 100.0),
                "samples at a limit".into(),
            ),
        ];
        all.into_iter().chain(reached).chain(rest).collect()
    }

    fn spectra(&self, tones: &Tones) -> Vec<Block> {
        vec![
            figures::spectra(self).into(),
            figures::amplitudes(self, tones)
                .captioned(self.amplitudes_text(tones))
                .into(),
        ]
    }

    /// How the amplitude spectra were computed.
    fn amplitudes_text(&self, tones: &Tones) -> String {
        let segment = tones.welch.segment as f64;
        format!(
            "Amplitude spectra (FFT) of target and measurement within {}, drawn up to {} Hz: a tone, for example of a periodic texture, is shown at its peak amplitude. Computed with a {} window over segments of {segment} samples ({:.2} s, lines {:.2} Hz apart), {:.0} % overlap, {} averages of power; single-sided, each line divided by the sum of the window, so that the amplitude of a tone is correct within 0.1 %. For noise, the amplitude depends on the width of the spectral lines: use the PSD.",
            self.band_hz,
            figures::amplitudes_end_hz(self.band_hz),
            tones.welch.window.name(),
            segment / self.rate_hz,
            self.rate_hz / segment,
            tones.welch.overlap * 100.0,
            tones.averages,
        )
    }

    fn method(&self) -> Vec<Block> {
        vec![
            Block::note(format!(
                "The verdict follows from the criteria: if one is not met, it is “not passed”; if one is not decided, “not decided”; if only part of the target could be evaluated, “passed in part”. Errors and levels there are those of the vibration alone: the sensor noise, measured before and after the texture, and the scatter of estimates of this length are subtracted. They are for {}; the numbers below the conclusion are as measured over all of {}, with noise and scatter, and therefore differ.",
                self.judged_band(),
                self.band_hz
            )),
            Block::note(format!(
                "PSDs by Welch's method at {} Hz: {} window, segments of {} samples ({:.2} Hz), {:.0} % overlap, {} averages; one-sided, in {}. Error: unweighted rms over the lines of the band.",
                self.rate_hz,
                self.welch.window.name(),
                self.welch.segment,
                self.rate_hz / self.welch.segment as f64,
                self.welch.overlap * 100.0,
                self.averages,
                self.psd_unit
            )),
        ]
    }
}

impl<'a> Compared<'a> {
    /// The verdict, its reasons, and target and measurement beside each other.
    fn measured_sections(&self, v: &Verification) -> Page {
        let numbers = Block::numbers(v.numbers(self.rendering));
        Page::new(&self.title, self.origin_line())
            .section("", [v.conclusion(), numbers])
            .section("Criteria", v.criteria_blocks())
            .section("Target and measured spectrum", v.spectra(&self.tones))
            .section(
                "Waveform",
                [
                    Block::text("Spectra can agree even if every phase is wrong; waveforms cannot."),
                    figures::waveforms(v)
                        .captioned(
                            "150 ms from the middle of the texture, both limited to the compared band; the measurement is shifted \
                             earlier by its delay.",
                        )
                        .into(),
                ],
            )
    }

    /// The drive and the transfer function that it was made with.
    fn device_sections(&self, v: &Verification, page: Page) -> Page {
        let page = match &self.drive {
            Some(shown) => page.section("Texture and drive", drive::beside_texture(v, shown)),
            None => page,
        };
        let page = match self.function {
            Some(function) => page.section(
                "Transfer function of the device with the finger on it",
                self.function_blocks(v, function),
            ),
            None => page,
        };
        match &self.drive {
            Some(shown) => page.section(
                "Drive and its headroom",
                drive::headroom(shown, self.rendering),
            ),
            None => page,
        }
    }

    fn function_blocks(
        &self,
        v: &Verification,
        function: &TransferFunction<Drive, Acceleration>,
    ) -> Vec<Block> {
        let inverted = self
            .rendering
            .map(|rendering| rendering.config.inverse.band);
        let setup = function.drive.as_ref().map_or(String::new(), |setup| {
            format!(
                "; amplifier gain {}, {:.3} V at full scale",
                setup.gain, setup.volts_per_full_scale
            )
        });
        let text = format!(
            "{} from {} averages in steps of {:.2} Hz{setup}.",
            function.estimator,
            function.averages,
            function.resolution_hz()
        );
        let figure = transfer::figure(function, inverted.unwrap_or(v.band_hz), "(m/s²)/FS");
        let figure = figure.map(Block::Figure);
        [Block::text(text)].into_iter().chain(figure).collect()
    }

    /// Warnings, methods and origin.
    fn ended(&self, page: Page, v: &Verification) -> Page {
        page.warnings(&v.warnings)
            .section("Methods", v.method())
            .section("Origin of the data", [Block::facts(self.origin())])
            .rows(v.rows())
    }

    fn origin_line(&self) -> String {
        let provenance = &self.about.provenance;
        let unknown = "The measurement does not say which bench it comes from.";
        let kind = provenance.bench.map_or(unknown, BenchKind::sentence);
        let seed = provenance
            .seed
            .map_or(String::new(), |seed| format!(" Seed {seed}."));
        match self.about.condition.to_string() {
            nothing if nothing.is_empty() => format!("{kind}{seed}"),
            known => format!("{kind} Measured with {known}.{seed}"),
        }
    }

    /// The manipulations of the texture, up to its rendering where that is known.
    fn lineage(&self) -> Option<&'a Lineage> {
        let rendered = self
            .rendering
            .and_then(|r| r.about.provenance.lineage.as_ref());
        rendered.or(self.target.about.provenance.lineage.as_ref())
    }

    fn origin(&self) -> Vec<Fact> {
        let of_texture = &self.target.about.provenance;
        let measured = &self.about.provenance;
        let mut facts = vec![Fact::new("texture", &of_texture.source).steps(&of_texture.steps)];
        let lineage = self.lineage();
        facts.extend(
            lineage.map(|lineage| {
                Fact::new("processing steps", &lineage.source).steps(&lineage.steps)
            }),
        );
        facts.push(Fact::new("measurement", &measured.source).steps(&measured.steps));
        if let Some(rendering) = self.rendering {
            let function = &rendering.about.provenance;
            facts.push(Fact::new("transfer function", &function.source).steps(&function.steps));
            let config = &rendering.config;
            facts.push(Fact::new(
                "rendering",
                format!(
                    "over {}, regularisation {:.1e}, modelling delay {}, fade {}, level {} dB",
                    config.inverse.band,
                    config.inverse.regularisation,
                    config.modelling_delay,
                    config.fade,
                    plus(rendering.level_db, 1)
                ),
            ));
        }
        facts
    }
}

fn counted_more(count: usize) -> String {
    match count {
        1 => "1 more criterion".into(),
        count => format!("{count} more criteria"),
    }
}

fn criteria_table(criteria: &[&Criterion<VerifyCriterion>]) -> Table {
    let heads = ["criterion", "outcome", "found", "95 % interval", "limit"];
    let mut table = Table::new(heads.map(|head| Column::new(head, head)));
    let rows = criteria.iter().map(|c| {
        let interval = c
            .interval
            .map_or(Cell::Missing(()), |_| Cell::Text(c.interval_text()));
        vec![
            Cell::Text(c.what.to_string()),
            Cell::from(c.outcome),
            Cell::Text(c.found_text()),
            interval,
            Cell::Text(c.limit_text()),
        ]
    });
    table.rows = rows.collect();
    table
}
