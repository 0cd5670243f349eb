//! Comparison of all methods with the coefficients of the vehicle's file.

use super::{
    Geometry, added_mass, damping, displacement, drag, inertia,
    lift::{Planes, Surface, area_ratio, fin_slope, jones_slope, turning_arm},
    munk::{Spheroid, equivalent_diameter},
    power,
    reference::Reference,
    restoring,
    swing::Swing,
};
use crate::Vehicle;
use planesman_units::{FOOT, FOOT_POUND, POUND_FORCE};

/// A unit in both systems.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// SI unit.
    pub si: &'static str,
    /// Imperial unit.
    pub imperial: &'static str,
    /// The imperial unit in SI.
    pub size: f64,
}

const MASS: Unit = unit("kg", "slug", POUND_FORCE / FOOT);
const FORCE: Unit = unit("N/rad", "lbf/rad", POUND_FORCE);
const FORCE_PER_VELOCITY: Unit = unit("N s/m", "lbf s/ft", POUND_FORCE / FOOT);
const IMPULSE: Unit = unit("N s", "lbf s", POUND_FORCE);
const MOMENT: Unit = unit("N m/rad", "ft lbf/rad", FOOT_POUND);
const MOMENT_PER_RATE: Unit = unit("N m s", "ft lbf s", FOOT_POUND);
const QUADRATIC: Unit = unit("N m s^2", "ft lbf s^2", FOOT_POUND);
const INERTIA: Unit = unit("kg m^2", "ft lbf s^2", FOOT_POUND);
const POWER: Unit = unit("W", "ft lbf/s", FOOT_POUND);
const SPEED: Unit = unit("m/s", "ft/s", FOOT);

const fn unit(si: &'static str, imperial: &'static str, size: f64) -> Unit {
    Unit { si, imperial, size }
}

/// A coefficient computed by one method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Its name.
    pub coefficient: &'static str,
    /// Method of computation.
    pub method: &'static str,
    /// Computed, nondimensional.
    pub computed: f64,
    /// Nondimensional value in the vehicle's file; `None` if the file does not have this coefficient.
    pub in_the_file: Option<f64>,
    /// SI value of one nondimensional unit at the speed of the table.
    pub factor: f64,
    /// The units.
    pub unit: Unit,
}

impl Row {
    /// Computed value, in SI.
    #[must_use]
    pub fn si(&self) -> f64 {
        self.computed * self.factor
    }

    /// Computed, imperial.
    #[must_use]
    pub fn imperial(&self) -> f64 {
        self.si() / self.unit.size
    }

    /// Relative difference of the computed value from the file's value.
    #[must_use]
    pub fn difference(&self) -> Option<f64> {
        self.in_the_file
            .filter(|v| *v != 0.0)
            .map(|v| self.computed / v - 1.0)
    }
}

/// A dimensional quantity by one method.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Its name.
    pub quantity: String,
    /// Method of computation.
    pub method: &'static str,
    /// Computed value, in SI.
    pub si: f64,
    /// Standard uncertainty in SI; `None` if the method does not give one.
    pub uncertainty: Option<f64>,
    /// The units.
    pub unit: Unit,
}

/// All coefficients of a vehicle by every method, at one speed.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Coefficients, with the values of the file.
    pub rows: Vec<Row>,
    /// Dimensional quantities: inertia, damping, drag, power, swing tests.
    pub figures: Vec<Figure>,
    /// Coefficients that could not be computed, each with the reason.
    pub missing: Vec<String>,
}

/// Both pairs of planes as lifting surfaces.
#[must_use]
pub fn planes(vehicle: &Vehicle, geometry: &Geometry) -> Planes {
    let pair = |fin: super::geometry::FinPair| Surface {
        z_w: -fin_slope(fin.effective_aspect_ratio())
            * area_ratio(
                geometry.water.density,
                2.0 * fin.area(),
                vehicle.reference_mass,
                vehicle.reference_length,
            ),
        arm: fin.arm / vehicle.reference_length,
    };
    Planes {
        forward: pair(geometry.fins.forward),
        aft: pair(geometry.fins.aft),
    }
}

/// `Z'w` of the hull by Jones, for the area breadth times `length` \[m\].
#[must_use]
pub fn hull_lift(vehicle: &Vehicle, geometry: &Geometry, length: f64) -> f64 {
    let hull = geometry.hull;
    -jones_slope(hull.breadth / hull.length)
        * area_ratio(
            geometry.water.density,
            hull.breadth * length,
            vehicle.reference_mass,
            vehicle.reference_length,
        )
}

