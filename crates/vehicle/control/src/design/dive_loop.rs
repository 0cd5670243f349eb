//! The linear analysis of the dive loop: any vehicle, all four gains, any actuator.
//!
//! With feedback of depth and its rate, pitch and its rate (bow up, dive-positive planes, SI), the plane command is
//!
//! ```text
//! delta = P (D (z_c - z) - Kdz F z' + theta) + Kr q,     P = Kpy + Kiy S,   D = Kpz + Kiz S
//! ```
//! with the integrator `S` and the filter `F` of the derivative if the controller has them ([`Memory`]): `P = Kpy`, `D = Kpz`, `F = 1` by
//! default. Broken at the planes, with `G_x` from `delta` to `x`, the loop is
//!
//! ```text
//! L = -(Kr G_q + P G_theta - P D G_z - P Kdz F G_z')
//! ```
//! and closed, `z / z_c = P D G_z / (1 + L)` (Brunner, NPS thesis, 1988, pp. 9 to 20, whose vehicle is
//! a [`PitchModel`] and whose planes are ideal). There are two such loops.
//!
//! - The sampled loop ([`DivePlant::sampled`]) is the one that flies: the law is evaluated at each tick, its command is held over the tick, and the
//!   actuator moves the planes with its own motion ([`Sampled`]). `G_x(z)` includes all of that, exact at the ticks;
//! - **continuous**: `G_x(s)` with an actuator `A(s)` of a lag and a dead time, which represents hold and actuator.

use planesman_linear::{ComplexFunctions as _, polar};
use std::f64::consts::TAU;
use std::sync::Arc;

use planesman_linear::{
    Complex, DMatrix, DelayedLoop, Error, RouthColumn, Sampled, StateSpace, StepMetrics,
    TransferFunction, discrete_to_continuous,
    frequency::{self, GainMargin, Peak, PhaseMargin, Response},
    poles::eigenvalues,
    polynomial,
};

use super::step;
use crate::gains::{LoopGains, PitchModel};

/// The frequency range of the search for phase crossovers, rad/s.
const FREQUENCIES: (f64, f64) = (1e-4, 1e3);

/// The frequencies of a sampled loop's response range from the first to the second share of Nyquist's frequency, where every loop is real.
const SHARES_OF_NYQUIST: (f64, f64) = (1e-6, 0.9999);

/// Number of samples of a continuous loop's step response.
const STEP_SAMPLES: f64 = 1500.0;

/// The vehicle in level flight, from the dive planes (rad, dive) to pitch rate (rad/s, bow up), pitch (rad, bow up), depth (m, down) and depth rate
/// (m/s).
#[derive(Clone, Debug, PartialEq)]
pub struct DivePlant {
    vehicle: StateSpace,
    sampled: Option<Arc<SampledPlant>>,
}

/// A vehicle with a sampled command, and its frequency response.
#[derive(Clone, Debug, PartialEq)]
struct SampledPlant {
    system: Sampled,
    /// Frequency, rad/s, and the four outputs per command.
    response: Vec<(f64, DMatrix<Complex<f64>>)>,
}

impl DivePlant {
    /// The vehicle from a state space with those four outputs, in that order.
    ///
    /// # Errors
    /// [`Error::Shape`] for another number of outputs or inputs.
    pub fn new(state_space: StateSpace) -> Result<Self, Error> {
        if state_space.d.shape() == (4, 1) {
            Ok(Self {
                vehicle: state_space,
                sampled: None,
            })
        } else {
            Err(Error::Shape {
                what: "the vehicle",
                found: format!(
                    "{} outputs of {} inputs",
                    state_space.d.nrows(),
                    state_space.d.ncols()
                ),
                expected: "4 outputs of 1 input".to_owned(),
            })
        }
    }

