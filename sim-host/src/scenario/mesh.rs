//! Meshes from files: Wavefront OBJ and STL, as triangles between shared corners.

use std::collections::BTreeMap;
use std::io::{Cursor, Read};
use std::path::Path;

/// Largest mesh file that is read, bytes: a solid of few corners needs a few thousand.
pub const MESH_BYTES_MAX: u64 = 1 << 20;

/// What a mesh file's path begins with if the mesh is one that the program holds.
const BUILT_IN: &str = "built-in:";

/// The meshes that the program holds.
const MESHES: &[(&str, &[u8])] =
    &[("hexagonal_prism.obj", include_bytes!("../../scenarios/meshes/hexagonal_prism.obj").as_slice())];

/// Triangles between corners; anticlockwise from outside, or all clockwise.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Corners, in the file's unit.
    pub corners: Vec<[f64; 3]>,
    /// Indices of corners.
    pub triangles: Vec<[usize; 3]>,
}

/// Reads a mesh; a relative path is meant from `folder`. The error is one line without the file's name.
///
/// # Errors
/// The file cannot be read, is too large, is neither OBJ nor STL by its ending and its contents, or holds a number that
/// is not finite.
pub fn read(file: &Path, folder: &Path) -> Result<Mesh, String> {
    let built_in = file.to_str().and_then(|name| name.strip_prefix(BUILT_IN));
    let bytes = match built_in {
        Some(name) => built_in_mesh(name)?.to_vec(),
        None => read_bounded(&folder.join(file), MESH_BYTES_MAX)?,
    };
    let ending = file.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    let corners_and_triangles = match ending.as_str() {
        "obj" => parse_obj(&bytes)?,
        "stl" => parse_stl(&bytes)?,
        _ => return Err("expected a file that ends in .obj or .stl".to_owned()),
    };
    shared(corners_and_triangles)
}

fn built_in_mesh(name: &str) -> Result<&'static [u8], String> {
    let names = || MESHES.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
    let found = MESHES.iter().find(|(known, _)| *known == name).map(|(_, bytes)| *bytes);
    found.ok_or_else(|| format!("no such built-in mesh; expected one of: {}", names()))
}

/// The bytes of a file that must not be larger than `bytes_max`; no more than that is ever read.
///
/// # Errors
/// It cannot be read, or is larger: one line without the file's name.
pub fn read_bounded(path: &Path, bytes_max: u64) -> Result<Vec<u8>, String> {
    let file = std::fs::File::open(path).map_err(|e| e.to_string())?;
    let mut bytes = Vec::new();
    file.take(bytes_max + 1).read_to_end(&mut bytes).map_err(|e| e.to_string())?;
    if bytes.len() as u64 > bytes_max {
        return Err(format!("larger than {} KiB, the most that is read", bytes_max >> 10));
    }
    Ok(bytes)
}

/// Corners by their coordinates, three a triangle.
type Soup = Vec<[[f32; 3]; 3]>;

fn parse_obj(bytes: &[u8]) -> Result<Soup, String> {
    let options =
        tobj::LoadOptions { triangulate: true, ignore_points: true, ignore_lines: true, ..Default::default() };
    // Colours are of no use here: materials are left unread.
    let no_materials = |_: &Path| Ok(Default::default());
    let (models, _) = tobj::load_obj_buf(&mut Cursor::new(bytes), &options, no_materials)
        .map_err(|e| format!("not a Wavefront OBJ file ({e})"))?;
    let mut soup = Soup::new();
    for tobj::Model { mesh, .. } in &models {
        let corner = |index: &u32| mesh.positions.chunks_exact(3).nth(*index as usize).map(|p| [p[0], p[1], p[2]]);
        for triangle in mesh.indices.chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|k| corner(&triangle[k]));
            let known = |corner: Option<[f32; 3]>| corner.ok_or("a face names a vertex that the file does not have");
            soup.push([known(a)?, known(b)?, known(c)?]);
        }
    }
    Ok(soup)
}

fn parse_stl(bytes: &[u8]) -> Result<Soup, String> {
    let mut cursor = Cursor::new(bytes);
    let triangles = stl_io::create_stl_reader(&mut cursor).map_err(|e| format!("not an STL file ({e})"))?;
    triangles
        .map(|triangle| triangle.map(|t| t.vertices.map(Into::into)).map_err(|e| format!("not an STL file ({e})")))
        .collect()
}

