//! Limit cycles of the depth loop with the digital hydraulic actuator in one table: simulated, the orbit found by shooting, and
//! the cycle foreseen by harmonic balance.

use maud::html;
use planesman_console::{Format, Table, wrapped};
use planesman_pages::{document, figures};
use planesman_plot::{Plot, Style};
use planesman_units::{DEGREE, INCH};

use crate::depth_loop::{Case, Dive, DiveError, Figure, LimitCycle, MOST_RESIDUAL, Prediction};
use crate::orbit::Orbit;
use crate::watched::{Irregular, Motion};

/// The most points of a curve on the page.
const POINTS: usize = 400;
/// Depth error, in, and plane angle, deg.
type Curve = Vec<(f64, f64)>;

/// The page: the table, each orbit, and predicted beside simulated.
#[must_use]
pub fn page(rows: &[Row]) -> String {
    let (table, compared, deviating) = table(rows);
    let of = |plot: Plot<'static>, pair: &dyn Fn(&Row) -> Option<(f64, f64)>| {
        let points: Vec<(f64, f64)> = rows.iter().filter_map(pair).collect();
        let most = points
            .iter()
            .fold(0.0_f64, |most, p| most.max(p.0).max(p.1));
        plot.plane()
            .with(Style::Crosses, "configuration", points)
            .with(Style::Bound, "equal", [(0.0, 0.0), (most, most)])
    };
    let cycle = |row: &Row| {
        let found = row.prediction.filter(|it| it.residual <= MOST_RESIDUAL)?;
        Some((row.frequency()?, found.frequency))
    };
    let orbit = |row: &Row| Some((row.frequency()?, row.orbit()?.turns()));
    let depth = |row: &Row| {
        let expected = row.case.expected?.depth?;
        Some((row.cycle.depth / INCH, expected))
    };
    let frequency = "simulated [Hz]";
    let plots = [
        of(
            Plot::new(
                "Frequency of the limit cycle",
                [frequency, "of the orbit [Hz]"],
            ),
            &orbit,
        ),
        of(
            Plot::new(
                "Frequency by harmonic balance",
                [frequency, "predicted by harmonic balance [Hz]"],
            ),
            &cycle,
        ),
        of(
            Plot::new(
                "Depth, peak to peak",
                ["simulated [in]", "by an independent simulation [in]"],
            ),
            &depth,
        ),
    ];
    let shown: Vec<_> = plots
        .into_iter()
        .filter(|plot| !plot.series[0].points.is_empty())
        .collect();
    let orbits: Vec<_> = rows.iter().filter_map(Row::phase_plane).collect();
    let title = "Limit cycles of the depth loop";
    let body = html! {
        h1 { (title) }
        ul.verdict {
            li { (rows.len()) " configurations; " (deviating) " of " (compared) " figures deviate by more than 15 % from an independent simulation (*)." }
            li { (tally(rows)) }
        }
        (figures(&shown))
        (table.html())
        p { (LEGEND) }
        h2 { "Orbits" }
        p { "One period of each orbit over the simulated motion (pale), which walks about it by up to a sample at each decision." }
        (figures(&orbits))
    };
    document(title, "", &body, "")
}

/// A configuration with its results.
#[derive(Clone, Debug)]
pub struct Row {
    /// The configuration.
    pub case: Case,
    /// Simulated.
    pub cycle: LimitCycle,
    /// What that motion is.
    pub motion: Motion,
    /// Predicted, if asked for.
    pub prediction: Option<Prediction>,
    /// Of the loop, when its motion was judged: turns a second; depth, m, and planes, rad, in a period of its orbit on average.
    followed: Option<[f64; 3]>,
    simulated: Curve,
}

