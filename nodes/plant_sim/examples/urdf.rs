//! Prints a vehicle's URDF, as `plant_sim` publishes it:
//!
//! ```sh
//! cargo run -p plant_sim --example urdf brunner > launch-scripts/urdf/brunner.urdf
//! ```

use planesman_vehicle::vehicle_file::{self, VehicleError};

fn main() -> Result<(), VehicleError> {
    let name = std::env::args().nth(1).unwrap_or("brunner".to_owned());
    print!(
        "{}",
        plant_sim::robot_description(&vehicle_file::load(&name)?)
    );
    Ok(())
}
