//! Surface and bottom: limits of the depth, and the first contact.
//!
//! A vehicle at a limit keeps its other motion. After the contact, the depth stays at the limit until the depth rate points away from the limit.
//! Within a step the depth is the cubic through depths and rates at both ends. So short contacts are found, and the depth after leaving the limit is
//! correct, also in long steps. (The tether's drag grows with the depth; within such a step it uses the depth without the limit.)
//!
//! The limits apply to the body's origin. The vehicle keeps its pitch and body velocities: there is no impact, no friction, no broaching.
//! During contact only depth and the accelerometers are valid; the accelerometers use the actual motion of the origin.

use crate::environment::SURFACE;

/// Limit of the water.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Boundary {
    /// From below.
    Surface,
    /// From above.
    Bottom,
}

/// A contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// With what.
    pub boundary: Boundary,
    /// Begin of the contact \[s\], from the start of the interval.
    pub time: f64,
}

/// A depth \[m\] and its rate \[m/s\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthState {
    /// \[m\], positive down.
    pub depth: f64,
    /// \[m/s\], positive down.
    pub rate: f64,
}

/// Extent of the water in depth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DepthLimits {
    /// Depth of the bottom \[m\]; `None` without a bottom.
    pub bottom: Option<f64>,
}

/// Number of bisections of the interval with a contact: to 1e-12 of the step.
const HALVINGS: u32 = 40;

impl DepthLimits {
    /// The depth, restricted to the limits.
    #[must_use]
    pub fn confined(&self, depth: f64) -> f64 {
        depth.min(self.bottom.unwrap_or(f64::INFINITY)).max(SURFACE)
    }

    /// The depth rate at a depth, restricted so that the limits hold.
    #[must_use]
    pub fn confined_rate(&self, depth: f64, rate: f64) -> f64 {
        match self.touched(depth) {
            Some(Boundary::Surface) => rate.max(0.0),
            Some(Boundary::Bottom) => rate.min(0.0),
            None => rate,
        }
    }

    /// Limit that the vehicle touches at a depth.
    #[must_use]
    pub fn touched(&self, depth: f64) -> Option<Boundary> {
        if depth <= SURFACE {
            Some(Boundary::Surface)
        } else if self.bottom.is_some_and(|bottom| depth >= bottom) {
            Some(Boundary::Bottom)
        } else {
            None
        }
    }

    /// Depth \[m\] at the end of a step of `dt` \[s\] between two depth states, which are those without limits, and the first contact after
    /// the start of the step.
    #[must_use]
    pub fn way(&self, from: DepthState, to: DepthState, dt: f64) -> (f64, Option<Contact>) {
        let path = Cubic::new(from, to, dt);
        // Between these the cubic is monotonic: it passes a limit where the ends differ.
        let [first, second] = path.turning_points();
        let (mut depth, mut contact) = (from.depth, None);
        let mut start = 0.0;
        for end in [first, second, 1.0] {
            // A limit has moved the path by so much.
            let moved = depth - path.at(start);
            let reached = path.at(end) + moved;
            depth = self.confined(reached);
            if depth != reached && contact.is_none() {
                contact = self.touched(depth).map(|boundary| Contact {
                    boundary,
                    time: dt * path.passage(start, end, depth - moved),
                });
            }
            start = end;
        }
        if contact.is_none() {
            depth = to.depth;
        }
        (depth, contact)
    }
}

/// The cubic (Hermite) through two depth states, over a share `s` in \[0, 1\] of the step.
struct Cubic {
    /// `c0 + c1 s + c2 s^2 + c3 s^3`
    c: [f64; 4],
}

impl Cubic {
    fn new(from: DepthState, to: DepthState, dt: f64) -> Self {
        let (z0, v0, z1, v1) = (from.depth, from.rate * dt, to.depth, to.rate * dt);
        let rise = z1 - z0;
        Self {
            c: [z0, v0, 3.0 * rise - 2.0 * v0 - v1, v0 + v1 - 2.0 * rise],
        }
    }

