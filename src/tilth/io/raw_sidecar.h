// The text file beside a .r16 or .r32f file that says what the raw bytes mean. Format: RAW_SIDECAR.md.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "tilth/core/result.h"

namespace tilth::io {

enum class RawKind { R16, R32f };

/// What a sidecar says.
struct RawSidecar {
    std::int32_t width = 0, depth = 0;  ///< heights along +x and +z, 1 to 16 384
    bool big_endian = false;
    double min_m = 0, max_m = 0;    ///< r16 only: heights of the values 0 and 65 535, metres
    std::optional<double> no_data;  ///< as stored; may be NaN for r32f
};

/// The kind that the ending of `path` names (.r16, .r32f, in any case), or nothing.
std::optional<RawKind> raw_kind_of(std::string_view path);

/// Name of the sidecar of the raw file `path`: ".txt" appended.
std::string sidecar_path(const std::string& path);

/// Reads `content`; `name` is the sidecar's, and opens every message together with the line and key.
/// Fails with `FileFormat`: unknown, missing or repeated key, value of the wrong form or out of range.
Result<RawSidecar> parse_sidecar(std::string_view content, RawKind kind, const std::string& name);

/// The text that `parse_sidecar` reads back to an equal value (numbers have 17 digits).
std::string sidecar_text(const RawSidecar& sidecar, RawKind kind);

}  // namespace tilth::io
