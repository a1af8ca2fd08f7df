//! The two formats in which every figure of a page is drawn: for wide and for narrow places. A page shows the one that fits.

use crate::image::escaped;

/// How wide a figure is and how large its texts are, in pixels of the drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Format {
    pub(crate) width: u32,
    pub(crate) text: u32,
    /// Its class in a page.
    pub(crate) class: &'static str,
}

impl Format {
    /// Drawn at two thirds of its width its texts are still 11 px high.
    pub(crate) const WIDE: Self = Self {
        width: 900,
        text: 16,
        class: "wide-format",
    };
    /// As wide as the card of a page on a telephone.
    pub(crate) const NARROW: Self = Self {
        width: 330,
        text: 12,
        class: "narrow-format",
    };

    pub(crate) fn is_narrow(self) -> bool {
        self == Self::NARROW
    }

    /// `share` of the height of a text.
    pub(crate) fn em(self, share: f64) -> f64 {
        share * f64::from(self.text)
    }

    /// How wide a scale of colours is with its numbers and its label.
    pub(crate) fn scale_width(self) -> f64 {
        self.em(6.0)
    }

    /// About how wide a text is.
    pub(crate) fn width_of(self, text: &str) -> f64 {
        0.6 * f64::from(self.text) * text.chars().count() as f64
    }

    /// `text` cut where `room` ends.
    pub(crate) fn cut(self, text: &str, room: f64) -> String {
        if self.width_of(text) <= room {
            return text.into();
        }
        let letters = (room / (0.6 * f64::from(self.text))) as usize;
        let kept = text.chars().take(letters.saturating_sub(1));
        kept.chain(['…']).collect()
    }

    /// `text` in lines of at most `room`, broken between words.
    pub(crate) fn lines(self, text: &str, room: f64) -> Vec<String> {
        let mut lines: Vec<String> = Vec::new();
        for word in text.split_whitespace() {
            match lines.last_mut() {
                Some(line) if self.width_of(line) + self.width_of(word) < room => {
                    line.push(' ');
                    line.push_str(word);
                }
                _ => lines.push(self.cut(word, room)),
            }
        }
        lines
    }
}

/// A figure in both formats, one after the other, each with its class and with the text `alternative` for who cannot see it.
pub(crate) fn both<E>(
    alternative: &str,
    drawn: impl Fn(Format) -> Result<String, E>,
) -> Result<String, E> {
    let label = labelled(alternative);
    let classed = |format: Format| -> Result<String, E> {
        let class = format!("role=\"img\" class=\"{}\" {label}", format.class);
        Ok(drawn(format)?.replacen("role=\"img\"", &class, 1))
    };
    Ok(format!(
        "{}\n{}",
        classed(Format::WIDE)?,
        classed(Format::NARROW)?
    ))
}

/// The attribute of a drawing that says what it shows.
pub(crate) fn labelled(alternative: &str) -> String {
    let text = escaped(alternative).replace('"', "&quot;");
    format!("aria-label=\"{text}\"")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_cut_and_broken_where_their_room_ends() {
        let format = Format::NARROW;
        assert_eq!(format.cut("S1 at 30 mm/s", 200.0), "S1 at 30 mm/s");
        assert_eq!(format.cut(&"ä".repeat(9), 36.1), "ääää…");
        assert_eq!(
            format.lines("error for a new participant, dB rms", 150.0),
            ["error for a new", "participant, dB rms"]
        );
        assert!(format.lines("", 10.0).is_empty());
    }
}
