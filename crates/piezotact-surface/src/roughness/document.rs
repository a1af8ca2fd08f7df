//! The roughness of a surface as it is handed out: lengths in µm and mm.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Serialize, Serializer};

use super::{
    ArealRoughness, Cutoff, Ends, Form, InstrumentSettings, LineDirection, LineRoughness,
    PeriodRule, PeriodicTexture, PowerLaw, ProfileFilter, ProfileRoughness, ProfileStandard,
    Roughness, Texture, TextureKind,
};
use piezotact::criterion::Criterion;
use piezotact::document::Content;
use piezotact::warning::{Merged, Warnings};

/// The surface in a file with its roughness. Its written form is [`RoughnessDocument`].
#[derive(Clone, Debug)]
pub struct EvaluatedSurface {
    pub file: PathBuf,
    /// What kind of file it is.
    pub format: String,
    pub roughness: Roughness,
    /// The roughness of the lines of a map, where it was asked for.
    pub lines: Option<LineRoughness>,
    /// What the instrument states of it; absent without such a file.
    pub instrument: Option<InstrumentSettings>,
    /// What limits it: of the file and of the evaluation.
    pub warnings: Warnings,
}

/// What was evaluated, in the units in which people state it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum RoughnessExtent {
    /// A profile.
    Profile {
        /// How many points it has.
        points: usize,
        /// The distance of two points, µm.
        step_um: f64,
        /// How long it is, mm.
        length_mm: f64,
    },
    /// A height map.
    Map {
        /// Points in a row.
        columns: usize,
        /// Rows.
        rows: usize,
        /// The distance of two points in a row, µm.
        step_x_um: f64,
        /// The distance of two rows, µm.
        step_y_um: f64,
        /// How long a row is, mm.
        length_x_mm: f64,
        /// How long a column is, mm.
        length_y_mm: f64,
        /// The share of the points that were not measured, 0–1.
        missing_share: f64,
    },
}

/// How the roughness was computed: lengths in the units and settings in the words in which people state them.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct RoughnessMethod {
    /// By which standard: "iso4287".
    pub standard: &'static str,
    /// Which form was taken away: "level", "poly2".
    pub form: String,
    /// Which filter: "gauss", "none", or "instrument" for a profile that the instrument had filtered.
    pub filter: &'static str,
    /// The cut-off of long waves, mm; absent without one.
    pub cutoff_mm: Option<f64>,
    /// What the cut-off follows from: "stated", "iso4288", "`iso4288_periodic`" or "instrument"; absent without one.
    pub cutoff_by: Option<&'static str>,
    /// The cut-off of short waves, µm; absent without one.
    pub lambda_s_um: Option<f64>,
    /// How many sections were evaluated; absent for a map.
    pub sections: Option<usize>,
    /// Ra of the section in which it is lowest and of that in which it is highest, µm; absent for a map.
    pub section_ra_um: Option<[f64; 2]>,
    /// The length that was evaluated, mm; absent for a map.
    pub evaluation_length_mm: Option<f64>,
    /// What was done at the ends; absent for a map.
    pub ends: Option<Ends>,
}

/// The roughness of a surface: lengths in µm and mm, and parameters by their symbol.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct RoughnessDocument<'a> {
    /// The file.
    pub file: &'a Path,
    /// What kind of file it is.
    pub format: &'a str,
    /// The unit of lengths among the parameters.
    pub unit: &'static str,
    /// The parameters by their symbol, lengths in `unit`; absent where the surface has none.
    #[serde(flatten)]
    pub parameters: BTreeMap<&'static str, Option<f64>>,
    /// What was evaluated.
    #[serde(flatten)]
    pub extent: RoughnessExtent,
    /// How.
    #[serde(flatten)]
    pub method: RoughnessMethod,
    /// Whether a map repeats itself, and how; absent for a profile and for a flat map.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub texture: Option<TextureDocument<'a>>,
    /// The roughness of the lines of a map in one direction; absent where it was not asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lines: Option<LinesDocument>,
    /// What the instrument states of it; absent without such a file.
    pub instrument: Option<&'a InstrumentSettings>,
    /// What limits it.
    pub warnings: Vec<Merged>,
}

