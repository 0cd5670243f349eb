//! A plot: its series, and its data as JSON for the page's script.

use std::borrow::Cow;

use serde_json::{Map, Value, json};

use crate::plot::error::{LARGEST, PlotError};
use crate::plot::json::{list, places, script};
use planesman_linear::TimeHistory;

/// One line or point set of a plot.
pub struct Series<'a> {
    /// Name in the legend.
    pub name: Cow<'a, str>,
    /// Points (x, y).
    pub points: Vec<(f64, f64)>,
    /// Drawing style of the series.
    pub style: Style,
    /// Name of a further quantity and its value at each point, such as the gain along a locus.
    pub at: Option<(Cow<'a, str>, Vec<f64>)>,
}

impl<'a> Series<'a> {
    /// A series of these points.
    pub fn new(
        style: Style,
        name: impl Into<Cow<'a, str>>,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        Self {
            name: name.into(),
            points: points.into_iter().collect(),
            style,
            at: None,
        }
    }

    /// Whether x never decreases, apart from rounding of times.
    fn is_over_x(&self) -> bool {
        let finite = self.points.iter().map(|p| p.0).filter(|x| x.is_finite());
        let x: Vec<f64> = finite.collect();
        let rounding = match x[..] {
            [first, .., last] => 1e-6 * (last - first).abs(),
            _ => 0.0,
        };
        self.style == Style::Area || x.is_sorted_by(|a, b| *a <= b + rounding)
    }

    /// A band between two lines; each point has x, lower y and upper y. The band has the colour of the next series.
    pub fn band(
        name: impl Into<Cow<'a, str>>,
        bounds: impl IntoIterator<Item = (f64, f64, f64)>,
    ) -> Self {
        let bounds: Vec<_> = bounds.into_iter().collect();
        let upper = bounds.iter().map(|(x, _, high)| (*x, *high));
        let lower = bounds.iter().rev().map(|(x, low, _)| (*x, *low));
        Self::new(Style::Area, name, upper.chain(lower))
    }
}

planesman_text::choices! {
    /// Drawing style of a series.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Style {
        /// A solid line.
        Line = "line",
        /// A thin dashed line, for setpoints and truths.
        Dashed = "dashed",
        /// A broad pale line, for measured data below other series.
        Broad = "broad",
        /// Crosses, for poles.
        Crosses = "crosses",
        /// Circles, for true poles and zeros.
        Circles = "circles",
        /// Squares, for the beginning of a locus.
        Squares = "squares",
        /// Diamonds, for the end of a locus.
        Diamonds = "diamonds",
        /// Small dots, for loci.
        Dots = "dots",
        /// A pale filled area between the points, in the colour of the next series.
        Area = "area",
        /// A thin dashed line in the text colour, for bounds.
        Bound = "bound",
        /// A thin pale line in the text colour, for a grid.
        Grid = "grid",
    }
}

/// A plot with its heading and note.
pub struct Plot<'a> {
    /// The heading.
    pub title: Cow<'a, str>,
    /// A note of one or two sentences; may be empty.
    pub note: Cow<'a, str>,
    /// Label of the x axis, with its unit.
    x: &'a str,
    /// Label of the y axis, with its unit.
    y: &'a str,
    /// Draws larger y values lower.
    y_down: bool,
    /// The x axis includes zero.
    from_zero: bool,
    /// Both axes have the same scale.
    one_scale: bool,
    /// Points in a plane, not a function of x.
    plane: bool,
    /// The x axis is logarithmic.
    log_x: bool,
    /// Plots with the same name share one x axis: zoom and cursor.
    link: &'a str,
    /// The series.
    pub series: Vec<Series<'a>>,
}

