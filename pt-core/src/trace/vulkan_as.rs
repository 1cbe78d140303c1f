//! The driver's acceleration structures (`VK_KHR_acceleration_structure`) for the ray-query and rt-pipeline backends.
//!
//! Bottom level: one structure a mesh, geometry 0 the opaque triangles, geometry 1 those with the alpha test; built once, and
//! updated inside the frame (the topology stays) when the mesh deforms.
//! Top level: rebuilt inside the frame; all its memory is taken for the number of instances given at the start.

use super::{InstancePlacement, MeshGeometry, MovedMesh};
use crate::buffer::{Buffer, Location};
use crate::device::Device;
use crate::error::{Error, Result, VkContext};
use crate::frame::{Frame, PassInfo, Touch};
use ash::{khr, vk};
use glam::{UVec3, Vec3};

/// One acceleration structure with its memory.
struct Structure {
    device: Device,
    buffer: Buffer,
    handle: vk::AccelerationStructureKHR,
    address: u64,
}

impl Structure {
    fn new(device: &Device, name: &str, ty: vk::AccelerationStructureTypeKHR, size: u64) -> Result<Self> {
        let extension = extension(device)?;
        let usage = vk::BufferUsageFlags::ACCELERATION_STRUCTURE_STORAGE_KHR;
        let buffer = Buffer::with_usage(device, name, size, Location::Device, usage)?;
        let info =
            vk::AccelerationStructureCreateInfoKHR::default().buffer(buffer.handle()).size(size).ty(ty);
        // SAFETY: the buffer has that size and lives as long as the structure.
        let handle = unsafe { extension.create_acceleration_structure(&info, None) }
            .context("vkCreateAccelerationStructureKHR")?;
        let info = vk::AccelerationStructureDeviceAddressInfoKHR::default().acceleration_structure(handle);
        // SAFETY: valid handle.
        let address = unsafe { extension.get_acceleration_structure_device_address(&info) };
        Ok(Self { device: device.clone(), buffer, handle, address })
    }
}

impl Drop for Structure {
    fn drop(&mut self) {
        if let Ok(extension) = extension(&self.device) {
            // A frame in flight keeps the buffer, not the handle.
            if let Err(error) = self.device.wait_idle() {
                eprintln!("warning: waiting for the device failed: {error}");
            }
            // SAFETY: the device is idle.
            unsafe { extension.destroy_acceleration_structure(self.handle, None) };
        }
    }
}

/// The structure of a mesh and what an update of it needs.
struct MeshStructure {
    structure: Structure,
    /// Triangles without and with the alpha test.
    counts: [u32; 2],
    vertices: u32,
    deforms: bool,
    update_scratch: u64,
}

/// Bottom and top levels of a scene.
pub(super) struct DriverStructures {
    meshes: Vec<Option<MeshStructure>>,
    /// For the updates of all deforming meshes, side by side.
    update_scratch: Option<Buffer>,
    top: Structure,
    instances: Buffer,
    scratch: Buffer,
    capacity: u32,
}

impl DriverStructures {
    pub(super) fn new(device: &Device, meshes: &[MeshGeometry], instances: usize) -> Result<Self> {
        let meshes = meshes.iter().map(|m| build_mesh(device, m)).collect::<Result<Vec<_>>>()?;
        let updates: u64 = meshes
            .iter()
            .flatten()
            .filter(|m| m.deforms)
            .map(|m| scratch_size(device, m.update_scratch))
            .sum();
        let update_scratch = if updates > 0 { Some(scratch(device, updates)?) } else { None };
        let capacity = instances as u32;
        let instance_bytes = (instances * size_of::<vk::AccelerationStructureInstanceKHR>()) as u64;
        // The build wants the instances on a 16-byte boundary, which every buffer's start is.
        let instances =
            Buffer::new(device, "acceleration structure instances", instance_bytes, Location::Device)?;
        let geometry = [top_geometry(&instances)];
        let sizes = build_sizes(device, &top_build(&geometry), &[capacity])?;
        let ty = vk::AccelerationStructureTypeKHR::TOP_LEVEL;
        let top = Structure::new(device, "top-level structure", ty, sizes.acceleration_structure_size)?;
        let scratch = scratch(device, sizes.build_scratch_size)?;
        Ok(Self { meshes, update_scratch, top, instances, scratch, capacity })
    }

    /// Address that `SceneRecord::tlas` takes.
    pub(super) fn address(&self) -> u64 {
        self.top.address
    }

    /// Buffers that a traversal reads.
    pub(super) fn buffers(&self) -> impl Iterator<Item = &Buffer> {
        self.meshes.iter().flatten().map(|m| &m.structure.buffer).chain([&self.top.buffer])
    }

