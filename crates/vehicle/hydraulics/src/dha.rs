//! The complete digital hydraulic actuator: pulse logic and hydraulics on the actuator's own clock.
//!
//! At the beginning of each valve cycle the logic determines an error and commands at most one volume. In the position loop (the report's
//! analog mode) it compares the commanded plane angle with the measured one. In open loop (the report's simulation mode) it sums the
//! commands and the volumes it has sent. An incremental actuator has no memory of its position: in open loop, any leakage becomes an angle
//! error. The position loop is therefore the default on a slow vehicle.

use crate::actuator_set::ActuatorSet;
use crate::condition::{Condition, Encoder};
use crate::cycle_clock::CycleClock;
use crate::energy::Energy;
use crate::hydraulics::{Hydraulics, Reading};
use crate::limit_cycle::{LimitCycle, Oscillation};
use crate::position_loop::PositionLoop;
use crate::pulse_logic::{Command, Decision, Options, PulseLogic, Volume};
use crate::valves::Stroke;

/// The demand on the actuator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Demand {
    /// delta_c, rad.
    pub angle: f64,
    /// Whether the position loop is closed.
    pub position_loop: bool,
    /// The pulse logic's options.
    pub logic: Options,
    /// Wear and faults.
    pub condition: Condition,
}

impl Demand {
    /// Returns a demand for an angle, rad, in the position loop, single-speed, with a sound actuator.
    #[must_use]
    pub fn angle(angle: f64) -> Self {
        Self {
            angle,
            position_loop: true,
            logic: Options::SINGLE_SPEED,
            condition: Condition::SOUND,
        }
    }
}

/// The commands to the valves since the last count.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    /// Number of valve cycles that have begun.
    pub cycles: u64,
    /// Number of these cycles with a commanded volume.
    pub volumes: u64,
    /// Whether the travel limit refused a volume.
    pub inhibited: bool,
    /// Hydraulic work, J: (A_R/A_L) P_h V_c for each moved volume.
    pub work: f64,
}

impl Tally {
    /// Whether a volume was commanded in every cycle: the actuator moves at its slew rate.
    #[must_use]
    pub fn slews(&self) -> bool {
        self.cycles > 0 && self.volumes == self.cycles
    }
}

/// Counters of the actuator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Counts {
    /// Commands since the last count.
    pub tally: Tally,
    /// These are the values of the functions of [`Dha`] with the same names.
    pub pulses: u64,
    pub small_pulses: u64,
    pub sign_changes: u64,
    pub error: f64,
    pub limit_cycle: Option<Oscillation>,
}

/// The actuator. A copy behaves identically from then on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dha {
    moment_arm: f64,
    /// V_cb and V_cs, m^3.
    volumes: (f64, f64),
    /// (A_R/A_L) P_h, Pa: work per m^3 metered.
    work_per_volume: f64,
    clock: CycleClock,
    hydraulics: Hydraulics,
    logic: PulseLogic,
    position_loop: PositionLoop,
    /// In open loop, the angle commanded in the last cycle.
    open_loop_angle: Option<f64>,
    /// Position at which the frozen encoder has stopped, m.
    frozen_at: Option<f64>,
    /// Whether the present cycle has begun; false before the first advance.
    begun: bool,
    pulses: u64,
    small_pulses: u64,
    sign_changes: u64,
    /// The last sign pulse.
    sign: i8,
    limit_cycle: LimitCycle,
    tally: Tally,
}

impl Dha {
    /// Returns an actuator at rest with neutral planes, at the start of its clock.
    #[must_use]
    pub fn new(set: &ActuatorSet) -> Self {
        Self::settled(set, 1)
    }

    /// Like [`Dha::new`], with the sign valve and the last sign pulse at `sign`, +1 or -1.
    #[must_use]
    pub fn settled(set: &ActuatorSet, sign: i8) -> Self {
        Self::resting_at(set, sign, 0.0)
    }

