//! Where points are shaded in each cluster.

use glam::Vec3;
use pt_scene::{Bounds, Clusters, Scene};

/// By how much of its size the box of a scene in which something moves is extended to each side: things move out of where they are
/// now.
const GROWTH: f32 = 0.25;

/// The box of the points that are shaded in a cluster.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClusterBox {
    /// World space.
    pub bounds: Bounds,
    /// Whether points outside of `bounds` may be shaded too: the cell is infinite and something that moves may get there.
    pub open: bool,
}

/// The boxes of all clusters of a scene.
///
/// If everything stands still, they are the bounds of the surfaces in each cell. Otherwise they are the cells themselves, because a
/// moving object may be anywhere; infinite faces are replaced by the scene's bounds, extended by a quarter of their size. A cell
/// without any surface always has its whole box: rounding may put a point on the wrong side of a plane.
pub fn cluster_boxes(scene: &Scene, clusters: &Clusters) -> Vec<ClusterBox> {
    let moves = scene.instances.iter().any(|i| !i.is_static(&scene.meshes[i.mesh as usize]));
    let contents = if moves { Vec::new() } else { clusters.contents(scene) };
    let scene = scene.bounds().unwrap_or(Bounds { min: Vec3::ZERO, max: Vec3::ZERO });
    let growth = GROWTH * scene.size();
    let outer = Bounds { min: scene.min - growth, max: scene.max + growth };
    let clip = |cluster: u32| {
        let cell = clusters.cell(cluster);
        let (below, above) = (cell.min.cmpeq(Vec3::NEG_INFINITY), cell.max.cmpeq(Vec3::INFINITY));
        let bounds = Bounds {
            min: Vec3::select(below, outer.min.min(cell.max), cell.min),
            max: Vec3::select(above, outer.max.max(cell.min), cell.max),
        };
        ClusterBox { bounds, open: below.any() || above.any() }
    };
    (0..clusters.count() as u32)
        .map(|cluster| match contents.get(cluster as usize).and_then(|c| c.bounds) {
            Some(bounds) => ClusterBox { bounds, open: false },
            None => clip(cluster),
        })
        .collect()
}
