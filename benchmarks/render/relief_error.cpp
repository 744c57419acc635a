#include "render/relief_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "render/support/relief_world.h"
#include "support/bench_device.h"

namespace tilth::bench {
namespace {

constexpr std::int32_t kPosts = 721;  // the walk and 15 m about it
constexpr std::int32_t kFirst = static_cast<std::int32_t>(3 * kTileWidth_m / kReferenceSpacing_m) - kPosts / 2;
constexpr std::array kShares{0.2, 0.5, 0.8};

/// The cut-out; truths of its views as depths.
struct ErrorWorld {
    explicit ErrorWorld(Dents dents)
        : world(std::make_shared<test::FormulaSource>(
                    kPosts, reference_heights()->min_m(), reference_heights()->max_m(),
                    [](double x, double z) {
                        return reference_heights()->height_m(
                            {static_cast<std::int32_t>(x) + kFirst, static_cast<std::int32_t>(z) + kFirst});
                    }),
                {.tile_size = 2048}) {
        for (StampRequest request : dents_of(dents, world.boot())) {
            request.centre = here(request.centre);
            world.stamp(request);
        }
        for (const double share : kShares) {
            const WorldPos at = here(walk_place(share));
            world.settle(at);
            views.push_back(walk_view(world.truth(), at));
            views.back().width = target.width(), views.back().height = target.height();
            surfaces.push_back(std::make_unique<test::ContractSurface>(world.truth(), at, 14));
            test::DetailMesh(*surfaces.back()).draw(target, views.back());
            truths.push_back(target.depths());
        }
    }
    static WorldPos here(WorldPos at) {
        return {at.x - kFirst * kReferenceSpacing_m, at.z - kFirst * kReferenceSpacing_m};
    }
    test::Target target{1600, 900};
    test::ReliefWorld world;
    std::vector<View> views;
    std::vector<std::unique_ptr<test::ContractSurface>> surfaces;
    std::vector<std::vector<float>> truths;
};

ErrorWorld& world_of(Dents dents) {
    static std::map<Dents, ErrorWorld*> all;  // never destroyed: its context is rarely the current one
    ErrorWorld*& made = all[dents];
    if (made == nullptr) made = new ErrorWorld(dents);
    return *made;
}

}  // namespace

ReliefError relief_error(const DetailSettings& settings, Dents dents) {
    static_cast<void>(test::test_context(test::default_route()));
    ErrorWorld& scene = world_of(dents);
    DetailSettings deep = settings;
    deep.parallax.depth = true;
    ReliefError error;
    if (!scene.world.show(deep)) return {NAN, NAN, NAN};
    double squares = 0;
    long pixels = 0, wrong = 0;
    for (std::size_t i = 0; i < scene.views.size(); ++i) {
        const test::Frame frame = scene.world.draw(scene.target, scene.views[i]);
        const test::ShownGround shown = test::compare_ground(scene.views[i], frame.depth, scene.truths[i],
                                                             *scene.surfaces[i], scene.world.whole_reach_m());
        squares += shown.rms_px * shown.rms_px * static_cast<double>(shown.pixels);
        pixels += shown.pixels, wrong += shown.wrong;
        error.p99_px = std::max(error.p99_px, shown.p99_px);
    }
    error.rms_px = std::sqrt(squares / static_cast<double>(pixels));
    error.wrong_percent = 100.0 * static_cast<double>(wrong) / static_cast<double>(pixels);
    make_current();
    return error;
}

}  // namespace tilth::bench
