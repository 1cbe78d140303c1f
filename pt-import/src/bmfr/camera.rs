//! Cameras from matrices of unknown convention.

use super::Recorded;
use glam::{DMat3, DVec3, Mat4, Vec2, Vec3};
use pt_shaders::records::CameraRecord;

/// How the matrix is stored, and which way its y axis points. The frames themselves say which: their positions must fall into their own pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Convention {
    /// The rows of the file are columns of clip from world.
    transposed: bool,
    /// Row 0 of the picture is at y = -1 of clip space.
    flipped: bool,
}

/// A perspective camera.
#[derive(Clone, Debug)]
pub(super) struct Camera {
    /// Clip from world: x, y and w as (normal, offset).
    rows: [(DVec3, f64); 3],
    pub convention: Convention,
    /// Its place.
    pub eye: Vec3,
}

/// Median distance of positions from their pixels up to which a matrix fits.
const FITS_PIXELS: f64 = 1.5;

impl Camera {
    /// The camera with which the positions of a frame fall into their pixels. `known`: the convention of the frames before.
    pub(super) fn fitting(
        matrix: &[f64; 16],
        frame: &Recorded,
        known: Option<Convention>,
    ) -> Result<Self, String> {
        let all = [(false, false), (false, true), (true, false), (true, true)]
            .map(|(transposed, flipped)| Convention { transposed, flipped });
        let candidates = all.into_iter().filter(|convention| known.is_none_or(|known| known == *convention));
        let cameras = candidates.filter_map(|convention| Self::new(matrix, convention));
        let measured = cameras.filter_map(|camera| Some((camera.error(frame)?, camera)));
        let best = measured.min_by(|a, b| a.0.total_cmp(&b.0));
        match best {
            Some((error, camera)) if error <= FITS_PIXELS => Ok(camera),
            Some((error, _)) => Err(format!(
                "does not fit world_position: half of the positions are more than {error:.1} pixels off their own pixel"
            )),
            None => Err("shows none of the positions of world_position".into()),
        }
    }

    /// `None`: the matrix is no perspective.
    fn new(matrix: &[f64; 16], convention: Convention) -> Option<Self> {
        let row = |r: usize| {
            let at = |k: usize| if convention.transposed { matrix[4 * r + k] } else { matrix[4 * k + r] };
            (DVec3::new(at(0), at(1), at(2)), at(3))
        };
        let rows = [0, 1, 3].map(row);
        // The one point that is nowhere in the picture.
        let normals = DMat3::from_cols(rows[0].0, rows[1].0, rows[2].0).transpose();
        let eye = normals.inverse() * -DVec3::new(rows[0].1, rows[1].1, rows[2].1);
        let is_camera = eye.is_finite() && normals.determinant().abs() > 1e-12;
        is_camera.then(|| Self { rows, convention, eye: eye.as_vec3() })
    }

    /// UV of a point; `None` behind the camera.
    pub(super) fn project(&self, position: Vec3) -> Option<[f32; 2]> {
        let [x, y, w] = self.rows.map(|(normal, offset)| normal.dot(position.as_dvec3()) + offset);
        let v = if self.convention.flipped { 0.5 + 0.5 * y / w } else { 0.5 - 0.5 * y / w };
        (w > 0.0).then(|| [(0.5 + 0.5 * x / w) as f32, v as f32])
    }

    /// Median distance of the positions from the middles of their pixels, pixels.
    fn error(&self, frame: &Recorded) -> Option<f64> {
        let [width, height] = frame.size;
        let count = (width * height) as usize;
        let mut errors = Vec::new();
        let mut seen = 0;
        for i in (0..count).step_by((count / 4096).max(1)) {
            let Some((_, position)) = frame.surface(i) else { continue };
            seen += 1;
            let Some(uv) = self.project(position) else { continue };
            let at = [i as u32 % width, i as u32 / width].map(|v| f64::from(v) + 0.5);
            let off = [uv[0] * width as f32, uv[1] * height as f32].map(f64::from);
            errors.push((off[0] - at[0]).hypot(off[1] - at[1]));
        }
        errors.sort_by(f64::total_cmp);
        (2 * errors.len() > seen).then(|| errors[errors.len() / 2])
    }

    /// Directions to the right, up and forwards, and half the picture at distance 1.
    fn frame(&self) -> ([DVec3; 3], [f64; 2]) {
        let [x, y, w] = self.rows.map(|(normal, _)| normal);
        let forward = w.normalize();
        let across = |axis: DVec3| axis - axis.dot(forward) * forward;
        let right = across(x).normalize();
        let half = [x, y].map(|axis| w.length() / across(axis).length());
        ([right, right.cross(forward), forward], half)
    }

    /// Angle between the rays of neighbouring pixels in the middle of the picture.
    pub(super) fn pixel_angle(&self, size: [u32; 2]) -> f32 {
        let (_, half) = self.frame();
        [0, 1].map(|k| (2.0 * half[k] / f64::from(size[k])) as f32).into_iter().fold(0.0, f32::max)
    }

    /// As kernels see it.
    pub(super) fn record(&self) -> CameraRecord {
        let ([right, up, forward], half) = self.frame();
        let column = |v: DVec3| v.as_vec3().extend(0.0);
        let world_from_view =
            Mat4::from_cols(column(right), column(up), column(-forward), self.eye.extend(1.0));
        CameraRecord {
            view_from_world: world_from_view.inverse(),
            world_from_view,
            half_extent: Vec2::new(half[0] as f32, half[1] as f32),
            lens_radius: 0.0,
            focus_distance: 1.0,
            projection: 0,
            pad: [0; 3],
        }
    }
}
