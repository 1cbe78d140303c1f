// The shading normal `n`, bent as little as needed for wo to be reflected above the triangle: Keller et al. 2017, "The Iray Light
// Transport Simulation and Rendering System", app. A.3. Host twin: pt_reference::oracle::bsdf.
vec3 bend_normal(vec3 n, vec3 face_normal, vec3 wo) {
    const float ABOVE = 1e-3;
    if (dot(n, face_normal) <= 0.0) n = face_normal;
    vec3 mirrored = reflect(-wo, n);
    float height = dot(mirrored, face_normal);
    if (height >= ABOVE && dot(n, wo) > 0.0) return n;
    vec3 lifted = mirrored + face_normal * (ABOVE - height);
    vec3 h = wo + normalize(lifted);
    // Both at the horizon and opposite: the triangle's own normal.
    return dot(h, h) > 1e-6 && dot(h, wo) > 0.0 ? normalize(h) : face_normal;
}
