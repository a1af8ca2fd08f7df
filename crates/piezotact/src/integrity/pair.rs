//! Two channels of one recording: copies, and what a broken channel does to a transfer function.

use super::copied::{Copy, copied};
use super::hum::{Hum, hum_beside};
use super::level::{Usual, abrupt, at_the_floor};
use super::{ChannelFault, Defects, SignalWarning, Span, inspect_samples, never_changes};
use crate::clipping::limited;
use crate::quantity::{SampleRate, Seconds, Unit};
use crate::recording::{Clock, Recording};
use crate::warning::Warning;

/// A channel is compared with so many before it: with all, thousands of channels would take minutes.
const MOST_COMPARED: usize = 128;

/// The copies among the channels of a recording, but for the pair `told`.
pub(super) fn copies_in(recording: &Recording, told: Option<[&str; 2]>) -> Vec<Warning> {
    let found = copied_pairs(recording, told).into_iter();
    found
        .map(|([copy, of], found, clock)| found.warning(copy, of, clock.rate_hz.hz()).into())
        .collect()
}

/// The channels of a recording that are copies, each with the one of which it is, but for the pair `told`. A digital drive and the voltage
/// at the amplifier may legitimately be equal.
pub(super) fn copied_pairs<'r>(
    recording: &'r Recording,
    told: Option<[&str; 2]>,
) -> Vec<([&'r str; 2], Copy, Clock)> {
    let channels: Vec<_> = recording
        .channels_with_clocks()
        .filter(|(c, _)| !super::commanded(&c.unit) && !super::holds_codes(&c.name))
        .filter(|(c, _)| !never_changes(&c.samples))
        .collect();
    let sends = |unit: &Unit| matches!(unit, Unit::FullScale | Unit::Volt);
    let mut copies = Vec::new();
    for (i, (copy, clock)) in channels.iter().enumerate().skip(1) {
        let before = &channels[i.saturating_sub(MOST_COMPARED)..i];
        let found = before.iter().find_map(|(of, of_clock)| {
            let is_told = told.is_some_and(|told| {
                told.contains(&copy.name.as_str()) && told.contains(&of.name.as_str())
            });
            if clock != of_clock || sends(&copy.unit) && sends(&of.unit) || is_told {
                return None;
            }
            Some((of, copied(&of.samples, &copy.samples)?))
        });
        copies.extend(found.map(|(of, found)| {
            let names = [copy.name.as_str(), of.name.as_str()];
            (names, found, *clock)
        }));
    }
    copies
}

impl Copy {
    /// The warning that the channel `copy` is one of the channel `of`.
    pub(super) fn warning(self, copy: &str, of: &str, rate_hz: f64) -> SignalWarning {
        SignalWarning::Channel {
            channel: copy.to_owned(),
            fault: ChannelFault::Copied {
                of: of.to_owned(),
                factor: self.factor,
                delay_s: self.later as f64 / rate_hz,
            },
        }
    }
}

/// A drive and the response to it, with the names of their channels.
#[derive(Clone, Copy, Debug)]
pub struct Pair<'a> {
    pub drive: &'a [f64],
    /// The response, as many samples.
    pub response: &'a [f64],
    /// The rate of both.
    pub rate: SampleRate,
    /// What the drive's channel is called.
    pub drive_name: &'a str,
    /// What the response's channel is called.
    pub response_name: &'a str,
    /// The largest drive that can be played, in the drive's unit; absent where it is not known.
    pub drive_limit: Option<f64>,
    /// Whether the drive lasts: of hits, what is dead or limited is found hit by hit.
    pub lasts: bool,
}

/// The floor of a response while its drive goes on, re the usual level: −20 dB.
const FLOOR: f64 = 0.1;
/// A response that is dead for less is not looked at.
const SHORTEST: Seconds = Seconds(0.02);
/// The drive goes on where its level is this part of its usual one.
const EXCITED: f64 = 0.3;
/// A noise drive may have its crests clipped intentionally, up to this share.
const CRESTS: f64 = 0.005;
/// A drive within this part of its limit is not beyond it.
const TOLERANCE: f64 = 1e-6;

