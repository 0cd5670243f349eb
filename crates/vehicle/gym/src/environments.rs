//! The episodes of many vehicles, stepped in parallel on all cores.

use std::sync::{Mutex, PoisonError};

use planesman_parallel::on_all_cores;
use planesman_vehicle::six_dof::{Batch, State, Vehicle, Water, runge_kutta};
use planesman_vehicle::standard_normal;
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng as _;

use crate::options::{Options, Setting};
use crate::refused::Refused;
use crate::task::{MOST, Outcome, Target, Task, uniform};

/// Number of environments in a part, which one core steps.
const PART: usize = 64;
/// Number of draws of factors before all are considered impossible.
const DRAWS: usize = 100;
/// A motion beyond this value has failed \[m, m/s, rad/s\].
const LARGEST: f64 = 1e4;

/// The results of a step of all environments.
#[derive(Clone, Debug, Default)]
pub struct Stepped {
    /// A row for each environment, in the order of [`Task::quantities`].
    pub observations: Vec<f32>,
    /// One number for each environment.
    pub rewards: Vec<f64>,
    /// One outcome for each environment.
    pub outcomes: Vec<Outcome>,
}

/// Many environments of one task.
#[derive(Debug)]
pub struct Environments {
    setting: Setting,
    all: Vec<One>,
}

/// An environment.
#[derive(Clone, Debug)]
struct One {
    random: Pcg64,
    /// The environment's own vehicle, if vehicles are randomised, and the random factors.
    own: Option<Vehicle>,
    factors: Vec<f64>,
    state: State,
    water: Water<f64>,
    target: Target,
    /// The true quantities last observed.
    seen: [f64; MOST],
    bias: [f64; MOST],
    steps: u32,
    is_over: bool,
}

/// A part of all environments, and the place for its results.
struct Part<'a> {
    all: &'a mut [One],
    actions: &'a [f32],
    observations: &'a mut [f32],
    rewards: &'a mut [f64],
    outcomes: &'a mut [Outcome],
}

impl Environments {
    /// `count` environments, each at the beginning of an episode; number `k` has the seed `seed + k`.
    ///
    /// # Errors
    /// [`Refused`], if an option is invalid, or the vehicle cannot be used.
    pub fn new(options: &Options, count: usize, seed: u64) -> Result<Self, Refused> {
        let setting = Setting::new(options)?;
        let seeds = (0..count as u64).map(|k| seed.wrapping_add(k));
        let start = setting
            .task
            .begin(&setting.conditions, &mut Pcg64::seed_from_u64(seed));
        let one = |seed| One {
            random: Pcg64::seed_from_u64(seed),
            own: None,
            factors: Vec::new(),
            state: start.state,
            water: Water::steady(start.current),
            target: start.target,
            seen: [0.0; MOST],
            bias: [0.0; MOST],
            steps: 0,
            is_over: false,
        };
        let mut made = Self {
            all: seeds.map(one).collect(),
            setting,
        };
        made.reset(None)?;
        Ok(made)
    }

    /// How many.
    #[must_use]
    pub fn len(&self) -> usize {
        self.all.len()
    }

    /// Whether there are no environments.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// Their task.
    #[must_use]
    pub fn task(&self) -> Task {
        self.setting.task
    }

    /// The name of each action's target, with the value at -1 and at 1.
    #[must_use]
    pub fn actions(&self) -> &[(String, [f64; 2])] {
        &self.setting.moved
    }

    /// The state of environment `k`.
    #[must_use]
    pub fn state(&self, k: usize) -> State {
        self.all[k].state
    }

    /// The factors of environment `k`'s vehicle, in the order of [`Options::randomise`].
    #[must_use]
    pub fn factors(&self, k: usize) -> &[f64] {
        &self.all[k].factors
    }

    /// Begins an episode in each environment, with the given seeds or the next numbers; returns the first observations.
    ///
    /// # Errors
    /// [`Refused`], if the number of seeds is wrong, or no drawn factors give a possible vehicle.
    pub fn reset(&mut self, seeds: Option<&[u64]>) -> Result<Vec<f32>, Refused> {
        if let Some(seeds) = seeds {
            if seeds.len() != self.all.len() {
                let reason = format!("{} given; {} are expected", seeds.len(), self.all.len());
                return Err(Refused::option("seeds", reason));
            }
            for (one, seed) in self.all.iter_mut().zip(seeds) {
                one.random = Pcg64::seed_from_u64(*seed);
            }
        }
        let stepped = self.in_parts(&[], |setting, part| {
            for (one, row) in part.all.iter_mut().zip(rows(part.observations, setting)) {
                one.begin(setting)?;
                one.observe(setting, row);
            }
            Ok(())
        });
        stepped.map(|it| it.observations)
    }

