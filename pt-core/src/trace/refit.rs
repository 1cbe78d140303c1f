//! Refitting of the compute backend's trees on the device: same topology, new boxes (`bvh_refit.comp`).
//!
//! Refitting is cheap. A refitted tree is as good as a new one while the mesh roughly keeps its shape; otherwise it stays correct but
//! becomes slower to trace.

use super::bvh::levels;
use super::push::{NodeBounds, RefitNode, RefitPush};
use crate::buffer::{Buffer, Location};
use crate::device::Device;
use crate::error::Result;
use crate::frame::Frame;
use crate::kernel::Kernel;
use crate::kernels;
use obvhs::cwbvh::CwBvh;

/// Threads per row of the launch: devices must support only 65,535 workgroups per row.
const ROW: u32 = 1 << 20;

/// The nodes of all deforming meshes, level by level.
pub(super) struct Refit {
    kernel: Kernel,
    nodes: Buffer,
    bounds: Buffer,
    /// From the deepest to the roots.
    levels: Vec<Level>,
}

/// Nodes that are refitted by one pass.
struct Level {
    /// Name of the pass; the roots are level 1.
    pass: String,
    /// First entry in the list of nodes.
    first: u32,
    count: u32,
}

impl Refit {
    /// For the trees of meshes that deform, each with the index of its mesh; `None` without any.
    pub(super) fn new<'a>(
        device: &Device,
        trees: impl Iterator<Item = (u32, &'a CwBvh)>,
    ) -> Result<Option<Self>> {
        let mut by_level: Vec<Vec<RefitNode>> = Vec::new();
        let mut bounds = 0;
        for (mesh, tree) in trees {
            for (node, level) in (0..).zip(levels(&tree.nodes)) {
                let level = level as usize;
                by_level.resize_with(by_level.len().max(level), Vec::new);
                by_level[level - 1].push(RefitNode { mesh, node, bounds });
            }
            bounds += tree.nodes.len() as u32;
        }
        if bounds == 0 {
            return Ok(None);
        }
        let mut levels = Vec::new();
        let mut nodes = Vec::new();
        for (level, of_level) in by_level.iter().enumerate().rev() {
            let (first, count) = (nodes.len() as u32, of_level.len() as u32);
            levels.push(Level { pass: format!("refit level {}", level + 1), first, count });
            nodes.extend_from_slice(of_level);
        }
        let bytes = u64::from(bounds) * size_of::<NodeBounds>() as u64;
        Ok(Some(Self {
            kernel: Kernel::compute::<RefitPush>(device, &kernels::BVH_REFIT, &[])?,
            nodes: Buffer::from_slice(device, "refit nodes", &nodes)?,
            bounds: Buffer::new(device, "refit bounds", bytes, Location::Device)?,
            levels,
        }))
    }

    /// Records the passes, one a level. `meshes` is the `MeshRecord` table with the new positions' addresses, `read` are the
    /// buffers that these and the indices lie in, `trees` those of the nodes and triangles.
    pub(super) fn record<'a>(
        &'a self,
        frame: &mut Frame<'_>,
        meshes: &Buffer,
        read: &[&Buffer],
        trees: impl Iterator<Item = &'a Buffer> + Clone,
    ) -> Result<()> {
        for Level { pass, first, count } in &self.levels {
            let (first, count) = (*first, *count);
            let push = RefitPush {
                meshes: meshes.address(),
                nodes: self.nodes.address(),
                bounds: self.bounds.address(),
                first,
                count,
                width: count.min(ROW),
                pad: 0,
            };
            let pass = frame.pass(pass, &self.kernel).push(&push);
            let tables = [meshes, &self.nodes].into_iter().chain(read.iter().copied());
            let pass = tables.fold(pass, |pass, b| pass.addresses(b));
            let pass = trees.clone().chain([&self.bounds]).fold(pass, |pass, b| pass.addresses_updated(b));
            pass.dispatch([push.width, count.div_ceil(push.width), 1])?;
        }
        Ok(())
    }
}