    /// Like [`Dha::settled`], with the ram at rest at `position`, m.
    #[must_use]
    pub fn resting_at(set: &ActuatorSet, sign: i8, position: f64) -> Self {
        Self {
            moment_arm: set.load.moment_arm,
            volumes: (set.volume, set.small.map_or(0.0, |small| small.volume)),
            work_per_volume: set.resting_pressure(),
            clock: CycleClock::new(set.frequency_millihertz),
            hydraulics: Hydraulics::resting_at(set, sign, position),
            logic: PulseLogic::new(set).settled(sign),
            position_loop: PositionLoop::new(set),
            open_loop_angle: None,
            frozen_at: None,
            begun: false,
            pulses: 0,
            small_pulses: 0,
            sign_changes: 0,
            sign,
            limit_cycle: LimitCycle::new(),
            tally: Tally::default(),
        }
    }

    /// Keeps the energies from now on ([`Dha::energy`]). The motion does not depend on this.
    #[must_use]
    pub fn keeping_energy(mut self) -> Self {
        self.hydraulics.keep_energy();
        self
    }

    /// Energies up to the last change of flow or law, at most one valve cycle ago; `None` if they are not kept.
    #[must_use]
    pub fn energy(&self) -> Option<Energy> {
        self.hydraulics.booked_energy()
    }

    /// Runs to the instant `nanos` after the start. Cycles that begin before this instant use `demand`; a cycle that begins exactly then
    /// waits for the next call. An earlier instant has no effect.
    #[inline]
    pub fn advance_to(&mut self, nanos: i64, demand: Demand) {
        if !self.begun && nanos > 0 {
            self.begin_cycle(demand);
            self.begun = true;
        }
        if !self.begun {
            return;
        }
        while self.clock.ends_before(nanos) {
            self.hydraulics.finish_cycle();
            self.clock.next();
            self.begin_cycle(demand);
        }
        self.hydraulics.advance(self.clock.time_in_cycle(nanos));
    }

    /// Reading of the hydraulics at the instant `nanos`, up to which the actuator has been advanced.
    #[must_use]
    pub fn reading(&self, nanos: i64) -> Reading {
        self.hydraulics.reading(self.time_in_cycle(nanos))
    }

    /// Appends the plane angle, rad, at the instant `nanos`, up to which the actuator has been advanced, and at later times `interval` s
    /// apart. Sampling stops before the ram's law changes, and after `count` values.
    pub(crate) fn sample(&self, nanos: i64, interval: f64, count: usize, angles: &mut Vec<f64>) {
        let first = angles.len();
        self.hydraulics
            .sample(self.time_in_cycle(nanos), interval, count, angles);
        for angle in &mut angles[first..] {
            *angle /= self.moment_arm;
        }
    }

    fn time_in_cycle(&self, nanos: i64) -> f64 {
        if self.begun {
            self.clock.time_in_cycle(nanos)
        } else {
            0.0
        }
    }

    /// delta_a = X_1/R, rad.
    #[must_use]
    pub fn plane_angle(&self, reading: &Reading) -> f64 {
        reading.ram.position / self.moment_arm
    }

    /// delta_a, rad, at the instant `nanos`, up to which the actuator has been advanced: the value of the reading, computed faster.
    #[must_use]
    pub fn angle(&self, nanos: i64) -> f64 {
        self.hydraulics.position(self.time_in_cycle(nanos)) / self.moment_arm
    }

    /// The planes' rate, rad/s.
    #[must_use]
    pub fn plane_rate(&self, reading: &Reading) -> f64 {
        reading.ram.velocity / self.moment_arm
    }

    /// Commanded calibrated volumes since the start, both signs.
    #[must_use]
    pub fn pulses(&self) -> u64 {
        self.pulses
    }

    /// Number of small volumes among the calibrated volumes.
    #[must_use]
    pub fn small_pulses(&self) -> u64 {
        self.small_pulses
    }

    /// Changes of the sign pulse since the start.
    #[must_use]
    pub fn sign_changes(&self) -> u64 {
        self.sign_changes
    }

    /// T, s.
    #[must_use]
    pub fn cycle(&self) -> f64 {
        self.clock.period()
    }

