//! The schedule on a model from a file: the gains that [`adaptive`](super::adaptive) would reach with the same model, from the beginning.
//! The model must satisfy the same conditions, except for its age. At speeds other than that of the identification, the model is scaled with speed in the
//! same way as the schedule's own model.

use std::path::Path;

use planesman_model_file::ModelFile;
use planesman_msgs::planesman_msgs::msg::ModelEstimate;

use super::distrust::{Distrust, FileError};
use super::pitch_model::{Identified, SpeedLaw};
use super::schedule::{LoopGains, Schedule};
use super::trust::Trust;

/// The vehicle in pitch over speed, from a model file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FromFile {
    law: SpeedLaw,
}

impl FromFile {
    /// The model in a file.
    ///
    /// # Errors
    /// [`FileError`], with the file's name: it cannot be read, lacks its speed, has other signals than dive planes and pitch rate, or
    /// cannot be trusted.
    pub fn read(path: &str, schedule: &Schedule, trust: &Trust) -> Result<Self, FileError> {
        let file = ModelFile::read(Path::new(path))?;
        Self::from_model(&file, schedule, trust).map_err(|reason| FileError::Distrusted {
            path: path.to_owned(),
            reason,
        })
    }

    /// Computes the gains from a model that has already been read.
    ///
    /// # Errors
    /// Like [`read`](Self::read), without the file's name.
    pub fn from_model(
        file: &ModelFile,
        schedule: &Schedule,
        trust: &Trust,
    ) -> Result<Self, Distrust> {
        let speed = file.required_speed()?;
        if file.has_feedthrough() {
            return Err(Distrust::Feedthrough);
        }
        let identified = Identified::from_estimate(&estimate(file))?;
        let model = trust.believed(&identified, schedule, speed)?;
        Ok(Self {
            law: SpeedLaw {
                model,
                reference_speed: speed,
                ..schedule.law
            },
        })
    }

    /// The gains at a speed (m/s).
    #[must_use]
    pub fn gains(&self, schedule: &Schedule, trust: &Trust, speed: f64) -> LoopGains {
        let model = self.law.at(schedule.scheduled(speed));
        trust.gains(schedule, &model, speed)
    }
}

/// The file's transfer function as `sysid` would publish it.
fn estimate(file: &ModelFile) -> ModelEstimate {
    ModelEstimate {
        input: file.input.clone(),
        output: file.output.clone(),
        sample_time: file.sample_time,
        a: file.den[1..].to_vec(),
        b: file.num.clone(),
        covariance: file.covariance.concat(),
        noise_variance: file.noise_variance,
        valid: true,
        ..ModelEstimate::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gains::PitchModel;
    use crate::gains::adaptive::Adaptive;
    use crate::gains::pitch_model::tests::estimate_of;
    use crate::gains::schedule::tests::T6;

    const TRUST: Trust = Trust {
        delay: 1.0,
        oldest: 5.0,
        uncertainty: 0.25,
        factor: 4.0,
        rate: 1e3,
    };

    /// Planes half as strong as the schedule's, known to `deviation` in each coefficient.
    fn weaker(deviation: f64) -> ModelEstimate {
        let model = PitchModel {
            plane: 0.5 * T6.law.model.plane,
            ..T6.law.model
        };
        estimate_of(&model, 0.05, deviation)
    }

    /// The file that holds an estimate.
    fn file(estimate: &ModelEstimate) -> ModelFile {
        let den = [vec![1.0], estimate.a.clone()].concat();
        let mut file = ModelFile::exact(
            &estimate.input,
            &estimate.output,
            estimate.sample_time,
            estimate.b.clone(),
            den,
        );
        let width = estimate.covariance.len().isqrt();
        let rows = estimate.covariance.chunks(width);
        for (row, estimated) in file.covariance.iter_mut().zip(rows) {
            row.clone_from(&estimated[..2 * estimate.b.len()].to_vec());
        }
        file.speed = Some(1.0);
        file
    }

    #[test]
    fn a_file_gives_the_gains_that_the_same_model_received_live_gives() {
        let estimate = weaker(1e-6);
        let mut adaptive = Adaptive::new();
        adaptive.on_model(estimate.clone(), &TRUST);
        let (live, reason) = adaptive.step(&T6, &TRUST, 1.0, 0, 0.05);
        assert_eq!(reason, None);
        let read = FromFile::from_model(&file(&estimate), &T6, &TRUST).unwrap();
        assert_eq!(read.gains(&T6, &TRUST, 1.0), live);
        assert!((live.pitch_p / T6.reference.pitch_p - 2.0).abs() < 1e-2);
    }

    #[test]
    fn away_from_its_speed_the_model_goes_as_water_goes() {
        let model = file(&weaker(1e-6));
        let read = FromFile::from_model(&model, &T6, &TRUST).unwrap();
        for speed in [0.5, 2.0] {
            let scheduled = T6.at(speed);
            let gains = read.gains(&T6, &TRUST, speed);
            // Half as strong at every speed.
            let there = PitchModel {
                plane: read.law.model.plane * speed * speed,
                damping: read.law.model.damping * speed,
                ..read.law.model
            };
            assert_eq!(gains, T6.on(&there, speed));
            assert!(gains.pitch_p > scheduled.pitch_p);
        }
    }

    #[test]
    fn a_model_that_cannot_be_trusted_is_refused_with_the_reason() {
        type Change = fn(&mut ModelFile);
        let refused: [(Change, &str); 4] = [
            (|m| m.speed = None, "the speed of the vehicle"),
            (|m| m.output = "state:depth".to_owned(), "pitch_rate"),
            // Sixteen times the plane moment at a quarter of the speed.
            (|m| m.speed = Some(0.2), "times its scheduled"),
            (|m| m.sample_time = 9.0, "too long to resolve"),
        ];
        for (change, reason) in refused {
            let mut changed = file(&weaker(1e-6));
            change(&mut changed);
            let refusal = FromFile::from_model(&changed, &T6, &TRUST)
                .unwrap_err()
                .to_string();
            assert!(refusal.contains(reason), "{refusal}");
        }
        let unsure = FromFile::from_model(&file(&weaker(0.1)), &T6, &TRUST).unwrap_err();
        let unsure = unsure.to_string();
        assert!(unsure.contains("known only to"), "{unsure}");
    }

    #[test]
    fn what_is_refused_of_a_file_names_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("model.json");
        let read = || FromFile::read(path.to_str().unwrap(), &T6, &TRUST);
        assert!(read().unwrap_err().to_string().contains("model.json"));
        let mut model = file(&weaker(1e-6));
        model.write(&path).unwrap();
        assert!(read().is_ok());
        model.speed = None;
        model.write(&path).unwrap();
        let refusal = read().unwrap_err().to_string();
        assert!(refusal.contains("model.json") && refusal.contains("the speed of the vehicle"));
    }
}
