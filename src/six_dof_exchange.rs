//! `planesman six-dof export` and `check`: vehicles in the files of Gazebo, Stonefish and DAVE.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail};
use planesman_console::{Outcome, err, out};
use planesman_linear::digits::significant;
use planesman_vehicle::six_dof::exchange::{self, Finding, Format, ModelNumbers, Named, findings};
use planesman_vehicle::six_dof::{self, FileError, Matrix6};

use crate::arguments::{output_file, within};

/// Options of `export`.
#[derive(Clone, Debug, clap::Args)]
#[command(group = clap::ArgGroup::new("simulator").required(true).args(["gz", "stonefish", "dave"]))]
pub struct ExportArgs {
    /// A built-in vehicle (bluerov2_heavy, lauv, remus_100_6dof, remus_100_printed) or a vehicle file
    vehicle: String,
    /// SDF for Gazebo (gz-sim): hydrodynamics and thruster systems
    #[arg(long)]
    gz: bool,
    /// XML for Stonefish
    #[arg(long)]
    stonefish: bool,
    /// URDF for DAVE on Gazebo Classic: the plugins of the UUV simulator
    #[arg(long)]
    dave: bool,
    /// Density of the water (kg/m^3) [default: the simulator's own, 1000 or 1028]
    #[arg(long, value_parser = within(900.0, 1200.0))]
    density: Option<f64>,
    /// File to write; must not exist yet [default: print the text]
    #[arg(long, value_parser = output_file)]
    out: Option<PathBuf>,
}

/// Options of `check`.
#[derive(Clone, Debug, clap::Args)]
pub struct CheckArgs {
    /// A file of Gazebo, Stonefish or DAVE, with macros expanded, or a vehicle file of planesman
    file: PathBuf,
    /// Density of the water (kg/m^3) where the file gives none [default: the simulator's own, 1000 or 1028]
    #[arg(long, value_parser = within(900.0, 1200.0))]
    density: Option<f64>,
    /// Print everything as JSON
    #[arg(long)]
    json: bool,
}

/// Writes the vehicle for a simulator.
///
/// # Errors
/// A refused vehicle, or a file that cannot be written.
pub fn export(args: &ExportArgs) -> Result<()> {
    let format = match (args.gz, args.stonefish) {
        (true, _) => Format::Gazebo,
        (_, true) => Format::Stonefish,
        _ => Format::Dave,
    };
    let vehicle = six_dof::load(&args.vehicle)?;
    let density = args.density.unwrap_or(format.density());
    let Some(export) = exchange::export(&vehicle, format, density) else {
        bail!("--gz, --stonefish or --dave is expected");
    };
    for it in &export.omitted {
        err!("not expressed for {}: {it}", format.name());
    }
    match &args.out {
        None => planesman_console::print(&export.text)?,
        Some(path) => {
            planesman_text::write_text(path, export.text)
                .with_context(|| format!("{}", path.display()))?;
            out!("{}", planesman_console::file_line("Model", path))?;
        }
    }
    Ok(())
}

/// Prints what is not physical in a file, then the numbers read.
///
/// # Errors
/// A file that cannot be read, or one that is not physical.
pub fn check(args: &CheckArgs) -> Result<()> {
    let numbers = match read(&args.file, args.density)? {
        Ok(numbers) => numbers,
        Err(reason) if args.json => {
            let finding = serde_json::json!({ "code": "refused", "text": reason, "entries": [] });
            let all = serde_json::json!({ "physical": false, "findings": [finding] });
            out!("{}", serde_json::to_string_pretty(&all)?)?;
            bail!("{}: not physical", args.file.display());
        }
        Err(reason) => {
            Outcome::new(format!("Not physical: 1 finding\n- {reason}")).print()?;
            bail!("{}: not physical", args.file.display());
        }
    };
    let found = findings(&numbers);
    if args.json {
        out!("{}", serde_json::to_string_pretty(&json(&numbers, &found))?)?;
    } else {
        let mut answer = match found.len() {
            0 => "Physical: nothing found".to_owned(),
            1 => "Not physical: 1 finding".to_owned(),
            n => format!("Not physical: {n} findings"),
        };
        let absent = absent(&numbers).join(", ");
        if !absent.is_empty() {
            answer += &format!("; not in the file, and not checked: {absent}");
        }
        found.iter().for_each(|it| answer += &format!("\n- {it}"));
        Outcome::new(answer).numbers(table(&numbers)).print()?;
    }
    match found.is_empty() {
        true => Ok(()),
        false => bail!("{}: not physical", args.file.display()),
    }
}

