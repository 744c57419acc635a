// Byte offsets into a bound buffer, in the form in which GL takes them.
#pragma once

#include <cstddef>

namespace tilth::gl {

inline const void* offset_pointer(std::size_t offset_bytes) { return reinterpret_cast<const void*>(offset_bytes); }

}  // namespace tilth::gl
