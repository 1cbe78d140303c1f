//! Buffers with device addresses.

use crate::block::Part;
use crate::device::Device;
use crate::error::{Result, VkContext};
use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};
use std::sync::{Arc, Mutex};

/// Where a buffer's memory is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Location {
    /// Device-local, filled by copies.
    Device,
    /// Host-visible, written by the host and read by the device.
    Upload,
    /// Host-visible and host-cached, written by the device and read by the host.
    Readback,
}

/// A buffer; clones share it. Usable as storage, uniform, indirect and transfer buffer, with a device address.
#[derive(Clone)]
pub struct Buffer(Arc<Inner>);

struct Inner {
    device: Device,
    id: u64,
    name: String,
    handle: vk::Buffer,
    address: u64,
    size: u64,
    // Taken only on drop; the lock serves host writes through a shared handle.
    allocation: Mutex<Option<Allocation>>,
    /// Its memory, if that is not its own.
    part: Option<Part>,
}

impl Buffer {
    /// A buffer of `size` bytes (at least 1) with undefined content.
    pub fn new(device: &Device, name: &str, size: u64, location: Location) -> Result<Self> {
        Self::with_usage(device, name, size, location, vk::BufferUsageFlags::empty())
    }

    /// As [`Buffer::new`] with more usages (acceleration structures, shader binding tables).
    pub(crate) fn with_usage(
        device: &Device,
        name: &str,
        size: u64,
        location: Location,
        usage: vk::BufferUsageFlags,
    ) -> Result<Self> {
        let size = size.max(1);
        let raw = device.raw();
        let (handle, requirements) = create(device, size, usage | default_usage(device))?;
        let allocation = device.allocate(&AllocationCreateDesc {
            name,
            requirements,
            location: match location {
                Location::Device => MemoryLocation::GpuOnly,
                Location::Upload => MemoryLocation::CpuToGpu,
                Location::Readback => MemoryLocation::GpuToCpu,
            },
            linear: true,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        });
        let allocation = match allocation {
            Ok(allocation) => allocation,
            Err(error) => {
                // SAFETY: never bound or used.
                unsafe { raw.destroy_buffer(handle, None) };
                return Err(error);
            }
        };
        // SAFETY: memory and offset come from the allocator for exactly these requirements.
        let address = unsafe {
            raw.bind_buffer_memory(handle, allocation.memory(), allocation.offset())
                .context("vkBindBufferMemory")?;
            raw.get_buffer_device_address(&vk::BufferDeviceAddressInfo::default().buffer(handle))
        };
        device.name(handle, name);
        Ok(Self(Arc::new(Inner {
            device: device.clone(),
            id: device.next_id(),
            name: name.to_owned(),
            handle,
            address,
            size,
            allocation: Mutex::new(Some(allocation)),
            part: None,
        })))
    }

    /// Memory that a buffer of `size` bytes needs.
    pub(crate) fn requirements(device: &Device, size: u64) -> vk::MemoryRequirements {
        let info = vk::BufferCreateInfo::default().size(size).usage(default_usage(device));
        let info = vk::DeviceBufferMemoryRequirements::default().create_info(&info);
        let mut requirements = vk::MemoryRequirements2::default();
        // SAFETY: valid create info.
        unsafe { device.raw().get_device_buffer_memory_requirements(&info, &mut requirements) };
        requirements.memory_requirements
    }

    /// A buffer of `size` bytes in memory that others use too, of what [`Buffer::requirements`] says.
    pub(crate) fn placed(part: Part, device: &Device, name: &str, size: u64) -> Result<Self> {
        let raw = device.raw();
        let (handle, _) = create(device, size, default_usage(device))?;
        let (memory, offset) = part.memory();
        // SAFETY: the part is as large as asked for, in memory of a type that serves such buffers.
        let address = unsafe {
            raw.bind_buffer_memory(handle, memory, offset).context("vkBindBufferMemory")?;
            raw.get_buffer_device_address(&vk::BufferDeviceAddressInfo::default().buffer(handle))
        };
        device.name(handle, name);
        Ok(Self(Arc::new(Inner {
            device: device.clone(),
            id: device.next_id(),
            name: name.to_owned(),
            handle,
            address,
            size,
            allocation: Mutex::new(None),
            part: Some(part),
        })))
    }

    /// Its memory, if others use that too.
    pub(crate) fn part(&self) -> Option<&Part> {
        self.0.part.as_ref()
    }

    /// A pass writes it: returns the numbers of the resources in this memory whose content is lost.
    pub(crate) fn note_written(&self) -> Vec<u64> {
        self.part().map_or_else(Vec::new, |part| part.note_written(self.0.id))
    }

    /// Whether another resource in this memory was written after it.
    pub(crate) fn is_overwritten(&self) -> bool {
        self.part().is_some_and(|part| part.is_overwritten(self.0.id))
    }

