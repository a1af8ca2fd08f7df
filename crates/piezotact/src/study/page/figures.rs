//! The figures of a report on strokes, one function for each.

use std::collections::BTreeMap;

use crate::compare::{RoughnessTrend, SpatialPeriod, Summary, WaySpectrum};
use crate::criterion::Outcome;
use crate::feature::{Analysis, Statistics, StrokeSpectra};
use crate::figure::{Axis, Chart, Figure, Line, MOST_POINTS, Mark, Panels, Scale, Tone, extremes};
use crate::number::signed;
use crate::quantity::{Seconds, Unit};
use crate::recording::Channel;
use crate::statistics::{Direction, LogFit};
use crate::stroke::Interval;
use crate::study::{AnalysedRecording, Example};

const SIGNAL: Tone = Tone::Signal;
const SECOND: Tone = Tone::Accent;
const SINGLE: Tone = Tone::Pale;
const MEAN: Tone = Tone::Reference;
/// A fitted line.
const LAW: Tone = Tone::Second;
/// Up to so many strokes are shown one by one beside their mean.
const FEW: usize = 5;

/// The part of a recording that is shown: all of it, or its first `LONGEST_S` seconds.
const LONGEST_S: f64 = 60.0;

/// What a chart of signals shows, and its channels.
type Drawn<'t> = (String, Vec<&'t Channel>);

/// How long a part of `take` is shown, s.
fn shown_s(take: &AnalysedRecording) -> f64 {
    let rate = take.recording.rate();
    let whole = rate.duration_of(take.recording.len()).0;
    whole.min(LONGEST_S)
}

/// The channels of a recording, those of one kind together.
fn kinds(take: &AnalysedRecording) -> Vec<Drawn<'_>> {
    let roles = &take.segmentation.roles;
    let channel = |name: &String| take.recording.pick(Some(name), &Unit::Newton).ok();
    let vibration: Vec<&Channel> = roles.vibration.iter().filter_map(channel).take(3).collect();
    let unit = vibration.first().map_or("", |c| c.unit.symbol()).to_owned();
    let mut kinds = vec![
        (axis_label("vibration", &unit), vibration),
        (
            "normal force, N".into(),
            roles.normal_force.iter().filter_map(channel).collect(),
        ),
        (
            "tangential force, N".into(),
            roles.tangential_force.iter().filter_map(channel).collect(),
        ),
    ];
    if let Some(channel) = roles
        .motion
        .as_ref()
        .and_then(|m| channel(&m.channel().to_owned()))
    {
        kinds.push((axis_label("motion", channel.unit.symbol()), vec![channel]));
    }
    kinds.retain(|(_, channels)| !channels.is_empty());
    kinds
}

/// The signals of recordings with their cuts: for each recording the charts of each kind of channel over one time. One kind has
/// one scale.
pub(super) fn signals(takes: &[AnalysedRecording]) -> Vec<Figure> {
    let kinds: Vec<Vec<Drawn<'_>>> = takes.iter().map(kinds).collect();
    let mut scales: BTreeMap<&str, (f64, f64)> = BTreeMap::new();
    for (take, kinds) in takes.iter().zip(&kinds) {
        let shown = take.recording.rate().samples_in(Seconds(shown_s(take)));
        for (label, channels) in kinds {
            let samples = channels.iter().flat_map(|c| c.samples.iter().take(shown));
            let scale = scales.entry(label).or_insert((f64::MAX, f64::MIN));
            *scale = samples.fold(*scale, |(low, high), v| (low.min(*v), high.max(*v)));
        }
    }
    let figures = takes.iter().zip(&kinds).map(|(take, kinds)| {
        let charts = kinds.iter().map(|(label, channels)| {
            let (low, high) = scales.get(label.as_str()).copied().unwrap_or((0.0, 1.0));
            let room = 0.06 * (high - low).max(f64::MIN_POSITIVE);
            let scale = Axis::new(label.as_str(), low - room, high + room);
            signals_of(take, channels, scale)
        });
        Panels::new(charts.collect())
            .captioned("Shaded green: strokes as they are analysed. Shaded red: rejected.")
    });
    figures.collect()
}

