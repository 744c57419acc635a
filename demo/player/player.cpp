#include "demo/player/player.h"

#include <cmath>
#include <ostream>
#include <set>
#include <stdexcept>

#include "demo/player/dump.h"
#include "demo/player/expectations.h"
#include "demo/player/walk_plan.h"
#include "tilth/ground/path.h"
#include "tilth/ground/random_stamps.h"

namespace tilth::demo {

namespace {

/// Stamps that are queued before they are applied without waiting for a frame: 64 bytes each, so at most 64 MiB.
constexpr std::int64_t kMaxQueuedStamps = 1 << 20;

std::uint64_t tiles_with_detail(const Ground& ground) {
    const std::int32_t pages_a_tile = ground.settings().tile_size / kPageTexels;
    std::set<PageIndex> tiles;
    for (const auto& [page, codes] : ground.detail().pages())
        tiles.insert({page.x >= 0 ? page.x / pages_a_tile : (page.x + 1) / pages_a_tile - 1,
                      page.z >= 0 ? page.z / pages_a_tile : (page.z + 1) / pages_a_tile - 1});
    return tiles.size();
}

}  // namespace

Player::Player(Terrain& terrain, const Scenario& scenario, Screen* screen, PlayerSettings settings,
               std::ostream& errors)
    : terrain_(terrain),
      scenario_(scenario),
      screen_(screen),
      settings_(std::move(settings)),
      errors_(errors),
      shading_(shading_of(scenario.view, settings_.low_m, settings_.high_m)),
      viewer_(viewer_at_centre(terrain.ground())) {}

bool Player::play() {
    for (const Step& step : scenario_.steps)
        attempt(step.number, step.line,
                [&] { return std::visit([this](const auto& action) { return run(action); }, step.action); });
    if (!scenario_.steps.empty()) {
        const Step& last = scenario_.steps.back();
        attempt(last.number, last.line, [&] { return settle(), Outcome(); });
    }
    return failures_.empty();
}

void Player::attempt(int number, int line, const std::function<Outcome()>& action) {
    Outcome failed;
    try {
        failed = action();
    } catch (const std::exception& error) {
        failed = error.what();
    }
    if (!failed) return;
    const std::string message = text(scenario_.file.string(), ":", line, ": step ", number, ": ", *failed);
    failures_.push_back(message);
    errors_ << message << std::endl;
}

void Player::settle() {
    queued_ = 0;
    if (const auto drained = terrain_.drain(); !drained) throw std::runtime_error(drained.error().message);
}

double Player::ground_m(WorldPos at) {
    settle();
    return terrain_.height_m(at);
}

std::string Player::output_path(const std::string& file) const {
    const std::filesystem::path path = settings_.out / file;  // an absolute `file` stays as it is
    std::error_code ignored;  // a folder that cannot be made shows in the writer's error
    if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), ignored);
    return path.string();
}

View Player::view_now() const {
    const double above_m = viewer_.eye.y - terrain_.height_m({viewer_.eye.x, viewer_.eye.z});
    return view_of(viewer_, scenario_.view, above_m);
}

Player::Outcome Player::queue(StampRequest request, std::int64_t repeat) {
    for (std::int64_t i = 0; i < repeat; ++i) {
        const auto record = terrain_.stamp(request);
        if (!record) return record.error().message;
        request.key = record->key + 1;  // drawn once, then counted up
        if (++queued_ >= kMaxQueuedStamps) settle();
    }
    return {};
}

Player::Outcome Player::draw_frame() {
    queued_ = 0;
    if (screen_ == nullptr) return {};
    const auto drawn = screen_->draw(terrain_, view_now(), shading_, scenario_.view.clear);
    if (!drawn) return drawn.error().message;
    return {};
}

Player::Outcome Player::timed_frame(double dt_s) {
    const Stopwatch watch;
    const auto updated = terrain_.update(dt_s);
    Outcome failed = draw_frame();
    if (!updated) failed = updated.error().message;
    watch.stop(frames_);
    return failed;
}

Player::Outcome Player::run(const CameraStep& step) {
    Viewer next{.eye = step.eye, .forward = {}};
    if (step.above_ground_m) next.eye.y = ground_m({step.eye.x, step.eye.z}) + *step.above_ground_m;
    next.forward = {step.look_at.x - next.eye.x, step.look_at.y - next.eye.y, step.look_at.z - next.eye.z};
    if (next.forward == Vec3d{}) return "camera: look_at is the eye itself";
    viewer_ = next;
    return {};
}

Player::Outcome Player::run(const StampStep& step) {
    StampRequest request = step.request;
    request.shape = *terrain_.shapes().find(step.shape);
    return queue(request, step.repeat);
}

Player::Outcome Player::run(const PathStep& step) {
    PathRequest path{step.stamp.request, step.points, step.spacing_m, step.alternate_m};
    path.stamp.shape = *terrain_.shapes().find(step.stamp.shape);
    const auto stamps = stamps_along(path);
    if (!stamps) return stamps.error().message;
    for (const StampRequest& request : *stamps)
        if (Outcome failed = queue(request, step.stamp.repeat)) return failed;
    return {};
}

