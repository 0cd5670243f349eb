//! The `planesman` program.

use std::ffi::OsString;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Result, anyhow};
use clap::builder::NonEmptyStringValueParser;
use clap::{Args, CommandFactory as _, Parser, Subcommand};
use clap_complete::Shell;
use planesman::arguments::{
    command_of, completed, ended, is_help, overwritten, parsed, refused, within,
};
use planesman::coefficients_command::{self, CoefficientsArgs};
use planesman::design::{self, DesignCommand};
use planesman::dha::{self, DhaCommand};
use planesman::dive::{self, Pace};
use planesman::reports_program::{self, NotBuilt, PassedOn};
use planesman::run_folder::{Loss, RunFolder};
use planesman::{
    bag_command, bag_play, doctor, export_command, nodes, params_command, report, tf_command, watch,
};
use planesman_console::progress::Bars;
use planesman_console::{Format, Outcome};
use planesman_flight::nodes::NAMESPACE;
use planesman_flight::scenario::{Scenario, builtin_names};
use planesman_flight::{Parts, fly, fly_over};
use planesman_parameters::Parameters as _;
use planesman_plant::PlantParameters;
use planesman_text::{did_you_mean, shell_word, shown};

/// Exit status of a dive with messages missing in its bag.
const LOST: u8 = 3;

/// Exit status of a comparison that found differences.
const DIFFERENT: u8 = 4;

/// Exit statuses of all commands.
const EXIT_CODES: &str = "\
Exit status:
  0  done
  1  refused or failed; the last line gives the reason
  2  the command line is wrong
  3  done, but messages are missing in a dive's bag; the last line says how many of which topic
  4  two recordings differ (bag diff, bag play)";

/// Commands to try first.
const EXAMPLES: &str = "\
Examples:
  planesman                                           fly the built-in dive
  planesman dive --set depth_controller.depth.p=1.2   with another gain
  planesman sim dive --out dive.csv                   in one process, as a table
  planesman sysid topics dive.csv                     what can be identified
  planesman sysid fit dive.csv -i dive_planes -o gyro_pitch_rate --window 20..90
  planesman doctor                                    check whether nodes find each other";

/// Examples of sweeps.
const SWEEPS: &str = "\
Examples:
  planesman sweep dive --vary plant_sim.speed=1ft/s,2ft/s --seeds 10 \\
      --vary depth_controller.depth.p=0.4:1.6:0.1
  planesman sweep dive --vary depth_controller.depth.p=0.4..1.6 \\
      --vary depth_controller.depth.d=0..3 --samples 200
  planesman sweep dive --vary dha_actuator.model=ideal,dha --seeds 1000 \\
      --out sweep --shard 1/4";

/// Examples of dives, and of commands that follow one.
const DIVES: &str = "\
Examples:
  planesman dive --set depth_controller.depth.p=1.2
  planesman dive remus_100 --factor 1 --watch

Next:
  planesman report FOLDER             summarise the flight again
  planesman bag info FOLDER/bag       topics, counts, and missing messages
  planesman sysid topics FOLDER/bag   signals to identify from";

fn help(parts: &[&str]) -> String {
    parts.join("\n\n")
}

/// Simulates, controls and identifies an underwater vehicle: a ROS 2 Jazzy node suite.
///
/// Without a command it dives: it starts the simulated vehicle, its controller, its hydraulic
/// actuator, an identifier and a recorder as separate processes over DDS, and prints a summary.
#[derive(Parser)]
#[command(name = "planesman", version, max_term_width = 80, args_conflicts_with_subcommands = true, after_help = help(&[EXAMPLES, EXIT_CODES]))]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    dive: DiveArgs,
}

