// What the tests of undo and replay share: a small world, and random stamps of every kind on it.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <vector>

#include "ground/support.h"
#include "tilth/ground/apply_edit.h"
#include "tilth/ground/ground.h"
#include "tilth/ground/undo_history.h"

namespace tilth::test {

/// A hill, with sides that are no multiples of a page: 101 posts (2 x 2 pages), 301 texels (5 x 5 pages), and user
/// shapes in the library. The detail map has 128 texels a tile.
inline std::unique_ptr<Ground> small_world(HeightPrecision precision) {
    const GroundSettings settings{.origin = {-13.3, 7.1}, .spacing_m = 0.75, .tile_size = 128, .precision = precision};
    Result<std::unique_ptr<Ground>> made = Ground::create(std::make_shared<HillSource>(101, 6.0, 20.0), settings);
    EXPECT_TRUE(made.ok()) << (made.ok() ? "" : made.error().message);
    std::unique_ptr<Ground> ground = *std::move(made);
    UserShapes shapes(ground->shapes());
    return ground;
}

/// Stamps of all rules, shapes and both maps; tiny ones that are widened, large ones, some half off the map, and a
/// quarter with amplitudes and levels that saturate.
class RandomRequests {
public:
    explicit RandomRequests(std::uint32_t seed) : random_(seed) {}

    std::int32_t whole(std::int32_t from, std::int32_t to) { return std::uniform_int_distribution(from, to)(random_); }
    double real(double from, double to) { return std::uniform_real_distribution(from, to)(random_); }
    bool chance(double share) { return real(0, 1) < share; }

    StampRequest next(const Ground& ground) {
        const MapKind kind = chance(0.35) ? MapKind::Coarse : MapKind::Detail;
        const MapGeometry& map = ground.map(kind);
        const double side_m = map.grid.spacing_m * map.grid.width, reach_m = 32768 * map.codec.quantum_m;
        const bool saturates = chance(0.25);
        StampRequest request{
            .shape = {static_cast<std::uint32_t>(whole(0, 8))},
            .centre = {map.grid.origin.x + side_m * real(-0.05, 1.05), map.grid.origin.z + side_m * real(-0.05, 1.05)},
            .radius_m = map.grid.spacing_m * (chance(0.15) ? real(0.01, 1) : real(1, 45)),
            .amplitude_m = saturates ? reach_m * real(-1.9, 1.9) : real(-0.4, 0.4),
            .map = kind == MapKind::Coarse ? MapChoice::Coarse : MapChoice::Detail,
            .rule = static_cast<StampRule>(chance(0.45) ? 0 : whole(1, 4)),
            .rotation_rad = real(0, 6),
            .mirror = chance(0.5)};
        if (request.rule == StampRule::Smooth) request.amplitude_m = real(0, 1);
        request.level_m = map.codec.middle_m + (saturates ? reach_m * real(-0.99, 0.99) : real(-1, 1));
        return request;
    }

private:
    std::mt19937 random_;
};

/// A ground with its history, and edits applied at once.
struct Undoable {
    std::unique_ptr<Ground> ground;
    UndoHistory history;

    Undoable(std::unique_ptr<Ground> made, std::uint64_t bound) : ground(std::move(made)), history(bound) {}

    ApplyResult stamp(const StampRequest& request, bool begins_stroke = true) {
        return apply_edit(*ground, history.add(issued(*ground, request), begins_stroke));
    }
    void random_stroke(RandomRequests& random, std::int32_t most_stamps = 10) {
        const std::int32_t count = random.whole(1, most_stamps);
        for (std::int32_t i = 0; i < count; ++i) stamp(random.next(*ground), i == 0);
    }
    [[nodiscard]] bool undo() {
        const Result<StrokePtr> stroke = history.undo();
        if (stroke) apply_edit(*ground, undo_edit(*stroke));
        return stroke.ok();
    }
    [[nodiscard]] bool redo() {
        const Result<StrokePtr> stroke = history.redo();
        if (stroke)
            for (const GroundEdit& edit : redo_edits(*stroke)) apply_edit(*ground, edit);
        return stroke.ok();
    }
};

inline constexpr std::uint64_t kPlenty = std::uint64_t{1} << 40;  // a bound that no test reaches

}  // namespace tilth::test

namespace tilth {
inline void PrintTo(const StateHash& hash, std::ostream* out) { *out << std::hex << hash.coarse << '/' << hash.detail; }
}  // namespace tilth
