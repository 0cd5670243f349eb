//! Normal random numbers with mean 0 and variance 1, bit-identical on every machine.
//!
//! The ziggurat of Marsaglia and Tsang, "The ziggurat method for generating random variables", J. Stat. Software 5 (2000), with 256 layers.
//! The crate `rand_distr` also uses this method, and gives the same numbers within the ten digits of its table, but with the C library's logarithm.

use std::sync::LazyLock;

use rand_pcg::{Pcg64, rand_core::Rng as _};

/// Begin of the tail.
const TAIL: f64 = 3.654152885361009;
const LAYERS: usize = 256;

/// Right edge of each layer, from the lowest up to 0, and the density at this edge.
static EDGES: LazyLock<[(f64, f64); LAYERS + 1]> = LazyLock::new(|| {
    // Every layer has the area of the lowest: its rectangle and the tail.
    let tail = std::f64::consts::FRAC_PI_2.sqrt() * libm::erfc(TAIL / std::f64::consts::SQRT_2);
    let area = TAIL * density(TAIL) + tail;
    let mut edges = [(0.0, 1.0); LAYERS + 1];
    let mut edge = area / density(TAIL);
    for (layer, at) in edges.iter_mut().enumerate().take(LAYERS) {
        *at = (edge, density(edge));
        edge = match layer {
            0 => TAIL,
            _ => (-2.0 * libm::log(area / edge + density(edge))).sqrt(),
        };
    }
    edges
});

fn density(x: f64) -> f64 {
    libm::exp(-x * x / 2.0)
}

/// Draws the next normal number.
pub fn standard_normal(random: &mut Pcg64) -> f64 {
    loop {
        let bits = random.next_u64();
        let layer = (bits & 0xff) as usize;
        // 52 bits, from -1 to below 1.
        let u = (bits >> 12) as f64 * (0.5_f64).powi(51) - 1.0;
        let ((edge, low), (inner, high)) = (EDGES[layer], EDGES[layer + 1]);
        let x = u * edge;
        if x.abs() < inner {
            return x;
        }
        if layer == 0 {
            return tail(random).copysign(u);
        }
        let level = (random.next_u64() >> 11) as f64 * (0.5_f64).powi(53);
        if high + (low - high) * level < density(x) {
            return x;
        }
    }
}

/// Draws a number of the tail, by Marsaglia's method of 1964.
fn tail(random: &mut Pcg64) -> f64 {
    // Between 0 and 1, neither of them.
    let mut open = || ((random.next_u64() >> 12) as f64 + 0.5) * (0.5_f64).powi(52);
    loop {
        let x = -libm::log(open()) / TAIL;
        let y = -libm::log(open());
        if 2.0 * y >= x * x {
            return TAIL + x;
        }
    }
}

#[cfg(test)]
mod tests {
    use rand_pcg::rand_core::SeedableRng as _;

    use super::*;

    /// Numbers of `rand_distr::StandardNormal` 0.6.0 from the same generator, and their places: the first, and some of the tail. As
    /// a dependency it would give num-traits a feature with which all of the release build would be built once more for the tests.
    const RAND_DISTR: [(usize, f64); 9] = [
        (2, -1.587966701481),
        (3, 1.068765135906),
        (4, 0.112267521937),
        (5, 0.903964226903),
        (3919, 4.102362396588),
        (15297, 3.657347474398),
        (27788, -4.638122068947),
        (146183, -4.398381006171),
        (197735, -3.899395338937),
    ];

    #[test]
    fn the_numbers_are_those_of_rand_distr_to_nine_digits() {
        let mut random = Pcg64::seed_from_u64(3);
        let numbers: Vec<f64> = (0..200_000).map(|_| standard_normal(&mut random)).collect();
        for (place, expected) in RAND_DISTR {
            let found = numbers[place];
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
        let sums = [1, 2, 3].map(|power| numbers.iter().map(|it| it.powi(power)).sum::<f64>());
        let expected = [-314.9133557902981, 200104.70789458865, -435.3960227923054];
        for (found, expected) in sums.into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-4, "{found} {expected}");
        }
    }
}
