//! Writes an FMU: finds the subject by its name or file, adds the library that runs it, and the description of both.

use std::env::consts::{ARCH, DLL_PREFIX, DLL_SUFFIX, OS};
use std::fs;
use std::path::{Path, PathBuf};

use planesman_hydraulics::Error as ActuatorError;
use planesman_hydraulics::actuator_file::{self, ActuatorFileError};
use planesman_model_file::{ModelFile, SeveralModelFile};
use planesman_text::did_you_mean;
use planesman_vehicle::vehicle_file;
use serde::Deserialize;

use crate::archive::zip;
use crate::description;
use crate::error::Error;
use crate::resources::{FORMAT, Format, MANIFEST, Manifest, Resources};
use crate::subject::Kind;
use crate::variable::Causality;

/// The subject and the options of an export.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// A built-in actuator or vehicle, or the file of an actuator, a vehicle or an identified model.
    pub subject: String,
    /// The tick \[s\]; `None`: the subject's own, 0.05 s for actuators and vehicles.
    pub tick: Option<f64>,
    /// Start values of parameters, each as YAML.
    pub start: Vec<(String, String)>,
    /// The library that runs FMUs; `None` for the library in the program's folder.
    pub library: Option<PathBuf>,
}

/// An FMU, not yet written to a file.
#[derive(Debug)]
pub struct Fmu {
    /// Its bytes.
    pub bytes: Vec<u8>,
    /// The kind of its subject.
    pub kind: Kind,
    /// The tick \[s\].
    pub tick: f64,
    /// The inputs' names.
    pub inputs: Vec<String>,
    /// The outputs' names.
    pub outputs: Vec<String>,
    /// The number of parameters.
    pub parameters: usize,
    /// The platform for which the library was built, as named in FMI: `x86_64-linux`.
    pub platform: String,
}

/// The FMU of a subject.
///
/// # Errors
/// If a subject, a tick or a start value is invalid, or the library is missing.
pub fn fmu(options: &Options) -> Result<Fmu, Error> {
    let (kind, text) = subject(&options.subject)?;
    let path = Path::new(&options.subject);
    let stem = path.file_stem().map_or_else(
        || options.subject.clone(),
        |stem| stem.to_string_lossy().into_owned(),
    );
    let ending = match (kind, path.extension()) {
        (Kind::Model, Some(ending)) => ending.to_string_lossy().into_owned(),
        _ => "yaml".to_owned(),
    };
    let identifier = identifier(&stem);
    let manifest = Manifest {
        format: Format::One,
        version: env!("CARGO_PKG_VERSION").to_owned(),
        kind,
        file: format!("{identifier}.{ending}"),
        tick: options.tick,
        start: options.start.clone(),
    };
    let resources = Resources::of(manifest, path, &text).map_err(|reason| match reason {
        Error::Actuator(ActuatorError::ActuatorFile(ActuatorFileError::Malformed { .. })) => {
            Error::Unknown {
                file: options.subject.clone(),
                reason: Box::new(reason),
            }
        }
        _ => reason,
    })?;
    let library = match &options.library {
        Some(path) => path.clone(),
        None => library()?,
    };
    let library = library_at(&library)?;
    let description = description::text(&resources, &stem, &identifier);
    let platform = format!("{ARCH}-{}", if OS == "macos" { "darwin" } else { OS });
    let Manifest { file, .. } = &resources.manifest;
    let files = [
        ("modelDescription.xml".to_owned(), description.into_bytes()),
        (
            format!("resources/{MANIFEST}"),
            resources.manifest.text().into_bytes(),
        ),
        (format!("resources/{file}"), text.into_bytes()),
        (
            format!("binaries/{platform}/{identifier}{DLL_SUFFIX}"),
            library,
        ),
    ];
    let named = |is: fn(&Causality) -> bool| {
        let chosen = resources.variables().filter(|it| is(&it.causality));
        chosen.map(|it| it.declaration.name.clone()).collect()
    };
    Ok(Fmu {
        bytes: zip(&files),
        kind,
        tick: resources.subject.tick(),
        inputs: named(|it| *it == Causality::Input),
        outputs: named(|it| matches!(it, Causality::Output(_))),
        parameters: (resources.variables())
            .filter(|it| it.causality == Causality::Parameter)
            .count(),
        platform,
    })
}

/// Reads the library from a file and checks that it can read the manifests written here.
fn library_at(path: &Path) -> Result<Vec<u8>, Error> {
    let bytes = fs::read(path).map_err(|reason| Error::File {
        path: path.display().to_string(),
        reason,
    })?;
    let format = FORMAT.as_bytes();
    match bytes.windows(format.len()).any(|part| part == format) {
        true => Ok(bytes),
        false => Err(Error::OtherLibrary(path.display().to_string())),
    }
}

/// The kind of a name or file, and its text.
fn subject(name: &str) -> Result<(Kind, String), Error> {
    /// The keys that distinguish a vehicle's file from an actuator's: particulars for the vertical plane, inputs for six degrees.
    #[derive(Deserialize)]
    struct Head {
        particulars: Option<serde::de::IgnoredAny>,
        inputs: Option<serde::de::IgnoredAny>,
    }
    let built_in = actuator_file::built_in().find(|it| it.0 == name);
    if let Some((_, text)) = built_in {
        return Ok((Kind::Actuator, text.to_owned()));
    }
    let text = vehicle_file::text(name).map_err(|reason| {
        let actuators: Vec<&str> = actuator_file::built_in().map(|it| it.0).collect();
        Error::NoSubject {
            name: name.to_owned(),
            meant: did_you_mean(name, actuators.iter().copied()),
            actuators: actuators.join(", "),
            reason: Box::new(reason),
        }
    })?;
    let path = Path::new(name);
    if ModelFile::recognises(path, &text) || SeveralModelFile::recognises(path, &text) {
        return Ok((Kind::Model, text));
    }
    let head: Result<Head, _> = planesman_text::yaml::from_str(&text);
    let is_vehicle = head.is_ok_and(|it| it.particulars.is_some() || it.inputs.is_some());
    let kind = if is_vehicle {
        Kind::Vehicle
    } else {
        Kind::Actuator
    };
    Ok((kind, text))
}

/// A valid C name, for the FMU's library and its function names.
fn identifier(name: &str) -> String {
    let signs = name.chars().map(|sign| match sign.is_ascii_alphanumeric() {
        true => sign,
        false => '_',
    });
    let name: String = signs.take(64).collect();
    match name.starts_with(|first: char| first.is_ascii_digit()) || name.is_empty() {
        true => format!("_{name}"),
        false => name,
    }
}

/// The path of the library that runs FMUs, in the places where cargo or an installation puts it.
fn library() -> Result<PathBuf, Error> {
    let name = format!("{DLL_PREFIX}{}{DLL_SUFFIX}", env!("CARGO_PKG_NAME"));
    let program = std::env::current_exe().and_then(fs::canonicalize);
    let folder = program.ok().and_then(|it| it.parent().map(Path::to_owned));
    let places = folder
        .iter()
        .flat_map(|folder| ["deps", "", "../lib"].map(|place| folder.join(place).join(&name)));
    let found = places.into_iter().find(|it| it.is_file());
    found.ok_or(Error::NoLibrary { library: name })
}
