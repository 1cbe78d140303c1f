//! From scene types to GPU records.

use crate::{
    AlphaMode, Filter, Instance, Light, Lobes, Material, Mesh, MipFilter, Sampler, Scene, Shows, Texture,
    TextureRef, Wrap, media,
};
use glam::{Affine2, Affine3A, Vec4};
use pt_core::pack::{pack_tangent, pack_unit_vector};
use pt_shaders::records::{
    FEATURE_BASE_COLOR_TEXTURE, FEATURE_CAMERA_VIEWS, FEATURE_COVERAGE, FEATURE_EFFECTS,
    FEATURE_EMISSIVE_TEXTURE, FEATURE_INSTANCES, FEATURE_LOBES, FEATURE_METALLIC_ROUGHNESS_TEXTURE,
    FEATURE_NORMAL_TEXTURE, FEATURE_OPACITY_TABLE, FEATURE_PORTALS, FEATURE_SECOND_UV, FEATURE_SKY,
    FEATURE_SUN_DISC, FEATURE_TEXTURE_FILTER, FEATURE_TEXTURE_TRANSFORM, FEATURE_TRANSMISSION,
    FEATURE_VERTEX_COLOR, FEATURE_WAVES, InstanceRecord, LobeRecord, MASK_MIXED_SIDES, MASK_OPAQUE,
    MASK_SINGLE_SIDED, MASK_TRANSMISSIVE, MATERIAL_BLEND, MATERIAL_CAMERA_SHIFT, MATERIAL_DOUBLE_SIDED,
    MATERIAL_MASK, MATERIAL_OWN_MOTION, MATERIAL_SKY, MATERIAL_UNLIT, MaterialRecord, NONE, TEXTURE_CLAMP_U,
    TEXTURE_CLAMP_V, TEXTURE_MAG_NEAREST, TEXTURE_MIN_NEAREST, TEXTURE_MIP_NEAREST, TEXTURE_MIP_OFF,
    TEXTURE_MIRROR_U, TEXTURE_MIRROR_V, TEXTURE_SECOND_UV, TextureSlot, VertexRecord,
};
use std::collections::HashMap;

fn texture_slot(texture: Option<TextureRef>, textures: &[Texture]) -> TextureSlot {
    let Some(TextureRef { texture, uv_set, transform }) = texture else {
        return TextureSlot { texture: NONE, flags: 0, transform: [[0.0; 3]; 2] };
    };
    let bit = |on: bool, flag: u32| if on { flag } else { 0 };
    let Sampler { mag, min, mip, wrap_u, wrap_v } = textures[texture as usize].sampler;
    let flags = bit(uv_set != 0, TEXTURE_SECOND_UV)
        | bit(mag == Filter::Nearest, TEXTURE_MAG_NEAREST)
        | bit(min == Filter::Nearest, TEXTURE_MIN_NEAREST)
        | bit(mip == MipFilter::Nearest, TEXTURE_MIP_NEAREST)
        | bit(mip == MipFilter::Off, TEXTURE_MIP_OFF)
        | bit(wrap_u == Wrap::MirroredRepeat, TEXTURE_MIRROR_U)
        | bit(wrap_v == Wrap::MirroredRepeat, TEXTURE_MIRROR_V)
        | bit(wrap_u == Wrap::ClampToEdge, TEXTURE_CLAMP_U)
        | bit(wrap_v == Wrap::ClampToEdge, TEXTURE_CLAMP_V);
    let (m, t) = (transform.matrix2, transform.translation);
    let transform = [[m.x_axis.x, m.y_axis.x, t.x], [m.x_axis.y, m.y_axis.y, t.y]];
    TextureSlot { texture, flags, transform }
}

/// The records of all materials, and of those lobes that they have.
pub(super) fn materials(
    materials: &[Material],
    textures: &[Texture],
) -> (Vec<MaterialRecord>, Vec<LobeRecord>) {
    let mut lobes = Vec::new();
    let media = media(materials);
    let records = materials.iter().zip(&media).map(|(m, &medium)| {
        let of_lobes =
            [m.transmission_texture, m.thickness_texture, m.specular_texture, m.specular_color_texture];
        let index = if m.lobes.is_some() || of_lobes.iter().any(Option::is_some) {
            lobes.push(lobe(m, textures));
            lobes.len() as u32 - 1
        } else {
            NONE
        };
        material(m, textures, index, medium, m.exterior.map(|exterior| media[exterior as usize]))
    });
    let records = records.collect();
    // A table without entries still has an address.
    if lobes.is_empty() {
        lobes.push(lobe(&Material::default(), textures));
    }
    (records, lobes)
}