    /// The vehicle with a sampled command. `lag` (s, 0 for none) is the lag of the actuator; `motion` is the remaining response between command and
    /// planes, in the form of [`Sampled::new`], for ticks of `tick` seconds.
    ///
    /// # Errors
    /// Errors of [`Sampled::new`].
    pub fn sampled(self, lag: f64, motion: &[(f64, f64)], tick: f64) -> Result<Self, Error> {
        let system = Sampled::new(&self.behind_lag(lag)?, motion, tick)?;
        let (lowest, highest) = SHARES_OF_NYQUIST;
        let nyquist = system.nyquist();
        let mut grid = frequency::grid(lowest * nyquist, highest * nyquist);
        grid.push(nyquist);
        let response = grid.into_iter().filter_map(|w| Some((w, system.at(w)?)));
        let response = response.collect();
        Ok(Self {
            sampled: Some(Arc::new(SampledPlant { system, response })),
            ..self
        })
    }

    /// The vehicle with a lag before the planes, s.
    fn behind_lag(&self, lag: f64) -> Result<StateSpace, Error> {
        let StateSpace { a, b, c, d } = self.vehicle.clone();
        if lag == 0.0 {
            return StateSpace::new(a, b, c, d);
        }
        let n = a.nrows();
        let mut with_planes = a.resize(n + 1, n + 1, 0.0);
        with_planes.view_mut((0, n), (n, 1)).copy_from(&b);
        with_planes[(n, n)] = -1.0 / lag;
        let mut driven = DMatrix::zeros(n + 1, 1);
        driven[n] = 1.0 / lag;
        StateSpace::new(with_planes, driven, c.resize_horizontally(n + 1, 0.0), d)
    }

    /// A damped inertia whose depth rate follows its pitch: `z' = -U theta`.
    ///
    /// # Errors
    /// [`Error::NotFinite`].
    pub fn of_pitch(model: &PitchModel, speed: f64) -> Result<Self, Error> {
        let PitchModel {
            plane,
            damping,
            restoring,
        } = *model;
        // x = (q, theta, z)
        #[rustfmt::skip]
        let a = [
            -damping, -restoring, 0.0,
            1.0,      0.0,        0.0,
            0.0,      -speed,     0.0,
        ];
        #[rustfmt::skip]
        let c = [
            1.0, 0.0,    0.0,
            0.0, 1.0,    0.0,
            0.0, 0.0,    1.0,
            0.0, -speed, 0.0,
        ];
        StateSpace::new(
            DMatrix::from_row_slice(3, 3, &a),
            DMatrix::from_row_slice(3, 1, &[-plane, 0.0, 0.0]),
            DMatrix::from_row_slice(4, 3, &c),
            DMatrix::zeros(4, 1),
        )
        .and_then(Self::new)
    }
}

/// The continuous model between command and planes: a lag and a dead time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Path {
    /// s; 0 for none.
    pub lag: f64,
    /// s
    pub delay: f64,
}

/// Parts of the law that remember earlier ticks: the controller's `depth.i`, `pitch.i` and `depth.derivative_filter`; 0 for an unused part.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Memory {
    /// `Kiz`, rad/(m s).
    pub depth_i: f64,
    /// `Kiy`, 1/s.
    pub pitch_i: f64,
    /// Time constant of the derivative's filter, s.
    pub derivative_filter: f64,
}

/// A vehicle, gains and an actuator.
#[derive(Clone, Debug, PartialEq)]
pub struct DiveLoop {
    /// The vehicle.
    pub plant: DivePlant,
    /// `Kpz`, `Kdz`, `Kpy`, `Kr`.
    pub gains: LoopGains,
    /// Integrals and filter.
    pub memory: Memory,
    /// The actuator.
    pub path: Path,
}

/// The law in `s`: polynomials over a common denominator.
struct Law {
    /// Weights of pitch rate, pitch, depth and depth rate, the last two with opposite signs.
    fed_back: [Vec<f64>; 4],
    den: Vec<f64>,
}

