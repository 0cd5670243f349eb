//! The time to simulate a circuit of on/off valves.
//!
//! ```text
//! cargo bench -p planesman_circuit --bench schedule     the circuit alone
//! benches/peers/run --only circuit                      beside scipy with events
//! ```
//!
//! The built-in circuit, its travel shortened to 40 mm so that it meets its stops, under six commands to its valves in 0.6 s; then the
//! same under its controller over a load cycle. Times are the best of several rounds.

use std::{hint::black_box, sync::Arc, time::Instant};

use planesman_circuit::{
    Circuit, ElasticStop, LoadCycle, MOST_EDGES, Point, Simulation, file, run,
};

const ROUNDS: usize = 20;

/// Times, s, and the masks of P-A, A-T, P-B, B-T.
const COMMANDS: [(f64, [u32; 4]); 6] = [
    (0.0, [31, 0, 0, 31]),
    (0.06, [9, 0, 0, 5]),
    (0.15, [0, 0, 0, 0]),
    (0.22, [0, 20, 17, 0]),
    (0.34, [0, 31, 31, 0]),
    (0.5, [3, 0, 0, 2]),
];

/// The shortest of some rounds, us.
fn best(mut work: impl FnMut()) -> f64 {
    let round = |_| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64() * 1e6
    };
    (0..ROUNDS).map(round).fold(f64::INFINITY, f64::min)
}

/// The state after 0.6 s.
fn commanded(circuit: &Arc<Circuit>, accuracy: f64) -> [f64; 4] {
    let mut simulation = Simulation::new(Arc::clone(circuit), accuracy, 0.02, 500.0, 1);
    let place = |name: &str| {
        (0..4)
            .find(|edge| circuit.edge_name(*edge) == name)
            .unwrap_or(0)
    };
    let order = ["P-A", "A-T", "P-B", "B-T"].map(place);
    for (time, written) in COMMANDS {
        let mut masks = [0; MOST_EDGES];
        for (edge, mask) in order.into_iter().zip(written) {
            masks[edge] = mask;
        }
        simulation.command(time, &masks);
    }
    simulation.advance(0.6, 1.0);
    simulation.at(0.6)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = file::parse(file::BUILT_IN[0].1)?;
    let mut short = file.clone();
    short.valves.scatter = 0.0;
    short.load.travel = 0.04;
    let mut elastic = short.clone();
    elastic.load.spring = 2000.0;
    elastic.load.elastic_stop = Some(ElasticStop {
        stiffness: 5e6,
        damping: 2.0,
    });
    for (name, circuit) in [("rigid", short), ("elastic", elastic)] {
        let circuit = Arc::new(circuit);
        for accuracy in [1e-12, 1e-8] {
            let time = best(|| {
                black_box(commanded(black_box(&circuit), accuracy));
            });
            let [x, ..] = commanded(&circuit, accuracy);
            println!(
                "{name} at {accuracy:e}: 0.6 s in {time:.1} us, x = {:.12} m",
                x
            );
        }
    }
    let circuit = Arc::new(file);
    let point = |time, position| Point {
        time,
        position,
        force: 500.0,
    };
    let cycle = LoadCycle::new(vec![point(0.0, -0.1), point(5.0, 0.1), point(10.0, -0.1)])?;
    let time = best(|| {
        black_box(run(black_box(&circuit), &cycle, 1e-6, 1, |_, _| ()));
    });
    println!("under its controller: 10 s in {:.2} ms", time / 1e3);
    Ok(())
}
