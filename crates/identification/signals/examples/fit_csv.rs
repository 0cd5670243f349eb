//! Writes a CSV table of a known system, reads it back onto a grid, fits a model, and prints the verdict.
//!
//! ```sh
//! cargo run -p planesman_signals --example fit_csv
//! ```

use std::{fs, path::Path};

use planesman_identification::{
    analysis::{self, analyse},
    filter, noise, with_noise,
};
use planesman_signals::{CsvSource, Options, TableTime, read_record};

/// Time between two rows, s.
const SAMPLE_TIME: f64 = 0.05;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("table.csv");
    fs::write(&path, table())?;
    println!("{}", fit(&path)?);
    Ok(())
}

/// A system with poles at z = 0.9 and 0.7, its output measured with noise.
fn table() -> String {
    let input = noise(1, 800);
    let output = with_noise(
        &filter(&[0.0, 0.2, 0.1], &[1.0, -1.6, 0.63], &input),
        2,
        0.1,
    );
    let rows = input.iter().zip(&output).enumerate();
    let rows = rows.map(|(k, (u, y))| format!("{},{u},{y}\n", k as f64 * SAMPLE_TIME));
    "time,u,y\n".to_owned() + &rows.collect::<String>()
}

fn fit(path: &Path) -> Result<String, Box<dyn std::error::Error>> {
    let source = CsvSource::open(path, &TableTime::default())?;
    let names = |name: &str| [name.to_owned()];
    let prepared = read_record(
        &source,
        &names("u"),
        &names("y"),
        &[Options::default()],
        &|_| {},
    )?;
    let analysis = analyse(&prepared.resampled.record, &analysis::Options::default())?;
    Ok(analysis.text())
}
