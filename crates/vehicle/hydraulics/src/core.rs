//! The core of the actuator node: it reads a plane command and returns the plane motion over the coming tick.
//!
//! **A tick** is [t, t + tick]. The command stamped t applies to every valve cycle that begins in [t, t + tick). The cycles follow the
//! actuator's own clock, which starts at the first stamp. The motion is computed ahead on a copy. So any stamp may follow: also a stamp that skips
//! ticks, or a stamp before the tick's end.
//!
//! **Commands hold** for `command_timeout` from their stamp. Then the planes are commanded to neutral, and `command_stale` is set. Before the first
//! command the planes are neutral too.
//!
//! **Stamps**: a repetition of the last command's stamp gets the last answer again. A late command, whose tick was already answered without
//! it, gets that answer and applies from the next tick on. A stamp before the last command's stamp (or before the run, if no command has
//! come) means the clock was set back. A stamp more than 600 s after the last tick means the clock was set forward. Both begin a new run with
//! neutral planes at rest.
//!
//! In `dha_state` physical quantities are at the stamp; pulses, `inhibited`, `error` and `commanded_angle` belong to the decisions within
//! the tick.
//!
//! **Groups.** With `groups: together` one actuator moves the bow and stern planes. The differentials and the rudder pass through at once
//! without quantization, clipped to `command_limit` and held over the tick. They are empty (neutral) if they are 0 or the command is stale.
//! With `groups: each` bow, stern, roll and rudder have an actuator each ([`crate::groups`]). The thrust always passes through, clipped to
//! \[-1, 1\].
//!
//! A command with a number that is not finite is rejected and changes nothing. The states of the actuators do not depend on the division of
//! time into ticks, bit for bit; the samples of the motion within a tick differ by rounding.

use std::sync::Arc;

use planesman_circuit::MOST_FORCE;
use planesman_msgs::Message;
use planesman_msgs::builtin_interfaces::msg::{Duration, Time};
use planesman_msgs::planesman_msgs::msg::{DhaState, PlaneCommand, PlaneMotion};
use planesman_msgs::sensor_msgs::msg::JointState;
use planesman_msgs::std_msgs::msg::Header;

use crate::actuator_file::{self, ActuatorFileError};
use crate::actuator_model::{ActuatorModel, Model, Planes, Request};
use crate::actuator_set::{ActuatorFile, MOST_CYCLES_IN_FLIGHT};
use crate::condition::Condition;
use crate::dha::{Counts, Demand};
use crate::energy::Energy;
use crate::error::Error;
use crate::groups::{Group, Grouping};
use crate::modes::FrictionState;
use crate::parameters::{ActuatorParameters, Config, Member};

/// Frame of the plane angles: forward, right, down.
const FRAME: &str = "base_link_frd";

/// Longest gap between stamps that is simulated, ns.
const LONGEST_GAP: i64 = 600_000_000_000;

/// Largest number of motion samples in a tick.
const MOST_SAMPLES: i64 = 100_000;

/// Answer to a command: the motion, and the data from which the other messages are made when they have subscribers.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// Plane angles over the tick.
    pub motion: PlaneMotion,
    design: Arc<Design>,
    groups: Vec<Moved>,
    /// Whether the command has expired.
    stale: bool,
}

/// A group's actuator in one tick: planes at the stamp, and activity in the coming tick.
#[derive(Clone, Debug, PartialEq)]
struct Moved {
    planes: Planes,
    /// rad
    commanded: f64,
    /// `None` for an actuator without pulses.
    counts: Option<Counts>,
    /// Work of a circuit's supply in the tick, J.
    work: f64,
    /// Energies at the stamp; `None` for an actuator without hydraulics.
    energy: Option<Energy>,
}

impl Moved {
    /// Commanded volumes since the start; for a circuit, switchings of its valves.
    fn pulses(&self) -> u64 {
        let switchings = self
            .planes
            .chambers
            .map_or(0, |chambers| chambers.switchings);
        self.counts.map_or(switchings, |counts| counts.pulses)
    }

