//! The kinds of recordings: what is planned otherwise than usually, and what is done to what was recorded.

use super::super::signal::{Draws, RATE_HZ};
use super::generator::{Made, Motion, Plan, Surface, coloured};

/// What a study is made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Is {
    /// Its conclusions have to be said.
    Right,
    /// Nothing has to be said of it; what is said has to be true.
    Odd,
    /// As odd, with a unit that is wrong, which the recordings themselves hardly show.
    WrongUnit,
}

/// A kind of study.
pub(super) struct Kind {
    pub(super) name: &'static str,
    pub(super) is: Is,
    pub(super) plan: fn(&mut Plan),
    pub(super) change: fn(&mut Vec<Made>, &mut Draws),
}

const fn right(name: &'static str, plan: fn(&mut Plan)) -> Kind {
    let is = Is::Right;
    let change = |_: &mut Vec<Made>, _: &mut Draws| ();
    Kind {
        name,
        is,
        plan,
        change,
    }
}

const fn right_with(name: &'static str, change: fn(&mut Vec<Made>, &mut Draws)) -> Kind {
    let kind = odd(name, change);
    Kind {
        is: Is::Right,
        ..kind
    }
}

const fn odd(name: &'static str, change: fn(&mut Vec<Made>, &mut Draws)) -> Kind {
    both(name, |_| (), change)
}

const fn wrong_unit(name: &'static str, change: fn(&mut Vec<Made>, &mut Draws)) -> Kind {
    let kind = odd(name, change);
    Kind {
        is: Is::WrongUnit,
        ..kind
    }
}

const fn planned(name: &'static str, plan: fn(&mut Plan)) -> Kind {
    both(name, plan, |_, _| ())
}

const fn both(
    name: &'static str,
    plan: fn(&mut Plan),
    change: fn(&mut Vec<Made>, &mut Draws),
) -> Kind {
    let is = Is::Odd;
    Kind {
        name,
        is,
        plan,
        change,
    }
}

