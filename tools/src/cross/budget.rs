//! `firmware/budget.toml`: what an image may take, and why its remaining panic sites cannot be reached.

use super::image::Image;
use super::panics::{Site, Sites};
use crate::cargo;
use anyhow::{Context, ensure};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

/// The file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Budget {
    image: BTreeMap<String, Limits>,
    #[serde(default)]
    panic: Vec<Explained>,
}

/// What one image may take.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Bytes of flash.
    pub flash_bytes: u64,
    /// Bytes of RAM, reserved stack included.
    pub ram_bytes: u64,
    /// Bytes of the reserved stack that must never be touched.
    pub stack_margin_bytes: u64,
    /// Instructions of the longest tick, where the image can be measured.
    pub tick_instructions: Option<u64>,
}

/// Panic sites that may be there.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Explained {
    file: String,
    what: String,
    /// At most so many calls, in any image.
    count: u32,
    /// Why no input reaches them.
    reason: String,
}

impl Budget {
    /// Reads it.
    ///
    /// # Errors
    /// One line: what is wrong with the file.
    pub fn read() -> anyhow::Result<Self> {
        let path = cargo::root().join("firmware/budget.toml");
        let text = std::fs::read_to_string(&path).with_context(|| format!("{}: cannot be read", path.display()))?;
        let budget: Self = toml::from_str(&text).with_context(|| format!("{}: not as expected", path.display()))?;
        let unexplained = budget.panic.iter().find(|entry| entry.reason.trim().is_empty());
        ensure!(unexplained.is_none(), "{}: a panic site without a reason: {unexplained:?}", path.display());
        Ok(budget)
    }

    /// What this image may take.
    ///
    /// # Errors
    /// The file does not name the image.
    pub fn limits(&self, image: &str) -> anyhow::Result<&Limits> {
        self.image.get(image).with_context(|| format!("firmware/budget.toml: no [image.{image}]"))
    }

    fn entry(&self, site: &Site) -> Option<&Explained> {
        self.panic.iter().find(|entry| entry.file == site.file && entry.what == site.what)
    }

    /// Sites that are new, or more than there were.
    pub fn unexplained(&self, sites: &Sites) -> Vec<String> {
        let over = |(site, count): &(&Site, &u32)| self.entry(site).is_none_or(|entry| **count > entry.count);
        sites.iter().filter(over).map(|(site, count)| format!("{count} x {} in {}", site.what, site.file)).collect()
    }

    /// The sites with their reasons.
    pub fn explained(&self, sites: &Sites) -> Vec<String> {
        let reason = |site| self.entry(site).map_or("", |entry| entry.reason.as_str());
        sites.iter().map(|(site, n)| format!("{n} x {} in {}: {}", site.what, site.file, reason(site))).collect()
    }
}

/// What the image measured of itself in the emulator, as the tests of the image leave it.
#[derive(Clone, Debug, Deserialize)]
pub struct Measured {
    /// Digest of the main job.
    pub digest: String,
    /// Ticks of the main job.
    pub ticks: u64,
    /// Bytes of stack that were ever used.
    pub stack: u64,
    /// Instructions of the longest tick.
    pub worst_tick: u64,
    /// Mean.
    pub mean_tick: u64,
}

impl Measured {
    /// Reads what the tests have left.
    ///
    /// # Errors
    /// They have left nothing.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let text = std::fs::read_to_string(path).with_context(|| {
            format!("{}: missing; expected the tests of the image to leave what it measured", path.display())
        })?;
        toml::from_str(&text).with_context(|| format!("{}: not as expected", path.display()))
    }

    /// Holds it against the budget.
    ///
    /// # Errors
    /// One line: which figure is over its limit.
    pub fn check(&self, image: &Image, limits: &Limits) -> anyhow::Result<()> {
        let stack_max = image.stack.saturating_sub(limits.stack_margin_bytes);
        ensure!(
            self.stack <= stack_max,
            "{}: {} bytes of stack were used; {} are reserved (memory.x), of which {} must stay free",
            image.name,
            self.stack,
            image.stack,
            limits.stack_margin_bytes
        );
        let ticks_max = limits.tick_instructions.unwrap_or(u64::MAX);
        ensure!(
            self.worst_tick <= ticks_max,
            "{}: the longest tick took {} instructions; firmware/budget.toml allows {ticks_max}",
            image.name,
            self.worst_tick
        );
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn budget() -> Budget {
        toml::from_str(
            r#"
            [image.a]
            flash_bytes = 1000
            ram_bytes = 100
            stack_margin_bytes = 10
            tick_instructions = 50
            [[panic]]
            file = "common/src/x.rs"
            what = "panic_bounds_check"
            count = 1
            reason = "the index is a constant"
            "#,
        )
        .expect("a budget")
    }

    fn image(stack: u64) -> Image {
        let panics = Sites::new();
        Image { name: "a".to_owned(), flash: 1, static_ram: 1, stack, allocators: Vec::new(), panics }
    }

    fn sites(file: &str, count: u32) -> Sites {
        Sites::from([(Site { file: file.to_owned(), what: "panic_bounds_check".to_owned() }, count)])
    }

    #[test]
    fn a_site_is_explained_by_file_kind_and_count() {
        assert_eq!(budget().unexplained(&sites("common/src/x.rs", 1)), Vec::<String>::new());
        assert_eq!(budget().unexplained(&sites("common/src/x.rs", 2)).len(), 1);
        assert_eq!(budget().unexplained(&sites("common/src/y.rs", 1)), ["1 x panic_bounds_check in common/src/y.rs"]);
    }

    #[test]
    fn what_was_measured_must_keep_within_the_limits() {
        let measured =
            |stack, worst_tick| Measured { digest: String::new(), ticks: 1, stack, worst_tick, mean_tick: 1 };
        let budget = budget();
        let limits = budget.limits("a").expect("named");
        assert!(measured(90, 50).check(&image(100), limits).is_ok());
        assert!(measured(91, 50).check(&image(100), limits).is_err());
        assert!(measured(90, 51).check(&image(100), limits).is_err());
        assert!(budget.limits("b").is_err());
    }
}
