//! What the host programs share at the command line: how far they are ([`progress`]), completions, help with examples.

pub mod progress;

use std::path::PathBuf;

use clap::CommandFactory;
pub use clap_complete::Shell;

/// Prints the completions of a program for a shell.
pub fn complete<P: CommandFactory>(shell: Shell) {
    let mut command = P::command();
    let name = command.get_name().to_owned();
    clap_complete::generate(shell, &mut command, name, &mut std::io::stdout());
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
    enum Program {
        #[command(after_help = "Example:\n  program shown")]
        Shown,
        #[command(hide = true)]
        Hidden,
        Bare,
    }

    #[test]
    fn a_command_without_an_example_is_found() {
        assert_eq!(without_example::<Program>(), ["bare"]);
    }
}
