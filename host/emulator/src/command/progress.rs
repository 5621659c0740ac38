// SPDX-License-Identifier: GPL-2.0-only
//! How far a command is, on a terminal alone.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

/// A bar that counts to `total`.
pub fn bar(total: usize, what: &str) -> ProgressBar {
    let bar = ProgressBar::new(total as u64);
    style(
        &bar,
        &format!("{{bar:30}} {{pos}}/{{len}} {what}, {{elapsed}}"),
    );
    bar
}

/// For work whose end is not known: a text that changes.
pub fn spinner() -> ProgressBar {
    let spinner = ProgressBar::new_spinner();
    style(&spinner, "{spinner} {msg}");
    spinner
}

fn style(bar: &ProgressBar, template: &str) {
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(200));
}
