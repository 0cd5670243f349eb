//! Writes a model as a file that other programs load.

use planesman_identification::analysis::{Analysis, Curved, Reason, Verdict};
use planesman_identification::estimators::{
    Error, Method, Physical, ProcessModel, Property, UNKNOWNS,
};
use planesman_identification::selection::Kind;
use planesman_identification::static_curve::{Side, StaticCurve};
use planesman_identification::{GivenModel, IdentificationError, Model, Uncertain, continuous};
use planesman_linear::rows;
use planesman_model_file::{
    ChannelModel, Continuous, Format, Heave, Judgement, ModelFile, Parameter,
    Physical as PhysicalFile, Place, Process, Refusal, Side as FileSide,
    StaticCurve as StaticCurveFile,
};

/// The content of a model file.
///
/// # Errors
/// If poles or zeros cannot be computed.
pub fn from_analysis(analysis: &Analysis) -> Result<ModelFile, IdentificationError> {
    let of = GivenModel::new(&analysis.estimate, analysis.longest);
    let reading = analysis.reading();
    let places = |found: Vec<Uncertain>| -> Vec<Place> { found.iter().map(place).collect() };
    Ok(ModelFile {
        format: Format::Three,
        input: analysis.input.clone(),
        output: analysis.output.clone(),
        method: analysis.method_name().to_owned(),
        speed: analysis.options.speed,
        sample_time: of.sample_time,
        num: of.num,
        den: of.den,
        covariance: of.covariance,
        continuous: match (&analysis.estimate.process, &analysis.estimate.frequency) {
            (Some(process), _) => {
                let (num, den, delay) = process.transfer();
                Some(Continuous { num, den, delay })
            }
            (None, Some(fit)) => Some(Continuous {
                num: fit.transfer.transfer_function.num.clone(),
                den: fit.transfer.transfer_function.den.clone(),
                delay: fit.transfer.delay,
            }),
            (None, None) => in_s(&analysis.estimate.model_of_means(analysis.longest)),
        },
        process: analysis.estimate.process.as_ref().map(process_file),
        static_curve: analysis.curved.as_ref().map(curve_file),
        physical: analysis.physical().map(|it| physical_file(analysis, &it)),
        offset: of.offset,
        input_level: of.input_level,
        noise_variance: of.noise_variance,
        noise_model: analysis.estimate.noise_model.clone(),
        noise_denominator: of.noise_denominator,
        poles: places(reading.poles()?),
        continuous_poles: places(reading.continuous_poles()?),
        zeros: places(reading.zeros()?),
        steady_state_gain: reading
            .steady_state_gain()
            .map(|gain| [gain.value.re, gain.real_deviation()]),
        fit: analysis.fit,
        held_out_fit: analysis.held_out.fit,
        preparation: Vec::new(),
        judgement: Some(judgement(analysis.verdict, analysis.reasons.iter())),
        verdict: analysis.sentences(),
    })
}

/// The continuous model with the same response under zero-order hold.
pub(crate) fn in_s(model: &Model) -> Option<Continuous> {
    let it = continuous(model).ok()?;
    Some(Continuous {
        num: it.transfer.num.clone(),
        den: it.transfer.den.clone(),
        delay: it.delay,
    })
}

/// A verdict with its reasons as data.
pub(crate) fn judgement<'a>(
    verdict: Verdict,
    reasons: impl Iterator<Item = &'a Reason>,
) -> Judgement {
    Judgement {
        standing: verdict.standing().name().to_owned(),
        code: verdict.code().to_owned(),
        findings: reasons.map(|it| it.code().to_owned()).collect(),
    }
}

fn curve_file(found: &Curved) -> StaticCurveFile {
    StaticCurveFile {
        side: match found.side {
            Side::Input => FileSide::Input,
            Side::Output => FileSide::Output,
        },
        kind: found.fitted.curve.name().to_owned(),
        parameters: (found.fitted.named())
            .map(|(name, value, deviation)| Parameter {
                name,
                unit: String::new(),
                value,
                deviation,
            })
            .collect(),
    }
}

fn curve(file: &StaticCurveFile) -> Result<(Side, StaticCurve), Refusal> {
    let parameters = file.parameters.iter();
    let parameters: Vec<_> = parameters.map(|it| (it.name.as_str(), it.value)).collect();
    let curve = StaticCurve::named(&file.kind, &parameters).ok_or(Refusal::CurveParameters)?;
    let side = match file.side {
        FileSide::Input => Side::Input,
        FileSide::Output => Side::Output,
    };
    Ok((side, curve))
}

