//! Schemas and payloads made to hurt: every answer comes soon and is a number or an error.

use planesman_decode::{Catalogue, Decoder, FieldPath, Values, schema};
use planesman_msgs::planesman_msgs::msg::PlaneMotion;
use planesman_msgs::sensor_msgs::msg::{Imu, JointState};
use planesman_msgs::tf2_msgs::msg::TFMessage;
use planesman_msgs::{Message, cdr};
use planesman_testing::hostile::{self, mutated};
use rand::SeedableRng as _;
use rand_pcg::Pcg64Mcg;

#[test]
fn schemas_made_to_hurt_are_read_where_the_payload_reaches_or_refused() {
    let mut payloads = hostile::payloads();
    payloads.extend([0, 1, 255].map(|byte| [&[0, 1, 0, 0][..], &vec![byte; 100_000]].concat()));
    let msg = hostile::schemas().into_iter().chain(hostile::lists());
    let idl = hostile::idl().into_iter();
    let all = msg
        .map(|(case, text)| (case, "ros2msg", text))
        .chain(idl.map(|(case, text)| (case, "ros2idl", text)));
    for (case, encoding, text) in all {
        let Ok(types) = schema::read("a/msg/A", encoding, &text) else {
            continue;
        };
        let catalogue = Catalogue::of(&types, 1000);
        let has_numbers = case.starts_with("a bush") && !text.contains("string");
        assert!(
            !has_numbers || catalogue.is_cut && catalogue.fields.len() == 1000,
            "{case}"
        );
        let decoder = Decoder::compile(&types, &catalogue.fields).unwrap();
        for payload in &payloads {
            // Numbers or an error; what matters is that it ends.
            let _ = decoder.read(payload, &mut Values::default());
        }
    }
}

#[test]
fn a_length_that_lies_reserves_nothing() {
    for (case, text) in hostile::lists() {
        let types = schema::read("a/msg/A", "ros2msg", &text).unwrap();
        let decoder = Decoder::compile(&types, &["x".parse().unwrap()]).unwrap();
        let mut values = Values::default();
        for length in [u32::MAX, u32::MAX / 2, 1 << 29, 3] {
            let payload = [&[0, 1, 0, 0][..], &length.to_le_bytes()].concat();
            assert!(decoder.read(&payload, &mut values).is_err(), "{case}");
            assert!(values.list(0).is_empty());
        }
    }
}

fn decodes_or_refuses<M: Message>(message: &M, random: &mut Pcg64Mcg) {
    let types = schema::read(M::TYPE_NAME, "ros2msg", M::DEFINITION).unwrap();
    let fields = Catalogue::of(&types, 200).fields;
    let decoder = Decoder::compile(&types, &fields).unwrap();
    let payload = cdr::to_bytes(message);
    let mut values = Values::default();
    for _ in 0..3000 {
        let payload = mutated(&payload, random);
        if decoder.read(&payload, &mut values).is_ok() {
            let numbers: usize = (0..fields.len()).map(|it| values.list(it).len()).sum();
            assert!(numbers <= 8 * payload.len());
        }
    }
    for _ in 0..1000 {
        let text = mutated(M::DEFINITION.as_bytes(), random);
        let text = String::from_utf8_lossy(&text);
        if let Ok(types) = schema::read(M::TYPE_NAME, "ros2msg", &text) {
            let fields: Vec<FieldPath> = Catalogue::of(&types, 200).fields;
            let _ = Decoder::compile(&types, &fields)
                .unwrap()
                .read(&payload, &mut values);
        }
    }
}

#[test]
fn damaged_payloads_and_schemas_give_numbers_or_errors() {
    let mut random = Pcg64Mcg::seed_from_u64(1988);
    decodes_or_refuses(&Imu::default(), &mut random);
    decodes_or_refuses(
        &JointState {
            name: vec!["port".to_owned(), "starboard".to_owned()],
            position: vec![0.5; 20],
            ..JointState::default()
        },
        &mut random,
    );
    decodes_or_refuses(
        &TFMessage {
            transforms: vec![Default::default(); 3],
        },
        &mut random,
    );
    decodes_or_refuses(&PlaneMotion::default(), &mut random);
}
