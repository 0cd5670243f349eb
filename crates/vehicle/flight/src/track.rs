//! Accuracy of a flight along its way-points, or at a held position.

use std::f64::consts::PI;

use planesman_control::{ControllerParameters, Turning};
use planesman_linear::Complex;
use planesman_linear::digits::significant;

use crate::flight::{Points, TimeHistories};

/// Way-points reached, and distances from the legs between them.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// Number of way-points that the vehicle passed within `acceptance`, in any order, and number of all way-points; a held position counts
    /// as one.
    pub reached: (usize, usize),
    /// Radius of acceptance of a way-point, m.
    pub acceptance: f64,
    /// Distance from the nearest leg, root mean square and maximum, m.
    pub off: (f64, f64),
    /// Distance from the last way-point at the end, m.
    pub at_end: f64,
}

impl Track {
    /// Evaluates positions along and to starboard of the initial heading. `None` without positions, and without way-points for a vehicle
    /// that does not hover.
    #[must_use]
    pub fn of(
        place: &[Points; 2],
        controller: &ControllerParameters,
        hovers: bool,
    ) -> Option<Self> {
        let points = &controller.waypoints;
        let mut legs: Vec<Complex<f64>> = (points.x.iter().zip(&points.y))
            .map(|(x, y)| Complex::new(*x, *y))
            .collect();
        if legs.is_empty() && hovers {
            legs.push(Complex::new(controller.hover.x, controller.hover.y));
        }
        let flown = place[0].iter().zip(&place[1]);
        let flown: Vec<Complex<f64>> = flown.map(|(x, y)| Complex::new(x.1, y.1)).collect();
        let (first, last, goal) = (*flown.first()?, *flown.last()?, *legs.last()?);
        let far = |p: Complex<f64>, q: Complex<f64>| (p - q).norm_sqr().sqrt();
        let is_reached =
            |goal: &&Complex<f64>| flown.iter().any(|p| far(*p, **goal) <= points.acceptance);
        let reached = (legs.iter().filter(is_reached).count(), legs.len());
        legs.insert(0, first);
        let from_leg = |p: Complex<f64>, from: Complex<f64>, to: Complex<f64>| {
            let along =
                (p - from) * (to - from).conj() / (to - from).norm_sqr().max(f64::MIN_POSITIVE);
            far(p, from + (to - from) * along.re.clamp(0.0, 1.0))
        };
        let off: Vec<f64> = flown
            .iter()
            .map(|p| {
                let each = legs.windows(2).map(|leg| from_leg(*p, leg[0], leg[1]));
                each.fold(f64::INFINITY, f64::min)
            })
            .collect();
        let squares: f64 = off.iter().map(|it| it * it).sum();
        Some(Self {
            reached,
            acceptance: points.acceptance,
            off: (
                (squares / off.len() as f64).sqrt(),
                off.iter().copied().fold(0.0, f64::max),
            ),
            at_end: far(last, goal),
        })
    }

    /// In a sentence.
    #[must_use]
    pub fn text(&self) -> String {
        format!(
            "{} of {} way-points reached within {} m; distance from the track {:.2} m rms, {:.2} m at most; {:.2} m from the last at the end.",
            self.reached.0, self.reached.1, self.acceptance, self.off.0, self.off.1, self.at_end
        )
    }
}

