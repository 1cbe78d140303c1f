struct Interior { uint count; };
Interior interior_empty() { return Interior(0u); }
vec3 interior_transmittance(Interior i, float t) { return vec3(1.0); }