    /// A device-local buffer with the given content. An empty slice gives a one-byte buffer, so that its address is valid.
    pub fn from_slice<T: bytemuck::NoUninit>(device: &Device, name: &str, data: &[T]) -> Result<Self> {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let buffer = Self::new(device, name, bytes.len() as u64, Location::Device)?;
        buffer.write_through_staging(bytes)?;
        Ok(buffer)
    }

    /// Fills the start of a device-local buffer and waits: for set-up, never inside a frame.
    pub fn write_through_staging(&self, bytes: &[u8]) -> Result<()> {
        if bytes.is_empty() {
            return Ok(());
        }
        let device = &self.0.device;
        let staging = Self::new(device, "staging", bytes.len() as u64, Location::Upload)?;
        staging.write(0, bytes);
        let region = [vk::BufferCopy::default().size(bytes.len() as u64)];
        // SAFETY: both buffers are alive until the wait inside submit_once is over.
        device.submit_once(|cmd| unsafe {
            device.raw().cmd_copy_buffer(cmd, staging.handle(), self.handle(), &region);
        })
    }

    /// Writes to a host-visible buffer.
    ///
    /// # Panics
    /// When the buffer is not host-visible or the range lies outside it: a mistake of the caller, not of its input.
    pub fn write(&self, offset: usize, bytes: &[u8]) {
        let mut allocation = crate::lock::lock(&self.0.allocation);
        let mapped =
            allocation.as_mut().and_then(Allocation::mapped_slice_mut).expect("a host-visible buffer");
        mapped[offset..offset + bytes.len()].copy_from_slice(bytes);
    }

    /// Copies the whole buffer to the host, after everything submitted so far.
    pub fn read<T: bytemuck::AnyBitPattern>(&self) -> Result<Vec<T>> {
        let device = &self.0.device;
        let staging = Self::new(device, "read-back", self.0.size, Location::Readback)?;
        let region = [vk::BufferCopy::default().size(self.0.size)];
        // SAFETY: both buffers are alive until the wait inside submit_once is over.
        device.submit_once(|cmd| unsafe {
            device.raw().cmd_copy_buffer(cmd, self.handle(), staging.handle(), &region);
        })?;
        Ok(staging.mapped())
    }

    /// Whole elements of a host-visible buffer, as the device has written them by now.
    ///
    /// # Panics
    /// When the buffer is not host-visible: a mistake of the caller, not of its input.
    pub fn mapped<T: bytemuck::AnyBitPattern>(&self) -> Vec<T> {
        let allocation = crate::lock::lock(&self.0.allocation);
        let mapped = allocation.as_ref().and_then(Allocation::mapped_slice).expect("a host-visible buffer");
        mapped[..self.0.size as usize]
            .chunks_exact(size_of::<T>())
            .map(bytemuck::pod_read_unaligned)
            .collect()
    }

    /// Size in bytes.
    pub fn size(&self) -> u64 {
        self.0.size
    }

    /// Device address of the first byte.
    pub fn address(&self) -> u64 {
        self.0.address
    }

    /// Debug name.
    pub fn name(&self) -> &str {
        &self.0.name
    }

    pub(crate) fn handle(&self) -> vk::Buffer {
        self.0.handle
    }

    /// Its number, for barriers.
    pub(crate) fn id(&self) -> u64 {
        self.0.id
    }
}

/// What every buffer may be used for.
fn default_usage(device: &Device) -> vk::BufferUsageFlags {
    let mut usage = vk::BufferUsageFlags::STORAGE_BUFFER
        | vk::BufferUsageFlags::UNIFORM_BUFFER
        | vk::BufferUsageFlags::INDIRECT_BUFFER
        | vk::BufferUsageFlags::TRANSFER_SRC
        | vk::BufferUsageFlags::TRANSFER_DST
        | vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS;
    if device.inner().acceleration_structure.is_some() {
        usage |= vk::BufferUsageFlags::ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_KHR;
    }
    usage
}

fn create(
    device: &Device,
    size: u64,
    usage: vk::BufferUsageFlags,
) -> Result<(vk::Buffer, vk::MemoryRequirements)> {
    let info = vk::BufferCreateInfo::default().size(size).usage(usage);
    // SAFETY: valid device and create info.
    unsafe {
        let handle = device.raw().create_buffer(&info, None).context("vkCreateBuffer")?;
        Ok((handle, device.raw().get_buffer_memory_requirements(handle)))
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        // SAFETY: the frame recorder keeps clones of what is in flight, so the device no longer uses the buffer.
        unsafe { self.device.raw().destroy_buffer(self.handle, None) };
        if let Some(allocation) = crate::lock::lock(&self.allocation).take() {
            self.device.free(allocation);
        }
    }
}
