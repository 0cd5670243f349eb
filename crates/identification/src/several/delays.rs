//! The interval of each channel's delay: the delays at which the whole model fits as well, as [`crate::analysis::Lag`] has
//! it of one input.

use planesman_record::Segment;

use super::equations::Equations;
use super::estimate::Fitted;
use crate::analysis::Lag;
use crate::analysis::lag::{BEYOND_DOUBT, FARTHEST, WITHIN};
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
    // The errors at every delay are of the same samples.
    layout.channels[number].structure.delay += FARTHEST as usize;
    let first = layout.unknown(&one[0].past).min(one[0].len() / 4);
    layout.channels[number].structure.delay = chosen as usize;
    let samples = (one[0].len() - first) as f64;
    let search = Search {
        steps: 20,
        enough: 1e-7,
        radius,
    };
    let mut cost = |delay: i64| -> Option<f64> {
        layout.channels[number].structure.delay = usize::try_from(delay).ok()?;
        let equations = Equations::from(one, layout.clone(), &whitening, first);
        let start = equations.completed(&poles, &whole)?;
        Some(equations.minimised(start, &whole, search)?.1)
    };
    let worse = |cost: f64, than: f64| samples * (cost / than).ln();
    let own = cost(chosen)?;
    let mut costs = vec![(chosen, own)];
    for step in [-1, 1] {
        let mut delay = chosen;
        loop {
            delay += step;
            if (delay - chosen).abs() > FARTHEST {
                break;
            }
            let Some(cost) = cost(delay) else {
                break;
            };
            let least = costs.iter().map(|it| it.1).fold(f64::INFINITY, f64::min);
            costs.push((delay, cost));
            if worse(cost, least) > WITHIN {
                break;
            }
        }
    }
    let (best, least) = costs.iter().copied().min_by(|p, q| p.1.total_cmp(&q.1))?;
    let within = costs.iter().filter(|it| worse(it.1, least) <= WITHIN);
    let within: Vec<i64> = within.map(|it| it.0).collect();
    Some(Lag {
        best,
        interval: (*within.iter().min()?, *within.iter().max()?),
        is_another: worse(own, least) > BEYOND_DOUBT,
    })
}
