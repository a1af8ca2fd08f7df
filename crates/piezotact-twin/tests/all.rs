//! Every test of the digital twin, in one program: it is linked once and runs on all cores.

mod characterise;
mod closed_loop;
mod closed_rendering;
mod conformance;