    /// Whether all numbers of the group are finite; `angles` is the group's motion over the tick, rad.
    fn is_finite(&self, angles: &[f64]) -> bool {
        let planes = &self.planes;
        let [p_a, p_b] = planes.chambers.map_or([0.0; 2], |it| it.pressures);
        let oil = planes.reading.map_or(0.0, |it| it.pressure + it.leaked);
        let energy = self.energy.map_or(0.0, |it| it.residual() + it.switching);
        let all = planes.angle + planes.rate + oil + p_a + p_b + self.work + energy;
        all.is_finite() && angles.iter().all(|it| it.is_finite())
    }

    fn at_stop(&self) -> bool {
        self.planes.reading.is_some_and(|reading| {
            matches!(reading.mode.friction, FrictionState::AtStop(_))
                || reading.mode.limited.is_some()
        }) || self
            .planes
            .chambers
            .is_some_and(|chambers| chambers.at_stop)
    }
}

impl Output {
    /// Lists the groups at their limits, one line of text for each group.
    #[must_use]
    pub fn limits(&self) -> Vec<String> {
        let line = |(member, moved): (&Member, &Moved)| {
            let limit = if moved.at_stop() {
                "at its stop"
            } else if moved.counts.is_some_and(|counts| counts.tally.inhibited) {
                "at its travel limit"
            } else {
                return None;
            };
            Some(format!("{}: {limit}", member.group.name()))
        };
        let members = self.design.config.members.iter();
        members.zip(&self.groups).filter_map(line).collect()
    }

    /// Mean hydraulic power over the tick, sum of all groups, W.
    #[must_use]
    pub fn hydraulic_power(&self) -> f64 {
        self.groups.iter().map(|moved| self.power(moved)).sum()
    }

    /// Commanded calibrated volumes since the start, sum of all groups.
    #[must_use]
    pub fn pulses(&self) -> u64 {
        self.groups.iter().map(Moved::pulses).sum()
    }

    fn power(&self, moved: &Moved) -> f64 {
        let work = moved.counts.map_or(moved.work, |counts| counts.tally.work);
        work / (self.motion.duration.nanos() as f64 * 1e-9)
    }

    /// Energies since the start, sum of all groups; `None` if no group has hydraulics.
    #[must_use]
    pub fn energy(&self) -> Option<Energy> {
        let energies = self.groups.iter().filter_map(|moved| moved.energy);
        energies.reduce(|sum, of_group| sum + of_group)
    }

    /// Gauge pressures p_A and p_B of each circuit of on/off valves at the stamp, Pa.
    pub fn chamber_pressures(&self) -> impl Iterator<Item = [f64; 2]> {
        let chambers = self.groups.iter().filter_map(|it| it.planes.chambers);
        chambers.map(|it| it.pressures)
    }

    /// Named planes and rams of each group at the stamp; the dive planes (bow and stern together) come first.
    #[must_use]
    pub fn planes(&self) -> JointState {
        let mut joints = JointState {
            header: self.motion.header.clone(),
            ..JointState::default()
        };
        let mut add = |name: String, angle: f64, rate: f64| {
            joints.name.push(name);
            joints.position.push(angle);
            joints.velocity.push(rate);
        };
        let grouping = self.design.config.parameters.groups;
        if grouping == Grouping::Each {
            let mean = |of: fn(&Planes) -> f64| {
                0.5 * (of(&self.groups[0].planes) + of(&self.groups[1].planes))
            };
            add(
                Group::DivePlanes.name().to_owned(),
                mean(|planes| planes.angle),
                mean(|planes| planes.rate),
            );
        }
        let groups = grouping.groups().iter().zip(&self.groups);
        for ((group, Moved { planes, .. }), file) in groups.zip(&self.design.files) {
            let ram = match group {
                Group::DivePlanes => "ram".to_owned(),
                other => format!("{}_ram", other.name()),
            };
            add(group.name().to_owned(), planes.angle, planes.rate);
            let arm = file.moment_arm();
            add(ram, planes.angle * arm, planes.rate * arm);
        }
        joints
    }

