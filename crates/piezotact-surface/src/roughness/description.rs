//! How large a surface is and how its roughness was computed, in words.

use super::{
    ArealRoughness, Cutoff, Ends, Form, LineRoughness, ProfileFilter, ProfileRoughness,
    ProfileStandard, Roughness, Texture, TextureKind,
};
use piezotact::criterion::Outcome;
use piezotact::number::{digits_that_count, signed};

/// The unit that a length of this size, m, is read in, and how many of it make a metre.
///
/// Source: ISO 3274 states cut-offs in mm and tip radii in µm.
#[must_use]
pub fn unit_for(length_m: f64) -> (&'static str, f64) {
    match length_m.abs() {
        m if m < 0.0999e-6 => ("nm", 1e9),
        m if m < 0.0999e-3 => ("µm", 1e6),
        _ => ("mm", 1e3),
    }
}

/// A length, m, for a person, without digits that say nothing.
///
/// Source: as [`unit_for`].
///
/// ```
/// use piezotact_surface::length_text;
/// assert_eq!([length_text(0.8e-3), length_text(2.5e-6)], ["0.8 mm", "2.5 µm"]);
/// ```
#[must_use]
pub fn length_text(length_m: f64) -> String {
    let (unit, per_m) = unit_for(length_m);
    format!("{} {unit}", short_number(length_m * per_m))
}

/// Two lengths in one unit.
fn both(x_m: f64, y_m: f64) -> String {
    let (unit, per_m) = unit_for(x_m.max(y_m));
    format!(
        "{} × {} {unit}",
        short_number(x_m * per_m),
        short_number(y_m * per_m)
    )
}

/// Four digits that count, without zeros that say nothing.
///
/// Source: as [`digits_that_count`].
///
/// ```
/// assert_eq!(piezotact_surface::short_number(2.50), "2.5");
/// ```
#[must_use]
pub fn short_number(value: f64) -> String {
    let text = digits_that_count(value, 4);
    if text.contains('.') && !text.contains('e') {
        text.trim_end_matches('0').trim_end_matches('.').into()
    } else {
        text
    }
}

impl Roughness {
    /// How large the surface is, and how fine, in words.
    ///
    /// Source: docs/decisions/documents.md.
    #[must_use]
    pub fn size_text(&self) -> String {
        match self {
            Self::Profile(r) => format!(
                "profile of {} points, spacing {}, length {}",
                r.roughness.heights_m().len(),
                length_text(r.roughness.step_m()),
                length_text(r.roughness.length_m())
            ),
            Self::Map(r) => {
                let map = &r.surface;
                format!(
                    "height map of {} × {} points, spacing {}, size {}",
                    map.columns(),
                    map.rows(),
                    both(map.step_x_m(), map.step_y_m()),
                    both(map.length_x_m(), map.length_y_m())
                )
            }
        }
    }

    /// One line on how it was computed.
    ///
    /// Source: docs/decisions/documents.md.
    #[must_use]
    pub fn method_text(&self) -> String {
        match self {
            Self::Profile(roughness) => of_profile(roughness),
            Self::Map(roughness) => of_map(roughness),
        }
    }
}

impl Texture {
    /// The period and the elements in a sentence, or why there is none.
    ///
    /// Source: docs/decisions/roughness.md.
    #[must_use]
    pub fn text(&self) -> String {
        let Some(found) = &self.periodic else {
            let why = (self.criteria.iter()).find(|criterion| criterion.outcome != Outcome::Met);
            return match why {
                Some(criterion) => format!("No period: {criterion}."),
                None => "No period: the autocorrelation has no clear maximum up to a quarter of the map.".into(),
            };
        };
        let (what, second) = match (found.kind, found.second_period_m) {
            (TextureKind::Ridges, _) => ("width", String::new()),
            (_, Some(second_m)) => ("diameter", format!(" and {}", length_text(second_m))),
            (_, None) => ("diameter", String::new()),
        };
        let height = match found.kind {
            TextureKind::Pits => "depth",
            TextureKind::Dots | TextureKind::Ridges => "height",
        };
        let dots = found.dots.map_or_else(String::new, |(count, spread_m)| {
            // Equal ones differ by rounding.
            let spread = match spread_m > 1e-6 * found.width_m {
                true => format!("standard deviation {}", length_text(spread_m)),
                false => "all alike".into(),
            };
            format!(" ({count} whole {}, {spread})", found.kind)
        });
        format!(
            "Texture of {}: period {}{second} ({}° from x), {height} {}, {what} at half {height} {}{dots}.",
            found.kind,
            length_text(found.period_m),
            signed(found.direction_deg, 1),
            length_text(found.height_m),
            length_text(found.width_m)
        )
    }
}

