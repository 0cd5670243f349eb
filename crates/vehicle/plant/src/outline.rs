//! The vehicle as lines, for drawings.

use std::f64::consts::TAU;

use crate::craft::VehicleModel;
use crate::description::{self, Driver, Extent, Motion};
use crate::error::Error;
use crate::parameters::PlantParameters;

/// Hull, planes and thrusters as lines, each a list of points forward, starboard, down from the body's origin \[m\].
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// Polylines, each through its points.
    pub lines: Vec<Vec<[f64; 3]>>,
}

/// Number of corners of a ring about the hull.
const CORNERS: u32 = 16;

impl Outline {
    /// Returns the outline of the vehicle that the parameters name.
    ///
    /// # Errors
    /// Same as [`VehicleModel::load`].
    pub fn load(parameters: &PlantParameters) -> Result<Self, Error> {
        Ok(Self::of(&VehicleModel::load(parameters)?))
    }

    /// Of a vehicle.
    #[must_use]
    pub fn of(craft: &VehicleModel) -> Self {
        let Extent {
            length,
            width,
            height,
            is_round,
        } = Extent::of(craft);
        let ring = |x: f64, share: f64| {
            (0..=CORNERS)
                .map(|k| {
                    let (sin, cos) = libm::sincos(TAU * f64::from(k) / f64::from(CORNERS));
                    [x, 0.5 * share * width * sin, 0.5 * share * height * cos]
                })
                .collect::<Vec<_>>()
        };
        let mut lines = Vec::new();
        if is_round {
            // Nose and tail: so much of the width so far along.
            let shape = [
                (0.5, 0.0),
                (0.45, 0.6),
                (0.35, 1.0),
                (-0.2, 1.0),
                (-0.4, 0.6),
                (-0.5, 0.1),
            ];
            lines.extend(
                shape
                    .iter()
                    .skip(1)
                    .map(|(x, share)| ring(x * length, *share)),
            );
            for side in [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]] {
                let along = shape.iter().map(|(x, share)| {
                    let half = 0.5 * share;
                    [x * length, half * side[0] * width, half * side[1] * height]
                });
                lines.push(along.collect());
            }
        } else {
            let (x, y, z) = (0.5 * length, 0.5 * width, 0.5 * height);
            let frame = |z: f64| vec![[x, y, z], [x, -y, z], [-x, -y, z], [-x, y, z], [x, y, z]];
            lines.extend([frame(z), frame(-z)]);
            for (x, y) in [(x, y), (x, -y), (-x, -y), (-x, y)] {
                lines.push(vec![[x, y, z], [x, y, -z]]);
            }
            // The bow.
            lines.push(vec![
                [x, 0.5 * y, 0.0],
                [1.3 * x, 0.0, 0.0],
                [x, -0.5 * y, 0.0],
            ]);
        }
        let (chord, span) = (
            0.25 * width.min(height).max(0.05 * length),
            width.max(height),
        );
        for part in description::parts(craft) {
            let [x, left, up] = part.origin;
            let at = |dx: f64, aside: f64, down: f64| [x + dx, aside - left, down - up];
            let fin = match (part.motion, part.driver) {
                (Motion::Slide(_), _) => continue,
                (Motion::Swing(_), _) | (_, Driver::Rudder) => [
                    at(chord, 0.0, -span),
                    at(-chord, 0.0, -span),
                    at(-chord, 0.0, span),
                    at(chord, 0.0, span),
                ],
                (Motion::Turn(_), _) => [
                    at(chord, -span, 0.0),
                    at(-chord, -span, 0.0),
                    at(-chord, span, 0.0),
                    at(chord, span, 0.0),
                ],
            };
            lines.push(fin.into_iter().chain([fin[0]]).collect());
        }
        for thruster in description::thrusters(craft) {
            let ([x, y, z], [a, b, c]) = (thruster.origin, thruster.direction);
            let reach = 0.2 * width.min(height);
            lines.push(vec![
                [x - reach * a, reach * b - y, reach * c - z],
                [x + reach * a, -reach * b - y, -reach * c - z],
            ]);
        }
        Self { lines }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_vehicle_has_an_outline_of_its_own_size() {
        for (name, length) in [
            ("brunner", 0.7),
            ("lauv", 1.08),
            ("bluerov2_heavy", 0.457 * 1.3),
        ] {
            let parameters = PlantParameters {
                vehicle: name.to_owned(),
                ..PlantParameters::default()
            };
            let outline = Outline::load(&parameters).expect("built in");
            let along = outline.lines.iter().flatten().map(|it| it[0]);
            let most = along.clone().fold(f64::MIN, f64::max);
            assert!(
                (2.0 * most - length).abs() < 0.05 * length,
                "{name}: {most}"
            );
        }
    }
}
