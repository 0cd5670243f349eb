//! The sensors of docs/sensors.md, held by numpy to the truth beside them in the bag.
//!
//! Where `.venv` is absent the test passes, saying what it skipped (tests/README.md).

use serde_json::Value;

use crate::foreign::peers::program;
use crate::stage::Stage;

const TURN: &str = "description: a turn in a current over a bottom
duration: 60.0
parameters:
  plant_sim:
    speed: 0.6096
    environment: {bottom: 20.0, current: {x: 0.1, y: -0.2}}
    sensors:
      depth: {port: centre}
      dvl: {rate: 5.0}
      usbl: {rate: 2.0, delay: 1.3}
      attitude: {enabled: true}
  depth_controller: {depth_setpoint: 1.0, heading_setpoint: 2.0}
";

#[test]
fn dead_reckoning_by_the_sensors_ends_where_their_covariances_let_it() {
    let Some(mut peer) = program("dead_reckoning.py") else {
        return;
    };
    let stage = Stage::new();
    let (file, bag) = (stage.file("turn.yaml", TURN), stage.path("turn.mcap"));
    stage.run(&["sim", &file, "--out", &bag]).success();
    let printed = peer.arg(&bag).output().unwrap();
    let found: Value = serde_json::from_slice(&printed.stdout)
        .unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&printed.stderr)));
    let number = |value: &Value| value.as_f64().unwrap();
    assert!(number(&found["way"]) > 20.0, "{found}");
    // Over a way of 24 m the covariances foretell 3 cm east and north, 1 cm up.
    for (axis, most) in [(0, 0.04), (1, 0.04), (2, 0.02)] {
        assert!(number(&found["deviation"][axis]) < most, "{found}");
    }
    // Of three normal numbers the sum of squares is above 16.3 once in a thousand.
    assert!(number(&found["normalised"]) < 16.3, "{found}");
    assert!(number(&found["largest"]) < 4.0, "{found}");
    // The mean of n squares of normal numbers is 1 with deviation sqrt(2 / n).
    for sensor in ["dvl", "depth", "usbl"] {
        let [mean, count] = [0, 1].map(|i| number(&found[sensor][i]));
        assert!(count > 300.0, "{found}");
        assert!((mean - 1.0).abs() < 5.0 * (2.0 / count).sqrt(), "{found}");
    }
}
