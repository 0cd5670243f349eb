//! Quantities of the vehicle: Tables 1, 2, 4 and 6, Fig. 23, lift, damping, planes, drag and power, structure, ballast and swing tests (Brunner
//! 1988, chs. II to IV).
//!
//! Where the report continues with its own rounded results, this module does the same.

use std::f64::consts::FRAC_PI_6;

use crate::book::Book;

use super::{numbers::Recomputed, rounding::to_decimals, structure};
use planesman_units::{FOOT, FOOT_POUND, INCH, POUND_FORCE, PSI, SLUG};

use planesman_vehicle::{
    Vehicle,
    coefficients::{
        Geometry, added_mass, damping, displacement, drag,
        geometry::Blocks,
        inertia::box_inertia,
        lift, munk, power,
        reference::{Reference, reference_mass},
        restoring,
        swing::Swing,
        table,
    },
    vehicle_file::{self, BRUNNER},
};

const SQUARE_INCH: f64 = INCH * INCH;
const CUBIC_INCH: f64 = SQUARE_INCH * INCH;
const CUBIC_FOOT: f64 = FOOT * FOOT * FOOT;
/// `g` \[m/s^2\] used to convert masses in kg to weights.
const STANDARD_GRAVITY: f64 = 9.806_65;
/// The report's plane angle, 30 degrees.
const PLANES: f64 = FRAC_PI_6;

/// All numbers of this module.
///
/// # Panics
/// Never: tests read the compiled-in files.
#[must_use]
pub(super) fn recomputed() -> Recomputed {
    let report = Report {
        book: super::book().expect("the built-in book is valid"),
        vehicle: vehicle_file::brunner(),
        geometry: vehicle_file::geometry(BRUNNER)
            .ok()
            .flatten()
            .expect("the built-in vehicle has a geometry"),
    };
    [
        report.references(),
        report.table_1(),
        report.figure_23(),
        report.fins_and_hull(),
        report.volumes(),
        report.inertia(),
        report.damping(),
        report.plane_constants(),
        report.table_6(),
        report.power(),
        report.structure(),
        report.swing_tests(),
        report.metric(),
    ]
    .concat()
}

/// Sources of the numbers.
struct Report {
    book: Book,
    vehicle: Vehicle,
    geometry: Geometry,
}

impl Report {
    /// A printed number, in its entry's unit: the report's own result of an earlier step.
    fn printed(&self, id: &str) -> f64 {
        self.book.printed(id).unwrap_or(f64::NAN)
    }

    /// `rho` \[kg/m^3\].
    fn rho(&self) -> f64 {
        self.geometry.water.density
    }

    /// The reference quantities at 1 ft/s.
    fn reference(&self) -> Reference {
        Reference::new(&self.vehicle, FOOT)
    }

    /// Table 2.
    fn references(&self) -> Recomputed {
        let (l, t) = (self.vehicle.reference_length, self.geometry.hull.depth);
        let r = self.reference();
        vec![
            ("Tab2.ref_mass", reference_mass(self.rho(), l, t) / SLUG),
            ("Tab2.ref_force", r.force() / POUND_FORCE),
            ("Tab2.ref_moment", r.moment() / FOOT_POUND),
        ]
    }