#[derive(Subcommand)]
enum Command {
    /// Run a scenario as separate processes over DDS (the default)
    #[command(after_help = help(&[DIVES, EXIT_CODES]))]
    Dive(DiveArgs),
    /// Run a scenario in one process, without DDS, and write a bag or a CSV file
    #[command(
        after_help = "Examples:\n  planesman sim dive --out dive.csv\n  planesman sim remus_100 --set plant_sim.speed=2kn --out remus.mcap"
    )]
    Sim(SimArgs),
    /// Fly a scenario many times with different parameters and seeds, and compare the results
    #[command(after_help = SWEEPS)]
    Sweep(planesman::sweep::SweepArgs),
    /// Summarise a recorded flight from its folder, or compare several flights
    #[command(
        after_help = "Examples:\n  planesman report runs/dive\n  planesman report before after --html flights.html"
    )]
    Report(report::ReportArgs),
    /// Run the live identifier on a bag, table or log, and compare with the bag's published estimates
    #[command(
        after_help = "Examples:\n  planesman replay runs/dive/bag --params-file runs/dive/parameters.yaml\n  planesman replay log.csv -i u -o y -p order:=2 --history estimates.csv"
    )]
    Replay(planesman::sysid::replay::ReplayArgs),
    /// Identify models from bags or CSV files: list signals, fit, compare
    #[command(
        subcommand,
        after_help = "Examples:\n  planesman sysid topics dive.csv\n  planesman sysid fit dive.csv -i dive_planes -o gyro_pitch_rate --window 20..90"
    )]
    Sysid(planesman::sysid::Command),
    /// Find PI or PID gains for a model, and their margins for the model's uncertainty
    #[command(
        after_help = "Examples:\n  planesman tune model.yaml --html tune.html\n  planesman tune step.csv -i valve -o temperature --ms 1.4\n  planesman tune model.yaml --controller pid --method optimise --period 50ms"
    )]
    Tune(Box<planesman::tune::TuneArgs>),
    /// Write one page for colleagues with data, model, validation, margins and robustness of gains; each number with its sample size
    #[command(
        after_help = "Examples:\n  planesman review step.csv -i valve -o temperature\n  planesman review flight1 flight2 -i 'cmd:data[0]' -o imu:angular_velocity.y --html gains.html\n  planesman review runs/dive/bag"
    )]
    Review(Box<planesman::review::ReviewArgs>),
    /// Show the running vehicles of the DDS domain on a page in the browser: charts, parameters, commands, log
    #[command(
        after_help = "Example:\n  planesman dive --factor 1 --keep-running     in one terminal\n  planesman watch                              in another"
    )]
    Watch(watch::WatchArgs),
    /// Inspect a bag, or compare it with another
    #[command(
        subcommand,
        after_help = "Examples:\n  planesman bag info runs/dive/bag\n  planesman bag diff before.mcap after.mcap"
    )]
    Bag(BagCommand),
    /// Print a vehicle's transfer functions, continuous and sampled, or as printed in the thesis
    #[command(
        after_help = "Examples:\n  planesman tf brunner --output pitch --speed 1ft/s\n  planesman tf model.yaml --speed 2kn"
    )]
    Tf(tf_command::TfArgs),
    /// List every parameter of every node, with unit, range and default
    #[command(
        after_help = "Examples:\n  planesman params depth_controller\n  planesman params --yaml --scenario dive > params.yaml"
    )]
    Params {
        /// Print only the parameters of this node
        node: Option<String>,
        /// Print a ROS 2 parameter file
        #[arg(long)]
        yaml: bool,
        /// Use the values of this scenario (built-in or a file)
        #[arg(long, requires = "yaml")]
        scenario: Option<String>,
        /// Print a table in this format [default: a list]
        #[arg(long, value_parser = planesman::arguments::format(), conflicts_with = "yaml")]
        format: Option<Format>,
    },
    /// Compute a vehicle's hydrodynamic coefficients from its geometry, and compare them with the vehicle file
    #[command(after_help = "Example:\n  planesman coefficients brunner --speed 1ft/s")]
    Coefficients(CoefficientsArgs),
    /// Fly a vehicle with six degrees of freedom, find its steady turns, or fit it to a recording
    #[command(
        subcommand,
        after_help = "Examples:\n  planesman six-dof fly lauv --input thrust=9 --input rudder=10deg@5 --out turn.csv\n  planesman six-dof turn lauv --input thrust=9 --input rudder=10deg"
    )]
    SixDof(planesman::six_dof_command::SixDofCommand),
    /// Design the depth and pitch loops: stability, margins, root locus, pole placement, gains
    #[command(
        subcommand,
        after_help = "Example:\n  planesman design analyse brunner --speed 1ft/s"
    )]
    Design(DesignCommand),
    /// Analyse the digital hydraulic actuator: sizes, frequency response, limit cycles, the 1966 tables
    #[command(
        subcommand,
        after_help = "Examples:\n  planesman dha size auv\n  planesman dha limit-cycles --html limit_cycles.html"
    )]
    Dha(DhaCommand),
    /// Write an actuator, a vehicle or an identified model as an FMU (FMI 3.0) for other simulators
    #[command(
        after_help = "Examples:\n  planesman export --fmi auv -o auv.fmu\n  planesman export --fmi lauv --set propulsion=thrust --set speed=1 -o lauv.fmu\n  planesman export --fmi model.yaml -o model.fmu"
    )]
    Export(export_command::ExportArgs),
    /// Recompute the numbers of the two historical reports and of Hopsan's validations, and print which numbers agree
    #[command(after_help = "Example:\n  planesman reproduce --html book.html")]
    Reproduce(PassedOn),
    /// Check whether nodes find each other on this machine: domain, middleware, multicast, messages, other loops
    #[command(after_help = "Example:\n  planesman doctor --namespace /auv2")]
    Doctor {
        /// Namespace in which to look for other loops
        #[arg(long, default_value = NAMESPACE, value_parser = NonEmptyStringValueParser::new())]
        namespace: String,
    },
    /// Print a shell script that completes command lines
    #[command(
        after_help = "Example:\n  planesman completions bash \\\n      > ~/.local/share/bash-completion/completions/planesman"
    )]
    Completions {
        /// The shell
        shell: Shell,
    },
    /// Print the manual page of the program or of a command
    #[command(
        after_help = "Examples:\n  planesman man | man -l -\n  planesman man sysid fit | man -l -"
    )]
    Man {
        /// A command, such as sysid fit
        command: Vec<String>,
    },
    /// Run one node in this process, like `ros2 run`
    #[command(after_help = "Example:\n  planesman node plant_sim --ros-args -p speed:=0.5")]
    Node(NodeArgs),
}

