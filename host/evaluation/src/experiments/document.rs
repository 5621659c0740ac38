//! Tables in the documentation, between markers, with the fingerprint of the code they describe.

use std::path::Path;

use palpate_document::section::{Markers, SectionError};

use super::calibration::Summary;
use super::effects;
use super::result::{Place, Row, headline, markdown};

/// Documents that hold tables, from the root of the checkout.
pub const DOCUMENTS: [&str; 2] = ["docs/RESULTS.md", "README.md"];

const TABLES: Markers = Markers {
    begin: "<!-- experiments: begin",
    end: "<!-- experiments: end -->",
};

/// The worlds of the rows, in their order.
fn places(rows: &[Row]) -> Vec<&Place> {
    let mut places: Vec<&Place> = Vec::new();
    for row in rows {
        if !places.contains(&&row.place) {
            places.push(&row.place);
        }
    }
    places
}

/// What goes between the markers of each document: all tables, world by world with what its guided calibrations came to, and the
/// headline table of the README.
#[must_use]
pub fn bodies(rows: &[Row], calibrations: &[(Place, Summary)]) -> [(&'static str, String); 2] {
    let paper = |row: &Row| {
        ["proximal", "distal", "preshape", "free", "random"].contains(&row.experiment.as_str())
    };
    let other = |row: &Row| {
        let scenes = [
            "tendon",
            "hidden",
            "return",
            "p70-preloaded",
            "linkage",
            "direct",
        ];
        scenes.iter().any(|scene| row.experiment.starts_with(scene))
    };
    let ablation = |row: &Row| row.experiment.starts_with("ablation");
    let effect = |row: &Row| row.experiment.starts_with(effects::BEGINS);
    let mut all = String::new();
    for place in places(rows) {
        let Place { world, engine } = place;
        let mut part = |title: &str, keep: &dyn Fn(&Row) -> bool| {
            let kept = rows.iter().filter(|row| row.place == *place && keep(row));
            let kept: Vec<Row> = kept.cloned().collect();
            if !kept.is_empty() {
                all += &format!(
                    "### World {world}, engine {engine}: {title}\n\n{}\n",
                    markdown(&kept)
                );
            }
        };
        part("the paper's experiments, prototype", &paper);
        part("other fingers", &other);
        part(
            "where the difference comes from\n\n\
             The distal grasps again; each line adds one thing to the line above.",
            &ablation,
        );
        part(
            "sensitivity\n\n20 distal contacts at each level, after the guided calibration.",
            &|row| !paper(row) && !other(row) && !ablation(row) && !effect(row),
        );
        part(
            "one effect at a time\n\n32 distal contacts with each, on four fingers, after the guided calibration with it.",
            &effect,
        );
        for (_, summary) in calibrations.iter().filter(|(other, _)| other == place) {
            all += &format!(
                "### World {world}, engine {engine}: calibration\n\n{}\n",
                summary.markdown()
            );
        }
    }
    let short: Vec<Row> = rows.iter().filter(|row| paper(row)).cloned().collect();
    [(DOCUMENTS[0], all), (DOCUMENTS[1], headline(&short))]
}

/// Replaces what stands between the markers.
///
/// # Errors
/// [`SectionError`].
pub fn write(path: &Path, fingerprint: &str, body: &str) -> Result<(), SectionError> {
    let told = format!(", written by `cargo xtask experiments --write`, code {fingerprint} -->");
    TABLES.write(path, &told, body)
}

/// The fingerprint that a document was written for.
///
/// # Errors
/// [`SectionError`].
pub fn described(path: &Path) -> Result<Option<String>, SectionError> {
    let section = TABLES.read(path)?;
    let line = section.lines().next().unwrap_or_default();
    Ok(line
        .split_whitespace()
        .skip_while(|word| *word != "code")
        .nth(1)
        .map(str::to_owned))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiments::result::Method;
    use crate::score::Trial;

    #[test]
    fn a_world_has_the_tables_that_were_run_and_no_others() {
        let place = |engine: &str| Place {
            world: "workshop".into(),
            engine: engine.into(),
        };
        let row = |engine: &str, name: &str| {
            Row::of(
                &place(engine),
                name,
                Method::Ours,
                true,
                &[Trial::default()],
            )
        };
        let rows = [
            row("plant", "free"),
            row("plant", "speed 0.1 rad/s"),
            row("plant", "effect: none"),
            row("mujoco", "free"),
        ];
        let calibrations = [(place("mujoco"), Summary::of(&[]))];
        let [(_, results), (_, readme)] = bodies(&rows, &calibrations);
        let headings: Vec<_> = results
            .lines()
            .filter_map(|line| line.strip_prefix("### World workshop, engine "))
            .collect();
        assert_eq!(
            headings,
            [
                "plant: the paper's experiments, prototype",
                "plant: sensitivity",
                "plant: one effect at a time",
                "mujoco: the paper's experiments, prototype",
                "mujoco: calibration",
            ]
        );
        assert!(readme.contains("| workshop | free |"));
        assert!(readme.contains("| workshop, MuJoCo | free |"));
        assert!(!readme.contains("speed"));
    }

    #[test]
    fn a_table_is_replaced_and_its_fingerprint_found() {
        let path = std::env::temp_dir().join(format!("palpate-document-{}.md", std::process::id()));
        std::fs::write(
            &path,
            format!("above\n{} -->\nold\n{}\nbelow\n", TABLES.begin, TABLES.end),
        )
        .unwrap();
        assert_eq!(described(&path).unwrap(), None);
        write(&path, "0123abcd", "| new |").unwrap();
        write(&path, "89abcdef", "| newer |").unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.starts_with("above\n") && text.ends_with("\nbelow\n"));
        assert!(text.contains("| newer |") && !text.contains("old"));
        assert_eq!(described(&path).unwrap().as_deref(), Some("89abcdef"));
        std::fs::write(&path, "no markers").unwrap();
        assert!(matches!(
            described(&path),
            Err(SectionError::NoMarkers { .. })
        ));
        std::fs::remove_file(&path).unwrap();
    }
}
