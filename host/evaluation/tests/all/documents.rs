//! The tables in the documents describe the code that is there.

use palpate_evaluation::experiments::{document, fingerprint};

#[test]
fn tables_are_as_new_as_the_code() {
    let code = fingerprint::fingerprint().expect("the sources are there");
    for file in document::DOCUMENTS {
        let described = document::described(&fingerprint::root().join(file)).expect(file);
        assert_eq!(
            described.as_deref(),
            Some(code.as_str()),
            "the experiments' table in {file} is older than the code it describes; run: cargo xtask experiments --write"
        );
    }
}
