//! `planesman six-dof`: vehicles with six degrees of freedom: flights with held inputs, steady turns, fits to recordings.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail};
use planesman_console::out;
use planesman_units::{Dimension, Quantity};
use planesman_vehicle::six_dof::{
    self, Accurate, Forces, Sea, Simulation, State, Turn, Vehicle, Wave, rotation, steady_turns,
};

use crate::arguments::{length, output_file, quantity, speed, within};
use crate::six_dof_exchange::{self, CheckArgs, ExportArgs};
use crate::six_dof_fit::{self, FitArgs};

/// The commands of `planesman six-dof`.
#[derive(Clone, Debug, clap::Subcommand)]
pub enum SixDofCommand {
    /// Fly the vehicle with held inputs; print its final position and attitude, and the integration error
    #[command(
        after_help = "Examples:\n  planesman six-dof fly lauv --input thrust=9 --input rudder=10deg@5 --out turn.csv\n  planesman six-dof fly bluerov2_heavy --input front_port=0.2 --current 0,0.3,0 --forces --out rov.csv"
    )]
    Fly(Box<FlyArgs>),
    /// Make a vehicle file of a torpedo-shaped AUV from its shape: hull, fins, trim and top speed
    #[command(
        after_help = "Example:\n  planesman six-dof torpedo --length 1.6m --diameter 0.2m --out mine.yaml\n  planesman six-dof fly mine.yaml --speed 1.5 --input thrust=6"
    )]
    Torpedo(Box<TorpedoArgs>),
    /// Make a first vehicle file of an ROV whose force and moment are recorded, from its mass and size, to be fitted to the recording
    #[command(
        after_help = "Example:\n  planesman six-dof box --mass 40 --size 0.8,0.6,0.4 --out start.yaml\n  planesman six-dof fit log.csv --real --like start.yaml --out rov.yaml"
    )]
    Box(BoxArgs),
    /// Find the steady turns at one depth, held by one input, and whether each is stable
    #[command(
        after_help = "Example:\n  planesman six-dof turn lauv --input thrust=9 --input rudder=10deg"
    )]
    Turn(TurnArgs),
    /// Fit the vehicle's coefficients to a recording: 95 % intervals, undetermined coefficients, and the best next run
    #[command(
        after_help = "Examples:\n  planesman six-dof fit run.csv --like lauv --fixed added_mass --out mine.yaml\n  planesman six-dof fit log.csv --real --like start.yaml --html rov.html\n  planesman six-dof fit bag --like my_rov.yaml \\\n      --signal 'front_port=thrusters:data[0]' --out mine.yaml"
    )]
    Fit(Box<FitArgs>),
    /// Write the vehicle for Gazebo, Stonefish or DAVE; list what their files cannot express
    #[command(
        after_help = "Example:\n  planesman six-dof export bluerov2_heavy --gz --out bluerov2.sdf"
    )]
    Export(ExportArgs),
    /// Check a file of Gazebo, Stonefish or DAVE, or a vehicle file: mass matrix, damping, buoyancy, signs; status 1 if not physical
    #[command(after_help = "Example:\n  planesman six-dof check model.sdf")]
    Check(CheckArgs),
}

/// A vehicle and its inputs.
#[derive(Clone, Debug, clap::Args)]
struct SimulationOutput {
    /// A built-in vehicle (bluerov2_heavy, lauv, remus_100_6dof, remus_100_printed) or a vehicle file (docs/six_dof.md)
    vehicle: String,
    /// Value of an input: a number in SI or with its unit (10deg, 9N), optionally from a time on; may be repeated [default: 0]
    #[arg(long = "input", value_name = "NAME=VALUE[@SECONDS]")]
    inputs: Vec<String>,
}

