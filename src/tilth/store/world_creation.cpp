#include "tilth/store/world_creation.h"

#include <algorithm>
#include <random>
#include <vector>

#include "tilth/core/log.h"

namespace tilth {
namespace {

std::uint64_t drawn_salt() {
    std::random_device device;
    return (std::uint64_t{device()} << 32) | device();
}

bool is_of_a_world(const std::string& name) {
    return name.ends_with(".tlp") || name.ends_with(".tlj") || name.ends_with(".tls");
}

}  // namespace

Result<void> make_world_folder(FileSystem& files, const std::string& folder) {
    const bool was_there = files.exists(folder);
    if (Result<void> made = files.make_folder(folder); !made) return made;
    if (files.exists(folder + "/world.tlw")) return {};
    const std::size_t slash = folder.rfind('/');
    const std::string parent = slash == std::string::npos ? "." : folder.substr(0, std::max<std::size_t>(slash, 1));
    Result<void> synced = files.sync_folder(parent);
    if (synced || !was_there) return synced;
    log(LogLevel::Warning, synced.error().message);
    return {};
}

Result<WorldIdentity> identity_in(FileSystem& files, const std::string& folder, const Ground& ground,
                                  const std::string& heights, bool& is_new) {
    WorldIdentity given = identity_of(ground);
    auto stored = read_identity(files, folder);
    is_new = !stored && stored.error().code == ErrorCode::NotFound;
    if (stored) {
        if (const Result<void> same = check_same(*stored, given); !same)
            return Error{same.error().code, text(folder, ": ", same.error().message)};
        return stored;
    }
    if (!is_new) return stored;
    const auto names = files.list(folder);
    if (!names) return names.error();
    if (const auto found = std::ranges::find_if(*names, is_of_a_world); found != names->end())
        return Error{ErrorCode::FileFormat, text(folder, "/world.tlw: is missing, but there is ", *found,
                                                 " of a world; restore it from a backup, or choose another folder")};
    given.salt = drawn_salt();
    given.heights = heights;
    if (const Result<void> written = write_identity(files, folder, given); !written) return written.error();
    return given;
}

}  // namespace tilth
