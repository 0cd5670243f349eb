//! What the program answers.

use std::process::Command;

use planesman_testing::near;
use serde_json::Value;

use crate::plant::{GAIN, POLE};

/// What a run printed, and how it ended.
#[derive(Debug)]
pub(crate) struct Answer {
    pub(crate) status: Option<i32>,
    /// Standard output and standard error.
    pub(crate) text: String,
    /// The object that `--json` prints; null without.
    pub(crate) json: Value,
}

/// Runs the program in a folder.
pub(crate) fn planesman(folder: &std::path::Path, arguments: &[&str]) -> Answer {
    answer(program(folder, arguments))
}

fn program(folder: &std::path::Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_planesman"));
    command.args(arguments).current_dir(folder);
    command
}

fn answer(mut command: Command) -> Answer {
    let output = command.output().unwrap();
    let printed = String::from_utf8(output.stdout).unwrap();
    Answer {
        status: output.status.code(),
        json: serde_json::from_str(&printed).unwrap_or_default(),
        text: printed + &String::from_utf8(output.stderr).unwrap(),
    }
}

/// `planesman sysid fit ... --json`.
pub(crate) fn fit(folder: &std::path::Path, arguments: &[&str]) -> Answer {
    planesman(
        folder,
        &[&["sysid", "fit"], arguments, &["--json"]].concat(),
    )
}

/// The same, with a variable of the environment.
pub(crate) fn fit_with(
    folder: &std::path::Path,
    arguments: &[&str],
    (name, value): (&str, &std::path::Path),
) -> Answer {
    let arguments = [&["sysid", "fit"], arguments, &["--json"]].concat();
    let mut command = program(folder, &arguments);
    command.env(name, value);
    answer(command)
}

impl Answer {
    /// A number of the JSON, by its place: `model/poles/0/re`.
    #[track_caller]
    pub(crate) fn number(&self, place: &str) -> f64 {
        let value = self.json.pointer(&format!("/{place}"));
        let number = value.and_then(Value::as_f64);
        number.unwrap_or_else(|| panic!("no number {place} in: {}", self.brief()))
    }

    /// Reading's notes and verdict, one line each.
    pub(crate) fn said(&self) -> String {
        let lines = |place: &str| {
            let lines = self.json.pointer(place).and_then(Value::as_array);
            lines.cloned().unwrap_or_default().into_iter()
        };
        let said = lines("/reading/notes").chain(lines("/model/verdict"));
        let said: Vec<String> = said
            .map(|it| it.as_str().unwrap_or_default().to_owned())
            .collect();
        said.join("\n")
    }

    /// What is said, without the numbers.
    pub(crate) fn brief(&self) -> String {
        if self.json.is_null() {
            return self.text.clone();
        }
        let channels = ["/record/inputs/0", "/record/outputs/0"];
        let channels = channels.map(|it| self.json.pointer(it).map(Value::to_string));
        format!("{}\n{channels:?}", self.said())
    }

    /// Checks that something is said: in the refusal, or beside the model.
    #[track_caller]
    pub(crate) fn says(&self, words: &str) -> &Self {
        let said = self.brief();
        assert!(said.contains(words), "'{words}' is not in: {said}");
        self
    }

    /// Checks what is said of the stamps.
    #[track_caller]
    pub(crate) fn says_stamps(&self, words: &str) -> &Self {
        let stamps = self.json.pointer("/reading/stamps").and_then(Value::as_str);
        assert!(
            stamps.is_some_and(|it| it.contains(words)),
            "'{words}' is not in: {stamps:?}"
        );
        self
    }

    /// Checks that the data is refused, with these words.
    #[track_caller]
    pub(crate) fn refused(&self, words: &[&str]) -> &Self {
        assert_eq!(self.status, Some(1), "{}", self.text);
        for words in words {
            assert!(
                self.text.contains(words),
                "'{words}' is not in: {}",
                self.text
            );
        }
        self
    }

    /// Checks that the model is `3/(s^2 + 1.2 s + 4)`, that so many samples made it, and that the verdict is good.
    #[track_caller]
    pub(crate) fn is_the_plant(&self, samples: u64) -> &Self {
        assert_eq!(self.status, Some(0), "{}", self.brief());
        let found = self.number("record/samples");
        // Stamps that are rounded may end a hair before the last instant.
        let is_as_expected = (found - samples as f64).abs() <= 1.0;
        assert!(is_as_expected, "{found} samples: {}", self.brief());
        near(self.number("model/continuous_poles/0/re"), POLE.0, 0.01);
        let im = self.number("model/continuous_poles/0/im").abs();
        near(im, POLE.1, 0.01);
        near(self.number("model/steady_state_gain/0"), GAIN, 0.005);
        self.says("verdict: good")
    }
}
