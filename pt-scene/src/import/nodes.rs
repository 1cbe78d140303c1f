use std::sync::Arc;

use glam::{Affine3A, Mat4, Quat, Vec3};
use gltf::json::camera::Type as CameraType;
use gltf::json::extensions::scene::khr_lights_punctual::{Light as JsonLight, Type as LightType};
use gltf::json::scene::Node;
use gltf::json::validation::Checked;
use gltf::json::{Camera as JsonCamera, Index};

use super::document::Document;
use crate::animation::{NodeMotion, Rig, visible};
use crate::camera::without_scale;
use crate::light::shines;
use crate::scene::is_invertible;
use crate::{Attachment, Camera, Instance, Light, LightKind, Projection, Scene, SceneError};

/// Walks the node hierarchy of the default scene and places meshes, cameras and lights.
pub(super) fn read(
    document: &Document,
    meshes: &[Option<u32>],
    rig: Option<&Arc<Rig>>,
    scene: &mut Scene,
) -> Result<(), SceneError> {
    let root = &document.root;
    let mut pending: Vec<(Index<Node>, Affine3A, String)> = Vec::new();
    match root.scene.or((!root.scenes.is_empty()).then(|| Index::new(0))) {
        Some(index) => {
            let at = format!("scenes[{}].nodes", index.value());
            let nodes = &document.get(index, "scene")?.nodes;
            pending.extend(nodes.iter().rev().map(|&node| (node, Affine3A::IDENTITY, at.clone())));
        }
        None if !root.nodes.is_empty() => {
            scene.notices.push("the file has nodes but no scene to show".into())
        }
        None => {}
    }
    if root.scenes.len() > 1 {
        scene
            .notices
            .push(format!("{} scenes in the file, only the default one is loaded", root.scenes.len()));
    }
    let mut visited = vec![false; root.nodes.len()];
    while let Some((index, parent, at)) = pending.pop() {
        let node = document.get(index, &at)?;
        if std::mem::replace(&mut visited[index.value()], true) {
            return Err(document
                .invalid(at, format!("node {} is reached twice; nodes must form a tree", index.value())));
        }
        let at = format!("nodes[{}]", index.value());
        let world = parent * local_transform(node);
        if !world.is_finite() {
            return Err(document.invalid(at, "the transform is not finite"));
        }
        let moves = rig.and_then(|rig| NodeMotion::new(rig, index.value() as u32));
        place(document, index, moves, &world, &at, meshes, scene)?;
        let children = node.children.iter().flatten().rev();
        pending.extend(children.map(|&child| (child, world, format!("{at}.children"))));
    }
    Ok(())
}

pub(super) fn local_transform(node: &Node) -> Affine3A {
    if let Some(matrix) = &node.matrix {
        return Affine3A::from_mat4(Mat4::from_cols_array(matrix));
    }
    let rotation = node.rotation.map_or(Quat::IDENTITY, |q| Quat::from_array(q.0));
    Affine3A::from_scale_rotation_translation(
        Vec3::from_array(node.scale.unwrap_or([1.0; 3])),
        if rotation.length_squared() > 0.0 { rotation.normalize() } else { Quat::IDENTITY },
        Vec3::from_array(node.translation.unwrap_or_default()),
    )
}

fn place(
    document: &Document,
    index: Index<Node>,
    motion: Option<NodeMotion>,
    world: &Affine3A,
    at: &str,
    meshes: &[Option<u32>],
    scene: &mut Scene,
) -> Result<(), SceneError> {
    let node = document.get(index, at)?;
    let number = index.value() as u32;
    let name = node.name.as_deref().unwrap_or(at);
    if let Some(mesh) = node.mesh {
        document.get(mesh, &format!("{at}.mesh"))?;
        match meshes[mesh.value()] {
            Some(_) if !is_invertible(world) && motion.is_none() && node.skin.is_none() => {
                scene.notices.push(format!("{at}: left out, its scale is zero"))
            }
            Some(mesh) => scene.instances.push(Instance {
                attachment: Some(Attachment { node: number, offset: Affine3A::IDENTITY }),
                ..Instance::new(name, mesh, visible(*world))
            }),
            None => {}
        }
    }
    if let Some(index) = node.camera {
        let description = document.get(index, &format!("{at}.camera"))?;
        let at = format!("cameras[{}]", index.value());
        let projection = projection(document, description, &at)?;
        let name = node.name.as_deref().or(description.name.as_deref()).unwrap_or(&at);
        scene.cameras.push(Camera {
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
        scene.lights.push(Light { node, ..light_at(document, description, world, &at, name)? });
    }
    Ok(())
}

fn projection(document: &Document, camera: &JsonCamera, at: &str) -> Result<Projection, SceneError> {
    match (camera.type_, &camera.perspective, &camera.orthographic) {
        (Checked::Valid(CameraType::Perspective), Some(p), _) => Ok(Projection::Perspective { yfov: p.yfov }),
        (Checked::Valid(CameraType::Orthographic), _, Some(o)) => {
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
) -> Result<Light, SceneError> {
    let kind = match (light.type_, &light.spot) {
        (Checked::Valid(LightType::Point), _) => LightKind::Point,
        (Checked::Valid(LightType::Directional), _) => LightKind::Directional,
        (Checked::Valid(LightType::Spot), Some(spot)) => {
            LightKind::Spot { inner: spot.inner_cone_angle, outer: spot.outer_cone_angle }
        }
        (Checked::Valid(LightType::Spot), None) => {
            return Err(document.invalid(at, "a spot light needs its spot object"));
        }
        (Checked::Invalid, _) => return Err(document.invalid(format!("{at}.type"), "unknown light type")),
    };
    let direction = shines(world);
    let intensity = light.intensity * Vec3::from_array(light.color);
    let name = light.name.as_deref().unwrap_or(node);
    Ok(Light { kind, direction, ..Light::point(name, world.translation.into(), intensity) })
}
