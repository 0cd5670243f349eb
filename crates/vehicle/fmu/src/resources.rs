//! The folder `resources` of an FMU: the subject's file, and `fmu.json`, which describes it.

use std::path::Path;

use planesman_parameters::{Value, Values};
use planesman_units::Quantity;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use crate::actuator::Ticking;
use crate::error::Error;
use crate::model::Model;
use crate::node::Node;
use crate::subject::{Kind, Subject};
use crate::variable::{Causality, Variable};
use crate::vehicle::Driven;

/// The file's name within `resources`.
pub(crate) const MANIFEST: &str = "fmu.json";

/// The name and version of the manifest's format, by which a library that reads it is recognised.
pub(crate) const FORMAT: &str = "planesman fmu 1";

/// The data types as an enumeration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Format {
    /// The only version so far.
    #[default]
    #[serde(rename = "planesman fmu 1")]
    One,
}

/// The description of an FMU.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Manifest {
    pub(crate) format: Format,
    /// The version of the program that wrote the manifest.
    pub(crate) version: String,
    pub(crate) kind: Kind,
    /// The subject's file, in the same folder.
    pub(crate) file: String,
    /// The tick \[s\]; `None`: the subject's own.
    pub(crate) tick: Option<f64>,
    /// Start values other than the defaults, each as YAML.
    pub(crate) start: Vec<(String, String)>,
}

impl Manifest {
    /// The manifest as text, always the same for the same FMU.
    pub(crate) fn text(&self) -> String {
        // Texts and finite numbers: there is nothing to fail.
        serde_json::to_string_pretty(self).unwrap_or_default()
    }

    /// The token that distinguishes FMUs: a hash of the manifest and the subject's file.
    pub(crate) fn token(&self, subject: &str) -> String {
        let mut hash = Sha256::new();
        hash.update(self.text());
        hash.update([0]);
        hash.update(subject);
        let digits = hash.finalize();
        digits.iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

/// An FMU's resources, after reading.
pub(crate) struct Resources {
    pub(crate) manifest: Manifest,
    pub(crate) token: String,
    pub(crate) subject: Box<dyn Subject>,
    /// The variables, with start values from the manifest.
    variables: Vec<Variable>,
}

impl Resources {
    /// The resources in a folder.
    ///
    /// # Errors
    /// If the manifest has another version, or the subject is invalid.
    pub(crate) fn read(folder: &Path) -> Result<Self, Error> {
        let refused = |reason: String| Error::Resources {
            file: MANIFEST,
            reason,
        };
        let text = planesman_text::read(&folder.join(MANIFEST));
        let text = text.map_err(|reason| refused(reason.to_string()))?;
        let manifest: Manifest =
            serde_json::from_str(&text).map_err(|reason| refused(reason.to_string()))?;
        if Path::new(&manifest.file).components().count() != 1 || manifest.file.starts_with('.') {
            return Err(refused(
                "'file' must name a file in the same folder".to_owned(),
            ));
        }
        let file = folder.join(&manifest.file);
        let text = planesman_text::read(&file).map_err(|reason| Error::File {
            path: file.display().to_string(),
            reason,
        })?;
        Self::of(manifest, &file, &text)
    }

    /// The resources of a manifest, for the subject in a file, or built in with that name, with this text.
    ///
    /// # Errors
    /// Like [`Self::read`].
    pub(crate) fn of(manifest: Manifest, file: &Path, text: &str) -> Result<Self, Error> {
        let subject = load(manifest.kind, file, text, manifest.tick)?;
        let mut variables = subject.variables().to_vec();
        let is_set = |it: &&mut Variable| it.causality == Causality::Parameter;
        let declared = variables.iter_mut().filter(is_set);
        let declared = declared.map(|it| &mut it.declaration);
        start(declared.collect(), &manifest.start)?;
        let resources = Self {
            token: manifest.token(text),
            manifest,
            subject,
            variables,
        };
        // Start values that do not go together are refused here, not in the middle of an importer's run.
        resources.subject.begin(&resources.parameters())?;
        Ok(resources)
    }

    /// Every variable except time, in the order of value references, from 1.
    pub(crate) fn variables(&self) -> impl Iterator<Item = &Variable> {
        self.variables.iter()
    }

    pub(crate) fn variable(&self, place: usize) -> &Variable {
        &self.variables[place]
    }

    /// The parameters' start values.
    fn parameters(&self) -> Vec<(String, Value)> {
        (self.variables.iter())
            .filter(|it| it.causality == Causality::Parameter)
            .map(|it| (it.declaration.name.clone(), it.declaration.default.clone()))
            .collect()
    }
}

/// Changes the defaults of declarations.
fn start(
    declared: Vec<&mut planesman_parameters::Declaration>,
    changes: &[(String, String)],
) -> Result<(), Error> {
    let parsed = changes.iter().map(|(name, text)| {
        let value = planesman_parameters::file::parse_value(name, text)?;
        // A number with its unit, as a file has it.
        let Ok(quantity) = text.parse::<Quantity>();
        let own = declared.iter().find(|it| it.name == *name);
        Ok(match (quantity.in_si(), own) {
            (Some((number, unit)), Some(own)) if own.unit == unit => (name.clone(), number.into()),
            _ => (name.clone(), value),
        })
    });
    let parsed: Vec<(String, Value)> = parsed.collect::<Result<_, Error>>()?;
    let values = Values::defaults(declared.iter().map(|it| (**it).clone()).collect());
    let values = values.with(parsed)?;
    for declaration in declared {
        if let Some(value) = values.get(&declaration.name) {
            declaration.default = value.clone();
        }
    }
    Ok(())
}

/// The subject in the text of a file.
///
/// # Errors
/// If a file or a tick is invalid.
fn load(kind: Kind, file: &Path, text: &str, tick: Option<f64>) -> Result<Box<dyn Subject>, Error> {
    Ok(match kind {
        Kind::Actuator => Box::new(Node::<Ticking>::load(file, text, tick)?),
        Kind::Vehicle => Box::new(Node::<Driven>::load(file, text, tick)?),
        Kind::Model => Box::new(Model::load(file, text, tick)?),
    })
}
