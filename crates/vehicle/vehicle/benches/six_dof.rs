//! A manoeuvre of 60 s by vehicles of six degrees of freedom: one to an accuracy, many at a fixed step.
//!
//! ```text
//! cargo bench -p planesman_vehicle --bench six_dof      ours alone
//! benches/peers/run --only six_dof                      beside scipy, numpy and C++
//! ```
//!
//! There is a steady current, and the inputs jump every 10 s. Errors are the largest of any number of the state at those times, relative where it is above 1, beside our own run at
//! 1e-13. Many vehicles begin with a speed each of their own and are measured by processor time: what else the machine does takes none of it.

#![allow(clippy::unwrap_used)]

use std::time::Instant;

use planesman_vehicle::six_dof::{
    Accurate, Batch, Sea, Simulation, State, Vehicle, Water, load, rotation,
};

/// \[s\]
const SEGMENT: f64 = 10.0;
const STEP: f64 = 0.02;
const STEPS: u32 = 500;
/// North, east, down \[m/s\].
const CURRENT: [f64; 3] = [0.1, 0.2, 0.0];
const COUNT: usize = 1024;
/// Whose states are looked at.
const SEEN: [usize; 3] = [0, 511, 1023];

/// Inputs of each segment.
type Manoeuvre = Vec<Vec<f64>>;

/// States at the end of each segment.
type Way = Vec<[f64; 13]>;

fn problems() -> [(&'static str, Manoeuvre); 2] {
    let lauv = [
        [0.0, 0.0, 9.0],
        [0.15, 0.0, 9.0],
        [-0.15, 0.1, 9.0],
        [0.0, -0.1, 12.0],
        [0.2, 0.05, 6.0],
        [0.0, 0.0, 9.0],
    ];
    let bluerov = [
        [0.15, 0.15, -0.15, -0.15, 0.05, 0.05, 0.05, 0.05],
        [0.15, 0.1, -0.1, -0.15, 0.05, 0.05, 0.05, 0.05],
        [0.1, 0.15, -0.15, -0.1, -0.05, -0.05, -0.05, -0.05],
        [0.15, -0.1, -0.1, 0.15, 0.1, 0.05, 0.05, 0.1],
        [-0.1, -0.1, 0.1, 0.1, 0.0, 0.0, 0.0, 0.0],
        [0.0; 8],
    ];
    [
        ("lauv", lauv.map(Vec::from).into()),
        ("bluerov2_heavy", bluerov.map(Vec::from).into()),
    ]
}

fn start(k: usize) -> State {
    State {
        position: [0.0, 0.0, 5.0],
        attitude: rotation::from_euler([0.05, -0.02, 0.3]),
        velocity: [0.5 + k as f64 / COUNT as f64, 0.05, 0.0, 0.0, 0.0, 0.0],
    }
}

fn adaptive(vehicle: &Vehicle, manoeuvre: &Manoeuvre, k: usize, accuracy: f64) -> Way {
    let sea = Sea {
        current: CURRENT,
        ..Sea::default()
    };
    let accuracy = Accurate {
        relative: accuracy,
        absolute: accuracy,
    };
    let mut one = Simulation::new(vehicle, &sea, start(k), accuracy);
    let ends = manoeuvre.iter().zip(1..).map(|(inputs, segment)| {
        one.advance(SEGMENT * f64::from(segment), inputs).unwrap();
        one.state.row()
    });
    ends.collect()
}

/// Time of this thread on a processor so far \[s\].
fn processor_time() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap();
    text.split(' ').next().unwrap().parse::<f64>().unwrap() / 1e9
}

/// The ways of those of `SEEN`, and the processor time of all vehicles on all threads \[s\].
fn fixed_step(vehicle: &Vehicle, manoeuvre: &Manoeuvre, threads: usize) -> ([Way; 3], f64) {
    let starts: Vec<State> = (0..COUNT).map(start).collect();
    let size = COUNT.div_ceil(threads);
    let fly = |part: &mut Batch<'_>| {
        let begun = processor_time();
        let mut ends = Vec::new();
        for inputs in manoeuvre {
            (0..part.len()).for_each(|k| part.set_inputs(k, inputs));
            part.advance(STEPS, STEP);
            ends.push((0..part.len()).map(|k| part.state(k).row()).collect());
        }
        (ends, processor_time() - begun)
    };
    let mut all = Batch::new(vehicle, &starts);
    (0..COUNT).for_each(|k| all.set_water(k, &Water::steady(CURRENT)));
    let parts = all.split(size);
    let flown: Vec<(Vec<Vec<[f64; 13]>>, f64)> = std::thread::scope(|scope| {
        let flying: Vec<_> = parts
            .into_iter()
            .map(|mut part| scope.spawn(move || fly(&mut part)))
            .collect();
        flying.into_iter().map(|one| one.join().unwrap()).collect()
    });
    let seen = SEEN.map(|k| flown[k / size].0.iter().map(|all| all[k % size]).collect());
    (seen, flown.iter().map(|(_, time)| time).sum())
}

fn error(found: &Way, truth: &Way) -> f64 {
    let pairs = found.iter().flatten().zip(truth.iter().flatten());
    pairs
        .map(|(a, b)| (a - b).abs() / b.abs().max(1.0))
        .fold(0.0, f64::max)
}

fn main() {
    // For whoever compares them with a program of its own.
    let with_states = std::env::args().any(|argument| argument == "--states");
    for (name, manoeuvre) in problems() {
        let vehicle = load(name).unwrap();
        let truths = SEEN.map(|k| adaptive(&vehicle, &manoeuvre, k, 1e-13));
        let mut shortest = f64::INFINITY;
        let mut found = Way::new();
        for _ in 0..200 {
            let begun = Instant::now();
            found = adaptive(&vehicle, &manoeuvre, 0, 1e-10);
            shortest = shortest.min(begun.elapsed().as_secs_f64());
        }
        println!(
            "{name}, one vehicle at 1e-10: {:.4} ms, error {:.1e}",
            shortest * 1e3,
            error(&found, &truths[0])
        );
        if with_states {
            println!("{name}, one vehicle at 1e-10, states: {found:?}");
            println!("{name}, one vehicle at 1e-13, states: {:?}", truths[0]);
        }
        for threads in [1, 2] {
            let mut shortest = f64::INFINITY;
            let mut ways = Default::default();
            for _ in 0..3 {
                let (seen, time) = fixed_step(&vehicle, &manoeuvre, threads);
                (ways, shortest) = (seen, shortest.min(time));
            }
            let steps = COUNT as f64 * f64::from(STEPS) * manoeuvre.len() as f64;
            let worst = ways
                .iter()
                .zip(&truths)
                .map(|(way, truth)| error(way, truth));
            println!(
                "{name}, {COUNT} vehicles on {threads} threads: {:.1} ns of CPU a step of a vehicle, {:.2} million a CPU second, error {:.1e}",
                shortest / steps * 1e9,
                steps / shortest / 1e6,
                worst.fold(0.0, f64::max)
            );
            if with_states {
                println!("{name}, {COUNT} vehicles on {threads} threads, states: {ways:?}");
            }
        }
    }
}
