// gbuffer.decomposition=planes: at its first glass a path parts into its lobes, and each of up to three planes follows one of them with probability 1.
// A mirror before that glass is passed in every plane alike. What ends before it parts, and all light met on the way there, is in plane 0 alone, so that
// the sum of the planes has every path once.
layout(constant_id = 8) const bool has_planes = false;

// Lobes are numbered as their planes.
const uint LOBE_REFLECTION = 0u, LOBE_TRANSMISSION = 1u, LOBE_DIFFUSE = 2u;

// A checkerboard flag between the passes of this stage alone: the path is on the lobe of its plane. The last pass takes it away.
const uint FLAG_PARTED = 8u;

bool is_last_pass() { return (push.mask & MASK_TRANSMISSIVE) == 0u; }

bool has_parted(uint flags) { return has_planes && (flags & FLAG_PARTED) != 0u; }

// Flags as the next pass, or the stages after this one, are to find them.
uint handed_on(uint flags, bool parted) { return has_planes && parted && !is_last_pass() ? flags | FLAG_PARTED : flags; }

float lobe_light(InterfaceLobes lobes, uint lobe) {
    if (lobe == LOBE_REFLECTION) return max_component(lobes.reflection);
    return max_component(lobe == LOBE_TRANSMISSION ? lobes.transmission : lobes.diffuse);
}

// With one lobe alone, as in total internal reflection, there is nothing to part. Which lobes a microfacet of rough glass has is chance: the mean would
// be right if that decided, but a plane would show now one lobe and now another.
bool parts_here(MaterialRecord m, InterfaceLobes lobes, bool rough) {
    if (m.transmission <= 0.0) return false;
    int count = 0;
    for (uint lobe = LOBE_REFLECTION; lobe <= LOBE_DIFFUSE; lobe++) count += lobe_light(lobes, lobe) > 0.0 ? 1 : 0;
    return rough || count > 1;
}

// The plane has no surface at this pixel, and no light but `overlay`. The stages after this one treat it as sky.
void leave_plane(ivec2 p, uint direction, uint flags, vec4 overlay) {
    store_no_surface(p);
    imageStore(ch_view_depth, p, vec4(SKY_DISTANCE));
    imageStore(ch_view_direction, p, uvec4(direction, handed_on(flags, true), 0, 0));
    imageStore(ch_throughput, p, vec4(0.0, 0.0, 0.0, log2(SKY_DISTANCE)));
    imageStore(ch_transparent, p, overlay);
}

// Where the path of a pixel has ended, on the sky or on a surface that is shaded.
void end_in_plane(ivec2 p) {
    if (!has_planes) return;
    uvec2 view = imageLoad(ch_view_direction, p).xy;
    uint flags = view.y & ~FLAG_PARTED;
    if (has_parted(view.y)) {
        if (is_last_pass()) imageStore(ch_view_direction, p, uvec4(view.x, flags, 0, 0));
    } else if (push.plane > 0u) {
        leave_plane(p, view.x, flags, vec4(0.0));
    }
}
