//! Events as the firmware's log has them.

use palpate::app::log;
use palpate::sensing::{Event, Followed, Object};
use serde_json::{Map, Value, json};

/// Name and fields of what is written to a log; null what is not known.
fn written(write: impl FnOnce(&mut dyn FnMut(&'static log::Line, &[log::Value<'_>]))) -> Fields {
    let mut name = "";
    let mut map = Map::new();
    write(&mut |line, values| {
        name = line.name();
        let values = values.iter().map(|value| match *value {
            log::Value::Number(number) if number.is_finite() => {
                json!((f64::from(number) * 1e4).round() / 1e4)
            }
            log::Value::Number(_) => Value::Null,
            log::Value::Count(count) => json!(count),
            log::Value::Flag(flag) => json!(flag),
            log::Value::Text(text) => json!(text),
        });
        map.extend(line.keys.iter().map(ToString::to_string).zip(values));
    });
    (name, map)
}

/// Name and fields of an event.
pub type Fields = (&'static str, Map<String, Value>);

/// An event as name and fields, as the firmware's log has them; null what is not known.
#[must_use]
pub fn fields(event: &Event) -> Fields {
    written(|line| log::event(&mut log::Fields(line), event))
}

/// The same of what follows the first contact.
#[must_use]
pub fn followed_fields(event: &Followed) -> Fields {
    written(|line| log::followed(&mut log::Fields(line), event))
}

/// The same of how stiff an object is.
#[must_use]
pub fn object_fields(object: &Object) -> Fields {
    written(|line| log::object(&mut log::Fields(line), object))
}

/// An event as a log line: `name key=value key=value`.
#[must_use]
pub fn line((name, fields): &Fields) -> String {
    let mut out = (*name).to_owned();
    for (key, value) in fields.iter().filter(|(_, value)| !value.is_null()) {
        match value {
            Value::String(text) => out.push_str(&format!(" {key}={text}")),
            value => out.push_str(&format!(" {key}={value}")),
        }
    }
    out
}