/// Options of `fly`.
#[derive(Clone, Debug, clap::Args)]
pub struct FlyArgs {
    #[command(flatten)]
    flown: SimulationOutput,
    /// Duration (s)
    #[arg(long, default_value_t = 60.0, value_parser = within(0.001, 1e5))]
    duration: f64,
    /// Time between the rows of the file (s)
    #[arg(long, default_value_t = 0.1, value_parser = within(1e-4, 1e3))]
    tick: f64,
    /// Surge over ground at the start (m/s, or with its unit)
    #[arg(long, default_value_t = 0.0, value_parser = speed(-20.0, 20.0))]
    speed: f64,
    /// Depth at the start (m, or with its unit)
    #[arg(long, default_value_t = 5.0, value_parser = length(-1e3, 1.1e4))]
    depth: f64,
    /// Roll at the start (rad, or with its unit: 5deg)
    #[arg(long, default_value_t = 0.0, value_parser = quantity(Dimension::Angle, -7.0, 7.0))]
    roll: f64,
    /// Pitch at the start
    #[arg(long, default_value_t = 0.0, value_parser = quantity(Dimension::Angle, -7.0, 7.0))]
    pitch: f64,
    /// Heading at the start, from north over east
    #[arg(long, default_value_t = 0.0, value_parser = quantity(Dimension::Angle, -7.0, 7.0))]
    heading: f64,
    /// Current, as north, east, down (m/s)
    #[arg(long, value_name = "N,E,D", value_parser = current, default_value = "0,0,0", allow_hyphen_values = true)]
    current: Three,
    /// Rate at which the current's direction turns about the vertical (rad/s)
    #[arg(long, default_value_t = 0.0, value_parser = within(-10.0, 10.0))]
    current_turning: f64,
    /// A wave in deep water: amplitude (m), period (s), direction it travels to, from north over east (rad); may be repeated
    #[arg(long = "wave", value_name = "A,T,DIRECTION", value_parser = three, allow_hyphen_values = true)]
    waves: Vec<Three>,
    /// Integration error allowed in each step, relative and absolute
    #[arg(long, default_value_t = 1e-9, value_parser = within(1e-13, 1e-2))]
    accuracy: f64,
    /// Also write each force and moment of the equations into the file
    #[arg(long, requires = "out")]
    forces: bool,
    /// CSV file of the motion; must not exist yet
    #[arg(long, value_parser = output_file)]
    out: Option<PathBuf>,
}

/// Options of `torpedo`.
#[derive(Clone, Debug, clap::Args)]
pub struct TorpedoArgs {
    /// The vehicle's name
    #[arg(long, default_value = "torpedo")]
    name: String,
    /// Length of the hull (m, or with its unit)
    #[arg(long, value_name = "M", value_parser = length(0.2, 20.0))]
    length: f64,
    /// Diameter of the hull
    #[arg(long, value_name = "M", value_parser = length(0.02, 5.0))]
    diameter: f64,
    /// Prismatic coefficient: the hull's volume divided by that of its enclosing cylinder
    #[arg(long, default_value_t = 0.85, value_parser = within(0.5, 1.0))]
    prismatic: f64,
    /// Density of the water (kg/m^3)
    #[arg(long, default_value_t = 1025.0, value_parser = within(900.0, 1200.0))]
    density: f64,
    /// Reserve buoyancy: (buoyancy - weight) / buoyancy
    #[arg(long, default_value_t = 0.01, value_parser = within(-0.05, 0.1))]
    reserve: f64,
    /// Distance of the centre of gravity below the centre of buoyancy [default: 0.1 diameters]
    #[arg(long, value_parser = length(0.0, 2.5))]
    gravity_below: Option<f64>,
    /// Span of a fin from hull to tip [default: 0.5 diameters]
    #[arg(long, value_parser = length(0.001, 10.0))]
    fin_span: Option<f64>,
    /// Chord of a fin [default: 0.4 diameters]
    #[arg(long, value_parser = length(0.001, 10.0))]
    fin_chord: Option<f64>,
    /// Distance of the fins' centre of pressure aft of midships [default: 0.43 lengths]
    #[arg(long, value_parser = length(0.0, 12.0))]
    fin_aft: Option<f64>,
    /// Speed at full thrust (m/s, or with its unit)
    #[arg(long, default_value_t = 2.5, value_parser = speed(0.1, 15.0))]
    top_speed: f64,
    /// Vehicle file to write; must not exist yet [default: print the text]
    #[arg(long, value_parser = output_file)]
    out: Option<PathBuf>,
}

