//! `tactus view`: a recording as one page, in a file or on this machine's own network.

use crate::view::Replay;
use crate::view::server::Server;
use anyhow::{Context, ensure};
use clap::Args;
use std::path::{Path, PathBuf};
use tactus_hil::say;

/// Which recording, and where its page goes.
#[derive(Args, Debug)]
pub struct ViewArgs {
    /// Recording that `tactus run --record` wrote.
    #[arg(value_name = "FILE.mcap")]
    file: PathBuf,
    /// Where to write the page; `-` writes it to standard output [default: FILE.html beside the recording].
    #[arg(long, value_name = "FILE.html", conflicts_with = "serve")]
    out: Option<PathBuf>,
    /// Write nothing; show the page to browsers on this machine until interrupted (0: a free port) [default PORT: 8350].
    #[arg(long, value_name = "PORT", num_args = 0..=1, default_missing_value = "8350")]
    serve: Option<u16>,
}

impl ViewArgs {
    /// Makes the page; the exit status.
    ///
    /// # Errors
    /// The file is no recording, or the page cannot be written or served.
    pub fn run(&self) -> anyhow::Result<u8> {
        let replay = Replay::read(&self.file)?;
        if let Some(warning) = &replay.heading.warning {
            say::complaint(format_args!("{}: {warning}", self.file.display()));
        }
        let page = replay.page()?;
        match self.serve {
            Some(port) => serve(port, page),
            None => write(&self.out()?, &page),
        }?;
        Ok(0)
    }

    fn out(&self) -> anyhow::Result<PathBuf> {
        let out = self.out.clone().unwrap_or_else(|| self.file.with_extension("html"));
        ensure!(out != self.file, "--out {}: that is the recording", out.display());
        Ok(out)
    }
}

fn write(out: &Path, page: &str) -> anyhow::Result<()> {
    if out.as_os_str() == "-" {
        return Ok(say::text(page)?);
    }
    std::fs::write(out, page).with_context(|| format!("--out {}", out.display()))?;
    let megabytes = page.len() as f64 / 1e6;
    Ok(say::line(format_args!("{}: {megabytes:.1} MB, opens in any browser", out.display()))?)
}

fn serve(port: u16, page: String) -> anyhow::Result<()> {
    let server = Server::open(port, page)?;
    say::line(format_args!("{} until interrupted", server.address()?))?;
    server.run()
}
