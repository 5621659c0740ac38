//! Lists of words kept as one text, a word a line: no pointer and no length for each of them in flash.

/// The lines of a list, one after the other.
#[derive(Clone, Debug)]
pub struct Words(&'static str);

/// The lines of `list`, each of which ends with `'\n'`.
pub const fn words(list: &'static str) -> Words {
    Words(list)
}

impl Iterator for Words {
    type Item = &'static str;

    #[inline(never)]
    fn next(&mut self) -> Option<&'static str> {
        let end = self.0.bytes().position(|byte| byte == b'\n')?;
        let word = self.0.get(..end)?;
        self.0 = self.0.get(end + 1..)?;
        Some(word)
    }
}

/// The line with this number, counted from zero; empty behind the last one.
#[inline(never)]
pub fn word(list: &'static str, number: u8) -> &'static str {
    words(list).nth(usize::from(number)).unwrap_or("")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_is_found_and_none_behind_the_last() {
        let list = "idle\nstop it\n\nüben\n";
        assert!(words(list).eq(["idle", "stop it", "", "üben"]));
        assert_eq!(word(list, 0), "idle");
        assert_eq!(word(list, 3), "üben");
        assert_eq!(word(list, 4), "");
        assert_eq!(word("", 0), "");
    }
}
