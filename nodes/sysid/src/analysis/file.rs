//! A model as a file that other programs load.

use planesman_model_file::{Continuous, Format, Heave, ModelFile, Physical as PhysicalFile, Place};

use super::Analysis;
use crate::conversion;
use crate::estimators::vehicle::{Physical, UNKNOWNS};
use crate::uncertainty::Uncertain;

impl Analysis {
    /// The model file: what other programs load.
    ///
    /// # Errors
    /// A sentence, when poles or zeros cannot be found.
    pub fn file(&self) -> Result<ModelFile, String> {
        let model = self.model();
        let reading = self.reading();
        let places = |found: Vec<Uncertain>| -> Vec<Place> { found.iter().map(place).collect() };
        let continuous = conversion::continuous(&model).ok();
        let covariance = self.estimate.coefficient_covariance(self.longest);
        Ok(ModelFile {
            format: Format::One,
            input: self.input.clone(),
            output: self.output.clone(),
            method: self.options.method.name(),
            speed: self.options.speed,
            sample_time: model.sample_time,
            num: model.b.clone(),
            den: std::iter::once(1.0)
                .chain(model.a.iter().copied())
                .collect(),
            covariance: covariance
                .row_iter()
                .map(|row| row.iter().copied().collect())
                .collect(),
            continuous: continuous.map(|it| Continuous {
                num: it.transfer.num.clone(),
                den: it.transfer.den.clone(),
                delay: it.delay,
            }),
            physical: self.physical().map(|it| self.physical_file(&it)),
            offset: self.estimate.offset(self.longest),
            noise_variance: self.estimate.noise_variance,
            noise_model: self.estimate.noise_model.clone(),
            poles: places(reading.poles()?),
            continuous_poles: places(reading.continuous_poles()?),
            zeros: places(reading.zeros()?),
            dc_gain: reading
                .dc_gain()
                .map(|gain| [gain.value.re, gain.real_deviation()]),
            fit: self.fit,
            held_out_fit: self.held_out_fit,
            verdict: self.verdict.clone(),
        })
    }

    fn physical_file(&self, found: &Physical) -> PhysicalFile {
        let at = |i: usize, j: usize| found.covariance[(i, j)];
        // What was known of heave, or found where that was in doubt.
        let known = self.options.knowledge.vehicle.heave;
        let heave = known.filter(|_| self.estimate.physical.is_some());
        let sought: Option<[f64; 4]> = found.values.as_slice()[UNKNOWNS..].try_into().ok();
        PhysicalFile {
            kappa: found.values[0],
            beta: found.values[1],
            mu: found.values[2],
            covariance: [0, 1, 2].map(|i| [0, 1, 2].map(|j| at(i, j))),
            heave: heave
                .map(|known| sought.map_or(known, |sought| known.with(sought)))
                .map(|it| Heave {
                    to_pitch: it.to_pitch,
                    damping: it.damping,
                    from_rate: it.from_rate,
                    from_input: it.from_input,
                }),
        }
    }
}

fn place(it: &Uncertain) -> Place {
    Place {
        re: it.value.re,
        im: it.value.im,
        re_deviation: it.real_deviation(),
        im_deviation: it.imaginary_deviation(),
    }
}
