//! The glTF extensions and how this importer treats each of them.

use pt_scene::{ExtensionUse, Support};

use Support::{Ignored, Refused, Supported};

/// Extensions of the Khronos registry (ratified, multi-vendor, and vendors' ones that are met in the wild), by name.
/// One that is not listed counts as [`Support::Refused`].
pub const EXTENSIONS: &[(&str, Support)] = &[
    ("ADOBE_materials_clearcoat_specular", Refused),
    ("ADOBE_materials_clearcoat_tint", Refused),
    ("ADOBE_materials_thin_transparency", Refused),
    ("AGI_articulations", Ignored),
    ("AGI_stk_metadata", Ignored),
    ("CESIUM_primitive_outline", Ignored),
    ("CESIUM_RTC", Refused),
    ("EXT_instance_features", Ignored),
    ("EXT_lights_ies", Refused),
    ("EXT_lights_image_based", Refused),
    ("EXT_mesh_features", Ignored),
    ("EXT_mesh_gpu_instancing", Supported),
    ("EXT_mesh_manifold", Ignored),
    ("EXT_meshopt_compression", Supported),
    ("EXT_structural_metadata", Ignored),
    ("EXT_texture_astc", Refused),
    ("EXT_texture_avif", Refused),
    ("EXT_texture_webp", Supported),
    ("FB_geometry_metadata", Ignored),
    ("GODOT_single_root", Ignored),
    ("GRIFFEL_bim_data", Ignored),
    ("KHR_animation_pointer", Refused),
    ("KHR_audio_emitter", Ignored),
    ("KHR_draco_mesh_compression", Supported),
    ("KHR_gaussian_splatting", Refused),
    ("KHR_implicit_shapes", Ignored),
    ("KHR_interactivity", Ignored),
    ("KHR_lights_punctual", Supported),
    ("KHR_materials_anisotropy", Supported),
    ("KHR_materials_clearcoat", Supported),
    ("KHR_materials_diffuse_transmission", Refused),
    ("KHR_materials_dispersion", Supported),
    ("KHR_materials_emissive_strength", Supported),
    ("KHR_materials_ior", Supported),
    ("KHR_materials_iridescence", Supported),
    ("KHR_materials_pbrSpecularGlossiness", Supported),
    ("KHR_materials_sheen", Supported),
    ("KHR_materials_specular", Supported),
    ("KHR_materials_transmission", Supported),
    ("KHR_materials_unlit", Supported),
    ("KHR_materials_variants", Supported),
    ("KHR_materials_volume", Supported),
    ("KHR_materials_volume_scatter", Refused),
    ("KHR_mesh_quantization", Supported),
    ("KHR_meshopt_compression", Supported),
    ("KHR_node_hoverability", Ignored),
    ("KHR_node_selectability", Ignored),
    ("KHR_node_visibility", Supported),
    ("KHR_physics_rigid_bodies", Ignored),
    ("KHR_techniques_webgl", Refused),
    ("KHR_texture_basisu", Supported),
    ("KHR_texture_transform", Supported),
    ("KHR_xmp", Ignored),
    ("KHR_xmp_json_ld", Ignored),
    ("MSFT_lod", Ignored),
    ("MSFT_packing_normalRoughnessMetallic", Ignored),
    ("MSFT_packing_occlusionRoughnessMetallic", Ignored),
    ("MSFT_texture_dds", Supported),
    ("NV_materials_mdl", Refused),
];

/// Extensions that need the feature `codecs`.
const CODECS: [&str; 4] = [
    "EXT_meshopt_compression",
    "KHR_draco_mesh_compression",
    "KHR_meshopt_compression",
    "KHR_texture_basisu",
];

/// Whether the extension would be supported by a build with the feature `codecs`.
pub(crate) fn needs_codecs(name: &str) -> bool {
    cfg!(not(feature = "codecs")) && CODECS.contains(&name)
}

/// How the importer treats the extension of this name.
pub fn support(name: &str) -> Support {
    if needs_codecs(name) {
        return Refused;
    }
    EXTENSIONS.iter().find(|(known, _)| *known == name).map_or(Refused, |&(_, support)| support)
}

/// What becomes of the extensions that a loaded file names, each once, in the order of the file.
pub(crate) fn uses(used: &[String], required: &[String]) -> Vec<ExtensionUse> {
    let mut out: Vec<ExtensionUse> = Vec::new();
    for name in used.iter().chain(required) {
        if out.iter().all(|u| u.name != *name) {
            let support = if support(name) == Supported { Supported } else { Ignored };
            out.push(ExtensionUse { name: name.clone(), required: required.contains(name), support });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_names_each_extension_once() {
        for (i, (name, _)) in EXTENSIONS.iter().enumerate() {
            assert!(EXTENSIONS[..i].iter().all(|(other, _)| other != name), "{name}");
        }
    }
}