fn torpedo(args: &TorpedoArgs) -> Result<()> {
    let shape = six_dof::Torpedo {
        name: args.name.clone(),
        length: args.length,
        diameter: args.diameter,
        prismatic: args.prismatic,
        density: args.density,
        reserve: args.reserve,
        gravity_below: args.gravity_below.unwrap_or(0.1 * args.diameter),
        fin_span: args.fin_span.unwrap_or(0.5 * args.diameter),
        fin_chord: args.fin_chord.unwrap_or(0.4 * args.diameter),
        fin_aft: args.fin_aft.unwrap_or(0.43 * args.length),
        top_speed: args.top_speed,
    };
    write_vehicle(&args.name, shape.file()?, args.out.as_deref())
}

fn box_body(args: &BoxArgs) -> Result<()> {
    let body = six_dof::BoxBody {
        name: args.name.clone(),
        mass: args.mass,
        size: args.size.0,
        density: args.density,
        gravity_below: args.gravity_below,
    };
    write_vehicle(&args.name, body.file(), args.out.as_deref())
}

/// Prints or writes the text of a vehicle.
fn write_vehicle(name: &str, text: String, out: Option<&Path>) -> Result<()> {
    // What is written is taken.
    six_dof::parse(name, &text)?;
    match out {
        None => planesman_console::print(&text)?,
        Some(path) => {
            planesman_text::write_text(path, text)
                .with_context(|| format!("{}", path.display()))?;
            out!("{}", planesman_console::file_line("Vehicle", path))?;
        }
    }
    Ok(())
}

/// Options of `box`.
#[derive(Clone, Debug, clap::Args)]
pub struct BoxArgs {
    /// Name of the vehicle
    #[arg(long, default_value = "rov")]
    name: String,
    /// Mass in air, with the water that it holds (kg)
    #[arg(long, value_name = "KG", value_parser = within(0.1, 1e6))]
    mass: f64,
    /// Length, width and height (m)
    #[arg(long, value_name = "L,W,H", value_parser = size)]
    size: Three,
    /// Density of the water (kg/m^3)
    #[arg(long, default_value_t = 1000.0, value_parser = within(900.0, 1200.0))]
    density: f64,
    /// Distance of the centre of gravity below the centre of buoyancy
    #[arg(long, value_name = "M", default_value_t = 0.02, value_parser = length(0.0, 10.0))]
    gravity_below: f64,
    /// Vehicle file to write; must not exist yet [default: print the text]
    #[arg(long, value_parser = output_file)]
    out: Option<PathBuf>,
}

/// Options of `turn`.
#[derive(Clone, Debug, clap::Args)]
pub struct TurnArgs {
    #[command(flatten)]
    flown: SimulationOutput,
    /// Input that keeps the depth
    #[arg(long, default_value = "stern_planes")]
    hold: String,
    /// An additional starting point of the search: surge (m/s, or with its unit)
    #[arg(long, default_value_t = 1.4, value_parser = speed(-20.0, 20.0))]
    speed: f64,
    /// An additional starting point of the search: yaw rate, positive to starboard (rad/s)
    #[arg(long, default_value_t = 0.0, value_parser = within(-10.0, 10.0))]
    yaw_rate: f64,
}

/// Three numbers separated by commas.
#[derive(Clone, Copy, Debug)]
struct Three([f64; 3]);

fn three(text: &str) -> Result<Three, String> {
    let numbers: Vec<f64> = text
        .split(',')
        .filter_map(|x| x.trim().parse().ok())
        .collect();
    match numbers[..] {
        [x, y, z] if [x, y, z].iter().all(|x| x.is_finite()) && text.matches(',').count() == 2 => {
            Ok(Three([x, y, z]))
        }
        _ => Err("three numbers separated by commas are expected".to_owned()),
    }
}

