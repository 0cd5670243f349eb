//! One plot: its series, and its data as JSON for the script of the page.

use std::borrow::Cow;

use serde_json::{Map, Value, json};

use crate::plot::error::{LARGEST, PlotError};
use crate::plot::json::{list, places, script};
use planesman_linear::TimeHistory;

/// One line or point set of a plot.
pub struct Series<'a> {
    /// Its name in the legend.
    pub name: Cow<'a, str>,
    /// Its points.
    pub points: Vec<(f64, f64)>,
    /// How it is drawn.
    pub style: Style,
    /// The name of a quantity, and its value at each point: the gain along a locus.
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

    /// Whether x never falls, but for the rounding of times.
    fn is_over_x(&self) -> bool {
        let finite = self.points.iter().map(|p| p.0).filter(|x| x.is_finite());
        let x: Vec<f64> = finite.collect();
        let rounding = match x[..] {
            [first, .., last] => 1e-6 * (last - first).abs(),
            _ => 0.0,
        };
        self.style == Style::Area || x.is_sorted_by(|a, b| *a <= b + rounding)
    }

    /// An area between two lines, each point an x with the lower and the upper y. It has the colour of the series after it.
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
    /// How a series is drawn.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Style {
        /// A solid line.
        Line = "line",
        /// A thin dashed line, for setpoints and truths.
        Dashed = "dashed",
        /// A broad pale line, for measured data that others are drawn over.
        Broad = "broad",
        /// Crosses, for poles.
        Crosses = "crosses",
        /// Circles, for true poles and zeros.
        Circles = "circles",
        /// Squares, for the begin of a locus.
        Squares = "squares",
        /// Diamonds, for its end.
        Diamonds = "diamonds",
        /// Small dots, for loci.
        Dots = "dots",
        /// The area within the points, pale: it has the colour of the series after it.
        Area = "area",
        /// A thin dashed line in the colour of the text, for bounds: it takes none of the other series' colours.
        Bound = "bound",
        /// A thin pale line in the colour of the text, for a grid of the plane.
        Grid = "grid",
    }
}

/// One plot, with what is written above it.
pub struct Plot<'a> {
    /// The heading.
    pub title: Cow<'a, str>,
    /// A note of a sentence or two; may be empty.
    pub note: Cow<'a, str>,
    /// The x axis, with its unit.
    x: &'a str,
    /// The y axis, with its unit.
    y: &'a str,
    /// Draws larger y values lower.
    y_down: bool,
    /// The x axis reaches zero, wherever the data begin.
    from_zero: bool,
    /// A unit is as long on one axis as on the other.
    one_scale: bool,
    /// Points anywhere in a plane, not over x.
    plane: bool,
    /// The x axis is logarithmic.
    log_x: bool,
    /// The plots of one name have one x axis: zoom and cursor are common.
    link: &'a str,
    /// The series.
    pub series: Vec<Series<'a>>,
}

/// A plot is put together call by call: `Plot::new("Depth", ["time [s]", "depth [m]"]).line("depth", points)`.
impl<'a> Plot<'a> {
    /// A plot of nothing yet, its axes named with their units, x first.
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

    /// With a sentence or two about what it shows.
    #[must_use]
    pub fn note(self, note: impl Into<Cow<'a, str>>) -> Self {
        Self {
            note: note.into(),
            ..self
        }
    }

    /// Larger y values lower, as divers think of depth.
    #[must_use]
    pub fn y_down(self) -> Self {
        Self {
            y_down: true,
            ..self
        }
    }

    /// The x axis reaches zero, wherever the data begin.
    #[must_use]
    pub fn from_zero(self) -> Self {
        Self {
            from_zero: true,
            ..self
        }
    }

    /// Points anywhere in a plane: the cursor finds the nearest one, not that of the same x.
    #[must_use]
    pub fn plane(self) -> Self {
        Self {
            plane: true,
            ..self
        }
    }

    /// A plane in which a unit is as long on one axis as on the other: a circle is round.
    #[must_use]
    pub fn one_scale(self) -> Self {
        Self {
            one_scale: true,
            plane: true,
            ..self
        }
    }

    /// With a range of x shaded, over these heights; it has the colour of the series after it.
    #[must_use]
    pub fn shaded(
        self,
        name: impl Into<Cow<'a, str>>,
        (from, to): (f64, f64),
        (low, high): (f64, f64),
    ) -> Self {
        self.with_all([Series::band(name, [(from, low, high), (to, low, high)])])
    }

    /// A logarithmic x axis; points at or below zero are left out.
    #[must_use]
    pub fn log_x(self) -> Self {
        Self {
            log_x: true,
            ..self
        }
    }

    /// One x axis with the other plots of this name on the page: zoom and cursor are common.
    #[must_use]
    pub fn linked(self, link: &'a str) -> Self {
        Self { link, ..self }
    }

    /// With these series too.
    #[must_use]
    pub fn with_all(mut self, series: impl IntoIterator<Item = Series<'a>>) -> Self {
        self.series.extend(series);
        self
    }

    /// With one more series.
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

    /// With a solid line.
    #[must_use]
    pub fn line(
        self,
        name: impl Into<Cow<'a, str>>,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        self.with(Style::Line, name, points)
    }

    /// With a thin dashed line.
    #[must_use]
    pub fn dashed(
        self,
        name: impl Into<Cow<'a, str>>,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        self.with(Style::Dashed, name, points)
    }

    /// Whether there is no point to draw.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.series.iter().all(|series| series.points.is_empty())
    }

    /// The plot's data as the text of a `<script type="application/json">`, from which the page's script draws it. Points that are
    /// not finite are left out; of a long time history it has what can be seen of it ([`TimeHistory`]).
    ///
    /// # Errors
    /// When no series has a finite point, or one lies beyond 1e30.
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

    /// A series with the number of its colour, 0 for none.
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
