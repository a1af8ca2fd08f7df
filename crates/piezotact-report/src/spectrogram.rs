//! Spectrograms as images: time across, frequency up, the PSD in dB as colour.

use piezotact::figure::{SpectrogramPanel, Spectrograms};

use crate::DrawError;
use crate::alternative;
use crate::format::{Format, both};
use crate::image::{Colours, Image, Svg, ticks};

/// Around the panels, in heights of a text: labels and ticks on the left, time below.
const LEFT: f64 = 5.0;
const BELOW: f64 = 3.6;
/// Above every panel, for its title; and between one column of panels and the next.
const ABOVE: f64 = 1.9;
const BETWEEN: f64 = 1.2;
/// From the panels to the scale of colours.
const GAP: f64 = 1.4;
const TALLEST_BAR: f64 = 360.0;
/// Below that, for each line of a note.
const LINE: f64 = 1.4;
/// The steps on which the scale of colours ends, and its least and largest depth, dB.
const STEP_DB: f64 = 5.0;
const SHALLOWEST_DB: f64 = 20.0;
const DEEPEST_DB: f64 = 80.0;
/// The share of the cells that may lie below the scale of colours.
const BELOW_SCALE: f64 = 0.02;

/// Spectrograms with one scale of colours, one of time and one of frequency, in both formats, as SVG text that takes the width
/// there is.
///
/// # Errors
/// [`DrawError`] where an image cannot be made.
pub fn svg(figure: &Spectrograms) -> Result<String, DrawError> {
    both(&alternative::spectrograms(figure), |format| {
        drawn(figure, format)
    })
}

fn drawn(figure: &Spectrograms, format: Format) -> Result<String, DrawError> {
    let (panels, unit) = (&figure.panels, &figure.unit);
    let layout = Layout::of(panels.len(), format);
    let notes = layout.notes(&figure.note);
    let height = layout.height(&figure.note);
    let mut svg = Svg::new(format, height);
    svg.background(height);
    let all = |values: fn(&SpectrogramPanel) -> (f64, f64)| {
        let ends = panels.iter().map(values);
        ends.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
            .unwrap_or((0.0, 1.0))
    };
    // Time begins with the recording: the first column stands in the middle of its segment.
    let (time, frequency) = ((0.0, all(times).1), all(frequencies));
    let scale = scale_db(panels);
    for (i, panel) in panels.iter().enumerate() {
        let frame = Frame {
            at: layout.place(i),
            size: layout.size,
            time,
            frequency,
        };
        svg.text(
            (frame.at.0, frame.at.1 - format.em(0.5)),
            "start",
            &format.cut(&panel.title, layout.size.0),
        );
        let image = Image {
            values: &panel.levels_db,
            columns: panel.times_s.len(),
            scale,
            colours: Colours::Rising,
        };
        frame.fill(&mut svg, panel, &image)?;
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
        (
            0.5 * (left + layout.right()),
            layout.bottom() + format.em(2.9),
        ),
        "middle",
        "time, s",
    );
    svg.upright((format.em(1.1), middle), "frequency, Hz");
    let tall = (layout.bottom() - top).min(TALLEST_BAR);
    svg.colour_bar(
        (layout.right() + format.em(GAP), middle - 0.5 * tall),
        tall,
        scale,
        Colours::Rising,
        &format!("PSD, dB re 1 {unit}"),
    );
    for (i, note) in notes.iter().enumerate() {
        let y = layout.bottom() + format.em(BELOW + LINE * (i as f64 + 0.9));
        svg.text((format.em(0.5), y), "start", note);
    }
    Ok(svg.finish())
}

/// Where panels stand: the same size each, in rows.
struct Layout {
    format: Format,
    across: usize,
    down: usize,
    size: (f64, f64),
}

impl Layout {
    fn of(panels: usize, format: Format) -> Self {
        let (across, high) = match panels {
            0 | 1 if format.is_narrow() => (1, 170.0),
            0 | 1 => (1, 300.0),
            2..=4 if !format.is_narrow() => (2, 170.0),
            2 => (1, 130.0),
            _ if format.is_narrow() => (2, 110.0),
            _ => (3, 140.0),
        };
        let around = format.em(LEFT + GAP) + format.scale_width();
        let between = format.em(BETWEEN) * (across - 1) as f64;
        Self {
            format,
            across,
            down: panels.div_ceil(across).max(1),
            size: (
                (f64::from(format.width) - around - between) / across as f64,
                high,
            ),
        }
    }

    /// The left and the top of panel `i`.
    fn place(&self, i: usize) -> (f64, f64) {
        let (column, row) = ((i % self.across) as f64, (i / self.across) as f64);
        let em = |share| self.format.em(share);
        (
            em(LEFT) + (self.size.0 + em(BETWEEN)) * column,
            em(ABOVE) + (self.size.1 + em(ABOVE)) * row,
        )
    }

    fn right(&self) -> f64 {
        self.place(self.across - 1).0 + self.size.0
    }

    fn bottom(&self) -> f64 {
        (self.size.1 + self.format.em(ABOVE)) * self.down as f64
    }

    /// What stands below: what grey means, and a note.
    fn notes(&self, note: &str) -> Vec<String> {
        let room = f64::from(self.format.width) - self.format.em(1.0);
        let grey = self
            .format
            .lines("Grey: no segment is centred there.", room);
        [grey, self.format.lines(note, room)].concat()
    }

