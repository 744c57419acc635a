// shared/stamp_params.glsl: one stamp, ready for its map. Compiled as GLSL and as C++.
// 28 words = seven RGBA32UI texels of the stamp list; the C++ side copies the struct as it stands.
#ifndef TILTH_SHARED_STAMP_PARAMS
#define TILTH_SHARED_STAMP_PARAMS
struct StampParams {
    int min_x, min_z, max_x, max_z;     // texels of the map that it may change: half-open, clipped to the map
    int centre_x, centre_z;             // texel nearest to the centre
    int offset_x, offset_z;             // centre minus that texel, 1/1024 texel, -512..511
    uint radius;                        // 1/1024 texel, 1..2^23, widened to the shape's least radius
    uint radius_reciprocal;             // floor((2^63 - 1) / (radius << radius_shift))
    uint radius_shift;                  // leading zeros of radius
    uint amplitude;                     // magnitude in codes; for smooth in 1/65536
    uint flags;                         // STAMP_* below
    uint level;                         // code
    uint key;                           // of the 16-bit dither
    uint residue;                       // magnitude in codes, added at the centre texel (zero-volume profiles)
    uint table;                         // GPU only: first weight of the shape in the weight texture
    uint image_width, image_height;     // texels
    uint u_bits;                        // fraction bits of image positions along the image's x axis,
    int u_centre, v_centre;             // image position of the centre texel
    int u_per_x, u_per_z;               // image position's step per texel of the map
    int v_per_x, v_per_z;
    uint v_bits;                        // and along its y axis
    uint unused;
};
#define STAMP_RULE_MASK 7u
#define STAMP_RULE_ADD 0u
#define STAMP_RULE_MIN 1u
#define STAMP_RULE_MAX 2u
#define STAMP_RULE_SET 3u
#define STAMP_RULE_SMOOTH 4u
#define STAMP_IMAGE 8u             // an image, else a radial profile
#define STAMP_NEGATIVE 16u         // the amplitude is below zero
#define STAMP_BITS16 32u           // the map keeps the high plane only
#define STAMP_RESIDUE_NEGATIVE 64u // the residue is below zero
#endif
