//! The vibration of a recording that is felt as a texture: of a recording of touch the strokes, without landing, lift and rest.

use super::ScoreWarning;
use crate::fourier::fade;
use crate::quantity::{Acceleration, Drive, Quantity, Seconds};
use crate::recording::{Recording, RecordingError};
use crate::roles::Roles;
use crate::series::Series;
use crate::statistics::mean;
use crate::stroke::{Expected, Interval, Judging, Rule, segment};
use crate::warning::Warning;

/// How long the end of a stroke overlaps the beginning of the next.
const JOIN: Seconds = Seconds(0.02);

/// The acceleration in `channel` of `recording`, m/s², or in its only one: where the recording has strokes, their steady parts alone,
/// each about its mean, joined with cross-fades of 20 ms at constant power; with a warning that says so of `signal`. A recording without
/// force and motion, one of a drive, and one in which no stroke is found are taken whole, the last with a warning where it has several
/// contacts.
///
/// Source: docs/decisions/verification.md; the strokes are those of [`segment`].
///
/// # Errors
/// [`RecordingError`] where there is no such acceleration.
pub fn sliding_part(
    signal: &str,
    recording: &Recording,
    channel: Option<&str>,
) -> Result<(Series<Acceleration>, Option<Warning>), RecordingError> {
    let whole = recording.series::<Acceleration>(channel)?;
    let name = &recording.pick(channel, &Acceleration::UNIT)?.name;
    let (strokes, none_is_kept) = strokes_of(recording, name);
    let join = whole.rate().samples_in(JOIN);
    let Some(joined) = joined(whole.samples(), &strokes, join) else {
        return Ok((whole, none_is_kept));
    };
    let Ok(sliding) = Series::new(joined, whole.rate()) else {
        return Ok((whole, None));
    };
    let warning = ScoreWarning::StrokesAlone {
        signal: signal.into(),
        strokes: strokes.len(),
        sliding_s: sliding.duration().0,
        whole_s: whole.duration().0,
    };
    Ok((sliding, Some(warning.into())))
}

/// The steady parts of the strokes of `recording` in the samples of its channel `vibration`; none where it is no recording of touch, and
/// a warning where it seems to be one, with several contacts of which none is kept.
fn strokes_of(recording: &Recording, vibration: &str) -> (Vec<Interval>, Option<Warning>) {
    let (guessed, _) = Roles::guess(recording);
    let roles = Roles {
        vibration: vec![vibration.into()],
        ..guessed
    };
    let plays = recording.channels().iter().any(|c| c.unit == Drive::UNIT);
    if plays || (roles.normal_force.is_none() && roles.motion.is_none()) {
        return (Vec::new(), None);
    }
    let Ok((recording, measured)) = roles.on_one_clock(recording.clone()) else {
        return (Vec::new(), None);
    };
    let condition = &recording.about.condition;
    let expected = Expected {
        load_n: condition.load_n,
        speed_m_s: condition.speed_m_s,
        judging: Judging::Sliding,
    };
    let found = segment(&recording, &roles, expected);
    match found.map(|found| found.within(&measured)) {
        Ok(found) if found.rule != Rule::Whole => {
            let several = found.strokes.is_empty() && found.rejected.len() > 1;
            let none_is_kept = several.then(|| found.rejection_warning()).flatten();
            let steady = found.strokes.iter().map(|stroke| stroke.steady);
            (steady.collect(), none_is_kept)
        }
        _ => (Vec::new(), None),
    }
}

/// `parts` of `samples`, each about its mean, one after another: the ends overlap over `join` samples at constant power. `None` where
/// there is no part as long as two joins.
fn joined(samples: &[f64], parts: &[Interval], join: usize) -> Option<Vec<f64>> {
    let long = parts.iter().map(|part| part.of(samples));
    let mut long = long.filter(|part| part.len() > 2 * join);
    let about_mean = |part: &[f64]| -> Vec<f64> {
        let mean = mean(part);
        part.iter().map(|value| value - mean).collect()
    };
    let mut all = about_mean(long.next()?);
    for part in long {
        let next = about_mean(part);
        let from = all.len() - join;
        for (i, (old, new)) in all[from..].iter_mut().zip(&next).enumerate() {
            let share = fade((i as f64 + 0.5) / join as f64);
            *old = *old * (1.0 - share).sqrt() + new * share.sqrt();
        }
        all.extend(&next[join..]);
    }
    Some(all)
}
