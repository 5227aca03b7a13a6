//! How far the work is: a bar on a terminal, a line now and then elsewhere, nothing for short work.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Work shorter than this shows nothing.
const PATIENCE: Duration = Duration::from_secs(2);
/// Time between lines where standard error is no terminal.
const BETWEEN_LINES: Duration = Duration::from_secs(10);
/// Share of the work after which a line would come with the end.
const ALMOST: f64 = 0.95;
/// Steps of the bar.
const STEPS: u64 = 1000;

/// Shows on standard error how far one piece of work is.
#[derive(Debug)]
pub struct Progress {
    shown: bool,
    terminal: bool,
    started: Instant,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    bar: Option<ProgressBar>,
    last_line: Option<Instant>,
}

impl Progress {
    /// Begins now; `quiet` hides it.
    #[must_use]
    pub fn new(quiet: bool) -> Self {
        let terminal = std::io::stderr().is_terminal();
        Self { shown: !quiet, terminal, started: Instant::now(), state: Mutex::default() }
    }

    /// Tells that the share `done` (0 to 1) of the whole work is done and that it is now at `what`.
    pub fn observe(&self, done: f64, what: &str) {
        let elapsed = self.started.elapsed();
        if !self.shown || elapsed < PATIENCE {
            return;
        }
        let done = if done.is_finite() { done.clamp(0.0, 1.0) } else { 0.0 };
        let message = format!("{what}{}", time_left(elapsed, done));
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if self.terminal {
            let bar = state.bar.get_or_insert_with(new_bar);
            bar.set_position((done * STEPS as f64) as u64);
            bar.set_message(message);
        } else if done < ALMOST && state.last_line.is_none_or(|last| last.elapsed() >= BETWEEN_LINES) {
            state.last_line = Some(Instant::now());
            super::note(&format!("{:.0} % {message}", 100.0 * done));
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        let state = self.state.get_mut().unwrap_or_else(PoisonError::into_inner);
        if let Some(bar) = &state.bar {
            bar.finish_and_clear();
        }
    }
}

fn new_bar() -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::stderr());
    match ProgressStyle::with_template("{wide_bar} {percent} % {msg}") {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

/// Time left if the rest goes as fast as what is done; nothing below a hundredth, where that would be a guess.
fn time_left(elapsed: Duration, done: f64) -> String {
    if done < 0.01 {
        return String::new();
    }
    let left = elapsed.as_secs_f64() * (1.0 - done) / done;
    match left {
        left if left < 90.0 => format!(", {left:.0} s left"),
        left if left < 5400.0 => format!(", {:.0} min left", left / 60.0),
        left => format!(", {:.1} h left", left / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_left_is_that_of_even_work() {
        let minute = Duration::from_secs(60);
        assert_eq!(time_left(minute, 0.5), ", 60 s left");
        assert_eq!(time_left(minute, 0.1), ", 9 min left");
        assert_eq!(time_left(minute, 0.01), ", 1.6 h left");
        assert_eq!(time_left(minute, 0.001), "");
    }
}