#[derive(Args)]
struct DiveArgs {
    #[arg(default_value = "dive", help = planesman::arguments::scenario_help())]
    scenario: String,
    #[command(flatten)]
    changes: Changes,
    /// Folder for bag, parameters, logs and report; must not exist yet [default: runs/SCENARIO-TIME]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Run in lockstep: a tick ends when every node has answered, independent of the wall clock (the default)
    #[arg(long, help_heading = "Pace", conflicts_with_all = ["factor", "sim_time"])]
    lockstep: bool,
    /// Run in real time with this real-time factor (vehicle time divided by wall-clock time)
    #[arg(long, help_heading = "Pace", value_name = "F", value_parser = factor)]
    factor: Option<f64>,
    /// Run in real time with stamps from 0 and a /clock topic (implied by a factor other than 1)
    #[arg(long, help_heading = "Pace")]
    sim_time: bool,
    /// Keep the loop running until Ctrl-C, for `ros2 topic echo` and similar tools
    #[arg(long)]
    keep_running: bool,
    /// Show the dive on a page in the browser, like `planesman watch`; in real time unless --lockstep is given
    #[arg(long)]
    watch: bool,
    /// Print all numbers of the flight, and each step of the launch
    #[arg(long)]
    verbose: bool,
    /// Namespace of all nodes; simulated time is on /clock for the default namespace, otherwise on NAMESPACE/clock
    #[arg(long, default_value = NAMESPACE, value_parser = NonEmptyStringValueParser::new())]
    namespace: String,
}