pub(super) static KINDS: [Kind; 69] = [
    // Right ones.
    right("three speeds", |_| ()),
    right("20 and 40 mm/s", |plan| plan.speeds_m_s = vec![0.02, 0.04]),
    right("10 and 30 mm/s", |plan| plan.speeds_m_s = vec![0.01, 0.03]),
    right("four speeds", |plan| {
        plan.speeds_m_s = vec![0.01, 0.015, 0.022, 0.035]
    }),
    right("three loads", |plan| plan.loads_n = vec![0.2, 0.4, 0.8]),
    right("three recordings each", |plan| plan.repeats = 3),
    right("sessions 1 dB apart", |plan| {
        (plan.repeats, plan.session_sd_db) = (3, 1.0)
    }),
    right("with a speed channel", |plan| plan.motion = Motion::Speed),
    right("with a position channel", |plan| {
        plan.motion = Motion::Position
    }),
    right("long strokes", |plan| {
        (plan.stroke_s, plan.strokes) = (3.0, 4)
    }),
    right("fourteen strokes", |plan| plan.strokes = 14),
    right("a noisy accelerometer", |plan| {
        plan.sensor_noise_m_s2 = 0.05
    }),
    right("one load of 1 N", |plan| plan.loads_n = vec![1.0]),
    right("six roughnesses", six_roughnesses),
    right_with("mains beside", |all, draws| {
        each(all, |made| made.add_line(50.0, 0.1, draws))
    }),
    right_with("mains beside, harmonics", |all, draws| {
        lines(all, draws, [(50.0, 0.2), (100.0, 0.1), (150.0, 0.2)])
    }),
    right_with("a fan at 23.7 Hz beside", |all, draws| {
        each(all, |made| made.add_line(23.7, 0.05, draws))
    }),
    right_with("force upside down", |all, _| {
        each(all, |made| scale(&mut made.normal_n, -1.0))
    }),
    right_with("friction upside down", |all, _| {
        each(all, |made| scale(&mut made.tangential_n, -1.0))
    }),
    // Lines of a machine.
    odd("motor 37, 74, 111 Hz", |all, draws| {
        lines(all, draws, [(37.0, 1.0), (74.0, 0.7), (111.0, 0.7)])
    }),
    odd("motor while sliding", |all, draws| {
        each(all, |made| {
            for (hz, level) in [(37.0, 1.0), (74.0, 0.7), (111.0, 0.7)] {
                while_moving(made, level, draws, |_, i| hz * i as f64 / RATE_HZ);
            }
        })
    }),
    odd("motor, one sample's", |all, draws| {
        of(all, "A", |made| made.add_line(83.0, 1.0, draws))
    }),
    odd("mains 50 Hz", |all, draws| {
        each(all, |made| made.add_line(50.0, 1.0, draws))
    }),
    odd("mains 60 Hz and harmonics", |all, draws| {
        lines(all, draws, [(60.0, 1.0), (120.0, 0.7), (180.0, 0.5)])
    }),
    odd("mains 50, 100, 150 Hz", |all, draws| {
        lines(all, draws, [(50.0, 0.7), (100.0, 0.7), (150.0, 0.7)])
    }),
    odd("mains in one sample", |all, draws| {
        of(all, "A", |made| made.add_line(50.0, 1.0, draws))
    }),
    odd("mains while sliding, one sample", |all, draws| {
        of(all, "A", |made| {
            while_moving(made, 1.0, draws, |_, i| 50.0 * i as f64 / RATE_HZ)
        })
    }),
    odd("lead screw 0.9 mm", |all, draws| {
        each(all, |made| {
            while_moving(made, 1.0, draws, |made, i| made.path_m[i] / 0.0009)
        })
    }),
    odd("gear 0.5 and 0.33 mm", |all, draws| {
        each(all, |made| {
            while_moving(made, 0.7, draws, |made, i| made.path_m[i] / 0.0005);
            while_moving(made, 0.7, draws, |made, i| made.path_m[i] / 0.000_33);
        })
    }),
    both(
        "lead screw, one sample alone",
        |plan| plan.surfaces.truncate(1),
        |all, draws| {
            each(all, |made| {
                made.drive_m = Some(0.0009);
                while_moving(made, 1.0, draws, |made, i| made.path_m[i] / 0.0009);
            })
        },
    ),
    odd("f = 5 Hz + 2v", |all, draws| {
        each(all, |made| {
            let hz = 5.0 + 2.0 * made.true_speed_m_s * 1e3;
            while_moving(made, 1.0, draws, |_, i| hz * i as f64 / RATE_HZ);
        })
    }),
    odd("a line that wanders 1 Hz", |all, draws| {
        each(all, |made| {
            let [turn, rate] = [draws.uniform(), draws.between(0.1, 0.4)];
            made.add(1.0, |_, i| {
                let at_s = i as f64 / RATE_HZ;
                61.0 * at_s
                    + (std::f64::consts::TAU * rate * at_s + turn).sin()
                        / (std::f64::consts::TAU * rate)
            });
        })
    }),
    odd("a machine that warms up", |all, draws| {
        each(all, |made| {
            let hz = 40.0 * 1.04f64.powf(made.true_speed_m_s / 0.01);
            made.add_line(hz, 1.0, draws);
        })
    }),
    both(
        "warming with the speed",
        |plan| plan.speeds_m_s = vec![0.02, 0.022, 0.024],
        |all, draws| {
            each(all, |made| {
                made.add_line(40.0 * made.true_speed_m_s / 0.02, 1.0, draws);
            })
        },
    ),
    // Copies.
    odd("copies as speeds", |all, _| {
        copies_as_speeds(all, |_, _| ())
    }),
    odd("copies as speeds, scaled", |all, _| {
        copies_as_speeds(all, scaled)
    }),
    odd("copies as speeds, shifted", |all, _| {
        copies_as_speeds(all, shifted)
    }),
    odd("copy as another sample", |all, _| {
        copies_as_sample(all, |_, _| ())
    }),
    odd("copy as another sample, scaled", |all, _| {
        copies_as_sample(all, scaled)
    }),
    odd("copy as another sample, shifted", |all, _| {
        copies_as_sample(all, shifted)
    }),
    both(
        "copies as repeats, scaled",
        |plan| plan.session_sd_db = 3.0,
        |all, _| repeats(all, scaled),
    ),
    both(
        "copies as repeats, shifted",
        |plan| plan.session_sd_db = 3.0,
        |all, _| repeats(all, shifted),
    ),
    // Labels.
    odd("speeds swapped", |all, _| {
        each(all, |made| made.speed_m_s = 0.04 - made.true_speed_m_s)
    }),
    odd("speeds turned", |all, _| {
        each(all, |made| {
            made.speed_m_s = if made.true_speed_m_s < 0.025 {
                made.true_speed_m_s + 0.01
            } else {
                0.01
            };
        })
    }),
    odd("samples swapped at one speed", |all, _| {
        each(all, |made| {
            if made.true_speed_m_s == 0.02 {
                made.sample = match made.sample.as_str() {
                    "A" => "C",
                    "C" => "A",
                    other => other,
                }
                .into();
            }
        })
    }),
    both(
        "one label wrong of three",
        |plan| plan.repeats = 3,
        |all, _| {
            if let Some(made) = all.iter_mut().find(|made| made.sample == "C") {
                made.sample = "A".into();
            }
        },
    ),
    both(
        "speeds that are equal",
        |plan| plan.speeds_m_s = vec![0.02; 3],
        |all, _| {
            for (i, made) in all.iter_mut().enumerate() {
                made.speed_m_s = 0.01 * (i % 3 + 1) as f64;
            }
        },
    ),
    planned("one speed", |plan| plan.speeds_m_s = vec![0.02]),
    planned("speeds within 5 %", |plan| {
        plan.speeds_m_s = vec![0.02, 0.0205, 0.021]
    }),
    // Surfaces and sliding.
    planned("two combs", |plan| {
        for surface in &mut plan.surfaces {
            let second: Vec<_> = surface
                .combs
                .iter()
                .map(|(m, share)| (1.4 * m, 0.4 * share))
                .collect();
            surface
                .combs
                .iter_mut()
                .for_each(|(_, share)| *share *= 0.6);
            surface.combs.extend(second);
        }
    }),
    planned("speed wobbles 20 %", |plan| plan.wobble = 0.2),
    planned("short strokes", |plan| plan.stroke_s = 0.6),
    planned("two strokes", |plan| plan.strokes = 2),
    planned("interrupted sliding", |plan| {
        (plan.stroke_s, plan.pause_s) = (2.5, 0.5)
    }),
    odd("lifted for half of the time", |all, _| {
        each(all, |made| {
            let half = made.acceleration.len() / 2;
            for i in (0..half).filter(|i| (i / 2_000) % 2 == 0) {
                (made.normal_n[i], made.tangential_n[i]) = (0.01, 0.0);
                made.acceleration[i] *= 0.01;
            }
        })
    }),
    odd("no contact", |all, draws| {
        each(all, |made| untouched(made, draws))
    }),
    odd("no contact, motor moves", |all, draws| {
        each(all, |made| {
            untouched(made, draws);
            while_moving(made, 0.3, draws, |made, i| made.path_m[i] / 0.0009);
        })
    }),
    odd("noise alone, force held", |all, draws| {
        each(all, |made| {
            made.acceleration = draws
                .white(made.acceleration.len())
                .iter()
                .map(|v| 0.02 * v)
                .collect();
            made.surface = None;
        })
    }),
    // Sensors.
    odd("accelerometer clips on one side", |all, _| {
        of(all, "A", |made| clip(&mut made.acceleration, 1.0))
    }),
    odd("force clips", |all, _| {
        each(all, |made| {
            let at_n = 0.75 * made.true_load_n;
            clip(&mut made.normal_n, at_n);
        })
    }),
    odd("force drifts 20 mN/s", |all, _| {
        each(all, |made| {
            made.normal_n
                .iter_mut()
                .enumerate()
                .for_each(|(i, v)| *v += 0.02 * i as f64 / RATE_HZ);
        })
    }),
    odd("loose, one sample", |all, draws| {
        of(all, "A", |made| {
            let rattle = coloured(made.acceleration.len(), [500.0, 700.0], draws);
            made.while_sliding(|i, a| a + 0.7 * rattle[i]);
        })
    }),
    odd("loosens in mid-recording, one sample", |all, _| {
        of(all, "A", |made| {
            let half = made.acceleration.len() / 2;
            scale(&mut made.acceleration[half..], 0.3);
        })
    }),
    odd("drop-outs, one sample", |all, _| {
        of(all, "A", |made| {
            let all = made.acceleration.iter_mut().enumerate();
            all.filter(|(i, _)| (i / 500) % 3 == 0)
                .for_each(|(_, a)| *a = 0.0);
        })
    }),
    wrong_unit("in g, one sample", |all, _| {
        of(all, "A", |made| scale(&mut made.acceleration, 1.0 / 9.81))
    }),
    wrong_unit("in g, all samples", |all, _| {
        each(all, |made| scale(&mut made.acceleration, 1.0 / 9.81))
    }),
    wrong_unit("velocity, one sample", |all, _| of(all, "A", velocity)),
    wrong_unit("velocity, all samples", |all, _| each(all, velocity)),
    planned("force noise 0.1 N", |plan| plan.force_noise_n = 0.1),
];

