//! Spectrograms as images: time across, frequency up, the PSD in dB as colour.

use piezotact::quantity::{Decibels, Quantity};
use piezotact::spectrum::Spectrogram;

use super::axis::number;
use super::chart::WIDTH;
use super::image::{BAR, Image, Svg, ticks};
use crate::failure::Outcome;
use crate::output::digits;

/// The most columns and rows of an image: what a figure this wide shows.
pub(crate) const COLUMNS: usize = 600;
pub(crate) const ROWS: usize = 300;

/// Around the panels: labels and ticks on the left, the scale of colours on the right, time below.
const LEFT: f64 = 70.0;
const RIGHT: f64 = GAP + BAR + 82.0;
const BELOW: f64 = 46.0;
/// Above every panel, for its title; and between one column of panels and the next.
const ABOVE: f64 = 28.0;
const BETWEEN: f64 = 16.0;
/// From the panels to the scale of colours.
const GAP: f64 = 22.0;
const TALLEST_BAR: f64 = 360.0;
/// Below that, for a note.
const LINE: f64 = 26.0;
/// How wide a letter of a title is, about.
const LETTER: f64 = 6.4;
/// The steps on which the scale of colours ends, and its least and largest depth, dB.
const STEP_DB: f64 = 5.0;
const SHALLOWEST_DB: f64 = 20.0;
const DEEPEST_DB: f64 = 80.0;
/// The share of the cells that may lie below the scale of colours.
const BELOW_SCALE: f64 = 0.02;

/// One spectrogram of a figure.
pub(crate) struct Panel<'a, Q: Quantity> {
    pub(crate) title: String,
    pub(crate) spectrogram: &'a Spectrogram<Q>,
}

/// One spectrogram, as a file of its own that says how it was estimated; `unit` is that of the PSD.
pub(crate) fn file<Q: Quantity>(panel: &Panel<'_, Q>, unit: &str) -> Outcome<String> {
    let note = estimate(panel.spectrogram);
    let svg = figure(std::slice::from_ref(panel), unit, &note)?;
    // In a page a figure takes the width there is; a file of its own needs its size.
    let height = Layout::of(1).height(&note);
    let size = format!("width=\"{WIDTH}\" height=\"{height:.0}\"");
    Ok(svg.replacen("role=\"img\"", &size, 1))
}

/// How a spectrogram was estimated, for its caption.
pub(crate) fn estimate<Q: Quantity>(spectrogram: &Spectrogram<Q>) -> String {
    let config = &spectrogram.config;
    let averaged = |count: usize, what: &str| match count {
        1 => String::new(),
        several => format!(", {several} averaged per {what}"),
    };
    format!(
        "{} window, {} samples, {} % overlap: {} segments{}; lines {:.2} Hz apart{}",
        config.window.name(),
        config.segment,
        digits(config.overlap * 100.0),
        spectrogram.segments,
        averaged(spectrogram.segments_per_column, "column"),
        spectrogram.resolution_hz(),
        averaged(spectrogram.lines_per_row, "row"),
    )
}

