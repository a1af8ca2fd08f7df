//! Whether what a command is about to compute fits into memory.

use anyhow::anyhow;

use crate::failure::Outcome;

/// Refuses a computation over `samples` samples that takes `bytes_a_sample` for each, where less memory is free: `what` begins the
/// sentence. Where the system does not say what is free, nothing is refused.
pub(crate) fn fits(what: &str, samples: usize, bytes_a_sample: usize) -> Outcome {
    let needed = samples as f64 * bytes_a_sample as f64;
    match free_bytes() {
        Some(free) if needed > free => Err(anyhow!(
            "{what}: {samples} samples take about {:.1} GB of memory, and {:.1} GB are free; use a shorter part or a lower rate, or a \
             machine with more memory",
            needed / 1e9,
            free / 1e9
        )
        .into()),
        _ => Ok(()),
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
