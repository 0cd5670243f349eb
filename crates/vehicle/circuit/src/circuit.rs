//! The constants of a circuit, in SI, and the equations of its parts.
//!
//! ```text
//!   P1 ... Pn, T          supply levels, constant pressures
//!    |  |  |  |
//!   [edges: 0 to 8 on/off valves in parallel from a level to a chamber]
//!    |           |
//!    A |====|==| B        chambers of a cylinder; x > 0 enlarges A
//! ```

use planesman_units::readers;
use serde::{Deserialize, Deserializer};

use crate::choice::choice;

/// Maximum number of supply levels, including the tank.
pub const MOST_LEVELS: usize = 5;
/// Maximum number of edges: one for each pair of level and chamber.
pub const MOST_EDGES: usize = 2 * MOST_LEVELS;
/// Maximum number of valves in an edge.
pub const MOST_VALVES: usize = 8;

/// Atmospheric pressure, Pa, added to the gauge pressures of files.
pub const ATMOSPHERE: f64 = 101_325.0;

/// A circuit. Made and validated by [`crate::file`].
#[derive(Clone, Debug, PartialEq)]
pub struct Circuit {
    /// Its name.
    pub name: String,
    /// The source of the numbers.
    pub source: String,
    /// The load at the ram.
    pub load: Load,
    /// A and B; in a single-acting cylinder B has no area.
    pub chambers: [Chamber; 2],
    /// Laminar leakage from A to B past the piston, m^3/(s Pa).
    pub seal_leakage: f64,
    /// The supply levels with their gauge pressures, Pa, including the tank.
    pub levels: Vec<Level>,
    /// The oil.
    pub oil: Oil,
    /// The valves between levels and chambers.
    pub edges: Vec<Edge>,
    /// The common data of all valves.
    pub valves: Valves,
    /// The controller.
    pub control: Control,
}

// The fields of the files' sections, each with its range in SI.
readers! {
    mass: Mass, [1e-3, 1e7];
    viscous: Damping, [0.0, 1e8];
    friction: Force, [0.0, 1e8];
    stepping: Number, [0.0, 1.0];
    spring: Stiffness, [0.0, 1e9], or 0.0;
    force: Force, [-1e8, 1e8], or 0.0;
    travel: Length, [1e-4, 100.0];
    stop_stiffness: Stiffness, [1.0, 1e12];
    stop_damping: Number, [0.0, 1e4];

    area: Area, [1e-7, 10.0];
    volume: Volume, [1e-9, 100.0];

    bulk_modulus: Pressure, [1e6, 1e11];
    // Without any air a chamber that is drawn empty would have a pressure below zero.
    air: Number, [1e-6, 0.5];
    polytropic: Number, [1.0, 1.7], or 1.4;
    // Of mineral oil.
    density: Density, [100.0, 1e4], or 870.0;
    viscosity: Viscosity, [0.0, 1.0], or 0.0;

    rated_drop: Pressure, [1e3, 1e8];
    delay: Time, [0.0, 1.0];
    scatter: Time, [0.0, 1.0], or 0.0;
    transition: Pressure, [1e2, 1e6], or 5e4;
    rated_life: Number, [1.0, 1e12];
    energy: Energy, [0.0, 1e3], or 0.0;

    period: Time, [1e-4, 10.0];
    gain: Number, [0.0, 1e4];
    dead_zone: Length, [0.0, 1.0], or 0.0;
    switching_cost: Number, [0.0, 1.0];
    energy_cost: Number, [0.0, 10.0];
    pressure_limit: Pressure, [1e3, 1e9], or f64::INFINITY;
    force_filter: Time, [0.0, 10.0], or 0.0;
}

/// A period, ns.
fn nanoseconds<'de, D: Deserializer<'de>>(from: D) -> Result<i64, D::Error> {
    Ok((period::deserialize(from)? * 1e9).round() as i64)
}

