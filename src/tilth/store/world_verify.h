// Reading everything that a world has on disk, to see whether it is whole.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/store/blob_store.h"
#include "tilth/store/file_system.h"
#include "tilth/store/journal.h"
#include "tilth/store/world_pages.h"

namespace tilth {

struct VerifiedWorld {
    FileSystem* files = nullptr;
    std::string folder;
    std::uint64_t salt = 0;
    BlobStore* blobs = nullptr;
    WorldPages* pages = nullptr;
    Journal* journal = nullptr;
};

/// Reads and decodes every blob, every durable edit that the journal still has, identity and shapes. One error for each
/// that is damaged, with file and offset where the store tells them. Changes nothing. Cost: reads everything once.
std::vector<Error> verify_world(const VerifiedWorld& world);

}  // namespace tilth
