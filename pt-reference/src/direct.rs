//! Direct light at Lambertian surfaces: emission and one reflection, integrated over the lights by dense deterministic
//! quadrature with ray-cast visibility.
//!
//! A pixel's samples, and the shifts (Cranley and Patterson 1976) of the grids of equal area or solid angle that cover
//! emissive triangles and the environment, are the dimensions of one Kronecker sequence: a pixel's value has as many points on
//! each light as it has samples times grid points, and edges that run along the pixel's sides cost no more than others. Delta
//! lights are closed forms. Nothing is random.

use crate::bvh::{Bvh, Triangle};
use glam::{DAffine3, DVec2, DVec3, DVec4, Vec3, Vec4Swizzles};
use pt_scene::{AlphaMode, Camera, LightKind, Material, Projection, Scene, Shows};
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// What keeps a scene or a camera from being integrated.
#[derive(Debug, thiserror::Error)]
pub enum DirectError {
    /// A surface that is not opaque and Lambertian with constant colour.
    #[error(
        "material {material}: {what}; the direct light reference takes opaque Lambertian surfaces without textures"
    )]
    Material {
        /// Its name.
        material: String,
        /// The offending property.
        what: &'static str,
    },
    /// A punctual light with an extent.
    #[error("light {0} has a radius; the direct light reference takes point-like and parallel light only")]
    Light(String),
    /// A thin lens.
    #[error("camera {0} has a lens; the direct light reference takes pinholes only")]
    Lens(String),
}

/// How fine the integration is. The cost of a pixel is proportional to `pixel` times the squares of the rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quality {
    /// Samples of a pixel.
    pub pixel: u32,
    /// Points along each side of the grid on an emissive triangle.
    pub emitter: u32,
    /// Rows of the grid on the environment's sphere; twice as many columns.
    pub environment: u32,
}

impl Default for Quality {
    /// 4096 points a pixel on every emissive triangle, 32768 on the environment.
    fn default() -> Self {
        Self { pixel: 256, emitter: 4, environment: 8 }
    }
}

struct Surface {
    normals: [DVec3; 3],
    /// Of the front face.
    face_normal: DVec3,
    /// Base colour of the material times vertex colours.
    albedo: [DVec3; 3],
    emission: DVec3,
    double_sided: bool,
}

struct Emitter {
    corners: [DVec3; 3],
    normal: DVec3,
    area: f64,
    radiance: DVec3,
    double_sided: bool,
}

/// A scene prepared for integration.
pub struct DirectLight<'a> {
    scene: &'a Scene,
    bvh: Bvh,
    surfaces: Vec<Surface>,
    emitters: Vec<Emitter>,
    quality: Quality,
    /// Nearest distance of a shadow ray's hit, metres.
    near: f64,
}

impl<'a> DirectLight<'a> {
    /// Places the scene's triangles where its instances are now.
    ///
    /// # Errors
    /// A material or a light that the integration does not cover.
    pub fn new(scene: &'a Scene, quality: Quality) -> Result<Self, DirectError> {
        for light in &scene.lights {
            let extent =
                if light.kind == LightKind::Directional { light.angular_radius } else { light.radius };
            if extent > 0.0 {
                return Err(DirectError::Light(light.name.clone()));
            }
        }
        let (mut triangles, mut surfaces, mut emitters) = (Vec::new(), Vec::new(), Vec::new());
        let mut extent = 1.0f64;
        for instance in &scene.instances {
            let mesh = &scene.meshes[instance.mesh as usize];
            let world_from_object = double(&instance.world_from_object);
            let normal_matrix = world_from_object.matrix3.inverse().transpose();
            let side = world_from_object.matrix3.determinant().signum();
            for (t, indices) in mesh.indices.iter().enumerate() {
                let material = &scene.materials[instance.material_at(mesh, t) as usize];
                check(material)?;
                let corners = indices
                    .map(|v| world_from_object.transform_point3(mesh.positions[v as usize].as_dvec3()));
                let cross = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
                if cross == DVec3::ZERO {
                    continue;
                }
                extent = corners.iter().fold(extent, |e, c| e.max(c.abs().max_element()));
                let face_normal = side * cross.normalize();
                let base = material.base_color.truncate().as_dvec3();
                let emission = material.emissive.as_dvec3();
                triangles.push(Triangle::new(corners));
                surfaces.push(Surface {
                    normals: indices
                        .map(|v| (normal_matrix * mesh.normals[v as usize].as_dvec3()).normalize()),
                    face_normal,
                    albedo: indices.map(|v| base * mesh.colors[v as usize].truncate().as_dvec3()),
                    emission,
                    double_sided: material.double_sided,
                });
                if material.is_emissive() {
                    emitters.push(Emitter {
                        corners,
                        normal: face_normal,
                        area: 0.5 * cross.length(),
                        radiance: emission,
                        double_sided: material.double_sided,
                    });
                }
            }
        }
        Ok(Self { scene, bvh: Bvh::new(triangles), surfaces, emitters, quality, near: 1e-9 * extent })
    }

