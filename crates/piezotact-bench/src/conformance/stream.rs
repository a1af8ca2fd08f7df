//! Conformance tests of the acquired samples.

use super::{Draws, Make, Subject, expect, same, usual};

pub(super) fn described(make: &Make, subject: &Subject) -> Result<(), String> {
    let mut bench = make();
    let before = bench.acquirer.describe();
    let channels = before.channels.len();
    expect(channels > 0, "channels", "none")?;
    let at_rest = bench.acquirer.calibrate().map_err(super::said)?;
    let rest = [at_rest.offset.len(), at_rest.noise_rms.len()];
    expect(
        rest == [channels; 2],
        format!("offset and noise at rest of {channels} channels"),
        format!("{rest:?}"),
    )?;
    let taken = usual(&mut bench, subject)?;
    for chunk in taken
        .chunks
        .iter()
        .filter(|chunk| !chunk.channels.is_empty())
    {
        let found = chunk.channels.len();
        expect(found == channels, format!("{channels} channels"), found)?;
        let equal = chunk
            .channels
            .iter()
            .all(|channel| channel.len() == chunk.len());
        expect(equal, "channels of one length", "of different lengths")?;
    }
    let after = bench.acquirer.describe();
    expect(
        before == after,
        "the same description after a run",
        "another",
    )
}

pub(super) fn contiguous(make: &Make, subject: &Subject) -> Result<(), String> {
    let mut bench = make();
    let rate_hz = bench.acquirer.describe().rate.hz();
    let taken = usual(&mut bench, subject)?;
    let mut next = 0;
    let mut time: Option<(u64, f64)> = None;
    for chunk in &taken.chunks {
        let longest = (rate_hz * 1.001).max(1.0);
        expect(
            chunk.len() as f64 <= longest,
            "chunks of at most a second",
            format!("{} samples", chunk.len()),
        )?;
        next += chunk.lost;
        expect(
            chunk.first == next,
            format!("sample {next} next"),
            format!("a chunk that begins with sample {}", chunk.first),
        )?;
        let numbers = chunk.channels.iter().flatten().all(|v| v.is_finite());
        expect(numbers, "numbers", "a sample that is not a number")?;
        if let (Some((first, before_s)), Some(now_s)) = (time, chunk.device_s) {
            let passed_s = (chunk.first - first) as f64 / rate_hz;
            let found = now_s - before_s;
            expect(
                found >= 0.0 && (found - passed_s).abs() <= 0.005 + 0.001 * passed_s,
                format!(
                    "{passed_s:.6} s of device time between sample {first} and {}",
                    chunk.first
                ),
                format!("{found:.6} s"),
            )?;
        }
        time = chunk.device_s.map(|now_s| (chunk.first, now_s)).or(time);
        next += chunk.len() as u64;
    }
    expect(next > 0, "samples", "none")
}

pub(super) fn repeatable(make: &Make, subject: &Subject) -> Result<(), String> {
    if subject.draws == Draws::Unseeded {
        return Ok(());
    }
    let mut bench = make();
    let first = usual(&mut bench, subject)?;
    let again = usual(&mut bench, subject)?;
    same(&first, &again, "in the same run on the same bench")?;
    let other = usual(&mut make(), subject)?;
    same(
        &first,
        &other,
        "in the same run on a bench of the same seed",
    )
}

pub(super) fn calibration(make: &Make, subject: &Subject) -> Result<(), String> {
    let mut bench = make();
    let first = usual(&mut bench, subject)?;
    bench.acquirer.calibrate().map_err(super::said)?;
    let after = usual(&mut bench, subject)?;
    match subject.draws {
        Draws::Seeded => same(&first, &after, "after a calibration"),
        Draws::Unseeded => expect(
            after.samples() == first.samples(),
            first.samples(),
            after.samples(),
        ),
    }
}
