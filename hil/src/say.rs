//! Text for people and tools on standard output and standard error, which may be closed.
//!
//! `tactus --help | head -1` closes the pipe after a line. The rest is then for nobody: it is dropped, and the command
//! goes on to its end with its own exit status.

use std::fmt::Display;
use std::io::{self, ErrorKind, Write};

/// Writes to standard output, as it is.
///
/// # Errors
/// It cannot be written, for another reason than that nobody reads it any more.
pub fn text(text: impl Display) -> io::Result<()> {
    unless_closed(write_to(&mut io::stdout().lock(), text))
}

/// Writes a line to standard output.
///
/// # Errors
/// As [`text`].
pub fn line(line: impl Display) -> io::Result<()> {
    text(format_args!("{line}\n"))
}

/// Writes a line to standard error. If that cannot be written there is nowhere to say so.
pub fn complaint(line: impl Display) {
    let _ = writeln!(io::stderr().lock(), "{line}");
}

fn write_to(out: &mut impl Write, text: impl Display) -> io::Result<()> {
    write!(out, "{text}")?;
    out.flush()
}

fn unless_closed(written: io::Result<()>) -> io::Result<()> {
    match written {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        other => other.map_err(|error| io::Error::new(error.kind(), format!("standard output: {error}"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Broken(ErrorKind);

    impl Write for Broken {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(self.0.into())
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_reader_that_has_gone_is_no_error_and_a_full_disk_is_one() {
        assert!(unless_closed(write_to(&mut Broken(ErrorKind::BrokenPipe), "text")).is_ok());
        let told = unless_closed(write_to(&mut Broken(ErrorKind::StorageFull), "text")).unwrap_err();
        assert!(told.to_string().starts_with("standard output: "), "{told}");
    }
}
