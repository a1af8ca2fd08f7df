//! Every test of the contract of a bench, in one program: it is linked once and runs on all cores.

mod conformance;
mod measured;
mod procedures;
mod stops;
