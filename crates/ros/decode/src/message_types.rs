//! Message types by name: first the types compiled in, then the types of the ROS installation, then ROS's own.
//!
//! An installation lists its packages in the ament index: each prefix in `AMENT_PREFIX_PATH` contains `share/PACKAGE/msg/TYPE.msg` (REP 122).
//! The type hash, by which DDS peers identify types, is computed from these definitions.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use planesman_rosidl::definition::Kind;
use planesman_rosidl::{Library, TypeName, parse_message};

use crate::{Types, schema, standard};

/// Largest definition file that is read, bytes, and the maximum number of files per type.
const LONGEST: u64 = 1 << 20;
const MAX_TYPES: usize = 1000;

/// The reason why a message type is unknown.
#[derive(Debug, thiserror::Error)]
pub enum TypeError {
    /// The text is not the name of a message type.
    #[error("'{0}' is not a message type; package/msg/Type is expected")]
    NotAType(String),
    /// A type that uses too many other types.
    #[error("{0} uses more than {most} types", most = MAX_TYPES)]
    TooMany(String),
    /// A type that is not compiled in, without a ROS installation.
    #[error(
        "no message type '{0}' is compiled in, and AMENT_PREFIX_PATH names no ROS installation"
    )]
    NoInstallation(TypeName),
    /// A type that is neither compiled in nor installed; contains the file that would define it.
    #[error(
        "no message type '{name}' is compiled in, and no prefix in AMENT_PREFIX_PATH has {}", .file.display()
    )]
    NotInstalled {
        /// The type.
        name: TypeName,
        /// The file.
        file: PathBuf,
    },
    /// A file that cannot be read.
    #[error("{}: {error}", .path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Error of the file system.
        error: std::io::Error,
    },
    /// The compiled-in definition of a type cannot be read.
    #[error(transparent)]
    Schema(#[from] schema::SchemaError),
    /// An invalid installed definition.
    #[error(transparent)]
    Definition(#[from] planesman_rosidl::Error),
}

/// A message type known at run time.
#[derive(Clone, Debug)]
pub struct MessageType {
    /// The type's definition, with all types that it uses.
    pub types: Types,
    /// Type hash, `RIHS01_...`.
    pub hash: String,
}

/// The message type with this name, such as `sensor_msgs/msg/Imu`.
///
/// # Errors
/// The type is neither compiled in nor in the ament index, or cannot be read.
pub fn find(type_name: &str) -> Result<MessageType, TypeError> {
    if let Some(info) = planesman_msgs::type_info(type_name) {
        return Ok(MessageType {
            types: schema::read(info.type_name, "ros2msg", info.definition)?,
            hash: info.type_hash.to_owned(),
        });
    }
    let known = |types: Types| MessageType {
        hash: types.hash(),
        types,
    };
    installed(type_name).or_else(|error| {
        let standard = standard::versions(type_name).into_iter().next();
        standard.map(known).ok_or(error)
    })
}

/// Possible definitions of a type for a bag without definitions: compiled in, installed, and those of the ROS distributions.
#[must_use]
pub fn versions(type_name: &str) -> Vec<Types> {
    let compiled = planesman_msgs::type_info(type_name);
    let compiled =
        compiled.and_then(|it| schema::read(it.type_name, "ros2msg", it.definition).ok());
    let installed = installed(type_name).map(|it| it.types);
    let all = compiled.into_iter().chain(installed);
    all.chain(standard::versions(type_name)).collect()
}

/// The type from the ament index.
fn installed(type_name: &str) -> Result<MessageType, TypeError> {
    let index = std::env::var_os("AMENT_PREFIX_PATH").unwrap_or_default();
    let prefixes: Vec<PathBuf> = std::env::split_paths(&index)
        .filter(|prefix| !prefix.as_os_str().is_empty())
        .collect();
    in_index(type_name, &prefixes)
}

/// The type from the first prefix that contains it.
fn in_index(type_name: &str, prefixes: &[PathBuf]) -> Result<MessageType, TypeError> {
    let root = TypeName::parse(type_name)
        .filter(|name| name.kind == Kind::Msg)
        .ok_or_else(|| TypeError::NotAType(type_name.to_owned()))?;
    let mut library = Library::new();
    let mut wanted = vec![root.clone()];
    while let Some(name) = wanted.pop() {
        if library.message(&name).is_some() {
            continue;
        }
        if library.messages().count() == MAX_TYPES {
            return Err(TypeError::TooMany(type_name.to_owned()));
        }
        let text = definition(&name, prefixes)?;
        let message = parse_message(&name.package, &name.name, &text)?;
        wanted.extend(
            message
                .references()
                .into_iter()
                .map(|(name, _)| name.clone()),
        );
        library.add_message(message)?;
    }
    let hash = library.type_hash(&root)?;
    let types = Types::of(library, type_name)?;
    Ok(MessageType { types, hash })
}

fn definition(name: &TypeName, prefixes: &[PathBuf]) -> Result<String, TypeError> {
    let file = Path::new("share")
        .join(&name.package)
        .join("msg")
        .join(format!("{}.msg", name.name));
    let Some(path) = prefixes
        .iter()
        .map(|it| it.join(&file))
        .find(|it| it.is_file())
    else {
        let name = name.clone();
        return Err(match prefixes {
            [] => TypeError::NoInstallation(name),
            _ => TypeError::NotInstalled { name, file },
        });
    };
    let mut text = String::new();
    fs::File::open(&path)
        .and_then(|file| file.take(LONGEST).read_to_string(&mut text))
        .map_err(|error| TypeError::Read { path, error })?;
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The project's own definitions, laid out as an installation.
    fn lay_out(folder: &Path) {
        let standard = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../msgs/standard");
        for package in [
            "sensor_msgs",
            "std_msgs",
            "geometry_msgs",
            "builtin_interfaces",
        ] {
            let target = folder.join("share").join(package).join("msg");
            fs::create_dir_all(&target).unwrap();
            for file in fs::read_dir(standard.join(package).join("msg")).unwrap() {
                let file = file.unwrap();
                fs::copy(file.path(), target.join(file.file_name())).unwrap();
            }
        }
    }

    #[test]
    fn a_type_read_from_the_index_is_the_one_compiled_in() {
        let folder = tempfile::tempdir().unwrap();
        lay_out(folder.path());
        let prefixes = [PathBuf::from("/nowhere"), folder.path().to_owned()];
        for name in ["sensor_msgs/msg/Imu", "std_msgs/msg/Float64"] {
            assert_eq!(
                in_index(name, &prefixes).unwrap().hash,
                find(name).unwrap().hash
            );
        }
    }

    #[test]
    fn a_type_that_cannot_be_had_is_refused_with_the_place_looked_at() {
        let folder = tempfile::tempdir().unwrap();
        let package = folder.path().join("share/odd/msg");
        fs::create_dir_all(&package).unwrap();
        fs::write(package.join("Loop.msg"), "Loop again\n").unwrap();
        fs::write(package.join("Broken.msg"), "float64\n").unwrap();
        fs::write(package.join("Away.msg"), "far/Away x\n").unwrap();
        let prefixes = [folder.path().to_owned()];
        for (name, reason) in [
            ("odd/msg/None", "share/odd/msg/None.msg"),
            ("odd/srv/None", "package/msg/Type"),
            ("../odd/msg/Loop", "package/msg/Type"),
            ("odd/msg/Loop", "contains itself"),
            ("odd/msg/Broken", "odd/msg/Broken:1"),
            ("odd/msg/Away", "far/msg/Away"),
        ] {
            let refusal = in_index(name, &prefixes).unwrap_err().to_string();
            assert!(refusal.contains(reason), "{refusal}");
        }
        assert!(
            in_index("a/msg/A", &[])
                .unwrap_err()
                .to_string()
                .contains("AMENT_PREFIX_PATH")
        );
    }
}
