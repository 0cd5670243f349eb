//! Steps the digital hydraulic actuator to five degrees and prints how its ram follows, volume by volume.
//!
//! ```sh
//! cargo run -p planesman_hydraulics --example ram
//! ```

use planesman_hydraulics::{Demand, Dha, actuator_file};
use planesman_units::DEGREE;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let set = actuator_file::load("auv")?;
    println!("quantum {:.3} deg", set.quantum / DEGREE);
    println!("time [ms]  planes [deg]  volumes");

    let mut actuator = Dha::new(&set);
    for millisecond in (0..=500).step_by(25) {
        let nanos = millisecond * 1_000_000;
        actuator.advance_to(nanos, Demand::angle(5.0 * DEGREE));
        let angle = actuator.plane_angle(&actuator.reading(nanos));
        println!(
            "{millisecond:9}  {:12.3}  {:7}",
            angle / DEGREE,
            actuator.pulses()
        );
    }
    Ok(())
}
