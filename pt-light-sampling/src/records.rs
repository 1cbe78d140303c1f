//! Push constants of the kernels, and the enums of the samplers.

pt_shaders::named_enum! {
    /// How shadow statistics are kept.
    pub enum StatisticsTable {
        /// Dense as long as it has at most four million entries, else sparse.
        Auto = "auto",
        /// An entry for every cluster, light and direction.
        Dense = "dense",
        /// A hash table: entries for what shadow rays have asked for.
        Sparse = "sparse",
    }
}

pt_shaders::named_enum! {
    /// Whether the lists of clusters leave out lights that are hidden from the whole cluster.
    pub enum ListVisibility {
        /// They do not know what is hidden.
        Off = "off",
        /// Rays on the CPU decide when the lists are built: 16 rays between the cluster and a light that all meet an opaque surface leave it out.
        Rays = "rays",
    }
}

pt_shaders::gpu_struct! {
    /// Of `local_lights.comp`.
    pub struct LocalLightsPush {
        /// Device addresses of the tables.
        pub local_lights: u64,
        /// `LightCandidateRecord[]`.
        pub light_candidates: u64,
        /// Threads in a row.
        pub width: u32,
        /// Number of lights, dark ones too.
        pub count: u32,
    }
}

pt_shaders::gpu_struct! {
    /// Of `shadow_statistics.comp`.
    pub struct ShadowStatisticsPush {
        /// Share of the history that is kept.
        pub keep: f32,
        /// Threads in a row.
        pub width: u32,
        /// First entry.
        pub first: u32,
        /// Number of entries.
        pub count: u32,
    }
}

pt_shaders::gpu_struct! {
    /// Of `cluster_subsets.comp`.
    pub struct ClusterSubsetsPush {
        /// `vec4[]`: centre and radius of each cluster's box.
        pub balls: u64,
        /// The first cluster of this frame.
        pub first: u32,
        /// Number of clusters.
        pub clusters: u32,
    }
}
