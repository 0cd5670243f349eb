//! `planesman review`: data, model and gains on one page for colleagues, each number with its sample size.

use std::path::PathBuf;

use anyhow::{Result, anyhow};
use clap::Parser;
use planesman_console::{Outcome, called, file_line};
use planesman_fit::{
    DataOptions, FitData, FitOptions, FitResult, SamplesOptions, Sources, Validation, samples,
};
use planesman_flight::sink::write_text;
use planesman_flight::titles;
use planesman_identification::frequency::MeasuredResponse;
use planesman_show::pages::review::{self, Review};
use planesman_text::in_one_line;
use serde_json::json;

use crate::arguments::{overwrites, page_file};
use crate::sysid::arguments::SignalArgs;
use crate::tune::{GainArgs, Gains, model_for_gains, review_of_dive};

/// Default signals, for bags of this suite.
const OWN: [&str; 2] = ["plane_motion:dive_planes", "state:pitch_rate"];
/// Default file name of the page.
const PAGE: &str = "review.html";

/// Topic of the vehicle's speed in this suite's bags, m/s, and the number of initial samples to average.
const SPEED: (&str, usize) = ("state:surge", 100);

/// The speed at the beginning of a bag of this suite, m/s; only that part of the bag is read.
fn speed_at_begin(data: &DataOptions) -> Option<f64> {
    let Sources::Files(paths) = &data.sources else {
        return None;
    };
    let first = Sources::Files(paths.iter().take(1).cloned().collect());
    let options = SamplesOptions {
        data: DataOptions {
            sources: first,
            ..data.clone()
        },
        signals: vec![SPEED.0.to_owned()],
    };
    let mut speeds = Vec::new();
    samples(&options, &mut |_, _, value| {
        speeds.extend(value);
        speeds.len() < SPEED.1
    })
    .ok()?;
    let mean = speeds.iter().sum::<f64>() / speeds.len() as f64;
    (mean > 0.0).then_some(mean)
}

fn of_own_bags(argument: clap::Arg) -> clap::Arg {
    match argument.get_id().as_str() {
        "input" | "output" => argument.required(false),
        _ => argument,
    }
}

/// Write one page for colleagues with data, model, validation, margins and robustness of gains; each number with its sample size.
#[derive(Clone, Debug, Parser)]
#[command(
    name = "review",
    mut_args = of_own_bags,
    override_usage = "planesman review [OPTIONS] -i <SIGNAL> -o <SIGNAL> <DATA>...\n       planesman review [OPTIONS] <BAG>..."
)]
pub struct ReviewArgs {
    #[command(flatten)]
    signals: SignalArgs,
    /// Validation data, not used for the fit: a file or folder with the same signals, or a window of the data
    /// [default: a model of the first 70 % is validated on the rest]
    #[arg(long, value_name = "DATA|FROM..TO", value_parser = |text: &str| text.parse::<Validation>(), allow_hyphen_values = true, help_heading = "Data")]
    validation: Option<Validation>,
    #[command(flatten)]
    gains: GainArgs,
    /// Print JSON
    #[arg(long, help_heading = "Output")]
    json: bool,
    /// Write one page to share: conclusion, gains, margins, the plots of validation and step
    #[arg(long, help_heading = "Output")]
    brief: bool,
    /// HTML page to write
    #[arg(long, value_name = "FILE", default_value = PAGE, value_parser = page_file, help_heading = "Output")]
    html: PathBuf,
}

impl ReviewArgs {
    /// Whether no signals are named, so that the default signals of this suite's bags are used.
    fn is_own(&self) -> bool {
        self.signals.input.is_empty() && self.signals.output.is_empty()
    }

    fn options(&self) -> Result<FitOptions> {
        let mut signals = self.signals.clone();
        let is_own = self.is_own();
        if is_own {
            [signals.input, signals.output] = OWN.map(|it| vec![it.to_owned()]);
        }
        if signals.input.len() != 1 || signals.output.len() != 1 {
            return Err(anyhow!(
                "review needs a controller with one input and one output. Name one --input and one --output (planesman sysid topics lists the signals)"
            ));
        }
        let mut options = FitOptions {
            signals: signals.options(),
            validation: self.validation.clone(),
            ..FitOptions::default()
        };
        let own = || {
            is_own
                .then(|| speed_at_begin(&options.signals.data))
                .flatten()
        };
        options.vehicle.speed = self.gains.speed().or_else(own);
        Ok(options)
    }
}

