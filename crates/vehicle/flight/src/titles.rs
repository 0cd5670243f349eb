//! Display names of quantities. Columns and fields have names for programs: `settling_time_5 [s]` is displayed as
//! `Settling time (5 %) [s]`.

/// Names of columns and fields without units, and their display names.
const TITLES: [(&str, &str); 45] = [
    // A flight, as `planesman sweep` and `planesman report` tell it.
    ("depth_setpoint", "depth setpoint"),
    ("rise_time", "rise time (10-90 %)"),
    ("overshoot", "overshoot"),
    ("settling_time_2", "settling time (2 %)"),
    ("settling_time_5", "settling time (5 %)"),
    ("steady_error", "steady error"),
    ("itae", "time-weighted absolute error (ITAE)"),
    ("plane_travel", "plane travel"),
    ("test_signal", "test signal"),
    ("pulses", "actuator pulses"),
    ("hydraulic_work", "hydraulic work"),
    ("energy_supply", "energy of the supply"),
    ("energy_switching", "energy of the solenoids"),
    ("energy_load", "work on the load"),
    ("energy_friction", "energy lost to friction"),
    ("energy_stops", "energy lost to the stops"),
    ("energy_throttling", "energy lost to throttling"),
    ("energy_leakage", "energy lost to leakage"),
    ("energy_compression", "energy in the compressed oil"),
    ("energy_auxiliary", "energy in the auxiliary pistons"),
    (
        "energy_proportional_valve",
        "energy of an ideal proportional valve",
    ),
    ("efficiency", "actuator efficiency"),
    ("efficiency_proportional", "efficiency, proportional valve"),
    ("samples", "samples of the model"),
    ("fit", "one-step fit"),
    ("steady_state_gain", "steady-state gain"),
    ("first_markov_parameter", "first Markov parameter"),
    ("held_ticks", "ticks without the actuator's answer"),
    ("pole_error", "error of the dominant pole"),
    // Its signals, as `planesman sim --out FLIGHT.csv` names them.
    ("time", "time"),
    ("depth", "depth"),
    ("depth_rate", "depth rate"),
    ("distance", "distance"),
    ("pitch", "pitch"),
    ("pitch_rate", "pitch rate"),
    ("surge", "speed through the water"),
    ("heave", "heave velocity"),
    ("dive_planes", "dive plane angle"),
    ("plane_command", "plane command"),
    ("pitch_command", "pitch command"),
    ("identification", "test signal"),
    ("ram", "ram position"),
    ("pressure", "actuator pressure"),
    ("depth_pressure", "pressure at the depth cell"),
    ("gyro_pitch_rate", "pitch rate of the gyro"),
];

/// Display name of a quantity within a sentence or table, followed by the unit in its column name; an unknown name stays unchanged.
#[must_use]
pub fn name(column: &str) -> String {
    let (field, unit) = match column.split_once(" [") {
        Some((field, _)) => (field, &column[field.len()..]),
        None => (column, ""),
    };
    let known = TITLES.iter().find(|(it, _)| *it == field);
    match known {
        // A count has no unit.
        Some((_, name)) => format!("{name}{}", if unit == " [1]" { "" } else { unit }),
        None => column.to_owned(),
    }
}

/// Display name as a title, with a capital letter.
#[must_use]
pub fn title(column: &str) -> String {
    let name = name(column);
    if name == column {
        return name;
    }
    let mut letters = name.chars();
    letters.next().map_or_else(String::new, |first| {
        first.to_uppercase().chain(letters).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_has_a_name_for_people_with_its_unit() {
        assert_eq!(title("settling_time_5 [s]"), "Settling time (5 %) [s]");
        assert_eq!(name("plane_travel [rad]"), "plane travel [rad]");
        assert_eq!(title("pulses [1]"), "Actuator pulses");
        assert_eq!(title("steady_state_gain"), "Steady-state gain");
    }

    #[test]
    fn another_name_stays_as_it_is() {
        for other in ["u", "/auv/imu:angular_velocity.y", "speed_kn", "y [V]", ""] {
            assert_eq!(title(other), other);
        }
    }

    #[test]
    fn every_column_of_a_flights_table_has_a_name() {
        for (column, ..) in crate::sink::COLUMNS {
            let field = column.split(" [").next().unwrap_or_default();
            assert!(TITLES.iter().any(|(it, _)| *it == field), "{column}");
        }
    }
}
