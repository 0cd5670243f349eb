//! Limit cycles of the depth loop with the digital hydraulic actuator in one table: simulated, the orbit found by shooting, and
//! the cycle foreseen by harmonic balance.

use std::ops::Range;

use maud::html;
use planesman_console::{Format, Table, wrapped};
use planesman_linear::digits::significant;
use planesman_show::design::{Describing, MOST_RESIDUAL, Prediction};
use planesman_show::pages::{document, figures};
use planesman_show::plot::{Plot, Style};
use planesman_units::{DEGREE, INCH};

use crate::studies::depth_loop::{Case, Dive, DiveError, Figure, LimitCycle, STARTS};
use crate::studies::orbit::{Growth, Orbit};
use crate::studies::watched::{Irregular, Motion};

/// Beyond so many standard errors a growth is not 0.
const CERTAIN: f64 = 3.0;
/// The most points of a curve on the page.
const POINTS: usize = 400;
/// Depth error, in, and plane angle, deg.
type Curve = Vec<(f64, f64)>;

/// The page: the table, each orbit, and predicted beside simulated.
#[must_use]
pub fn page(rows: &[Row]) -> String {
    let cells = Cells::of(rows);
    let [compared, found, irregular] = cells.tables();
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
            li { (rows.len()) " configurations. " (cells.verdict()) }
            li { (tally(rows)) }
        }
        (figures(&shown))
        (found.html())
        p { (LEGEND) }
        @if !irregular.is_empty() {
            h2 { "Irregular motions" }
            (irregular.html())
            p { (IRREGULAR) }
        }
        h2 { "Simulated" }
        (compared.html())
        h2 { "Orbits" }
        p { "One period of each orbit over the simulated motion (pale). Its decisions fall on the samples of controller and valves, up to one of them late, so it does not repeat exactly." }
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
    /// What it is from the other places of the ram, [`STARTS`].
    pub elsewhere: Vec<Motion>,
    /// Predicted, if asked for.
    pub prediction: Option<Prediction>,
    /// Whether the depth swings less later on, where it follows an orbit.
    settling: bool,
    /// Of the loop, from 500 to 1000 s: turns a second; depth, m, and planes, rad, in a period of its orbit on average.
    followed: Option<[f64; 3]>,
    simulated: Curve,
}

impl Row {
    /// Simulates configurations of one actuator and finds their orbits, and predicts their cycles if that is asked for.
    ///
    /// # Errors
    /// Those of the actuator's file and of [`Loop::dive`](crate::studies::depth_loop::Loop::dive).
    pub fn of(cases: &[Case], predicted: bool) -> Result<Vec<Self>, DiveError> {
        let known = Describing::default();
        let row = |case: &Case| {
            let mut all = case.motions(&STARTS)?;
            let (dive, motion) = all.remove(0);
            let followed = match &motion {
                Motion::Orbit(orbit) => {
                    let watched = &dive.watched;
                    let turns = orbit.turns() / (1.0 + watched.apart(orbit).0);
                    let (swing, stroke) =
                        (watched.swing(orbit.period), watched.stroke(orbit.period));
                    Some([turns, swing, stroke])
                }
                _ => None,
            };
            Ok(Self {
                case: case.clone(),
                cycle: dive.cycle,
                elsewhere: all.into_iter().map(|(_, motion)| motion).collect(),
                prediction: predicted.then(|| case.predict(&known)).transpose()?,
                settling: followed.is_some() && dive.settles(),
                followed,
                simulated: simulated(&dive, &motion),
                motion,
            })
        };
        cases.iter().map(row).collect()
    }

    /// How many starts come to the motion from the middle.
    fn alike(&self) -> usize {
        1 + self
            .elsewhere
            .iter()
            .filter(|it| self.motion.alike(it))
            .count()
    }

    /// That, and what the others come to.
    fn starts(&self) -> String {
        let mut others: Vec<(&Motion, usize)> = Vec::new();
        for motion in self.elsewhere.iter().filter(|it| !self.motion.alike(it)) {
            match others.iter_mut().find(|(other, _)| other.alike(motion)) {
                Some((_, count)) => *count += 1,
                None => others.push((motion, 1)),
            }
        }
        let mut text = format!("{} of {}", self.alike(), 1 + self.elsewhere.len());
        for (motion, count) in others {
            let what = match motion {
                Motion::Orbit(orbit) => format!("orbit {:.4} Hz", orbit.turns()),
                Motion::Rest => "rest".to_owned(),
                Motion::Repeats(_) => "repeats".to_owned(),
                Motion::Irregular(_) => "irregular".to_owned(),
            };
            text += &format!("; {count}: {what}");
        }
        text
    }

