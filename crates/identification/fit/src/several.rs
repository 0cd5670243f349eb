//! Models of several inputs and outputs: fitted to data, written as a file, validated on data.

use std::path::PathBuf;

use planesman_identification::GivenModel;
use planesman_identification::analysis::Shown;
use planesman_identification::several::{
    Analysis, ChannelModel, Judged, KnownStructure, analyse, analyse_validated,
};
use planesman_model_file::{
    ChannelModel as ChannelFile, LeftOut, OutputModel, SeveralFormat, SeveralModelFile, StateSpace,
};
use planesman_parallel::{Progress, stop_point};
use planesman_signals::PreparedRecord;
use serde_json::{Value, json};

use crate::compare::{CompareOptions, name};
use crate::error::FitError;
use crate::fit::{data_warnings, downgrade_verdict, with_data};
use crate::model_file::{given_channel, in_s, judgement, place};
use crate::options::{FitOptions, SignalOptions};
use crate::rules::check_ahead;

/// A model of each output, and the record.
#[derive(Debug)]
pub struct SeveralResult {
    /// The record, and how it was prepared.
    pub prepared: PreparedRecord,
    /// The validation record, if given.
    pub validation: Option<PreparedRecord>,
    /// The model of each output, with all inputs.
    pub outputs: Vec<Analysis>,
}

/// Reads the data and fits to each output a model with all inputs. `progress` receives the progress.
///
/// # Errors
/// If an option is for one input and one output, the data cannot be read, an input never moves, or the record does not determine a model.
pub fn fit_several(
    options: &FitOptions,
    progress: &dyn Progress,
) -> Result<SeveralResult, FitError> {
    // Refused before anything is read.
    options.check()?;
    let of = options.of_several()?;
    let (prepared, validation) = options.read(progress)?;
    let record = &prepared.resampled.record;
    let of_output = |output: usize| match &validation {
        None => analyse(record, output, &of),
        Some(validation) => analyse_validated(record, output, &of, &validation.resampled.record),
    };
    progress.begin("models", record.outputs.len() as u64, 0);
    let outputs = (0..record.outputs.len()).map(|output| {
        stop_point();
        let found = of_output(output);
        progress.step();
        found
    });
    let outputs: Result<Vec<Analysis>, _> = outputs.collect();
    progress.end();
    let mut outputs = outputs?;
    let readings = std::iter::once(&prepared).chain(&validation);
    let readings: Vec<_> = readings.map(|it| &it.reading).collect();
    for found in &mut outputs {
        let told = data_warnings(&readings).into_iter().map(Into::into);
        found.reasons.splice(0..0, told);
        found.verdict = downgrade_verdict(&readings, found.verdict);
    }
    Ok(SeveralResult {
        prepared,
        validation,
        outputs,
    })
}

impl SeveralResult {
    /// The models as text, with all details: each output's verdict, table of channels, numbers and reasons.
    #[must_use]
    pub fn text(&self) -> String {
        self.text_as(Shown {
            verbose: true,
            ..Shown::default()
        })
    }

    /// The results as text, with a choice of what to show; the lines about the record are printed with the first output.
    #[must_use]
    pub fn text_as(&self, shown: Shown<'_>) -> String {
        let texts = self.outputs.iter().enumerate().map(|(number, it)| {
            let record = if number == 0 { shown.record } else { "" };
            it.text_as(Shown { record, ..shown })
        });
        texts.collect::<Vec<_>>().join("\n")
    }

