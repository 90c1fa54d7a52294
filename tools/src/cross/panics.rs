//! Panic sites of a linked image: every call of a function that only panics.
//!
//! All panics of a Rust image go through `core::panicking::panic_fmt`. Functions of `core` that lead there by name
//! (`unwrap_failed`, `slice_index_fail`, ...) are ways to it; who calls a way, is a site. Calls are found as what they are
//! in Thumb code: a branch, with or without link, whose target is the first instruction of a way. A word of data that
//! looks like one would be a site too many, never one too few; calls through pointers are not seen.

use addr2line::Loader;
use anyhow::Context;
use object::{Object, ObjectSection, ObjectSymbol, SymbolKind};
use rustc_demangle::demangle;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// A place that may panic: as the budget names it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Site {
    /// Source file, from the workspace's root; of other crates, from the crate's name.
    pub file: String,
    /// What happens there: the last part of the name of the function called, `bounds_check`.
    pub what: String,
}

/// How many calls at each site.
pub type Sites = BTreeMap<Site, u32>;

/// A function: its name, and its code.
struct Function<'a> {
    name: String,
    address: u64,
    code: &'a [u8],
}

/// Finds them.
///
/// # Errors
/// The file cannot be read or has no line numbers.
pub fn sites(file: &object::File<'_>, path: &Path) -> anyhow::Result<Sites> {
    let functions = functions(file);
    let ways = ways(&functions);
    let lines = Loader::new(path).map_err(|error| anyhow::anyhow!("{}: no line numbers: {error}", path.display()))?;
    let mut sites = Sites::new();
    for function in functions.iter().filter(|function| !ways.contains(&function.address)) {
        for (at, target) in branches(function) {
            let Some(way) = functions.iter().find(|f| f.address == target && ways.contains(&target)) else { continue };
            let source = source(&lines, at).with_context(|| format!("{at:#x} in {}: no source", function.name))?;
            *sites.entry(Site { file: source, what: last_part(&way.name) }).or_default() += 1;
        }
    }
    Ok(sites)
}

fn functions<'a>(file: &object::File<'a>) -> Vec<Function<'a>> {
    let mut functions = Vec::new();
    for symbol in file.symbols().filter(|symbol| symbol.kind() == SymbolKind::Text && symbol.size() > 0) {
        let address = symbol.address() & !1;
        let section = symbol.section_index().and_then(|index| file.section_by_index(index).ok());
        let code = section.and_then(|section| section.data_range(address, symbol.size()).ok().flatten());
        if let (Some(code), Ok(name)) = (code, symbol.name()) {
            functions.push(Function { name: format!("{:#}", demangle(name)), address, code });
        }
    }
    functions
}

