//! Steps of many vehicles of six degrees of freedom a second, with the error of the step:
//!
//!     cargo bench -p planesman_vehicle --bench six_dof

use planesman_vehicle::six_dof::{Accurate, Batch, Sea, Simulation, State, load, rotation};

/// Time on a processor so far \[s\]: what else the machine does takes none of it.
fn processor_time() -> f64 {
    let text = std::fs::read_to_string("/proc/self/schedstat").unwrap();
    text.split(' ').next().unwrap().parse::<f64>().unwrap() / 1e9
}

fn main() {
    for (name, inputs) in [
        ("lauv", vec![0.1, 0.03, 9.0]),
        ("remus_100_printed", vec![0.1, -0.2]),
        (
            "bluerov2_heavy",
            vec![0.3, 0.35, -0.2, -0.25, 0.05, 0.05, 0.0, 0.0],
        ),
    ] {
        let vehicle = load(name).unwrap();
        let start = State {
            position: [0.0, 0.0, 5.0],
            attitude: rotation::from_euler([0.05, -0.02, 0.3]),
            velocity: [0.5, 0.05, 0.0, 0.0, 0.0, 0.0],
        };
        let sea = Sea::default();
        let mut exact = Simulation::new(
            &vehicle,
            &sea,
            start,
            Accurate {
                relative: 1e-13,
                absolute: 1e-13,
            },
        );
        exact.advance(60.0, &inputs).unwrap();
        let count = 1024;
        for (dt, steps) in [(0.02, 3000), (0.01, 6000), (0.005, 12000)] {
            let mut one = Batch::new(&vehicle, &[start]);
            one.set_inputs(0, &inputs);
            one.advance(steps, dt);
            let (found, truth) = (one.state(0).row(), exact.state.row());
            let error = found
                .iter()
                .zip(truth)
                .map(|(a, b)| (a - b).abs() / b.abs().max(1.0))
                .fold(0.0, f64::max);
            let mut batch = Batch::new(&vehicle, &vec![start; count]);
            (0..count).for_each(|k| batch.set_inputs(k, &inputs));
            let begun = processor_time();
            batch.advance(200, dt);
            let rate = 200.0 * count as f64 / (processor_time() - begun);
            println!(
                "{name}: dt {dt}: {:.2} million steps/s on one core, error after 60 s {error:.1e}",
                rate / 1e6
            );
        }
    }
}
