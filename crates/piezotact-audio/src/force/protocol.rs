//! The lines of a force cell: `docs/guide/force-cell.md`.

use super::error::ForceError;
use super::unit::ForceUnit;

/// The time of a device, ms, begins again at 0 after this.
const WRAP_MS: f64 = 4_294_967_296.0;
/// Times of two readings in a row are no farther apart than this, s.
const LONGEST_STEP_S: f64 = 60.0;
/// So many readings in a row have to agree on another time before it is believed.
const AGREEING: usize = 3;

/// What a line says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Said {
    /// A reading: when it was measured, s since the first reading of this clock, and the force, N.
    Reading { device_s: Option<f64>, force_n: f64 },
    /// A reading by a clock that began again: its last time before, and its first after, s.
    Restarted {
        from_s: f64,
        to_s: f64,
        force_n: f64,
    },
    /// A force in a unit that is not known yet.
    WithoutUnit,
    /// A header or a comment.
    Header,
    /// Nothing that can be read.
    Unreadable,
}

/// Reads the lines of one device.
#[derive(Clone, Debug)]
pub(super) struct Protocol {
    name: String,
    unit: Option<ForceUnit>,
    from_settings: bool,
    pub(super) nominal_rate_hz: Option<f64>,
    /// Readings had a checksum: those without are damaged.
    has_checksums: bool,
    clock: DeviceClock,
}

impl Protocol {
    /// The lines of the device `name`, in `unit` if the settings state one.
    pub(super) fn new(name: &str, unit: Option<ForceUnit>) -> Self {
        Self {
            name: name.to_owned(),
            unit,
            from_settings: unit.is_some(),
            nominal_rate_hz: None,
            has_checksums: false,
            clock: DeviceClock::new(Some(WRAP_MS / 1e3)),
        }
    }

    pub(super) fn unit(&self) -> Option<ForceUnit> {
        self.unit
    }

    /// What `line` says.
    pub(super) fn line(&mut self, line: &[u8]) -> Result<Said, ForceError> {
        let Some((text, checked)) = std::str::from_utf8(line).ok().and_then(without_checksum)
        else {
            return Ok(Said::Unreadable);
        };
        if let Some(header) = text.strip_prefix('#') {
            return self.header(header).map(|()| Said::Header);
        }
        match text.strip_prefix("F ") {
            Some(reading) => {
                if self.has_checksums && checked == Checked::No {
                    return Ok(Said::Unreadable);
                }
                let said = self.timed(reading);
                if checked == Checked::Right && said != Said::Unreadable {
                    self.has_checksums = true;
                }
                Ok(said)
            }
            None => self.plain(text),
        }
    }

