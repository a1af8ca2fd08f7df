//! The parameters of roughness as people read them: lengths in µm.

use anyhow::anyhow;
use piezotact::surface::{ArealRoughness, ProfileRoughness};

use crate::failure::{Failure, Outcome};
use crate::output::digits_that_count;

/// A parameter, its unit and its meaning.
pub(crate) struct Parameter {
    pub(crate) symbol: &'static str,
    /// In `unit`; absent where the surface has none.
    pub(crate) value: Option<f64>,
    /// Empty for a number without one.
    pub(crate) unit: &'static str,
    pub(crate) meaning: &'static str,
}

impl Parameter {
    /// The value with the digits that count, or a dash.
    pub(crate) fn number(&self) -> String {
        let number = |value| digits_that_count(value, 4);
        self.value.map_or_else(|| "–".into(), number)
    }

    /// The name in JSON: that of the parameter, with the unit where it is not µm or none.
    pub(crate) fn key(&self) -> &'static str {
        match self.symbol {
            "Sdr" => "Sdr_percent",
            symbol => symbol,
        }
    }
}

fn length(symbol: &'static str, value_m: Option<f64>, meaning: &'static str) -> Parameter {
    Parameter {
        symbol,
        value: value_m.map(|m| m * 1e6),
        unit: "µm",
        meaning,
    }
}

fn number(symbol: &'static str, value: Option<f64>, meaning: &'static str) -> Parameter {
    Parameter {
        symbol,
        value,
        unit: "",
        meaning,
    }
}

pub(crate) fn of_profile(r: &ProfileRoughness) -> Vec<Parameter> {
    vec![
        length("Ra", Some(r.ra_m), "arithmetic mean height"),
        length("Rq", Some(r.rq_m), "root-mean-square height"),
        length("Rz", Some(r.rz_m), "maximum height of a section, mean"),
        length("Rt", Some(r.rt_m), "total height"),
        length("Rp", Some(r.rp_m), "highest peak of a section, mean"),
        length("Rv", Some(r.rv_m), "deepest valley of a section, mean"),
        number("Rsk", r.rsk, "skewness"),
        number("Rku", r.rku, "kurtosis, 3 for Gaussian heights"),
        length("RSm", r.rsm_m, "mean width of the profile elements"),
        number("Rdq", Some(r.rdq), "root-mean-square slope"),
    ]
}

pub(crate) fn areal(r: &ArealRoughness) -> Vec<Parameter> {
    vec![
        length("Sa", Some(r.sa_m), "arithmetic mean height"),
        length("Sq", Some(r.sq_m), "root-mean-square height"),
        length("Sz", Some(r.sz_m), "maximum height"),
        length("Sp", Some(r.sp_m), "highest peak"),
        length("Sv", Some(r.sv_m), "deepest pit"),
        number("Ssk", r.ssk, "skewness"),
        number("Sku", r.sku, "kurtosis, 3 for Gaussian heights"),
        number("Sdq", r.sdq, "root-mean-square gradient"),
        Parameter {
            symbol: "Sdr",
            value: r.sdr.map(|share| share * 100.0),
            unit: "%",
            meaning: "area beyond the projected one",
        },
        length("Sal", r.sal_m, "autocorrelation length"),
        number(
            "Str",
            r.str_ratio,
            "aspect ratio of the texture, 0 for ridges to 1",
        ),
    ]
}

/// A profile as a table: one row for each point.
pub(super) fn csv_of(roughness: &ProfileRoughness) -> Outcome<String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(["position_mm", "primary_um", "mean_line_um", "roughness_um"])?;
    let step_mm = roughness.roughness.step_m() * 1e3;
    let primary = roughness.primary();
    let lines = primary
        .heights_m()
        .iter()
        .zip(roughness.mean_line.heights_m())
        .zip(roughness.roughness.heights_m());
    for (i, ((primary_m, mean_m), rough_m)) in lines.enumerate() {
        writer.write_record([
            format!("{:.9}", i as f64 * step_mm),
            format!("{:.6}", primary_m * 1e6),
            format!("{:.6}", mean_m * 1e6),
            format!("{:.6}", rough_m * 1e6),
        ])?;
    }
    let bytes = writer
        .into_inner()
        .map_err(|error| anyhow!("a table could not be written: {error}"))?;
    String::from_utf8(bytes).map_err(Failure::from)
}
