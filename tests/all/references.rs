//! References to documents lead somewhere: `docs/X.md#section` in sources, relative links in Markdown.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Folders that hold nothing of this project's own text.
const SKIPPED: &[&str] = &["target", ".git", "corpus", "artifacts", "recordings"];
/// What a source or a document is called.
const KINDS: &[&str] = &["rs", "toml", "md", "x", "sh", "yml"];

/// A text that a command copies elsewhere: its links start from there.
const TEMPLATE: (&str, &str) = ("host/report/src/report/intro.md", "docs/report");

/// A reference, as it stands in a file.
#[derive(Debug, PartialEq, Eq)]
struct Reference {
    line: usize,
    /// From the root of the checkout, or from the file's own folder where `relative`.
    path: String,
    section: Option<String>,
    relative: bool,
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    let entries = std::fs::read_dir(folder).expect("a readable folder");
    for entry in entries.map(|entry| entry.expect("a readable entry")) {
        let (path, name) = (entry.path(), entry.file_name());
        let name = name.to_string_lossy();
        if path.is_dir() {
            if !SKIPPED.contains(&&*name) {
                collect(&path, files);
            }
        } else if name
            .rsplit_once('.')
            .is_some_and(|(_, kind)| KINDS.contains(&kind))
        {
            files.push(path);
        }
    }
}

/// The anchors that GitHub gives to a document's headings.
fn anchors(text: &str) -> BTreeSet<String> {
    let mut anchors = BTreeSet::new();
    let mut in_code = false;
    for line in text.lines() {
        in_code ^= line.starts_with("```");
        let title = line.trim_start_matches('#');
        if in_code || title.len() == line.len() || !title.starts_with(' ') {
            continue;
        }
        let base: String = title
            .trim()
            .chars()
            .filter(|c| c.is_alphanumeric() || " -_".contains(*c))
            .map(|c| {
                if c == ' ' {
                    '-'
                } else {
                    c.to_ascii_lowercase()
                }
            })
            .collect();
        let mut anchor = base.clone();
        let mut again = 0;
        while !anchors.insert(anchor) {
            again += 1;
            anchor = format!("{base}-{again}");
        }
    }
    anchors
}

fn section_after(rest: &str) -> Option<String> {
    let rest = rest.strip_prefix('#')?;
    let end = rest
        .find(|c: char| !(c.is_alphanumeric() || "-_".contains(c)))
        .unwrap_or(rest.len());
    Some(rest[..end].to_owned())
}

/// `docs/X.md`, with or without a section, anywhere in a line.
fn mentioned(text: &str) -> Vec<Reference> {
    let mut found = Vec::new();
    for (number, line) in text.lines().enumerate() {
        for (start, _) in line.match_indices("docs/") {
            let before = &line[..start];
            let foreign = before.ends_with(|c: char| c.is_alphanumeric() || "/-_".contains(c));
            if foreign && !before.ends_with("../") {
                continue;
            }
            let rest = &line[start..];
            let end = rest
                .find(|c: char| !(c.is_ascii_alphanumeric() || "-_./".contains(c)))
                .unwrap_or(rest.len());
            let Some(length) = rest[..end].find(".md").map(|at| at + 3) else {
                continue;
            };
            found.push(Reference {
                line: number + 1,
                path: rest[..length].to_owned(),
                section: section_after(&rest[length..]),
                relative: false,
            });
        }
    }
    found
}

/// Links of a Markdown text to other files of the checkout, and within it.
fn linked(text: &str) -> Vec<Reference> {
    let mut found = Vec::new();
    for (number, line) in text.lines().enumerate() {
        for (start, _) in line.match_indices("](") {
            let rest = &line[start + 2..];
            let target = &rest[..rest.find([')', ' ']).unwrap_or(rest.len())];
            if target.contains("://") || target.starts_with("mailto:") {
                continue;
            }
            let (path, section) = match target.split_once('#') {
                Some((path, section)) => (path, Some(section.to_owned())),
                None => (target, None),
            };
            found.push(Reference {
                line: number + 1,
                path: path.to_owned(),
                section,
                relative: true,
            });
        }
    }
    found
}

/// Files of the checkout that a text names between backticks, as `src/x.rs`; patterns and placeholders are not files.
fn named_files(text: &str) -> Vec<(usize, String)> {
    let rooms = [
        "src/", "host/", "tests/", "bench/", "scenes/", "build/", ".github/", ".vscode/",
    ];
    let mut found = Vec::new();
    for (number, line) in text.lines().enumerate() {
        for word in line.split('`').skip(1).step_by(2) {
            let is_path = word
                .chars()
                .all(|c| c.is_ascii_alphanumeric() || "-_./".contains(c));
            let is_placeholder =
                word.chars().any(|c| c.is_ascii_uppercase()) && !word.ends_with(".md");
            if is_path && !is_placeholder && rooms.iter().any(|room| word.starts_with(room)) {
                found.push((number + 1, word.to_owned()));
            }
        }
    }
    found
}

