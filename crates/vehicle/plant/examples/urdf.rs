//! Prints a vehicle's URDF, as `plant_sim` publishes it:
//!
//! ```sh
//! cargo run -p planesman_plant --example urdf brunner > launch-scripts/urdf/brunner.urdf
//! ```

use planesman_plant::{Error, PlantParameters, VehicleModel, robot_description};

fn main() -> Result<(), Error> {
    let name = std::env::args_os().nth(1).unwrap_or("brunner".into());
    let parameters = PlantParameters {
        vehicle: name.to_string_lossy().into_owned(),
        ..PlantParameters::default()
    };
    print!("{}", robot_description(&VehicleModel::load(&parameters)?));
    Ok(())
}