    /// The last sign pulse: +1 or -1.
    #[must_use]
    pub fn sign(&self) -> i8 {
        self.sign
    }

    /// Valves, metering and ram in the present cycle.
    #[must_use]
    pub fn hydraulics(&self) -> &Hydraulics {
        &self.hydraulics
    }

    /// eps, rad, at the last decision.
    #[must_use]
    pub fn error(&self) -> f64 {
        self.logic.error()
    }

    /// The limit cycle of the actuator; `None` if there is no limit cycle.
    #[must_use]
    pub fn limit_cycle(&self) -> Option<Oscillation> {
        self.limit_cycle
            .oscillation(self.clock.cycle(), self.clock.period())
    }

    /// The commands to the valves since the last call.
    pub fn take_tally(&mut self) -> Tally {
        std::mem::take(&mut self.tally)
    }

    /// Returns all counters, and the commands since the last call.
    pub(crate) fn take_counts(&mut self) -> Counts {
        Counts {
            tally: self.take_tally(),
            pulses: self.pulses(),
            small_pulses: self.small_pulses(),
            sign_changes: self.sign_changes(),
            error: self.error(),
            limit_cycle: self.limit_cycle(),
        }
    }

    /// X_1, m, as measured by the encoder. The travel limit has its own switches.
    fn measured(&mut self, encoder: Encoder, ram: f64) -> f64 {
        self.frozen_at = match encoder {
            Encoder::Frozen => self.frozen_at.or(Some(ram)),
            Encoder::Sound | Encoder::Lost => None,
        };
        self.frozen_at.unwrap_or(ram)
    }

    /// Decides the command of the cycle and starts its stroke.
    fn begin_cycle(&mut self, demand: Demand) {
        self.hydraulics.set_condition(demand.condition);
        // The cycle before has been finished, so this is the ram at the begin of the new one.
        let before = if self.begun { self.clock.period() } else { 0.0 };
        let ram = self.hydraulics.position(before);
        let measured = self.measured(demand.condition.encoder, ram);
        let predicted = self
            .position_loop
            .error(demand.angle, measured / self.moment_arm);
        self.logic.set_options(demand.logic);
        let decision = if demand.position_loop && demand.condition.encoder != Encoder::Lost {
            self.open_loop_angle = None;
            self.logic.decide(predicted, ram)
        } else {
            // Opening the loop starts from the error there is.
            let last = self.open_loop_angle.unwrap_or_else(|| {
                self.logic.restart_from(predicted);
                demand.angle
            });
            self.open_loop_angle = Some(demand.angle);
            self.logic.accumulate(demand.angle - last, ram)
        };
        let stroke = self.hydraulics.begin_cycle(decision.command);
        self.position_loop.remember(decision.command);
        self.count(decision, stroke, &demand.condition);
        self.limit_cycle.observe(
            self.clock.cycle(),
            decision.command.sign,
            ram / self.moment_arm,
        );
    }

