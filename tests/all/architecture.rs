//! Imports between rooms are those of the table in docs/ARCHITECTURE.md, and every room stands there.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

const PAGE: &str = include_str!("../../docs/ARCHITECTURE.md");

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Names between backticks.
fn quoted(cell: &str) -> impl Iterator<Item = String> + '_ {
    cell.split('`').skip(1).step_by(2).map(str::to_owned)
}

/// Room to the rooms it may import.
fn table(page: &str) -> BTreeMap<String, BTreeSet<String>> {
    let rows = page.lines().filter_map(|line| {
        let cells: Vec<&str> = line.trim_matches('|').split('|').collect();
        let [room, _, imports] = cells[..] else {
            return None;
        };
        let room = quoted(room).next()?;
        let is_room = ["src/", "host/", "bench"]
            .iter()
            .any(|start| room.starts_with(start));
        is_room.then(|| (room, quoted(imports).collect()))
    });
    rows.collect()
}

fn sources(at: &Path, found: &mut Vec<PathBuf>) {
    if at.is_dir() {
        for entry in std::fs::read_dir(at).expect("a readable folder") {
            sources(&entry.expect("a readable entry").path(), found);
        }
    } else if at.extension().is_some_and(|kind| kind == "rs") {
        found.push(at.to_path_buf());
    }
}

/// The text without comments and without the unit tests at its end.
fn code(text: &str) -> String {
    let text = text.split("mod tests {").next().unwrap_or_default();
    let lines = text
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"));
    lines.collect::<Vec<_>>().join("\n")
}

/// First names after `prefix::`, with those of a group in braces.
fn imports(code: &str, prefix: &str) -> BTreeSet<String> {
    let path = format!("{prefix}::");
    let name = |text: &str| -> String {
        text.chars()
            .take_while(|c| c.is_ascii_alphanumeric() || *c == '_')
            .collect()
    };
    let mut found = BTreeSet::new();
    for (at, _) in code.match_indices(&path) {
        if code[..at].ends_with(|c: char| c.is_alphanumeric() || "_:$".contains(c)) {
            continue;
        }
        let rest = &code[at + path.len()..];
        let Some(group) = rest.strip_prefix('{') else {
            found.insert(name(rest));
            continue;
        };
        let mut depth = 0;
        let mut begins = true;
        for (at, c) in group.char_indices() {
            match c {
                '{' => depth += 1,
                '}' if depth == 0 => break,
                '}' => depth -= 1,
                ',' if depth == 0 => begins = true,
                _ if begins && depth == 0 && !c.is_whitespace() => {
                    found.insert(name(&group[at..]));
                    begins = false;
                }
                _ => {}
            }
        }
    }
    found.remove("");
    found
}

/// A room of `src/`: its file or folder, its name.
fn rooms() -> Vec<(String, Vec<PathBuf>)> {
    let mut rooms: BTreeMap<String, Vec<PathBuf>> = BTreeMap::new();
    for entry in std::fs::read_dir(root().join("src")).expect("src") {
        let path = entry.expect("a readable entry").path();
        let name = path
            .file_stem()
            .expect("a name")
            .to_string_lossy()
            .into_owned();
        if name != "lib" {
            sources(&path, rooms.entry(name).or_default());
        }
    }
    rooms.into_iter().collect()
}

/// What a room's code imports, of the names that are rooms.
fn imported(files: &[PathBuf], known: &BTreeSet<String>) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for file in files {
        let in_tests = file.components().any(|part| {
            let part = part.as_os_str();
            part == "tests" || part == "tests.rs" || part == "testing.rs"
        });
        if in_tests && file.starts_with(root().join("src")) {
            continue;
        }
        let code = code(&std::fs::read_to_string(file).expect("text"));
        for prefix in ["crate", "palpate"] {
            found.extend(imports(&code, prefix).intersection(known).cloned());
        }
    }
    found
}

/// Crates of this repository that a manifest depends on, as rooms.
fn dependencies(manifest: &str) -> BTreeSet<String> {
    let mut section = "";
    let mut found = BTreeSet::new();
    for line in manifest.lines() {
        if line.starts_with('[') {
            section = line;
        }
        let Some((name, _)) = line.split_once(['=', '.']) else {
            continue;
        };
        let counts = section.contains("dependencies") && !section.contains("dev-dependencies");
        let name = name.trim().trim_matches('"');
        if counts && (name == "palpate" || name.starts_with("palpate-")) {
            found.insert(match name.strip_prefix("palpate-") {
                None => "palpate".to_owned(),
                Some("bench") => "bench".to_owned(),
                Some(other) => format!("host/{other}"),
            });
        }
    }
    found
}

