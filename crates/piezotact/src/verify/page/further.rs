//! What stands beside the measurement that is judged: further measurements, the textures before, and the texture sent directly.

use super::super::{
    FurtherVerification, TextureBefore, UncompensatedOutcome, UncompensatedPrediction, Verification,
};
use super::{Compared, figures};
use crate::figure::{Axis, Chart, Figure, Line, Panels, Tone, range};
use crate::lineage::{Lineage, Operation};
use crate::number::{difference_db, digits};
use crate::page::{Block, Cell, Column, Number, Page, Table, fixed};
use crate::quantity::Acceleration;
use crate::series::Series;
use crate::statistics::mean;
use crate::warning::merged;

/// The stretch of textures that is drawn before and after, s.
const BEFORE_DRAWN_S: f64 = 0.5;

fn columns<const N: usize>(heads: [(&str, &str); N]) -> Table {
    Table::new(heads.map(|(heading, name)| Column::new(heading, name)))
}

/// Further measurements of the same target.
pub(super) fn also(
    page: Page,
    (v, compared): (&Verification, &Compared<'_>),
    also: &[FurtherVerification<'_>],
) -> Page {
    if also.is_empty() {
        return page;
    }
    let mut table = columns([
        ("measurement", "measurement"),
        ("rendering level, dB", "rendering_level_db"),
        ("error, dB rms", "error_db_rms"),
        (
            "error over the reached part, dB rms",
            "error_db_rms_achievable",
        ),
        ("largest error, dB", "error_db_max"),
        ("at, Hz", "error_max_at_hz"),
        ("level error, dB", "level_error_db"),
        ("waveform correlation", "waveform_correlation"),
        ("samples at a limit, %", "clipped_percent"),
        ("own verdict", "verdict"),
    ]);
    let row = |label: &str, v: &Verification, level_db: Option<f64>| {
        vec![
            Cell::from(label),
            level_db.map_or_else(|| "not stated".into(), |db| Cell::rounded(db, 1)),
            Cell::rounded(v.error_db_rms, 2),
            v.error_db_rms_achievable
                .map_or(Cell::Missing(()), |db| Cell::rounded(db, 2)),
            Cell::rounded(v.error_db_max, 2),
            Cell::rounded(v.error_max_at_hz, 0),
            Cell::rounded(v.level_error_db, 2),
            Cell::rounded(v.waveform_correlation, 3),
            Cell::rounded(v.clipped_fraction * 100.0, 2),
            Cell::from(v.verdict.word()),
        ]
    };
    let own = compared.rendering.map(|rendering| rendering.level_db);
    table.rows = vec![row(compared.measured, v, own)];
    table.rows.extend(
        also.iter()
            .map(|one| row(one.file, one.verification.verification, one.rendered_at_db)),
    );
    let shown: Vec<(&str, &Verification)> = also
        .iter()
        .map(|one| (one.file, one.verification.verification))
        .collect();
    let mut blocks = vec![
        Block::text(format!(
            "Each is verified in the same way over {}, at its own stated rendering level. The verdict above is that of {}.",
            v.band_hz, compared.measured
        )),
        table.into(),
    ];
    let conclusions = also.iter();
    let conclusions = conclusions.map(|one| format!("{}: {}", one.file, one.verification.sentence));
    blocks.extend(conclusions.map(|text| Block::conclusion(text, None)));
    blocks.push(figures::all_spectra((compared.measured, v), &shown).into());
    blocks.push(Block::heading(
        "Warnings about these measurements, apart from those about the target",
    ));
    for one in also {
        blocks.push(Block::text(format!("{}:", one.file)));
        blocks.push(Block::warnings(one.file, merged(&one.warnings)));
    }
    page.section("Further measurements of the same target", blocks)
}

/// What was done to the texture before it was rendered: the target says it, or else the drive that was rendered from it.
fn made_from<'a>(compared: &Compared<'a>) -> Option<&'a Lineage> {
    let own = compared.target.about.provenance.lineage.as_ref();
    own.or_else(|| {
        let rendering = compared.rendering?;
        let known = rendering.about.provenance.lineage.as_ref();
        // A texture that was only rendered was made from nothing else.
        known.filter(|lineage| lineage.source != rendering.target)
    })
}

/// Whether a step of `lineage` takes a property of the texture called `label`, or of one that was made from it.
fn takes_from(lineage: &Lineage, label: &str) -> bool {
    lineage.steps.iter().any(|step| match &step.operation {
        Operation::RmsOf { of, .. } | Operation::SpectrumOf { of, .. } => {
            of.source == label || takes_from(of, label)
        }
        _ => false,
    })
}

/// What the lineage of the target says of a texture called `label`.
fn place_in(lineage: Option<&Lineage>, label: &str) -> &'static str {
    match lineage {
        None => "the target does not state what it was made from",
        Some(lineage) if lineage.source == label => "source of the target",
        Some(lineage) if takes_from(lineage, label) => "one of its properties was used",
        Some(_) => "not named in the processing steps",
    }
}