/// A plot is built call by call: `Plot::new("Depth", ["time [s]", "depth [m]"]).line("depth", points)`.
impl<'a> Plot<'a> {
    /// An empty plot with the labels of its axes, x first.
    #[must_use]
    pub fn new(title: impl Into<Cow<'a, str>>, [x, y]: [&'a str; 2]) -> Self {
        Self {
            title: title.into(),
            note: Cow::Borrowed(""),
            x,
            y,
            y_down: false,
            from_zero: false,
            one_scale: false,
            plane: false,
            log_x: false,
            link: "",
            series: Vec::new(),
        }
    }

    /// Adds a note of one or two sentences.
    #[must_use]
    pub fn note(self, note: impl Into<Cow<'a, str>>) -> Self {
        Self {
            note: note.into(),
            ..self
        }
    }

    /// Draws larger y values lower, as usual for depth.
    #[must_use]
    pub fn y_down(self) -> Self {
        Self {
            y_down: true,
            ..self
        }
    }

    /// Makes the x axis include zero.
    #[must_use]
    pub fn from_zero(self) -> Self {
        Self {
            from_zero: true,
            ..self
        }
    }

    /// Marks the points as points in a plane: the cursor finds the nearest point, in contrast to the point with the same x.
    #[must_use]
    pub fn plane(self) -> Self {
        Self {
            plane: true,
            ..self
        }
    }

    /// Gives both axes the same scale, so that circles are round.
    #[must_use]
    pub fn one_scale(self) -> Self {
        Self {
            one_scale: true,
            plane: true,
            ..self
        }
    }

    /// Shades a range of x over a range of y, in the colour of the next series.
    #[must_use]
    pub fn shaded(
        self,
        name: impl Into<Cow<'a, str>>,
        (from, to): (f64, f64),
        (low, high): (f64, f64),
    ) -> Self {
        self.with_all([Series::band(name, [(from, low, high), (to, low, high)])])
    }

    /// Makes the x axis logarithmic; points at or below zero are left out.
    #[must_use]
    pub fn log_x(self) -> Self {
        Self {
            log_x: true,
            ..self
        }
    }

    /// Shares the x axis (zoom and cursor) with all plots of this name on the page.
    #[must_use]
    pub fn linked(self, link: &'a str) -> Self {
        Self { link, ..self }
    }

    /// Adds several series.
    #[must_use]
    pub fn with_all(mut self, series: impl IntoIterator<Item = Series<'a>>) -> Self {
        self.series.extend(series);
        self
    }

    /// Adds a series.
    #[must_use]
    pub fn with(
        mut self,
        style: Style,
        name: impl Into<Cow<'a, str>>,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        self.series.push(Series::new(style, name, points));
        self
    }

    /// Adds a solid line.
    #[must_use]
    pub fn line(
        self,
        name: impl Into<Cow<'a, str>>,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        self.with(Style::Line, name, points)
    }

    /// Adds a thin dashed line.
    #[must_use]
    pub fn dashed(
        self,
        name: impl Into<Cow<'a, str>>,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        self.with(Style::Dashed, name, points)
    }

    /// Whether the plot has no points.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.series.iter().all(|series| series.points.is_empty())
    }

    /// The plot's data as content of a `<script type="application/json">`, from which the page's script draws the plot. Points that are not finite
    /// are left out; a long time history is reduced to its visible points ([`TimeHistory`]).
    ///
    /// # Errors
    /// No series has a finite point, or a point is beyond 1e30.
    pub fn data(&self) -> Result<String, PlotError> {
        let plane = self.plane || !self.series.iter().all(Series::is_over_x);
        let mut colour = 0;
        let mut series = Vec::new();
        for it in &self.series {
            let number = match it.style {
                Style::Bound | Style::Grid => 0,
                Style::Area => colour + 1,
                // A further part of the series before.
                Style::Line | Style::Broad if it.name.is_empty() => colour,
                _ => {
                    colour += 1;
                    colour
                }
            };
            series.push(self.series_data(it, number, plane)?);
        }
        if series
            .iter()
            .all(|it| it["y"].as_array().is_none_or(Vec::is_empty))
        {
            return Err(PlotError::Empty(self.title.to_string()));
        }
        let mut data = Map::new();
        data.insert("x".to_owned(), self.x.into());
        data.insert("y".to_owned(), self.y.into());
        for (name, is_so) in [
            ("down", self.y_down),
            ("zero", self.from_zero),
            ("equal", self.one_scale),
            ("plane", plane),
            ("log", self.log_x),
        ] {
            if is_so {
                data.insert(name.to_owned(), true.into());
            }
        }
        if !self.link.is_empty() {
            data.insert("link".to_owned(), self.link.into());
        }
        data.insert("series".to_owned(), series.into());
        Ok(script(&data.into()))
    }

    /// The JSON of a series; `colour` is the number of its colour, 0 for no colour.
    fn series_data(
        &self,
        series: &Series<'_>,
        colour: usize,
        plane: bool,
    ) -> Result<Value, PlotError> {
        let drawn =
            |(x, y): &(f64, f64)| x.is_finite() && y.is_finite() && (!self.log_x || *x > 0.0);
        let values = series.at.as_ref().map(|(name, values)| {
            let kept = series.points.iter().zip(values);
            let kept = kept.filter(|(point, _)| drawn(point)).map(|(_, it)| *it);
            (name, kept.collect::<Vec<_>>())
        });
        let mut points: Vec<_> = series.points.iter().copied().filter(drawn).collect();
        if !plane && matches!(series.style, Style::Line | Style::Dashed | Style::Broad) {
            points = points
                .into_iter()
                .collect::<TimeHistory>()
                .points()
                .collect();
        }
        if let Some(far) = points
            .iter()
            .flat_map(|(x, y)| [x, y])
            .find(|it| it.abs() > LARGEST)
        {
            return Err(PlotError::TooLarge(self.title.to_string(), *far));
        }
        let mut data = json!({
            "name": series.name,
            "style": series.style.name(),
            "colour": colour,
            "x": places(points.iter().map(|p| p.0)),
            "y": list(points.iter().map(|p| p.1)),
        });
        if let Some((name, values)) = values {
            data["at"] = json!({ "name": name, "values": list(values.into_iter()) });
        }
        Ok(data)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(points: Vec<(f64, f64)>) -> Plot<'static> {
        Plot::new("t", ["s", "m"]).line("a", points)
    }

    fn data(plot: &Plot<'_>) -> Value {
        serde_json::from_str(&plot.data().expect("drawn")).expect("JSON")
    }

    #[test]
    fn what_is_not_finite_is_left_out() {
        let data = data(&plot(vec![(0.0, 1.0), (1.0, f64::NAN), (2.5, 3.0)]));
        assert_eq!(data["series"][0]["y"], json!([1, 3]));
        assert_eq!(
            data["series"][0]["x"],
            json!({"first": 0, "last": 2.5, "count": 2})
        );
    }

    #[test]
    fn a_plot_of_nothing_says_so() {
        assert!(plot(vec![(f64::NAN, 0.0)]).data().is_err());
        assert!(Plot::new("t", ["s", "m"]).data().is_err());
    }

    #[test]
    fn numbers_beyond_all_quantities_are_refused_by_name() {
        let refusal = plot(vec![(0.0, 0.0), (1.0, 1e300)])
            .data()
            .expect_err("refused");
        assert!(refusal.to_string().contains("1e300"), "{refusal}");
    }

    #[test]
    fn a_bound_leaves_the_colours_to_the_others_and_an_area_has_that_of_its_line() {
        let plot = plot(vec![(0.0, 1.0)])
            .with(Style::Bound, "bound", [(0.0, 0.0)])
            .with_all([Series::band("95 %", [(0.0, 1.0, 3.0)])])
            .line("b", [(0.0, 2.0)]);
        let data = data(&plot);
        let colours = data["series"].as_array().expect("a list").iter();
        let colours: Vec<_> = colours.map(|it| it["colour"].as_u64()).collect();
        assert_eq!(colours, [Some(1), Some(0), Some(2), Some(2)]);
    }

    #[test]
    fn a_name_does_not_end_the_script_that_holds_it() {
        let name = "</script><script>alert(1)</script>";
        let plot = Plot::new("t", ["s", "m"]).line(name, [(0.0, 1.0)]);
        assert!(!plot.data().expect("drawn").contains('<'));
        assert_eq!(data(&plot)["series"][0]["name"], name);
    }

    #[test]
    fn a_long_time_history_is_as_fine_as_a_page_can_show() {
        let points = (0..200_000).map(|k| (f64::from(k), f64::from(k % 7)));
        let data = data(&plot(points.collect()));
        let drawn = data["series"][0]["y"].as_array().expect("a list").len();
        assert!((2_000..=8_192).contains(&drawn), "{drawn}");
    }

    #[test]
    fn a_value_stays_with_its_point() {
        let mut plot = Plot::new("t", ["re", "im"]).one_scale();
        plot.series.push(Series {
            at: Some(("gain".into(), vec![1.0, 2.0, 3.0])),
            ..Series::new(
                Style::Dots,
                "locus",
                [(0.0, 1.0), (f64::NAN, 1.0), (2.0, 0.0)],
            )
        });
        assert_eq!(data(&plot)["series"][0]["at"]["values"], json!([1, 3]));
    }
}
