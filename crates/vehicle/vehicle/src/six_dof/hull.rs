//! Dimensions of the hull.

use serde::Deserialize;

use crate::positive;

/// Dimensions of the hull \[m\], centred at the centre of buoyancy.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hull {
    /// Along x.
    #[serde(with = "positive::length")]
    pub length: f64,
    /// Along y.
    #[serde(with = "positive::length")]
    pub width: f64,
    /// Along z.
    #[serde(with = "positive::length")]
    pub height: f64,
}

/// Number of strips along the hull.
pub(super) const STRIPS: usize = 9;

impl Hull {
    /// A cube with the volume of a buoyancy \[N\], for a vehicle whose file gives no hull.
    #[must_use]
    pub fn of_buoyancy(buoyancy: f64) -> Self {
        let edge = libm::cbrt(buoyancy / (1000.0 * super::water::GRAVITY));
        Self {
            length: edge,
            width: edge,
            height: edge,
        }
    }

    /// Centres of the strips from the centre of buoyancy, along x \[m\].
    pub(super) fn strips(&self) -> [f64; STRIPS] {
        std::array::from_fn(|i| self.length * ((i as f64 + 0.5) / STRIPS as f64 - 0.5))
    }

    /// Corners of its base from the centre of buoyancy, along x and y \[m\].
    pub(super) fn ends(&self) -> [[f64; 2]; 4] {
        let (x, y) = (0.5 * self.length, 0.5 * self.width);
        [[x, y], [x, -y], [-x, y], [-x, -y]]
    }

    /// Largest vertical distance of any part from the centre of buoyancy \[m\].
    pub(super) fn reach(&self) -> f64 {
        0.5 * (self.length + self.width + self.height)
    }
}
