//! Schemas and payloads made to hurt: every answer comes soon and is a number or an error.
#![allow(clippy::unwrap_used)]

use planesman_decode::{Catalogue, Decoder, FieldPath, Values, schema};
use planesman_msgs::planesman_msgs::msg::PlaneMotion;
use planesman_msgs::sensor_msgs::msg::{Imu, JointState};
use planesman_msgs::tf2_msgs::msg::TFMessage;
use planesman_msgs::{Message, cdr};
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;

/// A type nested 60 deep, each level holding the next eight times: 8^59 numbers.
fn bush(reference: &str, leaf: &str) -> String {
    let mut text = String::new();
    for level in 0..60 {
        if level > 0 {
            text += &format!("{}\nMSG: a/L{level}\n", "=".repeat(80));
        }
        for field in 0..8 {
            if level < 59 {
                text += &format!("L{}{reference} f{field}\n", level + 1);
            } else {
                text += &format!("{leaf} f{field}\n");
            }
        }
    }
    text
}

#[test]
fn a_type_of_more_numbers_than_there_are_atoms_is_read_where_its_payload_reaches() {
    for (reference, leaf) in [
        ("", "float64"),
        ("", "string"),
        ("[]", "float64"),
        ("[4294967295]", "uint8"),
        ("[4294967295]", "string"),
    ] {
        let text = bush(reference, leaf);
        let types = schema::read("a/msg/L0", "ros2msg", &text).unwrap();
        let catalogue = Catalogue::of(&types, 1000);
        assert!(leaf == "string" || (catalogue.is_cut && catalogue.fields.len() == 1000));
        let decoder = Decoder::compile(&types, &catalogue.fields).unwrap();
        for filling in [0, 1, 255] {
            let payload = [&[0, 1, 0, 0][..], &vec![filling; 100_000]].concat();
            // Numbers or an error; what matters is that it ends.
            let _ = decoder.read(&payload, &mut Values::default());
        }
    }
}

#[test]
fn a_length_that_lies_reserves_nothing() {
    for text in [
        "float64[] x\n",
        "string[] s\nfloat64[] x\n",
        "wstring s\nfloat64[] x\n",
    ] {
        let types = schema::read("a/msg/A", "ros2msg", text).unwrap();
        let decoder = Decoder::compile(&types, &["x".parse().unwrap()]).unwrap();
        let mut values = Values::default();
        for length in [u32::MAX, u32::MAX / 2, 1 << 29, 3] {
            let payload = [&[0, 1, 0, 0][..], &length.to_le_bytes()].concat();
            assert!(decoder.read(&payload, &mut values).is_err());
            assert!(values.list(0).is_empty());
        }
    }
}

/// Changes, removes or repeats some bytes.
fn mutated(bytes: &[u8], random: &mut Pcg64Mcg) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..random.random_range(1..6) {
        if bytes.is_empty() {
            break;
        }
        let at = random.random_range(0..bytes.len());
        match random.random_range(0..4) {
            0 => bytes[at] = random.random(),
            1 => bytes.truncate(at),
            2 => drop(bytes.remove(at)),
            _ => {
                let piece = bytes[at..].to_vec();
                bytes.splice(at..at, piece.into_iter().take(40));
            }
        }
    }
    bytes
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
