// What shadow rays do with glass: the knob `lights.glass_shadows`.
#include "scene.glsl"

// Whether they look for glass, which tints their light: scenes without any have no code for it.
bool glass_tints(uint glass_shadows) {
    return scene_has(FEATURE_TRANSMISSION) && (glass_shadows == GLASS_SHADOWS_TINTED || glass_shadows == GLASS_SHADOWS_STRAIGHT);
}