/// The warnings about a transfer function from a drive to a response because of what is broken in the two: each says how
/// far the function is off, where that can be computed.
///
/// Formula: a response that is dead while the share p of the drive's power is played leaves H1·(1 − p). A Gaussian
/// response of which the share s is limited leaves H1·(1 − s). A drive x of which c(x) is played leaves
/// H1·Σx·c(x)/Σx².
///
/// Source: J. J. Bussgang (1952), MIT RLE Technical Report 216, for limited Gaussian signals; the others follow from H1 = Sxy/Sxx.
#[must_use]
pub fn transfer_warnings(pair: &Pair<'_>) -> Vec<Warning> {
    Broken::of(pair).warnings(pair)
}

/// What is broken in a drive and the response to it, as it was found.
#[derive(Clone, Debug, Default)]
pub(crate) struct Broken {
    /// The response is the drive once more.
    pub(super) copied: Option<Copy>,
    /// The response is dead while the drive goes on.
    dead: Option<Dead>,
    /// Lines of the mains in the response.
    hum: Option<Hum>,
    /// The shares of drive and response at a limit, 0–1; 0 for what is limited on purpose.
    clipped: [f64; 2],
    /// The drive is beyond its limit.
    pub(super) beyond: Option<SignalWarning>,
}

impl Broken {
    pub(crate) fn of(pair: &Pair<'_>) -> Self {
        let (drive, response) = (pair.drive, pair.response);
        if never_changes(drive) || never_changes(response) || drive.len() != response.len() {
            return Self::default();
        }
        let of_drive = Some(limited(drive).share()).filter(|share| *share > CRESTS);
        let clipped = [of_drive.unwrap_or(0.0), limited(response).share()];
        let limit = pair.drive_limit;
        Self {
            copied: copied(drive, response),
            dead: pair.lasts.then(|| dead(pair)).flatten(),
            hum: hum_beside(drive, response, pair.rate),
            clipped: if pair.lasts { clipped } else { [0.0; 2] },
            beyond: limit.and_then(|limit| beyond(drive, pair.drive_name, limit)),
        }
    }

    /// The warnings about a transfer function from the drive to the response of `pair`.
    pub(crate) fn warnings(&self, pair: &Pair<'_>) -> Vec<Warning> {
        let [drive, response] = [pair.drive_name, pair.response_name].map(str::to_owned);
        let copied = self.copied;
        let copied = copied.map(|copy| copy.warning(&response, &drive, pair.rate.hz()));
        let hum = self.hum.as_ref().map(|hum| hum.warning(response.clone()));
        let [of_drive, of_response] = self.clipped;
        let response_clipped = (of_response > 0.0).then(|| SignalWarning::Channel {
            channel: response,
            fault: ChannelFault::Clipped {
                fraction: of_response,
                off_db: Some(20.0 * (1.0 - of_response).max(1e-3).log10()),
            },
        });
        let drive_clipped = (of_drive > 0.0).then_some(SignalWarning::Channel {
            channel: drive,
            fault: ChannelFault::Clipped {
                fraction: of_drive,
                off_db: None,
            },
        });
        let dead = self.dead.map(|dead| dead.warning(pair.response_name));
        let beyond = self.beyond.clone();
        let all = [copied, dead, hum, response_clipped, drive_clipped, beyond];
        all.into_iter().flatten().map(Warning::from).collect()
    }