    /// Table 1, each column computed from the other.
    fn table_1(&self) -> Recomputed {
        let r = self.reference();
        let nondim = |name: &str| self.printed(&format!("Tab1.{name}.nondim"));
        let dim = |name: &str| self.printed(&format!("Tab1.{name}.dim"));
        let mass = self.printed("F23.mass") / self.printed("Tab2.ref_mass");
        let (weight, arm) = (self.vehicle.weight, self.vehicle.restoring_arm);
        vec![
            (
                "Tab1.Zw.nondim",
                dim("Zw") * (POUND_FORCE / FOOT) / r.force_per_velocity(),
            ),
            (
                "Tab1.Zwdot.nondim",
                dim("Zwdot") * (POUND_FORCE / FOOT) / r.mass,
            ),
            ("Tab1.Zq.nondim", dim("Zq") * POUND_FORCE / r.impulse()),
            (
                "Tab1.Zdelta.nondim",
                dim("Zdelta") * POUND_FORCE / r.force(),
            ),
            ("Tab1.Mw.nondim", dim("Mw") * POUND_FORCE / r.impulse()),
            (
                "Tab1.Mq.nondim",
                dim("Mq") * FOOT_POUND / r.moment_per_rate(),
            ),
            (
                "Tab1.Iy-Mqdot.nondim",
                dim("Iy-Mqdot") * FOOT_POUND / r.inertia(),
            ),
            ("Tab1.Mtheta.nondim", restoring::m_theta(weight, arm, &r)),
            (
                "Tab1.Mdelta.nondim",
                dim("Mdelta") * FOOT_POUND / r.moment(),
            ),
            (
                "Tab1.Zw.dim",
                nondim("Zw") * r.force_per_velocity() / (POUND_FORCE / FOOT),
            ),
            (
                "Tab1.Zwdot.dim",
                nondim("Zwdot") * r.mass / (POUND_FORCE / FOOT),
            ),
            ("Tab1.Zq.dim", nondim("Zq") * r.impulse() / POUND_FORCE),
            (
                "Tab1.Zdelta.dim",
                nondim("Zdelta") * r.force() / POUND_FORCE,
            ),
            ("Tab1.Mw.dim", nondim("Mw") * r.impulse() / POUND_FORCE),
            (
                "Tab1.Mq.dim",
                nondim("Mq") * r.moment_per_rate() / FOOT_POUND,
            ),
            (
                "Tab1.Iy-Mqdot.dim",
                nondim("Iy-Mqdot") * r.inertia() / FOOT_POUND,
            ),
            (
                "Tab1.Mtheta.dim",
                nondim("Mtheta") * r.moment() / FOOT_POUND,
            ),
            (
                "Tab1.Mdelta.dim",
                nondim("Mdelta") * r.moment() / FOOT_POUND,
            ),
            ("Tab1.mprime", mass),
        ]
    }

    /// Fig. 23: particulars of the vehicle.
    fn figure_23(&self) -> Recomputed {
        let weight = self.vehicle.weight;
        let fins = self.geometry.fins;
        let volume = displacement::volume_of_weight(weight, self.specific_weight());
        vec![
            ("F23.mass", weight / self.geometry.gravity / SLUG),
            ("F23.volume", volume / CUBIC_INCH),
            ("F23.fwd_area", fins.forward.area() / SQUARE_INCH),
            ("F23.fwd_AR", fins.forward.aspect_ratio()),
            ("F23.fwd_ARe", fins.forward.effective_aspect_ratio()),
            ("F23.aft_area", fins.aft.area() / SQUARE_INCH),
            ("F23.aft_AR", fins.aft.aspect_ratio()),
            ("F23.aft_ARe", fins.aft.effective_aspect_ratio()),
            (
                "F23.BG_moment",
                restoring::stiffness(weight, self.vehicle.restoring_arm) / FOOT_POUND,
            ),
        ]
    }

    /// Specific weight of water, 62.4 lbf/ft^3 \[N/m^3\] (p. 52).
    fn specific_weight(&self) -> f64 {
        62.4 * POUND_FORCE / CUBIC_FOOT
    }

