//! Dive of program T6's vehicle with a digital hydraulic actuator, tick by tick: the observed motion of the depth loop, and the decisions from which
//! [`crate::studies::orbit`] starts.

use std::f64::consts::FRAC_PI_2;

use crate::brunner_1988::controllers::axis::DampedInertia;
use crate::brunner_1988::controllers::program_t6::{Motion, Plant};
use planesman_control::{
    AntiWindup, ControllerParameters, DepthLoop, Integral, Limit, LimitError, PitchLoop,
};
use planesman_hydraulics::{Demand, Dha};
use planesman_show::design::default_gains;
use planesman_units::FOOT;

use crate::studies::orbit::{Body, SCALE, State};
use crate::studies::watched::{Done, Watched};

/// Sampling time of the controller, s.
pub(crate) const TICK: f64 = 0.05;
/// Integration steps of the vehicle per tick: four per valve cycle at 80 Hz.
const STEPS: i64 = 16;
/// Half an integration step, ns.
const HALF_NANOS: i64 = 1_562_500;
/// Integration step of the vehicle, ns.
const STEP_NANOS: i64 = 2 * HALF_NANOS;
/// Integration step of the vehicle, s.
const H: f64 = TICK / STEPS as f64;
/// Depth setpoint z_c, m.
pub(crate) const SETPOINT: f64 = 3.0 * FOOT;
/// Error at 5 % of the step, m.
const NEAR: f64 = -0.05 * SETPOINT;

/// Integral gain of the loop and righting moment of the vehicle; both are 0 in program T6.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Loop {
    /// Integral gain K_i, 1/s.
    pub integral: f64,
    /// Righting moment M_theta, ft lb.
    pub restoring: f64,
}

impl Loop {
    pub(crate) fn plant(&self) -> Plant {
        let plant = Plant::default();
        Plant {
            axis: DampedInertia {
                restoring: self.restoring,
                ..plant.axis
            },
            ..plant
        }
    }

    /// The depth controller's law with default gains; its integral may use all of the planes' travel.
    pub(crate) fn law(&self) -> Result<Law, LimitError> {
        let parameters = ControllerParameters::default();
        let gains = default_gains();
        Ok(Law {
            depth: DepthLoop {
                p: gains.depth_p,
                d: gains.depth_d,
                pitch_limit: Limit::new(parameters.depth.pitch_limit)?,
            },
            pitch: PitchLoop {
                p: gains.pitch_p,
                rate: gains.pitch_rate,
            },
            integral: gains.pitch_p * self.integral,
            share: Limit::new(FRAC_PI_2)?,
            planes: Limit::new(parameters.planes.limit)?,
            anti_windup: parameters.anti_windup,
        })
    }
}

/// The depth controller's law with default gains: depth loop, pitch loop and integral, with the planes' limits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law {
    pub(crate) depth: DepthLoop,
    pub(crate) pitch: PitchLoop,
    /// Integral gain: plane angle per pitch error and second.
    pub(crate) integral: f64,
    /// Limit of the integral term.
    pub(crate) share: Limit,
    pub(crate) planes: Limit,
    pub(crate) anti_windup: AntiWindup,
}

impl Law {
    /// Commanded plane angle, rad, and rate of the integral term, rad/s.
    fn evaluate(&self, plant: &Plant, motion: &Motion, share: f64) -> (f64, f64) {
        let rate = plant.depth_rate(motion);
        let depth = self.depth.evaluate(SETPOINT, motion.depth, rate, 0.0);
        let terms = self
            .pitch
            .evaluate(depth.pitch_command.value, motion.pitch, motion.pitch_rate);
        (terms.dive_planes() + share, -self.integral * terms.error)
    }
}

/// A running dive.
#[derive(Clone, Debug)]
pub(crate) struct Flight {
    plant: Plant,
    law: Law,
    pub(crate) dha: Dha,
    motion: Motion,
    integral: Integral,
    /// Plane angle at the last step, rad.
    planes: f64,
    /// Angle commanded in the last tick, rad.
    asked: f64,
    pub(crate) tick: i64,
    /// Time at which the depth was first within 5 % of the step, s.
    pub(crate) reached: Option<f64>,
    /// Observed motion, while the dive is observed.
    watched: Option<Watched<Diving>>,
    /// States at the beginning of this tick and of the two before.
    recent: [State<Diving>; 3],
}

