// Sums over strata of 3 x 3 pixels of light in this frame and in the history, by which antilag.glsl tells changes from noise. One thread for a pixel: a
// group has 8 x 3 strata. The kernel declares `push` as TemporalPush.
layout(local_size_x = 24, local_size_y = 9) in;

// x: this frame; y: the history; z: the square of their difference; w: its variance, by the moments of the history. z is small where rare bright samples are absent
// from this frame, w where they are absent from the history: the larger of both sums is the noise. `second`: mean of squares; `share`: weight of a
// frame in the history.
vec4 sum_term(float now, float before, float second, float share) {
    float variance = max(second - before * before, 0.0) * (1.0 + share) / max(1.0 - share, 0.5);
    return vec4(now, before, (now - before) * (now - before), variance);
}

// Of a running mean over that many frames, or an exponential one.
float history_share(float frames, float alpha) { return max(1.0 / frames, alpha / (2.0 - alpha)); }

// Thread of the group that has pixel i of the stratum.
uint thread_of(uint stratum, int i) { return (stratum / 8u * 3u + uint(i / 3)) * 24u + stratum % 8u * 3u + uint(i % 3); }

// The stratum that the thread stores, if it does.
bool stores_stratum(out ivec2 stratum) {
    uint own = gl_LocalInvocationIndex;
    stratum = ivec2(gl_WorkGroupID.xy) * ivec2(8, 3) + ivec2(own % 8u, own / 8u);
    return own < 24u && all(lessThan(stratum, (ivec2(push.size) + 2) / 3));
}