impl Row {
    /// Simulates a configuration and finds its orbit, and predicts its cycle if that is asked for.
    ///
    /// # Errors
    /// Those of the actuator's file and of [`Loop::dive`](crate::depth_loop::Loop::dive).
    pub fn of(case: &Case, predicted: bool) -> Result<Self, DiveError> {
        let mut dive = case.run()?;
        let (motion, _) = case.motion(&mut dive)?;
        let followed = match &motion {
            Motion::Orbit(orbit) => {
                let watched = &dive.watched;
                let turns = orbit.turns() / (1.0 + watched.apart(orbit).0);
                let (swing, stroke) = (watched.swing(orbit.period), watched.stroke(orbit.period));
                Some([turns, swing, stroke])
            }
            _ => None,
        };
        Ok(Self {
            case: case.clone(),
            cycle: dive.cycle,
            prediction: predicted.then(|| case.predict()).transpose()?,
            followed,
            simulated: simulated(&dive, &motion),
            motion,
        })
    }

    /// The orbit that is followed.
    fn orbit(&self) -> Option<&Orbit> {
        match &self.motion {
            Motion::Orbit(orbit) => Some(orbit),
            _ => None,
        }
    }

    /// Turns a second.
    fn frequency(&self) -> Option<f64> {
        self.followed.map(|[turns, ..]| turns)
    }

    fn phase_plane(&self) -> Option<Plot<'static>> {
        let orbit = self.orbit()?;
        let axes = ["depth error [in]", "planes [deg]"];
        let title = format!("{}, M_theta = {}", self.case.name, self.case.restoring);
        let note = format!("{:.2} s; {}", orbit.period, multipliers(orbit));
        let every = orbit.samples.len().div_ceil(POINTS);
        let curve = orbit
            .samples
            .iter()
            .step_by(every)
            .chain(orbit.samples.first())
            .map(|s| (s.output / INCH, s.angle / DEGREE));
        Some(
            Plot::new(title, axes)
                .note(note)
                .plane()
                .with(Style::Broad, "simulated", self.simulated.clone())
                .with(Style::Line, "orbit", curve),
        )
    }
}

/// Three periods of the simulated motion at its end.
fn simulated(dive: &Dive, motion: &Motion) -> Curve {
    let Motion::Orbit(orbit) = motion else {
        return Vec::new();
    };
    let watched = &dive.watched;
    let length = (3.0 * orbit.period / watched.interval) as usize;
    let begin = watched.outputs.len().saturating_sub(length);
    let every = length.div_ceil(2 * POINTS).max(1);
    let both = watched.outputs.iter().zip(&watched.angles);
    both.skip(begin)
        .step_by(every)
        .map(|(depth, angle)| (depth / INCH, angle / DEGREE))
        .collect()
}

/// What the columns mean.
const LEGEND: &str = "Motion: an orbit found by shooting, which the loop follows, with its largest multiplier (below 1 a deviation decays); \
     rest; the same decisions again and again (repeats); or irregular, with the swing of the depth and the decisions a second in 50 s, and the multiplier of the \
     nearest orbit. Orbit (simulated): of a whole period, on average. First harmonic: its share in the variance of the angle asked of the actuator, which harmonic balance \
     takes for all of it. Predicted where 1 + N H comes within 0.1 of 0; otherwise harmonic balance foresees no cycle.";

/// How many of the motions are which.
fn tally(rows: &[Row]) -> String {
    let count = |is: fn(&Motion) -> bool| rows.iter().filter(|row| is(&row.motion)).count();
    format!(
        "{} orbits, {} exact repetitions, {} at rest, {} irregular.",
        count(|m| matches!(m, Motion::Orbit(_))),
        count(|m| matches!(m, Motion::Repeats(_))),
        count(|m| matches!(m, Motion::Rest)),
        count(|m| matches!(m, Motion::Irregular(_))),
    )
}