impl Flight {
    /// A dive from rest at the surface.
    pub(crate) fn begin(around: &Loop, dha: Dha) -> Result<Self, LimitError> {
        let (plant, law) = (around.plant(), around.law()?);
        let body = Diving {
            plant,
            law,
            motion: Motion::default(),
            share: 0.0,
        };
        let state = State {
            body,
            hydraulics: *dha.hydraulics(),
            sign: dha.sign(),
            time: 0.0,
        };
        Ok(Self {
            plant,
            law,
            planes: dha.angle(0),
            asked: 0.0,
            dha,
            motion: Motion::default(),
            integral: Integral::default(),
            tick: 0,
            reached: None,
            watched: None,
            recent: [state; 3],
        })
    }

    /// Simulates up to the beginning of a tick; `demand`: the demand on the actuator as a function of time in s, without the angle.
    pub(crate) fn until(&mut self, tick: i64, demand: &impl Fn(f64) -> Demand) {
        while self.tick < tick {
            self.fly(demand(self.tick as f64 * TICK));
        }
    }

    /// Simulates up to the beginning of a tick and observes the motion.
    pub(crate) fn watch(&mut self, until: i64, demand: &impl Fn(f64) -> Demand) -> Watched<Diving> {
        let unseen = Watched::new(0.5 * H, self.tick as f64 * TICK);
        self.watched = Some(unseen.clone());
        self.until(until, demand);
        self.watched.take().unwrap_or(unseen)
    }

    /// Simulates one tick.
    fn fly(&mut self, demand: Demand) {
        let elapsed = if self.tick == 0 { 0.0 } else { TICK };
        let share = self.integral.after(elapsed, self.law.share);
        let (wanted, drive) = self.law.evaluate(&self.plant, &self.motion, share);
        let angle = self.law.planes.apply(wanted).value;
        self.asked = angle;
        self.integral
            .lead(drive, wanted - angle, self.law.anti_windup);
        let demand = Demand { angle, ..demand };
        if self.watched.is_some() {
            self.recent.rotate_right(1);
            self.recent[0] = self.state(share);
        }
        for quarter in 0..4 {
            self.quarter(self.tick * STEPS + quarter * STEPS / 4, demand);
        }
        self.tick += 1;
    }

    /// Simulates a quarter of a tick, after `steps` steps.
    fn quarter(&mut self, steps: i64, demand: Demand) {
        const QUARTER: usize = STEPS as usize / 4;
        // Within a tick the actuator does not see the vehicle.
        let mut angles = [0.0; 2 * QUARTER];
        for (k, pair) in angles.chunks_exact_mut(2).enumerate() {
            let nanos = (steps + k as i64 + 1) * STEP_NANOS;
            let before = Done::of(&self.dha);
            for (angle, nanos) in pair.iter_mut().zip([nanos - HALF_NANOS, nanos]) {
                self.dha.advance_to(nanos, demand);
                *angle = self.dha.angle(nanos);
            }
            if let Some(watched) = &mut self.watched {
                let asked = (nanos, demand.angle);
                watched.take_decision(&self.dha, before, asked, &self.recent[2]);
            }
        }
        // While the ram is stuck, the vehicle's equations need no short steps.
        let still = angles.iter().all(|angle| *angle == self.planes);
        let step = if still { angles.len() } else { 2 };
        for (k, these) in angles.chunks_exact(step).enumerate() {
            let (h, last) = (0.5 * H * step as f64, self.motion.depth - SETPOINT);
            let mean = simpson([self.planes, these[step / 2 - 1], these[step - 1]]);
            self.motion = self.plant.after(self.motion, h, |_| mean);
            self.planes = these[step - 1];
            let error = self.motion.depth - SETPOINT;
            let at = |share: f64| last + share * (error - last);
            if self.reached.is_none() && error >= NEAR {
                let share = (NEAR - last) / (error - last);
                self.reached = Some(steps as f64 * H + (k as f64 + share) * h);
            }
            if let Some(watched) = &mut self.watched {
                let shares = (1..=step).map(|i| i as f64 / step as f64);
                watched.outputs.extend(shares.map(at));
                watched.angles.extend(these);
            }
        }
    }