/// Result of a turning circle (steady turn in its last quarter) or a zig-zag (overshoot of the heading after the rudder was reversed), as a sentence;
/// `None` without such a manoeuvre or result.
pub(crate) fn turn(drawn: &TimeHistories, controller: &ControllerParameters) -> Option<String> {
    let turning = &controller.turning;
    let begin = drawn.yaw.iter().position(|it| it.0 >= turning.start)?;
    let (mut off, mut last) = (0.0, drawn.yaw[begin].1);
    let off = drawn.yaw[begin..].iter().map(|(t, yaw)| {
        off += libm::remainder(yaw - std::mem::replace(&mut last, *yaw), 2.0 * PI);
        (*t, off)
    });
    let off: Vec<(f64, f64)> = off.collect();
    match turning.manoeuvre {
        Turning::None => None,
        Turning::Circle => {
            let (from, to) = (off[off.len() * 3 / 4], *off.last()?);
            let rate = (to.1 - from.1) / (to.0 - from.0);
            let side = if rate > 0.0 { "starboard" } else { "port" };
            let diameter = 2.0 * drawn.speed.last()?.1 / rate.abs();
            rate.is_normal().then(|| {
                let [rate, diameter] =
                    [rate.abs().to_degrees(), diameter].map(|it| significant(it, 3));
                format!("Turned to {side} at {rate}°/s, in a circle of {diameter} m diameter.")
            })
        }
        Turning::Zigzag => {
            let beyond = off.iter().filter(|it| it.1.abs() >= turning.heading);
            let mut extremes: Vec<f64> = Vec::new();
            for (_, off) in beyond {
                match extremes.last_mut() {
                    Some(last) if *last * off > 0.0 => {
                        *last = last.signum() * last.abs().max(off.abs());
                    }
                    _ => extremes.push(*off),
                }
            }
            // The last one may not have come to its end.
            extremes.pop()?;
            let over = extremes.iter().take(3);
            let over = over.map(|it| it.abs() - turning.heading);
            let over = over.map(|it| format!("{}°", significant(it.to_degrees(), 2)));
            let over = over.collect::<Vec<_>>().join(", ");
            (!over.is_empty()).then(|| format!("Zig-zag: first overshoots of the heading {over}."))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_circle_and_a_zigzag_of_known_size_are_measured() {
        let mut controller = ControllerParameters::default();
        controller.turning.manoeuvre = Turning::Circle;
        let heading = controller.turning.heading;
        let yaw = |of: &dyn Fn(f64) -> f64| -> Points {
            (0..1000)
                .map(|k| 0.1 * f64::from(k))
                .map(|t| (t, of(t)))
                .collect()
        };
        let mut drawn = TimeHistories {
            yaw: yaw(&|t| libm::remainder(0.2 * t, 2.0 * PI)),
            speed: vec![(0.0, 1.2)],
            ..TimeHistories::default()
        };
        let circle = turn(&drawn, &controller).unwrap();
        assert!(
            circle.contains("starboard at 11.5°/s, in a circle of 12.0 m"),
            "{circle}"
        );
        controller.turning.manoeuvre = Turning::Zigzag;
        drawn.yaw = yaw(&|t| (heading + 1_f64.to_radians()) * libm::sin(0.4 * t));
        let zigzag = turn(&drawn, &controller).unwrap();
        assert!(zigzag.ends_with(" heading 1.0°, 1.0°, 1.0°."), "{zigzag}");
        drawn.yaw.truncate(10);
        assert_eq!(turn(&drawn, &controller), None);
    }

    #[test]
    fn a_flight_beside_its_track_is_told_how_far() {
        let mut controller = ControllerParameters::default();
        controller.waypoints.x = vec![10.0, 10.0];
        controller.waypoints.y = vec![0.0, 10.0];
        controller.waypoints.acceptance = 0.5;
        // Along the first leg 0.3 m beside it, then straight to 1 m before the last.
        let flown = [(0.0, 0.0), (2.0, 0.3), (8.0, 0.3), (10.0, 0.0), (10.0, 9.0)];
        let of = |axis: fn(&(f64, f64)) -> f64| {
            (0..).map(f64::from).zip(flown.iter().map(axis)).collect()
        };
        let track = Track::of(&[of(|it| it.0), of(|it| it.1)], &controller, false).unwrap();
        assert_eq!(
            (track.reached, track.off.1, track.at_end),
            ((1, 2), 0.3, 1.0)
        );
        assert!((track.off.0 - (2.0 * 0.09 / 5.0_f64).sqrt()).abs() < 1e-12);
        controller.waypoints.x.clear();
        assert_eq!(
            Track::of(&[of(|it| it.0), of(|it| it.1)], &controller, false),
            None
        );
        let held = Track::of(&[of(|it| it.0), of(|it| it.1)], &controller, true).unwrap();
        assert_eq!(held.reached, (1, 1));
    }
}
