//! What the window asks of the renderer, and what the renderer says: plain data.

use pt_core::Image;

/// Where the camera is and what it looks at; +Y is up in the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Position, metres.
    pub eye: [f32; 3],
    /// The point that it looks at, metres.
    pub target: [f32; 3],
    /// Vertical field of view, degrees.
    pub vfov: f32,
}

/// A request of the window.
#[derive(Clone, Debug, PartialEq)]
pub enum Request {
    /// The camera moves.
    Camera(Pose),
    /// A camera of the scene, by its place in the list.
    SceneCamera(usize),
    /// Values of knobs, those that differ from what the renderer has: key and text.
    Knobs(Vec<(String, String)>),
    /// Scene time runs, or stands still.
    Play(bool),
    /// One frame further in scene time, then stand still.
    Step,
    /// The scene at this time, seconds.
    Seek(f64),
    /// Forget all histories.
    ResetHistories,
    /// Show this image in false colour; `None`: the picture.
    Look(Option<String>),
    /// The pixel of the picture whose values are wanted.
    Pixel(Option<[u32; 2]>),
    /// How the ground truth is shown.
    Truth(TruthView),
    /// Make the command line that reproduces the picture.
    HandOut,
    /// Write the picture as PNG and EXR.
    Save,
    /// Begin to record the way of the camera, or end and write it.
    Record(bool),
    /// Begin to capture the next frames, or end it early.
    Capture(bool),
}

/// How the ground truth is shown beside the frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TruthView {
    /// It is not traced.
    #[default]
    Off,
    /// In the right part of the picture.
    Split,
    /// In place of the frame.
    Alone,
    /// In place of the frame while a key is held.
    Flip,
    /// The difference of frame and truth in false colour.
    Difference,
}

impl TruthView {
    /// All of them, in the order of the key that goes through them.
    pub const ALL: [Self; 5] = [Self::Off, Self::Split, Self::Alone, Self::Flip, Self::Difference];

    /// For the panel.
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Split => "split",
            Self::Alone => "truth alone",
            Self::Flip => "flip",
            Self::Difference => "difference",
        }
    }
}

/// Time of a pass.
#[derive(Clone, Debug, PartialEq)]
pub struct PassTime {
    /// Its name.
    pub name: String,
    /// GPU time in milliseconds.
    pub ms: f64,
    /// Rays that it traced; 0 without any.
    pub rays: u64,
    /// Bytes that it moves when it touches every texel of its images once.
    pub bytes: u64,
}

/// What false colours mean.
#[derive(Clone, Debug, PartialEq)]
pub struct Legend {
    /// The image.
    pub name: String,
    /// What a value is, with its unit.
    pub meaning: String,
    /// Values at the ends of the scale.
    pub range: [f32; 2],
    /// Whether components are shown as red, green and blue instead of on the scale.
    pub is_color: bool,
}

/// How far the ground truth is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TruthState {
    /// Samples a pixel.
    pub samples: u32,
    /// Relative standard error of its mean; `None` after one sample.
    pub relative_error: Option<f64>,
    /// Mean FLIP of the frame as shown against the truth as shown.
    pub flip: Option<f64>,
    /// Relative mean squared error of the frame's radiance.
    pub rel_mse: Option<f64>,
}

/// What there is to show, after each frame.
#[derive(Clone, Default)]
pub struct Status {
    /// The picture; `None` before the first frame.
    pub picture: Option<Image>,
    /// The ground truth as it would be shown.
    pub truth: Option<Image>,
    /// No frame was rendered: the picture that was handed out stays.
    pub is_resting: bool,
    /// Frames since the histories were reset.
    pub frames: u32,
    /// Scene time, seconds.
    pub time: f64,
    /// Whether scene time runs.
    pub playing: bool,
    /// Whether the way of the camera is recorded.
    pub recording: bool,
    /// Frames that are captured already, and that will be; `None` while none are.
    pub capture: Option<[u32; 2]>,
    /// Where the renderer has put the camera, with a number that changes when it did so by itself.
    pub pose: Option<(u64, Pose)>,
    /// Times of the last frame that is finished, pass by pass.
    pub passes: Vec<PassTime>,
    /// GPU time of that frame, milliseconds.
    pub frame_ms: f64,
    /// Values of the pixel that was asked for: name of the image, and its components.
    pub pixel: Vec<(String, String)>,
    /// Of the image that is looked at.
    pub legend: Option<Legend>,
    /// Images that can be looked at.
    pub images: Vec<String>,
    /// State of the ground truth.
    pub truth_state: TruthState,
    /// What went wrong with the last request, or what it did.
    pub message: String,
    /// The last command line that was made, with its number.
    pub command: Option<(u64, String)>,
}

/// Makes frames; lives on a thread of its own.
pub trait Frames {
    /// Follows the requests, in their order, and makes a frame. What a request asks for that can't be is said in [`Status::message`].
    ///
    /// # Errors
    /// When the device fails.
    fn next(&mut self, requests: Vec<Request>) -> Result<Status, Failure>;
}

/// An error of the renderer.
pub type Failure = Box<dyn std::error::Error + Send + Sync>;