fn size(text: &str) -> Result<Three, String> {
    three(text).and_then(|of| match of.0.iter().all(|x| (0.05..=100.0).contains(x)) {
        true => Ok(of),
        false => Err("numbers from 0.05 to 100 m are expected".to_owned()),
    })
}

fn current(text: &str) -> Result<Three, String> {
    three(text).and_then(|of| match of.0.iter().all(|x| x.abs() <= 20.0) {
        true => Ok(of),
        false => Err("numbers from -20 to 20 m/s are expected".to_owned()),
    })
}

/// Runs the command.
///
/// # Errors
/// A refused vehicle or input, a diverging motion, no turn found, or a file that cannot be written.
pub fn run(command: &SixDofCommand) -> Result<()> {
    match command {
        SixDofCommand::Fly(args) => fly(args),
        SixDofCommand::Torpedo(args) => torpedo(args),
        SixDofCommand::Box(args) => box_body(args),
        SixDofCommand::Turn(args) => turn(args),
        SixDofCommand::Fit(args) => six_dof_fit::run(args),
        SixDofCommand::Export(args) => six_dof_exchange::export(args),
        SixDofCommand::Check(args) => six_dof_exchange::check(args),
    }
}

/// Times (s) at which the inputs change, with the inputs from then on.
type Schedule = Vec<(f64, Vec<f64>)>;

impl SimulationOutput {
    fn vehicle(&self) -> Result<Vehicle> {
        Ok(six_dof::load(&self.vehicle)?)
    }

    fn schedule(&self, vehicle: &Vehicle) -> Result<Schedule> {
        let names = &vehicle.parts().inputs;
        let mut changes = Vec::new();
        for written in &self.inputs {
            let parsed = written.split_once('=').and_then(|(name, value)| {
                let (value, time) = value.split_once('@').unwrap_or((value, "0"));
                let time: f64 = time.parse().ok().filter(|t| *t >= 0.0)?;
                Some((name, number(value)?, time))
            });
            let Some((name, value, time)) = parsed else {
                bail!(
                    "--input {written}: NAME=VALUE or NAME=VALUE@SECONDS is expected, as rudder=10deg@5"
                );
            };
            let Some(place) = names.iter().position(|it| it == name) else {
                bail!(
                    "--input {written}: the inputs of '{}' are {}",
                    vehicle.parts().name,
                    names.join(", ")
                );
            };
            changes.push((time, place, value));
        }
        changes.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut now = vec![0.0; names.len()];
        let mut schedule: Schedule = vec![(0.0, now.clone())];
        for (time, place, value) in changes {
            now[place] = value;
            match schedule.last_mut() {
                Some(last) if last.0 == time => last.1.clone_from(&now),
                _ => schedule.push((time, now.clone())),
            }
        }
        Ok(schedule)
    }
}

/// Parses a number in SI, or with the unit of an angle, a force or a rate.
fn number(text: &str) -> Option<f64> {
    let quantity: Quantity = text.parse().ok()?;
    [Dimension::Angle, Dimension::Force, Dimension::Rate]
        .into_iter()
        .find_map(|dimension| quantity.argument(dimension).ok())
}

impl FlyArgs {
    /// The states at each tick.
    fn flown(
        &self,
        vehicle: &Vehicle,
        sea: &Sea,
        schedule: &Schedule,
        accuracy: f64,
    ) -> Result<Vec<(f64, State)>> {
        let start = State {
            position: [0.0, 0.0, self.depth],
            attitude: rotation::from_euler([self.roll, self.pitch, self.heading]),
            velocity: [self.speed, 0.0, 0.0, 0.0, 0.0, 0.0],
        };
        let accuracy = Accurate {
            relative: accuracy,
            absolute: accuracy,
        };
        let mut simulation = Simulation::new(vehicle, sea, start, accuracy);
        let mut states = vec![(0.0, start)];
        let mut changes = schedule.iter().skip(1).peekable();
        let mut inputs = &schedule[0].1;
        let ticks = (self.duration / self.tick - 1e-9).ceil() as usize;
        for k in 1..=ticks {
            let until = (k as f64 * self.tick).min(self.duration);
            // A change at a tick is one of the tick: 13.7 s is not 137 times 0.1 s to the last bit.
            let before = until - 1e-9 * (1.0 + until);
            while let Some((time, next)) = changes.next_if(|(time, _)| *time < before) {
                simulation.advance(*time, inputs)?;
                inputs = next;
            }
            simulation.advance(until, inputs)?;
            states.push((until, simulation.state));
        }
        Ok(states)
    }
}

