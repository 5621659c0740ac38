//! Lists of words kept as one text, a word a line: no pointer and no length for each of them in flash.

/// The line of `list` with this number, counted from zero; each ends with `'\n'`. Empty behind the last one.
#[inline(never)]
pub fn word(list: &'static str, number: u8) -> &'static str {
    let (mut left, mut start) = (number, 0);
    for (end, byte) in list.bytes().enumerate() {
        if byte == b'\n' {
            if left == 0 {
                return list.get(start..end).unwrap_or("");
            }
            left -= 1;
            start = end + 1;
        }
    }
    ""
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_is_found_and_none_behind_the_last() {
        let list = "idle\nstop it\n\nüben\n";
        let found: Vec<&str> = (0..6).map(|number| word(list, number)).collect();
        assert_eq!(found, ["idle", "stop it", "", "üben", "", ""]);
        assert_eq!(word("", 0), "");
    }
}
