//! What a viewer shows: every body's shapes in its frame, the believed object as a ghost, forces as arrows.

use super::convert::{point, pose, timestamp, vector};
use super::{points, solid};
use crate::solid::Solid;
use crate::world::view::{Body, HandForce, Kind};
use foxglove::messages::{
    ArrowPrimitive, Color, KeyValuePair, LinePrimitive, Point3, PointCloud, SceneEntity, SceneUpdate, line_primitive,
};
use nalgebra::{Isometry3, Matrix2, SymmetricEigen, UnitQuaternion, Vector2, Vector3};
use tactus_common::message::{Setup, Status};
use tactus_common::pose::PlanarPose;

/// The frame that all others are posed in: z up, origin on the table top's centre.
pub const WORLD: &str = "world";
/// The frame of the believed object.
pub const BELIEVED: &str = "believed_object";
/// Length of an arrow for one newton, metres.
const ARROW_M_PER_N: f64 = 0.01;
/// Corners of the ellipse.
const ELLIPSE_CORNERS: u16 = 64;
/// Lines on the table lie this much above it, metres.
const ABOVE_TABLE_M: f32 = 0.001;
/// 99 % of a normal distribution in one dimension lie within so many standard deviations, in two within the root of 9.21.
const DEVIATIONS_99: [f32; 2] = [2.576, 3.035];

/// Colours that readers with any kind of colour vision can tell apart (Okabe and Ito 2008): truth orange, belief blue, forces
/// vermilion; robot and table grey.
const fn color([r, g, b]: [u8; 3], a: f64) -> Color {
    Color { r: r as f64 / 255.0, g: g as f64 / 255.0, b: b as f64 / 255.0, a }
}
const BLUE: [u8; 3] = [0, 114, 178];
const VERMILION: [u8; 3] = [213, 94, 0];

const fn rgb_of(kind: Kind) -> [u8; 3] {
    match kind {
        Kind::Arm => [176, 182, 190],
        Kind::Hand => [110, 118, 128],
        Kind::Table => [214, 208, 196],
        Kind::Object => [230, 159, 0],
        Kind::Loose => [240, 228, 66],
        Kind::Obstacle => [150, 120, 110],
    }
}

const fn kind_name(kind: Kind) -> &'static str {
    match kind {
        Kind::Arm => "arm",
        Kind::Hand => "hand",
        Kind::Table => "table",
        Kind::Object => "object",
        Kind::Loose => "loose",
        Kind::Obstacle => "obstacle",
    }
}

/// An entity of a frame, with its kind as metadata.
fn entity(tick: u32, frame: &str, id: &str, kind: &str) -> SceneEntity {
    SceneEntity {
        timestamp: Some(timestamp(tick)),
        frame_id: frame.to_owned(),
        id: id.to_owned(),
        frame_locked: true,
        metadata: vec![KeyValuePair { key: "kind".to_owned(), value: kind.to_owned() }],
        ..SceneEntity::default()
    }
}

fn update(entities: Vec<SceneEntity>) -> SceneUpdate {
    SceneUpdate { deletions: Vec::new(), entities }
}

/// All bodies, each in its own frame.
///
/// # Errors
/// A shape that cannot be shown.
pub fn bodies(tick: u32, bodies: &[Body]) -> anyhow::Result<SceneUpdate> {
    let shown = bodies.iter().map(|body| {
        let mut entity = entity(tick, &body.name, &body.name, kind_name(body.kind));
        for (at, shape) in &body.shapes {
            solid::add(&mut entity, at, shape, color(rgb_of(body.kind), 1.0))?;
        }
        Ok(entity)
    });
    Ok(update(shown.collect::<anyhow::Result<_>>()?))
}

/// The surfaces of a body as points, in its own frame.
///
/// # Errors
/// A shape that cannot be shown.
pub fn body_points(tick: u32, body: &Body) -> anyhow::Result<PointCloud> {
    points::cloud(tick, &body.name, body.shapes.iter().map(|(at, shape)| (at, shape)), rgb_of(body.kind))
}

/// The surface of the believed object as points, in its own frame.
///
/// # Errors
/// A shape that cannot be shown.
pub fn believed_points(tick: u32, setup: &Setup) -> anyhow::Result<PointCloud> {
    let told = Solid::new(&setup.shape).map(|told| (told.in_body.into(), told.shape));
    points::cloud(tick, BELIEVED, told.iter().map(|(at, shape)| (at, shape)), BLUE)
}