fn fly(args: &FlyArgs) -> Result<()> {
    let vehicle = args.flown.vehicle()?;
    let schedule = args.flown.schedule(&vehicle)?;
    let sea = Sea {
        current: args.current.0,
        turning: args.current_turning,
        waves: args
            .waves
            .iter()
            .map(|Three([amplitude, period, direction])| Wave {
                amplitude: *amplitude,
                period: *period,
                direction: *direction,
                phase: 0.0,
            })
            .collect(),
        ..Sea::default()
    };
    if sea.waves.iter().any(|wave| wave.period <= 0.0) {
        bail!("--wave: the period must be above zero");
    }
    let states = args.flown(&vehicle, &sea, &schedule, args.accuracy)?;
    let finer = args.flown(
        &vehicle,
        &sea,
        &schedule,
        (args.accuracy / 100.0).max(1e-14),
    )?;
    let difference = |(one, other): (&(f64, State), &(f64, State))| {
        let pairs = one.1.row().into_iter().zip(other.1.row());
        pairs.map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
    };
    let error = states
        .iter()
        .zip(&finer)
        .map(difference)
        .fold(0.0, f64::max);
    if let Some(path) = &args.out {
        let text = csv(&vehicle, &sea, &schedule, &states, args.forces);
        planesman_text::write_text(path, text).with_context(|| format!("{}", path.display()))?;
    }
    let Some((time, last)) = states.last() else {
        bail!("the duration is zero. Choose a longer --duration");
    };
    let [north, east, down] = last.position;
    let [roll, pitch, yaw] = rotation::euler(last.attitude).map(f64::to_degrees);
    let [u, v, w, p, q, r] = last.velocity;
    let [p, q, r] = [p, q, r].map(f64::to_degrees);
    out!("{} after {time} s", vehicle.parts().name)?;
    out!("  north, east, depth  {north:.4} {east:.4} {down:.4} m")?;
    out!("  roll, pitch, yaw    {roll:.4} {pitch:.4} {yaw:.4} deg")?;
    out!("  u, v, w             {u:.5} {v:.5} {w:.5} m/s")?;
    out!("  p, q, r             {p:.5} {q:.5} {r:.5} deg/s")?;
    out!(
        "integration error {error:.1e} (m, m/s, rad/s): largest difference from a run with a hundredth of --accuracy {:e}",
        args.accuracy
    )?;
    Ok(())
}