/// One spectrogram, or several with one scale of colours, one of time and one of frequency, each with its title;
/// `unit` is that of all their PSDs, and `note` stands below them.
pub(crate) fn figure<Q: Quantity>(
    panels: &[Panel<'_, Q>],
    unit: &str,
    note: &str,
) -> Outcome<String> {
    let layout = Layout::of(panels.len());
    let height = layout.height(note);
    let mut svg = Svg::new(height);
    svg.background(height);
    let all = |values: fn(&Spectrogram<Q>) -> (f64, f64)| {
        let ends = panels.iter().map(|panel| values(panel.spectrogram));
        ends.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
            .unwrap_or((0.0, 1.0))
    };
    // Time begins with the recording: the first column stands in the middle of its segment.
    let (time, frequency) = ((0.0, all(times).1), all(frequencies));
    let decibels: Vec<Vec<f64>> = panels.iter().map(|p| rows_db(p.spectrogram)).collect();
    let scale = scale_db(&decibels);
    for (i, (panel, values)) in panels.iter().zip(&decibels).enumerate() {
        let frame = Frame {
            at: layout.place(i),
            size: layout.size,
            time,
            frequency,
        };
        let letters = (layout.size.0 / LETTER) as usize;
        svg.text(
            (frame.at.0, frame.at.1 - 9.0),
            "start",
            &shortened(&panel.title, letters),
        );
        let image = Image {
            values,
            columns: panel.spectrogram.times_s.len(),
            scale,
        };
        frame.fill(&mut svg, panel.spectrogram, &image)?;
        // Panels share their axes: only the outer ones say what they are.
        if i + layout.across >= panels.len() {
            frame.time_ticks(&mut svg);
        }
        if i % layout.across == 0 {
            frame.frequency_ticks(&mut svg);
        }
    }
    let (left, top) = layout.place(0);
    let middle = 0.5 * (top + layout.bottom());
    svg.text(
        (0.5 * (left + layout.right()), layout.bottom() + 40.0),
        "middle",
        "time, s",
    );
    svg.text(
        (layout.right(), layout.bottom() + 40.0),
        "end",
        "grey: no segment is centred there",
    );
    svg.upright((18.0, middle), "frequency, Hz");
    let tall = (layout.bottom() - top).min(TALLEST_BAR);
    svg.colour_bar(
        (layout.right() + GAP, middle - 0.5 * tall),
        tall,
        scale,
        &format!("PSD, dB re 1 {unit}"),
    );
    if !note.is_empty() {
        svg.text((LEFT, height - 12.0), "start", note);
    }
    Ok(svg.finish())
}

/// Where panels stand: the same size each, in rows.
struct Layout {
    across: usize,
    down: usize,
    size: (f64, f64),
}

impl Layout {
    fn of(panels: usize) -> Self {
        let (across, high) = match panels {
            0 | 1 => (1, 300.0),
            2..=4 => (2, 170.0),
            _ => (3, 130.0),
        };
        let room = f64::from(WIDTH) - LEFT - RIGHT - BETWEEN * (across - 1) as f64;
        Self {
            across,
            down: panels.div_ceil(across).max(1),
            size: (room / across as f64, high),
        }
    }

    /// The left and the top of panel `i`.
    fn place(&self, i: usize) -> (f64, f64) {
        let (column, row) = ((i % self.across) as f64, (i / self.across) as f64);
        (
            LEFT + (self.size.0 + BETWEEN) * column,
            ABOVE + (self.size.1 + ABOVE) * row,
        )
    }

    fn right(&self) -> f64 {
        self.place(self.across - 1).0 + self.size.0
    }

    fn bottom(&self) -> f64 {
        (self.size.1 + ABOVE) * self.down as f64
    }

    fn height(&self, note: &str) -> f64 {
        self.bottom() + BELOW + if note.is_empty() { 0.0 } else { LINE }
    }
}

/// A panel's frame and what its sides stand for.
struct Frame {
    at: (f64, f64),
    size: (f64, f64),
    time: (f64, f64),
    frequency: (f64, f64),
}

impl Frame {
    fn x(&self, time_s: f64) -> f64 {
        self.at.0 + self.size.0 * (time_s - self.time.0) / (self.time.1 - self.time.0)
    }

    fn y(&self, frequency_hz: f64) -> f64 {
        let (low, high) = self.frequency;
        self.at.1 + self.size.1 * (high - frequency_hz) / (high - low)
    }

    fn fill<Q: Quantity>(
        &self,
        svg: &mut Svg,
        spectrogram: &Spectrogram<Q>,
        image: &Image<'_>,
    ) -> Outcome {
        let (time, frequency) = (times(spectrogram), frequencies(spectrogram));
        let (left, right) = (self.x(time.0), self.x(time.1));
        let (top, bottom) = (self.y(frequency.1), self.y(frequency.0));
        svg.missing(self.at, self.size);
        svg.image((left, top), (right - left, bottom - top), image)?;
        svg.frame(self.at, self.size);
        Ok(())
    }

    fn time_ticks(&self, svg: &mut Svg) {
        let bottom = self.at.1 + self.size.1;
        for tick in ticks(self.time.0, self.time.1, self.size.0 / 80.0) {
            let x = self.x(tick);
            svg.line((x, bottom), (x, bottom + 6.0));
            svg.text((x, bottom + 20.0), "middle", &number(tick));
        }
    }

    fn frequency_ticks(&self, svg: &mut Svg) {
        let left = self.at.0;
        for tick in ticks(self.frequency.0, self.frequency.1, self.size.1 / 45.0) {
            let y = self.y(tick);
            svg.line((left - 6.0, y), (left, y));
            svg.text((left - 10.0, y + 4.0), "end", &number(tick));
        }
    }
}

/// From where to where the columns reach, s.
fn times<Q: Quantity>(spectrogram: &Spectrogram<Q>) -> (f64, f64) {
    reach(&spectrogram.times_s, spectrogram.time_step_s)
}

/// From where to where the rows reach, Hz.
fn frequencies<Q: Quantity>(spectrogram: &Spectrogram<Q>) -> (f64, f64) {
    reach(&spectrogram.frequencies_hz, spectrogram.frequency_step_hz)
}

/// Cells of one size; the first one's middle is known, the last may stand for less.
fn reach(middles: &[f64], step: f64) -> (f64, f64) {
    let low = middles.first().map_or(0.0, |first| first - 0.5 * step);
    (low, low + step * middles.len().max(1) as f64)
}

/// The levels row by row from the highest frequency, as an image has them.
fn rows_db<Q: Quantity>(spectrogram: &Spectrogram<Q>) -> Vec<f64> {
    let rows = spectrogram.frequencies_hz.len();
    (0..rows)
        .rev()
        .flat_map(|row| {
            spectrogram
                .columns()
                .map(move |column| Decibels::from_power(column[row]).0)
        })
        .collect()
}

/// The ends of a scale that holds the loudest cell of all, and nearly all cells above its low end.
fn scale_db(panels: &[Vec<f64>]) -> (f64, f64) {
    let mut levels: Vec<f64> = panels
        .iter()
        .flatten()
        .copied()
        .filter(|level| level.is_finite())
        .collect();
    if levels.is_empty() {
        return (-SHALLOWEST_DB, 0.0);
    }
    let place = (levels.len() as f64 * BELOW_SCALE) as usize;
    let (_, low, louder) = levels.select_nth_unstable_by(place, f64::total_cmp);
    let low = *low;
    let high = louder.iter().copied().fold(low, f64::max);
    let high = (high / STEP_DB).ceil() * STEP_DB;
    let low = (low / STEP_DB).floor() * STEP_DB;
    (low.clamp(high - DEEPEST_DB, high - SHALLOWEST_DB), high)
}

/// A title cut where its room ends.
fn shortened(title: &str, letters: usize) -> String {
    if title.chars().count() <= letters {
        return title.into();
    }
    title.chars().take(letters - 1).chain(['…']).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::quantity::{Acceleration, Hertz, SampleRate};
    use piezotact::series::Series;
    use piezotact::spectrum::{Cells, SpectrogramConfig, spectrogram};

    /// A tone that rises, at `level`, for `seconds`.
    fn rising(level: f64, seconds: f64) -> Spectrogram<Acceleration> {
        let rate = SampleRate::new(2000.0).unwrap();
        let samples = (0..(2000.0 * seconds) as usize).map(|i| {
            let t = i as f64 / 2000.0;
            level * (std::f64::consts::TAU * (100.0 + 100.0 * t) * t).sin()
        });
        let series = Series::new(samples.collect(), rate).unwrap();
        let config = SpectrogramConfig {
            cells: Cells::AtMost {
                columns: COLUMNS,
                rows: ROWS,
                highest: Hertz(1000.0),
            },
            ..SpectrogramConfig::usual(rate)
        };
        spectrogram(&series, &config).unwrap()
    }

    fn count(svg: &str, part: &str) -> usize {
        svg.matches(part).count()
    }

    /// Panels have their titles, and between them one scale of colours and one label for each axis.
    #[test]
    fn multiples_share_their_scales() {
        let spectrograms: Vec<_> = (1..=7)
            .map(|k| rising(f64::from(k), 1.0 + 0.2 * f64::from(k)))
            .collect();
        for panels in 1..=7 {
            let panels: Vec<_> = spectrograms[..panels]
                .iter()
                .enumerate()
                .map(|(k, spectrogram)| Panel {
                    title: format!("S{k} & more"),
                    spectrogram,
                })
                .collect();
            let svg = figure(&panels, "(m/s²)²/Hz", "").ok().unwrap();
            assert_eq!(count(&svg, "<image"), panels.len());
            assert_eq!(count(&svg, "&amp; more"), panels.len());
            for once in [">time, s<", ">frequency, Hz<", ">PSD, dB re 1 (m/s²)²/Hz<"] {
                assert_eq!(count(&svg, once), 1, "{once}");
            }
            let across = Layout::of(panels.len()).across;
            let down = panels.len().div_ceil(across);
            // 0 s once for every column, 0 Hz once for every row.
            assert_eq!(count(&svg, "middle\">0<"), across);
            assert_eq!(count(&svg, "end\">0<"), down);
            assert!(svg.len() < 1_000_000, "{}", svg.len());
        }
    }

    /// The loudest cell is inside the scale; a single weak one does not stretch it, and silence has one too.
    #[test]
    fn the_scale_holds_what_is_loud() {
        let check = |levels: &[f64], expected: (f64, f64)| {
            assert_eq!(scale_db(&[levels.to_vec()]), expected);
        };
        check(&[-12.0; 100], (-30.0, -10.0));
        check(
            &[&[-300.0, f64::NEG_INFINITY][..], &[-42.0; 98], &[3.0]].concat(),
            (-45.0, 5.0),
        );
        check(&[&[-300.0; 50][..], &[0.0; 50]].concat(), (-80.0, 0.0));
        check(&[f64::NEG_INFINITY], (-20.0, 0.0));
        check(&[], (-20.0, 0.0));
    }

    #[test]
    fn a_long_title_is_cut() {
        assert_eq!(shortened("S1 at 30 mm/s", 20), "S1 at 30 mm/s");
        assert_eq!(shortened("ä".repeat(9).as_str(), 5), "ääää…");
    }

    /// The highest row comes first, and a file of its own has a size.
    #[test]
    fn high_frequencies_are_on_top() {
        let spectrogram = rising(1.0, 1.0);
        let (columns, rows) = (spectrogram.times_s.len(), spectrogram.frequencies_hz.len());
        let levels = rows_db(&spectrogram);
        assert_eq!(levels.len(), columns * rows);
        let loudest = (0..rows)
            .max_by(|a, b| levels[a * columns].total_cmp(&levels[b * columns]))
            .unwrap();
        let at_hz = spectrogram.frequencies_hz[rows - 1 - loudest];
        assert!((100.0..=130.0).contains(&at_hz), "{at_hz}");
        let panel = Panel {
            title: "rising".into(),
            spectrogram: &spectrogram,
        };
        let alone = file(&panel, "V²/Hz").ok().unwrap();
        assert!(
            alone.starts_with("<svg width=\"900\" height=\"400\""),
            "{}",
            &alone[..80]
        );
    }
}