/// The load: M dv/dt = p_A A_A - p_B A_B - C v - F_C sgn v - K x - F(t).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Load {
    /// M, kg.
    #[serde(with = "mass")]
    pub mass: f64,
    /// C, N s/m.
    #[serde(with = "viscous")]
    pub viscous: f64,
    /// F_C, N: Coulomb friction.
    #[serde(with = "friction")]
    pub coulomb: f64,
    /// Excess of the static friction, as a share of F_C.
    #[serde(default, with = "stepping")]
    pub stepping: f64,
    /// K, N/m: a spring to the middle.
    #[serde(default, with = "spring")]
    pub spring: f64,
    /// F, N: a constant force against positive motion, for example a weight.
    #[serde(default, with = "force")]
    pub force: f64,
    /// Half of the stroke, m: |x| stays within it.
    #[serde(with = "travel")]
    pub travel: f64,
    /// The elastic stops at the ends of the travel, if there are any.
    pub elastic_stop: Option<ElasticStop>,
    /// R, m: ram travel per radian of plane.
    #[serde(with = "travel")]
    pub moment_arm: f64,
}

/// A stop after Hunt and Crossley: F = k d (1 + lambda dd/dt) at the penetration d, never negative.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ElasticStop {
    /// k, N/m.
    #[serde(with = "stop_stiffness")]
    pub stiffness: f64,
    /// lambda, s/m.
    #[serde(with = "stop_damping")]
    pub damping: f64,
}

/// A chamber.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chamber {
    /// Piston area, m^2.
    #[serde(with = "area")]
    pub area: f64,
    /// Oil volume at mid-stroke, including lines, m^3.
    #[serde(with = "volume")]
    pub volume: f64,
}

impl Chamber {
    /// The oil volume, m^3, after the ram has enlarged it by `more`; at least a hundredth of the volume at mid-stroke.
    #[inline]
    #[must_use]
    pub fn volume_at(&self, more: f64) -> f64 {
        (self.volume + more).max(0.01 * self.volume)
    }
}

/// A supply level.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Its name: `P`, `P2`, `T`.
    pub name: String,
    /// Gauge pressure, Pa.
    pub pressure: f64,
    /// The line from the level to its valves; `None` if the valves are next to the level.
    pub line: Option<Line>,
}

/// A hydraulic line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Travel time of a wave from one end to the other, s: length over the speed of sound `sqrt(B/rho)`.
    pub delay: f64,
    /// Characteristic impedance `rho a/A`, Pa s/m^3.
    pub impedance: f64,
    /// Laminar resistance `128 rho nu l/(pi d^4)`, Pa s/m^3.
    pub resistance: f64,
}

impl Line {
    /// A line with `length` and `diameter`, m, full of oil with the bulk modulus `bulk`, Pa, the density `density`, kg/m^3, and the
    /// kinematic viscosity `viscosity`, m^2/s.
    #[must_use]
    pub fn new(length: f64, diameter: f64, bulk: f64, density: f64, viscosity: f64) -> Self {
        let area = 0.25 * std::f64::consts::PI * diameter * diameter;
        Self {
            delay: length * (density / bulk).sqrt(),
            impedance: (density * bulk).sqrt() / area,
            resistance: 8.0 * std::f64::consts::PI * density * viscosity * length / (area * area),
        }
    }
}

/// Parallel valves between a level and a chamber.
#[derive(Clone, Debug, PartialEq)]
pub struct Edge {
    /// Index of the level in [`Circuit::levels`].
    pub level: usize,
    /// 0 for A, 1 for B.
    pub chamber: usize,
    /// Flow coefficients K of the valves, m^3/(s sqrt(Pa)).
    pub valves: Vec<f64>,
}

/// The common data of all valves.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Valves {
    /// The pressure drop to which the file's flows refer, Pa.
    #[serde(with = "rated_drop")]
    pub rated_drop: f64,
    /// Time from the command to open, s.
    #[serde(with = "delay")]
    pub opening: f64,
    /// Time from the command to closed, s.
    #[serde(with = "delay")]
    pub closing: f64,
    /// Each delay is drawn from a uniform distribution of this half width, s.
    #[serde(default, with = "scatter")]
    pub scatter: f64,
    /// Below this pressure drop the flow becomes laminar, Pa.
    #[serde(default = "transition::default", with = "transition")]
    pub transition: f64,
    /// Number of switchings in a valve's life.
    #[serde(with = "rated_life")]
    pub rated_life: f64,
    /// Energy of its solenoid for each switching, J.
    #[serde(default, with = "energy")]
    pub energy: f64,
}

