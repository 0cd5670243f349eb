//! The plant tick by tick: messages in, messages out.
//!
//! [`Plant::observe`] returns the messages at a stamp, [`Plant::advance`] advances by one tick. An observation changes nothing, so a
//! repeated observation of a stamp gives the same bytes. The output depends only on the parameters, the plane motions and the number of
//! ticks.
//!
//! A changed parameter takes effect in the next tick; messages already published at a stamp stay the same. A refused motion or a diverging
//! step leaves the plant unchanged.

use planesman_msgs::{
    builtin_interfaces::msg::{Duration, Time},
    loop_topics::Sink,
    nav_msgs::msg::Odometry,
    planesman_msgs::msg::{PlaneMotion, ThrusterCommand, VehicleState},
    sensor_msgs::msg::JointState,
    std_msgs::msg::String as Text,
    tf2_msgs::msg::TFMessage,
};

use crate::{
    craft::{Place, VehicleModel},
    description::{self, Driver, Part},
    error::Error,
    frames::Frames,
    messages::Instruments,
    odometry::{self, wrapped},
    parameters::PlantParameters,
    sensors::{Memory, Readings, Truth},
    settings::{Settings, Supply},
};
use planesman_vehicle::{Body, Boundary, Contact, GeneralisedForce, Inputs, PlanePath, Waves};

/// Time for which a thruster command holds without a new one \[ns\].
const COMMAND_LIFETIME: i64 = 1_000_000_000;

/// All messages of the plant at one stamp.
#[derive(Clone, Debug, PartialEq)]
pub struct Observation {
    /// True state, on `state`.
    pub state: VehicleState,
    /// Readings of the instruments.
    pub instruments: Instruments,
    /// True pose in ROS frames.
    pub pose: Pose,
}

/// The true pose and velocity in ROS frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pose {
    /// The odometry in the frame `odom`.
    pub odometry: Odometry,
    /// `odom` to `base_link`, and `base_link` to the planes.
    pub transforms: TFMessage,
}

impl Pose {
    /// Sends each message to `sink`.
    ///
    /// # Errors
    /// If the sink cannot store a message.
    pub fn put_into<S: Sink>(&self, stamp: &Time, sink: &mut S) -> Result<(), S::Error> {
        sink.put("odom", stamp, &self.odometry)?;
        sink.put("/tf", stamp, &self.transforms)
    }
}

/// The vehicle and its instruments at the present tick.
#[derive(Clone, Debug)]
pub struct Plant {
    craft: VehicleModel,
    settings: Settings,
    /// Accepted settings that apply from the next tick on.
    next_settings: Option<Settings>,
    place: Place,
    /// Ticks since the start or a reset.
    ticks: i64,
    acting: Acting,
    /// Commands of the thrusters, and the number of ticks since the last command.
    thrusters: (Vec<f64>, i64),
    planes_source: u8,
    /// First contact during the last tick; its time counts from the tick's start.
    contact: Option<Contact>,
    waves: Waves,
    /// Upper bound of the kinetic energy of heave and pitch so far \[J\].
    energy: f64,
    /// The conditions for which that bound was computed.
    supply: Option<Supply>,
    /// State of the sensors for the next tick.
    memory: Memory,
    /// Readings at the present tick; `None` until they are requested.
    readings: Option<Readings>,
}

/// The inputs at the stamp: actuator positions at the end of the last tick, and the wave load over that tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Acting {
    dive_planes: f64,
    bow_stern_differential: f64,
    roll_differential: f64,
    rudder: f64,
    thrust: f64,
    waves: GeneralisedForce,
}

impl Acting {
    fn held(&self) -> Inputs<'_> {
        Inputs {
            dive_planes: PlanePath::held(&self.dive_planes),
            bow_stern_differential: PlanePath::held(&self.bow_stern_differential),
            roll_differential: PlanePath::held(&self.roll_differential),
            rudder: PlanePath::held(&self.rudder),
            thrust: PlanePath::held(&self.thrust),
        }
    }

    fn at_the_end_of(inputs: &Inputs<'_>, waves: GeneralisedForce) -> Self {
        Self {
            dive_planes: inputs.dive_planes.end(),
            bow_stern_differential: inputs.bow_stern_differential.end(),
            roll_differential: inputs.roll_differential.end(),
            rudder: inputs.rudder.end(),
            thrust: inputs.thrust.end(),
            waves,
        }
    }
}

/// Messages that are constant for the whole flight, also for late subscribers.
#[derive(Clone, Debug, PartialEq)]
pub struct StaticMessages {
    /// Fixed frames.
    pub transforms: TFMessage,
    /// URDF of the vehicle.
    pub description: Text,
}

impl Plant {
    /// Creates the plant at its initial state with neutral planes.
    ///
    /// # Errors
    /// If the vehicle file or the prefix is refused, or thrust is set for a vehicle without propulsion.
    pub fn new(parameters: &PlantParameters) -> Result<Self, Error> {
        Self::of(VehicleModel::load(parameters)?, parameters)
    }

    /// Creates the plant as [`Plant::new`] does, for a vehicle that has already been read.
    ///
    /// # Errors
    /// Same as [`Plant::new`].
    pub fn of(craft: VehicleModel, parameters: &PlantParameters) -> Result<Self, Error> {
        let settings = Settings::new(parameters, &craft)?;
        Ok(Self {
            place: Place::of(settings.initial),
            ticks: 0,
            acting: Acting::default(),
            thrusters: (Vec::new(), 0),
            planes_source: VehicleState::PLANES_ANSWERED,
            contact: None,
            waves: Waves::new(settings.seed),
            energy: 0.0,
            supply: None,
            memory: Memory::new(settings.seed),
            readings: None,
            craft,
            settings,
            next_settings: None,
        })
    }

    /// Applies changed parameters from the next tick on; the initial state and the seed apply at the next reset.
    ///
    /// # Errors
    /// Same as [`Plant::new`]; the previous parameters then stay in force.
    pub fn set_parameters(&mut self, parameters: &PlantParameters) -> Result<(), Error> {
        let next = Settings::new(parameters, &self.craft)?;
        if next.fixed() != self.settings.fixed() {
            return Err(Error::Fixed);
        }
        self.next_settings = Some(next);
        Ok(())
    }

    /// The tick \[ns\].
    #[must_use]
    pub fn tick_nanos(&self) -> i64 {
        self.settings.tick_nanos
    }

    /// The vehicle, for comparison with an identified model.
    #[must_use]
    pub fn craft(&self) -> &VehicleModel {
        &self.craft
    }

    /// First contact during the last tick; its time \[s\] counts from the tick's start.
    #[must_use]
    pub fn contact(&self) -> Option<Contact> {
        self.contact
    }

    /// The forward speed \[m/s\] through the water.
    #[must_use]
    pub fn speed(&self) -> f64 {
        self.place.body.speed
    }

    /// Pose and motion of the body; with six degrees of freedom also its sway.
    #[must_use]
    pub fn body(&self) -> &Body {
        &self.place.body
    }

