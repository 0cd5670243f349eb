//! A bench for the hydraulics: pulse commands in, the report's units (in, lb, s) out.
#![allow(dead_code)] // each test file uses its part

use planesman_hydraulics::actuator_file::load;
use planesman_hydraulics::{
    ActuatorSet, Condition, Constants, Energy, Leakages, PulseTrain, Reading, Sound,
};
use planesman_units::{INCH, PSI};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

/// Cubic metres in a cubic inch.
pub(crate) const CUBIC_INCH: f64 = INCH * INCH * INCH;

/// Seeded choices.
pub(crate) struct Dice(Pcg64);

impl Dice {
    pub(crate) fn new(seed: u64) -> Self {
        Self(Pcg64::seed_from_u64(seed))
    }

    /// Uniform in [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(crate) fn one_of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[(self.unit() * choices.len() as f64) as usize]
    }
}

/// One instant, in inches, pounds and seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Instant {
    pub(crate) position: f64,
    pub(crate) velocity: f64,
    pub(crate) pressure: f64,
    pub(crate) volume: f64,
}

/// The built-in actuator, without leakage or friction where asked.
pub(crate) fn actuator(name: &str, leakage: bool, friction: bool) -> ActuatorSet {
    let mut set = load(name).expect("built in");
    if !leakage {
        (set.rate_gain, set.error_rate) = (0.0, 0.0);
    }
    if !friction {
        set.coulomb = 0.0;
    }
    set
}

/// Runs one command per cycle from t = 0, then none.
pub(crate) struct Bench {
    pub(crate) set: ActuatorSet,
    pub(crate) condition: Condition,
    train: PulseTrain,
}

impl Bench {
    pub(crate) fn new(set: ActuatorSet, commands: &[i8]) -> Self {
        Self::settled(set, 1, commands)
    }

    /// As [`Bench::new`], the sign valve at `sign` from before the start.
    pub(crate) fn settled(set: ActuatorSet, sign: i8, commands: &[i8]) -> Self {
        Self::worn(set, Condition::SOUND, sign, commands)
    }

    /// As [`Bench::settled`], the actuator in `condition`.
    pub(crate) fn worn(set: ActuatorSet, condition: Condition, sign: i8, commands: &[i8]) -> Self {
        Self {
            train: PulseTrain::worn(&set, condition, sign, commands),
            set,
            condition,
        }
    }

    /// The ram's constants in the bench's condition.
    pub(crate) fn constants(&self) -> Constants {
        Sound::new(&self.set).in_condition(&self.condition).0
    }

    /// The leakages in the bench's condition.
    pub(crate) fn leakages(&self) -> Leakages {
        Sound::new(&self.set).in_condition(&self.condition).1
    }

    /// The reading at `t`, s; times must not go back.
    pub(crate) fn reading(&mut self, t: f64) -> Reading {
        self.train.at(t)
    }

    /// The energies up to `t`, s; times must not go back.
    pub(crate) fn energy(&mut self, t: f64) -> Energy {
        self.train.energy(t)
    }

    /// The distance the load has slid against friction up to `t`, m; times must not go back.
    pub(crate) fn slid(&mut self, t: f64) -> f64 {
        self.train.slid(t)
    }

    /// The instant at `t`, s, in the report's units.
    pub(crate) fn at(&mut self, t: f64) -> Instant {
        let reading = self.reading(t);
        Instant {
            position: reading.ram.position / INCH,
            velocity: reading.ram.velocity / INCH,
            pressure: reading.pressure / PSI,
            volume: reading.ram.volume / CUBIC_INCH,
        }
    }
}
