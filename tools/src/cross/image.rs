//! What a linked image is made of.

use super::panics;
use anyhow::Context;
use object::{Object, ObjectSection, ObjectSymbol, SectionFlags, SectionKind, elf};
use rustc_demangle::demangle;
use std::path::Path;

/// An image.
#[derive(Clone, Debug)]
pub struct Image {
    /// The board's name.
    pub name: String,
    /// Bytes of flash: vectors, code, constants, initial values of variables.
    pub flash: u64,
    /// Bytes of variables.
    pub static_ram: u64,
    /// Bytes reserved for the stack.
    pub stack: u64,
    /// Names of functions that allocate.
    pub allocators: Vec<String>,
    /// Where it may panic, and how often each.
    pub panics: panics::Sites,
}

impl Image {
    /// Reads a linked image.
    ///
    /// # Errors
    /// The file cannot be read, is no such image, or lacks the symbols that bound its stack.
    pub fn read(name: &str, path: &Path) -> anyhow::Result<Self> {
        let bytes = std::fs::read(path).with_context(|| format!("{}: cannot be read", path.display()))?;
        let file = object::File::parse(&*bytes).with_context(|| format!("{}: is no ELF file", path.display()))?;
        let (mut flash, mut static_ram) = (0, 0);
        for section in file.sections() {
            let SectionFlags::Elf { sh_flags, .. } = section.flags() else { continue };
            if sh_flags.0 & elf::SHF_ALLOC.0 == 0 {
                continue;
            }
            let writable = sh_flags.0 & elf::SHF_WRITE.0 != 0;
            let empty = section.kind() == SectionKind::UninitializedData;
            flash += if empty { 0 } else { section.size() };
            static_ram += if writable { section.size() } else { 0 };
        }
        let symbol = |wanted: &str| {
            let found = file.symbols().find(|symbol| symbol.name() == Ok(wanted)).map(|symbol| symbol.address());
            found.with_context(|| format!("{}: no symbol {wanted}", path.display()))
        };
        let stack = symbol("_stack_start")?.saturating_sub(symbol("_stack_end")?);
        let names = file.symbols().filter_map(|symbol| symbol.name().ok()).map(|name| format!("{:#}", demangle(name)));
        let allocators = names.filter(|name| allocates(name)).collect();
        let panics = panics::sites(&file, path)?;
        Ok(Self { name: name.to_owned(), flash, static_ram, stack, allocators, panics })
    }

    /// Bytes of RAM, stack included.
    pub fn ram(&self) -> u64 {
        self.static_ram + self.stack
    }
}

/// Is this the name of a function that hands out memory, or of the crate that needs one?
pub(super) fn allocates(name: &str) -> bool {
    let last = name.rsplit("::").next().unwrap_or(name);
    name.starts_with("alloc::")
        || name.starts_with("<alloc::")
        || ["__rust_alloc", "__rust_realloc", "__rg_alloc", "__rdl_alloc", "malloc", "calloc", "realloc", "sbrk"]
            .contains(&last)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn allocators_are_known_by_their_names() {
        for name in ["alloc::raw_vec::finish_grow", "<alloc::vec::Vec<u8>>::push", "__rustc::__rust_alloc", "malloc"] {
            assert!(allocates(name), "{name}");
        }
        for name in ["heapless::vec::push", "core::fmt::write", "tactus_common::slcan::read", "memcpy"] {
            assert!(!allocates(name), "{name}");
        }
    }
}