    /// The messages of the present tick, which falls on `stamp`.
    #[must_use]
    pub fn observe(&mut self, stamp: Time) -> Observation {
        let readings = self.readings();
        let odometry = odometry::Odometry::new(&self.place.body, self.settings.equations.current());
        let frames = self.frames(stamp);
        Observation {
            state: self.state_message(&frames),
            instruments: Instruments::new(&frames, &readings, &self.settings.sensors),
            pose: Pose {
                odometry: frames.odometry(&odometry),
                transforms: frames.transforms(&odometry, &self.parts()),
            },
        }
    }

    /// Ranges of the saturated channels in a sample of the acquisition, one line each.
    #[must_use]
    pub fn saturated(&self, flags: u8) -> Vec<String> {
        let Settings {
            sensors,
            environment,
            ..
        } = &self.settings;
        sensors.limits(flags, environment)
    }

    /// The state alone, the same as in [`Plant::observe`].
    #[must_use]
    pub fn state(&self, stamp: Time) -> VehicleState {
        self.state_message(&self.frames(stamp))
    }

    /// The instruments alone, the same as in [`Plant::observe`].
    #[must_use]
    pub fn instruments(&mut self, stamp: Time) -> Instruments {
        let readings = self.readings();
        Instruments::new(&self.frames(stamp), &readings, &self.settings.sensors)
    }

    /// One message for each topic of an enabled instrument; used to create the publishers.
    #[must_use]
    pub fn instruments_that_are_on(&self) -> Instruments {
        Instruments::of_all_that_are_on(&self.settings.sensors)
    }

    fn frames(&self, stamp: Time) -> Frames<'_> {
        Frames {
            stamp,
            prefix: &self.settings.frame_prefix,
        }
    }

    /// Messages that are constant for the whole flight.
    #[must_use]
    pub fn static_messages(&self) -> StaticMessages {
        let frames = self.frames(Time::default());
        StaticMessages {
            transforms: frames.fixed_transforms(
                self.settings.map_to_odom,
                &description::thrusters(&self.craft),
                &self.settings.sensors,
            ),
            description: Text {
                data: description::robot_description(&self.craft),
            },
        }
    }

    /// Moving parts, each with its angle \[rad\].
    fn parts(&self) -> Vec<(Part, f64)> {
        let together = self.acting.dive_planes;
        let apart = self.acting.bow_stern_differential;
        description::parts(&self.craft)
            .into_iter()
            .map(|part| {
                let angle = match part.driver {
                    Driver::Bow => together + apart,
                    Driver::Stern => together - apart,
                    Driver::Together => together,
                    Driver::Rudder => self.acting.rudder,
                };
                (part, angle)
            })
            .collect()
    }

    /// Converts the joint state of a foreign actuator to a motion with a constant angle over the tick. `None` if the joint `dive_planes` or
    /// its position is missing.
    #[must_use]
    pub fn motion(&self, planes: &JointState) -> Option<PlaneMotion> {
        let joint = planes.name.iter().position(|n| n == "dive_planes")?;
        let angle = *planes.position.get(joint)?;
        Some(PlaneMotion {
            header: planes.header.clone(),
            duration: Duration::from_nanos(self.tick_nanos()),
            dive_planes: vec![angle, angle],
            ..PlaneMotion::default()
        })
    }

    /// Checks a motion as [`Plant::advance`] will.
    ///
    /// # Errors
    /// If the motion does not fit the tick.
    pub fn check_motion(&self, motion: &PlaneMotion) -> Result<(), Error> {
        inputs_of(motion, self.tick_nanos()).map(drop)
    }

    /// Advances by one tick with the planes along `motion`. Without a plane motion the planes hold their angle, and the next state reports this.
    ///
    /// # Errors
    /// If the motion does not fit the tick, or the vehicle's state diverges. The plant then stays unchanged.
    pub fn advance(&mut self, motion: Option<&PlaneMotion>) -> Result<(), Error> {
        // Planes that it does not have tell nothing, whether or not somebody speaks of them.
        let motion = motion.filter(|_| !self.craft.is_of_thrusters_alone());
        let settings = self.next_settings.as_ref().unwrap_or(&self.settings);
        let inputs = match motion {
            Some(motion) => inputs_of(motion, settings.tick_nanos)?,
            None => self.acting.held(),
        };
        let waves = self.waves_force(settings);
        let (place, contact) = (settings.equations).advance(
            &self.place,
            &inputs,
            self.commands(),
            waves,
            settings.steps,
        )?;
        let (energy, supply) = self.energy_after(&place.body, settings, &inputs, waves)?;
        let acting = Acting::at_the_end_of(&inputs, waves);

        if let Some((_, filter)) = &settings.seaway {
            self.waves.advance(filter);
        }
        self.place = place;
        self.ticks += 1;
        self.energy = energy;
        self.supply = supply;
        self.acting = acting;
        self.thrusters.1 += 1;
        self.contact = contact;
        self.planes_source = match motion {
            Some(_) => VehicleState::PLANES_ANSWERED,
            None if self.craft.is_of_thrusters_alone() => VehicleState::PLANES_ANSWERED,
            None => VehicleState::PLANES_HELD,
        };
        self.take_next_settings();
        self.readings = None;
        Ok(())
    }

    /// Names of the thrusters, in the order of their commands; empty for a vehicle without thrusters.
    #[must_use]
    pub fn thrusters(&self) -> &[String] {
        self.craft.thrusters()
    }

    /// Sets the thrusters' commands from the present tick on; a thruster that is not named gets 0.
    ///
    /// # Errors
    /// [`Error::Commands`], [`Error::Thruster`], [`Error::Command`]; the previous commands then stay in force.
    pub fn set_thrusters(&mut self, command: &ThrusterCommand) -> Result<(), Error> {
        let names = self.thrusters();
        let mut commands = vec![0.0; names.len()];
        if command.name.len() != command.command.len() {
            return Err(Error::Commands {
                names: command.name.len(),
                commands: command.command.len(),
            });
        }
        for (name, value) in command.name.iter().zip(&command.command) {
            if names.is_empty() {
                return Err(Error::NoThrusters(self.craft.name().to_owned()));
            }
            let Some(place) = names.iter().position(|it| it == name) else {
                return Err(Error::Thruster {
                    name: name.escape_debug().to_string(),
                    names: names.join(", "),
                });
            };
            // Written so that NaN is refused too.
            if !(-1.0..=1.0).contains(value) {
                return Err(Error::Command(*value));
            }
            commands[place] = *value;
        }
        self.thrusters = (commands, 0);
        Ok(())
    }

    /// Commands in force; empty after a second without a command.
    fn commands(&self) -> &[f64] {
        let (commands, ticks) = &self.thrusters;
        match ticks * self.settings.tick_nanos > COMMAND_LIFETIME {
            true => &[],
            false => commands,
        }
    }

    /// Like [`Plant::advance`], along a motion meant for an earlier tick; the next state reports this.
    ///
    /// # Errors
    /// Same as [`Plant::advance`].
    pub fn advance_late(&mut self, motion: &PlaneMotion) -> Result<(), Error> {
        self.advance(Some(motion))?;
        self.planes_source = VehicleState::PLANES_LATE;
        Ok(())
    }

    /// Returns to the initial state with neutral planes and restarts the noise; the present state reports this.
    pub fn reset(&mut self) {
        self.take_next_settings();
        self.place = Place::of(self.settings.initial);
        self.ticks = 0;
        self.energy = 0.0;
        self.supply = None;
        self.acting = Acting::default();
        self.thrusters = (Vec::new(), 0);
        self.planes_source = VehicleState::PLANES_RESET;
        self.contact = None;
        self.waves = Waves::new(self.settings.seed);
        self.memory = Memory::new(self.settings.seed);
        self.readings = None;
    }

    /// The sensors' readings in the present tick. The readings are computed once in a tick, when they are requested; in a tick without a request the
    /// noise does not advance.
    fn readings(&mut self) -> Readings {
        let (settings, memory) = (&self.settings, &mut self.memory);
        let time = self.ticks * settings.tick_nanos;
        *self.readings.get_or_insert_with(|| {
            settings.sensors.read(
                &truth(settings, &self.place, &self.acting, time),
                &settings.environment,
                &self.craft.depth_port(),
                settings.tick_nanos as f64 * 1e-9,
                memory,
            )
        })
    }

    fn take_next_settings(&mut self) {
        if let Some(next) = self.next_settings.take() {
            self.settings = next;
            self.settings.equations.hold_speed(&mut self.place);
        }
    }

    fn state_message(&self, frames: &Frames<'_>) -> VehicleState {
        let Body {
            plane,
            across,
            speed,
            roll,
            yaw,
            ..
        } = self.place.body;
        let (depth_rate, touched) = (self.settings.equations).depth_rate_and_contact(&self.place);
        VehicleState {
            header: frames.header(frames.map_ned()),
            distance: plane.distance,
            cross_track: across,
            depth: plane.depth,
            depth_rate,
            roll: wrapped(roll.angle),
            roll_rate: roll.rate,
            pitch: wrapped(plane.pitch),
            pitch_rate: plane.pitch_rate,
            yaw: wrapped(yaw.angle),
            yaw_rate: yaw.rate,
            surge: speed,
            heave: plane.heave,
            dive_planes: self.acting.dive_planes,
            planes_source: self.planes_source,
            contact: match touched.or(self.contact.map(|c| c.boundary)) {
                None => VehicleState::CONTACT_NONE,
                Some(Boundary::Surface) => VehicleState::CONTACT_SURFACE,
                Some(Boundary::Bottom) => VehicleState::CONTACT_BOTTOM,
            },
        }
    }

    /// Upper bound of the kinetic energy at the end of a tick \[J\], and the conditions for which it was computed.
    ///
    /// # Errors
    /// A larger energy means that a linear law of pitch damping was used far outside its range.
    fn energy_after(
        &self,
        body: &Body,
        settings: &Settings,
        inputs: &Inputs<'_>,
        waves: GeneralisedForce,
    ) -> Result<(f64, Option<Supply>), Error> {
        let Some(motion) = settings.equations.plane() else {
            return Ok((0.0, None));
        };
        let derivatives = motion.derivatives(body);
        let energy = derivatives.kinetic_energy(&body.plane);
        let Some(drag) = &settings.drag else {
            return Ok((energy, None));
        };
        let supply = drag.supply(motion, &self.place.body, inputs, waves);
        let (most, supply) = match self.supply.filter(|known| supply.is_within(known)) {
            Some(known) => (self.energy, known),
            None => (self.energy.max(supply.most_energy()), supply),
        };
        if energy > most {
            return Err(Error::Damping {
                law: drag.law,
                rate: drag.rate,
                pitch_rate: body.plane.pitch_rate,
                speed: derivatives.speed,
            });
        }
        Ok((most, Some(supply)))
    }

    /// Wave load over the coming tick.
    fn waves_force(&self, settings: &Settings) -> GeneralisedForce {
        match &settings.seaway {
            Some((seaway, _)) => {
                let gravity = settings.environment.gravity;
                seaway.load(&self.waves, self.place.body.plane.depth, gravity)
            }
            None => GeneralisedForce::NONE,
        }
    }
}

