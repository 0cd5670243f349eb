//! `planesman sweep`: flies a scenario many times ([`planesman_flight::sweep`]) and writes a page of the results.

use std::fmt::Write as _;
use std::num::NonZero;
use std::path::{Path, PathBuf};

use crate::arguments::{make_way, make_way_for_folder};
use crate::run_folder::dive_command;
use anyhow::Result;
use clap::Args;
use planesman_console::progress::Bars;
use planesman_console::{Outcome, Table};
use planesman_flight::Scenario;
use planesman_flight::scenario::plain;
use planesman_flight::sink::write_text;
use planesman_flight::summary::test_signal;
use planesman_flight::sweep::outcomes::{Outcomes, Settled};
use planesman_flight::sweep::space::{Axis, Space};
use planesman_flight::sweep::{Part, Sweep, file_of};
use planesman_linear::digits::significant;
use planesman_parameters::Value;
use planesman_text::{grouped, shell_word};

/// Maximum number of combinations that are printed.
const LISTED: usize = 10;

/// Arguments of `sweep`.
#[derive(Args)]
pub struct SweepArgs {
    #[arg(help = crate::arguments::scenario_help())]
    scenario: String,
    /// Set a parameter of a node in all cases, such as depth_controller.depth.p=1.2; may be repeated
    #[arg(long = "set", value_name = "NODE.PARAMETER=VALUE")]
    set: Vec<String>,
    /// Parameter to vary: a list (1ft/s,2ft/s or ideal,dha), a range with a step (0.4:1.6:0.1), or a range to sample (0.4..1.6); may be
    /// repeated, then every combination is flown
    #[arg(long, value_name = "NODE.PARAMETER=VALUES", required = true)]
    vary: Vec<String>,
    /// Number of seeds to fly each combination with, from the scenario's seed on
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    seeds: u32,
    /// Number of samples: a Latin hypercube over all parameters that vary as FROM..TO
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    samples: Option<u32>,
    /// Folder for the results; the same command resumes an interrupted sweep [default: runs/sweep-SCENARIO]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Fly only part I of N of the combinations, such as 1/4: for several machines, or batch jobs, that share a folder
    #[arg(long, value_name = "I/N", value_parser = shard, allow_hyphen_values = true)]
    shard: Option<Part>,
    /// Number of flights at the same time [default: number of cores]
    #[arg(long, value_name = "N")]
    jobs: Option<NonZero<usize>>,
}

/// Parses `I/N`: one part, and the number of parts.
fn shard(text: &str) -> Result<Part, String> {
    let parts = text.split_once('/').and_then(|(part, of)| {
        let (part, of) = (part.parse().ok()?, of.parse().ok()?);
        (1..=of).contains(&part).then_some(Part { part, of })
    });
    parts.ok_or_else(|| "I/N is expected, I from 1 to N".to_owned())
}

/// The files of a sweep's folder; the folder is recognised by the first one.
const OWN: [&str; 6] = [
    "sweep.yaml",
    "cases.csv",
    "cases.parquet",
    "cases-*.csv",
    "cases-*.parquet",
    "report.html",
];

/// Flies the cases that are not in the folder yet, and writes the page.
///
/// # Errors
/// A refused command line, before the first case; a folder that contains another sweep or cannot be written.
pub fn run(args: &SweepArgs) -> Result<()> {
    let sweep = Sweep::new(
        Scenario::load_with(&args.scenario, &args.set)?,
        &args.vary,
        args.samples,
        args.seeds,
    )?;
    sweep.check(&Bars::default())?;
    let folder = args.out.clone().unwrap_or_else(|| {
        let stem = Path::new(&args.scenario).file_stem().unwrap_or_default();
        Path::new("runs").join(format!("sweep-{}", stem.display()))
    });
    if args.shard.is_none() {
        make_way_for_folder(&folder, &OWN)?;
    }
    let parts = args.shard.map(|it| it.of);
    sweep.define(&folder, parts)?;
    if let Some(Part { part, of }) = args.shard {
        // The other parts are those of other machines.
        for ending in ["csv", "parquet"] {
            make_way(&folder.join(file_of(part, of)).with_extension(ending))?;
        }
    }

    let jobs = args
        .jobs
        .unwrap_or_else(|| std::thread::available_parallelism().unwrap_or(NonZero::<usize>::MIN));
    let flown = sweep.fly(&folder, args.shard, jobs, &Bars::default())?;
    let (scenario, space) = (sweep.scenario(), sweep.space());
    let signal = test_signal(scenario)?;
    let outcomes = Outcomes::read(&folder, parts, space)?;
    let page = folder.join("report.html");
    write_text(
        &page,
        planesman_show::pages::sweep::page(scenario, signal.as_ref(), space, &outcomes),
    )?;
    let settled = outcomes.settled();
    let mut notes = String::new();
    if flown.there > 0 {
        let _ = writeln!(
            notes,
            "{} of {} cases were simulated before this run.",
            flown.there, flown.all
        );
    }
    if outcomes.failed > 0 {
        let failed = outcomes.failed;
        let _ = writeln!(
            notes,
            "{failed} cases stopped early; the column 'error' gives the reason."
        );
    }
    if let Some(signal) = &signal {
        let _ = writeln!(notes, "Test signal: {signal}; {}.", signal.effect());
    }
    let mut outcome = Outcome::new(answer(space, &outcomes, &settled))
        .numbers(best(space, &settled).aligned())
        .numbers(notes)
        .file("Table", &flown.file)
        .file("Page", &page);
    if let Some(first) = settled.first() {
        let values = space.values(first.combination);
        let set = values.map(|(axis, value)| {
            format!(
                " --set {}",
                shell_word(&format!("{}={value}", axis.parameter))
            )
        });
        let dive = dive_command(&args.scenario);
        outcome = outcome.next(
            dive + &set.collect::<String>(),
            "fly the fastest combination",
        );
    }
    Ok(outcome.print()?)
}

