//! Motion of the water: currents and waves.

use std::f64::consts::TAU;

use super::lanes::{Real, Three};

/// Motion of the water at the vehicle, in the fixed frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Water<T> {
    /// \[m/s\]
    pub velocity: Three<T>,
    /// Derivative of the water's velocity along the vehicle's path \[m/s^2\].
    pub acceleration: Three<T>,
    /// Acceleration of the water itself \[m/s^2\]: its pressure gradient divided by its density.
    pub of_water: Three<T>,
    /// Whether the water has a surface at depth 0; otherwise there is water above too.
    pub has_surface: bool,
    /// Depth of the bottom \[m\]; `None` without a bottom.
    pub bottom: Option<f64>,
}

impl<T: Real> Water<T> {
    /// Water at rest.
    #[must_use]
    pub fn at_rest() -> Self {
        Self::steady([0.0; 3])
    }

    /// A steady uniform current: north, east, down \[m/s\].
    #[must_use]
    pub fn steady(velocity: Three<f64>) -> Self {
        Self {
            velocity: velocity.map(T::of),
            acceleration: [T::of(0.0); 3],
            of_water: [T::of(0.0); 3],
            has_surface: false,
            bottom: None,
        }
    }
}

/// Standard gravity of the reports and vehicles \[m/s^2\].
pub const GRAVITY: f64 = 9.81;

/// The sea: a current that may turn and vary with depth, and waves.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sea {
    /// Current at the surface at time 0: north, east, down \[m/s\].
    pub current: Three<f64>,
    /// Rate at which the current turns about the down axis \[rad/s\].
    pub turning: f64,
    /// Gradient of the current with depth, north and east \[1/s\].
    pub shear: [f64; 2],
    /// First-order waves.
    pub waves: Vec<Wave>,
    /// Whether the vehicle emerges at depth 0: at the mean surface, with or without waves.
    pub has_surface: bool,
    /// Depth of the bottom \[m\]; `None` without a bottom.
    pub bottom: Option<f64>,
}

/// A wave of small amplitude in deep water.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wave {
    /// \[m\]
    pub amplitude: f64,
    /// \[s\]
    pub period: f64,
    /// Direction of propagation, from north towards east \[rad\].
    pub direction: f64,
    /// Phase of the elevation at the origin at time 0 \[rad\].
    pub phase: f64,
}

impl Sea {
    /// Whether the water's motion is uniform and constant.
    #[must_use]
    pub fn is_steady(&self) -> bool {
        self.turning == 0.0 && self.shear == [0.0; 2] && self.waves.is_empty()
    }

    /// The water at a position (north, east, down \[m\]) at a time \[s\], for a vehicle with a velocity over ground \[m/s\].
    #[must_use]
    pub fn at(&self, place: Three<f64>, over_ground: Three<f64>, time: f64) -> Water<f64> {
        let (sin, cos) = libm::sincos(self.turning * time);
        let turned = |[x, y]: [f64; 2]| [cos * x - sin * y, sin * x + cos * y];
        let depth = place[2].max(0.0);
        let [north, east, down] = self.current;
        let level = [north + self.shear[0] * depth, east + self.shear[1] * depth];
        let [north, east] = turned(level);
        let sinking = if place[2] > 0.0 { over_ground[2] } else { 0.0 };
        let [by_north, by_east] = turned(self.shear.map(|s| s * sinking));
        let turning = [-self.turning * east, self.turning * north, 0.0];
        let mut water = Water {
            velocity: [north, east, down],
            acceleration: [by_north + turning[0], by_east + turning[1], 0.0],
            of_water: turning,
            has_surface: self.has_surface,
            bottom: self.bottom,
        };
        for wave in &self.waves {
            wave.add(&mut water, place, over_ground, time);
        }
        water
    }
}

impl Wave {
    /// Adds the wave's velocity and its derivative along the path: Airy's wave, `omega^2 = g k`.
    fn add(&self, water: &mut Water<f64>, place: Three<f64>, over_ground: Three<f64>, time: f64) {
        let omega = TAU / self.period;
        let k = omega * omega / GRAVITY;
        let (toward_east, toward_north) = libm::sincos(self.direction);
        let along = |v: Three<f64>| v[0] * toward_north + v[1] * toward_east;
        let chi = k * along(place) - omega * time + self.phase;
        let (sin, cos) = libm::sincos(chi);
        let depth = place[2].max(0.0);
        let size = self.amplitude * omega * libm::exp(-k * depth);
        // Along the way chi changes by k x' - omega, and the size by -k z'.
        let chi_rate = k * along(over_ground) - omega;
        let fading = if place[2] > 0.0 {
            -k * over_ground[2]
        } else {
            0.0
        };
        let (level, down) = (size * cos, -size * sin);
        let level_rate = -size * sin * chi_rate + level * fading;
        let down_rate = -size * cos * chi_rate + down * fading;
        let add = |to: &mut Three<f64>, level: f64, down: f64| {
            to[0] += level * toward_north;
            to[1] += level * toward_east;
            to[2] += down;
        };
        add(&mut water.velocity, level, down);
        add(&mut water.acceleration, level_rate, down_rate);
        add(&mut water.of_water, size * omega * sin, size * omega * cos);
    }
}