#[test]
fn rooms_import_what_the_table_allows() {
    let table = table(PAGE);
    let rooms = rooms();
    let known: BTreeSet<String> = rooms.iter().map(|(name, _)| name.clone()).collect();
    let mut wrong = Vec::new();
    let mut judge = |room: String, imports: BTreeSet<String>| match table.get(&room) {
        None => wrong.push(format!("{room} is not in the table")),
        Some(allowed) => wrong.extend(
            imports
                .difference(allowed)
                .map(|import| format!("{room} must not import {import}")),
        ),
    };
    let mut found = 0;
    for (name, files) in &rooms {
        let mut imports = imported(files, &known);
        imports.remove(name);
        found += imports.len();
        judge(format!("src/{name}"), imports);
    }
    let hosts = std::fs::read_dir(root().join("host")).expect("host");
    let hosts = hosts.map(|entry| entry.expect("a readable entry").path());
    for folder in hosts.chain([root().join("bench")]) {
        let Ok(manifest) = std::fs::read_to_string(folder.join("Cargo.toml")) else {
            continue;
        };
        let room = folder.strip_prefix(root()).expect("below the root");
        let imports = dependencies(&manifest);
        found += imports.len();
        judge(room.to_string_lossy().into_owned(), imports);
    }
    for room in table.keys() {
        let here = root().join(room);
        if !here.exists() && !here.with_extension("rs").exists() {
            wrong.push(format!("{room} is in the table and nowhere else"));
        }
    }
    println!("{found} imports between {} rooms", table.len());
    assert!(
        wrong.is_empty(),
        "docs/ARCHITECTURE.md: {}",
        wrong.join("; ")
    );
    assert!(
        found > 20,
        "only {found} imports found: the search itself is broken"
    );
}

#[test]
fn the_search_sees_what_it_should() {
    let text = "//! crate::comment\nuse crate::{a::{b, c}, d};\nlet e = crate::f::g();\nnot_crate::h;\n#[cfg(test)]\nmod tests { use crate::i; }";
    let found: Vec<String> = imports(&code(text), "crate").into_iter().collect();
    assert_eq!(found, ["a", "d", "f"]);
    let manifest = "[dependencies]\npalpate = { path = \"x\" }\npalpate-plant.path = \"y\"\n[dev-dependencies]\npalpate-bench = \"1\"";
    let found: Vec<String> = dependencies(manifest).into_iter().collect();
    assert_eq!(found, ["host/plant", "palpate"]);
    let rows =
        table("| room | x | y |\n|---|---|---|\n| `src/a` | text | `b`, `c` |\n| `d` | e | f |");
    assert_eq!(rows.len(), 1);
    assert_eq!(rows["src/a"].len(), 2);
}

/// `13K` or `0x2000_3400` as a number.
fn number(text: &str) -> u64 {
    let text = text.trim().replace('_', "");
    match (text.strip_prefix("0x"), text.strip_suffix('K')) {
        (Some(digits), _) => u64::from_str_radix(digits, 16).expect("a hexadecimal number"),
        (_, Some(digits)) => 1024 * digits.parse::<u64>().expect("a number"),
        _ => text.parse().expect("a number"),
    }
}

#[test]
fn the_memory_map_is_that_of_the_linker() {
    let script = include_str!("../../memory.x");
    let (_, regions) = script.split_once("MEMORY\n{").expect("regions");
    let (regions, _) = regions.split_once('}').expect("an end");
    let mut compared = 0;
    for region in regions.lines().filter(|line| line.contains("ORIGIN")) {
        let (_, origin) = region.split_once("ORIGIN =").expect("an origin");
        let (origin, length) = origin.split_once(", LENGTH =").expect("a length");
        // The bench's image has another length, before the colon.
        let length = length.rsplit(':').next().expect("a length");
        let origin = number(origin);
        // Code in CCM SRAM runs at one address and is written at another.
        let alias = if origin >> 28 == 1 {
            origin - 0x1000_0000 + 0x2000_5800
        } else {
            origin
        };
        let hex = format!("{alias:08x}");
        let row = format!(
            "| `0x{}_{}` | {} KiB |",
            &hex[..4],
            &hex[4..].to_uppercase(),
            number(length) as f64 / 1024.0
        );
        assert!(PAGE.contains(&row), "docs/ARCHITECTURE.md lacks {row}");
        compared += 1;
    }
    assert!(compared >= 5, "only {compared} regions");
}

/// A file that `main.rs` does not name is not compiled, and its tests pass unseen.
#[test]
fn every_test_file_is_a_module() {
    for package in ["", "host/emulator", "host/evaluation", "host/simulation"] {
        let folder = root().join(package).join("tests/all");
        let main = std::fs::read_to_string(folder.join("main.rs")).expect("text");
        for entry in std::fs::read_dir(&folder).expect("a folder") {
            let path = entry.expect("a readable entry").path();
            let name = path.file_stem().expect("a name").to_string_lossy();
            assert!(
                name == "main" || main.lines().any(|line| line == format!("mod {name};")),
                "{}",
                path.display()
            );
        }
    }
}
