//! A bag replayed into the identifier gives what the node gave live on the same samples.
#![allow(clippy::unwrap_used)]

mod stage;

use clap::Parser;
use stage::{Stage, scenario};
use sysid::replay::{Replay, ReplayArgs, replay};

fn replayed(arguments: &[&str]) -> Replay {
    let args = ["replay"].iter().chain(arguments);
    replay(&ReplayArgs::try_parse_from(args).unwrap()).unwrap()
}

#[test]
fn a_replayed_bag_gives_the_estimates_that_were_published_live() {
    let stage = Stage::new();
    let dive = "  plant_sim: {speed: 0.36576}
  depth_controller:
    depth_setpoint: 0.5
    identification: {signal: prbs, amplitude: 0.0349, period: 1.0}
  sysid: {start: 2.0}
";
    let file = stage.file("short.yaml", scenario(15.0, dive));
    let out = stage.path("run");
    stage.run(&["dive", &file, "--out", &out]).success();
    let (bag, parameters) = (format!("{out}/bag"), format!("{out}/parameters.yaml"));

    let again = replayed(&[&bag, "--params-file", &parameters]);
    assert!(again.estimates[0].valid, "{}", again.estimates[0].reason);
    assert_eq!(again.incomplete, None);
    let live = again.live.unwrap();
    assert!(live.compared > 10);
    assert_eq!(live.missing, 0);
    assert!(live.largest_difference <= 1e-9, "{live:?}");

    // With other parameters it is another identification, and the comparison shows it.
    let other = replayed(&[
        &bag,
        "--params-file",
        &parameters,
        "-p",
        "first_moment:=false",
    ]);
    assert!(other.live.unwrap().largest_difference > 1e-9);
}
