// The cluster of a world position. Comparisons only, so that the host's twin (pt-scene, Clusters::find) gives the same to the bit.
#include "scene.glsl"

uint cluster_of(vec3 position) {
    ClusterTable nodes = ClusterTable(scene.clusters);
    ClusterNode node = nodes.at[0];
    while ((node.link & 3u) != 3u) {
        bool below = position[node.link & 3u] < node.split;
        node = nodes.at[(node.link >> 2) + (below ? 0u : 1u)];
    }
    return node.link >> 2;
}
