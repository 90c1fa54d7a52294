//! `tactus info` and `tactus export`: what is in a recording, and its numbers as tables.

use crate::recording::{Contents, Ending, export};
use clap::Args;
use std::path::PathBuf;
use tactus_hil::say;

/// Which recording.
#[derive(Args, Debug)]
pub struct InfoArgs {
    /// A recording (MCAP), also one that was cut off.
    #[arg(value_name = "FILE.mcap")]
    file: PathBuf,
}

impl InfoArgs {
    /// Prints what is in it; the exit status.
    ///
    /// # Errors
    /// The file is no recording.
    pub fn run(&self) -> anyhow::Result<u8> {
        say::text(Contents::read(&self.file)?)?;
        Ok(0)
    }
}

/// Which recording, and where its tables go.
#[derive(Args, Debug)]
pub struct ExportArgs {
    /// A recording (MCAP), also one that was cut off.
    #[arg(value_name = "FILE.mcap")]
    file: PathBuf,
    /// Folder for the tables: one CSV file for each channel of numbers, its columns with their units. Made if it is not
    /// there; tables of an earlier export are replaced.
    #[arg(long, value_name = "DIR")]
    csv: PathBuf,
}

impl ExportArgs {
    /// Writes the tables; the exit status.
    ///
    /// # Errors
    /// The file is no recording, or the tables cannot be written.
    pub fn run(&self) -> anyhow::Result<u8> {
        let exported = export(&self.file, &self.csv)?;
        say::text(&exported)?;
        if let Ending::Cut(why) = &exported.ending {
            let cut = format_args!("{}: cut off ({why}); the tables hold what comes before", self.file.display());
            say::complaint(cut);
        }
        Ok(0)
    }
}
