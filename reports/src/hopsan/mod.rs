//! Recorded validations of the Hopsan simulator for its on/off valves and its cylinder, recomputed with [`planesman_circuit`].
//!
//! For each component, Hopsan (Linköping University) keeps a test model with its expected results: `Models/Component Test Validations` in its
//! repository. Hopsan's components are connected by transmission lines of one time step, 1 ms; so its cylinder starts one or two steps late, and a
//! volume next to the cylinder adds some inertia.
//!
//! Hopsan's valves are orifices, `Q = C_q A sqrt(2 dp/rho)`, whose spool follows a critically damped second-order lag with `w` = 100 rad/s. Here a
//! valve opens or closes after a delay; a delay of `2/w` gives the same volume.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::book::{Book, BookError, Chapter, Names, Recomputed, Report, ReportError};
use planesman_circuit::{
    Chamber, Circuit, Control, Edge, Law, Level, Load, MOST_EDGES, Oil, Simulation, Valves,
};
use planesman_show::plot::{Plot, Style};

/// Description of the report.
pub const REPORT: Report = Report {
    name: "Hopsan",
    citation: "Hopsan, Linköping University, github.com/Hopsan/hopsan, Models/Component Test Validations, 2014 to 2016.",
    book,
    names: || Names::parse(include_str!("../../data/hopsan/names.json")),
    recomputed,
    procedure: None,
    figures,
};

/// One bar, Pa.
const BAR: f64 = 1e5;
/// All three valves: C_q, density kg/m^3, spool diameter m times stroke m, lag rad/s.
const ORIFICE: (f64, f64, f64, f64) = (0.67, 890.0, 0.01 * 0.01, 100.0);
/// Cylinder: area m^2, mass kg, force N, half stroke m, supplies Pa, bulk modulus Pa, chamber m^3.
const CYLINDER: (f64, f64, f64, f64, [f64; 2], f64, f64) =
    (1e-3, 1000.0, 100.0, 0.2, [1e7, 9e6], 1e9, 0.01);

/// The recorded numbers.
///
/// # Errors
/// [`BookError`]; a test reads the compiled-in file.
pub fn book() -> Result<Book, BookError> {
    Book::parse(include_str!("../../data/hopsan/hopsan.json"), "{}")
}

/// A circuit with only the given parts, and the pressure drop below which flow is laminar.
fn circuit(
    levels: Vec<(&str, f64)>,
    edges: Vec<Edge>,
    chambers: [Chamber; 2],
    load: Load,
    (bulk_modulus, transition): (f64, f64),
) -> Arc<Circuit> {
    let level = |(name, pressure): (&str, f64)| Level {
        name: name.to_owned(),
        pressure,
        line: None,
    };
    Arc::new(Circuit {
        name: String::new(),
        source: REPORT.citation.to_owned(),
        load,
        chambers,
        seal_leakage: 0.0,
        levels: levels.into_iter().map(level).collect(),
        oil: Oil {
            bulk_modulus,
            air: 1e-6,
            polytropic: 1.4,
            density: ORIFICE.1,
            viscosity: 0.0,
        },
        edges,
        valves: Valves {
            rated_drop: 1.0,
            opening: 0.0,
            closing: 2.0 / ORIFICE.3,
            scatter: 0.0,
            transition,
            rated_life: 1.0,
            energy: 0.0,
        },
        control: Control {
            law: Law::Nearest,
            period: 1_000_000,
            gain: 0.0,
            dead_zone: 0.0,
            switching_cost: 0.0,
            energy_cost: 0.0,
            pressure_limit: f64::INFINITY,
            force_filter: 0.0,
        },
    })
}

/// Volume through a valve between two constant pressures until `open` s, and in total, m^3. The consumer is a chamber so large that its pressure is
/// constant.
fn passed(from: f64, to: f64, open: f64) -> (f64, f64) {
    let (coefficient, density, area, _) = ORIFICE;
    let k = coefficient * PI * area * (2.0 / density).sqrt();
    let held = Load {
        mass: 1.0,
        viscous: 0.0,
        coulomb: 1e12,
        stepping: 0.0,
        spring: 0.0,
        force: 0.0,
        travel: 1.0,
        elastic_stop: None,
        moment_arm: 1.0,
    };
    let large = Chamber {
        area: 1e-6,
        volume: 1e9,
    };
    let none = Chamber {
        area: 0.0,
        volume: 1.0,
    };
    // A chamber begins at the lowest level; the valve's own level is the other end.
    let low = from.min(to);
    let levels = vec![("P", from.max(to)), ("T", low)];
    let edges = vec![Edge {
        level: 0,
        chamber: 0,
        valves: vec![k],
    }];
    let mut simulation = Simulation::new(
        circuit(levels, edges, [large, none], held, (1e9, 100.0)),
        1e-10,
        0.0,
        low * large.area,
        1,
    );
    let mut masks = [0; MOST_EDGES];
    masks[0] = 1;
    simulation.command(0.0, &masks);
    simulation.command(open, &[0; MOST_EDGES]);
    simulation.advance(open, 10.0);
    let before = simulation.ledger(open).supply / from.max(to);
    simulation.advance(open + 1.0, 10.0);
    let sign = (from - to).signum();
    (
        sign * before,
        sign * simulation.ledger(open + 1.0).supply / from.max(to),
    )
}

