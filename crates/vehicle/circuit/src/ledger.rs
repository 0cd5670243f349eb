//! Where the work of the supply goes.
//!
//! ```text
//! supply = throttling + seal + compression + viscous + friction + load + mechanical + stops + lines + line friction
//! ```
//! Every term is an integral of its own, so that the balance is a check. Switching is electrical and beside it.

use crate::circuit::{MOST_EDGES, MOST_LEVELS};

/// Works since the start, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ledger {
    /// What all levels gave: the pressure of each times the volume that left it.
    pub supply: f64,
    /// The same by level; negative where a level took oil back.
    pub levels: [f64; MOST_LEVELS],
    /// Lost in the valves of each edge.
    pub throttling: [f64; MOST_EDGES],
    /// Lost past the piston.
    pub seal: f64,
    /// Stored in the oil, net: what compressed it less what it gave back.
    pub compression: f64,
    /// What compressed it.
    pub compressed: f64,
    /// Lost to viscous friction.
    pub viscous: f64,
    /// Lost to Coulomb friction.
    pub friction: f64,
    /// Done on the load's force of the load cycle.
    pub load: f64,
    /// Gained as kinetic energy, in spring, weight and elastic stops.
    pub mechanical: f64,
    /// Lost at the stops.
    pub stops: f64,
    /// Gained in the lines: oil compressed and in motion.
    pub lines: f64,
    /// Lost to the oil's friction in the lines.
    pub line_friction: f64,
    /// Electrical: the solenoids' energy.
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

    /// Each term so many times.
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

    /// All that the valves lost.
    #[must_use]
    pub fn throttled(&self) -> f64 {
        self.throttling.iter().sum()
    }

    /// What is missing in the balance, J.
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

    /// What the balance is to be compared with: all the work that went through it, J.
    #[must_use]
    pub fn turnover(&self) -> f64 {
        self.levels.iter().map(|work| work.abs()).sum::<f64>() + self.compressed
    }
}
