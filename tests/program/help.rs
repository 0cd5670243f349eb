//! Every help text: an example, 80 columns, and brackets that no shell takes for a pattern; in the documents too.
use std::path::Path;
use std::process::Command;

use planesman_signals::{LogKind, TABLES};

/// The help of a command, short or whole.
fn help(command: &[String], flag: &str) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_planesman"))
        .args(command)
        .arg(flag)
        .output()
        .unwrap();
    assert!(output.status.success(), "{command:?} {flag}");
    String::from_utf8(output.stdout).unwrap()
}

/// The names below `Commands:` in a help text.
fn commands(help: &str) -> Vec<String> {
    let lines = help.lines().skip_while(|line| *line != "Commands:").skip(1);
    let own = lines.take_while(|line| !line.is_empty());
    let names = own.filter_map(|line| {
        let name = line.strip_prefix("  ")?.split_whitespace().next()?;
        (!line.starts_with("   ") && name != "help").then(|| name.to_owned())
    });
    names.collect()
}

/// Every command of the program, itself first.
fn all() -> Vec<Vec<String>> {
    let mut found = vec![Vec::new()];
    let mut next = 0;
    while next < found.len() {
        let command = found[next].clone();
        for name in commands(&help(&command, "-h")) {
            found.push([&command[..], &[name]].concat());
        }
        next += 1;
    }
    found
}

/// Whether a line of a shell has a bracket outside quotes, where zsh looks for files. `[OPTIONS]` of a usage is none of a shell.
fn has_a_bare_bracket(line: &str) -> bool {
    let code = line.split(" #").next().unwrap_or_default();
    let mut quote = None;
    for sign in code.chars() {
        match (quote, sign) {
            (None, '\'' | '"') => quote = Some(sign),
            (Some(open), _) if sign == open => quote = None,
            (None, '[') => return true,
            _ => {}
        }
    }
    false
}

#[test]
fn every_help_text_has_an_example_within_eighty_columns() {
    let commands = all();
    assert!(commands.len() >= 35, "{}", commands.len());
    for command in &commands {
        for flag in ["-h", "--help"] {
            let text = help(command, flag);
            let name = format!("planesman {} {flag}", command.join(" "));
            let examples = text.split("\nExample").nth(1);
            let examples = examples.unwrap_or_else(|| panic!("{name} has no example"));
            let called = ["planesman", &command.join(" ")].join(" ");
            assert!(examples.contains(called.trim_end()), "{name}: {examples}");
            for line in text.lines() {
                assert!(line.chars().count() <= 80, "{name}: {line}");
                assert!(!line.contains("\\["), "{name}: {line}");
            }
            for line in examples.lines() {
                assert!(!has_a_bare_bracket(line), "{name}: {line}");
            }
        }
    }
}

#[test]
fn the_short_help_of_a_fit_is_half_a_page_and_the_long_one_has_every_option() {
    let fit = ["sysid", "fit"].map(str::to_owned);
    let (short, long) = (help(&fit, "-h"), help(&fit, "--help"));
    for option in ["--order", "--window", "--html"] {
        assert!(short.contains(option) && long.contains(option), "{option}");
    }
    for option in ["--prefilter", "--initial-covariance", "--heave-doubt"] {
        assert!(!short.contains(option) && long.contains(option), "{option}");
    }
    assert!(short.lines().count() * 3 < long.lines().count());
}

#[test]
fn fields_with_brackets_are_quoted_wherever_a_shell_is_shown() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let docs = std::fs::read_dir(root.join("docs")).unwrap();
    let pages = docs.map(|it| it.unwrap().path());
    let further = ["README.md", "launch-scripts/README.md", "CONTRIBUTING.md"];
    let mut blocks = 0;
    for page in pages.chain(further.map(|it| root.join(it))) {
        if page.extension().is_none_or(|it| it != "md") {
            continue;
        }
        let text = std::fs::read_to_string(&page).unwrap();
        let mut in_shell = false;
        for line in text.lines() {
            if line.starts_with("```") {
                in_shell = line.starts_with("```sh");
                blocks += usize::from(in_shell);
            } else if in_shell && line.trim_start().starts_with("planesman") {
                assert!(!has_a_bare_bracket(line), "{}: {line}", page.display());
            }
        }
    }
    assert!(blocks > 20, "{blocks}");
}

#[test]
fn every_ending_that_is_read_stands_in_the_help_and_in_the_document() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/sysid.md");
    let page = std::fs::read_to_string(page).unwrap();
    let help = help(&["sysid", "fit"].map(str::to_owned), "--help");
    let logs = LogKind::all().iter().flat_map(|it| it.endings);
    for ending in logs.chain(&TABLES) {
        assert!(page.contains(&format!("`.{ending}`")), "{ending}");
        assert!(help.contains(&format!(".{ending}")), "{ending}");
    }
}
