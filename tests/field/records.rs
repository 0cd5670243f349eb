//! What a record has in it: integrators, and inputs with a mean.

use std::fs;

use planesman_testing::near;

use crate::answer::fit;
use crate::plant::{STEP, noise, prbs, second_order, table};

#[test]
fn an_integrator_behind_an_input_with_a_mean_is_good_and_its_gain_is_told() {
    let folder = tempfile::tempdir().unwrap();
    for (mean, seed) in [(0.0, 1), (2.0, 2), (-5.0, 3)] {
        // 0.5/(s (s + 1)).
        let u: Vec<f64> = prbs(seed, 4000).iter().map(|u| u + mean).collect();
        let y = second_order([0.5, 1.0, 0.0], STEP, &u);
        let y: Vec<f64> = y
            .iter()
            .zip(noise(9, 4000))
            .map(|(y, e)| y + 0.02 * e)
            .collect();
        let rows = (0..4000).map(|k| (format!("{:.2}", k as f64 * STEP), u[k], y[k]));
        fs::write(folder.path().join("log.csv"), table("t,u,y", rows)).unwrap();
        let answer = fit(folder.path(), &["log.csv", "-i", "u", "-o", "y"]);
        answer.says("verdict: good");
        near(answer.number("integrator_gain/0"), 0.5, 0.002);
        near(answer.number("model/continuous_poles/0/re"), -1.0, 0.01);
    }
}
