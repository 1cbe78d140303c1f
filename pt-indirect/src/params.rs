//! The knobs of indirect lighting.

use crate::records::{
    BounceReuse, DRAW_FIXED_HALF, DRAW_UNIFORM_HEMISPHERE, Hemisphere, IndirectPush, LobeChoice,
    RestirVisibility,
};
use pt_core::knobs;
use pt_core::settings::InvalidValue;
use pt_shaders::dimensions::{MAX_BOUNCES, MAX_RESTIR_NEIGHBOURS};
use pt_shaders::records::{
    AreaSampling, BvhImportance, EmissionShare, GlassShadows, KIND_EMISSIVE, KIND_ENVIRONMENT,
    KIND_POSITIONAL, KIND_SUN, LightSampler, MASK_OPAQUE, MASK_TRANSMISSIVE, RisSource,
};

knobs! {
    /// Knobs of indirect lighting. Which kinds of light there are, how a light is picked and what glass does to shadow rays is what the knobs of direct lighting say.
    pub struct IndirectParams {
        /// Bounces of a path: 0 is none, 0.5 is one bounce of diffuse light at every other row of pixels with twice the weight, else a whole
        /// number.
        pub bounces: f32 = 1.0, in 0.0..=MAX_BOUNCES as f32 => structural;
        /// Bounces before Russian roulette begins.
        pub roulette_start: u32 = 3, in 0..=MAX_BOUNCES, source "Arvo and Kirk 1990";
        /// Whether diffuse light keeps its direction, in spherical harmonics, for filters across surfaces with different normals.
        pub sh: bool = true, source "Ramamoorthi and Hanrahan 2001";
        /// How directions of the diffuse lobe are drawn.
        pub hemisphere: Hemisphere = Hemisphere::Cosine;
        /// How often a bounce ray is drawn for the specular lobes.
        pub lobe_choice: LobeChoice = LobeChoice::Fresnel;
        /// Which part of the specular light of emissive triangles bounce rays find, instead of the light samples of direct lighting.
        pub emission_share: EmissionShare = EmissionShare::Mis, source "Veach 1997, section 9.2" => structural;
        /// BIASED: factor on the width of the cone over which textures are filtered where a ray ends; 0 reads their finest level.
        pub texture_spread: f32 = 0.25, in 0.0..=4.0, source "Bekaert et al. 2003";
        /// BIASED below 1: part of the visible normals, from the middle of the lobe on, that specular directions are drawn from.
        pub ndf_trim: f32 = 1.0, in 0.1..=1.0;
        /// BIASED below 1: perceptual roughness from which on indirect specular light fades out, over 0.1.
        pub specular_fade: f32 = 1.0, in 0.0..=1.0;
        /// BIASED above 0: indirect specular light is divided by ray length times roughness times this, where that is above 1.
        pub anti_flicker: f32 = 0.0, in 0.0..=100.0, unit "1/m";
        /// BIASED above 0: length of the first ray at which bounced light of directional lights has faded out; 0 is no limit.
        pub sun_range: f32 = 0.0, in 0.0..=1e6, unit "m";
        /// BIASED above 0: largest radiance of a sample, per channel, against fireflies; 0 is no limit.
        pub clamp: f32 = 0.0, in 0.0..=f32::MAX, unit "radiance";
        /// BIASED above 0: largest radiance, mean of the channels, of what a path of narrow lobes brings at once; a path that scattered or found
        /// its light with a low density may bring less; 0 is no limit.
        pub firefly: f32 = 0.0, in 0.0..=f32::MAX, unit "radiance";
        /// Whether surfaces get light that the paths of other pixels and frames have found; not with half a bounce.
        pub reuse: BounceReuse = BounceReuse::None, source "Ouyang et al. 2021" => structural;
        /// Which rays `reuse=restir-gi` traces; all but `in-weight` are biased.
        pub restir_visibility: RestirVisibility = RestirVisibility::InWeight, source "Lin et al. 2022" => structural;
        /// How much the past of `reuse=restir-gi` counts at most: more means less noise that changes more slowly; 0: the past is not reused.
        pub restir_history: u32 = 20, in 0..=64, unit "frames", source "Ouyang et al. 2021, section 4.2";
        /// Neighbours whose bounces `reuse=restir-gi` reuses.
        pub restir_spatial: u32 = 3, in 0..=MAX_RESTIR_NEIGHBOURS, source "Ouyang et al. 2021, section 4.3";
        /// How far neighbours of `reuse=restir-gi` are at most.
        pub restir_radius: f32 = 30.0, in 1.0..=128.0, unit "pixels";
        /// Length from which on first rays are reused, over the distance of the surface from the camera: neighbours differ the more, the shorter they are.
        pub restir_distance: f32 = 0.02, in 0.0..=10.0, source "Lin et al. 2022, section 7.2";
        /// Perceptual roughness of a surface from which on its specular light is that of `reuse=restir-gi`, too.
        pub restir_roughness: f32 = 0.6, in 0.0..=1.0;
        check Self::has_whole_bounces;
    }
}

