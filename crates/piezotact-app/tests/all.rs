//! Every test of the command as a black box, in one program: it is linked once and runs on all cores.

mod align;
mod audio;
mod audio_session;
mod belonging;
mod bids;
mod bids_attacks;
mod bids_eeg;
mod bids_refused;
mod campaign;
mod campaign_answers;
mod campaign_drives;
mod campaign_places;
mod campaign_server;
mod campaign_session;
mod campaign_simulated;
mod campaign_trust;
mod characterise;
#[path = "../../piezotact-web/tests/client/http.rs"]
mod client;
mod closed_loop;
mod command_line;
mod conclusions;
mod discrimination;
mod docs;
mod eeg;
mod examples;
#[cfg(feature = "haptic")]
mod export;
mod fake_bench;
mod hostile_inputs;
#[cfg(feature = "modal")]
mod impact;
mod integrity;
mod interrupts;
mod keeps;
#[path = "../../piezotact/tests/known_cuts/mod.rs"]
mod known_cuts;
mod levels;
mod manipulate;
mod matrix;
mod measured_bench;
mod message_numbers;
mod own_device;
mod own_files;
mod panel;
#[path = "../../piezotact-study/tests/support/postgres.rs"]
mod postgres;
mod prepare;
mod real_input;
mod record;
mod refusals;
#[cfg(feature = "surface")]
mod reliefs;
mod replay;
mod rerun;
#[cfg(feature = "surface")]
mod roughness;
mod score;
mod script;
mod serve;
mod snapshots;
mod support;
#[cfg(feature = "surface")]
mod surfcom;
mod touch;
mod twin;
mod verify;
