//! The plant's messages: the models' output in the frames and fields of its topics.

use planesman_msgs::{
    builtin_interfaces::msg::Time,
    geometry_msgs::msg::{
        Point, Pose, PoseWithCovariance, Quaternion, Transform, TransformStamped, Twist,
        TwistWithCovariance,
    },
    loop_topics::Sink,
    nav_msgs::msg::Odometry,
    planesman_msgs::msg::DaqSample,
    sensor_msgs::msg::{FluidPressure, Imu},
    tf2_msgs::msg::TFMessage,
};

use crate::{
    description::{self, Motion, Part, Thruster},
    frames::{Frames, diagonal, quaternion, truth, vector},
    navigation_messages::{NavigationMessages, known, mounts},
    odometry,
    sensors::{Readings, Sensors},
};

impl Frames<'_> {
    pub(crate) fn odometry(&self, odometry: &odometry::Odometry) -> Odometry {
        let [x, y, z] = odometry.position;
        Odometry {
            header: self.header(self.odom()),
            child_frame_id: self.base_link(),
            pose: PoseWithCovariance {
                pose: Pose {
                    position: Point { x, y, z },
                    orientation: quaternion(odometry.orientation),
                },
                covariance: truth(),
            },
            twist: TwistWithCovariance {
                twist: Twist {
                    linear: vector(odometry.velocity),
                    angular: vector(odometry.angular_velocity),
                },
                covariance: truth(),
            },
        }
    }

    /// Transforms of the body and of its moving parts; each part has the angle of its planes \[rad\].
    pub(crate) fn transforms(
        &self,
        odometry: &odometry::Odometry,
        parts: &[(Part, f64)],
    ) -> TFMessage {
        let body = TransformStamped {
            header: self.header(self.odom()),
            child_frame_id: self.base_link(),
            transform: Transform {
                translation: vector(odometry.position),
                rotation: quaternion(odometry.orientation),
            },
        };
        let parts = parts.iter().map(|(part, angle)| {
            let [forward, left, up] = part.origin;
            let (slid, rotation) = match part.motion {
                Motion::Turn(side) => (0.0, about_y(side * angle)),
                Motion::Swing(side) => (0.0, about_z(side * angle)),
                Motion::Slide(arm) => (arm * angle, about_y(0.0)),
            };
            TransformStamped {
                header: self.header(self.base_link()),
                child_frame_id: self.named(part.link),
                transform: Transform {
                    translation: vector([forward + slid, left, up]),
                    rotation,
                },
            }
        });
        TFMessage {
            transforms: std::iter::once(body).chain(parts).collect(),
        }
    }

    /// The fixed transforms between frames with z up and frames with z down: half a turn about x. With `map_to_odom` also from REP 105's `map` to
    /// `odom`, which coincide. Also the frames of the thrusters, and of instruments that have a separate frame.
    pub(crate) fn fixed_transforms(
        &self,
        map_to_odom: bool,
        thrusters: &[Thruster],
        sensors: &Sensors,
    ) -> TFMessage {
        let at = |parent, child, place, rotation| TransformStamped {
            header: self.header(parent),
            child_frame_id: child,
            transform: Transform {
                translation: vector(place),
                rotation: quaternion(rotation),
            },
        };
        let fixed = |parent, child, rotation| at(parent, child, [0.0; 3], rotation);
        let half_a_turn = [1.0, 0.0, 0.0, 0.0];
        let (map, body_down) = (self.named("map"), self.named(description::BODY_DOWN));
        let odom = map_to_odom.then(|| fixed(map.clone(), self.odom(), [0.0, 0.0, 0.0, 1.0]));
        let thrusters = thrusters.iter().map(|it| {
            let link = self.named(&it.link);
            at(self.base_link(), link, it.origin, it.orientation())
        });
        let down = [
            fixed(map, self.map_ned(), half_a_turn),
            fixed(self.base_link(), body_down, half_a_turn),
        ];
        let mounts = mounts(&sensors.navigation).into_iter();
        let mounts = mounts
            .map(|(name, place, rotation)| at(self.base_link(), self.named(name), place, rotation));
        TFMessage {
            transforms: odom
                .into_iter()
                .chain(down)
                .chain(thrusters)
                .chain(mounts)
                .collect(),
        }
    }

    /// Gyros and accelerometers give no orientation: its covariance is -1, as `sensor_msgs/Imu` specifies. With an attitude reference the
    /// orientation is filled in.
    pub(crate) fn imu(&self, readings: &Readings, sensors: &Sensors) -> Imu {
        let mut no_orientation = [0.0; 9];
        no_orientation[0] = -1.0;
        let attitude = sensors.navigation.attitude;
        let (orientation, orientation_covariance) = match readings.navigation.orientation {
            Some(orientation) => (orientation, diagonal(attitude.deviation().map(known))),
            None => ([0.0, 0.0, 0.0, 1.0], no_orientation),
        };
        Imu {
            header: self.header(self.base_link()),
            orientation: quaternion(orientation),
            orientation_covariance,
            angular_velocity: vector(readings.angular_velocity),
            angular_velocity_covariance: diagonal(sensors.rate_noise()),
            linear_acceleration: vector(readings.specific_force),
            linear_acceleration_covariance: diagonal([sensors.accelerometer.noise; 3]),
        }
    }

    pub(crate) fn pressure(&self, pressure: f64, noise: f64) -> FluidPressure {
        FluidPressure {
            header: self.header(self.base_link()),
            fluid_pressure: pressure,
            variance: noise * noise,
        }
    }

    pub(crate) fn daq(&self, readings: &Readings) -> DaqSample {
        let (volts, at_end) = (&readings.volts, &readings.saturated);
        let saturated = [
            (at_end.pitch_rate, DaqSample::PITCH_RATE),
            (at_end.depth, DaqSample::DEPTH),
            (at_end.dive_planes, DaqSample::DIVE_PLANES),
            (at_end.speed, DaqSample::SPEED),
        ];
        DaqSample {
            header: self.header(self.base_link()),
            pitch_rate: volts.pitch_rate,
            depth: volts.depth,
            dive_planes: volts.dive_planes,
            speed: volts.speed,
            saturated: saturated
                .iter()
                .filter(|(at_end, _)| *at_end)
                .fold(0, |flags, (_, channel)| flags | channel),
        }
    }
}