    /// `defects` of the channel `name` without those that the warnings about the pair name already.
    pub(super) fn beside(&self, pair: &Pair<'_>, name: &str, mut defects: Defects) -> Defects {
        let [of_drive, of_response] = self.clipped.map(|share| share > 0.0 || !pair.lasts);
        if name == pair.drive_name && of_drive || name == pair.response_name && of_response {
            defects.clipped_fraction = 0.0;
        }
        if name == pair.response_name {
            if self.dead.is_some() {
                defects.frozen.clear();
                defects.gaps.clear();
            }
            defects.hum = defects.hum.filter(|_| self.hum.is_none());
        }
        defects
    }
}

/// What is broken in a drive and the response to it that come part by part, each inspected as signals of their own.
#[derive(Clone, Debug, Default)]
pub(crate) struct BrokenInParts {
    /// Those in which both change.
    parts: usize,
    /// The first copy; none where a part is no copy, or one of another delay.
    copied: Option<Copy>,
    /// Dead stretches, the longest in s, and the power of the drive then and in all.
    dead: (usize, f64, f64),
    power: f64,
    hums: Vec<Hum>,
    beyond: Beyond,
}

impl BrokenInParts {
    pub(crate) fn add(&mut self, pair: &Pair<'_>) {
        let broken = Broken::of(pair);
        let power: f64 = pair.drive.iter().map(|v| v * v).sum();
        self.power += power;
        if let Some(limit) = pair.drive_limit {
            self.beyond.add(pair.drive, limit);
        }
        if never_changes(pair.drive) {
            return;
        }
        if never_changes(pair.response) {
            let (all, longest, lost) = self.dead;
            let length_s = pair.rate.duration_of(pair.response.len()).0;
            self.dead = (all + 1, longest.max(length_s), lost + power);
            return;
        }
        let is_first = self.parts == 0;
        self.parts += 1;
        self.copied = (broken.copied)
            .filter(|copy| is_first || self.copied.is_some_and(|first| first.later == copy.later));
        if let Some(dead) = broken.dead {
            let (all, longest, lost) = self.dead;
            self.dead = (
                all + dead.count,
                longest.max(dead.longest_s),
                lost + dead.share * power,
            );
        }
        self.hums.extend(broken.hum);
    }

    /// What is broken in all parts of `pair`, whose samples are not looked at; `clipped` are the shares of drive and response at a limit.
    pub(crate) fn broken(mut self, pair: &Pair<'_>, clipped: [f64; 2]) -> Broken {
        let (count, longest_s, lost) = self.dead;
        let share = lost / self.power.max(f64::MIN_POSITIVE);
        let dead = Dead {
            count,
            longest_s,
            share,
        };
        let dead = (count > 0).then_some(dead).filter(Dead::lowers);
        let hum = (2 * self.hums.len() > self.parts).then(|| {
            self.hums.sort_by(|a, b| a.share.total_cmp(&b.share));
            self.hums.swap_remove(self.hums.len() / 2)
        });
        let [drive, response] = clipped;
        let limit = pair.drive_limit;
        Broken {
            copied: self.copied,
            dead,
            hum,
            clipped: [if drive > CRESTS { drive } else { 0.0 }, response],
            beyond: limit.and_then(|limit| self.beyond.warning(pair.drive_name, limit)),
        }
    }
}

/// The warnings about all channels of `recording`, of each and of pairs, but for what is `broken` in `pair` of them and told of both
/// together. `limit_fraction` is the largest drive that can be played, of full scale.
pub(crate) fn warnings_beside(
    recording: &Recording,
    limit_fraction: f64,
    (pair, broken): (&Pair<'_>, &Broken),
) -> Vec<Warning> {
    let mut warnings = Vec::new();
    for (channel, clock) in recording.channels_with_clocks() {
        let name = &channel.name;
        let defects = super::defects_of(recording, channel, clock);
        warnings.extend(broken.beside(pair, name, defects).warnings(name));
        let is_told = name == pair.drive_name && broken.beyond.is_some();
        if channel.unit == Unit::FullScale && !is_told {
            let beyond = beyond(&channel.samples, name, limit_fraction);
            warnings.extend(beyond.map(Warning::from));
        }
    }
    let pair = [pair.drive_name, pair.response_name];
    warnings.extend(copies_in(recording, broken.copied.map(|_| pair)));
    warnings
}

/// The warning about a drive beyond `limit`.
pub(super) fn beyond(drive: &[f64], channel: &str, limit: f64) -> Option<SignalWarning> {
    let mut beyond = Beyond::default();
    beyond.add(drive, limit);
    beyond.warning(channel, limit)
}

/// How much of a drive is beyond a limit.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Beyond {
    peak: f64,
    count: usize,
    samples: usize,
    /// The sums of what is played times what was to be played, and of the squares of this.
    played: f64,
    all: f64,
}

