//! Completions of `cargo xtask`: its commands, and behind a command the options of the program that does the work.

use crate::commands::host_program;
use crate::host;
use crate::process::{Failure, Outcome};

/// The programs with options, each with its commands.
const PROGRAMS: &[(&str, &[&str])] = &[
    (host::EMULATOR, &["sim", "faults"]),
    (
        host::EVALUATION,
        &[
            "experiments",
            "replay",
            "recordings",
            "false-contacts",
            "figures",
        ],
    ),
    ("palpate-monitor", &["monitor", "record"]),
];

/// What bash calls for the word `cargo`: the completions of before, unless the next word is `xtask`. `COMMANDS` and `CASES` are
/// written into it.
const BASH: &str = r#"
_palpate_before=$(complete -p cargo 2>/dev/null | sed -n 's/.* -F \([^ ]*\) .*/\1/p')
[[ $_palpate_before == _palpate_xtask ]] && _palpate_before=
_palpate_xtask() {
    local program command
    if [[ ${COMP_WORDS[1]} != xtask ]]; then
        [[ -n $_palpate_before ]] && "$_palpate_before" "$@"
        return
    fi
    if (( COMP_CWORD == 2 )); then
        COMPREPLY=($(compgen -W "COMMANDS" -- "${COMP_WORDS[2]}"))
        return
    fi
    case ${COMP_WORDS[2]} in
CASES        *) return ;;
    esac
    COMP_WORDS=("$program" "$command" "${COMP_WORDS[@]:3}")
    (( COMP_CWORD -= 1 ))
    "_$program" "$program" "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD - 1]}"
}
complete -F _palpate_xtask -o bashdefault -o default cargo
"#;

/// Prints them: for bash of `cargo xtask` itself, for other shells of the programs in `target/host`.
pub fn print(commands: &[&str], arguments: &[String]) -> Outcome {
    let Some((shell, [])) = arguments.split_first() else {
        return Err(Failure::usage(
            "completions needs a shell: bash, zsh, fish, elvish or powershell",
        ));
    };
    let words = ["completions".to_owned(), shell.clone()];
    for (package, _) in PROGRAMS {
        host_program(package, &words)?;
    }
    if shell == "bash" {
        print!("{}", bash(commands));
    }
    Ok(())
}

fn bash(commands: &[&str]) -> String {
    let mut cases = String::new();
    for (program, theirs) in PROGRAMS {
        for command in *theirs {
            // The name of the program's function in bash, see host/cli.
            let name = program.replace('-', "_");
            cases += &format!("        {command}) program={name} command={command} ;;\n");
        }
    }
    BASH.replace("COMMANDS", &commands.join(" "))
        .replace("CASES", &cases)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::Command;

    /// What bash offers for the last of these words; the programs' own completions are stood in for.
    fn offered(words: &[&str]) -> Option<String> {
        let quoted: Vec<String> = words.iter().map(|word| format!("'{word}'")).collect();
        let script = format!(
            "_before() {{ COMPREPLY=(build); }}\ncomplete -F _before cargo\n\
             _palpate_monitor() {{ COMPREPLY=(\"$1:${{COMP_WORDS[1]}}:$2:$3\"); }}\n{}\n\
             COMP_WORDS=({})\nCOMP_CWORD={}\n_palpate_xtask cargo\necho \"${{COMPREPLY[*]}}\"",
            bash(&["sim", "size", "test"]),
            quoted.join(" "),
            words.len() - 1
        );
        let output = Command::new("bash").args(["-c", &script]).output().ok()?;
        assert!(output.stderr.is_empty(), "{output:?}");
        Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
    }

    #[test]
    fn bash_offers_commands_and_hands_options_to_their_program() {
        let Some(commands) = offered(&["cargo", "xtask", "si"]) else {
            eprintln!("there is no bash: nothing tested");
            return;
        };
        assert_eq!(commands, "sim size");
        let monitor = offered(&["cargo", "xtask", "monitor", "--from", "si"]);
        assert_eq!(
            monitor.as_deref(),
            Some("palpate_monitor:monitor:si:--from")
        );
        let nothing = offered(&["cargo", "xtask", "test", "--"]);
        assert_eq!(nothing.as_deref(), Some(""));
        // Cargo's own completions are still there.
        let build = offered(&["cargo", "bu"]);
        assert_eq!(build.as_deref(), Some("build"));
    }
}
