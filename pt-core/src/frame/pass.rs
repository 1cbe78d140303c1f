//! Declaration of one pass.

use super::hazards::Touch;
use super::rays::RayCount;
use super::recorder::Frame;
use super::resource::{Keep, PassInfo, Resource};
use crate::buffer::Buffer;
use crate::channels::{ChannelImages, Lacking};
use crate::error::{Error, Result};
use crate::image::Image;
use crate::kernel::{Binding, BindingKind, Kernel};
use crate::plan::StageIo;
use crate::texture::TextureTable;
use ash::vk;
use pt_shaders::GpuStruct;
use std::collections::BTreeMap;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Use {
    Read,
    Write,
    Update,
    Sample,
    Trace,
}

impl Use {
    fn verb(self) -> &'static str {
        match self {
            Self::Read => "reads",
            Self::Write => "writes",
            Self::Update => "reads and writes",
            Self::Sample => "samples",
            Self::Trace => "traces",
        }
    }
}

/// A pass being declared. Errors are kept and returned by [`Pass::dispatch`].
pub struct Pass<'f, 'r> {
    frame: &'f mut Frame<'r>,
    name: String,
    kernel: &'f Kernel,
    bound: BTreeMap<String, (Resource, Use)>,
    /// Reached through device addresses: no name, but a hazard all the same.
    addressed: Vec<(Resource, Use)>,
    /// The same, of which the pass table tells.
    streamed: Vec<(Resource, Use)>,
    textures: Option<TextureTable>,
    push: Vec<u8>,
    touches_part: bool,
    rays: Option<RayCount>,
    problem: Option<String>,
    missing: Option<MissingTable>,
}

/// What [`Pass::lacks`] refuses.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MissingTable {
    /// What reads the table.
    pub reader: String,
    /// The table.
    pub table: &'static str,
    /// What makes it.
    pub remedy: &'static str,
}

impl<'r> Frame<'r> {
    /// Declares a pass that runs `kernel`; `dispatch` ends the declaration.
    pub fn pass<'f>(&'f mut self, name: &str, kernel: &'f Kernel) -> Pass<'f, 'r> {
        Pass::new(self, name, kernel)
    }
}

impl<'f, 'r> Pass<'f, 'r> {
    pub(super) fn new(frame: &'f mut Frame<'r>, name: &str, kernel: &'f Kernel) -> Self {
        Self {
            name: frame.full_name(name),
            frame,
            kernel,
            bound: BTreeMap::new(),
            addressed: Vec::new(),
            streamed: Vec::new(),
            textures: None,
            push: Vec::new(),
            touches_part: false,
            rays: None,
            problem: None,
            missing: None,
        }
    }

    /// The kernel that it runs.
    pub fn kernel(&self) -> &Kernel {
        self.kernel
    }

    /// Refuses the pass if a table is missing that its kernel reaches through a device address: bindings are checked by name, addresses can't be,
    /// and a kernel that reads from address 0 ends the program or loses the device.
    pub fn lacks(mut self, missing: Option<MissingTable>) -> Self {
        self.missing = self.missing.or(missing);
        self
    }

    fn bind(mut self, name: &str, resource: Resource, how: Use) -> Self {
        if self.bound.insert(name.into(), (resource, how)).is_some() {
            self.problem.get_or_insert(format!("\"{name}\" is bound twice"));
        }
        self
    }

