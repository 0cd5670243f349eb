//! Steps the digital hydraulic actuator to five degrees and prints how its ram follows, volume by volume, and what each two
//! valve cycles take from the supply.
//!
//! ```sh
//! cargo run -p planesman_hydraulics --example ram
//! ```

use planesman_hydraulics::{Demand, Dha, Energy, actuator_file};
use planesman_units::DEGREE;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let set = actuator_file::load("auv")?;
    println!("quantum {:.3} deg", set.quantum / DEGREE);
    println!("time [ms]  planes [deg]  volumes  supply [mJ]  load  throttling  leakage  friction");

    let mut actuator = Dha::new(&set).keeping_energy();
    let mut before = Energy::default();
    for millisecond in (0..=500).step_by(25) {
        let nanos = millisecond * 1_000_000;
        actuator.advance_to(nanos, Demand::angle(5.0 * DEGREE));
        let angle = actuator.plane_angle(&actuator.reading(nanos));
        let energy = actuator.energy().unwrap_or_default();
        let within = energy - before;
        before = energy;
        println!(
            "{millisecond:9}  {:12.3}  {:7}  {:11.3}  {:4.3}  {:10.3}  {:7.3}  {:8.3}",
            angle / DEGREE,
            actuator.pulses(),
            1e3 * within.supply,
            1e3 * within.load(),
            1e3 * within.throttling,
            1e3 * within.leakage,
            1e3 * within.friction,
        );
    }
    Ok(())
}