fn each(all: &mut [Made], change: impl FnMut(&mut Made)) {
    all.iter_mut().for_each(change);
}

/// The recordings of one sample.
fn of(all: &mut [Made], sample: &str, change: impl FnMut(&mut Made)) {
    all.iter_mut()
        .filter(|made| made.sample == sample)
        .for_each(change);
}

/// Lines at fixed frequencies, each with its amplitude, on all recordings.
fn lines<const N: usize>(all: &mut [Made], draws: &mut Draws, lines: [(f64, f64); N]) {
    each(all, |made| {
        lines
            .iter()
            .for_each(|(hz, level)| made.add_line(*hz, *level, draws))
    });
}

/// A line that is there while the finger slides, or what carries it.
fn while_moving(
    made: &mut Made,
    level: f64,
    draws: &mut Draws,
    turns: impl Fn(&Made, usize) -> f64,
) {
    let still = made.acceleration.clone();
    let turn = draws.uniform();
    made.add(level, |made, i| turns(made, i) + turn);
    for (i, v) in made.slides_m_s.iter().enumerate() {
        if *v <= 0.0 {
            made.acceleration[i] = still[i];
        }
    }
}

fn scale(samples: &mut [f64], by: f64) {
    samples.iter_mut().for_each(|v| *v *= by);
}

