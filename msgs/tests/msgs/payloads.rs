//! Payloads on the wire and in bags: what they look like, and what is refused.

use planesman_msgs::builtin_interfaces::msg::{Duration, Time};
use planesman_msgs::geometry_msgs::msg::Quaternion;
use planesman_msgs::nav_msgs::msg::Odometry;
use planesman_msgs::planesman_msgs::action::Manoeuvre;
use planesman_msgs::planesman_msgs::msg::{PlaneMotion, VehicleState};
use planesman_msgs::rcl_interfaces::msg::{
    FloatingPointRange, Log, ParameterDescriptor, ParameterEvent,
};
use planesman_msgs::std_msgs::msg::{Empty, Header};
use planesman_msgs::std_srvs::srv::SetBool;
use planesman_msgs::tf2_msgs::msg::TFMessage;
use planesman_msgs::{Action, Message, Service, cdr, registry, type_info};
use serde_json::json;

fn plane_motion() -> PlaneMotion {
    PlaneMotion {
        header: Header {
            stamp: Time {
                sec: 1,
                nanosec: 50_000_000,
            },
            frame_id: "map".to_owned(),
        },
        duration: Duration::from_nanos(50_000_000),
        dive_planes: vec![0.0, 0.25],
        bow_stern_differential: Vec::new(),
        roll_differential: Vec::new(),
        rudder: Vec::new(),
        thrust: Vec::new(),
    }
}

#[test]
fn a_payload_is_little_endian_cdr_aligned_from_behind_its_header() {
    #[rustfmt::skip]
    let expected = [
        0x00, 0x01, 0x00, 0x00,                         // CDR_LE
        1, 0, 0, 0,  0x80, 0xf0, 0xfa, 0x02,            // stamp
        4, 0, 0, 0,  b'm', b'a', b'p', 0,               // frame_id with its NUL
        0, 0, 0, 0,  0x80, 0xf0, 0xfa, 0x02,            // duration
        2, 0, 0, 0,  0, 0, 0, 0,                        // two samples; padding up to 32
        0, 0, 0, 0, 0, 0, 0, 0,
        0, 0, 0, 0, 0, 0, 0xd0, 0x3f,
        0, 0, 0, 0,  0, 0, 0, 0,                        // differentials bow to stern, of roll: none
        0, 0, 0, 0,  0, 0, 0, 0,                        // rudder, thrust: none
    ];
    assert_eq!(cdr::to_bytes(&plane_motion()), expected);
    assert_eq!(
        cdr::from_bytes::<PlaneMotion>(&expected).unwrap(),
        plane_motion()
    );
}

#[test]
fn a_payload_written_by_the_python_package_rosbags_is_written_the_same_here() {
    let descriptor = ParameterDescriptor {
        name: "kp".to_owned(),
        r#type: 3,
        description: "gain".to_owned(),
        read_only: true,
        floating_point_range: vec![FloatingPointRange {
            to_value: 2.5,
            ..Default::default()
        }],
        ..Default::default()
    };
    let by_rosbags = "00 01 00 00 03 00 00 00 6b 70 00 03 05 00 00 00 67 61 69 6e 00 00 00 00 01 00 00 00 00 01 00 00 \
                      01 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 04 40 00 00 00 00 00 00 00 00 00 00 00 00";
    let by_rosbags: Vec<u8> = by_rosbags
        .split_whitespace()
        .map(|byte| u8::from_str_radix(byte, 16).unwrap())
        .collect();
    assert_eq!(cdr::to_bytes(&descriptor), by_rosbags);
    assert_eq!(
        cdr::from_bytes::<ParameterDescriptor>(&by_rosbags).unwrap(),
        descriptor
    );
}

#[test]
fn big_endian_payloads_are_read_too() {
    let payload = [0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 2];
    let time: Time = cdr::from_bytes(&payload).unwrap();
    assert_eq!(time, Time { sec: 1, nanosec: 2 });
}

#[test]
fn padding_up_to_four_bytes_is_no_error_but_more_is() {
    let mut payload = cdr::to_bytes(&Empty::default());
    assert_eq!(payload, [0, 1, 0, 0, 0]);
    payload.extend([0, 0, 0]);
    assert_eq!(
        cdr::from_bytes::<Empty>(&payload).unwrap(),
        Empty::default()
    );
    payload.push(0);
    assert_eq!(
        cdr::from_bytes::<Empty>(&payload).unwrap_err().to_string(),
        "not a std_msgs/msg/Empty: 4 bytes are left over at the end"
    );
}

#[test]
fn other_encodings_are_refused_by_name() {
    let error = cdr::from_bytes::<Empty>(&[0, 7, 0, 0, 0]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "encapsulation 0x0007 is not plain CDR (0x0000 or 0x0001)"
    );
    let error = cdr::from_bytes::<Empty>(&[0, 1, 0]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "a payload of 3 bytes has no encapsulation header"
    );
}

#[test]
fn no_part_of_a_payload_is_taken_for_the_whole() {
    let event = ParameterEvent {
        node: "/auv/plant_sim".to_owned(),
        new_parameters: vec![Default::default(); 3],
        ..Default::default()
    };
    let payload = cdr::to_bytes(&event);
    for length in 0..payload.len() {
        assert!(
            cdr::from_bytes::<ParameterEvent>(&payload[..length]).is_err(),
            "{length}"
        );
    }
}

