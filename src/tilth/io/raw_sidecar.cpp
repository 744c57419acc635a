#include "tilth/io/raw_sidecar.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <vector>

#include "tilth/io/image_codec.h"

namespace tilth::io {
namespace {

std::string_view trimmed(std::string_view s) {
    constexpr std::string_view kBlank = " \t\r";
    const std::size_t first = s.find_first_not_of(kBlank);
    return first == std::string_view::npos ? "" : s.substr(first, s.find_last_not_of(kBlank) - first + 1);
}

bool number_of(std::string_view digits, double& value) {
    const auto [end, problem] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    return problem == std::errc{} && end == digits.data() + digits.size();
}

/// One sidecar being read: a value per line goes to `set`, and `missing` names what never came.
class SidecarReader {
public:
    explicit SidecarReader(RawKind kind) : kind_(kind) {}

    /// Empty if the pair is good, else what is wrong with it.
    std::string set(std::string_view key, std::string_view value) {
        if (std::find(seen_.begin(), seen_.end(), key) != seen_.end()) return "is given twice";
        seen_.emplace_back(key);
        if (key == "width") return side(value, sidecar_.width);
        if (key == "depth") return side(value, sidecar_.depth);
        if (key == "endian") {
            sidecar_.big_endian = value == "big";
            return value == "big" || value == "little" ? "" : quoted(value, "little or big");
        }
        if (key == "no_data") return no_data(value);
        if (kind_ == RawKind::R16 && key == "min_m") return metres(value, sidecar_.min_m);
        if (kind_ == RawKind::R16 && key == "max_m") return metres(value, sidecar_.max_m);
        return kind_ == RawKind::R16 ? "unknown key; allowed are width, depth, endian, min_m, max_m, no_data"
                                     : "unknown key; allowed for .r32f are width, depth, endian, no_data";
    }

    [[nodiscard]] const char* missing() const {
        for (const char* key : {"width", "depth", "endian", "min_m", "max_m"}) {
            if (kind_ == RawKind::R32f && key[0] == 'm') continue;
            if (std::find(seen_.begin(), seen_.end(), key) == seen_.end()) return key;
        }
        return nullptr;
    }
    [[nodiscard]] const RawSidecar& sidecar() const { return sidecar_; }

private:
    static std::string quoted(std::string_view value, const char* allowed) {
        return text("'", value, "' is not allowed; give ", allowed);
    }
    static std::string side(std::string_view value, std::int32_t& side) {
        const auto [end, problem] = std::from_chars(value.data(), value.data() + value.size(), side);
        const bool good =
            problem == std::errc{} && end == value.data() + value.size() && side >= 1 && side <= kMaxImageSide;
        return good ? "" : quoted(value, "an integer from 1 to 16384");
    }
    static std::string metres(std::string_view value, double& metres) {
        const bool good = number_of(value, metres) && std::isfinite(metres) && std::fabs(metres) <= 1e6;
        return good ? "" : quoted(value, "a number of metres from -1e6 to 1e6");
    }
    std::string no_data(std::string_view value) {
        double number = 0;
        if (!number_of(value, number)) return quoted(value, "a number as it is stored in the file, or nan");
        if (kind_ == RawKind::R16 && !(number >= 0 && number <= 65535 && number == std::floor(number)))
            return quoted(value, "an integer from 0 to 65535");
        sidecar_.no_data = number;
        return "";
    }

    RawKind kind_;
    RawSidecar sidecar_;
    std::vector<std::string> seen_;
};

}  // namespace

std::optional<RawKind> raw_kind_of(std::string_view path) {
    const auto ends_with = [&](std::string_view ending) {
        if (path.size() < ending.size()) return false;
        const std::string_view tail = path.substr(path.size() - ending.size());
        return std::equal(tail.begin(), tail.end(), ending.begin(),
                          [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == b; });
    };
    if (ends_with(".r16")) return RawKind::R16;
    if (ends_with(".r32f")) return RawKind::R32f;
    return std::nullopt;
}

std::string sidecar_path(const std::string& path) { return path + ".txt"; }

Result<RawSidecar> parse_sidecar(std::string_view content, RawKind kind, const std::string& name) {
    SidecarReader reader(kind);
    for (int number = 1; !content.empty(); ++number) {
        const std::size_t end = std::min(content.find('\n'), content.size());
        const std::string_view line = trimmed(content.substr(0, std::min(content.find('#'), end)));
        content.remove_prefix(std::min(end + 1, content.size()));
        if (line.empty()) continue;

        const std::size_t equals = line.find('=');
        if (equals == std::string_view::npos)
            return Error{ErrorCode::FileFormat,
                         text(name, ":", number, ": '", line.substr(0, 40), "' has no '='; write key = value")};
        const std::string_view key = trimmed(line.substr(0, equals));
        const std::string problem = reader.set(key, trimmed(line.substr(equals + 1)));
        if (!problem.empty()) return Error{ErrorCode::FileFormat, text(name, ":", number, ": ", key, ": ", problem)};
    }
    if (const char* key = reader.missing()) return Error{ErrorCode::FileFormat, text(name, ": ", key, ": is missing")};
    const RawSidecar& s = reader.sidecar();
    if (s.max_m < s.min_m)
        return Error{ErrorCode::FileFormat, text(name, ": max_m: ", s.max_m, " lies below min_m, ", s.min_m)};
    return s;
}

std::string sidecar_text(const RawSidecar& sidecar, RawKind kind) {
    std::string out = text("width = ", sidecar.width, "\ndepth = ", sidecar.depth,
                           "\nendian = ", sidecar.big_endian ? "big" : "little", "\n");
    if (kind == RawKind::R16) out += text("min_m = ", sidecar.min_m, "\nmax_m = ", sidecar.max_m, "\n");
    if (sidecar.no_data) out += text("no_data = ", *sidecar.no_data, "\n");
    return out;
}

}  // namespace tilth::io