    fn count(&mut self, decision: Decision, stroke: Stroke, condition: &Condition) {
        let Command { volume, sign } = decision.command;
        let commanded = u64::from(volume != Volume::None);
        self.pulses += commanded;
        self.small_pulses += u64::from(volume == Volume::Small);
        self.sign_changes += u64::from(sign != self.sign);
        self.sign = sign;
        self.tally.cycles += 1;
        self.tally.volumes += commanded;
        self.tally.inhibited |= decision.inhibited;
        let (large, small) = self.volumes;
        let moved = f64::from(stroke.large.abs()) * large + f64::from(stroke.small.abs()) * small;
        let left = (1.0 - condition.short_volume) * (1.0 - condition.lost_supply);
        self.tally.work += self.work_per_volume * moved * left;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::actuator_file::load;
    use planesman_units::DEGREE;

    fn tight() -> ActuatorSet {
        let mut set = load("auv").expect("built in");
        (set.rate_gain, set.error_rate) = (0.0, 0.0);
        set
    }

    fn angle_after(dha: &mut Dha, nanos: i64, demand: Demand) -> f64 {
        dha.advance_to(nanos, demand);
        dha.plane_angle(&dha.reading(nanos)) / DEGREE
    }

    #[test]
    fn the_planes_come_within_the_dead_zone_and_the_stiction_band() {
        let mut dha = Dha::new(&tight());
        let angle = angle_after(&mut dha, 1_000_000_000, Demand::angle(12.3 * DEGREE));
        assert!((angle - 12.3).abs() < 0.3125 + 0.12, "{angle}");
        assert!((23..=26).contains(&dha.pulses()));
    }

    #[test]
    fn the_planes_slew_at_forty_degrees_a_second() {
        let mut dha = Dha::new(&tight());
        let demand = Demand::angle(30.0 * DEGREE);
        let early = angle_after(&mut dha, 200_000_000, demand);
        let late = angle_after(&mut dha, 500_000_000, demand);
        assert!(((late - early) / 0.3 - 40.0).abs() < 1.0);
    }

    #[test]
    fn open_loop_the_logic_counts_what_it_sent_and_leakage_becomes_an_error() {
        let open = Demand {
            position_loop: false,
            ..Demand::angle(10.0 * DEGREE)
        };
        let minute = 60_000_000_000;
        let tight = angle_after(&mut Dha::new(&tight()), minute, open);
        assert!((tight - 10.0).abs() < 0.44, "{tight}");
        let leaky = load("auv").expect("built in");
        let drifted = angle_after(&mut Dha::new(&leaky), minute, open);
        assert!((drifted - 10.0).abs() > 5.0, "{drifted}");
        let held = angle_after(&mut Dha::new(&leaky), minute, Demand::angle(10.0 * DEGREE));
        assert!((held - 10.0).abs() < 0.6, "{held}");
    }

    #[test]
    fn a_constant_angle_is_held_without_a_pulse_when_nothing_leaks() {
        for tenths in (1..300).step_by(7) {
            let mut dha = Dha::new(&tight());
            let demand = Demand::angle(f64::from(tenths) * 0.1 * DEGREE);
            dha.advance_to(2_000_000_000, demand);
            let pulses = dha.pulses();
            dha.advance_to(10_000_000_000, demand);
            assert_eq!(dha.pulses(), pulses, "{tenths}");
        }
    }

    #[test]
    fn the_hydraulic_power_of_slewing_polaris_is_the_reports_two_horsepower() {
        let set = load("table_4_1").expect("built in");
        let mut dha = Dha::new(&set);
        dha.advance_to(1_000_000_000, Demand::angle(90.0 * DEGREE));
        let tally = dha.take_tally();
        assert!(tally.slews() && !tally.inhibited);
        // W = X_1 A_L P_h (A_R/A_L) f = 14170 in lb/s at 82.5 Hz.
        let seconds = tally.cycles as f64 / 82.5;
        let watts = tally.work / seconds;
        assert!((watts / 1601.0 - 1.0).abs() < 2e-3, "{watts} W");
        assert_eq!(dha.take_tally(), Tally::default());
    }

    #[test]
    fn opening_the_loop_moves_nothing_by_itself() {
        let mut dha = Dha::new(&tight());
        let closed = Demand::angle(12.3 * DEGREE);
        let before = angle_after(&mut dha, 1_000_000_000, closed);
        let open = Demand {
            position_loop: false,
            ..closed
        };
        let after = angle_after(&mut dha, 2_000_000_000, open);
        assert!((after - before).abs() < 1e-9, "{before} {after}");
    }

    #[test]
    fn a_cycle_that_begins_with_the_tick_acts_on_the_ticks_command() {
        let mut early = Dha::new(&tight());
        let mut late = early;
        early.advance_to(50_000_000, Demand::angle(0.0));
        late.advance_to(50_000_001, Demand::angle(0.0));
        let asked = Demand::angle(10.0 * DEGREE);
        early.advance_to(60_000_000, asked);
        late.advance_to(60_000_000, asked);
        assert_eq!((early.pulses(), late.pulses()), (1, 0));
    }
}
