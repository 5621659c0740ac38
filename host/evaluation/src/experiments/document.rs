//! Tables in the documentation, between markers, with the fingerprint of the code they describe.

use std::path::Path;

use palpate_document::section::{Markers, SectionError};

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

/// What goes between the markers of each document: all tables, world by world, and the headline table of the README.
#[must_use]
pub fn bodies(rows: &[Row]) -> [(&'static str, String); 2] {
    let paper = |row: &Row| {
        ["proximal", "distal", "preshape", "free", "random"].contains(&row.experiment.as_str())
    };
    let other =
        |row: &Row| row.experiment.starts_with("tendon") || row.experiment.starts_with("linkage");
    let ablation = |row: &Row| row.experiment.starts_with("ablation");
    let mut all = String::new();
    for place in places(rows) {
        let pick = |keep: &dyn Fn(&Row) -> bool| -> String {
            let kept = rows.iter().filter(|row| row.place == *place && keep(row));
            markdown(&kept.cloned().collect::<Vec<_>>())
        };
        let Place { world, engine } = place;
        all += &format!(
            "### World {world}, engine {engine}: the paper's experiments, prototype\n\n{}\n\
             ### World {world}, engine {engine}: other fingers\n\n{}\n\
             ### World {world}, engine {engine}: where the difference comes from\n\n\
             The distal grasps again; each line adds one thing to the line above.\n\n{}\n\
             ### World {world}, engine {engine}: sensitivity\n\n\
             20 distal contacts at each level, after the guided calibration.\n\n{}\n",
            pick(&paper),
            pick(&other),
            pick(&ablation),
            pick(&|row| !paper(row) && !other(row) && !ablation(row)),
        );
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
