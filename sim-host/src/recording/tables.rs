//! A recording as tables: one CSV file for each channel of numbers.

use super::columns::columns;
use super::log::{Ending, Entry, Log, Message};
use super::{Channel, json};
use anyhow::Context;
use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};
use std::fs::File;
use std::path::{Path, PathBuf};

/// What was exported.
#[derive(Clone, Debug)]
pub struct Exported {
    /// Tables written, with their rows.
    pub tables: Vec<(PathBuf, u64)>,
    /// How the recording ends.
    pub ending: Ending,
}

/// A table being written.
struct Table {
    path: PathBuf,
    names: Vec<String>,
    rows: u64,
    csv: csv::Writer<File>,
}

impl Table {
    fn create(path: PathBuf, names: Vec<String>) -> anyhow::Result<Self> {
        let mut csv = csv::Writer::from_path(&path).with_context(|| path.display().to_string())?;
        csv.write_record(&names).with_context(|| path.display().to_string())?;
        Ok(Self { path, names, rows: 0, csv })
    }

    fn add(&mut self, names: &[String], texts: &[String]) -> anyhow::Result<()> {
        anyhow::ensure!(
            names == self.names,
            "{}: row {} has other columns than the first one",
            self.path.display(),
            self.rows + 1
        );
        self.rows += 1;
        self.csv.write_record(texts).with_context(|| self.path.display().to_string())
    }

    fn finish(mut self) -> anyhow::Result<(PathBuf, u64)> {
        self.csv.flush().with_context(|| self.path.display().to_string())?;
        Ok((self.path, self.rows))
    }
}

/// Is a channel a table: the same numbers in every message?
fn is_table(channel: Channel) -> bool {
    channel.encoding() == json::ENCODING && channel != Channel::Pads
}

/// Writes the tables of a recording into a folder, which is made if it is not there. Files of the same names are replaced.
///
/// # Errors
/// The recording cannot be read or has no table, or a table cannot be written; the message names the file.
pub fn export(recording: &Path, folder: &Path) -> anyhow::Result<Exported> {
    let mut log = Log::open(recording)?;
    let mut tables: BTreeMap<Channel, Table> = BTreeMap::new();
    while let Some(entry) = log.next_entry()? {
        let Entry::Message(message) = entry else { continue };
        let Some(channel) = message.source.channel.filter(|channel| is_table(*channel)) else { continue };
        let (names, texts) = row(&message).with_context(|| recording.display().to_string())?;
        if let Some(table) = tables.get_mut(&channel) {
            table.add(&names, &texts)?;
            continue;
        }
        std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
        let path = folder.join(format!("{}.csv", channel.topic().trim_start_matches('/').replace('/', "_")));
        let mut table = Table::create(path, names.clone())?;
        table.add(&names, &texts)?;
        tables.insert(channel, table);
    }
    anyhow::ensure!(
        !tables.is_empty(),
        "{}: no channel of numbers in it; expected a recording of `tactus run --record`",
        recording.display()
    );
    let tables = tables.into_values().map(Table::finish).collect::<anyhow::Result<_>>()?;
    Ok(Exported { tables, ending: log.ending().cloned().unwrap_or(Ending::Whole) })
}

/// Names and texts of a message's row, robot time first.
fn row(message: &Message) -> anyhow::Result<(Vec<String>, Vec<String>)> {
    let columns =
        columns(&message.bytes).with_context(|| format!("{} at {:.3} s", message.source.topic, message.time_s()))?;
    let time = ("time_s".to_owned(), format!("{:.3}", message.time_s()));
    Ok(std::iter::once(time).chain(columns).unzip())
}

impl Display for Exported {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        self.tables.iter().try_for_each(|(path, rows)| writeln!(f, "{}: {rows} rows", path.display()))
    }
}
