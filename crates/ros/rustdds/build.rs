//! Makes the patched RustDDS: finds the published crate, copies its sources to `OUT_DIR`
//! and applies `patches/*.patch` in order.
//!
//! The workspace replaces `rustdds` by this crate (`[patch.crates-io]`), so Cargo does
//! not fetch the published one by itself. A second, one-dependency manifest (`published/`)
//! names it, and `cargo metadata` downloads it if the registry does not hold it
//! yet. Its lock file is the workspace's with the published crate's checksum entered:
//! Cargo refuses any other content, and nothing else is resolved anew. Cargo runs in this
//! folder, where it finds the configuration that the build has, with vendored sources too.
//!
//! To take another version: its number, features and dependencies in `Cargo.toml`, its
//! number in `published/Cargo.toml`, its checksum below, and every patch that no longer
//! applies made anew or dropped.

use std::{
    env, fs, io,
    path::{Path, PathBuf},
    process::Command,
};

use diffy::patch_set::{FileOperation, ParseOptions, PatchSet};

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// The crate's version, which is ours too.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// SHA-256 of `rustdds-0.15.1.crate`, as crates.io's index has it.
const CHECKSUM: &str = "42683a88b9dc025d7d45771b88d20846443b4901ec4b045ca78b8dd316ab616f";

fn main() -> Result<()> {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=patches");
    println!("cargo::rerun-if-changed=published");
    let out = PathBuf::from(env::var("OUT_DIR")?);
    let patched = out.join("rustdds");
    if patched.exists() {
        fs::remove_dir_all(&patched)?;
    }
    copy_sources(&published(&out)?.join("src"), &patched.join("src"))?;
    for patch in patches()? {
        apply(&patch, &patched).map_err(|e| format!("{}: {e}", patch.display()))?;
    }
    make_includable(&patched.join("src/lib.rs"))?;
    Ok(())
}

/// Where Cargo keeps the published crate's sources, downloaded now if need be.
fn published(out: &Path) -> Result<PathBuf> {
    let probe = out.join("published");
    fs::create_dir_all(probe.join("src"))?;
    for file in ["Cargo.toml", "src/lib.rs"] {
        fs::write(
            probe.join(file),
            fs::read(Path::new("published").join(file))?,
        )?;
    }
    fs::write(probe.join("Cargo.lock"), lock_file()?)?;
    // Without network first: that is the usual case, and the quick one.
    let metadata = cargo_metadata(&probe, true).or_else(|_| cargo_metadata(&probe, false))?;
    metadata["packages"]
        .as_array()
        .into_iter()
        .flatten()
        .find(|package| package["name"] == "rustdds" && package["version"] == VERSION)
        .and_then(|package| package["manifest_path"].as_str())
        .and_then(|manifest| Path::new(manifest).parent())
        .map(Path::to_owned)
        .ok_or_else(|| format!("cargo metadata does not list rustdds {VERSION}").into())
}

/// The output of `cargo metadata` on the manifest in `directory`, for this target only.
fn cargo_metadata(directory: &Path, offline: bool) -> Result<serde_json::Value> {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command
        .args(["metadata", "--format-version", "1", "--filter-platform"])
        .arg(env::var("TARGET")?)
        .arg("--manifest-path")
        .arg(directory.join("Cargo.toml"));
    if offline {
        command.arg("--offline");
    }
    let output = command.output()?;
    if !output.status.success() {
        let reason = String::from_utf8_lossy(&output.stderr);
        return Err(format!("cargo metadata for rustdds {VERSION} failed: {reason}").into());
    }
    Ok(serde_json::from_slice(&output.stdout)?)
}

/// The workspace's lock file with `rustdds` taken from the registry.
fn lock_file() -> Result<String> {
    let here = PathBuf::from(env::var("CARGO_MANIFEST_DIR")?);
    let workspace = here.ancestors().map(|dir| dir.join("Cargo.lock"));
    let lock = workspace
        .filter_map(|path| fs::read_to_string(path).ok())
        .next()
        .ok_or("no Cargo.lock in this folder or above it")?;
    let ours = format!("name = \"rustdds\"\nversion = \"{VERSION}\"\n");
    if !lock.contains(&ours) {
        return Err(format!("Cargo.lock has no rustdds {VERSION}").into());
    }
    let published = format!(
        "{ours}source = \"registry+https://github.com/rust-lang/crates.io-index\"\n\
         checksum = \"{CHECKSUM}\"\n"
    );
    Ok(lock.replace(&ours, &published))
}

/// Copies every file below `from` to `to`.
fn copy_sources(from: &Path, to: &Path) -> io::Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let target = to.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            copy_sources(&entry.path(), &target)?;
        } else {
            fs::write(target, fs::read(entry.path())?)?;
        }
    }
    Ok(())
}

/// Our patches in the order of their numbers.
fn patches() -> io::Result<Vec<PathBuf>> {
    let mut found = fs::read_dir("patches")?
        .map(|entry| Ok(entry?.path()))
        .collect::<io::Result<Vec<_>>>()?;
    found.retain(|path| path.extension().is_some_and(|e| e == "patch"));
    found.sort();
    Ok(found)
}

/// Applies one patch file to the sources below `root`. A hunk whose context is not
/// exactly what was published fails the build.
fn apply(patch: &Path, root: &Path) -> Result<()> {
    let text = fs::read_to_string(patch)?;
    for file in PatchSet::parse(&text, ParseOptions::unidiff()) {
        let file = file?;
        let hunks = file.patch().as_text().ok_or("a text patch is expected")?;
        let (path, before) = match file.operation().strip_prefix(1) {
            FileOperation::Create(path) => (root.join(&*path), String::new()),
            FileOperation::Modify { original, .. } => {
                let path = root.join(&*original);
                let before = fs::read_to_string(&path)?;
                (path, before)
            }
            other => return Err(format!("{other:?} is not supported").into()),
        };
        fs::write(&path, diffy::apply(&before, hunks)?)?;
    }
    Ok(())
}

/// Takes out what only the root file of a crate may hold, as ours is `src/lib.rs`: the
/// crate's documentation and its `#![..]` attributes.
fn make_includable(lib: &Path) -> Result<()> {
    let text = fs::read_to_string(lib)?;
    let mut kept = String::with_capacity(text.len());
    let mut attribute = false;
    for line in text.lines() {
        attribute |= line.starts_with("#![");
        if !attribute && !line.starts_with("//!") {
            kept.push_str(line);
            kept.push('\n');
        }
        attribute &= !line.trim_end().ends_with(']');
    }
    fs::write(lib, kept)?;
    Ok(())
}
