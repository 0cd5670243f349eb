//! Comparison of designs of a circuit of on/off valves: coding, number of valves and control law, each over one load cycle.
//!
//! All designs have the file's total flow per edge; the coding divides the flow among the valves. The results:
//!
//! Each result is a mean over several random draws of the valves' scatter; for the peak pressure it is the maximum. A design whose ram hit a
//! stop is marked. A design does not follow if its tracking error exceeds the largest of: half of the reference's standard deviation, the
//! dead zone, 1 % of the stroke. A design that hits a stop or does not follow is never Pareto-optimal.
//!
//! - energy: energy from the supply over the load cycle (pressure times volume), plus the energy of the solenoids, J;
//! - **tracking**: root mean square of reference minus position, m;
//! - **peak pressure**: the highest chamber pressure, gauge, Pa;
//! - **switchings**: number of valve switchings per hour, opening and closing counted separately;
//! - **life**: time until the valve that switches most reaches its rated life, h.

use std::fmt::Write as _;
use std::sync::Arc;

use crate::pages::{document, figures};
use crate::plot::{Plot, Style};
use maud::{Markup, html};
use planesman_circuit::coding::Coding;
use planesman_circuit::{ATMOSPHERE, Circuit, Edge, Figures, Law, Ledger, LoadCycle, run};
use planesman_console::Table;
use planesman_linear::digits::significant;
use planesman_parameters::Choice as _;
use planesman_text::number;

/// Largest integration error per step, relative to each quantity's scale.
const ACCURACY: f64 = 1e-6;
/// Maximum number of points of a time plot.
const POINTS: usize = 1500;

/// A design of the circuit.
#[derive(Clone, Debug, PartialEq)]
pub struct Design {
    /// Coding and number of valves per edge; `None` for the file's own valves.
    pub coding: Option<(Coding, usize)>,
    /// Control law.
    pub law: Law,
    /// The circuit.
    pub circuit: Arc<Circuit>,
}

impl Design {
    /// Name, such as `pcm 5, model`.
    #[must_use]
    pub fn name(&self) -> String {
        match self.coding {
            Some((coding, count)) => format!("{} {count}, {}", coding.name(), self.law.name()),
            None => format!("valves as in the file, {}", self.law.name()),
        }
    }
}

/// The file's own circuit and every combination of the codings, numbers of valves and laws.
#[must_use]
pub fn designs(file: &Circuit, codings: &[Coding], counts: &[usize], laws: &[Law]) -> Vec<Design> {
    let own = Design {
        coding: None,
        law: file.control.law,
        circuit: Arc::new(file.clone()),
    };
    let mut designs = vec![own];
    for coding in codings {
        for count in counts {
            for law in laws {
                let mut circuit = file.clone();
                circuit.control.law = *law;
                for Edge { valves, .. } in &mut circuit.edges {
                    if !valves.is_empty() {
                        *valves = coding.share(valves.iter().sum(), *count);
                    }
                }
                // The file's own valves need not stand there twice.
                if !is_same(&circuit, file) {
                    designs.push(Design {
                        coding: Some((*coding, *count)),
                        law: *law,
                        circuit: Arc::new(circuit),
                    });
                }
            }
        }
    }
    designs
}

/// Whether two circuits are equal except for rounding; only valves and law may differ.
fn is_same(one: &Circuit, other: &Circuit) -> bool {
    let valves = |circuit: &Circuit| -> Vec<f64> {
        circuit
            .edges
            .iter()
            .flat_map(|edge| edge.valves.clone())
            .collect()
    };
    let (one_valves, other_valves) = (valves(one), valves(other));
    let near = |(one, other): (&f64, &f64)| (one - other).abs() <= 1e-12 * other;
    one.control.law == other.control.law
        && one_valves.len() == other_valves.len()
        && one_valves.iter().zip(&other_valves).all(near)
}

/// Results of a design over several random draws of the valves' scatter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evaluation {
    /// Means of energy, tracking, switchings, life and the ledger; worst values of the others.
    pub mean: Figures,
    /// Largest tracking error of all draws, m.
    pub worst_tracking: f64,
}