/// Stability, margins and step response of a loop.
#[derive(Clone, Debug, PartialEq)]
pub struct Judgement {
    /// Poles of the closed loop, slowest first: of a continuous one in `s` \[1/s\], with a Pade approximation of the dead time; of a
    /// sampled one in `z`.
    pub poles: Vec<Complex<f64>>,
    /// Of a sampled loop, s.
    pub tick: Option<f64>,
    /// Routh's scheme, for a continuous loop.
    pub routh: Option<RouthColumn>,
    /// The phase margin at every gain crossover.
    pub phase: Vec<PhaseMargin>,
    /// The gain margin at every phase crossover.
    pub gain: Vec<GainMargin>,
    /// The largest sensitivity `|1 / (1 + L)|`.
    pub sensitivity: Option<Peak>,
    /// Metrics of the depth after a unit step of the setpoint, for a sampled loop at the ticks; `None` for an unstable loop.
    pub step: Option<StepMetrics>,
}

impl Judgement {
    /// Whether every pole is stable.
    #[must_use]
    pub fn is_stable(&self) -> bool {
        self.growth() < 0.0
    }

    /// The amount by which the most unstable pole exceeds the limit of stability: its real part, 1/s, or its magnitude minus 1.
    #[must_use]
    pub fn growth(&self) -> f64 {
        growth(&self.poles, self.tick.is_some())
    }

    /// The number of unstable poles.
    #[must_use]
    pub fn unstable_poles(&self) -> usize {
        let beyond = |pole: &&Complex<f64>| match self.tick {
            Some(_) => pole.modulus() >= 1.0,
            None => pole.re >= 0.0,
        };
        self.poles.iter().filter(beyond).count()
    }

    /// The poles in `s`, 1/s; for a sampled loop `ln(z) / T`, without poles at `z = 0`.
    #[must_use]
    pub fn continuous_poles(&self) -> Vec<Complex<f64>> {
        match self.tick {
            Some(tick) => {
                let poles = self.poles.iter();
                poles
                    .filter_map(|z| discrete_to_continuous(*z, tick))
                    .collect()
            }
            None => self.poles.clone(),
        }
    }

    /// The phase margin nearest to zero, rad; `None` without a gain crossover.
    #[must_use]
    pub fn phase_margin(&self) -> Option<f64> {
        let margins = self.phase.iter().map(|m| m.margin);
        margins.min_by(|a, b| a.abs().total_cmp(&b.abs()))
    }

    /// The factors to which the loop's gain may rise and fall: the nearest gain margins above and below one, `None` if there is no margin.
    #[must_use]
    pub fn gain_limits(&self) -> (Option<GainMargin>, Option<GainMargin>) {
        let by_factor = |a: &GainMargin, b: &GainMargin| a.factor.total_cmp(&b.factor);
        let margins = || self.gain.iter().copied();
        (
            margins().filter(|m| m.factor >= 1.0).min_by(by_factor),
            margins().filter(|m| m.factor < 1.0).max_by(by_factor),
        )
    }

    /// The smallest additional delay, s, that makes a stable loop unstable: the minimum of the phase margin, expressed as a delay, over all crossover
    /// frequencies. For a sampled loop it is exact for whole ticks.
    #[must_use]
    pub fn delay_margin(&self) -> Option<f64> {
        let delay = |m: &PhaseMargin| m.margin.rem_euclid(TAU) / m.frequency;
        self.phase.iter().map(delay).min_by(f64::total_cmp)
    }
}

/// The amount by which the most unstable of the poles, in `z` or in `s`, exceeds the limit of stability.
fn growth(poles: &[Complex<f64>], is_sampled: bool) -> f64 {
    let beyond = |pole: &Complex<f64>| match is_sampled {
        true => pole.modulus() - 1.0,
        false => pole.re,
    };
    poles.iter().map(beyond).fold(f64::MIN, f64::max)
}

impl DiveLoop {
    /// Replaces the sampled loop by the continuous loop.
    #[must_use]
    pub fn continuous(&self) -> Self {
        let mut continuous = self.clone();
        continuous.plant.sampled = None;
        continuous
    }

