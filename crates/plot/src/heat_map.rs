//! A heat map as SVG text: one field for each pair of values, coloured by a number.

use anyhow::{Result, anyhow, bail};
use plotters::coord::Shift;
use plotters::prelude::*;

use crate::{AXIS, LABELS, MARGIN, SIZE, X_LABELS, label};

/// Below the plots' usual size: the height follows the rows.
const FIELD: u32 = 26;
const LEAST_HEIGHT: u32 = 140;
/// Width of the scale and of its numbers, pixels.
const SCALE: u32 = 120;
/// Width of the rows' names, pixels.
const NAMES: u32 = 110;
/// The most names along an axis.
const MOST_NAMES: usize = 14;

/// Viridis at equal distances (van der Walt and Smith 2015): its lightness grows evenly, for any colour vision.
const COLOURS: [(u8, u8, u8); 9] = [
    (68, 1, 84),
    (72, 40, 120),
    (62, 74, 137),
    (49, 104, 142),
    (38, 130, 142),
    (31, 158, 137),
    (53, 183, 121),
    (110, 206, 88),
    (253, 231, 37),
];

/// Numbers over two lists of values.
#[derive(Clone, Debug)]
pub struct HeatMap {
    /// The names of the horizontal and the vertical axis, with their units.
    pub axes: [String; 2],
    /// The values along the horizontal axis, as text.
    pub columns: Vec<String>,
    /// The values along the vertical axis, upwards, as text.
    pub rows: Vec<String>,
    /// A number for each row and column; a field without is left white.
    pub values: Vec<Vec<Option<f64>>>,
    /// What the numbers are, with the unit.
    pub quantity: String,
}

impl HeatMap {
    /// The map as one `<svg>` element.
    ///
    /// # Errors
    /// When there is no finite number, a row has another length than the columns, or the drawing library fails.
    pub fn svg(&self) -> Result<String> {
        let is_whole = self.values.len() == self.rows.len()
            && self
                .values
                .iter()
                .all(|row| row.len() == self.columns.len());
        if !is_whole {
            bail!("a heat map needs a number, or none, for each row and column");
        }
        let finite = self
            .values
            .iter()
            .flatten()
            .flatten()
            .filter(|it| it.is_finite());
        let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), it| {
            (low.min(*it), high.max(*it))
        });
        if low > high {
            bail!("there is nothing to draw");
        }
        let fields = FIELD * self.rows.len().min(40) as u32;
        let height = fields.max(LEAST_HEIGHT) + X_LABELS + 2 * MARGIN;
        let mut text = String::new();
        {
            let area = SVGBackend::with_string(&mut text, (SIZE.0, height)).into_drawing_area();
            let (map, scale) = area.split_horizontally(SIZE.0 - SCALE);
            self.draw(&map, low, high)
                .and_then(|()| self.draw_scale(&scale, low, high))
                // Once: it closes the element.
                .and_then(|()| Ok(area.present()?))
                .map_err(|error| anyhow!("heat map of {}: {error}", self.quantity))?;
        }
        Ok(text)
    }

    fn draw(&self, area: &DrawingArea<SVGBackend<'_>, Shift>, low: f64, high: f64) -> Result<()> {
        let mut chart = ChartBuilder::on(area)
            .margin(MARGIN)
            .x_label_area_size(X_LABELS)
            .y_label_area_size(NAMES)
            .build_cartesian_2d(
                segments(self.columns.len()).into_segmented(),
                segments(self.rows.len()).into_segmented(),
            )?;
        let named = |names: &[String], at: &SegmentValue<u32>| match at {
            SegmentValue::CenterOf(place) => {
                names.get(*place as usize).cloned().unwrap_or_default()
            }
            SegmentValue::Exact(_) | SegmentValue::Last => String::new(),
        };
        chart
            .configure_mesh()
            .disable_mesh()
            .x_labels(self.columns.len().min(MOST_NAMES))
            .y_labels(self.rows.len().min(MOST_NAMES))
            .x_desc(&self.axes[0])
            .y_desc(&self.axes[1])
            .x_label_formatter(&|at| named(&self.columns, at))
            .y_label_formatter(&|at| named(&self.rows, at))
            .axis_style(AXIS)
            .label_style(LABELS)
            .draw()?;
        let fields = self.values.iter().enumerate().flat_map(|(y, row)| {
            let row = row.iter().enumerate();
            row.filter_map(move |(x, value)| Some((x as u32, y as u32, (*value)?)))
        });
        let fields = fields.filter(|(_, _, value)| value.is_finite());
        chart.draw_series(fields.map(|(x, y, value)| {
            let corners = [
                (SegmentValue::Exact(x), SegmentValue::Exact(y)),
                (SegmentValue::Exact(x + 1), SegmentValue::Exact(y + 1)),
            ];
            Rectangle::new(corners, colour(value, low, high).filled())
        }))?;
        Ok(())
    }

    fn draw_scale(
        &self,
        area: &DrawingArea<SVGBackend<'_>, Shift>,
        low: f64,
        high: f64,
    ) -> Result<()> {
        let air = match high > low {
            true => 0.0,
            false => 1e-9 + 1e-6 * high.abs(),
        };
        let (from, to) = (low - air, high + air);
        let mut chart = ChartBuilder::on(area)
            .margin(MARGIN)
            .x_label_area_size(X_LABELS)
            .y_label_area_size(70)
            .build_cartesian_2d(0.0..1.0, from..to)?;
        chart
            .configure_mesh()
            .disable_mesh()
            .x_labels(0)
            .y_labels(6)
            .y_desc(&self.quantity)
            .y_label_formatter(&label)
            .axis_style(AXIS)
            .label_style(LABELS)
            .draw()?;
        const STEPS: u32 = 64;
        let at = |step: u32| from + (to - from) * f64::from(step) / f64::from(STEPS);
        chart.draw_series((0..STEPS).map(|step| {
            let corners = [(0.0, at(step)), (1.0, at(step + 1))];
            Rectangle::new(corners, colour(at(step), from, to).filled())
        }))?;
        Ok(())
    }
}

