//! The hand's joints, shapes and taxels, checked against one another.

use crate::model::{FILE, body, expect_axis, expect_links, joint, link, origin};
use crate::settings::{self, Settings};
use crate::spatial::{Body, Frame, about_z};
use urdf_rs::{Geometry, Joint, JointType, Link, Robot};

/// The hand's joints by kind, in finger order.
pub struct Joints<'a> {
    pub spread: [&'a Joint; 2],
    pub inner: [&'a Joint; 3],
    pub tip: [&'a Joint; 3],
}

/// A right prism along its link's z: corners anticlockwise, lower and upper face, metres.
pub struct Prism {
    pub corners_m: Vec<[f64; 2]>,
    pub z_m: [f64; 2],
}

/// One tactile cell: centre and outward normal in its pad's frame, area.
pub struct Taxel {
    pub centre_m: [f64; 3],
    pub normal: [f64; 3],
    pub area_m2: f64,
}

/// Looks up the joints and checks that they connect the links as the hand's kinematics assumes.
pub fn joints<'a>(robot: &'a Robot, s: &Settings) -> Result<Joints<'a>, String> {
    let (h, l) = (&s.hand, &s.hand.links);
    let find = |name: &str, parent: &str, child: &str, axis| -> Result<&'a Joint, String> {
        let j = joint(robot, name, JointType::Revolute)?;
        expect_links(j, parent, child)?;
        expect_axis(j, axis)?;
        Ok(j)
    };
    let (z, spread) = ([0.0, 0.0, 1.0], &h.spread_joints);
    let found = Joints {
        spread: [find(&spread[0], &l[0], &l[1], [0.0, -1.0, 0.0])?, find(&spread[1], &l[0], &l[4], [0.0, 1.0, 0.0])?],
        inner: [
            find(&h.inner_joints[0], &l[1], &l[2], z)?,
            find(&h.inner_joints[1], &l[4], &l[5], z)?,
            find(&h.inner_joints[2], &l[0], &l[7], z)?,
        ],
        tip: [
            find(&h.tip_joints[0], &l[2], &l[3], z)?,
            find(&h.tip_joints[1], &l[5], &l[6], z)?,
            find(&h.tip_joints[2], &l[7], &l[8], z)?,
        ],
    };
    mimic(found.spread[1], &h.spread_joints[0], 1.0)?;
    for (tip, inner) in found.tip.iter().zip(&h.inner_joints) {
        mimic(tip, inner, h.drive.gear_inner / h.drive.gear_distal_engaged)?;
        if (tip.limit.lower, tip.limit.upper) != (found.tip[0].limit.lower, found.tip[0].limit.upper) {
            return Err(format!("{FILE}: joint `{}`: limits differ from F1's; expected equal fingers", tip.name));
        }
    }
    for inner in found.inner {
        if (inner.limit.lower, inner.limit.upper) != (found.inner[0].limit.lower, found.inner[0].limit.upper) {
            return Err(format!("{FILE}: joint `{}`: limits differ from F1's; expected equal fingers", inner.name));
        }
    }
    Ok(found)
}

fn mimic(j: &Joint, leader: &str, ratio: f64) -> Result<(), String> {
    let expected = format!(
        "expected <mimic joint=\"{leader}\" multiplier=\"{ratio}\" offset=\"0\"/> (from the gears in the TOML)"
    );
    let Some(m) = &j.mimic else { return Err(format!("{FILE}: joint `{}` has no <mimic>; {expected}", j.name)) };
    let same =
        m.joint == leader && (m.multiplier.unwrap_or(1.0) - ratio).abs() < 1e-9 && m.offset.unwrap_or(0.0) == 0.0;
    if same { Ok(()) } else { Err(format!("{FILE}: joint `{}` mimics {m:?}; {expected}", j.name)) }
}

/// The link's collision shape as a prism in its own frame.
pub fn prism(link: &Link, mesh: &dyn Fn(&str) -> Result<String, String>) -> Result<Prism, String> {
    let name = &link.name;
    let [collision] = link.collision.as_slice() else {
        return Err(format!(
            "{FILE}: link `{name}` has {} collision shapes; expected one box or mesh",
            link.collision.len()
        ));
    };
    if collision.origin.rpy.0 != [0.0; 3] {
        return Err(format!("{FILE}: link `{name}`: its collision shape is turned; expected rpy 0 0 0"));
    }
    let at = collision.origin.xyz.0;
    let (corners, z) = match &collision.geometry {
        Geometry::Box { size } => {
            let [x, y, z] = size.0.map(|s| 0.5 * s);
            (vec![[-x, -y], [x, -y], [x, y], [-x, y]], [-z, z])
        }
        Geometry::Mesh { filename, scale: None } => read_prism(filename, &mesh(filename)?)?,
        other => {
            return Err(format!(
                "{FILE}: link `{name}`: collision shape {other:?}; expected a box or an unscaled mesh"
            ));
        }
    };
    let corners_m: Vec<_> = corners.iter().map(|c| [c[0] + at[0], c[1] + at[1]]).collect();
    convex(name, &corners_m)?;
    Ok(Prism { corners_m, z_m: [z[0] + at[2], z[1] + at[2]] })
}

