// What the fuzz targets share: the fuzzer's bytes taken as numbers and pieces, and checks that count as findings.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace tilth::fuzz {

using Bytes = std::vector<std::byte>;

/// A finding where it does not hold: the fuzzer keeps the input that led here.
inline void check(bool holds, std::string_view what) {
    if (holds) return;
    std::fprintf(stderr, "broken: %.*s\n", static_cast<int>(what.size()), what.data());
    std::abort();
}

/// Takes numbers and pieces off the front. Behind the end everything is zero, and pieces are empty.
class Input {
public:
    Input(const std::uint8_t* data, std::size_t size) : rest_(std::as_bytes(std::span(data, size))) {}

    template <class T>
    T number() {
        static_assert(std::is_integral_v<T>);
        T value = 0;
        const std::span<const std::byte> found = piece(sizeof value);
        if (!found.empty()) std::memcpy(&value, found.data(), found.size());
        return value;
    }
    std::uint8_t byte() { return number<std::uint8_t>(); }
    bool flag() { return (byte() & 1) != 0; }
    /// 0..bound - 1, bound up to 65 536.
    std::size_t below(std::size_t bound) { return (bound <= 256 ? byte() : number<std::uint16_t>()) % bound; }
    /// Small ones, large ones and those at the edges.
    std::uint64_t any_number() {
        const std::uint8_t how = byte();
        switch (how % 4) {
            case 0:
                return number<std::uint64_t>();
            case 1:
                return std::uint64_t{1} << (how / 4);
            case 2:
                return ~std::uint64_t{0} - byte();
            default:
                return how / 4;
        }
    }
    /// At most so many bytes: fewer only at the end.
    std::span<const std::byte> piece(std::size_t most) {
        const std::span<const std::byte> found = rest_.first(std::min(most, rest_.size()));
        rest_ = rest_.subspan(found.size());
        return found;
    }
    std::span<const std::byte> rest() { return piece(rest_.size()); }
    [[nodiscard]] bool empty() const { return rest_.empty(); }

private:
    std::span<const std::byte> rest_;
};

inline Bytes copy_of(std::span<const std::byte> bytes) { return {bytes.begin(), bytes.end()}; }
inline std::string_view text_of(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}
inline void append(Bytes& to, std::span<const std::byte> bytes) { to.insert(to.end(), bytes.begin(), bytes.end()); }

/// `most` bytes, the fuzzer's `pattern` over and over, changed a little with every turn.
inline Bytes repeated(std::span<const std::byte> pattern, std::size_t size) {
    Bytes bytes(size);
    for (std::size_t i = 0; i < size && !pattern.empty(); ++i)
        bytes[i] = pattern[i % pattern.size()] ^ static_cast<std::byte>(i / pattern.size());
    return bytes;
}

/// Up to 15 of them: a byte is changed, or the end cut off.
inline void damage(Bytes& bytes, Input& input) {
    for (std::size_t times = input.below(16); times > 0; --times) {
        const std::size_t at = input.number<std::uint32_t>();
        const std::uint8_t with = input.byte();
        if (bytes.empty()) return;
        if (with == 0)
            bytes.resize(at % bytes.size());
        else
            bytes[at % bytes.size()] ^= static_cast<std::byte>(with);
    }
}

}  // namespace tilth::fuzz