    /// Lift of fins and hull, and the resulting entries of Table 1 (pp. 43-46).
    fn fins_and_hull(&self) -> Recomputed {
        let (vehicle, hull) = (&self.vehicle, self.geometry.hull);
        let l = vehicle.reference_length;
        let fins = table::planes(vehicle, &self.geometry);
        let slope = |fin: planesman_vehicle::coefficients::geometry::FinPair| {
            lift::fin_slope(fin.effective_aspect_ratio())
        };
        let hull_z_w = table::hull_lift(vehicle, &self.geometry, l);
        let c_p = displacement::prismatic_coefficient(
            self.printed("F23.volume") * CUBIC_INCH,
            hull.section,
            l,
        );
        let turning = lift::Surface {
            z_w: self.printed("Zw.hull"),
            arm: -lift::turning_arm(c_p, hull.length, l),
        };
        let diameter = munk::equivalent_diameter(hull.section);
        let spheroid = munk::Spheroid::new(hull.length, diameter);
        // Hull moments as printed: 0.12 from Munk's moment and the vortex lift, 0.18 as an airfoil (p. 44).
        let (munk_and_vortex, airfoil) = (0.12, 0.18);
        vec![
            ("fin.CLa_fwd", slope(self.geometry.fins.forward)),
            ("fin.CLa_aft", slope(self.geometry.fins.aft)),
            ("fin.Zw_fwd", fins.forward.z_w),
            ("fin.Zw_aft", fins.aft.z_w),
            ("Zdelta.fin", fins.z_delta()),
            ("Mdelta.fin", fins.m_delta()),
            ("hull.AR", hull.breadth / hull.length),
            ("Zw.hull", hull_z_w),
            (
                "Zw.hull_S26.5",
                table::hull_lift(vehicle, &self.geometry, hull.length),
            ),
            ("Zw.total", hull_z_w + fins.z_w()),
            ("Mw.fin", fins.m_w()),
            ("Mw.total", munk_and_vortex + fins.m_w()),
            ("Mw.hull_airfoil_arm", airfoil / -self.printed("Zw.hull")),
            ("Zq.fin", fins.z_q()),
            ("hull.Cp", c_p),
            ("Mq.total", fins.m_q() + turning.m_q()),
            ("munk.De", diameter / INCH),
            ("munk.k1", spheroid.map_or(f64::NAN, |s| s.k1)),
            ("munk.k2", spheroid.map_or(f64::NAN, |s| s.k2)),
        ]
    }

    /// Displacement from geometry, and ballast (pp. 52, 79).
    fn volumes(&self) -> Recomputed {
        let hull = self.geometry.hull;
        let mid = displacement::box_volume(17.0 * INCH, hull.breadth, hull.depth);
        let stern = displacement::wedge_volume(6.0 * INCH, hull.breadth, hull.depth);
        // The forward section is printed as "approximately 37" cubic inches, its bases are not.
        let total = mid + stern + 37.0 * CUBIC_INCH;
        let pounds = |mass: f64| mass * STANDARD_GRAVITY / POUND_FORCE;
        vec![
            ("vol.mid", mid / CUBIC_INCH),
            ("vol.stern", stern / CUBIC_INCH),
            ("vol.total", total / CUBIC_INCH),
            (
                "disp.weight",
                displacement::displaced_weight(total, self.specific_weight()) / POUND_FORCE,
            ),
            ("wt.dry", pounds(8.215)),
            ("wt.sub", pounds(9.113)),
        ]
    }

    /// Moments of inertia in air and in water (p. 53, Table 4).
    fn inertia(&self) -> Recomputed {
        let (air, blocks) = (self.geometry.air, self.geometry.added_mass);
        let mass = air.weight / self.geometry.gravity;
        let jy = box_inertia(mass, air.length, air.depth);
        let jx = box_inertia(mass, air.breadth, air.depth);
        let jz = box_inertia(mass, air.length, air.breadth);
        let added = |b: Blocks| {
            f64::from(b.count)
                * added_mass::block(self.rho(), b.side, b.thickness).unwrap_or(f64::NAN)
        };
        let spread = |b: Blocks| added_mass::spread(added(b), b.spread_length, b.spread_breadth);
        let row = added_mass::in_a_row(added(blocks.pitch), blocks.pitch.count, blocks.pitch.side);
        let mut values = vec![
            ("am.pitch", added(blocks.pitch) / SLUG),
            ("Tab4.am_z", added(blocks.yaw) / SLUG),
            ("Tab4.am_x", added(blocks.roll) / SLUG),
        ];
        values.extend(
            [
                ("Jy.air", jy),
                ("Jx.air", jx),
                ("Jz.air", jz),
                ("am.Jpitch", spread(blocks.pitch)),
                ("am.Jpitch_discrete", row),
                ("Jy.sum", jy + spread(blocks.pitch)),
                ("Tab4.Jz", jz + spread(blocks.yaw)),
                ("Tab4.Jx", jx + spread(blocks.roll)),
            ]
            .map(|(id, j)| (id, j / FOOT_POUND)),
        );
        values
    }

