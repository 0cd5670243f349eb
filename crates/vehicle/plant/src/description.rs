//! URDF of the vehicle, and the frames of its moving parts.
//!
//! The links have the frames of `/tf`, without the frame prefix. The vehicle files contain no shape. The hull is a mesh of the ROS package, scaled to
//! the reference length and to the volume of the vehicle's buoyancy. The collision shape of every link is a primitive, for viewers without the
//! package.

use std::f64::consts::{FRAC_PI_2, PI};

use planesman_vehicle::Vehicle;
use planesman_vehicle::six_dof::{Fin, Tick};

use crate::craft::VehicleModel;

/// The body: forward, left, up.
pub(crate) const BODY: &str = "base_link";

/// The body: forward, right, down (REP 103).
pub(crate) const BODY_DOWN: &str = "base_link_frd";

/// Specific weight of the water that the hull displaces \[N/m^3\].
const WATER: f64 = 9810.0;

/// A part that moves with the planes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Part {
    /// Its frame.
    pub link: &'static str,
    /// Name of the plane's joint, as in `sensor_msgs/JointState` on `planes`.
    pub joint: &'static str,
    /// Position at neutral planes, from the body's origin: forward, left, up \[m\].
    pub origin: [f64; 3],
    /// Planes that move it.
    pub driver: Driver,
    /// Direction of motion for a positive angle.
    pub motion: Motion,
}

/// Planes that move a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Driver {
    /// Angle of the bow planes.
    Bow,
    /// Angle of the stern planes.
    Stern,
    /// Angle of both together.
    Together,
    /// The rudder's.
    Rudder,
}

/// Motion of a part with its angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Motion {
    /// Rotation about y: 1 leading edge down, -1 up.
    Turn(f64),
    /// Rotation about z: 1 moves the leading edge to port, like a rudder to starboard.
    Swing(f64),
    /// Translation forward, m/rad.
    Slide(f64),
}

/// A thruster: its link, position and direction of thrust, forward, left, up \[m\].
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Thruster {
    /// Its frame.
    pub link: String,
    /// \[m\]
    pub origin: [f64; 3],
    /// Of length 1.
    pub direction: [f64; 3],
}

impl Thruster {
    /// Pitch and yaw \[rad\] that turn the body's x axis into the direction of thrust.
    fn pitch_and_yaw(&self) -> (f64, f64) {
        let [x, y, z] = self.direction;
        (-libm::asin(z.clamp(-1.0, 1.0)), libm::atan2(y, x))
    }

    /// The same direction as a quaternion (x, y, z, w).
    pub(crate) fn orientation(&self) -> [f64; 4] {
        let (pitch, yaw) = self.pitch_and_yaw();
        let ((sp, cp), (sy, cy)) = (libm::sincos(0.5 * pitch), libm::sincos(0.5 * yaw));
        [-sy * sp, cy * sp, sy * cp, cy * cp]
    }
}

/// Thrusters of the vehicle; empty without thrusters.
pub(crate) fn thrusters(craft: &VehicleModel) -> Vec<Thruster> {
    let VehicleModel::SixDof(tick) = craft else {
        return Vec::new();
    };
    let parts = tick.vehicle().parts();
    let all = parts.thrusters().map(|(input, thruster)| Thruster {
        link: format!("thruster_{}", no_xml(&parts.inputs[input])),
        origin: turned_up(thruster.position),
        direction: turned_up(thruster.direction),
    });
    all.collect()
}

/// Converts forward, right, down to forward, left, up.
fn turned_up([x, y, z]: [f64; 3]) -> [f64; 3] {
    [x, 0.0 - y, 0.0 - z]
}

/// Escapes a user's name for XML.
fn no_xml(name: &str) -> String {
    name.replace(|c: char| !c.is_ascii_alphanumeric() && c != '_', "_")
}

/// Bow and stern planes, their ram, and the rudder; parts that the vehicle file lacks are omitted.
pub(crate) fn parts(craft: &VehicleModel) -> Vec<Part> {
    match craft {
        VehicleModel::Plane(vehicle) => parts_of_the_plane(vehicle),
        VehicleModel::SixDof(tick) => parts_of_six_degrees(tick),
    }
}

fn parts_of_the_plane(vehicle: &Vehicle) -> Vec<Part> {
    let Some(arms) = vehicle.planes else {
        return Vec::new();
    };
    let mut parts = vec![
        bow_planes([arms.bow, 0.0, 0.0]),
        stern_planes([arms.stern, 0.0, 0.0]),
    ];
    parts.extend(arms.moment_arm.map(|arm| Part {
        link: "ram",
        joint: "ram",
        origin: [0.5 * (arms.bow + arms.stern), 0.0, arm],
        driver: Driver::Together,
        motion: Motion::Slide(arm),
    }));
    parts
}

fn bow_planes(origin: [f64; 3]) -> Part {
    Part {
        link: "bow_planes",
        joint: "dive_planes",
        origin,
        driver: Driver::Bow,
        motion: Motion::Turn(1.0),
    }
}