/// True quantities that the instruments measure, at a time \[ns\] since the start or a reset.
fn truth(settings: &Settings, place: &Place, acting: &Acting, time: i64) -> Truth {
    let (body, gravity) = (&place.body, settings.environment.gravity);
    Truth {
        rates: body.rates(),
        specific_force: (settings.equations).specific_force(
            place,
            &acting.held(),
            acting.waves,
            gravity,
        ),
        pitch: body.plane.pitch,
        depth: body.plane.depth,
        speed: body.speed,
        planes: acting.dive_planes,
        time,
        odometry: odometry::Odometry::new(body, settings.equations.current()),
        bottom: settings.equations.bottom(),
    }
}

/// The five paths of a motion over a tick of `tick` ns; omitted paths are neutral.
fn inputs_of(motion: &PlaneMotion, tick: i64) -> Result<Inputs<'_>, Error> {
    let duration = motion.duration.nanos();
    // Written so that NaN is refused too.
    if let Some(share) = motion.thrust.iter().find(|n| !(-1.0..=1.0).contains(*n)) {
        return Err(Error::Thrust(*share));
    }
    Ok(Inputs {
        dive_planes: PlanePath::new(&motion.dive_planes, duration, tick)?,
        bow_stern_differential: or_neutral(
            "bow-stern differential",
            &motion.bow_stern_differential,
            duration,
            tick,
        )?,
        roll_differential: or_neutral(
            "roll differential",
            &motion.roll_differential,
            duration,
            tick,
        )?,
        rudder: or_neutral("rudder", &motion.rudder, duration, tick)?,
        thrust: or_neutral("thrust", &motion.thrust, duration, tick)?,
    })
}

