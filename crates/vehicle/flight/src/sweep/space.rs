//! The varied parameters, and the resulting cases.
//!
//! A case is a combination of values and a seed. The number of a case alone determines its values: the first parameter varies slowest, samples of a
//! Latin hypercube vary faster than the grid, and the seed varies fastest. No list of cases is stored.

use crate::error::{During, Result, refuse, refused};
use planesman_parameters::Value;
use planesman_text::{option, setting};
use rand::RngExt as _;
use rand::seq::SliceRandom as _;
use rand_pcg::Pcg64;

use crate::scenario::{ParameterName, Scenario};

/// Largest number of values of one parameter.
const MOST_VALUES: f64 = 1e6;

/// Largest number of cases.
const MOST_CASES: u64 = 1_000_000_000;

/// A varied parameter and its values.
#[derive(Clone, Debug)]
pub struct Axis {
    /// The varied parameter.
    pub parameter: ParameterName,
    /// Unit of the parameter, as declared.
    pub unit: &'static str,
    /// Its values.
    pub values: Vec<Value>,
    /// Whether the values are sampled together with the values of other sampled parameters.
    pub is_sampled: bool,
}

impl Axis {
    /// Parses `NODE.PARAMETER=VALUES` from the command line. VALUES is a list, for numbers also `FROM:TO:STEP`, or `FROM..TO` for `samples`
    /// random values.
    fn read(text: &str, place: usize, samples: u32, seed: u32) -> Result<Self> {
        let (parameter, values) = ParameterName::split(text)?;
        if parameter.node == "plant_sim" && parameter.name == "seed" {
            refuse!("refused: use {} to vary the seed", option("seeds"));
        }
        let declaration = parameter.declaration()?;
        let is_number = matches!(declaration.default, Value::Double(_) | Value::Integer(_));
        let is_whole = matches!(declaration.default, Value::Integer(_));
        let number = |text: &str| -> Result<f64> {
            let number = match parameter.value(text)? {
                Value::Double(number) => Some(number),
                Value::Integer(number) => Some(number as f64),
                _ => None,
            };
            number.ok_or_else(|| refused!("'{text}' is not a number"))
        };
        let typed = |number: f64| match is_whole {
            true => Value::Integer(number.round() as i64),
            false => Value::Double(number),
        };
        let range = values.split_once("..").filter(|_| is_number);
        let parts: Vec<&str> = values.split(':').collect();
        let (values, is_sampled) = match (range, parts.as_slice()) {
            (Some((from, to)), _) => {
                let (from, to) = (number(from)?, number(to)?);
                if samples == 0 {
                    refuse!(
                        "the range FROM..TO needs a number of samples. Give {}",
                        setting("samples", "N")
                    );
                }
                if from >= to {
                    refuse!("refused: a range FROM..TO must have FROM below TO");
                }
                let shares = strata(samples, place, seed);
                let at = |share: f64| typed(rounded(from + share * (to - from)));
                (shares.into_iter().map(at).collect(), true)
            }
            (None, [from, to, step]) if is_number => {
                let numbers = steps(number(from)?, number(to)?, number(step)?)?;
                (numbers.into_iter().map(typed).collect(), false)
            }
            _ => {
                let items = items(values).into_iter().map(|it| parameter.value(it));
                (items.collect::<Result<Vec<_>>>()?, false)
            }
        };
        let values = values
            .into_iter()
            .map(|value| Ok(declaration.accept(value)?));
        Ok(Self {
            values: values.collect::<Result<_>>()?,
            unit: declaration.unit,
            parameter,
            is_sampled,
        })
    }

    /// Node and name, with unit.
    pub fn name(&self) -> String {
        with_unit(self.parameter.to_string(), self.unit)
    }

    /// Name without the node, with unit.
    pub fn label(&self) -> String {
        with_unit(self.parameter.name.clone(), self.unit)
    }

    /// The values as numbers; `None` for words.
    pub fn numbers(&self) -> Option<Vec<f64>> {
        let number = |value: &Value| match value {
            Value::Integer(it) => Some(*it as f64),
            Value::Double(it) => Some(*it),
            _ => None,
        };
        self.values.iter().map(number).collect()
    }
}

