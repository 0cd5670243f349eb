//! Numbers picked out by schema are the numbers that were put in, whatever lies around them.

use byteorder::{BigEndian, LittleEndian};
use planesman_decode::{Catalogue, DecodeError, Decoder, FieldPath, Values, schema};
use planesman_msgs::diagnostic_msgs::msg::{DiagnosticArray, DiagnosticStatus, KeyValue};
use planesman_msgs::geometry_msgs::msg::TransformStamped;
use planesman_msgs::nav_msgs::msg::Odometry;
use planesman_msgs::planesman_msgs::msg::PlaneMotion;
use planesman_msgs::sensor_msgs::msg::{Imu, JointState};
use planesman_msgs::tf2_msgs::msg::TFMessage;
use planesman_msgs::{Field, Message, cdr};
use serde_json::Value;

fn path(text: &str) -> FieldPath {
    text.parse().unwrap()
}

fn types_of<M: Message>() -> schema::Types {
    schema::read(M::TYPE_NAME, "ros2msg", M::DEFINITION).unwrap()
}

/// The message in either byte order.
fn payloads<M: Message>(message: &M) -> [Vec<u8>; 2] {
    let mut little = vec![0, 1, 0, 0];
    cdr_encoding::to_writer::<M, LittleEndian, _>(&mut little, message).unwrap();
    let mut big = vec![0, 0, 0, 0];
    cdr_encoding::to_writer::<M, BigEndian, _>(&mut big, message).unwrap();
    [little, big]
}

/// What a decoder finds in the message in either byte order, and in the message itself.
fn readings<M: Message + Field>(decoder: &Decoder, message: &M) -> [Values; 3] {
    let mut readings: [Values; 3] = Default::default();
    let [payloads @ .., at_hand] = &mut readings;
    for (values, payload) in payloads.iter_mut().zip(self::payloads(message)) {
        decoder.read(&payload, values).unwrap();
    }
    decoder.pick(message, at_hand);
    readings
}

/// The number at a path of the message as JSON.
fn in_json(message: &Value, path: &FieldPath) -> Option<f64> {
    let pointer = format!("/{path}")
        .replace('.', "/")
        .replace('[', "/")
        .replace(']', "");
    let value = message.pointer(&pointer)?;
    value.as_f64().or_else(|| value.as_bool().map(f64::from))
}

/// Reads every number of the type, all at once and each by itself, and holds it against the JSON form.
fn every_number_is_found<M: Message + Field>(message: &M) {
    let types = types_of::<M>();
    let json = serde_json::to_value(message).unwrap();
    let fields: Vec<FieldPath> = Catalogue::of(&types, usize::MAX)
        .fields
        .into_iter()
        .filter(|path| {
            let name = path.to_string();
            !["roll", "pitch", "yaw", "norm"]
                .iter()
                .any(|it| name.ends_with(it))
        })
        .collect();
    assert!(!fields.is_empty());
    let all = Decoder::compile(&types, &fields).unwrap();
    let mut found = 0;
    let together = readings(&all, message);
    for (index, field) in fields.iter().enumerate() {
        let expected = in_json(&json, field);
        for values in &together {
            assert_eq!(
                values.number(index),
                expected,
                "{field} of {}",
                M::TYPE_NAME
            );
        }
        found += usize::from(expected.is_some());
        let alone = Decoder::compile(&types, std::slice::from_ref(field)).unwrap();
        for values in readings(&alone, message) {
            assert_eq!(values.number(0), expected, "{field} alone");
        }
    }
    assert!(found > 0);
}

/// A message whose every field differs, strings of odd lengths among them.
fn odometry() -> Odometry {
    let mut odometry = Odometry::default();
    odometry.header.stamp.sec = -3;
    odometry.header.stamp.nanosec = 999_999_999;
    odometry.header.frame_id = "odo".to_owned();
    odometry.child_frame_id = "base_link".to_owned();
    odometry.pose.pose.position.z = -4.25;
    odometry.twist.twist.angular.y = 1e-300;
    for (k, value) in odometry.pose.covariance.iter_mut().enumerate() {
        *value = k as f64;
    }
    odometry
}

fn joints(count: usize) -> JointState {
    JointState {
        name: (0..count).map(|k| "x".repeat(k)).collect(),
        position: (0..count).map(|k| k as f64 + 0.5).collect(),
        effort: vec![7.0],
        ..JointState::default()
    }
}

fn transforms(count: usize) -> TFMessage {
    let mut message = TFMessage::default();
    for k in 0..count {
        let mut transform = TransformStamped::default();
        transform.header.frame_id = "f".repeat(3 * k);
        transform.transform.translation.y = k as f64;
        message.transforms.push(transform);
    }
    message
}

