//! Geometry of a vehicle: the `geometry:` section of its file, in SI.
//!
//! The section is optional: only [`table`](super::table) uses it. Every length, area etc. in the file has its unit and must be finite and
//! positive; only the arms of fins are negative aft of the centre of gravity.

use planesman_units::{Rule, readers};
use serde::Deserialize;

use crate::positive;

/// Geometry of a vehicle, and the free choices of the methods.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Geometry {
    /// `g` \[m/s^2\] for the conversion of weights.
    #[serde(with = "positive::acceleration")]
    pub gravity: f64,
    /// The water.
    pub water: Water,
    /// Bare hull.
    pub hull: Hull,
    /// Box that approximates the vehicle's moment of inertia in air.
    pub air: AirBox,
    /// Dive planes.
    pub fins: Fins,
    /// Blocks for the added mass, one entry per axis.
    pub added_mass: Axes<Blocks>,
    /// Plates for the damping of rotation, one per axis.
    pub damping: Damping,
    /// Friction and pressure drag.
    pub drag: DragAreas,
    /// Screws, and the drag they overcome.
    pub screws: Screws,
    /// Swing tests; may be empty.
    #[serde(default)]
    pub swing_tests: Vec<SwingTest>,
}

/// Water.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Water {
    /// `rho` \[kg/m^3\].
    #[serde(with = "positive::density")]
    pub density: f64,
    /// `nu` \[m^2/s\].
    #[serde(with = "positive::viscosity")]
    pub viscosity: f64,
}

/// Bare hull.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hull {
    /// Length without planes and screws \[m\].
    #[serde(with = "positive::length")]
    pub length: f64,
    /// Breadth \[m\].
    #[serde(with = "positive::length")]
    pub breadth: f64,
    /// Height from keel to deck \[m\].
    #[serde(with = "positive::length")]
    pub depth: f64,
    /// Largest section \[m^2\].
    #[serde(with = "positive::area")]
    pub section: f64,
    /// Volume \[m^3\].
    #[serde(with = "positive::volume")]
    pub volume: f64,
    /// Distance aft of the centre \[m\] at which the hull's lift at an angle of attack acts; `None` if it must not reduce the Munk moment.
    #[serde(default, with = "positive::optional_length")]
    pub lift_aft: Option<f64>,
}

/// Box for the moment of inertia in air.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AirBox {
    /// Its weight \[N\].
    #[serde(with = "positive::force")]
    pub weight: f64,
    /// Length along the hull \[m\].
    #[serde(with = "positive::length")]
    pub length: f64,
    /// Across \[m\].
    #[serde(with = "positive::length")]
    pub breadth: f64,
    /// Height from keel to deck \[m\].
    #[serde(with = "positive::length")]
    pub depth: f64,
}

/// Both pairs of dive planes.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fins {
    /// The forward pair.
    pub forward: FinPair,
    /// The aft pair.
    pub aft: FinPair,
}

/// A pair of dive planes.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FinPair {
    /// Span of one plane, from hull to tip \[m\].
    #[serde(with = "positive::length")]
    pub span: f64,
    /// Chord along the stream \[m\].
    #[serde(with = "positive::length")]
    pub chord: f64,
    /// Position of the centre of pressure forward of the centre of gravity \[m\].
    #[serde(with = "signed_length")]
    pub arm: f64,
}

impl FinPair {
    /// Area of one plane \[m^2\].
    #[must_use]
    pub fn area(&self) -> f64 {
        self.span * self.chord
    }

    /// Span divided by chord.
    #[must_use]
    pub fn aspect_ratio(&self) -> f64 {
        self.span / self.chord
    }

    /// Twice the geometric aspect ratio, since the hull mirrors the plane.
    #[must_use]
    pub fn effective_aspect_ratio(&self) -> f64 {
        2.0 * self.aspect_ratio()
    }
}

