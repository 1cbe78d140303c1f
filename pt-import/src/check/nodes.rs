use glam::Mat4;

use crate::document::Document;
use crate::notices::Notices;
use pt_scene::SceneError;

/// Checks that nodes form trees and that their references exist.
pub(crate) fn check(document: &Document, notices: &mut Notices) -> Result<(), SceneError> {
    let root = &document.root;
    let mut parents = vec![None; root.nodes.len()];
    for (i, node) in root.nodes.iter().enumerate() {
        let at = format!("nodes[{i}]");
        for (c, &child) in node.children.iter().flatten().enumerate() {
            let at = format!("{at}.children[{c}]");
            document.get(child, &at)?;
            if let Some(other) = parents[child.value()].replace(i) {
                let what =
                    format!("node {} is a child of node {other} too; nodes must form a tree", child.value());
                return Err(document.invalid(at, what));
            }
        }
        if let Some(mesh) = node.mesh {
            document.get(mesh, &format!("{at}.mesh"))?;
        }
        if let Some(camera) = node.camera {
            document.get(camera, &format!("{at}.camera"))?;
        }
        if let Some(skin) = node.skin {
            document.get(skin, &format!("{at}.skin"))?;
        }
        transform(node, &at, notices);
        dependencies(document, node, &at, notices);
    }
    cycles(document, &parents)?;
    for (s, scene) in root.scenes.iter().enumerate() {
        for (n, &node) in scene.nodes.iter().enumerate() {
            let at = format!("scenes[{s}].nodes[{n}]");
            document.get(node, &at)?;
            if parents[node.value()].is_some() {
                notices.add(at, "is no root node; what its parents do to it is left out");
            }
        }
    }
    Ok(())
}

/// With one parent each, a node is on a cycle exactly when following parents never ends. Every node is looked at once.
fn cycles(document: &Document, parents: &[Option<usize>]) -> Result<(), SceneError> {
    let mut done = vec![false; parents.len()];
    let mut path = vec![usize::MAX; parents.len()];
    for start in 0..parents.len() {
        let mut node = start;
        while !done[node] {
            if path[node] == start {
                let what = format!("node {node} is its own ancestor; nodes must form a tree");
                return Err(document.invalid(format!("nodes[{node}].children"), what));
            }
            path[node] = start;
            match parents[node] {
                Some(parent) => node = parent,
                None => break,
            }
        }
        let mut node = start;
        while !std::mem::replace(&mut done[node], true) {
            match parents[node] {
                Some(parent) => node = parent,
                None => break,
            }
        }
    }
    Ok(())
}

fn transform(node: &gltf::json::Node, at: &str, notices: &mut Notices) {
    if let Some(matrix) = &node.matrix {
        if node.translation.is_some() || node.rotation.is_some() || node.scale.is_some() {
            notices.add(at, "has a matrix beside translation, rotation or scale; the matrix is used");
        }
        let m = Mat4::from_cols_array(matrix);
        let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis].map(|c| c.truncate().normalize_or_zero());
        if x.dot(y).abs().max(y.dot(z).abs()).max(z.dot(x).abs()) > 1e-3 {
            notices.add(
                format!("{at}.matrix"),
                "is sheared, which translation, rotation and scale cannot express",
            );
        }
        if m.row(3) != glam::Vec4::W {
            notices.add(format!("{at}.matrix"), "is not affine; its last row is left out");
        }
    }
    if let Some(rotation) = node.rotation {
        let length = rotation.0.iter().map(|x| x * x).sum::<f32>();
        if (length - 1.0).abs() > 2e-3 {
            notices.add(format!("{at}.rotation"), "is no unit quaternion; normalised");
        }
    }
}

fn dependencies(document: &Document, node: &gltf::json::Node, at: &str, notices: &mut Notices) {
    use gltf::json::mesh::Semantic;
    use gltf::json::validation::Checked;
    let Some(mesh) = node.mesh.and_then(|m| document.root.meshes.get(m.value())) else {
        if node.skin.is_some() {
            notices.add(format!("{at}.skin"), "means nothing without a mesh");
        }
        if node.weights.is_some() {
            notices.add(format!("{at}.weights"), "means nothing without a mesh");
        }
        return;
    };
    let joints = Checked::Valid(Semantic::Joints(0));
    if node.skin.is_some() && !mesh.primitives.iter().all(|p| p.attributes.contains_key(&joints)) {
        notices.add(format!("{at}.skin"), "the mesh has primitives without joints");
    }
    let targets = mesh.primitives.first().and_then(|p| p.targets.as_ref()).map_or(0, Vec::len);
    if node.weights.as_ref().is_some_and(|w| w.len() != targets) {
        notices.add(format!("{at}.weights"), "differ in number from the morph targets");
    }
}
