//! Numbers of Tables 3-1 and 4-1, and numbers that follow from them by algebra.

use crate::book::Recomputed;
use crate::ibm_1966::autopilot::{COMPENSATION, PULSE};
use crate::ibm_1966::missile::Surrogate;
use planesman_hydraulics::ActuatorSet;
use planesman_hydraulics::actuator_file::{ActuatorFileError, load};
use planesman_units::{DEGREE, INCH, POUND_FORCE as POUND, PSI};

const CUBIC_INCH: f64 = INCH * INCH * INCH;
/// q_LC of both tables, in^3/s.
const CONSTANT_LEAKAGE: f64 = -0.006;
/// Pressure maintained by the auxiliary pistons of both actuators, relative to the middle, psi.
const AUXILIARY: f64 = 750.0;
/// Inches per foot: a slug is one lbf s^2/ft.
const FOOT: f64 = 12.0;

/// Values of the tables, and derived values.
///
/// # Errors
/// [`ActuatorFileError`] if a built-in actuator cannot be read.
pub(super) fn recomputed() -> Result<Recomputed, ActuatorFileError> {
    let (hardware, polaris, auv) = (load("table_3_1")?, load("table_4_1")?, load("auv")?);
    let mut all = table("T3-1", &hardware);
    all.extend(table("T4-1", &polaris));
    all.extend(implied("chk.T3-1", &hardware));
    all.extend(implied("chk.T4-1", &polaris));
    all.extend(pressures(&hardware, &polaris));
    all.extend(pulses(&polaris));
    for viscous in [6.0, 18.0] {
        let mut set = hardware.clone();
        set.load.viscous = viscous * POUND / INCH;
        let (plus, minus) = set.force_limits();
        all.push((format!("chk.T3-1.slew_force_plus_C{viscous}"), plus / INCH));
        all.push((
            format!("chk.T3-1.slew_force_minus_C{viscous}"),
            minus / INCH,
        ));
    }
    all.push(("AUV.quantum".into(), auv.plane_quantum() / DEGREE));
    all.push((
        "AUV.slew".into(),
        auv.slew_rate() / auv.load.moment_arm / DEGREE,
    ));
    all.extend(surrogates());
    Ok(all)
}

/// Values of a parameter table, in its units.
fn table(name: &str, set: &ActuatorSet) -> Recomputed {
    let symmetric = set.oil.clamp_positive == set.oil.clamp_negative;
    let clamps = if symmetric {
        vec![("P_m", set.oil.clamp_positive / PSI)]
    } else {
        vec![
            ("P_m_plus", set.oil.clamp_positive / PSI),
            ("P_m_minus", -set.oil.clamp_negative / PSI),
        ]
    };
    // Table 3-1's actuator leaks its q_LC*, Table 4-1's its q_LC.
    let constant_leakage = if symmetric { "q_LC" } else { "q_LC_star" };
    let mut values = vec![
        ("dF", set.load.coulomb / POUND),
        ("M", set.load.mass * INCH / POUND),
        ("R", set.load.moment_arm / INCH),
        ("beta_V", set.oil.stiffness * CUBIC_INCH / PSI),
        ("C", set.load.viscous * INCH / POUND),
        ("q_L", set.rate_gain / CUBIC_INCH),
        (constant_leakage, set.error_rate / CUBIC_INCH),
        ("V_cb", set.volume / CUBIC_INCH),
        ("f_c", 1.0 / set.cycle()),
        ("T_v", set.valve_time),
        ("T_f", set.flow_time),
        ("P_r", set.oil.return_pressure / PSI),
        ("P_h", set.oil.supply / PSI),
        ("A_L", set.area / (INCH * INCH)),
        ("ratio_AL_AR", set.area_ratio),
        ("e_b", set.threshold / DEGREE),
        ("delta_b", set.quantum / DEGREE),
        ("K", COMPENSATION),
    ];
    values.extend(clamps);
    named(name, values)
}

