// Lengths of the histories in a pixel of im_surface, frames: of both channels in the lower half of y; the upper half is 0 or that of specular light, where
// it follows mirror images and has a length of its own.
const uint NO_SPECULAR_HISTORY = 0xffffu;

uint history_frames(uint word) { return word & 0xffffu; }

uint specular_frames(uint word) {
    uint own = word >> 16u;
    return own == 0u ? word & 0xffffu : own == NO_SPECULAR_HISTORY ? 0u : own;
}

// x: of diffuse, y: of specular light.
uint history_word(uvec2 frames) {
    if (frames.x == frames.y) return frames.x;
    return frames.x | (frames.y == 0u ? NO_SPECULAR_HISTORY : frames.y) << 16u;
}

// Length of a history that is left: n (1 - a)^10, rounded down.
uint kept_frames(uint frames, float lag) {
    float kept = 1.0 - lag, second = kept * kept, fourth = second * second;
    return uint(float(frames) * (fourth * fourth * second));
}