    /// Viscous damping and its linearisation (pp. 54-57).
    fn damping(&self) -> Recomputed {
        let choice = self.geometry.damping;
        let plate = |p: planesman_vehicle::coefficients::geometry::Plate| {
            damping::plate(self.rho(), choice.drag_coefficient, p.area(), p.length) / FOOT_POUND
        };
        let strips = damping::plate_by_strips(
            self.rho(),
            choice.drag_coefficient,
            choice.pitch.area(),
            choice.pitch.length,
        ) / FOOT_POUND;
        let secant = |id: &str| damping::secant(self.printed(id), choice.rate);
        let nondim = |b: f64| b * FOOT_POUND / self.reference().moment_per_rate();
        vec![
            ("damp.Ny", plate(choice.pitch)),
            ("damp.Nz", plate(choice.yaw)),
            ("damp.Nx", plate(choice.roll)),
            ("damp.Ny_exact", strips),
            ("damp.By_lin", secant("damp.Ny")),
            ("damp.Bz_lin", secant("damp.Nz")),
            ("damp.Bx_lin", secant("damp.Nx")),
            (
                "damp.Mq_015",
                damping::tangent(plate(choice.pitch), choice.rate),
            ),
            ("damp.Mq_1", damping::tangent(self.printed("damp.Ny"), 1.0)),
            ("damp.Mq_015_nd", nondim(self.printed("damp.Mq_015"))),
            ("damp.Mq_1_nd", nondim(self.printed("damp.Mq_1"))),
            // The secant, rounded to 0.06 (p. 56).
            (
                "damp.By_nd",
                -nondim(to_decimals(self.printed("damp.By_lin"), 2)),
            ),
        ]
    }

    /// Moments per plane angle of the simplified controllers (pp. 8-9, 30, 32), at 1 ft/s and 30 degrees.
    fn plane_constants(&self) -> Recomputed {
        let (forward, aft) = (self.geometry.fins.forward, self.geometry.fins.aft);
        let half = PLANES / 2.0;
        let stream = 2.0 * forward.area() * libm::sin(PLANES);
        let bow = power::side_force(self.rho(), stream, FOOT, half) / POUND_FORCE;
        // Printed forces [lbf]: at the stern 0.048, set as 0.48.
        let moment = |stern: f64| (self.printed("Ky.Fbow") * forward.arm - stern * aft.arm) / INCH;
        let roll = power::side_force(self.rho(), 4.0 * SQUARE_INCH, FOOT, half) / POUND_FORCE;
        let inches_per_foot = FOOT / INCH;
        let yaw = 0.03 * 14.0 / inches_per_foot;
        vec![
            ("Ky.Fbow", bow),
            ("Ky.moment", moment(0.048)),
            ("Ky.moment_048x10", moment(0.48)),
            ("Ky", self.printed("Ky.moment") / inches_per_foot / PLANES),
            (
                "Ky.ratio",
                -self.printed("Tab1.Mdelta.dim") / self.printed("Ky"),
            ),
            ("Kx.F", roll),
            ("Kx.M", self.printed("Kx.F") * 9.0 / inches_per_foot),
            ("Kx", self.printed("Kx.M") / PLANES),
            ("Kz", yaw / PLANES),
        ]
    }

