//! Markdown tables.

/// The first two lines of a table; the columns' names are separated by bars.
#[must_use]
pub fn head(columns: &str) -> String {
    let rule = "|---".repeat(columns.split('|').count());
    format!("| {columns} |\n{rule}|\n")
}

#[cfg(test)]
mod tests {
    use super::head;

    #[test]
    fn every_column_is_ruled() {
        assert_eq!(head("a | b"), "| a | b |\n|---|---|\n");
        assert_eq!(head(" | b |"), "|  | b | |\n|---|---|---|\n");
    }
}
