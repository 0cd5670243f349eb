//! A bag replayed into the identifier gives what the node gave live on the same samples.

use crate::recorded;
use crate::stage;
use std::path::Path;

use clap::Parser;
use planesman::sysid::replay::ReplayArgs;
use planesman_identifier::replay::Replay;
use planesman_msgs::planesman_msgs::msg::ModelEstimate;
use planesman_msgs::std_srvs::srv::{SetBool, SetBoolRequest, Trigger, TriggerRequest};
use stage::{Received, Signal, Stage, scenario};

fn replayed(arguments: &[&str]) -> Replay {
    let args = ["replay"].iter().chain(arguments);
    ReplayArgs::try_parse_from(args).unwrap().replay().unwrap()
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

#[test]
fn what_was_frozen_and_forgotten_in_flight_is_so_in_the_replay_for_every_pair() {
    let stage = Stage::new();
    let dive = "  depth_controller:
    depth_setpoint: 0.5
    identification: {signal: prbs, amplitude: 0.0349, period: 1.0}
  sysid:
    pairs:
      - \"heave: plane_motion:dive_planes -> state:heave order=2\"
      - \"vehicle: plane_motion:dive_planes -> state:pitch_rate estimator=kalman\"
";
    // Until enough has been learnt, however many ticks a busy machine leaves without an answer.
    let file = stage.file("frozen.yaml", scenario(3600.0, dive));
    let out = stage.path("run");
    let launcher = stage.start(&[
        "dive",
        &file,
        "--keep-running",
        "--factor",
        "4",
        "--out",
        &out,
    ]);
    let operator = stage.operator();
    let learnt = |estimates: usize| {
        for _ in 0..estimates {
            operator.until("an estimate", |received| {
                matches!(received, Received::Model(_)).then_some(())
            });
        }
    };
    let freeze = operator.rt.client::<SetBool>("/auv/sysid/freeze").unwrap();
    let reset = operator.rt.client::<Trigger>("/auv/sysid/reset").unwrap();
    for (estimates, data) in [(15, true), (9, false)] {
        learnt(estimates);
        let answer = operator.call(&freeze, SetBoolRequest { data });
        assert!(answer.success, "{}", answer.message);
    }
    learnt(12);
    assert!(operator.call(&reset, TriggerRequest::default()).success);
    learnt(30);
    launcher.signal(Signal::TERM);
    launcher.finish().success();

    let (bag, parameters) = (format!("{out}/bag"), format!("{out}/parameters.yaml"));
    let mut models: Vec<ModelEstimate> = recorded::messages(Path::new(&bag), "/auv/model").unwrap();
    models.retain(|model| model.name == "model");
    assert!(models.iter().any(|model| model.frozen));
    assert!(models.iter().any(|model| model.samples == 0));
    let again = replayed(&[&bag, "--params-file", &parameters]);
    assert_eq!(again.estimates.len(), 3);
    let live = again.live.unwrap();
    assert!(live.compared > 60, "{live:?}");
    assert_eq!((live.missing, live.largest_difference), (0, 0.0));
}