/// Some channels of a recording with its cuts.
fn signals_of(take: &AnalysedRecording, channels: &[&Channel], scale: Axis) -> Chart {
    let rate = take.recording.rate();
    let length_s = shown_s(take);
    let shown = rate.samples_in(Seconds(length_s));
    let points = |channel: &Channel| -> Vec<(f64, f64)> {
        let samples = channel.samples.iter().take(shown).enumerate();
        let samples = samples.map(|(i, v)| (i as f64 / rate.hz(), *v));
        extremes(samples.collect(), MOST_POINTS)
    };
    let colours = [SIGNAL, SECOND, Tone::Third];
    let several = channels.len() > 1;
    let lines: Vec<Line> = channels
        .iter()
        .zip(colours.iter().cycle())
        .map(|(channel, colour)| {
            let name = if several { channel.name.as_str() } else { "" };
            Line::new(name, *colour, points(channel)).thin()
        })
        .collect();
    let span = |interval: &Interval| {
        let at = |sample: usize| rate.duration_of(sample).0.min(length_s);
        (at(interval.start), at(interval.end))
    };
    let mut chart = Chart::new(Axis::new("time, s", 0.0, length_s), scale, lines);
    let segmentation = &take.segmentation;
    chart.shaded = segmentation
        .strokes
        .iter()
        .map(|s| span(&s.steady))
        .collect();
    let rejected = segmentation.rejected.iter();
    chart.rejected = rejected.map(|r| span(&r.interval)).collect();
    for ranges in [&mut chart.shaded, &mut chart.rejected] {
        ranges.retain(|(from, to)| from < to);
    }
    chart
}

/// "acceleration, m/s²" where the unit says so.
pub(super) fn axis_label(what: &str, unit: &str) -> String {
    match unit {
        "m/s²" => "acceleration, m/s²".into(),
        "FS" => format!("{what}, full scale = 1"),
        unit => format!("{what}, {unit}"),
    }
}

/// One stroke as it was cut: its vibration, its forces and their ratio over one time (thesis figure 28).
pub(super) fn stroke(take: &AnalysedRecording, example: &Example, unit: &str) -> Option<Figure> {
    let stroke = take.segmentation.strokes.first()?;
    let rate_hz = take.recording.rate().hz();
    let seconds = |sample: usize| sample as f64 / rate_hz;
    let points = |samples: &[f64]| -> Vec<(f64, f64)> {
        let samples = samples.iter().enumerate();
        let samples = samples.map(|(i, v)| (seconds(stroke.steady.start + i), *v));
        extremes(samples.collect(), MOST_POINTS)
    };
    let time = Axis::new(
        "time, s",
        seconds(stroke.steady.start),
        seconds(stroke.steady.end),
    );
    let chart = |y: Axis, line: Line| Chart::new(time.clone(), y, vec![line.thin()]);
    let mut charts = Vec::new();
    if let Some(samples) = &example.samples {
        let reach = samples
            .iter()
            .fold(f64::MIN_POSITIVE, |reach, v| reach.max(v.abs()))
            * 1.1;
        charts.push(chart(
            Axis::new(axis_label("vibration", unit), -reach, reach),
            Line::new("", SIGNAL, points(samples)),
        ));
    }
    let forces = example.forces.iter().flat_map(|forces| {
        [
            ("normal force, N", &forces.normal_n),
            ("tangential force, N", &forces.tangential_n),
            ("friction coefficient", &forces.friction_coefficient),
        ]
    });
    for (label, samples) in forces.filter(|(_, samples)| !samples.is_empty()) {
        let y = Axis::around(label, Scale::Linear, samples.iter().copied());
        charts.push(chart(y, Line::new("", SIGNAL, points(samples))));
    }
    let filtered = (take.analysis.as_ref()).and_then(|analysis| analysis.config.high_pass);
    let filtered = filtered.map_or(
        "",
        |_| ", its vibration with the gesture filtered out as described below",
    );
    let forces = example.forces.as_ref().map_or(
        "",
        |_| " Forces are relative to their zero while the finger is lifted.",
    );
    let is_empty = charts.is_empty();
    (!is_empty)
        .then(|| Panels::new(charts).captioned(format!("The first stroke{filtered}.{forces}")))
}