#[test]
fn every_number_of_every_kind_of_message_is_found_in_both_byte_orders() {
    every_number_is_found(&odometry());
    every_number_is_found(&Imu::default());
    for count in [0, 1, 3, 40] {
        every_number_is_found(&joints(count));
    }
    for count in [1, 2, 9] {
        every_number_is_found(&transforms(count));
    }
    let status = |texts: usize| DiagnosticStatus {
        level: 2,
        message: "m".repeat(texts),
        values: vec![KeyValue::default(); texts],
        ..DiagnosticStatus::default()
    };
    every_number_is_found(&DiagnosticArray {
        status: vec![status(0), status(1), status(5)],
        ..DiagnosticArray::default()
    });
}

#[test]
fn every_type_that_the_suite_knows_has_a_schema_that_is_read() {
    for info in planesman_msgs::registry() {
        let types = schema::read(info.type_name, "ros2msg", info.definition).unwrap();
        let fields = Catalogue::of(&types, 5000).fields;
        Decoder::compile(&types, &fields).unwrap();
    }
}

#[test]
fn a_list_is_read_whole_and_its_elements_with_it() {
    let motion = PlaneMotion {
        dive_planes: (0..11).map(f64::from).collect(),
        ..PlaneMotion::default()
    };
    let paths = [
        "dive_planes",
        "dive_planes[3]",
        "dive_planes[11]",
        "dive_planes[3]",
    ]
    .map(path);
    let decoder = Decoder::compile(&types_of::<PlaneMotion>(), &paths).unwrap();
    let found = |values: &Values| {
        assert_eq!(values.list(0), motion.dive_planes);
        assert_eq!(values.list(1), [3.0]);
        assert_eq!(values.number(2), None);
        assert_eq!(values.list(3), [3.0]);
    };
    let mut values = Values::default();
    // Twice into the same values: nothing of the message before is left.
    for _ in 0..2 {
        decoder.read(&cdr::to_bytes(&motion), &mut values).unwrap();
        found(&values);
        decoder.pick(&motion, &mut values);
        found(&values);
    }
}

#[test]
fn an_element_is_found_by_its_name_wherever_that_stands() {
    let paths = [
        "position[elbow]",
        "position[1]",
        "position",
        "effort[elbow]",
        "position[knee]",
    ]
    .map(path);
    let decoder = Decoder::compile(&types_of::<JointState>(), &paths).unwrap();
    let mut names = ["wrist", "elbow", "arm.shoulder"];
    for place in [1, 2, 0] {
        let joints = JointState {
            name: names.iter().map(|it| (*it).to_owned()).collect(),
            position: vec![0.5, 1.5, 2.5],
            effort: vec![7.0],
            ..JointState::default()
        };
        assert_eq!(names[place], "elbow");
        for values in readings(&decoder, &joints) {
            assert_eq!(values.number(0), Some(joints.position[place]));
            assert_eq!(values.number(1), Some(1.5));
            assert_eq!(values.list(2), joints.position);
            assert_eq!(values.number(3), (place == 0).then_some(7.0));
            assert_eq!(values.number(4), None);
        }
        names.rotate_right(1);
    }
    // A name with a dot, and the names behind or around the list.
    let types = schema::read(
        "demo_msgs/msg/Arm",
        "ros2msg",
        &format!(
            "float64[] values\nfloat64[] gain_values\nstring[] gain_names\nPoint[] points\nstring[] joint_names\n{}\n\
             MSG: demo_msgs/Point\nfloat64[] positions\n",
            "=".repeat(80)
        ),
    )
    .unwrap();
    for (list, names) in [
        ("gain_values", Some("gain_names")),
        ("values", Some("joint_names")),
        ("points[1].positions", Some("joint_names")),
        ("joint_names", Some("joint_names")),
        ("points", Some("joint_names")),
    ] {
        assert_eq!(types.names_of(&path(list)), names.map(path), "{list}");
    }
    assert!(
        Decoder::compile(
            &types,
            &["gain_values[arm.p]", "points[1].positions[a]"].map(path)
        )
        .is_ok()
    );
    for text in ["points[a]", "points[a].positions", "joint_names[a]"] {
        let refusal = Decoder::compile(&types, &[path(text)])
            .unwrap_err()
            .to_string();
        assert!(refusal.contains("[a] of"), "{refusal}");
    }
}

