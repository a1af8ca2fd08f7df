//! Every test of files, in one program: it is linked once and runs on all cores.

mod blocks;
mod catman;
mod damage;
mod eeg;
mod eeg_contradictions;
mod eeg_damage;
mod eeg_odd;
mod eeg_written;
mod flac;
mod haptic;
mod haptic_limits;
mod lvm;
mod matlab;
mod matlab_recordings;
mod matlab_units;
mod newer_files;
mod npy;
#[path = "../../piezotact/tests/shared_data/mod.rs"]
mod shared_data;
mod sidecar;
mod stored_functions;
mod support;
mod tables;
mod tdms;
mod tdms_clocks;
mod tdms_damage;
mod uff;
mod uff_clocks;
