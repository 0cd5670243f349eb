//! Generates the Rust modules from the definitions beside this file, into `OUT_DIR/interfaces.rs`.

use std::error::Error;
use std::fmt::Write as _;
use std::io;
use std::path::{Path, PathBuf};

use planesman_rosidl::{Library, rust};

fn main() -> Result<(), Box<dyn Error>> {
    let here = PathBuf::from(std::env::var("CARGO_MANIFEST_DIR")?);
    let out = PathBuf::from(std::env::var("OUT_DIR")?);

    for folder in ["msg", "srv", "action", "standard"] {
        println!("cargo::rerun-if-changed={folder}");
    }
    let library = read(&here).map_err(|error| format!("cannot read the definitions: {error}"))?;
    std::fs::write(out.join("interfaces.rs"), rust::generate(&library)?)?;
    std::fs::write(out.join("sources.rs"), sources(&here)?)?;
    Ok(())
}

/// Every definition file with its package, kind and name, as a Rust expression.
fn sources(here: &Path) -> Result<String, Box<dyn Error>> {
    let mut text = String::from("&[\n");
    for (folder, package) in packages(here)? {
        for kind in ["msg", "srv", "action"] {
            let Ok(files) = folder.join(kind).read_dir() else {
                continue;
            };
            let mut files: Vec<_> = files
                .map(|file| Ok(file?.path()))
                .collect::<io::Result<_>>()?;
            files.retain(|file| file.extension().is_some_and(|it| it == kind));
            files.sort();
            for file in files {
                let name = file.file_stem().unwrap_or_default().to_string_lossy();
                writeln!(
                    text,
                    "    ({package:?}, {kind:?}, {name:?}, include_str!({file:?})),"
                )?;
            }
        }
    }
    text.push_str("]\n");
    Ok(text)
}

fn read(here: &Path) -> Result<Library, Box<dyn Error>> {
    let mut library = Library::new();
    for (folder, package) in packages(here)? {
        library.read_package(&folder, &package)?;
    }
    Ok(library)
}

/// Folder and name of this package and of every package below `standard/`.
fn packages(here: &Path) -> io::Result<Vec<(PathBuf, String)>> {
    let mut packages = vec![(here.to_owned(), "planesman_msgs".to_owned())];
    for package in here.join("standard").read_dir()? {
        let package = package?;
        let name = package.file_name().to_string_lossy().into_owned();
        packages.push((package.path(), name));
    }
    packages.sort();
    Ok(packages)
}
