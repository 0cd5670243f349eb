//! A log of ArduPilot, MAVLink or MOOS: its topics, its messages, and the record that a fit would be of.
#![no_main]

use libfuzzer_sys::fuzz_target;
use planesman_fuzz::{InMemory, choice};
use planesman_signals::{LogKind, LogSource, Options, Resampler, Source as _};

fuzz_target!(|data: &[u8]| {
    let Some((kind, bytes)) = choice(data) else {
        return;
    };
    let name = ["log.bin", "log.tlog", "log.alog"][usize::from(kind % 3)];
    let kind = LogKind::of(name.as_ref()).expect("a kind that is read");
    let file = InMemory::file(bytes);
    let Ok(log) = LogSource::open(&file.path(), kind) else {
        return;
    };
    let topics = log.topics().into_iter();
    let requests: Vec<_> = topics.flat_map(|it| it.requests).take(2).collect();
    if let [input, output] = &requests[..] {
        let names = [input, output].map(|request| vec![request.name.clone()]);
        let mut resampler = Resampler::new(&names[0], &names[1], Options::default());
        let mut take = |signal, stamp, value| resampler.take(signal, stamp, value);
        let _ = log.read(&requests, &mut take, &|_| {});
        let _ = resampler.finish();
    }
});