impl Beyond {
    pub(super) fn add(&mut self, drive: &[f64], limit: f64) {
        let most = limit * (1.0 + TOLERANCE);
        for v in drive {
            self.peak = self.peak.max(v.abs());
            self.count += usize::from(v.abs() > most);
            self.played += v * v.clamp(-limit, limit);
            self.all += v * v;
        }
        self.samples += drive.len();
    }

    pub(super) fn warning(&self, channel: &str, limit: f64) -> Option<SignalWarning> {
        (self.count > 0).then(|| SignalWarning::Channel {
            channel: channel.into(),
            fault: ChannelFault::BeyondLimit {
                peak: self.peak,
                limit,
                share: self.count as f64 / self.samples as f64,
                lost_db: 20.0 * (self.all / self.played).log10(),
            },
        })
    }
}

/// A dead response that lowers the transfer function by less than this, dB, is not reported: the response begins later than
/// the drive anyway.
const LEAST_LOW_DB: f64 = 0.1;

/// A response that is dead while the drive goes on: so many stretches, the longest in s, and their share of the drive's power.
#[derive(Clone, Copy, Debug)]
struct Dead {
    count: usize,
    longest_s: f64,
    share: f64,
}

impl Dead {
    /// How far a transfer function is lowered, dB.
    fn low_db(&self) -> f64 {
        -20.0 * (1.0 - self.share).max(1e-3).log10()
    }

    /// Whether it lowers a transfer function by what is reported.
    fn lowers(&self) -> bool {
        self.low_db() >= LEAST_LOW_DB
    }

    fn warning(self, response_name: &str) -> SignalWarning {
        SignalWarning::Channel {
            channel: response_name.into(),
            fault: ChannelFault::DeadWhileDriven {
                count: self.count,
                longest_s: self.longest_s,
                share: self.share,
                low_db: self.low_db(),
            },
        }
    }
}

/// Where a response is dead while the drive goes on.
fn dead(pair: &Pair<'_>) -> Option<Dead> {
    let (drive, response, rate) = (pair.drive, pair.response, pair.rate);
    let usual = Usual::of(response, rate);
    let known = inspect_samples(response, rate, &Unit::MetrePerSecondSquared);
    let mut spans: Vec<Span> = known.frozen;
    spans.extend(known.gaps);
    for span in at_the_floor(response, rate, &usual, FLOOR, SHORTEST) {
        let within = |known: &Span| known.from < span.to && span.from < known.to;
        if abrupt(response, rate, &usual, span) && !spans.iter().any(within) {
            spans.push(span);
        }
    }
    let power = |part: &[f64]| part.iter().map(|v| v * v).sum::<f64>();
    let all = power(drive);
    let usual_power = all / drive.len() as f64;
    spans.retain(|span| {
        power(&drive[span.from..span.to]) >= EXCITED * EXCITED * usual_power * span.len() as f64
    });
    let share = spans
        .iter()
        .map(|span| power(&drive[span.from..span.to]))
        .sum::<f64>()
        / all;
    let longest = spans.iter().map(|span| span.len()).max()?;
    let dead = Dead {
        count: spans.len(),
        longest_s: rate.duration_of(longest).0,
        share,
    };
    dead.lowers().then_some(dead)
}