#[test]
fn angles_of_a_quaternion_are_those_of_rep_103() {
    let paths = [
        "orientation.roll",
        "orientation.pitch",
        "orientation.yaw",
        "orientation.x",
        "linear_acceleration.norm",
    ]
    .map(path);
    let decoder = Decoder::compile(&types_of::<Imu>(), &paths).unwrap();
    for [roll, pitch, yaw] in [[0.1_f64, 0.2, 0.3], [-3.0, -1.5, 2.5], [0.0, 1.57, -0.7]] {
        // About fixed x, then y, then z: q = q_z q_y q_x.
        let [(sr, cr), (sp, cp), (sy, cy)] =
            [roll, pitch, yaw].map(|angle| libm::sincos(angle / 2.0));
        let mut imu = Imu::default();
        imu.orientation.x = 2.0 * (sr * cp * cy - cr * sp * sy);
        imu.orientation.y = 2.0 * (cr * sp * cy + sr * cp * sy);
        imu.orientation.z = 2.0 * (cr * cp * sy - sr * sp * cy);
        imu.orientation.w = 2.0 * (cr * cp * cy + sr * sp * sy);
        imu.linear_acceleration.x = 2.0;
        imu.linear_acceleration.y = -3.0;
        imu.linear_acceleration.z = 6.0;
        for values in readings(&decoder, &imu) {
            for (index, angle) in [roll, pitch, yaw].into_iter().enumerate() {
                assert!((values.number(index).unwrap() - angle).abs() < 1e-12);
            }
            assert_eq!(values.number(3), Some(imu.orientation.x));
            assert_eq!(values.number(4), Some(7.0));
        }
    }
    let mut nowhere = Imu::default();
    nowhere.orientation.w = 0.0;
    for values in readings(&decoder, &nowhere) {
        assert_eq!(values.number(0), None);
    }
}

#[test]
fn nothing_behind_the_last_number_asked_for_is_walked() {
    let payload = cdr::to_bytes(&joints(3));
    let decoder = |text| Decoder::compile(&types_of::<JointState>(), &[path(text)]).unwrap();
    let mut values = Values::default();
    // A header of two times 4 bytes stands before everything else.
    decoder("header.stamp.nanosec")
        .read(&payload[..4 + 8], &mut values)
        .unwrap();
    assert_eq!(values.number(0), Some(0.0));
    let cut = decoder("position[2]").read(&payload[..payload.len() / 2], &mut values);
    assert!(matches!(cut, Err(DecodeError::Short { .. })), "{cut:?}");
}

#[test]
fn where_messages_carry_their_stamp_is_found() {
    let stamp = |text: &str| schema::read("a/msg/A", "ros2msg", text).unwrap().stamp();
    let time = "=".repeat(80) + "\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
    assert_eq!(types_of::<Imu>().stamp(), Some(path("header.stamp")));
    assert_eq!(
        stamp(&format!("int8 x\nbuiltin_interfaces/Time when\n{time}")),
        Some(path("when"))
    );
    assert_eq!(
        stamp(&format!("builtin_interfaces/Time[2] when\n{time}")),
        None
    );
    assert_eq!(stamp("float64 data\n"), None);
    // A header that says it is one and has no stamp.
    let header = "=".repeat(80) + "\nMSG: std_msgs/Header\nstring frame_id\n";
    let text = format!("std_msgs/Header header\n{header}");
    assert_eq!(stamp(&text), None);
    assert_eq!(
        stamp(&format!("builtin_interfaces/Time when\n{text}{time}")),
        Some(path("when"))
    );
}

#[test]
fn what_leads_to_no_number_is_refused_with_what_would() {
    let types = types_of::<TFMessage>();
    for (text, reason) in [
        ("transform", "it has transforms"),
        ("transforms", "choose an element"),
        ("transforms[0]", "it has header, child_frame_id, transform"),
        (
            "transforms[0].child_frame_id",
            "it is a string, not a number",
        ),
        ("transforms.header", "'header' does not exist in a"),
        ("transforms[0].transform[1]", "which is not a list"),
        (
            "transforms[0].transform.translation.pitch",
            "has no field 'pitch'",
        ),
        (
            "transforms[0].transform.rotation.pitch.x",
            "has no field 'pitch'",
        ),
        (
            "transforms[0].header.stamp.sec.x",
            "'x' does not exist in a",
        ),
    ] {
        let refusal = Decoder::compile(&types, &[path(text)])
            .unwrap_err()
            .to_string();
        assert!(
            refusal.starts_with(text) && refusal.contains(reason),
            "{refusal}"
        );
    }
    let refusal = Decoder::compile(&types_of::<Imu>(), &[path("orientation_covariance[9]")]);
    assert!(
        refusal
            .unwrap_err()
            .to_string()
            .contains("float64[9] has no element [9]")
    );
}

