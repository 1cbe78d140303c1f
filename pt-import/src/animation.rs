//! Node hierarchy, animations, skins and morph targets of a glTF file.

use glam::{Affine3A, Mat4};
use gltf::json::animation::{Animation, Interpolation as JsonInterpolation, Property as JsonProperty};
use gltf::json::scene::Node;
use gltf::json::validation::Checked;
use std::collections::BTreeSet;
use std::sync::Arc;

use crate::document::Document;
use crate::notices::Notices;
use crate::options::LoadOptions;
use crate::transforms::{local_transform, local_trs};
use pt_scene::animation::{
    AnimationChoice, AnimationEnd, AnimationInfo, Deformation, Interpolation, Property, Rig, RigNode,
    Sampler, Skin, Track, Trs, VertexLists, unit,
};
use pt_scene::{Mesh, Scene, SceneError};

/// Lists the animations of the file and makes the rig of those that the options play. A file in which nothing can move gets none.
pub(crate) fn read_rig(
    document: &Document,
    options: &LoadOptions,
    scene: &mut Scene,
    notices: &mut Notices,
) -> Result<Option<Arc<Rig>>, SceneError> {
    let root = &document.root;
    let mut tracks = Vec::new();
    for (i, animation) in root.animations.iter().enumerate() {
        let clip = read_animation(document, animation, &format!("animations[{i}]"), notices)?;
        let duration = clip.iter().map(|t| t.sampler.end()).fold(0.0, f64::max);
        let name = animation.name.clone().unwrap_or_default();
        scene.animations.push(AnimationInfo { name, duration, channels: clip.len(), plays: false });
        tracks.push(clip);
    }
    choose(document, &options.animation, &tracks, scene)?;
    let morphs = root.meshes.iter().flat_map(|m| &m.primitives).any(|p| p.targets.is_some());
    if root.animations.is_empty() && root.skins.is_empty() && !morphs {
        return Ok(None);
    }
    let playing = tracks.into_iter().zip(&scene.animations).filter(|(_, info)| info.plays);
    let playing = playing.flat_map(|(tracks, info)| {
        let period = match options.animation_end {
            AnimationEnd::Loop => info.duration,
            AnimationEnd::Hold => 0.0,
        };
        tracks.into_iter().map(move |track| Track { period, ..track })
    });
    let rig = Rig::new(rig_nodes(document)?, playing.collect())
        .map_err(|node| document.invalid(format!("nodes[{node}]"), "nodes must form trees"))?;
    Ok(Some(Arc::new(rig)))
}

/// Marks the animations that play.
fn choose(
    document: &Document,
    choice: &AnimationChoice,
    tracks: &[Vec<Track>],
    scene: &mut Scene,
) -> Result<(), SceneError> {
    let mut moved = BTreeSet::new();
    let mut found =
        matches!(choice, AnimationChoice::Compatible | AnimationChoice::All | AnimationChoice::None);
    for (i, info) in scene.animations.iter_mut().enumerate() {
        let targets = || tracks[i].iter().map(|t| (t.node, t.property));
        info.plays = match choice {
            AnimationChoice::Compatible => targets().all(|target| !moved.contains(&target)),
            AnimationChoice::All => true,
            AnimationChoice::None => false,
            AnimationChoice::Index(index) => i == *index,
            // Names may repeat: the first counts.
            AnimationChoice::Name(name) => !found && info.name == *name,
        };
        found |= info.plays;
        if info.plays {
            moved.extend(targets());
        }
    }
    if found {
        return Ok(());
    }
    let names: Vec<_> =
        scene.animations.iter().enumerate().map(|(i, a)| format!("{i} \"{}\"", a.name)).collect();
    let there = if names.is_empty() { "none".into() } else { names.join(", ") };
    let wanted = match choice {
        AnimationChoice::Index(index) => index.to_string(),
        AnimationChoice::Name(name) => format!("{name:?}"),
        _ => String::new(),
    };
    Err(document.invalid("animations", format!("there is no animation {wanted}; the file has {there}")))
}

fn rig_nodes(document: &Document) -> Result<Vec<RigNode>, SceneError> {
    let root = &document.root;
    let mut parents = vec![None; root.nodes.len()];
    for (n, node) in root.nodes.iter().enumerate() {
        for &child in node.children.iter().flatten() {
            let at = format!("nodes[{n}].children");
            document.get(child, &at)?;
            if parents[child.value()].replace(n as u32).is_some() {
                return Err(document.invalid(
                    at,
                    format!("node {} is reached twice; nodes must form a tree", child.value()),
                ));
            }
        }
    }
    let nodes = root.nodes.iter().zip(parents);
    nodes.enumerate().map(|(n, (node, parent))| rig_node(document, node, parent, n)).collect()
}