    /// Table 6: each column computed from the previous rounded one.
    fn table_6(&self) -> Recomputed {
        let areas = self.geometry.drag;
        [
            [
                "Tab6.Cf_lam_1",
                "Tab6.Cf_turb_1",
                "Tab6.Cfb_1",
                "Tab6.Cdb_1",
            ],
            [
                "Tab6.Cf_lam_2",
                "Tab6.Cf_turb_2",
                "Tab6.Cfb_2",
                "Tab6.Cdb_2",
            ],
            [
                "Tab6.Cf_lam_3",
                "Tab6.Cf_turb_3",
                "Tab6.Cfb_3",
                "Tab6.Cdb_3",
            ],
            [
                "Tab6.Cf_lam_4",
                "Tab6.Cf_turb_4",
                "Tab6.Cfb_4",
                "Tab6.Cdb_4",
            ],
            [
                "Tab6.Cf_lam_5",
                "Tab6.Cf_turb_5",
                "Tab6.Cfb_5",
                "Tab6.Cdb_5",
            ],
        ]
        .into_iter()
        .zip([1.0, 2.0, 3.0, 4.0, 5.0])
        .flat_map(|([lam_id, turb_id, cfb_id, cdb_id], feet_per_second)| {
            let viscosity = self.geometry.water.viscosity;
            let re = drag::reynolds(feet_per_second * FOOT, areas.plate_length, viscosity);
            let turb = drag::turbulent_friction(re);
            let section = self.geometry.hull.section;
            let cfb = drag::forebody(to_decimals(turb, 3), areas.forebody, section);
            [
                (lam_id, drag::laminar_friction(re)),
                (turb_id, turb),
                (cfb_id, cfb),
                (cdb_id, drag::base(to_decimals(cfb, 2))),
            ]
        })
        .collect()
    }

    /// Power at 5 ft/s, the jet, and induced drag with the planes at 30 degrees (pp. 59-62).
    fn power(&self) -> Recomputed {
        let (areas, screws, fins) = (self.geometry.drag, self.geometry.screws, self.geometry.fins);
        let section = self.geometry.hull.section;
        let watts = |c: f64, area: f64| {
            power::against(drag::drag(self.rho(), c, area, areas.speed), areas.speed)
        };
        let laminar = drag::laminar_friction(drag::reynolds(
            areas.speed,
            areas.plate_length,
            self.geometry.water.viscosity,
        ));
        let turbulent = self.printed("Tab6.Cf_turb_5");
        let shape = self.printed("Tab6.Cfb_5") + self.printed("Tab6.Cdb_5");
        let stern = areas.wetted - areas.forebody;
        let both = power::swept_area(screws.count, screws.diameter);
        let one = power::swept_area(1, screws.diameter);
        let jet = power::jet_speed(self.rho(), screws.speed, screws.drag, one);
        let jet_as_printed = self.printed("prop.Vp") * FOOT;
        let forward = 2.0 * fins.forward.area() * libm::sin(PLANES);
        let aft = self.printed("prop.area2") * SQUARE_INCH;
        // From 1 ft/s to 5 ft/s; a pound-force at 1 ft/s is a foot-pound per second.
        let at_full_speed =
            |pounds: f64| power::by_cube_law(pounds * FOOT_POUND, FOOT, areas.speed);
        let planes = self.printed("ind.drag_fwd") + self.printed("ind.drag_aft");
        let rudder = at_full_speed(self.printed("ind.drag_aft"));
        // Screws of one half efficiency take twice the power.
        let total =
            |rudder: f64| 2.0 * (self.printed("pow.comb") + self.printed("ind.power5W") + rudder);
        vec![
            (
                "pow.lam",
                watts(self.printed("Tab6.Cf_lam_5"), areas.wetted),
            ),
            ("pow.lam_unrounded", watts(laminar, areas.wetted)),
            ("pow.turb", watts(turbulent, areas.wetted)),
            ("pow.comb", watts(shape, section) + watts(turbulent, stern)),
            ("pow.cd02", watts(areas.coefficient, section)),
            ("prop.area2", both / SQUARE_INCH),
            ("prop.Vp", jet / FOOT),
            (
                "ind.drag_fwd",
                power::induced_drag(self.rho(), forward, FOOT, PLANES) / POUND_FORCE,
            ),
            (
                "ind.drag_aft",
                power::induced_drag(self.rho(), aft, jet_as_printed, PLANES) / POUND_FORCE,
            ),
            ("ind.power5", at_full_speed(planes) / FOOT_POUND),
            ("ind.power5W", at_full_speed(planes)),
            ("ind.aft_W", rudder),
            ("pow.total", total(rudder)),
            ("pow.total_with2.8", total(self.printed("ind.aft_W"))),
        ]
    }