    /// Radiance along a ray: emission of the first surface, the light that it reflects directly, or the environment.
    /// `shift` in [0, 1)^2 moves the grids on the lights.
    pub fn radiance(&self, origin: DVec3, direction: DVec3, shift: DVec2) -> DVec3 {
        let Some(hit) = self.bvh.closest(origin, direction, 0.0) else {
            return self.scene.environment.radiance(direction.as_vec3().normalize()).as_dvec3();
        };
        let surface = &self.surfaces[hit.triangle];
        let [b, c] = hit.weights;
        let mix = |of: [DVec3; 3]| of[0] * (1.0 - b - c) + of[1] * b + of[2] * c;
        let front = surface.face_normal.dot(direction) < 0.0;
        let facing = if front { 1.0 } else { -1.0 };
        let normal = facing * mix(surface.normals).normalize();
        let point = origin + hit.t * direction;
        let emission = if front || surface.double_sided { surface.emission } else { DVec3::ZERO };
        let albedo = mix(surface.albedo).clamp(DVec3::ZERO, DVec3::ONE);
        emission + albedo / PI * self.irradiance(point, normal, facing * surface.face_normal, shift)
    }

    /// Irradiance at a point, in radiance times steradians; `face_normal` bounds what can be seen.
    fn irradiance(&self, point: DVec3, normal: DVec3, face_normal: DVec3, shift: DVec2) -> DVec3 {
        // Cosine at the surface, zero below either horizon.
        let cosine = |l: DVec3| if face_normal.dot(l) > 0.0 { normal.dot(l).max(0.0) } else { 0.0 };
        let visible = |to: DVec3, t_max: f64| !self.bvh.occluded(point, to, self.near, t_max);
        let mut sum = DVec3::ZERO;
        for light in &self.scene.lights {
            let intensity = light.intensity.as_dvec3();
            let (to, falloff, reach) = match light.kind {
                LightKind::Directional => (-light.direction.as_dvec3(), 1.0, f64::INFINITY),
                LightKind::Point | LightKind::Spot { .. } => {
                    let d = light.position.as_dvec3() - point;
                    (d.normalize(), spot(light, -d.normalize()) / d.length_squared(), d.length())
                }
            };
            let weight = cosine(to) * falloff;
            if weight > 0.0 && visible(to, reach) {
                sum += intensity * weight;
            }
        }
        sum + self.emitted(point, &cosine, &visible, shift) + self.environment(&cosine, &visible, shift)
    }

    /// Integral over the emissive triangles of L cos cos' / d^2 dA.
    fn emitted(
        &self,
        point: DVec3,
        cosine: &impl Fn(DVec3) -> f64,
        visible: &impl Fn(DVec3, f64) -> bool,
        shift: DVec2,
    ) -> DVec3 {
        let n = self.quality.emitter;
        let mut sum = DVec3::ZERO;
        for emitter in &self.emitters {
            let [a, b, c] = emitter.corners;
            let mut geometry = 0.0;
            for xi in grid(n, n, shift) {
                // Uniform in area (Turk 1990).
                let root = xi.x.sqrt();
                let d = a * (1.0 - root) + b * (root * (1.0 - xi.y)) + c * (root * xi.y) - point;
                let distance = d.length();
                let l = d / distance;
                let leaving = -emitter.normal.dot(l);
                let leaving = if emitter.double_sided { leaving.abs() } else { leaving.max(0.0) };
                let weight = cosine(l) * leaving / (distance * distance);
                if weight > 0.0 && visible(l, distance * (1.0 - 1e-9)) {
                    geometry += weight;
                }
            }
            sum += emitter.radiance * (geometry * emitter.area / f64::from(n * n));
        }
        sum
    }

    /// Integral over the sphere of L cos d(solid angle).
    fn environment(
        &self,
        cosine: &impl Fn(DVec3) -> f64,
        visible: &impl Fn(DVec3, f64) -> bool,
        shift: DVec2,
    ) -> DVec3 {
        if self.scene.environment.is_black() {
            return DVec3::ZERO;
        }
        let rows = self.quality.environment;
        let mut sum = DVec3::ZERO;
        for xi in grid(2 * rows, rows, shift) {
            let (phi, y) = (TAU * xi.x, 1.0 - 2.0 * xi.y);
            let r = (1.0 - y * y).max(0.0).sqrt();
            let l = DVec3::new(r * phi.cos(), y, r * phi.sin());
            let cos = cosine(l);
            if cos > 0.0 && visible(l, f64::INFINITY) {
                sum += cos * self.scene.environment.radiance(l.as_vec3()).as_dvec3();
            }
        }
        sum * (4.0 * PI / f64::from(2 * rows * rows))
    }