    /// The kernel only reads it.
    pub fn read<'a>(self, name: &str, resource: impl Into<Resource> + 'a) -> Self {
        self.bind(name, resource.into(), Use::Read)
    }

    /// As [`Pass::read`], for kernels that have that binding.
    pub fn read_if_used(self, name: &str, buffer: &Buffer) -> Self {
        if self.kernel.has_binding(name) { self.read(name, buffer) } else { self }
    }

    /// The kernel only writes it.
    pub fn write<'a>(self, name: &str, resource: impl Into<Resource> + 'a) -> Self {
        self.bind(name, resource.into(), Use::Write)
    }

    /// The kernel reads and writes it.
    pub fn update<'a>(self, name: &str, resource: impl Into<Resource> + 'a) -> Self {
        self.bind(name, resource.into(), Use::Update)
    }

    /// The kernel samples it (`sampler2D`) with a linear filter, clamped at the edge.
    pub fn sample(self, name: &str, image: &Image) -> Self {
        self.bind(name, image.into(), Use::Sample)
    }

    /// Binds the images of a stage's declaration that the kernel uses: `ch_NAME` or `im_NAME` for texels, `tex_NAME` to sample,
    /// each with `_prev` for the last frame's content.
    pub fn touches(mut self, images: &ChannelImages, io: &StageIo) -> Self {
        for (ids, how) in [(io.reads, Use::Read), (io.writes, Use::Write), (io.updates, Use::Update)] {
            for &id in ids {
                self = self.channel(images.get(id), &id.glsl_name(), &id.glsl_sampler(), how);
            }
        }
        for &id in io.reads_previous {
            let (image, sampler) = (id.glsl_name_prev(), id.glsl_sampler_prev());
            self = self.channel(images.get_previous(id), &image, &sampler, Use::Read);
        }
        self
    }

    fn channel(
        mut self,
        image: std::result::Result<&Image, Lacking>,
        texels: &str,
        sampler: &str,
        how: Use,
    ) -> Self {
        let name = match (self.kernel.has_binding(texels), self.kernel.has_binding(sampler)) {
            (false, false) => return self,
            (true, _) => texels,
            (false, true) => sampler,
        };
        match image {
            Ok(image) => self.bind(name, image.into(), if name == sampler { Use::Sample } else { how }),
            Err(lacking) => {
                self.problem.get_or_insert(lacking.into());
                self
            }
        }
    }

    /// A buffer that the kernel reads through its device address.
    pub fn addresses(mut self, buffer: &Buffer) -> Self {
        self.addressed.push((buffer.into(), Use::Read));
        self
    }

    /// A buffer that the kernel writes through its device address.
    pub fn addresses_written(mut self, buffer: &Buffer) -> Self {
        self.addressed.push((buffer.into(), Use::Write));
        self
    }

    /// A buffer that the kernel reads and writes through its device address.
    pub fn addresses_updated(mut self, buffer: &Buffer) -> Self {
        self.addressed.push((buffer.into(), Use::Update));
        self
    }

    /// As [`Pass::addresses`], of a buffer that the threads together read from end to end: it stands in the pass table.
    pub fn streams(mut self, buffer: &Buffer) -> Self {
        self.streamed.push((buffer.into(), Use::Read));
        self
    }

    /// As [`Pass::addresses_written`], of a buffer that the threads together write from end to end: it stands in the pass table.
    pub fn streams_written(mut self, buffer: &Buffer) -> Self {
        self.streamed.push((buffer.into(), Use::Write));
        self
    }

    /// As [`Pass::addresses_updated`], of a buffer that the threads together go through from end to end: it stands in the pass table.
    pub fn streams_updated(mut self, buffer: &Buffer) -> Self {
        self.streamed.push((buffer.into(), Use::Update));
        self
    }

    /// A driver's acceleration structure, in the buffer that holds it.
    pub(crate) fn traces(mut self, buffer: &Buffer) -> Self {
        self.addressed.push((buffer.into(), Use::Trace));
        self
    }

    /// The bindless textures.
    pub fn textures(mut self, table: &TextureTable) -> Self {
        self.textures = Some(table.clone());
        self
    }

    /// Declares that only some threads access the bound resources: [`PassInfo::bytes`] is then an upper bound.
    pub fn touches_part(mut self) -> Self {
        self.touches_part = true;
        self
    }

    /// Declares how many rays it traces, for [`super::Recorder::count_rays`].
    pub fn rays(mut self, count: RayCount) -> Self {
        self.rays = Some(count);
        self
    }

    /// Push constants; the type is the one that the kernel was made with.
    pub fn push<P: GpuStruct>(mut self, constants: &P) -> Self {
        self.push = bytemuck::bytes_of(constants).to_vec();
        self
    }

    /// Ends the declaration: checks it against the kernel's interface and records `extent` threads.
    ///
    /// # Errors
    /// A binding that the kernel has not, one that it has and the pass lacks, a resource of the wrong kind or format, or
    /// an access that the kernel's instructions contradict.
    pub fn dispatch(self, extent: [u32; 3]) -> Result<()> {
        self.launch(extent, None)
    }

    /// As [`Pass::dispatch`], for an amount of work that an earlier pass has found out: as many workgroups as the three words at
    /// `offset` bytes in `groups` say, for which `extent` must have room. A ray tracing pipeline launches all of `extent`,
    /// so the kernel itself must know where the work ends.
    ///
    /// # Errors
    /// As [`Pass::dispatch`].
    pub fn dispatch_indirect(self, extent: [u32; 3], groups: &Buffer, offset: u64) -> Result<()> {
        self.launch(extent, Some((groups, offset)))
    }

    fn launch(self, extent: [u32; 3], groups: Option<(&Buffer, u64)>) -> Result<()> {
        let fail = |problem: String| Error::Pass {
            pass: self.name.clone(),
            kernel: self.kernel.name().into(),
            problem,
        };
        if let Some(MissingTable { reader, table, remedy }) = self.missing {
            let reader = format!("{reader} of kernel {}", self.kernel.name()).into();
            return Err(Error::MissingTable { pass: self.name, reader, table, remedy });
        }
        self.check().map_err(fail)?;
        let device = self.frame.device().clone();
        let stage = self.kernel.stage();
        let mut touches = Vec::new();
        // Before the kernel's own accesses, which may be to the same buffer.
        touches.extend(groups.map(|(buffer, _)| (buffer.id(), INDIRECT_READ)));
        for (resource, how) in self.bound.values() {
            touches.push((resource.id(), touch(stage, resource, *how)));
        }
        for (resource, how) in self.addressed.iter().chain(&self.streamed) {
            touches.push((resource.id(), touch(stage, resource, *how)));
        }
        let mut fresh = Vec::new();
        for (resource, how) in self.bound.values().chain(&self.streamed) {
            let writes = matches!(how, Use::Write | Use::Update);
            // Kernels have access to what is bound, so that who writes in this memory later has to wait for them.
            let is_unread = matches!(resource, Resource::Image(image) if image.is_unread());
            if !writes && !is_unread {
                continue;
            }
            let lost = resource.note_written();
            if let (Resource::Image(image), true) = (resource, writes && !lost.is_empty()) {
                fresh.push(image.handle());
            }
            // What accesses them comes before.
            touches.extend(lost.into_iter().map(|id| (id, touch(stage, resource, Use::Write))));
        }
        let sets = self.write_descriptors(&device)?;
        if let Some(count) = &self.rays {
            self.frame.note_rays(&self.name, extent, count)?;
        }

        let listed = || self.bound.values().chain(&self.streamed);
        let names = |keep: &dyn Fn(Use) -> bool| {
            let kept = listed().filter(|(_, how)| keep(*how));
            kept.map(|(resource, _)| resource.name().to_owned()).collect::<Vec<_>>()
        };
        let moved = |how: Use| if how == Use::Update { 2 } else { 1 };
        let info = PassInfo {
            name: self.name.clone(),
            kernel: self.kernel.name().into(),
            extent,
            reads: names(&|how| how != Use::Write),
            writes: names(&|how| matches!(how, Use::Write | Use::Update)),
            bytes: listed().map(|(resource, how)| resource.bytes() * moved(*how)).sum(),
            bytes_are_upper_bound: self.touches_part || groups.is_some(),
        };
        let mut keep: Vec<_> = listed().chain(&self.addressed).map(|(r, _)| r.keep()).collect();
        keep.push(Keep::Kernel(self.kernel.clone()));
        keep.extend(groups.map(|(buffer, _)| Keep::Buffer(buffer.clone())));
        keep.extend(self.textures.clone().map(Keep::Textures));
        let (kernel, push) = (self.kernel, &self.push);
        self.frame.encode_fresh(info, &touches, &fresh, keep, |_, cmd| {
            // SAFETY: recording; the sets were made from the kernel's layouts; the slot keeps the kernel.
            unsafe {
                kernel.encode(cmd, &sets, push, extent, groups.map(|(b, offset)| (b.handle(), offset)))
            };
        })
    }

    fn check(&self) -> std::result::Result<(), String> {
        if let Some(problem) = &self.problem {
            return Err(problem.clone());
        }
        let reflection = self.kernel.reflection();
        if self.push.len() != reflection.push_size as usize {
            return Err(format!(
                "{} bytes of push constants given, the kernel has {}",
                self.push.len(),
                reflection.push_size
            ));
        }
        if reflection.textures && self.textures.is_none() {
            return Err("the kernel uses textures[], the pass binds no texture table".into());
        }
        for binding in reflection.bindings.values() {
            let (resource, how) = self
                .bound
                .get(&binding.name)
                .ok_or_else(|| format!("the kernel's binding \"{}\" is not bound", binding.name))?;
            check_binding(binding, resource, *how)?;
        }
        match self.bound.keys().find(|name| !reflection.bindings.values().any(|b| b.name == **name)) {
            Some(name) => {
                let known: Vec<_> = reflection.bindings.values().map(|b| b.name.as_str()).collect();
                Err(format!("the kernel has no binding \"{name}\"; it has {}", known.join(", ")))
            }
            None => self.check_memory(),
        }
    }

    /// What shares memory does so by what the stages declare; here it shows where a declaration lacks something.
    fn check_memory(&self) -> std::result::Result<(), String> {
        let all = || self.bound.values().chain(&self.streamed);
        if let Some((lost, _)) = all().find(|(resource, how)| *how != Use::Write && resource.is_overwritten())
        {
            return Err(format!(
                "it reads \"{}\", whose memory something else has taken: no stage declares that it is read so late",
                lost.name()
            ));
        }
        let is_image = |resource: &Resource| matches!(resource, Resource::Image(_));
        for (resource, _) in all().filter(|(_, how)| matches!(how, Use::Write | Use::Update)) {
            let others = all()
                .filter(|(other, _)| is_image(resource) || is_image(other) || other.id() != resource.id());
            let same_memory = others.filter(|(other, _)| other.shares_memory_with(resource)).count();
            if same_memory > usize::from(is_image(resource)) {
                return Err(format!(
                    "it writes \"{}\" and accesses that memory by another name, too",
                    resource.name()
                ));
            }
        }
        Ok(())
    }

    fn write_descriptors(&self, device: &crate::device::Device) -> Result<Vec<(u32, vk::DescriptorSet)>> {
        let reflection = self.kernel.reflection();
        let layouts = self.kernel.layout().sets;
        let mut used: Vec<u32> = reflection.bindings.keys().map(|(set, _)| *set).collect();
        used.dedup();
        let wanted: Vec<_> = used.iter().map(|&set| layouts[set as usize]).collect();
        let handles = if wanted.is_empty() { Vec::new() } else { self.frame.descriptor_sets(&wanted)? };
        let mut sets: Vec<_> = used.into_iter().zip(handles).collect();

        for binding in reflection.bindings.values() {
            let (resource, _) = &self.bound[&binding.name];
            let set =
                sets.iter().find(|(index, _)| *index == binding.set).map(|(_, set)| *set).unwrap_or_default();
            let write = vk::WriteDescriptorSet::default()
                .dst_set(set)
                .dst_binding(binding.binding)
                .descriptor_type(binding.kind.descriptor_type());
            match resource {
                Resource::Image(image) => {
                    let info = [vk::DescriptorImageInfo {
                        sampler: match binding.kind {
                            BindingKind::Sampled => device.inner().linear_sampler,
                            _ => vk::Sampler::null(),
                        },
                        image_view: image.view(),
                        image_layout: vk::ImageLayout::GENERAL,
                    }];
                    // SAFETY: the set belongs to this frame and is not in use yet.
                    unsafe { device.raw().update_descriptor_sets(&[write.image_info(&info)], &[]) };
                }
                Resource::Buffer(buffer) => {
                    let info = [vk::DescriptorBufferInfo {
                        buffer: buffer.handle(),
                        offset: 0,
                        range: vk::WHOLE_SIZE,
                    }];
                    // SAFETY: as above.
                    unsafe { device.raw().update_descriptor_sets(&[write.buffer_info(&info)], &[]) };
                }
            }
        }
        if reflection.textures {
            sets.extend(self.textures.as_ref().map(|table| (crate::sampler::TEXTURE_SET, table.set())));
        }
        Ok(sets)
    }
}