    /// Plates and beams of aluminium under a pressure of 5 psi (pp. 50-52).
    fn structure(&self) -> Recomputed {
        let (pressure, stress, modulus) = (5.0 * PSI, 30_000.0 * PSI, 1e7 * PSI);
        let (length, breadth, skin) = (16.0 * INCH, 6.0 * INCH, 0.125 * INCH);
        let beams = 2.0;
        let load = pressure * length * breadth / (beams + 1.0);
        let beam = structure::beam_width(load, breadth, modulus, 0.25 * INCH, 0.007 * INCH);
        vec![
            (
                "hull.t",
                structure::plate_thickness(0.5, pressure, length, stress) / INCH,
            ),
            (
                "hull.defl",
                structure::plate_deflection(0.028, pressure, breadth, modulus, skin) / INCH,
            ),
            ("hull.beam_b", beam / INCH),
        ]
    }

    /// Swing tests (pp. 80-83).
    fn swing_tests(&self) -> Recomputed {
        const NAMES: [[&str; 6]; 3] = [
            [
                "swing.Jy1",
                "swing.Jy1.J0",
                "swing.Jy1.g32.174",
                "swing.Jy1.dJ_dtau",
                "swing.Jy1.dJ_dL",
                "swing.Jy1.u",
            ],
            [
                "swing.Jy2",
                "swing.Jy2.J0",
                "swing.Jy2.g32.174",
                "swing.Jy2.dJ_dtau",
                "swing.Jy2.dJ_dL",
                "swing.Jy2.u",
            ],
            [
                "swing.Jx",
                "swing.Jx.J0",
                "swing.Jx.g32.174",
                "swing.Jx.dJ_dtau",
                "swing.Jx.dJ_dL",
                "swing.Jx.u",
            ],
        ];
        self.geometry
            .swing_tests
            .iter()
            .zip(NAMES)
            .flat_map(|(test, [j, j0, standard, per_period, per_length, u])| {
                let swing = Swing {
                    weight: self.vehicle.weight,
                    length: test.length,
                    period: test.period,
                    gravity: self.geometry.gravity,
                };
                let by_standard_gravity = Swing {
                    gravity: 32.174 * FOOT,
                    ..swing
                };
                [
                    (j, swing.inertia() / FOOT_POUND),
                    (j0, swing.about_the_pivot() / FOOT_POUND),
                    (standard, by_standard_gravity.inertia() / FOOT_POUND),
                    (per_period, swing.per_period() / FOOT_POUND),
                    (per_length, swing.per_length() * INCH / FOOT_POUND),
                    (
                        u,
                        swing.uncertainty(test.period_uncertainty, test.length_uncertainty)
                            / FOOT_POUND,
                    ),
                ]
            })
            .collect()
    }

    /// Main quantities in SI units, converted from the printed quantities.
    fn metric(&self) -> Recomputed {
        let table_1 = |name: &str| self.printed(&format!("Tab1.{name}.dim"));
        // Table 3 and p. 48 [ft lbf s]: By rounded, and with rate feedback of 2 on Ky = 0.14.
        let b_y = to_decimals(self.printed("damp.By_lin"), 2);
        let b_eff = b_y + 2.0 * self.printed("Ky");
        vec![
            ("SI.L", self.vehicle.reference_length),
            ("SI.BG", self.vehicle.restoring_arm),
            ("SI.mass", self.printed("F23.mass") * SLUG),
            ("SI.m_ref", self.vehicle.reference_mass),
            ("SI.F_ref", self.printed("Tab2.ref_force") * POUND_FORCE),
            ("SI.Jy", table_1("Iy-Mqdot") * FOOT_POUND),
            ("SI.By", b_y * FOOT_POUND),
            ("SI.Beff", b_eff * FOOT_POUND),
            ("SI.Mdelta", -table_1("Mdelta") * FOOT_POUND),
            ("SI.Ky", self.printed("Ky") * FOOT_POUND),
            ("SI.Kx", self.printed("Kx") * FOOT_POUND),
            ("SI.Zw", -table_1("Zw") * POUND_FORCE / FOOT),
            ("SI.Zdelta", table_1("Zdelta") * POUND_FORCE),
        ]
    }
}
