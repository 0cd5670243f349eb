//! The URDF files of the package are what the node publishes.
#![allow(clippy::unwrap_used)]

use planesman_vehicle::vehicle_file;
use plant_sim::robot_description;

#[test]
fn the_committed_files_are_what_is_published() {
    for (name, committed) in [
        (
            "brunner",
            include_str!("../../../launch-scripts/urdf/brunner.urdf"),
        ),
        (
            "remus_100",
            include_str!("../../../launch-scripts/urdf/remus_100.urdf"),
        ),
    ] {
        let published = robot_description(&vehicle_file::load(name).unwrap());
        assert!(
            published == committed,
            "write it anew: cargo run -p plant_sim --example urdf {name} > launch-scripts/urdf/{name}.urdf"
        );
    }
}
