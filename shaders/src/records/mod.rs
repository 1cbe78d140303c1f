//! Records that several crates read on the GPU. Spaces: world is metres, +Y up, right-handed.

mod effects;
mod frame;
mod light;
mod material;
mod scene;

pub use crate::constants::*;
pub use effects::*;
pub use frame::*;
pub use light::*;
pub use material::*;
pub use scene::*;

use crate::gpu_struct::GpuStruct;

macro_rules! table {
    ($($record:ident),* $(,)?) => {
        /// Name, size and members of every record of this module, for the layout check against SPIR-V.
        pub fn all() -> Vec<(&'static str, usize, Vec<crate::Field>)> {
            vec![$((<$record as GpuStruct>::STRUCT_NAME, size_of::<$record>(), $record::fields())),*]
        }

        fn declarations() -> String {
            [$($record::glsl()),*].concat()
        }
    };
}

// In order of use: a record stands after those that it contains.
table! {
    CameraRecord,
    FrameRecord,
    InstanceRecord,
    MeshRecord,
    LightTablesRecord,
    SceneRecord,
    EffectRecord,
    EffectNode,
    FogRecord,
    ClusterNode,
    VertexRecord,
    Ray,
    Hit,
    RayListHead,
    BvhTriangle,
    BvhNode,
    TextureSlot,
    MaterialRecord,
    LobeRecord,
    LightRecord,
    EmissiveRecord,
    AliasRecord,
    LocalLightRecord,
    LightCandidateRecord,
    EnvironmentQuadRecord,
    EnvironmentQuadNode,
    PortalRecord,
    ClusterListRecord,
    LightBvhNode,
    NeeAtTile,
}

/// GLSL declarations of this module (`records.glsl`), after the constants.
pub fn glsl() -> String {
    let mut text = String::from("#include \"constants.glsl\"\n");
    text.push_str(&SamplerKind::glsl());
    text.push_str(&RandomSource::glsl());
    text.push_str(&Culling::glsl());
    text.push_str(&GlassShadows::glsl());
    text.push_str(&LightSampler::glsl());
    text.push_str(&RisSource::glsl());
    text.push_str(&BvhImportance::glsl());
    text.push_str(&AreaSampling::glsl());
    text.push_str(&Background::glsl());
    text.push_str(&EmissionShare::glsl());
    text.push_str(&declarations());
    text
}
