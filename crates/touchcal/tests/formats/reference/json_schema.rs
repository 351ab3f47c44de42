//! JSON Schemas, for editors.

use serde_json::{Map, Value as Json, json};

use super::keys::{Key, Keys, Value};

/// The schema (draft 2020-12) of a file whose root is this table.
pub fn text(keys: &Keys, root: &str) -> String {
    let mut used = vec![root.to_owned()];
    let mut next = 0;
    while next < used.len() {
        let table = used[next].clone();
        next += 1;
        for key in keys.of(&table) {
            let mut value = &key.value;
            while let Value::List(inner, _) = value {
                value = inner;
            }
            if let Value::Table(name) = value
                && !used.contains(name)
            {
                used.push(name.clone());
            }
        }
    }
    let tables: Map<String, Json> = used.iter().map(|name| (name.clone(), table(keys.of(name)))).collect();
    let schema = json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$ref": format!("#/$defs/{root}"),
        "$defs": tables,
    });
    serde_json::to_string_pretty(&schema).unwrap() + "\n"
}

fn table(keys: &[Key]) -> Json {
    let properties: Map<String, Json> = keys.iter().map(|key| (key.name.clone(), property(key))).collect();
    let required: Vec<&str> = keys.iter().filter(|key| key.is_required).map(|key| key.name.as_str()).collect();
    json!({ "type": "object", "properties": properties, "required": required, "additionalProperties": false })
}

fn property(key: &Key) -> Json {
    let mut found = value(&key.value);
    let default = key.default.as_ref().map(|default| format!(" Without it: {default}."));
    let example = key.example.as_ref().map(|example| format!(" Example: {example}"));
    let description = format!("{}{}{}", key.meaning, default.unwrap_or_default(), example.unwrap_or_default());
    found["description"] = description.into();
    found
}

fn value(value: &Value) -> Json {
    match value {
        Value::Number => json!({ "type": "number" }),
        Value::Integer => json!({ "type": "integer" }),
        Value::Text => json!({ "type": "string" }),
        Value::Flag => json!({ "type": "boolean" }),
        Value::FlagOrTexts => {
            json!({ "anyOf": [{ "type": "boolean" }, { "type": "array", "items": { "type": "string" } }] })
        }
        Value::OneOf(names) => json!({ "enum": names }),
        Value::List(inner, None) => json!({ "type": "array", "items": self::value(inner) }),
        Value::List(inner, Some(length)) => {
            json!({ "type": "array", "items": self::value(inner), "minItems": length, "maxItems": length })
        }
        Value::Texts => json!({ "type": "object", "additionalProperties": { "type": "string" } }),
        Value::Table(name) => json!({ "$ref": format!("#/$defs/{name}") }),
    }
}

/// Whether a TOML value is one of this kind.
pub fn accepts(keys: &Keys, expected: &Value, found: &toml::Value) -> bool {
    use toml::Value as Toml;
    let each = |list: &[Toml], inner: &Value| list.iter().all(|entry| accepts(keys, inner, entry));
    match (expected, found) {
        (Value::Number, Toml::Integer(_) | Toml::Float(_)) | (Value::Integer, Toml::Integer(_)) => true,
        (Value::Text, Toml::String(_)) => true,
        (Value::Flag | Value::FlagOrTexts, Toml::Boolean(_)) => true,
        (Value::FlagOrTexts, Toml::Array(list)) => each(list, &Value::Text),
        (Value::OneOf(names), Toml::String(name)) => names.contains(name),
        (Value::List(inner, length), Toml::Array(list)) => {
            length.is_none_or(|length| length == list.len()) && each(list, inner)
        }
        (Value::Texts, Toml::Table(table)) => table.values().all(Toml::is_str),
        (Value::Table(name), Toml::Table(table)) => {
            let known = keys.of(name);
            let is_known = |(name, value): (&String, &Toml)| {
                known.iter().any(|key| key.name == *name && accepts(keys, &key.value, value))
            };
            table.iter().all(is_known) && known.iter().all(|key| !key.is_required || table.contains_key(&key.name))
        }
        _ => false,
    }
}
