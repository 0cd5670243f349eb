//! The time to simulate one second of the actuator.
//!
//! ```text
//! cargo bench -p planesman_hydraulics --bench second     the actuator alone
//! benches/peers/run --only actuator                      beside scipy with events
//! ```
//!
//! Three loads on each built-in actuator: the hydraulics slewing, with a volume in every cycle
//! and the direction changed every 20; the whole actuator in its position loop under a square
//! wave of +-10 degrees at 2 Hz, its plane angle read every millisecond, as `plane_motion` samples
//! it; and the whole actuator holding 5 degrees, read every tick of 50 ms. Then the last two keeping their energies, read
//! every tick. Times are per second
//! of actuator, the best of several rounds: what else the machine does only ever adds.

use std::{hint::black_box, time::Instant};

use planesman_hydraulics::actuator_file::{BUILT_IN, load};
use planesman_hydraulics::{ActuatorSet, Command, Demand, Dha, Hydraulics, Volume};
use planesman_units::{DEGREE, INCH};

const ROUNDS: usize = 20;
const SECONDS: u32 = 20;

/// The shortest of some rounds, in microseconds for each second simulated.
fn best(mut work: impl FnMut()) -> f64 {
    let shortest = (0..ROUNDS)
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64()
        })
        .fold(f64::INFINITY, f64::min);
    shortest / f64::from(SECONDS) * 1e6
}

/// X_1, m, after so many cycles with a volume each.
fn slew(set: &ActuatorSet, cycles: u32) -> f64 {
    let mut hydraulics = Hydraulics::new(set);
    for n in 0..cycles {
        let sign = if (n + 10) % 40 < 20 { 1 } else { -1 };
        hydraulics.begin_cycle(Command {
            volume: Volume::Large,
            sign,
        });
    }
    hydraulics.finish_cycle();
    hydraulics.reading(set.cycle()).ram.position
}

/// Follows `angle`, rad at a time in s, and reads the plane every `every` milliseconds.
fn follow(mut dha: Dha, angle: impl Fn(f64) -> f64, every: i64) -> u64 {
    const TICK: i64 = 50;
    for tick in 0..i64::from(SECONDS) * 1000 / TICK {
        let demand = Demand::angle(angle((tick * TICK) as f64 * 1e-3));
        for sample in 1..=TICK / every {
            let nanos = (tick * TICK + sample * every) * 1_000_000;
            dha.advance_to(nanos, demand);
            black_box(dha.plane_angle(&dha.reading(nanos)));
        }
        black_box(dha.energy());
    }
    dha.pulses()
}

fn square(t: f64) -> f64 {
    let half = if (2.0 * t).fract() < 0.5 { 1.0 } else { -1.0 };
    10.0 * half * DEGREE
}

fn main() {
    for (name, _) in BUILT_IN {
        let set = match load(name) {
            Ok(set) => set,
            Err(error) => {
                eprintln!("{error}");
                return;
            }
        };
        let cycles = |seconds: u32| set.frequency_millihertz * seconds / 1000;
        let slewing = best(|| {
            black_box(slew(black_box(&set), cycles(SECONDS)));
        });
        let dha = Dha::new(&set);
        let [following, with_energy] = [dha, dha.keeping_energy()].map(|dha| {
            best(|| {
                black_box(follow(black_box(dha), square, 1));
            })
        });
        let [holding, holding_with_energy] = [dha, dha.keeping_energy()].map(|dha| {
            best(|| {
                black_box(follow(black_box(dha), |_| 5.0 * DEGREE, 50));
            })
        });
        println!(
            "{name}: hydraulics slewing {slewing:.1} us, whole actuator slewing and read at 1 kHz {following:.1} us, holding {holding:.1} us"
        );
        println!(
            "{name}: with energies, slewing {with_energy:.1} us, holding {holding_with_energy:.1} us"
        );
        println!(
            "{name}: after {} cycles of slewing X_1 = {:.9} in",
            cycles(1),
            slew(&set, cycles(1)) / INCH
        );
    }
}
