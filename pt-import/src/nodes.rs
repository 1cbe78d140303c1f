use std::collections::BTreeMap;
use std::f32::consts::FRAC_PI_2;
use std::sync::Arc;

use glam::{Affine3A, Quat, Vec3};
use gltf::json::camera::Type as CameraType;
use gltf::json::extensions::scene::khr_lights_punctual::{Light as JsonLight, Type as LightType};
use gltf::json::scene::Node;
use gltf::json::validation::Checked;
use gltf::json::{Camera as JsonCamera, Index, Scene as JsonScene};
use serde::Deserialize;

use crate::document::Document;
use crate::effect_extras;
use crate::meshes::Shape;
use crate::notices::Notices;
use crate::options::LoadOptions;
use crate::transforms::{local_transform, unit_quaternion};
use pt_scene::animation::{NodeMotion, Rig, Trs};
use pt_scene::is_invertible;
use pt_scene::shines;
use pt_scene::without_scale;
use pt_scene::{
    Attachment, Camera, Instance, Light, LightKind, MAX_PORTALS, Portal, Projection, Scene, SceneError,
};
use pt_scene::{thickened, visible};

/// The nodes that instances, cameras and lights come from, in the order of those in [`Scene`].
#[derive(Default)]
pub(crate) struct Origins {
    pub instances: Vec<usize>,
    pub cameras: Vec<usize>,
    pub lights: Vec<usize>,
}

/// Walks the node hierarchy of a scene and places meshes, cameras and lights.
pub(crate) fn read(
    document: &Document,
    shapes: &[Option<Shape>],
    rig: Option<&Arc<Rig>>,
    options: &LoadOptions,
    scene: &mut Scene,
    notices: &mut Notices,
) -> Result<Origins, SceneError> {
    let root = &document.root;
    let mut origins = Origins::default();
    let mut pending: Vec<(Index<Node>, Affine3A, String)> = Vec::new();
    match chosen_scene(document, options)? {
        Some(index) => {
            let nodes = &document.get(index, "scene")?.nodes;
            let at = |n: usize| format!("scenes[{}].nodes[{n}]", index.value());
            pending
                .extend(nodes.iter().enumerate().rev().map(|(n, &node)| (node, Affine3A::IDENTITY, at(n))));
            if root.scenes.len() > 1 {
                let others = root.scenes.len() - 1;
                notices
                    .add(format!("scenes[{}]", index.value()), format!("shown; the file has {others} more"));
            }
        }
        None if !root.nodes.is_empty() => notices.add("nodes", "the file has nodes but no scene to show"),
        None => {}
    }
    let mut visited = vec![false; root.nodes.len()];
    while let Some((index, parent, at)) = pending.pop() {
        let node = document.get(index, &at)?;
        if std::mem::replace(&mut visited[index.value()], true) {
            return Err(document
                .invalid(at, format!("node {} is reached twice; nodes must form a tree", index.value())));
        }
        let at = format!("nodes[{}]", index.value());
        if !is_visible(document, node, &at)? {
            continue;
        }
        let world = parent * local_transform(node);
        if !world.is_finite() {
            return Err(document.invalid(at, "the transform is not finite"));
        }
        let motion = rig.and_then(|rig| NodeMotion::new(rig, index.value() as u32));
        place(document, index, motion, &world, &at, shapes, scene, notices)?;
        origins.instances.resize(scene.instances.len(), index.value());
        origins.cameras.resize(scene.cameras.len(), index.value());
        origins.lights.resize(scene.lights.len(), index.value());
        let children = node.children.iter().flatten().rev();
        pending.extend(children.map(|&child| (child, world, format!("{at}.children"))));
    }
    sort_cameras(scene, &mut origins);
    Ok(origins)
}

/// Cameras in the order of the file, so that the first one is the file's first.
fn sort_cameras(scene: &mut Scene, origins: &mut Origins) {
    let mut cameras: Vec<_> = scene.cameras.drain(..).zip(origins.cameras.drain(..)).collect();
    cameras.sort_by_key(|(camera, _)| camera.index);
    (scene.cameras, origins.cameras) = cameras.into_iter().unzip();
}

/// The requested scene, by name or else by index; without a request the default scene, or the first one.
fn chosen_scene(document: &Document, options: &LoadOptions) -> Result<Option<Index<JsonScene>>, SceneError> {
    let scenes = &document.root.scenes;
    let Some(wanted) = &options.scene else {
        return Ok(document.root.scene.or((!scenes.is_empty()).then(|| Index::new(0))));
    };
    let names: Vec<_> = scenes.iter().map(|s| s.name.clone().unwrap_or_default()).collect();
    let index = crate::options::named(wanted, &names);
    let index = index.map_err(|what| document.invalid("scenes", format!("no scene {what}")))?;
    Ok(Some(Index::new(index as u32)))
}

