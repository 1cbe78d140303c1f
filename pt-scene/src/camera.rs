use glam::{Affine3A, Mat3A, Vec3, Vec3A};

use crate::animation::NodeMotion;

/// How a camera maps directions or positions to the image. The width follows the aspect of the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Central projection.
    Perspective {
        /// Full vertical field of view, radians.
        yfov: f32,
    },
    /// Parallel projection.
    Orthographic {
        /// Half the height of the view, metres.
        ymag: f32,
    },
}

/// A camera with an optional thin lens and an optional path.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name by which it is chosen.
    pub name: String,
    /// Index in the list of cameras of the file; `None` for a camera made by code. Several nodes may carry one camera.
    pub index: Option<usize>,
    /// Projection.
    pub projection: Projection,
    /// Rigid transform: the camera looks along its -Z, +Y is up in the image.
    pub world_from_camera: Affine3A,
    /// Radius of the thin lens, metres; 0: a pinhole.
    pub lens_radius: f32,
    /// Distance along -Z of the plane in focus, metres, > 0; matters only with a lens.
    pub focus_distance: f32,
    /// The way the camera goes; [`Camera::at`] evaluates it.
    pub path: Option<CameraPath>,
    /// The node of a file that carries it, if it moves; [`Camera::at`] evaluates it.
    pub motion: Option<NodeMotion>,
}

impl Camera {
    /// A pinhole at `eye` that looks at `target` with +Y up in the image; `yfov` in radians.
    pub fn look_at(name: &str, eye: Vec3, target: Vec3, yfov: f32) -> Self {
        Self {
            name: name.into(),
            index: None,
            projection: Projection::Perspective { yfov },
            world_from_camera: looking(eye, target),
            lens_radius: 0.0,
            focus_distance: eye.distance(target).max(1e-3),
            path: None,
            motion: None,
        }
    }

    /// A camera that follows `path`, standing at its start.
    pub fn on_path(name: &str, path: CameraPath, yfov: f32) -> Self {
        let CameraKey { position: eye, target, .. } = path.keys[0];
        Self { path: Some(path), ..Self::look_at(name, eye, target, yfov) }
    }

    /// The camera at `time` seconds; itself when it has neither path nor motion.
    pub fn at(&self, time: f64) -> Self {
        let mut camera = self.clone();
        if let Some(motion) = &self.motion {
            camera.world_from_camera = without_scale(&motion.at(time));
        }
        if let Some(path) = &self.path {
            let (eye, target) = path.at(time);
            camera.world_from_camera = looking(eye, target);
            camera.focus_distance = eye.distance(target).max(1e-3);
        }
        camera
    }

    /// World position.
    pub fn position(&self) -> Vec3 {
        self.world_from_camera.translation.into()
    }

    /// Unit world direction of view.
    pub fn forward(&self) -> Vec3 {
        (-self.world_from_camera.matrix3.z_axis).normalize_or(Vec3A::NEG_Z).into()
    }
}

/// The position and the direction of view of a camera, however its node is scaled; +Y is kept as far up as it was.
pub fn without_scale(world: &Affine3A) -> Affine3A {
    let m = world.matrix3;
    let back = m.z_axis.normalize_or(Vec3A::Z);
    let side = m.y_axis.cross(back).try_normalize();
    let right = side.unwrap_or_else(|| back.any_orthonormal_vector());
    Affine3A { matrix3: Mat3A::from_cols(right, back.cross(right), back), translation: world.translation }
}

/// Rigid transform of something at `eye` whose -Z points at `target`, +Y as far up as that allows.
fn looking(eye: Vec3, target: Vec3) -> Affine3A {
    let back = (eye - target).normalize_or(Vec3::Z);
    let up = if back.y.abs() > 0.9999 { Vec3::NEG_Z } else { Vec3::Y };
    let right = up.cross(back).normalize();
    let matrix3 = Mat3A::from_cols(right.into(), back.cross(right).into(), back.into());
    Affine3A { matrix3, translation: eye.into() }
}

/// One station of a [`CameraPath`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraKey {
    /// Seconds.
    pub time: f64,
    /// Position of the camera.
    pub position: Vec3,
    /// The target point.
    pub target: Vec3,
}

/// A smooth way through stations: piecewise cubic Hermite curves through all of them with finite-difference slopes
/// (Catmull and Rom 1974, for uneven times). Before the first and after the last station the camera rests.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraPath {
    keys: Vec<CameraKey>,
}

impl CameraPath {
    /// A path through `keys`; `None` unless there are at least two with strictly rising times.
    pub fn new(keys: Vec<CameraKey>) -> Option<Self> {
        let rising = keys.windows(2).all(|pair| pair[0].time < pair[1].time);
        (keys.len() >= 2 && rising).then_some(Self { keys })
    }

    /// The stations.
    pub fn keys(&self) -> &[CameraKey] {
        &self.keys
    }

    /// Seconds from the first to the last station.
    pub fn duration(&self) -> f64 {
        self.keys[self.keys.len() - 1].time - self.keys[0].time
    }

    /// Position and target at `time`, on the clock of the stations.
    pub fn at(&self, time: f64) -> (Vec3, Vec3) {
        let keys = &self.keys;
        let time = time.clamp(keys[0].time, keys[keys.len() - 1].time);
        let i = keys.partition_point(|key| key.time <= time).clamp(1, keys.len() - 1) - 1;
        let (a, b) = (keys[i], keys[i + 1]);
        let span = b.time - a.time;
        let s = ((time - a.time) / span) as f32;
        let curve = |value: fn(&CameraKey) -> Vec3| {
            hermite(
                value(&a),
                self.slope(i, value) * span as f32,
                value(&b),
                self.slope(i + 1, value) * span as f32,
                s,
            )
        };
        (curve(|key| key.position), curve(|key| key.target))
    }

    /// Slope at a station: the chord between its neighbours; zero at the ends, so that the camera starts and stops gently.
    fn slope(&self, i: usize, value: fn(&CameraKey) -> Vec3) -> Vec3 {
        if i == 0 || i + 1 == self.keys.len() {
            return Vec3::ZERO;
        }
        let (before, after) = (&self.keys[i - 1], &self.keys[i + 1]);
        (value(after) - value(before)) / (after.time - before.time) as f32
    }
}

fn hermite(p0: Vec3, m0: Vec3, p1: Vec3, m1: Vec3, s: f32) -> Vec3 {
    let (s2, s3) = (s * s, s * s * s);
    p0 * (2.0 * s3 - 3.0 * s2 + 1.0) + m0 * (s3 - 2.0 * s2 + s) + p1 * (3.0 * s2 - 2.0 * s3) + m1 * (s3 - s2)
}
