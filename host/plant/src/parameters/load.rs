//! A user's file laid over the defaults.

use super::{DEFAULT_TOML, Parameters};
use crate::Error;
use toml::{Table, Value};

impl Parameters {
    /// Reads a TOML text; what it does not mention keeps its default.
    ///
    /// # Errors
    /// [`Error`]: not TOML, an unknown key, a value of the wrong kind or out of its range.
    pub fn from_toml(text: &str) -> Result<Self, Error> {
        let mut merged: Table = DEFAULT_TOML.parse().map_err(syntax)?;
        let user: Table = text.parse().map_err(syntax)?;
        overlay(&mut merged, user, "")?;
        let parameters: Self = Value::Table(merged).try_into().map_err(syntax)?;
        parameters.validate()?;
        Ok(parameters)
    }
}

fn syntax(error: toml::de::Error) -> Error {
    Error::Syntax(error.to_string())
}

fn overlay(base: &mut Table, user: Table, path: &str) -> Result<(), Error> {
    for (name, value) in user {
        let key = if path.is_empty() {
            name.clone()
        } else {
            format!("{path}.{name}")
        };
        let Some(slot) = base.get_mut(&name) else {
            let expected = base.keys().cloned().collect::<Vec<_>>().join(", ");
            return Err(Error::UnknownKey { key, expected });
        };
        match (slot, value) {
            (Value::Table(inner), Value::Table(user)) => overlay(inner, user, &key)?,
            (slot @ Value::Float(_), value) => *slot = number(value, &key)?,
            (slot @ Value::Array(_), Value::Array(list)) => {
                let numbers = list
                    .into_iter()
                    .enumerate()
                    .map(|(i, v)| number(v, &format!("{key}[{i}]")));
                *slot = Value::Array(numbers.collect::<Result<_, _>>()?);
            }
            (slot, value) => {
                return Err(Error::WrongType {
                    key,
                    found: value.type_str(),
                    expected: slot.type_str(),
                });
            }
        }
    }
    Ok(())
}

/// A number, written with or without a point.
fn number(value: Value, key: &str) -> Result<Value, Error> {
    match value {
        Value::Float(_) => Ok(value),
        #[expect(clippy::cast_precision_loss, reason = "parameters are far below 2^53")]
        Value::Integer(integer) => Ok(Value::Float(integer as f64)),
        other => Err(Error::WrongType {
            key: key.to_owned(),
            found: other.type_str(),
            expected: "a number",
        }),
    }
}