#[derive(Deserialize)]
struct Visibility {
    #[serde(default = "yes")]
    visible: bool,
}

fn yes() -> bool {
    true
}

/// KHR_node_visibility; an invisible node hides its children too.
fn is_visible(document: &Document, node: &Node, at: &str) -> Result<bool, SceneError> {
    let others = node.extensions.as_ref().map(|e| &e.others);
    let visibility = document.extension::<Visibility>(others, "KHR_node_visibility", at)?;
    Ok(visibility.is_none_or(|v| v.visible))
}

/// What a node's `extras` may hold: the width and height of a portal of the environment in the node's XY plane, centred.
#[derive(Deserialize)]
struct NodeExtras {
    pt_portal: Option<serde_json::Value>,
}

/// The portal that a node's extras ask for.
fn portal(node: &Node, world: &Affine3A, at: &str, notices: &mut Notices) -> Option<Portal> {
    let extras: NodeExtras = serde_json::from_str(node.extras.as_ref()?.get()).ok()?;
    let size = <[f32; 2]>::deserialize(extras.pt_portal?).ok();
    let portal = size.map(|[width, height]| Portal {
        corner: world.transform_point3(Vec3::new(-0.5 * width, -0.5 * height, 0.0)),
        edges: [Vec3::X * width, Vec3::Y * height].map(|edge| world.transform_vector3(edge)),
    });
    let portal = portal.filter(Portal::has_area);
    if portal.is_none() {
        notices.add(format!("{at}.extras.pt_portal"), "left out, it is not [width, height] of a rectangle");
    }
    portal
}

#[derive(Deserialize)]
struct Instancing {
    attributes: BTreeMap<String, u32>,
}

/// Transforms of the copies that EXT_mesh_gpu_instancing makes of a node's mesh, in the space of the node.
fn instances(document: &Document, node: &Node, at: &str) -> Result<Option<Vec<Affine3A>>, SceneError> {
    const NAME: &str = "EXT_mesh_gpu_instancing";
    let others = node.extensions.as_ref().map(|e| &e.others);
    let Some(Instancing { attributes }) = document.extension(others, NAME, at)? else { return Ok(None) };
    let at = format!("{at}.extensions.{NAME}.attributes");
    let mut count = None;
    for (name, &accessor) in &attributes {
        let at = format!("{at}.{name}");
        let n = document.count(Index::new(accessor), &at)?;
        if *count.get_or_insert(n) != n {
            return Err(document.invalid(at, format!("has {n} elements, others have {}", count.unwrap_or(0))));
        }
    }
    let count = count.unwrap_or(0);
    if (count as u64).saturating_mul(size_of::<Instance>() as u64) > document.max_geometry_bytes {
        return Err(document.invalid(at, format!("{count} instances are too many; see --max-geometry-bytes")));
    }
    let find = |name: &str| attributes.get(name).map(|&a| (Index::new(a), format!("{at}.{name}")));
    let vectors = |name: &str, default: Vec3| match find(name) {
        Some((index, at)) => {
            Ok(document.floats::<3>(index, &at)?.into_iter().map(Vec3::from_array).collect())
        }
        None => Ok(vec![default; count]),
    };
    let rotations = match find("ROTATION") {
        Some((index, at)) => document.floats::<4>(index, &at)?.into_iter().map(unit_quaternion).collect(),
        None => vec![Quat::IDENTITY; count],
    };
    let (translations, scales) = (vectors("TRANSLATION", Vec3::ZERO)?, vectors("SCALE", Vec3::ONE)?);
    let place = |((translation, rotation), scale)| Trs { translation, rotation, scale }.into();
    Ok(Some(translations.into_iter().zip(rotations).zip(scales).map(place).collect()))
}

