//! The clear sky of Hosek and Wilkie with its sun.

use std::f32::consts::{FRAC_PI_2, PI, TAU};
use std::str::FromStr;

use glam::Vec3;
use hw_skymodel::rgb::{Channel, SkyParams, SkyState};
use rayon::prelude::*;

use crate::{Environment, EnvironmentImage, Light};

/// Rows of the image; twice as many columns. A row is 0.18 degrees: the model's brightest band, at the horizon, is 0.6 degrees high.
const ROWS: u32 = 1024;

/// cd/m2 for a value of the model, whose RGB data are W/(m2 sr) weighted with the colour matching functions of CIE 1931.
const LUMENS_PER_WATT: f32 = 683.002;

/// Half the angle under which the sun is seen, radians.
const SUN_RADIUS: f32 = 0.533_f32.to_radians() / 2.0;

const SUN_TABLE: &str = include_str!("sun_illuminance.txt");

/// A clear sky over a diffuse ground, with the sun. Radiance is in cd/m2, and the sun's illuminance in lux.
///
/// The sky is that of Hosek and Wilkie 2012, "An Analytic Model for Full Spectral Sky-Dome Radiance", equations 8 to 11, with the authors'
/// RGB data. The sun's illuminance is that of their 2013 paper, "Adding a Solar-Radiance Function to the Hosek-Wilkie Skylight Model". The
/// ground below the horizon is a plane of the albedo in that light. The model has no twilight: the sun is above the horizon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhysicalSky {
    elevation: f32,
    azimuth: f32,
    turbidity: f32,
    albedo: f32,
    state: SkyState,
}

impl PhysicalSky {
    /// How an argument gives a sky.
    pub const FORM: &str = "ELEVATION,AZIMUTH[,TURBIDITY[,ALBEDO]]";
    /// Turbidity where none is given: a clear day.
    pub const DEFAULT_TURBIDITY: f32 = 3.0;
    /// Albedo of the ground where none is given: grass and soil.
    pub const DEFAULT_ALBEDO: f32 = 0.2;

    /// A sky.
    ///
    /// `elevation`: of the sun, 0..=90 degrees. `azimuth`: of the sun, degrees about +Y, counter-clockwise seen from above; 0 is +X, 90 is
    /// -Z. `turbidity`: haze, 1..=10; 2 is very clear, 10 is hazy. `albedo`: of the ground, 0..=1.
    ///
    /// # Errors
    /// A value that is out of its range or not finite, in words.
    pub fn new(elevation: f32, azimuth: f32, turbidity: f32, albedo: f32) -> Result<Self, String> {
        if (-90.0..0.0).contains(&elevation) {
            return Err(format!(
                "the sun is below the horizon at an elevation of {elevation} degrees; the model has no twilight, give 0 to 90"
            ));
        }
        let within = |what: &str, value: f32, [least, most]: [f32; 2]| match (least..=most).contains(&value) {
            true => Ok(()),
            false => Err(format!("{what} {value} is out of range; give {least} to {most}")),
        };
        within("elevation (degrees)", elevation, [0.0, 90.0])?;
        within("turbidity", turbidity, [1.0, 10.0])?;
        within("albedo of the ground", albedo, [0.0, 1.0])?;
        if !azimuth.is_finite() {
            return Err(format!("azimuth {azimuth} is not finite; give degrees"));
        }
        let params =
            SkyParams { elevation: elevation.to_radians().min(FRAC_PI_2), turbidity, albedo: [albedo; 3] };
        let state = SkyState::new(&params).map_err(|error| error.to_string())?;
        Ok(Self { elevation, azimuth, turbidity, albedo, state })
    }

    /// Unit direction towards the sun.
    pub fn towards_sun(&self) -> Vec3 {
        // The remainder keeps its digits where the number of degrees is large.
        let (elevation, azimuth) = (self.elevation.to_radians(), (self.azimuth % 360.0).to_radians());
        Vec3::new(elevation.cos() * azimuth.cos(), elevation.sin(), -elevation.cos() * azimuth.sin())
    }

