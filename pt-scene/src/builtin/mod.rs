//! Scenes made by code: no files, the same bits every time.

mod cornell;
mod effects;
mod field;
mod flicker;
mod furnace;
mod gallery;
mod glass;
mod kinds;
mod lamps;
mod noise;
mod plane;
mod room;
mod shapes;
mod solids;
mod textures;
mod veach;
mod window;

use crate::{Material, Mesh, Scene};

/// Names of the built-in scenes, with one line each.
pub const BUILTIN: &[(&str, &str)] = &[
    ("cornell", "the diffuse Cornell box with its classic measures and colours"),
    (
        "effects",
        "sparks, smoke, beams, a picture in the air and fog, before a mirror and glass; most of it moves",
    ),
    (
        "field",
        "ground, lamps and stones to measure growth; field:triangles=N,lights=N,instances=N,moving=N has that many",
    ),
    (
        "flicker",
        "a room in which objects, lights and the camera move and lights blink, to try what reuses earlier frames",
    ),
    ("furnace", "convex bodies of albedo 1 in a white environment: 11 roughnesses x 3 metalnesses"),
    (
        "gallery",
        "a vaulted hall with columns, sun, coloured lamps, metal, glass and a mirror; moving sculptures",
    ),
    (
        "glass",
        "tinted water with ice in a tumbler: nested dielectrics whose solids overlap, told apart by priority",
    ),
    ("glass-gapless", "the same without overlap: every interface of two solids is one surface"),
    ("kinds", "one body of every kind of material, in a grid"),
    (
        "lamps",
        "a flat of many rooms with hundreds of small emissive triangles, most of them hidden from any one point",
    ),
    ("plane", "one point light of 100 cd over a large Lambertian plane, for closed-form tests"),
    ("room", "a closed diffuse room of 236,000 triangles, to measure ray rates"),
    ("sprites", "1,000 translucent pictures that overlap, to measure how effects are blended"),
    (
        "textures",
        "patterns near and far: a chequered plane to the horizon, zone plates, print, a wire fence, grazing walls",
    ),
    (
        "veach",
        "four glossy plates under four lamps of equal power and different size (Veach and Guibas 1995)",
    ),
    ("window", "a room with one window, a portal of the sky, and a small lamp"),
];

/// A built-in scene by name, at time 0. `field:triangles=N,lights=N,instances=N,moving=N` is [`BUILTIN`]'s `field` with other counts.
pub fn builtin(name: &str) -> Option<Scene> {
    if let Some(counts) = name.strip_prefix("field:") {
        return Some(Scene { name: name.into(), ..field::scene(counts)? });
    }
    let scene = match name {
        "cornell" => cornell::scene(),
        "effects" => effects::scene(),
        "field" => field::scene("")?,
        "flicker" => flicker::scene(),
        "furnace" => furnace::scene(),
        "gallery" => gallery::scene(),
        "glass" => glass::scene(),
        "glass-gapless" => glass::gapless_scene(),
        "kinds" => kinds::scene(),
        "lamps" => lamps::scene(),
        "plane" => plane::scene(),
        "room" => room::scene(),
        "sprites" => effects::sprites(),
        "textures" => textures::scene(),
        "veach" => veach::scene(),
        "window" => window::scene(),
        _ => return None,
    };
    Some(Scene { name: name.into(), ..scene })
}

/// Adds a material and returns its index.
fn add_material(scene: &mut Scene, material: Material) -> u32 {
    scene.materials.push(material);
    scene.materials.len() as u32 - 1
}

/// Finishes a mesh, adds it and returns its index.
fn add_mesh(scene: &mut Scene, name: &str, shape: shapes::Shape) -> u32 {
    let mut mesh = Mesh { name: name.into(), ..shape.into_mesh() };
    mesh.sort_by_opacity(&scene.materials);
    scene.meshes.push(mesh);
    scene.meshes.len() as u32 - 1
}

/// Adds a mesh that stands where it was modelled.
fn place(scene: &mut Scene, name: &str, shape: shapes::Shape) {
    let mesh = add_mesh(scene, name, shape);
    scene.instances.push(crate::Instance::new(name, mesh, glam::Affine3A::IDENTITY));
}
