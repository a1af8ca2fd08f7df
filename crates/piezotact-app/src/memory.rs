//! Whether what a command is about to compute fits into memory.

use std::path::Path;

use anyhow::anyhow;

use crate::failure::Outcome;

/// Refuses a computation over `samples` samples that takes `bytes_a_sample` for each, where less memory is free: `what` begins the
/// sentence. Where the system does not say what is free, nothing is refused.
pub(crate) fn fits(what: &str, samples: usize, bytes_a_sample: usize) -> Outcome {
    let needed = samples as f64 * bytes_a_sample as f64;
    match free_bytes() {
        Some(free) if needed > free => Err(anyhow!(
            "{what}: {samples} samples take about {} of memory, and {} are free; use a shorter part or a lower rate, or a \
             machine with more memory",
            amount(needed),
            amount(free)
        )
        .into()),
        _ => Ok(()),
    }
}

/// What reading takes in memory for each byte of a file, by the ending of its name: samples of 16 bits become numbers of 64, and
/// Parquet is compressed. The last one is that of all others: tables, whose numbers have more digits than bytes.
const A_BYTE: [(&str, f64); 3] = [("wav", 6.0), ("parquet", 4.0), ("", 3.0)];

/// Refuses to read a file that does not fit into the memory that is free; what is no file is for its reader to refuse.
pub(crate) fn reading_fits(path: &Path) -> Outcome {
    let Ok(bytes) = std::fs::metadata(path).map(|found| found.len()) else {
        return Ok(());
    };
    let ending = path.extension().map(|ending| ending.to_ascii_lowercase());
    let ending = ending.as_deref().and_then(|ending| ending.to_str());
    let known = A_BYTE.iter().find(|(known, _)| Some(*known) == ending);
    let (_, a_byte) = known.unwrap_or(&A_BYTE[A_BYTE.len() - 1]);
    let needed = bytes as f64 * a_byte;
    match free_bytes() {
        Some(free) if needed > free => Err(anyhow!(
            "{}: reading this file of {} takes about {} of memory, and {} are free; use a shorter part or a lower rate, or a \
             machine with more memory",
            path.display(),
            amount(bytes as f64),
            amount(needed),
            amount(free)
        )
        .into()),
        _ => Ok(()),
    }
}

/// An amount of memory in words.
fn amount(bytes: f64) -> String {
    if bytes >= 1e9 {
        format!("{:.2} GB", bytes / 1e9)
    } else {
        format!("{:.0} MB", bytes / 1e6)
    }
}

/// The memory that is free for this process, bytes: what Linux calls available, and what is left of a limit of the address space.
fn free_bytes() -> Option<f64> {
    let read = |name: &str| std::fs::read_to_string(format!("/proc/{name}")).ok();
    let number = |text: &str, name: &str| -> Option<f64> {
        let line = text.lines().find_map(|line| line.strip_prefix(name))?;
        line.split_whitespace().next()?.parse().ok()
    };
    let available = number(&read("meminfo")?, "MemAvailable:")? * 1024.0;
    let limit = read("self/limits").and_then(|limits| number(&limits, "Max address space"));
    let used = read("self/status").and_then(|status| number(&status, "VmSize:"));
    let left = limit.zip(used).map(|(limit, used)| limit - used * 1024.0);
    Some(left.map_or(available, |left| left.min(available)).max(0.0))
}