    /// Advances all environments by one step. `actions` has one row for each environment, of numbers limited to -1 to 1. If an episode was
    /// over, a new one begins instead, with its first observation and a reward of 0.
    ///
    /// # Errors
    /// [`Refused`], if the number of actions is wrong or one is not a number, or no drawn factors give a possible vehicle.
    pub fn step(&mut self, actions: &[f32]) -> Result<Stepped, Refused> {
        let expected = self.all.len() * self.setting.moved.len();
        if actions.len() != expected {
            let reason = format!(
                "{} numbers are given; {expected} are expected",
                actions.len()
            );
            return Err(Refused::option("actions", reason));
        }
        if let Some(place) = actions.iter().position(|x| x.is_nan()) {
            let reason = format!(
                "the action of environment {} is not a number",
                place / self.setting.moved.len()
            );
            return Err(Refused::option("actions", reason));
        }
        self.in_parts(actions, advance)
    }

    /// Processes all parts on all cores.
    fn in_parts(
        &mut self,
        actions: &[f32],
        work: impl Fn(&Setting, &mut Part<'_>) -> Result<(), Refused> + Sync,
    ) -> Result<Stepped, Refused> {
        let (count, width) = (self.all.len(), self.setting.task.quantities().len());
        let mut stepped = Stepped {
            observations: vec![0.0; count * width],
            rewards: vec![0.0; count],
            outcomes: vec![Outcome::Running; count],
        };
        let setting = &self.setting;
        let mut actions = actions.chunks(PART * setting.moved.len());
        let parts = self.all.chunks_mut(PART);
        let parts = parts.zip(stepped.observations.chunks_mut(PART * width));
        let parts = parts.zip(stepped.rewards.chunks_mut(PART));
        let parts = parts.zip(stepped.outcomes.chunks_mut(PART));
        let parts = parts.map(|(((all, observations), rewards), outcomes)| {
            Mutex::new(Part {
                all,
                actions: actions.next().unwrap_or(&[]),
                observations,
                rewards,
                outcomes,
            })
        });
        let parts: Vec<_> = parts.collect();
        let done = on_all_cores(&parts, |part| {
            work(
                setting,
                &mut part.lock().unwrap_or_else(PoisonError::into_inner),
            )
        });
        done.into_iter().collect::<Result<(), _>>()?;
        drop(parts);
        Ok(stepped)
    }
}

/// The row of each environment.
fn rows<'a>(observations: &'a mut [f32], setting: &Setting) -> std::slice::ChunksMut<'a, f32> {
    observations.chunks_mut(setting.task.quantities().len())
}

/// Advances a part by one step.
fn advance(setting: &Setting, part: &mut Part<'_>) -> Result<(), Refused> {
    let width = setting.moved.len();
    let dt = setting.conditions.step / f64::from(setting.substeps);
    let (mut inputs, mut thrusts) = (Vec::new(), Vec::new());
    let actions = part.actions.chunks(width);
    let states: Vec<State> = match setting.randomise.is_empty() {
        // All of one vehicle: side by side, which is as alone.
        true => {
            let states: Vec<State> = part.all.iter().map(|one| one.state).collect();
            let mut batch = Batch::new(&setting.vehicle, &states);
            for (k, (one, row)) in part.all.iter().zip(actions).enumerate() {
                setting.actions.inputs(row, &mut inputs, &mut thrusts);
                batch.set_inputs(k, &inputs);
                batch.set_water(k, &one.water);
            }
            batch.advance(setting.substeps, dt);
            (0..batch.len()).map(|k| batch.state(k)).collect()
        }
        false => {
            let alone = part.all.iter().zip(actions).map(|(one, row)| {
                let vehicle = one.own.as_ref().unwrap_or(&setting.vehicle);
                setting.actions.inputs(row, &mut inputs, &mut thrusts);
                (0..setting.substeps).fold(one.state, |state, _| {
                    runge_kutta(vehicle, &state, &inputs, &one.water, dt)
                })
            });
            alone.collect()
        }
    };
    let actions = part.actions.chunks(width);
    let results = part.rewards.iter_mut().zip(part.outcomes.iter_mut());
    let results = results.zip(rows(part.observations, setting));
    for (((one, state), row), ((reward, outcome), seen)) in
        part.all.iter_mut().zip(states).zip(actions).zip(results)
    {
        if one.is_over {
            one.begin(setting)?;
        } else {
            let square = |x: &f32| f64::from(x.clamp(-1.0, 1.0)) * f64::from(x.clamp(-1.0, 1.0));
            let effort = row.iter().map(square).sum::<f64>() / width as f64;
            (*reward, *outcome) = one.arrive(setting, state, effort);
        }
        one.observe(setting, seen);
    }
    Ok(())
}

