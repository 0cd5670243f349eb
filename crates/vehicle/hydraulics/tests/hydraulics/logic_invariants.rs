//! Invariants of the whole actuator under any command: every logic, in either loop, with
//! faults that come and go, on seeded random runs.

use crate::common::{Dice, actuator};
use planesman_hydraulics::{
    ActuatorSet, Condition, Demand, Dha, DriftOption, Encoder, FrictionState, Options, Reading,
    SignChange, Sound, StuckValve, break_away_force,
};
use planesman_units::DEGREE;

const RUNS: u64 = 120;
const TICK: i64 = 50_000_000;
const TICKS: i64 = 30;

fn random_logic(dice: &mut Dice) -> Options {
    Options {
        drift: dice.one_of(&[
            DriftOption::Input,
            DriftOption::Error,
            DriftOption::LastCommand,
        ]),
        error_feedback: dice.one_of(&[0.0, 0.02 * DEGREE]),
        sign_feedback: dice.one_of(&[0.0, 0.01 * DEGREE]),
        sign_change: dice.one_of(&[SignChange::MovesVolume, SignChange::DropsVolume]),
        two_speed: dice.unit() < 0.5,
    }
}

fn random_condition(dice: &mut Dice) -> Condition {
    let sound = Condition::SOUND;
    dice.one_of(&[
        sound,
        sound,
        Condition {
            leakage_scale: 8.0,
            ..sound
        },
        Condition {
            short_volume: 0.3,
            ..sound
        },
        Condition {
            lost_supply: 0.85,
            ..sound
        },
        Condition { air: 0.9, ..sound },
        Condition {
            slow_latch: 0.009,
            stepping: 0.05,
            ..sound
        },
        Condition {
            stuck: Some(StuckValve::Actuating),
            ..sound
        },
        Condition {
            stuck: Some(StuckValve::Direction),
            ..sound
        },
        Condition {
            encoder: Encoder::Lost,
            ..sound
        },
        Condition {
            encoder: Encoder::Frozen,
            ..sound
        },
    ])
}

/// A run: an actuator, and what is asked of it in each tick.
struct Run {
    set: ActuatorSet,
    asked: Vec<Demand>,
}

impl Run {
    fn random(seed: u64) -> Self {
        let mut dice = Dice::new(seed);
        let name = dice.one_of(&["auv", "auv_two_speed", "auv_two_speed", "table_4_1"]);
        let set = actuator(name, dice.unit() < 0.8, dice.unit() < 0.9);
        let (mut logic, mut condition) = (random_logic(&mut dice), Condition::SOUND);
        let (mut position_loop, mut angle) = (true, 0.0);
        let asked = (0..TICKS)
            .map(|_| {
                if dice.unit() < 0.3 {
                    angle = 60.0 * DEGREE * (dice.unit() - 0.5);
                }
                angle += 0.4 * DEGREE * (dice.unit() - 0.5);
                if dice.unit() < 0.1 {
                    logic = random_logic(&mut dice);
                    position_loop = dice.unit() < 0.6;
                }
                if dice.unit() < 0.2 {
                    condition = random_condition(&mut dice);
                }
                Demand {
                    angle,
                    position_loop,
                    logic,
                    condition,
                }
            })
            .collect();
        Self { set, asked }
    }

    /// The readings at the ends of the ticks, each tick run in so many parts.
    fn readings(&self, dha: &mut Dha, parts: i64) -> Vec<Reading> {
        let tick = |(k, demand): (usize, &Demand)| {
            let begin = k as i64 * TICK;
            for part in 1..=parts {
                let nanos = begin + TICK * part / parts;
                dha.advance_to(nanos, *demand);
                std::hint::black_box(dha.reading(nanos));
            }
            dha.reading(begin + TICK)
        };
        self.asked.iter().enumerate().map(tick).collect()
    }
}

#[test]
fn the_run_is_the_same_to_the_last_bit_however_its_ticks_are_divided() {
    for seed in 0..RUNS {
        let run = Run::random(seed);
        let (mut whole, mut parts) = (Dha::new(&run.set), Dha::new(&run.set));
        let once = run.readings(&mut whole, 1);
        assert_eq!(run.readings(&mut parts, 7), once, "{seed}");
        assert_eq!(parts, whole, "{seed}");
    }
}