    /// Rebuilds the top level for the passes that follow in this and later frames.
    pub(super) fn update(&mut self, frame: &mut Frame<'_>, placements: &[InstancePlacement]) -> Result<()> {
        let records: Vec<_> = (0..).zip(placements).map(|(index, p)| self.instance(index, p)).collect();
        // SAFETY: the struct has no padding: 48 bytes of matrix, two words, an address.
        let bytes = unsafe {
            std::slice::from_raw_parts(records.as_ptr().cast::<u8>(), size_of_val(records.as_slice()))
        };
        frame.upload(&self.instances, bytes)?;
        let device = self.top.device.clone();
        let extension = extension(&device)?;
        use vk::AccessFlags2 as A;
        let stage = vk::PipelineStageFlags2::ACCELERATION_STRUCTURE_BUILD_KHR;
        let touch = |access, write| Touch { stage, access, write };
        let mut touches = vec![
            (self.instances.id(), touch(A::SHADER_READ, false)),
            (self.top.buffer.id(), touch(A::ACCELERATION_STRUCTURE_WRITE_KHR, true)),
            (
                self.scratch.id(),
                touch(A::ACCELERATION_STRUCTURE_READ_KHR | A::ACCELERATION_STRUCTURE_WRITE_KHR, true),
            ),
        ];
        let deforming = self.meshes.iter().flatten().filter(|m| m.deforms);
        let read = touch(A::ACCELERATION_STRUCTURE_READ_KHR, false);
        touches.extend(deforming.map(|m| (m.structure.buffer.id(), read)));
        let info = PassInfo {
            name: "top-level structure".into(),
            kernel: "(build)".into(),
            extent: [placements.len() as u32, 1, 1],
            reads: vec![self.instances.name().into()],
            writes: vec![self.top.buffer.name().into()],
            bytes: self.instances.size() + self.top.buffer.size(),
            bytes_are_upper_bound: true,
        };
        let keep = [self.instances.clone(), self.top.buffer.clone(), self.scratch.clone()];
        let geometry = [top_geometry(&self.instances)];
        let build = [top_build(&geometry)
            .dst_acceleration_structure(self.top.handle)
            .scratch_data(aligned(&device, &self.scratch))];
        let count = (placements.len() as u32).min(self.capacity);
        let range = [vk::AccelerationStructureBuildRangeInfoKHR::default().primitive_count(count)];
        frame.encode_other(info, &touches, &keep, |_, cmd| {
            // SAFETY: recording; sizes were asked for with at least this many instances; the slot keeps the buffers.
            unsafe { extension.cmd_build_acceleration_structures(cmd, &build, &[&range]) };
        })
    }

    /// Updates the bottom levels of deforming meshes, all in one command.
    pub(super) fn refit(
        &mut self,
        frame: &mut Frame<'_>,
        moved: &[MovedMesh],
        geometry: &[&Buffer],
    ) -> Result<()> {
        let Some(scratch) = &self.update_scratch else { return Ok(()) };
        let device = self.top.device.clone();
        let extension = extension(&device)?;
        use vk::AccessFlags2 as A;
        let stage = vk::PipelineStageFlags2::ACCELERATION_STRUCTURE_BUILD_KHR;
        let update = A::ACCELERATION_STRUCTURE_READ_KHR | A::ACCELERATION_STRUCTURE_WRITE_KHR;
        let mut touches = vec![(scratch.id(), Touch { stage, access: update, write: true })];
        let mut keep = vec![scratch.clone()];
        for buffer in geometry {
            touches.push((buffer.id(), Touch { stage, access: A::SHADER_READ, write: false }));
            keep.push((*buffer).clone());
        }
        let mut address = aligned(&device, scratch);
        let mut triangles = 0;
        let mut works = Vec::with_capacity(moved.len());
        for m in moved {
            let Some(mesh) = self.meshes.get(m.mesh as usize).and_then(Option::as_ref) else { continue };
            touches.push((mesh.structure.buffer.id(), Touch { stage, access: update, write: true }));
            keep.push(mesh.structure.buffer.clone());
            triangles += mesh.counts[0] + mesh.counts[1];
            works.push((
                mesh,
                geometries(mesh.vertices, m.positions, m.indices),
                ranges(mesh.counts),
                address,
            ));
            // SAFETY: all variants are plain addresses.
            unsafe { address.device_address += scratch_size(&device, mesh.update_scratch) };
        }
        let builds: Vec<_> = works
            .iter()
            .map(|(mesh, geometries, _, scratch)| {
                mesh_build(&geometries[..used(mesh.counts)], true)
                    .mode(vk::BuildAccelerationStructureModeKHR::UPDATE)
                    .src_acceleration_structure(mesh.structure.handle)
                    .dst_acceleration_structure(mesh.structure.handle)
                    .scratch_data(*scratch)
            })
            .collect();
        let ranges: Vec<_> = works.iter().map(|(mesh, _, ranges, _)| &ranges[..used(mesh.counts)]).collect();
        let info = PassInfo {
            name: "refit".into(),
            kernel: "(update)".into(),
            extent: [triangles, 1, 1],
            reads: geometry.iter().map(|b| b.name().into()).collect(),
            writes: vec!["bottom-level structure".into()],
            bytes: geometry.iter().map(|b| b.size()).sum(),
            bytes_are_upper_bound: true,
        };
        frame.encode_other(info, &touches, &keep, |_, cmd| {
            // SAFETY: recording; geometry and flags are those of the builds but for the positions; scratch ranges do not overlap
            // and are as large as was asked for; the slot keeps the buffers.
            unsafe { extension.cmd_build_acceleration_structures(cmd, &builds, &ranges) };
        })
    }

