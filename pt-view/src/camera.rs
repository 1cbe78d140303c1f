//! The camera that mouse and keys move: it flies, or goes round a point.

use crate::protocol::Pose;
use pt_core::glam::Vec3;

/// Keys that are held, each -1, 0 or 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Held {
    /// To the right.
    pub right: f32,
    /// Up.
    pub up: f32,
    /// Forward.
    pub forward: f32,
    /// Five times as fast.
    pub fast: bool,
}

impl Held {
    /// Whether the camera moves.
    pub fn is_any(&self) -> bool {
        [self.right, self.up, self.forward] != [0.0; 3]
    }
}

/// A camera with +Y up in the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeCamera {
    eye: Vec3,
    /// Radians about +Y; 0 looks along -Z, positive to the left.
    yaw: f32,
    /// Radians; positive looks up.
    pitch: f32,
    /// To the point that it goes round, metres.
    distance: f32,
    vfov: f32,
    /// Metres a second.
    speed: f32,
}

/// Radians that a drag of one pixel turns.
const TURN: f32 = 0.004;
/// Short of straight up and down, where the direction of up is lost.
const MOST_PITCH: f32 = 1.55;

impl FreeCamera {
    /// At `pose`, in a scene whose longest side measures `scene_size` metres.
    pub fn new(pose: Pose, scene_size: f32) -> Self {
        let mut camera = Self {
            eye: Vec3::ZERO,
            yaw: 0.0,
            pitch: 0.0,
            distance: 1.0,
            vfov: pose.vfov,
            speed: (0.15 * scene_size).clamp(1e-3, 1e4),
        };
        camera.put(pose);
        camera
    }

    /// Puts it at `pose`.
    pub fn put(&mut self, pose: Pose) {
        let (eye, target) = (Vec3::from(pose.eye), Vec3::from(pose.target));
        let forward = (target - eye).normalize_or(Vec3::NEG_Z);
        self.eye = eye;
        self.distance = eye.distance(target).max(1e-3);
        self.pitch = forward.y.clamp(-1.0, 1.0).asin().clamp(-MOST_PITCH, MOST_PITCH);
        self.yaw = (-forward.x).atan2(-forward.z);
        self.vfov = pose.vfov;
    }

    /// Where it is.
    pub fn pose(&self) -> Pose {
        let target = self.eye + self.forward() * self.distance;
        Pose { eye: self.eye.to_array(), target: target.to_array(), vfov: self.vfov }
    }

    /// Looks about: a drag by `pixels`, to the right and down.
    pub fn look(&mut self, pixels: [f32; 2]) {
        self.yaw -= pixels[0] * TURN;
        self.pitch = (self.pitch - pixels[1] * TURN).clamp(-MOST_PITCH, MOST_PITCH);
    }

    /// Goes round the point that it looks at: a drag by `pixels`.
    pub fn orbit(&mut self, pixels: [f32; 2]) {
        let centre = self.eye + self.forward() * self.distance;
        self.look(pixels);
        self.eye = centre - self.forward() * self.distance;
    }

    /// Moves sideways and up with the picture: a drag by `pixels` of a picture that is `height` pixels high.
    pub fn pan(&mut self, pixels: [f32; 2], height: f32) {
        let metres = 2.0 * self.distance * (0.5 * self.vfov.to_radians()).tan() / height.max(1.0);
        self.eye += (self.up() * pixels[1] - self.right() * pixels[0]) * metres;
    }

    /// Towards the point that it looks at, by notches of the wheel.
    pub fn dolly(&mut self, notches: f32) {
        let centre = self.eye + self.forward() * self.distance;
        self.distance = (self.distance * 0.85f32.powf(notches)).clamp(1e-3, 1e6);
        self.eye = centre - self.forward() * self.distance;
    }

    /// Flies faster or slower, by notches of the wheel.
    pub fn hurry(&mut self, notches: f32) {
        self.speed = (self.speed * 1.25f32.powf(notches)).clamp(1e-3, 1e5);
    }

    /// Flies for `seconds` with these keys held.
    pub fn fly(&mut self, held: Held, seconds: f32) {
        let way = self.right() * held.right + Vec3::Y * held.up + self.forward() * held.forward;
        let speed = self.speed * if held.fast { 5.0 } else { 1.0 };
        self.eye += way.normalize_or_zero() * speed * seconds;
    }

    fn forward(&self) -> Vec3 {
        let (sin, cos) = self.yaw.sin_cos();
        Vec3::new(-sin * self.pitch.cos(), self.pitch.sin(), -cos * self.pitch.cos())
    }

    fn right(&self) -> Vec3 {
        let (sin, cos) = self.yaw.sin_cos();
        Vec3::new(cos, 0.0, -sin)
    }

    fn up(&self) -> Vec3 {
        self.right().cross(self.forward())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const POSE: Pose = Pose { eye: [1.0, 2.0, 3.0], target: [-2.0, 1.0, -1.0], vfov: 50.0 };

    fn near(a: [f32; 3], b: [f32; 3]) -> bool {
        Vec3::from(a).abs_diff_eq(Vec3::from(b), 1e-4)
    }

    #[test]
    fn a_pose_is_kept() {
        let pose = FreeCamera::new(POSE, 10.0).pose();
        assert!(near(pose.eye, POSE.eye) && near(pose.target, POSE.target), "{pose:?}");
        for target in [[1.0, 2.0, 9.0], [1.0, 9.0, 3.0], [1.0, -9.0, 3.0], [5.0, 2.0, 3.0]] {
            let pose = FreeCamera::new(Pose { target, ..POSE }, 10.0).pose();
            let way = |pose: Pose| (Vec3::from(pose.target) - Vec3::from(pose.eye)).normalize();
            assert!(way(pose).dot(way(Pose { target, ..POSE })) > 0.999, "{target:?}: {pose:?}");
        }
    }

    #[test]
    fn it_flies_where_it_looks() {
        let look = |held| {
            let mut camera =
                FreeCamera::new(Pose { eye: [0.0; 3], target: [0.0, 0.0, -5.0], vfov: 50.0 }, 20.0);
            camera.fly(held, 1.0);
            camera.pose().eye
        };
        assert!(near(look(Held { forward: 1.0, ..Held::default() }), [0.0, 0.0, -3.0]));
        assert!(near(look(Held { right: 1.0, ..Held::default() }), [3.0, 0.0, 0.0]));
        assert!(near(look(Held { up: -1.0, fast: true, ..Held::default() }), [0.0, -15.0, 0.0]));
    }

    #[test]
    fn a_drag_to_the_right_turns_to_the_right_and_down_looks_down() {
        let mut camera = FreeCamera::new(Pose { eye: [0.0; 3], target: [0.0, 0.0, -5.0], vfov: 50.0 }, 1.0);
        camera.look([10.0, 10.0]);
        let target = camera.pose().target;
        assert!(target[0] > 0.0 && target[1] < 0.0, "{target:?}");
    }

    #[test]
    fn orbit_and_dolly_keep_the_point() {
        let mut camera = FreeCamera::new(POSE, 10.0);
        camera.orbit([40.0, -25.0]);
        camera.dolly(3.0);
        let pose = camera.pose();
        assert!(near(pose.target, POSE.target), "{pose:?}");
        assert!(!near(pose.eye, POSE.eye));
        let mut panned = camera;
        panned.pan([30.0, 0.0], 100.0);
        assert!(!near(panned.pose().target, POSE.target), "a pan moves the point");
    }
}