#[test]
fn asked_for_the_opposite_the_actuator_does_the_opposite_to_the_last_bit() {
    for seed in 0..RUNS {
        let mut run = Run::random(seed);
        // The return bounds the pressure on one side only, where the supply is lost.
        run.set.oil.return_pressure = 0.0;
        let mut opposite = Run {
            set: ActuatorSet {
                error_rate: -run.set.error_rate,
                ..run.set.clone()
            },
            asked: run.asked.clone(),
        };
        for demand in &mut opposite.asked {
            demand.angle = -demand.angle;
        }
        let mut dha = Dha::settled(&run.set, 1);
        let mut mirror = Dha::settled(&opposite.set, -1);
        let originals = run.readings(&mut dha, 2);
        for (original, image) in originals.iter().zip(opposite.readings(&mut mirror, 2)) {
            assert_eq!(image.ram.position, -original.ram.position, "{seed}");
            assert_eq!(image.ram.velocity, -original.ram.velocity, "{seed}");
            assert_eq!(image.ram.volume, -original.ram.volume, "{seed}");
            assert_eq!(image.pressure, -original.pressure, "{seed}");
        }
        assert_eq!(mirror.pulses(), dha.pulses(), "{seed}");
        assert_eq!(mirror.error(), -dha.error(), "{seed}");
    }
}

#[test]
fn the_ram_never_passes_a_stop_nor_the_volume_its_limit() {
    for seed in 0..RUNS {
        let run = Run::random(seed);
        for reading in run.readings(&mut Dha::new(&run.set), 9) {
            assert!(reading.ram.position.abs() <= run.set.stop * (1.0 + 1e-12));
            assert!(reading.ram.volume.abs() <= run.set.volume_limit * (1.0 + 1e-12));
            assert!(reading.ram.velocity.is_finite() && reading.pressure.is_finite());
        }
    }
}

#[test]
fn the_ram_has_travelled_whole_quanta_and_what_leaked_within_the_stiction_band() {
    for seed in 0..RUNS {
        let mut run = Run::random(seed);
        if run.set.cycle() * 4.0 != 0.05 {
            continue; // Where ticks end between cycles, a quantum may be on its way.
        }
        (run.set.stop, run.set.volume_limit) = (f64::INFINITY, f64::INFINITY);
        for demand in &mut run.asked {
            // Volumes as they should be; everything else may ail.
            demand.condition.short_volume = 0.0;
            demand.condition.slow_latch = 0.0;
        }
        let set = &run.set;
        let quantum = set.small.map_or(set.volume, |small| small.volume);
        let most_leakage = 8.0
            * (set.rate_gain
                + set.error_rate.abs()
                + set.pressure_leakage() * set.oil.clamp_positive);
        let readings = run.readings(&mut Dha::new(set), 1);
        for (k, (reading, demand)) in readings.iter().zip(&run.asked).enumerate() {
            let quanta = (reading.ram.volume - reading.leaked) / quantum;
            assert!((quanta - quanta.round()).abs() < 1e-9, "{seed}: {quanta}");
            let seconds = 0.05 * (k + 1) as f64;
            assert!(reading.leaked.abs() <= most_leakage * seconds + 1e-9 * quantum);
            if reading.mode.friction == FrictionState::Stuck && reading.mode.clamped.is_none() {
                let (ram, _) = Sound::new(set).in_condition(&demand.condition);
                let band = break_away_force(&ram) / (set.area * set.area * ram.stiffness);
                let off = reading.ram.position - reading.ram.volume / set.area;
                assert!(off.abs() <= band * (1.0 + 1e-9), "{seed}");
            }
        }
    }
}

#[test]
fn in_precision_mode_changes_of_direction_move_no_volume() {
    for seed in 0..RUNS {
        let mut run = Run::random(seed);
        for (k, demand) in run.asked.iter_mut().enumerate() {
            // Within the dead zone, to and fro.
            demand.angle = if k % 2 == 0 { 0.1 } else { -0.1 } * DEGREE;
            demand.position_loop = true;
            demand.logic = Options::PRECISION;
            demand.condition = Condition::SOUND;
        }
        let mut dha = Dha::new(&run.set);
        run.readings(&mut dha, 1);
        assert!(dha.sign_changes() > 10, "{seed}");
        assert_eq!(dha.pulses(), 0, "{seed}");
    }
}