#[derive(Args)]
struct SimArgs {
    #[arg(help = planesman::arguments::scenario_help())]
    scenario: String,
    #[command(flatten)]
    changes: Changes,
    /// File to write, *.mcap or *.csv; must not exist yet [default: SCENARIO.mcap]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Namespace of the topics in the bag
    #[arg(long, default_value = NAMESPACE, value_parser = NonEmptyStringValueParser::new())]
    namespace: String,
}

/// Changes to the scenario from the command line.
#[derive(Args)]
struct Changes {
    /// Set a parameter of a node, such as depth_controller.depth.p=1.2; may be repeated
    #[arg(long = "set", value_name = "NODE.PARAMETER=VALUE")]
    set: Vec<String>,
}

#[derive(Subcommand)]
enum BagCommand {
    /// Print topics, counts and times, whether the bag is complete, and which published messages are missing
    #[command(
        after_help = "Examples:\n  planesman bag info runs/dive/bag\n  planesman bag info dive.mcap --sha256"
    )]
    Info {
        /// A bag folder, a metadata.yaml or an .mcap file
        path: PathBuf,
        /// Print the SHA-256 of each topic's payloads instead, and one of all topics without wall-clock time; two bags of the same loop have equal hashes
        #[arg(long)]
        sha256: bool,
    },
    /// Compare two recordings message by message: the first difference, counts, largest differences; exit status 4 if they differ
    #[command(
        after_help = help(&["Examples:\n  planesman bag diff before.mcap after.mcap\n  planesman bag diff runs/a/bag runs/b/bag --ignore tick_answer --html diff.html\n  planesman bag diff expected.csv dive.mcap --tolerance depth=1e-9", EXIT_CODES])
    )]
    Diff(bag_command::DiffArgs),
    /// Play a bag's inputs through one node in lockstep, and compare its outputs with the recorded outputs; exit status 4 if they differ
    #[command(
        override_usage = "planesman bag play --lockstep --through NODE [OPTIONS] BAG [-- CMD...]",
        after_help = help(&["Examples:\n  planesman bag play runs/dive/bag --lockstep --through controller\n  planesman bag play runs/dive/bag --lockstep --through controller \\\n      -p pitch.p:=0.71\n  planesman bag play runs/dive/bag --lockstep --through own --input state \\\n      --output plane_command -- python3 own.py --ros-args -r __ns:=/auv", EXIT_CODES])
    )]
    Play(Box<bag_play::PlayArgs>),
}

#[derive(Args)]
struct NodeArgs {
    /// plant_sim, depth_controller, dha_actuator, sysid or recorder
    name: String,
    /// The node's arguments, as for `ros2 run`: --ros-args, then -p NAME:=VALUE, --params-file FILE,
    /// -r FROM:=TO, --log-level LEVEL (`planesman params` lists the parameters)
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    args: Vec<OsString>,
}

/// Parses a real-time factor within the range of the parameter.
fn factor(text: &str) -> Result<f64, String> {
    let declared = PlantParameters::declarations();
    let range = declared.iter().find(|it| it.name == "factor");
    let (least, most) = range.and_then(|it| it.range).unwrap_or_default();
    within(least, most)(text)
}

/// The first word of a refused command line, if it is neither a command nor a scenario.
fn unknown_word(error: &clap::Error) -> Option<String> {
    let word = std::env::args_os().nth(1)?.into_string().ok()?;
    let is_known = word.starts_with('-')
        || word == "help"
        || Cli::command().find_subcommand(&word).is_some()
        || Scenario::is_there(&word);
    (!is_help(error) && !is_known).then_some(word)
}