/// `FEATURE_*` bits of what any of the materials, meshes and lights has. `materials`: the records of the scene's.
pub(super) fn features(scene: &Scene, materials: &[MaterialRecord]) -> u32 {
    let bit = |on: bool, feature: u32| if on { feature } else { 0 };
    let textured = |slot: &TextureSlot| slot.texture != NONE;
    let of = |m: &MaterialRecord| {
        bit(textured(&m.base_color_texture), FEATURE_BASE_COLOR_TEXTURE)
            | bit(textured(&m.metallic_roughness_texture), FEATURE_METALLIC_ROUGHNESS_TEXTURE)
            | bit(textured(&m.normal_texture), FEATURE_NORMAL_TEXTURE)
            | bit(textured(&m.emissive_texture), FEATURE_EMISSIVE_TEXTURE)
            | bit(m.lobes != NONE, FEATURE_LOBES)
            | bit(m.transmission > 0.0, FEATURE_TRANSMISSION)
            | bit(m.flags & (MATERIAL_MASK | MATERIAL_BLEND) != 0, FEATURE_COVERAGE | FEATURE_OPACITY_TABLE)
            | bit(m.flags & MATERIAL_SKY != 0, FEATURE_SKY)
            | bit(m.wave_slope > 0.0, FEATURE_WAVES)
            | bit(m.flags >> MATERIAL_CAMERA_SHIFT != 0, FEATURE_CAMERA_VIEWS)
    };
    let uses = || scene.materials.iter().flat_map(Material::textures).map(|(_, texture)| texture);
    let coat_normals = |m: &Material| m.lobes.as_ref().is_some_and(|l| l.clearcoat_normal_texture.is_some());
    materials.iter().fold(0, |all, m| all | of(m))
        | bit(scene.materials.iter().any(coat_normals), FEATURE_NORMAL_TEXTURE)
        | bit(uses().any(|t| t.transform != Affine2::IDENTITY), FEATURE_TEXTURE_TRANSFORM)
        | bit(uses().any(|t| t.uv_set != 0), FEATURE_SECOND_UV)
        | bit(scene.meshes.iter().any(Mesh::is_colored), FEATURE_VERTEX_COLOR)
        | bit(scene.instances.len() != 1, FEATURE_INSTANCES)
        | bit(!scene.portals.is_empty(), FEATURE_PORTALS)
        | bit(!scene.effects.is_empty(), FEATURE_EFFECTS)
        | bit(scene.lights.iter().any(Light::is_disc), FEATURE_SUN_DISC)
        | FEATURE_TEXTURE_FILTER
}

fn lobe(m: &Material, textures: &[Texture]) -> LobeRecord {
    let texture_slot = |texture| texture_slot(texture, textures);
    let absent = Lobes::default();
    let l = m.lobes.as_deref().unwrap_or(&absent);
    LobeRecord {
        clearcoat: l.clearcoat,
        clearcoat_roughness: l.clearcoat_roughness,
        clearcoat_normal_scale: l.clearcoat_normal_scale,
        sheen_color: l.sheen_color,
        sheen_roughness: l.sheen_roughness,
        anisotropy_strength: l.anisotropy_strength,
        anisotropy_rotation: l.anisotropy_rotation,
        iridescence: l.iridescence,
        iridescence_ior: l.iridescence_ior,
        iridescence_thickness_min: l.iridescence_thickness_min,
        iridescence_thickness_max: l.iridescence_thickness_max,
        dispersion: l.dispersion,
        transmission_texture: texture_slot(m.transmission_texture),
        thickness_texture: texture_slot(m.thickness_texture),
        specular_texture: texture_slot(m.specular_texture),
        specular_color_texture: texture_slot(m.specular_color_texture),
        clearcoat_texture: texture_slot(l.clearcoat_texture),
        clearcoat_roughness_texture: texture_slot(l.clearcoat_roughness_texture),
        clearcoat_normal_texture: texture_slot(l.clearcoat_normal_texture),
        sheen_color_texture: texture_slot(l.sheen_color_texture),
        sheen_roughness_texture: texture_slot(l.sheen_roughness_texture),
        anisotropy_texture: texture_slot(l.anisotropy_texture),
        iridescence_texture: texture_slot(l.iridescence_texture),
        iridescence_thickness_texture: texture_slot(l.iridescence_thickness_texture),
    }
}

/// An alpha that equals the cutoff is opaque, also when interpolation, filtering and the half floats that textures may be stored in (1/2048)
/// round it down. Far less than a step of 8 bits.
const ALPHA_ROUNDING: f32 = 1.0 / 2000.0;