/// Results of a design on a load cycle with the seeds 1 to `seeds` of the valves' scatter; without scatter one seed is enough.
#[must_use]
pub fn evaluate(design: &Design, cycle: &LoadCycle, seeds: u64) -> Evaluation {
    let seeds = if design.circuit.valves.scatter > 0.0 {
        seeds.max(1)
    } else {
        1
    };
    let mut all = run(&design.circuit, cycle, ACCURACY, 1, |_, _| ());
    let mut worst_tracking = all.tracking;
    for seed in 2..=seeds {
        let one = run(&design.circuit, cycle, ACCURACY, seed, |_, _| ());
        worst_tracking = worst_tracking.max(one.tracking);
        all.energy += one.energy;
        all.tracking += one.tracking;
        all.switchings += one.switchings;
        all.life += one.life;
        all.ledger = all.ledger.plus(&one.ledger);
        all.met_stop |= one.met_stop;
        all.largest_error = all.largest_error.max(one.largest_error);
        all.peak_pressure = all.peak_pressure.max(one.peak_pressure);
        all.lowest_pressure = all.lowest_pressure.min(one.lowest_pressure);
        all.line_pressures = wider(all.line_pressures, one.line_pressures);
    }
    let share = 1.0 / seeds as f64;
    all.ledger = all.ledger.times(share);
    for figure in [
        &mut all.energy,
        &mut all.tracking,
        &mut all.switchings,
        &mut all.life,
    ] {
        *figure *= share;
    }
    Evaluation {
        mean: all,
        worst_tracking,
    }
}

/// The union of two pressure ranges (highest, lowest).
fn wider(one: Option<(f64, f64)>, other: Option<(f64, f64)>) -> Option<(f64, f64)> {
    let both = one
        .zip(other)
        .map(|(one, other)| (one.0.max(other.0), one.1.min(other.1)));
    both.or(one).or(other)
}

/// Designs with their results.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The designs, the file's own first.
    pub designs: Vec<(Design, Evaluation)>,
    /// Whether each design is Pareto-optimal: it follows the load cycle without hitting a stop, and no other such design is at least as good in every
    /// result and better in one.
    pub front: Vec<bool>,
    /// Energy that an ideal proportional valve would need for the reference's motion, J.
    pub proportional: f64,
    /// Tracking error above which a design does not follow, m.
    pub loose: f64,
}

impl Outcome {
    /// Compares the designs (the file's own first) by their results on the load cycle, and finds those that no other design beats.
    #[must_use]
    pub fn new(designs: Vec<(Design, Evaluation)>, cycle: &LoadCycle) -> Self {
        let circuit = &designs[0].0.circuit;
        let proportional = cycle.proportional(circuit);
        let loose = (0.5 * cycle.deviation())
            .max(circuit.control.dead_zone)
            .max(0.02 * circuit.load.travel);
        let of = |figures: &Figures| {
            [
                figures.energy,
                figures.tracking,
                figures.peak_pressure,
                figures.switchings,
                -figures.life,
            ]
        };
        let beats = |one: &[f64; 5], other: &[f64; 5]| {
            one.iter().zip(other).all(|(one, other)| one <= other) && one != other
        };
        // As printed: what differs by less is the same.
        let rounded =
            |figures: [f64; 5]| figures.map(|it| format!("{it:.3e}").parse().unwrap_or(it));
        let all: Vec<Option<[f64; 5]>> = designs
            .iter()
            .map(|(_, it)| {
                let holds = !it.mean.met_stop && it.mean.tracking <= loose;
                holds.then(|| rounded(of(&it.mean)))
            })
            .collect();
        let beaten = |one: &[f64; 5]| all.iter().flatten().any(|other| beats(other, one));
        let front = all
            .iter()
            .map(|one| one.is_some_and(|one| !beaten(&one)))
            .collect();
        Self {
            designs,
            front,
            proportional,
            loose,
        }
    }

    /// The table of all designs, or of those not beaten, sorted by tracking.
    #[must_use]
    pub fn table(&self, all: bool) -> Table {
        let mut table = Table::new([
            "design",
            "energy, J",
            "tracking, mm",
            "worst, mm",
            "peak, MPa",
            "switchings/h",
            "life, h",
            "of proportional, %",
            "not beaten",
        ]);
        let none = !self.front.contains(&true);
        let mut order: Vec<usize> = (0..self.designs.len())
            .filter(|place| all || none || self.front[*place])
            .collect();
        let tracking = |place: &usize| self.designs[*place].1.mean.tracking;
        order.sort_by(|one, other| tracking(one).total_cmp(&tracking(other)));
        // Nothing is no negative nothing.
        let whole = |figure: f64| match figure.is_finite() {
            true => format!("{:.0}", figure.round() + 0.0),
            false => "-".to_owned(),
        };
        for place in order {
            let (design, it) = &self.designs[place];
            let figures = &it.mean;
            table.row([
                design.name(),
                whole(figures.energy),
                format!("{:.2}", figures.tracking * 1e3),
                format!("{:.2}", it.worst_tracking * 1e3),
                format!("{:.2}", figures.peak_pressure / 1e6),
                whole(figures.switchings),
                whole(figures.life),
                whole(100.0 * figures.energy / self.proportional),
                if figures.met_stop {
                    "met a stop"
                } else if figures.tracking > self.loose {
                    "does not follow"
                } else if self.front[place] {
                    "yes"
                } else {
                    ""
                }
                .to_owned(),
            ]);
        }
        table
    }

