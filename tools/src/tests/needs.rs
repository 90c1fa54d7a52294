//! Which tests need something that `cargo test` cannot give.

use anyhow::Context;
use std::path::{Path, PathBuf};

/// How such a test is marked.
const MARK: &str = "#[ignore = \"needs ";

/// Files below a folder with tests that need something, and whose names begin with none of these.
pub fn homeless(folder: &Path, files: &[&str]) -> anyhow::Result<Vec<String>> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(folder) = folders.pop() {
        let entries = std::fs::read_dir(&folder).with_context(|| format!("cannot read {}", folder.display()))?;
        for entry in entries {
            let path = entry?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if path.is_dir() {
                if name != "target" && !name.starts_with('.') {
                    folders.push(path);
                }
            } else if is_homeless(&path, &name, files)? {
                found.push(path.display().to_string());
            }
        }
    }
    found.sort();
    Ok(found)
}

fn is_homeless(path: &PathBuf, name: &str, files: &[&str]) -> anyhow::Result<bool> {
    if !name.ends_with(".rs") || files.iter().any(|begin| name.starts_with(begin)) {
        return Ok(false);
    }
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    Ok(text.lines().any(|line| line.trim_start().starts_with(MARK)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cargo;

    #[test]
    fn a_test_that_needs_something_in_a_file_of_no_place_is_found() {
        let all = homeless(&cargo::root(), &[]).unwrap();
        assert!(all.iter().any(|file| file.ends_with("hil/tests/socketcan_bus.rs")), "{all:?}");
        let others = homeless(&cargo::root(), &["socketcan"]).unwrap();
        assert!(!others.iter().any(|file| file.contains("socketcan")), "{others:?}");
        assert!(others.len() < all.len());
        assert!(!all.iter().any(|file| file.ends_with("tools/src/tests.rs")), "which only speaks of them");
    }
}