/// The first and the last of so many segments; of one, a second is left empty.
fn segments(count: usize) -> std::ops::Range<u32> {
    0..count.max(2) as u32 - 1
}

/// The colour of a value between `low` and `high`.
fn colour(value: f64, low: f64, high: f64) -> RGBColor {
    let share = if high > low {
        (value - low) / (high - low)
    } else {
        0.5
    };
    let place = share.clamp(0.0, 1.0) * (COLOURS.len() - 1) as f64;
    let below = (place as usize).min(COLOURS.len() - 2);
    let part = place - below as f64;
    let (a, b) = (COLOURS[below], COLOURS[below + 1]);
    let mixed = |a: u8, b: u8| (f64::from(a) + part * (f64::from(b) - f64::from(a))).round() as u8;
    RGBColor(mixed(a.0, b.0), mixed(a.1, b.1), mixed(a.2, b.2))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(values: Vec<Vec<Option<f64>>>) -> HeatMap {
        HeatMap {
            axes: ["gain".to_owned(), "speed [m/s]".to_owned()],
            columns: vec!["1".to_owned(), "2".to_owned()],
            rows: vec!["slow".to_owned()],
            values,
            quantity: "settling time [s]".to_owned(),
        }
    }

    #[test]
    fn a_field_is_drawn_for_each_number_and_none_where_there_is_none() {
        let svg = |values| map(values).svg().expect("drawn");
        let fields = |svg: &str| svg.matches("<rect").count();
        let both = svg(vec![vec![Some(1.0), Some(2.0)]]);
        assert!(both.starts_with("<svg") && both.contains("slow") && both.contains("gain"));
        assert!(both.trim_end().ends_with("</svg>") && both.matches("</svg>").count() == 1);
        assert!(both.contains("#440154") || both.to_lowercase().contains("#440154"));
        let one = svg(vec![vec![Some(1.0), None]]);
        assert_eq!(fields(&both), fields(&one) + 1);
        assert_eq!(
            fields(&svg(vec![vec![Some(1.0), Some(f64::NAN)]])),
            fields(&one)
        );
    }

    #[test]
    fn a_map_of_nothing_or_of_another_shape_says_so() {
        assert!(map(vec![vec![None, None]]).svg().is_err());
        assert!(map(vec![vec![Some(1.0)]]).svg().is_err());
    }
}
