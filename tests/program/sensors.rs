//! The sensors of docs/sensors.md: switched on they change nothing else of a flight, and off there is nothing of them.

use std::collections::BTreeMap;
use std::path::Path;

use planesman_bag::{BagReader, Order};
use planesman_msgs::{
    Message, cdr,
    geometry_msgs::msg::PoseWithCovarianceStamped,
    loop_topics::OPTIONAL_SENSORS,
    nav_msgs::msg::Odometry,
    sensor_msgs::msg::{NavSatFix, NavSatStatus},
};

use crate::stage::Stage;

/// A dive from the surface to half a metre, a metre above the bottom of a tank.
const DIVE: &str = "description: a short dive
duration: 20.0
parameters:
  depth_controller: {depth_setpoint: 0.5}
  plant_sim:
    speed: 0.6096
    environment: {bottom: 1.5}
";

const SENSORS: &str = "    sensors:
      dvl: {rate: 5.0, range: 1.5}
      magnetometer: {rate: 10.0}
      gps: {rate: 2.0}
      usbl: {rate: 0.5, delay: 1.23}
";

/// The payloads of each topic with their log times, ns.
type Topics = BTreeMap<String, Vec<(i64, Vec<u8>)>>;

fn flown(stage: &Stage, name: &str, scenario: &str) -> Topics {
    let file = stage.file(&format!("{name}.yaml"), scenario);
    let bag = stage.path(&format!("{name}.mcap"));
    stage.run(&["sim", &file, "--out", &bag]).success();
    let mut topics = Topics::new();
    for message in BagReader::open(Path::new(&bag))
        .unwrap()
        .messages(Order::File)
    {
        let message = message.unwrap();
        let taken = (message.log_time, message.payload.to_vec());
        let name = message.topic.name.trim_start_matches("/auv/").to_owned();
        topics.entry(name).or_default().push(taken);
    }
    topics
}

fn decoded<M: Message>(topics: &Topics, topic: &str) -> Vec<(i64, M)> {
    let read = |(time, payload): &(i64, Vec<u8>)| (*time, cdr::from_bytes(payload).unwrap());
    topics[topic].iter().map(read).collect()
}

#[test]
fn switched_on_they_change_nothing_else_and_off_they_are_not_there() {
    let stage = Stage::new();
    let off = flown(&stage, "off", DIVE);
    let on = flown(&stage, "on", &format!("{DIVE}{SENSORS}"));
    for (topic, messages) in &off {
        assert!(!OPTIONAL_SENSORS.contains(&topic.as_str()), "{topic}");
        // The frames of altimeter and antenna.
        assert!(*messages == on[topic] || topic == "/tf_static", "{topic}");
    }
    for topic in OPTIONAL_SENSORS {
        assert!(on.contains_key(topic), "{topic}");
    }
    // Level, 1.5 m along a beam reach the bottom from a depth of 0.2 m on; bow down the beams that look aft reach less far.
    assert_eq!(on["dvl"].len() + on["dvl_water"].len(), 100);
    assert_eq!(on["dvl_water"][0].0, 0);
    assert!(on["dvl"].len() > 20 && on["dvl"].last() > on["dvl_water"].last());
    assert_eq!(on["dvl"].len(), on["altitude"].len());
    assert_eq!(on["magnetic_field"].len(), 200);
    fixes_are_of_the_surface(&on);
    positions_come_late(&on);
}

fn fixes_are_of_the_surface(on: &Topics) {
    let depths: BTreeMap<i64, f64> = decoded::<Odometry>(on, "odom")
        .into_iter()
        .map(|(time, it)| (time, -it.pose.pose.position.z))
        .collect();
    let fixes = decoded::<NavSatFix>(on, "gps");
    assert_eq!(fixes.len(), 40);
    assert_eq!(fixes[0].1.status.status, NavSatStatus::STATUS_FIX);
    for (time, fix) in fixes {
        let is_under_water = depths[&time] > 0.1;
        let has_fix = fix.status.status == NavSatStatus::STATUS_FIX;
        assert!(!(is_under_water && has_fix), "{time}");
        if has_fix {
            // 1e-4 degrees are 11 m.
            assert!((fix.latitude - 36.7).abs() < 1e-4 && (fix.longitude + 122.0).abs() < 1e-4);
            assert_eq!(fix.position_covariance[8], 4.0);
        }
    }
}

fn positions_come_late(on: &Topics) {
    let positions = decoded::<PoseWithCovarianceStamped>(on, "usbl");
    // Measured each 2 s, published 1.23 s later: at the next tick.
    assert_eq!(positions.len(), 10);
    for (k, (time, position)) in (0..).zip(positions) {
        assert_eq!(position.header.stamp.nanos(), k * 2_000_000_000);
        assert_eq!(time, k * 2_000_000_000 + 1_250_000_000);
    }
}
