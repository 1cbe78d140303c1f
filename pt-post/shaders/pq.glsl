// PQ, SMPTE ST 2084: luminance over 10000 cd/m2 to code and back, both 0..1.

const float PQ_M1 = 2610.0 / 16384.0;
const float PQ_M2 = 2523.0 / 32.0;
const float PQ_C1 = 107.0 / 128.0;
const float PQ_C2 = 2413.0 / 128.0;
const float PQ_C3 = 2392.0 / 128.0;

vec3 pq_encode(vec3 luminance) {
    vec3 p = pow(luminance, vec3(PQ_M1));
    return pow((PQ_C1 + PQ_C2 * p) / (1.0 + PQ_C3 * p), vec3(PQ_M2));
}

vec3 pq_decode(vec3 code) {
    vec3 p = pow(code, vec3(1.0 / PQ_M2));
    return pow(max(p - PQ_C1, 0.0) / (PQ_C2 - PQ_C3 * p), vec3(1.0 / PQ_M1));
}