impl One {
    /// Begins an episode.
    fn begin(&mut self, setting: &Setting) -> Result<(), Refused> {
        if !setting.randomise.is_empty() {
            self.draw_vehicle(setting)?;
        }
        let start = setting.task.begin(&setting.conditions, &mut self.random);
        self.state = start.state;
        self.water = Water::steady(start.current);
        self.target = start.target;
        self.seen = setting.task.numbers(&self.state, self.target);
        if setting.sensors {
            for (bias, of) in self.bias.iter_mut().zip(setting.task.quantities()) {
                *bias = of.deviation * standard_normal(&mut self.random);
            }
        }
        (self.steps, self.is_over) = (0, false);
        Ok(())
    }

    /// A vehicle with random factors. Impossible vehicles are drawn again.
    fn draw_vehicle(&mut self, setting: &Setting) -> Result<(), Refused> {
        let mut left = DRAWS;
        loop {
            let names = setting.randomise.iter();
            self.factors.clear();
            self.factors.extend(
                names
                    .clone()
                    .map(|(_, range)| uniform(&mut self.random, *range)),
            );
            let factors = names
                .map(|(name, _)| name.as_str())
                .zip(self.factors.iter().copied());
            left -= 1;
            match setting.vehicle.scaled(factors) {
                Ok(vehicle) => {
                    self.own = Some(vehicle);
                    return Ok(());
                }
                Err(reason) if left == 0 => return Err(reason.into()),
                Err(_) => {}
            }
        }
    }

    /// Takes the state at the end of a step.
    fn arrive(&mut self, setting: &Setting, state: State, effort: f64) -> (f64, Outcome) {
        self.steps += 1;
        let before = self.seen;
        let is_motion = state.row().iter().all(|x| x.abs() < LARGEST);
        if is_motion {
            self.state = state;
            self.seen = setting.task.numbers(&state, self.target);
        }
        let (reward, outcome) =
            setting
                .task
                .judge(&setting.conditions, &before, &self.seen, effort);
        let outcome = match outcome {
            _ if !is_motion => Outcome::Failed,
            Outcome::Running if self.steps >= setting.steps => Outcome::TimeUp,
            outcome => outcome,
        };
        self.is_over = outcome != Outcome::Running;
        (reward, outcome)
    }

    /// Writes the observations: the true quantities, or sensor readings.
    fn observe(&mut self, setting: &Setting, row: &mut [f32]) {
        let quantities = setting.task.quantities().iter();
        for (((to, of), truth), bias) in
            row.iter_mut().zip(quantities).zip(self.seen).zip(self.bias)
        {
            let told = match setting.sensors {
                true => truth + bias + of.deviation * standard_normal(&mut self.random),
                false => truth,
            };
            *to = told.clamp(-of.bound, of.bound) as f32;
        }
    }
}

#[cfg(test)]
mod tests {
    use planesman_vehicle::six_dof::{Accurate, Sea, Simulation};

    use super::*;

    fn options(task: Task, vehicle: &str) -> Options {
        Options {
            task,
            vehicle: vehicle.to_owned(),
            sensors: false,
            actions: None,
            held: Vec::new(),
            speed: None,
            current: None,
            randomise: Vec::new(),
            step: 0.1,
            substeps: 2,
            duration: None,
        }
    }

    const ALL: [(Task, &str); 8] = [
        (Task::Depth, "lauv"),
        (Task::Depth, "remus_100_6dof"),
        (Task::Heading, "remus_100_6dof"),
        (Task::Docking, "lauv"),
        (Task::Station, "lauv"),
        (Task::Depth, "bluerov2_heavy"),
        (Task::Docking, "bluerov2_heavy"),
        (Task::Station, "bluerov2_heavy"),
    ];

    /// Actions of environment `k` in step `step`: some number of these two.
    fn action(k: u64, step: u64, j: usize) -> f32 {
        let number = (k * 7919 + step * 104_729 + j as u64 * 31) % 2001;
        number as f32 / 1000.0 - 1.0
    }

