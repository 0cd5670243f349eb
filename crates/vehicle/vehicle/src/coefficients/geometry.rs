//! The geometry of a vehicle: the `geometry:` section of its file, in SI.
//!
//! The section is optional: nothing but [`table`](super::table) reads it. Every length, area and so on stands
//! in the file with its unit, and must be finite and above zero, but for the arms of fins, which are
//! negative aft of the centre of gravity.

use planesman_units::{Rule, readers};
use serde::Deserialize;

use crate::positive;

/// The geometry of a vehicle, and the choices that the methods leave.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Geometry {
    /// `g` \[m/s^2\] that weights count with.
    #[serde(with = "positive::acceleration")]
    pub gravity: f64,
    /// The water.
    pub water: Water,
    /// The bare hull.
    pub hull: Hull,
    /// The box whose moment of inertia stands for the vehicle's in air.
    pub air: AirBox,
    /// The dive planes.
    pub fins: Fins,
    /// Blocks of added mass, per axis.
    pub added_mass: Axes<Blocks>,
    /// Plates that damp the turning, per axis.
    pub damping: Damping,
    /// Friction and pressure drag.
    pub drag: DragAreas,
    /// Screws and what they push against.
    pub screws: Screws,
    /// Swing tests, if any were made.
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

/// The bare hull.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hull {
    /// Length without planes and screws \[m\].
    #[serde(with = "positive::length")]
    pub length: f64,
    /// Breadth \[m\].
    #[serde(with = "positive::length")]
    pub breadth: f64,
    /// Depth, keel to deck \[m\].
    #[serde(with = "positive::length")]
    pub depth: f64,
    /// Largest section \[m^2\].
    #[serde(with = "positive::area")]
    pub section: f64,
    /// Volume \[m^3\].
    #[serde(with = "positive::volume")]
    pub volume: f64,
    /// Where the hull's lift acts at an angle to the stream \[m\] aft of the centre; absent where the
    /// Munk moment is not to be lessened by it.
    #[serde(default, with = "positive::optional_length")]
    pub lift_aft: Option<f64>,
}

/// A box in air.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AirBox {
    /// Its weight \[N\].
    #[serde(with = "positive::force")]
    pub weight: f64,
    /// Along the hull \[m\].
    #[serde(with = "positive::length")]
    pub length: f64,
    /// Across \[m\].
    #[serde(with = "positive::length")]
    pub breadth: f64,
    /// Keel to deck \[m\].
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

/// A pair of planes.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FinPair {
    /// From hull to tip, of one plane \[m\].
    #[serde(with = "positive::length")]
    pub span: f64,
    /// Along the stream \[m\].
    #[serde(with = "positive::length")]
    pub chord: f64,
    /// Centre of pressure forward of the centre of gravity \[m\].
    #[serde(with = "signed_length")]
    pub arm: f64,
}

impl FinPair {
    /// Area of one plane \[m^2\].
    #[must_use]
    pub fn area(&self) -> f64 {
        self.span * self.chord
    }

    /// Span over chord.
    #[must_use]
    pub fn aspect_ratio(&self) -> f64 {
        self.span / self.chord
    }

    /// Twice that: the hull mirrors the plane.
    #[must_use]
    pub fn effective_aspect_ratio(&self) -> f64 {
        2.0 * self.aspect_ratio()
    }
}

/// One of something per axis.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axes<T> {
    /// About the y axis.
    pub pitch: T,
    /// About the z axis.
    pub yaw: T,
    /// About the x axis.
    pub roll: T,
}

/// A hull taken as blocks.
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
    /// One side of the box that the added mass is spread over for its moment of inertia \[m\].
    #[serde(with = "positive::length")]
    pub spread_length: f64,
    /// The other \[m\].
    #[serde(with = "positive::length")]
    pub spread_breadth: f64,
}

/// Plates that damp.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Damping {
    /// `C_D` of a plate across the stream.
    #[serde(with = "number")]
    pub drag_coefficient: f64,
    /// The rate at which damping is made linear \[rad/s\].
    #[serde(with = "positive::rate")]
    pub rate: f64,
    /// About the y axis.
    pub pitch: Plate,
    /// About the z axis.
    pub yaw: Plate,
    /// About the x axis.
    pub roll: Plate,
}

/// A plate that turns about its middle.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plate {
    /// From end to end, square to the axis \[m\].
    #[serde(with = "positive::length")]
    pub length: f64,
    /// Along the axis \[m\].
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

/// Areas and lengths that drag is computed with.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DragAreas {
    /// Length of the Reynolds number \[m\].
    #[serde(with = "positive::length")]
    pub plate_length: f64,
    /// All that is wetted \[m^2\].
    #[serde(with = "positive::area")]
    pub wetted: f64,
    /// Of it, the forebody \[m^2\].
    #[serde(with = "positive::area")]
    pub forebody: f64,
    /// `C_D` of the whole on the largest section.
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
    /// The drag they overcome \[N\] at the cruising speed.
    #[serde(with = "positive::force")]
    pub drag: f64,
    /// The cruising speed \[m/s\].
    #[serde(with = "positive::speed")]
    pub speed: f64,
}

/// A swing test.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SwingTest {
    /// The measured quantity, such as `Jy`.
    pub name: String,
    /// Pivot to centre of mass \[m\].
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
