//! An identified model in an FMU: its difference equation, or its state space, from rest.
//!
//! ```text
//! one input      A(q) x = B(q) (f(u) - level)       y = g(x + offset)       f or g: the static curve, where there is one
//! several        x_(k+1) = A x_k + B u_k            y_k = C x_k + D u_k + offset
//! ```
//! At rest, earlier samples are assumed to be the input's level and the output's offset.

use std::collections::VecDeque;
use std::path::Path;

use planesman_identification::static_curve::StaticCurve;
use planesman_model_file::{ModelFile, Refusal, SeveralModelFile, Side, StateSpace};
use planesman_parameters::Value;

use crate::error::Error;
use crate::subject::{Parameters, Simulation, Subject};
use crate::variable::{Causality, Variable};

/// A model file, after reading.
pub(crate) struct Model {
    system: System,
    sample_time: f64,
    variables: Vec<Variable>,
}

#[derive(Clone)]
enum System {
    One(One),
    Several(Several),
}

impl Model {
    /// # Errors
    /// If a file is invalid, or the tick differs from the model's own.
    pub(crate) fn load(file: &Path, text: &str, tick: Option<f64>) -> Result<Self, Error> {
        let refused = |refusal| planesman_model_file::Error {
            path: file.display().to_string(),
            refusal,
        };
        let (system, sample_time, inputs, outputs) = if SeveralModelFile::recognises(file, text) {
            let model = SeveralModelFile::parse(file, text)?;
            let names: Vec<String> = (model.outputs.iter()).map(|it| it.output.clone()).collect();
            let several = Several::new(&model);
            (
                System::Several(several),
                model.sample_time,
                model.inputs,
                names,
            )
        } else {
            let model = ModelFile::parse(file, text)?;
            let one = One::new(&model).map_err(refused)?;
            let (inputs, outputs) = (vec![model.input], vec![model.output]);
            (System::One(one), model.sample_time, inputs, outputs)
        };
        if let Some(step) = tick.filter(|step| (step / sample_time - 1.0).abs() > 1e-9) {
            return Err(Error::Sampled {
                step,
                tick: sample_time,
            });
        }
        let inputs: Vec<String> = distinct(inputs, &[]);
        let outputs = distinct(outputs, &inputs);
        let output = |(place, name): (usize, String)| Variable {
            causality: Causality::Output(system.acts_at_once(place)),
            ..Variable::output(name, &Value::Double(0.0), "", "Output of the model")
        };
        Ok(Self {
            variables: (inputs.iter())
                .map(|it| Variable::input(it.clone(), "", "Input of the model"))
                .chain(outputs.into_iter().enumerate().map(output))
                .collect(),
            system,
            sample_time,
        })
    }
}

/// Names that differ from each other's and from `time`: duplicates get a number.
fn distinct(names: Vec<String>, others: &[String]) -> Vec<String> {
    let mut taken: Vec<String> = others.to_vec();
    taken.push("time".to_owned());
    let own = taken.len();
    for name in names {
        let numbered = (2..).map(|number| format!("{name}_{number}"));
        let free = [name.clone()].into_iter().chain(numbered);
        taken.extend(free.into_iter().find(|it| !taken.contains(it)));
    }
    taken.split_off(own)
}

impl Subject for Model {
    fn tick(&self) -> f64 {
        self.sample_time
    }

    fn variables(&self) -> &[Variable] {
        &self.variables
    }

    fn begin(&self, _: &Parameters) -> Result<Box<dyn Simulation>, Error> {
        Ok(Box::new(self.system.clone()))
    }
}

impl System {
    /// The indices of the inputs with direct feedthrough to an output.
    fn acts_at_once(&self, output: usize) -> Vec<usize> {
        match self {
            Self::One(one) if one.at_once != 0.0 => vec![0],
            Self::One(_) => Vec::new(),
            Self::Several(it) => {
                let row = it.space.d.get(output).map_or(&[][..], |row| row);
                (0..row.len()).filter(|input| row[*input] != 0.0).collect()
            }
        }
    }
}

impl Simulation for System {
    fn set_parameters(&mut self, _: &Parameters) -> Result<(), Error> {
        Ok(())
    }

    fn advance(&mut self, inputs: &[f64]) -> Result<(), Error> {
        match self {
            Self::One(one) => one.advance(inputs.first().copied().unwrap_or_default()),
            Self::Several(several) => several.advance(inputs),
        }
        Ok(())
    }

    fn outputs(&self, inputs: &[f64]) -> Vec<Value> {
        let outputs = match self {
            Self::One(one) => vec![one.output(inputs.first().copied().unwrap_or_default())],
            Self::Several(several) => several.outputs(inputs),
        };
        outputs.into_iter().map(Value::Double).collect()
    }

