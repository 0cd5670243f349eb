//! The reports' numbers, pages and help, as the program prints them.

use std::collections::BTreeMap;
use std::process::{Command, Output};

use crate::browser;

use planesman_reports::book::Verdict;
use planesman_reports::brunner_1988::REPORT;
use planesman_testing::content;

fn reports(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_planesman-reports"))
        .args(args)
        .output()
        .expect("run")
}

/// The count in front of `what` among the totals.
fn total(text: &str, what: &str) -> usize {
    text.lines()
        .find_map(|l| l.trim().strip_suffix(what)?.trim().parse().ok())
        .unwrap_or_else(|| panic!("no total '{what}' in\n{text}"))
}

/// How many recomputed numbers the book has with each verdict.
fn verdicts() -> BTreeMap<Verdict, usize> {
    let book = (REPORT.book)().expect("a book");
    let recomputed: BTreeMap<_, _> = (REPORT.recomputed)().into_iter().collect();
    let mut counts = BTreeMap::new();
    for entry in book.entries() {
        // A coefficient of Table 1 counts once: in the unit of its second column.
        if let Some(verdict) = entry.verdict
            && entry.counted_with.is_none()
            && recomputed.contains_key(entry.id.as_str())
        {
            *counts.entry(verdict).or_default() += 1;
        }
    }
    counts
}

#[test]
fn every_number_of_the_report_has_the_verdict_that_stands_in_the_book() {
    let folder = tempfile::tempdir().expect("a folder");
    let page = folder.path().join("page.html");
    let path = page.to_str().expect("UTF-8");
    let run = reports(&["reproduce", "--all", "--html", path]);
    let text = String::from_utf8(run.stdout).expect("UTF-8");
    assert!(run.status.success(), "{text}");

    assert_eq!(total(&text, "changed from the book"), 0);
    let expected = verdicts();
    for (what, verdict) in [
        ("printed, agree within their rounding", Verdict::Agrees),
        ("printed, agree approximately", Verdict::Approximate),
        ("printed, contradicted", Verdict::Contradicts),
    ] {
        assert_eq!(total(&text, what), expected[&verdict], "{what}");
    }
    // What the parts of the book came to when this was written.
    assert!(expected[&Verdict::Agrees] >= 194);
    let again = "counted above; they agree in another unit or with the other surrogate missile";
    assert_eq!(total(&text, again), 9);
    assert!(expected[&Verdict::Approximate] >= 43);
    assert!(expected[&Verdict::Contradicts] >= 10);
    assert!(total(&text, "not printed, recomputed") >= 448);
    for (number, erratum) in [
        ("ind.aft_W", "E12"),
        ("pow.cd02", "E13"),
        ("depth.Kpz_limit_U1", "E3"),
        ("depth.Ucrit_B.34", "E4"),
        ("roll.wn", "E5"),
        ("Tab9.9/1.zd4.a4", "E19"),
    ] {
        let line = text
            .lines()
            .find(|l| l.split_whitespace().next() == Some(number))
            .expect(number);
        assert!(
            line.contains("contradicts") && line.ends_with(erratum),
            "{line}"
        );
    }

    assert!(text.contains("Run 9/2, gyro to plane command") && text.contains("6) compare"));

    let html = std::fs::read_to_string(&page).expect("written");
    assert!(html.len() < 3_000_000, "{} bytes", html.len());
    let html = content(&html);
    assert_eq!(
        html.matches("<figure class=\"plot\">").count(),
        13 + 11 + 12 + 13 + 12 + 43 + 1,
        "figures B1 to B10, the loci, the time responses, the calibrations, the runs, the actuator's, and Hopsan's"
    );
    for part in [
        "Fig. B1",
        "Fig. B10",
        "Fig. 21",
        "Fig. 56",
        "id=\"E25\"",
        "pow.cd02",
        "Fig. 3-1",
        "Fig. 4-11",
        "Fig. 5-7",
        "surrogate missile",
        "id=\"D1\"",
        "T4-2.base.Kg_stable",
    ] {
        assert!(html.contains(part), "{part}");
    }
    browser::assert_alive(&page, 13 + 11 + 12 + 13 + 12 + 43 + 1);
    browser::assert_prints_lines(&page);
}