/// The period of a map, lengths in µm.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct TextureDocument<'a> {
    /// What decides whether it repeats itself; empty where the autocorrelation has no second maximum up to a quarter of the map.
    pub criteria: &'a [Criterion<PeriodRule>],
    /// What repeats itself; absent where a criterion is not met.
    pub kind: Option<TextureKind>,
    /// The distance to the nearest neighbour, or across the ridges, µm.
    pub period_um: Option<f64>,
    /// The direction of that distance from the rows towards the columns, degrees.
    pub direction_deg: Option<f64>,
    /// The distance to the nearest neighbour in another direction, µm; absent for ridges.
    pub second_period_um: Option<f64>,
    /// The height of the mean period, µm; the depth of pits.
    pub height_um: Option<f64>,
    /// The diameter of a dot or the width of a ridge at half its height, µm.
    pub width_um: Option<f64>,
    /// How many whole dots the map holds; absent for ridges.
    pub dots: Option<usize>,
    /// The standard deviation of the diameters of those dots, µm.
    pub diameter_deviation_um: Option<f64>,
}

impl<'a> TextureDocument<'a> {
    fn of(texture: &'a Texture) -> Self {
        let found = texture.periodic.as_ref();
        let um = |of: fn(&PeriodicTexture) -> f64| found.map(|found| of(found) * 1e6);
        let dots = found.and_then(|found| found.dots);
        Self {
            criteria: &texture.criteria,
            kind: found.map(|found| found.kind),
            period_um: um(|found| found.period_m),
            direction_deg: found.map(|found| found.direction_deg),
            second_period_um: found.and_then(|found| Some(found.second_period_m? * 1e6)),
            height_um: um(|found| found.height_m),
            width_um: um(|found| found.width_m),
            dots: dots.map(|(count, _)| count),
            diameter_deviation_um: dots.map(|(_, spread_m)| spread_m * 1e6),
        }
    }
}

/// The roughness of the lines of a map: lengths in µm and mm.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct LinesDocument {
    /// In which direction.
    pub along: LineDirection,
    /// How many lines were evaluated.
    pub lines: usize,
    /// How many lines have points that were not measured, and are not evaluated.
    pub incomplete: usize,
    /// The parameters by their symbol, mean over lines, lengths in µm.
    pub mean: BTreeMap<&'static str, Option<f64>>,
    /// Their standard deviations between lines.
    pub deviation: BTreeMap<&'static str, Option<f64>>,
    /// How.
    #[serde(flatten)]
    pub method: RoughnessMethod,
    /// The power spectral density of the lines: spatial frequency in 1/mm and density in µm²·mm, in ten bins a decade.
    pub spectrum: Vec<(f64, f64)>,
    /// The widest range of wavelengths in which it follows a power law; absent without one.
    pub law: Option<PowerLaw>,
}

impl LinesDocument {
    fn of(lines: &LineRoughness) -> Self {
        let parameters = || lines.parameters.iter();
        let (_, mut method) = of_profile(&lines.example);
        method.section_ra_um = None;
        Self {
            along: lines.along,
            lines: lines.lines,
            incomplete: lines.incomplete,
            mean: parameters().map(|p| (p.mean.key(), p.mean.value)).collect(),
            deviation: parameters().map(|p| (p.mean.key(), p.deviation)).collect(),
            method,
            spectrum: (lines.spectrum.iter())
                .map(|(per_m, m3)| (per_m * 1e-3, m3 * 1e15))
                .collect(),
            law: lines.law,
        }
    }
}

impl Serialize for EvaluatedSurface {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        RoughnessDocument::of(self).serialize(serializer)
    }
}

#[cfg(feature = "schemas")]
impl schemars::JsonSchema for EvaluatedSurface {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        RoughnessDocument::schema_name()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        RoughnessDocument::json_schema(generator)
    }
}

impl Content for EvaluatedSurface {
    const SCHEMA: &'static str = "roughness";
}

