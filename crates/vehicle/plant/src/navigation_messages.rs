//! Messages of the navigation instruments.

use planesman_msgs::{
    builtin_interfaces::msg::Time,
    geometry_msgs::msg::{
        Point, Pose, PoseWithCovariance, PoseWithCovarianceStamped, Twist, TwistWithCovariance,
        TwistWithCovarianceStamped,
    },
    loop_topics::Sink,
    sensor_msgs::msg::{MagneticField, NavSatFix, NavSatStatus, Range},
};

use crate::{
    frames::{Frames, TRUTH, diagonal, quaternion, vector},
    sensors::navigation::{
        BEAM_ANGLE, Dvl, DvlReading, Gps, GpsReading, Lock, Navigation, Readings, UsblReading,
    },
};

/// Frame of the altitude: its x axis points downwards in the body, as `sensor_msgs/Range` requires.
const ALTIMETER: &str = "altimeter";
/// Frame of the satellite receiver's antenna.
const GPS: &str = "gps";

/// Variance for components without a measurement, in messages that have no value for "unknown".
const UNKNOWN: f64 = 1e6;

/// Readings of these instruments in a tick; `None` for an instrument that is off or has no measurement.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NavigationMessages {
    /// Velocity over ground of the Doppler log, with bottom lock.
    pub dvl: Option<TwistWithCovarianceStamped>,
    /// The vehicle's velocity through the water, without bottom lock.
    pub dvl_water: Option<TwistWithCovarianceStamped>,
    /// The vehicle's distance to the bottom, with bottom lock.
    pub altitude: Option<Range>,
    /// Earth's field and the vehicle's own field.
    pub magnetic_field: Option<MagneticField>,
    /// Position of the antenna, or the status "no fix".
    pub gps: Option<NavSatFix>,
    /// Position sent by the ultra-short baseline, stamped with its time of validity.
    pub usbl: Option<PoseWithCovarianceStamped>,
}

impl NavigationMessages {
    /// One message for each topic of an enabled instrument.
    pub(crate) fn of_all_that_are_on(navigation: &Navigation) -> Self {
        fn on<M: Default>(rate: f64) -> Option<M> {
            (rate > 0.0).then(M::default)
        }
        Self {
            dvl: on(navigation.dvl.rate),
            dvl_water: on(navigation.dvl.rate),
            altitude: on(navigation.dvl.rate),
            magnetic_field: on(navigation.magnetometer.rate),
            gps: on(navigation.gps.rate),
            usbl: on(navigation.usbl.rate),
        }
    }

    pub(crate) fn new(frames: &Frames<'_>, readings: &Readings, navigation: &Navigation) -> Self {
        let twist = readings.dvl.map(|it| (it.lock, frames.twist(&it)));
        let (dvl, dvl_water) = match twist {
            Some((Lock::Bottom { .. }, twist)) => (Some(twist), None),
            Some((Lock::Water, twist)) => (None, Some(twist)),
            None => (None, None),
        };
        Self {
            dvl,
            dvl_water,
            altitude: (readings.dvl).and_then(|it| frames.altitude(it.lock, &navigation.dvl)),
            magnetic_field: readings.magnetic_field.map(|field| MagneticField {
                header: frames.header(frames.base_link()),
                magnetic_field: vector(field),
                magnetic_field_covariance: diagonal([navigation.magnetometer.noise; 3]),
            }),
            gps: readings.gps.map(|it| frames.fix(it, &navigation.gps)),
            usbl: readings.usbl.map(|it| frames.position(&it)),
        }
    }

    pub(crate) fn put_into<S: Sink>(&self, stamp: &Time, sink: &mut S) -> Result<(), S::Error> {
        if let Some(dvl) = &self.dvl {
            sink.put("dvl", stamp, dvl)?;
        }
        if let Some(dvl_water) = &self.dvl_water {
            sink.put("dvl_water", stamp, dvl_water)?;
        }
        if let Some(altitude) = &self.altitude {
            sink.put("altitude", stamp, altitude)?;
        }
        if let Some(magnetic_field) = &self.magnetic_field {
            sink.put("magnetic_field", stamp, magnetic_field)?;
        }
        if let Some(gps) = &self.gps {
            sink.put("gps", stamp, gps)?;
        }
        if let Some(usbl) = &self.usbl {
            sink.put("usbl", stamp, usbl)?;
        }
        Ok(())
    }
}

/// Frames of the enabled instruments: name, position in `base_link` \[m\] and quaternion (x, y, z, w).
pub(crate) fn mounts(navigation: &Navigation) -> Vec<(&'static str, [f64; 3], [f64; 4])> {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let altimeter = (ALTIMETER, [0.0; 3], [0.0, half, 0.0, half]);
    let gps = (
        GPS,
        [0.0, 0.0, navigation.gps.antenna],
        [0.0, 0.0, 0.0, 1.0],
    );
    [(navigation.dvl.rate, altimeter), (navigation.gps.rate, gps)]
        .into_iter()
        .filter_map(|(rate, mount)| (rate > 0.0).then_some(mount))
        .collect()
}