impl IndirectParams {
    fn has_whole_bounces(&self) -> Result<(), InvalidValue> {
        if self.is_half() && self.reuses() {
            let expected =
                "none with bounces=0.5, whose paths are those of other pixels in each frame".into();
            return Err(InvalidValue { key: "reuse".into(), value: self.reuse.name().into(), expected });
        }
        if self.is_half() || self.bounces.fract() == 0.0 {
            return Ok(());
        }
        let expected = format!("0.5, or a whole number of 0 to {MAX_BOUNCES}");
        Err(InvalidValue { key: "bounces".into(), value: self.bounces.to_string(), expected })
    }

    /// Whether there is a stage at all.
    pub fn is_on(&self) -> bool {
        self.bounces > 0.0
    }

    /// Half a bounce: every other row, diffuse light alone.
    pub fn is_half(&self) -> bool {
        self.bounces == 0.5
    }

    /// Whether bounces are reused.
    pub(crate) fn reuses(&self) -> bool {
        self.is_on() && self.reuse == BounceReuse::RestirGi
    }

    /// What direct lighting leaves to the bounce rays. Where shadow rays do not see glass, it leaves nothing: bounce rays see it.
    pub fn left_by_direct_light(&self, lights: &BounceLights) -> EmissionShare {
        let sees_glass = lights.glass_shadows.tints() || lights.shadow_mask & MASK_TRANSMISSIVE != 0;
        if self.bounces >= 1.0 && sees_glass { self.emission_share } else { EmissionShare::LightSamples }
    }

    /// Surfaces that a path scatters at after the first one, at most.
    pub(crate) fn surfaces(&self) -> u32 {
        self.bounces.ceil() as u32
    }

    /// `DRAW_*` bits.
    fn draw(&self) -> u32 {
        let uniform = if self.hemisphere == Hemisphere::Uniform { DRAW_UNIFORM_HEMISPHERE } else { 0 };
        uniform | if self.lobe_choice == LobeChoice::Half { DRAW_FIXED_HALF } else { 0 }
    }

    /// Push constants, without the tables that the passes share.
    pub fn push(&self, lights: &BounceLights, texture_lod_bias: f32) -> IndirectPush {
        IndirectPush {
            tables: 0,
            columns: 0,
            width: 0,
            vertex: 0,
            kinds: lights.kinds,
            mask: lights.shadow_mask,
            glass_shadows: lights.glass_shadows.code(),
            bounces: self.surfaces(),
            half_rows: u32::from(self.is_half()),
            roulette_start: self.roulette_start,
            emission_share: self.left_by_direct_light(lights).code(),
            directional: u32::from(self.sh),
            draw: self.draw(),
            lod_scale: texture_lod_bias.exp2(),
            texture_spread: self.texture_spread,
            ris_candidates: lights.ris_candidates,
            ris_stratified: u32::from(lights.ris_stratified),
            ndf_trim: self.ndf_trim,
            specular_fade: self.specular_fade,
            anti_flicker: self.anti_flicker,
            sun_range: self.sun_range,
            clamp: self.clamp,
            firefly: self.firefly,
            restir_counts: self.restir_history | self.restir_spatial << 16,
            restir_radius: self.restir_radius,
            restir_distance: self.restir_distance,
            restir_roughness: self.restir_roughness,
        }
    }
}

