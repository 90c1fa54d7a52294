//! The published JSON schema of scene files.

use super::format::SceneFile;

/// The schema, as `docs/scene.schema.json` has it.
pub fn text() -> String {
    let schema = schemars::schema_for!(SceneFile);
    serde_json::to_string_pretty(&schema).expect("a schema is JSON") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    const PUBLISHED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/scene.schema.json");

    #[test]
    fn the_published_schema_is_the_one_of_the_code() {
        let published = std::fs::read_to_string(PUBLISHED).unwrap_or_default();
        assert!(published == text(), "run: tactus scenes --schema > docs/scene.schema.json");
    }

    #[test]
    fn every_field_and_shape_says_what_it_is() {
        let schema: serde_json::Value = serde_json::from_str(&text()).unwrap();
        let properties = schema["properties"].as_object().unwrap();
        assert!(properties.contains_key("obstacles"));
        assert!(properties.values().all(|field| field["description"].is_string()), "{properties:?}");
        assert_eq!(schema["additionalProperties"], false);
        assert_eq!(schema["$defs"]["ShapeFile"]["oneOf"].as_array().unwrap().len(), 5);
    }
}
