use crate::params::DirectParams;
use crate::records::{DirectPush, LightRays, NeeAtPush};
use pt_core::channels::field_width;
use pt_core::frame::Pass;
use pt_core::split::split_size;
use pt_core::{Buffer, Device, Frame, Kernel, Location, Result, StageInputs, StageIo};
use pt_shaders::channels::MOTION;
use pt_shaders::records::{LightSampler, NEE_AT_PROXIES, NEE_AT_SIDE, NeeAtTile};
use std::cell::RefCell;

/// Bytes of a texel's feedback: a light and its weight.
const FEEDBACK_BYTES: u64 = 8;

/// What tiles of the screen learn about the lights from frame to frame (`lights/nee_at.glsl`), for `sampler=nee-at`.
pub struct NeeAt {
    device: Device,
    kernel: Kernel,
    /// Made in the first frame, which says how large frames are.
    tables: RefCell<Option<Tables>>,
}

/// Tables for frames of one size.
struct Tables {
    frame: [u32; 2],
    /// Tiles of this frame, and of the last one.
    tiles: [Buffer; 2],
    feedback: Buffer,
}

/// Tiles in a row and in a column of the split frame; each checkerboard field has its own.
fn tile_counts(frame: [u32; 2]) -> [u32; 2] {
    [2 * field_width(frame[0]).div_ceil(NEE_AT_SIDE), frame[1].div_ceil(NEE_AT_SIDE)]
}

impl Tables {
    fn new(device: &Device, frame: [u32; 2]) -> Result<Self> {
        let [columns, rows] = tile_counts(frame).map(u64::from);
        let [width, height] = split_size(frame).map(u64::from);
        let buffer = |name, bytes| Buffer::new(device, name, bytes, Location::Device);
        let tiles = || buffer("light proxies", columns * rows * size_of::<NeeAtTile>() as u64);
        Ok(Self {
            frame,
            tiles: [tiles()?, tiles()?],
            feedback: buffer("light feedback", width * height * FEEDBACK_BYTES)?,
        })
    }
}

impl DirectParams {
    fn nee_at_push(&self, tables: &Tables, reset: bool) -> NeeAtPush {
        let share = |share: f32, of: u32| (share * of as f32).round() as u32;
        let global_proxies = share(self.nee_at_global_share, NEE_AT_PROXIES);
        NeeAtPush {
            tiles: tables.tiles[0].address(),
            tiles_before: tables.tiles[1].address(),
            feedback: tables.feedback.address(),
            narrow: self.nee_at_narrow,
            uniform_share: self.nee_at_uniform,
            history: self.nee_at_history,
            global_proxies,
            kept_proxies: share(self.nee_at_history, NEE_AT_PROXIES - global_proxies),
            reset: reset.into(),
        }
    }
}

impl NeeAt {
    /// The image that it reads besides those of direct lighting.
    pub const IO: StageIo = StageIo { reads: &[MOTION], ..StageIo::of("light proxies") };

    /// Whether these knobs ask for it.
    pub fn is_used(params: &DirectParams) -> bool {
        params.rays == LightRays::Merged && params.sampler == LightSampler::NeeAt
    }

    /// Compiles the kernel.
    ///
    /// # Errors
    /// When the device refuses.
    pub fn new(device: &Device) -> Result<Self> {
        let kernel = Kernel::compute::<NeeAtPush>(device, &crate::kernels::NEE_AT_PROXIES, &[])?;
        Self::IO.check([&kernel])?;
        Ok(Self { device: device.clone(), kernel, tables: RefCell::new(None) })
    }

    /// Makes this frame's proxies of all tiles from the feedback of the last frame. In the first frame of a size it takes device memory: 8
    /// bytes a texel of the split frame and about 1 KB a tile.
    pub(crate) fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &StageInputs<'_>,
        params: &DirectParams,
    ) -> Result<()> {
        let size = inputs.images.size();
        let mut slot = self.tables.borrow_mut();
        let before = slot.take().filter(|tables| tables.frame == size);
        let reset = before.is_none() || !inputs.images.has_history();
        let tables = slot.insert(before.map_or_else(|| Tables::new(&self.device, size), Ok)?);
        tables.tiles.swap(0, 1);
        let [columns, rows] = tile_counts(size);
        let pass = inputs.pass(frame, "light proxies", &self.kernel, &Self::IO);
        pass.addresses_written(&tables.tiles[0])
            .addresses(&tables.tiles[1])
            .addresses(&tables.feedback)
            .push(&params.nee_at_push(tables, reset))
            .dispatch([columns * NEE_AT_PROXIES, rows, 1])
    }

    /// Tells the kernels of direct lighting where the tables are.
    pub(crate) fn fill(&self, push: &mut DirectPush) {
        if let Some(tables) = &*self.tables.borrow() {
            push.nee_at_tiles = tables.tiles[0].address();
            push.nee_at_feedback = tables.feedback.address();
        }
    }

    /// Declares that a pass draws from the tiles.
    pub(crate) fn bind_tiles<'f, 'r>(&self, pass: Pass<'f, 'r>) -> Pass<'f, 'r> {
        self.tables.borrow().iter().fold(pass, |pass, tables| pass.addresses(&tables.tiles[0]))
    }

    /// Declares that a pass keeps feedback.
    pub(crate) fn bind_feedback<'f, 'r>(&self, pass: Pass<'f, 'r>) -> Pass<'f, 'r> {
        self.tables.borrow().iter().fold(pass, |pass, tables| pass.addresses_updated(&tables.feedback))
    }

    /// The table of tiles that the frame recorded last drew from; `None` before the first frame. For tests and tools.
    pub fn tiles(&self) -> Option<Buffer> {
        self.tables.borrow().as_ref().map(|tables| tables.tiles[0].clone())
    }
}