impl Frames<'_> {
    fn twist(&self, reading: &DvlReading) -> TwistWithCovarianceStamped {
        TwistWithCovarianceStamped {
            header: self.header(self.base_link()),
            twist: TwistWithCovariance {
                twist: Twist {
                    linear: vector(reading.velocity),
                    ..Twist::default()
                },
                covariance: of_the_first_three(reading.deviation),
            },
        }
    }

    fn altitude(&self, lock: Lock, dvl: &Dvl) -> Option<Range> {
        let Lock::Bottom { altitude } = lock else {
            return None;
        };
        Some(Range {
            header: self.header(self.named(ALTIMETER)),
            radiation_type: Range::ULTRASOUND,
            field_of_view: 2.0 * BEAM_ANGLE as f32,
            min_range: 0.0,
            max_range: dvl.range as f32,
            range: altitude as f32,
            variance: (dvl.altitude_noise * dvl.altitude_noise) as f32,
        })
    }

    fn fix(&self, reading: GpsReading, gps: &Gps) -> NavSatFix {
        let header = self.header(self.named(GPS));
        let status = |status| NavSatStatus {
            status,
            service: NavSatStatus::SERVICE_GPS,
        };
        let Some(place) = reading else {
            return NavSatFix {
                header,
                status: status(NavSatStatus::STATUS_NO_FIX),
                ..NavSatFix::default()
            };
        };
        NavSatFix {
            header,
            status: status(NavSatStatus::STATUS_FIX),
            latitude: place.latitude,
            longitude: place.longitude,
            altitude: place.altitude,
            position_covariance: diagonal(gps.deviation().map(known)),
            position_covariance_type: NavSatFix::COVARIANCE_TYPE_DIAGONAL_KNOWN,
        }
    }

    fn position(&self, reading: &UsblReading) -> PoseWithCovarianceStamped {
        let [x, y, z] = reading.position;
        let mut header = self.header(self.named("map"));
        header.stamp = Time::from_nanos(self.stamp.nanos() - reading.age);
        PoseWithCovarianceStamped {
            header,
            pose: PoseWithCovariance {
                pose: Pose {
                    position: Point { x, y, z },
                    orientation: quaternion([0.0, 0.0, 0.0, 1.0]),
                },
                covariance: of_the_first_three([reading.deviation; 3]),
            },
        }
    }
}

/// A standard deviation that a filter accepts; for a true value, the standard deviation of `odom`.
pub(crate) fn known(deviation: f64) -> f64 {
    deviation.max(TRUTH.sqrt())
}

