// deform/stamps.frag: applies a list of stamps, in order, to the codes of one map or of one tile of it.
//   reads   u_high, u_low   R16 unorm       the height code at the fragment's texel (smooth: and its neighbours)
//           u_weights       R32I            all shapes' weights, 1/65536, 4096 to a row
//           u_stamps        RGBA32UI        StampParams, seven texels each
//           u_order         R32UI           stamps by number, lists of the blocks one behind the other
//           u_stamp         ONE_STAMP only  the pass's only stamp, in place of both lists
//   writes  new_high, new_low   R16 unorm   height code, to the scratch pair
// v_payload: texel of the map minus texel of the target (x, z), first entry and length of the list in u_order.
// Each texel depends on its own old code alone, so a list of stamps gives the bits that one pass a stamp would give.
// Features: BITS16 (no low plane), PROFILES, IMAGES (what the list holds), ONLY_ADD, ONE_STAMP, and with ONE_STAMP alone:
// SMOOTH (reads neighbours), COUNT_SATURATED (fragments that do not saturate are discarded, a query counts the rest).
#include "shared/height_code.glsl"
#include "shared/stamp_math.glsl"
flat in ivec4 v_payload;
uniform sampler2D u_high, u_low;
uniform isampler2D u_weights;
uniform usamplerBuffer u_stamps, u_order;
uniform ivec2 u_origin;                   // texel of the map at texel (0, 0) of u_high and u_low
uniform ivec2 u_first_held, u_last_held;  // texels of the map that they hold, inclusive: smooth repeats the outermost
layout(location = 0) out float new_high;
#ifndef BITS16
layout(location = 1) out float new_low;
#endif

#ifdef BITS16
const bool kBits16 = true;
#else
const bool kBits16 = false;
#endif

StampParams unpacked(uvec4 a, uvec4 b, uvec4 c, uvec4 d, uvec4 e, uvec4 f, uvec4 g) {
    return StampParams(int(a.x), int(a.y), int(a.z), int(a.w), int(b.x), int(b.y), int(b.z), int(b.w), c.x, c.y, c.z, c.w,
                       d.x, d.y, d.z, d.w, e.x, e.y, e.z, e.w, int(f.x), int(f.y), int(f.z), int(f.w), int(g.x), int(g.y),
                       g.z, g.w);
}

#ifdef ONE_STAMP
uniform ivec4 u_stamp[7];
#else
StampParams stamp_at(int number) {
    int first = number * 7;
    return unpacked(texelFetch(u_stamps, first), texelFetch(u_stamps, first + 1), texelFetch(u_stamps, first + 2),
                    texelFetch(u_stamps, first + 3), texelFetch(u_stamps, first + 4), texelFetch(u_stamps, first + 5),
                    texelFetch(u_stamps, first + 6));
}
#endif

int weight_entry(int index) { return texelFetch(u_weights, ivec2(index & 4095, index >> 12), 0).r; }

int profile_weight(StampParams s, int x, int z) {
    uint distance_here = stamp_distance(s, x, z);
    if (distance_here >= s.radius) return 0;
    uint position = profile_position(s, distance_here);
    int entry = int(s.table) + profile_entry(position);
    return between_weights(weight_entry(entry), weight_entry(entry + 1), profile_fraction(position));
}

int image_weight(StampParams s, int x, int z) {
    int u = image_u(s, x, z), v = image_v(s, x, z);
    if (!image_covers(u, s.image_width, s.u_bits) || !image_covers(v, s.image_height, s.v_bits)) return 0;
    int left = image_texel(u, s.u_bits), top = image_texel(v, s.v_bits), width = int(s.image_width);
    int x0 = max(left, 0), x1 = min(left + 1, width - 1);
    int y0 = int(s.table) + max(top, 0) * width, y1 = int(s.table) + min(top + 1, int(s.image_height) - 1) * width;
    uint across = image_fraction(u, s.u_bits), down = image_fraction(v, s.v_bits);
    return between_weights(between_weights(weight_entry(y0 + x0), weight_entry(y0 + x1), across),
                           between_weights(weight_entry(y1 + x0), weight_entry(y1 + x1), across), down);
}

int stamp_weight(StampParams s, int x, int z) {
#if defined(PROFILES) && defined(IMAGES)
    if ((s.flags & STAMP_IMAGE) != 0u) return image_weight(s, x, z);
    return profile_weight(s, x, z);
#elif defined(IMAGES)
    return image_weight(s, x, z);
#else
    return profile_weight(s, x, z);
#endif
}

uint map_code(ivec2 texel) {
    texel = clamp(texel, u_first_held, u_last_held) - u_origin;
#ifdef BITS16
    return plane_bits(texelFetch(u_high, texel, 0).r) << 16;
#else
    return code_of_planes(texelFetch(u_high, texel, 0).r, texelFetch(u_low, texel, 0).r);
#endif
}

#ifdef SMOOTH
uint neighbours_mean(ivec2 texel) {
    uint high = 0u, low = 0u;
    for (int z = -1; z <= 1; ++z)
        for (int x = -1; x <= 1; ++x) {
            if (x == 0 && z == 0) continue;
            uint code = map_code(texel + ivec2(x, z));
            high += code >> 16;
            low += code & 65535u;
        }
    return mean_of_eight(high, low, kBits16);
}
#endif

Blended stamped(StampParams s, ivec2 texel, uint code) {
    uint mean = 0u;
#if defined(SMOOTH)
    uint rule = STAMP_RULE_SMOOTH;
    mean = neighbours_mean(texel);
#elif defined(ONLY_ADD)
    uint rule = STAMP_RULE_ADD;
#else
    uint rule = s.flags & STAMP_RULE_MASK;
#endif
    uint dither = kBits16 ? dither_of(s.key, texel.x, texel.y) : 0u;
    Blended result = blended(rule, kBits16, code, stamp_weight(s, texel.x, texel.y), s.amplitude,
                             (s.flags & STAMP_NEGATIVE) != 0u, s.level, mean, dither);
    if (s.residue != 0u && texel.x == s.centre_x && texel.y == s.centre_z)
        result = with_residue(result, s.residue, (s.flags & STAMP_RESIDUE_NEGATIVE) != 0u, kBits16);
    return result;
}

void main() {
    ivec2 texel = ivec2(gl_FragCoord.xy) + v_payload.xy;
    uint code = map_code(texel);
#ifdef ONE_STAMP
    StampParams s = unpacked(uvec4(u_stamp[0]), uvec4(u_stamp[1]), uvec4(u_stamp[2]), uvec4(u_stamp[3]), uvec4(u_stamp[4]),
                             uvec4(u_stamp[5]), uvec4(u_stamp[6]));
    Blended result = stamped(s, texel, code);
#ifdef COUNT_SATURATED
    if (result.saturated == 0u) discard;
#endif
    code = result.code;
#else
    for (int i = 0; i < v_payload.w; ++i) {
        StampParams s = stamp_at(int(texelFetch(u_order, v_payload.z + i).r));
        if (texel.x < s.min_x || texel.x >= s.max_x || texel.y < s.min_z || texel.y >= s.max_z) continue;
        code = stamped(s, texel, code).code;
    }
#endif
    new_high = plane_value(code >> 16);
#ifndef BITS16
    new_low = plane_value(code & 65535u);
#endif
}