/// Frequencies that are worth showing: the band of the features, and what they hold.
fn frequency_axis(analysis_low_hz: f64, analysis_high_hz: f64) -> Axis {
    Axis::log("frequency, Hz", analysis_low_hz, analysis_high_hz)
}

fn density(spectra: &StrokeSpectra, values: &[f64]) -> Vec<(f64, f64)> {
    let lines = spectra.frequency_hz.iter().copied();
    lines.zip(values.iter().copied()).skip(1).collect()
}

/// A logarithmic axis for densities within the axis of frequencies, six decades at most.
fn density_axis(label: String, x: &Axis, lines: &[Line]) -> Axis {
    let inside = || {
        lines
            .iter()
            .flat_map(|line| &line.points)
            .filter(|(f, v)| *f >= x.low && *f <= x.high && *v > 0.0)
            .map(|(_, v)| *v)
    };
    let high = inside().fold(f64::MIN_POSITIVE, f64::max);
    let low = inside().fold(high, f64::min).max(1e-6 * high);
    Axis::log(label, low / 1.5, high * 2.0)
}

/// The spectra of single strokes with their mean: amplitude spectrum and PSD.
pub(super) fn strokes_with_mean(analysis: &Analysis) -> [Figure; 2] {
    let band = analysis.config.band;
    let chart = |spectra: &StrokeSpectra, label: String| {
        let mut lines: Vec<Line> = spectra
            .each
            .iter()
            .take(40)
            .enumerate()
            .map(|(i, each)| {
                let name = if i == 0 { "single strokes" } else { "" };
                Line::new(name, SINGLE, density(spectra, each)).thin()
            })
            .collect();
        lines.push(Line::new("mean", MEAN, density(spectra, &spectra.mean)));
        let x = frequency_axis(band.low().0, band.high().0);
        let y = density_axis(label, &x, &lines);
        Chart::new(x, y, lines)
    };
    let unit = &analysis.unit;
    [
        chart(&analysis.fft, format!("amplitude, {unit}")).captioned(
            "Amplitude spectrum (FFT) of every stroke (of the first 40 where there are more) over the same length, and the mean of \
             all.",
        ),
        chart(&analysis.psd, format!("PSD, {}", unit.of_psd())).captioned(
            "Power spectral density of every stroke (of the first 40 where there are more), and the mean of all.",
        ),
    ]
}

/// The axes of figures of PSDs that are compared with each other.
pub(super) struct SpectralAxes {
    frequency: Axis,
    density: Axis,
}

impl SpectralAxes {
    /// Around the mean PSDs of all `groups` over `band`, Hz.
    pub(super) fn around(band: (f64, f64), groups: &[&Summary]) -> Self {
        let frequency = frequency_axis(band.0, band.1);
        let unit = groups
            .first()
            .map_or(String::new(), |group| group.unit.of_psd());
        let lines = groups.iter().map(|group| {
            let points = density(&group.psd, &group.psd.mean);
            Line::new("", SINGLE, points)
        });
        let lines: Vec<Line> = lines.collect();
        Self {
            density: density_axis(format!("PSD, {unit}"), &frequency, &lines),
            frequency,
        }
    }
}

/// The mean PSDs of groups, one line each.
pub(super) fn psds(groups: &[&Summary], axes: &SpectralAxes) -> Chart {
    let colours = Tone::several(groups.len());
    let many = groups.len() > 7;
    let lines: Vec<Line> = groups
        .iter()
        .zip(&colours)
        .enumerate()
        .map(|(i, (group, colour))| {
            let line = Line::new(&group.name, *colour, density(&group.psd, &group.psd.mean));
            // Neighbours on a scale of colours differ in their stroke as well.
            if many && i % 2 == 1 {
                line.marked(Mark::Dashed)
            } else {
                line
            }
        })
        .collect();
    Chart::new(axes.frequency.clone(), axes.density.clone(), lines)
}