    /// The weights of the four outputs in `L`, with the law's integrator and filter at a frequency.
    fn fed_back(&self, integrator: Complex<f64>, filter: Complex<f64>) -> DMatrix<Complex<f64>> {
        let (g, m) = (&self.gains, &self.memory);
        let part = |i: f64| match i {
            0.0 => Complex::from(0.0),
            _ => integrator * i,
        };
        let pitch = part(m.pitch_i) + g.pitch_p;
        let depth = part(m.depth_i) + g.depth_p;
        let weights = [
            Complex::from(-g.pitch_rate),
            -pitch,
            pitch * depth,
            pitch * filter * g.depth_d,
        ];
        DMatrix::from_row_slice(1, 4, &weights)
    }

    /// `L(s)` of the continuous loop, broken at the planes.
    ///
    /// # Errors
    /// Errors of [`StateSpace::transfer_function`].
    pub fn open_loop(&self) -> Result<DelayedLoop, Error> {
        let law = self.law();
        let [rate, pitch, depth, derivative] = &law.fed_back;
        let minus = |p: &[f64]| p.iter().map(|c| -c).collect::<Vec<f64>>();
        self.through_actuator([&minus(rate), &minus(pitch), depth, derivative], &law.den)
    }

    /// The law in `s`.
    fn law(&self) -> Law {
        let (g, m) = (&self.gains, &self.memory);
        let pi = |p: f64, i: f64| match i {
            0.0 => (vec![p], vec![1.0]),
            _ => (vec![p, i], vec![1.0, 0.0]),
        };
        let ((pitch, pitch_den), (depth, depth_den)) =
            (pi(g.pitch_p, m.pitch_i), pi(g.depth_p, m.depth_i));
        let filter = match m.derivative_filter {
            0.0 => vec![1.0],
            time => vec![time, 1.0],
        };
        let product = |factors: &[&[f64]]| {
            let one = vec![1.0];
            factors
                .iter()
                .fold(one, |all, it| polynomial::product(&all, it))
        };
        let den = product(&[&pitch_den, &depth_den, &filter]);
        Law {
            fed_back: [
                product(&[&[g.pitch_rate], &den]),
                product(&[&pitch, &depth_den, &filter]),
                product(&[&pitch, &depth, &filter]),
                product(&[&pitch, &[g.depth_d], &depth_den]),
            ],
            den,
        }
    }

    /// `L(exp(j w T))` of the sampled loop up to Nyquist's frequency, rad/s, included; `None` for a continuous one.
    #[must_use]
    pub fn sampled_response(&self) -> Option<Response> {
        let plant = self.plant.sampled.as_ref()?;
        let tick = plant.system.tick();
        let points = plant.response.iter();
        Some(
            points
                .map(|(w, outputs)| (*w, self.sampled_at(tick, *w, outputs)))
                .collect(),
        )
    }

    /// `L` from the vehicle's outputs per command at a frequency.
    fn sampled_at(
        &self,
        tick: f64,
        frequency: f64,
        outputs: &DMatrix<Complex<f64>>,
    ) -> Complex<f64> {
        let z = polar(1.0, frequency * tick);
        let forgotten = self.forgotten(tick);
        let filter = (1.0 - forgotten) / (-z.inv() * forgotten + 1.0);
        (self.fed_back((z - 1.0).inv() * tick, filter) * outputs)[(0, 0)]
    }

    /// The remaining share of the derivative filter's state after a tick.
    fn forgotten(&self, tick: f64) -> f64 {
        match self.memory.derivative_filter {
            0.0 => 0.0,
            time => libm::exp(-tick / time),
        }
    }

