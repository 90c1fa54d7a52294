//! `tactus scenes` and `tactus check`: which scenes there are, what a scene file may say, and whether it is sound.

use crate::scenario::{Scenario, account, built_in, schema};
use anyhow::Context;
use clap::Args;
use std::path::{Path, PathBuf};
use tactus_hil::say;

/// `tactus scenes`.
#[derive(Args, Debug)]
pub(super) struct ScenesArgs {
    /// Print the file of this scene, to begin one of one's own with.
    #[arg(long, value_name = "NAME", conflicts_with = "schema")]
    show: Option<String>,
    /// Print the JSON schema of scene files (docs/scene.schema.json), for editors.
    #[arg(long)]
    schema: bool,
}

/// `tactus check`.
#[derive(Args, Debug)]
pub(super) struct CheckArgs {
    /// Scene file, or the name of a built-in scene.
    #[arg(value_name = "FILE.toml")]
    file: PathBuf,
}

impl ScenesArgs {
    /// Prints what is asked for; the exit status.
    pub fn run(&self) -> anyhow::Result<u8> {
        if self.schema {
            say::text(schema::text())?;
        } else if let Some(name) = &self.show {
            let scene = built_in::find(name)
                .with_context(|| format!("--show {name}: no such scene; expected one of: {}", built_in::names()))?;
            say::text(scene.text)?;
        } else {
            for scene in built_in::ALL {
                let Scenario { summary, .. } = Scenario::load(Path::new(scene.name)).context(scene.name)?;
                say::line(format_args!("{:<20} {summary}", scene.name))?;
            }
        }
        Ok(0)
    }
}

impl CheckArgs {
    /// Reads the scene and says what it is; the exit status.
    pub fn run(&self) -> anyhow::Result<u8> {
        let scenario = Scenario::load(&self.file).with_context(|| self.file.display().to_string())?;
        say::text(account::account(&scenario))?;
        Ok(0)
    }
}
