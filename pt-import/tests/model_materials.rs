//! Parameters that the sample models are known to have.

use glam::{Affine2, Vec2, Vec3};
use pt_import::{LoadOptions, load};
use pt_scene::{AlphaMode, Material, Scene, TextureUsage};
use pt_test_data::shared;

fn model(file: &str) -> Scene {
    load(shared("scenes").join(file), &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

fn material<'a>(scene: &'a Scene, name: &str) -> &'a Material {
    let found = scene.materials.iter().find(|m| m.name == name);
    found.unwrap_or_else(|| {
        panic!("no {name} in {:?}", scene.materials.iter().map(|m| &m.name).collect::<Vec<_>>())
    })
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn transforms_and_uv_sets() {
    let scene = model("TextureTransformTest/TextureTransformTest.gltf");
    let moved: Vec<_> = scene.materials.iter().filter_map(|m| m.base_color_texture).collect();
    assert_eq!(moved.iter().filter(|t| t.transform != Affine2::IDENTITY).count(), 6);
    let offset = moved.iter().find(|t| t.transform.translation == Vec2::new(0.5, 0.0));
    assert!(offset.is_some_and(|t| t.transform.transform_point2(Vec2::ZERO) == Vec2::new(0.5, 0.0)));
    let scene = model("MultiUVTest/MultiUVTest.gltf");
    let m = &scene.materials[0];
    let sets = [m.base_color_texture.unwrap().uv_set, m.emissive_texture.unwrap().uv_set];
    assert!(sets.contains(&0) && sets.contains(&1), "{sets:?}");
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn alpha_modes() {
    let scene = model("AlphaBlendModeTest/AlphaBlendModeTest.gltf");
    assert_eq!(material(&scene, "MatOpaque").alpha_mode, AlphaMode::Opaque);
    assert_eq!(material(&scene, "MatBlend").alpha_mode, AlphaMode::Blend);
    assert_eq!(material(&scene, "MatCutoffDefault").alpha_mode, AlphaMode::Mask { cutoff: 0.5 });
    assert_eq!(material(&scene, "MatCutoff25").alpha_mode, AlphaMode::Mask { cutoff: 0.25 });
    assert_eq!(material(&scene, "MatCutoff75").alpha_mode, AlphaMode::Mask { cutoff: 0.75 });
    // The gradient of alpha is the same whatever the mode; filtering differs.
    let texture = |name: &str| {
        let slot = material(&scene, name).base_color_texture.unwrap();
        &scene.textures[slot.texture as usize]
    };
    assert_eq!(texture("MatOpaque").usage, TextureUsage::Color);
    assert_eq!(texture("MatBlend").usage, TextureUsage::Cutout);
    let t = texture("MatBlend");
    let alphas: Vec<f32> = (0..t.height).map(|y| t.texel(t.width / 2, y)[3]).collect();
    assert!(alphas.iter().any(|&a| a < 0.1) && alphas.iter().any(|&a| a > 0.9));
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn images_of_extensions() {
    for file in
        ["CesiumBox_WebP/CesiumBoxWebp-Required.gltf", "CesiumBox_WebP/CesiumBoxWebp-WithFallbackPNG.gltf"]
    {
        let scene = model(file);
        assert_eq!(scene.textures.len(), 1, "{file}");
        assert!(scene.textures[0].width > 1 && scene.textures[0].texel(0, 0)[3] == 1.0);
    }
    let scene = model("AGI_KTX2/0.glb");
    let t = &scene.textures[0];
    assert_eq!(t.usage, TextureUsage::Color);
    assert!(scene.materials[0].unlit);
    // A photograph: many colours, none of them missing.
    let texels: Vec<_> = (0..64).map(|i| t.texel(i * t.width / 64, i * t.height / 64)).collect();
    let mean = texels.iter().map(|t| t[1]).sum::<f32>() / 64.0;
    assert!((0.02..0.9).contains(&mean) && texels.iter().any(|t| (t[1] - mean).abs() > 0.02), "{mean}");
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn volumes_and_transmission() {
    let scene = model("AttenuationTest/AttenuationTest.gltf");
    let volumes: Vec<_> = scene.materials.iter().filter(|m| m.thickness > 0.0).collect();
    assert!(!volumes.is_empty());
    assert!(volumes.iter().all(|m| m.transmission == 1.0));
    assert!(volumes.iter().any(|m| m.attenuation_distance.is_finite() && m.attenuation_color != Vec3::ONE));
    assert!(scene.materials.iter().any(|m| m.thickness_texture.is_some()));
    let scene = model("TransmissionTest/TransmissionTest.gltf");
    let textured: Vec<_> = scene.materials.iter().filter_map(|m| m.transmission_texture).collect();
    assert!(!textured.is_empty());
    assert!(textured.iter().all(|t| scene.textures[t.texture as usize].usage == TextureUsage::Data));
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn lobes() {
    let scene = model("ClearCoatTest/ClearCoatTest.gltf");
    let coats: Vec<_> = scene.materials.iter().filter_map(|m| m.lobes.as_ref()).collect();
    assert!(coats.iter().any(|l| l.clearcoat == 1.0 && l.clearcoat_texture.is_none()));
    assert!(coats.iter().any(|l| l.clearcoat_texture.is_some()));
    assert!(coats.iter().any(|l| l.clearcoat_roughness_texture.is_some()));
    assert!(coats.iter().any(|l| l.clearcoat_normal_texture.is_some()));

    let scene = model("SpecularTest/SpecularTest.gltf");
    let factors: Vec<f32> = scene.materials.iter().map(|m| m.specular).collect();
    assert!(factors.contains(&0.0) && factors.iter().any(|&f| f > 0.0 && f < 1.0), "{factors:?}");
    assert!(scene.materials.iter().any(|m| m.specular_texture.is_some()));
    assert!(scene.materials.iter().any(|m| m.specular_color_texture.is_some()));
    assert!(scene.materials.iter().any(|m| m.specular_color != Vec3::ONE));

    let scene = model("AnisotropyStrengthTest/AnisotropyStrengthTest.gltf");
    let mut strengths: Vec<f32> =
        scene.materials.iter().filter_map(|m| Some(m.lobes.as_ref()?.anisotropy_strength)).collect();
    strengths.sort_by(f32::total_cmp);
    assert!(strengths.len() > 3 && strengths[strengths.len() - 1] == 1.0, "{strengths:?}");
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn all_five_textures() {
    let scene = model("DamagedHelmet/DamagedHelmet.gltf");
    let m = &scene.materials[0];
    let usage = |slot: Option<pt_scene::TextureRef>| scene.textures[slot.unwrap().texture as usize].usage;
    assert_eq!(usage(m.base_color_texture), TextureUsage::Color);
    assert_eq!(usage(m.metallic_roughness_texture), TextureUsage::Data);
    assert_eq!(usage(m.normal_texture), TextureUsage::Normal);
    assert_eq!(usage(m.emissive_texture), TextureUsage::Color);
    assert_eq!(scene.textures.len(), 4, "the occlusion texture is not read");
    let normals = &scene.textures[m.normal_texture.unwrap().texture as usize];
    for i in 0..512 {
        let [x, y, z, _] = normals.texel(i * 4, i * 3).map(|t| 2.0 * t - 1.0);
        assert!((x * x + y * y + z * z - 1.0).abs() < 0.03, "({x}, {y}, {z}) is no unit vector");
    }
}
