//! The division of an edge's flow among its valves.

/// Flows that differ by less than this share are equal except for rounding.
pub(crate) const SAME_FLOW: f64 = 1e-9;

/// A coding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, planesman_parameters::Choice)]
pub enum Coding {
    /// Binary, pulse code modulation: 1, 2, 4, 8, ...
    Pcm,
    /// Equal, pulse number modulation: 1, 1, 1, 1, ...
    Pnm,
    /// Fibonacci: 1, 1, 2, 3, 5, ...
    Fibonacci,
}

impl Coding {
    /// The relative sizes of `count` valves, the smallest 1.
    #[must_use]
    pub fn sizes(self, count: usize) -> Vec<f64> {
        let mut sizes: Vec<f64> = Vec::with_capacity(count);
        for place in 0..count {
            let next = match (self, place) {
                (Self::Pnm, _) | (_, 0) => 1.0,
                (Self::Pcm, _) => 2.0 * sizes[place - 1],
                (Self::Fibonacci, 1) => 1.0,
                (Self::Fibonacci, _) => sizes[place - 1] + sizes[place - 2],
            };
            sizes.push(next);
        }
        sizes
    }

    /// `count` valves with the total flow coefficient `total`.
    #[must_use]
    pub fn share(self, total: f64, count: usize) -> Vec<f64> {
        let sizes = self.sizes(count);
        let sum: f64 = sizes.iter().sum();
        sizes.into_iter().map(|size| total * size / sum).collect()
    }
}

/// An opening of an edge: a subset of its valves that is open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Opening {
    /// Bit i: valve i is open.
    pub mask: u32,
    /// The sum of their flow coefficients, m^3/(s sqrt(Pa)).
    pub k: f64,
}

/// All openings of valves with the coefficients `valves`, by their sum, the closed one first.
#[must_use]
pub fn openings(valves: &[f64]) -> Vec<Opening> {
    let mut all: Vec<Opening> = (0..1_u32 << valves.len())
        .map(|mask| Opening {
            mask,
            k: valves
                .iter()
                .enumerate()
                .filter(|(place, _)| mask >> place & 1 == 1)
                .map(|(_, k)| k)
                .sum(),
        })
        .collect();
    all.sort_by(|one, other| one.k.total_cmp(&other.k).then(one.mask.cmp(&other.mask)));
    all
}

/// The number of different nonzero flows of these valves.
#[must_use]
pub fn levels(valves: &[f64]) -> usize {
    let mut count = 0;
    let mut last = 0.0;
    for opening in openings(valves) {
        if opening.k > last * (1.0 + SAME_FLOW) {
            count += 1;
            last = opening.k;
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn five_valves_have_the_levels_of_the_literature() {
        // 2^5 - 1 binary; 1 + 1 + 2 + 3 + 5 = 12 Fibonacci; 5 equal ones.
        let of = |coding: Coding| levels(&coding.sizes(5));
        assert_eq!(
            [Coding::Pcm, Coding::Fibonacci, Coding::Pnm].map(of),
            [31, 12, 5]
        );
    }
}
