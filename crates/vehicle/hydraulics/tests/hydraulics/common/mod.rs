//! A bench for the hydraulics: pulse commands in, the report's units (in, lb, s) out.

use planesman_hydraulics::actuator_file::load;
use planesman_hydraulics::{
    ActuatorSet, Condition, Constants, Energy, Leakages, PulseTrain, Reading, Sound, StuckValve,
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
        set.load.coulomb = 0.0;
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

    /// Like [`Bench::new`], the sign valve at `sign` from before the start.
    pub(crate) fn settled(set: ActuatorSet, sign: i8, commands: &[i8]) -> Self {
        Self::worn(set, Condition::SOUND, sign, commands)
    }

    /// Like [`Bench::settled`], the actuator in `condition`.
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

pub(crate) const SETS: [&str; 3] = ["table_3_1", "table_4_1", "auv"];

/// A condition that half of the time is sound, each of the ram's faults in it or not.
pub(crate) fn random_condition(dice: &mut Dice) -> Condition {
    let mut condition = Condition::SOUND;
    if dice.unit() < 0.5 {
        return condition;
    }
    let mut share = |most: f64| {
        let drawn = dice.unit();
        if drawn < 0.5 {
            0.0
        } else {
            most * (2.0 * drawn - 1.0)
        }
    };
    condition.leakage_scale += share(5.0);
    condition.stepping = share(0.1);
    condition.short_volume = share(0.5);
    condition.lost_supply = share(0.9);
    condition.air = share(0.95);
    condition.slow_latch = share(0.02);
    condition.stuck = match (dice.unit() * 6.0) as u32 {
        0 => Some(StuckValve::Actuating),
        1 => Some(StuckValve::Direction),
        _ => None,
    };
    condition
}

/// Runs of equal commands of random length, as a loop sends them.
pub(crate) fn random_commands(dice: &mut Dice, cycles: usize) -> Vec<i8> {
    let mut commands = Vec::new();
    while commands.len() < cycles {
        let command = dice.one_of(&[1, 0, -1]);
        let length = 1 + (dice.unit() * dice.unit() * 12.0) as usize;
        commands.extend(std::iter::repeat_n(command, length));
    }
    commands.truncate(cycles);
    commands
}

/// A random bench: any set, with or without leakage and friction, a few constants varied, in any
/// condition.
pub(crate) fn random_bench(seed: u64) -> (Bench, Vec<i8>, Dice) {
    let mut dice = Dice::new(seed);
    let name = SETS[(seed % 3) as usize];
    let mut set = actuator(name, dice.unit() < 0.7, dice.unit() < 0.8);
    set.load.viscous *= 0.3 + 2.0 * dice.unit();
    set.oil.stiffness *= 0.5 + dice.unit();
    set.extra_delay = if dice.unit() < 0.5 {
        0.0
    } else {
        0.02 * dice.unit()
    };
    if dice.unit() < 0.5 {
        set.volume_limit = set.volume * (2.0 + 6.0 * dice.unit());
        set.stop = set.volume_limit / set.area * (0.9 + 0.2 * dice.unit());
    }
    let commands = random_commands(&mut dice, 40);
    let condition = random_condition(&mut dice);
    let bench = Bench::worn(set, condition, 1, &commands);
    (bench, commands, dice)
}
