//! The static library for C on the target (docs/library.md): what it offers, and what it needs.

use super::image::allocates;
use super::toolchain;
use crate::cargo;
use anyhow::{Context, ensure};
use object::read::archive::ArchiveFile;
use object::{Object, ObjectSymbol};
use rustc_demangle::demangle;
use std::collections::BTreeSet;

/// The one function that the program brings.
const NEEDED: &str = "tactus_panic";

/// Builds it, and checks that it offers what the header declares, allocates nothing and needs at most the hook for
/// panics: the compiler's runtime is in it.
pub fn check() -> anyhow::Result<()> {
    let path = toolchain::library()?;
    let shown = path.display();
    let bytes = std::fs::read(&path).with_context(|| format!("{shown}: cannot be read"))?;
    let names = Names::of(&bytes).with_context(|| format!("{shown}: is no archive of ELF files"))?;
    let header_path = cargo::root().join("firmware/library/include/tactus.h");
    let header = std::fs::read_to_string(&header_path).with_context(|| format!("{}", header_path.display()))?;
    let declared = declared(&header);
    // Rust's own names have paths.
    let is_ours = |name: &&String| name.starts_with("tactus_") && !name.contains("::");
    let offered: BTreeSet<String> = names.defined.iter().filter(is_ours).cloned().collect();
    ensure!(
        offered == declared,
        "{shown}: not what tactus.h declares: {:?}",
        offered.symmetric_difference(&declared).collect::<Vec<_>>()
    );
    let missing: Vec<&String> = names.undefined.difference(&names.defined).collect();
    // Where the compiler has found every check to hold, not even the hook is called.
    ensure!(missing.iter().all(|name| *name == NEEDED), "{shown}: needs {missing:?}; expected {NEEDED} at most");
    let allocators: Vec<&String> = names.defined.iter().filter(|name| allocates(name)).collect();
    ensure!(allocators.is_empty(), "{shown}: holds an allocator: {allocators:?}");
    println!(
        "libtactus.a ({}): {} functions, no allocator, needs {}",
        toolchain::described(),
        declared.len(),
        if missing.is_empty() { "nothing" } else { NEEDED }
    );
    Ok(())
}

/// The functions that the header declares and the library brings.
fn declared(header: &str) -> BTreeSet<String> {
    let calls = header.lines().filter(|line| !line.trim_start().starts_with(['/', '*', '#']));
    let names = calls.filter_map(|line| line.split_once('(')).filter_map(|(left, _)| left.rsplit([' ', '*']).next());
    names.filter(|name| name.starts_with("tactus_") && *name != NEEDED).map(str::to_owned).collect()
}

/// Names of symbols, demangled.
#[derive(Debug, Default)]
struct Names {
    defined: BTreeSet<String>,
    undefined: BTreeSet<String>,
}

impl Names {
    fn of(archive: &[u8]) -> anyhow::Result<Self> {
        let mut names = Self::default();
        for member in ArchiveFile::parse(archive)?.members() {
            let file = object::File::parse(member?.data(archive)?)?;
            for symbol in file.symbols() {
                let name = format!("{:#}", demangle(symbol.name()?));
                if symbol.is_undefined() && !name.is_empty() {
                    names.undefined.insert(name);
                } else if symbol.is_definition() {
                    names.defined.insert(name);
                }
            }
        }
        Ok(names)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn declarations_are_told_from_comments_and_the_hook() {
        let header = "/// `tactus_a(x)` says.\nuint32_t tactus_a(void);\nTactusResult tactus_b(void *memory,\n    size_t bytes);\n\
                      extern void tactus_panic(const char *file);\n#define TACTUS_X (1)\n";
        assert_eq!(declared(header).into_iter().collect::<Vec<_>>(), ["tactus_a", "tactus_b"]);
    }
}