fn clip(samples: &mut [f64], at: f64) {
    samples.iter_mut().for_each(|v| *v = v.min(at));
}

/// Six samples whose level rises with Ra to the power of 0.5, at one speed.
fn six_roughnesses(plan: &mut Plan) {
    let first = plan.surfaces[0].clone();
    let surface = |(i, name): (usize, &'static str)| {
        let rougher = 2.5f64.powi(i as i32);
        Surface {
            name,
            ra_m: 1e-6 * rougher,
            level_m_s2: 0.3 * rougher.sqrt(),
            ..first.clone()
        }
    };
    plan.surfaces = ["A", "B", "C", "D", "E", "F"]
        .into_iter()
        .enumerate()
        .map(surface)
        .collect();
    plan.speeds_m_s = vec![0.03];
}

fn scaled(made: &mut Made, number: usize) {
    let by = 1.001f64.powi(number as i32);
    for samples in [
        &mut made.acceleration,
        &mut made.normal_n,
        &mut made.tangential_n,
    ] {
        scale(samples, by);
    }
}

/// Without its first samples.
fn shifted(made: &mut Made, number: usize) {
    for samples in [
        &mut made.acceleration,
        &mut made.normal_n,
        &mut made.tangential_n,
    ] {
        samples.rotate_left(7 * number);
    }
}

/// The first recording of each sample under every speed.
fn copies_as_speeds(all: &mut [Made], change: fn(&mut Made, usize)) {
    let mut first = all[0].clone();
    for (i, made) in all.iter_mut().enumerate() {
        if made.sample != first.sample {
            first = made.clone();
        }
        let speed_m_s = made.speed_m_s;
        *made = first.clone();
        made.speed_m_s = speed_m_s;
        change(made, i % 3);
    }
}

/// The recordings of sample A as those of B too.
fn copies_as_sample(all: &mut [Made], change: fn(&mut Made, usize)) {
    let first: Vec<Made> = all
        .iter()
        .filter(|made| made.sample == "A")
        .cloned()
        .collect();
    let others = all.iter_mut().filter(|made| made.sample == "B");
    for (made, copy) in others.zip(first) {
        *made = Made {
            sample: "B".into(),
            ..copy
        };
        change(made, 1);
    }
}

/// Every recording three times.
fn repeats(all: &mut Vec<Made>, change: fn(&mut Made, usize)) {
    let once = std::mem::take(all);
    for made in once {
        for number in 0..3 {
            let mut copy = made.clone();
            change(&mut copy, number);
            all.push(copy);
        }
    }
}

/// The finger stays in the air: the noise of the sensors alone.
fn untouched(made: &mut Made, draws: &mut Draws) {
    let Made {
        normal_n,
        tangential_n,
        acceleration,
        ..
    } = made;
    for samples in [normal_n, tangential_n, acceleration] {
        *samples = draws.white(samples.len());
        scale(samples, 0.003);
    }
    made.surface = None;
}

/// What a vibrometer gives, at the level of an acceleration at 100 Hz.
fn velocity(made: &mut Made) {
    let step = std::f64::consts::TAU * 100.0 / RATE_HZ;
    let forget = 1.0 - 0.005;
    let mut sum = 0.0;
    for value in &mut made.acceleration {
        sum = forget * sum + step * *value;
        *value = sum;
    }
}
