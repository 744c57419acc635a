// The first steps of a world on disk: its folder, and the file that says what it is.
#pragma once

#include <string>

#include "tilth/core/result.h"
#include "tilth/ground/ground.h"
#include "tilth/store/file_system.h"
#include "tilth/store/world_identity.h"

namespace tilth {

/// Makes the folder where it is missing, and its name durable. (A folder that was there before may lie in one that we
/// may not look into: then its name is taken to be durable, and a warning is logged.)
Result<void> make_world_folder(FileSystem& files, const std::string& folder);

/// The identity of the world in `folder`, which is locked. Where there is none it is made: it is the first file of a
/// world, so that a crash leaves either no world or one without edits; everything else is made under its salt. Fails
/// where the ground is another one, and where there are files of a world but no identity.
Result<WorldIdentity> identity_in(FileSystem& files, const std::string& folder, const Ground& ground,
                                  const std::string& heights, bool& is_new);

}  // namespace tilth
