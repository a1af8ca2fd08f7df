//! Slow random departures of a hand: Ornstein–Uhlenbeck processes, drawn at a control rate with straight lines
//! between.

use piezotact_bench::random::Random;

/// Control points a second at least, and for the memory of the process.
const CONTROL_HZ: f64 = 200.0;
const CONTROL_PER_MEMORY: f64 = 10.0;

/// A stationary process of mean 0 that forgets exponentially.
#[derive(Clone, Debug)]
pub(crate) struct Wander {
    random: Random,
    spread: f64,
    forget: f64,
    from: f64,
    to: f64,
    at: usize,
    every: usize,
}

impl Wander {
    /// A process of standard deviation `spread` that forgets over `memory_s`, read `rate_hz` times a second.
    pub(crate) fn new(spread: f64, memory_s: f64, rate_hz: f64, mut random: Random) -> Self {
        let control_hz = CONTROL_HZ.max(CONTROL_PER_MEMORY / memory_s).min(rate_hz);
        let every = (rate_hz / control_hz).round().max(1.0) as usize;
        let forget = (-(every as f64) / rate_hz / memory_s).exp();
        let from = spread * random.normal();
        let mut wander = Self {
            random,
            spread,
            forget,
            from,
            to: from,
            at: 0,
            every,
        };
        wander.to = wander.draw();
        wander
    }

    fn draw(&mut self) -> f64 {
        self.forget * self.to
            + self.spread * (1.0 - self.forget * self.forget).sqrt() * self.random.normal()
    }

    pub(crate) fn next(&mut self) -> f64 {
        if self.at == self.every {
            self.at = 0;
            self.from = self.to;
            self.to = self.draw();
        }
        let share = self.at as f64 / self.every as f64;
        self.at += 1;
        self.from + (self.to - self.from) * share
    }
}

/// A process without corners: low-passed twice over with the same memory.
#[derive(Clone, Debug)]
pub(crate) struct SmoothWander {
    wander: Wander,
    state: f64,
    forget: f64,
}

impl SmoothWander {
    /// A process of standard deviation `spread` with two memories of `memory_s`, read `rate_hz` times a second.
    pub(crate) fn new(spread: f64, memory_s: f64, rate_hz: f64, random: Random) -> Self {
        Self {
            // Two equal low-passes leave half the variance of one.
            wander: Wander::new(spread * std::f64::consts::SQRT_2, memory_s, rate_hz, random),
            state: 0.0,
            forget: (-1.0 / (rate_hz * memory_s)).exp(),
        }
    }

    pub(crate) fn next(&mut self) -> f64 {
        self.state = self.forget * self.state + (1.0 - self.forget) * self.wander.next();
        self.state
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As long, with two memories of 0.1 s.
    #[test]
    fn a_smooth_one_has_its_spread_too() {
        let mut wander = SmoothWander::new(1.5, 0.1, 1_000.0, Random::stream(3, 0, "smooth"));
        let x: Vec<f64> = (0..1_000_000).map(|_| wander.next()).collect();
        let found = piezotact::statistics::rms(&x);
        assert!((found / 1.5 - 1.0).abs() < 0.08, "{found}");
    }

    /// 1,000 s with a memory of 0.3 s hold some 1,700 independent values: four standard errors of the standard
    /// deviation are 7 %; straight lines between control points take away 1 %.
    #[test]
    fn it_has_its_spread_and_forgets() {
        let mut wander = Wander::new(0.03, 0.3, 1_000.0, Random::stream(3, 0, "wander"));
        let x: Vec<f64> = (0..1_000_000).map(|_| wander.next()).collect();
        let variance = x.iter().map(|v| v * v).sum::<f64>() / x.len() as f64;
        assert!(
            (variance.sqrt() / 0.03 - 1.0).abs() < 0.08,
            "{}",
            variance.sqrt()
        );
        let after = |lag: usize| {
            x.iter().zip(&x[lag..]).map(|(a, b)| a * b).sum::<f64>() / x.len() as f64 / variance
        };
        assert!((after(300) - (-1f64).exp()).abs() < 0.1, "{}", after(300));
    }
}