/// The mean PSDs of groups along the way, one line each.
pub(super) fn along_the_way(groups: &[(&str, &WaySpectrum)]) -> Chart {
    let colours = Tone::several(groups.len());
    let each = groups.iter().zip(colours);
    let lines: Vec<Line> = each
        .map(|((name, spectrum), colour)| {
            let per_mm = spectrum.wavenumber_1_m.iter().map(|k| k * 1e-3);
            let points = per_mm.zip(spectrum.mean.iter().copied());
            Line::new(*name, colour, points.filter(|(k, _)| *k > 0.0).collect())
        })
        .collect();
    let ends = || lines.iter().flat_map(|line| &line.points).map(|(k, _)| *k);
    let low = ends().fold(f64::MAX, f64::min);
    let x = Axis::log("wavenumber, 1/mm", low, ends().fold(low, f64::max));
    let unit = groups.first().map_or("", |(_, spectrum)| &spectrum.unit);
    let y = density_axis(format!("PSD, {unit}"), &x, &lines);
    Chart::new(x, y, lines)
}

/// A power law of Ra in µm, within both axes.
fn line_of(fit: &LogFit, x: &Axis, y: &Axis) -> Vec<(f64, f64)> {
    let (from, to) = (x.low.log10(), x.high.log10());
    (0..=200)
        .map(|i| from + (to - from) * f64::from(i) / 200.0)
        .map(|place| {
            // The fit is over Ra in m.
            let level = fit.intercept + fit.slope * (place - 6.0);
            (10f64.powf(place), 10f64.powf(level))
        })
        .filter(|(_, value)| (y.low..=y.high).contains(value))
        .collect()
}

/// Ra and rms of the samples in the order of their roughness, the roughest first (thesis figure 33).
pub(super) fn in_order(groups: &[&Summary], trend: &RoughnessTrend) -> Figure {
    let mut known: Vec<(&Summary, f64)> = with_roughness(groups, trend);
    known.sort_by(|a, b| b.1.total_cmp(&a.1));
    let at = |i: usize| i as f64;
    let ra = known.iter().enumerate();
    let ra: Vec<(f64, f64)> = ra.map(|(i, (_, ra_um))| (at(i), *ra_um)).collect();
    let rms = known.iter().enumerate();
    let rms: Vec<(f64, f64)> = rms.map(|(i, (group, _))| (at(i), group.rms.mean)).collect();
    let each: Vec<(f64, Spread)> = (known.iter().enumerate())
        .filter_map(|(i, (group, _))| Some((at(i), Spread::of_rms(group)?)))
        .collect();
    let spread = each.iter().filter(|(_, group)| group.sd < group.mean);
    let spread = spread.map(|(x, group)| (*x, group.mean - group.sd, group.mean + group.sd));
    let spread: Vec<(f64, f64, f64)> = spread.collect();
    let names = known.iter().map(|(group, _)| group.name.clone()).collect();
    let x = Axis::names("sample, the roughest first", names);
    let ends = spread.iter().flat_map(|(_, low, high)| [*low, *high]);
    let levels = Axis::around(
        rms_label(groups),
        Scale::Logarithmic,
        ends.chain(rms.iter().map(|p| p.1)),
    );
    let heights = Axis::around("Ra, µm", Scale::Logarithmic, ra.iter().map(|p| p.1));
    Panels::new(vec![
        Chart::new(
            x.clone(),
            heights,
            vec![Line::new("", MEAN, ra).marked(Mark::Joined)],
        ),
        Chart::new(
            x,
            levels,
            vec![
                singles(each.iter().map(|(x, group)| (*x, group)), SIGNAL),
                Line::new("", SIGNAL, rms)
                    .marked(Mark::Joined)
                    .spread(spread),
            ],
        ),
    ])
    .captioned(
        "Roughness Ra and rms of the vibration of the samples, the roughest first; bars: standard deviation over strokes.",
    )
}

/// The groups whose roughness is known, with their Ra in µm.
fn with_roughness<'g>(groups: &[&'g Summary], trend: &RoughnessTrend) -> Vec<(&'g Summary, f64)> {
    groups
        .iter()
        .filter_map(|group| {
            let place = trend.samples.iter().position(|name| *name == group.name)?;
            Some((*group, trend.ra_m[place] * 1e6))
        })
        .collect()
}

