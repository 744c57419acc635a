#include "tilth/io/height_encoding.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace tilth::io {
namespace {

constexpr std::string_view kMark = "tilth:";

/// True if `word` is "key=..."; then `value` is what follows, or NaN if that is no number.
bool value_of(std::string_view word, std::string_view key, double& value) {
    if (!word.starts_with(key)) return false;
    const std::string_view digits = word.substr(key.size());
    const auto [end, problem] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (problem != std::errc{} || end != digits.data() + digits.size()) value = std::nan("");
    return true;
}

}  // namespace

std::string encoding_text(const HeightEncoding& encoding) {
    return text(kMark, " scale=", encoding.scale_m, " offset=", encoding.offset_m);
}

Result<std::optional<HeightEncoding>> encoding_in(std::string_view description, const std::string& name) {
    if (!description.starts_with(kMark)) return std::optional<HeightEncoding>{};
    const std::string_view whole = description;
    description.remove_prefix(kMark.size());
    HeightEncoding encoding;
    bool found = false;
    while (!description.empty()) {
        const std::size_t blank = std::min(description.find_first_of(" \n"), description.size());
        const std::string_view word = description.substr(0, blank);
        description.remove_prefix(std::min(blank + 1, description.size()));
        if (value_of(word, "scale=", encoding.scale_m) || value_of(word, "offset=", encoding.offset_m)) found = true;
    }
    if (!std::isfinite(encoding.scale_m) || encoding.scale_m == 0 || !std::isfinite(encoding.offset_m))
        return Error{ErrorCode::FileFormat,
                     text(name, ": description \"", whole.substr(0, 100),
                          "\": scale must be a finite number other than 0, offset a finite number")};
    return found ? std::optional(encoding) : std::nullopt;
}

}  // namespace tilth::io
