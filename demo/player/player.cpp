#include "demo/player/player.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ostream>
#include <stdexcept>
#include <thread>
#include <tuple>

#include "demo/overlay/residency_map.h"
#include "demo/player/dump.h"
#include "demo/player/expectations.h"
#include "demo/player/region.h"
#include "demo/player/walk_plan.h"
#include "tilth/ground/path.h"
#include "tilth/ground/random_stamps.h"

namespace tilth::demo {

namespace {

/// Stamps that are queued before they are applied without waiting for a frame: 64 bytes each, so at most 64 MiB.
constexpr std::int64_t kMaxQueuedStamps = 1 << 20;

/// How long a screenshot waits for tiles before its step fails. Nine tiles from memory take a second on one core.
constexpr std::chrono::seconds kMostWaitForTiles{30};

constexpr std::size_t kMostTroublesTold = 3;

/// Damage that cost nothing: the store made again what it had lost.
bool is_repaired(const Error& error) {
    return error.code == ErrorCode::FileFormat && error.message.ends_with("from the journal");
}

/// Stamps while it lives are undone together.
class StrokeScope {
public:
    explicit StrokeScope(Terrain& terrain) : terrain_(terrain) { terrain_.begin_stroke(); }
    ~StrokeScope() { terrain_.end_stroke(); }
    StrokeScope(const StrokeScope&) = delete;
    StrokeScope& operator=(const StrokeScope&) = delete;

private:
    Terrain& terrain_;
};

std::uint64_t resident_tiles(const Terrain& terrain) {
    const std::vector<TileReport> tiles = terrain.tiles();
    return static_cast<std::uint64_t>(std::count_if(
        tiles.begin(), tiles.end(), [](const TileReport& tile) { return tile.state == TileState::Resident; }));
}

}  // namespace

Player::Player(WorldSession& world, const Scenario& scenario, Screen* screen, PlayerSettings settings,
               std::ostream& errors)
    : world_(world),
      scenario_(scenario),
      screen_(screen),
      settings_(std::move(settings)),
      errors_(errors),
      shading_(shading_of(scenario.view, settings_.low_m, settings_.high_m)),
      shown_(scenario.view.shown),
      viewer_(viewer_at_centre(world.terrain().ground())) {}

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
        failed = world_.is_open() ? action() : "the world is not open; see the step that opened it again";
    } catch (const std::exception& error) {
        failed = error.what();
    }
    if (const Outcome trouble = store_trouble(); trouble && (!failed || failed->find(*trouble) == std::string::npos))
        failed = failed ? *failed + "; " + *trouble : *trouble;
    if (!failed) return;
    const std::string message = text(scenario_.file.string(), ":", line, ": step ", number, ": ", *failed);
    failures_.push_back(message);
    errors_ << message << std::endl;
}

Player::Outcome Player::drained() {
    queued_ = 0;
    if (const auto done = terrain().drain(); !done) return done.error().message;
    return {};
}

void Player::settle() {
    if (const Outcome failed = drained()) throw std::runtime_error(*failed);
}

Player::Outcome Player::store_trouble() {
    if (!world_.is_open()) return {};
    std::vector<Error> errors = terrain().take_errors();
    for (const Error& error : errors)
        if (is_repaired(error)) errors_ << "store: " << error.message << std::endl;
    std::erase_if(errors, is_repaired);
    if (errors.empty()) return {};
    std::string told;
    for (std::size_t i = 0; i < std::min(errors.size(), kMostTroublesTold); ++i)
        told += (told.empty() ? "" : "; ") + errors[i].message;
    if (errors.size() > kMostTroublesTold) told += text("; and ", errors.size() - kMostTroublesTold, " more");
    return told;
}

std::vector<WorldPos> Player::viewers() const {
    std::vector<WorldPos> all{{viewer_.eye.x, viewer_.eye.z}};
    all.insert(all.end(), further_viewers_.begin(), further_viewers_.end());
    return all;
}

double Player::ground_m(WorldPos at) {
    settle();
    return terrain().height_m(at);
}

std::string Player::output_path(const std::string& file) const {
    const std::filesystem::path path = settings_.out / file;  // an absolute `file` stays as it is
    std::error_code ignored;  // a folder that cannot be made shows in the writer's error
    if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), ignored);
    return path.string();
}

