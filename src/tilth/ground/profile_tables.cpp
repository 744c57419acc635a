#include "tilth/ground/profile_tables.h"

namespace tilth {
namespace {

constexpr std::int32_t kTables[kBuiltinProfiles][kProfileEntries] = {
#include "tilth/ground/profile_tables.inc"
};

}  // namespace

std::span<const std::int32_t> profile_table(BuiltinProfile profile) {
    return kTables[static_cast<std::uint32_t>(profile)];
}

}  // namespace tilth
