//! Running other programs.

use std::cell::Cell;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use crate::own_scene;

/// A step that took at least this long says so.
const WORTH_TELLING_S: u64 = 5;

/// Why a command ended badly: exit status and what to tell (empty where the program itself has told it).
#[derive(Debug)]
pub struct Failure {
    /// Exit status of xtask: 1 for a failed check, 2 for a wrong call.
    pub code: u8,
    /// One line for the user.
    pub message: String,
}

/// What every command returns.
pub type Outcome<T = ()> = Result<T, Failure>;

impl Failure {
    /// Something could not be done.
    pub fn new(message: impl Into<String>) -> Self {
        Self {
            code: 1,
            message: message.into(),
        }
    }

    /// The call was wrong.
    pub fn usage(message: impl Into<String>) -> Self {
        Self {
            code: 2,
            message: message.into(),
        }
    }
}

/// Root of the checkout, wherever xtask was started.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .ancestors()
        .nth(2)
        .map(Path::to_path_buf)
        .unwrap_or_default()
}

/// Where build products go.
pub fn target_dir() -> PathBuf {
    match std::env::var_os("CARGO_TARGET_DIR") {
        Some(dir) => root().join(dir),
        None => root().join("target"),
    }
}

/// A `cargo` call at the root of the checkout.
///
/// The variables that cargo sets for the programs it runs would make a nested cargo believe that things
/// changed, and build again.
pub fn cargo<I: AsRef<OsStr>>(arguments: impl IntoIterator<Item = I>) -> Command {
    let mut command = Command::new("cargo");
    command.args(arguments).current_dir(root());
    for (name, _) in std::env::vars_os() {
        let text = name.to_string_lossy();
        if text.starts_with("CARGO_PKG_") || text.starts_with("CARGO_MANIFEST_") {
            command.env_remove(&name);
        }
    }
    own_scene::pass_on(&mut command);
    command
}

thread_local! {
    /// Whether this thread works behind another one, whose output is not to be mixed with that of this one.
    static BEHIND: Cell<bool> = const { Cell::new(false) };
}

/// Runs steps that keep one core busy, builds for the chip, behind others; cargo is quiet in them. A failure of either is told when
/// both have ended.
pub fn together<A: Send, B>(
    behind: impl FnOnce() -> Outcome<A> + Send,
    front: impl FnOnce() -> Outcome<B>,
) -> Outcome<(A, B)> {
    std::thread::scope(|scope| {
        let behind = scope.spawn(|| {
            BEHIND.set(true);
            behind()
        });
        let front = front();
        let behind = behind
            .join()
            .unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        Ok((behind?, front?))
    })
}

/// Runs a program to its end; its own exit status is passed on.
pub fn run(command: &mut Command) -> Outcome {
    if BEHIND.get() {
        command.env("CARGO_TERM_QUIET", "true");
    }
    let status = command
        .status()
        .map_err(|error| cannot_start(command, &error))?;
    if status.success() {
        return Ok(());
    }
    let code = status
        .code()
        .and_then(|code| u8::try_from(code).ok())
        .unwrap_or(1);
    Err(Failure {
        code,
        message: String::new(),
    })
}

/// Runs a step whose failure needs a word about what failed; tells how long a long one took.
pub fn step(what: &str, command: &mut Command) -> Outcome {
    eprintln!("==> {what}");
    let start = Instant::now();
    run(command).map_err(|failure| Failure {
        message: format!("{what}: failed"),
        ..failure
    })?;
    let seconds = start.elapsed().as_secs();
    if seconds >= WORTH_TELLING_S {
        eprintln!("==> {what}: {seconds} s");
    }
    Ok(())
}

/// What a program prints, or nothing where it fails or does not exist.
pub fn output(program: impl AsRef<OsStr>, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program)
        .args(arguments)
        .stderr(Stdio::null())
        .output()
        .ok()?;
    output
        .status
        .success()
        .then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

fn cannot_start(command: &Command, error: &std::io::Error) -> Failure {
    Failure::new(format!(
        "cannot start {}: {error}",
        command.get_program().to_string_lossy()
    ))
}

/// The words of a call.
#[cfg(test)]
pub fn words(call: &str) -> Vec<String> {
    call.split_whitespace().map(str::to_owned).collect()
}