    /// The closed sampled loop, from the depth setpoint to the depth, at the ticks; `None` for a continuous one.
    ///
    /// In addition to the vehicle and the delayed commands, its states are the filtered rate of the last tick and the integrals, as in the
    /// autopilot.
    #[must_use]
    pub fn sampled_closed_loop(&self) -> Option<StateSpace> {
        let system = &self.plant.sampled.as_ref()?.system;
        let (plant, tick) = (system.state_space(), system.tick());
        let (g, m) = (&self.gains, &self.memory);
        let n = plant.a.nrows();
        let memories = [m.derivative_filter, m.depth_i, m.pitch_i];
        let states = n + memories.iter().filter(|it| **it != 0.0).count();
        // Linear forms of all states, the setpoint last.
        let unit = |i: usize| DMatrix::from_fn(1, states + 1, |_, j| f64::from(u8::from(i == j)));
        let output = |i: usize| plant.c.rows(i, 1).resize_horizontally(states + 1, 0.0);
        let mut next_state = n;
        let [filtered, depth_integral, pitch_integral] = memories.map(|memory| {
            (memory != 0.0).then(|| {
                next_state += 1;
                next_state - 1
            })
        });
        let integral = |state: Option<usize>| match state {
            Some(state) => unit(state),
            None => DMatrix::zeros(1, states + 1),
        };
        let forgotten = self.forgotten(tick);
        let rate = output(3) * (1.0 - forgotten) + integral(filtered) * forgotten;
        let error = unit(states) - output(2);
        let dive = &error * g.depth_p + integral(depth_integral) - &rate * g.depth_d;
        let inner = dive + output(1);
        let command = &inner * g.pitch_p + integral(pitch_integral) + output(0) * g.pitch_rate;
        let mut whole = DMatrix::zeros(states, states + 1);
        whole.view_mut((0, 0), (n, n)).copy_from(&plant.a);
        let driven = &plant.b * command;
        let mut vehicle = whole.rows_mut(0, n);
        vehicle += driven;
        for (state, next) in [
            (filtered, rate),
            (
                depth_integral,
                integral(depth_integral) + error * (tick * m.depth_i),
            ),
            (
                pitch_integral,
                integral(pitch_integral) + inner * (tick * m.pitch_i),
            ),
        ] {
            if let Some(state) = state {
                whole.rows_mut(state, 1).copy_from(&next);
            }
        }
        Some(StateSpace {
            a: whole.columns(0, states).into_owned(),
            b: whole.columns(states, 1).into_owned(),
            c: output(2).columns(0, states).into_owned(),
            d: DMatrix::zeros(1, 1),
        })
    }

    /// The poles of the closed loop, like [`Judgement::poles`].
    ///
    /// # Errors
    /// Errors of [`eigenvalues`] and [`DiveLoop::closed_loop`].
    pub fn poles(&self) -> Result<Vec<Complex<f64>>, Error> {
        match self.sampled_closed_loop() {
            Some(closed) => eigenvalues(&closed.a),
            None => self.closed_loop()?.poles(),
        }
    }

    /// Like [`Judgement::growth`], without the margins.
    ///
    /// # Errors
    /// Errors of [`DiveLoop::poles`].
    pub fn growth(&self) -> Result<f64, Error> {
        Ok(growth(&self.poles()?, self.plant.sampled.is_some()))
    }

    /// The end points of the root locus as one gain grows without bound, in the form of [`Judgement::poles`]; `gain` selects the gain.
    ///
    /// # Errors
    /// Errors of [`StateSpace::zeros`] and [`DiveLoop::closed_loop`].
    pub fn locus_zeros(
        &self,
        gain: impl Fn(&mut LoopGains) -> &mut f64,
    ) -> Result<Vec<Complex<f64>>, Error> {
        let with = |value: f64| {
            let mut changed = self.clone();
            *gain(&mut changed.gains) = value;
            changed
        };
        // What is fed back is linear in each gain: the loop is closed by its polynomial, or its matrix, M(0) + gain (M(1) - M(0)).
        let (without, one) = (with(0.0), with(1.0));
        let (Some(closed), Some(more)) = (without.sampled_closed_loop(), one.sampled_closed_loop())
        else {
            let less: Vec<f64> = without.closed_loop()?.den.iter().map(|c| -c).collect();
            let more = polynomial::sum(&one.closed_loop()?.den, &less);
            let more: Vec<f64> = more.into_iter().skip_while(|c| *c == 0.0).collect();
            return match more[..] {
                [] => Ok(Vec::new()),
                _ => polynomial::roots(&more),
            };
        };
        // The difference has rank one: b c.
        let more = more.a - &closed.a;
        let (row, column) = more.iamax_full();
        let largest = more[(row, column)];
        if largest == 0.0 {
            return Ok(Vec::new());
        }
        StateSpace {
            a: closed.a,
            b: more.columns(column, 1).into_owned(),
            c: more.rows(row, 1) / largest,
            d: DMatrix::zeros(1, 1),
        }
        .zeros()
    }

