//! Line plots and heat maps as SVG text.

mod heat_map;

use std::borrow::Cow;

use anyhow::{Result, anyhow};
use plotters::data::float::FloatPrettyPrinter;
use plotters::prelude::*;

pub use heat_map::HeatMap;

/// One line or point set of a plot.
pub struct Series<'a> {
    /// Its name in the legend.
    pub name: Cow<'a, str>,
    /// Its points.
    pub points: Vec<(f64, f64)>,
    /// How it is drawn.
    pub style: Style,
}

/// How a series is drawn.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Style {
    /// A solid line.
    Line,
    /// A thin dashed line, for setpoints and truths.
    Dashed,
    /// Crosses, for poles.
    Crosses,
    /// Circles, for true poles.
    Circles,
    /// Small dots, for loci.
    Dots,
    /// A thin dashed black line, for bounds: it takes none of the other series' colours.
    Bound,
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

    /// A unit is as long on one axis as on the other: a circle is round.
    #[must_use]
    pub fn one_scale(self) -> Self {
        Self {
            one_scale: true,
            ..self
        }
    }

    /// With one more series.
    #[must_use]
    pub fn with(
        mut self,
        style: Style,
        name: impl Into<Cow<'a, str>>,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        self.series.push(Series {
            name: name.into(),
            points: points.into_iter().collect(),
            style,
        });
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
}

const SIZE: (u32, u32) = (820, 300);

/// The largest magnitude drawn: beyond any quantity in any unit, and small enough to compute with.
const LARGEST: f64 = 1e30;

/// The border around the plot area, pixels: margin and axis labels.
const MARGIN: u32 = 8;
const X_LABELS: u32 = 36;
const Y_LABELS: u32 = 64;

/// Colour of the axes, and font of what stands along them.
const AXIS: RGBColor = RGBColor(120, 120, 120);
const LABELS: (&str, u32) = ("sans-serif", 13);

/// The side of a square field, pixels.
const SIDE: u32 = 480;

/// Colours that people with any colour vision tell apart (Okabe and Ito).
const COLOURS: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(90, 90, 90),
    RGBColor(230, 159, 0),
];

impl Plot<'_> {
    /// The plot as one `<svg>` element.
    ///
    /// # Errors
    /// When no series has a finite point, one lies beyond 1e30, or the drawing library fails.
    pub fn svg(&self) -> Result<String> {
        let mut text = String::new();
        let size = if self.one_scale {
            let around = 2 * MARGIN;
            (SIDE + Y_LABELS + around, SIDE + X_LABELS + around)
        } else {
            SIZE
        };
        self.draw(&SVGBackend::with_string(&mut text, size).into_drawing_area())
            .map_err(|e| anyhow!("plot '{}': {e}", self.title))?;
        Ok(text)
    }

    fn draw(&self, area: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>) -> Result<()> {
        let (x, mut y) = self.ranges()?;
        if self.y_down {
            y = y.end..y.start;
        }
        let mut chart = ChartBuilder::on(area)
            .margin(MARGIN)
            .x_label_area_size(X_LABELS)
            .y_label_area_size(Y_LABELS)
            .build_cartesian_2d(x, y)?;
        chart
            .configure_mesh()
            .x_desc(self.x)
            .y_desc(self.y)
            .x_label_formatter(&label)
            .y_label_formatter(&label)
            .light_line_style(TRANSPARENT)
            .bold_line_style(RGBColor(228, 228, 228))
            .axis_style(AXIS)
            .label_style(LABELS)
            .draw()?;
        for (series, colour) in self.coloured() {
            let points = series.points.iter().copied().filter(finite);
            let line = ShapeStyle::from(colour).stroke_width(2);
            match series.style {
                Style::Line => chart.draw_series(LineSeries::new(points, line))?,
                Style::Dashed | Style::Bound => chart.draw_series(DashedLineSeries::new(
                    points,
                    6,
                    4,
                    ShapeStyle::from(colour).stroke_width(1),
                ))?,
                Style::Crosses => chart.draw_series(points.map(|p| Cross::new(p, 5, line)))?,
                Style::Circles => chart.draw_series(
                    points.map(|p| Circle::new(p, 7, ShapeStyle::from(colour).stroke_width(2))),
                )?,
                Style::Dots => chart.draw_series(
                    points.map(|p| Circle::new(p, 1, ShapeStyle::from(colour).filled())),
                )?,
            };
        }
        area.present()?;
        Ok(())
    }

    /// Each series with its colour.
    fn coloured(&self) -> impl Iterator<Item = (&Series<'_>, &RGBColor)> {
        let mut colours = COLOURS.iter().cycle();
        self.series.iter().map(move |series| match series.style {
            Style::Bound => (series, &BLACK),
            _ => (series, colours.next().unwrap_or(&BLACK)),
        })
    }

    /// Each series' name, colour (`#rrggbb`) and style, for a legend beside the drawing.
    pub fn legend(&self) -> impl Iterator<Item = (&str, String, Style)> {
        self.coloured().map(|(series, RGBColor(r, g, b))| {
            let colour = format!("#{r:02x}{g:02x}{b:02x}");
            (&*series.name, colour, series.style)
        })
    }

    /// Both axes' ranges, with a little air.
    fn ranges(&self) -> Result<(std::ops::Range<f64>, std::ops::Range<f64>)> {
        let mut low = (f64::INFINITY, f64::INFINITY);
        let mut high = (f64::NEG_INFINITY, f64::NEG_INFINITY);
        for p in self
            .series
            .iter()
            .flat_map(|s| s.points.iter().copied())
            .filter(finite)
        {
            low = (low.0.min(p.0), low.1.min(p.1));
            high = (high.0.max(p.0), high.1.max(p.1));
        }
        if self.from_zero {
            low.0 = low.0.min(0.0);
            high.0 = high.0.max(0.0);
        }
        if low.1 > high.1 {
            return Err(anyhow!("there is nothing to draw"));
        }
        for end in [low.0, low.1, high.0, high.1] {
            if end.abs() > LARGEST {
                return Err(anyhow!(
                    "{end:e} cannot be drawn: it must lie within ±{LARGEST:e}"
                ));
            }
        }
        let widen = |low: f64, high: f64, share: f64| {
            let air = ((high - low) * share).max(1e-9 + 1e-6 * high.abs().max(low.abs()));
            low - air..high + air
        };
        if self.one_scale {
            let half = 0.55 * (high.0 - low.0).max(high.1 - low.1).max(1e-9);
            let about = |low: f64, high: f64| (low + high) / 2.0 - half..(low + high) / 2.0 + half;
            return Ok((about(low.0, high.0), about(low.1, high.1)));
        }
        Ok((widen(low.0, high.0, 0.01), widen(low.1, high.1, 0.08)))
    }
}