    fn instance(&self, index: u32, placement: &InstancePlacement) -> vk::AccelerationStructureInstanceKHR {
        let m = placement.world_from_object;
        let (rows, shift) = (m.matrix3.transpose(), m.translation);
        let flags = vk::GeometryInstanceFlagsKHR::TRIANGLE_FACING_CULL_DISABLE.as_raw() as u8;
        let mesh = self.meshes.get(placement.mesh as usize).and_then(Option::as_ref);
        vk::AccelerationStructureInstanceKHR {
            transform: vk::TransformMatrixKHR {
                matrix: [
                    rows.x_axis.x,
                    rows.x_axis.y,
                    rows.x_axis.z,
                    shift.x,
                    rows.y_axis.x,
                    rows.y_axis.y,
                    rows.y_axis.z,
                    shift.y,
                    rows.z_axis.x,
                    rows.z_axis.y,
                    rows.z_axis.z,
                    shift.z,
                ],
            },
            instance_custom_index_and_mask: vk::Packed24_8::new(index, placement.mask as u8),
            instance_shader_binding_table_record_offset_and_flags: vk::Packed24_8::new(0, flags),
            // Address 0: an inactive instance, for a mesh without triangles.
            acceleration_structure_reference: vk::AccelerationStructureReferenceKHR {
                device_handle: mesh.map_or(0, |m| m.structure.address),
            },
        }
    }
}

fn extension(device: &Device) -> Result<&khr::acceleration_structure::Device> {
    let missing = || Error::Unsupported("the device has no VK_KHR_acceleration_structure".into());
    device.inner().acceleration_structure.as_ref().ok_or_else(missing)
}

fn build_mesh(device: &Device, mesh: &MeshGeometry) -> Result<Option<MeshStructure>> {
    if mesh.indices.is_empty() {
        return Ok(None);
    }
    let positions = Buffer::from_slice(device, "positions for the build", mesh.positions)?;
    let indices = Buffer::from_slice(device, "indices for the build", mesh.indices)?;
    let total = mesh.indices.len() as u32;
    let opaque = mesh.first_masked.min(total);
    let counts = [opaque, total - opaque];
    let vertices = mesh.positions.len() as u32;
    let geometries = geometries(vertices, positions.address(), indices.address());
    let build = mesh_build(&geometries[..used(counts)], mesh.deforms);
    let sizes = build_sizes(device, &build, &counts[..used(counts)])?;
    let ty = vk::AccelerationStructureTypeKHR::BOTTOM_LEVEL;
    let structure = Structure::new(device, "bottom-level structure", ty, sizes.acceleration_structure_size)?;
    let scratch = scratch(device, sizes.build_scratch_size)?;
    let build = [build.dst_acceleration_structure(structure.handle).scratch_data(aligned(device, &scratch))];
    let extension = extension(device)?;
    // SAFETY: all buffers live until the wait inside submit_once is over.
    device.submit_once(|cmd| unsafe {
        extension.cmd_build_acceleration_structures(cmd, &build, &[&ranges(counts)[..used(counts)]]);
    })?;
    let update_scratch = sizes.update_scratch_size;
    Ok(Some(MeshStructure { structure, counts, vertices, deforms: mesh.deforms, update_scratch }))
}

/// Number of geometries: the masked one is there only when it has triangles.
fn used(counts: [u32; 2]) -> usize {
    if counts[1] > 0 { 2 } else { 1 }
}