impl Table {
    /// The table of `vehicle` at `speed` \[m/s\].
    #[must_use]
    pub fn of(vehicle: &Vehicle, geometry: &Geometry, speed: f64) -> Self {
        let mut table = Self {
            rows: Vec::new(),
            figures: Vec::new(),
            missing: Vec::new(),
        };
        let reference = Reference::new(vehicle, speed);
        table.lift(vehicle, geometry, &reference);
        table.inertia(vehicle, geometry, &reference);
        table.damping(vehicle, geometry, &reference);
        let arm = vehicle.restoring_arm;
        table.row(Row {
            coefficient: "M'theta",
            method: "W BG",
            computed: restoring::m_theta(vehicle.weight, arm, &reference),
            in_the_file: None,
            factor: reference.moment(),
            unit: MOMENT,
        });
        table.drag(geometry);
        table.swing(vehicle, geometry);
        table
    }

    fn row(&mut self, row: Row) {
        self.rows.push(row);
    }

    fn figure(&mut self, quantity: impl Into<String>, method: &'static str, si: f64, unit: Unit) {
        self.figures.push(Figure {
            quantity: quantity.into(),
            method,
            si,
            uncertainty: None,
            unit,
        });
    }

    /// Rows of one coefficient, with its name and its value in the file; one row for each method.
    fn by_methods<const N: usize>(
        &mut self,
        (coefficient, in_the_file): (&'static str, f64),
        (factor, unit): (f64, Unit),
        values: [(&'static str, f64); N],
    ) {
        for (method, computed) in values {
            self.row(Row {
                coefficient,
                method,
                computed,
                in_the_file: Some(in_the_file),
                factor,
                unit,
            });
        }
    }

    fn lift(&mut self, vehicle: &Vehicle, geometry: &Geometry, reference: &Reference) {
        let (hull, l) = (geometry.hull, vehicle.reference_length);
        let file = vehicle.coefficients;
        let fins = planes(vehicle, geometry);
        let hull_z_w = hull_lift(vehicle, geometry, l);
        let on_own_length = hull_lift(vehicle, geometry, hull.length);
        self.by_methods(
            ("Z'w", file.z_w),
            (reference.force_per_velocity(), FORCE_PER_VELOCITY),
            [
                ("Jones' hull on L, and fins", hull_z_w + fins.z_w()),
                (
                    "Jones' hull on its own length, and fins",
                    on_own_length + fins.z_w(),
                ),
                ("fins alone", fins.z_w()),
            ],
        );
        let impulse = (reference.impulse(), IMPULSE);
        self.by_methods(("Z'q", file.z_q), impulse, [("fins alone", fins.z_q())]);
        self.by_methods(
            ("Z'delta", file.z_delta),
            (reference.force(), FORCE),
            [("fins", fins.z_delta())],
        );
        self.moment_per_heave(vehicle, geometry, reference, hull_z_w);
        let c_p = displacement::prismatic_coefficient(hull.volume, hull.section, l);
        let turning = Surface {
            z_w: hull_z_w,
            arm: -turning_arm(c_p, hull.length, l),
        };
        self.by_methods(
            ("M'q", file.m_q),
            (reference.moment_per_rate(), MOMENT_PER_RATE),
            [
                ("hull lift at C_p / 2, and fins", turning.m_q() + fins.m_q()),
                ("fins alone", fins.m_q()),
            ],
        );
        self.by_methods(
            ("M'delta", file.m_delta),
            (reference.moment(), MOMENT),
            [("fins", fins.m_delta())],
        );
    }

    /// `M'w`, with the hull's lift `hull_z_w`.
    fn moment_per_heave(
        &mut self,
        vehicle: &Vehicle,
        geometry: &Geometry,
        reference: &Reference,
        hull_z_w: f64,
    ) {
        let (hull, l) = (geometry.hull, vehicle.reference_length);
        let fins = planes(vehicle, geometry);
        let m_w = ("M'w", vehicle.coefficients.m_w);
        let impulse = (reference.impulse(), IMPULSE);
        let quarter = Surface {
            z_w: hull_z_w,
            arm: 0.25 * hull.length / l,
        };
        let at_quarter = quarter.m_w() + fins.m_w();
        let method = "hull lift at a quarter of its length, and fins";
        self.by_methods(m_w, impulse, [(method, at_quarter)]);
        let Some(spheroid) = Spheroid::new(hull.length, equivalent_diameter(hull.section)) else {
            let reason = "M'w by Munk: the hull is not longer than the diameter of its section";
            return self.missing.push(reason.into());
        };
        let ideal = spheroid.m_w(vehicle.mass / vehicle.reference_mass);
        self.by_methods(
            m_w,
            impulse,
            [("Munk moment in an ideal fluid, without fins", ideal)],
        );
        match hull.lift_aft {
            Some(aft) => {
                let less = ideal + hull_z_w * aft / l + fins.m_w();
                self.by_methods(
                    m_w,
                    impulse,
                    [("Munk moment minus the lift aft, and fins", less)],
                );
            }
            None => self
                .missing
                .push("M'w by Munk minus the lift aft: geometry.hull.lift_aft is not given".into()),
        }
    }

    fn inertia(&mut self, vehicle: &Vehicle, geometry: &Geometry, reference: &Reference) {
        let (air, blocks) = (geometry.air, geometry.added_mass);
        let mass = air.weight / geometry.gravity;
        let rho = geometry.water.density;
        self.row(Row {
            coefficient: "m'",
            method: "W / g",
            computed: vehicle.weight / geometry.gravity / vehicle.reference_mass,
            in_the_file: Some(vehicle.mass / vehicle.reference_mass),
            factor: vehicle.reference_mass,
            unit: MASS,
        });
        for (axis, name, sides, blocks) in [
            ("pitch", "Jy", (air.length, air.depth), blocks.pitch),
            ("yaw", "Jz", (air.length, air.breadth), blocks.yaw),
            ("roll", "Jx", (air.breadth, air.depth), blocks.roll),
        ] {
            let in_air = inertia::box_inertia(mass, sides.0, sides.1);
            self.figure(format!("{name} in air"), "box", in_air, INERTIA);
            let Some(one) = added_mass::block(rho, blocks.side, blocks.thickness) else {
                self.missing.push(format!(
                    "added mass in {axis}: the table of blocks covers B/A from 0.5 to 2, not {:.3}",
                    blocks.thickness / blocks.side
                ));
                continue;
            };
            let added = f64::from(blocks.count) * one;
            let whole =
                in_air + added_mass::spread(added, blocks.spread_length, blocks.spread_breadth);
            if axis == "pitch" {
                self.row(Row {
                    coefficient: "Z'wdot",
                    method: "square blocks",
                    computed: -added / reference.mass,
                    in_the_file: Some(vehicle.coefficients.z_w_dot),
                    factor: reference.mass,
                    unit: MASS,
                });
                self.row(Row {
                    coefficient: "I'y - M'qdot",
                    method: "box in air and square blocks",
                    computed: whole / reference.inertia(),
                    in_the_file: Some(vehicle.coefficients.i_y_minus_m_q_dot),
                    factor: reference.inertia(),
                    unit: INERTIA,
                });
            } else {
                self.figure(
                    format!("added mass in {axis}"),
                    "square blocks",
                    added,
                    MASS,
                );
                self.figure(format!("{name} in water"), "box and blocks", whole, INERTIA);
            }
        }
    }

    fn damping(&mut self, vehicle: &Vehicle, geometry: &Geometry, reference: &Reference) {
        let choice = geometry.damping;
        let (rho, rate) = (geometry.water.density, choice.rate);
        for (name, linear, plate) in [
            ("N_y", "B_y", choice.pitch),
            ("N_z", "B_z", choice.yaw),
            ("N_x", "B_x", choice.roll),
        ] {
            let c = damping::plate(rho, choice.drag_coefficient, plate.area(), plate.length);
            self.figure(name, "plate, mean speed", c, QUADRATIC);
            let strips =
                damping::plate_by_strips(rho, choice.drag_coefficient, plate.area(), plate.length);
            self.figure(name, "plate, by strips", strips, QUADRATIC);
            self.figure(
                linear,
                "secant at the linearising rate",
                damping::secant(c, rate),
                MOMENT_PER_RATE,
            );
            if name == "N_y" {
                for (method, b) in [
                    ("viscous plate, secant", damping::secant(c, rate)),
                    ("viscous plate, tangent", damping::tangent(c, rate)),
                ] {
                    self.row(Row {
                        coefficient: "M'q",
                        method,
                        computed: -b / reference.moment_per_rate(),
                        in_the_file: Some(vehicle.coefficients.m_q),
                        factor: reference.moment_per_rate(),
                        unit: MOMENT_PER_RATE,
                    });
                }
            }
        }
    }

    fn drag(&mut self, geometry: &Geometry) {
        let (areas, water, hull) = (geometry.drag, geometry.water, geometry.hull);
        let re = drag::reynolds(areas.speed, areas.plate_length, water.viscosity);
        let turbulent = drag::turbulent_friction(re);
        let power = |c: f64, area: f64| {
            power::against(drag::drag(water.density, c, area, areas.speed), areas.speed)
        };
        let laminar = power(drag::laminar_friction(re), areas.wetted);
        self.figure("power", "laminar friction", laminar, POWER);
        self.figure(
            "power",
            "turbulent friction",
            power(turbulent, areas.wetted),
            POWER,
        );
        let cfb = drag::forebody(turbulent, areas.forebody, hull.section);
        let shape = power(cfb + drag::base(cfb), hull.section);
        let stern = power(turbulent, (areas.wetted - areas.forebody).max(0.0));
        self.figure(
            "power",
            "forebody, base, stern friction",
            shape + stern,
            POWER,
        );
        self.figure(
            "power",
            "drag coefficient",
            power(areas.coefficient, hull.section),
            POWER,
        );
        let screws = geometry.screws;
        for (method, count) in [("one screw's disk", 1), ("all screws' disks", screws.count)] {
            let area = power::swept_area(count, screws.diameter);
            let jet = power::jet_speed(water.density, screws.speed, screws.drag, area);
            self.figure("jet speed", method, jet, SPEED);
        }
    }

    fn swing(&mut self, vehicle: &Vehicle, geometry: &Geometry) {
        if geometry.swing_tests.is_empty() {
            self.missing
                .push("moments of inertia measured: geometry.swing_tests is empty".into());
        }
        for test in &geometry.swing_tests {
            let swing = Swing {
                weight: vehicle.weight,
                length: test.length,
                period: test.period,
                gravity: geometry.gravity,
            };
            self.figures.push(Figure {
                quantity: test.name.clone(),
                method: "swing test",
                si: swing.inertia(),
                uncertainty: Some(
                    swing.uncertainty(test.period_uncertainty, test.length_uncertainty),
                ),
                unit: INERTIA,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vehicle_file::{self, BRUNNER};

    fn table() -> Table {
        let vehicle = vehicle_file::load(BRUNNER).expect("built in");
        let geometry = vehicle_file::geometry(BRUNNER)
            .expect("valid")
            .expect("there");
        Table::of(&vehicle, &geometry, FOOT)
    }

    /// Brunner 1988, Table 1 (p. 41): the coefficients, by the methods of pp. 42-46.
    #[test]
    fn the_report_s_methods_come_to_the_report_s_coefficients() {
        let table = table();
        for (coefficient, method, bound) in [
            ("m'", "W / g", 0.002),
            ("Z'w", "Jones' hull on L, and fins", 0.003),
            ("Z'delta", "fins", 0.04),
            ("M'delta", "fins", 0.005),
            ("M'w", "Munk moment minus the lift aft, and fins", 0.02),
            ("M'q", "hull lift at C_p / 2, and fins", 0.005),
            ("Z'wdot", "square blocks", 0.02),
        ] {
            let row = table
                .rows
                .iter()
                .find(|r| r.coefficient == coefficient && r.method == method)
                .expect("in the table");
            let off = row.difference().expect("in the file");
            assert!(off.abs() < bound, "{coefficient}: {off}");
        }
        assert!(table.missing.is_empty(), "{:?}", table.missing);
    }

    #[test]
    fn a_row_has_its_imperial_and_metric_value() {
        let table = table();
        let row = table
            .rows
            .iter()
            .find(|r| r.coefficient == "M'theta")
            .expect("there");
        assert!((row.imperial() + 0.16333).abs() < 1e-5);
        assert!((row.si() + 0.22145).abs() < 1e-5);
    }

    #[test]
    fn roll_inertia_is_not_measured_by_a_swing_test() {
        let table = table();
        let jx = table
            .figures
            .iter()
            .find(|f| f.quantity == "Jx")
            .expect("there");
        assert!(jx.uncertainty.expect("given") > jx.si);
    }
}