/// Numbers from `from` to `to`; `to` is included if a step reaches it.
fn steps(from: f64, to: f64, step: f64) -> Result<Vec<f64>> {
    let count = ((to - from) / step + 1e-9).floor();
    if !(0.0..MOST_VALUES).contains(&count) {
        refuse!("refused: FROM:TO:STEP must get from FROM to TO in at most {MOST_VALUES} steps");
    }
    let at = |i: u64| rounded(from + i as f64 * step);
    Ok((0..=count as u64).map(at).collect())
}

/// Rounds to twelve digits, so that three times 0.1 and 0.4 make 0.7.
fn rounded(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}

/// A random number in each of `samples` equal parts of [0, 1), in random order: one axis of a Latin hypercube (McKay, Beckman and Conover
/// 1979).
fn strata(samples: u32, place: usize, seed: u32) -> Vec<f64> {
    let mut random = Pcg64::new(u128::from(seed), place as u128);
    let mut parts: Vec<u32> = (0..samples).collect();
    parts.shuffle(&mut random);
    let within = |part: u32| (f64::from(part) + random.random::<f64>()) / f64::from(samples);
    parts.into_iter().map(within).collect()
}

/// Items of a list, separated by commas outside brackets.
fn items(text: &str) -> Vec<&str> {
    let mut depth = 0;
    let is_between = |c: char| {
        depth += i32::from(c == '[') - i32::from(c == ']');
        c == ',' && depth == 0
    };
    text.split(is_between).collect()
}

/// All cases.
#[derive(Clone, Debug)]
pub struct Space {
    /// The varied parameters, the slowest first.
    pub axes: Vec<Axis>,
    /// Number of samples of a Latin hypercube; 1 if there is none.
    samples: u64,
    /// Number of seeds, starting at the scenario's seed.
    pub seeds: u32,
}

impl Space {
    /// Creates the cases of these `--vary`.
    ///
    /// # Errors
    /// If the form is wrong, or the parameter's declaration refuses a value.
    pub fn new(vary: &[String], samples: u32, seeds: u32, seed: u32) -> Result<Self> {
        let axis = |(place, text): (usize, &String)| {
            Axis::read(text, place, samples, seed).during(|| setting("vary", text).to_string())
        };
        let axes = vary.iter().enumerate().map(axis);
        let axes = axes.collect::<Result<Vec<_>>>()?;
        let is_sampled = axes.iter().any(|axis| axis.is_sampled);
        if samples > 0 && !is_sampled {
            refuse!(
                "{} needs a range: there is no {} to sample from",
                option("samples"),
                setting("vary", "NODE.PARAMETER=FROM..TO")
            );
        }
        for (place, axis) in axes.iter().enumerate() {
            if axes[..place]
                .iter()
                .any(|other| other.parameter == axis.parameter)
            {
                refuse!("{}: {} occurs twice", option("vary"), axis.parameter);
            }
        }
        let space = Self {
            axes,
            samples: if is_sampled { samples.into() } else { 1 },
            seeds,
        };
        let sizes = space.axes.iter().filter(|axis| !axis.is_sampled);
        let all = sizes
            .map(|axis| axis.values.len() as u64)
            .chain([space.samples, seeds.into()])
            .try_fold(1_u64, |all, some| all.checked_mul(some))
            .filter(|all| *all <= MOST_CASES);
        match all {
            Some(_) => Ok(space),
            None => refuse!("refused: more than {MOST_CASES} cases"),
        }
    }

    /// Number of combinations of values.
    pub fn combinations(&self) -> u64 {
        let sizes = self.axes.iter().filter(|axis| !axis.is_sampled);
        sizes.fold(self.samples, |all, axis| all * axis.values.len() as u64)
    }

    /// Index of each axis' value in a combination.
    pub fn places(&self, combination: u64) -> Vec<usize> {
        let sample = (combination % self.samples) as usize;
        let mut rest = combination / self.samples;
        let mut places = vec![sample; self.axes.len()];
        for (axis, place) in self.axes.iter().zip(&mut places).rev() {
            if !axis.is_sampled {
                let size = axis.values.len() as u64;
                *place = (rest % size) as usize;
                rest /= size;
            }
        }
        places
    }

    /// Values of a combination, in the order of the axes.
    pub fn values(&self, combination: u64) -> impl Iterator<Item = (&Axis, &Value)> {
        let places = self.places(combination).into_iter();
        let axes = self.axes.iter().zip(places);
        axes.map(|(axis, place)| (axis, &axis.values[place]))
    }