/// A value for each axis of rotation.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axes<T> {
    /// Value for the y axis.
    pub pitch: T,
    /// Value for the z axis.
    pub yaw: T,
    /// Value for the x axis.
    pub roll: T,
}

/// Blocks that approximate a hull.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Blocks {
    /// How many.
    pub count: u32,
    /// `A` \[m\], side of the square face.
    #[serde(with = "positive::length")]
    pub side: f64,
    /// `B` \[m\], thickness along the motion.
    #[serde(with = "positive::length")]
    pub thickness: f64,
    /// Side of the box over which the added mass is distributed for its moment of inertia \[m\].
    #[serde(with = "positive::length")]
    pub spread_length: f64,
    /// The other \[m\].
    #[serde(with = "positive::length")]
    pub spread_breadth: f64,
}

/// Plates for the damping of rotation.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Damping {
    /// `C_D` of a plate normal to the stream.
    #[serde(with = "number")]
    pub drag_coefficient: f64,
    /// Rate at which the damping is linearised \[rad/s\].
    #[serde(with = "positive::rate")]
    pub rate: f64,
    /// Plate for rotation about the y axis.
    pub pitch: Plate,
    /// Plate for rotation about the z axis.
    pub yaw: Plate,
    /// Plate for rotation about the x axis.
    pub roll: Plate,
}

/// A plate that rotates about its middle.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plate {
    /// Length from end to end, normal to the axis \[m\].
    #[serde(with = "positive::length")]
    pub length: f64,
    /// Breadth along the axis \[m\].
    #[serde(with = "positive::length")]
    pub breadth: f64,
}

impl Plate {
    /// Its area \[m^2\].
    #[must_use]
    pub fn area(&self) -> f64 {
        self.length * self.breadth
    }
}

/// Areas and lengths for the drag.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DragAreas {
    /// Length for the Reynolds number \[m\].
    #[serde(with = "positive::length")]
    pub plate_length: f64,
    /// Total wetted area \[m^2\].
    #[serde(with = "positive::area")]
    pub wetted: f64,
    /// Wetted area of the forebody \[m^2\].
    #[serde(with = "positive::area")]
    pub forebody: f64,
    /// `C_D` of the vehicle, referred to the largest section.
    #[serde(with = "number")]
    pub coefficient: f64,
    /// Greatest speed \[m/s\].
    #[serde(with = "positive::speed")]
    pub speed: f64,
}

/// Screws.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Screws {
    /// How many.
    pub count: u32,
    /// Their diameter \[m\].
    #[serde(with = "positive::length")]
    pub diameter: f64,
    /// Drag that they overcome at the cruising speed \[N\].
    #[serde(with = "positive::force")]
    pub drag: f64,
    /// Cruising speed \[m/s\].
    #[serde(with = "positive::speed")]
    pub speed: f64,
}

/// A swing test.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SwingTest {
    /// Measured quantity, such as `Jy`.
    pub name: String,
    /// Distance from pivot to centre of mass \[m\].
    #[serde(with = "positive::length")]
    pub length: f64,
    /// Period \[s\].
    #[serde(with = "positive::time")]
    pub period: f64,
    /// Standard uncertainty of the length \[m\].
    #[serde(with = "positive::length")]
    pub length_uncertainty: f64,
    /// Standard uncertainty of the period \[s\].
    #[serde(with = "positive::time")]
    pub period_uncertainty: f64,
}

readers! {
    signed_length: Length, Rule::Any;
    number: Number, [1e-6, 1e6];
}

#[cfg(test)]
mod tests {
    use crate::vehicle_file::{BRUNNER, geometry};

    #[test]
    fn the_built_in_vehicle_has_the_planes_of_figure_23() {
        let g = geometry(BRUNNER).expect("valid").expect("there");
        assert!((g.fins.forward.aspect_ratio() - 1.316).abs() < 5e-4);
        assert!((g.fins.aft.effective_aspect_ratio() - 2.5).abs() < 1e-12);
        assert!(g.fins.aft.arm < 0.0);
    }
}
