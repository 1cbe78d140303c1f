//! The dimensions of the random numbers that the frame's stages draw.
//!
//! A number is a pure function of (pixel, frame, dimension, seed). Every decision that draws has a dimension of its own, so that
//! no two of them see the same numbers. The table generates the GLSL constants (`dimensions.glsl`).

/// A decision that draws random numbers, or several of one kind that follow each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dimension {
    /// Name in Rust and GLSL.
    pub name: &'static str,
    /// The first decision's dimension.
    pub first: u32,
    /// How many decisions there are; number i draws from `first + i`.
    pub count: u32,
    /// What the four numbers decide.
    pub numbers: &'static str,
}

/// How many reflections and refractions of a frame have a dimension.
pub const MAX_REFLECT_REFRACT: u32 = 10;

/// Most candidates of resampled importance sampling.
pub const MAX_RIS_CANDIDATES: u32 = 16;

/// Most neighbours of spatiotemporal resampling.
pub const MAX_RESTIR_NEIGHBOURS: u32 = 8;

/// Most steps of a march through the medium.
pub const MAX_GODRAYS_STEPS: u32 = 64;

/// Most surfaces that a photon meets.
pub const MAX_CAUSTIC_SEGMENTS: u32 = 16;

/// Most bounces of a path of indirect light.
pub const MAX_BOUNCES: u32 = 16;

/// Dimensions of a vertex of such a path; `bounce_random.glsl` of pt-indirect says which is which.
pub const BOUNCE_DIMENSIONS: u32 = 8 + MAX_RIS_CANDIDATES;

/// Dimensions of the stochastic texture filter: surfaces of instances whose numbers differ modulo it draw independent numbers.
pub const TEXTURE_DIMENSIONS: u32 = 64;

