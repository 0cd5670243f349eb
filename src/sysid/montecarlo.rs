//! `planesman sysid montecarlo`: every estimator on the thesis' kinds of runs, with many noise realisations.

use anyhow::Result;
use brunner_1988::identification::montecarlo::{contenders, failures_markdown, table};
use brunner_1988::identification::synthetic::Run;
use clap::Parser;

use planesman_console::progress::{bar, end_with_reader};

/// Test every estimator by Monte Carlo simulation: bias, spread and coverage on five synthetic runs.
#[derive(Clone, Debug, Parser)]
#[command(name = "sysid montecarlo")]
pub struct MonteCarloArgs {
    /// Noise realisations per run
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    seeds: u32,
}

/// Runs the command and prints the tables, in Markdown.
///
/// # Errors
/// None; the type is that of every command.
pub(super) fn run(args: &MonteCarloArgs) -> Result<()> {
    let seeds = args.seeds as usize;
    end_with_reader();
    let contenders = contenders();
    let progress = bar("estimators on runs", contenders.len() * Run::ALL.len());
    let table = table(&contenders, seeds, &|| progress.inc(1));
    progress.finish_and_clear();
    planesman_console::out!("{}\n{}", table.markdown(), failures_markdown(seeds))?;
    planesman_console::out!(
        "Under 2 % bias and 90 to 98 % coverage of the dominant pole on every run:"
    )?;
    match table.trustworthy()[..] {
        [] => planesman_console::out!("- none")?,
        ref names => names
            .iter()
            .try_for_each(|name| planesman_console::out!("- {name}"))?,
    }
    Ok(())
}
