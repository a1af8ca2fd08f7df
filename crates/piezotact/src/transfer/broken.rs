//! Signal defects (clipping, drop-outs, …) in the drive and response of a transfer function.

use crate::integrity::{Pair, transfer_warnings};
use crate::quantity::{Quantity, Unit};
use crate::series::Series;
use crate::warning::Warning;

/// The warnings about a drive and its response, named by their quantities. A drive in digital samples is limited at full
/// scale. For a drive that lasts.
///
/// Source: [`transfer_warnings`].
#[must_use]
pub fn pair_warnings<I: Quantity, O: Quantity>(
    drive: &Series<I>,
    response: &Series<O>,
) -> Vec<Warning> {
    transfer_warnings(&Pair {
        drive: drive.samples(),
        response: response.samples(),
        rate: drive.rate(),
        drive_name: I::NAME,
        response_name: O::NAME,
        drive_limit: (I::UNIT == Unit::FullScale).then_some(1.0),
        lasts: true,
    })
}
