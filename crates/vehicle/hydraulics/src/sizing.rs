//! Sizing: derived quantities of an actuator, and an actuator for a load.
//!
//! The formulas are taken from IBM 66-L03-005, Sections II and III and the list of symbols, next to Tables 3-1 and 4-1; most are methods of
//! [`ActuatorSet`]. The actuator for a load is computed by inverting them:
//!
//! ```text
//! V_c = A_L R delta_q,   f_c = slew/delta_q,   T_f = 0.85 (T - T_v)          one volume in each cycle, no overlap
//! A_L/A_R = 2 P_h/(P_h + P_R)                                                equal force both ways
//! P_m = 0.75 (P_h - P_R)/2,   A_L >= (Delta F + 2 C R slew)/P_m              twice the rate within the force
//! Delta F/(A_L^2 beta/V) <= R delta_q/4                                      stiction within a quarter quantum
//! e_b = (delta_q + delta_q/4)/2                                              a quarter quantum of hysteresis
//! ```
//! 0.75 is the value of Table 4-1, and its stiction is within a sixth. The Polaris actuator has barely the force for its slew rate, and is
//! slower for that reason; here the force is twice as large.

use crate::actuator_file::SWITCHING_ENERGY;
use crate::actuator_set::{ActuatorSet, LimitOption, Oil, RamLoad};
use crate::linearised::dead_time;
use planesman_units::{DEGREE, INCH, POUND_FORCE as POUND, PSI};

/// Watts per horsepower: 6600 in lb/s.
pub const HORSEPOWER: f64 = 6600.0 * INCH * POUND;

/// Clamp pressure as a share of half the pressure difference.
const CLAMP_SHARE: f64 = 0.75;
/// Ratio of the force to the force needed for slewing.
const FORCE_MARGIN: f64 = 2.0;
/// Largest rest error of the load caused by stiction, as a share of a quantum.
const STICTION_SHARE: f64 = 0.25;
/// T_f as a share of the cycle time that remains after T_v.
const FLOW_SHARE: f64 = 0.85;

/// A load and its requirements; SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load {
    /// M at the ram, kg.
    pub mass: f64,
    /// C at the ram, N s/m.
    pub viscous: f64,
    /// Delta F at the ram, N.
    pub coulomb: f64,
    /// R, m.
    pub moment_arm: f64,
    /// Stroke to either side, rad.
    pub stroke: f64,
    /// delta_q, rad.
    pub resolution: f64,
    /// rad/s
    pub slew: f64,
    /// P_h, Pa.
    pub supply: f64,
    /// P_R, Pa.
    pub return_pressure: f64,
    /// beta/V, Pa/m^3.
    pub stiffness: f64,
    /// T_v, s.
    pub valve_time: f64,
}

/// The load for which no actuator can be sized.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SizingError {
    /// The quantity is not positive.
    #[error("{0}: '{1}' refused: it must be positive")]
    NotPositive(&'static str, f64),
    /// The valves are too slow for the volume rate.
    #[error(
        "a resolution of {:.4} deg at {:.3} deg/s needs {:.3} volumes per second, but valves of {:.2} ms allow fewer than {:.3}. Use a coarser resolution, a slower slew rate, or two volumes",
        .resolution / DEGREE,
        .slew / DEGREE,
        .slew / .resolution,
        .valve_time * 1e3,
        1.0 / .valve_time
    )]
    ValvesTooSlow {
        /// rad
        resolution: f64,
        /// rad/s
        slew: f64,
        /// s
        valve_time: f64,
    },
}

/// Sizes a tight single-speed actuator for a load.
///
/// # Errors
/// [`SizingError`].
pub fn for_load(load: &Load) -> Result<ActuatorSet, SizingError> {
    for (what, value) in [
        ("mass", load.mass),
        ("viscous", load.viscous),
        ("moment arm", load.moment_arm),
        ("stroke", load.stroke),
        ("resolution", load.resolution),
        ("slew", load.slew),
        ("stiffness", load.stiffness),
        ("supply above return", load.supply - load.return_pressure),
    ] {
        if !(value.is_finite() && value > 0.0) {
            return Err(SizingError::NotPositive(what, value));
        }
    }
    let hertz = load.slew / load.resolution;
    let flow_time = FLOW_SHARE * (1.0 / hertz - load.valve_time);
    let millihertz = (1000.0 * hertz).round();
    if flow_time <= 0.0 || !(1.0..=f64::from(u32::MAX)).contains(&millihertz) {
        return Err(SizingError::ValvesTooSlow {
            resolution: load.resolution,
            slew: load.slew,
            valve_time: load.valve_time,
        });
    }
    let clamp = CLAMP_SHARE * 0.5 * (load.supply - load.return_pressure);
    let speed = load.slew * load.moment_arm;
    let travel = |angle: f64| angle * load.moment_arm;
    let for_force = (load.coulomb + FORCE_MARGIN * load.viscous * speed) / clamp;
    let column = load.coulomb / (STICTION_SHARE * travel(load.resolution));
    let area = for_force.max((column / load.stiffness).sqrt());
    Ok(ActuatorSet {
        name: "sized for a load".to_owned(),
        source: "the formulas of IBM 66-L03-005 (1966), solved for the dimensions".to_owned(),
        load: RamLoad {
            mass: load.mass,
            viscous: load.viscous,
            coulomb: load.coulomb,
            moment_arm: load.moment_arm,
        },
        area,
        area_ratio: 2.0 * load.supply / (load.supply + load.return_pressure),
        volume_limit: area * travel(1.07 * load.stroke),
        stop: travel(1.1 * load.stroke),
        oil: Oil {
            stiffness: load.stiffness,
            supply: load.supply,
            return_pressure: load.return_pressure,
            clamp_positive: clamp,
            clamp_negative: clamp,
        },
        volume: area * travel(load.resolution),
        frequency_millihertz: millihertz as u32,
        valve_time: load.valve_time,
        flow_time,
        extra_delay: 0.0,
        switching_energy: SWITCHING_ENERGY,
        rate_gain: 0.0,
        error_rate: 0.0,
        quantum: load.resolution,
        threshold: 0.625 * load.resolution,
        small: None,
        inhibit_beyond: travel(load.stroke),
        limit_option: LimitOption::Unaware,
    })
}

