//! `tactus report`: one page of all the experiments in a directory.

use crate::report::html;
use anyhow::Context;
use clap::Args;
use std::path::PathBuf;

/// Which directory, and where the page goes.
#[derive(Args, Debug)]
pub struct ReportArgs {
    /// Directory with the outputs of experiments: pairs STEM.csv and STEM.json, and bench.json.
    #[arg(value_name = "DIR")]
    dir: PathBuf,
    /// Where to write the page; `-` writes it to standard output [default: DIR/report.html].
    #[arg(long, value_name = "FILE.html")]
    out: Option<PathBuf>,
}

impl ReportArgs {
    /// Makes and writes the page; the exit status.
    ///
    /// # Errors
    /// The directory has no experiment or a malformed one, or the page cannot be written.
    pub fn run(&self) -> anyhow::Result<u8> {
        let out = self.out.clone().unwrap_or_else(|| self.dir.join("report.html"));
        let page = html::make(&self.dir, Some(&out))?;
        for (path, reason) in &page.ignored {
            eprintln!("ignored: {} ({reason})", path.display());
        }
        if out.as_os_str() == "-" {
            print!("{}", page.html);
        } else {
            std::fs::write(&out, page.html).with_context(|| format!("--out {}", out.display()))?;
            println!("{}: {}", out.display(), page.contents);
        }
        Ok(0)
    }
}
