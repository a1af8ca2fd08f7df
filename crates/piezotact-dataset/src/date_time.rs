//! Dates and times of day in the cells of tables.

use piezotact::recording::StartTime;

/// A moment as a cell holds it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Stamp {
    at: StartTime,
    /// Whether the cell states the day, and says which of its numbers is the month.
    has_date: bool,
    /// The time after which such cells start again at 0, s: one day, or one hour where they hold minutes and seconds only.
    lasts_s: f64,
}

impl Stamp {
    /// The moment in a cell: `2024-03-01T10:22:33.000Z`, `2024-03-01 10:22:33,5`, `01.03.2024 10:22:33`, `10:22:33.500`,
    /// `3/1/2024 10:22:33 PM`; `22:33.500` of minutes and seconds with a fraction; of a date with slashes that ends in the year, the time of day alone.
    pub(crate) fn of(cell: &str) -> Option<Self> {
        let cell = cell.trim().trim_matches('"');
        let colon = cell.find(':')?;
        let (date, clock) = match cell[..colon].rfind(['T', ' ']) {
            Some(at) => (Some(&cell[..at]), &cell[at + 1..]),
            None => (None, cell),
        };
        if let (None, Some((minutes, seconds))) = (date, clock.split_once(':'))
            && let Some((whole, fraction)) = seconds.split_once(['.', ','])
            && [minutes, whole, fraction]
                .iter()
                .all(|part| is_digits(part))
        {
            let minutes: u32 = minutes.parse().ok()?;
            let clock = format!(
                "{:02}:{:02}:{whole:0>2}.{fraction}",
                minutes / 60,
                minutes % 60
            );
            return Some(Self {
                at: StartTime::try_from(format!("2000-01-01T{clock}")).ok()?,
                has_date: false,
                lasts_s: HOUR_S,
            });
        }
        let date = match date.map(str::trim) {
            None => None,
            Some(date) => date_in(date)?,
        };
        let text = format!(
            "{}T{}",
            date.as_deref().unwrap_or("2000-01-01"),
            clock_in(clock)?
        );
        Some(Self {
            at: StartTime::try_from(text).ok()?,
            has_date: date.is_some(),
            lasts_s: DAY_S,
        })
    }

    /// The moment that began the recording; absent where the day is not known.
    pub(crate) fn start(self) -> Option<StartTime> {
        self.has_date.then_some(self.at)
    }
}

fn is_digits(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit())
}

/// Whether a cell is a date without a time of day.
pub(crate) fn is_date(cell: &str) -> bool {
    !cell.contains(':') && cell.len() <= 12 && date_in(cell.trim().trim_matches('"')).is_some()
}

/// `2024-03-01` of a date; of `12/31/2023` and `31/12/2023` too; `Some(None)` where month and day cannot be told apart.
fn date_in(date: &str) -> Option<Option<String>> {
    let sign = date.chars().find(|c| ['-', '/', '.'].contains(c))?;
    let parts: Vec<&str> = date.split(sign).collect();
    let &[one, two, three] = parts.as_slice() else {
        return None;
    };
    let digits = |part: &str, most: usize| {
        (1..=most).contains(&part.len()) && part.bytes().all(|byte| byte.is_ascii_digit())
    };
    if one.len() == 4 && digits(one, 4) && digits(two, 2) && digits(three, 2) {
        return Some(Some(format!("{one}-{two:0>2}-{three:0>2}")));
    }
    if !(digits(one, 2) && digits(two, 2) && three.len() == 4 && digits(three, 4)) {
        return None;
    }
    // A number beyond 12 is the day.
    let number = |part: &str| part.parse::<u32>().unwrap_or(0);
    Some(match sign {
        '.' => Some(format!("{three}-{two:0>2}-{one:0>2}")),
        _ if number(one) > 12 => Some(format!("{three}-{two:0>2}-{one:0>2}")),
        _ if number(two) > 12 => Some(format!("{three}-{one:0>2}-{two:0>2}")),
        _ => None,
    })
}

/// `10:22:33.5+01:00` of a time of day.
fn clock_in(clock: &str) -> Option<String> {
    let clock = clock.trim();
    let last = clock
        .get(clock.len().checked_sub(2)?..)?
        .to_ascii_uppercase();
    let (clock, half) = match last.as_str() {
        "AM" | "PM" => (clock[..clock.len() - 2].trim_end(), Some(last)),
        _ => (clock, None),
    };
    let zone = clock.find(['Z', '+', '-']).unwrap_or(clock.len());
    let (clock, zone) = clock.split_at(zone);
    let zone = match zone.get(1..).unwrap_or_default().trim() {
        "" => zone.trim().to_owned(),
        offset => {
            let digits: String = offset.chars().filter(char::is_ascii_digit).collect();
            let (hours, minutes) = (digits.get(..2)?, digits.get(2..)?);
            format!("{}{hours}:{minutes:0<2}", &zone[..1])
        }
    };
    let parts: Vec<&str> = clock.trim_end().split(':').collect();
    let (hour, minute, second, fraction) = match parts.as_slice() {
        [hour, minute, second] => {
            let (second, fraction) = second.split_once(['.', ',']).unwrap_or((second, "0"));
            (hour, minute, second, fraction)
        }
        [hour, minute, second, fraction] => (hour, minute, *second, *fraction),
        _ => return None,
    };
    let hour: u32 = hour.trim().parse().ok()?;
    let hour = match half.as_deref() {
        Some("PM") => hour % 12 + 12,
        Some(_) => hour % 12,
        None => hour,
    };
    let fraction = if fraction.is_empty() { "0" } else { fraction };
    Some(format!(
        "{hour:02}:{minute:0>2}:{second:0>2}.{fraction}{zone}"
    ))
}

