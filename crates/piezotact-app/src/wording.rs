//! Conclusions in words: a direction only where the numbers have one, and what they are over.

use piezotact::compare::{CommonLine, LineOrigin, PeriodUnit, SpatialPeriod};
use piezotact::criterion::Outcome;
use piezotact::statistics::{Direction, LogFit, PairedDifference, RankCorrelation};

use crate::output::digits;

/// A number with a minus sign that is one.
pub(crate) fn signed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(zero) if zero.chars().all(|c| matches!(c, '0' | '.')) => zero.to_owned(),
        Some(rest) => format!("−{rest}"),
        None => text,
    }
}

/// A probability.
pub(crate) fn p_text(p: f64) -> String {
    match p {
        p if p < 0.001 => "p < 0.001".into(),
        p if p < 0.1 => format!("p = {p:.3}"),
        p => format!("p = {p:.2}"),
    }
}

/// What a power law of `y` on `x` says; its points are `units`, such as "speeds".
pub(crate) fn power_law(y: &str, x: &str, fit: &LogFit, units: &str) -> String {
    let (Some([low, high]), Some(p)) = (fit.slope_interval, fit.p_value) else {
        return format!(
            "{y} and {x}: not decided from {} {units} (exponent {})",
            fit.points,
            signed(fit.slope, 2)
        );
    };
    let numbers = format!(
        "exponent {} (95 %: {} to {} over {} {units}, {})",
        signed(fit.slope, 2),
        signed(low, 2),
        signed(high, 2),
        fit.points,
        p_text(p)
    );
    match fit.direction() {
        Direction::Rises => format!("{y} rises with {x}: {numbers}"),
        Direction::Falls => format!("{y} falls with {x}: {numbers}"),
        Direction::NotShown => format!("{y} and {x}: no trend shown: {numbers}"),
    }
}

/// What a rank correlation of `y` and `x` says; its pairs are `units`, such as "samples".
pub(crate) fn ranks(y: &str, x: &str, found: &RankCorrelation, units: &str) -> String {
    let rho = signed(found.rho, 2);
    let numbers = format!(
        "rank correlation {rho} ({} over {} {units})",
        p_text(found.p_value),
        found.pairs
    );
    match found.direction() {
        Direction::Rises => format!("{y} rises with {x}: {numbers}"),
        Direction::Falls => format!("{y} falls with {x}: {numbers}"),
        Direction::NotShown if found.too_few() => format!(
            "{y} and {x}: not decided: no order of {} {units} could show a trend at p < 0.05 (rank correlation {rho})",
            found.pairs
        ),
        Direction::NotShown => format!("{y} and {x}: no trend shown: {numbers}"),
    }
}

/// What a paired difference of levels says; its pairs are `units`.
pub(crate) fn level_difference(what: [&str; 2], found: &PairedDifference, units: &str) -> String {
    let [low, high] = found.interval;
    let numbers = format!(
        "{} dB (95 %: {} to {} dB over {} {units}, {})",
        signed(found.mean, 1),
        signed(low, 1),
        signed(high, 1),
        found.pairs,
        p_text(found.p_value)
    );
    let [one, other] = what;
    match Direction::of(Some(found.interval)) {
        Direction::Rises => format!("{one} is louder than {other}: {numbers}"),
        Direction::Falls => format!("{one} is fainter than {other}: {numbers}"),
        Direction::NotShown => {
            format!("{one} and {other}: no difference of level shown: {numbers}")
        }
    }
}

/// What a spatial period is, with its interval.
pub(crate) fn spatial_period(period: &SpatialPeriod) -> String {
    let mm = |m: f64| m * 1e3;
    let over = match period.over {
        PeriodUnit::Groups => "loads",
        PeriodUnit::Recordings => "recordings",
    };
    let interval = period.interval_m.map_or(String::new(), |[low, high]| {
        format!(
            " (95 %: {:.3} to {:.3} mm over {} {over})",
            mm(low),
            mm(high),
            period.units
        )
    });
    let number = format!("{:.3} mm{interval}", mm(period.period_m));
    let groups: Vec<String> = period
        .groups
        .iter()
        .map(|group| {
            let own = group.period_m.filter(|_| !period.jumps());
            format!(
                "{}: {:.3} mm",
                group.group,
                mm(own.unwrap_or(group.strongest_m))
            )
        })
        .collect();
    let groups = groups.join(", ");
    match period.outcome() {
        Outcome::Met if groups.is_empty() => format!("spatial period {number}"),
        Outcome::Met => format!("spatial period {number}; {groups}"),
        _ if period.jumps() => {
            format!("spatial period not decided: the loads show different ones ({groups})")
        }
        Outcome::NotDecided if period.missed_at_a_speed() => format!(
            "spatial period not decided: it stands out of the noise at some speeds only, as a line does that stays at its frequency; the candidate is {number}"
        ),
        Outcome::NotDecided => format!(
            "spatial period not decided: it fits into the shortest stroke fewer than 3 times; the candidate is {number}"
        ),
        Outcome::NotMet => format!(
            "no spatial period stands out at all speeds; the strongest candidate is {number}"
        ),
    }
}

/// Whose a line is that every sample has.
pub(crate) fn common_line(line: &CommonLine) -> String {
    let where_found = format!(
        "{} Hz: in all {} recordings of {} samples",
        digits(line.frequency_hz),
        line.recordings,
        line.samples
    );
    let speeds = line.speed_ratio.map_or(String::new(), |ratio| {
        format!(" at speeds up to {ratio:.1} times apart")
    });
    match line.origin {
        LineOrigin::Mains => {
            format!("{where_found}{speeds}: the mains, no texture's and no finger's")
        }
        LineOrigin::Machine => {
            format!("{where_found}{speeds}: the machine's, no texture's and no finger's")
        }
        LineOrigin::NotDecided => format!(
            "{where_found}: the machine's or the finger's; record at another speed to decide, a finger's moves with it"
        ),
    }
}
