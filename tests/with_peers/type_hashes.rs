//! The type hashes that every endpoint announces are those of ROS 2 Jazzy's own generator (`rosidl_generator_type_description`),
//! for the standard types and for ours.

use crate::foreign::{self, peers};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use foreign::{RCLPY, root};
use planesman_decode::standard;
use planesman_msgs::planesman_msgs::{action::Manoeuvre, srv::Fit, srv::Step};
use planesman_msgs::rcl_interfaces::srv::GetLoggerLevels;
use planesman_msgs::{Action, Message, Service, registry};
use serde_json::Value;

/// Name and hash of every type in `share/PACKAGE/{msg,srv,action}/*.json`.
fn official(share: &Path) -> BTreeMap<String, String> {
    let mut hashes = BTreeMap::new();
    for package in fs::read_dir(share).unwrap() {
        for kind in ["msg", "srv", "action"] {
            let Ok(files) = fs::read_dir(package.as_ref().unwrap().path().join(kind)) else {
                continue;
            };
            let files = files.map(|file| file.unwrap().path());
            for file in files.filter(|file| file.extension().is_some_and(|it| it == "json")) {
                let recorded: Value = serde_json::from_slice(&fs::read(&file).unwrap()).unwrap();
                for entry in recorded["type_hashes"].as_array().unwrap() {
                    let of = |key: &str| entry[key].as_str().unwrap().to_owned();
                    hashes.insert(of("type_name"), of("hash_string"));
                }
            }
        }
    }
    hashes
}

#[test]
fn every_type_has_the_hash_that_ros_gives_it() {
    let Some(ros) = RCLPY.found() else { return };
    let official = official(&root().join(ros.environment).join("share"));
    let mut ours: Vec<(&str, &str)> = registry()
        .iter()
        .map(|info| (info.type_name, info.type_hash))
        .collect();
    fn message<M: Message>() -> (&'static str, &'static str) {
        (M::TYPE_NAME, M::TYPE_HASH)
    }
    fn service<S: Service>() -> [(&'static str, &'static str); 3] {
        let whole = (S::TYPE_NAME, S::TYPE_HASH);
        [whole, message::<S::Request>(), message::<S::Response>()]
    }
    ours.extend(service::<Step>());
    ours.extend(service::<Fit>());
    ours.extend(service::<GetLoggerLevels>());
    ours.push((Manoeuvre::TYPE_NAME, Manoeuvre::TYPE_HASH));
    ours.extend(service::<<Manoeuvre as Action>::SendGoal>());
    ours.extend(service::<<Manoeuvre as Action>::GetResult>());
    ours.push(message::<<Manoeuvre as Action>::FeedbackMessage>());

    for (name, hash) in ours {
        match official.get(name) {
            Some(official) => assert_eq!(hash, official, "{name}"),
            // PyPI has no tf2_msgs.
            None => assert!(name.starts_with("tf2_msgs/"), "{name} is not there"),
        }
    }
}

/// Messages with a `char`.
const OF_CHAR: [&str; 2] = ["service_msgs/msg/ServiceEventInfo", "std_msgs/msg/Char"];

#[test]
fn the_built_in_definitions_are_those_of_rosbags_by_their_hashes() {
    for distribution in ["jazzy", "humble"] {
        let Some(mut store) = peers::program("store_hashes.py") else {
            return;
        };
        let output = store.arg(distribution).output().unwrap();
        let theirs: BTreeMap<String, String> = serde_json::from_slice(&output.stdout).unwrap();
        let mut compared = 0;
        for name in standard::names() {
            // rosbags has no control_msgs, and takes char for uint8 (ROS' own generator does not: see above).
            let Some(hash) = theirs
                .get(&name)
                .filter(|_| !OF_CHAR.contains(&name.as_str()))
            else {
                continue;
            };
            let versions = standard::versions(&name);
            let ours: Vec<String> = versions.iter().map(|it| it.hash()).collect();
            let newest = distribution == "jazzy";
            let is_there = if newest {
                ours[0] == *hash
            } else {
                ours.contains(hash)
            };
            assert!(is_there, "{name} of {distribution}: {ours:?}, {hash}");
            compared += 1;
        }
        assert!(compared > 140, "{compared} of {distribution}");
    }
}
