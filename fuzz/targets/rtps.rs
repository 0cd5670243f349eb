//! Datagrams to the patched RustDDS: the message receiver, matched readers, what Discovery decodes, acknowledgements.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| rustdds::fuzzing::receive(data));
