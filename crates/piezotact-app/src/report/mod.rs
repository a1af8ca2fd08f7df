//! Reports: one HTML file that holds everything it shows.

pub(crate) mod figures;
pub(crate) mod manipulate;
pub(crate) mod panel;
pub(crate) mod rendering;
pub(crate) mod replay;
pub(crate) mod roughness;
pub(crate) mod score;
pub(crate) mod transfer;
pub(crate) mod verify;

use std::path::Path;

use piezotact::recording::BenchKind;
use piezotact_report::criteria;
pub(crate) use piezotact_report::{broad_document, document, figure};

/// A file's name without its folder.
pub(crate) fn name(path: &Path) -> String {
    path.file_name().map_or_else(
        || path.display().to_string(),
        |name| name.to_string_lossy().into_owned(),
    )
}

/// What stands in a report of something that does not say which bench it comes from.
const UNKNOWN_BENCH: &str = "The measurement does not say which bench it comes from.";

/// What a report says of the bench that a measurement comes from.
fn bench_told(bench: Option<BenchKind>) -> Option<&'static str> {
    bench.map(|kind| match kind {
        BenchKind::Twin => "Digital twin: no hardware and no person took part.",
        BenchKind::Hardware => "Measured on hardware.",
        BenchKind::Measured => {
            "Played through a measured transfer function: no finger was touched."
        }
        BenchKind::Scripted => "Scripted fake of a bench: no device and no finger, for tests only.",
    })
}
