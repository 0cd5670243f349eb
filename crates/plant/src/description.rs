//! The vehicle as URDF, and the frames of its moving parts.
//!
//! The links' frames are those of `/tf` without their prefix. The vehicle files have no shape: the hull is a mesh of the ROS package, scaled to
//! the reference length and to displace the vehicle's buoyancy. Every link's collision shape is a primitive, for viewers without the package.

use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt::Write as _;

use planesman_vehicle::Vehicle;

/// The body: forward, left, up.
pub(crate) const BODY: &str = "base_link";

/// The body: forward, right, down (REP 103).
pub(crate) const BODY_DOWN: &str = "base_link_frd";

/// Weight of the water that the hull displaces \[N/m^3\].
const WATER: f64 = 9810.0;

/// A part that moves with the planes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Part {
    /// Its frame.
    pub link: &'static str,
    /// Its joint: as in `sensor_msgs/JointState` on `planes`.
    pub joint: &'static str,
    /// At neutral planes, from the body's origin: forward, left, up \[m\].
    pub origin: [f64; 3],
    /// How it moves with a positive, diving, plane angle.
    pub motion: Motion,
}

/// The motion of a part with its plane angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Motion {
    /// Turns about y: 1 the leading edge down, -1 up.
    Turn(f64),
    /// Moves forward, by so many metres per radian.
    Slide(f64),
}

/// The planes, bow and stern, and the ram that turns them; none where the vehicle file does not place the planes.
pub(crate) fn parts(vehicle: &Vehicle) -> Vec<Part> {
    let Some(arms) = vehicle.planes else {
        return Vec::new();
    };
    let mut parts = vec![
        Part {
            link: "bow_planes",
            joint: "dive_planes",
            origin: [arms.bow, 0.0, 0.0],
            motion: Motion::Turn(1.0),
        },
        Part {
            link: "stern_planes",
            joint: "stern_planes",
            origin: [arms.stern, 0.0, 0.0],
            motion: Motion::Turn(-1.0),
        },
    ];
    parts.extend(arms.moment_arm.map(|arm| Part {
        link: "ram",
        joint: "ram",
        origin: [0.5 * (arms.bow + arms.stern), 0.0, arm],
        motion: Motion::Slide(arm),
    }));
    parts
}

/// The vehicle's URDF.
#[must_use]
pub fn robot_description(vehicle: &Vehicle) -> String {
    let length = vehicle.reference_length;
    let radius = (vehicle.buoyancy / (WATER * length * PI)).sqrt();
    let lengthwise = |length, radius| {
        let shape = format!("<cylinder length=\"{length}\" radius=\"{radius}\"/>");
        format!("<origin rpy=\"0 {FRAC_PI_2} 0\"/><geometry>{shape}</geometry>")
    };
    // A name of the user's: nothing in it is XML.
    let name = vehicle
        .name
        .replace(|c: char| !c.is_ascii_alphanumeric() && c != '_', "_");
    let mut urdf = format!(
        r#"<?xml version="1.0"?>
<robot name="{name}">
  <link name="{BODY}">
    <visual>
      <geometry><mesh filename="package://planesman/meshes/hull.obj" scale="{length} {radius} {radius}"/></geometry>
      <material name="hull"><color rgba="0.9 0.7 0.2 0.5"/></material>
    </visual>
    <collision>{}</collision>
  </link>
  <link name="{BODY_DOWN}"/>
  <joint name="{BODY_DOWN}" type="fixed">
    <parent link="{BODY}"/>
    <child link="{BODY_DOWN}"/>
    <origin rpy="{PI} 0 0"/>
  </joint>
"#,
        lengthwise(length, radius)
    );
    for part in parts(vehicle) {
        let Part { link, joint, .. } = part;
        let [forward, left, up] = part.origin;
        let (kind, axis, limit, gain, shape) = match part.motion {
            Motion::Turn(side) => {
                let [chord, span, thickness] = [0.5, 4.0, 0.05].map(|it| it * radius);
                let shape =
                    format!(r#"<geometry><box size="{chord} {span} {thickness}"/></geometry>"#);
                // It has no limits.
                (
                    "continuous",
                    format!("0 {side} 0"),
                    String::new(),
                    1.0,
                    shape,
                )
            }
            Motion::Slide(arm) => {
                let shape = lengthwise(0.5 * length, 0.1 * radius);
                // Those of a radian.
                let limit = format!(
                    "\n    <limit lower=\"-{arm}\" upper=\"{arm}\" effort=\"0\" velocity=\"0\"/>"
                );
                ("prismatic", "1 0 0".to_owned(), limit, arm, shape)
            }
        };
        // All go with the bow planes, unless an actuator of their own moves them.
        let mimic = match joint {
            "dive_planes" => String::new(),
            _ => format!("\n    <mimic joint=\"dive_planes\" multiplier=\"{gain}\"/>"),
        };
        // Writing to a String does not fail.
        let _ = write!(
            urdf,
            r#"  <link name="{link}">
    <visual>{shape}</visual>
    <collision>{shape}</collision>
  </link>
  <joint name="{joint}" type="{kind}">
    <parent link="{BODY}"/>
    <child link="{link}"/>
    <origin xyz="{forward} {left} {up}"/>
    <axis xyz="{axis}"/>{limit}{mimic}
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
        assert!(robot_description(&brunner()).contains("joint=\"dive_planes\""));
        let mut vehicle = remus_100();
        vehicle.planes = None;
        assert_eq!(robot_description(&vehicle).matches("<joint").count(), 1);
    }

    #[test]
    fn a_name_is_no_xml() {
        let mut vehicle = brunner();
        vehicle.name = "a\"/><x>&".to_owned();
        assert!(robot_description(&vehicle).contains("<robot name=\"a____x__\">"));
    }

    #[test]
    fn the_hull_displaces_the_buoyancy() {
        let vehicle = brunner();
        let radius = (vehicle.buoyancy / (WATER * vehicle.reference_length * PI)).sqrt();
        // 7 in by 3.5 in are 24.5 square inches; the hull is rounded.
        assert!((PI * radius * radius / (24.5 * 0.0254 * 0.0254) - 0.8).abs() < 0.05);
    }
}