    /// The output of `--json`, without the information on the record.
    ///
    /// # Errors
    /// Same as [`SeveralResult::model_file`].
    pub fn as_json(&self) -> Result<Value, FitError> {
        let outputs = self.outputs.iter().map(|it| {
            let inputs = it.inputs.iter().map(|input| {
                json!({
                    "input": input.name,
                    "f": input.effect.f,
                    "f_needed": input.effect.needed.is_finite().then_some(input.effect.needed),
                    "own_share": input.own.share,
                    "left_out": input.model.is_none(),
                    "delay": input.model.as_ref().and_then(|it| it.lag).map(|it| json!({"best": it.best, "interval": it.interval})),
                    "residuals": input.model.as_ref().and_then(|it| it.residuals.as_ref()),
                })
            });
            let selected = it.candidates.iter().map(|of| {
                let channels = of.channels.iter().map(|channel| {
                    let name = &it.inputs[channel.input].name;
                    json!({"input": name, "order": channel.order(), "delay": channel.delay()})
                });
                let channels: Vec<Value> = channels.collect();
                json!({"kind": of.kind.name(), "channels": channels, "parameters": of.parameters(), "fit": of.fit()})
            });
            json!({
                "output": it.output,
                "inputs": inputs.collect::<Vec<_>>(),
                "selected": selected.collect::<Vec<_>>(),
                "attainable_fit": it.held_out.attainable,
                "offsets": (0..it.segments.len()).map(|run| it.offset(run)).collect::<Vec<_>>(),
            })
        });
        let found = json!({
            "model": self.model_file()?,
            "outputs": outputs.collect::<Vec<_>>(),
        });
        Ok(with_data(found, &self.prepared, self.validation.as_ref()))
    }

    /// The models as a file for `sysid compare`: transfer functions, and a state space of the complete system.
    ///
    /// # Errors
    /// If poles or zeros cannot be computed.
    pub fn model_file(&self) -> Result<SeveralModelFile, FitError> {
        let record = &self.prepared.resampled.record;
        let outputs = self.outputs.iter().map(output_model);
        let steps = self.prepared.steps.iter();
        Ok(SeveralModelFile {
            format: SeveralFormat::Four,
            inputs: record.inputs.clone(),
            sample_time: record.sample_time,
            outputs: outputs.collect::<Result<_, _>>()?,
            state_space: state_space(record.inputs.len(), &self.outputs),
            preparation: steps.map(|it| it.text.clone()).collect(),
        })
    }
}

fn output_model(found: &Analysis) -> Result<OutputModel, FitError> {
    let channels = found.channels().map(|(_, input, model)| {
        let reading = model.reading();
        let of = GivenModel::new(&model.estimate, 0);
        Ok(ChannelFile {
            input: input.name.clone(),
            num: of.num,
            den: of.den,
            covariance: of.covariance,
            delay: model.delay(),
            delay_interval: model.lag.map(|it| [it.interval.0, it.interval.1]),
            continuous: in_s(&model.estimate.model(0)),
            poles: reading.poles()?.iter().map(place).collect(),
            continuous_poles: reading.continuous_poles()?.iter().map(place).collect(),
            zeros: reading.zeros()?.iter().map(place).collect(),
            steady_state_gain: reading
                .steady_state_gain()
                .map(|gain| [gain.value.re, gain.real_deviation()]),
            effect: [input.effect.f, input.effect.needed.min(f64::MAX)],
        })
    });
    let channels: Result<Vec<_>, FitError> = channels.collect();
    let left_out = found.inputs.iter().filter(|it| it.model.is_none());
    Ok(OutputModel {
        output: found.output.clone(),
        method: found.kind.name().to_owned(),
        channels: channels?,
        left_out: left_out
            .map(|it| LeftOut {
                input: it.name.clone(),
                effect: [it.effect.f, it.effect.needed.min(f64::MAX)],
            })
            .collect(),
        offset: found.offset(found.longest),
        noise_variance: found.noise_variance,
        noise_denominator: found.noise_denominator.clone(),
        fit: found.fit,
        held_out_fit: found.held_out.fit,
        judgement: Some(judgement(
            found.verdict,
            found.reasons.iter().map(|it| &it.reason),
        )),
        verdict: found.sentences(),
    })
}

