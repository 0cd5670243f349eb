//! The surface and the bottom: how deep the vehicle can be, and when it touched.
//!
//! A vehicle held at a limit moves on as it would otherwise, and its depth is the limit from the contact on, until
//! its depth rate turns away from it. Within a step the depth is taken as the cubic through both ends' depths and
//! rates: so neither a contact that is over before the step is, nor how far the vehicle has left the limit since, is
//! missed, however long the step. (The tether's drag grows with the depth; within such a step it is that of the way
//! without the limit.)
//!
//! The limits hold for the body's origin. The vehicle keeps its pitch and body velocities: no
//! impact, no friction, no broaching; while in contact trust no other number, but that the
//! accelerometers feel how the origin moves.

use crate::environment::SURFACE;

/// A limit of the water.
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
    /// When it began \[s\], from the start of what was asked about.
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

/// The water's extent in depth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DepthLimits {
    /// \[m\]; `None`: no bottom.
    pub bottom: Option<f64>,
}

/// How many times the interval that holds a contact is halved: to 1e-12 of the step.
const HALVINGS: u32 = 40;

impl DepthLimits {
    /// The depth that the limits allow.
    #[must_use]
    pub fn confined(&self, depth: f64) -> f64 {
        depth.min(self.bottom.unwrap_or(f64::INFINITY)).max(SURFACE)
    }

    /// The depth rate that the limits allow at a depth.
    #[must_use]
    pub fn confined_rate(&self, depth: f64, rate: f64) -> f64 {
        match self.touched(depth) {
            Some(Boundary::Surface) => rate.max(0.0),
            Some(Boundary::Bottom) => rate.min(0.0),
            None => rate,
        }
    }

    /// The limit that the vehicle touches at a depth.
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

    /// The depth \[m\] at the end of the way from one depth state to another, as it would be without limits, over `dt`
    /// \[s\]; and the first contact, if there is one after the start.
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

/// The cubic through two soundings (Hermite), over a share `s` in \[0, 1\] of the step.
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

    /// Where it turns, in order; 0 in place of a point outside of the step.
    fn turning_points(&self) -> [f64; 2] {
        let [_, c, b, a] = self.c;
        // 3 a s^2 + 2 b s + c = 0, by the form that keeps its digits when a is small.
        let root = (b * b - 3.0 * a * c).sqrt();
        let q = -(b + root.copysign(b));
        let inside = |s: f64| if s > 0.0 && s < 1.0 { s } else { 0.0 };
        let (one, other) = (inside(q / (3.0 * a)), inside(c / q));
        [one.min(other), one.max(other)]
    }

    /// Where between `a` and `b`, the latter beyond it, the limit is passed.
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
