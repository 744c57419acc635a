#include "tilth/core/hash.h"

#define XXH_INLINE_ALL  // no global XXH symbol leaves the library
#include <xxhash.h>

#include <array>
#include <bit>

#include "tilth/core/checks.h"

namespace tilth {

static_assert(std::endian::native == std::endian::little, "hashing relies on little-endian memory");

struct StateHasher::State {
    XXH3_state_t* xxh = XXH3_createState();
    State() {
        TILTH_ASSERT(xxh != nullptr, "no memory for a hash state");
        XXH3_64bits_reset(xxh);
    }
    ~State() { XXH3_freeState(xxh); }
    State(const State&) = delete;
    State& operator=(const State&) = delete;
};

StateHasher::StateHasher() : state_(std::make_unique<State>()) {}
StateHasher::~StateHasher() = default;
StateHasher::StateHasher(StateHasher&&) noexcept = default;
StateHasher& StateHasher::operator=(StateHasher&&) noexcept = default;

void StateHasher::add_u32(std::span<const std::uint32_t> values) {
    XXH3_64bits_update(state_->xxh, values.data(), values.size_bytes());
}

void StateHasher::add_i64(std::int64_t value) { XXH3_64bits_update(state_->xxh, &value, sizeof value); }

std::uint64_t StateHasher::digest() const { return XXH3_64bits_digest(state_->xxh); }

std::uint64_t hash_bytes(std::span<const std::byte> bytes) { return XXH3_64bits(bytes.data(), bytes.size()); }

std::string hex16(std::uint64_t hash) {
    std::array<char, 16> digits{};
    for (std::size_t i = 0; i < digits.size(); ++i) digits[i] = "0123456789abcdef"[(hash >> (60 - 4 * i)) & 15];
    return {digits.data(), digits.size()};
}

}  // namespace tilth