/// Refuses a first word that is neither a command nor a scenario.
fn unknown(word: &str) -> ExitCode {
    let program = Cli::command();
    let commands = program.get_subcommands().map(|it| it.get_name().to_owned());
    let scenarios = builtin_names().into_iter().map(str::to_owned);
    let known: Vec<String> = commands.chain(scenarios).collect();
    planesman_console::err!(
        "planesman: '{}' is neither a command nor a scenario{} (see planesman --help)",
        shown(word),
        did_you_mean(word, known.iter().map(String::as_str)),
    );
    ExitCode::from(2)
}

fn main() -> ExitCode {
    let cli = match parsed::<Cli>() {
        Ok(cli) => cli,
        Err(error) => {
            return match unknown_word(&error) {
                Some(word) => unknown(&word),
                None => refused::<Cli>(&error),
            };
        }
    };
    let command = match cli.command {
        Some(command) => command,
        None if Scenario::is_there(&cli.dive.scenario) => Command::Dive(cli.dive),
        None => return unknown(&cli.dive.scenario),
    };
    planesman_text::use_wording(planesman_text::Wording::CommandLine);
    planesman_node::file_size::limit_is_an_error();
    let outcome = match command {
        Command::Dive(args) => match dive(&args) {
            Ok(None) => Ok(()),
            Ok(Some(loss)) => {
                planesman_console::err!("planesman: {loss}");
                return ExitCode::from(LOST);
            }
            Err(error) => Err(error),
        },
        Command::Sim(args) => simulate(&args),
        Command::Sweep(args) => planesman::sweep::run(&args),
        Command::Report(args) => report::run(&args),
        Command::Replay(args) => planesman::sysid::replay::run(&args),
        Command::Sysid(command) => command.run(),
        Command::Tune(args) => planesman::tune::run(&args),
        Command::Review(args) => planesman::review::run(&args),
        Command::Watch(args) => stay_local().and_then(|()| watch::run(&args)),
        Command::Export(args) => export_command::run(&args),
        Command::Tf(args) if args.as_printed => reports_program::run("tf", 1),
        Command::Tf(args) => tf_command::run(&args),
        Command::Bag(BagCommand::Info {
            path,
            sha256: false,
        }) => bag_command::info(&path),
        Command::Bag(BagCommand::Info { path, sha256: true }) => bag_command::hashes(&path),
        Command::Bag(BagCommand::Diff(args)) => match bag_command::compare(&args) {
            Ok(false) => return ExitCode::from(DIFFERENT),
            other => other.map(drop),
        },
        Command::Bag(BagCommand::Play(args)) => {
            match stay_local().and_then(|()| bag_play::run(&args)) {
                Ok(false) => return ExitCode::from(DIFFERENT),
                other => other.map(drop),
            }
        }
        Command::Params {
            node,
            yaml: true,
            scenario,
            ..
        } => parameter_file(node.as_deref(), scenario.as_deref()),
        Command::Params { node, format, .. } => {
            params_command::list_parameters(node.as_deref(), format)
        }
        Command::SixDof(command) => planesman::six_dof_command::run(&command),
        Command::Coefficients(args) => coefficients_command::run(&args),
        Command::Design(command) => design::run(&command),
        Command::Dha(command) => dha::run(&command),
        Command::Reproduce(_) => reports_program::run("reproduce", 1),
        Command::Doctor { namespace } => stay_local().and_then(|()| doctor::run(&namespace)),
        Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(
                shell,
                &mut completed(Cli::command()),
                "planesman",
                &mut script,
            );
            written(script)
        }
        Command::Man { command } => manual(&command).and_then(written),
        Command::Node(args) => return nodes::run(&args.name, args.args),
    };
    let asks_for_help = || std::env::args_os().any(|it| it == "-h" || it == "--help");
    ended(
        "planesman",
        match outcome {
            Err(error) if error.is::<NotBuilt>() && asks_for_help() => help_without_the_reports(),
            other => other,
        },
    )
}

