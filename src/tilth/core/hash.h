// The state hash: XXH3-64 over bytes that were put into a fixed order and endianness first.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace tilth {

/// XXH3-64 of a stream of integers, fed as little-endian bytes. Not thread-safe; one stream, one thread.
class StateHasher {
public:
    StateHasher();
    ~StateHasher();
    StateHasher(StateHasher&&) noexcept;
    StateHasher& operator=(StateHasher&&) noexcept;

    void add_u32(std::span<const std::uint32_t> values);
    void add_i64(std::int64_t value);
    [[nodiscard]] std::uint64_t digest() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// XXH3-64 of `bytes`.
std::uint64_t hash_bytes(std::span<const std::byte> bytes);

/// Sixteen lower-case hexadecimal digits, as statistics and scenarios write a hash.
std::string hex16(std::uint64_t hash);

}  // namespace tilth
