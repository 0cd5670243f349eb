//! Gains of the depth and pitch loops for an identified vehicle, with margins that hold over the model's uncertainty.
//!
//! The gains are those of [`planesman_control::design::optimise`] for the model itself. The margins are tightened until all drawn vehicles except the
//! share [`MISSED`] keep the requested margins.

use planesman_control::design::dive_loop::{DiveLoop, DivePlant, Judgement, Memory};
use planesman_control::design::optimise::Wishes;
use planesman_control::gains::LoopGains;
use planesman_flight::During as _;
use planesman_model_file::ModelFile;
use planesman_tuning::{Band, Distribution, MISSED};
use planesman_vehicle::identified;
use planesman_vehicle::vehicle_file;

use crate::design::error::{Error, Result};
use crate::design::subject::{Body, Drive, Subject};

/// Number of steps of tightening, and the total amount for the phase margin, rad, and for the gain margin, a factor.
const STEPS: u32 = 8;
const TIGHTER: (f64, f64) = (0.6, 2.0);
/// Limits that the user does not set, rad: the defaults of `depth_controller`.
const PITCH_LIMIT: f64 = std::f64::consts::FRAC_PI_4;
const PLANES_LIMIT: f64 = std::f64::consts::FRAC_PI_6;

/// Input of a design for an uncertain vehicle.
#[derive(Clone, Debug)]
pub struct DiveTask {
    /// The model from planes to pitch or pitch rate, with its speed.
    pub model: ModelFile,
    /// Models drawn from the model's covariance.
    pub draws: Vec<ModelFile>,
    /// The base vehicle, which supplies everything except the pitch dynamics.
    pub base: String,
    /// Actuator, tick rate and computing delay; its body is not used.
    pub subject: Subject,
    /// Minimum phase margin, rad.
    pub phase_margin: f64,
    /// Minimum gain margin, upward and downward, a factor above 1.
    pub gain_margin: f64,
    /// Maximum sensitivity peak.
    pub sensitivity: f64,
    /// Maximum overshoot of a depth step, %.
    pub overshoot: f64,
    /// Depth step whose first pitch and plane commands must stay within the limits, m.
    pub step: f64,
    /// Duration of the step response, s.
    pub duration: f64,
}

/// The gains, and the margins of all vehicles with these gains.
#[derive(Clone, Debug)]
pub struct DiveGains {
    /// Gains of the depth and pitch loops.
    pub gains: LoopGains,
    /// Speed, m/s.
    pub speed: f64,
    /// Judgement of the loop with the model itself.
    pub model: Judgement,
    /// Judgements of the loops with the drawn vehicles.
    pub draws: Vec<Judgement>,
    /// The reason for the first drawn model that does not describe a vehicle, and the number of such models.
    pub left_out: Option<(String, usize)>,
}

/// The plants: the model's vehicle, the drawn vehicles, and the reasons why other draws were left out.
struct Plants {
    speed: f64,
    drive: Drive,
    own: DivePlant,
    drawn: Vec<DivePlant>,
    refused: Vec<String>,
}

impl Plants {
    fn dive(&self, plant: &DivePlant, gains: LoopGains) -> DiveLoop {
        DiveLoop {
            plant: plant.clone(),
            gains,
            memory: Memory::default(),
            path: self.drive.path,
        }
    }
}

impl DiveTask {
    /// The plants of the model and of its draws.
    fn plants(&self) -> Result<Plants> {
        let base = vehicle_file::load(&self.base)?;
        let drive = self.subject.drive()?;
        let speed = self
            .model
            .required_speed()
            .map_err(|refusal| Error::Model(refusal.to_string()))?;
        let plant = |file: &ModelFile| {
            let vehicle = identified::vehicle(&base, file)
                .map_err(|refusal| Error::Model(refusal.to_string()))?;
            let body = Body::Given {
                name: "the identified vehicle".to_owned(),
                vehicle: Box::new(vehicle),
            };
            Subject {
                body,
                ..self.subject.clone()
            }
            .plant(&drive, speed)
        };
        let own = plant(&self.model)?;
        let (mut drawn, mut refused): (Vec<DivePlant>, Vec<String>) = (Vec::new(), Vec::new());
        for file in &self.draws {
            match plant(file) {
                Ok(plant) => drawn.push(plant),
                Err(reason) => refused.push(reason.to_string()),
            }
        }
        Ok(Plants {
            speed,
            drive,
            own,
            drawn,
            refused,
        })
    }