    /// `z / z_c`, with a Pade approximation of the dead time.
    ///
    /// # Errors
    /// Errors of [`StateSpace::transfer_function`].
    pub fn closed_loop(&self) -> Result<TransferFunction, Error> {
        let law = self.law();
        let none: &[f64] = &[0.0];
        let forward = self
            .through_actuator([none, none, &law.fed_back[2], none], &law.den)?
            .rational()?;
        let open = self.open_loop()?.rational()?;
        // Both have the law's, the actuator's and the vehicle's denominator.
        TransferFunction::new(forward.num, polynomial::sum(&open.num, &open.den))
    }

    /// Poles, margins and the step response over `duration` seconds; for a sampled plant, of the sampled loop.
    ///
    /// # Errors
    /// Errors of [`DiveLoop::margins`] and [`step::response`].
    pub fn judge(&self, duration: f64) -> Result<Judgement, Error> {
        let mut judgement = self.margins()?;
        if judgement.is_stable() {
            let samples = self.step(duration)?;
            let (times, depths): (Vec<f64>, Vec<f64>) = samples.into_iter().unzip();
            judgement.step = Some(StepMetrics::of(&times, &depths, 0.0, 1.0)?);
        }
        Ok(judgement)
    }

    /// The depth after a unit step of the setpoint: time in s and value, over `duration` seconds; for a sampled loop at the ticks.
    ///
    /// # Errors
    /// Errors of [`DiveLoop::closed_loop`] and [`step::samples`].
    pub fn step(&self, duration: f64) -> Result<Vec<(f64, f64)>, Error> {
        match (&self.plant.sampled, self.sampled_closed_loop()) {
            (Some(plant), Some(closed)) => Ok(step::held(&closed, plant.system.tick(), duration)),
            _ => step::samples(&self.closed_loop()?, duration / STEP_SAMPLES, duration),
        }
    }

    /// Poles and margins, without the step response.
    ///
    /// # Errors
    /// Errors of [`StateSpace::transfer_function`] and [`eigenvalues`].
    pub fn margins(&self) -> Result<Judgement, Error> {
        match &self.plant.sampled {
            Some(plant) => self.sampled_margins(&plant.system),
            None => self.continuous_margins(),
        }
    }

    fn continuous_margins(&self) -> Result<Judgement, Error> {
        let closed = self.closed_loop()?;
        let open = self.open_loop()?;
        let grid = frequency::grid(FREQUENCIES.0, FREQUENCIES.1).into_iter();
        let response: Response = grid.map(|w| (w, open.at(w))).collect();
        Ok(Judgement {
            poles: closed.poles()?,
            tick: None,
            routh: Some(RouthColumn::of(&closed.den)?),
            phase: open.phase_margins()?,
            gain: frequency::gain_margins(&response, |w| open.at(w)),
            sensitivity: frequency::sensitivity_peak(&response, |w| open.at(w)),
            step: None,
        })
    }

    fn sampled_margins(&self, system: &Sampled) -> Result<Judgement, Error> {
        let nowhere = Complex::new(f64::INFINITY, 0.0);
        let at = |w: f64| {
            let outputs = system.at(w);
            outputs.map_or(nowhere, |it| self.sampled_at(system.tick(), w, &it))
        };
        let mut response = self.sampled_response().unwrap_or_default();
        let end = response.pop();
        let mut gain = frequency::gain_margins(&response, at);
        // At Nyquist's frequency the loop is real, whatever the sign of its imaginary part before.
        if let Some((frequency, value)) = end {
            if value.re < 0.0 {
                let factor = -1.0 / value.re;
                gain.push(GainMargin { frequency, factor });
            }
            response.push((frequency, value));
        }
        Ok(Judgement {
            poles: self.poles()?,
            tick: Some(system.tick()),
            routh: None,
            phase: frequency::phase_margins(&response, at),
            gain,
            sensitivity: frequency::sensitivity_peak(&response, at),
            step: None,
        })
    }

