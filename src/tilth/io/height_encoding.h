// How an integer image says in its description which height a value stands for.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "tilth/core/result.h"

namespace tilth::io {

/// height [m] = value * scale_m + offset_m.
struct HeightEncoding {
    double scale_m = 1;
    double offset_m = 0;
    friend bool operator==(const HeightEncoding&, const HeightEncoding&) = default;
};

/// "tilth: scale=... offset=...", 17 digits: reads back to the same bits.
std::string encoding_text(const HeightEncoding& encoding);

/// Finds the encoding in an image's description. Nothing if it does not start with "tilth:" or has neither word; one
/// word alone leaves the other at its default. Other words are ignored.
/// Fails with `FileFormat` if a value is no finite number, or scale is 0.
Result<std::optional<HeightEncoding>> encoding_in(std::string_view description, const std::string& name);

}  // namespace tilth::io