/// A term of the equations: its name, and a function of its forces and moments.
type Part = (&'static str, fn(&Forces) -> [f64; 6]);

/// The motion as a table: time, position, attitude, velocities, inputs; with `forces` also each term of the equations.
fn csv(
    vehicle: &Vehicle,
    sea: &Sea,
    schedule: &Schedule,
    states: &[(f64, State)],
    forces: bool,
) -> String {
    let parts: [Part; 8] = [
        ("rigid_body_coriolis", |f| f.rigid_body_coriolis),
        ("added_mass_coriolis", |f| f.added_mass_coriolis),
        ("current_acceleration", |f| f.current_acceleration),
        ("restoring", |f| f.restoring),
        ("damping", |f| f.damping),
        ("coefficients", |f| f.coefficients),
        ("fins", |f| f.fins),
        ("propulsion", |f| f.propulsion),
    ];
    let mut text = "time [s],north [m],east [m],depth [m],roll [rad],pitch [rad],yaw [rad],u [m/s],v [m/s],w [m/s],p [rad/s],q [rad/s],r [rad/s]".to_owned();
    for input in &vehicle.parts().inputs {
        text += &format!(",{input}");
    }
    if forces {
        for (name, _) in parts {
            for row in ["X [N]", "Y [N]", "Z [N]", "K [N m]", "M [N m]", "N [N m]"] {
                text += &format!(",{name} {row}");
            }
        }
    }
    text.push('\n');
    for (time, state) in states {
        let held = schedule.iter().rev().find(|(from, _)| from <= time);
        let inputs = held.map_or(&schedule[0].1, |(_, inputs)| inputs);
        let mut row = vec![*time];
        row.extend(state.position);
        row.extend(rotation::euler(state.attitude));
        row.extend(state.velocity);
        row.extend(inputs);
        if forces {
            let r = rotation::matrix(state.attitude);
            let [u, v, w, ..] = state.velocity;
            let over_ground = rotation::to_fixed(&r, [u, v, w]);
            let water = sea.at(state.position, over_ground, *time);
            let found = vehicle.forces(state, inputs, &water);
            parts.iter().for_each(|(_, of)| row.extend(of(&found)));
        }
        for (k, x) in row.iter().enumerate() {
            let comma = if k == 0 { "" } else { "," };
            let _ = write!(text, "{comma}{x}");
        }
        text.push('\n');
    }
    text
}

fn turn(args: &TurnArgs) -> Result<()> {
    let vehicle = args.flown.vehicle()?;
    let schedule = args.flown.schedule(&vehicle)?;
    let names = &vehicle.parts().inputs;
    let Some(holding) = names.iter().position(|name| *name == args.hold) else {
        bail!(
            "--hold {}: the inputs of '{}' are {}",
            args.hold,
            vehicle.parts().name,
            names.join(", ")
        );
    };
    let inputs = match &schedule[..] {
        [(_, inputs)] => inputs,
        _ => bail!("the inputs of a steady turn are constant. Leave out @SECONDS"),
    };
    let start = Turn {
        velocity: [args.speed, 0.0, 0.0],
        roll: 0.0,
        pitch: 0.0,
        yaw_rate: args.yaw_rate,
        held: 0.0,
    };
    let turns = steady_turns(&vehicle, inputs, holding, start);
    let of = match turns.len() {
        0 => bail!(
            "no steady turn was found from the start {} m/s, {} rad/s or from the 36 default starts. Choose another start with --speed and --yaw-rate",
            args.speed,
            args.yaw_rate
        ),
        1 => "1 steady turn at one depth".to_owned(),
        n => format!("{n} steady turns at one depth"),
    };
    out!("{}: {of}", vehicle.parts().name)?;
    for turn in &turns {
        let growth = six_dof::growth(&vehicle, inputs, holding, turn);
        print_turn(turn, &args.hold, growth)?;
    }
    Ok(())
}

/// Prints a steady turn and its stability: `growth` is the growth rate of a small deviation with the inputs held, 1/s.
fn print_turn(found: &Turn, hold: &str, growth: Option<f64>) -> Result<()> {
    let [u, v, w] = found.velocity;
    let speed = (u * u + v * v + w * w).sqrt();
    out!("  speed       {speed:.5} m/s; u, v, w {u:.5} {v:.5} {w:.5} m/s")?;
    out!(
        "  yaw rate    {:.4} deg/s, positive to starboard",
        found.yaw_rate.to_degrees()
    )?;
    if found.yaw_rate != 0.0 {
        out!("  radius      {:.3} m", speed / found.yaw_rate.abs())?;
    }
    out!(
        "  roll, pitch {:.3} {:.3} deg",
        found.roll.to_degrees(),
        found.pitch.to_degrees()
    )?;
    out!(
        "  {} {:.5} ({:.2} deg as an angle)",
        hold,
        found.held,
        found.held.to_degrees()
    )?;
    match growth {
        Some(rate) if rate < 0.0 => out!(
            "  stable: with constant inputs, a small deviation decays by a factor e in {:.3} s or less\n",
            -1.0 / rate
        )?,
        Some(rate) => out!(
            "  unstable: with constant inputs, a small deviation grows by a factor e in {:.3} s\n",
            1.0 / rate
        )?,
        None => out!("  stability: not computed\n")?,
    }
    Ok(())
}
