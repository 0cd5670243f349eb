//! Global search without derivatives, with identical results on every machine.

/// Probability that a member takes a coordinate from its trial point.
const CROSSOVER: f64 = 0.9;

/// The point between bounds with the lowest cost, and its cost: differential evolution (Storn and Price, *J. Global Optimization* 11, 1997;
/// strategy current-to-best/1/bin with a factor from 0.5 to 1), with a fixed seed. `costs` evaluates many points at once; a pair as cost puts
/// violated limits before the value. The search ends once the costs of all members are `alike` the lowest one.
///
/// # Errors
/// Those of `costs`.
pub fn lowest<const N: usize, C: PartialOrd + Copy, E>(
    bounds: &[(f64, f64); N],
    members: usize,
    generations: usize,
    alike: impl Fn(C, C) -> bool,
    mut costs: impl FnMut(&[[f64; N]]) -> Result<Vec<C>, E>,
) -> Result<([f64; N], C), E> {
    let mut random = Random(1);
    let mut all: Vec<[f64; N]> = (0..members.max(4))
        .map(|_| bounds.map(|(low, high)| low + (high - low) * random.uniform()))
        .collect();
    let mut values = costs(&all)?;
    let lowest_of = |values: &[C]| {
        (1..values.len()).fold(0, |best, i| match values[i] < values[best] {
            true => i,
            false => best,
        })
    };
    for _ in 0..generations {
        let least = lowest_of(&values);
        let best = all[least];
        if values.iter().all(|it| alike(values[least], *it)) {
            break;
        }
        let trials: Vec<[f64; N]> = all
            .iter()
            .map(|own| {
                let [a, b] = [(); 2].map(|()| all[random.below(all.len())]);
                let (factor, forced) = (0.5 + 0.5 * random.uniform(), random.below(N));
                std::array::from_fn(|j| {
                    if random.uniform() > CROSSOVER && j != forced {
                        return own[j];
                    }
                    let to = own[j] + factor * (best[j] - own[j] + a[j] - b[j]);
                    match bounds[j] {
                        (low, _) if to < low => 0.5 * (own[j] + low),
                        (_, high) if to > high => 0.5 * (own[j] + high),
                        _ => to,
                    }
                })
            })
            .collect();
        for (i, cost) in costs(&trials)?.into_iter().enumerate() {
            if cost <= values[i] {
                (all[i], values[i]) = (trials[i], cost);
            }
        }
    }
    let best = lowest_of(&values);
    Ok((all[best], values[best]))
}

/// Random generator splitmix64 (Steele, Lea and Flood, OOPSLA 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// Uniform random number in [0, 1).
    fn uniform(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn below(&mut self, count: usize) -> usize {
        (self.next() % count as u64) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rastrigin's function has about 10^4 valleys in this range; the limit x_0 >= 0.3 makes the lowest one end at a wall.
    #[test]
    fn the_lowest_of_many_valleys_is_found_at_a_limit() {
        let cost = |x: &[f64; 4]| {
            let terms = x
                .iter()
                .map(|x| x * x + 10.0 * (1.0 - libm::cos(2.0 * std::f64::consts::PI * x)));
            ((0.3 - x[0]).max(0.0), terms.sum::<f64>())
        };
        let of = |all: &[[f64; 4]]| Ok::<_, ()>(all.iter().map(cost).collect());
        let (at, (missed, value)) =
            lowest(&[(-5.0, 5.0); 4], 60, 400, |p: (f64, f64), q| p == q, of).unwrap();
        // Beyond the limit the valley at x_0 = 1 is the lowest: 0.995 (scipy's differential_evolution agrees).
        assert_eq!(missed, 0.0);
        assert!((value - 0.995).abs() < 1e-3, "{at:?} {value}");
    }
}
