//! The time base: units, clocks that wrap or are set back, stamps that are too coarse, messages in bursts.

use std::fs;

use crate::answer::fit;
use crate::plant::{SAMPLES, STEP, log, table};

#[test]
fn a_table_with_seconds_gives_the_plant() {
    let folder = tempfile::tempdir().unwrap();
    let (u, y) = log(1, SAMPLES);
    let rows = (0..SAMPLES).map(|k| (format!("{:.2}", k as f64 * STEP), u[k], y[k]));
    fs::write(folder.path().join("log.csv"), table("t,u,y", rows)).unwrap();
    fit(folder.path(), &["log.csv", "-i", "u", "-o", "y"]).is_the_plant(SAMPLES as u64);
}
