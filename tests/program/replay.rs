//! `planesman replay` of tables: the truth is known, and changes at a known sample.

use std::fmt::Write as _;
use std::fs;

use clap::Parser;
use planesman::sysid::replay::ReplayArgs;
use planesman_identification::noise;
use planesman_identifier::replay::Replay;
use tempfile::TempDir;

const COUNT: usize = 600;
const CHANGE: usize = 300;
const INTERVAL: f64 = 0.1;

fn try_replay(folder: &TempDir, data: &str, more: &str) -> Result<Replay, String> {
    let path = folder.path().join(data).display().to_string();
    let args = ["replay", "--quiet", &path].into_iter();
    let args = ReplayArgs::try_parse_from(args.chain(more.split_whitespace()));
    let args = args.map_err(|error| error.to_string())?;
    args.replay().map_err(|error| format!("{error:#}"))
}

/// y_k = 0.8 y_(k-1) + g u_(k-1) + e_k, g = 0.2 and from sample 300 on 0.3, e normal of 0.002: `plant.csv`.
fn plant(folder: &TempDir) {
    let (signs, e) = (noise(4, COUNT), noise(5, COUNT));
    let mut text = String::from("time,u,y\n");
    let (mut y, mut u) = (0.0, 0.0);
    for k in 0..COUNT {
        let gain = if k < CHANGE { 0.2 } else { 0.3 };
        y = 0.8 * y + gain * u + 0.002 * e[k];
        u = if signs[k / 3] < 0.0 { -1.0 } else { 1.0 };
        let _ = writeln!(text, "{:.1},{u},{y}", INTERVAL * k as f64);
    }
    fs::write(folder.path().join("plant.csv"), text).unwrap();
}

#[test]
fn a_table_is_replayed_its_jump_told_and_every_estimate_written() {
    let folder = TempDir::new().unwrap();
    plant(&folder);
    let history = folder.path().join("history.csv");
    let more = format!(
        "-i u -o y -p order:=1 -p bias:=true --history {}",
        history.display()
    );
    let found = try_replay(&folder, "plant.csv", &more).unwrap();
    let estimate = &found.estimates[0];
    assert_eq!((&*estimate.input, &*estimate.output), ("u", "y"));
    assert_eq!(estimate.sample_time, INTERVAL);
    assert!(estimate.valid, "{}", estimate.reason);
    assert!((estimate.a[0] + 0.8).abs() < 0.005, "{}", estimate.a[0]);
    assert!((estimate.b[0] - 0.3).abs() < 0.002, "{}", estimate.b[0]);
    let (name, jump) = &found.jumps[0];
    let after = (jump.stamp as f64 * 1e-9 / INTERVAL).round() as usize - CHANGE;
    assert_eq!(name, "model");
    assert!(after <= 20, "{after}");

    let mut rows = csv::Reader::from_path(&history).unwrap();
    let columns = rows.headers().unwrap().clone();
    let at = |name: &str| columns.iter().position(|it| it == name).unwrap();
    let rows: Vec<csv::StringRecord> = rows.records().map(Result::unwrap).collect();
    // The first sample only begins the history.
    assert_eq!(rows.len(), COUNT - 1);
    let number = |row: &csv::StringRecord, name: &str| row[at(name)].parse::<f64>().unwrap();
    let jumps: Vec<f64> = (rows.iter().filter(|row| &row[at("event")] == "jump"))
        .map(|row| number(row, "time"))
        .collect();
    assert_eq!(jumps.len(), found.jumps.len());
    assert!((jumps[0] - jump.stamp as f64 * 1e-9).abs() < 1e-6);
    let before = &rows[CHANGE - 10];
    assert!((number(before, "b1") - 0.2).abs() < 4.0 * number(before, "b1_deviation"));
    let last = rows.last().unwrap();
    assert_eq!(number(last, "b1"), estimate.b[0]);
    assert_eq!(number(last, "bias"), estimate.bias);
    let of_bias = estimate.covariance.last().unwrap().sqrt();
    assert!((number(last, "bias_deviation") - of_bias).abs() < 1e-12);
    assert!((number(last, "b1_deviation") - estimate.covariance[4].sqrt()).abs() < 1e-12);
}

#[test]
fn a_grid_of_ones_own_is_that_of_the_estimate_and_what_does_not_fit_is_refused() {
    let folder = TempDir::new().unwrap();
    plant(&folder);
    for more in ["--rate 5", "-p sample_time:=0.2"] {
        let found = try_replay(
            &folder,
            "plant.csv",
            &format!("-i u -o y -p order:=1 {more}"),
        );
        assert_eq!(found.unwrap().estimates[0].sample_time, 0.2, "{more}");
    }
    fs::create_dir(folder.path().join("bag")).unwrap();
    for (data, more, reason) in [
        ("plant.csv", "-i u", "-o is missing"),
        ("plant.csv", "-i u -o z", "no column 'z'"),
        ("plant.csv", "-i u -o y -p order:=0", "order"),
        ("bag", "--rate 5", "for tables and logs"),
    ] {
        let refusal = try_replay(&folder, data, more).unwrap_err();
        assert!(refusal.contains(reason), "{refusal}");
    }
}