/// The numbers of a file; as inner error the entry and rule of a vehicle file that is not physical.
fn read(path: &Path, density: Option<f64>) -> Result<Result<ModelNumbers, String>> {
    let name = path.display().to_string();
    let is_built_in = six_dof::built_in().any(|it| it == name);
    let vehicle = if is_built_in {
        six_dof::load(&name)
    } else {
        let text = planesman_text::read(path).with_context(|| name.clone())?;
        if text.trim_start().starts_with('<') {
            let numbers = exchange::read(&text, density);
            return Ok(Ok(numbers.with_context(|| name.clone())?));
        }
        six_dof::parse(&name, &text)
    };
    match vehicle {
        Ok(vehicle) => Ok(Ok(ModelNumbers::of(&vehicle))),
        Err(FileError::Refused { reason, .. }) => Ok(Err(reason.to_string())),
        Err(error) => Err(error.into()),
    }
}

/// What a complete model has and this file does not give.
fn absent(numbers: &ModelNumbers) -> Vec<&'static str> {
    let parts = [
        ("mass", numbers.mass.is_none()),
        ("inertia", numbers.inertia.is_none()),
        ("volume", numbers.displaced.is_none()),
        ("centre of buoyancy", numbers.centre_of_buoyancy.is_none()),
        ("added mass", numbers.added_mass.is_none()),
    ];
    parts.into_iter().filter(|it| it.1).map(|it| it.0).collect()
}

fn json(numbers: &ModelNumbers, found: &[Finding]) -> serde_json::Value {
    let entry = |Named(name, value): &Named| serde_json::json!({ "name": name, "value": value });
    let findings = found.iter().map(|it| {
        let entries: Vec<_> = it.entries().iter().map(entry).collect();
        serde_json::json!({ "code": it.code(), "text": it.to_string(), "entries": entries })
    });
    serde_json::json!({
        "physical": found.is_empty(),
        "findings": findings.collect::<Vec<_>>(),
        "format": numbers.format.name(),
        "name": numbers.name,
        "mass": numbers.mass,
        "displaced_mass": numbers.displaced,
        "centre_of_gravity": numbers.centre_of_gravity,
        "centre_of_buoyancy": numbers.centre_of_buoyancy,
        "inertia": numbers.inertia,
        "added_mass": numbers.added_mass,
        "linear_damping": numbers.damping.linear,
        "quadratic_damping": numbers.damping.quadratic,
        "other_coefficients": numbers.terms.len(),
        "not_checked": absent(numbers),
        "ignored": numbers.ignored,
    })
}

/// Numbers separated by spaces, with six digits.
fn row(numbers: &[f64]) -> String {
    let all = numbers.iter().map(|x| significant(x + 0.0, 6));
    all.collect::<Vec<_>>().join(" ")
}

/// The numbers read, in SI, axes forward, starboard, keel, positive for a passive vehicle.
fn table(numbers: &ModelNumbers) -> String {
    let absent = || "not in the file".to_owned();
    let number = |of: Option<f64>| of.map_or_else(absent, |x| significant(x, 6) + " kg");
    let matrix = |of: &Matrix6| {
        let is_diagonal = (0..36).all(|k| k / 6 == k % 6 || of[k / 6][k % 6] == 0.0);
        match is_diagonal {
            true => row(&std::array::from_fn::<f64, 6, _>(|i| of[i][i])),
            false => of.iter().map(|it| "\n    ".to_owned() + &row(it)).collect(),
        }
    };
    let centre = numbers.centre_of_buoyancy;
    let inertia = numbers.inertia.map(|it| it.map(|it| row(&it)).join("; "));
    let added = numbers.added_mass.as_ref().map(matrix);
    let by_shape = || "computed from the shape by the simulator".to_owned();
    let mut text = format!(
        "{} of {}: SI; axes forward, starboard, keel; added mass and damping positive\n",
        numbers.name,
        numbers.format.name()
    );
    for (title, value) in [
        ("mass", number(numbers.mass)),
        ("displaced mass", number(numbers.displaced)),
        ("centre of gravity", row(&numbers.centre_of_gravity)),
        (
            "centre of buoyancy",
            centre.map_or_else(absent, |it| row(&it)),
        ),
        ("inertia", inertia.unwrap_or_else(absent)),
        ("added mass", added.unwrap_or_else(by_shape)),
        ("linear damping", matrix(&numbers.damping.linear)),
        ("quadratic damping", matrix(&numbers.damping.quadratic)),
    ] {
        let wide = if value.starts_with('\n') { 0 } else { 20 };
        let _ = writeln!(text, "  {title:<wide$}{value}");
    }
    if !numbers.terms.is_empty() {
        let count = numbers.terms.len();
        let _ = writeln!(text, "  other coefficients  {count}, not checked");
    }
    for it in &numbers.ignored {
        let _ = writeln!(text, "  not used            {it}");
    }
    text
}