/// Rms against Ra, both logarithmic, with the power law that is fitted where a trend is shown.
pub(super) fn roughness(groups: &[&Summary], trend: &RoughnessTrend) -> Figure {
    let known = with_roughness(groups, trend);
    let points: Vec<(f64, f64)> = known.iter().map(|(g, ra)| (*ra, g.rms.mean)).collect();
    let spread = known
        .iter()
        .map(|(g, ra)| (*ra, g.rms.mean - g.rms.sd, g.rms.mean + g.rms.sd))
        .collect();
    let x = Axis::around("Ra, µm", Scale::Logarithmic, points.iter().map(|p| p.0));
    let y = Axis::around(
        rms_label(groups),
        Scale::Logarithmic,
        points.iter().map(|p| p.1),
    );
    let mut lines = Vec::new();
    let fit = trend.rms_on_ra.as_ref();
    if let Some(fit) = fit.filter(|fit| fit.direction() != Direction::NotShown) {
        let law = format!("rms ∝ Ra^{}", signed(fit.slope, 2));
        lines.push(Line::new(law, LAW, line_of(fit, &x, &y)));
    }
    lines.push(
        Line::new("", SIGNAL, points)
            .marked(Mark::Dots)
            .spread(spread),
    );
    let mut chart = Chart::new(x, y, lines);
    chart.notes = known
        .iter()
        .map(|(g, ra)| (*ra, g.rms.mean, g.name.clone()))
        .collect();
    chart.captioned(
        "Rms of the vibration against the roughness Ra of the samples, with the fitted power law where a trend is shown.",
    )
}

fn rms_label(groups: &[&Summary]) -> String {
    let unit = groups
        .first()
        .map_or(String::new(), |group| group.unit.to_string());
    axis_label("rms", &unit).replace("acceleration", "rms of acceleration")
}

/// Something of a group: mean and standard deviation over its strokes, and its single strokes.
#[derive(Clone)]
pub(super) struct Spread {
    mean: f64,
    sd: f64,
    each: Vec<f64>,
}

impl Spread {
    /// The rms of a group.
    pub(super) fn of_rms(group: &Summary) -> Option<Self> {
        Some(Self::of(group.rms, &group.rms_each))
    }

    /// The friction coefficient of a group.
    pub(super) fn of_friction(group: &Summary) -> Option<Self> {
        let friction = group.friction_coefficient?;
        Some(Self::of(friction, &group.friction_each))
    }

    fn of(value: Statistics, each: &[f64]) -> Self {
        Self {
            mean: value.mean,
            sd: value.sd,
            each: each.to_vec(),
        }
    }

    /// The single strokes, where they are so few that a mean and its bar hide them.
    fn few(&self) -> &[f64] {
        match self.each.len() {
            2..=FEW => &self.each,
            _ => &[],
        }
    }
}

/// The single strokes of `groups` at their x, as small dots.
fn singles<'s>(groups: impl Iterator<Item = (f64, &'s Spread)>, tone: Tone) -> Line {
    let points = groups.flat_map(|(x, group)| group.few().iter().map(move |value| (x, *value)));
    Line::new("", tone, points.collect())
        .thin()
        .marked(Mark::Dots)
}

/// Something of every group for each setting; absent where it was not measured.
pub(super) type Sets = Vec<(String, Vec<Option<Spread>>)>;

/// Something of every group, over the names of the groups: a point for each of `sets`, those of one name side by side. Names
/// have no order that a line could follow.
pub(super) fn by_name(names: &[String], y_label: String, x_label: &str, sets: &Sets) -> Chart {
    let colours = Tone::several(sets.len());
    let beside = |set: usize| 0.5 * ((set as f64 + 0.5) / sets.len() as f64 - 0.5);
    // Single strokes stand a little to the right of their mean.
    let aside = 0.12 / sets.len() as f64;
    let mut lines: Vec<Line> = Vec::new();
    for (set, ((label, values), colour)) in sets.iter().zip(&colours).enumerate() {
        let known = || {
            let values = values.iter().enumerate();
            values.filter_map(move |(i, v)| Some((i as f64 + beside(set), v.as_ref()?)))
        };
        let label = if sets.len() > 1 { label.as_str() } else { "" };
        let points = known().map(|(x, group)| (x, group.mean)).collect();
        let spread = known().map(|(x, group)| (x, group.mean - group.sd, group.mean + group.sd));
        lines.push(singles(
            known().map(|(x, group)| (x + aside, group)),
            *colour,
        ));
        lines.push(
            Line::new(label, *colour, points)
                .marked(Mark::Dots)
                .spread(spread.collect()),
        );
    }
    let ends = lines.iter().flat_map(|line| {
        let spread = line.spread.iter().flat_map(|(_, low, high)| [*low, *high]);
        spread.chain(line.points.iter().map(|p| p.1))
    });
    let y = Axis::around(y_label, Scale::Linear, ends);
    Chart::new(Axis::names(x_label, names.to_vec()), y, lines)
}