/// The model of a file, for validation on data.
///
/// # Errors
/// [`Refusal::CurveParameters`], if the static curve is invalid.
pub fn given(file: &ModelFile) -> Result<GivenModel, Refusal> {
    let by_equation = Method::all_with(Property::HasNoiseInEquation).map(Method::name);
    let mut by_equation = by_equation.chain([Kind::Arx.name()]);
    // A noise model stands in the equation; without one the method says where the noise is.
    let in_equation = !file.noise_model.is_empty() || by_equation.any(|it| it == file.method);
    let curve = file.static_curve.as_ref().map(curve).transpose()?;
    Ok(GivenModel {
        curve,
        sample_time: file.sample_time,
        num: file.num.clone(),
        den: file.den.clone(),
        covariance: file.covariance.clone(),
        offset: file.offset,
        input_level: file.input_level,
        error: if in_equation {
            Error::Equation
        } else {
            Error::Output
        },
        noise_variance: file.noise_variance,
        noise_model: file.noise_model.clone(),
        noise_denominator: file.noise_denominator.clone(),
    })
}

/// A channel of a file with several inputs, for validation on data.
pub(crate) fn given_channel(channel: &ChannelModel, sample_time: f64) -> GivenModel {
    GivenModel {
        sample_time,
        num: channel.num.clone(),
        den: channel.den.clone(),
        covariance: channel.covariance.clone(),
        offset: 0.0,
        input_level: 0.0,
        error: Error::Output,
        noise_variance: 0.0,
        noise_model: Vec::new(),
        noise_denominator: Vec::new(),
        curve: None,
    }
}

fn process_file(found: &ProcessModel) -> Process {
    let named = found.named();
    Process {
        form: found.form.name().to_owned(),
        equation: found.form.equation().to_owned(),
        parameters: named
            .map(|(name, unit, value, deviation)| Parameter {
                name: name.to_owned(),
                unit: unit.to_owned(),
                value,
                deviation,
            })
            .collect(),
        covariance: rows(&found.covariance),
    }
}

fn physical_file(analysis: &Analysis, found: &Physical) -> PhysicalFile {
    let at = |i: usize, j: usize| found.covariance[(i, j)];
    // What was known of heave, or found where that was in doubt.
    let known = analysis.options.knowledge.vehicle.heave;
    let heave = known.filter(|_| analysis.estimate.physical.is_some());
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

pub(crate) fn place(it: &Uncertain) -> Place {
    Place {
        re: it.value.re,
        im: it.value.im,
        re_deviation: it.real_deviation(),
        im_deviation: it.imaginary_deviation(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_identification::analysis::{Options, analyse};
    use planesman_identification::noise;
    use planesman_identification::{Record, filter, with_noise};

    const SAMPLE_TIME: f64 = 0.05;

    #[test]
    fn the_model_file_holds_what_python_control_and_matlab_take() {
        let inputs = noise(1, 400);
        let outputs = with_noise(
            &filter(&[0.0, 0.2, 0.1], &[1.0, -1.6, 0.63], &inputs),
            2,
            0.05,
        );
        let options = Options {
            order: Some(2),
            delay: Some(1),
            ..Options::default()
        };
        let (inputs, outputs) = (vec![("u", inputs)], vec![("y", outputs)]);
        let record = Record::of_run(SAMPLE_TIME, inputs, outputs).unwrap();
        let analysis = analyse(&record, &options).unwrap();
        let file = serde_json::to_value(from_analysis(&analysis).unwrap()).unwrap();
        assert_eq!(file["den"].as_array().unwrap().len(), 3);
        assert_eq!(file["num"].as_array().unwrap().len(), 2);
        assert_eq!(file["sample_time"], SAMPLE_TIME);
        // G(1) = 0.3 / 0.03 in both domains.
        let steady = |of: &serde_json::Value, at: usize| -> f64 {
            let list = |name: &str| -> Vec<f64> {
                of[name]
                    .as_array()
                    .unwrap()
                    .iter()
                    .map(|c| c.as_f64().unwrap())
                    .collect()
            };
            let value = |c: Vec<f64>| {
                if at == 0 {
                    c[c.len() - 1]
                } else {
                    c.iter().sum()
                }
            };
            value(list("num")) / value(list("den"))
        };
        assert!((steady(&file, 1) - 10.0).abs() < 0.5);
        assert!((steady(&file["continuous"], 0) - steady(&file, 1)).abs() < 1e-6);
        assert_eq!(file["poles"].as_array().unwrap().len(), 2);
    }
}
