// Integers and doubles at fixed places of a byte buffer, little-endian: how headers and entries are laid out.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

#include "tilth/core/checks.h"

namespace tilth {

static_assert(std::endian::native == std::endian::little, "files are little-endian, and so must memory be");

template <class T>
void put_field(std::span<std::byte> bytes, std::size_t at, T value) {
    static_assert(std::is_arithmetic_v<T>);
    TILTH_ASSERT(at <= bytes.size() && sizeof value <= bytes.size() - at, "a field outside its buffer");
    std::memcpy(bytes.data() + at, &value, sizeof value);
}

template <class T>
[[nodiscard]] T get_field(std::span<const std::byte> bytes, std::size_t at) {
    static_assert(std::is_arithmetic_v<T>);
    T value{};
    TILTH_ASSERT(at <= bytes.size() && sizeof value <= bytes.size() - at, "a field outside its buffer");
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}

/// Eight characters as the number whose little-endian bytes they are: what a file begins with.
constexpr std::uint64_t magic_of(const char (&eight)[9]) {
    std::uint64_t magic = 0;
    for (int i = 7; i >= 0; --i) magic = magic << 8 | static_cast<unsigned char>(eight[i]);
    return magic;
}

}  // namespace tilth