#[test]
fn a_length_that_lies_is_refused_without_memory_for_it() {
    // Sequences and strings that claim four thousand million elements, with nothing behind them.
    let claims = [0, 1, 0, 0, 0xff, 0xff, 0xff, 0xff];
    assert!(cdr::from_bytes::<TFMessage>(&claims).is_err());
    let mut log = vec![0, 1, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 20, 0, 0, 0];
    log.extend([0xff, 0xff, 0xff, 0xff]);
    assert!(cdr::from_bytes::<Log>(&log).is_err());

    // Every type, every four bytes of a payload overwritten.
    for info in registry() {
        let zeros = vec![0; 1024];
        for at in 0..zeros.len() / 4 {
            let mut payload = zeros.clone();
            payload[1] = 1;
            payload[4 * at..4 * at + 4].fill(0xff);
            let _ = (info.to_json)(&payload);
        }
    }
}

#[test]
fn text_that_is_not_utf_8_is_refused() {
    let payload = [0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 0xff, 0];
    assert!(cdr::from_bytes::<Header>(&payload).is_err());
}

#[test]
fn the_first_number_that_is_not_finite_is_named_by_its_path() {
    let mut motion = plane_motion();
    assert_eq!(motion.first_non_finite(), None);
    motion.dive_planes = vec![0.0, 1.0, f64::INFINITY];
    assert_eq!(motion.first_non_finite().as_deref(), Some("dive_planes[2]"));

    let mut odometry = Odometry::default();
    odometry.pose.covariance[35] = f64::NAN;
    assert_eq!(
        odometry.first_non_finite().as_deref(),
        Some("pose.covariance[35]")
    );
    odometry.pose.pose.position.z = f64::NAN;
    assert_eq!(
        odometry.first_non_finite().as_deref(),
        Some("pose.pose.position.z")
    );

    let mut tf = TFMessage {
        transforms: vec![Default::default(); 2],
    };
    tf.transforms[1].transform.rotation.w = f64::NEG_INFINITY;
    assert_eq!(
        tf.first_non_finite().as_deref(),
        Some("transforms[1].transform.rotation.w")
    );
}

#[test]
fn new_messages_have_the_defaults_of_their_definitions() {
    assert_eq!(
        Quaternion::default(),
        Quaternion {
            x: 0.0,
            y: 0.0,
            z: 0.0,
            w: 1.0
        }
    );
    assert_eq!(Odometry::default().pose.pose.orientation.w, 1.0);
    assert_eq!(Odometry::default().twist.covariance, [0.0; 36]);
    assert_eq!(VehicleState::PLANES_HELD, 1);
}

#[test]
fn json_has_the_field_names_of_ros_and_null_for_what_is_no_number() {
    let descriptor = ParameterDescriptor {
        name: "kp".to_owned(),
        r#type: 3,
        ..Default::default()
    };
    let info = type_info("rcl_interfaces/msg/ParameterDescriptor").expect("registered");
    assert_eq!(
        (info.to_json)(&cdr::to_bytes(&descriptor)).unwrap(),
        json!({
            "name": "kp", "type": 3, "description": "", "additional_constraints": "", "read_only": false,
            "dynamic_typing": false, "floating_point_range": [], "integer_range": []
        })
    );

    let state = VehicleState {
        depth: f64::NAN,
        ..Default::default()
    };
    let info = type_info(VehicleState::TYPE_NAME).expect("registered");
    assert_eq!(
        (info.to_json)(&cdr::to_bytes(&state)).unwrap()["depth"],
        json!(null)
    );
    assert_eq!(
        (info.to_json)(&[]).unwrap_err().to_string(),
        "a payload of 0 bytes has no encapsulation header"
    );
}

#[test]
fn every_message_is_registered_in_order_of_name() {
    assert!(registry().is_sorted_by(|a, b| a.type_name < b.type_name));
    for info in registry() {
        assert_eq!(
            type_info(info.type_name).map(|found| found.type_hash),
            Some(info.type_hash)
        );
    }
    assert!(type_info("std_msgs/msg/Nothing").is_none());
}

#[test]
fn services_and_actions_name_their_parts() {
    assert_eq!(SetBool::TYPE_NAME, "std_srvs/srv/SetBool");
    assert_eq!(
        SetBool::REQUEST_DDS_TYPE_NAME,
        "std_srvs::srv::dds_::SetBool_Request_"
    );
    assert_eq!(
        SetBool::RESPONSE_DDS_TYPE_NAME,
        "std_srvs::srv::dds_::SetBool_Response_"
    );
    assert_eq!(
        <Manoeuvre as Action>::SendGoal::REQUEST_DDS_TYPE_NAME,
        "planesman_msgs::action::dds_::Manoeuvre_SendGoal_Request_"
    );
    assert_eq!(
        <Manoeuvre as Action>::FeedbackMessage::DDS_TYPE_NAME,
        "planesman_msgs::action::dds_::Manoeuvre_FeedbackMessage_"
    );
}

#[test]
fn times_and_durations_are_whole_nanoseconds() {
    for nanos in [
        0,
        1,
        -1,
        999_999_999,
        1_000_000_000,
        -1_500_000_000,
        1_700_000_000_123_456_789,
    ] {
        assert_eq!(Time::from_nanos(nanos).nanos(), nanos);
        assert_eq!(Duration::from_nanos(nanos).nanos(), nanos);
    }
    assert_eq!(
        Duration::from_nanos(-500_000_000),
        Duration {
            sec: -1,
            nanosec: 500_000_000
        }
    );
    assert_eq!(
        Time::from_nanos(i64::MAX),
        Time {
            sec: i32::MAX,
            nanosec: 999_999_999
        }
    );
    assert_eq!(
        Time::from_nanos(i64::MIN),
        Time {
            sec: i32::MIN,
            nanosec: 0
        }
    );
}