/// Marks that name a document of the theory without saying where it is.
fn bare_marks(text: &str) -> Vec<usize> {
    let marks = [["HARD", "WARE"], ["MECH", "ANICS"], ["DES", "IGN.md"]].map(|mark| mark.concat());
    let section = ["MA", "TH "].concat();
    let bare = |line: &str| {
        let numbered = line.match_indices(&section).any(|(at, _)| {
            line[at + section.len()..].starts_with(|c: char| c.is_ascii_digit() || c == 'n')
        });
        let unnamed = marks.iter().any(|mark| {
            line.match_indices(mark.as_str())
                .any(|(at, _)| !line[..at].ends_with("docs/"))
        });
        numbered || unnamed
    };
    let lines = text.lines().enumerate();
    lines
        .filter(|(_, line)| bare(line))
        .map(|(number, _)| number + 1)
        .collect()
}

#[test]
fn every_reference_resolves() {
    let mut files = Vec::new();
    collect(root(), &mut files);
    let mut sections: BTreeMap<PathBuf, BTreeSet<String>> = BTreeMap::new();
    let (mut checked, mut broken) = (0, Vec::new());
    for file in &files {
        let name = file.strip_prefix(root()).expect("below the root").display();
        let text = std::fs::read_to_string(file).expect("text");
        let is_document = file.extension().is_some_and(|kind| kind == "md");
        let mut references = mentioned(&text);
        if is_document {
            references.extend(linked(&text));
            for (line, path) in named_files(&text) {
                checked += 1;
                let near = file.parent().expect("a folder").join(&path);
                let at = root().join(&path);
                if !(near.exists() || at.exists() || at.with_extension("rs").exists()) {
                    broken.push(format!("{name}:{line}: no {path}"));
                }
            }
        } else if !file.ends_with("tests/all/references.rs") {
            broken.extend(
                bare_marks(&text)
                    .iter()
                    .map(|line| format!("{name}:{line}: names no document and section")),
            );
        }
        if file.ends_with("tests/all/references.rs") {
            continue;
        }
        for reference in references {
            checked += 1;
            let folder = match file.parent() {
                _ if !reference.relative => root().to_owned(),
                _ if file.ends_with(TEMPLATE.0) => root().join(TEMPLATE.1),
                parent => parent.expect("a folder").to_owned(),
            };
            let target = if reference.path.is_empty() {
                file.clone()
            } else {
                folder.join(&reference.path)
            };
            let place = format!("{name}:{}", reference.line);
            if !target.exists() {
                broken.push(format!("{place}: no {}", reference.path));
                continue;
            }
            let Some(section) = reference.section else {
                continue;
            };
            let known = sections
                .entry(target.clone())
                .or_insert_with(|| anchors(&std::fs::read_to_string(&target).unwrap_or_default()));
            if !known.contains(&section) {
                broken.push(format!(
                    "{place}: {} has no section #{section}",
                    reference.path
                ));
            }
        }
    }
    println!("{checked} references checked in {} files", files.len());
    assert!(broken.is_empty(), "{}", broken.join("\n"));
    assert!(
        checked > 50,
        "only {checked} references found: the search itself is broken"
    );
}

#[test]
fn the_search_sees_what_it_should() {
    let seen = mentioned("/// K_c (docs/A.md#part-one), see docs/B.md.\nhttps://x.org/docs/C.md");
    assert_eq!(seen.len(), 2);
    assert_eq!(
        (seen[0].path.as_str(), seen[0].section.as_deref()),
        ("docs/A.md", Some("part-one"))
    );
    assert_eq!(
        (seen[1].path.as_str(), seen[1].section.as_deref()),
        ("docs/B.md", None)
    );
    let seen = linked("[a](b.md#c) and [d](https://e.f) and ![g](h.svg)");
    assert_eq!(seen.len(), 2);
    assert_eq!(seen[1].path, "h.svg");
    let seen = named_files("`src/a.rs` and `src/X.toml`, `scenes/*.toml`, src/b.rs");
    assert_eq!(seen, [(1, "src/a.rs".to_owned())]);
    let anchors = anchors("# A `b`, c\n## A b c\ntext # no\n```\n# code\n```\n");
    assert_eq!(
        anchors.into_iter().collect::<Vec<_>>(),
        ["a-b-c", "a-b-c-1"]
    );
    let marks = [
        ["/// (MA", "TH 5)"],
        ["// HARD", "WARE: why"],
        ["// docs/HARD", "WARE.md#marks"],
    ];
    assert_eq!(
        bare_marks(&marks.map(|mark| mark.concat()).join("\n")),
        [1, 2]
    );
}
