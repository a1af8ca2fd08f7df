//! Every test of the command as a black box, in one program: it is linked once and runs on all cores.
#![cfg_attr(
    not(feature = "every-command"),
    allow(
        dead_code,
        unused_imports,
        reason = "what tests share, some of which are not in this build"
    )
)]

mod align;
#[cfg(feature = "every-command")]
mod audio;
#[cfg(feature = "every-command")]
mod audio_session;
#[cfg(feature = "study")]
mod belonging;
#[cfg(feature = "every-command")]
mod bids;
#[cfg(feature = "every-command")]
mod bids_attacks;
#[cfg(feature = "every-command")]
mod bids_eeg;
#[cfg(feature = "every-command")]
mod bids_laboratory;
#[cfg(feature = "every-command")]
mod bids_refused;
#[cfg(feature = "study")]
mod campaign;
#[cfg(feature = "every-command")]
mod campaign_answers;
#[cfg(feature = "every-command")]
mod campaign_drives;
#[cfg(feature = "study")]
mod campaign_places;
#[cfg(feature = "every-command")]
mod campaign_server;
#[cfg(feature = "study")]
mod campaign_session;
#[cfg(feature = "study")]
mod campaign_simulated;
#[cfg(feature = "every-command")]
mod campaign_touch;
#[cfg(feature = "every-command")]
mod campaign_trust;
mod characterise;
#[cfg(feature = "every-command")]
#[path = "../../piezotact-web/tests/client/http.rs"]
mod client;
mod closed_loop;
mod command_line;
mod conclusions;
#[cfg(feature = "study")]
mod discrimination;
#[cfg(feature = "every-command")]
mod docs;
#[cfg(feature = "study")]
mod eeg;
#[cfg(feature = "every-command")]
mod examples;
#[cfg(feature = "every-command")]
mod export;
#[cfg(feature = "every-command")]
mod fake_bench;
#[cfg(feature = "every-command")]
mod hostile_inputs;
#[cfg(feature = "modal")]
mod impact;
mod integrity;
mod interrupts;
#[cfg(feature = "every-command")]
mod keeps;
#[path = "../../piezotact/tests/known_cuts/mod.rs"]
mod known_cuts;
mod lean;
mod levels;
mod manipulate;
#[cfg(feature = "study")]
mod matrix;
#[cfg(feature = "every-command")]
mod measured_bench;
mod message_numbers;
mod own_device;
mod own_files;
#[cfg(feature = "every-command")]
mod panel;
#[cfg(feature = "study")]
#[path = "../../piezotact-study/tests/support/postgres.rs"]
mod postgres;
mod prepare;
mod real_input;
#[cfg(feature = "every-command")]
mod record;
#[cfg(feature = "every-command")]
mod refusals;
#[cfg(feature = "surface")]
mod reliefs;
mod rerun;
#[cfg(feature = "surface")]
mod roughness;
mod score;
#[cfg(feature = "every-command")]
mod script;
#[cfg(feature = "every-command")]
mod serve;
#[cfg(feature = "every-command")]
mod snapshots;
mod spectrum;
mod support;
#[cfg(feature = "surface")]
mod surfcom;
mod touch;
mod touch_measured;
#[cfg(feature = "every-command")]
mod twin;
mod verify;
