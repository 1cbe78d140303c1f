use glam::Vec3;

/// Most portals that samplers look at: each sample of the environment looks at all of them.
pub const MAX_PORTALS: usize = 32;

/// A parallelogram that the environment shines through into a room, such as a window. It has no effect on the mean of an image: it tells where
/// directions of the environment are worth a sample. Both sides count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Portal {
    /// One corner, world space, metres.
    pub corner: Vec3,
    /// From there to the two next ones.
    pub edges: [Vec3; 2],
}

impl Portal {
    /// Whether it has an area that samplers can see.
    pub fn has_area(&self) -> bool {
        let [a, b] = self.edges;
        self.corner.is_finite() && a.is_finite() && b.is_finite() && a.cross(b).length() > 1e-12
    }
}