/// Writes the page and prints its conclusion. Without a usable model the page explains this, and gives the next step.
///
/// # Errors
/// Like [`planesman_fit::fit`], [`planesman_tuning::tune`] and [`planesman_show::design::DiveTask::gains`]; the page is still written unless no
/// data could be read. A page that cannot be written.
pub fn run(args: &ReviewArgs) -> Result<()> {
    let options = args.options()?;
    let progress = args.signals.data.progress();
    let data = FitData::read(&options, &*progress).map_err(|refusal| match args.is_own() {
        true => {
            anyhow!(refusal).context("without --input and --output, DATA must be the bag of a dive")
        }
        false => refusal.into(),
    })?;
    let record = &data.prepared.resampled.record;
    let sample_time = record.sample_time;
    let model = model_for_gains(&data, &options, &*progress);
    let response = match &model {
        Ok(found) => MeasuredResponse::new(&found.analysis.of_dynamics(record)),
        Err(_) => MeasuredResponse::new(record),
    };
    let found = match &model {
        Ok(found) => (found.model_file().map_err(Into::into)).and_then(|it| args.gains.gains(it)),
        Err(_) => Err(anyhow!("no model was identified")),
    };
    let title = |names: &[String]| {
        let name = names.first().map_or("", String::as_str);
        titles::title(data.prepared.reading.column(name))
    };
    let [input, output] = [title(&record.inputs), title(&record.outputs)];
    let seed = args.gains.seed();
    let gains = match &found {
        Err(refusal) => Err(in_one_line(refusal.as_ref())),
        Ok(Gains::Controller(of)) => Ok(review::Gains::of_tuning(of, [&input, &output], seed)),
        Ok(Gains::Dive(task, of)) => Ok(review_of_dive(task, of, seed)?),
    };
    let review = Review {
        command: &called(),
        program: concat!("planesman ", env!("CARGO_PKG_VERSION")),
        data: &data,
        response: response.as_ref().map_err(ToString::to_string),
        model: model.as_ref().map_err(|it| in_one_line(it)),
        gains,
    };
    let page = match args.brief {
        true => review::brief(&review),
        false => review::page(&review),
    };
    write_text(&args.html, &page)?;
    if args.json {
        let tuned = match &found {
            Ok(Gains::Controller(of)) => of.as_json(),
            Ok(Gains::Dive(task, of)) => crate::tune::json_of_dive(task, of),
            Err(_) => json!(null),
        };
        let as_json = json!({
            "conclusion": review.sentences().collect::<Vec<_>>(),
            "command": review.command,
            "page": args.html,
            "identification": model.as_ref().ok().map(FitResult::as_json).transpose()?,
            "response": response.as_ref().ok().map(|it| json!({
                "band": it.band(),
                "omega": it.points.iter().map(|it| it.omega).collect::<Vec<_>>(),
                "input_spectrum": it.points.iter().map(|it| it.inputs.first().map(|it| 2.0 * sample_time * it)).collect::<Vec<_>>(),
                "input_spectrum_unit": "square of the input's unit per Hz, one-sided",
                "coherence": it.points.iter().map(|it| it.coherence).collect::<Vec<_>>(),
            })),
            "tuning": tuned,
        });
        planesman_console::print(serde_json::to_string_pretty(&as_json)? + "\n")?;
        planesman_console::err!("{}", file_line("Page", &args.html));
    } else {
        let mut sentences = review.sentences();
        let answer = sentences.next().unwrap_or_default();
        let mut outcome = Outcome::new(answer)
            .numbers(sentences.map(|it| format!("- {it}\n")).collect::<String>())
            .file("Page", &args.html);
        if !args.brief {
            outcome = outcome.next(
                format!(
                    "{} --brief{}",
                    called(),
                    if overwrites() { "" } else { " --overwrite" }
                ),
                "one page to share",
            );
        }
        outcome.print()?;
    }
    model?;
    found.map(|_| ())
}