    /// Radiance of the sky without the disc of the sun from a unit direction above the horizon, cd/m2.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        let theta = direction.y.clamp(0.0, 1.0).acos();
        // The angle to the sun by the chord: a cosine has no digits left near the sun.
        let gamma = 2.0 * (0.5 * direction.distance(self.towards_sun())).min(1.0).asin();
        let channels = [Channel::R, Channel::G, Channel::B];
        // Colours outside of Rec. 709, in a sky with a low sun, have negative values.
        Vec3::from_array(channels.map(|c| (LUMENS_PER_WATT * self.state.radiance(theta, gamma, c)).max(0.0)))
    }

    /// Illuminance of the sun on a surface that faces it, lux.
    pub fn sun_illuminance(&self) -> Vec3 {
        // Linear between two turbidities, as the authors interpolate. The square root is nearly linear in the elevation of a low sun.
        let low = (self.turbidity as usize).clamp(1, 9);
        let share = self.turbidity - low as f32;
        let rows: Vec<Vec<f32>> = SUN_TABLE.split("= ").skip(1).map(parse_row).collect();
        let next = rows.partition_point(|row| row[0] < self.elevation).clamp(1, rows.len() - 1);
        let [before, after] = [&rows[next - 1], &rows[next]];
        let between = (self.elevation - before[0]) / (after[0] - before[0]);
        Vec3::from_array([0, 1, 2].map(|channel| {
            let at = |turbidity: usize| {
                let value = 1 + 3 * (turbidity - 1) + channel;
                (before[value].sqrt() * (1.0 - between) + after[value].sqrt() * between).powi(2)
            };
            at(low) * (1.0 - share) + at(low + 1) * share
        }))
    }

    /// The sun, as wide as it is seen from the Earth.
    pub fn sun(&self) -> Light {
        Light {
            angular_radius: SUN_RADIUS,
            ..Light::directional("sun of the sky", -self.towards_sun(), self.sun_illuminance())
        }
    }

    /// The sky without the disc of the sun, which is the light [`PhysicalSky::sun`], and the ground.
    pub fn environment(&self) -> Environment {
        let (width, height) = (2 * ROWS, ROWS);
        let mut environment = Environment::new(EnvironmentImage { width, height, texels: vec![] });
        let texel = |x: u32, y: u32| {
            let uv = glam::Vec2::new((x as f32 + 0.5) / width as f32, (y as f32 + 0.5) / height as f32);
            self.radiance(environment.direction(uv))
        };
        let row = |y: u32| -> Vec<Vec3> { (0..width).map(|x| texel(x, y)).collect() };
        let rows: Vec<Vec<Vec3>> = (0..height / 2).into_par_iter().map(row).collect();
        let edge = |y: usize| (y as f32 * PI / height as f32).sin().powi(2);
        let of_row = |(y, row): (usize, &Vec<Vec3>)| {
            // Integral of the cosine over the solid angle of a texel.
            let weight = 0.5 * (edge(y + 1) - edge(y)) * TAU / width as f32;
            weight * row.iter().sum::<Vec3>()
        };
        let from_sky: Vec3 = rows.iter().enumerate().map(of_row).sum();
        let from_sun = self.towards_sun().y * self.sun_illuminance();
        let ground = self.albedo / PI * (from_sky + from_sun);
        environment.image.texels = rows.concat();
        environment.image.texels.resize((width * height) as usize, ground);
        environment
    }
}

impl FromStr for PhysicalSky {
    type Err = String;

    /// [`PhysicalSky::FORM`], numbers with commas between them.
    fn from_str(text: &str) -> Result<Self, String> {
        let values: Result<Vec<f32>, _> = text.split(',').map(|part| part.trim().parse()).collect();
        let (turbidity, albedo) = (Self::DEFAULT_TURBIDITY, Self::DEFAULT_ALBEDO);
        match values.as_deref() {
            Ok(&[elevation, azimuth]) => Self::new(elevation, azimuth, turbidity, albedo),
            Ok(&[elevation, azimuth, turbidity]) => Self::new(elevation, azimuth, turbidity, albedo),
            Ok(&[elevation, azimuth, turbidity, albedo]) => Self::new(elevation, azimuth, turbidity, albedo),
            _ => Err(format!("expected {}", Self::FORM)),
        }
    }
}

/// An elevation, and red, green and blue for each turbidity.
fn parse_row(line: &str) -> Vec<f32> {
    line.split_whitespace().filter_map(|word| word.parse().ok()).collect()
}