fn check_binding(binding: &Binding, resource: &Resource, how: Use) -> std::result::Result<(), String> {
    let name = &binding.name;
    match (binding.kind, resource) {
        (BindingKind::Uniform | BindingKind::Storage, Resource::Buffer(_)) => {}
        (BindingKind::Sampled, Resource::Image(_)) if how == Use::Sample => return Ok(()),
        (BindingKind::Image(format), Resource::Image(image)) => {
            if spirv_format(image.format()) != format {
                return Err(format!(
                    "\"{name}\" is declared {format:?} in the kernel, the image is {:?}",
                    image.format()
                ));
            }
        }
        (kind, Resource::Image(_)) => {
            return Err(format!("\"{name}\" is {kind:?} in the kernel, an image is bound"));
        }
        (kind, Resource::Buffer(_)) => {
            return Err(format!("\"{name}\" is {kind:?} in the kernel, a buffer is bound"));
        }
    }
    let access = binding.access;
    if access.unknown {
        return Ok(());
    }
    let actual = match (access.read, access.write) {
        (true, false) => Use::Read,
        (false, true) => Use::Write,
        (true, true) => Use::Update,
        (false, false) => return Ok(()),
    };
    if actual == how {
        return Ok(());
    }
    Err(format!("the pass declares that it {} \"{name}\", the kernel {} it", how.verb(), actual.verb()))
}

