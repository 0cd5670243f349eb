//! Signals scaled for searches: relative to their level, divided by their scale.

use crate::structure::variance;

/// A signal's level and scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scale {
    pub(crate) level: f64,
    pub(crate) size: f64,
}

impl Scale {
    /// Level and scale of lists; the level is 0 if the model does not allow an offset.
    pub(crate) fn of(lists: &[&[f64]], is_centred: bool) -> Self {
        let all = lists.concat();
        let mean = all.iter().sum::<f64>() / all.len().max(1) as f64;
        let deviation = variance(&all).sqrt();
        Self {
            level: if is_centred { mean } else { 0.0 },
            size: if deviation > 0.0 { deviation } else { 1.0 },
        }
    }

    /// Values minus the level, divided by the scale.
    pub(crate) fn taken_off(self, values: &[f64]) -> Vec<f64> {
        let values = values.iter();
        values.map(|v| (v - self.level) / self.size).collect()
    }
}