/// Prints the help of a command that `planesman-reports` runs, as far as this program has it.
fn help_without_the_reports() -> Result<()> {
    let (_, mut command) = command_of::<Cli>(std::env::args_os().skip(1));
    written(command.render_long_help().to_string().into_bytes())
}

/// The manual page of the command with these names, in roff.
fn manual(names: &[String]) -> Result<Vec<u8>> {
    let mut command = completed(Cli::command());
    command.build();
    for name in names {
        let known: Vec<_> = command
            .get_subcommands()
            .map(|it| it.get_name().to_owned())
            .collect();
        command = command.find_subcommand(name).cloned().ok_or_else(|| {
            let meant = did_you_mean(name, known.iter().map(String::as_str));
            anyhow!("unknown command '{}'{meant}", names.join(" "))
        })?;
    }
    let mut page = Vec::new();
    clap_mangen::Man::new(command).render(&mut page)?;
    Ok(page)
}

fn written(text: Vec<u8>) -> Result<()> {
    Ok(planesman_console::print(String::from_utf8(text)?)?)
}

/// Restricts discovery to this machine, unless the environment requests another range. The variable must be set before the first thread starts, so
/// the program restarts itself with the variable set.
fn stay_local() -> Result<()> {
    const RANGE: &str = "ROS_AUTOMATIC_DISCOVERY_RANGE";
    if std::env::var_os(RANGE).is_some() {
        return Ok(());
    }
    Err(std::process::Command::new(std::env::current_exe()?)
        .args(std::env::args_os().skip(1))
        .env(RANGE, "LOCALHOST")
        .exec()
        .into())
}

fn dive(args: &DiveArgs) -> Result<Option<Loss>> {
    stay_local()?;
    let scenario = Scenario::load_with(&args.scenario, &args.changes.set)?;
    let in_real_time = args.sim_time || (args.watch && !args.lockstep);
    let pace = match (args.factor, in_real_time) {
        (None, false) => Pace::Lockstep,
        (factor, sim_time) => {
            let factor = factor.unwrap_or(1.0);
            Pace::Real {
                factor,
                sim_time: sim_time || factor != 1.0,
            }
        }
    };
    let run = RunFolder::free(args.out.as_deref(), &args.scenario)?;
    dive::run(
        &scenario,
        &run,
        &dive::Options {
            pace,
            keep_running: args.keep_running,
            watch: args.watch,
            namespace: args.namespace.clone(),
            scenario: args.scenario.clone(),
            verbose: args.verbose,
        },
    )
}

fn simulate(args: &SimArgs) -> Result<()> {
    let scenario = Scenario::load_with(&args.scenario, &args.changes.set)?;
    let out = args.out.clone().unwrap_or_else(|| {
        let stem = Path::new(&args.scenario).file_stem().unwrap_or_default();
        Path::new(stem).with_extension("mcap")
    });
    let fly = match overwritten(&out, args.out.is_some())? {
        true => fly_over,
        false => fly,
    };
    let ticks = fly(
        &scenario,
        &Parts::default(),
        &out,
        &args.namespace,
        &Bars::default(),
    )?;
    let flown = format!("Flew {:.2} s, {ticks} ticks.", ticks as f64 * scenario.tick);
    let kind = match out.extension() {
        Some(extension) if extension == "mcap" => "Bag",
        _ => "Table",
    };
    let topics = format!(
        "planesman sysid topics {}",
        shell_word(&out.display().to_string())
    );
    let outcome = Outcome::new(flown).file(kind, &out);
    Ok(outcome.next(topics, "list its signals").print()?)
}

fn parameter_file(node: Option<&str>, scenario: Option<&str>) -> Result<()> {
    let scenario = scenario.map(Scenario::load).transpose()?;
    planesman_console::print(format_args!(
        "{}",
        planesman_flight::parameter_file::parameter_file(node, scenario.as_ref())?
    ))?;
    Ok(())
}
