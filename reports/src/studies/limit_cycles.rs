//! Table of limit cycles of the depth loop with the digital hydraulic actuator: simulated, orbits found by shooting, and predicted by harmonic
//! balance.

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

/// Number of standard errors beyond which a growth rate differs from 0.
const CERTAIN: f64 = 3.0;
/// Maximum number of points of a plotted curve.
const POINTS: usize = 400;
/// Depth error, in, and plane angle, deg.
type Curve = Vec<(f64, f64)>;

/// HTML page: the table, each orbit, and predicted against simulated frequencies.
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
        p { "One period of each orbit, drawn over the simulated motion (pale). The simulated motion does not repeat exactly, because its decisions are delayed to the next sample of controller and valves." }
        (figures(&orbits))
    };
    document(title, "", &body, "")
}

/// A configuration with its results.
#[derive(Clone, Debug)]
pub struct Row {
    /// The configuration.
    pub case: Case,
    /// Simulated limit cycle.
    pub cycle: LimitCycle,
    /// Kind of the simulated motion.
    pub motion: Motion,
    /// Kinds of motion from the other initial ram positions, [`STARTS`].
    pub elsewhere: Vec<Motion>,
    /// Predicted limit cycle, if requested.
    pub prediction: Option<Prediction>,
    /// Whether the depth amplitude decreases later, for a loop that follows an orbit.
    settling: bool,
    /// Loop from 500 to 1000 s: cycles per second; mean amplitude of depth, m, and planes, rad, per period of its orbit.
    followed: Option<[f64; 3]>,
    simulated: Curve,
}

impl Row {
    /// Simulates configurations of one actuator, finds their orbits, and predicts their limit cycles if requested.
    ///
    /// # Errors
    /// Errors of the actuator file and of [`Loop::dive`](crate::studies::depth_loop::Loop::dive).
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

    /// Number of initial positions that lead to the same motion as the middle.
    fn alike(&self) -> usize {
        1 + self
            .elsewhere
            .iter()
            .filter(|it| self.motion.alike(it))
            .count()
    }

    /// That number, and the motions from the other starts.
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

    /// Cells for irregular motions, over all starts that lead to one.
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

    /// The orbit that the loop follows.
    fn orbit(&self) -> Option<&Orbit> {
        match &self.motion {
            Motion::Orbit(orbit) => Some(orbit),
            _ => None,
        }
    }

    /// Cycles per second.
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

/// The last three periods of the simulated motion.
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

/// Explanation of the columns.
const LEGEND: &str = "Depth, mean error, planes, volumes and t95 (time until the depth is first within 5 % of the step) are from 250 to 500 s, with the ram initially in the middle; the brackets contain the results of an independent simulation. \
     Motion is one of: an orbit found by shooting that the loop follows, with its largest multiplier (below 1, deviations decay); rest; an exact repetition of decisions (repeats); or irregular. Starts: the number of dives, with the ram at 0, -3/8 and 1/4 quantum, that end in this motion, and the motions of the others. \
     Orbit: values of the orbit found by shooting; in brackets the means over whole periods of this program's simulation from 500 to 1000 s. First harmonic: its share in the variance of the actuator's command; harmonic balance \
     assumes 100 %. Predicted: shown only if |1 + N H| is below 0.1; otherwise harmonic balance predicts no limit cycle, and the brackets contain the smallest |1 + N H|. pp: peak to peak.";

/// Explanation of the columns for irregular motions.
const IRREGULAR: &str = "Irregular motions: the smallest and largest values in windows of 50 s (the number of windows is given), over all starts with such a motion; these are not bounds. Growth: growth rate of small deviations (largest Lyapunov exponent, which includes \
     the effect of deviations on the times of decisions), with its standard error over the windows. The motion is chaotic if the rate is above 0 by more than three standard errors. If it is below 0 by as many, deviations decay towards an orbit, but decisions happen only at samples, \
     which keeps the loop away from the orbit. Nearest orbit: the orbit found with the nearest frequency, its period and its largest multiplier.";

/// Number of columns for the comparison with the independent simulation.
const SIMULATED: usize = 7;
/// Number of columns up to and including the kind of motion.
const FOUND: usize = 15;
/// Column headers; the last columns are for irregular motions.
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

/// Number of motions of each kind.
fn tally(rows: &[Row]) -> String {
    let count = |is: fn(&Motion) -> bool| rows.iter().filter(|row| is(&row.motion)).count();
    let several = rows.iter().filter(|row| row.alike() < STARTS.len());
    format!(
        "Motions with the ram initially in the middle: {} orbits, {} exact repetitions, {} at rest, {} irregular. In {} configurations the motion depends on the start.",
        count(|m| matches!(m, Motion::Orbit(_))),
        count(|m| matches!(m, Motion::Repeats(_))),
        count(|m| matches!(m, Motion::Rest)),
        count(|m| matches!(m, Motion::Irregular(_))),
        several.count(),
    )
}

/// The table, with deviations marked by an asterisk; for readers in three parts with explanations.
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

/// Cells of all columns.
struct Cells {
    rows: Vec<Vec<String>>,
    /// Number of compared results, number of deviations, and number of rows in which the depth has not settled.
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

    /// Tables of the simulation, of the orbits, and of irregular motions.
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
                " In {some} the depth is still settling (~): from 500 to 1000 s its amplitude is smaller by more than 15 %."
            ),
        };
        format!(
            "Found (expected by an independent simulation); {} of {} figures deviate by more than 15 % (*).{settling}",
            self.deviating, self.compared
        )
    }
}

/// Unit of depth in the tables.
pub(crate) const INCHES: (f64, &str) = (INCH, "in");

/// A motion in a few words, with its amplitudes in a unit.
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

/// A range with two digits.
fn between((low, high): (f64, f64), unit: f64) -> String {
    let two = |value: f64| significant(value / unit, 2);
    format!("{} to {}", two(low), two(high))
}

/// Growth rate of deviations with its standard error, and the conclusion.
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

/// Frequency, depth and planes of the orbit, each with the simulated value.
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
