//! A table: its header, its time, its cells, and the record that a fit would be of.
#![no_main]

use libfuzzer_sys::fuzz_target;
use planesman_fuzz::{InMemory, choice};
use planesman_signals::{CsvSource, Options, Resampler, Source as _, TableTime, TimeUnit};

fuzz_target!(|data: &[u8]| {
    let Some((unit, text)) = choice(data) else {
        return;
    };
    let unit = [TimeUnit::S, TimeUnit::Ms, TimeUnit::Us, TimeUnit::Ns][usize::from(unit % 4)];
    let file = InMemory::file(text);
    let time = TableTime {
        unit: Some(unit),
        ..TableTime::default()
    };
    let Ok(table) = CsvSource::open(&file.path(), &time) else {
        return;
    };
    let topics = table.topics().into_iter();
    let requests: Vec<_> = topics.flat_map(|it| it.requests).collect();
    let mut take = |signal: usize, _: i64, _: Option<f64>| signal < requests.len();
    let _ = table.read(&requests, &mut take, &|_| {});
    if let [input, output, ..] = &requests[..] {
        let signals = [input.clone(), output.clone()];
        let names = signals.clone().map(|request| vec![request.name]);
        let mut resampler = Resampler::new(&names[0], &names[1], Options::default());
        let mut take = |signal, stamp, value| resampler.take(signal, stamp, value);
        let _ = table.read(&signals, &mut take, &|_| {});
        let _ = resampler.finish();
    }
});
