//! Long work: on all cores, with its progress on the terminal, and no longer than somebody reads its output.

use std::fmt;
use std::time::Duration;

use indicatif::style::TemplateError;
use indicatif::{HumanDuration, ProgressBar, ProgressState, ProgressStyle};
use rustix::event::{PollFd, PollFlags, poll};

/// A bar on standard error with the time left; nothing where that is no terminal.
#[must_use]
pub fn bar(what: &'static str, steps: usize) -> ProgressBar {
    bar_with(what, steps as u64, 0)
}

/// As [`bar`], of work of which so many steps were done before.
#[must_use]
pub fn bar_with(what: &'static str, steps: u64, done: u64) -> ProgressBar {
    let style = ProgressStyle::with_template("{msg} {bar:30} {pos}/{len}{left}");
    let bar = ProgressBar::new(steps).with_position(done);
    // What was done before says nothing of the time left.
    bar.reset_eta();
    styled(bar, what, style.map(with_time_left))
}

/// The time that work of unknown length has taken, on standard error; nothing where that is no terminal.
#[must_use]
pub fn spinner(what: &'static str) -> ProgressBar {
    let style = ProgressStyle::with_template("{spinner} {msg}, {elapsed}");
    styled(ProgressBar::new_spinner(), what, style)
}

/// The time left, once a step is done: nothing is known of it before.
fn with_time_left(style: ProgressStyle) -> ProgressStyle {
    style.with_key(
        "left",
        |state: &ProgressState, text: &mut dyn fmt::Write| {
            // An error would be of a terminal that is gone.
            let _ = match state.pos() {
                0 => Ok(()),
                _ => write!(text, ", {:#} left", HumanDuration(state.eta())),
            };
        },
    )
}

fn styled(
    bar: ProgressBar,
    what: &'static str,
    style: Result<ProgressStyle, TemplateError>,
) -> ProgressBar {
    if let Ok(style) = style {
        bar.set_style(style);
    }
    bar.set_message(what);
    if !bar.is_hidden() {
        bar.enable_steady_tick(Duration::from_millis(200));
    }
    bar
}

/// The results of `work` on each of the items, in their order, computed on all cores, under a progress bar.
pub fn on_all_cores<T: Sync, R: Send>(
    what: &'static str,
    items: &[T],
    work: impl Fn(&T) -> R + Sync,
) -> Vec<R> {
    let bar = bar(what, items.len());
    let results = planesman_identification::on_all_cores(items, |item| {
        let result = work(item);
        bar.inc(1);
        result
    });
    bar.finish_and_clear();
    results
}

/// Ends the program once nobody can read its standard output any more, as behind `| head`. For commands that
/// leave nothing but that output.
pub fn end_with_reader() {
    // Without a thread the program goes on to its end.
    let _ = std::thread::Builder::new().spawn(|| {
        let stdout = std::io::stdout();
        let mut watched = [PollFd::new(&stdout, PollFlags::empty())];
        loop {
            match poll(&mut watched, None) {
                Err(rustix::io::Errno::INTR) => {}
                Ok(_) if watched[0].revents().contains(PollFlags::ERR) => std::process::exit(0),
                _ => return,
            }
        }
    });
}