#[test]
fn other_encodings_are_refused_by_name() {
    let types = types_of::<Imu>();
    let decoder = Decoder::compile(&types, &[path("linear_acceleration.x")]).unwrap();
    let mut values = Values::default();
    for (id, name) in [
        (3, "parameter list"),
        (7, "XCDR2"),
        (9, "delimited"),
        (77, "unknown"),
    ] {
        let refusal = decoder
            .read(&[0, id, 0, 0, 1, 2, 3], &mut values)
            .unwrap_err();
        assert!(refusal.to_string().contains(name), "{refusal}");
    }
    assert!(decoder.read(&[0, 1], &mut values).is_err());
    let refusal = schema::read("a/msg/A", "protobuf", "").unwrap_err();
    assert!(refusal.to_string().contains("'protobuf'"), "{refusal}");
}

/// A payload in CDR, put together field by field.
struct Payload {
    bytes: Vec<u8>,
    big_endian: bool,
}

impl Payload {
    fn new(big_endian: bool) -> Self {
        Self {
            bytes: vec![0, u8::from(!big_endian), 0, 0],
            big_endian,
        }
    }

    fn number<const N: usize>(mut self, mut little_endian: [u8; N]) -> Self {
        while !(self.bytes.len() - 4).is_multiple_of(N) {
            self.bytes.push(0);
        }
        if self.big_endian {
            little_endian.reverse();
        }
        self.bytes.extend(little_endian);
        self
    }

    /// A wide string: its length in characters, then these, two bytes or four each.
    fn wide(self, text: &str, bytes: usize) -> Self {
        let units: Vec<u16> = text.encode_utf16().collect();
        let begun = self.number((units.len() as u32).to_le_bytes());
        units.into_iter().fold(begun, |payload, unit| match bytes {
            2 => payload.number(unit.to_le_bytes()),
            _ => payload.number(u32::from(unit).to_le_bytes()),
        })
    }
}

#[test]
fn numbers_behind_wide_strings_are_found_however_wide_their_characters_are() {
    let text = "uint8 before\nwstring name\nfloat64 between\nwstring[] more\nint16 behind\n";
    let types = schema::read("a/msg/A", "ros2msg", text).unwrap();
    let decoder = Decoder::compile(&types, &["before", "between", "behind"].map(path)).unwrap();
    let mut values = Values::default();
    // What Fast CDR 2.2.5 writes of L"abc" and 1.5.
    let fast_cdr = Payload::new(false)
        .wide("abc", 2)
        .number(1.5_f64.to_le_bytes());
    assert_eq!(
        fast_cdr.bytes,
        [
            0, 1, 0, 0, 3, 0, 0, 0, 97, 0, 98, 0, 99, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xf8,
            0x3f
        ]
    );
    for big_endian in [false, true] {
        for bytes in [2, 4] {
            for names in [
                ["", ""],
                ["a", ""],
                ["planes", "rudder and more"],
                ["λ", "\u{1f6a2} ship"],
            ] {
                let payload = Payload::new(big_endian)
                    .number([7])
                    .wide(names[0], bytes)
                    .number(0.1_f64.to_le_bytes())
                    .number(2_u32.to_le_bytes())
                    .wide(names[1], bytes)
                    .wide("x", bytes)
                    .number((-3_i16).to_le_bytes());
                decoder.read(&payload.bytes, &mut values).unwrap();
                let found = [0, 1, 2].map(|index| values.number(index));
                assert_eq!(found, [7.0, 0.1, -3.0].map(Some), "{bytes} {names:?}");
            }
        }
    }
}

#[test]
fn elements_and_messages_are_chosen_by_what_they_are_called() {
    let mut message = transforms(3);
    for (transform, (frame, child)) in message.transforms.iter_mut().zip([
        ("odom", "base_link"),
        ("map", "odom"),
        ("/odom", "/camera"),
    ]) {
        transform.header.frame_id = frame.to_owned();
        transform.child_frame_id = child.to_owned();
    }
    let types = types_of::<TFMessage>();
    for (name, expected) in [
        ("base_link", Some(0.0)),
        ("odom->base_link", Some(0.0)),
        ("odom", Some(1.0)),
        ("camera", Some(2.0)),
        ("/camera", Some(2.0)),
        ("map->base_link", None),
        ("base", None),
    ] {
        let paths = [
            path(&format!("transforms[{name}].transform.translation.y")),
            path("transforms[1].transform.translation.y"),
        ];
        let decoder = Decoder::compile(&types, &paths).unwrap();
        for values in readings(&decoder, &message) {
            assert_eq!(values.number(0), expected, "{name}");
            assert_eq!(values.number(1), Some(1.0));
        }
    }
    let odometry = odometry();
    let types = types_of::<Odometry>();
    for (name, is_it) in [
        ("base_link", true),
        ("odo->base_link", true),
        ("odo", false),
    ] {
        let path = path(&format!("[{name}].pose.pose.position.z"));
        let decoder = Decoder::compile(&types, &[path]).unwrap();
        for values in readings(&decoder, &odometry) {
            assert_eq!(values.number(0).is_some(), is_it, "{name}");
        }
    }
    // A name where nothing has one.
    let types = types_of::<PlaneMotion>();
    let refusal = Decoder::compile(&types, &[path("dive_planes[x]")]).unwrap_err();
    assert!(
        refusal
            .to_string()
            .contains("the message has no names for the elements of this list")
    );
}