    /// State of each group's actuator: physical quantities at the stamp, decisions from the coming tick.
    #[must_use]
    pub fn states(&self) -> Vec<DhaState> {
        let Design { config, files } = &*self.design;
        let groups = config.members.iter().zip(files).zip(&self.groups);
        groups
            .map(|((member, file), moved)| self.state(config, member, file.moment_arm(), moved))
            .collect()
    }

    fn state(&self, config: &Config, member: &Member, moment_arm: f64, moved: &Moved) -> DhaState {
        let planes = &moved.planes;
        let mut state = DhaState {
            header: self.motion.header.clone(),
            group: member.group.name().to_owned(),
            commanded_angle: moved.commanded,
            command_stale: self.stale,
            ram: planes.angle * moment_arm,
            ram_velocity: planes.rate * moment_arm,
            plane_angle: planes.angle,
            sign: 1,
            faults: config.fault_texts(member).join("; "),
            ..DhaState::default()
        };
        if let Some(reading) = planes.reading {
            state.pressure = reading.pressure;
            state.volume = reading.ram.volume;
            state.leakage = reading.leaked;
            state.sign = reading.polarity;
            state.sliding = matches!(reading.mode.friction, FrictionState::Sliding(_));
            state.at_stop = moved.at_stop();
            state.pressure_limited = reading.mode.clamped.is_some();
        }
        state.hydraulic_power = self.power(moved);
        state.pulses = moved.pulses();
        if let Some(chambers) = planes.chambers {
            state.pressure = chambers.pressures[0] - chambers.pressures[1];
            state.volume = chambers.volume;
            state.sign = if planes.rate < 0.0 { -1 } else { 1 };
            state.sliding = chambers.sliding;
            state.at_stop = chambers.at_stop;
            state.error = moved.commanded - planes.angle;
        }
        if let Some(counts) = moved.counts {
            state.small_pulses = counts.small_pulses;
            state.sign_changes = counts.sign_changes;
            state.inhibited = counts.tally.inhibited;
            state.slewing = counts.tally.slews();

            state.error = counts.error;
            if let Some(cycle) = counts.limit_cycle {
                state.limit_cycle_frequency = cycle.frequency;
                state.limit_cycle_amplitude = cycle.amplitude;
            }
        }
        if let Some(energy) = moved.energy {
            energy.fill(&mut state);
        }
        state
    }
}

/// The actuators of all groups, driven by messages.
#[derive(Clone, Debug)]
pub struct Actuator {
    design: Arc<Design>,
    tick: i64,
    load_force: f64,
    run: Option<Run>,
}

/// To a tick.
type Answer = Result<Arc<Output>, Error>;

/// Fixed data for the computation of a tick.
#[derive(Clone, Debug, PartialEq)]
struct Design {
    /// Constants of each group's actuator.
    files: Vec<ActuatorFile>,
    config: Config,
}

/// A run: from its first stamp until the clock is set back.
#[derive(Clone, Debug)]
struct Run {
    /// First stamp, ns.
    began: i64,
    /// Stamp of the last tick, ns, and each group's actuator at that time.
    stamp: i64,
    now: Vec<ActuatorModel>,
    /// Actuators at the end of the last tick.
    ahead: Vec<ActuatorModel>,
    /// Demands of the last tick.
    acting: Demands,
    /// Last command, clipped.
    command: Option<ClippedCommand>,
    output: Arc<Output>,
    /// Answer to the tick before the last one.
    before: Option<Arc<Output>>,
}

/// A command after clipping, and its stamp, ns.
#[derive(Clone, Debug)]
struct ClippedCommand {
    command: PlaneCommand,
    stamp: i64,
}

