//! A schema as it comes in a bag, in either language: read, listed, compiled.
#![no_main]

use libfuzzer_sys::fuzz_target;
use planesman_decode::{Catalogue, Decoder, Values, schema};
use planesman_fuzz::choice;

/// Fields listed at most, as `sysid topics` does.
const FIELDS: usize = 1000;

fuzz_target!(|data: &[u8]| {
    let Some((language, text)) = choice(data) else {
        return;
    };
    let Ok(text) = std::str::from_utf8(text) else {
        return;
    };
    let encoding = if language % 2 == 0 {
        "ros2msg"
    } else {
        "ros2idl"
    };
    let Ok(types) = schema::read("a/msg/A", encoding, text) else {
        return;
    };
    let mut paths = Catalogue::of(&types, FIELDS).fields;
    paths.extend(
        types
            .stamp()
            .iter()
            .flat_map(|stamp| ["sec", "nanosec"].map(|name| stamp.field(name))),
    );
    let decoder = Decoder::compile(&types, &paths).expect("what is listed is there");
    let mut values = Values::default();
    for payload in [
        &[0, 1, 0, 0][..],
        &[0, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8],
        text.as_bytes(),
    ] {
        let _ = decoder.read(payload, &mut values);
    }
});