/// Addresses of the functions that only panic.
fn ways(functions: &[Function<'_>]) -> BTreeSet<u64> {
    let mut ways: BTreeSet<u64> =
        functions.iter().filter(|f| last_part(&f.name) == "panic_fmt").map(|f| f.address).collect();
    let candidates: Vec<&Function<'_>> = functions.iter().filter(|f| only_panics(&f.name)).collect();
    // Ways lead to ways; as many rounds as there can be steps.
    for _ in 0..candidates.len() {
        let more: Vec<u64> = candidates
            .iter()
            .filter(|f| !ways.contains(&f.address) && branches(f).any(|(_, target)| ways.contains(&target)))
            .map(|f| f.address)
            .collect();
        if more.is_empty() {
            break;
        }
        ways.extend(more);
    }
    ways
}

/// Is this, by its name, a function of `core` that does nothing but panic?
fn only_panics(name: &str) -> bool {
    let of_core = name.starts_with("core::") || name.starts_with("<core::");
    let last = last_part(name);
    of_core && (name.starts_with("core::panicking::") || ["fail", "panic"].iter().any(|part| last.contains(part)))
}

/// The last part of a function's name, without the types it is made for.
fn last_part(name: &str) -> String {
    let plain = name.split("::<").next().unwrap_or(name);
    plain.rsplit("::").next().unwrap_or(plain).to_owned()
}

/// Branches of a function to fixed places: where from, where to.
fn branches(function: &Function<'_>) -> impl Iterator<Item = (u64, u64)> {
    let halves: Vec<u32> =
        function.code.chunks_exact(2).map(|pair| u32::from(pair[0]) | u32::from(pair[1]) << 8).collect();
    let address = function.address;
    (0..halves.len()).filter_map(move |index| {
        let at = address + 2 * index as u64;
        let offset = offset(halves[index], halves.get(index + 1).copied().unwrap_or(0))?;
        Some((at, at.wrapping_add(4).wrapping_add_signed(offset)))
    })
}

/// Distance of a branch's target from the end of its first four bytes (ARM DDI 0403, A7.7.12 and A7.7.18: B encodings T2
/// and T4, BL encoding T1).
fn offset(first: u32, second: u32) -> Option<i64> {
    let signed = |value: u32, bits: u32| i64::from((value << (32 - bits)) as i32 >> (32 - bits));
    if first & 0xf800 == 0xe000 {
        return Some(signed((first & 0x7ff) << 1, 12));
    }
    if first & 0xf800 != 0xf000 || second & 0x9000 != 0x9000 {
        return None;
    }
    let (s, j1, j2) = (first >> 10 & 1, second >> 13 & 1, second >> 11 & 1);
    let (i1, i2) = (1 ^ j1 ^ s, 1 ^ j2 ^ s);
    let value = s << 24 | i1 << 23 | i2 << 22 | (first & 0x3ff) << 12 | (second & 0x7ff) << 1;
    Some(signed(value, 25))
}

/// The source file of an instruction: the innermost one of this workspace, else of another crate, else of `core`, as
/// functions were put into one another.
fn source(lines: &Loader, at: u64) -> Option<String> {
    let mut frames = lines.find_frames(at).ok()?;
    let mut files = Vec::new();
    while let Some(frame) = frames.next().ok()? {
        files.extend(frame.location.and_then(|location| location.file.map(short)));
    }
    let ranked = |rank: fn(&str) -> bool| files.iter().find(|file| rank(file)).cloned();
    let ours = |file: &str| ["common/", "firmware/"].iter().any(|start| file.starts_with(start));
    let of_core = |file: &str| file.starts_with("core/");
    ranked(ours).or_else(|| files.iter().find(|file| !of_core(file)).cloned()).or_else(|| files.first().cloned())
}

/// A path without the machine's part of it.
fn short(path: &str) -> String {
    // What a build script made lies in a folder whose name ends with a hash: `build/CRATE-HASH/out/FILE`.
    if let Some((_, made)) = path.split_once("/release/build/")
        && let Some((folder, file)) = made.split_once('/')
    {
        return format!("{}/{file}", folder.rsplit_once('-').map_or(folder, |(name, _)| name));
    }
    let root = crate::cargo::root();
    let own = Path::new(path).strip_prefix(&root).map(|path| path.display().to_string());
    if let Ok(own) = own {
        return own;
    }
    let parts: Vec<&str> = path.split('/').filter(|part| *part != ".").collect();
    let after =
        |mark: &dyn Fn(&str) -> bool| parts.iter().rposition(|part| mark(part)).map(|at| parts[at + 1..].join("/"));
    after(&|part| part == "library" || part.starts_with("index.crates.io-")).unwrap_or_else(|| path.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn branches_are_decoded_as_the_assembler_encodes_them() {
        // From `objdump` of an image: bl 5a02 at 448, and b.n 59b6 at 5a0a.
        assert_eq!(offset(0xf005, 0xfadb), Some(0x5a02 - 0x44c));
        assert_eq!(offset(0xe7d4, 0), Some(0x59b6 - 0x5a0e));
        // b.w backwards: f7ff bffe jumps to itself.
        assert_eq!(offset(0xf7ff, 0xbffe), Some(-4));
        assert_eq!(offset(0xb580, 0x466f), None);
    }

    #[test]
    fn functions_that_only_panic_are_known_by_their_names() {
        for name in [
            "core::panicking::panic_bounds_check",
            "core::option::expect_failed",
            "core::slice::index::slice_index_fail",
        ] {
            assert!(only_panics(name), "{name}");
        }
        for name in ["core::fmt::write", "tactus_common::fail", "core::slice::sort::unstable::quicksort::quicksort"] {
            assert!(!only_panics(name), "{name}");
        }
        assert_eq!(last_part("core::panicking::assert_failed::<u64, u64>"), "assert_failed");
    }

    #[test]
    fn paths_lose_the_machine_s_part() {
        assert_eq!(short("/rustc/59807616/library/core/src/fmt/float.rs"), "core/src/fmt/float.rs");
        assert_eq!(short("/usr/src/rustc-1.96/library/core/src/fmt/float.rs"), "core/src/fmt/float.rs");
        let registry = "/home/a/.cargo/registry/src/index.crates.io-1949cf8c6b5b557f/libm-0.2.16/src/math/sinf.rs";
        assert_eq!(short(registry), "libm-0.2.16/src/math/sinf.rs");
        let made = "/home/a/tactus/target/firmware/own/thumbv7em-none-eabihf/release/build/embassy-stm32-c07c/out/_generated.rs";
        assert_eq!(short(made), "embassy-stm32/out/_generated.rs");
        let own = crate::cargo::root().join("common/src/pose.rs");
        assert_eq!(short(&own.display().to_string()), "common/src/pose.rs");
    }
}
