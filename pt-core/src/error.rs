//! Errors of device, kernels, frames and scenes.

use ash::vk;

/// Errors of the GPU side of pt-core. Each message names the thing and, where there is one, the way out.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// libvulkan could not be loaded.
    #[error(
        "no Vulkan loader (libvulkan.so.1): {0}; run scripts/setup-vulkan.sh, or install your GPU's driver or Mesa's lavapipe"
    )]
    NoLoader(String),
    /// The loader found no driver at all.
    #[error(
        "no Vulkan driver found; run scripts/setup-vulkan.sh, or install your GPU's driver or Mesa's lavapipe"
    )]
    NoDriver,
    /// No device fulfils the requirements of the frame.
    #[error("no usable Vulkan device: {0}; run scripts/setup-vulkan.sh to install Mesa's lavapipe")]
    NoDevice(String),
    /// `--device` matched nothing usable.
    #[error("no usable device matches \"{wanted}\"; devices: {available}")]
    UnknownDevice {
        /// What was asked for.
        wanted: String,
        /// What there is.
        available: String,
    },
    /// The stages of a frame do not fit together.
    #[error("stage \"{stage}\" reads \"{channel}\", {lacking}")]
    NoWriter {
        /// The stage that reads.
        stage: String,
        /// What it reads.
        channel: String,
        /// Who does not write it.
        lacking: &'static str,
    },
    /// A stage declares an image that none of its kernels touches so.
    #[error("stage \"{stage}\" declares \"{channel}\", which none of its kernels touches")]
    Unused {
        /// The stage.
        stage: String,
        /// The image.
        channel: String,
    },
    /// A structural knob differs from the value that the stage was created with.
    #[error("{key} is structural and changed between frames: create the frame (or the stage) anew")]
    StructuralKnob {
        /// Dotted name of the knob.
        key: String,
    },
    /// More punctual lights than the tables have room for.
    #[error("{lights} punctual lights, but the light tables have room for {room}: make them with more room")]
    TooManyLights {
        /// How many places the lights take.
        lights: usize,
        /// How many there are.
        room: usize,
    },
    /// A validation run was asked for without the layers.
    #[error(
        "validation asked for, but VK_LAYER_KHRONOS_validation is not installed; run scripts/setup-vulkan.sh --tests"
    )]
    NoValidationLayer,
    /// A Vulkan call failed.
    #[error("{call}: {result}")]
    Vulkan {
        /// What was attempted.
        call: &'static str,
        /// The driver's answer.
        result: vk::Result,
    },
    /// Device memory could not be had.
    #[error(
        "{name}: the device did not give {} of memory ({reason}); ask for a smaller image or scene, or another device",
        gib(*bytes)
    )]
    Allocation {
        /// Resource.
        name: String,
        /// Size asked for.
        bytes: u64,
        /// The allocator's answer.
        reason: String,
    },
    /// Images of a size that takes more memory than is free.
    #[error(
        "{what} of {}x{} needs {}, {place} has {} of free memory; {}x{} fits", size[0], size[1], gib(*bytes), gib(*free), fits[0], fits[1]
    )]
    TooLarge {
        /// What was asked for.
        what: &'static str,
        /// Its size in pixels.
        size: [u32; 2],
        /// The memory that it takes.
        bytes: u64,
        /// Whose memory it is.
        place: &'static str,
        /// How much of that is free.
        free: u64,
        /// The largest size of the same shape that fits.
        fits: [u32; 2],
    },
    /// A kernel's SPIR-V does not agree with the host side.
    #[error("kernel {kernel}: {problem}")]
    Kernel {
        /// Kernel name.
        kernel: String,
        /// What disagrees.
        problem: String,
    },
    /// A specialisation constant does not fit its kernel.
    #[error(transparent)]
    Constant(#[from] ConstantError),
    /// A pass is declared wrongly.
    #[error("pass \"{pass}\" (kernel {kernel}): {problem}")]
    Pass {
        /// Pass name.
        pass: String,
        /// Kernel name.
        kernel: String,
        /// What is wrong.
        problem: String,
    },
    /// A kernel reads a table that the scene on the device does not have.
    #[error("pass \"{pass}\": {reader} needs {table}, which the scene on the device does not have; {remedy}")]
    MissingTable {
        /// Pass name.
        pass: String,
        /// What reads the table, and the name of its kernel.
        reader: Box<str>,
        /// The table.
        table: &'static str,
        /// What makes it.
        remedy: &'static str,
    },
    /// No images can be shown in a window.
    #[error("no window can be shown: {0}; pt render writes pictures without one")]
    NoPresentation(String),
    /// The GPU did not finish in time.
    #[error("the device did not finish within {0} s: a kernel hangs, or the work is too large for it")]
    Timeout(u64),
    /// An acceleration structure can't be built.
    #[error(transparent)]
    Trace(#[from] TraceError),
    /// A feature that this device lacks was asked for.
    #[error("{0}")]
    Unsupported(String),
}

/// Result with [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

/// Names the failed call.
pub(crate) trait VkContext<T> {
    fn context(self, call: &'static str) -> Result<T>;
}

impl<T> VkContext<T> for std::result::Result<T, vk::Result> {
    fn context(self, call: &'static str) -> Result<T> {
        self.map_err(|result| Error::Vulkan { call, result })
    }
}

/// Why a specialisation constant does not fit its kernel.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ConstantError {
    /// There is none of that name.
    #[error("kernel {kernel} has no specialisation constant \"{constant}\"; it has: {declared}")]
    Unknown {
        /// Kernel name.
        kernel: String,
        /// Name that was given.
        constant: String,
        /// Names that there are.
        declared: String,
    },
    /// It has another type.
    #[error(
        "kernel {kernel}: specialisation constant \"{constant}\" has type {declared}, the given value has type {given}"
    )]
    Type {
        /// Kernel name.
        kernel: String,
        /// Name of the constant.
        constant: String,
        /// Type in GLSL.
        declared: &'static str,
        /// Type of the value.
        given: &'static str,
    },
    /// It got two values.
    #[error("kernel {kernel}: specialisation constant \"{constant}\" is given twice")]
    Repeated {
        /// Kernel name.
        kernel: String,
        /// Name of the constant.
        constant: String,
    },
}