fn material(
    m: &Material,
    textures: &[Texture],
    lobes: u32,
    medium: u32,
    exterior: Option<u32>,
) -> MaterialRecord {
    let texture_slot = |texture| texture_slot(texture, textures);
    let mut flags = 0;
    let mut alpha_cutoff = 0.0;
    match m.alpha_mode {
        AlphaMode::Opaque => {}
        AlphaMode::Mask { cutoff } => {
            (flags, alpha_cutoff) = (MATERIAL_MASK, cutoff * (1.0 - ALPHA_ROUNDING))
        }
        AlphaMode::Blend => flags = MATERIAL_BLEND,
    }
    if m.double_sided {
        flags |= MATERIAL_DOUBLE_SIDED;
    }
    if m.unlit {
        flags |= MATERIAL_UNLIT;
    }
    if m.own_motion {
        flags |= MATERIAL_OWN_MOTION;
    }
    match m.shows {
        Shows::Itself => {}
        Shows::Environment => flags |= MATERIAL_SKY,
        Shows::Camera(camera) => flags |= (camera + 1) << MATERIAL_CAMERA_SHIFT,
    }
    MaterialRecord {
        base_color: m.base_color,
        emissive: m.emissive,
        metallic: m.metallic,
        roughness: m.roughness,
        normal_scale: m.normal_scale,
        alpha_cutoff,
        ior: m.ior,
        transmission: m.transmission,
        thickness: m.thickness,
        specular: m.specular,
        attenuation_distance: if m.attenuation_distance.is_finite() { m.attenuation_distance } else { 0.0 },
        specular_color: m.specular_color,
        flags,
        attenuation_color: m.attenuation_color,
        lobes,
        nesting: m.priority | exterior.map_or(0, |medium| (medium + 1) << 8),
        medium,
        wave_slope: m.waves.map_or(0.0, |waves| waves.slope),
        wave_length: m.waves.map_or(1.0, |waves| waves.length),
        base_color_texture: texture_slot(m.base_color_texture),
        metallic_roughness_texture: texture_slot(m.metallic_roughness_texture),
        normal_texture: texture_slot(m.normal_texture),
        emissive_texture: texture_slot(m.emissive_texture),
    }
}

pub(super) fn vertices(mesh: &Mesh) -> impl Iterator<Item = VertexRecord> {
    (0..mesh.positions.len()).map(|i| VertexRecord {
        normal: pack_unit_vector(mesh.normals[i]),
        tangent: pack_tangent(mesh.tangents[i]),
        uv0: mesh.uv0[i].to_array(),
        uv1: mesh.uv1[i].to_array(),
    })
}

fn rows(transform: &Affine3A) -> [Vec4; 3] {
    let m = transform.matrix3;
    let t = transform.translation;
    std::array::from_fn(|r| Vec4::new(m.x_axis[r], m.y_axis[r], m.z_axis[r], t[r]))
}

pub(super) fn instance(instance: &Instance, mask: u32) -> InstanceRecord {
    InstanceRecord {
        world_from_object: rows(&instance.world_from_object),
        object_from_world: rows(&instance.world_from_object.inverse()),
        world_from_object_prev: rows(&instance.world_from_object_prev),
        mesh: instance.mesh,
        mask,
        mirrored: u32::from(instance.world_from_object.matrix3.determinant() < 0.0),
        material: instance.material.unwrap_or(NONE),
    }
}

/// An instance lets shadow rays through only when all of it transmits.
/// What rays of each kind see of the instances.
pub(super) fn visibility_masks(scene: &Scene) -> Vec<u32> {
    // Instances share meshes: the triangles of each are gone through once for each material that replaces their own.
    let mut known = HashMap::new();
    let mut mask = |instance: &Instance| {
        *known.entry((instance.mesh, instance.material)).or_insert_with(|| {
            visibility_mask(instance, &scene.meshes[instance.mesh as usize], &scene.materials)
        })
    };
    scene.instances.iter().map(&mut mask).collect()
}

fn visibility_mask(instance: &Instance, mesh: &Mesh, materials: &[Material]) -> u32 {
    let mask = if instance.transmits(mesh, materials) { MASK_TRANSMISSIVE } else { MASK_OPAQUE };
    let single = |material: u32| {
        let m = &materials[material as usize];
        !m.double_sided && !m.is_solid()
    };
    let mut sides = match instance.material {
        Some(material) => vec![single(material)],
        None => mesh.triangle_materials.iter().map(|&m| single(m)).collect(),
    };
    sides.dedup();
    mask | match sides[..] {
        [] | [false] => 0,
        [true] => MASK_SINGLE_SIDED,
        _ => MASK_MIXED_SIDES,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use half::f16;

    #[test]
    fn a_cutoff_lies_between_its_alpha_and_the_next_one() {
        for alpha in 1..=255u8 {
            let held = |alpha: u8| f16::from_f32(f32::from(alpha) / 255.0).to_f32();
            let alpha_mode = AlphaMode::Mask { cutoff: f32::from(alpha) / 255.0 };
            let (records, _) = materials(&[Material { alpha_mode, ..Material::default() }], &[]);
            let cutoff = records[0].alpha_cutoff;
            assert!(held(alpha) >= cutoff && held(alpha - 1) < cutoff, "{alpha}: {cutoff}");
        }
    }
}