    /// The cells of the irregular motions, of all starts that come to one.
    fn irregular(&self) -> [String; 6] {
        let all = std::iter::once(&self.motion).chain(&self.elsewhere);
        let of = |motion: &Motion| match motion {
            Motion::Irregular(irregular) => Some(irregular.clone()),
            _ => None,
        };
        let found: Vec<Irregular> = all.filter_map(of).collect();
        let starts = format!("{} of {}", found.len(), 1 + self.elsewhere.len());
        let Some(all) = found.into_iter().reduce(|all, it| all.and(&it)) else {
            return std::array::from_fn(|_| "-".to_owned());
        };
        [
            starts,
            all.windows.to_string(),
            between(all.swing, INCH),
            between(all.rate, 1.0),
            grows(&all).unwrap_or_else(|| "-".to_owned()),
            all.orbit.as_ref().map_or_else(
                || "-".to_owned(),
                |orbit| format!("{:.2} s, {}", orbit.period, multipliers(orbit)),
            ),
        ]
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
const LEGEND: &str = "Depth, mean error, planes, volumes and t95 (until the depth first comes within 5 % of the step): from 250 to 500 s, the ram in the middle at first; in brackets by an independent simulation. \
     Motion: an orbit found by shooting, which the loop follows, with its largest multiplier (below 1 a deviation decays); \
     rest; the same decisions again and again (repeats); or irregular. Starts: how many dives, from the middle and from -3/8 and 1/4 quantum, come to this motion, and what the others come to. \
     Orbit: in brackets this program's simulation from 500 to 1000 s, of a whole period, on average. First harmonic: its share in the variance of the angle asked of the actuator, which harmonic balance \
     takes for all of it. Predicted where 1 + N H comes within 0.1 of 0; otherwise harmonic balance foresees no cycle, and the brackets have the least |1 + N H|.";

/// What the columns of irregular motions mean.
const IRREGULAR: &str = "Irregular motions: the least and the largest among so many windows of 50 s, of all starts that come to one; no bounds. Growth: how fast small deviations grow (the largest Lyapunov exponent, decisions \
     moving with their thresholds), with the standard error over the windows. Where it is above 0 by more than three of them the motion is chaotic. Where it is below by as many, deviations decay: an orbit would attract, but decisions fall on samples, \
     which keep the loop from it. Nearest orbit: the one of the nearest frequency that was found, its period and its largest multiplier.";

/// The columns of the table: the simulation beside the independent one, ...
const SIMULATED: usize = 7;
/// ... what the motion is, ...
const FOUND: usize = 15;
/// ... and where it is irregular.
const COLUMNS: [&str; 21] = [
    "configuration",
    "M_theta",
    "depth pp, in",
    "mean error, in",
    "planes pp, deg",
    "volumes/s",
    "t95, s",
    "motion",
    "multiplier",
    "starts",
    "orbit f, Hz",
    "orbit depth pp, in",
    "orbit planes pp, deg",
    "first harmonic",
    "predicted f, Hz: depth pp, in",
    "irregular starts",
    "windows",
    "depth pp in 50 s, in",
    "decisions/s",
    "growth, 1/s",
    "nearest orbit",
];

/// How many of the motions are which.
fn tally(rows: &[Row]) -> String {
    let count = |is: fn(&Motion) -> bool| rows.iter().filter(|row| is(&row.motion)).count();
    let several = rows.iter().filter(|row| row.alike() < STARTS.len());
    format!(
        "From the middle: {} orbits, {} exact repetitions, {} at rest, {} irregular. In {} configurations other starts come to another motion.",
        count(|m| matches!(m, Motion::Orbit(_))),
        count(|m| matches!(m, Motion::Repeats(_))),
        count(|m| matches!(m, Motion::Rest)),
        count(|m| matches!(m, Motion::Irregular(_))),
        several.count(),
    )
}

/// The table, a deviation marked with an asterisk; for people in three, also what the marks mean.
#[must_use]
pub fn text(rows: &[Row], format: Format) -> String {
    let cells = Cells::of(rows);
    if !matches!(format, Format::Table | Format::Md) {
        return cells.table(0..COLUMNS.len(), |_| true).text(format);
    }
    let [simulated, found, irregular] = cells.tables();
    let mut text = simulated.text(format);
    text += &wrapped(&format!("\n{}\n\n", cells.verdict()));
    text += &found.text(format);
    text += &wrapped(&format!("\n{}\n{LEGEND}\n", tally(rows)));
    if !irregular.is_empty() {
        text += &format!("\n{}", irregular.text(format));
        text += &wrapped(&format!("\n{IRREGULAR}\n"));
    }
    text
}

/// The cells of all columns.
struct Cells {
    rows: Vec<Vec<String>>,
    /// How many figures are compared, how many of them deviate, and in how many rows the depth has not settled.
    compared: usize,
    deviating: usize,
    settling: usize,
}

impl Cells {
    fn of(rows: &[Row]) -> Self {
        let mut all = Self {
            rows: Vec::new(),
            compared: 0,
            deviating: 0,
            settling: 0,
        };
        for row in rows {
            let expected = row.case.expected.unwrap_or_default();
            let mut cells = vec![row.case.name.clone(), row.case.restoring.to_string()];
            for (i, figure) in row.cycle.figures(&expected).iter().enumerate() {
                all.compared += usize::from(figure.expected.is_some());
                all.deviating += usize::from(!figure.agrees());
                let settling = i == 0 && row.settling;
                all.settling += usize::from(settling);
                cells.push(cell(figure, if settling { "~" } else { "" }));
            }
            let orbit =
                |of: &dyn Fn(&Orbit) -> String| row.orbit().map_or_else(|| "-".to_owned(), of);
            cells.push(match &row.motion {
                Motion::Orbit(_) => "orbit".to_owned(),
                Motion::Irregular(_) => "irregular".to_owned(),
                other => described(other, INCHES),
            });
            cells.push(orbit(&|orbit| format!("{:.3}", orbit.growth())));
            cells.push(row.starts());
            cells.extend(beside(row));
            cells.push(orbit(&|orbit| {
                format!("{:.0} %", 100.0 * orbit.first_harmonic())
            }));
            cells.push(foreseen(row.prediction.as_ref()));
            cells.extend(row.irregular());
            all.rows.push(cells);
        }
        all
    }

    fn table(&self, columns: Range<usize>, shown: impl Fn(&[String]) -> bool) -> Table {
        let named = |i: &usize| *i < 2 || columns.contains(i);
        let which: Vec<usize> = (0..COLUMNS.len()).filter(named).collect();
        let mut table = Table::of(which.iter().map(|i| COLUMNS[*i]));
        for row in self.rows.iter().filter(|row| shown(row)) {
            table.row(which.iter().map(|i| row[*i].clone()));
        }
        table
    }

    /// Simulated, found, irregular.
    fn tables(&self) -> [Table; 3] {
        [
            self.table(0..SIMULATED, |_| true),
            self.table(SIMULATED..FOUND, |_| true),
            self.table(FOUND..COLUMNS.len(), |row| row[FOUND] != "-"),
        ]
    }

    fn verdict(&self) -> String {
        let settling = match self.settling {
            0 => String::new(),
            some => format!(
                " In {some} the depth still settles (~): from 500 to 1000 s it swings by more than 15 % less."
            ),
        };
        format!(
            "Found (expected by an independent simulation); {} of {} figures deviate by more than 15 % (*).{settling}",
            self.deviating, self.compared
        )
    }
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
            let Irregular { swing, rate, .. } = irregular;
            let near = irregular.orbit.as_ref().map_or_else(String::new, |orbit| {
                format!("; nearest orbit {}", multipliers(orbit))
            });
            format!(
                "irregular: {} {name}, {} /s{near}",
                between(*swing, unit),
                between(*rate, 1.0)
            )
        }
    }
}