/// Values derived from a parameter table.
fn implied(name: &str, set: &ActuatorSet) -> Recomputed {
    let (plus, minus) = set.force_limits();
    let degrees = |flow: f64| flow * CUBIC_INCH / (set.area * set.load.moment_arm) / DEGREE;
    named(
        name,
        vec![
            ("quantum_X", set.ram_quantum() / INCH),
            ("quantum_deg", set.plane_quantum() / DEGREE),
            ("omega_n", set.natural_frequency()),
            ("zeta_leak", set.leakage_damping()),
            ("stiffness", set.column_stiffness() * INCH / POUND),
            ("stiction_band_X", set.stiction_band() / INCH),
            ("slew_pulse", set.slew_rate() / INCH),
            (
                "slew_pulse_deg",
                set.slew_rate() / set.load.moment_arm / DEGREE,
            ),
            ("slew_force_plus", plus / INCH),
            ("slew_force_minus", minus / INCH),
            ("P_L0", set.resting_pressure() / PSI),
            ("K_L", set.drift_rate() / DEGREE),
            ("delta_LC", degrees(CONSTANT_LEAKAGE)),
            ("kP", set.pressure_leakage() * PSI / CUBIC_INCH),
            ("P_leak_decay", set.pressure_leakage() * set.oil.stiffness),
        ],
    )
}

/// Resting pressures, related pressures of the clamps, and q_LC*.
fn pressures(hardware: &ActuatorSet, polaris: &ActuatorSet) -> Recomputed {
    let middle = 0.5 * (polaris.oil.supply + polaris.oil.return_pressure) / PSI;
    let above = hardware.resting_pressure() / PSI - middle;
    let span = (hardware.oil.supply - hardware.oil.return_pressure) / PSI;
    let shift = 2.0 / span * above * hardware.rate_gain / CUBIC_INCH;
    vec![
        ("chk.mid_pressure".into(), middle),
        ("chk.P_m_plus_from_750".into(), AUXILIARY - above),
        ("chk.P_m_minus_from_750".into(), -AUXILIARY - above),
        (
            "chk.a3_over_A3".into(),
            (middle - AUXILIARY) * PSI / polaris.oil.supply,
        ),
        (
            "chk.qLC_star_formula_as_printed".into(),
            CONSTANT_LEAKAGE + shift,
        ),
        (
            "chk.qLC_from_qLCstar_physical".into(),
            hardware.error_rate / CUBIC_INCH + shift,
        ),
    ]
}

/// Pulses, their flow and power, and constants of the autopilot.
fn pulses(polaris: &ActuatorSet) -> Recomputed {
    let cycle = polaris.cycle();
    let own = (cycle - polaris.valve_time) / polaris.flow_time * polaris.volume / CUBIC_INCH;
    let power = |frequency: f64| {
        let energy = polaris.ram_quantum() * polaris.area * polaris.resting_pressure();
        energy * frequency / (INCH * POUND)
    };
    let pulse = PULSE / DEGREE;
    vec![
        ("chk.T".into(), cycle),
        (
            "chk.e_b".into(),
            0.5 * (polaris.quantum + polaris.quantum / 4.0) / DEGREE,
        ),
        ("chk.K_2".into(), pulse),
        ("chk.K_2_percent".into(), 100.0 * pulse / (12.0 * pulse)),
        ("chk.K_i".into(), COMPENSATION / cycle),
        (
            "chk.M_slugs".into(),
            polaris.load.mass * INCH / POUND * FOOT,
        ),
        ("chk.dV1".into(), own),
        ("chk.dV2".into(), polaris.volume / CUBIC_INCH - own),
        (
            "chk.delay_small_signal".into(),
            polaris.delay() + 0.5 * polaris.flow_time + 0.5 * cycle,
        ),
        ("chk.power_f6".into(), power(6.0)),
        ("chk.power_f82.5".into(), power(1.0 / cycle)),
        (
            "chk.power_note_nozzle_osc".into(),
            polaris.plane_quantum() / DEGREE,
        ),
    ]
}

fn surrogates() -> Recomputed {
    [Surrogate::Ps2, Surrogate::Ps1]
        .into_iter()
        .flat_map(|surrogate| {
            let plant = surrogate.plant();
            named(
                &surrogate.to_string(),
                vec![
                    ("Ka", surrogate.attitude_gain()),
                    ("Kr", surrogate.rate_gain()),
                    ("md", plant.nozzle_moment),
                    ("mb", plant.sideslip_moment),
                    ("rmax", surrogate.analog_rate_limit() / DEGREE),
                ],
            )
        })
        .collect()
}

fn named(family: &str, values: Vec<(&str, f64)>) -> Recomputed {
    values
        .into_iter()
        .map(|(name, value)| (format!("{family}.{name}"), value))
        .collect()
}