/// The believed object as a ghost; the ellipse on the table that holds its position by 99 %, and the wedge of its yaw.
///
/// # Errors
/// A shape that cannot be shown.
pub fn belief(setup: &Setup, status: &Status) -> anyhow::Result<SceneUpdate> {
    let mut ghost = entity(status.tick, BELIEVED, "belief", "belief");
    // One that is not valid has no solid; the controller refuses it.
    if let Some(told) = Solid::new(&setup.shape) {
        solid::add(&mut ghost, &told.in_body.into(), &told.shape, color(BLUE, 0.35))?;
    }
    let mut region = entity(status.tick, WORLD, "belief_region", "belief");
    let reach_m = setup.shape.half_extents_m().into_iter().take(2).fold(0.0, f32::max);
    region.lines.push(line(ellipse(&status.belief, &status.covariance), line_primitive::Type::LineLoop));
    region
        .lines
        .push(line(wedge(&status.belief, status.covariance[5], 1.5 * reach_m), line_primitive::Type::LineStrip));
    Ok(update(vec![ghost, region]))
}

fn line(points: Vec<Point3>, of: line_primitive::Type) -> LinePrimitive {
    LinePrimitive {
        r#type: of.into(),
        pose: Some(pose(&Isometry3::identity())),
        thickness: 2.0,
        scale_invariant: true,
        points,
        color: Some(color(BLUE, 1.0)),
        ..LinePrimitive::default()
    }
}

fn on_table(x_m: f32, y_m: f32) -> Point3 {
    point([x_m, y_m, ABOVE_TABLE_M])
}

/// The 99 % region of the position.
fn ellipse(belief: &PlanarPose, covariance: &[f32; 6]) -> Vec<Point3> {
    let [xx, xy, _, yy, ..] = *covariance;
    let axes = SymmetricEigen::new(Matrix2::new(xx, xy, xy, yy));
    let half_m = axes.eigenvalues.map(|variance| DEVIATIONS_99[1] * libm::sqrtf(variance.max(0.0)));
    let corner = |i: u16| {
        let (sin, cos) = libm::sincosf(core::f32::consts::TAU * f32::from(i) / f32::from(ELLIPSE_CORNERS));
        let from_centre = axes.eigenvectors * Vector2::new(half_m.x * cos, half_m.y * sin);
        on_table(belief.x_m + from_centre.x, belief.y_m + from_centre.y)
    };
    (0..ELLIPSE_CORNERS).map(corner).collect()
}

/// The 99 % region of the yaw: the object's x axis turned as far as it may be, either way.
fn wedge(belief: &PlanarPose, variance_rad2: f32, length_m: f32) -> Vec<Point3> {
    let half_rad = (DEVIATIONS_99[0] * libm::sqrtf(variance_rad2.max(0.0))).min(core::f32::consts::PI);
    let end = |turn_rad: f32| {
        let (sin, cos) = libm::sincosf(belief.phi_rad + turn_rad);
        on_table(belief.x_m + length_m * cos, belief.y_m + length_m * sin)
    };
    vec![end(-half_rad), on_table(belief.x_m, belief.y_m), end(half_rad)]
}

/// Forces as arrows that end where they act.
pub fn contacts(tick: u32, forces: &[HandForce]) -> SceneUpdate {
    let mut shown = entity(tick, WORLD, "contacts", "contacts");
    shown.arrows = forces.iter().map(arrow).collect();
    update(vec![shown])
}

fn arrow(force: &HandForce) -> ArrowPrimitive {
    let length_m = ARROW_M_PER_N * f64::from(force.force_n.norm());
    let along = UnitQuaternion::rotation_between(&Vector3::x(), &force.force_n)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::z_axis(), core::f32::consts::PI));
    let start = force.point_m - force.force_n * ARROW_M_PER_N as f32;
    let head_m = length_m.min(0.012);
    ArrowPrimitive {
        pose: Some(foxglove::messages::Pose {
            position: Some(vector(start.coords.into())),
            orientation: Some(super::convert::quaternion(&along)),
        }),
        shaft_length: length_m - head_m,
        shaft_diameter: 0.004,
        head_length: head_m,
        head_diameter: 0.009,
        color: Some(color(VERMILION, 1.0)),
    }
}