#[expect(clippy::too_many_arguments, reason = "the walk's state")]
fn place(
    document: &Document,
    index: Index<Node>,
    motion: Option<NodeMotion>,
    world: &Affine3A,
    at: &str,
    shapes: &[Option<Shape>],
    scene: &mut Scene,
    notices: &mut Notices,
) -> Result<(), SceneError> {
    let node = document.get(index, at)?;
    let number = index.value() as u32;
    effect_extras::add(document, node, world, at, &mut scene.effects)?;
    scene.portals.extend(portal(node, world, at, notices));
    if scene.portals.len() > MAX_PORTALS {
        scene.portals.truncate(MAX_PORTALS);
        notices.add(at, format!("its portal is left out, a scene has at most {MAX_PORTALS}"));
    }
    let name = node.name.as_deref().unwrap_or(at);
    if let Some(mesh) = node.mesh {
        document.get(mesh, &format!("{at}.mesh"))?;
        let moves = motion.is_some() || node.skin.is_some();
        let mut add = |name: &str, shape: Shape, offset: Affine3A| {
            let world = *world * offset;
            if is_invertible(&world) || thickened(&world).is_some() || moves {
                let attachment = Some(Attachment { node: number, offset });
                let material = shape.material;
                let instance = Instance::new(name, shape.mesh, visible(world));
                scene.instances.push(Instance { attachment, material, ..instance });
            } else {
                notices.add(at, "left out, its scale is zero along two axes or beyond single precision");
            }
        };
        match (shapes[mesh.value()], instances(document, node, at)?) {
            (Some(shape), Some(copies)) => {
                let copies = copies.iter().enumerate();
                copies.for_each(|(i, &copy)| add(&format!("{name}[{i}]"), shape, copy));
            }
            (Some(shape), None) => add(name, shape, Affine3A::IDENTITY),
            (None, _) => {}
        }
    }
    if let Some(index) = node.camera {
        let description = document.get(index, &format!("{at}.camera"))?;
        let at = format!("cameras[{}]", index.value());
        let projection = projection(document, description, &at)?;
        let name = node.name.as_deref().or(description.name.as_deref()).unwrap_or(&at);
        scene.cameras.push(Camera {
            index: Some(index.value()),
            projection,
            world_from_camera: without_scale(world),
            motion: motion.clone(),
            ..Camera::look_at(name, Vec3::ZERO, Vec3::NEG_Z, 1.0)
        });
    }
    let light = node.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref()).map(|l| l.light);
    if let Some(index) = light {
        let description = document.get(index, &format!("{at}.extensions.KHR_lights_punctual"))?;
        let at = format!("extensions.KHR_lights_punctual.lights[{}]", index.value());
        let node = motion.map(|_| number);
        let light = light_at(document, description, world, &at, name, notices)?;
        scene.lights.push(Light { node, ..light });
    }
    Ok(())
}

/// The height of the view is the camera's; the width follows the image (`aspectRatio` and `xmag` are for another image).
fn projection(document: &Document, camera: &JsonCamera, at: &str) -> Result<Projection, SceneError> {
    match (camera.type_, &camera.perspective, &camera.orthographic) {
        (Checked::Valid(CameraType::Perspective), Some(p), _) => {
            if !(p.yfov > 0.0 && p.yfov < std::f32::consts::PI) {
                let what = format!("{} is not between 0 and pi", p.yfov);
                return Err(document.invalid(format!("{at}.perspective.yfov"), what));
            }
            Ok(Projection::Perspective { yfov: p.yfov })
        }
        (Checked::Valid(CameraType::Orthographic), _, Some(o)) => {
            if !o.ymag.is_normal() {
                let what = format!("{} is zero or not finite", o.ymag);
                return Err(document.invalid(format!("{at}.orthographic.ymag"), what));
            }
            Ok(Projection::Orthographic { ymag: o.ymag.abs() })
        }
        _ => Err(document.invalid(at, "has no projection of its type")),
    }
}

fn light_at(
    document: &Document,
    light: &JsonLight,
    world: &Affine3A,
    at: &str,
    node: &str,
    notices: &mut Notices,
) -> Result<Light, SceneError> {
    let kind = match (light.type_, &light.spot) {
        (Checked::Valid(LightType::Point), _) => LightKind::Point,
        (Checked::Valid(LightType::Directional), _) => LightKind::Directional,
        (Checked::Valid(LightType::Spot), Some(spot)) => {
            let outer = spot.outer_cone_angle.clamp(1e-3, FRAC_PI_2);
            let inner = spot.inner_cone_angle.clamp(0.0, outer * 0.999);
            if !(outer.is_finite() && inner.is_finite()) {
                return Err(document.invalid(format!("{at}.spot"), "an angle is not finite"));
            }
            if (inner, outer) != (spot.inner_cone_angle, spot.outer_cone_angle) {
                notices.add(format!("{at}.spot"), "angles are not 0 <= inner < outer <= pi/2; clamped");
            }
            LightKind::Spot { inner, outer }
        }
        (Checked::Valid(LightType::Spot), None) => {
            return Err(document.invalid(at, "a spot light needs its spot object"));
        }
        (Checked::Invalid, _) => return Err(document.invalid(format!("{at}.type"), "unknown light type")),
    };
    let direction = shines(world);
    let intensity = light.intensity * Vec3::from_array(light.color);
    if !intensity.is_finite() || intensity.min_element() < 0.0 {
        return Err(
            document.invalid(at, format!("colour x intensity is negative or not finite: {intensity}"))
        );
    }
    let name = light.name.as_deref().unwrap_or(node);
    Ok(Light { kind, direction, ..Light::point(name, world.translation.into(), intensity) })
}
