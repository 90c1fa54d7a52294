//! Right prism over a convex polygon: the collision shape of every hand link.

/// A convex polygon in the local x-y plane, extruded along the local z axis.
///
/// Every hand link is one prism in its own link frame (boxes are prisms too), so that world, planner and
/// estimator agree on the cross-sections: a study showed that links modelled 6 mm too thin spoil most updates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prism {
    /// Corners of the polygon, metres, anticlockwise seen from +z, convex.
    pub corners_m: &'static [[f32; 2]],
    /// Lower and upper face, metres along z.
    pub z_m: [f32; 2],
}
