//! Invariants under any sequence of pulses, with any fault, on seeded random runs.

mod energy;

use crate::common::{Bench, Dice, SETS, actuator, random_bench, random_commands, random_condition};
use planesman_hydraulics::{ActuatorSet, Condition, FrictionState, break_away_force};
use planesman_units::INCH;

const RUNS: u64 = 160;

#[test]
fn pressure_volume_and_ram_keep_their_limits() {
    for seed in 0..RUNS {
        let (mut bench, _, mut dice) = random_bench(seed);
        let set = bench.set.clone();
        let ram = bench.constants();
        let mut t = 0.0;
        while t < 0.8 {
            let reading = bench.reading(t);
            assert!(reading.pressure <= ram.clamp_positive, "{seed}");
            assert!(reading.pressure >= -ram.clamp_negative, "{seed}");
            assert!(
                reading.ram.volume.abs() <= set.volume_limit * (1.0 + 1e-12),
                "{seed}"
            );
            assert!(
                reading.ram.position.abs() <= set.stop * (1.0 + 1e-12),
                "{seed}"
            );
            assert!(reading.ram.velocity.is_finite(), "{seed}");
            t += 0.003 * dice.unit();
        }
    }
}

#[test]
fn from_rest_the_speed_stays_within_what_force_and_friction_allow() {
    for seed in 0..RUNS {
        let (mut bench, _, mut dice) = random_bench(seed);
        let set = bench.set.clone();
        if set.load.coulomb == 0.0 {
            continue;
        }
        let ram = bench.constants();
        // (P_m A_L - Delta F)/C; none where friction holds against all the pressure there is.
        let limit =
            |clamp: f64| ((clamp * set.area - set.load.coulomb) / set.load.viscous).max(0.0);
        let (plus, minus) = (limit(ram.clamp_positive), -limit(ram.clamp_negative));
        let mut t = 0.0;
        while t < 0.8 {
            let speed = bench.reading(t).ram.velocity;
            assert!(speed <= plus * (1.0 + 1e-9), "{seed}: {speed} {plus}");
            assert!(speed >= minus * (1.0 + 1e-9), "{seed}: {speed} {minus}");
            t += 0.003 * dice.unit();
        }
    }
}

#[test]
fn the_volume_balance_closes() {
    for seed in 0..RUNS {
        let (bench, commands, _) = random_bench(seed);
        // What the volume limit refuses is not in the sum.
        let set = ActuatorSet {
            volume_limit: f64::INFINITY,
            stop: f64::INFINITY,
            ..bench.set
        };
        let condition = bench.condition;
        let mut bench = Bench::worn(set.clone(), condition, 1, &commands);
        let (ram, leakages) = (bench.constants(), bench.leakages());
        // V_T = sum of quanta + integral of (d q_L + q_LC - k P_d).
        let (step, end) = (2e-5, 0.4);
        let mut lost = 0.0;
        let mut before = bench.reading(0.0);
        for i in 1..=(end / step) as usize {
            let reading = bench.reading(i as f64 * step);
            let drift = f64::from(reading.polarity) * leakages.rate_gain + leakages.error_rate;
            let pressure = 0.5 * (before.pressure + reading.pressure);
            lost += (ram.leakage * pressure - drift) * step;
            before = reading;
        }
        let error = before.leaked + lost;
        // Only the trapezoids are approximate, and those around a change of polarity.
        let allowed = if set.rate_gain == 0.0 { 1e-12 } else { 5e-3 };
        assert!(
            error.abs() <= allowed * set.volume,
            "{seed}: {}",
            error / set.volume
        );
    }
}

#[test]
fn at_rest_the_ram_is_within_the_stiction_band_of_its_volume() {
    for seed in 0..RUNS {
        let (mut bench, _, _) = random_bench(seed);
        let set = bench.set.clone();
        let ram = bench.constants();
        for i in 0..100 {
            let reading = bench.reading(f64::from(i) * 0.01);
            // What the auxiliary pistons hold back is delivered later.
            if reading.mode.friction == FrictionState::Stuck && reading.mode.clamped.is_none() {
                let stiffness = set.area * set.area * ram.stiffness;
                let band = break_away_force(&ram) / stiffness;
                let off = reading.ram.position - reading.ram.volume / set.area;
                assert!(off.abs() <= band * (1.0 + 1e-9), "{seed}");
            }
        }
    }
}