    /// ` unit=mN rate=80`; words of other kinds are comments.
    fn header(&mut self, text: &str) -> Result<(), ForceError> {
        for word in text.split_ascii_whitespace() {
            match word.split_once('=') {
                Some(("unit", unit)) => {
                    let known = unit.parse().map_err(|_none| ForceError::UnknownUnit {
                        name: self.name.clone(),
                        found: unit.chars().take(20).collect(),
                    })?;
                    self.state(known)?;
                }
                Some(("rate", rate)) => {
                    let rate_hz = rate.parse().ok();
                    self.nominal_rate_hz =
                        rate_hz.filter(|rate_hz: &f64| rate_hz.is_finite() && *rate_hz > 0.0);
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// The device states its unit.
    pub(super) fn state(&mut self, unit: ForceUnit) -> Result<(), ForceError> {
        match self.unit {
            Some(expected) if expected != unit => Err(ForceError::Unit {
                name: self.name.clone(),
                expected,
                found: unit,
                from_settings: self.from_settings,
            }),
            _ => {
                self.unit = Some(unit);
                Ok(())
            }
        }
    }

    /// `<time in ms> <force>`.
    fn timed(&mut self, text: &str) -> Said {
        let mut words = text.split_ascii_whitespace();
        let (Some(time), Some(force), None) = (words.next(), words.next(), words.next()) else {
            return Said::Unreadable;
        };
        match (time.parse::<u32>(), number(force)) {
            (Ok(time_ms), Some(force)) => self.reading(Some(f64::from(time_ms) / 1e3), force),
            _ => Said::Unreadable,
        }
    }

    /// A number, and perhaps the unit behind it.
    fn plain(&mut self, text: &str) -> Result<Said, ForceError> {
        let mut words = text.split_ascii_whitespace();
        let (Some(force), unit, None) = (words.next(), words.next(), words.next()) else {
            return Ok(Said::Unreadable);
        };
        let Some(force) = number(force) else {
            return Ok(Said::Unreadable);
        };
        if let Some(unit) = unit {
            let Ok(unit) = unit.parse() else {
                return Ok(Said::Unreadable);
            };
            self.state(unit)?;
        }
        Ok(self.reading(None, force))
    }

    /// A reading of `force` in the unit of the device, measured at `time_s` by its clock.
    pub(super) fn reading(&mut self, time_s: Option<f64>, force: f64) -> Said {
        let Some(unit) = self.unit else {
            return Said::WithoutUnit;
        };
        let force_n = force * unit.newtons();
        if force_n.abs() > LARGEST_N {
            return Said::Unreadable;
        }
        let Some(time_s) = time_s else {
            return Said::Reading {
                device_s: None,
                force_n,
            };
        };
        match self.clock.step(time_s) {
            Step::On(device_s) => Said::Reading {
                device_s: Some(device_s),
                force_n,
            },
            Step::Unlikely => Said::Unreadable,
            Step::Restarted { from_s, to_s } => Said::Restarted {
                from_s,
                to_s,
                force_n,
            },
        }
    }

    /// The same device with a clock that has no end, s.
    pub(super) fn endless(mut self) -> Self {
        self.clock = DeviceClock::new(None);
        self
    }

    /// The clock of the device restarts at the next reading.
    pub(super) fn new_clock(&mut self) {
        self.clock = DeviceClock::new(self.clock.wrap_s);
    }
}

/// No finger presses harder, N: a larger number is damage.
const LARGEST_N: f64 = 1e4;

/// A number that is one; neither `nan` nor `inf`.
pub(super) fn number(text: &str) -> Option<f64> {
    text.parse().ok().filter(|value: &f64| value.is_finite())
}

/// Whether a line has a checksum that is right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Checked {
    Right,
    No,
}

/// A line without its checksum `*5A`, the exclusive or of all bytes before the star; none where it is wrong.
fn without_checksum(line: &str) -> Option<(&str, Checked)> {
    let Some((text, digits)) = line.rsplit_once('*') else {
        return Some((line, Checked::No));
    };
    // A comment may have stars in it.
    let Ok(stated) = u8::from_str_radix(digits, 16) else {
        return line.starts_with('#').then_some((line, Checked::No));
    };
    let found = text.bytes().fold(0, |sum, byte| sum ^ byte);
    (found == stated && digits.len() == 2).then_some((text.trim_ascii_end(), Checked::Right))
}

/// The clock of a device: goes on, wraps, or begins again.
#[derive(Clone, Debug)]
struct DeviceClock {
    wrap_s: Option<f64>,
    /// The last time that was believed, as stated and as s since the first.
    last: Option<(f64, f64)>,
    /// How many times followed from the one before.
    followed: usize,
    /// The last of the times that do not follow from it, and how many of them agree.
    other: Option<(f64, usize)>,
}

/// What a time says about the clock.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Step {
    /// It goes on: s since the first time.
    On(f64),
    /// A damaged time.
    Unlikely,
    /// The clock began again.
    Restarted { from_s: f64, to_s: f64 },
}

impl DeviceClock {
    fn new(wrap_s: Option<f64>) -> Self {
        Self {
            wrap_s,
            last: None,
            followed: 0,
            other: None,
        }
    }

    /// From `from_s` to `to_s`, s, if that may be the next time.
    fn follows(&self, from_s: f64, to_s: f64) -> Option<f64> {
        let step_s = match self.wrap_s {
            Some(wrap_s) => (to_s - from_s).rem_euclid(wrap_s),
            None => to_s - from_s,
        };
        // Times of ms are no binary fractions.
        (-1e-9..=LONGEST_STEP_S)
            .contains(&step_s)
            .then_some(step_s.max(0.0))
    }

    fn step(&mut self, time_s: f64) -> Step {
        let Some((stated_s, total_s)) = self.last else {
            self.last = Some((time_s, 0.0));
            return Step::On(0.0);
        };
        if let Some(step_s) = self.follows(stated_s, time_s) {
            self.last = Some((time_s, total_s + step_s));
            self.followed += 1;
            self.other = None;
            return Step::On(total_s + step_s);
        }
        let agree = match self.other {
            Some((other_s, agree)) if self.follows(other_s, time_s).is_some() => agree + 1,
            _ => 1,
        };
        self.other = Some((time_s, agree));
        if agree < AGREEING {
            return Step::Unlikely;
        }
        self.last = Some((time_s, total_s));
        self.other = None;
        if self.followed == 0 {
            // The first time of all was the damaged one.
            return Step::On(total_s);
        }
        self.last = Some((time_s, 0.0));
        Step::Restarted {
            from_s: stated_s,
            to_s: time_s,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(protocol: &mut Protocol, line: &str) -> Said {
        protocol.line(line.as_bytes()).unwrap()
    }

    fn force(said: Said) -> Option<f64> {
        match said {
            Said::Reading { force_n, .. } => Some(force_n),
            _ => None,
        }
    }

    fn time(said: Said) -> Option<f64> {
        match said {
            Said::Reading { device_s, .. } => device_s,
            _ => None,
        }
    }

    #[test]
    fn a_header_states_unit_and_rate() {
        let mut p = Protocol::new("cell", None);
        assert_eq!(read(&mut p, "F 10 204.5"), Said::WithoutUnit);
        assert_eq!(
            read(&mut p, "# Piezotact force cell unit=mN rate=80"),
            Said::Header
        );
        assert_eq!(p.nominal_rate_hz, Some(80.0));
        // 204.5 times 1e-3 is not a binary fraction.
        let found = force(read(&mut p, "F 20 204.5")).unwrap();
        assert!((found - 0.2045).abs() < 1e-15);
        let repeated = p.line(b"# unit=mN");
        assert_eq!(repeated, Ok(Said::Header));
        let changed = p.line(b"# unit=g").unwrap_err();
        assert!(matches!(
            changed,
            ForceError::Unit {
                found: ForceUnit::Gram,
                from_settings: false,
                ..
            }
        ));
        assert!(matches!(
            p.line(b"# unit=oz").unwrap_err(),
            ForceError::UnknownUnit { .. }
        ));
    }

    #[test]
    fn grams_are_of_standard_gravity_and_numbers_may_stand_alone() {
        let mut p = Protocol::new("scale", Some(ForceUnit::Gram));
        for line in ["20.394", "+20.394", "  20.394 g", "2.0394e1"] {
            let found = force(read(&mut p, line.trim())).unwrap();
            // 0.2 N are 20.394 g: 0.2 / 9.80665e-3.
            assert!((found - 0.2).abs() < 1e-5, "{line}: {found}");
        }
        assert!(matches!(
            p.line(b"0.2 N").unwrap_err(),
            ForceError::Unit {
                from_settings: true,
                ..
            }
        ));
    }

    #[test]
    fn garbage_is_unreadable() {
        let mut p = Protocol::new("cell", Some(ForceUnit::Newton));
        for line in [
            "F",
            "F 1",
            "F 1 2 3",
            "F -1 2",
            "F 4294967296 2",
            "F 1.5 2",
            "F 1 nan",
            "F 1 inf",
            "nan",
            "-inf",
            "infinity",
            "1,5",
            "ST,GS,12.5",
            "12.5 apples",
            "F 1 2 *00",
            "F 1 2*",
            "*",
            "1 2 3",
            "1e999",
        ] {
            assert_eq!(read(&mut p, line), Said::Unreadable, "{line}");
        }
        assert_eq!(p.line(&[0xff, 0xfe, b'1']), Ok(Said::Unreadable));
    }

    #[test]
    fn checksums_are_kept_once_there() {
        // By golden/force_clock.py.
        let mut p = Protocol::new("cell", Some(ForceUnit::Newton));
        assert_eq!(force(read(&mut p, "F 1000 204.5*6A")), Some(204.5));
        assert_eq!(force(read(&mut p, "F 1012 204.7*6B")), Some(204.7));
        assert_eq!(read(&mut p, "F 1024 204.7*6A"), Said::Unreadable);
        let line = "F 1000 0.25";
        let sum = line.bytes().fold(0, |sum, byte| sum ^ byte);
        let mut p = Protocol::new("cell", Some(ForceUnit::Newton));
        assert_eq!(force(read(&mut p, "F 990 0.25")), Some(0.25));
        assert_eq!(
            force(read(&mut p, &format!("{line}*{sum:02X}"))),
            Some(0.25)
        );
        let before = read(&mut p, &format!("F 1000 0.75*{sum:02x}"));
        assert_eq!(before, Said::Unreadable);
        assert_eq!(read(&mut p, "F 1010 0.2"), Said::Unreadable);
        assert_eq!(read(&mut p, "# a comment *with* stars"), Said::Header);
    }

    #[test]
    fn time_wraps_and_damaged_times_do_not_count() {
        let mut p = Protocol::new("cell", Some(ForceUnit::Newton));
        assert_eq!(time(read(&mut p, "F 4294967286 1")), Some(0.0));
        let found = time(read(&mut p, "F 5 1")).unwrap();
        assert!((found - 0.015).abs() < 1e-6, "{found}");
        assert_eq!(read(&mut p, "F 900000 1"), Said::Unreadable);
        let found = time(read(&mut p, "F 25 1")).unwrap();
        assert!((found - 0.035).abs() < 1e-6, "{found}");
        // A damaged time at the beginning.
        let mut p = Protocol::new("cell", Some(ForceUnit::Newton));
        for (line, expected) in [
            ("F 7100000 1", Some(0.0)),
            ("F 100010 1", None),
            ("F 100020 1", None),
            ("F 100030 1", Some(0.0)),
        ] {
            assert_eq!(time(read(&mut p, line)), expected, "{line}");
        }
        // Backwards three times: it started again.
        let mut p = Protocol::new("cell", Some(ForceUnit::Newton));
        read(&mut p, "F 99990 1");
        read(&mut p, "F 100000 1");
        assert_eq!(read(&mut p, "F 12 1"), Said::Unreadable);
        assert_eq!(read(&mut p, "F 24 1"), Said::Unreadable);
        assert_eq!(
            read(&mut p, "F 36 2"),
            Said::Restarted {
                from_s: 100.0,
                to_s: 0.036,
                force_n: 2.0
            }
        );
        assert_eq!(
            time(read(&mut p, "F 48 1")).map(|t| (1e3 * t).round()),
            Some(12.0)
        );
    }
}