macro_rules! dimensions {
    ($($name:ident: $first:literal, $count:expr, $numbers:literal;)*) => {
        $(#[doc = $numbers] pub const $name: u32 = $first;)*
        /// The table itself.
        pub const DIMENSIONS: &[Dimension] = &[$(Dimension {
            name: stringify!($name), first: $first, count: $count, numbers: $numbers,
        }),*];
    };
}

dimensions! {
    DIM_PIXEL: 0, 1, "x, y: position in the pixel; z, w: position on the lens.";
    DIM_SUN: 1, 1, "A directional light. x: which one; z, w: point on its disc.";
    DIM_POSITIONAL: 2, 1, "A point or spot light. x: which one; z, w: point on its sphere.";
    DIM_EMISSIVE: 3, 1, "An emissive triangle. x, y: which one (alias table); z, w: point on it.";
    DIM_ENVIRONMENT: 4, 1, "A direction of the environment. x, y: which texel (alias table); z, w: point in it.";
    DIM_REFLECTION: 5, 1, "The ray of a narrow lobe to the environment. x, y: direction in the lobe; z: which lobe; w: reflection or transmission.";
    DIM_LIGHT: 6, 1, "A local light. x: which part of the list; y: which one of it; z, w: point on it.";
    DIM_LIGHT_BY_POWER: 7, 1, "A local light by its power. x, y: which one (alias table).";
    DIM_RIS: 8, MAX_RIS_CANDIDATES, "Candidate i of resampled importance sampling. x, y: which light; z, w: point on it.";
    DIM_RESTIR: 24, 1, "Choices of spatiotemporal resampling. x: of a candidate; y: of now or the past; z: of a neighbour.";
    DIM_RESTIR_NEIGHBOURS: 25, MAX_RESTIR_NEIGHBOURS / 2, "Places of the neighbours 2 i (x, y) and 2 i + 1 (z, w) of spatiotemporal resampling.";
    DIM_NEE_AT: 29, 1, "The proxies of a tile (nee-at). x: which feedback; y: which proxies of the last frame; z, w: a light by its power.";
    DIM_NEE_AT_FEEDBACK: 30, 1, "The light that a pixel keeps as feedback (nee-at). x: whether the new one replaces the old one.";
    DIM_PORTAL: 31, 1, "A direction of the environment through a portal. x: whether, and which portal; y, z: point of it.";
    DIM_REFLECT_REFRACT: 32, MAX_REFLECT_REFRACT, "Reflection or refraction number i of a frame. x: which lobe; y, z: microfacet normal; w: which kind of punctual light.";
    DIM_HIGHLIGHT: 42, MAX_REFLECT_REFRACT, "The punctual light whose highlight rough glass number i shows. x: which one; z, w: point of it.";
    DIM_LIGHT_STORAGE: 60, 2, "Rounding of stored light, 60: diffuse, 61: specular. x, y, z: red, green, blue.";
    DIM_GRADIENT: 62, 1, "The gradient pixel of a stratum. x: which pixel.";
    DIM_COSINE: 63, 1, "A direction of the environment by the cosine. x: whether; y, z: direction.";
    DIM_REUSE: 64, 1, "Choices of the reuse of bounces. x: of now or the past; y: of a neighbour.";
    DIM_REUSE_NEIGHBOURS: 65, MAX_RESTIR_NEIGHBOURS / 2, "Places of the neighbours 2 i (x, y) and 2 i + 1 (z, w) of the reuse of bounces.";
    DIM_INDIRECT: 128, (MAX_BOUNCES + 1) * BOUNCE_DIMENSIONS, "Vertex i of a path of indirect light, from 128 + 24 i on: direction; choices; light; light by power; shadow ray; texture filter; 8 and on: candidates.";
    DIM_GODRAYS: 536, MAX_GODRAYS_STEPS, "Step i of a march through the medium. x: which directional light; y: where in the step; z, w: point on the light's disc.";
    DIM_CAUSTICS: 600, MAX_CAUSTIC_SEGMENTS + 1, "A photon, 600: x: which directional light; y: which target; z, w: point on the light's disc; 601 + i: its surface i. x: which lobe; y: reflection or transmission; z: which colour, where they part; w: rounding.";
    DIM_CAUSTIC_PLACE: 617, 1, "x, y: where in a cell of photons a pixel looks.";
    DIM_HISTORIES: 618, 7, "Rounding of histories in half floats, 618: diffuse light; 619: specular light; 620: moments; 621, 622: indirect diffuse light; 623, 624: diffuse and specular light that was filtered afterwards. A number for each component.";
    DIM_TEXTURE: 640, TEXTURE_DIMENSIONS, "Stochastic texture filter at a surface of instance i, from 640 + i modulo 64. x, y: texel; z: mip level; w: place along the footprint.";
    DIM_COVERAGE: 1024, 1024, "The BLEND surfaces that a ray meets: the ray of the decision with dimension i draws from 1024 + i.";
}

/// The entry of a dimension; `None` when no decision draws from it.
pub fn dimension(number: u32) -> Option<&'static Dimension> {
    DIMENSIONS.iter().find(|d| (d.first..d.first + d.count).contains(&number))
}

/// GLSL constants (`dimensions.glsl`).
pub fn glsl() -> String {
    let first = DIMENSIONS.iter().map(|d| format!("const uint {} = {}u;\n", d.name, d.first));
    let counts = [
        ("BOUNCE_DIMENSIONS", BOUNCE_DIMENSIONS),
        ("MAX_CAUSTIC_SEGMENTS", MAX_CAUSTIC_SEGMENTS),
        ("TEXTURE_DIMENSIONS", TEXTURE_DIMENSIONS),
    ];
    first.chain(counts.map(|(name, count)| format!("const uint {name} = {count}u;\n"))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_decisions_share_a_dimension() {
        let mut numbers: Vec<u32> = DIMENSIONS.iter().flat_map(|d| d.first..d.first + d.count).collect();
        let count = numbers.len();
        numbers.sort_unstable();
        numbers.dedup();
        assert_eq!(numbers.len(), count);
        let name = |number| dimension(number).map(|d| d.name);
        let end = DIM_REFLECT_REFRACT + MAX_REFLECT_REFRACT;
        assert_eq!(name(end - 1), Some("DIM_REFLECT_REFRACT"));
        assert_eq!(name(end), Some("DIM_HIGHLIGHT"));
        assert_eq!(name(DIM_HIGHLIGHT + MAX_REFLECT_REFRACT), None);
    }

    /// The rays of all decisions have a coverage dimension.
    #[test]
    fn coverage_dimensions_suffice() {
        let coverage = dimension(DIM_COVERAGE).unwrap();
        for decision in DIMENSIONS.iter().filter(|d| d.name != coverage.name) {
            assert!(decision.first + decision.count <= coverage.count, "{decision:?}");
        }
    }
}
