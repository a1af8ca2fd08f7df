//! One simulated person. The properties of a person are drawn once from a seed and are the same on every bench.

#[cfg(feature = "eeg")]
use super::eeg::Brain;
use super::finger::Finger;
use super::parameters::{Sample, TwinParameters};
use piezotact_bench::random::Random;

/// One person: a finger, its skin, the hand that moves it, and the brain that feels. Perception will be added here.
#[derive(Clone, Debug)]
pub struct Participant {
    /// The number, from 1; 0 is the reference participant, who has every mean.
    pub number: u64,
    /// The seed that draws everybody.
    pub seed: u64,
    /// The mechanical response of the finger.
    pub finger: Finger,
    /// What touches the surface.
    pub skin: Skin,
    /// What moves the finger.
    pub hand: Hand,
    /// What its EEG shows.
    #[cfg(feature = "eeg")]
    pub brain: Brain,
}

/// The skin of one fingertip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Skin {
    /// The distance between ridges, m.
    pub ridge_wavelength_m: f64,
    /// The vibration amplitude re the mean person, a ratio.
    pub loudness: f64,
    /// The friction re the mean person, a ratio.
    pub friction: f64,
}

/// How one person moves and presses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hand {
    /// The actual speed re the requested speed, a ratio.
    pub speed: f64,
    /// The actual force on a sample re the requested force, a ratio; not used on the device and the shaker, where the person sees
    /// the force on a screen.
    pub force: f64,
    /// The speed of free touch, m/s.
    pub free_speed_m_s: f64,
    /// The force of free touch on a surface with a friction coefficient of 0.6, N.
    pub free_force_n: f64,
}

impl Participant {
    /// Participant `number` under `seed`.
    #[must_use]
    pub fn of(number: u64, seed: u64, parameters: &TwinParameters) -> Self {
        let (person, hand) = (&parameters.person, &parameters.hand);
        let finger = Finger::of(parameters, number, seed);
        #[cfg(feature = "eeg")]
        let brain = Brain::of(parameters, number, seed);
        if number == 0 {
            return Self {
                number,
                seed,
                finger,
                skin: Skin {
                    ridge_wavelength_m: person.reference_ridge_m,
                    loudness: 1.0,
                    friction: 1.0,
                },
                hand: Hand {
                    speed: 1.0,
                    force: 1.0,
                    free_speed_m_s: hand.free_speed_m_s,
                    free_force_n: hand.free_force_n,
                },
                #[cfg(feature = "eeg")]
                brain,
            };
        }
        let mut skin = Random::stream(seed, number, "skin");
        let mut moves = Random::stream(seed, number, "hand");
        Self {
            number,
            seed,
            finger,
            skin: Skin {
                ridge_wavelength_m: (person.ridge_m + person.ridge_spread_m * skin.person()).clamp(
                    person.least_ridge_m,
                    person.most_ridge_m.max(person.least_ridge_m),
                ),
                loudness: (person.loudness_spread * skin.person()).exp(),
                friction: (person.friction_spread * skin.person()).exp(),
            },
            hand: Hand {
                speed: 1.0 + hand.speed_bias * moves.person(),
                force: 1.0 + hand.force_bias * moves.person(),
                free_speed_m_s: (hand.free_speed_m_s
                    * (hand.free_speed_spread * moves.person()).exp())
                .clamp(
                    hand.least_free_speed_m_s,
                    hand.most_free_speed_m_s.max(hand.least_free_speed_m_s),
                ),
                free_force_n: hand.free_force_n * (hand.free_force_spread * moves.person()).exp(),
            },
            #[cfg(feature = "eeg")]
            brain,
        }
    }

    /// The pseudonym.
    #[must_use]
    pub fn pseudonym(&self) -> String {
        format!("P{:02}", self.number)
    }

    /// The stream `name` of this person.
    pub(crate) fn random(&self, name: &str) -> Random {
        Random::stream(self.seed, self.number, name)
    }

    /// The vibration amplitude of `sample` for this person, m/s² rms at 30 mm/s and 0.2 N.
    #[must_use]
    pub fn level_m_s2(&self, sample: &Sample) -> f64 {
        let own = match self.number {
            0 => 1.0,
            _ => {
                let mut random = self.random(&format!("level of {}", sample.name));
                (sample.loudness_spread * random.person()).exp()
            }
        };
        sample.rms_m_s2 * self.skin.loudness * own
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reference_has_every_mean_and_people_differ() {
        let parameters = TwinParameters::built_in();
        let reference = Participant::of(0, 5, &parameters);
        let s1 = parameters.sample("S1").unwrap();
        assert!((reference.skin.ridge_wavelength_m - 0.545e-3).abs() < 1e-12);
        assert!((reference.level_m_s2(s1) - 2.0).abs() < 1e-12);
        let (one, again, two) = (
            Participant::of(1, 5, &parameters),
            Participant::of(1, 5, &parameters),
            Participant::of(2, 5, &parameters),
        );
        assert_eq!((one.skin, one.hand), (again.skin, again.hand));
        assert!(one.skin != two.skin && one.hand != two.hand);
        assert!((one.level_m_s2(s1) - two.level_m_s2(s1)).abs() > 1e-3);
    }

    /// Two hundred people: the mean ridge within 4 standard errors (0.06/√200 = 4.2 µm), all within the population.
    #[test]
    fn ridges_are_those_of_the_population() {
        let parameters = TwinParameters::built_in();
        let ridges: Vec<f64> = (1..=200)
            .map(|n| Participant::of(n, 1, &parameters).skin.ridge_wavelength_m)
            .collect();
        let mean = piezotact::statistics::mean(&ridges);
        assert!((mean - 0.46e-3).abs() < 17e-6, "{mean}");
        assert!(ridges.iter().all(|r| (0.35e-3..=0.60e-3).contains(r)));
    }
}
