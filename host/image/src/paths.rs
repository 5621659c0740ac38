//! Text in an image that tells of the machine that built it.

/// Parts of paths below which compilers keep sources and users their files: what is searched for, on whatever machine.
const MACHINE_FOLDERS: &[&str] = &[
    "registry/src/",
    "rustlib/src/",
    "/root/",
    "/home/",
    "/Users/",
    "/target/",
];

/// Paths of the building machine among other bytes, up to the end of the text.
pub fn machine_paths(bytes: &[u8]) -> Vec<String> {
    bytes
        .split(|byte| !(b' '..=b'~').contains(byte))
        .map(String::from_utf8_lossy)
        .filter_map(|text| {
            let at = MACHINE_FOLDERS
                .iter()
                .filter_map(|folder| text.find(folder))
                .min()?;
            text.get(at..).map(str::to_owned)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::machine_paths;

    #[test]
    fn paths_of_the_building_machine_among_other_text() {
        let bytes = b"rad/ssrc/board/mod.rs\0okok/home/me/.cargo/registry/src/i/a-1.0/src/lib.rs\x01/rustc/1/library";
        assert_eq!(
            machine_paths(bytes),
            ["/home/me/.cargo/registry/src/i/a-1.0/src/lib.rs"]
        );
    }
}
