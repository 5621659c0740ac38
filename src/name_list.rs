//! Look-up of a name in a list that is kept as one text, one name a line.
//!
//! Faults, states, verbs and settings are declared once by macros, which join their names with `concat!`. One text needs no
//! table of pointers and lengths in flash.

/// The name with this number in `list`, counted from zero. Every name ends with `'\n'`; empty beyond the last one.
#[inline(never)]
pub fn nth(list: &'static str, number: u8) -> &'static str {
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
    fn every_name_is_found_and_none_beyond_the_last() {
        let list = "idle\nstop it\n\nüben\n";
        let found: Vec<&str> = (0..6).map(|number| nth(list, number)).collect();
        assert_eq!(found, ["idle", "stop it", "", "üben", "", ""]);
        assert_eq!(nth("", 0), "");
    }
}
