//! The text of the robot's description, for whoever loads it at run time (the simulated world, reports).

/// The robot's URDF.
pub const URDF: &str = include_str!("../../models/wam7_bh280.urdf");

/// The settings beside it: mount, gears, taxels.
pub const TOML: &str = include_str!("../../models/wam7_bh280.toml");

/// The meshes that the URDF names, each a convex prism as Wavefront OBJ: file name, text.
pub const MESHES: [(&str, &str); 4] = [
    ("palm.obj", include_str!("../../models/palm.obj")),
    ("finger_knuckle.obj", include_str!("../../models/finger_knuckle.obj")),
    ("finger_inner.obj", include_str!("../../models/finger_inner.obj")),
    ("fingertip.obj", include_str!("../../models/fingertip.obj")),
];

/// The text of a mesh by the file name in the URDF.
pub fn mesh(file: &str) -> Option<&'static str> {
    MESHES.iter().find(|(name, _)| *name == file).map(|(_, text)| *text)
}