/// Reads the vertices of an OBJ that holds a prism: a ring at the lower face, then the same ring at the upper.
fn read_prism(file: &str, text: &str) -> Result<(Vec<[f64; 2]>, [f64; 2]), String> {
    let mut vertices = Vec::new();
    for (index, line) in text.lines().enumerate() {
        if let Some(rest) = line.strip_prefix("v ") {
            let numbers: Vec<f64> =
                rest.split_whitespace().filter_map(|w| w.parse().ok()).filter(|x: &f64| x.is_finite()).collect();
            let vertex = <[f64; 3]>::try_from(numbers)
                .map_err(|_| format!("models/{file}: line {}: `{line}`; expected `v x y z`", index + 1))?;
            vertices.push(vertex);
        }
    }
    let (lower, upper) = vertices.split_at(vertices.len() / 2);
    let [Some(first), Some(last)] = [lower.first(), upper.first()] else {
        return Err(format!("models/{file}: {} vertices; expected a prism: two equal rings", vertices.len()));
    };
    let same = lower.len() == upper.len()
        && lower.iter().zip(upper).all(|(a, b)| a[..2] == b[..2] && a[2] == first[2] && b[2] == last[2]);
    if !same || first[2] >= last[2] {
        return Err(format!(
            "models/{file}: not a right prism along z; expected a lower ring of vertices, then the same ring above it"
        ));
    }
    Ok((lower.iter().map(|v| [v[0], v[1]]).collect(), [first[2], last[2]]))
}

fn convex(name: &str, corners: &[[f64; 2]]) -> Result<(), String> {
    let n = corners.len();
    for i in 0..n {
        let [a, b, c] = [corners[i], corners[(i + 1) % n], corners[(i + 2) % n]];
        let turn = (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0]);
        if n < 3 || turn <= 0.0 {
            return Err(format!(
                "{FILE}: link `{name}`: its cross-section turns the wrong way at corner {b:?}; expected convex, anticlockwise"
            ));
        }
    }
    Ok(())
}

/// The 24 cells of a fingertip, checked to lie on the tip's surface within 0.1 mm.
pub fn fingertip_taxels(s: &Settings, tip: &Prism) -> Result<Vec<Taxel>, String> {
    let pad = &s.tactile.fingertip;
    let mut cells = Vec::new();
    for (index, row) in pad.rows_mm_deg.iter().enumerate() {
        let (sin, cos) = row.tilt.to_radians().sin_cos();
        let [x, y] = [row.x * 1e-3, row.y * 1e-3];
        let height = surface_distance(tip, [x, y]);
        if height.abs() > 1e-4 {
            let file = settings::FILE;
            return Err(format!(
                "{file}: tactile.fingertip row {index} lies {height} m off the tip's surface; expected within 0.0001"
            ));
        }
        for z_mm in pad.columns_z_mm {
            cells.push(Taxel {
                centre_m: [x, y, z_mm * 1e-3],
                normal: [sin, cos, 0.0],
                area_m2: row.length * pad.cell_width_mm * 1e-6,
            });
        }
    }
    Ok(cells)
}

/// Largest signed distance of a point to the sides of the cross-section, positive outside.
fn surface_distance(prism: &Prism, p: [f64; 2]) -> f64 {
    let c = &prism.corners_m;
    let side = |i: usize| {
        let (a, b) = (c[i], c[(i + 1) % c.len()]);
        let (x, y) = (b[0] - a[0], b[1] - a[1]);
        ((p[0] - a[0]) * y - (p[1] - a[1]) * x) / x.hypot(y)
    };
    (0..c.len()).map(side).fold(f64::NEG_INFINITY, f64::max)
}

/// The 24 cells of the palm, row by row, in the hand frame.
pub fn palm_taxels(s: &Settings, palm: &Prism) -> Result<Vec<Taxel>, String> {
    let pad = &s.tactile.palm;
    let z = pad.z_mm * 1e-3;
    if (z - palm.z_m[1]).abs() > 1e-4 || (s.hand.palm_face_z_m - palm.z_m[1]).abs() > 1e-9 {
        let file = settings::FILE;
        return Err(format!(
            "{file}: tactile.palm.z_mm and hand.palm_face_z_m must both be the palm shape's upper face, {} m",
            palm.z_m[1]
        ));
    }
    let area_m2 = pad.cell_mm[0] * pad.cell_mm[1] * 1e-6;
    let mut cells = Vec::new();
    for (x_mm, count) in pad.rows_x_mm.iter().zip(pad.row_cells) {
        for k in 0..count {
            let y_mm = (f64::from(k) - 0.5 * f64::from(count - 1)) * pad.pitch_y_mm;
            cells.push(Taxel { centre_m: [x_mm * 1e-3, y_mm * 1e-3, z], normal: [0.0, 0.0, 1.0], area_m2 });
        }
    }
    Ok(cells)
}

/// The hand as one body in its own frame: spread 0, fingers half closed, tips following by their gears.
pub fn lumped(robot: &Robot, s: &Settings, joints: &Joints) -> Result<Body, String> {
    let half = 0.5 * (joints.inner[0].limit.lower + joints.inner[0].limit.upper);
    let still = about_z(0.0);
    let base = Frame { rotation: still, xyz_m: [0.0; 3] };
    let knuckles = [origin(joints.spread[0]), origin(joints.spread[1]), base];
    let mut total = body(link(robot, &s.hand.links[0])?);
    for (finger, knuckle) in knuckles.iter().enumerate() {
        if finger < 2 {
            total = total.joined(&body(link(robot, &joints.spread[finger].child.link)?).seen_through(knuckle));
        }
        let turn = |angle| Frame { rotation: about_z(angle), xyz_m: [0.0; 3] };
        let inner = knuckle.then(&origin(joints.inner[finger])).then(&turn(half));
        let tip = inner
            .then(&origin(joints.tip[finger]))
            .then(&turn(half * s.hand.drive.gear_inner / s.hand.drive.gear_distal_engaged));
        total = total.joined(&body(link(robot, &joints.inner[finger].child.link)?).seen_through(&inner));
        total = total.joined(&body(link(robot, &joints.tip[finger].child.link)?).seen_through(&tip));
    }
    Ok(total)
}