    /// A sentence about the best compromise, or that no design follows the load cycle.
    #[must_use]
    pub fn winner(&self) -> String {
        let of = self.designs.len();
        if !self.front.contains(&true) {
            return format!("None of the {of} designs follows the load cycle.");
        }
        let (design, it) = &self.designs[self.middle()];
        let figures = &it.mean;
        format!(
            "Best compromise of {of} designs between tracking and energy: {}, tracking {} mm, energy {} J ({:.0} % of an ideal proportional valve's), peak pressure {} MPa, {:.0} switchings/h.",
            design.name(),
            significant(1e3 * figures.tracking, 3),
            significant(figures.energy, 3),
            100.0 * figures.energy / self.proportional,
            significant(figures.peak_pressure / 1e6, 3),
            figures.switchings
        )
    }

    /// The text above the table.
    #[must_use]
    pub fn head(&self, cycle_name: &str, cycle: &LoadCycle) -> String {
        let (design, _) = &self.designs[0];
        let circuit = &design.circuit;
        let count = self.front.iter().filter(|front| **front).count();
        let mut text = format!("{}\n{}\n", circuit.name, circuit.source);
        // Writing to a String does not fail.
        let _ = writeln!(
            text,
            "Load cycle {cycle_name}, {} s; {} designs, {count} of them Pareto-optimal (no other design is better in energy, tracking, peak pressure, switchings and life together).",
            number(cycle.duration()),
            self.designs.len()
        );
        let lines = self.designs.iter().map(|(_, it)| it.mean.line_pressures);
        if let Some((highest, lowest)) = lines.fold(None, wider) {
            let _ = writeln!(
                text,
                "At the valves' end of the lines the oil pressure ranges from {:.2} to {:.2} MPa over all designs{}.",
                lowest / 1e6,
                highest / 1e6,
                if lowest < -ATMOSPHERE {
                    "; below -0.1 MPa the oil would boil, but the model does not include boiling"
                } else {
                    ""
                }
            );
        }
        text
    }

    /// Index of the design nearest to the best values of tracking and energy, each relative to its range over the Pareto-optimal designs.
    #[must_use]
    pub fn middle(&self) -> usize {
        let front = || {
            self.designs
                .iter()
                .enumerate()
                .filter(|(place, _)| self.front[*place])
        };
        let share = |of: fn(&Figures) -> f64| {
            let values = front().map(|(_, (_, it))| of(&it.mean));
            let (low, high) = values.fold((f64::MAX, f64::MIN), |(low, high), it| {
                (low.min(it), high.max(it))
            });
            move |figures: &Figures| {
                if high > low {
                    (of(figures) - low) / (high - low)
                } else {
                    0.0
                }
            }
        };
        let (tracking, energy) = (share(|f| f.tracking), share(|f| f.energy));
        let distance = |figures: &Figures| tracking(figures) + energy(figures);
        let nearest = front()
            .min_by(|one, other| distance(&one.1.1.mean).total_cmp(&distance(&other.1.1.mean)));
        nearest.map_or(0, |(place, _)| place)
    }

    /// The page.
    #[must_use]
    pub fn page(&self, cycle_name: &str, cycle: &LoadCycle) -> String {
        let title = "Designs of a circuit of on/off valves";
        let middle = self.middle();
        let (design, of_design) = &self.designs[middle];
        let body = html! {
            h1 { (title) }
            @for line in self.head(cycle_name, cycle).lines() { p { (line) } }
            h2 { "Designs" }
            (figures(&self.plots()))
            div.scroll { (self.table(false).html()) }
            h2 { "All designs" }
            div.scroll { (self.table(true).html()) }
            h2 { "Time histories of " (design.name()) }
            p { "The best compromise between tracking and energy, with the first seed of the valves' scatter." }
            (figures(&traces(design, cycle)))
            h2 { "Where its energy goes (mean over the seeds)" }
            (ledger(&design.circuit, &of_design.mean.ledger))
        };
        document(title, "", &body, "")
    }

