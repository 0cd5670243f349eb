//! Complete digital flight control: autopilot, pulse logic, hydraulics and missile (Figure 2-4).
//!
//! The actuator is in the report's simulation mode: open loop; the loop around the missile determines the position error. At the beginning of each
//! valve cycle the autopilot samples the missile and the logic commands at most one volume. Within the cycle the missile is integrated with the
//! nozzle angle of the exactly integrated ram.

use crate::ibm_1966::autopilot::DigitalAutopilot;
use crate::ibm_1966::case::{Case, RateSignal};
use crate::ibm_1966::missile::{Yaw, YawPlant};
use planesman_hydraulics::{Hydraulics, PulseLogic};

/// Runge-Kutta steps of the missile per valve cycle. The missile's poles are two orders of magnitude below the sampling frequency, but the ram's
/// motion, at 50 Hz, must be resolved.
const STEPS: u32 = 12;

/// Initial state of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Start {
    /// Yaw angle psi_0, rad, without sideslip.
    pub yaw: f64,
    /// Initial ram position, m.
    pub ram: f64,
}

/// State at an instant of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instant {
    /// Time from the start, s.
    pub time: f64,
    /// State of the missile.
    pub yaw: Yaw,
    /// Nozzle angle delta_a, rad.
    pub nozzle: f64,
    /// Ram position X_1, m.
    pub ram: f64,
    /// Differential pressure P_d, Pa.
    pub pressure: f64,
    /// Large volume commanded at the beginning of this cycle: +1, 0 or -1.
    pub quanta: i8,
}

/// The loop with its state; copying it copies the state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DigitalLoop {
    period: f64,
    moment_arm: f64,
    plant: YawPlant,
    rate: RateSignal,
    /// psi at the beginning of the last cycle, rad.
    last: f64,
    yaw: Yaw,
    autopilot: DigitalAutopilot,
    logic: PulseLogic,
    hydraulics: Hydraulics,
    /// Ram position at the beginning of the next cycle, m.
    ram: f64,
    cycles: u32,
}

impl Case {
    /// Starts the loop of this case.
    #[must_use]
    pub fn fly(&self, start: Start) -> DigitalLoop {
        DigitalLoop::new(self, start)
    }
}

impl DigitalLoop {
    /// The loop of a case, at rest except for `start`.
    #[must_use]
    pub fn new(case: &Case, start: Start) -> Self {
        let set = case.surrogate.fitted(case.set.clone());
        let mut hydraulics = Hydraulics::resting_at(&set, 1, start.ram);
        hydraulics.set_condition(case.condition);
        Self {
            period: set.cycle(),
            moment_arm: set.load.moment_arm,
            plant: case.plant,
            rate: case.rate,
            last: start.yaw,
            yaw: Yaw {
                angle: start.yaw,
                ..Yaw::default()
            },
            autopilot: DigitalAutopilot::new(case.gains),
            logic: PulseLogic::with_options(&set, case.options),
            hydraulics,
            ram: start.ram,
            cycles: 0,
        }
    }

    /// Time from the start to the beginning of the next cycle, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        f64::from(self.cycles) * self.period
    }

    /// Current state of the missile.
    #[must_use]
    pub fn yaw(&self) -> Yaw {
        self.yaw
    }

    /// Current ram position X_1, m.
    #[must_use]
    pub fn ram(&self) -> f64 {
        self.ram
    }

    /// Error eps at the last decision of the pulse logic, rad.
    #[must_use]
    pub fn error(&self) -> f64 {
        self.logic.error()
    }

    /// Simulates one valve cycle with `steering` pulses. `watch` receives the states from its beginning in equal steps, without its end. Returns the
    /// commanded volume: +1, 0 or -1.
    pub fn cycle(&mut self, steering: f64, mut watch: impl FnMut(&Instant)) -> i8 {
        let rate = match self.rate {
            RateSignal::Gyro => self.yaw.rate,
            RateSignal::Difference => (self.yaw.angle - self.last) / self.period,
        };
        self.last = self.yaw.angle;
        let input = self.autopilot.input(steering, self.yaw.angle, rate);
        let decision = self.logic.accumulate(input, self.ram);
        let quanta = self.hydraulics.begin_cycle(decision.command).large;
        let begin = self.time();
        let h = self.period / f64::from(STEPS);
        let (mut nozzle, mut pressure) = self.seen_at(0.0);
        for i in 0..STEPS {
            let at = f64::from(i) * h;
            watch(&Instant {
                time: begin + at,
                yaw: self.yaw,
                nozzle,
                ram: nozzle * self.moment_arm,
                pressure,
                quanta,
            });
            let (middle, _) = self.seen_at(at + 0.5 * h);
            let (end, pressure_after) = self.seen_at(at + h);
            self.yaw = self.plant.step(self.yaw, [nozzle, middle, end], h);
            (nozzle, pressure) = (end, pressure_after);
        }
        self.hydraulics.finish_cycle();
        self.ram = self.hydraulics.reading(self.period).ram.position;
        self.cycles += 1;
        quanta
    }

    /// delta_a, rad, and P_d, Pa, at `time` s within the cycle; times must not decrease.
    fn seen_at(&mut self, time: f64) -> (f64, f64) {
        let time = time.min(self.period);
        self.hydraulics.advance(time);
        let reading = self.hydraulics.reading(time);
        (reading.ram.position / self.moment_arm, reading.pressure)
    }
}