    /// The sum of the vehicle's four outputs with these weights over `den`, polynomials in `s`, after the actuator.
    fn through_actuator(&self, weights: [&[f64]; 4], den: &[f64]) -> Result<DelayedLoop, Error> {
        let mut num = vec![0.0];
        let mut vehicle = vec![1.0];
        for (output, weight) in weights.into_iter().enumerate() {
            let seen = self.plant.vehicle.transfer_function(output, 0)?;
            num = polynomial::sum(&num, &polynomial::product(weight, &seen.num));
            vehicle = seen.den;
        }
        let lag: &[f64] = match self.path.lag > 0.0 {
            true => &[self.path.lag, 1.0],
            false => &[1.0],
        };
        let den = polynomial::product(&polynomial::product(den, &vehicle), lag);
        Ok(DelayedLoop {
            transfer_function: TransferFunction::new(num, den)?,
            delay: self.path.delay,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gains::T6 as PROGRAM_T6;

    const T6: LoopGains = PROGRAM_T6.reference;

    /// The report's vehicle and gains, in feet.
    fn report(speed: f64, gains: LoopGains) -> DiveLoop {
        DiveLoop {
            plant: DivePlant::of_pitch(&PROGRAM_T6.law.model, speed).unwrap(),
            gains,
            memory: Memory::default(),
            path: Path::default(),
        }
    }

    #[test]
    fn without_derivative_the_loop_is_lost_between_two_and_a_quarter_and_three_feet_per_second() {
        let gains = LoopGains { depth_d: 0.0, ..T6 };
        for (speed, stable) in [(1.0, true), (2.2, true), (2.3, false), (3.0, false)] {
            let judged = report(speed, gains).judge(60.0).unwrap();
            assert_eq!(judged.is_stable(), stable, "{speed}");
            assert_eq!(judged.routh.unwrap().unstable_roots() == Some(0), stable);
            assert_eq!(judged.step.is_some(), stable);
        }
    }

    #[test]
    fn the_gain_margin_puts_a_pole_on_the_axis() {
        let mut dive = report(1.0, T6);
        dive.path.delay = 0.2;
        let (above, _) = dive.judge(60.0).unwrap().gain_limits();
        let factor = above.unwrap().factor;
        let LoopGains {
            pitch_p,
            pitch_rate,
            ..
        } = dive.gains;
        // Everything fed back passes the planes: Kpy and Kr together are the loop's gain.
        let nearest = |factor: f64| {
            let mut scaled = dive.clone();
            scaled.gains.pitch_p = pitch_p * factor;
            scaled.gains.pitch_rate = pitch_rate * factor;
            let poles = scaled.closed_loop().unwrap().poles().unwrap();
            poles.iter().map(|s| s.re).fold(f64::MIN, f64::max)
        };
        assert!(nearest(0.95 * factor) < 0.0 && nearest(1.05 * factor) > 0.0);
    }

    #[test]
    fn dead_time_and_lag_cost_phase() {
        let margin = |path| {
            let dive = DiveLoop {
                path,
                ..report(1.0, T6)
            };
            dive.judge(60.0).unwrap().phase_margin().unwrap()
        };
        let ideal = margin(Path::default());
        assert!(
            margin(Path {
                lag: 0.1,
                delay: 0.0
            }) < ideal
        );
        assert!(
            margin(Path {
                lag: 0.0,
                delay: 0.1
            }) < ideal
        );
    }

    /// Planes at once, late, and by a ramp that reaches into the next tick.
    const MOTIONS: [[(f64, f64); 2]; 3] = [
        [(0.0, 0.0), (0.0, 1.0)],
        [(0.02, 0.0), (0.02, 1.0)],
        [(0.01, 0.0), (0.08, 1.0)],
    ];

    /// The report's vehicle and gains, sampled; behind the motion, so many further ticks late, and with the loop's gain scaled.
    fn sampled(speed: f64, lag: f64, motion: &[(f64, f64)], late: f64, factor: f64) -> DiveLoop {
        let motion = motion.iter().map(|knot| (knot.0 + 0.05 * late, knot.1));
        let continuous = report(speed, T6);
        DiveLoop {
            plant: continuous
                .plant
                .sampled(lag, &motion.collect::<Vec<_>>(), 0.05)
                .unwrap(),
            gains: LoopGains {
                pitch_p: T6.pitch_p * factor,
                pitch_rate: T6.pitch_rate * factor,
                ..T6
            },
            ..continuous
        }
    }

    const MEMORY: Memory = Memory {
        depth_i: 0.005,
        pitch_i: 0.03,
        derivative_filter: 0.1,
    };

    #[test]
    fn the_margins_of_the_sampled_loop_put_a_pole_on_the_unit_circle() {
        for memory in [Memory::default(), MEMORY] {
            for speed in [0.5, 2.0] {
                for lag in [0.0, 0.1] {
                    for motion in &MOTIONS {
                        let with = |late: f64, factor: f64| {
                            let mut scaled = sampled(speed, lag, motion, late, factor);
                            scaled.memory = memory;
                            scaled.memory.pitch_i *= factor;
                            scaled.margins().unwrap()
                        };
                        let is_stable = |late, factor| with(late, factor).is_stable();
                        let judged = with(0.0, 1.0);
                        assert!(judged.is_stable(), "{memory:?} {speed} {:?}", judged.poles);
                        let factor = judged.gain_limits().0.unwrap().factor;
                        assert!(is_stable(0.0, 0.9999 * factor));
                        assert!(!is_stable(0.0, 1.0001 * factor));
                        let ticks = (judged.delay_margin().unwrap() / 0.05).floor();
                        assert!(is_stable(ticks, 1.0) && !is_stable(ticks + 1.0, 1.0));
                    }
                }
            }
        }
    }

    #[test]
    fn for_short_ticks_the_sampled_loop_is_the_continuous_one() {
        let continuous = DiveLoop {
            memory: MEMORY,
            ..report(1.0, T6)
        };
        let plant = continuous.plant.clone();
        let sampled = DiveLoop {
            plant: plant.sampled(0.1, &MOTIONS[0], 1e-4).unwrap(),
            ..continuous.clone()
        };
        let continuous = DiveLoop {
            path: Path {
                lag: 0.1,
                delay: 5e-5,
            },
            ..continuous
        };
        let [a, b] = [sampled, continuous].map(|it| it.judge(60.0).unwrap());
        let near = |a: f64, b: f64, within: f64| assert!((a / b - 1.0).abs() < within, "{a} {b}");
        near(a.phase_margin().unwrap(), b.phase_margin().unwrap(), 1e-4);
        near(
            a.gain_limits().0.unwrap().factor,
            b.gain_limits().0.unwrap().factor,
            1e-3,
        );
        for (a, b) in a.continuous_poles().iter().zip(&b.poles) {
            assert!((a - b).modulus() < 1e-3 * b.modulus(), "{a} {b}");
        }
        near(a.step.unwrap().itae, b.step.unwrap().itae, 1e-3);
    }

    #[test]
    fn a_locus_ends_at_its_zeros() {
        for dive in [report(1.0, T6), sampled(1.0, 0.0, &MOTIONS[2], 0.0, 1.0)] {
            let mut far = dive.clone();
            far.gains.depth_p = 1e13;
            let ends = far.poles().unwrap();
            for zero in dive.locus_zeros(|gains| &mut gains.depth_p).unwrap() {
                let nearest = ends.iter().map(|end| (end - zero).modulus());
                assert!(
                    nearest.fold(f64::MAX, f64::min) < 1e-3 * zero.modulus(),
                    "{zero}: {ends:?}"
                );
            }
        }
    }
}