fn geometries(
    vertices: u32,
    positions: u64,
    indices: u64,
) -> [vk::AccelerationStructureGeometryKHR<'static>; 2] {
    let triangles = vk::AccelerationStructureGeometryTrianglesDataKHR::default()
        .vertex_format(vk::Format::R32G32B32_SFLOAT)
        .vertex_data(vk::DeviceOrHostAddressConstKHR { device_address: positions })
        .vertex_stride(size_of::<Vec3>() as u64)
        .max_vertex(vertices - 1)
        .index_type(vk::IndexType::UINT32)
        .index_data(vk::DeviceOrHostAddressConstKHR { device_address: indices });
    [vk::GeometryFlagsKHR::OPAQUE, vk::GeometryFlagsKHR::empty()].map(|flags| {
        vk::AccelerationStructureGeometryKHR::default()
            .geometry_type(vk::GeometryTypeKHR::TRIANGLES)
            .geometry(vk::AccelerationStructureGeometryDataKHR { triangles })
            .flags(flags)
    })
}

fn ranges(counts: [u32; 2]) -> [vk::AccelerationStructureBuildRangeInfoKHR; 2] {
    let range = |first: u32, count| {
        vk::AccelerationStructureBuildRangeInfoKHR::default()
            .primitive_count(count)
            .primitive_offset(first * size_of::<UVec3>() as u32)
    };
    [range(0, counts[0]), range(counts[0], counts[1])]
}

fn mesh_build<'a>(
    geometries: &'a [vk::AccelerationStructureGeometryKHR<'a>],
    deforms: bool,
) -> vk::AccelerationStructureBuildGeometryInfoKHR<'a> {
    let update = if deforms {
        vk::BuildAccelerationStructureFlagsKHR::ALLOW_UPDATE
    } else {
        vk::BuildAccelerationStructureFlagsKHR::empty()
    };
    vk::AccelerationStructureBuildGeometryInfoKHR::default()
        .ty(vk::AccelerationStructureTypeKHR::BOTTOM_LEVEL)
        .flags(vk::BuildAccelerationStructureFlagsKHR::PREFER_FAST_TRACE | update)
        .mode(vk::BuildAccelerationStructureModeKHR::BUILD)
        .geometries(geometries)
}

fn top_geometry(instances: &Buffer) -> vk::AccelerationStructureGeometryKHR<'static> {
    let data = vk::AccelerationStructureGeometryInstancesDataKHR::default()
        .data(vk::DeviceOrHostAddressConstKHR { device_address: instances.address() });
    vk::AccelerationStructureGeometryKHR::default()
        .geometry_type(vk::GeometryTypeKHR::INSTANCES)
        .geometry(vk::AccelerationStructureGeometryDataKHR { instances: data })
}

fn top_build<'a>(
    geometry: &'a [vk::AccelerationStructureGeometryKHR<'a>],
) -> vk::AccelerationStructureBuildGeometryInfoKHR<'a> {
    vk::AccelerationStructureBuildGeometryInfoKHR::default()
        .ty(vk::AccelerationStructureTypeKHR::TOP_LEVEL)
        .flags(vk::BuildAccelerationStructureFlagsKHR::PREFER_FAST_TRACE)
        .mode(vk::BuildAccelerationStructureModeKHR::BUILD)
        .geometries(geometry)
}

fn build_sizes(
    device: &Device,
    build: &vk::AccelerationStructureBuildGeometryInfoKHR,
    counts: &[u32],
) -> Result<vk::AccelerationStructureBuildSizesInfoKHR<'static>> {
    let mut sizes = vk::AccelerationStructureBuildSizesInfoKHR::default();
    let ty = vk::AccelerationStructureBuildTypeKHR::DEVICE;
    // SAFETY: one count a geometry.
    unsafe { extension(device)?.get_acceleration_structure_build_sizes(ty, build, counts, &mut sizes) };
    Ok(sizes)
}

fn scratch(device: &Device, size: u64) -> Result<Buffer> {
    let slack = u64::from(device.info().capabilities.scratch_alignment);
    Buffer::new(device, "acceleration structure scratch", size + slack, Location::Device)
}

/// Scratch memory of one update, so that the next one's is aligned too.
fn scratch_size(device: &Device, size: u64) -> u64 {
    size.max(1).next_multiple_of(u64::from(device.info().capabilities.scratch_alignment).max(1))
}

fn aligned(device: &Device, scratch: &Buffer) -> vk::DeviceOrHostAddressKHR {
    let alignment = u64::from(device.info().capabilities.scratch_alignment).max(1);
    vk::DeviceOrHostAddressKHR { device_address: scratch.address().next_multiple_of(alignment) }
}
