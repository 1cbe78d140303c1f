use gltf::json::accessor::ComponentType;
use gltf::json::validation::Checked;
use gltf::json::{Index, Root};

use crate::document::Document;
use crate::notices::Notices;
use pt_scene::SceneError;

/// Buffer views lie in their buffers.
pub(crate) fn views(document: &Document, notices: &mut Notices) -> Result<(), SceneError> {
    for (i, buffer) in document.root.buffers.iter().enumerate() {
        if buffer.byte_length.0 == 0 {
            notices.add(format!("buffers[{i}].byteLength"), "is zero or missing");
        }
    }
    for (i, view) in document.root.buffer_views.iter().enumerate() {
        let at = format!("bufferViews[{i}]");
        let others = view.extensions.as_ref().map(|e| &e.others);
        let compressed = others.is_some_and(|o| o.keys().any(|name| name.ends_with("_meshopt_compression")));
        document.get(view.buffer, &format!("{at}.buffer"))?;
        if !compressed {
            document.view(Index::new(i as u32), &at)?;
        }
        if view.byte_length.0 == 0 {
            notices.add(format!("{at}.byteLength"), "is zero");
        }
        if let Some(stride) = view.byte_stride.map(|s| s.0) {
            if !stride.is_multiple_of(4) || !(4..=252).contains(&stride) {
                notices.add(format!("{at}.byteStride"), "is not one of 4, 8 .. 252");
            }
            if stride as u64 > view.byte_length.0 {
                notices.add(format!("{at}.byteStride"), "is more than byteLength");
            }
            if matches!(view.target, Some(Checked::Valid(gltf::json::buffer::Target::ElementArrayBuffer))) {
                notices.add(format!("{at}.byteStride"), "is given for a buffer view of indices");
            }
        }
    }
    Ok(())
}

/// Indices that the readers of materials, meshes and nodes follow only where the scene uses them.
pub(crate) fn references(document: &Document) -> Result<(), SceneError> {
    let Root { images, textures, animations, skins, .. } = &document.root;
    for (i, image) in images.iter().enumerate() {
        if let Some(view) = image.buffer_view {
            document.get(view, &format!("images[{i}].bufferView"))?;
        }
    }
    for (i, texture) in textures.iter().enumerate() {
        if let Some(sampler) = texture.sampler {
            document.get(sampler, &format!("textures[{i}].sampler"))?;
        }
    }
    for (i, animation) in animations.iter().enumerate() {
        for (s, sampler) in animation.samplers.iter().enumerate() {
            document.get(sampler.input, &format!("animations[{i}].samplers[{s}].input"))?;
            document.get(sampler.output, &format!("animations[{i}].samplers[{s}].output"))?;
        }
        for (c, channel) in animation.channels.iter().enumerate() {
            let at = format!("animations[{i}].channels[{c}]");
            if channel.sampler.value() >= animation.samplers.len() {
                let what = format!("index {} does not exist", channel.sampler.value());
                return Err(document.invalid(format!("{at}.sampler"), what));
            }
            if let Checked::Valid(_) = channel.target.path {
                document.get(channel.target.node, &format!("{at}.target.node"))?;
            }
        }
    }
    for (i, skin) in skins.iter().enumerate() {
        for (j, &joint) in skin.joints.iter().enumerate() {
            document.get(joint, &format!("skins[{i}].joints[{j}]"))?;
        }
        if let Some(matrices) = skin.inverse_bind_matrices {
            document.get(matrices, &format!("skins[{i}].inverseBindMatrices"))?;
        }
        if let Some(skeleton) = skin.skeleton {
            document.get(skeleton, &format!("skins[{i}].skeleton"))?;
        }
    }
    Ok(())
}

/// Accessors lie in their buffer views; alignment, which does not matter for reading bytes.
pub(crate) fn accessors(document: &Document, notices: &mut Notices) -> Result<(), SceneError> {
    for (i, accessor) in document.root.accessors.iter().enumerate() {
        let at = format!("accessors[{i}]");
        document.check_accessor(i)?;
        let (Checked::Valid(component), Checked::Valid(kind)) = (accessor.component_type, accessor.type_)
        else {
            notices.add(&at, "its type or component type is unknown");
            continue;
        };
        let component = component.0;
        if accessor.normalized && matches!(component, ComponentType::F32 | ComponentType::U32) {
            notices.add(format!("{at}.normalized"), "is meant for 8- and 16-bit integers");
        }
        let offset = accessor.byte_offset.map_or(0, |o| o.0);
        if accessor.buffer_view.is_none() && accessor.byte_offset.is_some() {
            notices.add(format!("{at}.byteOffset"), "means nothing without a bufferView");
        }
        let size = component.size() as u64;
        let start = accessor.buffer_view.and_then(|v| document.root.buffer_views[v.value()].byte_offset);
        let matrix = kind.multiplicity() > 4 || kind == gltf::json::accessor::Type::Mat2;
        let alignment = if matrix { size.max(4) } else { size };
        if !offset.is_multiple_of(alignment) || !start.map_or(0, |s| s.0).is_multiple_of(size) {
            notices.add(&at, "its data are not aligned to their component type");
        }
        if let Some(sparse) = &accessor.sparse {
            for view in [sparse.indices.buffer_view, sparse.values.buffer_view] {
                if document.root.buffer_views[view.value()].byte_stride.is_some() {
                    notices.add(format!("{at}.sparse"), "its buffer view has a byteStride");
                }
            }
        }
    }
    Ok(())
}