/// The oil and its air content.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Oil {
    /// Bulk modulus without air, Pa.
    #[serde(with = "bulk_modulus")]
    pub bulk_modulus: f64,
    /// Share of undissolved air at atmospheric pressure.
    #[serde(with = "air")]
    pub air: f64,
    /// The air's polytropic exponent: 1 slow, 1.4 fast.
    #[serde(default = "polytropic::default", with = "polytropic")]
    pub polytropic: f64,
    /// Density, kg/m^3, of the waves in lines.
    #[serde(default = "density::default", with = "density")]
    pub density: f64,
    /// Kinematic viscosity, m^2/s, of the friction in lines.
    #[serde(default, with = "viscosity")]
    pub viscosity: f64,
}

/// The controller.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Control {
    /// Its law.
    #[serde(deserialize_with = "choice")]
    pub law: Law,
    /// Sampling time, ns.
    #[serde(deserialize_with = "nanoseconds")]
    pub period: i64,
    /// Position gain, 1/s: commanded speed per position error.
    #[serde(with = "gain")]
    pub gain: f64,
    /// Position errors below this are ignored while the reference rests, m.
    #[serde(default, with = "dead_zone")]
    pub dead_zone: f64,
    /// Cost of switching one valve once, as a share of the largest speed.
    #[serde(default, with = "switching_cost")]
    pub switching_cost: f64,
    /// Cost of the supply's largest power, as a share of the largest speed.
    #[serde(default, with = "energy_cost")]
    pub energy_cost: f64,
    /// Limit of the chambers' pressures in the model-based law, gauge, Pa.
    #[serde(default = "pressure_limit::default", with = "pressure_limit")]
    pub pressure_limit: f64,
    /// Time constant of the filter of the measured force, s.
    #[serde(default, with = "force_filter")]
    pub force_filter: f64,
}

/// A control law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, planesman_parameters::Choice)]
pub enum Law {
    /// The opening whose flow at half the supply pressure is nearest to the commanded flow.
    Nearest,
    /// The openings with the best steady speed under the measured force, weighing pressures and switchings.
    Model,
    /// All valves of an edge together, for a part of each period.
    Pwm,
}

impl Oil {
    /// The air's volume at the gauge pressure `pressure`, Pa, relative to the oil's volume: `a = air (p_0/p)^(1/n)`.
    #[must_use]
    pub fn air_at(&self, pressure: f64) -> f64 {
        self.air * libm::pow(ATMOSPHERE / (pressure + ATMOSPHERE), 1.0 / self.polytropic)
    }

    /// The effective bulk modulus at the gauge pressure `pressure`, Pa, where the air has the volume `air`: oil and air in series,
    /// `1/B = (1/B_oil + a/(n p)) / (1 + a)` (H. E. Merritt, *Hydraulic Control Systems*, 1967, section 2-3).
    #[inline]
    #[must_use]
    pub fn effective(&self, pressure: f64, air: f64) -> f64 {
        let absolute = pressure + ATMOSPHERE;
        (1.0 + air) / (1.0 / self.bulk_modulus + air / (self.polytropic * absolute))
    }

    /// The rate of the air's volume if the pressure changes by `rate`, Pa/s: `da/dt = -a/(n p) dp/dt`. A simulation integrates it, which
    /// avoids a power function in each step.
    #[inline]
    #[must_use]
    pub fn air_rate(&self, pressure: f64, air: f64, rate: f64) -> f64 {
        -air / (self.polytropic * (pressure + ATMOSPHERE)) * rate
    }
}

/// `sign(drop) sqrt(|drop|)`, made smooth and linear about zero within `transition`:
/// `drop / (drop^2 + transition^2)^(1/4)` (Modelica Standard Library, `Fluid.Utilities.regRoot`).
#[inline]
#[must_use]
pub fn root(drop: f64, transition: f64) -> f64 {
    drop / (drop * drop + transition * transition).sqrt().sqrt()
}