Player::Outcome Player::run(const RandomStep& step) {
    RandomStamps random{.seed = step.seed,
                        .count = step.count,
                        .region = step.region,
                        .radius_m = step.radius_m,
                        .amplitude_m = step.amplitude_m,
                        .map = step.map,
                        .shapes = {},
                        .rules = step.rules};
    for (const std::string& name : step.shapes) random.shapes.push_back(*terrain_.shapes().find(name));
    for (const StampRequest& request : random_stamps(random, terrain_.ground()))
        if (Outcome failed = queue(request, 1)) return failed;
    return {};
}

Player::Outcome Player::run(const WalkStep& step) {
    const WorldPos from{viewer_.eye.x, viewer_.eye.z};
    const WalkPlan plan = plan_walk(from, step);
    if (plan.frames == 0) return {};
    viewer_.forward = {step.to.x - from.x, 0, step.to.z - from.z};
    std::vector<StampRequest> prints;
    if (step.print) {
        PathRequest path{step.print->request, {from, step.to}, step.stride_m, step.alternate_m};
        path.stamp.shape = *terrain_.shapes().find(step.print->shape);
        auto along = stamps_along(path);
        if (!along) return along.error().message;
        prints = std::move(*along);
    }
    settle();
    Outcome failed;
    std::size_t printed = 0;
    for (std::int64_t frame = 1; frame <= plan.frames; ++frame) {
        const WorldPos at = plan.position(frame);
        // What the CPU knows of the ground: with the GPU executor without the prints of this walk, but without waiting.
        viewer_.eye = {at.x, terrain_.height_m(at) + step.above_ground_m, at.z};
        const std::size_t due = std::min(prints.size(), prints_until(plan.distance_m(frame), step.stride_m));
        for (; printed < due; ++printed)
            if (Outcome wrong = queue(prints[printed], step.print->repeat); wrong && !failed) failed = wrong;
        if (Outcome wrong = timed_frame(step.dt_s); wrong && !failed) failed = wrong;
    }
    viewer_.eye.y = ground_m(step.to) + step.above_ground_m;
    return failed;
}

Player::Outcome Player::run(const TeleportStep& step) {
    const double above_m = viewer_.eye.y - ground_m({viewer_.eye.x, viewer_.eye.z});
    viewer_.eye = {step.to.x, ground_m(step.to) + above_m, step.to.z};
    return {};
}

Player::Outcome Player::run(const WaitStep& step) {
    const WaitPlan plan = plan_wait(step);
    Outcome failed;
    for (std::int64_t frame = 0; frame < plan.frames; ++frame)
        if (Outcome wrong = timed_frame(plan.dt(frame)); wrong && !failed) failed = wrong;
    return failed;
}

Player::Outcome Player::run(const ScreenshotStep& step) {
    if (screen_ == nullptr) return "screenshot: there is no GL context to draw with";
    settle();
    if (const auto updated = terrain_.update(0); !updated) return updated.error().message;
    if (Outcome failed = draw_frame()) return failed;
    if (const auto written = screen_->write_png(output_path(step.file)); !written) return written.error().message;
    if (step.depth_file.empty()) return {};
    if (const auto written = screen_->write_depth(output_path(step.depth_file), view_now()); !written)
        return written.error().message;
    return {};
}

Player::Outcome Player::run(const DumpStep& step) {
    settle();
    const auto written = write_dump(terrain_.ground(), step, output_path(step.file));
    if (!written) return "dump: " + written.error().message;
    return {};
}

Player::Outcome Player::run(const QueryStep& step) {
    settle();
    Json heights = Json::array();
    for (const WorldPos& at : step.at) heights.push_back(terrain_.height_m(at, step.map));
    queries_.push_back(std::move(heights));
    return {};
}

Player::Outcome Player::run(const ExpectStep& step) {
    settle();
    if (const auto* height = std::get_if<ExpectHeight>(&step.what))
        return unmet(*height, terrain_.height_m(height->at));
    if (const auto* hash = std::get_if<ExpectHash>(&step.what)) return unmet(*hash, terrain_.hash());
    const auto& stat = std::get<ExpectStat>(step.what);
    return unmet(stat, to_json(report(stat.path.starts_with("hash"))));
}

RunReport Player::report(bool with_hash) {
    RunReport r;
    r.route = settings_.route, r.renderer = terrain_.renderer(), r.gl_version = terrain_.gl_version();
    r.executor = terrain_.executor() == ExecutorKind::Gpu ? "gpu" : "cpu";
    r.executor_reason = terrain_.executor_reason();
    if (with_hash) {
        settle();
        r.hash = terrain_.hash();
    }
    r.frames = frames_;
    r.total = terrain_.total(), r.last_frame = terrain_.last_frame();
    r.tiles = tiles_with_detail(terrain_.ground());
    r.gpu_bytes = terrain_.gpu_bytes(), r.cpu_bytes = terrain_.cpu_bytes();
    r.queries = queries_, r.failures = failures_;
    return r;
}

}  // namespace tilth::demo
