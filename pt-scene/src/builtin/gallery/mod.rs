//! The show-piece: a vaulted hall of six bays along -Z with aisles, lit by the sun, a sky, and many coloured lamps.
//!
//! Nave: |x| < 3.2, vault from y = 6.6; aisles to |x| = 6.5 under a flat ceiling; z from -12 to 12.
//! Composed for direct light: every large surface sees the sky through an opening, a cove, a panel or a lamp.

mod art;
mod exhibits;
mod hall;
mod lighting;

use glam::Vec3;

use super::add_material;
use crate::{AlphaMode, Camera, CameraKey, CameraPath, Material, Scene, Texture, TextureRef};

const BAYS: usize = 6;
const BAY: f32 = 4.0;
/// Half the length of the hall.
const END: f32 = 12.0;
/// Half the width of the nave, and of the whole hall.
const NAVE: f32 = 3.2;
const WALL: f32 = 6.5;
/// Height of capitals, of the cornice, and thickness of the arcade.
const CAPITAL: f32 = 4.1;
const CORNICE: f32 = 6.6;
const ARCADE: f32 = 0.7;

/// Material indices.
struct Palette {
    floor: u32,
    stone: u32,
    plaster: u32,
    wood: u32,
    carpet: u32,
    gold: u32,
    copper: u32,
    steel: u32,
    mirror: u32,
    glass: u32,
    tinted: u32,
    leaf: u32,
    screen: u32,
    paintings: [u32; 3],
    ground: u32,
    cove: u32,
    bulb: u32,
    panels: [u32; 6],
}

pub(super) fn scene() -> Scene {
    let mut scene = Scene::default();
    let palette = palette(&mut scene);
    hall::build(&mut scene, &palette);
    hall::columns(&mut scene, &palette);
    lighting::build(&mut scene, &palette);
    exhibits::build(&mut scene, &palette);
    lighting::hangings(&mut scene, &palette);
    exhibits::plants(&mut scene, &palette);
    scene.merge_static("hall");
    cameras(&mut scene);
    scene
}

fn palette(scene: &mut Scene) -> Palette {
    fn add(scene: &mut Scene, texture: Texture) -> Option<TextureRef> {
        scene.textures.push(texture);
        Some(TextureRef::new(scene.textures.len() as u32 - 1))
    }
    let white = |name: &str, roughness| Material { roughness, ..Material::diffuse(name, Vec3::ONE) };
    let mut textured = |texture: Texture, material: Material| {
        let base_color_texture = add(scene, texture);
        add_material(scene, Material { base_color_texture, ..material })
    };
    let masked =
        |m: Material| Material { alpha_mode: AlphaMode::Mask { cutoff: 0.5 }, double_sided: true, ..m };
    let [floor_color, floor_roughness] = art::floor();
    let [plaster_color, plaster_relief] = art::plaster();
    let [carpet_color, carpet_weave] = art::carpet();
    let floor = textured(floor_color, white("floor", 1.0));
    let stone = textured(art::stone(), white("stone", 0.55));
    let plaster = textured(plaster_color, white("plaster", 0.85));
    let wood = textured(art::wood(), white("wood", 0.45));
    let carpet = textured(carpet_color, white("carpet", 0.95));
    let leaf = textured(art::leaf(), masked(white("leaf", 0.5)));
    let brass = Material::metal("screen", Vec3::new(0.75, 0.55, 0.28), 0.4);
    let screen = textured(art::screen(), masked(brass));
    let paintings =
        [art::landscape(), art::abstraction(), art::waves()].map(|t| textured(t, white("painting", 0.5)));
    scene.materials[floor as usize].metallic_roughness_texture = add(scene, floor_roughness);
    scene.materials[plaster as usize].normal_texture = add(scene, plaster_relief);
    scene.materials[carpet as usize].normal_texture = add(scene, carpet_weave);
    let grooves = add(scene, art::brushed());
    let panels = [
        (1.0, 0.09, 0.04),
        (1.0, 0.42, 0.04),
        (0.08, 0.85, 0.18),
        (0.03, 0.55, 1.0),
        (0.22, 0.12, 1.0),
        (1.0, 0.05, 0.5),
    ];
    Palette {
        floor,
        stone,
        plaster,
        wood,
        carpet,
        leaf,
        screen,
        paintings,
        gold: add_material(scene, Material::metal("gold", Vec3::new(1.0, 0.71, 0.29), 0.28)),
        copper: add_material(scene, Material::metal("copper", Vec3::new(0.93, 0.52, 0.38), 0.35)),
        steel: add_material(
            scene,
            Material {
                normal_texture: grooves,
                ..Material::metal("brushed steel", Vec3::new(0.56, 0.57, 0.58), 0.38)
            },
        ),
        mirror: add_material(scene, Material::metal("mirror", Vec3::splat(0.94), 0.0)),
        glass: add_material(
            scene,
            Material {
                transmission: 1.0,
                roughness: 0.0,
                thickness: 1.0,
                attenuation_color: Vec3::new(0.75, 0.95, 0.9),
                attenuation_distance: 0.8,
                ..Material::diffuse("glass", Vec3::ONE)
            },
        ),
        tinted: add_material(
            scene,
            Material {
                transmission: 1.0,
                roughness: 0.0,
                double_sided: true,
                ..Material::diffuse("tinted pane", Vec3::new(0.35, 0.75, 0.85))
            },
        ),
        ground: add_material(scene, Material::diffuse("ground", Vec3::new(0.36, 0.38, 0.26))),
        cove: add_material(scene, Material::lamp("cove", 14.0 * Vec3::new(1.0, 0.72, 0.45))),
        bulb: add_material(scene, Material::lamp("bulb", 28.0 * Vec3::new(1.0, 0.74, 0.46))),
        panels: panels.map(|c| add_material(scene, Material::lamp("panel", 3.2 * Vec3::from(c)))),
    }
}