    /// The scenario of a combination, with the scenario's own seed.
    ///
    /// # Errors
    /// If a parameter's declaration refuses a value.
    pub fn scenario(&self, base: &Scenario, combination: u64) -> Result<Scenario> {
        let mut scenario = base.clone();
        for (axis, value) in self.values(combination) {
            scenario.put(&axis.parameter, value.clone())?;
        }
        Ok(scenario)
    }
}

fn with_unit(name: String, unit: &str) -> String {
    match unit {
        "" => name,
        unit => format!("{name} [{unit}]"),
    }
}

#[cfg(test)]
mod tests {
    use planesman_text::in_one_line;

    use super::*;

    fn space(vary: &[&str], samples: u32, seeds: u32) -> Result<Space> {
        let vary: Vec<String> = vary.iter().map(|it| (*it).to_owned()).collect();
        Space::new(&vary, samples, seeds, 1)
    }

    #[test]
    fn a_range_a_list_and_units_are_read_as_written() {
        let space = space(
            &[
                "depth_controller.depth.p=0.4:1.6:0.1",
                "plant_sim.speed=1ft/s,2ft/s",
                "dha_actuator.model=ideal,dha",
            ],
            0,
            3,
        )
        .expect("a space");
        let gains = space.axes[0].numbers().expect("numbers");
        assert_eq!(gains.len(), 13);
        assert_eq!(gains[3], 0.7);
        assert_eq!(gains[12], 1.6);
        assert_eq!(space.axes[1].numbers().expect("numbers"), [0.3048, 0.6096]);
        assert_eq!(space.axes[2].numbers(), None);
        assert_eq!(space.combinations(), 13 * 2 * 2);
        assert_eq!(space.places(0), [0, 0, 0]);
        assert_eq!(space.places(51), [12, 1, 1]);
        assert_eq!(space.places(2), [0, 1, 0]);
    }

    #[test]
    fn a_latin_hypercube_has_one_sample_in_each_part_of_each_axis() {
        let sampled = space(
            &[
                "depth_controller.depth.p=0..1",
                "dha_actuator.model=ideal,dha",
                "plant_sim.speed=1ft/s..2ft/s",
            ],
            50,
            1,
        )
        .expect("a space");
        assert_eq!(sampled.combinations(), 100);
        let gains = sampled.axes[0].numbers().expect("numbers");
        let mut parts: Vec<u64> = gains.iter().map(|it| (it * 50.0) as u64).collect();
        assert!(!parts.is_sorted());
        parts.sort_unstable();
        assert_eq!(parts, (0..50).collect::<Vec<_>>());
        let speeds = sampled.axes[2].numbers().expect("numbers");
        assert!(speeds.iter().all(|it| (0.3048..0.6096).contains(it)));
        // The axes are not in one order, and the samples of a seed are always the same.
        assert_ne!(
            gains
                .iter()
                .map(|it| (it * 50.0) as u64)
                .collect::<Vec<_>>(),
            parts
        );
        let again = space(&["depth_controller.depth.p=0..1"], 50, 1).expect("a space");
        assert_eq!(again.axes[0].numbers().expect("numbers"), gains);
    }

    #[test]
    fn what_is_refused_is_refused_by_name() {
        for (vary, samples, part) in [
            ("plant_sim.sped=1,2", 0, "did you mean"),
            ("rudder.depth.p=1,2", 0, "unknown node 'rudder'"),
            ("depth_controller.depth.p", 0, "NODE.PARAMETER=VALUE"),
            ("depth_controller.depth.p=1:2", 0, "number"),
            ("depth_controller.depth.p=2:1:0.1", 0, "FROM:TO:STEP"),
            ("depth_controller.depth.p=1:2:0", 0, "FROM:TO:STEP"),
            ("depth_controller.depth.p=0..1", 0, "samples"),
            ("depth_controller.depth.p=1..0", 5, "below"),
            ("depth_controller.depth.p=1,2", 5, "samples"),
            ("plant_sim.speed=1ft/s,-1", 0, "must lie in"),
            ("plant_sim.speed=1ft", 0, "number"),
            ("plant_sim.seed=1,2", 0, "seeds"),
            ("dha_actuator.model=ideal,perfect", 0, "one of"),
        ] {
            let refusal = space(&[vary], samples, 1).expect_err(vary);
            let text = in_one_line(&refusal);
            assert!(text.contains(part), "{vary}: {text}");
        }
    }
}
