//! `tactus report`: one page of all the experiments in a directory.

use crate::report::html;
use anyhow::Context;
use clap::Args;
use std::path::{Path, PathBuf};
use tactus_hil::say;

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
    /// The page of a directory, in that directory.
    pub fn of(dir: &Path) -> Self {
        Self { dir: dir.to_owned(), out: None }
    }

    /// Makes and writes the page; the exit status.
    ///
    /// # Errors
    /// The directory has no experiment or a malformed one, or the page cannot be written.
    pub fn run(&self) -> anyhow::Result<u8> {
        let out = self.out.clone().unwrap_or_else(|| self.dir.join("report.html"));
        let page = html::make(&self.dir, Some(&out))?;
        for (path, reason) in &page.ignored {
            say::complaint(format_args!("ignored: {} ({reason})", path.display()));
        }
        if out.as_os_str() == "-" {
            say::text(&page.html)?;
        } else {
            std::fs::write(&out, page.html).with_context(|| format!("--out {}", out.display()))?;
            say::line(format_args!("{}: {}", out.display(), page.contents))?;
        }
        Ok(0)
    }
}

#[cfg(test)]
mod tests {
    use std::ffi::OsString;
    use std::path::Path;
    use std::process::ExitCode;

    fn report(dir: &Path) -> ExitCode {
        crate::cli::main(["tactus".into(), "report".into(), OsString::from(dir)])
    }

    #[test]
    fn the_page_is_written_into_the_directory_and_malformed_input_is_exit_status_2() {
        let dir = tempfile::tempdir().unwrap();
        assert_eq!(report(dir.path()), ExitCode::from(2));
        let file = |name: &str, text: &str| std::fs::write(dir.path().join(name), text).unwrap();
        file("s.json", r#"{"experiment": "surface", "title": "A surface", "command": "tactus surface"}"#);
        file("s.csv", "x,y,phi,error,outcome\n0.1,0,0,1.5,ok\n0.2,0,0,,no inverse kinematics\n");
        let page = dir.path().join("report.html");
        for _ in 0..2 {
            // The second time the first one's page lies there.
            assert_eq!(report(dir.path()), ExitCode::SUCCESS);
            assert!(std::fs::read_to_string(&page).unwrap().contains("A surface"));
        }
        std::fs::remove_file(&page).unwrap();
        file("s.csv", "x,y,phi,error,outcome\n0.1,0,0,much,ok\n");
        assert_eq!(report(dir.path()), ExitCode::from(2));
        assert!(!page.exists(), "a page was written");
    }
}