View Player::view_now() {
    // For the near plane the coarse ground is near enough, and it is there without waiting, whatever is resident.
    const double above_m =
        viewer_.eye.y - terrain().ground().height_m({viewer_.eye.x, viewer_.eye.z}, MapSelect::Coarse);
    return view_of(viewer_, scenario_.view, above_m);
}

Player::Outcome Player::queue(StampRequest request, std::int64_t repeat) {
    for (std::int64_t i = 0; i < repeat; ++i) {
        const auto record = terrain().stamp(request);
        if (!record) return record.error().message;
        request.key = record->key + 1;  // drawn once, then counted up
        if (++queued_ >= kMaxQueuedStamps) settle();
    }
    return {};
}

Player::Outcome Player::bring_tiles() {
    // Within a bound of memory there may be no room for more than what the picture shows.
    const bool bounded = scenario_.terrain.settings.tiles.most_gpu_bytes > 0;
    const Interest needed = bounded ? Interest::Active : Interest::Loaded;
    const auto given_up = std::chrono::steady_clock::now() + kMostWaitForTiles;
    for (;;) {
        terrain().set_viewers(viewers());
        if (const auto updated = terrain().update(0); !updated) return updated.error().message;
        if (Outcome failed = drained()) return failed;
        const std::vector<TileReport> tiles = terrain().tiles();
        const auto coming = std::find_if(tiles.begin(), tiles.end(), [&](const TileReport& tile) {
            return tile.interest >= needed && tile.state != TileState::Resident;
        });
        if (coming == tiles.end()) return {};
        if (Outcome trouble = store_trouble()) return trouble;
        if (std::chrono::steady_clock::now() > given_up)
            return text("tile (", coming->tile.x, ", ", coming->tile.z,
                        ") does not come; tile_memory may be too small");
        std::this_thread::sleep_for(std::chrono::milliseconds(1));  // the disk worker's turn
    }
}

Player::Outcome Player::draw_frame(bool overlay) {
    queued_ = 0;
    if (screen_ == nullptr) return {};
    std::vector<ColouredRect> map;
    if (overlay) map = residency_map(terrain(), viewers(), scenario_.view.width, scenario_.view.height);
    const auto drawn = screen_->draw(terrain(), view_now(), shading_, scenario_.view.clear, map);
    if (!drawn) return drawn.error().message;
    return {};
}

Player::Outcome Player::timed_frame(double dt_s) {
    const Stopwatch watch;
    terrain().set_viewers(viewers());
    const auto updated = terrain().update(dt_s);
    Outcome failed = draw_frame(false);
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
    const StrokeScope stroke(terrain());
    StampRequest request = step.request;
    request.shape = *terrain().shapes().find(step.shape);
    return queue(request, step.repeat);
}

Player::Outcome Player::run(const PathStep& step) {
    const StrokeScope stroke(terrain());
    PathRequest path{step.stamp.request, step.points, step.spacing_m, step.alternate_m};
    path.stamp.shape = *terrain().shapes().find(step.stamp.shape);
    const auto stamps = stamps_along(path);
    if (!stamps) return stamps.error().message;
    for (const StampRequest& request : *stamps)
        if (Outcome failed = queue(request, step.stamp.repeat)) return failed;
    return {};
}

Player::Outcome Player::run(const RandomStep& step) {
    const StrokeScope stroke(terrain());
    RandomStamps random{.seed = step.seed,
                        .count = step.count,
                        .region = step.region,
                        .radius_m = step.radius_m,
                        .amplitude_m = step.amplitude_m,
                        .map = step.map,
                        .shapes = {},
                        .rules = step.rules};
    for (const std::string& name : step.shapes) random.shapes.push_back(*terrain().shapes().find(name));
    for (const StampRequest& request : random_stamps(random, terrain().ground()))
        if (Outcome failed = queue(request, 1)) return failed;
    return {};
}

