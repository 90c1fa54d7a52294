//! Usage errors as the programs of Tactus print them.

/// A usage error as one line: what is wrong and what was expected.
pub fn one_line(error: &clap::Error) -> String {
    let text = error.render().to_string();
    let lines: Vec<&str> = text.lines().map(str::trim).filter(|l| !l.is_empty()).collect();
    let what: Vec<&str> =
        lines.iter().copied().take_while(|l| !l.starts_with("Usage:") && !l.starts_with("For more")).collect();
    what.join("; ").replace(":; ", ": ")
}