/// The values of a combination, as text.
fn values(space: &Space, combination: u64) -> impl Iterator<Item = String> {
    space.values(combination).map(|(axis, value)| match value {
        Value::Double(number) if axis.is_sampled => significant(*number, 4),
        value => plain(value),
    })
}

/// A sentence about the fastest combination, and the number of combinations that settle.
fn answer(space: &Space, outcomes: &Outcomes, settled: &[Settled]) -> String {
    let (of, cases) = (outcomes.combinations.len(), grouped(outcomes.cases));
    let Some(first) = settled.first() else {
        return format!(
            "No combination of {of} settles within 5 % in every flight ({cases} cases)."
        );
    };
    let values = space.axes.iter().zip(values(space, first.combination));
    let values =
        values.map(|(axis, value)| format!("{} {value} {}", axis.parameter.name, axis.unit));
    format!(
        "Fastest of {of} combinations: {} settles in {} s (5 %) with {} rad of plane travel. {} of {of} settle in every flight ({cases} cases).",
        values
            .map(|it| it.trim_end().to_owned())
            .collect::<Vec<_>>()
            .join(", "),
        significant(first.settling, 3),
        significant(first.travel, 3),
        settled.len()
    )
}

/// The combinations that no other one beats in both settling time and plane travel.
fn best(space: &Space, settled: &[Settled]) -> Table {
    let names: Vec<String> = space.axes.iter().map(Axis::label).collect();
    let results = ["settling time (5 %) [s]", "plane travel [rad]"];
    let mut table = Table::of(names.iter().map(String::as_str).chain(results));
    for it in settled.iter().filter(|it| it.is_on_front).take(LISTED) {
        let results = [it.settling, it.travel].map(|it| significant(it, 3));
        table.row(values(space, it.combination).chain(results));
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENARIO: &str = "
description: short
duration: 4.0
parameters:
  depth_controller: {depth_setpoint: 0.1}
";

    fn args(folder: &Path, out: &str) -> SweepArgs {
        let scenario = folder.join("short.yaml");
        std::fs::write(&scenario, SCENARIO).expect("written");
        SweepArgs {
            scenario: scenario.display().to_string(),
            set: Vec::new(),
            vary: vec![
                "depth_controller.depth.p=0.5:1.5:0.5".to_owned(),
                "plant_sim.speed=1ft/s,2ft/s".to_owned(),
            ],
            seeds: 2,
            samples: None,
            out: Some(folder.join(out)),
            shard: None,
            jobs: NonZero::new(3),
        }
    }

    fn text(folder: &Path, name: &str) -> String {
        std::fs::read_to_string(folder.join(name)).expect("read")
    }

    #[test]
    fn a_sweep_has_a_row_a_case_whether_whole_interrupted_or_in_parts() {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = folder.path();
        let whole = args(folder, "whole");
        run(&whole).expect("swept");
        let rows = text(folder, "whole/cases.csv");
        assert_eq!(rows.lines().count(), 1 + 3 * 2 * 2);
        assert!(rows.starts_with(
            "case,depth_controller.depth.p [rad/m],plant_sim.speed [m/s],seed,depth_setpoint [m],"
        ));
        assert!(
            rows.lines()
                .nth(6)
                .expect("a row")
                .starts_with("5,1,0.3048,2,0.1,")
        );
        assert!(text(folder, "whole/report.html").contains(r#"<figure class="plot">"#));

        let file = folder.join("whole/cases.csv");
        std::fs::write(&file, &rows[..rows.len() / 2]).expect("cut");
        run(&whole).expect("gone on");
        assert_eq!(text(folder, "whole/cases.csv"), rows);

        let mut parts = Vec::new();
        for part in 1..=4 {
            let part_of = SweepArgs {
                shard: Some(Part { part, of: 4 }),
                ..args(folder, "parts")
            };
            run(&part_of).expect("swept");
            let text = text(folder, &format!("parts/cases-{part}-of-4.csv"));
            parts.extend(text.lines().skip(1).map(str::to_owned));
        }
        parts.sort_by_key(|row| row.split(',').next().and_then(|it| it.parse::<u64>().ok()));
        assert_eq!(parts, rows.lines().skip(1).collect::<Vec<_>>());
        assert!(text(folder, "parts/report.html").contains("12 of 12 cases"));
    }

    #[test]
    fn a_folder_holds_each_case_once_however_a_sweep_is_divided() {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = folder.path();
        let shard = |out: &str, shard: Option<(u64, u64)>| {
            let shard = shard.map(|(part, of)| Part { part, of });
            run(&SweepArgs {
                shard,
                ..args(folder, out)
            })
        };
        shard("parts", Some((1, 2))).expect("swept");
        for (other, part) in [(Some((2, 3)), "in 2 parts"), (None, "in 2 parts")] {
            let refusal = format!("{:#}", shard("parts", other).expect_err("refused"));
            assert!(refusal.contains(part), "{refusal}");
        }
        shard("whole", None).expect("swept");
        let refusal = format!("{:#}", shard("whole", Some((1, 1))).expect_err("refused"));
        assert!(refusal.contains("whole"), "{refusal}");
        // What somebody has copied there.
        for (from, to) in [
            ("parts/cases-1-of-2.csv", "parts/cases-1-of-2 (copy).csv"),
            ("parts/cases-1-of-2.csv", "parts/cases-01-of-2.csv"),
            ("whole/cases.csv", "parts/cases.csv"),
            ("whole/cases.csv", "parts/cases-2-of-3.csv"),
            ("parts/cases-1-of-2.csv", "whole/cases-1-of-2.csv"),
        ] {
            std::fs::copy(folder.join(from), folder.join(to)).expect("copied");
        }
        shard("parts", Some((1, 2))).expect("done already");
        assert!(text(folder, "parts/report.html").contains(">6 of 12 cases"));
        shard("parts", Some((2, 2))).expect("swept");
        assert!(text(folder, "parts/report.html").contains(">12 of 12 cases"));
        shard("whole", None).expect("done already");
        assert!(text(folder, "whole/report.html").contains(">12 of 12 cases"));
    }

    #[test]
    fn what_is_refused_is_refused_before_the_first_case() {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = folder.path();
        // Each is a value of its range; the actuator has no small volume.
        let combination = SweepArgs {
            vary: vec!["dha_actuator.logic.mode=single_speed,two_speed".to_owned()],
            ..args(folder, "refused")
        };
        let refusal = format!("{:#}", run(&combination).expect_err("refused"));
        assert!(refusal.contains("1 of 2 combinations"), "{refusal}");
        assert!(
            refusal.contains(r#"dha_actuator.logic.mode="two_speed""#),
            "{refusal}"
        );
        assert!(!folder.join("refused").exists());

        run(&args(folder, "one")).expect("swept");
        let other = SweepArgs {
            seeds: 3,
            ..args(folder, "one")
        };
        let refusal = format!("{:#}", run(&other).expect_err("refused"));
        assert!(refusal.contains("another sweep"), "{refusal}");
    }

    #[test]
    fn a_flight_that_breaks_off_has_a_reason_in_place_of_numbers() {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = folder.path();
        let wild = SweepArgs {
            vary: vec!["plant_sim.environment.seaway.moment=0,10000".to_owned()],
            seeds: 1,
            ..args(folder, "wild")
        };
        run(&wild).expect("swept");
        let rows = text(folder, "wild/cases.csv");
        assert_eq!(rows.lines().count(), 3);
        assert!(rows.lines().nth(1).expect("a row").ends_with(','));
        let broken_off = rows.lines().nth(2).expect("a row");
        assert!(broken_off.contains("plant_sim: "), "{broken_off}");
        assert!(text(folder, "wild/report.html").contains("1 broke off"));
    }
}