/// What the models are given and only read back is counted apart: Tables 3-1 and 4-1 of 1966.
#[test]
fn the_summary_has_the_contradictions_and_the_files_have_every_number() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (csv, json) = (path("book.csv"), path("book.json"));
    let run = reports(&["reproduce", "--csv", &csv, "--json", &json]);
    let text = String::from_utf8(run.stdout).expect("UTF-8");
    assert!(run.status.success(), "{text}");
    assert!(
        text.contains("plane.F2_30") && !text.contains("Tab1.Zw.dim"),
        "{text}"
    );

    let rows = std::fs::read_to_string(&json).expect("written");
    let rows: Vec<serde_json::Value> = serde_json::from_str(&rows).expect("JSON");
    let read_back = rows.iter().filter(|row| row["verdict"] == "read back");
    let of_1966: Vec<_> = read_back.map(|row| row["family"].as_str()).collect();
    assert_eq!(of_1966.len(), 39);
    assert!(
        of_1966
            .iter()
            .flatten()
            .all(|it| it.starts_with("Table 3-1") || it.starts_with("Table 4-1"))
    );
    let told = |verdict: &str| -> Vec<&str> {
        let its = rows.iter().filter(|row| row["verdict"] == verdict);
        its.filter_map(|row| row["number"].as_str()).collect()
    };
    // What PS-2 was made to give: a row of Table 4-2, three runs of Table 4-3.
    let calibrated = told("calibrated on");
    assert_eq!(calibrated.len(), 7, "{calibrated:?}");
    assert!(calibrated.contains(&"T4-3.C-13A") && calibrated.contains(&"T4-2.base.Kg_stable"));
    // Cells of Table 3-2 that PS-1 gives and PS-2 does not.
    let surrogate = told("surrogate");
    for row in ["model", "C=6", "beta_V=13300", "beta_V=100000"] {
        assert!(surrogate.contains(&format!("T3-2.{row}.max_pos_step").as_str()));
    }
    assert!(surrogate.iter().all(|it| it.starts_with("T3-2.")));
    // Every printed cell has a verdict with PS-1 too.
    let again = ["agrees again", "approximate again", "contradicts again"].map(told);
    let with_ps_1 = again.iter().flatten().filter(|it| it.starts_with("PS-1."));
    assert_eq!(with_ps_1.count(), 58);
    assert!(!told("not printed").contains(&"PS-1.T4-2.base.max_pos_step"));
    let unnamed = rows
        .iter()
        .filter(|row| row["name"].is_null() || row["family"].is_null());
    assert_eq!(unnamed.count(), 0);
    let mut table = csv::Reader::from_path(&csv).expect("written");
    assert_eq!(table.records().count(), rows.len());
}

#[test]
fn the_theory_beside_the_identified_models_is_that_of_the_plant() {
    let values: BTreeMap<_, _> = (REPORT.recomputed)().into_iter().collect();
    for (run, speed) in [("9/2", 1.8), ("7/3", 1.2), ("8/1", 2.1)] {
        for (identified, plant) in [("dc_pred", "gain_norest"), ("pole_pred", "BJ")] {
            let theory = values[format!("Tab9.{run}.qd2.{identified}").as_str()];
            let plant = values[format!("P2.U{speed}.{plant}").as_str()];
            assert!((theory - plant).abs() < 1e-12, "{run}: {theory}, {plant}");
        }
    }
}

#[test]
fn a_page_that_cannot_be_written_is_refused_in_one_line_before_anything_is_computed() {
    let there = tempfile::NamedTempFile::new().expect("a file");
    let there = there.path().display().to_string();
    for path in ["/no/such/folder/page.html", &there] {
        let run = reports(&["reproduce", "--html", path]);
        let error = String::from_utf8_lossy(&run.stderr);
        assert_eq!(run.status.code(), Some(2));
        assert!(run.stdout.is_empty());
        assert_eq!(error.lines().count(), 1, "{error}");
        assert!(error.starts_with("planesman-reports: "), "{error}");
        assert!(error.contains(path), "{error}");
        assert!(
            error.contains("(see planesman-reports reproduce --help)"),
            "{error}"
        );
    }
}

#[test]
fn the_page_of_limit_cycles_tells_its_values_under_the_cursor() {
    let folder = tempfile::tempdir().expect("a folder");
    let page = folder.path().join("cycles.html");
    let path = page.to_str().expect("UTF-8");
    let cycles = ["limit-cycles", "open loop, two speed", "--no-prediction"];
    let run = reports(&[&cycles[..], &["--html", path]].concat());
    assert!(run.status.success(), "{run:?}");
    // Frequency, depth, and the orbits of three configurations.
    browser::assert_alive(&page, 5);
}

#[test]
fn every_help_text_has_an_example_within_eighty_columns() {
    for command in ["reproduce", "bench", "limit-cycles", "frequency", "tf"] {
        let run = reports(&[command, "--help"]);
        let text = String::from_utf8(run.stdout).expect("UTF-8");
        assert!(run.status.success() && text.contains("\nExample"), "{text}");
        for line in text.lines() {
            assert!(line.chars().count() <= 80, "{command}: {line}");
        }
    }
}

/// Like `planesman frequency` and `tf --as-printed` hand them over.
#[test]
fn what_the_program_hands_over_is_printed() {
    for (arguments, says) in [
        ("frequency table_4_1", "10.45 volumes per second"),
        ("tf brunner --as-printed --speed 1.2ft/s", "eq. (7a)"),
        ("bench --table 4-3 --format csv", "C-14"),
    ] {
        let run = reports(&arguments.split(' ').collect::<Vec<_>>());
        let text = String::from_utf8(run.stdout).expect("UTF-8");
        assert!(run.status.success() && text.contains(says), "{text}");
    }
}