    /// Observations, rewards and states of environments `from` on, by their bits.
    fn flown(options: &Options, from: u64, count: usize, steps: u64) -> Vec<Vec<u64>> {
        let mut these = Environments::new(options, count, 100 + from).expect("options");
        let width = these.task().quantities().len();
        let mut bits = vec![Vec::new(); count];
        for step in 0..steps {
            let actions: Vec<f32> = (0..count)
                .flat_map(|k| {
                    (0..these.actions().len()).map(move |j| action(from + k as u64, step, j))
                })
                .collect();
            let stepped = these.step(&actions).expect("a step");
            for (k, bits) in bits.iter_mut().enumerate() {
                let seen = &stepped.observations[k * width..(k + 1) * width];
                bits.extend(seen.iter().map(|x| u64::from(x.to_bits())));
                bits.push(stepped.rewards[k].to_bits());
                bits.push(stepped.outcomes[k] as u64);
                bits.extend(these.state(k).row().map(f64::to_bits));
            }
        }
        bits
    }

    /// Also in the second part of the work, and over the ends of episodes.
    #[test]
    fn an_environment_among_many_is_the_one_alone_to_the_last_bit() {
        for (task, vehicle) in ALL {
            for (sensors, factors) in [(false, &[][..]), (true, &["mass", "linear_damping"][..])] {
                if vehicle == "remus_100_6dof" && !factors.is_empty() {
                    continue;
                }
                let factors = factors.iter().map(|it| ((*it).to_owned(), [0.8, 1.2]));
                let options = Options {
                    sensors,
                    randomise: factors.collect(),
                    duration: Some(0.5),
                    ..options(task, vehicle)
                };
                let many = flown(&options, 0, 70, 8);
                for k in [0, 65] {
                    let alone = flown(&options, k, 1, 8);
                    assert!(many[k as usize] == alone[0], "{task:?} {vehicle} {k}");
                }
                assert_ne!(many[0], many[65]);
            }
        }
    }

    /// Beside the method of order eight at 1e-9, from the same state by the same inputs: after 5 s that change each second.
    #[test]
    fn two_steps_of_runge_kutta_in_a_tenth_of_a_second_are_enough() {
        for (task, vehicle) in ALL {
            let mut one = Environments::new(&options(task, vehicle), 1, 5).expect("options");
            let (vehicle_of, count) = (one.setting.vehicle.clone(), one.actions().len());
            let sea = Sea {
                current: one.all[0].water.velocity,
                ..Sea::default()
            };
            let accuracy = Accurate {
                relative: 1e-9,
                absolute: 1e-9,
            };
            let mut truth = Simulation::new(&vehicle_of, &sea, one.state(0), accuracy);
            let (mut inputs, mut thrusts) = (Vec::new(), Vec::new());
            for step in 0..50 {
                let actions: Vec<f32> = (0..count).map(|j| action(3, step / 10, j) / 2.0).collect();
                one.setting
                    .actions
                    .inputs(&actions, &mut inputs, &mut thrusts);
                truth
                    .advance(0.1 * (step + 1) as f64, &inputs)
                    .expect("a motion");
                one.step(&actions).expect("a step");
            }
            let (found, exact) = (one.state(0).row(), truth.state.row());
            let error = found
                .iter()
                .zip(exact)
                .map(|(a, b)| (a - b).abs() / b.abs().max(1.0));
            let error = error.fold(0.0, f64::max);
            assert!(error < 3e-4, "{task:?} {vehicle}: {error:.1e}");
        }
    }

    /// Steps of two seconds at once, at which the method is unstable: such an episode ends, and the next begins.
    #[test]
    fn no_number_that_is_not_finite_leaves_an_environment() {
        for (task, vehicle) in ALL {
            let options = Options {
                step: 2.0,
                substeps: 1,
                current: Some([5.0, 10.0]),
                ..options(task, vehicle)
            };
            let mut these = Environments::new(&options, 8, 1).expect("options");
            let mut failed = 0;
            for step in 0..40 {
                let actions = (0..8 * these.actions().len()).map(|k| action(k as u64, step, 0));
                let stepped = these.step(&actions.collect::<Vec<_>>()).expect("a step");
                assert!(stepped.observations.iter().all(|x| x.is_finite()));
                assert!(stepped.rewards.iter().all(|x| x.is_finite()));
                assert!((0..8).all(|k| these.state(k).row().iter().all(|x| x.is_finite())));
                let failures = stepped.outcomes.iter();
                failed += failures.filter(|it| **it == Outcome::Failed).count();
            }
            assert!(failed > 0, "{task:?} {vehicle}");
        }
    }
}
