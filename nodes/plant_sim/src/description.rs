//! The vehicle as URDF, and the frames of its planes.
//!
//! The links' frames are those of `/tf` without their prefix. The hull is drawn as a cylinder of the reference length that
//! displaces the vehicle's buoyancy: the vehicle files have no shape.

use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt::Write as _;

use planesman_vehicle::Vehicle;

/// The body: forward, left, up.
pub(crate) const BODY: &str = "base_link";

/// The body: forward, right, down (REP 103).
pub(crate) const BODY_DOWN: &str = "base_link_frd";

/// Weight of the water that the hull displaces \[N/m^3\].
const WATER: f64 = 9810.0;

/// A pair of planes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Plane {
    /// Its frame.
    pub link: &'static str,
    /// Its joint: as in `sensor_msgs/JointState` on `planes`.
    pub joint: &'static str,
    /// Forward of the body's origin \[m\].
    pub forward: f64,
    /// The side to which it turns at a positive, diving, angle: 1 its leading edge down, -1 up.
    pub axis: f64,
}

/// The vehicle's planes, bow and stern; none where the vehicle file does not place them.
pub(crate) fn planes(vehicle: &Vehicle) -> Vec<Plane> {
    let Some(arms) = vehicle.planes else {
        return Vec::new();
    };
    vec![
        Plane {
            link: "bow_planes",
            joint: "dive_planes",
            forward: arms.bow,
            axis: 1.0,
        },
        Plane {
            link: "stern_planes",
            joint: "stern_planes",
            forward: arms.stern,
            axis: -1.0,
        },
    ]
}

/// The vehicle's URDF.
#[must_use]
pub fn of(vehicle: &Vehicle) -> String {
    let length = vehicle.reference_length;
    let radius = (vehicle.buoyancy / (WATER * length * PI)).sqrt();
    // A name of the user's: nothing in it is XML.
    let name = vehicle
        .name
        .replace(|c: char| !c.is_ascii_alphanumeric() && c != '_', "_");
    let mut urdf = format!(
        r#"<?xml version="1.0"?>
<robot name="{name}">
  <link name="{BODY}">
    <visual>
      <origin rpy="0 {FRAC_PI_2} 0"/>
      <geometry><cylinder length="{length}" radius="{radius}"/></geometry>
    </visual>
  </link>
  <link name="{BODY_DOWN}"/>
  <joint name="{BODY_DOWN}" type="fixed">
    <parent link="{BODY}"/>
    <child link="{BODY_DOWN}"/>
    <origin rpy="{PI} 0 0"/>
  </joint>
"#
    );
    for (index, plane) in planes(vehicle).iter().enumerate() {
        let Plane {
            link,
            joint,
            forward,
            axis,
        } = plane;
        // The stern planes go with the bow planes, unless an actuator of their own moves them.
        let mimic = match index {
            0 => "",
            _ => "\n    <mimic joint=\"dive_planes\"/>",
        };
        let (span, chord, thickness) = (4.0 * radius, 0.5 * radius, 0.05 * radius);
        // Writing to a String does not fail.
        let _ = write!(
            urdf,
            r#"  <link name="{link}">
    <visual>
      <geometry><box size="{chord} {span} {thickness}"/></geometry>
    </visual>
  </link>
  <joint name="{joint}" type="continuous">
    <parent link="{BODY}"/>
    <child link="{link}"/>
    <origin xyz="{forward} 0 0"/>
    <axis xyz="0 {axis} 0"/>{mimic}
  </joint>
"#
        );
    }
    urdf.push_str("</robot>\n");
    urdf
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_vehicle::vehicle_file::{brunner, remus_100};

    #[test]
    fn a_vehicle_without_placed_planes_has_no_joint_for_them() {
        assert!(of(&brunner()).contains("joint=\"dive_planes\""));
        let mut vehicle = remus_100();
        vehicle.planes = None;
        assert_eq!(of(&vehicle).matches("<joint").count(), 1);
    }

    #[test]
    fn a_name_is_no_xml() {
        let mut vehicle = brunner();
        vehicle.name = "a\"/><x>&".to_owned();
        assert!(of(&vehicle).contains("<robot name=\"a____x__\">"));
    }

    #[test]
    fn the_hull_displaces_the_buoyancy() {
        let vehicle = brunner();
        let radius = (vehicle.buoyancy / (WATER * vehicle.reference_length * PI)).sqrt();
        // 7 in by 3.5 in are 24.5 square inches; the hull is rounded.
        assert!((PI * radius * radius / (24.5 * 0.0254 * 0.0254) - 0.8).abs() < 0.05);
    }
}
