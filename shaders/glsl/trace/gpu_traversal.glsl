// Whether trees and traversal of the compute backend are as on a GPU (Device::with_gpu_traversal).
layout(constant_id = 23) const bool gpu_traversal = false;

// Triangles of a leaf of a mesh's tree; they stand next to each other (pt_core::trace::Leaf).
#define LEAF_TRIANGLES (gpu_traversal ? 2u : 1u)
