#include "store/sample_pages.h"

#include <algorithm>
#include <cmath>

#include "support/bench_device.h"
#include "tilth/ground/path.h"
#include "tilth/source/analytic_sources.h"
#include "tilth/source/ridged_source.h"

namespace tilth::bench {
namespace {

ShapeId boot_of(Ground& ground) {
    if (const auto known = ground.shapes().find("boot")) return *known;
    return value(ground.shapes().bake("boot", kBootTexels, boot_weight));
}

void apply_all(Ground& ground, const std::vector<StampRequest>& requests) {
    for (const StampRequest& request : requests) ground.apply(value(ground.issue(request)));
}

constexpr ShapeId id_of(BuiltinProfile profile) { return {static_cast<std::uint32_t>(profile)}; }

std::vector<Page> detail_pages(const Ground& ground) {
    std::vector<Page> pages;
    for (const auto& [index, codes] : ground.detail().pages()) pages.push_back({index, codes});
    return pages;
}

std::vector<Page> coarse_pages(const Ground& ground) {
    std::vector<Page> pages;
    const HeightField& field = ground.coarse();
    for (std::int32_t z = 0; z < field.depth() / kPageTexels; ++z)
        for (std::int32_t x = 0; x < field.width() / kPageTexels; ++x) {
            Page page{{x, z}, std::make_shared<PageCodes>()};
            for (std::int32_t row = 0; row < kPageTexels; ++row)
                std::copy_n(field.row(z * kPageTexels + row) + x * kPageTexels, kPageTexels,
                            page.codes->data() + row * kPageTexels);
            pages.push_back(std::move(page));
        }
    return pages;
}

/// Spread evenly over what there is.
std::vector<Page> some_of(const std::vector<Page>& pages, std::size_t count) {
    std::vector<Page> some;
    for (std::size_t i = 0; i < std::min(count, pages.size()); ++i)
        some.push_back(pages[i * pages.size() / std::min(count, pages.size())]);
    return some;
}

std::vector<Page> scattered(HeightPrecision precision, std::size_t count, const RandomStamps& how, std::int64_t each) {
    // As many posts as `count` pages need: 64 texels are 21.3 posts.
    const auto posts = static_cast<std::int32_t>(std::sqrt(static_cast<double>(count)) * kPageTexels / 3) + 2;
    auto ground = flat_ground(posts, precision);
    RandomStamps stamps = how;
    stamps.count = each * static_cast<std::int64_t>(count);
    stamps.region = {WorldPos{0, 0}, WorldPos{posts * 0.1, posts * 0.1}};
    stamps.map = MapChoice::Detail;
    apply_all(*ground, random_stamps(stamps, *ground));
    return some_of(detail_pages(*ground), count);
}

std::unique_ptr<Ground> mountains(HeightPrecision precision) {
    return value(Ground::create(make_ridged_source({.seed = 7, .size = 1025, .relief_m = 200}),
                                {.spacing_m = 1, .detail = false, .precision = precision}));
}

}  // namespace

double boot_weight(double x, double z) {
    const auto ellipse = [&](double cx, double rx, double rz) {
        return 1 - ((x - cx) * (x - cx) / (rx * rx) + z * z / (rz * rz));
    };
    return std::clamp(2 * std::max(ellipse(0.35, 0.6, 0.36), ellipse(-0.6, 0.35, 0.3)), 0.0, 1.0);
}

const char* name_of(SampleKind kind) {
    switch (kind) {
        case SampleKind::Prints:
            return "prints";
        case SampleKind::Adds:
            return "adds";
        case SampleKind::Craters:
            return "craters";
        case SampleKind::Dense:
            return "dense";
        case SampleKind::Heights:
            return "heights";
        case SampleKind::Battered:
            return "battered";
        case SampleKind::Uniform:
            return "uniform";
    }
    return "";
}

std::unique_ptr<Ground> flat_ground(std::int32_t posts, HeightPrecision precision) {
    return value(Ground::create(std::make_unique<FlatSource>(posts, 10.0),
                                {.spacing_m = 0.1, .texels_per_post = 3, .tile_size = 2048, .precision = precision}));
}

std::vector<StampRequest> trail_of_prints(Ground& ground, const Trail& trail) {
    // To and fro in lanes, two metres from the borders.
    const GridSpec& grid = ground.map(MapKind::Coarse).grid;
    const double far = grid.spacing_m * (grid.width - 1) - 2, deep = grid.spacing_m * (grid.depth - 1) - 2;
    PathRequest path{.stamp = {.shape = boot_of(ground),
                               .radius_m = trail.radius_m,
                               .amplitude_m = -0.03,
                               .map = MapChoice::Detail,
                               .rule = StampRule::Min,
                               .mirror = true},
                     .spacing_m = trail.stride_m,
                     .alternate_m = 0.15};
    const double length = trail.stride_m * static_cast<double>(trail.prints);
    double walked = 0;
    bool forth = true;
    // Not along the texels: no two prints look alike.
    for (double z = 2; z < deep && walked < length; z += trail.lanes_m, forth = !forth) {
        path.points.push_back({forth ? 2 : far, z});
        path.points.push_back({forth ? far : 2, z + 1.3});
        walked += far - 2;
    }
    std::vector<StampRequest> prints = value(stamps_along(path));
    if (prints.size() < static_cast<std::size_t>(trail.prints)) {
        std::fprintf(stderr, "tilth-bench: no room for %lld prints\n", static_cast<long long>(trail.prints));
        std::exit(1);
    }
    prints.resize(static_cast<std::size_t>(trail.prints));
    return prints;
}

std::vector<Page> sample_pages(SampleKind kind, HeightPrecision precision, std::size_t count) {
    switch (kind) {
        case SampleKind::Prints: {
            auto ground = flat_ground(2049, precision);
            apply_all(*ground, trail_of_prints(*ground, {.prints = static_cast<std::int64_t>(2 * count)}));
            return some_of(detail_pages(*ground), count);
        }
        case SampleKind::Adds:
            return scattered(precision, count,
                             {.seed = 11,
                              .radius_m = {0.1, 1},
                              .amplitude_m = {-0.1, 0.1},
                              .shapes = {id_of(BuiltinProfile::Gaussian)},
                              .rules = {StampRule::Add}},
                             3);
        case SampleKind::Craters:
            return scattered(precision, count,
                             {.seed = 12,
                              .radius_m = {0.5, 3},
                              .amplitude_m = {-0.5, -0.1},
                              .shapes = {id_of(BuiltinProfile::Crater)},
                              .rules = {StampRule::Add}},
                             1);
        case SampleKind::Dense:
            return scattered(
                precision, count,
                {.seed = 13,
                 .radius_m = {0.07, 0.5},
                 .amplitude_m = {-0.1, 0.1},
                 .shapes = {id_of(BuiltinProfile::Gaussian), id_of(BuiltinProfile::Cone),
                            id_of(BuiltinProfile::Paraboloid), id_of(BuiltinProfile::Cosine),
                            id_of(BuiltinProfile::Crater), id_of(BuiltinProfile::Disc)},
                 .rules = {StampRule::Add, StampRule::Min, StampRule::Max, StampRule::Set, StampRule::Smooth}},
                100);
        case SampleKind::Heights:
            return some_of(coarse_pages(*mountains(precision)), count);
        case SampleKind::Battered: {
            auto ground = mountains(precision);
            apply_all(*ground, random_stamps({.seed = 14,
                                              .count = 500,
                                              .region = {WorldPos{0, 0}, WorldPos{1024, 1024}},
                                              .radius_m = {8, 40},
                                              .amplitude_m = {-6, -1},
                                              .map = MapChoice::Coarse,
                                              .shapes = {id_of(BuiltinProfile::Crater)},
                                              .rules = {StampRule::Add}},
                                             *ground));
            return some_of(coarse_pages(*ground), count);
        }
        case SampleKind::Uniform: {
            std::vector<Page> pages;
            for (std::size_t i = 0; i < count; ++i) {
                pages.push_back({{static_cast<std::int32_t>(i), 0}, std::make_shared<PageCodes>()});
                pages.back().codes->fill(kMidCode - (static_cast<std::uint32_t>(i) << 20));
            }
            return pages;
        }
    }
    return {};
}

}  // namespace tilth::bench
