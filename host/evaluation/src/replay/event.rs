//! Events as the firmware's log has them.

use palpate::app::log;
use palpate::sensing::Event;
use serde_json::{Map, Value, json};

/// An event as name and fields, as the firmware's log has them; null what is not known.
#[must_use]
pub fn fields(event: &Event) -> (&'static str, Map<String, Value>) {
    let mut name = "";
    let mut map = Map::new();
    let write = |line: &'static log::Line, values: &[log::Value<'_>]| {
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
    };
    log::event(&mut log::Fields(write), event);
    (name, map)
}

/// An event as a log line: `name key=value key=value`.
#[must_use]
pub fn line(event: &Event) -> String {
    let (name, fields) = fields(event);
    let mut out = name.to_owned();
    for (key, value) in fields.iter().filter(|(_, value)| !value.is_null()) {
        match value {
            Value::String(text) => out.push_str(&format!(" {key}={text}")),
            value => out.push_str(&format!(" {key}={value}")),
        }
    }
    out
}