    /// The depth response to a unit step of the setpoint, for the model's vehicle and for the stable drawn vehicles.
    ///
    /// # Errors
    /// Same as [`DiveTask::gains`].
    pub fn depths(&self, found: &DiveGains) -> Result<Band> {
        let plants = self.plants()?;
        let stable = plants.drawn.iter().zip(&found.draws);
        let stable = stable.filter(|it| it.1.is_stable()).map(|it| it.0);
        let after = |plant| {
            let dive = plants.dive(plant, found.gains);
            dive.step(self.duration)
                .during(|| format!("the loop at {} m/s", plants.speed))
        };
        let all = std::iter::once(&plants.own).chain(stable).map(after);
        let all: Vec<Vec<(f64, f64)>> = all.collect::<Result<_, _>>()?;
        let times: Vec<f64> = all[0].iter().map(|it| it.0).collect();
        let depths = all.iter().map(|it| it.iter().map(|it| it.1).collect());
        let depths: Vec<Vec<f64>> = depths.collect();
        let depths: Vec<&[f64]> = depths.iter().map(Vec::as_slice).collect();
        Ok(Band::of(&times, &depths))
    }

    /// Finds the gains.
    ///
    /// # Errors
    /// A model that does not describe a vehicle, a refused base vehicle or actuator, limits that no gains keep.
    pub fn gains(&self) -> Result<DiveGains> {
        let plants = self.plants()?;
        let mut nearest = None;
        for step in 0..STEPS {
            let share = f64::from(step) / f64::from(STEPS - 1);
            let Some(gains) = self.proposed(&plants, share)? else {
                break;
            };
            let judged = |plant: &DivePlant| {
                let dive = plants.dive(plant, gains);
                dive.judge(self.duration)
                    .during(|| format!("the loop at {} m/s", plants.speed))
            };
            let found = DiveGains {
                gains,
                speed: plants.speed,
                model: judged(&plants.own)?,
                draws: plants.drawn.iter().map(judged).collect::<Result<_, _>>()?,
                left_out: (plants.refused.first()).map(|it| (it.clone(), plants.refused.len())),
            };
            if found.keeps(self) {
                return Ok(found);
            }
            nearest = Some(found);
        }
        Err(Error::OutOfReach {
            phase_margin: self.phase_margin.to_degrees(),
            gain_margin: 20.0 * libm::log10(self.gain_margin),
            sensitivity: self.sensitivity,
            nearest: match nearest {
                None => "no gains keep the limits even for the model itself".to_owned(),
                Some(found) => format!(
                    "the last gains tried reach {:.1} deg, {:.1} dB and {:.2} in 95 % of the vehicles",
                    found.phase().quantile(MISSED),
                    found.gain().quantile(MISSED),
                    found.sensitivity().quantile(1.0 - MISSED)
                ),
            },
        })
    }

    /// The best gains for the model itself, with margins tightened by a share of [`TIGHTER`].
    fn proposed(&self, plants: &Plants, share: f64) -> Result<Option<LoopGains>> {
        let (phase, gain) = TIGHTER;
        let wishes = Wishes {
            plants: vec![(plants.speed, plants.own.clone())],
            memory: Memory::default(),
            path: plants.drive.path,
            phase_margin: self.phase_margin + share * phase,
            gain_margin: self.gain_margin * libm::pow(gain, share),
            overshoot: self.overshoot,
            step: self.step,
            pitch_limit: PITCH_LIMIT,
            planes_limit: PLANES_LIMIT,
            duration: self.duration,
        };
        Ok(wishes.propose()?.map(|it| it.gains))
    }
}

impl DiveGains {
    fn of(&self, value: impl Fn(&Judgement) -> f64) -> Distribution {
        Distribution::new(value(&self.model), self.draws.iter().map(&value))
    }

    /// Phase margins, degrees; minus infinity for an unstable loop.
    #[must_use]
    pub fn phase(&self) -> Distribution {
        self.of(|it| match it.is_stable() {
            true => it
                .phase_margin()
                .map_or(f64::INFINITY, |margin| margin.abs().to_degrees()),
            false => f64::NEG_INFINITY,
        })
    }

    /// Gain margins to the nearer side, dB; minus infinity for an unstable loop.
    #[must_use]
    pub fn gain(&self) -> Distribution {
        self.of(|it| {
            if !it.is_stable() {
                return f64::NEG_INFINITY;
            }
            let (above, below) = it.gain_limits();
            let sides = [above.map(|it| it.factor), below.map(|it| 1.0 / it.factor)];
            let nearer = sides.into_iter().flatten().fold(f64::INFINITY, f64::min);
            20.0 * libm::log10(nearer)
        })
    }

