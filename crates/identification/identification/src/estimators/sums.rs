//! Sums of products.

/// The scalar product, as eight parallel sums.
pub(crate) fn dot(f: &[f64], g: &[f64]) -> f64 {
    let (f, g) = (f.chunks_exact(8), g.chunks_exact(8));
    let rest = (f.remainder().iter().zip(g.remainder())).map(|(f, g)| f * g);
    let rest: f64 = rest.sum();
    let mut sums = [0.0; 8];
    for (f, g) in f.zip(g) {
        for i in 0..8 {
            sums[i] += f[i] * g[i];
        }
    }
    sums.iter().sum::<f64>() + rest
}