Player::Outcome Player::run(const WalkStep& step) {
    const StrokeScope stroke(terrain());
    const WorldPos from{viewer_.eye.x, viewer_.eye.z};
    const WalkPlan plan = plan_walk(from, step);
    if (plan.frames == 0) return {};
    viewer_.forward = {step.to.x - from.x, 0, step.to.z - from.z};
    std::vector<StampRequest> prints;
    if (step.print) {
        PathRequest path{step.print->request, {from, step.to}, step.stride_m, step.alternate_m};
        path.stamp.shape = *terrain().shapes().find(step.print->shape);
        auto along = stamps_along(path);
        if (!along) return along.error().message;
        prints = std::move(*along);
    }
    Outcome failed = drained();  // a tile that cannot be had stops nobody
    std::vector<PostPos> stand;
    for (const WorldPos& at : viewers()) stand.push_back(terrain().ground().map(MapKind::Detail).grid.posts(at));
    const LeadWatch leads(terrain().tile_grid(), scenario_.terrain.settings.tiles.band, stand, step.speed_m_per_s);
    std::ignore = terrain().take_arrivals();  // of earlier steps
    std::size_t printed = 0;
    for (std::int64_t frame = 1; frame <= plan.frames; ++frame) {
        const WorldPos at = plan.position(frame);
        // What the CPU knows of the ground: with the GPU executor without the prints of this walk, but without waiting.
        viewer_.eye = {at.x, terrain().ground().height_m(at) + step.above_ground_m, at.z};
        const std::size_t due = std::min(prints.size(), prints_until(plan.distance_m(frame), step.stride_m));
        for (; printed < due; ++printed)
            if (Outcome wrong = queue(prints[printed], step.print->repeat); wrong && !failed) failed = wrong;
        if (Outcome wrong = timed_frame(step.dt_s); wrong && !failed) failed = wrong;
        walk_frames_.cpu_ms.push_back(frames_.cpu_ms.back());
        walk_frames_.wall_ms.push_back(frames_.wall_ms.back());
        leads.frame(terrain().last_frame().cache, terrain().take_arrivals(), walk_);
    }
    if (Outcome wrong = drained(); wrong && !failed) failed = wrong;
    viewer_.eye.y = terrain().height_m(step.to) + step.above_ground_m;
    return failed;
}

Player::Outcome Player::run(const TeleportStep& step) {
    const double above_m = viewer_.eye.y - ground_m({viewer_.eye.x, viewer_.eye.z});
    viewer_.eye = {step.to.x, ground_m(step.to) + above_m, step.to.z};
    return {};
}

Player::Outcome Player::run(const ViewersStep& step) {
    further_viewers_ = step.at;
    return {};
}

Player::Outcome Player::run(const WaitStep& step) {
    const WaitPlan plan = plan_wait(step);
    Outcome failed;
    for (std::int64_t frame = 0; frame < plan.frames; ++frame)
        if (Outcome wrong = timed_frame(plan.dt(frame)); wrong && !failed) failed = wrong;
    return failed;
}

Player::Outcome Player::run(const ShowStep& step) {
    const ShownDetail next = shown_after(shown_, step);
    if (const auto set = terrain().set_detail(settings_of(next)); !set) return "show: " + set.error().message;
    shown_ = next;
    return {};
}

Player::Outcome Player::needs_a_folder(const char* step) const {
    if (world_.is_on_disk()) return {};
    return text(step, ": the world is in memory alone; set store in [terrain], or give --store DIR");
}

Player::Outcome Player::opened_again(const std::function<Result<void>()>& open) {
    Outcome trouble = store_trouble();
    if (const auto opened = open(); !opened) return opened.error().message;
    queued_ = 0;
    terrain().set_viewers(viewers());
    return trouble;
}

Player::Outcome Player::run(const SaveStep&) {
    if (Outcome failed = needs_a_folder("save")) return failed;
    queued_ = 0;
    if (const auto saved = terrain().save(); !saved) return "save: " + saved.error().message;
    return {};
}

Player::Outcome Player::run(const ReopenStep&) {
    if (Outcome failed = needs_a_folder("reopen")) return failed;
    settle();
    return opened_again([&] { return world_.reopen(); });
}

Player::Outcome Player::run(const CrashStep&) {
    if (Outcome failed = needs_a_folder("crash")) return failed;
    return opened_again([&] { return world_.crash(); });
}

Player::Outcome Player::run(const UndoStep& step) {
    const auto available = static_cast<std::int64_t>(terrain().undoable());
    if (step.strokes > available)
        return text("undo: ", step.strokes, " strokes were asked for, and ", available, " can be undone; none was");
    for (std::int64_t i = 0; i < step.strokes; ++i)
        if (const auto undone = terrain().undo(); !undone) return "undo: " + undone.error().message;
    return {};
}