/// All channels as one system. For each input the samples that the longest delay needs are states, shared by its channels. Each channel
/// adds as many states as it has poles, in companion form.
///
/// ```text
/// A w = v,  y = b w,   states w(k-1) ... w(k-n),   v the input, delayed
/// ```
fn state_space(inputs: usize, outputs: &[Analysis]) -> StateSpace {
    let all = || {
        let outputs = outputs.iter().enumerate();
        outputs.flat_map(|(output, it)| it.channels().map(move |of| (output, of.0, of.2)))
    };
    // A channel of poles delays by one sample itself; one without has no states.
    let waits = |model: &ChannelModel| match model.estimate.layout.structure.poles {
        0 => model.delay(),
        _ => model.delay().saturating_sub(1),
    };
    let longest = |input: usize| {
        let of_input = all().filter(|it| it.1 == input);
        of_input.map(|it| waits(it.2)).max().unwrap_or(0)
    };
    let chains: Vec<usize> = (0..inputs).map(longest).collect();
    let first = |input: usize| chains[..input].iter().sum::<usize>();
    let poles: usize = all().map(|it| it.2.estimate.layout.structure.poles).sum();
    let n = first(inputs) + poles;
    let mut space = StateSpace {
        a: vec![vec![0.0; n]; n],
        b: vec![vec![0.0; inputs]; n],
        c: vec![vec![0.0; n]; outputs.len()],
        d: vec![vec![0.0; inputs]; outputs.len()],
    };
    for (input, length) in chains.iter().enumerate() {
        for k in 0..*length {
            match k {
                0 => space.b[first(input)][input] = 1.0,
                _ => space.a[first(input) + k][first(input) + k - 1] = 1.0,
            }
        }
    }
    let mut at = first(inputs);
    for (output, input, model) in all() {
        let layout = &model.estimate.layout;
        let theta = model.estimate.theta.as_slice();
        let (a, b) = (&theta[layout.a()], &theta[layout.b(0)]);
        let wait = waits(model);
        let delayed = wait.checked_sub(1).map(|last| first(input) + last);
        match (a, delayed) {
            ([], None) => space.d[output][input] = b[0],
            ([], Some(state)) => space.c[output][state] = b[0],
            (a, delayed) => {
                for (j, a) in a.iter().enumerate() {
                    space.a[at][at + j] = -a;
                }
                for j in 1..a.len() {
                    space.a[at + j][at + j - 1] = 1.0;
                }
                match delayed {
                    None => space.b[at][input] = 1.0,
                    Some(state) => space.a[at][state] = 1.0,
                }
                let at_once = model.delay() == 0;
                for (j, a) in a.iter().enumerate() {
                    space.c[output][at + j] = match at_once {
                        true => b.get(j + 1).copied().unwrap_or(0.0) - b[0] * a,
                        false => b.get(j).copied().unwrap_or(0.0),
                    };
                }
                if at_once {
                    space.d[output][input] = b[0];
                }
                at += a.len();
            }
        }
    }
    space
}

/// Models of several inputs and outputs on one record.
#[derive(Clone, Debug)]
pub struct SeveralComparison {
    /// The record, and how it was prepared.
    pub prepared: PreparedRecord,
    /// Each model's judgement on each of its outputs.
    pub models: Vec<SeveralCompared>,
}

/// A validated model of one output.
#[derive(Clone, Debug)]
pub struct SeveralCompared {
    /// The model's name in the tables.
    pub name: String,
    /// The output's name.
    pub output: String,
    /// The names of the inputs with an effect.
    pub inputs: Vec<String>,
    /// The model's performance on the data.
    pub judged: Judged,
}

