//! Writes the channels of a recording as time responses of dataset 58.

use piezotact::recording::RecordingWarning;
use std::io::Write;
use std::path::Path;

use piezotact::Warning;
use piezotact::recording::Recording;

use super::write::{axis, line, scientific};
use crate::atomic::write_atomically;
use crate::error::WriteError;

/// The fifth id line of what is written here: the rate in the second is then exact.
pub(super) const OWN_TIME: &str = "piezotact recording";

/// Writes every channel of `recording` as a time response (function type 1, real double, text of 13 digits), whole or
/// not at all, and says what the file does not carry. The name of a channel stands in the first id line, the rate in the
/// second.
///
/// # Errors
/// [`WriteError`] when it cannot be written, or a name or unit is longer than the format holds.
pub fn write_uff_recording(path: &Path, recording: &Recording) -> Result<Vec<Warning>, WriteError> {
    let time = format!("{:10}{:5}{:5}{:5} {:20} {:20}", 17, 0, 0, 0, "Time", "s");
    let none = format!("{:10}{:5}{:5}{:5} {:20} {:20}", 0, 0, 0, 0, "NONE", "NONE");
    let mut heads = Vec::new();
    for (channel, clock) in recording.channels_with_clocks() {
        let rate = format!("rate_hz={}", clock.rate_hz.hz());
        let mut text = format!("{:6}{:74}\n{:6}{:74}\n", -1, "", 58, "");
        for id in [
            line(path, &channel.name, "a name of a channel")?.as_str(),
            &rate,
            "NONE",
            "NONE",
            OWN_TIME,
        ] {
            text.push_str(&format!("{id:80}\n"));
        }
        text.push_str(&format!(
            "{:5}{:10}{:5}{:10} {:10}{:10}{:4} {:10}{:10}{:4}\n",
            1, 0, 0, 0, "NONE", 0, 0, "NONE", 0, 0
        ));
        text.push_str(&format!(
            "{:10}{:10}{:10}{}{}{}\n",
            4,
            channel.samples.len(),
            1,
            scientific(clock.start_s.0, 13, 5),
            scientific(1.0 / clock.rate_hz.hz(), 13, 6),
            scientific(0.0, 13, 5)
        ));
        let ordinate = axis(path, &channel.unit, "Response")?;
        for axis in [&time, &ordinate, &none, &none] {
            text.push_str(axis);
            text.push('\n');
        }
        heads.push(text);
    }
    write_atomically(path, |out| {
        for (head, channel) in heads.iter().zip(recording.channels()) {
            out.write_all(head.as_bytes())
                .map_err(WriteError::io(path))?;
            for row in channel.samples.chunks(4) {
                let mut text: String = row.iter().map(|v| scientific(*v, 20, 12)).collect();
                text.push('\n');
                out.write_all(text.as_bytes())
                    .map_err(WriteError::io(path))?;
            }
            out.write_all(format!("{:6}{:74}\n", -1, "").as_bytes())
                .map_err(WriteError::io(path))?;
        }
        Ok(())
    })?;
    Ok(vec![Warning::from(RecordingWarning::FormatLoses {
        format: "a universal file".into(),
        what: "the condition, the provenance and the warnings of a recording".into(),
    })])
}
