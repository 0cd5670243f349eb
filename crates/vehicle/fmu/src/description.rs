//! `modelDescription.xml`, as specified in FMI 3.0 (section 2.4).

use std::collections::BTreeSet;
use std::fmt::Write as _;

use planesman_parameters::Value;

use crate::resources::Resources;
use crate::unit;
use crate::variable::{Causality, Variable};

/// The default stop time of a simulation \[s\].
const STOP_TIME: f64 = 60.0;

/// The description of an FMU of this name, whose library has the name `identifier`.
pub(crate) fn text(resources: &Resources, name: &str, identifier: &str) -> String {
    let tick = resources.subject.tick();
    let stop = (STOP_TIME / tick).round().max(1.0) * tick;
    let (name, token) = (escaped(name), &resources.token);
    let version = escaped(&resources.manifest.version);
    let file = escaped(&resources.manifest.file);
    let variables: Vec<(usize, &Variable)> = (1..).zip(resources.variables()).collect();
    let units = variables.iter().map(|it| it.1.declaration.unit);
    let units: BTreeSet<&str> = units.chain(["s"]).filter(|it| !it.is_empty()).collect();
    let units: String = units.into_iter().map(unit::definition).collect();
    let all: String = variables.iter().map(|(at, it)| variable(*at, it)).collect();
    let structure: String = variables.iter().map(|(at, it)| unknown(*at, it)).collect();
    let initial: String = variables
        .iter()
        .filter(|(_, it)| matches!(it.causality, Causality::Output(_)))
        .map(|(at, _)| format!("<InitialUnknown valueReference=\"{at}\"/>\n"))
        .collect();
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <fmiModelDescription fmiVersion=\"3.0\" modelName=\"{name}\" instantiationToken=\"{token}\" \
         description=\"resources/{file}, sampled every {tick:?} s\" \
         generationTool=\"planesman {version}\" variableNamingConvention=\"flat\">\n\
         <CoSimulation modelIdentifier=\"{identifier}\" canHandleVariableCommunicationStepSize=\"true\" \
         fixedInternalStepSize=\"{tick:?}\" canGetAndSetFMUState=\"true\"/>\n\
         <UnitDefinitions>{units}</UnitDefinitions>\n\
         <LogCategories><Category name=\"logStatusDiscard\"/><Category name=\"logStatusError\"/></LogCategories>\n\
         <DefaultExperiment startTime=\"0\" stopTime=\"{stop:?}\" stepSize=\"{tick:?}\"/>\n\
         <ModelVariables>\n<Float64 name=\"time\" valueReference=\"0\" causality=\"independent\" variability=\"continuous\" unit=\"s\"/>\n\
         {all}</ModelVariables>\n<ModelStructure>\n{structure}{initial}</ModelStructure>\n</fmiModelDescription>\n"
    )
}

fn variable(reference: usize, variable: &Variable) -> String {
    let it = &variable.declaration;
    let kind = match it.default {
        Value::Bool(_) => "Boolean",
        Value::Integer(_) => "Int64",
        Value::Double(_) => "Float64",
        _ => "String",
    };
    let (causality, variability) = match variable.causality {
        Causality::Input => ("input", "continuous"),
        Causality::Output(_) if kind == "Float64" => ("output", "continuous"),
        Causality::Output(_) => ("output", "discrete"),
        Causality::Parameter if it.read_only => ("parameter", "fixed"),
        Causality::Parameter => ("parameter", "tunable"),
    };
    let mut description = it.description.replace("\n", " ");
    if !it.choices.is_empty() {
        let _ = write!(description, " One of {}.", it.choices.join(", "));
    }
    let mut text = format!(
        "<{kind} name=\"{}\" valueReference=\"{reference}\" description=\"{}\" causality=\"{causality}\" variability=\"{variability}\"",
        escaped(&it.name),
        escaped(&description),
    );
    if kind == "Float64" && !it.unit.is_empty() {
        let _ = write!(text, " unit=\"{}\"", it.unit);
    }
    if let Some((low, high)) = it.range {
        let _ = match kind {
            "Int64" => write!(text, " min=\"{}\" max=\"{}\"", low as i64, high as i64),
            _ => write!(text, " min=\"{low:?}\" max=\"{high:?}\""),
        };
    }
    match (&variable.causality, &it.default) {
        (Causality::Output(_), _) => text += "/>\n",
        (_, Value::String(start)) => {
            let _ = writeln!(text, "><Start value=\"{}\"/></{kind}>", escaped(start));
        }
        (_, start) => {
            let _ = writeln!(text, " start=\"{start}\"/>");
        }
    }
    text
}

/// The entry of an output in the model's structure.
fn unknown(reference: usize, variable: &Variable) -> String {
    let Causality::Output(direct) = &variable.causality else {
        return String::new();
    };
    // Inputs have the first value references.
    let direct: Vec<String> = direct.iter().map(|input| (input + 1).to_string()).collect();
    let direct = direct.join(" ");
    format!("<Output valueReference=\"{reference}\" dependencies=\"{direct}\"/>\n")
}

/// Text for an attribute; characters that XML cannot contain are left out.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for sign in text.chars() {
        match sign {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            '>' => escaped += "&gt;",
            '"' => escaped += "&quot;",
            '\t' | '\n' | '\r' => escaped.push(' '),
            '\0'..='\u{1f}' | '\u{fffe}' | '\u{ffff}' => {}
            sign => escaped.push(sign),
        }
    }
    escaped
}
