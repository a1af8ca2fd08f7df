//! What was felt in confused pairs: spectra side by side, and whether level or spectrum separates them.

use maud::{Markup, html};
use piezotact::figure::{Axis, Chart, Line, Tone, range};
use piezotact_people::association::{Felt, FeltPair, FeltSpectrum};

use crate::chart::HEIGHT;
use crate::report::drawn_table;
use crate::{Draw, DrawError, figure};

/// As many pairs are drawn in a report; the table has all of them.
const PAIRS: usize = 20;
/// The range of levels that is drawn, dB.
const DEPTH_DB: f64 = 70.0;

pub(crate) fn felt_section(felt: &Felt) -> Result<Markup, DrawError> {
    let mut drawn = Vec::new();
    for pair in felt.pairs.iter().take(PAIRS) {
        drawn.push(html! {
            h3 { (pair.pair.join(" – ")) }
            p { strong { (pair.sentence()) } }
            @if let Some(picture) = pair_figure(felt, pair)? { (picture) }
        });
    }
    let table = felt.table();
    let shown = match felt.pairs.len() {
        all if all > PAIRS => format!(" Drawn are the first {PAIRS} of {all} pairs."),
        _ => String::new(),
    };
    Ok(html! {
        section {
            h2 { "What was felt in confused pairs" }
            p.soft {
                "Pairs that somebody confused and that the answers do not show to be told apart. Level: the difference in sensation \
                 level. Spectrum: the difference at equal sensation level, the louder attenuated to the level of the softer. Both in \
                 just-noticeable differences (JND) over " (felt.model.band) "; one separates a pair where its whole 95 % interval lies \
                 above the published range of the JND and above what the halves of one recording differ by."
                (shown)
            }
            @if felt.pairs.is_empty() { p { "Nobody confused a pair." } }
            @if !table.rows.is_empty() { (drawn_table(&table)?) }
            @for pair in &drawn { (pair) }
        }
    })
}

/// The spectra of a pair in one figure; `None` where neither was recorded.
fn pair_figure(felt: &Felt, pair: &FeltPair) -> Result<Option<Markup>, DrawError> {
    let tones = [Tone::Reference, Tone::Main];
    let of = |i: usize| -> Vec<&FeltSpectrum> {
        let spectra = felt.spectra.iter();
        spectra.filter(|s| s.sample == pair.pair[i]).collect()
    };
    let both = [of(0), of(1)];
    let people = both[0].len().max(both[1].len());
    let mut lines = Vec::new();
    for (i, spectra) in both.iter().enumerate() {
        for (number, spectrum) in spectra.iter().enumerate() {
            let label = if number == 0 { &*pair.pair[i] } else { "" };
            let line = Line::new(label, tones[i], spectrum.points());
            lines.push(if people > 1 { line.thin() } else { line });
        }
    }
    let Some(first) = both.iter().flatten().next() else {
        return Ok(None);
    };
    let (from, to) = (felt.model.band.low().0, felt.model.band.high().0);
    let points: Vec<&[(f64, f64)]> = lines.iter().map(|line| line.points.as_slice()).collect();
    let (low, high) = range(&points, from, to, 10.0, DEPTH_DB);
    let chart = Chart::new(
        Axis::log("frequency, Hz", from, to),
        Axis::new("PSD, dB re 1 (m/s²)²/Hz", low, high),
        lines,
    );
    let each = match people {
        1 => String::new(),
        people => format!(" One thin line for each of {people} participants."),
    };
    let caption = format!(
        "Acceleration of the fingernail: PSD (Welch, Hann, lines {:.1} Hz apart).{each}",
        first.resolution_hz
    );
    Ok(Some(figure(&chart.svg(HEIGHT)?, &caption)))
}
