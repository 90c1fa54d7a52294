//! A JSON object as columns of a table: nested names joined with `_`, places in lists counted from 1, in the order of the text.

use serde::de::{DeserializeSeed, Deserializer, MapAccess, SeqAccess, Visitor};
use std::fmt::{self, Formatter};

/// Names and texts of the columns of a JSON object.
///
/// # Errors
/// The bytes are no JSON.
pub fn columns(bytes: &[u8]) -> serde_json::Result<Vec<(String, String)>> {
    let mut columns = Vec::new();
    let mut json = serde_json::Deserializer::from_slice(bytes);
    Cells { name: String::new(), columns: &mut columns }.deserialize(&mut json)?;
    json.end()?;
    Ok(columns)
}

/// The value of this name, to be taken apart.
struct Cells<'a> {
    name: String,
    columns: &'a mut Vec<(String, String)>,
}

impl Cells<'_> {
    /// The part of this name.
    fn part(&mut self, part: &str) -> Cells<'_> {
        let name = if self.name.is_empty() { part.to_owned() } else { format!("{}_{part}", self.name) };
        Cells { name, columns: self.columns }
    }

    fn cell<E>(self, text: String) -> Result<(), E> {
        self.columns.push((self.name, text));
        Ok(())
    }
}

impl<'de> DeserializeSeed<'de> for Cells<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Cells<'_> {
    type Value = ();

    fn expecting(&self, f: &mut Formatter) -> fmt::Result {
        f.write_str("JSON")
    }

    fn visit_map<A: MapAccess<'de>>(mut self, mut map: A) -> Result<(), A::Error> {
        while let Some(key) = map.next_key::<String>()? {
            map.next_value_seed(self.part(&key))?;
        }
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(mut self, mut list: A) -> Result<(), A::Error> {
        for place in 1.. {
            if list.next_element_seed(self.part(&place.to_string()))?.is_none() {
                break;
            }
        }
        Ok(())
    }

    fn visit_bool<E>(self, value: bool) -> Result<(), E> {
        self.cell(value.to_string())
    }

    fn visit_i64<E>(self, value: i64) -> Result<(), E> {
        self.cell(value.to_string())
    }

    fn visit_u64<E>(self, value: u64) -> Result<(), E> {
        self.cell(value.to_string())
    }

    fn visit_f64<E>(self, value: f64) -> Result<(), E> {
        self.cell(value.to_string())
    }

    fn visit_str<E>(self, value: &str) -> Result<(), E> {
        self.cell(value.to_owned())
    }

    fn visit_unit<E>(self) -> Result<(), E> {
        self.cell(String::new())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_come_in_the_order_of_the_text_with_joined_names() {
        let json =
            br#"{"tick": 3, "belief": {"y_m": -0.5, "x_m": 1e-7}, "q_rad": [0.1, null], "name": "a, b", "ok": true}"#;
        let expected = [
            ("tick", "3"),
            ("belief_y_m", "-0.5"),
            ("belief_x_m", "0.0000001"),
            ("q_rad_1", "0.1"),
            ("q_rad_2", ""),
            ("name", "a, b"),
            ("ok", "true"),
        ];
        assert_eq!(columns(json).unwrap(), expected.map(|(name, text)| (name.to_owned(), text.to_owned())));
        assert!(columns(b"{\"tick\": 3").is_err());
        assert!(columns(b"{} {}").is_err());
    }
}