/// The slope of [`root`].
#[inline]
pub(crate) fn root_slope(drop: f64, transition: f64) -> f64 {
    let sum = drop * drop + transition * transition;
    (0.5 * drop * drop + transition * transition) / (sum * sum.sqrt().sqrt())
}

impl Circuit {
    /// The signed areas of A and B, on which pressures act on the ram, m^2.
    #[inline]
    #[must_use]
    pub fn areas(&self) -> [f64; 2] {
        [self.chambers[0].area, -self.chambers[1].area]
    }

    /// The highest and the lowest pressure of the supply levels, Pa.
    #[must_use]
    pub fn pressures(&self) -> (f64, f64) {
        let all = self.levels.iter().map(|level| level.pressure);
        (
            all.clone().fold(f64::NEG_INFINITY, f64::max),
            all.fold(f64::INFINITY, f64::min),
        )
    }

    /// The energy, J, that an ideal 4-way proportional valve without lag and leakage needs to move the ram by `way`: the highest level's pressure
    /// times the volume into one chamber, minus the lowest level's pressure times the volume out of the other.
    #[must_use]
    pub fn proportional(&self, way: f64) -> f64 {
        let (high, low) = self.pressures();
        let [filled, emptied] = if way > 0.0 { [0, 1] } else { [1, 0] }
            .map(|chamber| self.chambers[chamber].area * way.abs());
        high * filled - low * emptied
    }

    /// The static friction, N: slightly more than Coulomb friction, so that a halt is never immediately followed by a break-away.
    #[must_use]
    pub fn break_away(&self) -> f64 {
        self.load.coulomb * (1.0 + self.load.stepping.max(1e-10))
    }

    /// Number of valves of all edges.
    #[must_use]
    pub fn valve_count(&self) -> usize {
        self.edges.iter().map(|edge| edge.valves.len()).sum()
    }

    /// The edge's name: `P-A`, `B-T`.
    #[must_use]
    pub fn edge_name(&self, edge: usize) -> String {
        let Edge { level, chamber, .. } = &self.edges[edge];
        let (level, chamber) = (&self.levels[*level].name, ["A", "B"][*chamber]);
        if level == "T" {
            format!("{chamber}-{level}")
        } else {
            format!("{level}-{chamber}")
        }
    }

    /// The smallest oil volume of a chamber, at the end of the ram's travel, m^3.
    #[must_use]
    pub fn least_volume(&self, chamber: usize) -> f64 {
        let chamber = &self.chambers[chamber];
        chamber.volume_at(-chamber.area * self.load.travel)
    }

    /// The oil's stiffness at that volume, N/m.
    fn oil_stiffness(&self) -> f64 {
        let of = |chamber: usize| {
            let area = self.chambers[chamber].area;
            area * area * self.oil.bulk_modulus / self.least_volume(chamber)
        };
        of(0) + of(1)
    }

    /// The highest natural frequency, Hz, of the load with its oil, spring and elastic stops.
    #[must_use]
    pub fn highest_frequency(&self) -> f64 {
        let stop = self.load.elastic_stop.map_or(0.0, |stop| stop.stiffness);
        let stiffness = self.oil_stiffness() + stop + self.load.spring;
        (stiffness / self.load.mass).sqrt() / std::f64::consts::TAU
    }