    fn state(&self, share: f64) -> State<Diving> {
        State {
            body: Diving {
                plant: self.plant,
                law: self.law,
                motion: self.motion,
                share,
            },
            hydraulics: *self.dha.hydraulics(),
            sign: self.dha.sign(),
            time: self.tick as f64 * TICK,
        }
    }
}

/// Mean of an angle from its values at beginning, middle and end (Simpson's rule).
fn simpson([begin, middle, end]: [f64; 3]) -> f64 {
    (begin + 4.0 * middle + end) / 6.0
}

/// The vehicle with its controller as a [`Body`]: continuous between the controller's samples.
#[derive(Clone, Copy, Debug)]
pub struct Diving {
    plant: Plant,
    law: Law,
    motion: Motion,
    /// Integral term, rad.
    share: f64,
}

impl Body for Diving {
    fn advance(&mut self, angles: [f64; 3], h: f64) {
        if self.law.integral > 0.0 {
            let (_, drive) = self.law.evaluate(&self.plant, &self.motion, self.share);
            self.share = self.law.share.apply(self.share + drive * h).value;
        }
        let mean = simpson(angles);
        self.motion = self.plant.after(self.motion, h, |_| mean);
    }

    fn asked(&self) -> f64 {
        let (wanted, _) = self.law.evaluate(&self.plant, &self.motion, self.share);
        self.law.planes.apply(wanted).value
    }

    fn output(&self) -> f64 {
        self.motion.depth - SETPOINT
    }

    fn coordinates(&self) -> Vec<f64> {
        let m = &self.motion;
        let mut all = vec![
            m.pitch / SCALE,
            m.pitch_rate / SCALE,
            self.output() / (SCALE * FOOT),
        ];
        if self.law.integral > 0.0 {
            all.push(self.share / SCALE);
        }
        all
    }

    fn displace(&mut self, by: &[f64]) {
        self.motion.pitch += by[0] * SCALE;
        self.motion.pitch_rate += by[1] * SCALE;
        self.motion.depth += by[2] * SCALE * FOOT;
        if let Some(share) = by.get(3) {
            self.share += share * SCALE;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_control::Controller;
    use planesman_hydraulics::actuator_file::load;
    use planesman_msgs::builtin_interfaces::msg::Time;
    use planesman_msgs::planesman_msgs::msg::VehicleState;

    #[test]
    fn the_law_is_the_depth_controllers_to_the_last_bit() {
        let around = Loop {
            integral: 0.02,
            restoring: 0.163,
        };
        let set = load("auv").unwrap();
        let demand = Demand::angle(0.0);
        let mut flight = Flight::begin(&around, Dha::new(&set)).unwrap();
        let mut parameters = ControllerParameters {
            depth_setpoint: SETPOINT,
            ..ControllerParameters::default()
        };
        parameters.pitch.i = flight.law.integral;
        parameters.pitch.i_limit = FRAC_PI_2;
        let mut controller = Controller::new(&parameters).unwrap();
        for tick in 0..1200 {
            let motion = flight.motion;
            let mut state = VehicleState {
                depth: motion.depth,
                depth_rate: flight.plant.depth_rate(&motion),
                pitch: motion.pitch,
                pitch_rate: motion.pitch_rate,
                ..VehicleState::default()
            };
            state.header.stamp = Time::from_nanos(tick * STEPS * STEP_NANOS);
            let (command, _) = controller.on_state(&state).unwrap();
            flight.until(tick + 1, &|_| demand);
            assert_eq!(command.dive_planes, flight.asked, "tick {tick}");
        }
        assert!(flight.reached.is_some());
    }
}
