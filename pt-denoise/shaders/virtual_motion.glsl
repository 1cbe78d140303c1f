// Where the mirror image that a glossy surface shows was in the last frame. The image of a point at a distance h behind the mirror moves as a point h behind the
// surface (Stachowiak 2015, "Stochastic Screen-Space Reflections"; Zhdanov 2021, "ReBLUR: A Hierarchical Recurrent Denoiser", Ray Tracing Gems II, chapter 49). The
// lobe of a rough surface shows it nearer: Lagarde and de Rousiers 2014, "Moving Frostbite to Physically Based Rendering", section 4.9.3.
#include "camera.glsl"
#include "constants.glsl"
#include "frame.glsl"

// Farther is infinitely far.
const float FARTHEST_HIT = 1e6;
// Greatest difference of hit distances along with the distance of the surface, of one image.
const float HIT_TOLERANCE = 0.1;

float dominant_share(float roughness) {
    float alpha = roughness * roughness, smoothness = clamp(1.0 - alpha, 0.0, 1.0);
    return smoothness * (sqrt(smoothness) + alpha);
}

// xy: how much farther than its surface the image has moved since, pixels; 0 where there is no image.
vec2 image_parallax(ivec2 at, uint flags, float hit, float roughness) {
    if (flags != FLAG_PRIMARY || !(hit > 0.0) || frame.camera.projection != 0u) return vec2(0.0);
    vec3 position = imageLoad(ch_shading_position, at).xyz, eye = frame.camera.world_from_view[3].xyz;
    vec3 image = position + normalize(position - eye) * (min(hit, FARTHEST_HIT) * dominant_share(roughness));
    vec2 moved = (project(frame.camera_prev, image).xy - project(frame.camera_prev, position).xy) * vec2(push.size);
    return is_finite(vec3(moved, 0.0)) && all(lessThan(abs(moved), vec2(1e5))) ? moved : vec2(0.0);
}

// The surface at the place where the image was: the slope of the surface explains a difference in distance over the way.
Reprojection reproject_image(Reprojection surface, ivec2 at, vec2 parallax) {
    surface.place += parallax;
    surface.tolerance += length(parallax) / max(imageLoad(ch_motion, at).w, 1e-18);
    return surface;
}

// Part of a specular history that the turn of the reflection makes worthless, where history follows the surface.
float turned_away(float parallax, float pixel_angle, float roughness) {
    float lobe = push.parallax * max(roughness * roughness, 1e-4);
    return push.parallax > 0.0 ? clamp(parallax * pixel_angle / lobe, 0.0, 1.0) : 0.0;
}
