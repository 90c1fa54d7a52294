//! The surfaces of shapes as points, for viewers that draw clouds of points but no solids.

use super::convert::{pose, timestamp};
use foxglove::messages::{PackedElementField, PointCloud, packed_element_field::NumericType};
use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use rapier3d::prelude::{SharedShape, TypedShape};

/// Distance between neighbours, metres.
const STEP_M: f32 = 0.012;
/// It is at least this share of the shape's longest extent.
const STEP_SHARE: f32 = 1.0 / 40.0;
/// Bytes of a point: its place and its colour.
const POINT_BYTES: u32 = 16;

/// A body's shapes, posed in its frame, as points in one colour.
///
/// # Errors
/// A shape that is none of those that worlds are made of.
pub fn cloud<'a>(
    tick: u32,
    frame: &str,
    shapes: impl IntoIterator<Item = (&'a Isometry3<f32>, &'a SharedShape)>,
    rgb: [u8; 3],
) -> anyhow::Result<PointCloud> {
    let mut data = Vec::new();
    for (at, shape) in shapes {
        for point in points(shape)? {
            (at * point).iter().for_each(|metres| data.extend(metres.to_le_bytes()));
            data.extend(rgb);
            data.push(u8::MAX);
        }
    }
    let field =
        |name: &str, offset, of: NumericType| PackedElementField { name: name.to_owned(), offset, r#type: of.into() };
    let places = ["x", "y", "z"].into_iter().zip([0, 4, 8]).map(|(name, at)| field(name, at, NumericType::Float32));
    let colors =
        ["red", "green", "blue", "alpha"].into_iter().zip(12..).map(|(name, at)| field(name, at, NumericType::Uint8));
    Ok(PointCloud {
        timestamp: Some(timestamp(tick)),
        frame_id: frame.to_owned(),
        pose: Some(pose(&Isometry3::identity())),
        point_stride: POINT_BYTES,
        fields: places.chain(colors).collect(),
        data: data.into(),
    })
}

/// Points on a shape's surface, in the shape's frame.
fn points(shape: &SharedShape) -> anyhow::Result<Vec<Point3<f32>>> {
    let longest_m = shape.compute_local_aabb().extents().max_element();
    let mut surface = Surface { step_m: STEP_M.max(STEP_SHARE * longest_m), points: Vec::new() };
    match shape.as_typed_shape() {
        TypedShape::Cuboid(cuboid) => surface.add_box(cuboid.half_extents.to_array()),
        TypedShape::Cylinder(c) => {
            let (r, h) = (c.radius, c.half_height);
            surface.add_turned(&[[0.0, -h], [r, -h], [r, h], [0.0, h]], &Isometry3::identity());
        }
        TypedShape::Ball(ball) => surface.add_capsule(ball.radius, 0.0, &Isometry3::identity()),
        TypedShape::Capsule(capsule) => {
            let [a, b] = [capsule.segment.a, capsule.segment.b].map(|end| Vector3::from(end.to_array()));
            let along = UnitQuaternion::rotation_between(&Vector3::y(), &(b - a)).unwrap_or_default();
            let middle = Isometry3::from_parts(((a + b) / 2.0).into(), along);
            surface.add_capsule(capsule.radius, (b - a).norm() / 2.0, &middle);
        }
        TypedShape::ConvexPolyhedron(hull) => {
            let (corners, triangles) = hull.to_trimesh();
            for triangle in triangles {
                surface.add_triangle(triangle.map(|i| Point3::from(corners[i as usize].to_array())));
            }
        }
        other => anyhow::bail!("a recording cannot show a shape of the kind {other:?}"),
    }
    Ok(surface.points)
}

/// Points on a surface, a step apart.
struct Surface {
    step_m: f32,
    points: Vec<Point3<f32>>,
}

impl Surface {
    /// So many steps are on such a length.
    fn steps(&self, length_m: f32) -> u16 {
        libm::ceilf(length_m / self.step_m) as u16
    }

    /// Places 0..=1 along such a length, both ends among them.
    fn shares(&self, length_m: f32) -> impl Iterator<Item = f32> + use<> {
        let steps = self.steps(length_m);
        (0..=steps).map(move |i| f32::from(i) / f32::from(steps.max(1)))
    }

    fn add_line(&mut self, from: Point3<f32>, to: Point3<f32>) {
        self.points.extend(self.shares((to - from).norm()).map(|share| from + (to - from) * share));
    }

    /// Lines from one edge to the other.
    fn add_face(&mut self, [a, b]: [Point3<f32>; 2], [c, d]: [Point3<f32>; 2]) {
        for share in self.shares((b - a).norm().max((d - c).norm())) {
            self.add_line(a + (b - a) * share, c + (d - c) * share);
        }
    }

    fn add_box(&mut self, half_m: [f32; 3]) {
        for (normal, side) in (0..3).flat_map(|axis| [(axis, -1.0), (axis, 1.0)]) {
            let corner = |u: f32, v: f32| {
                let mut corner = Point3::from(half_m);
                corner[normal] *= side;
                corner[(normal + 1) % 3] *= u;
                corner[(normal + 2) % 3] *= v;
                corner
            };
            self.add_face([corner(-1.0, -1.0), corner(1.0, -1.0)], [corner(-1.0, 1.0), corner(1.0, 1.0)]);
        }
    }

    /// From the corner opposite to the shortest edge, so that points are a step apart on a slim triangle too.
    fn add_triangle(&mut self, corners: [Point3<f32>; 3]) {
        let [first, second, tip] = (0..3)
            .map(|i| [corners[i], corners[(i + 1) % 3], corners[(i + 2) % 3]])
            .min_by(|a, b| (a[1] - a[0]).norm().total_cmp(&(b[1] - b[0]).norm()))
            .unwrap_or(corners);
        self.add_face([tip, first], [tip, second]);
    }

    /// What a line of [distance from the axis, place along the axis] passes over as it turns about the y axis of `at`.
    fn add_turned(&mut self, line: &[[f32; 2]], at: &Isometry3<f32>) {
        for ends in line.windows(2) {
            let [[r0, y0], [r1, y1]] = [ends[0], ends[1]];
            for share in self.shares(libm::hypotf(r1 - r0, y1 - y0)) {
                self.add_ring(r0 + (r1 - r0) * share, y0 + (y1 - y0) * share, at);
            }
        }
    }

    fn add_ring(&mut self, radius_m: f32, y_m: f32, at: &Isometry3<f32>) {
        let count = self.steps(core::f32::consts::TAU * radius_m).max(1);
        self.points.extend((0..count).map(|i| {
            let (sin, cos) = libm::sincosf(core::f32::consts::TAU * f32::from(i) / f32::from(count));
            at * Point3::new(radius_m * cos, y_m, radius_m * sin)
        }));
    }

    fn add_capsule(&mut self, radius_m: f32, half_m: f32, at: &Isometry3<f32>) {
        let quarter = core::f32::consts::FRAC_PI_2;
        let end: Vec<[f32; 2]> = self
            .shares(quarter * radius_m)
            .map(|share| {
                let (sin, cos) = libm::sincosf(quarter * share);
                [radius_m * cos, half_m + radius_m * sin]
            })
            .collect();
        let line: Vec<[f32; 2]> = end.iter().rev().map(|[r, y]| [*r, -y]).chain(end.iter().copied()).collect();
        self.add_turned(&line, at);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rapier3d::prelude::Vector;

    #[test]
    fn points_lie_on_the_surface_everywhere_and_close_together() {
        let corners: Vec<Vector> =
            [[0.0; 3], [0.2, 0.0, 0.0], [0.2, 0.01, 0.0], [0.0, 0.1, 0.2]].map(Vector::from).to_vec();
        let shapes = [
            SharedShape::cuboid(0.05, 0.1, 0.02),
            SharedShape::cylinder(0.08, 0.03),
            SharedShape::ball(0.06),
            SharedShape::capsule(Vector::new(-0.05, 0.0, 0.01), Vector::new(0.1, 0.0, 0.01), 0.03),
            SharedShape::convex_hull(&corners).unwrap(),
        ];
        for shape in shapes {
            let kind = shape.shape_type();
            let points = points(&shape).unwrap();
            assert!((50..5000).contains(&points.len()), "{kind:?}: {}", points.len());
            for point in &points {
                let place = Vector::from(<[f32; 3]>::from(*point));
                let off_m = shape.project_local_point(place, false).point.distance(place);
                assert!(off_m < 1e-4, "{kind:?}: {point} is {off_m} m off the surface");
            }
            let (low, high) = points.iter().fold((points[0], points[0]), |(low, high), p| (low.inf(p), high.sup(p)));
            let bounds = shape.compute_local_aabb();
            for (found, expected) in [(low, bounds.mins), (high, bounds.maxs)] {
                let short_m = (found - Point3::from(expected.to_array())).norm();
                assert!(short_m < 2e-3, "{kind:?}: {found} instead of {expected}");
            }
            let next_m = |i: usize| {
                let others =
                    points.iter().enumerate().filter(|(j, other)| *j != i && (**other - points[i]).norm() > 1e-6);
                others.map(|(_, other)| (other - points[i]).norm()).fold(f32::INFINITY, f32::min)
            };
            let widest_m = (0..points.len()).map(next_m).fold(0.0, f32::max);
            assert!(widest_m <= STEP_M * 1.01, "{kind:?}: {widest_m}");
        }
    }

    #[test]
    fn a_cloud_holds_a_place_and_a_colour_for_each_point() {
        let shape = SharedShape::cuboid(0.001, 0.001, 0.001);
        let cloud = cloud(5, "table", [(&Isometry3::translation(1.0, 2.0, 3.0), &shape)], [1, 2, 3]).unwrap();
        assert_eq!((cloud.frame_id.as_str(), cloud.point_stride), ("table", POINT_BYTES));
        assert_eq!(cloud.data.len(), 24 * POINT_BYTES as usize, "four corners of each of six faces");
        let number = |at: usize| f32::from_le_bytes(cloud.data[at..at + 4].try_into().unwrap());
        assert!((number(0) - 1.0).abs() < 2e-3 && (number(4) - 2.0).abs() < 2e-3 && (number(8) - 3.0).abs() < 2e-3);
        assert_eq!(cloud.data[12..16], [1, 2, 3, 255]);
    }
}