Player::Outcome Player::run(const RedoStep& step) {
    const auto available = static_cast<std::int64_t>(terrain().redoable());
    if (step.strokes > available)
        return text("redo: ", step.strokes, " strokes were asked for, and ", available, " can be redone; none was");
    for (std::int64_t i = 0; i < step.strokes; ++i)
        if (const auto redone = terrain().redo(); !redone) return "redo: " + redone.error().message;
    return {};
}

Player::Outcome Player::run(const ScreenshotStep& step) {
    if (screen_ == nullptr) return "screenshot: there is no GL context to draw with";
    const Outcome trouble = bring_tiles();  // the picture is made all the same
    if (Outcome failed = draw_frame(step.overlay)) return failed;
    if (const auto written = screen_->write_png(output_path(step.file)); !written) return written.error().message;
    if (step.depth_file.empty()) return trouble;
    if (const auto written = screen_->write_depth(output_path(step.depth_file), view_now()); !written)
        return written.error().message;
    return trouble;
}

Player::Outcome Player::bring_codes(const DumpStep& step) {
    if (step.map != MapKind::Detail) return {};
    const GridSpec& texels = terrain().ground().map(MapKind::Detail).grid;
    const TileGrid grid = terrain().tile_grid();
    const TexelRect read = expanded(texels_in(texels, step.region), 1);  // slopes read the next texel
    const TileWindow window = tiles_of(grid, read);
    for (std::int32_t z = window.min.z; z <= window.max.z; ++z)
        for (std::int32_t x = window.min.x; x <= window.max.x; ++x) {
            // A query brings its tile, which stays until the next frame.
            const WorldPos inside = texels.world(intersection(grid.interior({x, z}), grid.map).min);
            if (std::isnan(terrain().height_m(inside, MapSelect::Detail)))
                return text("dump: tile (", x, ", ", z, ") cannot be had from the store");
        }
    return {};
}

Player::Outcome Player::run(const DumpStep& step) {
    settle();
    if (Outcome failed = bring_codes(step)) return failed;
    const auto written = write_dump(terrain().ground(), step, output_path(step.file));
    if (!written) return "dump: " + written.error().message;
    return {};
}

Player::Outcome Player::run(const QueryStep& step) {
    settle();
    Json heights = Json::array();
    for (const WorldPos& at : step.at) heights.push_back(terrain().height_m(at, step.map));
    queries_.push_back(std::move(heights));
    return {};
}

Player::Outcome Player::run(const ExpectStep& step) {
    settle();
    if (const auto* height = std::get_if<ExpectHeight>(&step.what))
        return unmet(*height, terrain().height_m(height->at));
    if (const auto* hash = std::get_if<ExpectHash>(&step.what)) {
        const auto is = terrain().hash();
        return is ? unmet(*hash, *is) : "expect: " + is.error().message;
    }
    const auto& stat = std::get<ExpectStat>(step.what);
    return unmet(stat, to_json(report(stat.path.starts_with("hash"))));
}

RunReport Player::report(bool with_hash) {
    RunReport r;
    r.frames = frames_, r.walk_frames = walk_frames_;
    r.walk = walk_;
    r.queries = queries_;
    r.route = settings_.route;
    r.executor_reason = world_.executor_reason();
    if (world_.is_open()) add_world(with_hash, r);
    r.total = world_.total();
    r.failures.insert(r.failures.begin(), failures_.begin(), failures_.end());
    return r;
}

void Player::add_world(bool with_hash, RunReport& r) {
    if (with_hash) {
        settle();
        if (const auto hash = terrain().hash())
            r.hash = *hash;
        else
            r.failures.push_back("hash: " + hash.error().message);
    }
    r.renderer = terrain().renderer(), r.gl_version = terrain().gl_version();
    r.executor = terrain().executor() == ExecutorKind::Gpu ? "gpu" : "cpu";
    r.last_frame = terrain().last_frame();
    r.tiles = resident_tiles(terrain()), r.tile_bytes = terrain().tile_gpu_bytes();
    r.gpu_bytes = terrain().gpu_bytes(), r.cpu_bytes = terrain().cpu_bytes();
    r.world = terrain().world();
}

}  // namespace tilth::demo