fn stern_planes(origin: [f64; 3]) -> Part {
    Part {
        link: "stern_planes",
        joint: "stern_planes",
        origin,
        driver: Driver::Stern,
        motion: Motion::Turn(-1.0),
    }
}

/// Parts at the fins' positions in the vehicle file, or else at the ends of the hull.
fn parts_of_six_degrees(tick: &Tick) -> Vec<Part> {
    let parts = tick.vehicle().parts();
    let place = |input: usize, end: f64| {
        let fins: Vec<&Fin> = (parts.fins.iter())
            .filter(|fin| fin.input == input)
            .collect();
        let along: f64 = fins.iter().map(|fin| fin.position[0]).sum();
        match fins.len() {
            0 => [
                parts.centre_of_buoyancy[0] + end * parts.hull.length,
                0.0,
                0.0,
            ],
            count => [along / count as f64, 0.0, 0.0],
        }
    };
    let of = |(input, name): (usize, &String)| match name.as_str() {
        "bow_planes" => Some(bow_planes(place(input, 0.4))),
        "stern_planes" => Some(stern_planes(place(input, -0.45))),
        "rudder" => Some(Part {
            link: "rudder",
            joint: "rudder",
            origin: place(input, -0.45),
            driver: Driver::Rudder,
            motion: Motion::Swing(1.0),
        }),
        _ => None,
    };
    parts.inputs.iter().enumerate().filter_map(of).collect()
}

/// Dimensions of the hull \[m\].
pub(crate) struct Extent {
    pub(crate) length: f64,
    pub(crate) width: f64,
    pub(crate) height: f64,
    /// Whether the hull is a body of revolution; otherwise it is a frame.
    pub(crate) is_round: bool,
}

impl Extent {
    pub(crate) fn of(craft: &VehicleModel) -> Self {
        match craft {
            VehicleModel::Plane(vehicle) => {
                let length = vehicle.reference_length;
                let width = 2.0 * (vehicle.buoyancy / (WATER * length * PI)).sqrt();
                Self {
                    length,
                    width,
                    height: width,
                    is_round: true,
                }
            }
            VehicleModel::SixDof(tick) => {
                let hull = tick.vehicle().parts().hull;
                Self {
                    length: hull.length,
                    width: hull.width,
                    height: hull.height,
                    is_round: hull.length > 3.0 * hull.width.max(hull.height),
                }
            }
        }
    }
}

/// Shape of the hull: a primitive for every viewer, and the mesh of the package.
struct Shape {
    name: String,
    collision: String,
    visual: String,
    length: f64,
    radius: f64,
}

impl Shape {
    fn new(craft: &VehicleModel) -> Self {
        let Extent {
            length,
            width,
            height,
            is_round,
        } = Extent::of(craft);
        if is_round {
            return Self::round(craft.name(), length, [0.5 * width, 0.5 * height]);
        }
        let size = format!("{length} {width} {height}");
        let shape = format!("<geometry><box size=\"{size}\"/></geometry>");
        Self {
            name: no_xml(craft.name()),
            collision: shape.clone(),
            visual: shape,
            length,
            radius: 0.5 * width.min(height),
        }
    }

    /// A body of revolution.
    fn round(name: &str, length: f64, [across, up]: [f64; 2]) -> Self {
        let mesh = "package://planesman/meshes/hull.obj";
        Self {
            name: no_xml(name),
            collision: lengthwise(length, up),
            visual: format!(
                "<geometry><mesh filename=\"{mesh}\" scale=\"{length} {across} {up}\"/></geometry>"
            ),
            length,
            radius: up,
        }
    }
}

fn lengthwise(length: f64, radius: f64) -> String {
    let shape = format!("<cylinder length=\"{length}\" radius=\"{radius}\"/>");
    format!("<origin rpy=\"0 {FRAC_PI_2} 0\"/><geometry>{shape}</geometry>")
}

/// A link with one shape; and the joint between the link and the body, with this name and type.
fn jointed(
    link: &str,
    (joint, kind): (&str, &str),
    shape: &str,
    origin: &str,
    moved: &str,
) -> String {
    format!(
        r#"  <link name="{link}">
    <visual>{shape}</visual>
    <collision>{shape}</collision>
  </link>
  <joint name="{joint}" type="{kind}">
    <parent link="{BODY}"/>
    <child link="{link}"/>
    <origin {origin}/>{moved}
  </joint>
"#
    )
}