impl ClippedCommand {
    /// Clips the angles of a command to `limit`, rad.
    fn new(command: &PlaneCommand, limit: f64) -> Self {
        Self {
            stamp: command.header.stamp.nanos(),
            command: PlaneCommand {
                dive_planes: command.dive_planes.clamp(-limit, limit),
                bow_stern_differential: command.bow_stern_differential.clamp(-limit, limit),
                roll_differential: command.roll_differential.clamp(-limit, limit),
                rudder: command.rudder.clamp(-limit, limit),
                thrust: command.thrust.clamp(-1.0, 1.0),
                ..PlaneCommand::default()
            },
        }
    }
}

/// Samples of a value held over a tick; empty for 0, which means neutral.
fn held_samples(value: f64) -> Vec<f64> {
    if value == 0.0 {
        Vec::new()
    } else {
        vec![value; 2]
    }
}

/// The demands: one request for each group until a deadline, ns, then neutral planes.
#[derive(Clone, Debug)]
struct Demands {
    requests: Vec<Request>,
    deadline: i64,
}

impl Demands {
    /// Request to the group `index` that applies at `stamp`.
    fn at(&self, index: usize, stamp: i64) -> Request {
        let mut request = self.requests[index];
        if stamp >= self.deadline {
            request.demand.angle = 0.0;
        }
        request
    }

    /// Runs the group `index` from one stamp to another, both in ns; the run began at `began`.
    fn drive(&self, index: usize, model: &mut ActuatorModel, began: i64, from: i64, to: i64) {
        if from < self.deadline {
            model.advance_to(to.min(self.deadline) - began, &self.requests[index]);
        }
        if to > self.deadline {
            model.advance_to(to - began, &self.at(index, self.deadline));
        }
    }
}

/// Checks the parameters against the actuators.
fn fit(config: &Config, files: &[ActuatorFile]) -> Result<(), Error> {
    if let Some(group) = config.faults.group
        && !config.parameters.groups.groups().contains(&group)
    {
        let groups: Vec<_> = config
            .parameters
            .groups
            .groups()
            .iter()
            .map(|g| g.name())
            .collect();
        return Err(Error::NoActuator {
            group: group.name(),
            groups: groups.join(", "),
        });
    }
    let mut faulty = config.members.iter().map(|m| config.fault_texts(m));
    let faults = config.faults.condition.faults_beside(&config.worn);
    if !faults.is_empty() && faulty.all(|texts| texts.is_empty()) {
        let whom = config.faults.group.map_or("all", Group::name);
        return Err(Error::NothingToFail(whom));
    }
    let hydraulic = |member: &&Member| member.model == Model::Dha;
    for (member, file) in config
        .members
        .iter()
        .zip(files)
        .filter(|(m, _)| hydraulic(m))
    {
        let set = match file {
            ActuatorFile::Metering(set) => set,
            ActuatorFile::Circuit(_) if config.condition(member.group) == Condition::SOUND => {
                continue;
            }
            ActuatorFile::Circuit(_) => {
                return Err(Error::SoundCircuit(member.actuator.clone()));
            }
        };
        if config.logic.two_speed && set.small.is_none() {
            return Err(Error::NoSmallVolume {
                actuator: member.actuator.clone(),
                group: member.group.name(),
            });
        }
        let slow_latch = config.condition(member.group).slow_latch;
        let last = set.delay() + slow_latch + 2.0 * set.flow_time;
        if slow_latch > 0.0 && last > set.cycle() * MOST_CYCLES_IN_FLIGHT as f64 {
            return Err(Error::SlowLatch {
                slow_latch,
                actuator: member.actuator.clone(),
            });
        }
    }
    Ok(())
}

impl Actuator {
    /// Creates the actuator that the parameters name, for ticks of `tick_nanos` ns, before its first stamp.
    ///
    /// # Errors
    /// [`Error`]: an actuator file, a tick that is not positive, parameters that do not fit the actuators.
    pub fn new(parameters: &ActuatorParameters, tick_nanos: i64) -> Result<Self, Error> {
        Self::of_files(parameters, tick_nanos, actuator_file::read)
    }

