//! Every test of the command as a black box, in one program: it is linked once and runs on all cores.

mod belonging;
mod characterise;
mod closed_loop;
mod command_line;
mod conclusions;
mod discrimination;
mod docs;
mod examples;
mod export;
mod fake_bench;
mod hostile_inputs;
mod impact;
mod integrity;
mod keeps;
#[path = "../../piezotact/tests/known_cuts/mod.rs"]
mod known_cuts;
mod manipulate;
mod measured_bench;
mod own_device;
mod own_files;
mod panel;
mod real_input;
mod refusals;
mod replay;
mod rerun;
mod roughness;
mod score;
mod script;
mod snapshots;
mod support;
mod surfcom;
mod touch;
mod twin;
mod verify;