/// A column of moments, read from its first row on.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stamps {
    first: Option<Stamp>,
    last_s: f64,
    before_s: f64,
}

impl Stamps {
    /// The time of a cell since the first one, s. Times of day without a date go on after midnight, and minutes after an hour.
    pub(crate) fn seconds(&mut self, cell: &str) -> Option<f64> {
        let mut stamp = Stamp::of(cell)?;
        let first = self.first.get_or_insert_with(|| stamp.clone());
        // Where the first row does not say its day, no row does.
        if stamp.has_date && !first.has_date {
            let at = String::from(stamp.at);
            stamp = Stamp::of(at.split_once('T')?.1)?;
        }
        let mut seconds = stamp.at.seconds_since(&first.at).0 + self.before_s;
        if !first.has_date && seconds < self.last_s - 0.5 * first.lasts_s {
            self.before_s += first.lasts_s;
            seconds += first.lasts_s;
        }
        self.last_s = seconds;
        Some(seconds)
    }

    /// The moment of the first row, on the day that another column may state.
    pub(crate) fn start(self, date: Option<&str>) -> Option<StartTime> {
        let first = self.first.filter(|first| first.lasts_s > HOUR_S)?;
        if first.has_date {
            return Some(first.at);
        }
        let at = String::from(first.at);
        Stamp::of(&format!("{} {}", date?, at.split_once('T')?.1))?.start()
    }
}

pub(crate) const DAY_S: f64 = 86_400.0;
const HOUR_S: f64 = 3600.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_read_as_programs_write_them() {
        for (cell, said) in [
            ("2024-03-01T10:22:33.000Z", "2024-03-01T10:22:33.000Z"),
            ("2024-03-01 10:22:33,5", "2024-03-01T10:22:33.5"),
            ("2024/3/1 10:22:33+0100", "2024-03-01T10:22:33.0+01:00"),
            ("01.03.2024 9:02:03", "2024-03-01T09:02:03.0"),
            ("2024-03-01 10:22:33:012", "2024-03-01T10:22:33.012"),
            ("12/31/2023 10:22:33", "2023-12-31T10:22:33.0"),
            ("31/12/2023 10:22:33", "2023-12-31T10:22:33.0"),
        ] {
            let start = Stamp::of(cell).and_then(Stamp::start);
            assert_eq!(
                start.map(|at| at.to_string()).as_deref(),
                Some(said),
                "{cell}"
            );
        }
        let evening = Stamp::of("3/1/2024 10:22:33 PM").unwrap();
        assert!(!evening.has_date && evening.at.to_string().ends_with("T22:22:33.0"));
        for cell in [
            "",
            "10:22",
            "10:61.5",
            "2024-03-01 10:22.5",
            "1.5",
            "-3",
            "a:b:c",
            "25:00:00",
            "é:0:1",
            "::",
            "2024-13-01 00:00:00",
        ] {
            assert_eq!(Stamp::of(cell), None, "{cell}");
        }
        assert!(is_date("2024-03-01") && is_date("3/1/2024") && !is_date("1.234.567"));
    }

    #[test]
    fn times_of_day_go_on_after_midnight() {
        let mut stamps = Stamps::default();
        let seconds: Vec<f64> = ["23:59:59.5", "00:00:00.0", "00:00:00.5"]
            .iter()
            .filter_map(|cell| stamps.seconds(cell))
            .collect();
        assert_eq!(seconds, [0.0, 0.5, 1.0]);
        let mut minutes = Stamps::default();
        let cells = ["59:59.500", "00:00.000", "0:00,250"];
        assert_eq!(
            cells.map(|cell| minutes.seconds(cell)),
            [Some(0.0), Some(0.5), Some(0.75)]
        );
        assert_eq!(minutes.start(Some("2024-03-01")), None);
        let mut longer = Stamps::default();
        let cells = ["59:59.500", "60:00.000"];
        assert_eq!(
            cells.map(|cell| longer.seconds(cell)),
            [Some(0.0), Some(0.5)]
        );
        let mut slashed = Stamps::default();
        let cells = ["12/12/2023 23:59:59.5", "12/13/2023 00:00:00.0"];
        assert_eq!(
            cells.map(|cell| slashed.seconds(cell)),
            [Some(0.0), Some(0.5)]
        );
        let start = stamps.start(Some("2024-03-01")).unwrap();
        assert_eq!(start.to_string(), "2024-03-01T23:59:59.5");
    }
}
