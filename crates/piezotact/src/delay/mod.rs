//! The delay between two signals over time: two clocks give a line, lost samples give steps.

mod course;

pub(crate) use course::{Course, Fit, Local, Outliers, Rules, Slope};
