//! The scenes that the program holds.

/// A scene that the program holds.
#[derive(Clone, Copy, Debug)]
pub struct BuiltIn {
    /// Its name on the command line.
    pub name: &'static str,
    /// Its file's text.
    pub text: &'static str,
}

/// All of them; the first is the default.
pub const ALL: &[BuiltIn] = &[
    BuiltIn { name: "thesis-box", text: include_str!("../../scenarios/thesis_box.toml") },
    BuiltIn { name: "cylinder", text: include_str!("../../scenarios/cylinder.toml") },
    BuiltIn { name: "tall-box", text: include_str!("../../scenarios/tall_box.toml") },
    BuiltIn { name: "hexagonal-prism", text: include_str!("../../scenarios/hexagonal_prism.toml") },
    BuiltIn { name: "between-obstacles", text: include_str!("../../scenarios/between_obstacles.toml") },
    BuiltIn { name: "two-boxes", text: include_str!("../../scenarios/two_boxes.toml") },
    BuiltIn { name: "heavy-slippery-box", text: include_str!("../../scenarios/heavy_slippery_box.toml") },
];

/// The scene of this name.
pub fn find(name: &str) -> Option<&'static BuiltIn> {
    ALL.iter().find(|scene| scene.name == name)
}

/// All names, with commas between them.
pub fn names() -> String {
    ALL.iter().map(|scene| scene.name).collect::<Vec<_>>().join(", ")
}
