//! Reproducible white noise for simulated records, the same numbers from any program.
//!
//! Twelve uniform numbers minus six, from `x <- 1664525 x + 1013904223 mod 2^32`.

/// `count` numbers with mean zero and variance one.
#[must_use]
pub fn noise(seed: u32, count: usize) -> Vec<f64> {
    let mut x = seed;
    let mut uniform = || {
        x = x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (f64::from(x) + 0.5) / 4_294_967_296.0
    };
    (0..count)
        .map(|_| (0..12).map(|_| uniform()).sum::<f64>() - 6.0)
        .collect()
}

/// Values plus noise with standard deviation `size`.
#[must_use]
pub fn with_noise(values: &[f64], seed: u32, size: f64) -> Vec<f64> {
    values
        .iter()
        .zip(noise(seed, values.len()))
        .map(|(y, e)| y + size * e)
        .collect()
}
