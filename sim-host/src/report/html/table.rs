//! A CSV file whose every complaint names file, line, column and what was expected.

use anyhow::{Context, anyhow, ensure};
use csv::StringRecord;
use std::path::{Path, PathBuf};

/// A CSV file with a header line.
pub struct Table {
    path: PathBuf,
    headers: StringRecord,
    records: Vec<StringRecord>,
}

impl Table {
    /// Reads a file that must have at least the columns `expected`, in any order.
    ///
    /// # Errors
    /// The file cannot be read, lacks a column, or has a line of another length than its header.
    pub fn read(path: &Path, expected: &[&str]) -> anyhow::Result<Self> {
        let name = path.display();
        let mut reader = csv::ReaderBuilder::new().flexible(true).from_path(path).with_context(|| format!("{name}"))?;
        let headers = reader.headers().with_context(|| format!("{name}, line 1"))?.clone();
        for column in expected {
            ensure!(
                headers.iter().any(|h| h == *column),
                "{name}, line 1: no column '{column}'; expected the columns {}",
                expected.join(",")
            );
        }
        let records = reader.records().collect::<Result<Vec<_>, _>>().with_context(|| format!("{name}"))?;
        for record in &records {
            let (found, due) = (record.len(), headers.len());
            ensure!(
                found == due,
                "{name}, line {}, column {}: {found} fields; expected {due}",
                line(record),
                found.min(due) + 1
            );
        }
        Ok(Self { path: path.into(), headers, records })
    }

    /// Its lines, each read by `read`.
    ///
    /// # Errors
    /// Those of `read`; no line at all.
    pub fn rows<T>(&self, read: impl Fn(&Row<'_>) -> anyhow::Result<T>) -> anyhow::Result<Vec<T>> {
        ensure!(!self.records.is_empty(), "{}, line 2: no data; expected at least one line", self.path.display());
        self.records.iter().map(|record| read(&Row { table: self, record })).collect()
    }
}

fn line(record: &StringRecord) -> u64 {
    record.position().map_or(0, csv::Position::line)
}

/// One line of a [`Table`].
pub struct Row<'a> {
    table: &'a Table,
    record: &'a StringRecord,
}

impl<'a> Row<'a> {
    fn index(&self, column: &str) -> Option<usize> {
        self.table.headers.iter().position(|h| h == column)
    }

    /// The field of a column that [`Table::read`] was told to expect; empty for any other that the file lacks.
    pub fn text(&self, column: &str) -> &'a str {
        self.index(column).and_then(|i| self.record.get(i)).unwrap_or_default().trim()
    }

    /// A complaint about a field.
    pub fn wrong(&self, column: &str, expected: &str) -> anyhow::Error {
        let found = match self.text(column) {
            "" => "nothing there".to_string(),
            text => format!("'{text}'"),
        };
        let number = self.index(column).map_or(0, |i| i + 1);
        anyhow!(
            "{}, line {}, column {number} ({column}): {found}; expected {expected}",
            self.table.path.display(),
            line(self.record)
        )
    }

    /// A finite number.
    ///
    /// # Errors
    /// It is something else.
    pub fn number(&self, column: &str) -> anyhow::Result<f64> {
        match self.text(column).parse::<f64>() {
            Ok(v) if v.is_finite() => Ok(v),
            _ => Err(self.wrong(column, "a finite number")),
        }
    }

    /// A number; `None` for an empty field or one that is not finite.
    ///
    /// # Errors
    /// It is something else.
    pub fn number_or_none(&self, column: &str) -> anyhow::Result<Option<f64>> {
        match self.text(column) {
            "" => Ok(None),
            text => match text.parse::<f64>() {
                Ok(v) => Ok(Some(v).filter(|v| v.is_finite())),
                Err(_) => Err(self.wrong(column, "a number or nothing")),
            },
        }
    }

    /// A whole number that is not negative.
    ///
    /// # Errors
    /// It is something else.
    pub fn count(&self, column: &str) -> anyhow::Result<u64> {
        self.text(column).parse().map_err(|_| self.wrong(column, "a whole number"))
    }

    /// One of a few words.
    ///
    /// # Errors
    /// It is none of them.
    pub fn choice<T: Copy>(&self, column: &str, words: &[(&str, T)]) -> anyhow::Result<T> {
        let found = self.text(column);
        words.iter().find(|(word, _)| *word == found).map(|(_, value)| *value).ok_or_else(|| {
            let words: Vec<&str> = words.iter().map(|(word, _)| *word).collect();
            self.wrong(column, &format!("one of: {}", words.join(", ")))
        })
    }
}