/// A path; neutral without samples.
fn or_neutral<'a>(
    name: &'static str,
    samples: &'a [f64],
    duration: i64,
    tick: i64,
) -> Result<PlanePath<'a>, Error> {
    if samples.is_empty() {
        return Ok(PlanePath::NEUTRAL);
    }
    PlanePath::new(samples, duration, tick).map_err(|error| Error::Motion(name, error))
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_msgs::planesman_msgs::msg::DaqSample;
    use planesman_msgs::{
        Message, builtin_interfaces::msg::Duration, cdr, geometry_msgs::msg::TransformStamped,
        std_msgs::msg::Header,
    };
    use planesman_parameters::{Parameters as _, Value};
    use planesman_units::FOOT;
    use planesman_vehicle::State;
    use std::f64::consts::FRAC_PI_6;

    fn with(changes: &[(&str, Value)]) -> PlantParameters {
        PlantParameters::default()
            .with(changes)
            .expect("valid parameters")
    }

    fn plant(changes: &[(&str, Value)]) -> Plant {
        Plant::new(&with(changes)).expect("a plant")
    }

    fn motion(from: f64, to: f64) -> PlaneMotion {
        PlaneMotion {
            header: Header::default(),
            duration: Duration::from_nanos(50_000_000),
            dive_planes: vec![from, to],
            ..PlaneMotion::default()
        }
    }

    fn stamp(k: i64) -> Time {
        Time::from_nanos(k * 50_000_000)
    }

    fn bytes(observation: &Observation) -> Vec<Vec<u8>> {
        vec![
            cdr::to_bytes(&observation.state),
            cdr::to_bytes(&observation.pose.odometry),
            cdr::to_bytes(&observation.pose.transforms),
            cdr::to_bytes(&observation.instruments.imu),
            cdr::to_bytes(&observation.instruments.depth_pressure),
            cdr::to_bytes(&observation.instruments.speed_pressure),
            cdr::to_bytes(&observation.instruments.daq),
        ]
    }

    fn run(plant: &mut Plant, ticks: i64) -> Vec<Vec<Vec<u8>>> {
        (0..ticks)
            .map(|k| {
                let seen = bytes(&plant.observe(stamp(k)));
                let angle = 0.01 * k as f64;
                plant.advance(Some(&motion(angle, angle))).expect("a tick");
                seen
            })
            .collect()
    }

    #[test]
    fn the_held_planes_of_the_report_dive_the_published_vehicle_five_feet_in_ten_seconds() {
        let mut plant = plant(&[]);
        for _ in 0..200 {
            let thirty_degrees = motion(FRAC_PI_6, FRAC_PI_6);
            plant.advance(Some(&thirty_degrees)).expect("a tick");
        }
        let Observation {
            state,
            pose: Pose { odometry, .. },
            ..
        } = plant.observe(stamp(200));
        assert!((state.depth / 0.3048 - 5.014_305).abs() < 1e-5);
        assert!((state.pitch.to_degrees() + 51.387_687).abs() < 1e-5);
        assert_eq!(state.dive_planes, FRAC_PI_6);
        assert_eq!(odometry.pose.pose.position.z, -state.depth);
        assert!(odometry.pose.pose.orientation.y > 0.0, "bow down");
    }

    #[test]
    fn the_same_seed_gives_the_same_bytes_and_another_gives_others() {
        let first = run(&mut plant(&[]), 50);
        assert_eq!(first, run(&mut plant(&[]), 50));
        let other = run(&mut plant(&[("seed", Value::Integer(7))]), 50);
        for (a, b) in first.iter().zip(&other) {
            assert_eq!(a[..3], b[..3], "the truth has no noise");
            assert_ne!(a[3..], b[3..]);
        }
    }

    #[test]
    fn a_reset_begins_the_same_run_again() {
        let mut plant = plant(&[("initial_depth", Value::Double(1.0))]);
        let first = run(&mut plant, 20);
        plant.reset();
        assert_eq!(
            plant.state(stamp(20)).planes_source,
            VehicleState::PLANES_RESET
        );
        // Of the first state that flag is the only difference.
        plant.planes_source = VehicleState::PLANES_ANSWERED;
        assert_eq!(first, run(&mut plant, 20));
    }

    #[test]
    fn a_stamp_observed_again_gives_the_same_bytes_even_after_a_parameter_changed() {
        let mut plant = plant(&[]);
        run(&mut plant, 3);
        let before = bytes(&plant.observe(stamp(3)));
        let faster = with(&[("speed", Value::Double(0.6))]);
        plant.set_parameters(&faster).expect("taken");
        assert_eq!(before, bytes(&plant.observe(stamp(3))));
        plant.advance(None).expect("a tick");
        assert_eq!(plant.observe(stamp(4)).state.surge, 0.6);
    }

    #[test]
    fn a_tick_without_an_answer_holds_the_planes_and_says_so() {
        let mut plant = plant(&[]);
        let source = |plant: &Plant| {
            let state = plant.state(stamp(0));
            (state.dive_planes, state.planes_source)
        };
        assert_eq!(source(&plant), (0.0, VehicleState::PLANES_ANSWERED));
        plant.advance(Some(&motion(0.1, 0.2))).expect("a tick");
        assert_eq!(source(&plant), (0.2, VehicleState::PLANES_ANSWERED));
        plant.advance(None).expect("a tick");
        assert_eq!(source(&plant), (0.2, VehicleState::PLANES_HELD));
        plant.advance_late(&motion(0.2, 0.1)).expect("a tick");
        assert_eq!(source(&plant), (0.1, VehicleState::PLANES_LATE));
    }

    #[test]
    fn rudder_roll_and_thrust_reach_the_plant_and_silence_holds_them() {
        let mut plant = plant(&[("propulsion", Value::from("thrust"))]);
        let full = PlaneMotion {
            roll_differential: vec![0.1, 0.1],
            rudder: vec![0.2, 0.2],
            thrust: vec![1.0, 1.0],
            ..motion(0.0, 0.0)
        };
        plant.advance(Some(&full)).expect("a tick");
        for _ in 0..20 {
            plant.advance(None).expect("a tick");
        }
        let Observation {
            state,
            pose: Pose { odometry, .. },
            ..
        } = plant.observe(stamp(21));
        assert!(state.surge > 0.3048 && plant.speed() == state.surge);
        assert!(state.yaw > 0.0 && state.roll > 0.0 && state.cross_track > 0.0);
        assert_eq!(odometry.pose.pose.position.y, -state.cross_track);
        assert!(odometry.twist.twist.angular.z < 0.0, "to starboard");
    }

    #[test]
    fn contact_is_flagged_at_the_surface_and_at_the_bottom() {
        let mut plant = plant(&[
            ("environment.bottom", Value::Double(0.3)),
            ("initial_depth", Value::Double(0.1)),
        ]);
        let contact = |plant: &Plant| plant.state(stamp(0)).contact;
        assert_eq!(contact(&plant), VehicleState::CONTACT_NONE);
        let mut go = |angle: f64| {
            for _ in 0..400 {
                plant.advance(Some(&motion(angle, angle))).expect("a tick");
            }
            let state = plant.state(stamp(0));
            (state.depth, state.contact)
        };
        assert_eq!(go(0.3), (0.3, VehicleState::CONTACT_BOTTOM));
        assert_eq!(go(-0.3), (0.0, VehicleState::CONTACT_SURFACE));
    }

    #[test]
    fn waves_are_the_same_for_the_same_seed_and_after_a_reset() {
        let waves = [
            ("environment.seaway.force", Value::Double(0.5)),
            ("environment.seaway.moment", Value::Double(0.05)),
            ("initial_depth", Value::Double(0.5)),
        ];
        let first = run(&mut plant(&waves), 40);
        let mut again = plant(&waves);
        assert_eq!(first, run(&mut again, 40));
        again.reset();
        assert_eq!(first[1..], run(&mut again, 40)[1..]);
        assert_ne!(first, run(&mut plant(&waves[2..]), 40));
    }

    #[test]
    fn a_refused_motion_leaves_the_plant_as_it_was() {
        let mut plant = plant(&[]);
        run(&mut plant, 3);
        let before = bytes(&plant.observe(stamp(3)));
        let mut short = motion(0.0, 0.0);
        short.duration = Duration::from_nanos(1);
        let reversed = PlaneMotion {
            thrust: vec![0.0, -1.1],
            ..motion(0.0, 0.0)
        };
        let lone = PlaneMotion {
            rudder: vec![0.1],
            ..motion(0.0, 0.0)
        };
        for refused in [
            motion(0.0, f64::NAN),
            motion(0.0, 3.0),
            short,
            reversed,
            lone,
        ] {
            assert!(plant.advance(Some(&refused)).is_err());
        }
        assert_eq!(before, bytes(&plant.observe(stamp(3))));
    }

    #[test]
    fn everything_published_is_finite_through_loops_and_at_the_surface() {
        let mut plant = plant(&[
            ("speed", Value::Double(5.0)),
            ("initial_pitch", Value::Double(3.0)),
        ]);
        for k in 0..400 {
            let angle = if k < 200 { 1.5 } else { -1.5 };
            plant.advance(Some(&motion(angle, angle))).expect("a tick");
            let o = plant.observe(stamp(k));
            assert_eq!(o.state.first_non_finite(), None);
            assert_eq!(o.pose.odometry.first_non_finite(), None);
            assert_eq!(o.instruments.imu.first_non_finite(), None);
            assert_eq!(o.instruments.daq.first_non_finite(), None);
            assert!(o.state.pitch.abs() <= std::f64::consts::PI && o.state.depth >= 0.0);
        }
    }

    #[test]
    fn frames_are_the_conventional_ones_with_the_prefix() {
        let mut plant = plant(&[("frame_prefix", Value::from("auv1/"))]);
        let o = plant.observe(stamp(1));
        assert_eq!(o.state.header.frame_id, "auv1/map_ned");
        assert_eq!(o.pose.odometry.header.frame_id, "auv1/odom");
        assert_eq!(o.pose.odometry.child_frame_id, "auv1/base_link");
        // A filter takes them, and believes the truth.
        for covariance in [
            o.pose.odometry.pose.covariance,
            o.pose.odometry.twist.covariance,
        ] {
            let on_diagonal = |i: usize| i / 6 == i % 6;
            for (i, value) in covariance.into_iter().enumerate() {
                assert_eq!(value, if on_diagonal(i) { 1e-9 } else { 0.0 });
            }
        }
        let frames = |plant: &Plant| -> Vec<(String, String)> {
            let transforms = plant.static_messages().transforms.transforms;
            let pair = |it: TransformStamped| (it.header.frame_id, it.child_frame_id);
            transforms.into_iter().map(pair).collect()
        };
        let pair = |parent: &str, child: &str| (format!("auv1/{parent}"), format!("auv1/{child}"));
        let [odom, ned, frd] = [
            pair("map", "odom"),
            pair("map", "map_ned"),
            pair("base_link", "base_link_frd"),
        ];
        assert_eq!(frames(&plant), [odom, ned.clone(), frd.clone()]);
        let localized = self::plant(&[
            ("frame_prefix", Value::from("auv1/")),
            ("map_to_odom", Value::Bool(false)),
        ]);
        assert_eq!(frames(&localized), [ned, frd]);
        assert_eq!(
            o.pose.transforms.transforms[0].header,
            o.pose.odometry.header
        );
        assert_eq!(
            o.pose.transforms.transforms[0].child_frame_id,
            "auv1/base_link"
        );
        assert_eq!(o.instruments.imu.header.frame_id, "auv1/base_link");
        assert_eq!(o.instruments.imu.orientation_covariance[0], -1.0);
        assert_eq!(o.instruments.imu.header.stamp, stamp(1));
    }

    #[test]
    fn without_noise_the_sensors_read_the_truth() {
        let mut plant = plant(&[
            ("sensors.errors", Value::Bool(false)),
            ("initial_depth", Value::Double(2.0)),
        ]);
        let o = plant.observe(stamp(0));
        assert_eq!(o.instruments.imu.angular_velocity.y, 0.0);
        assert_eq!(o.instruments.imu.linear_acceleration.z, 9.81456);
        let depth = (o.instruments.depth_pressure.fluid_pressure - 101_325.0) / (999.835 * 9.81456);
        assert!((depth - 2.0).abs() < 1e-12);
        let speed = (2.0 * o.instruments.speed_pressure.fluid_pressure / 999.835).sqrt();
        assert!((speed - 0.3048).abs() < 1e-12);
        assert_eq!(o.instruments.depth_pressure.variance, 0.0);
    }

    #[test]
    fn the_message_names_the_calibrations_that_the_wires_have() {
        let plant = plant(&[("sensors.errors", Value::Bool(false))]);
        let sensors = &plant.settings.sensors;
        for (named, ours) in [
            (
                DaqSample::PITCH_RATE_SLOPE,
                sensors.gyros.pitch.sensitivity(),
            ),
            (DaqSample::DEPTH_ZERO, sensors.depth.zero),
            (
                DaqSample::DEPTH_SLOPE,
                sensors.depth.slope * 999.835 * 9.81456,
            ),
            (DaqSample::DIVE_PLANES_SLOPE, sensors.dive_planes.slope_si()),
            (DaqSample::SPEED_SLOPE, sensors.speed.slope),
        ] {
            assert!((named / ours - 1.0).abs() < 1e-12, "{named} is not {ours}");
        }
    }

    #[test]
    fn the_wires_show_the_dive_in_volts_until_the_depth_cell_is_full() {
        let mut plant = plant(&[("sensors.gyro.drift.range", Value::Double(0.0))]);
        let thirty_degrees = motion(FRAC_PI_6, FRAC_PI_6);
        let mut full = None;
        for k in 0..200 {
            let Observation {
                state,
                instruments: Instruments { daq, .. },
                ..
            } = plant.observe(stamp(k));
            let q = daq.pitch_rate / DaqSample::PITCH_RATE_SLOPE;
            assert!(
                (q - state.pitch_rate).abs() < 0.04,
                "five deviations of the noise"
            );
            if daq.saturated & DaqSample::DEPTH != 0 {
                full.get_or_insert(state.depth);
            }
            plant.advance(Some(&thirty_degrees)).expect("a tick");
        }
        // 32.58 in.
        assert!((full.expect("a foot and a half per second") - 0.8275).abs() < 0.02);
        assert!((plant.observe(stamp(200)).instruments.daq.dive_planes - 0.3).abs() < 0.0025);
    }

    #[test]
    fn every_error_can_be_switched_off_and_shows_on_its_own_topics_only() {
        // Where the depth cell is about to be full, bow down for the dry lines.
        let deep = [
            ("initial_depth", Value::Double(0.826)),
            ("initial_pitch", Value::Double(-0.01)),
        ];
        let topics = ["imu", "depth_pressure", "speed_pressure", "daq"];
        let flown = |change: (&'static str, Value)| {
            let [depth, pitch] = deep.clone();
            // The report's cells.
            let cells = ["sensors.depth.saturation", "sensors.speed.saturation"];
            let [deepest, fastest] = cells.map(|it| (it, Value::Double(10.0)));
            let mut plant = plant(&[depth, pitch, deepest, fastest, change]);
            let seen = run(&mut plant, 20);
            let o = plant.observe(stamp(20));
            assert_eq!(o.instruments.daq.first_non_finite(), None);
            assert_eq!(o.instruments.imu.first_non_finite(), None);
            assert_eq!(o.instruments.depth_pressure.first_non_finite(), None);
            seen
        };
        let plain = flown(("sensors.errors", Value::Bool(true)));
        let (gyro, depth) = (["imu", "daq"], ["depth_pressure", "daq"]);
        let speed = ["speed_pressure", "daq"];
        let off = || Value::Double(0.0);
        let cases: [(&str, Value, &[&str]); 21] = [
            (
                "sensors.gyro.calibration",
                Value::from("preliminary"),
                &gyro,
            ),
            (
                "sensors.gyro.calibration",
                Value::from("preliminary_low"),
                &gyro,
            ),
            ("sensors.gyro.reference_error", Value::Double(-0.1), &gyro),
            ("sensors.gyro.bias", Value::Double(0.1), &gyro),
            ("sensors.gyro.drift.range", off(), &gyro),
            ("sensors.gyro.drift.rate", off(), &gyro),
            ("sensors.gyro.noise", off(), &gyro),
            ("sensors.accelerometer.noise", off(), &["imu"]),
            ("sensors.depth.port", Value::from("bottom"), &depth),
            ("sensors.depth.zero", off(), &depth),
            // Behind the cell the converter is full at the same 10 V.
            ("sensors.depth.saturation", off(), &["depth_pressure"]),
            ("sensors.depth.bias", Value::Double(-1.0), &depth),
            ("sensors.depth.noise", off(), &depth),
            ("sensors.speed.dry_lines", off(), &speed),
            ("sensors.speed.saturation", Value::Double(1.0), &speed),
            ("sensors.speed.noise", off(), &speed),
            (
                "daq.dive_planes.compensation",
                Value::Double(2.19),
                &["daq"],
            ),
            ("daq.dive_planes.noise", Value::Double(0.1), &["daq"]),
            ("daq.conditioning", Value::from("high_pass_twice"), &["daq"]),
            ("daq.conditioning", Value::from("dead_band"), &["daq"]),
            ("daq.adc.bits", Value::Integer(0), &["daq"]),
        ];
        for (name, value, where_it_shows) in cases {
            let seen = flown((name, value));
            for (i, topic) in topics.into_iter().enumerate() {
                let differs = seen.iter().zip(&plain).any(|(a, b)| a[3 + i] != b[3 + i]);
                assert_eq!(
                    differs,
                    where_it_shows.contains(&topic),
                    "{name} on {topic}"
                );
            }
        }
    }

    #[test]
    fn the_corner_frequency_decides_what_the_high_pass_leaves_of_a_steady_turn() {
        let after = |corner: f64| {
            let mut plant = plant(&[
                ("sensors.errors", Value::Bool(false)),
                ("daq.conditioning", Value::from("high_pass")),
                ("daq.high_pass", Value::Double(corner)),
            ]);
            for _ in 0..40 {
                plant.advance(Some(&motion(0.1, 0.1))).expect("a tick");
                let _ = plant.observe(stamp(0));
            }
            plant.observe(stamp(40)).instruments.daq.pitch_rate.abs()
        };
        let (open, slow, fast) = (after(0.0), after(0.1), after(10.0));
        assert!(fast < 0.5 * slow && slow < open, "{open} {slow} {fast}");
    }

    #[test]
    fn a_linear_damping_law_is_the_secant_or_tangent_of_the_drag_at_its_rate() {
        let craft = VehicleModel::load(&with(&[])).expect("built in");
        let damping = |law: &str| {
            let parameters = with(&[
                ("pitch_damping", Value::from(law)),
                ("pitch_damping_viscous", Value::Double(0.8)),
                ("pitch_damping_rate", Value::Double(0.25)),
            ]);
            let d = crate::derivatives(&parameters, &craft);
            (d.m_q, d.m_qq)
        };
        assert_eq!(damping("secant"), (-0.2, 0.0));
        assert_eq!(damping("tangent"), (-0.4, 0.0));
        assert_eq!(damping("quadratic"), (0.0, -0.8));
    }

    #[test]
    fn parameters_that_cannot_work_are_refused_with_the_reason() {
        for (changes, reason) in [
            (("vehicle", Value::from("no/such.yaml")), "no/such.yaml"),
            (("frame_prefix", Value::from("a b")), "frame_prefix"),
        ] {
            let refusal = Plant::new(&with(&[changes]))
                .expect_err("refused")
                .to_string();
            assert!(refusal.contains(reason), "{refusal}");
        }
        let undriven = [
            ("vehicle", Value::from("remus_100")),
            ("propulsion", Value::from("thrust")),
        ];
        let refusal = Plant::new(&with(&undriven))
            .expect_err("no propulsion")
            .to_string();
        assert!(refusal.contains("no propulsion"), "{refusal}");
    }

    #[test]
    fn the_tick_and_the_vehicle_cannot_change_on_the_way() {
        let mut plant = plant(&[]);
        assert_eq!(plant.tick_nanos(), 50_000_000);
        for fixed in [
            ("tick", Value::Double(0.1)),
            ("step", Value::Double(0.002)),
            ("vehicle", Value::from("other.yaml")),
        ] {
            assert!(plant.set_parameters(&with(&[fixed])).is_err());
        }
    }

    #[test]
    fn the_gyros_feel_the_heel_and_the_turn_that_the_state_tells() {
        let mut plant = plant(&[("sensors.errors", Value::Bool(false))]);
        let turning = PlaneMotion {
            roll_differential: vec![0.1; 51],
            rudder: vec![0.2; 51],
            ..motion(0.05, 0.05)
        };
        for _ in 0..40 {
            plant.advance(Some(&turning)).expect("a tick");
        }
        let Observation {
            state,
            instruments: Instruments { imu, .. },
            pose: Pose { odometry, .. },
            ..
        } = plant.observe(stamp(40));
        assert!(state.roll_rate.abs() > 1e-4 && state.yaw_rate > 1e-3);
        // Forward, left, up: the odometry's angular velocity is the truth in the same frame.
        let (felt, truth) = (&imu.angular_velocity, &odometry.twist.twist.angular);
        assert!((felt.x - truth.x).abs() < 1e-12);
        assert!((felt.y - truth.y).abs() < 1e-12);
        assert!((felt.z - truth.z).abs() < 1e-12);
        // To starboard is down through up's axis.
        assert!(felt.z < 0.0);
    }

    #[test]
    fn without_errors_the_gyros_read_the_truth_by_any_calibration() {
        for calibration in ["swing", "preliminary", "preliminary_low"] {
            let mut plant = plant(&[
                ("sensors.errors", Value::Bool(false)),
                ("sensors.gyro.calibration", Value::from(calibration)),
            ]);
            let turning = PlaneMotion {
                roll_differential: vec![0.1; 2],
                rudder: vec![-0.2; 2],
                ..motion(0.1, 0.1)
            };
            for _ in 0..40 {
                plant.advance(Some(&turning)).expect("a tick");
            }
            let Observation {
                instruments: Instruments { imu, .. },
                pose: Pose { odometry, .. },
                ..
            } = plant.observe(stamp(40));
            let (felt, truth) = (imu.angular_velocity, odometry.twist.twist.angular);
            for (felt, truth) in [(felt.x, truth.x), (felt.y, truth.y), (felt.z, truth.z)] {
                assert!(
                    (felt - truth).abs() < 1e-14 && truth.abs() > 1e-3,
                    "{calibration}"
                );
            }
        }
    }

    #[test]
    fn bow_planes_against_stern_planes_sink_the_vehicle_with_little_pitch() {
        let after = |together: f64, differential: f64| {
            let mut plant = plant(&[("initial_depth", Value::Double(1.0))]);
            let motion = PlaneMotion {
                bow_stern_differential: vec![differential; 2],
                ..motion(together, together)
            };
            for _ in 0..20 {
                plant.advance(Some(&motion)).expect("a tick");
            }
            plant.observe(stamp(20)).state
        };
        let (level, together, apart) = (after(0.0, 0.0), after(0.2, 0.0), after(0.0, 0.2));
        assert!(apart.heave > 3.0 * together.heave.abs() && apart.heave > 0.0);
        assert!(apart.pitch.abs() < 0.35 * together.pitch.abs());
        assert!(apart.depth > level.depth);
        assert_eq!(apart.dive_planes, 0.0);
    }

    #[test]
    fn a_contact_within_a_tick_is_reported_with_its_time() {
        let mut plant = plant(&[("environment.bottom", Value::Double(0.3))]);
        let touched = (0..400).find_map(|_| {
            plant.advance(Some(&motion(0.3, 0.3))).expect("a tick");
            plant.contact()
        });
        let contact = touched.expect("it gets there");
        assert_eq!(contact.boundary, Boundary::Bottom);
        assert!((0.0..=0.05).contains(&contact.time));
        assert_eq!(plant.observe(stamp(0)).state.depth, 0.3);
    }

    #[test]
    fn without_restoring_the_heeled_vehicle_stays_heeled() {
        let heel = |restoring: &str| {
            let mut plant = plant(&[("restoring", Value::from(restoring))]);
            for k in 0..2000 {
                let differential = if k < 20 { 0.2 } else { 0.0 };
                let motion = PlaneMotion {
                    roll_differential: vec![differential; 2],
                    ..motion(0.0, 0.0)
                };
                plant.advance(Some(&motion)).expect("a tick");
            }
            (plant.place.body.roll.angle, plant.place.body.roll.rate)
        };
        let (free, righted) = (heel("none"), heel("sine"));
        assert!(free.1 > 0.0, "nothing turns it back: {free:?}");
        assert!(free.0 > 10.0 * righted.0.abs());
    }

    /// The state after so many ticks with the planes at an angle for 10 s and then neutral.
    fn held_for_ten_seconds(changes: &[(&str, Value)], angle: f64, ticks: i64) -> State {
        let mut plant = plant(changes);
        for k in 0..ticks {
            let angle = if k < 200 { angle } else { 0.0 };
            plant.advance(Some(&motion(angle, angle))).expect("a tick");
        }
        plant.place.body.plane
    }

    #[test]
    fn the_vehicle_as_printed_dives_to_the_printed_depth_at_the_printed_pitch() {
        // Brunner 1988, pp. 38 f.: -4.2 degrees, 2.61 ft.
        let as_printed = [
            ("vehicle", Value::from("brunner_as_printed")),
            ("speed", Value::from(0.7112)),
            ("restoring", Value::from("small_angle")),
        ];
        let pitch = held_for_ten_seconds(&as_printed, FRAC_PI_6, 200).pitch;
        assert!((pitch.to_degrees() + 4.2).abs() < 0.05, "{pitch}");
        let depth = held_for_ten_seconds(&as_printed, FRAC_PI_6, 600).depth;
        assert!((depth / FOOT - 2.61).abs() < 0.015, "{depth}");
    }

    /// The largest pitch rate \[rad/s\] within so many ticks, planes held at an angle, and why the flight ended before.
    fn turned(changes: &[(&str, Value)], angle: f64, ticks: i64) -> (f64, Option<Error>) {
        let mut plant = plant(changes);
        let mut largest = 0.0_f64;
        for _ in 0..ticks {
            if let Err(error) = plant.advance(Some(&motion(angle, angle))) {
                return (largest, Some(error));
            }
            largest = largest.max(plant.place.body.plane.pitch_rate.abs());
        }
        (largest, None)
    }

    #[test]
    fn a_linear_pitch_damping_never_turns_the_vehicle_faster_than_its_drag_lets_it() {
        let law = |law: &'static str, speed: f64| {
            [
                ("pitch_damping", Value::from(law)),
                ("speed", Value::from(speed)),
                ("initial_depth", Value::from(1000.0)),
                ("initial_pitch", Value::from(0.1)),
            ]
        };
        for speed in [0.3, 0.6, 1.5, 2.5, 5.0] {
            for angle in [0.0, 0.1, 0.5] {
                let (drag, ended) = turned(&law("quadratic", speed), angle, 6000);
                assert!(ended.is_none(), "{ended:?}");
                for linear in ["secant", "tangent"] {
                    let (rate, ended) = turned(&law(linear, speed), angle, 6000);
                    let case = format!("{linear} {speed} m/s {angle} rad: {rate}, {drag} rad/s");
                    // The bound takes the signs that help most: it is wider than the drag's own motion.
                    assert!(rate < 4.0 * drag + 0.5, "{case}");
                    match ended {
                        None => assert!(speed < 1.5, "{case}"),
                        Some(error) => {
                            let Error::Damping { pitch_rate, .. } = error else {
                                panic!("{case}: {error}");
                            };
                            assert!(pitch_rate.abs() > drag, "{case}");
                            let cause =
                                format!("pitch_damping '{linear}' is linear about 0.15 rad/s");
                            assert!(error.to_string().contains(&cause), "{error}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn each_variant_of_the_equations_can_be_asked_for() {
        let plain = held_for_ten_seconds(&[], 0.1, 200);
        for change in [
            ("restoring", Value::from("none")),
            ("restoring", Value::from("small_angle")),
            ("heave_moment", Value::from(false)),
            ("pitch_damping", Value::from("secant")),
            ("pitch_damping", Value::from("tangent")),
            ("pitch_damping", Value::from("quadratic")),
        ] {
            let changed = held_for_ten_seconds(std::slice::from_ref(&change), 0.1, 200);
            assert_ne!(changed, plain, "{change:?}");
        }
    }

    /// A vehicle of six degrees under way.
    fn lauv(changes: &[(&str, Value)]) -> Plant {
        let mut all = vec![
            ("vehicle", Value::from("lauv")),
            ("propulsion", Value::from("thrust")),
            ("speed", Value::Double(1.5)),
            ("initial_depth", Value::Double(3.0)),
        ];
        all.extend_from_slice(changes);
        plant(&all)
    }

    #[test]
    fn a_vehicle_of_six_degrees_sways_and_heels_in_a_turn_and_odometry_tells_it() {
        let mut plant = lauv(&[
            ("environment.current.y", Value::Double(0.3)),
            ("sensors.errors", Value::Bool(false)),
        ]);
        let turning = PlaneMotion {
            rudder: vec![0.15; 2],
            thrust: vec![0.6; 2],
            ..motion(0.02, 0.02)
        };
        let mut before = plant.observe(stamp(0));
        for k in 1..=200 {
            plant.advance(Some(&turning)).expect("a tick");
            let now = plant.observe(stamp(k));
            if k == 200 {
                let twist = &now.pose.odometry.twist.twist;
                // It slides outwards: to port, which is left, beside what the current carries it.
                assert!(now.state.yaw_rate > 0.05, "{}", now.state.yaw_rate);
                // The track's difference is the twist in the fixed frame.
                let place = |it: &Observation| {
                    let p = it.pose.odometry.pose.pose.position.clone();
                    [p.x, p.y, p.z]
                };
                let (from, to) = (place(&before), place(&now));
                let speed: f64 = (0..3)
                    .map(|i| ((to[i] - from[i]) / 0.05).powi(2))
                    .sum::<f64>()
                    .sqrt();
                let told =
                    (twist.linear.x.powi(2) + twist.linear.y.powi(2) + twist.linear.z.powi(2))
                        .sqrt();
                assert!((speed - told).abs() < 2e-3, "{speed} {told}");
                assert!(twist.linear.y.abs() > 0.02);
                assert!(now.state.surge < 1.5 && now.state.surge > 0.8);
            }
            before = now;
        }
    }

    #[test]
    fn the_accelerometers_of_a_vehicle_of_six_degrees_feel_the_second_difference_of_its_track() {
        let mut plant = lauv(&[
            ("sensors.errors", Value::Bool(false)),
            ("tick", Value::Double(0.001)),
        ]);
        let turning = PlaneMotion {
            duration: Duration::from_nanos(1_000_000),
            rudder: vec![0.2; 2],
            thrust: vec![1.0; 2],
            ..motion(0.1, 0.1)
        };
        let mut places = Vec::new();
        let mut felt = None;
        for k in 0..=3000 {
            let now = plant.observe(stamp(k));
            if k >= 2999 - 1 {
                let odometry = &now.pose.odometry.pose.pose;
                let p = &odometry.position;
                places.push([p.x, p.y, p.z]);
                if k == 2999 {
                    felt = Some((
                        now.instruments.imu.linear_acceleration.clone(),
                        odometry.orientation.clone(),
                    ));
                }
            }
            plant.advance(Some(&turning)).expect("a tick");
        }
        let (felt, q) = felt.expect("the tick before the last");
        let mut expected: [f64; 3] =
            std::array::from_fn(|i| (places[2][i] - 2.0 * places[1][i] + places[0][i]) / 1e-6);
        expected[2] += 9.81456;
        // Into the body by the conjugate.
        let u = [-q.x, -q.y, -q.z];
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [
                a[1] * b[2] - a[2] * b[1],
                a[2] * b[0] - a[0] * b[2],
                a[0] * b[1] - a[1] * b[0],
            ]
        };
        let inner = cross(u, expected);
        let outer = cross(u, std::array::from_fn(|i| inner[i] + q.w * expected[i]));
        let body: [f64; 3] = std::array::from_fn(|i| expected[i] + 2.0 * outer[i]);
        for (x, y) in body.iter().zip([felt.x, felt.y, felt.z]) {
            assert!((x - y).abs() < 5e-3, "{body:?} {felt:?}");
        }
    }

    #[test]
    fn a_vehicle_of_six_degrees_floats_at_the_surface_and_stops_at_the_bottom() {
        let mut plant = lauv(&[
            ("speed", Value::Double(0.0)),
            ("initial_depth", Value::Double(0.3)),
        ]);
        for _ in 0..1200 {
            plant.advance(Some(&motion(0.0, 0.0))).expect("a tick");
        }
        let state = plant.observe(stamp(0)).state;
        // 1 N of 177.58 N of buoyancy is out of the water: 0.6 % of 0.15 m.
        assert!((state.depth - 0.0742).abs() < 2e-3, "{}", state.depth);
        assert_eq!(state.contact, VehicleState::CONTACT_SURFACE);

        let mut plant = lauv(&[("environment.bottom", Value::Double(6.0))]);
        let down = PlaneMotion {
            thrust: vec![0.8; 2],
            ..motion(0.2, 0.2)
        };
        let touched = (0..600).find_map(|_| {
            plant.advance(Some(&down)).expect("a tick");
            plant.contact()
        });
        assert_eq!(touched.expect("it gets there").boundary, Boundary::Bottom);
        assert!(plant.observe(stamp(0)).state.depth < 6.1);
    }

    #[test]
    fn what_is_of_the_planes_equations_is_refused_for_six_degrees() {
        for change in [
            ("restoring", Value::from("none")),
            ("pitch_damping", Value::from("secant")),
            ("heave_moment", Value::from(false)),
            ("environment.tether.diameter", Value::Double(0.005)),
        ] {
            let parameters = with(&[("vehicle", Value::from("lauv")), change.clone()]);
            let refusal = Plant::new(&parameters).expect_err("refused").to_string();
            assert!(refusal.contains(change.0), "{refusal}");
        }
    }

    #[test]
    fn a_held_speed_can_be_changed_on_the_way_for_six_degrees_too() {
        let mut plant = lauv(&[("propulsion", Value::from("held"))]);
        plant.advance(Some(&motion(0.05, 0.05))).expect("a tick");
        let faster = with(&[
            ("vehicle", Value::from("lauv")),
            ("speed", Value::Double(1.8)),
            ("initial_depth", Value::Double(3.0)),
        ]);
        plant.set_parameters(&faster).expect("taken");
        for _ in 0..20 {
            plant.advance(Some(&motion(0.05, 0.05))).expect("a tick");
        }
        assert!((plant.speed() - 1.8).abs() < 1e-9, "{}", plant.speed());
    }

    #[test]
    fn a_thrusters_command_is_taken_by_names_and_holds_for_a_second() {
        let mut plant = plant(&[
            ("vehicle", Value::from("bluerov2_heavy")),
            ("propulsion", Value::from("thrust")),
            ("speed", Value::Double(0.0)),
            ("initial_depth", Value::Double(5.0)),
        ]);
        let all = [
            "vertical_front_starboard",
            "vertical_front_port",
            "vertical_rear_starboard",
            "vertical_rear_port",
        ];
        let command = |name: &[&str], command: Vec<f64>| ThrusterCommand {
            name: name.iter().map(|it| (*it).to_owned()).collect(),
            command,
            ..ThrusterCommand::default()
        };
        for (bad, reason) in [
            (command(&["bow"], vec![0.1]), "unknown thruster 'bow'"),
            (command(&all, vec![0.1]), "4 names but 1 commands"),
            (command(&all[..1], vec![1.5]), "as a share of full command"),
            (
                command(&all[..1], vec![f64::NAN]),
                "as a share of full command",
            ),
        ] {
            let refusal = plant.set_thrusters(&bad).expect_err("refused").to_string();
            assert!(refusal.contains(reason), "{refusal}");
        }
        // Straight down, by the file's signs; without a motion of planes, which it does not have.
        plant
            .set_thrusters(&command(&all, vec![-0.5; 4]))
            .expect("taken");
        let mut depths = Vec::new();
        for _ in 0..100 {
            plant.advance(None).expect("a tick");
            depths.push(plant.observe(stamp(0)).state.depth_rate);
        }
        assert_eq!(
            plant.observe(stamp(0)).state.planes_source,
            VehicleState::PLANES_ANSWERED
        );
        let (at_one, at_five) = (depths[19].abs(), depths[99].abs());
        // After a second nobody asks for anything: it slows down.
        assert!(at_one > 0.2 && at_five < 0.5 * at_one, "{at_one} {at_five}");
    }

    /// Such a file has inputs too, by name, and is no vehicle of six degrees.
    #[test]
    fn a_model_of_several_inputs_is_refused_as_what_it_is() {
        let file =
            std::env::temp_dir().join(format!("planesman-several-{}.yaml", std::process::id()));
        std::fs::write(&file, "format: planesman model 2\ninputs: [a, b]\n").expect("written");
        let vehicle = ("vehicle", Value::from(file.to_str().expect("a path")));
        let refusal = Plant::new(&with(&[vehicle]))
            .expect_err("refused")
            .to_string();
        std::fs::remove_file(&file).expect("there");
        assert!(refusal.contains("several inputs"), "{refusal}");
    }
}
