//! How far a command is, on a terminal alone: a pipe gets none of it.

use std::time::Duration;

use indicatif::ProgressStyle;

pub use indicatif::ProgressBar;

/// Pause between two drawings of a bar that does not move: the elapsed time goes on.
const TICK: Duration = Duration::from_millis(200);

/// A bar that counts to `total`.
#[must_use]
pub fn bar(total: usize, what: &str) -> ProgressBar {
    styled(
        ProgressBar::new(total as u64),
        &format!("{{bar:30}} {{pos}}/{{len}} {what}, {{elapsed}}, {{eta}} left"),
    )
}

/// For work whose end is not known: a text that changes.
#[must_use]
pub fn spinner() -> ProgressBar {
    styled(ProgressBar::new_spinner(), "{spinner} {msg}")
}

fn styled(bar: ProgressBar, template: &str) -> ProgressBar {
    // One that cannot be read is a bar in the crate's own style.
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar.enable_steady_tick(TICK);
    bar
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_template_can_be_read() {
        for template in [
            "{bar:30} {pos}/{len} {elapsed}, {eta} left",
            "{spinner} {msg}",
        ] {
            assert!(ProgressStyle::with_template(template).is_ok());
        }
    }
}