fn spirv_format(format: pt_shaders::channels::Format) -> spirq::ty::ImageFormat {
    use pt_shaders::channels::Format as F;
    use spirq::ty::ImageFormat as I;
    match format {
        F::R32F => I::R32f,
        F::Rg32F => I::Rg32f,
        F::Rgba32F => I::Rgba32f,
        F::Rgba16F | F::Half(_) => I::Rgba16f,
        F::Rg16Unorm => I::Rg16,
        F::Rgba16Unorm => I::Rgba16,
        F::Rg8Unorm => I::Rg8,
        F::Rgba8Unorm | F::Rgba8Root => I::Rgba8,
        F::R32Uint => I::R32ui,
        F::Rg32Uint => I::Rg32ui,
        F::Rgba32Uint => I::Rgba32ui,
        F::R16Uint => I::R16ui,
    }
}

const INDIRECT_READ: Touch = Touch {
    stage: vk::PipelineStageFlags2::DRAW_INDIRECT,
    access: vk::AccessFlags2::INDIRECT_COMMAND_READ,
    write: false,
};

fn touch(stage: vk::PipelineStageFlags2, resource: &Resource, how: Use) -> Touch {
    use vk::AccessFlags2 as A;
    let read = match (resource, how) {
        (_, Use::Sample) => A::SHADER_SAMPLED_READ,
        (_, Use::Trace) => A::ACCELERATION_STRUCTURE_READ_KHR,
        (Resource::Buffer(_), Use::Read) => A::SHADER_STORAGE_READ | A::UNIFORM_READ,
        _ => A::SHADER_STORAGE_READ,
    };
    let access = match how {
        Use::Read | Use::Sample | Use::Trace => read,
        Use::Write => A::SHADER_STORAGE_WRITE,
        Use::Update => A::SHADER_STORAGE_READ | A::SHADER_STORAGE_WRITE,
    };
    Touch { stage, access, write: matches!(how, Use::Write | Use::Update) }
}