/// A number at an axis, as the drawing library writes it but for zero, which has no sign.
fn label(value: &f64) -> String {
    let printer = FloatPrettyPrinter {
        allow_scientific: false,
        min_decimal: 1,
        max_decimal: 5,
    };
    let text = printer.print(*value);
    match text.strip_prefix('-') {
        Some(digits) if digits.chars().all(|c| matches!(c, '0' | '.')) => digits.to_owned(),
        _ => text,
    }
}

fn finite(p: &(f64, f64)) -> bool {
    p.0.is_finite() && p.1.is_finite()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(points: Vec<(f64, f64)>) -> Plot<'static> {
        Plot::new("t", ["s", "m"]).line("a", points)
    }

    #[test]
    fn a_plot_is_one_svg_element_that_leaves_out_what_is_not_finite() {
        let svg = plot(vec![(0.0, 1.0), (1.0, f64::NAN), (2.0, 3.0)])
            .svg()
            .expect("drawn");
        assert!(svg.starts_with("<svg") && svg.contains("</svg>") && !svg.contains("NaN"));
    }

    #[test]
    fn a_plot_of_nothing_says_so() {
        assert!(plot(vec![(f64::NAN, 0.0)]).svg().is_err());
    }

    #[test]
    fn numbers_beyond_all_quantities_are_refused_by_name() {
        let refusal = plot(vec![(0.0, 0.0), (1.0, 1e300)])
            .svg()
            .expect_err("refused");
        assert!(refusal.to_string().contains("1e300"), "{refusal}");
    }

    #[test]
    fn a_bound_leaves_the_colours_to_the_others() {
        let plot = plot(vec![(0.0, 1.0)])
            .with(Style::Bound, "bound", [(0.0, 0.0)])
            .line("b", [(0.0, 2.0)]);
        let colours: Vec<String> = plot.legend().map(|(_, colour, _)| colour).collect();
        assert_eq!(colours, ["#0072b2", "#000000", "#d55e00"]);
    }

    #[test]
    fn zero_has_no_sign_at_an_axis() {
        assert_eq!(label(&-1e-18), "0.0");
        assert_eq!(label(&-0.25), "-0.25");
    }

    #[test]
    fn a_constant_has_room_around_it() {
        assert!(plot(vec![(0.0, 5.0), (1.0, 5.0)]).svg().is_ok());
    }
}
