//! `new-scene`: a file for your own finger.

use crate::firmware::{list, scenes};
use crate::process::{Failure, Outcome, root};

/// Folder of what all scenes share, beside them.
const COMMON: &str = "common";

/// Writes `scenes/NAME.toml`: a copy of another scene, then every default as a comment.
pub fn write(name: &str, from: &str) -> Outcome {
    let letter = |c: char| c.is_ascii_lowercase();
    let word = |c: char| letter(c) || c.is_ascii_digit() || c == '-';
    if !(name.starts_with(letter) && name.chars().all(word)) {
        return Err(Failure::usage(format!(
            "'{name}' cannot be a scene's name: it begins with a small letter and has small letters, digits and '-'"
        )));
    }
    if name == COMMON {
        return Err(Failure::usage(format!(
            "'{COMMON}' is the folder of what all scenes share: choose another name"
        )));
    }
    let known = scenes()?;
    if known.iter().any(|scene| scene == name) {
        return Err(Failure::usage(format!(
            "there is a scene '{name}' already: edit its file, scenes/{name}.toml, or choose another name"
        )));
    }
    if !known.iter().any(|scene| scene == from) {
        return Err(Failure::usage(format!(
            "there is no scene '{from}'; there are: {}",
            known.join(", ")
        )));
    }
    let folder = list::folder(&root());
    let path = folder.join(format!("{name}.toml"));
    let read = |file: &str| {
        let path = folder.join(file);
        std::fs::read_to_string(&path)
            .map_err(|error| Failure::new(format!("{}: {error}", path.display())))
    };
    let text = text(
        name,
        from,
        &read(&format!("{from}.toml"))?,
        &read("common/defaults.toml")?,
    );
    // A file that is there is somebody's finger.
    std::fs::File::create_new(&path)
        .and_then(|mut file| std::io::Write::write_all(&mut file, text.as_bytes()))
        .map_err(|error| Failure::new(format!("cannot write {}: {error}", path.display())))?;
    println!("{}", path.display());
    println!("edit it, then: cargo xtask sim --scene {name}");
    Ok(())
}

fn text(name: &str, from: &str, copied: &str, defaults: &str) -> String {
    let mut text = format!(
        "# A finger of your own, begun as a copy of {from}. A key that is left out takes the value of common/defaults.toml (all\n\
         # of them are below, as comments: uncomment a section's head and the keys to change). An unknown key or a value out\n\
         # of its range stops the build. Try it: cargo xtask sim --scene {name}; onto a board: cargo xtask flash --scene {name}\n\
         title = \"{name}\"\n"
    );
    // The other finger's own words are about the other finger.
    let own = |line: &&str| !line.starts_with("title") && !line.starts_with('#');
    for line in copied.lines().filter(own) {
        text += line;
        text.push('\n');
    }
    for line in defaults.lines().skip_while(|line| !line.starts_with('[')) {
        let heads = |section: &str| copied.lines().any(|line| line.starts_with(section));
        let section = line.split_inclusive(']').next().unwrap_or_default();
        text += &match line {
            "" => String::new(),
            _ if line.starts_with('[') && heads(section) => {
                format!("# more keys of {section} above:")
            }
            _ if line.starts_with('#') => line.to_owned(),
            _ => format!("# {line}"),
        };
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{text, write};

    /// Before anything is written.
    #[test]
    fn a_name_that_is_taken_is_refused_with_what_to_do() {
        for (name, remedy) in [
            ("common", "choose another name"),
            (
                "p70",
                "edit its file, scenes/p70.toml, or choose another name",
            ),
            ("Mine", "begins with a small letter"),
        ] {
            let refused = write(name, "p70").expect_err("refused");
            assert_eq!(refused.code, 2);
            assert!(refused.message.contains(remedy), "{}", refused.message);
        }
    }

    #[test]
    fn a_copy_keeps_its_keys_and_lists_the_defaults() {
        let text = text(
            "mine",
            "p70",
            "# of p70\ntitle = \"p70\"\n\n[finger] # two\nlength_m = [0.09, 0.07]\n",
            "# what it is\n\n[finger]\nhalf_thickness_m = 0.006\n\n[motor] # RE10\nresistance_ohm = 35.0 # I\n",
        );
        let rest = text.split_once("title = \"mine\"\n").expect("a title").1;
        assert_eq!(
            rest,
            "\n[finger] # two\nlength_m = [0.09, 0.07]\n# more keys of [finger] above:\n# half_thickness_m = 0.006\n\n\
             # [motor] # RE10\n# resistance_ohm = 35.0 # I\n"
        );
    }
}
