//! The readings of the instruments' topics: gyro, depth and speed for one stamp.
//!
//! ```text
//! q = -omega_y            REP 103's base_link has y to port: a rising bow turns backwards about it
//! z = (p - p_0) / (rho g)
//! U = sqrt(2 dp / rho)    of the speed cell's stagnation less static pressure
//! ```
//! The report's speed cell is also affected by pitch through its dry lines, and ends at 2.07 ft/s (Brunner, NPS thesis, 1988, pp. 68 f.);
//! the thesis used a stopwatch, and the default here is a nominal speed.

use planesman_msgs::sensor_msgs::msg::{FluidPressure, Imu};

use super::motion::Measurement;

/// Constants to compute depth and speed from pressures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Calibration {
    /// rho, kg/m^3.
    pub density: f64,
    /// g, m/s^2.
    pub gravity: f64,
    /// p_0, Pa: the pressure at the surface.
    pub surface_pressure: f64,
    /// Readings deeper than this are ignored, m; 0 for no limit.
    pub depth_range: f64,
    /// The speed, m/s; with `None` the speed cell measures it.
    pub speed: Option<f64>,
}

/// The last reading of each topic, each with its stamp in ns.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Instruments {
    pitch_rate: Option<(i64, f64)>,
    depth_pressure: Option<(i64, f64)>,
    speed_pressure: Option<(i64, f64)>,
}

impl Instruments {
    /// Takes the gyro's reading.
    pub(crate) fn on_imu(&mut self, imu: &Imu) {
        keep(
            &mut self.pitch_rate,
            imu.header.stamp.nanos(),
            -imu.angular_velocity.y,
        );
    }

    /// Takes the depth cell's reading.
    pub(crate) fn on_depth_pressure(&mut self, pressure: &FluidPressure) {
        let stamp = pressure.header.stamp.nanos();
        keep(&mut self.depth_pressure, stamp, pressure.fluid_pressure);
    }

    /// Takes the speed cell's reading.
    pub(crate) fn on_speed_pressure(&mut self, pressure: &FluidPressure) {
        let stamp = pressure.header.stamp.nanos();
        keep(&mut self.speed_pressure, stamp, pressure.fluid_pressure);
    }

    /// Whether all needed readings for this stamp have been received.
    #[must_use]
    pub(crate) fn complete(&self, stamp: i64, calibration: &Calibration) -> bool {
        let read = |reading: Option<(i64, f64)>| reading.is_some_and(|(at, _)| at == stamp);
        read(self.pitch_rate)
            && read(self.depth_pressure)
            && (calibration.speed.is_some() || read(self.speed_pressure))
    }

    /// The measurement for a stamp: the last reading of gyro and speed, but only a depth with the same stamp.
    #[must_use]
    pub(crate) fn measurement(&self, stamp: i64, calibration: &Calibration) -> Measurement {
        let c = calibration;
        let last = |reading: Option<(i64, f64)>| reading.map_or(0.0, |(_, value)| value);
        let depth = self
            .depth_pressure
            .filter(|(at, _)| *at == stamp)
            .map(|(_, pressure)| (pressure - c.surface_pressure) / (c.density * c.gravity))
            .filter(|depth| c.depth_range == 0.0 || *depth < c.depth_range);
        Measurement {
            pitch_rate: last(self.pitch_rate),
            depth,
            speed: c
                .speed
                .unwrap_or_else(|| (2.0 * last(self.speed_pressure).max(0.0) / c.density).sqrt()),
        }
    }
}

/// Stores a finite reading; a clock set back begins a new run, so an earlier stamp is accepted too.
fn keep(place: &mut Option<(i64, f64)>, stamp: i64, value: f64) {
    if value.is_finite() {
        *place = Some((stamp, value));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_msgs::builtin_interfaces::msg::Time;

    const CALIBRATION: Calibration = Calibration {
        density: 1000.0,
        gravity: 10.0,
        surface_pressure: 1e5,
        depth_range: 2.0,
        speed: None,
    };

    fn read(depth: f64, stamp: i64) -> Instruments {
        let mut instruments = Instruments::default();
        let mut imu = Imu::default();
        imu.header.stamp = Time::from_nanos(stamp);
        imu.angular_velocity.y = -0.1;
        instruments.on_imu(&imu);
        let mut pressure = FluidPressure::default();
        pressure.header.stamp = Time::from_nanos(stamp);
        pressure.fluid_pressure = 1e5 + 1e4 * depth;
        instruments.on_depth_pressure(&pressure);
        pressure.fluid_pressure = 500.0 * 0.25;
        instruments.on_speed_pressure(&pressure);
        instruments
    }

    #[test]
    fn pressures_are_depth_and_speed_and_a_rising_bow_turns_positively() {
        let measured = read(1.5, 7).measurement(7, &CALIBRATION);
        assert!((measured.pitch_rate - 0.1).abs() < 1e-15);
        assert!((measured.speed - 0.5).abs() < 1e-12);
        assert!(measured.depth.is_some_and(|z| (z - 1.5).abs() < 1e-12));
    }

    #[test]
    fn beyond_its_range_and_for_another_stamp_there_is_no_depth() {
        assert_eq!(read(2.5, 7).measurement(7, &CALIBRATION).depth, None);
        assert_eq!(read(1.5, 7).measurement(8, &CALIBRATION).depth, None);
        assert!(read(1.5, 7).complete(7, &CALIBRATION));
        assert!(!read(1.5, 7).complete(8, &CALIBRATION));
    }

    #[test]
    fn a_reading_that_is_no_number_is_not_kept() {
        let mut instruments = read(1.5, 7);
        let before = instruments;
        let mut imu = Imu::default();
        imu.angular_velocity.y = f64::NAN;
        instruments.on_imu(&imu);
        assert_eq!(instruments, before);
    }
}
