//! Samples at their original stamps, without a grid, on a continuous time, in order.

use crate::clock::{ClockFollower, Followed};
use crate::error::{Result, SourceError};
use crate::request::{Reading, Request, Role};
use crate::sieve::DuplicateFilter;
use crate::signal::LARGEST;
use crate::source::Source;
use crate::unwrap::Unwrap;

/// Maximum number of samples of all signals.
const MOST: usize = 20_000_000;

/// The samples of a signal, in stretches; between them the signal is unknown.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stretches {
    /// Increasing stamps, ns, with their values.
    pub stretches: Vec<Vec<(i64, f64)>>,
    /// The usual interval between two samples, s; 0 with fewer than two.
    pub interval: f64,
    /// Changes to the samples: angles unwrapped, bursts spread, repeats left out.
    pub changes: Vec<String>,
}

/// Reads signals sample by sample. If several samples have the same stamp, the last one counts; non-finite numbers are ignored.
///
/// # Errors
/// One line: a signal is missing or has no sample, or none of the data can be read.
pub fn read_samples(
    source: &dyn Source,
    requests: &[Request],
    unwrap: Unwrap,
    progress: &dyn Fn(u64),
) -> Result<(Vec<Stretches>, Reading)> {
    let mut found: Vec<Vec<Vec<(i64, f64)>>> = vec![vec![Vec::new()]; requests.len()];
    let mut count = 0_usize;
    let mut give = |followed: Followed| match followed {
        Followed::Sample(signal, stamp, Some(value)) if value.abs() <= LARGEST => {
            count += 1;
            if let Some(stretch) = found[signal].last_mut() {
                stretch.push((stamp, value));
            }
        }
        Followed::Sample(..) => {}
        Followed::Break(signal) => found[signal].push(Vec::new()),
    };
    let mut clock = ClockFollower::new(requests.len());
    let mut taken = 0_usize;
    let mut reading = source.read(
        requests,
        &mut |signal, stamp, value| {
            taken += 1;
            clock.take(signal, stamp, value, &mut give);
            taken < MOST
        },
        progress,
    )?;
    clock.finish(&mut give);
    reading.clock = clock.notes();
    let mut signals = Vec::new();
    for (request, stretches) in requests.iter().zip(found) {
        let is_output = request.role == Role::Output;
        let mut of = Stretches::default();
        for mut stretch in stretches {
            if stretch.is_empty() {
                continue;
            }
            let mut sieve = DuplicateFilter::find(&mut stretch, is_output, unwrap);
            of.stretches.push(sieve.through(&stretch));
            of.interval = sieve.interval * 1e-9;
            let changes = sieve.changes().into_iter().map(|it| it.to_string());
            of.changes.extend(changes);
        }
        if of.stretches.is_empty() {
            return Err(SourceError::Data(format!(
                "{}: the signal has no sample",
                request.name
            )));
        }
        signals.push(of);
    }
    Ok((signals, reading))
}
