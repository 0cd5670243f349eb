//! A time history as a row of small bars (sparkline).

const BARS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];

/// One bar per number, the smallest number lowest; equal numbers give low bars.
#[must_use]
pub fn sparkline(course: &[f64]) -> String {
    let least = course.iter().copied().fold(f64::INFINITY, f64::min);
    let greatest = course.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let height = |value: &f64| {
        // Halves, so that the range of the largest numbers there are is a number.
        let share = (0.5 * value - 0.5 * least) / (0.5 * greatest - 0.5 * least);
        // Of no range the share is no number, which counts as 0.
        BARS[((share * 8.0) as usize).min(7)]
    };
    course.iter().map(height).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_is_as_high_as_its_number() {
        let rising: Vec<f64> = (0..8).map(f64::from).collect();
        assert_eq!(sparkline(&rising), "▁▂▃▄▅▆▇█");
        assert_eq!(sparkline(&[f64::MIN, f64::MAX]), "▁█");
        assert_eq!(sparkline(&[1.0, 1.0]), "▁▁");
        assert_eq!(sparkline(&[]), "");
    }
}
