//! Time history of a quantity, reduced to the resolution of a plot.
//!
//! At most [`COLUMNS`] columns of equal width are stored, for any length; each column stores its first, smallest, largest and last point. A line
//! through them covers the same pixels as the line through all points if a column is at most one pixel wide (Jugel et al., *M4*, VLDB 2014). A short
//! history is kept unchanged. When there are too many columns, their width doubles.

/// Maximum number of columns, for a plot as wide as a large window; at least half of them are in use.
pub const COLUMNS: usize = 2048;

/// The stored points of one column, in the order of x.
#[derive(Clone, Copy, Debug)]
struct Column {
    first: Point,
    least: Point,
    greatest: Point,
    last: Point,
}

type Point = (f64, f64);

impl Column {
    fn new(point: Point) -> Self {
        Self {
            first: point,
            least: point,
            greatest: point,
            last: point,
        }
    }

    /// This column merged with the next.
    fn with(self, next: Self) -> Self {
        Self {
            first: self.first,
            least: if next.least.1 < self.least.1 {
                next.least
            } else {
                self.least
            },
            greatest: if next.greatest.1 > self.greatest.1 {
                next.greatest
            } else {
                self.greatest
            },
            last: next.last,
        }
    }

    /// Its distinct points.
    fn points(self) -> impl Iterator<Item = Point> {
        let (mut low, mut high) = (self.least, self.greatest);
        if high.0 < low.0 {
            (low, high) = (high, low);
        }
        let mut points = vec![self.first, low, high, self.last];
        points.dedup();
        points.into_iter()
    }
}

/// A time history that grows point by point, with x never decreasing. Points that are not finite are ignored.
#[derive(Clone, Debug)]
pub struct TimeHistory {
    /// Maximum number of columns.
    most: usize,
    columns: Vec<Column>,
    /// Width of a column; 0 while each contains one point.
    width: f64,
}

impl Default for TimeHistory {
    fn default() -> Self {
        Self::within(COLUMNS)
    }
}

impl TimeHistory {
    /// A history with at most this many columns, for a smaller plot.
    #[must_use]
    pub fn within(most: usize) -> Self {
        Self {
            most: most.max(2),
            columns: Vec::new(),
            width: 0.0,
        }
    }

    /// Adds the next point.
    pub fn take(&mut self, x: f64, y: f64) {
        if !(x.is_finite() && y.is_finite()) {
            return;
        }
        let next = Column::new((x, y));
        match self.columns.last().copied() {
            Some(last) if self.width > 0.0 && self.place(x) <= self.place(last.first.0) => {
                self.columns.pop();
                self.columns.push(last.with(next));
            }
            _ => self.columns.push(next),
        }
        while self.columns.len() > self.most {
            self.widen();
        }
    }

    /// The points to plot, with x never decreasing.
    pub fn points(&self) -> impl Iterator<Item = (f64, f64)> {
        self.columns.iter().flat_map(|column| column.points())
    }

    /// Index of the column that contains x.
    fn place(&self, x: f64) -> f64 {
        let origin = self.columns.first().map_or(x, |column| column.first.0);
        ((x - origin) / self.width).floor()
    }

    /// Doubles the width of the columns: neighbouring columns are merged, and single points are merged by their position.
    fn widen(&mut self) {
        let (Some(first), Some(last)) = (self.columns.first(), self.columns.last()) else {
            return;
        };
        let finest = (last.last.0 - first.first.0) / self.most as f64;
        self.width = (2.0 * self.width).max(finest);
        let mut wide: Vec<Column> = Vec::with_capacity(self.most + 1);
        for column in &self.columns {
            match wide.last().copied() {
                // Without any width all points have one x.
                Some(before)
                    if self.width == 0.0
                        || self.place(column.first.0) <= self.place(before.first.0) =>
                {
                    wide.pop();
                    wide.push(before.with(*column));
                }
                _ => wide.push(*column),
            }
        }
        self.columns = wide;
    }
}

impl FromIterator<(f64, f64)> for TimeHistory {
    fn from_iter<I: IntoIterator<Item = (f64, f64)>>(points: I) -> Self {
        let mut history = Self::default();
        points.into_iter().for_each(|(x, y)| history.take(x, y));
        history
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(points: impl IntoIterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
        points
            .into_iter()
            .collect::<TimeHistory>()
            .points()
            .collect()
    }

    #[test]
    fn a_short_one_is_kept_as_it_is() {
        let points: Vec<_> = (0..COLUMNS as u32)
            .map(|k| (f64::from(k * k), f64::from(k % 7)))
            .collect();
        assert_eq!(drawn(points.clone()), points);
    }

    #[test]
    fn every_peak_of_a_long_one_is_drawn_where_it_was() {
        let peaks = [(77_777, 5.0), (123_456, -3.0), (999_999, 9.0)];
        let at = |k: u32| peaks.iter().find(|peak| peak.0 == k).map_or(0.0, |p| p.1);
        let points = drawn((0..1_000_000).map(|k| (f64::from(k), at(k))));
        assert!(points.len() <= 4 * COLUMNS, "{}", points.len());
        assert!(points.len() >= COLUMNS / 2, "{}", points.len());
        assert!(points.is_sorted_by(|a, b| a.0 <= b.0));
        assert_eq!(points[0], (0.0, 0.0));
        for (k, value) in peaks {
            assert!(points.contains(&(f64::from(k), value)), "{k}");
        }
    }

    #[test]
    fn columns_stay_narrower_than_a_pixel_however_often_they_were_widened() {
        for count in [2049_u32, 5000, 40_000, 300_001] {
            let points = drawn((0..count).map(|k| (f64::from(k), f64::from(k % 2))));
            let widest = points.windows(2).map(|p| p[1].0 - p[0].0);
            let widest = widest.fold(0.0, f64::max);
            assert!(widest <= f64::from(count) / 740.0, "{count}: {widest}");
        }
    }

    #[test]
    fn what_is_not_finite_or_stands_still_is_no_trouble() {
        assert_eq!(drawn([(0.0, f64::NAN), (f64::INFINITY, 1.0)]), []);
        let still = drawn((0..10_000).map(|k| (3.0, f64::from(k % 10))));
        assert!(still.len() <= 4 * COLUMNS);
        assert!(still.contains(&(3.0, 9.0)));
        // As far apart as numbers go.
        let ends = drawn((0..10_000).map(|k| (f64::from(k) * 1e304, 0.0)));
        assert!(ends.len() <= 4 * COLUMNS && ends.len() >= 2);
    }
}
