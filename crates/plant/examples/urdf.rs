//! Prints a vehicle's URDF, as `plant_sim` publishes it:
//!
//! ```sh
//! cargo run -p planesman_plant --example urdf brunner > launch-scripts/urdf/brunner.urdf
//! ```

use planesman_vehicle::vehicle_file::{self, VehicleError};

fn main() -> Result<(), VehicleError> {
    let name = std::env::args_os().nth(1).unwrap_or("brunner".into());
    print!(
        "{}",
        planesman_plant::robot_description(&vehicle_file::load(&name.to_string_lossy())?)
    );
    Ok(())
}
