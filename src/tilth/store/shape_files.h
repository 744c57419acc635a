// The shapes that a world's stamps use, kept beside them: a record is worth nothing without its table.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/ground/shape_library.h"
#include "tilth/store/file_system.h"

namespace tilth {

/// Writes `shape-<id>.tls`, durable on return. Never replaces one.
Result<void> write_shape(FileSystem& files, const std::string& folder, std::uint64_t salt, ShapeId id,
                         const Shape& shape);

/// Adds the shapes of a world's folder to `shapes`, under the same ids. Returns how many ids the folder knows (built-in
/// ones included). Fails where a file is damaged or a number is missing, or where `shapes` has another shape under that
/// id or name.
Result<std::uint32_t> read_shapes(FileSystem& files, const std::string& folder, std::uint64_t salt,
                                  ShapeLibrary& shapes);

}  // namespace tilth