/// Reads the data and validates models with several inputs and outputs on it. The signals are those of the first model; the field `models` of the
/// options is ignored.
///
/// # Errors
/// If models have different signals, the data lacks a signal, or a model has another sampling interval.
pub fn compare_several(
    models: &[(PathBuf, SeveralModelFile)],
    options: &CompareOptions,
    progress: &dyn Progress,
) -> Result<SeveralComparison, FitError> {
    let (path, first) = models.first().ok_or(FitError::NoModel)?;
    check_ahead(&options.ahead)?;
    let mut inputs: Vec<String> = Vec::new();
    let mut outputs: Vec<String> = Vec::new();
    let take = |names: &mut Vec<String>, name: &String| {
        if !names.contains(name) {
            names.push(name.clone());
        }
    };
    for (_, model) in models {
        model.inputs.iter().for_each(|it| take(&mut inputs, it));
        let of = model.outputs.iter().map(|it| &it.output);
        of.for_each(|it| take(&mut outputs, it));
    }
    let none = || FitError::NoSignal;
    let mut inputs = inputs.into_iter();
    let mut outputs = outputs.into_iter();
    let signals = SignalOptions {
        data: options.data.clone(),
        input: inputs.next().ok_or_else(none)?,
        output: outputs.next().ok_or_else(none)?,
        other_inputs: inputs.collect(),
        other_outputs: outputs.collect(),
        grid: options.grid.clone(),
        preparation: options.preparation,
        ..SignalOptions::default()
    };
    signals.check()?;
    let prepared = options.read(&signals, path, first.sample_time, progress)?;
    let record = &prepared.resampled.record;
    let paths: Vec<PathBuf> = models.iter().map(|it| it.0.clone()).collect();
    let mut compared = Vec::new();
    for (path, model) in models {
        for of in &model.outputs {
            let place = |names: &[String], name: &String| names.iter().position(|it| it == name);
            let output = place(&record.outputs, &of.output).ok_or(FitError::NoSignal)?;
            let channels = of.channels.iter().map(|it| {
                let input = place(&record.inputs, &it.input).ok_or(FitError::NoSignal)?;
                Ok::<(usize, GivenModel), FitError>((input, given_channel(it, model.sample_time)))
            });
            let given = KnownStructure {
                channels: channels.collect::<Result<_, _>>()?,
                offset: of.offset,
                sample_time: model.sample_time,
            };
            let judged = given.on(record, output);
            compared.push(SeveralCompared {
                name: name(path, &paths),
                output: of.output.clone(),
                inputs: of.channels.iter().map(|it| it.input.clone()).collect(),
                judged: judged.map_err(|source| FitError::Judgement {
                    model: path.clone(),
                    rate: 1.0 / model.sample_time,
                    source,
                })?,
            });
        }
    }
    Ok(SeveralComparison {
        models: compared,
        prepared,
    })
}

#[cfg(test)]
mod tests {
    use planesman_identification::analysis::Verdict;
    use planesman_identification::{filter, noise, with_noise};
    use planesman_model_file::ModelFile;

    use super::*;
    use crate::data::{Columns, DataOptions};
    use crate::options::{MethodChoice, Validation};

    /// Numerator and denominator in powers of `q^-1`.
    type Channel = (&'static [f64], &'static [f64]);

    /// Channels with and without delay, of order 0, 1 and 2: two inputs to two outputs, with their offsets.
    const CHANNELS: [[Channel; 2]; 2] = [
        [
            (&[0.0, 0.0, 0.0, 0.2], &[1.0, -0.9]),
            (&[0.0, -0.05, -0.005], &[1.0, -1.6, 0.71]),
        ],
        [(&[0.3, 0.1], &[1.0, -0.8]), (&[0.0, 0.0, 0.7], &[1.0])],
    ];
    const OFFSETS: [f64; 2] = [5.0, -2.0];

    fn held(seed: u32, count: usize) -> Vec<f64> {
        let levels = noise(seed, count);
        (0..count).map(|k| levels[k - k % 6]).collect()
    }

    /// The outputs from rest.
    fn outputs(inputs: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let of = |(row, offset): (&[Channel; 2], f64)| {
            let parts: Vec<Vec<f64>> = (row.iter().zip(inputs))
                .map(|((num, den), u)| filter(num, den, u))
                .collect();
            let sums = (0..inputs[0].len()).map(|k| parts[0][k] + parts[1][k] + offset);
            sums.collect()
        };
        CHANNELS.iter().zip(OFFSETS).map(of).collect()
    }

    fn columns(seed: u32, size: f64) -> Columns {
        let inputs = [held(seed, 900), held(seed + 1, 900)];
        let names = ["u", "v"]
            .map(str::to_owned)
            .into_iter()
            .zip(inputs.clone());
        let measured = outputs(&inputs).into_iter().enumerate();
        let measured = measured.map(|(i, y)| {
            let name = ["y", "z"][i].to_owned();
            (name, with_noise(&y, seed + 7 + i as u32, size))
        });
        names.chain(measured).collect()
    }

    fn options(data: Columns) -> FitOptions {
        let mut options = FitOptions::default();
        options.signals.data = DataOptions::columns(data);
        options.signals.data.sample_time = Some(0.5);
        options.signals.input = "u".to_owned();
        options.signals.other_inputs = vec!["v".to_owned()];
        options.signals.output = "y".to_owned();
        options.signals.other_outputs = vec!["z".to_owned()];
        options
    }