    fn height(&self, note: &str) -> f64 {
        let lines = self.notes(note).len() as f64;
        self.bottom() + self.format.em(BELOW + LINE * lines + 0.4)
    }
}

/// A panel's frame and the ranges of its axes.
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

    fn fill(
        &self,
        svg: &mut Svg,
        panel: &SpectrogramPanel,
        image: &Image<'_>,
    ) -> Result<(), DrawError> {
        let (time, frequency) = (times(panel), frequencies(panel));
        let (left, right) = (self.x(time.0), self.x(time.1));
        let (top, bottom) = (self.y(frequency.1), self.y(frequency.0));
        svg.missing(self.at, self.size);
        svg.image((left, top), (right - left, bottom - top), image)?;
        svg.frame(self.at, self.size);
        Ok(())
    }

    fn time_ticks(&self, svg: &mut Svg) {
        let bottom = self.at.1 + self.size.1;
        for tick in ticks(self.time.0, self.time.1, self.size.0 / svg.em(5.0)) {
            svg.mark_below(self.x(tick), bottom, tick);
        }
    }

    fn frequency_ticks(&self, svg: &mut Svg) {
        let (low, high) = self.frequency;
        for tick in ticks(low, high, self.size.1 / svg.em(2.8)) {
            svg.mark_left(self.at.0, self.y(tick), tick);
        }
    }
}

/// From where to where the columns reach, s.
fn times(panel: &SpectrogramPanel) -> (f64, f64) {
    reach(&panel.times_s, panel.time_step_s)
}

/// From where to where the rows reach, Hz.
fn frequencies(panel: &SpectrogramPanel) -> (f64, f64) {
    reach(&panel.frequencies_hz, panel.frequency_step_hz)
}

/// Cells of one size; the first one's middle is known, the last may stand for less.
fn reach(middles: &[f64], step: f64) -> (f64, f64) {
    let low = middles.first().map_or(0.0, |first| first - 0.5 * step);
    (low, low + step * middles.len().max(1) as f64)
}

/// The ends of a scale that holds the loudest cell of all, and nearly all cells above its low end.
fn scale_db(panels: &[SpectrogramPanel]) -> (f64, f64) {
    let mut levels: Vec<f64> = panels
        .iter()
        .flat_map(|panel| &panel.levels_db)
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

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::quantity::{Acceleration, Hertz, SampleRate};
    use piezotact::series::Series;
    use piezotact::spectrum::{Cells, SpectrogramConfig, spectrogram};

    fn figure(panels: Vec<SpectrogramPanel>, unit: &str) -> Spectrograms {
        Spectrograms {
            panels,
            unit: unit.into(),
            note: String::new(),
        }
    }

    /// A tone that rises, at `level`, for `seconds`.
    fn rising(title: &str, level: f64, seconds: f64) -> SpectrogramPanel {
        let rate = SampleRate::new(2000.0).unwrap();
        let samples = (0..(2000.0 * seconds) as usize).map(|i| {
            let t = i as f64 / 2000.0;
            level * (std::f64::consts::TAU * (100.0 + 100.0 * t) * t).sin()
        });
        let series = Series::<Acceleration>::new(samples.collect(), rate).unwrap();
        let config = SpectrogramConfig {
            cells: Cells::of_a_figure(Hertz(1000.0)),
            ..SpectrogramConfig::usual(rate)
        };
        spectrogram(&series, &config).unwrap().panel(title)
    }

    fn count(svg: &str, part: &str) -> usize {
        svg.matches(part).count()
    }

    /// Panels have their titles, and between them one scale of colours and one label for each axis.
    #[test]
    fn multiples_share_their_scales() {
        let spectrograms: Vec<_> = (1..=7)
            .map(|k| {
                rising(
                    &format!("S{k} & more"),
                    f64::from(k),
                    1.0 + 0.2 * f64::from(k),
                )
            })
            .collect();
        for panels in 1..=7 {
            let panels = spectrograms[..panels].to_vec();
            let svg = drawn(&figure(panels.clone(), "(m/s²)²/Hz"), Format::WIDE).unwrap();
            assert_eq!(count(&svg, "<image"), panels.len());
            assert_eq!(count(&svg, "&amp; more"), panels.len());
            for once in [">time, s<", ">frequency, Hz<", ">PSD, dB re 1 (m/s²)²/Hz<"] {
                assert_eq!(count(&svg, once), 1, "{once}");
            }
            let across = Layout::of(panels.len(), Format::WIDE).across;
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
            let panel = SpectrogramPanel {
                levels_db: levels.to_vec(),
                ..rising("", 1.0, 0.5)
            };
            assert_eq!(scale_db(&[panel]), expected);
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

    /// The highest row comes first.
    #[test]
    fn high_frequencies_are_on_top() {
        let panel = rising("rising", 1.0, 1.0);
        let (columns, rows) = (panel.times_s.len(), panel.frequencies_hz.len());
        let levels = &panel.levels_db;
        assert_eq!(levels.len(), columns * rows);
        let loudest = (0..rows)
            .max_by(|a, b| levels[a * columns].total_cmp(&levels[b * columns]))
            .unwrap();
        let at_hz = panel.frequencies_hz[rows - 1 - loudest];
        assert!((100.0..=130.0).contains(&at_hz), "{at_hz}");
    }
}
