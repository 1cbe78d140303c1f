// The effects between a surface of the G-buffer and what a ray from it has met. Its specular lobes show them, whichever lobe the ray was drawn for; its
// diffuse base does not: effects light nothing and cast no shadows.
//
// Direct light passes them: that of the environment, of directional lights and of emissive triangles that light samples find, also the share of it that
// the ray finds instead (emission_share). The shadow rays of direct lighting do not see effects.
#include "channels.glsl"
#include "effects.glsl"

const EffectsSeen NO_EFFECTS = EffectsSeen(vec3(0.0), 1.0, NONE, NO_LAYER);

// From the surface of texel p. `specular`: what its specular lobes reflect of the light of that direction.
EffectsSeen first_effects(ivec2 p, vec3 direction, float reach, vec3 specular) {
    // Scenes without effects have nothing of this in their kernels.
    if (!scene_has(FEATURE_EFFECTS) || max_component(specular) <= 0.0) return NO_EFFECTS;
    return effects_along(imageLoad(ch_shading_position, p).xyz, direction, reach);
}