impl<'a> RoughnessDocument<'a> {
    /// The roughness of `surface`, lengths in µm and mm.
    ///
    /// Source: docs/decisions/documents.md.
    #[must_use]
    pub fn of(surface: &'a EvaluatedSurface) -> Self {
        let parameters = surface.roughness.parameters();
        let (extent, method) = match &surface.roughness {
            Roughness::Profile(roughness) => of_profile(roughness),
            Roughness::Map(roughness) => of_map(roughness),
        };
        Self {
            file: &surface.file,
            format: &surface.format,
            unit: "um",
            parameters: (parameters.iter())
                .map(|parameter| (parameter.key(), parameter.value))
                .collect(),
            extent,
            method,
            texture: match &surface.roughness {
                Roughness::Map(roughness) => roughness.texture.as_ref().map(TextureDocument::of),
                Roughness::Profile(_) => None,
            },
            lines: surface.lines.as_ref().map(LinesDocument::of),
            instrument: surface.instrument.as_ref(),
            warnings: surface.warnings.merged(),
        }
    }
}

fn form_name(form: Form) -> String {
    match form {
        Form::Mean => "mean".into(),
        Form::Level => "level".into(),
        Form::Polynomial(degree) => format!("poly{degree}"),
    }
}

fn of_profile(r: &ProfileRoughness) -> (RoughnessExtent, RoughnessMethod) {
    let extent = RoughnessExtent::Profile {
        points: r.roughness.heights_m().len(),
        step_um: r.roughness.step_m() * 1e6,
        length_mm: r.roughness.length_m() * 1e3,
    };
    let method = RoughnessMethod {
        standard: match r.config.standard {
            ProfileStandard::Iso4287 => "iso4287",
            ProfileStandard::Iso21920 => "iso21920",
        },
        form: form_name(r.config.form),
        filter: match r.config.filter {
            ProfileFilter::Gauss => "gauss",
            ProfileFilter::None => "none",
            ProfileFilter::Instrument => "instrument",
        },
        cutoff_mm: r.cutoff_m.map(|m| m * 1e3),
        cutoff_by: match (r.config.filter, r.config.cutoff) {
            (ProfileFilter::Instrument, Cutoff::Stated(_)) => Some("instrument"),
            (_, Cutoff::Stated(_)) => Some("stated"),
            (ProfileFilter::None | ProfileFilter::Instrument, _) => None,
            (_, Cutoff::Iso4288) => Some("iso4288"),
            (_, Cutoff::Iso4288Periodic) => Some("iso4288_periodic"),
        },
        lambda_s_um: r.lambda_s_m.map(|m| m * 1e6),
        sections: Some(r.sections),
        section_ra_um: Some(r.section_ra_m.map(|m| m * 1e6)),
        evaluation_length_mm: Some(r.evaluation_length_m * 1e3),
        ends: Some(r.ends),
    };
    (extent, method)
}

fn of_map(r: &ArealRoughness) -> (RoughnessExtent, RoughnessMethod) {
    let map = &r.surface;
    let filtered = r.config.s_nesting_m.or(r.config.l_nesting_m).is_some();
    let extent = RoughnessExtent::Map {
        columns: map.columns(),
        rows: map.rows(),
        step_x_um: map.step_x_m() * 1e6,
        step_y_um: map.step_y_m() * 1e6,
        length_x_mm: map.length_x_m() * 1e3,
        length_y_mm: map.length_y_m() * 1e3,
        missing_share: map.missing_share(),
    };
    let method = RoughnessMethod {
        standard: "iso25178",
        form: form_name(r.config.form),
        filter: if filtered { "gauss" } else { "none" },
        cutoff_mm: r.config.l_nesting_m.map(|m| m * 1e3),
        cutoff_by: r.config.l_nesting_m.map(|_| "stated"),
        lambda_s_um: r.config.s_nesting_m.map(|m| m * 1e6),
        sections: None,
        section_ra_um: None,
        evaluation_length_mm: None,
        ends: None,
    };
    (extent, method)
}