    /// The path of the file's field that causes the fastest motion, as `load.viscous`.
    #[must_use]
    pub fn fastest_field(&self) -> String {
        let load = &self.load;
        let swing = |stiffness: f64| (stiffness / load.mass).sqrt();
        let stop = load.elastic_stop.map_or(0.0, |stop| stop.stiffness);
        // 1/s for each m^3/(s Pa) into it.
        let filling = |chamber: usize| self.oil.bulk_modulus / self.least_volume(chamber);
        let laminar = self.valves.transition.sqrt();
        let edges = self.edges.iter().enumerate().map(|(place, edge)| {
            let flow = edge.valves.iter().sum::<f64>() / laminar;
            let path = format!("edges.{}", self.edge_name(place));
            (path, flow * filling(edge.chamber))
        });
        let rates = [
            ("load.viscous", load.viscous / load.mass),
            ("load.spring", swing(load.spring)),
            ("load.elastic_stop.stiffness", swing(stop)),
            ("oil.bulk_modulus", swing(self.oil_stiffness())),
            (
                "seal_leakage",
                self.seal_leakage * filling(0).max(filling(1)),
            ),
        ];
        let all = rates
            .map(|(path, rate)| (path.to_owned(), rate))
            .into_iter();
        let known = all.chain(edges).filter(|(_, rate)| !rate.is_nan());
        let fastest = known.max_by(|one, other| one.1.total_cmp(&other.1));
        fastest.map_or_else(|| "load.mass".to_owned(), |(path, _)| path)
    }

    /// The largest steady speed without load, m/s: over all pairs of edges, both with all valves open.
    #[must_use]
    pub fn largest_speed(&self) -> f64 {
        let all = |edge: &Edge| edge.valves.iter().sum::<f64>();
        self.pairs()
            .into_iter()
            .filter_map(|pair| {
                let steady = self.steady(
                    pair,
                    pair.map(|edge| edge.map_or(0.0, |e| all(&self.edges[e]))),
                    0.0,
                )?;
                Some(steady.speed.abs())
            })
            .fold(0.0, f64::max)
    }

    /// All combinations of edges that connect both chambers: one edge of A and one of B; only edges of A if B has no area.
    #[must_use]
    pub fn pairs(&self) -> Vec<[Option<usize>; 2]> {
        let of = |chamber| {
            let edges = self.edges.iter().enumerate();
            edges
                .filter(move |(_, edge)| edge.chamber == chamber && !edge.valves.is_empty())
                .map(|(place, _)| place)
        };
        if self.chambers[1].area == 0.0 {
            return of(0).map(|a| [Some(a), None]).collect();
        }
        of(0)
            .flat_map(|a| of(1).map(move |b| [Some(a), Some(b)]))
            .collect()
    }

    /// The steady motion through a pair of edges with the openings `k` under the force `force` against positive motion: the flows of both
    /// chambers match the ram's motion, and the forces balance:
    ///
    /// ```text
    /// p_A = p_a - s (A_A v/K_a)^2,  p_B = p_b + s (A_B v/K_b)^2,  p_A A_A - p_B A_B = F + s F_C,   s = sgn v
    /// ```
    /// `None` if an edge is closed.
    #[must_use]
    pub fn steady(&self, pair: [Option<usize>; 2], k: [f64; 2], force: f64) -> Option<Steady> {
        let [area_a, area_b] = [self.chambers[0].area, self.chambers[1].area];
        let level =
            |edge: Option<usize>| edge.map(|edge| self.levels[self.edges[edge].level].pressure);
        let (a, b) = (level(pair[0])?, level(pair[1]).unwrap_or(0.0));
        if k[0] <= 0.0 || (area_b > 0.0 && k[1] <= 0.0) {
            return None;
        }
        let surplus = a * area_a - b * area_b - force;
        let sign = if surplus < 0.0 { -1.0 } else { 1.0 };
        let left = (surplus.abs() - self.load.coulomb).max(0.0);
        let throttling = area_a * area_a * area_a / (k[0] * k[0])
            + if area_b > 0.0 {
                area_b * area_b * area_b / (k[1] * k[1])
            } else {
                0.0
            };
        let speed = sign * (left / throttling).sqrt();
        let drop = |area: f64, k: f64| {
            let root = area * speed / k;
            sign * root * root
        };
        Some(Steady {
            speed,
            pressures: [
                a - drop(area_a, k[0]),
                if area_b > 0.0 {
                    b + drop(area_b, k[1])
                } else {
                    0.0
                },
            ],
            power: (a * area_a - b * area_b) * speed,
        })
    }
}

/// A steady motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steady {
    /// m/s
    pub speed: f64,
    /// p_A and p_B, gauge, Pa.
    pub pressures: [f64; 2],
    /// Power taken from the supply levels, W.
    pub power: f64,
}
