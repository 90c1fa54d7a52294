//! Messages as JSON objects, with a JSON schema.

use super::channel::Schema;
use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use schemars::transform::RecursiveTransform;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// The encoding's name.
pub const ENCODING: &str = "json";

/// A type's name in recordings.
pub fn schema_name<T: JsonSchema>() -> String {
    format!("tactus.{}", T::schema_name())
}

/// A type's schema, complete in itself: viewers follow no references.
pub fn schema<T: JsonSchema>() -> Schema {
    let settings = SchemaSettings::draft07()
        .with(|settings| settings.inline_subschemas = true)
        .with_transform(RecursiveTransform(list_names));
    let schema = settings.into_generator().into_root_schema_for::<T>();
    Schema { name: schema_name::<T>(), encoding: "jsonschema", data: schema.as_value().to_string().into_bytes() }
}

/// Turns a choice of names with a text each into a list of names: Foxglove finds no type in a choice.
fn list_names(schema: &mut schemars::Schema) {
    let choices = schema.get("oneOf").and_then(Value::as_array);
    let names: Option<Vec<Value>> =
        choices.and_then(|choices| choices.iter().map(|choice| choice.get("const").cloned()).collect());
    if let Some(names) = names {
        schema.remove("oneOf");
        schema.insert("type".to_owned(), "string".into());
        schema.insert("enum".to_owned(), names.into());
    }
}

/// Appends a message.
///
/// # Errors
/// It has no JSON.
pub fn encode<T: Serialize>(message: &T, bytes: &mut Vec<u8>) -> anyhow::Result<()> {
    Ok(serde_json::to_writer(bytes, message)?)
}

/// The message in these bytes.
///
/// # Errors
/// There is none.
pub fn decode<T: DeserializeOwned>(bytes: &[u8]) -> anyhow::Result<T> {
    Ok(serde_json::from_slice(bytes)?)
}
