// Sums over strata of light in this frame and in the history, by which antilag.glsl tells changes from noise. One thread for a pixel: a group has 5 x 5 strata
// of 3 x 3 pixels, or 3 x 3 of 5 x 5. The kernel declares `push` as TemporalPush and includes stratum.glsl.
const int GROUP_SIDE = 15;
layout(local_size_x = GROUP_SIDE, local_size_y = GROUP_SIDE) in;

// x: this frame; y: the history; z: the square of their difference; w: its variance, by the moments of the history. z is small where rare bright samples are absent
// from this frame, w where they are absent from the history: the larger of both sums is the noise. `second`: mean of squares; `share`: weight of a
// frame in the history.
vec4 sum_term(float now, float before, float second, float share) {
    float variance = max(second - before * before, 0.0) * (1.0 + share) / max(1.0 - share, 0.5);
    return vec4(now, before, (now - before) * (now - before), variance);
}

// Of a running mean over that many frames, or an exponential one.
float history_share(float frames, float alpha) { return max(1.0 / frames, alpha / (2.0 - alpha)); }

// Strata of a group along a side.
int group_strata() { return GROUP_SIDE / stratum_side; }

// Thread of the group that has pixel i of the stratum.
int thread_of(int stratum, int i) {
    ivec2 pixel = stratum_pixel(ivec2(stratum % group_strata(), stratum / group_strata()), i);
    return pixel.y * GROUP_SIDE + pixel.x;
}

// The stratum that the thread stores, if it does.
bool stores_stratum(out ivec2 stratum) {
    int own = int(gl_LocalInvocationIndex), side = group_strata();
    stratum = ivec2(gl_WorkGroupID.xy) * side + ivec2(own % side, own / side);
    return own < side * side && all(lessThan(stratum, stratum_count()));
}
