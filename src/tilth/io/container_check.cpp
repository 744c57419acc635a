#include "tilth/io/container_check.h"

#include <string_view>

#include "tilth/core/result.h"

namespace tilth::io {
namespace {

/// Takes numbers and names off the front of a file; what the file does not hold clears `good`.
class Cursor {
public:
    explicit Cursor(std::span<const std::byte> file) : rest_(file) {}

    [[nodiscard]] std::size_t left() const { return rest_.size(); }
    [[nodiscard]] bool good() const { return good_; }

    void skip(std::size_t bytes) {
        good_ = good_ && bytes <= rest_.size();
        rest_ = rest_.subspan(good_ ? bytes : rest_.size());
    }
    std::uint32_t u32_big() {
        std::uint32_t value = 0;
        for (int i = 0; i < 4; ++i) value = value << 8 | byte();
        return value;
    }
    std::uint32_t u32_little() {
        std::uint32_t value = 0;
        for (int i = 0; i < 4; ++i) value |= byte() << (8 * i);
        return value;
    }
    std::string name() {  // up to and without its closing zero
        std::string name;
        for (std::uint32_t c = byte(); c != 0 && good_; c = byte()) name += static_cast<char>(c);
        return name;
    }

private:
    std::uint32_t byte() {
        const std::uint32_t value = rest_.empty() ? 0 : std::to_integer<std::uint32_t>(rest_.front());
        skip(1);
        return value;
    }

    std::span<const std::byte> rest_;
    bool good_ = true;
};

// Signature (8 bytes), then chunks: length 4, kind 4, data, checksum 4, all big-endian.
std::optional<std::string> wrong_png(Cursor at) {
    at.skip(8);
    while (at.left() != 0) {
        const std::uint64_t length = at.u32_big();
        const bool last = at.u32_big() == 0x49454e44;  // "IEND"; what follows it is nobody's
        if (length + 4 > at.left())
            return text("damaged or truncated: a chunk of ", length, " bytes where ", at.left(), " are left");
        if (last) return std::nullopt;
        at.skip(length + 4);
    }
    return "truncated: its closing chunk is missing";
}

// Magic 4, version 4, then attributes: name, zero, type, zero, size 4, value; an empty name ends a header. With several
// parts (flag 0x1000), an empty header ends the headers.
std::optional<std::string> wrong_exr(Cursor at, std::int64_t max_side) {
    at.skip(4);
    const bool several_parts = (at.u32_little() & 0x1000) != 0;
    bool header_is_empty = true;
    while (at.good()) {
        const std::string name = at.name();
        if (name.empty() && at.good()) {
            if (!several_parts || header_is_empty) return std::nullopt;
            header_is_empty = true;
            continue;
        }
        header_is_empty = false;
        const std::string type = at.name();
        const std::uint64_t size = at.u32_little();
        if (size > at.left())
            return text("damaged or truncated: an attribute of ", size, " bytes where ", at.left(), " are left");
        if (name == "dataWindow" && size == 16) {
            Cursor window = at;
            const std::int64_t x0 = static_cast<std::int32_t>(window.u32_little()),
                               y0 = static_cast<std::int32_t>(window.u32_little()),
                               x1 = static_cast<std::int32_t>(window.u32_little()),
                               y1 = static_cast<std::int32_t>(window.u32_little());
            if (x1 - x0 >= max_side || y1 - y0 >= max_side || x1 < x0 || y1 < y0)
                return text(x1 - x0 + 1, " x ", y1 - y0 + 1, " texels: 1 to ", max_side, " a side are allowed");
        }
        at.skip(size);
    }
    return "truncated header";
}

}  // namespace

std::optional<std::string> wrong_length(std::span<const std::byte> file, std::int64_t max_side) {
    using namespace std::string_view_literals;
    const std::string_view bytes(reinterpret_cast<const char*>(file.data()), file.size());
    if (bytes.starts_with("\x89PNG\r\n\x1a\n"sv)) return wrong_png(Cursor(file));
    if (bytes.starts_with("\x76\x2f\x31\x01"sv)) return wrong_exr(Cursor(file), max_side);
    return std::nullopt;
}

}  // namespace tilth::io