/// URDF of the vehicle.
#[must_use]
pub fn robot_description(craft: &VehicleModel) -> String {
    let Shape {
        name,
        collision,
        visual,
        length,
        radius,
    } = Shape::new(craft);
    let mut urdf = format!(
        r#"<?xml version="1.0"?>
<robot name="{name}">
  <link name="{BODY}">
    <visual>
      {visual}
      <material name="hull"><color rgba="0.9 0.7 0.2 0.5"/></material>
    </visual>
    <collision>{collision}</collision>
  </link>
  <link name="{BODY_DOWN}"/>
  <joint name="{BODY_DOWN}" type="fixed">
    <parent link="{BODY}"/>
    <child link="{BODY_DOWN}"/>
    <origin rpy="{PI} 0 0"/>
  </joint>
"#
    );
    let parts = parts(craft);
    let has_bow_planes = parts.iter().any(|it| it.joint == "dive_planes");
    for part in parts {
        let Part { link, joint, .. } = part;
        let [forward, left, up] = part.origin;
        let (kind, axis, limit, gain, shape) = match part.motion {
            Motion::Turn(side) | Motion::Swing(side) => {
                let [chord, span, thickness] = [0.5, 4.0, 0.05].map(|it| it * radius);
                let (size, axis) = match part.motion {
                    Motion::Swing(_) => {
                        (format!("{chord} {thickness} {span}"), format!("0 0 {side}"))
                    }
                    _ => (format!("{chord} {span} {thickness}"), format!("0 {side} 0")),
                };
                let shape = format!(r#"<geometry><box size="{size}"/></geometry>"#);
                // It has no limits.
                ("continuous", axis, String::new(), 1.0, shape)
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
        let mimic = match part.driver {
            Driver::Stern | Driver::Together if has_bow_planes => {
                format!("\n    <mimic joint=\"dive_planes\" multiplier=\"{gain}\"/>")
            }
            _ => String::new(),
        };
        let axis = format!("\n    <axis xyz=\"{axis}\"/>{limit}{mimic}");
        let origin = format!("xyz=\"{forward} {left} {up}\"");
        urdf += &jointed(link, (joint, kind), &shape, &origin, &axis);
    }
    for thruster in thrusters(craft) {
        let (pitch, yaw) = thruster.pitch_and_yaw();
        let Thruster {
            link,
            origin: [forward, left, up],
            ..
        } = thruster;
        let shape = lengthwise(0.6 * radius, 0.3 * radius);
        let origin = format!("xyz=\"{forward} {left} {up}\" rpy=\"0 {pitch} {yaw}\"");
        urdf += &jointed(&link, (&link, "fixed"), &shape, &origin, "");
    }
    urdf.push_str("</robot>\n");
    urdf
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_vehicle::vehicle_file::{brunner, remus_100};

    fn of_the_plane(vehicle: Vehicle) -> String {
        robot_description(&VehicleModel::Plane(Box::new(vehicle)))
    }

    #[test]
    fn a_vehicle_without_placed_planes_has_no_joint_for_them() {
        assert!(of_the_plane(brunner()).contains("joint=\"dive_planes\""));
        let mut vehicle = remus_100();
        vehicle.planes = None;
        assert_eq!(of_the_plane(vehicle).matches("<joint").count(), 1);
    }

    #[test]
    fn a_name_is_no_xml() {
        let mut vehicle = brunner();
        vehicle.name = "a\"/><x>&".to_owned();
        assert!(of_the_plane(vehicle).contains("<robot name=\"a____x__\">"));
    }

    #[test]
    fn the_hull_displaces_the_buoyancy() {
        let vehicle = brunner();
        let radius = (vehicle.buoyancy / (WATER * vehicle.reference_length * PI)).sqrt();
        // 7 in by 3.5 in are 24.5 square inches; the hull is rounded.
        assert!((PI * radius * radius / (24.5 * 0.0254 * 0.0254) - 0.8).abs() < 0.05);
    }

    #[test]
    fn each_thruster_is_a_link_that_points_where_it_pushes() {
        let parameters = crate::PlantParameters {
            vehicle: "bluerov2_heavy".to_owned(),
            ..crate::PlantParameters::default()
        };
        let craft = VehicleModel::load(&parameters).expect("built in");
        assert_eq!(robot_description(&craft).matches("<joint").count(), 9);
        let all = thrusters(&craft);
        // Forward and to port, as its file says it pushes: (1, -1, 0) forward, right, down is (1, 1, 0) forward, left, up.
        let first = &all[0];
        assert!((first.direction[0] - 0.5_f64.sqrt()).abs() < 1e-12);
        assert!((first.direction[1] - 0.5_f64.sqrt()).abs() < 1e-12);
        let [x, y, z, w] = first.orientation();
        // x turned by the quaternion.
        let turned = [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y + w * z),
            2.0 * (x * z - w * y),
        ];
        for (found, expected) in turned.iter().zip(first.direction) {
            assert!((found - expected).abs() < 1e-12, "{turned:?}");
        }
        let up = &all[4];
        let [x, y, z, w] = up.orientation();
        let turned = [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y + w * z),
            2.0 * (x * z - w * y),
        ];
        for (found, expected) in turned.iter().zip(up.direction) {
            assert!((found - expected).abs() < 1e-12, "{turned:?}");
        }
    }
}
