#include "demo/world/world_session.h"

#include <ostream>
#include <utility>

#include "demo/world/open_world.h"

namespace tilth::demo {

std::unique_ptr<WorldSession> WorldSession::open(WorldPlace place, Problems& problems, std::ostream& messages) {
    auto terrain = open_world(place.terrain, place.heights, place.stamp_folder, place.get_proc, problems);
    if (!terrain) return nullptr;
    return std::unique_ptr<WorldSession>(new WorldSession(std::move(place), std::move(terrain), messages));
}

WorldSession::WorldSession(WorldPlace place, std::unique_ptr<Terrain> terrain, std::ostream& messages)
    : place_(std::move(place)),
      terrain_(std::move(terrain)),
      messages_(messages),
      executor_reason_(terrain_->executor_reason()) {
    tell_damage();
}

Result<void> WorldSession::reopen() {
    if (Result<void> flushed = flush(); !flushed) return flushed;
    return open_again();
}

Result<void> WorldSession::crash() {
    terrain_->abandon_world();
    return open_again();
}

Result<void> WorldSession::flush() {
    if (!terrain_) return {};
    return terrain_->flush();
}

Result<void> WorldSession::open_again() {
    before_ = total();
    debug_messages_ = take_debug_messages();
    place_.terrain.settings.executor = terrain_->executor();
    place_.terrain.settings.detail = terrain_->detail();
    terrain_.reset();  // gives the lock back
    Problems problems;
    terrain_ = open_world(place_.terrain, place_.heights, place_.stamp_folder, place_.get_proc, problems);
    if (!terrain_) return Error{ErrorCode::FileRead, problems.list().front().text};
    tell_damage();
    return {};
}

void WorldSession::tell_damage() {
    if (!is_on_disk()) return;
    for (const Error& damage : terrain_->take_errors()) messages_ << "store: " << damage.message << std::endl;
}

gl::FrameStats WorldSession::total() const {
    gl::FrameStats sum = before_;
    if (terrain_) sum += terrain_->total();
    return sum;
}

std::vector<std::string> WorldSession::take_debug_messages() {
    std::vector<std::string> all = std::exchange(debug_messages_, {});
    if (terrain_)
        for (std::string& message : terrain_->take_debug_messages()) all.push_back(std::move(message));
    return all;
}

}  // namespace tilth::demo
