//! The interval of each channel's delay: the delays at which the whole model fits equally well, like [`crate::analysis::Lag`] for one
//! input.

use planesman_record::Segment;

use super::equations::Equations;
use super::estimate::Fitted;
use crate::analysis::Lag;
use crate::analysis::lag::{FARTHEST, Lags, profile};
use crate::estimators::Search;

/// The lag of each channel, from the longest record.
pub(super) fn lags(fitted: &Fitted, longest: &Segment, radius: f64) -> Vec<Option<Lag>> {
    let one = std::slice::from_ref(longest);
    let channels: Vec<usize> = (0..fitted.layout.channels.len()).collect();
    planesman_parallel::on_all_cores(&channels, |number| lag(fitted, one, *number, radius))
}

fn lag(fitted: &Fitted, one: &[Segment], number: usize, radius: f64) -> Option<Lag> {
    let (plain, theta) = fitted.on(one, 0);
    let poles = plain.poles(&theta);
    let whole = plain.whole();
    let whitening = plain.whitening(&plain.completed(&poles, &whole)?);
    // The numerator of a channel that acts at once is one longer: it is as free at every delay.
    let mut layout = plain.layout;
    let chosen = layout.channels[number].structure.delay as i64;
    let input = layout.channels[number].input;
    // The errors at every delay are of the same samples.
    layout.channels[number].structure.delay += FARTHEST as usize;
    let first = layout.unknown(&one[0].past).min(one[0].len() / 4);
    layout.channels[number].structure.delay = chosen as usize;
    let samples = one[0].len() - first;
    let search = Search {
        steps: 20,
        enough: 1e-7,
        radius,
    };
    let mut cost = |delay: i64, lags: Lags| -> Option<f64> {
        layout.channels[number].structure.delay = usize::try_from(delay).ok()?;
        let mut behind = one.to_vec();
        let before = one[0].past.get(input).map_or(&[][..], Vec::as_slice);
        let mut past = lags.of(&[before, &one[0].inputs[input]].concat(), false);
        behind[0].inputs[input] = past.split_off(before.len());
        if let Some(it) = behind[0].past.get_mut(input) {
            *it = past;
        }
        let equations = Equations::from(&behind, layout.clone(), &whitening, first);
        let start = equations.completed(&poles, &whole)?;
        Some(equations.minimised(start, &whole, search)?.1)
    };
    let lag = profile(chosen, samples, |delay| cost(delay, Lags::NONE))?;
    Some(lag.with_lags(samples, cost))
}
