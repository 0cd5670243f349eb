//! What viewers open: the layouts' topics and fields, and the transforms of the vehicle's description, are in the bag of a flight.

use crate::recorded;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

use planesman_flight::scenario::Scenario;
use planesman_flight::{Parts, fly};
use planesman_msgs::sensor_msgs::msg::JointState;
use planesman_msgs::std_msgs::msg::String as Text;
use planesman_msgs::tf2_msgs::msg::TFMessage;
use recorded::messages;
use serde_json::Value;
use tempfile::TempDir;

/// A flight of the main job in one process: its messages are those of the nodes.
struct Flight {
    _folder: TempDir,
    bag: PathBuf,
}

impl Flight {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let bag = folder.path().join("dive.mcap");
        fly(
            &Scenario::load("dive").unwrap(),
            &Parts::default(),
            &bag,
            "/auv",
            &(),
        )
        .unwrap();
        Self {
            _folder: folder,
            bag,
        }
    }

    /// The topics with their types and numeric fields, as `planesman sysid topics` lists them.
    fn topics(&self) -> Topics {
        let run = Command::new(env!("CARGO_BIN_EXE_planesman"))
            .args(["sysid", "topics", "--json"])
            .arg(&self.bag)
            .output()
            .unwrap();
        assert!(run.status.success(), "{run:?}");
        let survey: Value = serde_json::from_slice(&run.stdout).unwrap();
        let topics = survey["topics"].as_array().unwrap().iter().map(|topic| {
            let fields = topic["fields"].as_array().unwrap().iter();
            let fields = fields.map(|field| text(&field["path"])).collect();
            (text(&topic["name"]), (text(&topic["type_name"]), fields))
        });
        Topics(topics.collect())
    }

    /// The frames with the frame that each is given in.
    fn frames(&self) -> BTreeMap<String, String> {
        let messages =
            ["/tf_static", "/tf"].map(|it| messages::<TFMessage>(&self.bag, it).unwrap());
        let transforms = messages.into_iter().flatten().flat_map(|it| it.transforms);
        transforms
            .map(|it| (it.child_frame_id, it.header.frame_id))
            .collect()
    }
}

struct Topics(BTreeMap<String, (String, BTreeSet<String>)>);

impl Topics {
    fn assert_has(&self, topic: &str) {
        assert!(
            self.0.contains_key(topic),
            "{topic} is not in {:?}",
            self.0.keys()
        );
    }

    fn assert_has_field(&self, topic: &str, field: &str) {
        self.assert_has(topic);
        let (kind, fields) = &self.0[topic];
        assert!(
            fields.contains(field),
            "{topic} ({kind}) has no number {field}"
        );
    }

    fn assert_has_type(&self, topic: &str, kind: &str) {
        self.assert_has(topic);
        assert_eq!(self.0[topic].0, kind, "{topic}");
    }
}

fn text(value: &Value) -> String {
    value
        .as_str()
        .unwrap_or_else(|| panic!("{value} is no text"))
        .to_owned()
}

fn layout(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("launch-scripts/layouts");
    std::fs::read_to_string(folder.join(name)).unwrap()
}

/// What stands between `before` and the next quotation mark, everywhere in the text.
fn quoted<'a>(text: &'a str, before: &str) -> Vec<&'a str> {
    let parts = text.split(before).skip(1);
    parts.map(|it| it.split('"').next().unwrap()).collect()
}

#[test]
fn whatever_the_layouts_show_is_in_the_bag_of_a_flight() {
    let flight = Flight::new();
    let (topics, frames) = (flight.topics(), flight.frames());
    let is_frame = |name: &str| frames.contains_key(name) || frames.values().any(|it| it == name);

    let plotjuggler = layout("plotjuggler.xml");
    let curves = quoted(&plotjuggler, "<curve name=\"");
    assert!(curves.len() > 10, "{curves:?}");
    for curve in curves {
        let (topic, field) = curve.rsplit_once('/').unwrap();
        topics.assert_has_field(topic, field);
    }
    for selected in quoted(&plotjuggler, "<selected_topics value=\"") {
        selected.split(';').for_each(|it| topics.assert_has(it));
    }

    let foxglove: Value = serde_json::from_str(&layout("foxglove.json")).unwrap();
    for (panel, config) in foxglove["configById"].as_object().unwrap() {
        match panel.split_once('!').unwrap().0 {
            "Plot" => {
                for path in config["paths"].as_array().unwrap() {
                    let path = text(&path["value"]);
                    let (topic, field) = path.split_once('.').unwrap();
                    topics.assert_has_field(topic, field);
                }
            }
            "RawMessages" => topics.assert_has(&text(&config["topicPath"])),
            "3D" => {
                assert!(is_frame(&text(&config["followTf"])));
                for topic in config["topics"].as_object().unwrap().keys() {
                    topics.assert_has(topic);
                }
                let layers = &config["layers"];
                assert!(is_frame(&text(&layers["surface"]["frameId"])));
                let description = text(&layers["vehicle"]["topic"]);
                topics.assert_has_type(&description, "std_msgs/msg/String");
            }
            kind => assert_eq!(kind, "Tab"),
        }
    }

    let rviz: Value = serde_yaml_ng::from_str(&layout("planesman.rviz")).unwrap();
    let manager = &rviz["Visualization Manager"];
    assert!(is_frame(&text(&manager["Global Options"]["Fixed Frame"])));
    assert!(is_frame(&text(
        &manager["Views"]["Current"]["Target Frame"]
    )));
    for display in manager["Displays"].as_array().unwrap() {
        let topic = |key| text(&display[key]["Value"]);
        match text(&display["Class"]).as_str() {
            "rviz_default_plugins/RobotModel" => {
                topics.assert_has_type(&topic("Description Topic"), "std_msgs/msg/String");
            }
            "rviz_default_plugins/Odometry" => {
                topics.assert_has_type(&topic("Topic"), "nav_msgs/msg/Odometry");
            }
            "rviz_default_plugins/Grid" => assert!(is_frame(&text(&display["Reference Frame"]))),
            class => assert_eq!(class, "rviz_default_plugins/TF"),
        }
    }
}

#[test]
fn every_link_of_the_vehicle_has_a_transform_and_the_ram_moves_as_the_actuator_says() {
    let flight = Flight::new();
    let frames = flight.frames();
    let description = messages::<Text>(&flight.bag, "/auv/robot_description").unwrap();
    let links = quoted(&description[0].data, "<link name=\"");
    assert_eq!(links.len(), 5, "{links:?}");
    for link in links {
        assert!(frames.contains_key(link), "{link} is not in {frames:?}");
    }

    let transforms = messages::<TFMessage>(&flight.bag, "/tf").unwrap();
    let planes = messages::<JointState>(&flight.bag, "/auv/planes").unwrap();
    assert_eq!(transforms.len(), planes.len());
    let forward = |message: &TFMessage| {
        let mut parts = message.transforms.iter();
        let ram = parts.find(|it| it.child_frame_id == "ram").unwrap();
        ram.transform.translation.x
    };
    let rest = forward(&transforms[0]);
    let mut most: f64 = 0.0;
    for (transform, planes) in transforms.iter().zip(&planes) {
        let ram = planes.name.iter().position(|it| it == "ram").unwrap();
        let ram = planes.position[ram];
        assert!(
            (forward(transform) - rest - ram).abs() < 1e-12,
            "{transform:?}"
        );
        most = most.max(ram.abs());
    }
    assert!(most > 1e-3, "the ram moves by {most} m");
}
