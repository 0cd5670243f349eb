//! An `.mcap` file, whole or damaged: opened, summarised, read in both orders, compared with itself.
#![no_main]

use libfuzzer_sys::fuzz_target;
use planesman_bag::reader::Limits;
use planesman_bag::{BagInfo, BagReader, Order};
use planesman_show::diff::{Options, diff};
use planesman_fuzz::InMemory;

/// Small enough that what is refused for its size is met often.
const LIMITS: Limits = Limits {
    chunk: 1 << 20,
    definitions: 1 << 16,
    unpacked: 1 << 24,
};

fuzz_target!(|data: &[u8]| {
    let file = InMemory::file(data);
    let Ok(bag) = BagReader::open_within(&file.path(), LIMITS) else {
        return;
    };
    let _ = BagInfo::of(&bag).to_string();
    let listed: u64 = bag.topics().iter().map(|it| it.messages).sum();
    for order in [Order::File, Order::LogTime] {
        let mut count = 0;
        let mut is_damaged = false;
        for message in bag.messages(order) {
            count += u64::from(message.is_ok());
            is_damaged |= message.is_err();
        }
        // The counts match the messages, or an error says that they do not.
        assert!(is_damaged || count == listed, "{count} of {listed}");
    }
    let options = Options {
        all: true,
        ..Options::default()
    };
    if let Ok(found) = diff(&file.path(), &file.path(), &options) {
        assert!(found.is_equal(), "{}", found.headline());
    }
});