    fn copy(&self) -> Box<dyn Simulation> {
        Box::new(self.clone())
    }
}

/// A curve with the state of its play; only backlash has one.
#[derive(Clone)]
struct Curve {
    curve: StaticCurve,
    at: Option<f64>,
}

impl Curve {
    fn of(&self, x: f64) -> f64 {
        // Backlash goes on from where it stands; of the other curves the last value alone counts.
        let values = self.curve.of(&[self.at.unwrap_or(x), x]);
        values.last().copied().unwrap_or(x)
    }
}

/// A difference equation.
#[derive(Clone)]
struct One {
    /// `b1 ...` and `a1 ...`, without trailing zeros.
    num: Vec<f64>,
    den: Vec<f64>,
    /// `b0`.
    at_once: f64,
    level: f64,
    offset: f64,
    /// The curves before and after the equation.
    front: Option<Curve>,
    behind: Option<Curve>,
    /// Earlier samples, latest first.
    inputs: VecDeque<f64>,
    outputs: VecDeque<f64>,
}

impl One {
    fn new(model: &ModelFile) -> Result<Self, Refusal> {
        let curve = (model.static_curve.as_ref()).map(|file| {
            let named: Vec<(&str, f64)> = (file.parameters.iter())
                .map(|it| (it.name.as_str(), it.value))
                .collect();
            let curve = StaticCurve::named(&file.kind, &named).ok_or(Refusal::CurveParameters)?;
            Ok((file.side, Curve { curve, at: None }))
        });
        let curve = curve.transpose()?;
        let on = |side| curve.clone().filter(|it| it.0 == side).map(|it| it.1);
        let (at_once, num) = match model.num.split_first() {
            Some((first, rest)) if model.has_feedthrough() => (*first, rest),
            _ => (0.0, &model.num[..]),
        };
        let den = model.den.get(1..).unwrap_or_default();
        Ok(Self {
            inputs: vec![0.0; num.len()].into(),
            outputs: vec![0.0; den.len()].into(),
            num: num.to_vec(),
            den: den.to_vec(),
            at_once,
            level: model.input_level,
            offset: model.offset,
            front: on(Side::Input),
            behind: on(Side::Output),
        })
    }

    /// The input minus its level, after the input curve; and the output of the equation.
    fn equation(&self, input: f64) -> (f64, f64) {
        let sum = |coefficients: &[f64], past: &VecDeque<f64>| -> f64 {
            coefficients.iter().zip(past).map(|(c, x)| c * x).sum()
        };
        let driving = self.front.as_ref().map_or(input, |it| it.of(input)) - self.level;
        let past = sum(&self.num, &self.inputs) - sum(&self.den, &self.outputs);
        (driving, self.at_once * driving + past)
    }

    fn advance(&mut self, input: f64) {
        let (driving, output) = self.equation(input);
        if let Some(curve) = &mut self.front {
            curve.at = Some(curve.of(input));
        }
        if let Some(curve) = &mut self.behind {
            curve.at = Some(curve.of(output + self.offset));
        }
        for (past, now) in [(&mut self.inputs, driving), (&mut self.outputs, output)] {
            past.push_front(now);
            past.pop_back();
        }
    }

    fn output(&self, input: f64) -> f64 {
        let output = self.equation(input).1 + self.offset;
        self.behind.as_ref().map_or(output, |it| it.of(output))
    }
}

/// A state space.
#[derive(Clone)]
struct Several {
    space: StateSpace,
    offsets: Vec<f64>,
    state: Vec<f64>,
}

impl Several {
    fn new(model: &SeveralModelFile) -> Self {
        Self {
            state: vec![0.0; model.state_space.a.len()],
            offsets: model.outputs.iter().map(|it| it.offset).collect(),
            space: model.state_space.clone(),
        }
    }

    fn advance(&mut self, inputs: &[f64]) {
        let rows = self.space.a.iter().zip(&self.space.b);
        self.state = rows
            .map(|(a, b)| dot(a, &self.state) + dot(b, inputs))
            .collect();
    }

    fn outputs(&self, inputs: &[f64]) -> Vec<f64> {
        let rows = self.space.c.iter().zip(&self.space.d).zip(&self.offsets);
        rows.map(|((c, d), offset)| dot(c, &self.state) + dot(d, inputs) + offset)
            .collect()
    }
}

fn dot(row: &[f64], column: &[f64]) -> f64 {
    row.iter().zip(column).map(|(a, b)| a * b).sum()
}