/// Corners with the same coordinates are one.
fn shared(soup: Soup) -> Result<Mesh, String> {
    let mut mesh = Mesh { corners: Vec::new(), triangles: Vec::new() };
    let mut known: BTreeMap<[u32; 3], usize> = BTreeMap::new();
    for (number, triangle) in soup.iter().enumerate() {
        let mut indices = [0; 3];
        for (index, corner) in indices.iter_mut().zip(triangle) {
            if !corner.iter().all(|x| x.is_finite()) {
                return Err(format!("triangle {}: a corner is at {corner:?}; expected finite numbers", number + 1));
            }
            // Adding zero makes -0 and 0 one number.
            let key = corner.map(|x| (x + 0.0).to_bits());
            *index = *known.entry(key).or_insert_with(|| {
                mesh.corners.push(corner.map(f64::from));
                mesh.corners.len() - 1
            });
        }
        mesh.triangles.push(indices);
    }
    if mesh.triangles.len() < 4 {
        return Err(format!("{} triangles; a solid needs at least four", mesh.triangles.len()));
    }
    Ok(mesh)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TETRAHEDRON: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";

    fn read_text(name: &str, bytes: &[u8]) -> Result<Mesh, String> {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(name), bytes).unwrap();
        read(Path::new(name), folder.path())
    }

    #[test]
    fn the_same_solid_is_read_from_obj_and_from_both_forms_of_stl() {
        let obj = read_text("a.obj", TETRAHEDRON.as_bytes()).unwrap();
        assert_eq!((obj.corners.len(), obj.triangles.len()), (4, 4));
        let corner = |i: usize| stl_io::Vertex::new(obj.corners[i].map(|x| x as f32));
        let stl: Vec<stl_io::Triangle> = obj
            .triangles
            .iter()
            .map(|t| stl_io::Triangle { normal: stl_io::Normal::new([0.0; 3]), vertices: t.map(corner) })
            .collect();
        let mut binary = Vec::new();
        stl_io::write_stl(&mut binary, stl.iter()).unwrap();
        assert_eq!(read_text("a.STL", &binary).unwrap(), obj);
        let mut ascii = "solid a\n".to_owned();
        for triangle in &stl {
            ascii += "facet normal 0 0 0\nouter loop\n";
            for v in triangle.vertices {
                ascii += &format!("vertex {} {} {}\n", v.0[0], v.0[1], v.0[2]);
            }
            ascii += "endloop\nendfacet\n";
        }
        assert_eq!(read_text("a.stl", (ascii + "endsolid a\n").as_bytes()).unwrap(), obj);
    }

    #[test]
    fn what_is_no_mesh_is_refused_in_one_line() {
        let noise: Vec<u8> = (0..200_000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
        for (name, bytes, expected) in [
            ("noise.obj", &noise[..], "not a Wavefront OBJ"),
            ("noise.stl", &noise, "not an STL"),
            ("a.ply", TETRAHEDRON.as_bytes(), ".obj or .stl"),
            ("empty.obj", b"", "0 triangles"),
            ("short.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "at least four"),
            ("gap.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", ""),
            ("nan.obj", TETRAHEDRON.replace("v 1 0 0", "v nan 0 0").as_bytes(), "finite"),
            ("infinite.obj", TETRAHEDRON.replace("v 1 0 0", "v 1e99 0 0").as_bytes(), "finite"),
        ] {
            let told = read_text(name, bytes).unwrap_err();
            assert!(told.contains(expected) && !told.contains('\n'), "{name}: {told}");
        }
        let large = read_text("large.obj", &vec![b'#'; MESH_BYTES_MAX as usize + 1]).unwrap_err();
        assert!(large.contains("larger than 1024 KiB"), "{large}");
        assert!(read(Path::new("/nonexistent/a.obj"), Path::new("")).unwrap_err().contains("No such file"));
        assert!(read(Path::new("built-in:nothing.obj"), Path::new("")).unwrap_err().contains("hexagonal_prism.obj"));
    }
}