fn rig_node(document: &Document, node: &Node, parent: Option<u32>, n: usize) -> Result<RigNode, SceneError> {
    let local = local_transform(node);
    if !local.is_finite() {
        return Err(document.invalid(format!("nodes[{n}]"), "the transform is not finite"));
    }
    let trs = if node.matrix.is_some() {
        let (scale, rotation, translation) = local.to_scale_rotation_translation();
        Trs { translation, rotation: unit(rotation), scale }
    } else {
        local_trs(node)
    };
    let mut weights = Vec::new();
    if let Some(mesh) = node.mesh {
        let description = document.get(mesh, &format!("nodes[{n}].mesh"))?;
        let targets = description.primitives.iter().map(|p| p.targets.as_ref().map_or(0, Vec::len)).max();
        let given = node.weights.as_ref().or(description.weights.as_ref());
        weights = given.cloned().unwrap_or_default();
        weights.resize(targets.unwrap_or(0), 0.0);
        if !weights.iter().all(|w| w.is_finite()) {
            return Err(document.invalid(format!("nodes[{n}].weights"), "a weight is not finite"));
        }
    }
    Ok(RigNode { parent, local, trs, weights })
}

fn read_animation(
    document: &Document,
    animation: &Animation,
    at: &str,
    notices: &mut Notices,
) -> Result<Vec<Track>, SceneError> {
    let mut tracks = Vec::new();
    for (c, channel) in animation.channels.iter().enumerate() {
        let at_channel = format!("{at}.channels[{c}]");
        let Checked::Valid(path) = channel.target.path else {
            notices.add(at_channel, "left out, it moves no property of a node");
            continue;
        };
        let node = document.get(channel.target.node, &format!("{at_channel}.target.node"))?;
        let at_sampler = format!("{at}.samplers[{}]", channel.sampler.value());
        let sampler = animation
            .samplers
            .get(channel.sampler.value())
            .ok_or_else(|| document.invalid(format!("{at_channel}.sampler"), "there is no such sampler"))?;
        let (property, width) = match path {
            JsonProperty::Translation => (Property::Translation, 3),
            JsonProperty::Scale => (Property::Scale, 3),
            JsonProperty::Rotation => (Property::Rotation, 4),
            JsonProperty::MorphTargetWeights => {
                let mesh = node.mesh.and_then(|mesh| document.root.meshes.get(mesh.value()));
                let targets = mesh.iter().flat_map(|m| &m.primitives).filter_map(|p| p.targets.as_ref());
                match targets.map(Vec::len).max() {
                    Some(count) if count > 0 => (Property::Weights, count),
                    _ => {
                        notices.add(at_channel, "left out, its node has no morph targets");
                        continue;
                    }
                }
            }
        };
        let Checked::Valid(interpolation) = sampler.interpolation else {
            return Err(document.invalid(format!("{at_sampler}.interpolation"), "unknown interpolation"));
        };
        let interpolation = match interpolation {
            JsonInterpolation::Linear => Interpolation::Linear,
            JsonInterpolation::Step => Interpolation::Step,
            JsonInterpolation::CubicSpline => Interpolation::CubicSpline,
        };
        let at_input = format!("{at_sampler}.input");
        let times = document.floats::<1>(sampler.input, &at_input)?;
        if times.first().is_some_and(|&[first]| first < 0.0) {
            notices.add(at_input, "has keys before time 0; the animation begins at 0");
        }
        let at_output = format!("{at_sampler}.output");
        let values = match property {
            Property::Rotation => document.floats::<4>(sampler.output, &at_output)?.concat(),
            Property::Weights => document.floats::<1>(sampler.output, &at_output)?.concat(),
            _ => document.floats::<3>(sampler.output, &at_output)?.concat(),
        };
        let sampler = Sampler::new(times.concat(), values, width, interpolation)
            .map_err(|what| document.invalid(at_sampler, what))?;
        tracks.push(Track { node: channel.target.node.value() as u32, property, sampler, period: 0.0 });
    }
    Ok(tracks)
}

