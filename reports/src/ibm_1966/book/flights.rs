//! Numbers of Tables 2-1, 3-2, 4-2 and 4-3 and of the limit cycles of Section IV, from simulated flights.

use crate::book::Recomputed;
use crate::ibm_1966::case::Case;
use crate::ibm_1966::missile::Surrogate;
use crate::ibm_1966::procedure::{
    ANALOG_GAIN_TESTS, GAIN_STEP, LimitCycle, analog_gain_limit, analog_step_limit,
};
use crate::ibm_1966::tables::{Outcome, Row, TABLE_2_1, TABLE_3_2, TABLE_4_2};
use planesman_hydraulics::actuator_file::ActuatorFileError;
use planesman_units::DEGREE;

/// Values of the tables, and the limit cycles.
///
/// # Errors
/// [`ActuatorFileError`] if a built-in actuator cannot be read.
pub(super) fn recomputed() -> Result<Recomputed, ActuatorFileError> {
    let mut all = Recomputed::new();
    for surrogate in [Surrogate::Ps2, Surrogate::Ps1] {
        let hardware = Case::table_3_1(surrogate)?;
        let polaris = Case::table_4_1(surrogate)?;
        all.extend(table(surrogate, "T2-1", &TABLE_2_1, &polaris));
        all.extend(table(surrogate, "T4-2", &TABLE_4_2, &polaris));
        all.extend(table(surrogate, "T3-2", &TABLE_3_2, &hardware));
        all.extend(table(
            surrogate,
            "T3-2adj",
            &TABLE_3_2,
            &hardware.adjusted(),
        ));
        for (name, row) in [
            ("base", 0),
            ("noleak", 3),
            ("worst", 4),
            ("K16", 5),
            ("K5", 6),
            ("K9", 7),
        ] {
            let cycle = TABLE_4_2[row].of(&polaris).limit_cycle();
            all.extend(limit_cycle(&format!("{surrogate}.lc.{name}"), &cycle));
            if surrogate == Surrogate::Ps2 {
                all.extend(printed_of_limit_cycle(name, &cycle));
            }
        }
    }
    all.extend(phase_1());
    Ok(all)
}

/// Rows of a table. Flights of the default surrogate are compared with the printed ones.
fn table(surrogate: Surrogate, name: &str, rows: &[Row], base: &Case) -> Recomputed {
    let family = match (surrogate, name) {
        (Surrogate::Ps2, "T2-1" | "T3-2" | "T4-2") => name.to_owned(),
        _ => format!("{surrogate}.{name}"),
    };
    rows.iter()
        .flat_map(|row| {
            let Outcome { plus, minus, gain } = row.of(base).outcome();
            [
                ("max_pos_step", f64::from(plus)),
                ("max_neg_step", f64::from(minus)),
                ("Kg_stable", gain),
                ("Kg_unstable", gain + GAIN_STEP),
            ]
            .map(|(what, value)| (format!("{family}.{}.{what}", row.id), value))
        })
        .collect()
}

fn limit_cycle(family: &str, cycle: &LimitCycle) -> Recomputed {
    vec![
        (format!("{family}.yaw_pp"), cycle.yaw / DEGREE),
        (format!("{family}.yaw_mean"), cycle.mean_yaw / DEGREE),
        (format!("{family}.nozzle_pp"), cycle.nozzle / DEGREE),
        (format!("{family}.pulses"), cycle.pulses),
    ]
}

/// Limit cycles of Section IV.B.
fn printed_of_limit_cycle(name: &str, cycle: &LimitCycle) -> Recomputed {
    let yaw = cycle.yaw / DEGREE;
    match name {
        "base" => vec![
            ("T4.psi_pp_leak".into(), yaw),
            ("T4.f0_high".into(), cycle.pulses),
            ("T4.nozzle_osc".into(), cycle.nozzle / DEGREE),
        ],
        "noleak" => vec![
            ("T4.psi_pp_noleak".into(), yaw),
            ("T4.f0_low".into(), cycle.pulses),
        ],
        "K9" => vec![("T4.psi_pp_K9".into(), yaw)],
        _ => Recomputed::new(),
    }
}

/// Table 4-3: largest stable step and gain, and the first unstable step and gain.
fn phase_1() -> Recomputed {
    let surrogate = Surrogate::Ps2;
    let step = f64::from(analog_step_limit(surrogate));
    let mut all = vec![
        ("T4-3.C-14".to_owned(), step),
        ("T4-3.C-15".to_owned(), step + 1.0),
    ];
    for test in ANALOG_GAIN_TESTS {
        let stable = analog_gain_limit(surrogate, test.gain_step, test.steering);
        all.push((format!("T4-3.{}A", test.run), stable));
        all.push((format!("T4-3.{}B", test.run), stable + test.gain_step));
    }
    all
}
