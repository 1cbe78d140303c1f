//! Launches over lists of rays that an earlier pass has written: the host's side of `ray_list.glsl`.

use pt_shaders::records::{RAY_LIST_SHADING_GROUP, RAY_LIST_TRACE_GROUP, RayListHead};

/// Workgroup of a kernel that traces rays.
const TRACE_GROUP: [u32; 2] = [8, RAY_LIST_TRACE_GROUP / 8];

/// How launches over lists are laid out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RayLists {
    columns: u32,
    most: u64,
}

impl RayLists {
    /// Of lists with at most `most` entries, for an image that is `width` wide.
    pub fn new(width: u32, most: u64) -> Self {
        // A row of a launch is as long for kernels that shade as for those that trace.
        let columns =
            width.div_ceil(TRACE_GROUP[0]).next_multiple_of(RAY_LIST_SHADING_GROUP / RAY_LIST_TRACE_GROUP);
        Self { columns, most }
    }

    /// Workgroups in a row of a launch that traces.
    pub fn columns(self) -> u32 {
        self.columns
    }

    /// Of a list without entries.
    pub fn empty(self) -> RayListHead {
        RayListHead::empty(self.columns)
    }

    fn rows(self) -> u32 {
        self.most.div_ceil(u64::from(self.columns * RAY_LIST_TRACE_GROUP)) as u32
    }

    /// Threads of a launch that traces a full list; `RayListHead::groups` says how many are needed.
    pub fn trace_extent(self) -> [u32; 3] {
        [self.columns * TRACE_GROUP[0], self.rows() * TRACE_GROUP[1], 1]
    }

    /// Threads of a launch that shades a full list; `RayListHead::shading_groups` says how many are needed.
    pub fn shading_extent(self) -> [u32; 3] {
        [self.columns * RAY_LIST_TRACE_GROUP, self.rows(), 1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_launch_has_room_for_a_full_list_and_a_row_less_has_not() {
        for (width, most) in
            [(1, 1), (8, 513), (1920, 1920 * 1080), (1000, 5 * 1000 * 7), (7680, 7680 * 4320)]
        {
            let lists = RayLists::new(width, most);
            let [x, y, _] = lists.trace_extent().map(u64::from);
            assert!(x * y >= most && x * (y - 4) < most, "{width}, {most}: {x} x {y}");
            let [sx, sy, _] = lists.shading_extent().map(u64::from);
            assert_eq!(sx * sy, x * y);
            // The guaranteed limit of workgroups in a dimension.
            assert!(y / 4 <= 65535 && sy <= 65535);
            let head = lists.empty();
            assert_eq!(u64::from(head.groups.x) * 8, x);
            assert_eq!(u64::from(head.shading_groups.x * RAY_LIST_SHADING_GROUP), sx);
        }
    }
}