    fn at(&self, s: f64) -> f64 {
        let [c0, c1, c2, c3] = self.c;
        c0 + s * (c1 + s * (c2 + s * c3))
    }

    /// Extrema of the depth in order; 0 for extrema outside the step.
    fn turning_points(&self) -> [f64; 2] {
        let [_, c, b, a] = self.c;
        // 3 a s^2 + 2 b s + c = 0, by the form that keeps its digits when a is small.
        let root = (b * b - 3.0 * a * c).sqrt();
        let q = -(b + root.copysign(b));
        let inside = |s: f64| if s > 0.0 && s < 1.0 { s } else { 0.0 };
        let (one, other) = (inside(q / (3.0 * a)), inside(c / q));
        [one.min(other), one.max(other)]
    }

    /// Position between `a` and `b` at which the limit is crossed; `b` is beyond the limit.
    fn passage(&self, a: f64, b: f64, limit: f64) -> f64 {
        let beyond = |s: f64| (self.at(s) > limit) == (self.at(b) > limit);
        let (mut low, mut high) = (a, b);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if beyond(middle) {
                high = middle;
            } else {
                low = middle;
            }
        }
        high
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: DepthLimits = DepthLimits { bottom: Some(1.2) };

    fn depth_state(depth: f64, rate: f64) -> DepthState {
        DepthState { depth, rate }
    }

    #[test]
    fn a_vehicle_sinking_evenly_touches_the_bottom_when_it_gets_there() {
        let (depth, contact) = LIMITS.way(depth_state(1.0, 0.5), depth_state(1.5, 0.5), 1.0);
        let contact = contact.expect("it touches");
        assert_eq!(contact.boundary, Boundary::Bottom);
        assert!((contact.time - 0.4).abs() < 1e-9);
        assert_eq!((depth, LIMITS.confined(1.5)), (1.2, 1.2));
    }

    #[test]
    fn a_touch_that_is_over_before_the_step_is_found() {
        // 0.01 - 0.3 t + t^2: above the surface between 0.0382 s and 0.2618 s.
        let (from, to) = (depth_state(0.01, -0.3), depth_state(0.01 - 0.3 + 1.0, 1.7));
        let (depth, contact) = LIMITS.way(from, to, 1.0);
        let contact = contact.expect("it touches");
        assert_eq!(contact.boundary, Boundary::Surface);
        assert!((contact.time - 0.038_197).abs() < 1e-6, "{}", contact.time);
        // It leaves the surface at the lowest point, 0.0125 above it.
        assert!((depth - 0.7225).abs() < 1e-12, "{depth}");
        assert_eq!(
            LIMITS.way(depth_state(0.05, -0.3), depth_state(0.75, 1.7), 1.0),
            (0.75, None)
        );
    }

    #[test]
    fn a_vehicle_that_leaves_the_surface_does_not_touch_it() {
        assert_eq!(
            LIMITS.way(depth_state(0.0, 0.0), depth_state(0.1, 0.2), 1.0),
            (0.1, None)
        );
        assert_eq!(
            LIMITS.way(depth_state(0.0, 0.0), depth_state(0.0, 0.0), 1.0),
            (0.0, None)
        );
        assert_eq!(LIMITS.touched(0.0), Some(Boundary::Surface));
    }

    #[test]
    fn without_a_bottom_there_is_only_the_surface() {
        let open = DepthLimits::default();
        assert_eq!(open.confined(1e6), 1e6);
        assert_eq!(open.confined(-1.0), 0.0);
        assert_eq!(
            open.way(depth_state(1.0, 0.5), depth_state(1e3, 0.5), 1.0),
            (1e3, None)
        );
        assert_eq!(open.confined_rate(0.0, -0.1), 0.0);
        assert_eq!(LIMITS.confined_rate(1.2, 0.1), 0.0);
        assert_eq!(LIMITS.confined_rate(1.2, -0.1), -0.1);
    }
}
