/// What rays find at a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shows {
    /// The surface.
    #[default]
    Itself,
    /// The environment and the discs of directional lights, as where there is no surface: rays to infinity end there, and what is behind the
    /// surface is not seen. Light that comes from infinity passes; other light is stopped.
    Environment,
    /// What the camera of this index in [`crate::Scene::cameras`] sees, across the first texture coordinates from 0 to 1, in 16:9, through
    /// a pinhole. Seen by the camera, in mirrors and through smooth glass; for light that bounces the surface is what its other values say.
    Camera(u32),
}