    /// Mean radiance over the unit box of pixel (x, y) of an image of `size`; row 0 is the top.
    ///
    /// # Errors
    /// A camera with a lens.
    pub fn pixel(&self, camera: &Camera, size: [u32; 2], x: u32, y: u32) -> Result<[f64; 3], DirectError> {
        if camera.lens_radius > 0.0 {
            return Err(DirectError::Lens(camera.name.clone()));
        }
        let n = u64::from(self.quality.pixel);
        // Every pixel has a stretch of the sequence of its own.
        let first = u64::from(y * size[0] + x) * n;
        let sum: DVec3 = (first..first + n)
            .map(|k| {
                let point = (KRONECKER * (k as f64 + 0.5)).fract();
                let at = DVec2::new(f64::from(x), f64::from(y)) + point.xy();
                let (origin, direction) = camera_ray(camera, size, at);
                self.radiance(origin, direction, point.zw())
            })
            .sum();
        Ok((sum / n as f64).to_array())
    }

    /// All pixels, row by row from the top.
    ///
    /// # Errors
    /// A camera with a lens.
    pub fn image(&self, camera: &Camera, size: [u32; 2]) -> Result<Vec<[f64; 3]>, DirectError> {
        (0..size[0] * size[1])
            .into_par_iter()
            .map(|i| self.pixel(camera, size, i % size[0], i / size[0]))
            .collect()
    }
}

/// Steps of a Kronecker sequence in four dimensions: powers of the root of x^5 = x + 1 (Roberts 2018).
const KRONECKER: DVec4 =
    DVec4::new(0.856_674_883_854_502_9, 0.733_891_856_627_126, 0.628_706_721_037_808_6, 0.538_597_257_223_61);

/// Centres of a grid on the unit square, moved by `shift`, wrapped, and folded by the baker's transform: the folded integrand
/// is periodic, so that the error falls with the square of the grid's step whatever the shift (Hickernell 2002).
fn grid(columns: u32, rows: u32, shift: DVec2) -> impl Iterator<Item = DVec2> {
    let size = DVec2::new(f64::from(columns), f64::from(rows));
    (0..columns * rows).map(move |i| {
        let center = (DVec2::new(f64::from(i % columns), f64::from(i / columns)) + 0.5) / size;
        DVec2::ONE - (2.0 * (center + shift).fract() - 1.0).abs()
    })
}

pub(crate) fn double(m: &glam::Affine3A) -> DAffine3 {
    let column = |axis: glam::Vec3A| Vec3::from(axis).as_dvec3();
    DAffine3::from_cols(
        column(m.matrix3.x_axis),
        column(m.matrix3.y_axis),
        column(m.matrix3.z_axis),
        column(m.translation),
    )
}

/// Angular attenuation recommended by KHR_lights_punctual.
fn spot(light: &pt_scene::Light, direction: DVec3) -> f64 {
    let LightKind::Spot { inner, outer } = light.kind else { return 1.0 };
    let (inner, outer) = (f64::from(inner).cos(), f64::from(outer).cos());
    let cos = light.direction.as_dvec3().dot(direction);
    ((cos - outer) / (inner - outer).max(1e-3)).clamp(0.0, 1.0).powi(2)
}

fn check(m: &Material) -> Result<(), DirectError> {
    let problems = [
        (m.specular > 0.0, "has a specular lobe"),
        (m.metallic > 0.0, "is metallic"),
        (m.transmission > 0.0, "transmits light"),
        (m.alpha_mode != AlphaMode::Opaque, "has an alpha mode"),
        (m.unlit, "is unlit"),
        (m.textures().next().is_some(), "has a texture"),
        (m.shows != Shows::Itself, "shows something else than itself"),
    ];
    match problems.into_iter().find(|(is, _)| *is) {
        Some((_, what)) => Err(DirectError::Material { material: m.name.clone(), what }),
        None => Ok(()),
    }
}

/// Origin and unit direction of the ray through a point of the image, in pixels from its top left corner.
fn camera_ray(camera: &Camera, size: [u32; 2], at: DVec2) -> (DVec3, DVec3) {
    let [width, height] = size.map(f64::from);
    let plane = DVec2::new(2.0 * at.x / width - 1.0, 1.0 - 2.0 * at.y / height);
    let aspect = DVec2::new(width / height, 1.0);
    let world = double(&camera.world_from_camera);
    let (origin, direction) = match camera.projection {
        Projection::Perspective { yfov } => {
            let plane = plane * aspect * (0.5 * f64::from(yfov)).tan();
            (DVec3::ZERO, plane.extend(-1.0))
        }
        Projection::Orthographic { ymag } => ((plane * aspect * f64::from(ymag)).extend(0.0), DVec3::NEG_Z),
    };
    (world.transform_point3(origin), world.transform_vector3(direction).normalize())
}