/// The textures from which a manipulated target was made.
pub(super) fn before(
    page: Page,
    (v, compared): (&Verification, &Compared<'_>),
    before: &[TextureBefore<'_>],
) -> Page {
    let Some(first) = before.first() else {
        return page;
    };
    let lineage = made_from(compared);
    let levels = before.iter().map(|one| {
        let shape_db = one.changed.shape_error_db_rms;
        Number::new(
            format!("{} dB", difference_db(one.changed.level_db)),
            format!("level of the target relative to {}; their spectral shapes differ by {shape_db:.2} dB rms over {}", one.file, v.band_hz),
        )
    });
    let mut blocks = vec![Block::numbers(levels)];
    if let Some(lineage) = lineage {
        blocks.push(Block::text(format!(
            "Processing steps, from {}:",
            lineage.source
        )));
        let steps = lineage.steps.iter().map(ToString::to_string);
        blocks.push(Block::Steps {
            steps: steps.collect(),
        });
    }
    let shape = format!("difference of shape, dB rms over {}", v.band_hz);
    let mut table = columns([
        ("before", "before"),
        ("role in the processing", "role"),
        ("rms before, m/s²", "rms_before_m_s2"),
        ("rms after, m/s²", "rms_after_m_s2"),
        ("level, after relative to before, dB", "level_db"),
        (shape.as_str(), "shape_error_db_rms"),
    ]);
    let rows = before.iter().map(|one| {
        vec![
            Cell::from(one.file),
            Cell::from(place_in(lineage, one.file)),
            Cell::from(one.changed.rms_before),
            Cell::from(one.changed.rms_after),
            Cell::rounded(one.changed.level_db, 2),
            Cell::rounded(one.changed.shape_error_db_rms, 2),
        ]
    });
    table.rows = rows.collect();
    blocks.push(table.into());
    blocks.push(Block::note(
        "Levels are rms about the mean at all frequencies. Shape: the difference of the PSDs after subtracting their mean difference \
         over the band; 0 if only the level was changed.",
    ));
    let waveforms = waveforms(compared.texture, before, first.changed.rms_after);
    blocks.extend([waveforms, spectra(v, before, first)].map(Block::Figure));
    page.section("Texture manipulation: before and after", blocks)
}

/// One colour for each texture before.
fn tones(before: &[TextureBefore<'_>]) -> Vec<Tone> {
    match before.len() {
        1 => vec![figures::UNDER],
        many => figures::others(many),
    }
}

fn level_label(what: &str, rms: f64) -> String {
    format!("{what}, {} m/s² rms", digits(rms))
}

/// The waveforms before, and below them that of the target, on one scale.
fn waveforms(
    target: &Series<Acceleration>,
    before: &[TextureBefore<'_>],
    target_rms: f64,
) -> Figure {
    let points = |series: &Series<Acceleration>| -> Vec<(f64, f64)> {
        let (rate_hz, mean) = (series.rate().hz(), mean(series.samples()));
        let drawn = (BEFORE_DRAWN_S * rate_hz) as usize;
        let samples = series.samples().iter().take(drawn).enumerate();
        let samples = samples.map(|(i, v)| (i as f64 / rate_hz, v - mean));
        samples.collect()
    };
    let lines = before.iter().zip(tones(before)).map(|(one, tone)| {
        let label = level_label(one.file, one.changed.rms_before);
        Line::new(label, tone, points(one.series)).thin()
    });
    let lines: Vec<Line> = lines.collect();
    let label = level_label("target", target_rms);
    let after = vec![Line::new(label, figures::MEASURED, points(target)).thin()];
    let all = lines.iter().chain(&after).flat_map(|line| &line.points);
    let reach = all.map(|(_, v)| v.abs()).fold(f64::MIN_POSITIVE, f64::max) * 1.08;
    let chart = |lines| {
        Chart::new(
            Axis::new("time, s", 0.0, BEFORE_DRAWN_S),
            Axis::new("acceleration, m/s²", -reach, reach),
            lines,
        )
    };
    Panels::new(vec![chart(lines), chart(after)]).captioned(format!(
        "Before, and below after: the target that was rendered. The first {BEFORE_DRAWN_S} s, on the same scale."
    ))
}

/// The PSDs before, and that of the target.
fn spectra(v: &Verification, before: &[TextureBefore<'_>], first: &TextureBefore<'_>) -> Figure {
    let levels = |psd| figures::decibels(&first.changed.frequency_hz, psd);
    let mut lines: Vec<Line> = before
        .iter()
        .zip(tones(before))
        .map(|(one, tone)| {
            let label = level_label(one.file, one.changed.rms_before);
            let hz = &one.changed.frequency_hz;
            Line::new(label, tone, figures::decibels(hz, &one.changed.psd_before))
        })
        .collect();
    let label = level_label("target", first.changed.rms_after);
    lines.push(Line::new(
        label,
        figures::MEASURED,
        levels(&first.changed.psd_after),
    ));
    let (from, to) = figures::span(v.band_hz);
    let points: Vec<&[(f64, f64)]> = lines.iter().map(|line| line.points.as_slice()).collect();
    let (low, high) = range(&points, from, to, 10.0, figures::DEPTH_DB);
    let label = format!("PSD, dB re 1 {}", v.psd_unit);
    let chart = Chart {
        shaded: vec![(v.band_hz.low().0, v.band_hz.high().0)],
        ..Chart::new(
            Axis::log("frequency, Hz", from, to),
            Axis::new(label, low, high),
            lines,
        )
    };
    chart.captioned(
        "PSDs before and after, by Welch's method as above, of whole textures. A change of level alone shifts the curve up or down and \
         keeps its shape. Shaded: the band over which shapes are compared.",
    )
}

/// The negative control, measured: the texture sent directly as it stands, and turned down until nothing clips.
pub(super) fn uncompensated(
    page: Page,
    rendered: &Verification,
    [loud, fitting]: [&Verification; 2],
) -> Page {
    let error = format!("spectrum error, dB rms over {}", rendered.band_hz);
    let mut table = columns([
        ("strategy", "strategy"),
        (error.as_str(), "error_db_rms"),
        ("waveform correlation", "waveform_correlation"),
        ("clipped, %", "clipped_percent"),
    ]);
    let row = |what: &str, v: &Verification, error_db: f64| {
        vec![
            Cell::from(what),
            Cell::rounded(error_db, 2),
            Cell::rounded(v.waveform_correlation, 3),
            Cell::rounded(v.clipped_fraction * 100.0, 1),
        ]
    };
    table.rows = vec![
        row(
            "rendered through the transfer function",
            rendered,
            rendered.error_db_rms,
        ),
        row("sent directly, unscaled", loud, loud.error_db_rms),
        row(
            "sent directly, attenuated until nothing clips, level-matched",
            fitting,
            fitting.error_db_rms_level_matched,
        ),
    ];
    let numbers = [
        Number::new(
            format!("{:.2} dB", loud.error_db_rms),
            format!(
                "spectrum error of the texture sent directly, 1 m/s² as full scale, rms; {:.0} % of the samples clipped",
                loud.clipped_fraction * 100.0
            ),
        ),
        Number::new(
            format!("{:.2} dB", fitting.error_db_rms_level_matched),
            "the same, attenuated until nothing clips and level-matched",
        ),
    ];
    page.section(
        "Negative control: the texture sent directly to the device",
        [
            Block::numbers(numbers),
            Block::text(
                "Without compensation by the transfer function, the device reproduces a different spectrum. The texture was sent \
                 unscaled (1 m/s² as a drive of 1), which the device clips; and attenuated until nothing clips, compared after \
                 subtracting the mean error.",
            ),
            table.into(),
            figures::uncompensated(loud, fitting).into(),
        ],
    )
}

/// What the transfer function says that would come of the texture sent directly.
pub(super) fn predicted(
    page: Page,
    rendered: &Verification,
    predicted: &UncompensatedOutcome,
) -> Page {
    let blocks = match predicted {
        UncompensatedOutcome::Predicted(predicted) => predicted_blocks(rendered, predicted),
        UncompensatedOutcome::NotComputed { not_computed } => {
            vec![Block::note(format!("Not computed: {not_computed}"))]
        }
    };
    page.section(
        "The texture sent directly to the device (computed, not measured)",
        blocks,
    )
}

fn predicted_blocks(rendered: &Verification, predicted: &UncompensatedPrediction) -> Vec<Block> {
    let mut table = columns([
        ("strategy", "strategy"),
        ("evaluated band", "band_hz"),
        ("spectrum error, dB rms", "error_db_rms"),
        ("waveform correlation", "waveform_correlation"),
    ]);
    let row = |what: &str, band: String, error_db: f64, correlation: f64| {
        vec![
            Cell::from(what),
            Cell::from(band),
            Cell::rounded(error_db, 2),
            Cell::rounded(correlation, 3),
        ]
    };
    let band = predicted.judged_band(rendered);
    table.rows = vec![
        row(
            "measured, rendered through the transfer function",
            rendered.judged_band(),
            rendered.judged_error_db(),
            rendered.waveform_correlation,
        ),
        row(
            "sent directly, computed, level-matched",
            band.clone(),
            predicted.error_db_rms_level_matched,
            predicted.waveform_correlation,
        ),
    ];
    let error = Number::new(
        format!("{:.2} dB", predicted.error_db_rms_level_matched),
        format!(
            "spectrum error of the texture sent directly (computed, level-matched), rms over {band}"
        ),
    );
    vec![
        Block::numbers([error]),
        Block::text(
            "The response expected if the texture itself were the drive: the texture filtered by the transfer function, without noise, \
             distortion or clipping. Texture and drive have no common scale, so the level is matched: the mean error over the evaluated \
             lines is subtracted.",
        ),
        table.into(),
        figures::predicted(rendered, predicted)
            .captioned(format!(
                "PSDs of the target and of the target filtered by the transfer function ({} dB subtracted to match the level). Shaded: \
                 the evaluated band.",
                fixed(predicted.level_difference_db, 2)
            ))
            .into(),
    ]
}