/// How the surfaces that bounce rays meet are lit: as direct lighting lights those of the G-buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BounceLights {
    /// `KIND_*` bits of the light that counts.
    pub kinds: u32,
    /// How a local light is picked. Samplers that reuse samples of other pixels have none to reuse here: instead of
    /// [`LightSampler::RestirDi`] there is [`LightSampler::Ris`], instead of [`LightSampler::NeeAt`] [`LightSampler::Power`].
    pub sampler: LightSampler,
    /// How points of emissive triangles are drawn.
    pub area_sampling: AreaSampling,
    /// Of [`LightSampler::LightBvh`].
    pub bvh_importance: BvhImportance,
    /// Of [`LightSampler::Ris`].
    pub ris_source: RisSource,
    /// Of [`LightSampler::Ris`].
    pub ris_candidates: u32,
    /// Of [`LightSampler::Ris`].
    pub ris_stratified: bool,
    /// Instances that cast shadows.
    pub shadow_mask: u32,
    /// What becomes of light on its way through transmissive surfaces.
    pub glass_shadows: GlassShadows,
    /// Whether gradient pixels choose lights by the last frame's tables, which are kept then.
    pub replays: bool,
}

impl BounceLights {
    /// All kinds of light, and glass that tints it.
    pub fn all(sampler: LightSampler) -> Self {
        Self {
            kinds: KIND_SUN | KIND_POSITIONAL | KIND_EMISSIVE | KIND_ENVIRONMENT,
            sampler,
            area_sampling: AreaSampling::Spherical,
            bvh_importance: BvhImportance::SphericalGaussian,
            ris_source: RisSource::Cluster,
            ris_candidates: 8,
            ris_stratified: true,
            shadow_mask: MASK_OPAQUE,
            glass_shadows: GlassShadows::Tinted,
            replays: false,
        }
    }

    /// The sampler of the kernel.
    pub(crate) fn kernel_sampler(&self) -> LightSampler {
        match self.sampler {
            LightSampler::RestirDi => LightSampler::Ris,
            LightSampler::NeeAt => LightSampler::Power,
            sampler => sampler,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pt_core::settings::{Knobs, apply_sets};

    #[test]
    fn bounces_are_whole_or_a_half() {
        let set = |value: &str| {
            let mut params = IndirectParams::default();
            apply_sets(&mut params, &[format!("bounces={value}")]).map(|()| params)
        };
        for (value, is_half, count) in [("0", false, 0), ("0.5", true, 1), ("1", false, 1), ("16", false, 16)]
        {
            let params = set(value).unwrap();
            assert_eq!(params.is_half(), is_half, "{value}");
            assert_eq!(params.bounces.ceil() as u32, count, "{value}");
        }
        for value in ["1.5", "0.25", "2.001"] {
            let error = set(value).unwrap_err().to_string();
            assert_eq!(
                error,
                format!("bounces: {value} is out of range, expected 0.5, or a whole number of 0 to 16")
            );
        }
        for value in ["17", "-1", "nan"] {
            assert!(set(value).is_err(), "{value}");
        }
        assert!(IndirectParams::default().validate().is_ok());
    }

    /// Rays of half a bounce look for diffuse light alone: direct lighting must find all specular light then.
    #[test]
    fn what_direct_light_leaves() {
        let lights = BounceLights::all(LightSampler::Power);
        let params = |bounces| IndirectParams { bounces, ..IndirectParams::default() };
        let left = |bounces| params(bounces).left_by_direct_light(&lights);
        assert_eq!(left(0.0), EmissionShare::LightSamples);
        assert_eq!(left(0.5), EmissionShare::LightSamples);
        assert_eq!(left(1.0), EmissionShare::Mis);
        let ignored = BounceLights { glass_shadows: GlassShadows::Passed, ..lights };
        assert_eq!(params(1.0).left_by_direct_light(&ignored), EmissionShare::LightSamples);
    }
}
