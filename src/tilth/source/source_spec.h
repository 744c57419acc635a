// Procedural heights written down as one line of text, as scenarios and the command line name them.
#pragma once

#include <string_view>

#include "tilth/source/height_source.h"

namespace tilth {

/// Posts along a side that a specification may ask for. 16 384 x 16 384 floats are 1 GiB.
inline constexpr std::int32_t kMinSpecSize = 2;
inline constexpr std::int32_t kMaxSpecSize = 16384;

/// True if `spec` reads "word:...", that is, names a kind of procedural heights (known or not); anything else is a
/// path. The word has lower-case letters only and at least two, so "C:\map.tif" and "./a:b" are paths.
bool is_procedural(std::string_view spec);

/// Makes the heights that `spec` describes:
///
///     ridged:seed=7,size=1025,relief=200    `make_ridged_source`; seed 1, size 1025, relief 200 m unless given
///     flat:size=1025,height=10              `FlatSource`;         size 1025, height 0 m unless given
///     hill:size=513,peak=4,sigma=20         `HillSource`;         size 513, peak 4 m, sigma 20 posts unless given
///
/// size: 2 to 16384 posts; seed: 0 to 2^64 - 1; relief: above 0 m; sigma: above 0 posts; heights within +-1e6 m.
/// Fails with `InvalidArgument`; the message quotes the specification and names the key and what is allowed.
Result<std::unique_ptr<HeightSource>> make_source(std::string_view spec);

}  // namespace tilth
