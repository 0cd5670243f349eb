//! Faults, cell by cell of two tables: a process that dies, freezes, comes back or is there twice (`nodes`), and a node
//! behind a bad link (`links`); then many vehicles at once (`crowd`), packets that nobody should send (`garbage`), messages
//! of any size (`sizes`), announcements in another's name that it leaves (`farewells`), networks without multicast
//! (`static_peers`), and what clients do to the page's server (`page_attacks`);
//! two machines that fly apart and are joined (`joined`).
//! Each cell is a test of its own, with a fate that the table names.
//!
//! A few always run. With `PLANESMAN_FAULTS=all` in the environment all do; a word chooses by name, as with every test.
#![allow(clippy::unwrap_used)]

mod crew;
mod crowd;
mod evidence;
#[path = "../faked/mod.rs"]
mod faked;
mod farewells;
#[path = "../foreign/mod.rs"]
mod foreign;
mod forwarder;
mod garbage;
mod joined;
mod link;
mod links;
mod network;
mod nodes;
mod pace;
#[path = "../page/mod.rs"]
mod page;
mod page_attacks;
#[path = "../recorded/mod.rs"]
mod recorded;
mod sizes;
#[path = "../stage/mod.rs"]
mod stage;
mod static_peers;

use std::process::ExitCode;

use libtest_mimic::{Arguments, Completion, Trial};

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().collect();
    if let [_, flag, mtu, seed] = arguments.as_slice()
        && flag == forwarder::FLAG
    {
        return forwarder::main(mtu, seed);
    }
    // The longest first, which the others then run beside.
    let mut trials = joined::trials();
    trials.extend(link_trials());
    trials.extend(nodes::trials());
    trials.extend(links::trials());
    trials.extend(crowd::trials());
    trials.extend(garbage::trials());
    trials.extend(sizes::trials());
    trials.extend(farewells::trials());
    trials.extend(static_peers::trials());
    trials.extend(page_attacks::trials());
    for name in nodes::ALWAYS.iter().chain(&links::ALWAYS) {
        assert!(
            trials.iter().any(|trial| trial.name() == *name),
            "no cell {name}"
        );
    }
    let mut arguments = Arguments::from_args();
    // As Rust's own test programs do.
    let threads = std::env::var("RUST_TEST_THREADS");
    let threads = threads.ok().and_then(|it| it.parse().ok());
    arguments.test_threads = arguments.test_threads.or(threads);
    libtest_mimic::run(&arguments, trials).exit_code()
}

/// A test that always runs, or only when all are asked for.
fn trial(name: String, always: bool, run: impl FnOnce() + Send + 'static) -> Trial {
    trial_where(|| Ok(()), name, always, run)
}

/// Like [`trial`], skipped with the reason where it is not possible.
fn trial_where(
    possible: fn() -> Result<(), String>,
    name: String,
    always: bool,
    run: impl FnOnce() + Send + 'static,
) -> Trial {
    let all = std::env::var("PLANESMAN_FAULTS").is_ok_and(|value| value == "all");
    Trial::ignorable_test(name, move || match possible() {
        Err(reason) => {
            foreign::skip(&reason);
            Ok(Completion::ignored_with(reason))
        }
        Ok(()) => {
            run();
            Ok(Completion::Completed)
        }
    })
    .with_ignored_flag(!always && !all)
}

/// The specification of the link's model.
fn link_trials() -> Vec<Trial> {
    use link::claims::*;
    let claims: [(&str, fn()); 4] = [
        (
            "a_good_link_passes_each_frame_once_and_at_once",
            a_good_link_passes_each_frame_once_and_at_once,
        ),
        (
            "the_same_seed_loses_the_same_frames_and_another_others",
            the_same_seed_loses_the_same_frames_and_another_others,
        ),
        (
            "shares_and_delays_are_those_asked_for",
            shares_and_delays_are_those_asked_for,
        ),
        ("a_one_way_cut_stops_one_way", a_one_way_cut_stops_one_way),
    ];
    claims
        .into_iter()
        .map(|(name, claim)| trial(format!("link/{name}"), true, claim))
        .collect()
}