impl LineRoughness {
    /// Ra, Rz and Rq of the lines, how they were evaluated, and the slope of their spectrum, in words.
    ///
    /// Source: docs/decisions/roughness.md.
    #[must_use]
    pub fn text(&self) -> String {
        let values = ["Ra", "Rz", "Rq"].map(|symbol| {
            let mut parameters = self.parameters.iter();
            let found = parameters.find(|parameter| parameter.mean.symbol == symbol);
            let deviation = found.and_then(|found| found.deviation).unwrap_or(0.0);
            let value = found.map_or_else(|| "–".into(), |found| found.mean.number());
            format!("{symbol} {value} ± {} µm", digits_that_count(deviation, 2))
        });
        let incomplete = match self.incomplete {
            0 => String::new(),
            count => format!("; {count} with points that were not measured are left out"),
        };
        let law = match self.law {
            None => "their spectrum follows no power law over a decade of wavelengths".into(),
            Some(law) => {
                let hurst = law
                    .hurst
                    .map_or_else(String::new, |h| format!(" (Hurst exponent {h:.2})"));
                let [shortest_m, longest_m] = law.wavelengths_m;
                format!(
                    "the slope of their spectrum is {:.2}{hurst} from {} to {}",
                    law.slope,
                    length_text(shortest_m),
                    length_text(longest_m)
                )
            }
        };
        format!(
            "{} of {} lines along {} (mean ± standard deviation between them{incomplete}): {}; {law}.",
            values.join(", "),
            self.lines,
            self.along,
            of_profile(&self.example)
        )
    }
}

fn of_profile(r: &ProfileRoughness) -> String {
    let standard = match r.config.standard {
        ProfileStandard::Iso4287 => "ISO 4287",
        ProfileStandard::Iso21920 => "ISO 21920-2",
    };
    let why = match r.config.cutoff {
        Cutoff::Stated(_) => "stated",
        _ if !r.cutoff_settled => "the closest value in the table of ISO 4288 for this length",
        Cutoff::Iso4288 => "chosen by ISO 4288 from Ra",
        Cutoff::Iso4288Periodic => "chosen by ISO 4288 from RSm",
    };
    let cutoff = match (r.config.filter, r.cutoff_m) {
        (ProfileFilter::Gauss, Some(cutoff_m)) => {
            format!(
                "Gaussian filter, cut-off λc {} ({why})",
                length_text(cutoff_m)
            )
        }
        (ProfileFilter::None, Some(cutoff_m)) => {
            format!(
                "no filter, sampling lengths of {} (stated)",
                length_text(cutoff_m)
            )
        }
        (ProfileFilter::Instrument, Some(cutoff_m)) => format!(
            "filtered by the instrument (cut-off λc {}), not filtered again",
            length_text(cutoff_m)
        ),
        (ProfileFilter::Instrument, None) => {
            "filtered by the instrument, not filtered again".into()
        }
        (_, None) => "no filter".into(),
    };
    let short_waves = match (r.config.filter, r.lambda_s_m) {
        (ProfileFilter::None | ProfileFilter::Instrument, _) => String::new(),
        (ProfileFilter::Gauss, Some(s_m)) => format!(", λs {}", length_text(s_m)),
        (ProfileFilter::Gauss, None) => ", no λs".into(),
    };
    let sections = match r.sections {
        1 => "1 sampling length".into(),
        sections => format!("{sections} sampling lengths"),
    };
    let ends = match r.ends {
        Ends::Dropped => ", without the ends",
        Ends::Kept => ", ends included",
        Ends::Unfiltered => "",
    };
    format!(
        "{standard}; {}; {cutoff}{short_waves}; {sections}, evaluation length {}{ends}",
        form_text(r.config.form, "line"),
        length_text(r.evaluation_length_m)
    )
}

fn of_map(r: &ArealRoughness) -> String {
    let filter = |name: &str, nesting_m: Option<f64>| match nesting_m {
        Some(nesting_m) => format!("{name} Gaussian, {}", length_text(nesting_m)),
        None => format!("no {name}"),
    };
    format!(
        "ISO 25178-2; {}; {}; {}",
        form_text(r.config.form, "plane"),
        filter("S-filter", r.config.s_nesting_m),
        filter("L-filter", r.config.l_nesting_m)
    )
}

fn form_text(form: Form, level: &str) -> String {
    match form {
        Form::Mean => "only the mean height removed".into(),
        Form::Level => format!("least-squares {level} removed"),
        Form::Polynomial(degree) => format!("polynomial of degree {degree} removed"),
    }
}