    /// Creates the actuator as [`Actuator::new`] does; `read` finds the actuators' files by name.
    ///
    /// # Errors
    /// Same as [`Actuator::new`].
    pub fn of_files(
        parameters: &ActuatorParameters,
        tick_nanos: i64,
        read: impl Fn(&str) -> Result<ActuatorFile, ActuatorFileError>,
    ) -> Result<Self, Error> {
        let config = Config::new(parameters);
        if tick_nanos <= 0 {
            return Err(Error::Tick(tick_nanos));
        }
        let files = config
            .members
            .iter()
            .map(|member| read(&member.actuator))
            .collect::<Result<Vec<_>, _>>()?;
        fit(&config, &files)?;
        Ok(Self {
            design: Arc::new(Design { files, config }),
            tick: tick_nanos,
            load_force: 0.0,
            run: None,
        })
    }

    fn config(&self) -> &Config {
        &self.design.config
    }

    /// The groups with an actuator, in the order of [`Output::states`].
    #[must_use]
    pub fn groups(&self) -> &'static [Group] {
        self.config().parameters.groups.groups()
    }

    /// Faults of the actuators, one line for each group with faults.
    #[must_use]
    pub fn faults(&self) -> Vec<String> {
        let line = |member: &Member| {
            let faults = self.config().fault_texts(member);
            let name = member.group.name();
            (!faults.is_empty()).then(|| format!("{name}: {}", faults.join("; ")))
        };
        self.config().members.iter().filter_map(line).collect()
    }

    /// Applies changed parameters from the next tick on.
    ///
    /// # Errors
    /// If `groups` or an actuator or model differs, which are fixed from the start, or if the parameters do not fit the actuators. The
    /// parameters then stay unchanged.
    pub fn set_parameters(&mut self, parameters: &ActuatorParameters) -> Result<(), Error> {
        let new = Config::new(parameters);
        let Design { files, config } = &*self.design;
        if new.members != config.members {
            return Err(Error::Fixed);
        }
        fit(&new, files)?;
        self.design = Arc::new(Design {
            files: files.clone(),
            config: new,
        });
        Ok(())
    }

    /// Sets the force on the ram of each circuit of on/off valves, against positive motion, N, from the next tick on; 0 at first. An
    /// actuator of metered volumes ignores it.
    ///
    /// # Errors
    /// If it is not finite or exceeds [`MOST_FORCE`]; the force then stays unchanged.
    pub fn set_load_force(&mut self, force: f64) -> Result<(), Error> {
        if !(-MOST_FORCE..=MOST_FORCE).contains(&force) {
            return Err(Error::LoadForce(force));
        }
        self.load_force = force;
        Ok(())
    }

    /// Returns the motion over the tick that begins at the command's stamp.
    ///
    /// # Errors
    /// If a number in the command is not finite; the actuator then stays unchanged. [`Error::Motion`]: the next stamp begins a new run.
    pub fn on_command(&mut self, command: &PlaneCommand) -> Result<Arc<Output>, Error> {
        if let Some(field) = command.first_non_finite() {
            return Err(Error::Command(field));
        }
        let stamp = command.header.stamp.nanos();
        let held = ClippedCommand::new(command, self.config().parameters.command_limit);
        let Some(run) = &mut self.run else {
            return self.begin(stamp, Some(held));
        };
        match &run.command {
            Some(last) if stamp == last.stamp => return Ok(run.output.clone()),
            Some(last) if stamp < last.stamp => return self.begin(stamp, Some(held)),
            None if stamp < run.began => return self.begin(stamp, Some(held)),
            _ => {}
        }
        if stamp <= run.stamp {
            // Its tick was answered in silence.
            run.command = Some(held);
            return Ok(run.output.clone());
        }
        if stamp.saturating_sub(run.stamp) > LONGEST_GAP {
            return self.begin(stamp, Some(held));
        }
        self.go_on(stamp, Some(held))
    }

    /// The answer to the tick before the last one, in the same run. The motion is repeated together with a repeated command, for a vehicle that needs
    /// the motion up to its present state.
    #[must_use]
    pub fn before(&self) -> Option<&Arc<Output>> {
        self.run.as_ref()?.before.as_ref()
    }

    /// Returns the motion over a tick without a command. A stamp that was already answered gets the same answer again.
    ///
    /// # Errors
    /// [`Error::Motion`].
    pub fn on_silence(&mut self, stamp: Time) -> Result<Arc<Output>, Error> {
        let stamp = stamp.nanos();
        match &self.run {
            None => self.begin(stamp, None),
            Some(run) if stamp <= run.stamp => Ok(run.output.clone()),
            Some(run) if stamp.saturating_sub(run.stamp) > LONGEST_GAP => self.begin(stamp, None),
            Some(run) => {
                let held = run.command.clone();
                self.go_on(stamp, held)
            }
        }
    }

    /// Begins a new run at the next stamp, for a vehicle that was reset.
    pub fn restart(&mut self) {
        self.run = None;
    }

    /// Starts a new run and answers its first tick.
    fn begin(&mut self, stamp: i64, command: Option<ClippedCommand>) -> Result<Arc<Output>, Error> {
        let models = self
            .config()
            .members
            .iter()
            .zip(&self.design.files)
            .map(|(member, file)| {
                ActuatorModel::new(member.model, file, self.config().parameters.first_order)
            })
            .collect();
        self.run = None;
        self.answer(stamp, stamp, models, command, None)
    }

    /// Advances the run to `stamp` under the last demands, and answers the tick that begins there.
    fn go_on(&mut self, stamp: i64, command: Option<ClippedCommand>) -> Result<Arc<Output>, Error> {
        let Some(run) = self.run.take() else {
            return self.begin(stamp, command);
        };
        let tick_end = run.stamp.saturating_add(self.tick);
        let (mut models, from) = if stamp >= tick_end {
            (run.ahead, tick_end)
        } else {
            (run.now, run.stamp)
        };
        for (index, model) in models.iter_mut().enumerate() {
            run.acting.drive(index, model, run.began, from, stamp);
        }
        self.answer(run.began, stamp, models, command, Some(run.output))
    }

    /// Computes and stores the tick from `stamp`; `now` is the actuators' state there.
    fn answer(
        &mut self,
        began: i64,
        stamp: i64,
        mut now: Vec<ActuatorModel>,
        command: Option<ClippedCommand>,
        before: Option<Arc<Output>>,
    ) -> Answer {
        let acting = self.asked(stamp, command.as_ref());
        for (index, model) in now.iter_mut().enumerate() {
            model.ask(stamp - began, &acting.at(index, stamp));
            if let ActuatorModel::Dha(dha) = model {
                // Counted is what the tick ahead brings.
                dha.take_tally();
            }
        }
        let mut ahead = now.clone();
        let mut angles = Vec::with_capacity(now.len());
        let groups = now.iter().zip(&mut ahead).enumerate();
        let groups = groups
            .map(|(index, (now, ahead))| {
                angles.push(self.angles(&acting, index, ahead, began, stamp));
                let counts = match ahead {
                    ActuatorModel::Dha(dha) => Some(dha.take_counts()),
                    _ => None,
                };
                let work = match (now, ahead) {
                    (ActuatorModel::Circuit(now, _), ActuatorModel::Circuit(ahead, _)) => {
                        let begin = stamp - began;
                        let end = begin + self.tick;
                        ahead.ledger(end).supply - now.ledger(begin).supply
                    }
                    _ => 0.0,
                };
                Moved {
                    planes: now.planes(stamp - began),
                    work,
                    commanded: acting.at(index, stamp).demand.angle,
                    counts,
                    energy: now.energy(stamp - began),
                }
            })
            .collect::<Vec<_>>();
        for (index, (moved, angles)) in groups.iter().zip(&angles).enumerate() {
            let unsolved = ahead[index].unsolved();
            if unsolved.is_some() || !moved.is_finite(angles) {
                let Member {
                    group, actuator, ..
                } = &self.config().members[index];
                return Err(Error::Motion {
                    actuator: actuator.clone(),
                    group: group.name(),
                    time: stamp as f64 * 1e-9,
                    unsolved,
                });
            }
        }
        let stale = stamp >= acting.deadline;
        let obeyed = command.as_ref().filter(|_| !stale);
        let output = Arc::new(Output {
            motion: self.motion(stamp, obeyed, angles),
            design: Arc::clone(&self.design),
            groups,
            stale,
        });
        self.run = Some(Run {
            before,
            began,
            stamp,
            now,
            ahead,
            acting,
            command,
            output: Arc::clone(&output),
        });
        Ok(output)
    }

    /// Runs the group `index` over the tick from `stamp`, and returns its angle at the samples.
    fn angles(
        &self,
        acting: &Demands,
        index: usize,
        model: &mut ActuatorModel,
        began: i64,
        stamp: i64,
    ) -> Vec<f64> {
        let intervals = (self.tick as u64)
            .div_ceil(self.config().sample_interval.max(1) as u64)
            .clamp(1, MOST_SAMPLES as u64) as i64;
        let interval = self.tick as f64 * 1e-9 / intervals as f64;
        // The i-th of so many equal parts of the tick, rounded down: tick * i / intervals without a wide number.
        let (whole, rest) = (self.tick / intervals, self.tick % intervals);
        let mut angles = Vec::with_capacity(intervals as usize + 1);
        let mut from = stamp;
        // The last sample by itself: the next tick starts from it.
        for last in [intervals - 1, intervals] {
            while angles.len() as i64 <= last {
                let i = angles.len() as i64;
                let to = stamp.saturating_add(whole * i + rest * i / intervals);
                acting.drive(index, model, began, from, to);
                model.sample(to - began, interval, (last + 1 - i) as usize, &mut angles);
                from = to;
            }
        }
        angles
    }

    /// Motion over the tick: of the actuators, and of the channels that pass through.
    fn motion(
        &self,
        stamp: i64,
        obeyed: Option<&ClippedCommand>,
        angles: Vec<Vec<f64>>,
    ) -> PlaneMotion {
        let through = |of: fn(&PlaneCommand) -> f64| {
            obeyed.map_or_else(Vec::new, |held| held_samples(of(&held.command)))
        };
        let mut motion = PlaneMotion {
            header: Header {
                stamp: Time::from_nanos(stamp),
                frame_id: [self.config().parameters.frame_prefix.as_str(), FRAME].concat(),
            },
            duration: Duration::from_nanos(self.tick),
            dive_planes: Vec::new(),
            bow_stern_differential: through(|command| command.bow_stern_differential),
            roll_differential: through(|command| command.roll_differential),
            rudder: through(|command| command.rudder),
            thrust: through(|command| command.thrust),
        };
        self.config().parameters.groups.fill(&mut motion, angles);
        motion
    }

    /// The demands from `stamp` on, with or without a command.
    fn asked(&self, stamp: i64, command: Option<&ClippedCommand>) -> Demands {
        let config = self.config();
        let deadline = match command {
            // At its own stamp a command is never stale.
            Some(held) if held.stamp == stamp => {
                stamp.saturating_add(config.command_timeout.max(1))
            }
            Some(held) => held.stamp.saturating_add(config.command_timeout),
            None => i64::MIN,
        };
        let limit = config.parameters.command_limit;
        let request = |group: Group| Request {
            demand: Demand {
                angle: command.map_or(0.0, |held| group.angle(&held.command).clamp(-limit, limit)),
                position_loop: config.parameters.position_loop,
                logic: config.logic,
                condition: config.condition(group),
            },
            load_force: self.load_force,
            lag: config.parameters.first_order,
        };
        Demands {
            requests: self.groups().iter().map(|group| request(*group)).collect(),
            deadline,
        }
    }
}
