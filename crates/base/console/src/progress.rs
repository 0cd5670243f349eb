//! Long work: on all cores, with progress on standard error, and ended when nobody reads its output any more.
//!
//! On a terminal, progress is a bar with the remaining time; elsewhere, such as in a log file, a line every ten seconds.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use std::{fmt, io};

use indicatif::style::TemplateError;
use indicatif::{HumanDuration, ProgressDrawTarget, ProgressState, TermLike};
pub use indicatif::{ProgressBar, ProgressStyle};
use planesman_parallel::Progress;
use rustix::event::{PollFd, PollFlags, poll};

/// Interval of progress lines without a terminal.
const LINES: Duration = Duration::from_secs(10);

/// A bar on standard error with the remaining time.
#[must_use]
pub fn bar(what: &'static str, steps: usize) -> ProgressBar {
    bar_with(what, steps as u64, 0)
}

/// Like [`bar`], with `done` steps done before.
#[must_use]
pub fn bar_with(what: &'static str, steps: u64, done: u64) -> ProgressBar {
    let bar = ProgressBar::new(steps).with_position(done);
    let style = ProgressStyle::with_template(match bar.is_hidden() {
        true => "{msg} {pos}/{len}{left}",
        false => "{msg} {bar:30} {pos}/{len}{left}",
    });
    // What was done before says nothing of the time left.
    bar.reset_eta();
    styled(bar, what, style.map(with_time_left))
}

/// A bar for bytes read.
fn bar_of_bytes(bytes: u64) -> ProgressBar {
    let bar = ProgressBar::new(bytes);
    let style = ProgressStyle::with_template(match bar.is_hidden() {
        true => "{msg} {bytes}/{total_bytes}{left}",
        false => "{msg} {bar:40} {bytes}/{total_bytes}{left}",
    });
    styled(bar, "read", style.map(with_time_left))
}

/// Shows the progress of work as a bar, or as elapsed time if its length is unknown.
#[derive(Debug, Default)]
pub struct Bars(Mutex<Option<ProgressBar>>);

impl Progress for Bars {
    fn begin(&self, what: &'static str, steps: u64, done: u64) {
        *self.held() = Some(match steps {
            0 => spinner(what),
            _ => bar_with(what, steps, done),
        });
    }

    fn step(&self) {
        if let Some(bar) = &*self.held() {
            bar.inc(1);
        }
    }

    fn read(&self, bytes: u64, of: u64) {
        let mut held = self.held();
        let bar = held.get_or_insert_with(|| bar_of_bytes(of));
        bar.set_position(bytes);
    }

    fn end(&self) {
        if let Some(bar) = self.held().take() {
            bar.finish_and_clear();
        }
    }
}

impl Bars {
    fn held(&self) -> MutexGuard<'_, Option<ProgressBar>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Shows the elapsed time of work of unknown length on standard error.
#[must_use]
pub fn spinner(what: &'static str) -> ProgressBar {
    let bar = ProgressBar::new_spinner();
    let style = ProgressStyle::with_template(match bar.is_hidden() {
        true => "{msg}, {elapsed}",
        false => "{spinner} {msg}, {elapsed}",
    });
    styled(bar, what, style)
}

/// Adds the remaining time, which is known only after the first step.
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
    if bar.is_hidden() {
        let target = ProgressDrawTarget::term_like_with_hz(Box::new(Lines::default()), 1);
        bar.set_draw_target(target);
        tick_every(&bar, Duration::from_secs(1));
    } else {
        tick_every(&bar, Duration::from_millis(200));
    }
    bar
}

/// Redraws the bar at this interval. (The library's own function panics if the system provides no thread.)
fn tick_every(bar: &ProgressBar, interval: Duration) {
    let bar = bar.downgrade();
    // Without a thread it is drawn as it grows.
    let _ = std::thread::Builder::new().spawn(move || {
        while let Some(bar) = bar.upgrade().filter(|it| !it.is_finished()) {
            bar.tick();
            drop(bar);
            std::thread::sleep(interval);
        }
    });
}

/// Without a terminal: writes the present bar as a line from time to time.
#[derive(Debug)]
struct Lines(Mutex<(Instant, String)>);

impl Default for Lines {
    fn default() -> Self {
        Self(Mutex::new((Instant::now(), String::new())))
    }
}

impl Lines {
    /// The text drawn last, if a line is due.
    fn due(&self, now: Instant) -> Option<String> {
        let mut held = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let drawn = std::mem::take(&mut held.1).trim().to_owned();
        let is_due = !drawn.is_empty() && now.duration_since(held.0) >= LINES;
        is_due.then(|| {
            held.0 = now;
            drawn
        })
    }
}

impl TermLike for Lines {
    fn width(&self) -> u16 {
        100
    }

    fn move_cursor_up(&self, _: usize) -> io::Result<()> {
        Ok(())
    }

    fn move_cursor_down(&self, _: usize) -> io::Result<()> {
        Ok(())
    }

    fn move_cursor_right(&self, _: usize) -> io::Result<()> {
        Ok(())
    }

    fn move_cursor_left(&self, _: usize) -> io::Result<()> {
        Ok(())
    }

    fn write_line(&self, text: &str) -> io::Result<()> {
        self.write_str(text)
    }

    fn write_str(&self, text: &str) -> io::Result<()> {
        let mut held = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        held.1.push_str(text);
        Ok(())
    }

    fn clear_line(&self) -> io::Result<()> {
        Ok(())
    }

    fn flush(&self) -> io::Result<()> {
        if let Some(line) = self.due(Instant::now()) {
            crate::err!("{line}");
        }
        Ok(())
    }
}

/// Results of `work` for each item, in order, computed on all cores with a progress bar.
pub fn on_all_cores<T: Sync, R: Send>(
    what: &'static str,
    items: &[T],
    work: impl Fn(&T) -> R + Sync,
) -> Vec<R> {
    let bar = bar(what, items.len());
    let results = planesman_parallel::on_all_cores(items, |item| {
        let result = work(item);
        bar.inc(1);
        result
    });
    bar.finish_and_clear();
    results
}

/// Ends the program once nobody reads its standard output any more, for example after `| head`. Only for commands without other effects.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn where_there_is_no_terminal_one_of_many_drawings_becomes_a_line() {
        let lines = Lines::default();
        let begin = Instant::now();
        let drawn = |text: &str, after: u64| {
            lines.write_str(text).expect("held");
            lines.due(begin + Duration::from_secs(after))
        };
        assert_eq!(drawn("flights 1/9", 1), None);
        assert_eq!(drawn(" flights 2/9 ", 11).as_deref(), Some("flights 2/9"));
        assert_eq!(drawn("flights 3/9", 12), None);
        assert_eq!(drawn("", 30), None, "a bar that is gone");
        assert_eq!(drawn("flights 4/9", 31).as_deref(), Some("flights 4/9"));
    }
}