#[test]
fn without_leakage_and_friction_n_quanta_end_exactly_n_quanta_away() {
    for seed in 0..60 {
        let name = SETS[(seed % 3) as usize];
        let set = actuator(name, false, false);
        let commands = random_commands(&mut Dice::new(seed), 40);
        let quanta: i32 = commands.iter().map(|c| i32::from(*c)).sum();
        let expected = f64::from(quanta) * set.ram_quantum();
        let mut bench = Bench::new(set, &commands);
        let found = bench.reading(6.0).ram.position;
        assert!((found - expected).abs() / INCH <= 1e-13, "{name} {seed}");
    }
}

#[test]
fn one_quantum_out_and_one_back_leave_no_volume_behind() {
    for name in SETS {
        for apart in [1, 2, 12] {
            let mut commands = vec![0; apart + 1];
            (commands[0], commands[apart]) = (1, -1);
            let mut bench = Bench::new(actuator(name, false, true), &commands);
            let reading = bench.reading(2.0);
            assert!(reading.ram.volume.abs() < 1e-14 * bench.set.volume);
            assert!(reading.ram.position.abs() <= bench.set.stiction_band() * (1.0 + 1e-9));
        }
    }
}

#[test]
fn friction_only_takes_energy_and_the_energy_balance_closes() {
    let ill = Condition {
        air: 0.6,
        slow_latch: 0.007,
        lost_supply: 0.1,
        ..Condition::SOUND
    };
    for (name, condition) in SETS
        .iter()
        .flat_map(|name| [(*name, Condition::SOUND), (*name, ill)])
    {
        let set = actuator(name, true, true);
        let commands = random_commands(&mut Dice::new(7), 20);
        let mut bench = Bench::worn(set.clone(), condition, 1, &commands);
        // Midpoints of short steps: work by the pressure, and against C.
        let step = 2e-6;
        let (mut fluid, mut viscous, mut slid) = (0.0, 0.0, 0.0);
        for i in 0..150_000 {
            let t = (f64::from(i) + 0.5) * step;
            let reading = bench.reading(t);
            let v = reading.ram.velocity;
            fluid += set.area * reading.pressure * v * step;
            viscous += set.load.viscous * v * v * step;
            let slid_now = bench.slid(t);
            assert!(slid_now >= slid);
            slid = slid_now;
        }
        let v = bench.reading(0.3).ram.velocity;
        let kinetic = 0.5 * set.load.mass * v * v;
        let friction = set.load.coulomb * bench.slid(0.3);
        let gap = fluid - (kinetic + viscous + friction);
        assert!(gap.abs() < 1e-6 * fluid, "{name}: {}", gap / fluid);
    }
}

/// Equal force in both directions.
fn symmetric(name: &str) -> ActuatorSet {
    let mut set = actuator(name, true, true);
    set.oil.clamp_negative = set.oil.clamp_positive;
    set
}

#[test]
fn the_mirrored_run_is_the_mirror_image_to_the_last_bit() {
    for seed in 0..RUNS {
        let mut dice = Dice::new(seed);
        let name = SETS[(seed % 3) as usize];
        let mut set = symmetric(name);
        // The return bounds the pressure on one side only, where the supply is lost.
        set.oil.return_pressure = 0.0;
        if dice.unit() < 0.5 {
            set.volume_limit = set.volume * 5.3;
            set.stop = set.ram_quantum() * 5.1;
        }
        let mirrored_set = ActuatorSet {
            error_rate: -set.error_rate,
            ..set.clone()
        };
        let commands = random_commands(&mut dice, 40);
        let condition = random_condition(&mut dice);
        let mirrored_commands: Vec<i8> = commands.iter().map(|c| -c).collect();
        let mut bench = Bench::worn(set, condition, 1, &commands);
        let mut mirror = Bench::worn(mirrored_set, condition, -1, &mirrored_commands);
        let mut t = 0.0;
        while t < 0.7 {
            let (image, original) = (mirror.reading(t), bench.reading(t));
            assert_eq!(image.ram.position, -original.ram.position, "{seed} at {t}");
            assert_eq!(image.ram.velocity, -original.ram.velocity, "{seed} at {t}");
            assert_eq!(image.ram.volume, -original.ram.volume, "{seed} at {t}");
            assert_eq!(image.pressure, -original.pressure, "{seed} at {t}");
            t += 0.004 * dice.unit();
        }
    }
}

#[test]
fn the_run_is_the_same_to_the_last_bit_however_often_it_is_looked_at() {
    for seed in 0..RUNS {
        let (mut often, commands, mut dice) = random_bench(seed);
        let mut seldom = Bench::worn(often.set.clone(), often.condition, 1, &commands);
        let mut t = 0.0;
        while t < 0.7 {
            t += 0.05 * dice.unit();
            for i in 1..8 {
                often.reading(t - 0.006 / f64::from(i * i));
            }
            assert_eq!(often.reading(t), seldom.reading(t), "{seed} at {t}");
        }
    }
}
