//! Generates the Rust modules from the definitions beside this file, into `OUT_DIR/interfaces.rs`.

use std::error::Error;
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
    Ok(())
}

/// Our own package, and every package below `standard/`.
fn read(here: &Path) -> Result<Library, Box<dyn Error>> {
    let mut library = Library::new();
    library.read_package(here, "planesman_msgs")?;
    for package in here.join("standard").read_dir()? {
        let package = package?;
        if let Some(name) = package.file_name().to_str() {
            library.read_package(&package.path(), name)?;
        }
    }
    Ok(library)
}
