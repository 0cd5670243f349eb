//! The time of one row of recursive least squares.
//!
//! ```text
//! cargo bench -p planesman_identification --bench recursive
//! benches/peers/run --only recursive                               beside padasip
//! ```
//!
//! The difference equation `y_k = sum a_i y_(k-i) + b_i u_(k-i)` of orders 2 and 8, rows of 4 and 16 numbers, forgetting 0.99. After every row the
//! parameters are read, as a live identifier does. Times are the best of several rounds.

use std::{hint::black_box, time::Instant};

use planesman_identification::RecursiveLeastSquares;

const ROUNDS: usize = 20;
const ROWS: usize = 2000;
const FORGETTING: f64 = 0.99;

fn main() {
    for order in [2, 8] {
        let rows = rows(order);
        let mut shortest = f64::INFINITY;
        let mut learnt = Vec::new();
        for _ in 0..ROUNDS {
            let Ok(mut rls) = RecursiveLeastSquares::new(2 * order, FORGETTING, 1e8) else {
                return;
            };
            let start = Instant::now();
            for (row, output) in &rows {
                rls.update(black_box(row), *output);
                black_box(rls.parameters());
            }
            shortest = shortest.min(start.elapsed().as_secs_f64());
            learnt = rls.parameters().iter().copied().collect();
        }
        println!(
            "planesman_identification, recursive least squares, order {order}: {:.1} ns a row, a1 {:.6}, b1 {:.6}",
            shortest / ROWS as f64 * 1e9,
            learnt[0],
            learnt[order]
        );
    }
}

/// Rows of past outputs and inputs, each with its output: two poles at 0.9 and 0.8, gains 0.1 and 0.05, an input of pseudo-random signs.
fn rows(order: usize) -> Vec<(Vec<f64>, f64)> {
    let mut register = 1_u32;
    let (mut u, mut y) = (vec![0.0; order], vec![0.0; order]);
    (0..ROWS)
        .map(|_| {
            // x^16 + x^14 + x^13 + x^11 + 1
            let bit = (register ^ (register >> 2) ^ (register >> 3) ^ (register >> 5)) & 1;
            register = (register >> 1) | (bit << 15);
            let n = u.len();
            let output = 1.7 * y[n - 1] - 0.72 * y[n - 2] + 0.1 * u[n - 1] + 0.05 * u[n - 2];
            let past =
                |series: &[f64]| -> Vec<f64> { series.iter().rev().take(order).copied().collect() };
            let row = [past(&y), past(&u)].concat();
            y.push(output);
            u.push(if bit == 1 { 1.0 } else { -1.0 });
            (row, output)
        })
        .collect()
}