/// Gives every instance of a mesh that deforms a mesh of its own; shapes and places that never change are settled here.
pub(crate) fn attach(
    document: &Document,
    rig: Option<Arc<Rig>>,
    scene: &mut Scene,
) -> Result<(), SceneError> {
    let Some(rig) = rig else {
        scene.instances.iter_mut().for_each(|instance| instance.attachment = None);
        scene.meshes.iter_mut().for_each(|mesh| mesh.influences = VertexLists::default());
        return Ok(());
    };
    let mut skins = vec![None; document.root.skins.len()];
    let mut rigid = vec![false; scene.meshes.len()];
    let mut own_meshes = Vec::new();
    let mut copied = 0u64;
    for instance in &mut scene.instances {
        let mesh = &scene.meshes[instance.mesh as usize];
        let Some(node) = instance.attachment.map(|a| a.node) else {
            rigid[instance.mesh as usize] = true;
            continue;
        };
        let at = format!("nodes[{node}].skin");
        let skin = match document.root.nodes[node as usize].skin {
            Some(index) if !mesh.influences.is_empty() => {
                document.get(index, &at)?;
                let slot: &mut Option<Arc<Skin>> = &mut skins[index.value()];
                let skin = match slot.take() {
                    Some(skin) => skin,
                    None => Arc::new(read_skin(document, index.value())?),
                };
                Some(slot.insert(skin).clone())
            }
            _ => None,
        };
        instance.attachment = instance.attachment.filter(|_| rig.moves(node) && skin.is_none());
        if skin.is_none() && mesh.morphs.is_empty() {
            rigid[instance.mesh as usize] = true;
            continue;
        }
        let items = size_of_val(mesh.influences.items()) + size_of_val(mesh.morphs.items());
        // Two poses, vertices at rest and their other attributes.
        copied = copied.saturating_add((items + 256 * mesh.vertex_count()) as u64);
        let limit = document.max_geometry_bytes;
        if copied > limit {
            let what = format!("more than {limit} bytes of meshes that deform; see --max-geometry-bytes");
            return Err(document.invalid(format!("nodes[{node}].mesh"), what));
        }
        if skin.is_some() {
            // The joints alone place a skinned mesh.
            instance.world_from_object = Affine3A::IDENTITY;
            instance.world_from_object_prev = Affine3A::IDENTITY;
        }
        let own = own_mesh(&rig, mesh, node, skin).map_err(|what| document.invalid(at, what))?;
        instance.mesh = (scene.meshes.len() + own_meshes.len()) as u32;
        own_meshes.push(own);
    }
    // What only deforming instances used is not needed any more.
    let mut renamed = Vec::new();
    for (mesh, mut rest) in rigid.iter().zip(std::mem::take(&mut scene.meshes)) {
        renamed.push(scene.meshes.len() as u32);
        if *mesh || own_meshes.is_empty() {
            (rest.influences, rest.morphs) = (VertexLists::default(), VertexLists::default());
            scene.meshes.push(rest);
        }
    }
    for instance in &mut scene.instances {
        let (old, kept) = (instance.mesh as usize, scene.meshes.len());
        let own = || (old - renamed.len() + kept) as u32;
        instance.mesh = renamed.get(old).copied().unwrap_or_else(own);
    }
    scene.meshes.append(&mut own_meshes);
    scene.rig = rig.is_animated().then_some(rig);
    Ok(())
}

/// A copy of `mesh` for one node: deforming, or rigid in the pose that it never leaves.
fn own_mesh(rig: &Rig, mesh: &Mesh, node: u32, skin: Option<Arc<Skin>>) -> Result<Mesh, String> {
    let joints = skin.as_ref().map_or(&[][..], |s| &s.joints);
    let mut own = mesh.clone();
    if skin.is_none() {
        own.influences = VertexLists::default();
    }
    if let Some(wrong) = own.influences.items().iter().find(|i| i.joint as usize >= joints.len()) {
        return Err(format!("mesh {} names joint {} of {}", mesh.name, wrong.joint, joints.len()));
    }
    let moves = rig.moves(node) || joints.iter().any(|&joint| rig.moves(joint));
    let mut deformation = Deformation::new(&own, node, skin, &rig.rest().weights[node as usize]);
    deformation.set_pose(rig.rest());
    own.deformation = Some(Box::new(deformation));
    if !moves {
        own.pose();
        own.deformation = None;
        (own.influences, own.morphs) = (VertexLists::default(), VertexLists::default());
    }
    Ok(own)
}

fn read_skin(document: &Document, index: usize) -> Result<Skin, SceneError> {
    let at = format!("skins[{index}]");
    let description = &document.root.skins[index];
    let mut joints = Vec::new();
    for &joint in &description.joints {
        document.get(joint, &format!("{at}.joints"))?;
        joints.push(joint.value() as u32);
    }
    let inverse_bind = match description.inverse_bind_matrices {
        Some(accessor) => {
            let at = format!("{at}.inverseBindMatrices");
            let matrices = document.floats::<16>(accessor, &at)?;
            if matrices.len() < joints.len() {
                return Err(
                    document.invalid(at, format!("{} matrices for {} joints", matrices.len(), joints.len()))
                );
            }
            let affine = |m: [f32; 16]| Affine3A::from_mat4(Mat4::from_cols_array(&m));
            let matrices: Vec<_> = matrices.into_iter().take(joints.len()).map(affine).collect();
            if !matrices.iter().all(Affine3A::is_finite) {
                return Err(document.invalid(at, "a matrix is not finite"));
            }
            matrices
        }
        None => vec![Affine3A::IDENTITY; joints.len()],
    };
    Ok(Skin { joints, inverse_bind })
}
