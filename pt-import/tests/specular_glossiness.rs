//! KHR_materials_pbrSpecularGlossiness as a dielectric with a specular colour.

use crate::common;
use crate::common::gltf::{Glb, plain, shared_scene};
use crate::common::textured;
use pt_image::image_file::{PixelLayout, write_png};
use pt_import::{LoadOptions, load};
use pt_scene::glam::{Vec3, Vec4};
use pt_scene::{AlphaMode, Material, TextureUsage};
use serde_json::{Value, json};

const NAME: &str = "KHR_materials_pbrSpecularGlossiness";

fn material(extension: Value, rest: Value) -> Material {
    let mut glb = Glb::new();
    let positions = glb.floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0], "VEC3");
    glb.show(json!({"attributes": {"POSITION": positions}, "material": 0}));
    glb.json["extensionsUsed"] = json!([NAME]);
    glb.json["extensionsRequired"] = json!([NAME]);
    glb.json["materials"] = json!([rest]);
    glb.json["materials"][0]["extensions"] = json!({NAME: extension});
    let mut scene = glb.load_clean();
    scene.materials.swap_remove(0)
}

/// Reflectance at normal incidence (KHR_materials_specular).
fn f0(m: &Material) -> Vec3 {
    let index = ((m.ior - 1.0) / (m.ior + 1.0)).powi(2);
    (index * m.specular_color).min(Vec3::ONE) * m.specular
}

#[test]
fn factors_are_exact() {
    let m = material(
        json!({"diffuseFactor": [0.1, 0.2, 0.3, 0.4], "specularFactor": [0.9, 0.5, 0.04], "glossinessFactor": 0.75}),
        json!({"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1], "roughnessFactor": 1}}),
    );
    assert_eq!((m.base_color, m.metallic, m.roughness), (Vec4::new(0.1, 0.2, 0.3, 0.4), 0.0, 0.25));
    assert_eq!((m.alpha_mode, m.specular), (AlphaMode::Blend, 1.0));
    assert!(f0(&m).abs_diff_eq(Vec3::new(0.9, 0.5, 0.04), 1e-6), "{}", f0(&m));
}

#[test]
fn what_is_left_out_has_the_defaults_of_the_extension() {
    let m = material(json!({}), json!({}));
    assert_eq!((m.base_color, m.metallic, m.roughness), (Vec4::ONE, 0.0, 0.0));
    assert!(f0(&m).abs_diff_eq(Vec3::ONE, 1e-6), "{}", f0(&m));
}

#[test]
fn values_out_of_range_are_refused_by_path() {
    for (value, what) in [
        (json!({"glossinessFactor": 1.5}), "glossinessFactor: 1.5 is not in 0..1"),
        (json!({"glossinessFactor": -1}), "glossinessFactor: -1 is not in 0..1"),
        (json!({"specularFactor": [-1, 0, 0]}), "specular colour -25"),
        (json!({"diffuseFactor": [1, 1]}), "invalid length 2"),
    ] {
        let mut glb = Glb::new();
        glb.json["materials"] = json!([{"extensions": {NAME: value}}]);
        let text = glb.refusal();
        assert!(text.contains("materials[0]") && text.contains(what), "{text}");
    }
}

#[test]
fn textures_hold_colour_and_roughness() {
    let temp = tempfile::tempdir().unwrap();
    let texels: Vec<u8> = (0..=255).flat_map(|i| [i, 255 - i, 7, i]).collect();
    write_png(&temp.path().join("sg.png"), 16, 16, PixelLayout::Rgba, &texels).unwrap();
    let extension = json!({
        "diffuseTexture": {"index": 0}, "glossinessFactor": 0.5, "specularFactor": [0.5, 0.5, 0.5],
        "specularGlossinessTexture": {"index": 0, "texCoord": 1}
    });
    let materials = json!({"extensions": {NAME: extension}}).to_string();
    let file = textured::gltf(temp.path(), r#"{"uri": "sg.png"}"#, r#"{"source": 0}"#, &materials);
    let scene = load(&file, &plain()).unwrap_or_else(|e| panic!("{e}"));
    let m = &scene.materials[0];
    let [diffuse, specular, roughness] =
        [m.base_color_texture, m.specular_color_texture, m.metallic_roughness_texture].map(|t| t.unwrap());
    assert_eq!([diffuse.uv_set, specular.uv_set, roughness.uv_set], [0, 1, 1]);
    let texture = |t: pt_scene::TextureRef| &scene.textures[t.texture as usize];
    assert_eq!(texture(diffuse).usage, TextureUsage::Color);
    assert_eq!(
        (texture(specular).usage, texture(roughness).usage),
        (TextureUsage::Color, TextureUsage::Data)
    );
    assert!(f0(m).abs_diff_eq(Vec3::splat(0.5), 1e-6));
    assert_eq!(m.roughness, 1.0);
    for i in 0..256u32 {
        let [_, roughness, _, _] = texture(roughness).texel(i % 16, i / 16);
        let exact = 1.0 - 0.5 * i as f32 / 255.0;
        assert!((roughness - exact).abs() <= 0.51 / 255.0, "{roughness} is not {exact}");
        let color = texture(specular).texel(i % 16, i / 16);
        let expected = pt_scene::decode_texel(TextureUsage::Color, [i as u8, 255 - i as u8, 7, i as u8]);
        assert_eq!(color, expected);
    }
}

#[test]
fn roughness_has_the_16_bits_of_its_image() {
    let temp = tempfile::tempdir().unwrap();
    let glossiness = |i: u32| 0x8000 + i as u16;
    let image = image::ImageBuffer::from_fn(16, 16, |x, y| image::Rgba([1u16, 2, 3, glossiness(16 * y + x)]));
    image.save(temp.path().join("sg.png")).unwrap();
    let extension = json!({"glossinessFactor": 0.75, "specularGlossinessTexture": {"index": 0}});
    let materials = json!({"extensions": {NAME: extension}}).to_string();
    let file = textured::gltf(temp.path(), r#"{"uri": "sg.png"}"#, r#"{"source": 0}"#, &materials);
    let scene = load(&file, &plain()).unwrap_or_else(|e| panic!("{e}"));
    let slot = scene.materials[0].metallic_roughness_texture.unwrap();
    for i in 0..256 {
        let [metallic, roughness, ..] = scene.textures[slot.texture as usize].texel(i % 16, i / 16);
        let exact = 1.0 - 0.75 * f32::from(glossiness(i)) / 65535.0;
        assert!(metallic == 0.0 && (roughness - exact).abs() < 0.51 / 65535.0, "{roughness} is not {exact}");
    }
}

#[test]
#[cfg_attr(not(shared), ignore = "needs ../shared")]
fn the_sample_of_blender_loads() {
    let folder = pt_test_data::shared("scenes");
    let file = common::scene_files(&folder)
        .into_iter()
        .find(|file| file.to_string_lossy().contains("Blender_14_emission_strength"))
        .expect("the file is there");
    let name = file.strip_prefix(&folder).unwrap().to_string_lossy().into_owned();
    let scene = shared_scene(&name, &LoadOptions::default());
    assert!(scene.extensions.iter().any(|e| e.name == NAME));
    assert!(scene.statistics().instanced_triangles > 0);
}
