//! What the host programs share at the command line: how far they are ([`progress`]), their end, completions, help with examples, values
//! of options, errors of files.

pub mod progress;

use std::fmt::Display;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::CommandFactory;
pub use clap_complete::Shell;

/// How a program ends; an error is told first.
pub fn end<E: Display>(outcome: Result<(), E>) -> ExitCode {
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Prints the completions of a program for a shell.
pub fn complete<P: CommandFactory>(shell: Shell) {
    complete_to::<P>(shell, &mut std::io::stdout());
}

fn complete_to<P: CommandFactory>(shell: Shell, to: &mut impl Write) {
    let mut command = P::command();
    let mut name = command.get_name().to_owned();
    if shell == Shell::Bash {
        // For a name with a hyphen clap_complete (4.6) writes two spellings of each command, and offers no option. Bash meets the
        // function through `cargo xtask`, whatever its name.
        name = name.replace('-', "_");
    }
    clap_complete::generate(shell, &mut command, name, to);
}

/// The value of an option that `cargo xtask` carries out itself: it stands in the help of the program that does the rest, and the
/// program alone refuses it.
///
/// # Errors
/// Always; what to call instead.
pub fn by_xtask(value: &str) -> Result<PathBuf, String> {
    Err(format!(
        "this program alone does not write '{value}': `cargo xtask` and the same words do; --events leaves what it is made of"
    ))
}

/// Reads a whole number above 0.
///
/// # Errors
/// It is none; what is expected.
pub fn at_least_one(text: &str) -> Result<usize, String> {
    text.parse()
        .ok()
        .filter(|number| *number > 0)
        .ok_or_else(|| "a whole number from 1 on is expected".to_owned())
}

/// Tells that a file or folder of the user's cannot be written, and what to look at.
#[must_use]
pub fn cannot_write(path: &Path, error: &std::io::Error) -> String {
    let path = path.display();
    format!("cannot write {path}: {error}; does the folder exist, and may you write there?")
}

/// The commands of a program whose help shows no example; hidden ones need none.
///
/// For the programs' tests, which expect an empty list.
#[must_use]
pub fn without_example<P: CommandFactory>() -> Vec<String> {
    let program = P::command();
    program
        .get_subcommands()
        .filter(|command| {
            let help = command.get_after_help().map(ToString::to_string);
            !command.is_hide_set() && !help.is_some_and(|help| help.contains("Example"))
        })
        .map(|command| command.get_name().to_owned())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    #[command(name = "a-program")]
    enum Program {
        #[command(after_help = "Example:\n  program shown")]
        Shown,
        #[command(hide = true)]
        Hidden,
        Bare,
    }

    #[test]
    fn bash_completes_the_options_of_a_command() {
        let mut script = Vec::new();
        complete_to::<Program>(Shell::Bash, &mut script);
        script.extend(
            b"\nCOMP_WORDS=(a_program shown --h)\nCOMP_CWORD=2\n_a_program a_program --h shown\necho \"${COMPREPLY[*]}\"",
        );
        let script = String::from_utf8(script).expect("text");
        let Ok(output) = std::process::Command::new("bash")
            .args(["-c", &script])
            .output()
        else {
            eprintln!("there is no bash: nothing tested");
            return;
        };
        assert_eq!(
            String::from_utf8_lossy(&output.stdout).trim(),
            "--help",
            "{output:?}"
        );
    }

    #[test]
    fn a_command_without_an_example_is_found() {
        assert_eq!(without_example::<Program>(), ["bare"]);
    }
}
