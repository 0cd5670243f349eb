//! The pages as a reader sees them: in a browser, drawn by their own scripts, from a file.

use crate::browser;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use browser::{assert_alive, assert_prints_lines};
use planesman::run_folder::RunFolder;
use planesman_flight::scenario::Scenario;
use planesman_flight::{Parts, fly};
use planesman_testing::content;

fn planesman(folder: &Path, arguments: &[&str]) -> Output {
    let run = Command::new(env!("CARGO_BIN_EXE_planesman"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap();
    let complaint = String::from_utf8_lossy(&run.stderr);
    assert!(run.status.success(), "{arguments:?}: {complaint}");
    run
}

/// A flight in one process into a flight's folder.
fn flown(folder: &Path, name: &str, gain: f64) -> PathBuf {
    let path = folder.join(name);
    let run = RunFolder::free(Some(&path), name).unwrap();
    let scenario = format!(
        "description: {name}\nduration: 60.0\nparameters:\n  depth_controller:\n    depth_setpoint: 0.9\n    depth.p: {gain}\n"
    );
    let scenario = Scenario::parse(&scenario).unwrap();
    run.create(&scenario, "").unwrap();
    let bag = folder.join(format!("{name}.mcap"));
    fly(&scenario, &Parts::default(), &bag, "/auv", &()).unwrap();
    std::fs::create_dir(run.bag()).unwrap();
    std::fs::rename(bag, run.bag().join("bag_0.mcap")).unwrap();
    path
}

#[test]
fn a_flight_and_two_over_each_other_tell_their_values_under_the_cursor() {
    let folder = tempfile::tempdir().unwrap();
    let page = flown(folder.path(), "slow", 0.8).join("report.html");
    flown(folder.path(), "fast", 1.4);
    planesman(folder.path(), &["report", "slow"]);
    let size = std::fs::metadata(&page).unwrap().len();
    assert!(size < 1_000_000, "{size} bytes");
    let run = planesman(folder.path(), &["report", "slow", "fast"]);
    let text = String::from_utf8(run.stdout).unwrap();
    let row = |name: &str| {
        let line = text.lines().find(|it| it.starts_with(name));
        let cells = line.unwrap().split("  ").map(str::trim);
        cells.filter(|it| !it.is_empty()).collect::<Vec<_>>()
    };
    assert_eq!(row("         ")[..], ["slow", "fast", "difference"]);
    let number = |cell: &str| cell.split(' ').next().unwrap().parse::<f64>().unwrap();
    let [_, slow, fast, difference] = row("settling time (5 %)")[..] else {
        panic!("{text}");
    };
    assert!(
        (number(fast) - number(slow) - number(difference)).abs() < 1e-9,
        "{text}"
    );
    assert!(number(difference) < -1.0, "{text}");
    let both = std::fs::read_to_string(folder.path().join("flights.html")).unwrap();
    assert!(content(&both).contains("depth, slow") && content(&both).contains("depth, fast"));

    let Some(seen) = assert_alive(&page, 7) else {
        return;
    };
    let (heading, told) = &seen.plots[0];
    assert_eq!(heading, "Depth");
    assert!(told.contains("setpoint 0.9"), "{told}");
    // One instant in all plots over the time of the flight; the map of poles is no such plot, and the close-up ends before it.
    let place = &seen.together[0].1;
    assert!(place.starts_with("time 3"), "{place}");
    for (heading, other) in &seen.together {
        let has_it = !["Dive planes, close up", "Pole map"].contains(&heading.as_str());
        assert_eq!(other == place, has_it, "{heading}: {other}");
    }
    assert_alive(&folder.path().join("flights.html"), 7);
    assert_prints_lines(&page);
}

#[test]
fn models_loops_and_loci_tell_their_values_under_the_cursor() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    planesman(here, &["sim", "dive", "--out", "dive.csv"]);
    let fit = [
        "sysid",
        "fit",
        "dive.csv",
        "-i",
        "dive_planes",
        "-o",
        "pitch_rate",
        "--method",
        "oe",
        "--order",
        "3",
    ];
    planesman(here, &[&fit[..], &["--html", "model.html"]].concat());
    planesman(
        here,
        &["design", "analyse", "brunner", "--html", "analyse.html"],
    );
    for (varied, to) in [("depth_d", "5"), ("speed", "1")] {
        let page = format!("{varied}.html");
        let locus = ["design", "locus", "brunner", "--vary", varied, "--to", to];
        planesman(here, &[&locus[..], &["--html", &page]].concat());
    }
    if let Some(seen) = assert_alive(&here.join("model.html"), 10) {
        // The data's step response without a model is beside the model's.
        let step = seen.plots.iter().find(|it| it.0 == "Step response");
        let told = step.map_or("", |it| &it.1);
        assert!(
            told.contains("model -0.") && told.contains("data alone -0."),
            "{told}"
        );
    }
    assert_prints_lines(&here.join("model.html"));
    assert_alive(&here.join("analyse.html"), 5);
    if let Some(seen) = assert_alive(&here.join("depth_d.html"), 1) {
        let (_, told) = &seen.plots[0];
        assert!(
            told.contains("open-loop poles zeros between last value"),
            "{told}"
        );
    }
    if let Some(seen) = assert_alive(&here.join("speed.html"), 1) {
        // A pole of the locus is told with its speed.
        let (_, told) = &seen.plots[0];
        assert!(told.contains(", speed "), "{told}");
    }
}

#[test]
fn a_heat_map_tells_its_fields_under_the_cursor() {
    let folder = tempfile::tempdir().unwrap();
    let vary = [
        "--vary",
        "depth_controller.depth.p=0.6,1.0",
        "--vary",
        "plant_sim.speed=0.3,0.5",
    ];
    planesman(
        folder.path(),
        &[&["sweep", "dive", "--out", "sweep"], &vary[..]].concat(),
    );
    let Some(seen) = assert_alive(&folder.path().join("sweep/report.html"), 3) else {
        return;
    };
    assert_eq!(seen.plots[0].0, "Settling time (5 %) [s]");
    // The same field in both maps; the best one is said.
    let field = "at depth.p [rad/m] 1, speed [m/s] 0.3";
    for (heading, place) in &seen.together[..2] {
        assert!(place.ends_with(field), "{heading}: {place}");
    }
    assert!(seen.document.contains("★ best: "));
}

#[test]
fn the_page_of_a_table_of_designs_tells_its_values_under_the_cursor() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    planesman(here, &["design", "table", "--html", "table.html"]);
    assert_alive(&here.join("table.html"), 2);
}

#[test]
fn a_script_in_the_name_of_a_signal_is_not_run() {
    let folder = tempfile::tempdir().unwrap();
    let name =
        "</script><script>document.title='run'</script><img src=x onerror=document.title='run'>";
    let mut table = format!("t,u,\"{name}\"\n");
    let mut y = 0.0;
    for k in 0..400_i32 {
        let u = if (k / 20) % 2 == 0 { 1.0 } else { -1.0 };
        writeln!(table, "{},{u},{y}", f64::from(k) * 0.1).unwrap();
        y = 0.9 * y + 0.1 * u;
    }
    std::fs::write(folder.path().join("a.csv"), table).unwrap();
    let fit = [
        "sysid", "fit", "a.csv", "-i", "u", "-o", name, "--method", "arx", "--order", "1",
    ];
    planesman(
        folder.path(),
        &[&fit[..], &["--html", "model.html"]].concat(),
    );
    if let Some(seen) = browser::look(&folder.path().join("model.html")) {
        assert!(seen.errors.is_empty(), "{:?}", seen.errors);
        assert!(seen.plots.len() >= 8);
        assert!(!seen.document.contains("<title>run</title>") && !seen.document.contains("<img"));
    }
}