/// Time s, position m from the end of the stroke, speed m/s, every millisecond.
fn stroke() -> Vec<[f64; 3]> {
    let (area, mass, force, travel, [a, b], bulk_modulus, volume) = CYLINDER;
    let load = Load {
        mass,
        viscous: 0.0,
        coulomb: 0.0,
        stepping: 0.0,
        spring: 0.0,
        force,
        travel,
        elastic_stop: None,
        moment_arm: 1.0,
    };
    // Valves so wide that the chambers have their sources' pressures.
    let edge = |chamber| Edge {
        level: chamber,
        chamber,
        valves: vec![1e-4],
    };
    let chamber = Chamber { area, volume };
    let circuit = circuit(
        vec![("P", a), ("Q", b)],
        vec![edge(0), edge(1)],
        [chamber; 2],
        load,
        (bulk_modulus, 1e3),
    );
    let mut simulation = Simulation::new(circuit, 1e-8, 0.0, 0.0, 1);
    let mut masks = [0; MOST_EDGES];
    (masks[0], masks[1]) = (1, 1);
    simulation.command(0.0, &masks);
    let at = |millisecond: i32| {
        let time = f64::from(millisecond) * 1e-3;
        simulation.advance(time, 10.0);
        let [x, v, ..] = simulation.at(time);
        [time, x + travel, v]
    };
    (0..=1000).map(at).collect()
}

/// Numbers recomputed by this crate.
#[must_use]
pub fn recomputed() -> Recomputed {
    let flow = |from: f64, to: f64| passed(from, to, 0.5).0 / 0.5;
    let (before, in_all) = passed(10.0 * BAR, BAR, 0.5);
    let stroke = stroke();
    let stop = stroke
        .iter()
        .position(|[_, x, _]| *x >= 0.4 - 1e-9)
        .unwrap_or_default();
    [
        ("V22.flow", flow(10.0 * BAR, BAR)),
        ("V22.closing", in_all - before),
        ("V32.on", flow(10.0 * BAR, 5.0 * BAR)),
        ("V32.off", flow(0.0, 5.0 * BAR)),
        ("V42.PA", flow(10.0 * BAR, 5.0 * BAR)),
        ("V42.BT", flow(0.0, 5.0 * BAR)),
        ("cylinder.x_300", stroke[300][1]),
        ("cylinder.x_601", stroke[601][1]),
        ("cylinder.v_300", stroke[300][2]),
        ("cylinder.v_601", stroke[601][2]),
        ("cylinder.stop", stroke[stop][0]),
    ]
    .map(|(id, value)| (id.to_owned(), value))
    .to_vec()
}

/// The simulated stroke and the recorded points.
///
/// # Errors
/// None; required by the type of a report.
pub fn figures() -> Result<Vec<Chapter>, ReportError> {
    let recorded = [
        (0.0, 0.2),
        (0.1, 0.204354),
        (0.2, 0.217704),
        (0.3, 0.240052),
        (0.4, 0.271396),
        (0.501, 0.312187),
        (0.601, 0.361615),
        (0.701, 0.4),
        (0.801, 0.4),
    ];
    let stroke = stroke();
    let plot = Plot::new(
        "HydraulicCylinderQTest: position of the C-type cylinder",
        ["t, s", "x, m"],
    )
    .line("circuit", stroke.iter().map(|[t, x, _]| (*t, *x)))
    .with(Style::Dots, "Hopsan", recorded);
    Ok(vec![Chapter {
        title: "A cylinder between two pressures",
        note: "A mass of 1000 kg moved by 100 and 90 bar against 100 N, up to the stop.",
        figures: vec![plot],
    }])
}
