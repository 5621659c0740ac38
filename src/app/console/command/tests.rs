//! What is understood, and what is answered to anything else.

use super::*;
use proptest::prelude::*;

fn parse(text: &str) -> Result<Option<Command>, CommandError> {
    Command::parse(text.as_bytes())
}

#[test]
fn every_command_of_the_table_is_understood() {
    for verb in Verb::ALL {
        let (name, usage) = (verb.name(), verb.usage());
        let line = match usage {
            "" => name.to_owned(),
            "NAME VALUE" => format!("{name} closing-speed 0.3"),
            "on [N] | off" => format!("{name} on 40"),
            _ => format!("{name} 40"),
        };
        assert!(matches!(parse(&line), Ok(Some(_))), "{line}");
        assert!(matches!(parse(&line.to_uppercase()), Ok(Some(_))), "{line}");
        let command = format!("{:?}", parse(&line)).to_lowercase();
        assert!(command.starts_with(&format!("ok(some({}", name.replace('-', ""))));
        let excess = parse(&format!("{line} mm what"));
        assert_eq!(excess.is_ok(), name == "stop", "{line}: {excess:?}");
    }
}

#[test]
fn units_may_be_joined_apart_or_left_out() {
    for line in [
        "calibrate 40",
        "calibrate 40mm",
        "calibrate 40 mm",
        " calibrate\t40 MM ",
    ] {
        assert_eq!(
            parse(line),
            Ok(Some(Command::Calibrate(Calibrate::At { k_m: 40.0 * 1e-3 }))),
            "{line}"
        );
    }
    assert_eq!(
        parse("set current-limit 150 mA"),
        Ok(Some(Command::Set(Setting::CurrentLimit, 150.0 * 1e-3)))
    );
    assert_eq!(
        parse("set mounting -90 deg"),
        Ok(Some(Command::Set(
            Setting::Mounting,
            -90.0 * Setting::Mounting.range().unit_si
        )))
    );
    assert_eq!(
        parse("calibrate cable"),
        Ok(Some(Command::Calibrate(Calibrate::Cable)))
    );
    assert_eq!(
        parse("calibrate forget"),
        Ok(Some(Command::Calibrate(Calibrate::Forget)))
    );
}

#[test]
fn samples_are_streamed_whole_or_thinned() {
    for (line, every) in [("trace on", 1), ("trace on 10", 10), ("trace off", 0)] {
        assert_eq!(parse(line), Ok(Some(Command::Trace(every))), "{line}");
    }
    for line in [
        "trace",
        "trace 1",
        "trace on 0",
        "trace on 1.5",
        "trace on 1001",
        "trace on x",
    ] {
        let error = parse(line).expect_err(line);
        assert!(
            error.to_string().starts_with("expected on,"),
            "{line}: {error}"
        );
    }
}

#[test]
fn wrong_lines_are_told_what_was_expected() {
    for (line, answer) in [
        ("halt", "no such command; try help"),
        ("set", "expected NAME VALUE"),
        ("set speed 3", "no such setting; try show"),
        ("set closing-speed", "expected a number after the name"),
        ("set closing-speed fast", "expected a number after the name"),
        (
            "set closing-speed 0.3 mA",
            "expected a number after the name",
        ),
        (
            "set closing-speed 3",
            "closing-speed must be 0.05 to 0.8 rad/s",
        ),
        (
            "set closing-speed 0.3 rad/s now",
            "too many words; expected NAME VALUE",
        ),
        ("calibrate", "expected a place in mm, cable or forget"),
        ("calibrate 1e9", "expected a place in mm, cable or forget"),
        (
            "calibrate -5",
            "the place must be 1 to 500 mm from the joint",
        ),
        (
            "calibrate 501",
            "the place must be 1 to 500 mm from the joint",
        ),
        ("open wide", "this command takes nothing"),
        ("\u{fc}ben", "no such command; try help"),
    ] {
        let error = parse(line).expect_err(line);
        assert_eq!(error.to_string(), answer, "{line}");
    }
    assert_eq!(Command::parse(&[0xff, b'a']), Err(CommandError::NotALine));
    let most = format!("of at most {LINE_MAX} bytes");
    assert!(CommandError::NotALine.to_string().ends_with(&most));
    assert_eq!(
        Command::parse(&[b' '; LINE_MAX + 1]),
        Err(CommandError::NotALine)
    );
    assert_eq!(parse("   "), Ok(None));
}

proptest! {
    #[test]
    fn any_line_is_answered(line in proptest::collection::vec(any::<u8>(), 0..200)) {
        let _ = Command::parse(&line);
    }
}

#[test]
fn digits_are_a_number() {
    assert_eq!((whole("70"), whole("5"), whole("131")), (70.0, 5.0, 131.0));
}