/// Rotation about y, to the left, by an angle \[rad\].
fn about_y(angle: f64) -> Quaternion {
    let (sin, cos) = libm::sincos(0.5 * angle);
    quaternion([0.0, sin, 0.0, cos])
}

/// Rotation about z, to port, by an angle \[rad\].
fn about_z(angle: f64) -> Quaternion {
    let (sin, cos) = libm::sincos(0.5 * angle);
    quaternion([0.0, 0.0, sin, cos])
}

/// Readings of the instruments.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Instruments {
    /// Rate gyros and accelerometers.
    pub imu: Imu,
    /// Absolute pressure at the depth port.
    pub depth_pressure: FluidPressure,
    /// Stagnation pressure minus static pressure. `FluidPressure` is meant for absolute pressure, but no standard message exists for a
    /// differential pressure; MAVROS uses it for its airspeed sensor (`diff_pressure`) too.
    pub speed_pressure: FluidPressure,
    /// Voltages of the report's channels.
    pub daq: DaqSample,
    /// Messages of the navigation instruments, which are off by default.
    pub navigation: NavigationMessages,
}

impl Instruments {
    /// Sends each message to `sink`.
    ///
    /// # Errors
    /// If the sink cannot store a message.
    pub fn put_into<S: Sink>(&self, stamp: &Time, sink: &mut S) -> Result<(), S::Error> {
        sink.put("imu", stamp, &self.imu)?;
        sink.put("depth_pressure", stamp, &self.depth_pressure)?;
        sink.put("speed_pressure", stamp, &self.speed_pressure)?;
        sink.put("daq", stamp, &self.daq)?;
        self.navigation.put_into(stamp, sink)
    }

    /// One message for each topic of an enabled instrument; used to create the publishers.
    pub(crate) fn of_all_that_are_on(sensors: &Sensors) -> Self {
        Self {
            navigation: NavigationMessages::of_all_that_are_on(&sensors.navigation),
            ..Self::default()
        }
    }

    /// Converts the readings to messages.
    pub(crate) fn new(frames: &Frames<'_>, readings: &Readings, sensors: &Sensors) -> Self {
        Self {
            imu: frames.imu(readings, sensors),
            depth_pressure: frames
                .pressure(readings.depth_pressure, sensors.depth.pressure_noise()),
            speed_pressure: frames
                .pressure(readings.speed_pressure, sensors.speed.pressure_noise()),
            daq: frames.daq(readings),
            navigation: NavigationMessages::new(frames, &readings.navigation, &sensors.navigation),
        }
    }
}
