// What a world on disk is a world of: fixed when it is made, checked when it is opened.
#pragma once

#include <cstdint>
#include <string>

#include "tilth/core/result.h"
#include "tilth/ground/ground.h"
#include "tilth/store/file_system.h"

namespace tilth {

struct WorldIdentity {
    GroundSettings settings;            ///< `quantum_m` settled
    std::int32_t width = 0, depth = 0;  ///< of the height source, posts
    double middle_m = 0;                ///< height of the middle code: the codes alone do not tell a hill from a
                                        ///< lower one of the same form
    std::uint64_t original_hash = 0;    ///< of the coarse codes before any stamp
    std::uint64_t salt = 0;             ///< drawn when it was made; goes into the checksums of all its files
    std::string heights;                ///< the host's note of where the heights come from, at most 1 000 bytes
};

/// Of a ground that no stamp has touched. `salt` stays 0.
WorldIdentity identity_of(const Ground& ground);

/// Writes `world.tlw`, durable on return.
Result<void> write_identity(FileSystem& files, const std::string& folder, const WorldIdentity& identity);
/// NotFound where the folder holds no world. FileFormat for a file that is damaged or of a newer version.
Result<WorldIdentity> read_identity(FileSystem& files, const std::string& folder);

/// Fails with InvalidArgument and the name of the first field that differs (salt and note apart): a world is only ever
/// opened on the ground that it was made on.
Result<void> check_same(const WorldIdentity& stored, const WorldIdentity& given);

}  // namespace tilth
