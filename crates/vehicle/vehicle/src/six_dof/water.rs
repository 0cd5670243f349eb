//! How the water moves: currents and waves.

use std::f64::consts::TAU;

use super::lanes::{Real, Three};

/// The water's motion at the vehicle, in the fixed frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Water<T> {
    /// \[m/s\]
    pub velocity: Three<T>,
    /// Its change along the vehicle's way \[m/s^2\].
    pub acceleration: Three<T>,
    /// The acceleration of the water itself \[m/s^2\]: its pressure gradient over its density.
    pub of_water: Three<T>,
    /// Whether it ends at depth 0; else there is water above too.
    pub has_surface: bool,
    /// Depth of the bottom \[m\]; `None`: there is none.
    pub bottom: Option<f64>,
}

impl<T: Real> Water<T> {
    /// Water at rest.
    #[must_use]
    pub fn at_rest() -> Self {
        Self::steady([0.0; 3])
    }

    /// A steady current, the same everywhere: north, east, down \[m/s\].
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

/// Standard gravity, as the reports and vehicles here use it \[m/s^2\].
pub const GRAVITY: f64 = 9.81;

/// The sea: a current that may turn and vary with depth, and waves.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sea {
    /// North, east, down \[m/s\], at the surface and at the time 0.
    pub current: Three<f64>,
    /// How fast the current turns about down \[rad/s\].
    pub turning: f64,
    /// Change of the current per metre of depth, north and east \[1/s\].
    pub shear: [f64; 2],
    /// First-order waves.
    pub waves: Vec<Wave>,
    /// Whether the vehicle comes out of the water at depth 0: at the mean surface, waves or not.
    pub has_surface: bool,
    /// Depth of the bottom \[m\]; `None`: there is none.
    pub bottom: Option<f64>,
}

/// A wave of small amplitude on deep water.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wave {
    /// \[m\]
    pub amplitude: f64,
    /// \[s\]
    pub period: f64,
    /// Where it goes to, from north over east \[rad\].
    pub direction: f64,
    /// Of the elevation at the place and time 0 \[rad\].
    pub phase: f64,
}

impl Sea {
    /// Whether the water moves alike everywhere and always.
    #[must_use]
    pub fn is_steady(&self) -> bool {
        self.turning == 0.0 && self.shear == [0.0; 2] && self.waves.is_empty()
    }

    /// The water at a place (north, east, down \[m\]) of a vehicle that moves over ground (\[m/s\]), at a time \[s\].
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
    /// The water's velocity and its change along the way: Airy's wave, `omega^2 = g k`.
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