    fn plots(&self) -> [Plot<'static>; 3] {
        type Of = fn(&Figures) -> f64;
        type Axis = (&'static str, Of);
        let energy: Axis = ("energy, J", |f| f.energy);
        let tracking: Axis = ("tracking, mm", |f| f.tracking * 1e3);
        let peak: Axis = ("peak pressure, MPa", |f| f.peak_pressure / 1e6);
        let switchings: Axis = ("switchings an hour", |f| f.switchings);
        let one = |title: &'static str, x: Axis, y: Axis| {
            let points = |law: Law| {
                let of = self
                    .designs
                    .iter()
                    .filter(move |(design, _)| design.law == law);
                of.map(move |(_, it)| ((x.1)(&it.mean), (y.1)(&it.mean)))
            };
            let front = self
                .designs
                .iter()
                .zip(&self.front)
                .filter(|(_, front)| **front);
            let front = front.map(|((_, it), _)| ((x.1)(&it.mean), (y.1)(&it.mean)));
            let mut plot =
                Plot::new(title, [x.0, y.0])
                    .plane()
                    .with(Style::Crosses, "not beaten", front);
            for law in Law::NAMES.iter().filter_map(|name| Law::named(name)) {
                if points(law).next().is_some() {
                    plot = plot.with(Style::Dots, law.name(), points(law));
                }
            }
            plot
        };
        [
            one("Energy and tracking", tracking, energy),
            one("Peak pressure and tracking", tracking, peak),
            one("Switchings and tracking", tracking, switchings),
        ]
    }
}

/// Position and pressures of a design over the load cycle.
fn traces(design: &Design, cycle: &LoadCycle) -> [Plot<'static>; 3] {
    let mut rows: Vec<(f64, [f64; 4])> = Vec::new();
    let _ = run(&design.circuit, cycle, ACCURACY, 1, |time, row| {
        rows.push((time, row))
    });
    let every = rows.len().div_ceil(POINTS).max(1);
    let drawn = || rows.iter().step_by(every);
    let reference = drawn().map(|(time, _)| (*time, cycle.at(*time).0.position * 1e3));
    let of = |place: usize, scale: f64| drawn().map(move |(time, row)| (*time, row[place] * scale));
    let error = drawn().map(|(time, row)| (*time, (cycle.at(*time).0.position - row[0]) * 1e3));
    let mut pressures = Plot::new("Pressures", ["t, s", "p, MPa"]).line("A", of(2, 1e-6));
    if design.circuit.chambers[1].area > 0.0 {
        pressures = pressures.line("B", of(3, 1e-6));
    }
    [
        Plot::new("Position", ["t, s", "x, mm"])
            .line("reference", reference)
            .line("ram", of(0, 1e3)),
        Plot::new("Error of position", ["t, s", "e, mm"]).line("reference less ram", error),
        pressures,
    ]
}

/// The ledger as a table.
#[must_use]
pub fn ledger_table(circuit: &Circuit, ledger: &Ledger) -> Table {
    let mut table = Table::new(["work", "J", "% of the supply"]);
    let mut row = |name: String, work: f64| {
        table.row([
            name,
            number(work),
            match ledger.supply {
                0.0 => "-".to_owned(),
                supply => format!("{:.2}", 100.0 * work / supply + 0.0),
            },
        ]);
    };
    row("supply".to_owned(), ledger.supply);
    for (level, work) in circuit.levels.iter().zip(ledger.levels) {
        row(format!("  of level {}", level.name), work);
    }
    for (place, lost) in ledger
        .throttling
        .iter()
        .enumerate()
        .take(circuit.edges.len())
    {
        row(format!("throttling {}", circuit.edge_name(place)), *lost);
    }
    row("leakage past the piston".to_owned(), ledger.seal);
    row("compression of the oil, net".to_owned(), ledger.compression);
    row(
        "  stored (the rest was given back)".to_owned(),
        ledger.compressed,
    );
    row("viscous friction".to_owned(), ledger.viscous);
    row("Coulomb friction".to_owned(), ledger.friction);
    row("load".to_owned(), ledger.load);
    row("kinetic, springs, weight".to_owned(), ledger.mechanical);
    row("stops".to_owned(), ledger.stops);
    if circuit.levels.iter().any(|level| level.line.is_some()) {
        row("stored in the lines".to_owned(), ledger.lines);
        row("friction in the lines".to_owned(), ledger.line_friction);
    }
    row("error of the energy balance".to_owned(), ledger.residual());
    row(
        "switching (electrical, in addition)".to_owned(),
        ledger.switching,
    );
    table
}

fn ledger(circuit: &Circuit, ledger: &Ledger) -> Markup {
    html! { div.scroll { (ledger_table(circuit, ledger).html()) } }
}