/// W = X_1 A_L P_h (A_R/A_L) f, W: power of the supply for `frequency` volumes per second, each moving the ram by one quantum (the report's
/// list of symbols, with f_c as the actuation rate).
#[must_use]
pub fn power(set: &ActuatorSet, frequency: f64) -> f64 {
    set.volume * set.resting_pressure() * frequency
}

/// A size in SI, and in the report's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Size {
    /// Quantity with its symbol.
    pub quantity: &'static str,
    /// Value in the SI unit.
    pub value: f64,
    /// SI unit; empty if dimensionless.
    pub unit: &'static str,
    /// The report's unit expressed in the SI unit.
    pub report_size: f64,
    /// The report's unit.
    pub report_unit: &'static str,
}

/// All sizes of an actuator, in reading order.
#[must_use]
pub fn sizes(set: &ActuatorSet) -> Vec<Size> {
    const IN3: f64 = INCH * INCH * INCH;
    let size = |quantity, value, (unit, report_size, report_unit)| Size {
        quantity,
        value,
        unit,
        report_size,
        report_unit,
    };
    let none = ("", 1.0, "");
    let volume = ("m^3", IN3, "in^3");
    let length = ("m", INCH, "in");
    let speed = ("m/s", INCH, "in/s");
    let angle = ("rad", DEGREE, "deg");
    let rate = ("rad/s", DEGREE, "deg/s");
    let force = ("N", POUND, "lb");
    let time = ("s", 1e-3, "ms");
    let watts = ("W", HORSEPOWER, "hp");
    let (plus, minus) = set.force_limits();
    let zeta = set.damping_ratio();
    vec![
        size("quantum of oil V_c", set.volume, volume),
        size("quantum at the ram V_c/A_L", set.ram_quantum(), length),
        size("quantum at the planes", set.plane_quantum(), angle),
        size("plane angle counted for it delta_b", set.quantum, angle),
        size("dead zone +-e_b", set.threshold, angle),
        size(
            "stiction band +-Delta F/(A_L^2 beta/V)",
            set.stiction_band(),
            length,
        ),
        size(
            "  at the planes",
            set.stiction_band() / set.load.moment_arm,
            angle,
        ),
        size("slew rate V_c f_c/A_L", set.slew_rate(), speed),
        size(
            "  at the planes",
            set.slew_rate() / set.load.moment_arm,
            rate,
        ),
        size("force-limited rate, positive", plus, speed),
        size("force-limited rate, negative", minus, speed),
        size(
            "  smaller one divided by the slew rate",
            plus.min(-minus) / set.slew_rate(),
            none,
        ),
        size(
            "most force, positive",
            set.oil.clamp_positive * set.area,
            force,
        ),
        size(
            "most force, negative",
            set.oil.clamp_negative * set.area,
            force,
        ),
        size(
            "resting pressure P_L0",
            set.resting_pressure(),
            ("Pa", PSI, "psi"),
        ),
        size(
            "column stiffness A_L^2 beta/V",
            set.column_stiffness(),
            ("N/m", POUND / INCH, "lb/in"),
        ),
        size(
            "natural frequency omega_n",
            set.natural_frequency(),
            ("rad/s", std::f64::consts::TAU, "Hz"),
        ),
        size("damping ratio zeta", zeta, none),
        size("  with leakage", zeta + set.leakage_damping(), none),
        size("drift K_L, with the sign valve", set.drift_rate(), rate),
        size(
            "constant drift delta_LC",
            set.error_rate / (set.area * set.load.moment_arm),
            rate,
        ),
        size("valve cycle T", set.cycle(), time),
        size("dead time tau", dead_time(set), time),
        size(
            "commands in flight m",
            set.commands_in_flight() as f64,
            none,
        ),
        size("power, slewing", power(set, 1.0 / set.cycle()), watts),
        size("power, one volume a second", power(set, 1.0), watts),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::actuator_file::load;

    /// A size in the report's unit.
    fn in_the_reports_unit(set: &ActuatorSet, quantity: &str) -> f64 {
        let size = sizes(set)
            .into_iter()
            .find(|size| size.quantity == quantity)
            .unwrap();
        size.value / size.report_size
    }

    #[test]
    fn the_sizes_of_tables_3_1_and_4_1() {
        for (quantity, hardware, polaris) in [
            ("quantum of oil V_c", 0.152, 0.152),
            ("quantum at the ram V_c/A_L", 0.152_917_5, 0.152),
            ("quantum at the planes", 1.078_341_9, 1.088_63),
            ("plane angle counted for it delta_b", 1.09, 1.09),
            (
                "stiction band +-Delta F/(A_L^2 beta/V)",
                0.014_458_7,
                0.022_556_4,
            ),
            ("slew rate V_c f_c/A_L", 12.615_69, 12.54),
            ("force-limited rate, positive", 13.063_33, 12.5),
            ("force-limited rate, negative", -47.853_33, -12.5),
            ("resting pressure P_L0", 1_339.622_6, 1_129.973_5),
            ("column stiffness A_L^2 beta/V", 26_281.8, 26_600.0),
            ("natural frequency omega_n", 51.603_3, 47.711),
            ("damping ratio zeta", 0.074_02, 0.067_6),
            ("drift K_L, with the sign valve", 0.759_096, 0.766_331),
            ("dead time tau", 16.560_6, 16.560_6),
            ("commands in flight m", 1.0, 1.0),
        ] {
            for (name, expected) in [("table_3_1", hardware), ("table_4_1", polaris)] {
                let found = in_the_reports_unit(&load(name).unwrap(), quantity);
                assert!(
                    (found / expected - 1.0).abs() < 5e-4,
                    "{name} {quantity}: {found} for {expected}"
                );
            }
        }
    }

    #[test]
    fn the_power_of_polaris_at_6_at_11_and_at_82_volumes_a_second() {
        let polaris = load("table_4_1").unwrap();
        for (hertz, watts, horses) in [
            (6.0, 116.5, 0.156),
            (11.0, 213.5, 0.286),
            (82.5, 1601.0, 2.147),
        ] {
            let found = power(&polaris, hertz);
            assert!((found / watts - 1.0).abs() < 5e-3, "{found}");
            assert!((found / HORSEPOWER / horses - 1.0).abs() < 5e-3, "{found}");
        }
    }

    fn dive_planes() -> Load {
        let auv = load("auv").unwrap();
        Load {
            mass: auv.load.mass,
            viscous: auv.load.viscous,
            coulomb: auv.load.coulomb,
            moment_arm: auv.load.moment_arm,
            stroke: 30.0 * DEGREE,
            resolution: 0.5 * DEGREE,
            slew: 40.0 * DEGREE,
            supply: auv.oil.supply,
            return_pressure: auv.oil.return_pressure,
            stiffness: auv.oil.stiffness,
            valve_time: auv.valve_time,
        }
    }

    #[test]
    fn the_dive_planes_get_an_actuator_like_theirs_but_slimmer() {
        let auv = load("auv").unwrap();
        let sized = for_load(&dive_planes()).unwrap();
        assert_eq!(sized.frequency_millihertz, 80_000);
        assert!((sized.plane_quantum() / (0.5 * DEGREE) - 1.0).abs() < 1e-12);
        assert!((sized.area_ratio / auv.area_ratio - 1.0).abs() < 1e-12);
        assert_eq!(sized.commands_in_flight(), 0);
        // Here the oil column decides: stiff enough against the seal's friction.
        assert!((sized.stiction_band() / sized.ram_quantum() - 0.25).abs() < 1e-9);
        let (plus, minus) = sized.force_limits();
        assert!(plus / sized.slew_rate() > 2.0 && plus == -minus);
        assert!(sized.area < auv.area && sized.area > 0.9 * auv.area);
    }

    #[test]
    fn a_smooth_load_gets_the_area_that_its_slewing_takes() {
        let smooth = Load {
            coulomb: 0.0,
            ..dive_planes()
        };
        let sized = for_load(&smooth).unwrap();
        assert!((sized.force_limits().0 / sized.slew_rate() - 2.0).abs() < 1e-9);
    }

    #[test]
    fn valves_that_cannot_follow_are_an_error() {
        let fine = Load {
            resolution: 0.1 * DEGREE,
            ..dive_planes()
        };
        let refusal = for_load(&fine).unwrap_err().to_string();
        assert!(refusal.contains("400.000 volumes per second"), "{refusal}");
        let still = Load {
            slew: 0.0,
            ..dive_planes()
        };
        assert_eq!(
            for_load(&still).unwrap_err(),
            SizingError::NotPositive("slew", 0.0)
        );
    }
}