/// The table, a deviation marked with an asterisk; for people also what the marks mean.
#[must_use]
pub fn text(rows: &[Row], format: Format) -> String {
    let (table, compared, deviating) = table(rows);
    let mut text = table.text(format);
    if matches!(format, Format::Table | Format::Md) {
        text += &wrapped(&format!(
            "\n{}\nFound (expected by an independent simulation); {deviating} of {compared} figures deviate by more than 15 % (*).\n{LEGEND}\n",
            tally(rows)
        ));
    }
    text
}

/// The table; how many figures are compared, and how many of them deviate.
fn table(rows: &[Row]) -> (Table, usize, usize) {
    let mut table = Table::new([
        "configuration",
        "M_theta",
        "depth pp, in",
        "mean error, in",
        "planes pp, deg",
        "volumes/s",
        "t95, s",
        "motion",
        "orbit f, Hz",
        "orbit depth pp, in",
        "orbit planes pp, deg",
        "first harmonic",
        "predicted f, Hz: depth pp, in",
    ]);
    let (mut compared, mut deviating) = (0, 0);
    for row in rows {
        let expected = row.case.expected.unwrap_or_default();
        let mut cells = vec![row.case.name.clone(), row.case.restoring.to_string()];
        for figure in row.cycle.figures(&expected) {
            compared += usize::from(figure.expected.is_some());
            deviating += usize::from(!figure.agrees());
            cells.push(cell(&figure));
        }
        cells.push(described(&row.motion, INCHES));
        cells.extend(beside(row));
        cells.push(row.orbit().map_or_else(
            || "-".to_owned(),
            |orbit| format!("{:.0} %", 100.0 * orbit.first_harmonic()),
        ));
        cells.push(foreseen(row.prediction.as_ref()));
        table.row(cells);
    }
    (table, compared, deviating)
}

/// Of the depth.
pub(crate) const INCHES: (f64, &str) = (INCH, "in");

/// A motion in a few words, its swings in a unit.
pub(crate) fn described(motion: &Motion, (unit, name): (f64, &str)) -> String {
    match motion {
        Motion::Orbit(orbit) => format!("orbit, {}", multipliers(orbit)),
        Motion::Rest => "rest".to_owned(),
        Motion::Repeats(period) => format!("repeats after {period:.1} s"),
        Motion::Irregular(irregular) => {
            let Irregular { swing, rate, orbit } = irregular;
            let near = orbit.as_ref().map_or_else(String::new, |orbit| {
                format!("; nearest orbit {}", multipliers(orbit))
            });
            format!(
                "irregular: {:.4} to {:.4} {name}, {:.2} to {:.2} /s{near}",
                swing.0 / unit,
                swing.1 / unit,
                rate.0,
                rate.1
            )
        }
    }
}

fn multipliers(orbit: &Orbit) -> String {
    format!("multiplier {:.3}", orbit.growth())
}

/// Frequency, depth and planes of the orbit, each beside the simulated one.
fn beside(row: &Row) -> [String; 3] {
    let (Some(orbit), Some([turns, swing, stroke])) = (row.orbit(), row.followed) else {
        return ["-", "-", "-"].map(str::to_owned);
    };
    let pair = |orbit: f64, simulated: f64| format!("{orbit:.4} ({simulated:.4})");
    [
        pair(orbit.turns(), turns),
        pair(orbit.swing() / INCH, swing / INCH),
        pair(orbit.stroke() / DEGREE, stroke / DEGREE),
    ]
}

fn cell(figure: &Figure) -> String {
    let number = |value: f64| format!("{value:.3}");
    let found = figure.found.map_or_else(|| "never".to_owned(), number);
    let mark = if figure.agrees() { "" } else { "*" };
    match figure.expected {
        Some(expected) => format!("{found}{mark} ({expected:.3})"),
        None => found,
    }
}

fn foreseen(prediction: Option<&Prediction>) -> String {
    match prediction {
        None => "-".to_owned(),
        Some(p) if p.residual > MOST_RESIDUAL => format!("none ({:.2})", p.residual),
        Some(p) => format!("{:.3}: {:.3}", p.frequency, p.depth / INCH),
    }
}