/// A setting, and x and something at each of its groups.
pub(super) type Courses = Vec<(String, Vec<(f64, Spread)>)>;

/// Something of every group over a quantity, both logarithmic: joined points for each setting.
pub(super) fn over_quantity(x_label: &str, y_label: String, courses: &Courses) -> Chart {
    let colours = Tone::several(courses.len());
    let mut lines: Vec<Line> = Vec::new();
    for ((label, course), colour) in courses.iter().zip(&colours) {
        let label = if courses.len() > 1 {
            label.as_str()
        } else {
            ""
        };
        let points = course.iter().map(|(x, group)| (*x, group.mean));
        // A bar that reaches zero has no end on a logarithmic axis.
        let spread = course.iter().filter(|(_, group)| group.sd < group.mean);
        let spread = spread.map(|(x, group)| (*x, group.mean - group.sd, group.mean + group.sd));
        let each = course.iter().map(|(x, group)| (*x, group));
        lines.push(singles(each, *colour));
        lines.push(
            Line::new(label, *colour, points.collect())
                .thin()
                .marked(Mark::Joined)
                .spread(spread.collect()),
        );
    }
    let measured = || {
        courses
            .iter()
            .flat_map(|(_, course)| course.iter().map(|(x, _)| *x))
    };
    let ends = lines.iter().flat_map(|line| {
        let spread = line.spread.iter().flat_map(|(_, low, high)| [*low, *high]);
        spread.chain(line.points.iter().map(|p| p.1))
    });
    let x = Axis::around(x_label, Scale::Logarithmic, measured()).ticks_at(measured());
    let y = Axis::around(y_label, Scale::Logarithmic, ends);
    Chart::new(x, y, lines)
}

/// The axes of all figures of peaks over speed, which are compared with each other.
pub(super) fn period_axes<'p>(periods: impl Iterator<Item = &'p SpatialPeriod>) -> (Axis, Axis) {
    let peaks: Vec<_> = periods.flat_map(|period| &period.peaks).collect();
    let (fastest, highest) = peaks.iter().fold((0.0, 0.0), |(v, f): (f64, f64), peak| {
        (v.max(peak.speed_m_s * 1e3), f.max(peak.frequency_hz))
    });
    (
        Axis::new("speed, mm/s", 0.0, fastest * 1.1)
            .ticks_at(peaks.iter().map(|peak| peak.speed_m_s * 1e3)),
        Axis::new("frequency of the peak, Hz", 0.0, highest * 1.15),
    )
}

/// The peaks of a spatial period over speed, with the line f = v/λ where the period stands out.
pub(super) fn period(period: &SpatialPeriod, (speed, frequency): &(Axis, Axis)) -> Figure {
    let points: Vec<(f64, f64)> = period
        .peaks
        .iter()
        .map(|peak| (peak.speed_m_s * 1e3, peak.frequency_hz))
        .collect();
    let label = format!("f = v / {:.3} mm", period.period_m * 1e3);
    // The line ends where the first of the axes does.
    let fastest = speed.high.min(frequency.high * period.period_m * 1e3);
    let law = vec![(0.0, 0.0), (fastest, fastest * 1e-3 / period.period_m)];
    let mut lines = Vec::new();
    if period.outcome == Outcome::Met {
        lines.push(Line::new(label, LAW, law));
    }
    lines.push(Line::new("", SIGNAL, points).marked(Mark::Dots));
    Chart::new(speed.clone(), frequency.clone(), lines)
        .captioned("The peak of each speed, and the line f = v/λ where the period stands out.")
}