/// Why an acceleration structure could not be built.
#[derive(Debug, thiserror::Error)]
pub enum TraceError {
    /// An index points past the vertices.
    #[error("triangle {triangle}: vertex {vertex} does not exist, the mesh has {vertices}")]
    VertexIndex {
        /// Triangle of the mesh.
        triangle: usize,
        /// Its vertex index.
        vertex: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// A tree is deeper than the traversal's stack.
    #[error(
        "a BVH has {depth} levels, the traversal takes {limit}: far too many triangles or instances coincide"
    )]
    BvhDepth {
        /// Levels of the tree.
        depth: u32,
        /// Levels that the stack allows.
        limit: u32,
    },
    /// An instance names a mesh that is not there.
    #[error("instance {instance}: mesh {mesh} does not exist, there are {meshes}")]
    UnknownMesh {
        /// Instance index.
        instance: usize,
        /// Mesh index.
        mesh: u32,
        /// Number of meshes.
        meshes: usize,
    },
    /// More instances than the 24 bits of an instance index can name.
    #[error("{0} instances: at most 16777215 can be traced")]
    TooManyInstances(usize),
    /// More instances than memory was taken for.
    #[error("{instances} instances: the acceleration structure was made for {capacity}")]
    Capacity {
        /// Instances given.
        instances: usize,
        /// Instances announced.
        capacity: usize,
    },
}

/// Bytes for messages.
pub fn gib(bytes: u64) -> String {
    let gib = bytes as f64 / (1u64 << 30) as f64;
    if gib < 1.0 { format!("{:.0} MiB", 1024.0 * gib) } else { format!("{gib:.1} GiB") }
}
