//! What is wrong with a scene file, and where.

use std::fmt;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A mistake in a scene file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mistake {
    /// The field, as a path: `object.mass_kg`, `obstacles[1].pose`.
    pub field: String,
    /// Its value, and what was expected.
    pub what: String,
}

impl Mistake {
    /// A mistake of this field.
    pub fn new(field: impl Into<String>, what: impl Into<String>) -> Self {
        Self { field: field.into(), what: what.into() }
    }

    /// The mistake with its place in the scene file's text, one line.
    pub fn located(&self, text: &str) -> anyhow::Error {
        match place_of(text, &self.field) {
            Some(offset) => anyhow::anyhow!("{}: {self}", place(text, offset)),
            None => anyhow::anyhow!("{self}"),
        }
    }
}

impl fmt::Display for Mistake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.field, self.what)
    }
}

/// "line 3, column 7" of a byte offset.
pub fn place(text: &str, offset: usize) -> String {
    let before = text.get(..offset).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().map_or(0, |last| last.chars().count()) + 1;
    format!("line {line}, column {column}")
}

/// Byte offset of the value at a path, or of the nearest thing around it that is written in the text.
fn place_of(text: &str, field: &str) -> Option<usize> {
    let root = DeTable::parse(text).ok()?;
    let mut table = Some(root.get_ref());
    let mut found: Option<usize> = None;
    let mut value: Option<&Spanned<DeValue<'_>>>;
    for part in field.split('.') {
        let (key, index) = match part.split_once('[') {
            Some((key, rest)) => (key, rest.trim_end_matches(']').parse::<usize>().ok()),
            None => (part, None),
        };
        value = table.and_then(|table| table.get(key));
        if let (Some(list), Some(index)) = (value.and_then(|v| v.get_ref().as_array()), index) {
            value = list.get(index);
        }
        let Some(here) = value else { break };
        found = Some(here.span().start);
        table = here.get_ref().as_table();
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mistake_is_told_with_the_line_and_column_of_its_value_or_of_what_is_around_it() {
        let text = "name = \"x\"\n\n[object]\nmass_kg = -1\n\n[[obstacles]]\npose = [0, 0, 0]\n\n[[obstacles]]\nshape.sphere = { radius_m = -2 }\n";
        for (field, expected) in [
            ("object.mass_kg", "line 4, column 11: "),
            ("object.size_m", "line 3, column 1: "),
            ("obstacles[0].pose", "line 7, column 8: "),
            ("obstacles[1].shape.sphere.radius_m", "line 10, column 29: "),
            ("obstacles[1].pose", "line 9, column 1: "),
            ("nowhere", "nowhere: "),
        ] {
            let told = Mistake::new(field, "bad").located(text).to_string();
            assert!(told.starts_with(expected), "{field}: {told}");
            assert!(told.ends_with(&format!("{field}: bad")), "{told}");
        }
    }
}