/// The 6 x 6 covariance of three measured components with these standard deviations, and three that are not measured.
fn of_the_first_three(deviations: [f64; 3]) -> [f64; 36] {
    let mut covariance = [0.0; 36];
    for (i, deviation) in deviations.into_iter().enumerate() {
        let deviation = known(deviation);
        covariance[7 * i] = deviation * deviation;
        covariance[7 * (i + 3)] = UNKNOWN;
    }
    covariance
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Plant, PlantParameters};
    use planesman_msgs::Message;
    use planesman_parameters::{Parameters as _, Value};

    const ALL_ON: [(&str, f64); 6] = [
        ("sensors.dvl.rate", 20.0),
        ("sensors.magnetometer.rate", 20.0),
        ("sensors.gps.rate", 20.0),
        ("sensors.usbl.rate", 20.0),
        ("sensors.usbl.delay", 0.07),
        ("environment.bottom", 10.0),
    ];

    fn plant(changes: &[(&str, Value)]) -> Plant {
        let on = ALL_ON.map(|(name, value)| (name, Value::Double(value)));
        let attitude = ("sensors.attitude.enabled", Value::Bool(true));
        let all = [&on[..], &[attitude], changes].concat();
        let parameters = PlantParameters::default().with(&all).expect("valid");
        Plant::new(&parameters).expect("a plant")
    }

    fn fly(plant: &mut Plant, ticks: i64) -> Vec<crate::Observation> {
        (0..ticks)
            .map(|k| {
                let observation = plant.observe(Time::from_nanos(k * 50_000_000));
                plant.advance(None).expect("a tick");
                observation
            })
            .collect()
    }

    #[test]
    fn without_errors_they_tell_the_truth_with_variances_that_a_filter_takes() {
        let mut plant = plant(&[
            ("sensors.errors", Value::Bool(false)),
            ("initial_depth", Value::Double(1.0)),
            ("environment.current.y", Value::Double(0.2)),
        ]);
        let seen = fly(&mut plant, 10);
        let observation = &seen[9];
        let (truth, told) = (&observation.pose.odometry, &observation.instruments);
        let NavigationMessages {
            dvl,
            dvl_water,
            altitude,
            gps,
            usbl,
            ..
        } = &told.navigation;
        let dvl = &dvl.as_ref().expect("bottom lock").twist;
        let (found, expected) = (&dvl.twist.linear, &truth.twist.twist.linear);
        assert!((found.x - expected.x).abs() < 1e-15 && (found.y + 0.2).abs() < 1e-15);
        assert!((found.z - expected.z).abs() < 1e-15);
        for (i, value) in dvl.covariance.into_iter().enumerate() {
            let expected = match (i % 7, i / 7) {
                (0, 0..3) => 1e-9,
                (0, _) => 1e6,
                _ => 0.0,
            };
            assert!((value - expected).abs() < 1e-20, "{i} {value}");
        }
        assert_eq!(*dvl_water, None);
        let range = altitude.as_ref().expect("bottom lock").range;
        assert!((f64::from(range) - 9.0).abs() < 0.01, "{range}");
        assert_eq!(gps.as_ref().expect("a message").status.status, -1);
        // East is ahead: the orientation is that in `odom`.
        let (found, expected) = (&told.imu.orientation, &truth.pose.pose.orientation);
        assert!((found.y - expected.y).abs() < 1e-15 && (found.w - expected.w).abs() < 1e-15);
        assert!((told.imu.orientation_covariance[8] - 1e-9).abs() < 1e-20);
        // Of the tick 0.1 s before.
        let usbl = usbl.as_ref().expect("a position");
        assert_eq!(usbl.header.stamp.nanos(), 350_000_000);
        assert_eq!(
            usbl.pose.pose.position,
            seen[7].pose.odometry.pose.pose.position
        );
    }

    #[test]
    fn frames_have_the_prefix_and_are_in_the_tree() {
        let mut plant = plant(&[("frame_prefix", Value::from("auv2/"))]);
        let fixed = plant.static_messages().transforms.transforms;
        let children: Vec<&str> = fixed.iter().map(|it| &*it.child_frame_id).collect();
        assert_eq!(children[3..], ["auv2/altimeter", "auv2/gps"]);
        assert_eq!(fixed[4].transform.translation.z, 0.1);
        let seen = fly(&mut plant, 3);
        let told = &seen[2].instruments.navigation;
        let frame = |header: Option<&planesman_msgs::std_msgs::msg::Header>| {
            header.expect("a message").frame_id.clone()
        };
        assert_eq!(
            frame(told.dvl.as_ref().map(|it| &it.header)),
            "auv2/base_link"
        );
        assert_eq!(
            frame(told.altitude.as_ref().map(|it| &it.header)),
            "auv2/altimeter"
        );
        assert_eq!(frame(told.gps.as_ref().map(|it| &it.header)), "auv2/gps");
        assert_eq!(frame(told.usbl.as_ref().map(|it| &it.header)), "auv2/map");
    }

    #[test]
    fn a_reset_begins_their_run_again_and_forgets_what_is_on_its_way() {
        let mut plant = plant(&[("sensors.usbl.outlier", Value::Double(0.3))]);
        let told = |seen: Vec<crate::Observation>| -> Vec<NavigationMessages> {
            seen.into_iter()
                .map(|it| it.instruments.navigation)
                .collect()
        };
        let first = told(fly(&mut plant, 30));
        plant.reset();
        let again = told(fly(&mut plant, 30));
        assert_eq!(first, again);
        assert_eq!(first[0].usbl, None);
    }

    #[test]
    fn all_is_finite_through_loops_at_the_pole_with_every_error_at_its_largest() {
        let extreme = [
            ("speed", 5.0),
            ("initial_pitch", 3.0),
            ("environment.origin.latitude", 90.0),
            ("environment.origin.longitude", 180.0),
            ("environment.bottom", 0.5),
            ("sensors.dvl.noise", 10.0),
            ("sensors.dvl.altitude_noise", 10.0),
            ("sensors.gps.noise", 1000.0),
            ("sensors.gps.bias", -1000.0),
            ("sensors.usbl.outlier", 1.0),
            ("sensors.usbl.outlier_size", 10_000.0),
            ("sensors.attitude.heading_noise", 1.0),
        ];
        let extreme = extreme.map(|(name, value)| (name, Value::Double(value)));
        let mut plant = plant(&extreme);
        for observation in fly(&mut plant, 400) {
            let told = &observation.instruments;
            assert_eq!(told.imu.first_non_finite(), None);
            let told = &told.navigation;
            let finite = |it: Option<String>| assert_eq!(it, None);
            finite(told.dvl.as_ref().and_then(Message::first_non_finite));
            finite(told.dvl_water.as_ref().and_then(Message::first_non_finite));
            finite(told.altitude.as_ref().and_then(Message::first_non_finite));
            finite(told.gps.as_ref().and_then(Message::first_non_finite));
            finite(told.usbl.as_ref().and_then(Message::first_non_finite));
        }
    }
}
