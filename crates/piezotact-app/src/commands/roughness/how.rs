//! How a roughness was computed: said in a line, and stated in JSON.

use piezotact::surface::SurfaceDoubt;
use piezotact::surface::{
    ArealRoughness, Cutoff, Ends, Form, ProfileFilter, ProfileRoughness, ProfileStandard,
};
use serde_json::{Map, Value, json};

use super::{Evaluated, Surface};
use crate::output::digits_that_count;

/// The unit that a length of this size is read in, and how many of it make a metre.
pub(crate) fn unit_for(length_m: f64) -> (&'static str, f64) {
    match length_m.abs() {
        m if m < 0.0999e-6 => ("nm", 1e9),
        m if m < 0.0999e-3 => ("µm", 1e6),
        _ => ("mm", 1e3),
    }
}

/// A length for a person, without digits that say nothing.
pub(crate) fn length_text(length_m: f64) -> String {
    let (unit, per_m) = unit_for(length_m);
    format!("{} {unit}", short(length_m * per_m))
}

/// Two lengths in one unit.
fn both(x_m: f64, y_m: f64) -> String {
    let (unit, per_m) = unit_for(x_m.max(y_m));
    format!("{} × {} {unit}", short(x_m * per_m), short(y_m * per_m))
}

/// Four digits that count, without zeros that say nothing.
pub(crate) fn short(value: f64) -> String {
    let text = digits_that_count(value, 4);
    if text.contains('.') && !text.contains('e') {
        text.trim_end_matches('0').trim_end_matches('.').into()
    } else {
        text
    }
}

/// How large the surface is, and how fine.
pub(crate) fn size(surface: &Surface) -> String {
    match &surface.roughness {
        Evaluated::Profile(r) => format!(
            "profile of {} points, {} apart, {}",
            r.roughness.heights_m().len(),
            length_text(r.roughness.step_m()),
            length_text(r.roughness.length_m())
        ),
        Evaluated::Map(r) => {
            let map = &r.surface;
            format!(
                "height map of {} × {} points, {} apart, {}",
                map.columns(),
                map.rows(),
                both(map.step_x_m(), map.step_y_m()),
                both(map.length_x_m(), map.length_y_m())
            )
        }
    }
}

/// One line on how it was computed.
pub(crate) fn how(surface: &Surface) -> String {
    match &surface.roughness {
        Evaluated::Profile(roughness) => of_profile(roughness),
        Evaluated::Map(roughness) => of_map(roughness),
    }
}

fn of_profile(r: &ProfileRoughness) -> String {
    let standard = match r.config.standard {
        ProfileStandard::Iso4287 => "ISO 4287",
        ProfileStandard::Iso21920 => "ISO 21920-2",
    };
    let unsettled = r
        .doubts
        .iter()
        .any(|doubt| matches!(doubt.kind(), Some(SurfaceDoubt::CutoffUnsettled { .. })));
    let why = match r.config.cutoff {
        Cutoff::Stated(_) => "stated",
        _ if unsettled => "the nearest that the table of ISO 4288 offers for this length",
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
            format!("no filter, sections of {} (stated)", length_text(cutoff_m))
        }
        (_, None) => "no filter".into(),
    };
    let short_waves = match (r.config.filter, r.lambda_s_m) {
        (ProfileFilter::None, _) => String::new(),
        (ProfileFilter::Gauss, Some(s_m)) => format!(", λs {}", length_text(s_m)),
        (ProfileFilter::Gauss, None) => ", no λs".into(),
    };
    let sections = match r.sections {
        1 => "1 section".into(),
        sections => format!("{sections} sections"),
    };
    let ends = match r.ends {
        Ends::Dropped => ", in the middle",
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
        Form::Mean => "only the mean height taken away".into(),
        Form::Level => format!("least-squares {level} taken away"),
        Form::Polynomial(degree) => format!("polynomial of degree {degree} taken away"),
    }
}

fn form_name(form: Form) -> String {
    match form {
        Form::Mean => "mean".into(),
        Form::Level => "level".into(),
        Form::Polynomial(degree) => format!("poly{degree}"),
    }
}

fn fields(value: Value) -> Map<String, Value> {
    match value {
        Value::Object(fields) => fields,
        _ => Map::new(),
    }
}

pub(super) fn profile_json(r: &ProfileRoughness) -> Map<String, Value> {
    fields(json!({
        "kind": "profile",
        "points": r.roughness.heights_m().len(),
        "step_um": r.roughness.step_m() * 1e6,
        "length_mm": r.roughness.length_m() * 1e3,
        "standard": match r.config.standard {
            ProfileStandard::Iso4287 => "iso4287",
            ProfileStandard::Iso21920 => "iso21920",
        },
        "form": form_name(r.config.form),
        "filter": match r.config.filter {
            ProfileFilter::Gauss => "gauss",
            ProfileFilter::None => "none",
        },
        "cutoff_mm": r.cutoff_m.map(|m| m * 1e3),
        "cutoff_by": match (r.config.filter, r.config.cutoff) {
            (_, Cutoff::Stated(_)) => Some("stated"),
            (ProfileFilter::None, _) => None,
            (_, Cutoff::Iso4288) => Some("iso4288"),
            (_, Cutoff::Iso4288Periodic) => Some("iso4288_periodic"),
        },
        "lambda_s_um": r.lambda_s_m.map(|m| m * 1e6),
        "sections": r.sections,
        "evaluation_length_mm": r.evaluation_length_m * 1e3,
        "ends": r.ends,
    }))
}

pub(super) fn map_json(r: &ArealRoughness) -> Map<String, Value> {
    let map = &r.surface;
    let filtered = r.config.s_nesting_m.or(r.config.l_nesting_m).is_some();
    fields(json!({
        "kind": "map",
        "columns": map.columns(),
        "rows": map.rows(),
        "step_x_um": map.step_x_m() * 1e6,
        "step_y_um": map.step_y_m() * 1e6,
        "length_x_mm": map.length_x_m() * 1e3,
        "length_y_mm": map.length_y_m() * 1e3,
        "missing_share": map.missing_share(),
        "standard": "iso25178",
        "form": form_name(r.config.form),
        "filter": if filtered { "gauss" } else { "none" },
        "cutoff_mm": r.config.l_nesting_m.map(|m| m * 1e3),
        "cutoff_by": r.config.l_nesting_m.map(|_| "stated"),
        "lambda_s_um": r.config.s_nesting_m.map(|m| m * 1e6),
        "sections": null,
        "evaluation_length_mm": null,
        "ends": null,
    }))
}
