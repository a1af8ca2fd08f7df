//! The parameters of roughness as people read them: lengths in µm.

use super::{ArealRoughness, ProfileRoughness, Roughness};
use piezotact::number::digits_that_count;
use piezotact::page::{Cell, Column, Table};

/// A parameter, its unit and its meaning.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Its symbol: "Ra".
    pub symbol: &'static str,
    /// In `unit`; absent where the surface has none.
    pub value: Option<f64>,
    /// Empty for a number without one.
    pub unit: &'static str,
    /// What it is, in words.
    pub meaning: &'static str,
}

impl Parameter {
    /// The value with the digits that count, or a dash.
    #[must_use]
    pub fn number(&self) -> String {
        let number = |value| digits_that_count(value, 4);
        self.value.map_or_else(|| "–".into(), number)
    }

    /// The name in JSON: that of the parameter, with the unit where it is not µm or none.
    #[must_use]
    pub fn key(&self) -> &'static str {
        key_of(self.symbol)
    }
}

/// The name in JSON of the parameter with that symbol.
pub(super) fn key_of(symbol: &str) -> &str {
    match symbol {
        "Sdr" => "Sdr_percent",
        "Mr1" => "Mr1_percent",
        "Mr2" => "Mr2_percent",
        symbol => symbol,
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

fn percent(symbol: &'static str, share: Option<f64>, meaning: &'static str) -> Parameter {
    Parameter {
        symbol,
        value: share.map(|share| share * 100.0),
        unit: "%",
        meaning,
    }
}

fn of_profile(r: &ProfileRoughness) -> Vec<Parameter> {
    let curve = r.material;
    vec![
        length("Ra", Some(r.ra_m), "arithmetic mean height"),
        length("Rq", Some(r.rq_m), "root-mean-square height"),
        length(
            "Rz",
            Some(r.rz_m),
            "maximum height per sampling length, mean",
        ),
        length("Rt", Some(r.rt_m), "total height of the profile"),
        length(
            "Rp",
            Some(r.rp_m),
            "maximum peak height per sampling length, mean",
        ),
        length(
            "Rv",
            Some(r.rv_m),
            "maximum valley depth per sampling length, mean",
        ),
        number("Rsk", r.rsk, "skewness"),
        number("Rku", r.rku, "kurtosis, 3 for Gaussian heights"),
        length(
            "RSm",
            r.rsm_m,
            match r.rsm_m {
                Some(_) => "mean width of the profile elements",
                None => {
                    "mean width of the profile elements: there is no whole one (a peak and a valley beyond 10 % of Rz)"
                }
            },
        ),
        number("Rdq", Some(r.rdq), "root-mean-square slope"),
        length("Rk", curve.map(|c| c.rk_m), "core height"),
        length("Rpk", curve.map(|c| c.rpk_m), "reduced peak height"),
        length("Rvk", curve.map(|c| c.rvk_m), "reduced valley depth"),
        percent("Mr1", curve.map(|c| c.mr1), "material ratio of the peaks"),
        percent(
            "Mr2",
            curve.map(|c| c.mr2),
            "material ratio of peaks and core",
        ),
    ]
}

fn areal(r: &ArealRoughness) -> Vec<Parameter> {
    vec![
        length("Sa", Some(r.sa_m), "arithmetic mean height"),
        length("Sq", Some(r.sq_m), "root-mean-square height"),
        length("Sz", Some(r.sz_m), "maximum height"),
        length("Sp", Some(r.sp_m), "maximum peak height"),
        length("Sv", Some(r.sv_m), "maximum pit height"),
        number("Ssk", r.ssk, "skewness"),
        number("Sku", r.sku, "kurtosis, 3 for Gaussian heights"),
        number("Sdq", r.sdq, "root-mean-square gradient"),
        percent("Sdr", r.sdr, "developed interfacial area ratio"),
        length("Sal", r.sal_m, "autocorrelation length"),
        number(
            "Str",
            r.str_ratio,
            "texture aspect ratio, from 0 (directional) to 1 (isotropic)",
        ),
    ]
}

impl Roughness {
    /// The parameters in the order of a report, lengths in µm.
    ///
    /// Source: ISO 4287, ISO 13565-2 and ISO 21920-2 for profiles, ISO 25178-2 for maps.
    #[must_use]
    pub fn parameters(&self) -> Vec<Parameter> {
        match self {
            Self::Profile(roughness) => of_profile(roughness),
            Self::Map(roughness) => areal(roughness),
        }
    }
}

impl ProfileRoughness {
    /// The profile as a table, one row for each point: its position in mm, and primary profile, mean line and roughness in µm.
    ///
    /// Source: ISO 4287 for the three profiles.
    #[must_use]
    pub fn points_table(&self) -> Table {
        let columns = ["position_mm", "primary_um", "mean_line_um", "roughness_um"];
        let mut table = Table::new(columns.map(|name| Column::new(name, name)));
        let step_mm = self.roughness.step_m() * 1e3;
        let primary = self.primary();
        let lines = (primary.heights_m().iter())
            .zip(self.mean_line.heights_m())
            .zip(self.roughness.heights_m());
        let um = |height_m: f64| Cell::Text(format!("{:.6}", height_m * 1e6));
        table.rows = lines
            .enumerate()
            .map(|(i, ((primary_m, mean_m), rough_m))| {
                let position = Cell::Text(format!("{:.9}", i as f64 * step_mm));
                vec![position, um(*primary_m), um(*mean_m), um(*rough_m)]
            })
            .collect();
        table
    }
}
