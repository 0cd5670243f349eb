//! The energy balance of the supply.
//!
//! ```text
//! supply = throttling + seal + compression + viscous + friction + load + mechanical + stops + lines + line friction
//! ```
//! Every term is a separate integral, so the balance is a real check. The energy of switching is electrical and not included.

use crate::circuit::{MOST_EDGES, MOST_LEVELS};

/// Works since the start, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ledger {
    /// Work of all levels: for each level, its pressure times the volume that left it.
    pub supply: f64,
    /// The same work, by level; negative if a level received oil.
    pub levels: [f64; MOST_LEVELS],
    /// Lost in the valves of each edge.
    pub throttling: [f64; MOST_EDGES],
    /// Lost past the piston.
    pub seal: f64,
    /// Stored in the oil, net: compression work minus recovered work.
    pub compression: f64,
    /// Compression work.
    pub compressed: f64,
    /// Lost to viscous friction.
    pub viscous: f64,
    /// Lost to Coulomb friction.
    pub friction: f64,
    /// Work on the load cycle's force.
    pub load: f64,
    /// Gain of kinetic energy and of the energy in spring, weight and elastic stops.
    pub mechanical: f64,
    /// Lost at the stops.
    pub stops: f64,
    /// Gain of energy in the lines: compressed and moving oil.
    pub lines: f64,
    /// Lost to the oil's friction in the lines.
    pub line_friction: f64,
    /// Electrical energy of the solenoids.
    pub switching: f64,
}

impl Ledger {
    /// The sum of two, term by term.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        let mut sum = *self;
        let mut other = *other;
        for (term, other) in sum.terms().into_iter().zip(other.terms()) {
            *term += *other;
        }
        sum
    }

    /// Each term multiplied by a factor.
    #[must_use]
    pub fn times(&self, factor: f64) -> Self {
        let mut product = *self;
        for term in product.terms() {
            *term *= factor;
        }
        product
    }

    fn terms(&mut self) -> Vec<&mut f64> {
        let mut terms = vec![
            &mut self.supply,
            &mut self.seal,
            &mut self.compression,
            &mut self.compressed,
            &mut self.viscous,
            &mut self.friction,
            &mut self.load,
            &mut self.mechanical,
            &mut self.stops,
            &mut self.lines,
            &mut self.line_friction,
            &mut self.switching,
        ];
        terms.extend(self.levels.iter_mut().chain(&mut self.throttling));
        terms
    }

    /// The total loss in the valves.
    #[must_use]
    pub fn throttled(&self) -> f64 {
        self.throttling.iter().sum()
    }

    /// The residual of the balance, J.
    #[must_use]
    pub fn residual(&self) -> f64 {
        self.supply
            - (self.throttled()
                + self.seal
                + self.compression
                + self.viscous
                + self.friction
                + self.load
                + self.mechanical
                + self.stops
                + self.lines
                + self.line_friction)
    }

    /// The scale of the balance: the total work, J.
    #[must_use]
    pub fn turnover(&self) -> f64 {
        self.levels.iter().map(|work| work.abs()).sum::<f64>() + self.compressed
    }
}