/// Middle of a bay along z, from the near end to the far one.
fn bay(i: usize) -> f32 {
    END - (i as f32 + 0.5) * BAY
}

fn cameras(scene: &mut Scene) {
    scene.cameras.push(Camera::look_at(
        "main",
        Vec3::new(-0.75, 1.75, 11.2),
        Vec3::new(0.25, 2.9, -4.0),
        0.98,
    ));
    let stations: [[[f32; 3]; 2]; 9] = [
        [[-0.75, 1.75, 11.2], [0.25, 2.9, -4.0]],
        [[-0.4, 1.8, 7.0], [1.9, 1.6, 3.0]],
        [[0.3, 1.9, 2.6], [0.0, 2.0, -1.5]],
        [[2.2, 1.7, 0.2], [6.4, 2.3, -2.5]],
        [[4.9, 1.7, -3.6], [4.6, 2.0, -9.0]],
        [[2.6, 1.9, -8.2], [-1.9, 1.6, -6.0]],
        [[-0.5, 2.2, -8.6], [0.0, 3.4, 0.0]],
        [[-4.7, 1.8, -3.6], [-3.0, 2.4, 5.0]],
        [[-4.6, 1.8, 1.5], [0.0, 2.6, 0.0]],
    ];
    let key = |(i, &[position, target]): (usize, &[[f32; 3]; 2])| CameraKey {
        time: 2.5 * i as f64,
        position: position.into(),
        target: target.into(),
    };
    if let Some(path) = CameraPath::new(stations.iter().enumerate().map(key).collect()) {
        scene.cameras.push(Camera::on_path("tour", path, 1.05));
    }
    scene.cameras.push(Camera::look_at("aisle", Vec3::new(4.75, 1.7, 11.2), Vec3::new(5.1, 2.3, -4.0), 1.0));
    let close = Camera::look_at("close", Vec3::new(-0.9, 1.65, 2.3), Vec3::new(0.0, 2.0, -1.5), 0.7);
    scene.cameras.push(Camera { lens_radius: 0.02, ..close });
}
