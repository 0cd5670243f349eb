//! Guidance in the horizontal plane: way-points by line of sight, and standard rudder manoeuvres.
//!
//! ```text
//! leg from P to Q, course alpha: along s, across e (to starboard)     chi = alpha + atan2(-e, lookahead)
//! the next leg begins within the acceptance radius of Q, or abeam of it
//! ```
//! Lookahead-based steering: Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control (2011), sec. 10.3.2. Turning circle and zig-zag are
//! the standard manoeuvres of ships (IMO resolution MSC.137(76)): the rudder is reversed when the heading has changed by the angle of the zig-zag.

use planesman_parameters::Choice;

use crate::angle_loop::short_way;

/// Way-points in the horizontal plane, with the settings for following them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Path {
    /// Each point along and to starboard of the initial heading, m.
    pub points: Vec<[f64; 2]>,
    /// m
    pub lookahead: f64,
    /// The radius within which a way-point is reached, m.
    pub acceptance: f64,
}

/// The progress on a path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Progress {
    /// The beginning of the first leg, m.
    from: Option<[f64; 2]>,
    /// The current way-point.
    next: usize,
}

/// The course to steer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Course {
    /// rad, from the initial heading, to starboard, within half a turn.
    pub heading: f64,
    /// The point on the path to steer for; at the end of the path this is the last way-point.
    pub target: [f64; 2],
}

impl Path {
    /// The course from a position; `None` without way-points. Beyond the last way-point the course of the last leg continues.
    pub(crate) fn course(&self, progress: &mut Progress, at: [f64; 2]) -> Option<Course> {
        let last = self.points.len().checked_sub(1)?;
        let start = *progress.from.get_or_insert(at);
        loop {
            let to = self.points[progress.next.min(last)];
            let from = match progress.next {
                0 => start,
                next => self.points[next.min(last) - 1],
            };
            let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
            let length = libm::hypot(dx, dy);
            let course = libm::atan2(dy, dx);
            let (sin, cos) = libm::sincos(course);
            let (x, y) = (at[0] - from[0], at[1] - from[1]);
            let (along, across) = (x * cos + y * sin, y * cos - x * sin);
            let distance = libm::hypot(to[0] - at[0], to[1] - at[1]);
            if progress.next < last && (distance <= self.acceptance || along >= length) {
                progress.next += 1;
                continue;
            }
            let ahead = (along + self.lookahead).clamp(0.0, length);
            return Some(Course {
                heading: short_way(0.0, course + libm::atan2(-across, self.lookahead)),
                target: [from[0] + ahead * cos, from[1] + ahead * sin],
            });
        }
    }
}

/// The rudder's manoeuvre.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Choice)]
pub enum Turning {
    /// No manoeuvre: the heading loop commands the rudder.
    None,
    /// A constant angle.
    Circle,
    /// An angle alternating between both sides.
    Zigzag,
}

/// The rudder's manoeuvre: the parameters `turning.*`.
#[derive(Clone, Copy, Debug, PartialEq, planesman_parameters::Parameters)]
pub struct TurningManoeuvre {
    /// Manoeuvre of the rudder in place of the heading loop: none, circle (turning.rudder held) or zigzag (the rudder is reversed when the heading
    /// has changed by turning.heading).
    #[parameter(default = Turning::None)]
    pub manoeuvre: Turning,
    /// Rudder angle of the manoeuvre, positive to starboard first; 10 degrees; limited by heading.limit.
    #[parameter(default = 0.174_532_925_199_432_95, unit = "rad", positive = "to starboard first", range = -std::f64::consts::FRAC_PI_2..=std::f64::consts::FRAC_PI_2)]
    pub rudder: f64,
    /// Change of heading from the initial heading, to either side, at which the rudder of a zig-zag is reversed; 10 degrees.
    #[parameter(default = 0.174_532_925_199_432_95, unit = "rad", range = 0.001..=std::f64::consts::PI)]
    pub heading: f64,
    /// Start time of the manoeuvre, since the first state; until then the heading loop steers.
    #[parameter(default = 0.0, unit = "s", range = 0.0..=1e6)]
    pub start: f64,
}

/// The state of the rudder's manoeuvre.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Swing {
    /// The heading at the start of the manoeuvre, rad.
    from: Option<f64>,
    /// Whether the rudder is reversed, that is, on the other side.
    over: bool,
}

impl TurningManoeuvre {
    /// The rudder, rad, at a heading, rad; `None` while there is no manoeuvre.
    pub(crate) fn rudder(&self, swing: &mut Swing, elapsed: f64, yaw: f64) -> Option<f64> {
        if self.manoeuvre == Turning::None || elapsed < self.start {
            *swing = Swing::default();
            return None;
        }
        let from = *swing.from.get_or_insert(yaw);
        if self.manoeuvre == Turning::Zigzag {
            // Positive to the side of the first rudder.
            let turned = short_way(from, yaw) * self.rudder.signum();
            let reached = match swing.over {
                false => turned >= self.heading,
                true => turned <= -self.heading,
            };
            swing.over ^= reached;
        }
        Some(if swing.over {
            -self.rudder
        } else {
            self.rudder
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(points: &[[f64; 2]]) -> Path {
        Path {
            points: points.to_vec(),
            lookahead: 5.0,
            acceptance: 1.0,
        }
    }

    #[test]
    fn on_the_leg_its_course_is_steered_and_beside_it_the_way_back() {
        let path = path(&[[100.0, 0.0]]);
        let mut progress = Progress::default();
        let start = path.course(&mut progress, [0.0, 0.0]).expect("a leg");
        assert_eq!(start.heading, 0.0);
        let aside = path.course(&mut progress, [10.0, 5.0]).expect("a leg");
        assert!((aside.heading + std::f64::consts::FRAC_PI_4).abs() < 1e-15);
        assert_eq!(aside.target, [15.0, 0.0]);
    }

    #[test]
    fn a_way_point_is_left_within_its_radius_or_abeam() {
        let path = path(&[[10.0, 0.0], [10.0, 20.0]]);
        for reached in [[9.5, 0.5], [10.5, 4.0]] {
            let mut progress = Progress::default();
            path.course(&mut progress, [0.0, 0.0]).expect("a leg");
            path.course(&mut progress, reached).expect("a leg");
            assert_eq!(progress.next, 1, "{reached:?}");
        }
    }

    #[test]
    fn at_the_end_the_target_is_the_last_way_point() {
        let path = path(&[[10.0, 0.0]]);
        let mut progress = Progress::default();
        path.course(&mut progress, [0.0, 0.0]).expect("a leg");
        let end = path.course(&mut progress, [12.0, 1.0]).expect("a leg");
        assert_eq!(end.target, [10.0, 0.0]);
        assert_eq!(Path::default().course(&mut progress, [0.0; 2]), None);
    }

    #[test]
    fn the_rudder_goes_over_when_the_heading_has_changed() {
        let zigzag = TurningManoeuvre {
            manoeuvre: Turning::Zigzag,
            start: 1.0,
            rudder: 0.2,
            heading: 0.1,
        };
        let mut swing = Swing::default();
        assert_eq!(zigzag.rudder(&mut swing, 0.5, 3.1), None);
        let mut at = |yaw| zigzag.rudder(&mut swing, 2.0, yaw);
        assert_eq!(at(3.1), Some(0.2));
        // Through half a turn.
        assert_eq!(at(-3.1), Some(0.2));
        assert_eq!(at(-3.07), Some(-0.2));
        assert_eq!(at(3.05), Some(-0.2));
        assert_eq!(at(2.99), Some(0.2));
    }
}
