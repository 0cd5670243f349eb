//! A payload of each message type there is, by its schema and by the type compiled in: what one takes whole, the other
//! takes too, and compares with itself as equal.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use planesman_decode::difference::differences;
use planesman_decode::{Catalogue, Decoder, FieldPath, Types, Values, schema};
use planesman_fuzz::choice;
use planesman_msgs::diagnostic_msgs::msg::DiagnosticArray;
use planesman_msgs::nav_msgs::msg::Odometry;
use planesman_msgs::planesman_msgs::msg::{ModelEstimate, PlaneMotion, VehicleState};
use planesman_msgs::sensor_msgs::msg::JointState;
use planesman_msgs::tf2_msgs::msg::TFMessage;
use planesman_msgs::{Message, cdr};

/// A type's decoder, and whether its own type takes a payload.
struct Kind {
    decoder: Decoder,
    paths: Vec<FieldPath>,
    types: Types,
    is_taken: fn(&[u8]) -> bool,
}

fn kind<M: Message>() -> Kind {
    let types = schema::read(M::TYPE_NAME, "ros2msg", M::DEFINITION).expect("our own schema");
    let paths = Catalogue::of(&types, 1000).fields;
    Kind {
        decoder: Decoder::compile(&types, &paths).expect("what is listed is there"),
        paths,
        types,
        is_taken: |payload| cdr::from_bytes::<M>(payload).is_ok(),
    }
}

static KINDS: LazyLock<[Kind; 7]> = LazyLock::new(|| {
    [
        kind::<VehicleState>(),
        kind::<PlaneMotion>(),
        kind::<ModelEstimate>(),
        kind::<DiagnosticArray>(),
        kind::<JointState>(),
        kind::<Odometry>(),
        kind::<TFMessage>(),
    ]
});

fuzz_target!(|data: &[u8]| {
    let Some((which, payload)) = choice(data) else {
        return;
    };
    let kind = &KINDS[usize::from(which) % KINDS.len()];
    let mut values = Values::default();
    let is_read = kind.decoder.read(payload, &mut values).is_ok();
    if (kind.is_taken)(payload) {
        assert!(is_read, "a payload that its type takes");
    }
    let compared = differences(&kind.types, [payload, payload], &mut |place, _, _| {
        panic!("{place} differs from itself");
    });
    if (kind.is_taken)(payload) {
        assert!(compared.is_ok(), "a payload that its type takes");
    }
    // Another beside it: half of it is read as whatever it is.
    let _ = differences(&kind.types, [payload, &payload[payload.len() / 2..]], &mut |_, a, b| {
        assert!(!a.is(&b));
    });
    for index in 0..kind.paths.len() {
        let _ = (values.number(index), values.list(index).len());
    }
});