/// From the least to the largest, to two digits.
fn between((low, high): (f64, f64), unit: f64) -> String {
    let two = |value: f64| significant(value / unit, 2);
    format!("{} to {}", two(low), two(high))
}

/// The growth of deviations with its standard error, and what that says.
fn grows(irregular: &Irregular) -> Option<String> {
    let growth = Growth::of(&irregular.growth)?;
    let says = match growth.rate / (CERTAIN * growth.error) {
        above if above > 1.0 => "chaotic",
        below if below < -1.0 => "deviations decay",
        _ => "undecided",
    };
    Some(format!(
        "{:+.3} ± {:.3} ({says})",
        growth.rate, growth.error
    ))
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

fn cell(figure: &Figure, settling: &str) -> String {
    let number = |value: f64| format!("{value:.3}");
    let found = figure.found.map_or_else(|| "never".to_owned(), number);
    let mark = if figure.agrees() { settling } else { "*" };
    match figure.expected {
        Some(expected) => format!("{found}{mark} ({expected:.3})"),
        None => format!("{found}{settling}"),
    }
}

fn foreseen(prediction: Option<&Prediction>) -> String {
    match prediction {
        None => "-".to_owned(),
        Some(p) if p.residual > MOST_RESIDUAL => format!("none ({:.2})", p.residual),
        Some(p) => format!("{:.3}: {:.3}", p.frequency, p.depth / INCH),
    }
}