    #[test]
    fn the_state_space_of_the_file_does_what_the_truth_does() {
        let found = fit_several(&options(columns(1, 0.01)), &()).unwrap();
        for it in &found.outputs {
            assert_eq!(it.verdict, Verdict::Good, "{}", it.text());
        }
        let model = found.model_file().unwrap();
        model.check().unwrap();
        let StateSpace { a, b, c, d } = &model.state_space;
        let inputs = [held(50, 300), held(51, 300)];
        let truth = outputs(&inputs);
        let row = |row: &[f64], of: &[f64]| -> f64 { row.iter().zip(of).map(|(a, x)| a * x).sum() };
        let mut x = vec![0.0; a.len()];
        for k in 0..300 {
            let u = [inputs[0][k], inputs[1][k]];
            for (i, truth) in truth.iter().enumerate() {
                let y = row(&c[i], &x) + row(&d[i], &u) + model.outputs[i].offset;
                assert!((y - truth[k]).abs() < 0.05, "{i} {k}: {y} {}", truth[k]);
            }
            let next = a.iter().zip(b).map(|(a, b)| row(a, &x) + row(b, &u));
            x = next.collect();
        }
    }

    #[test]
    fn a_file_is_read_again_and_judged_on_other_data() {
        let found = fit_several(&options(columns(1, 0.05)), &()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        for ending in ["json", "yaml"] {
            let path = folder.path().join(format!("model.{ending}"));
            found.model_file().unwrap().write(&path).unwrap();
            let text = std::fs::read_to_string(&path).unwrap();
            assert!(SeveralModelFile::recognises(&path, &text));
            let read = SeveralModelFile::parse(&path, &text).unwrap();
            assert_eq!(read, found.model_file().unwrap());
            let refusal = ModelFile::read(&path).unwrap_err().to_string();
            assert!(refusal.contains("several inputs"), "{refusal}");
            let mut of = CompareOptions {
                data: DataOptions::columns(columns(60, 0.05)),
                ..CompareOptions::default()
            };
            of.data.sample_time = Some(0.5);
            let judged = compare_several(&[(path, read)], &of, &()).unwrap();
            let outputs: Vec<&str> = judged.models.iter().map(|it| it.output.as_str()).collect();
            assert_eq!(outputs, ["y", "z"]);
            for it in &judged.models {
                assert!(
                    it.judged.fit.unwrap() > 90.0,
                    "{} {:?}",
                    it.output,
                    it.judged.fit
                );
            }
        }
    }

    #[test]
    fn validation_data_judges_and_several_outputs_of_one_input_are_each_fitted() {
        let mut of = options(columns(1, 0.05));
        of.validation = Some(Validation::Window(300.0, 450.0));
        of.signals.other_inputs = Vec::new();
        let found = fit_several(&of, &()).unwrap();
        assert_eq!(found.outputs.len(), 2);
        assert_eq!(found.outputs[0].inputs.len(), 1);
        let said = found.outputs[0].sentences().concat();
        assert!(said.contains("evaluated on the validation data"), "{said}");
    }

    #[test]
    fn what_is_of_one_input_is_refused_before_data_is_read() {
        let refusal = |change: &dyn Fn(&mut FitOptions)| {
            let mut of = options(Vec::new());
            of.signals.data = DataOptions::files(["/no/such/table.csv"]);
            change(&mut of);
            fit_several(&of, &()).expect_err("refused").to_string()
        };
        type Case<'a> = (&'a dyn Fn(&mut FitOptions), &'a str);
        let cases: [Case<'_>; 5] = [
            (&|_| (), "/no/such/table.csv"),
            (
                &|it| it.signals.other_inputs.push("u".to_owned()),
                "'u' is given twice",
            ),
            (
                &|it| {
                    it.method =
                        MethodChoice::One(planesman_identification::estimators::Method::Armax)
                },
                "method armax is for one input",
            ),
            (
                &|it| it.signals.reference = Some("r".to_owned()),
                "reference is for one input",
            ),
            (&|it| it.bootstrap = Some(200), "bootstrap is for one input"),
        ];
        for (change, said) in cases {
            let refusal = refusal(change);
            assert!(refusal.contains(said), "{said}: {refusal}");
        }
        let single = crate::fit(&options(columns(1, 0.05)), &()).expect_err("refused");
        assert!(single.to_string().contains("several"), "{single}");
    }
}
