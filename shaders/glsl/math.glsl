// Constants and small functions without a paper of their own.

const float PI = 3.14159265358979323846;
const float INV_PI = 0.31830988618379067154;

float square(float x) { return x * x; }

float max_component(vec3 v) { return max(v.x, max(v.y, v.z)); }
float min_component(vec3 v) { return min(v.x, min(v.y, v.z)); }

// Rec. 709 luminance of linear RGB.
float luminance(vec3 c) { return dot(c, vec3(0.2126, 0.7152, 0.0722)); }

// Orthonormal basis around a unit vector, without branches: Duff et al. 2017, "Building an Orthonormal Basis, Revisited".
mat3 basis_around(vec3 n) {
    float s = n.z >= 0.0 ? 1.0 : -1.0;
    float a = -1.0 / (s + n.z);
    float b = n.x * n.y * a;
    return mat3(vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x), vec3(b, s + n.y * n.y * a, -n.y), n);
}

vec3 transform_point(vec4 rows[3], vec3 p) {
    vec4 h = vec4(p, 1.0);
    return vec3(dot(rows[0], h), dot(rows[1], h), dot(rows[2], h));
}

vec3 transform_vector(vec4 rows[3], vec3 v) {
    return vec3(dot(rows[0].xyz, v), dot(rows[1].xyz, v), dot(rows[2].xyz, v));
}

// Transposed 3x3 part: takes normals to the space that `rows` is the inverse of.
vec3 transform_transposed(vec4 rows[3], vec3 v) {
    return rows[0].xyz * v.x + rows[1].xyz * v.y + rows[2].xyz * v.z;
}
