//! A heat map: one coloured field per pair of values.

use serde_json::{Value, json};

use crate::plot::error::PlotError;
use crate::plot::json::{list, script};

/// Numbers over two lists of values.
#[derive(Clone, Debug)]
pub struct HeatMap {
    /// Names of the horizontal and the vertical axis, with units.
    pub axes: [String; 2],
    /// Values along the horizontal axis, as text.
    pub columns: Vec<String>,
    /// Values along the vertical axis, from bottom to top, as text.
    pub rows: Vec<String>,
    /// A number per row and column; `None` leaves a field empty.
    pub values: Vec<Vec<Option<f64>>>,
    /// Name of the quantity, with its unit.
    pub quantity: String,
    /// Row and column of the best field, which is marked.
    pub best: Option<[usize; 2]>,
}

impl HeatMap {
    /// The map's data as content of a `<script type="application/json">`, from which the page's script draws the map.
    ///
    /// # Errors
    /// No finite number, or a row whose length differs from the number of columns.
    pub fn data(&self) -> Result<String, PlotError> {
        let is_whole = self.values.len() == self.rows.len()
            && self
                .values
                .iter()
                .all(|row| row.len() == self.columns.len());
        if !is_whole {
            return Err(PlotError::HeatMapShape);
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
            return Err(PlotError::EmptyHeatMap);
        }
        let rows = self.values.iter();
        let heat: Value = rows
            .map(|row| list(row.iter().map(|it| it.unwrap_or(f64::NAN))))
            .collect();
        let [x, y] = &self.axes;
        Ok(script(&json!({
            "x": x,
            "y": y,
            "columns": self.columns,
            "rows": self.rows,
            "quantity": self.quantity,
            "range": list([low, high].into_iter()),
            "heat": heat,
            "best": self.best,
        })))
    }
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
            best: None,
        }
    }

    #[test]
    fn a_field_without_a_number_is_empty_and_the_range_is_that_of_the_others() {
        let data = map(vec![vec![Some(1.5), Some(f64::NAN)]])
            .data()
            .expect("drawn");
        let data: Value = serde_json::from_str(&data).expect("JSON");
        assert_eq!(data["heat"], json!([[1.5, null]]));
        assert_eq!(data["range"], json!([1.5, 1.5]));
    }

    #[test]
    fn a_map_of_nothing_or_of_another_shape_says_so() {
        assert!(map(vec![vec![None, None]]).data().is_err());
        assert!(map(vec![vec![Some(1.0)]]).data().is_err());
    }
}
