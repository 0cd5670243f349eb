//! Dives the thesis' vehicle at one foot per second by holding its planes at ten degrees, and prints the motion.
//!
//! ```sh
//! cargo run -p planesman_vehicle --example dive
//! ```

use planesman_units::{DEGREE, FOOT};
use planesman_vehicle::{Environment, Motion, PlanePath, Restoring, State, vehicle_file};

/// A tick, s; the longest step of the integration.
const TICK: f64 = 0.05;
const TICK_NANOS: i64 = 50_000_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let vehicle = vehicle_file::load("brunner")?;
    let motion = Motion {
        derivatives: vehicle.derivatives(FOOT),
        restoring: Restoring::Sine,
        environment: Environment {
            density: 999.835,
            gravity: 9.81456,
            atmospheric_pressure: 101_325.0,
        },
        step: TICK,
    };
    // The plane angle at the start and the end of a tick.
    let angles = [10.0 * DEGREE; 2];
    let planes = PlanePath::new(&angles, TICK_NANOS, TICK_NANOS)?;

    let mut state = State {
        depth: 1.0,
        ..State::default()
    };
    println!("time [s]  depth [m]  pitch [deg]");
    for tick in 0..=200_u32 {
        if tick % 20 == 0 {
            let time = f64::from(tick) * TICK;
            println!(
                "{time:8.1}  {:9.3}  {:11.2}",
                state.depth,
                state.pitch / DEGREE
            );
        }
        state = motion.advance(&state, &planes, 1)?;
    }
    Ok(())
}