    /// Sensitivity peaks; infinite for an unstable loop.
    #[must_use]
    pub fn sensitivity(&self) -> Distribution {
        self.of(|it| {
            let peak = it.sensitivity.filter(|_| it.is_stable());
            peak.map_or(f64::INFINITY, |it| it.value)
        })
    }

    /// Overshoots of a depth step, %; infinite for an unstable loop.
    #[must_use]
    pub fn overshoot(&self) -> Distribution {
        self.of(|it| it.step.map_or(f64::INFINITY, |it| it.overshoot))
    }

    /// Settling times of a depth step to 5 %, s; infinite if the depth does not settle.
    #[must_use]
    pub fn settling(&self) -> Distribution {
        self.of(|it| {
            it.step
                .and_then(|it| it.settling_time_5)
                .unwrap_or(f64::INFINITY)
        })
    }

    fn keeps(&self, task: &DiveTask) -> bool {
        let worst = |spread: &Distribution, share: f64| spread.quantile(share);
        let gain = 20.0 * libm::log10(task.gain_margin);
        worst(&self.phase(), MISSED) >= task.phase_margin.to_degrees()
            && worst(&self.gain(), MISSED) >= gain
            && worst(&self.sensitivity(), 1.0 - MISSED) <= task.sensitivity
            && self.sensitivity().model <= task.sensitivity
    }

    /// The gains as a ROS 2 parameter file of `depth_controller`, for any namespace.
    #[must_use]
    pub fn parameter_file(&self) -> String {
        let mut text = format!(
            "# Gains of planesman tune, for {} m/s: ros2 param load /auv/depth_controller FILE\n\n/**/depth_controller:\n  ros__parameters:\n",
            self.speed
        );
        for (name, value) in self.parameters() {
            text += &format!("    {name}: {value:?}\n");
        }
        text
    }

    /// The gains as parameters of `depth_controller`.
    #[must_use]
    pub fn parameters(&self) -> [(&'static str, f64); 4] {
        let g = &self.gains;
        [
            ("depth.p", g.depth_p),
            ("depth.d", g.depth_d),
            ("pitch.p", g.pitch_p),
            ("pitch.rate", g.pitch_rate),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_model_file::Physical;

    /// The thesis' vehicle at 1 ft/s (Brunner 1988, Table 3 with heave left out): kappa, beta and mu with so many % of deviation.
    fn task(percent: f64) -> DiveTask {
        let values = [-0.469, 1.2, 0.27];
        let mut covariance = [[0.0; 3]; 3];
        for i in 0..3 {
            covariance[i][i] = (0.01 * percent * values[i]).powi(2);
        }
        let mut model = ModelFile::exact(
            "plane_motion:dive_planes",
            "state:pitch",
            0.05,
            vec![0.1],
            vec![1.0, -0.9],
        );
        model.speed = Some(0.3048);
        let [kappa, beta, mu] = values;
        model.physical = Some(Physical {
            kappa,
            beta,
            mu,
            covariance,
            heave: None,
        });
        DiveTask {
            draws: planesman_tuning::drawn(&model, 6, 1),
            model,
            base: vehicle_file::BRUNNER.to_owned(),
            subject: Subject {
                actuator: "ideal".to_owned(),
                ..Subject::default()
            },
            phase_margin: 60_f64.to_radians(),
            gain_margin: 2.0,
            sensitivity: 1.6,
            overshoot: 5.0,
            step: 0.9144,
            duration: 60.0,
        }
    }

    #[test]
    fn the_gains_keep_their_margins_in_the_vehicles_that_the_model_allows() {
        let task = task(10.0);
        let found = task.gains().unwrap();
        assert_eq!(found.draws.len(), 6);
        assert!(
            found.phase().quantile(MISSED) >= 60.0 && found.phase().sorted[0] < found.phase().model
        );
        assert!(found.gain().quantile(MISSED) >= 20.0 * libm::log10(2_f64));
        assert!(found.sensitivity().quantile(0.95) <= 1.6);
        // The start that the thesis has is slower.
        let text = found.parameter_file();
        assert!(
            text.contains("/**/depth_controller:\n  ros__parameters:\n    depth.p: "),
            "{text}"
        );
    }

    #[test]
    fn limits_that_no_gains_keep_are_refused_with_what_was_found() {
        let mut task = task(10.0);
        task.phase_margin = 185_f64.to_radians();
        task.duration = 20.0;
        task.draws.truncate(1);
        let refusal = task.gains().unwrap_err().to_string();
        assert!(refusal.contains("relax the limits: ms "), "{refusal}");
    }
}