#[test]
fn a_message_tells_what_each_of_its_numbers_is_of() {
    let mut joints = joints(3);
    joints.header.frame_id = "arm".to_owned();
    let paths = [
        path("position[2]"),
        path("effort[0]"),
        path("position[xx]"),
        path("header.stamp.sec"),
    ];
    let types = types_of::<JointState>();
    let decoder = Decoder::compile_with_identities(&types, &paths).unwrap();
    let mut values = Values::default();
    let mut identities = |joints: &JointState| {
        decoder.read(&cdr::to_bytes(joints), &mut values).unwrap();
        let texts = |index| {
            let along = decoder.identity(index, &values);
            along.map(|it| it.1.text.clone()).collect::<Vec<_>>()
        };
        [0, 1, 2, 3].map(texts)
    };
    let named = identities(&joints);
    // The first joint's name is empty.
    assert_eq!(named[0], ["arm", "xx"]);
    assert_eq!(named[1], ["arm", "1 numbers"]);
    assert_eq!([&named[2][..], &named[3]], [["arm"], ["arm"]]);
    joints.name.clear();
    assert_eq!(identities(&joints)[0], ["arm", "3 numbers"]);
}

#[test]
fn messages_of_a_list_that_others_name_stand_where_their_names_stand() {
    let text = "string[] name\nP[] pose\nfloat64[] after\n================================================================================\nMSG: a/P\nfloat64 x\nstring[] axis_names\nfloat64[] axis_values\n";
    let types = schema::read("a/msg/A", "ros2msg", text).unwrap();
    let body = |names: [&str; 2]| {
        let mut bytes = vec![0, 1, 0, 0];
        let place = |bytes: &mut Vec<u8>, size: usize| {
            let length = (bytes.len() - 4).next_multiple_of(size) + 4;
            bytes.resize(length, 0);
        };
        let text = |bytes: &mut Vec<u8>, text: &str| {
            place(bytes, 4);
            bytes.extend((text.len() as u32 + 1).to_le_bytes());
            bytes.extend(text.bytes().chain([0]));
        };
        let length = |bytes: &mut Vec<u8>, length: u32| {
            place(bytes, 4);
            bytes.extend(length.to_le_bytes());
        };
        let number = |bytes: &mut Vec<u8>, number: f64| {
            place(bytes, 8);
            bytes.extend(number.to_le_bytes());
        };
        length(&mut bytes, 2);
        names.iter().for_each(|it| text(&mut bytes, it));
        length(&mut bytes, 2);
        for x in [1.0, 2.0] {
            number(&mut bytes, x);
            length(&mut bytes, 2);
            text(&mut bytes, "u");
            text(&mut bytes, "v");
            length(&mut bytes, 2);
            number(&mut bytes, x + 0.25);
            number(&mut bytes, x + 0.5);
        }
        length(&mut bytes, 1);
        number(&mut bytes, 9.0);
        bytes
    };
    let paths = [
        "pose[robot].x",
        "pose[robot].axis_values[v]",
        "after[0]",
        "pose[0].x",
        "pose[none].x",
    ];
    let decoder = Decoder::compile_with_identities(&types, &paths.map(path)).unwrap();
    let mut values = Values::default();
    for (names, expected, first) in [
        (["ground", "robot"], [2.0, 2.5], "ground"),
        (["robot", "ground"], [1.0, 1.5], "robot"),
    ] {
        decoder.read(&body(names), &mut values).unwrap();
        let found = [0, 1, 2, 3, 4].map(|it| values.number(it));
        let [robot, axis] = expected.map(Some);
        assert_eq!(found, [robot, axis, Some(9.0), Some(1.0), None]);
        let identity = decoder.identity(3, &values);
        let identity: Vec<_> = identity.map(|it| it.1.text.as_str()).collect();
        assert_eq!(identity, ["", first]);
    }
}
