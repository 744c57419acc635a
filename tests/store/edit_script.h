// An endless sequence of edits that follows from a seed, and the ground that a world must have after so many of them.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tilth/ground/apply_edit.h"
#include "tilth/ground/ground.h"
#include "tilth/ground/random_stamps.h"
#include "tilth/source/source_spec.h"
#include "tilth/store/editor.h"
#include "tilth/store/saved_ground.h"

namespace tilth::test {

/// A hill of 129 x 129 posts, detail in 4 x 4 tiles of 128 texels; what of it is another world can be changed.
struct ScriptWorld {
    HeightPrecision precision = HeightPrecision::bits32;
    const char* heights = "hill:size=129,peak=12,sigma=30";
    std::uint64_t undo_bytes = 64u << 20;

    [[nodiscard]] std::unique_ptr<Ground> ground() const {
        auto source = make_source(heights);
        auto made = Ground::create(std::shared_ptr<const HeightSource>(std::move(*source)),
                                   {.tile_size = 128, .precision = precision});
        return std::move(*made);
    }
};

/// The shape that is no built-in one: a ridge across the square.
inline ShapeId add_script_shape(ShapeLibrary& shapes) {
    if (const auto known = shapes.find("ridge")) return *known;
    return *shapes.bake("ridge", 32, [](double x, double z) { return (1 - x * x) * (1 - z * z * z * z); });
}

/// Edit number `n`, from 1, is the same in every run with this seed, wherever a run begins, but for one thing: where a
/// run begins within a stroke, a new stroke begins.
///
///     n mod 16   0 1 2 3   4 5 6 7    8      9    10   11    12     13   14    15
///                stamps    a stroke  stamp  undo undo redo  stamp  undo redo  stamp
class EditScript {
public:
    explicit EditScript(std::uint64_t seed) : seed_(seed) {}

    /// `world`: a SavedGround or a ReferenceWorld. False: it was refused, which no edit of a script should be.
    template <class World>
    bool step(World& world, std::uint64_t n) {
        switch (n % 16) {
            case 9:
            case 10:
            case 13:
                return world.undo().ok();
            case 11:
            case 14:
                return world.redo().ok();
            default:
                break;
        }
        if (n % 16 >= 4 && n % 16 <= 7 && !in_stroke_) {
            world.begin_stroke();
            in_stroke_ = true;
        }
        const bool done = world.stamp(request(n, world.ground())).ok();
        if (in_stroke_ && n % 16 == 7) {
            world.end_stroke();
            in_stroke_ = false;
        }
        return done;
    }

    [[nodiscard]] StampRequest request(std::uint64_t n, const Ground& ground) const {
        SplitMix64 random{seed_ * 0x9e3779b97f4a7c15u + n};
        const bool coarse = random.unit() < 0.3;
        RandomStamps one{.seed = random.next(), .count = 1};
        const double side = ground.map(MapKind::Coarse).grid.width;
        one.region = {WorldPos{-2, -2}, WorldPos{side + 1, side + 1}};
        one.radius_m = coarse ? std::array{4.0, 14.0} : std::array{0.2, 5.0};
        one.amplitude_m = coarse ? std::array{-2.0, 2.0} : std::array{-0.5, 0.5};
        // Now and then far too much, so that it saturates.
        if (random.unit() < 0.05) one.amplitude_m = coarse ? std::array{-60.0, 60.0} : std::array{-12.0, 12.0};
        one.map = coarse ? MapChoice::Coarse : MapChoice::Detail;
        for (std::uint32_t i = 0; i <= kBuiltinProfiles; ++i) one.shapes.push_back({i});
        one.rules = {StampRule::Add, StampRule::Min, StampRule::Max, StampRule::Set, StampRule::Smooth};
        return random_stamps(one, ground).front();
    }

private:
    std::uint64_t seed_;
    bool in_stroke_ = false;
};

/// A world without a disk: what every other must be equal to.
class ReferenceWorld {
public:
    explicit ReferenceWorld(const ScriptWorld& world, std::uint64_t seed)
        : seed_(seed), ground_(world.ground()), editor_(*ground_, nullptr, world.undo_bytes), script_(seed) {
        add_script_shape(ground_->shapes());
    }

    [[nodiscard]] const Ground& ground() const { return *ground_; }
    Result<StampRecord> stamp(const StampRequest& request) { return applied(editor_.stamp(request)); }
    Result<void> undo() { return applied(editor_.undo()); }
    Result<void> redo() { return applied(editor_.redo()); }
    void begin_stroke() { editor_.begin_stroke(); }
    void end_stroke() { editor_.end_stroke(); }
    [[nodiscard]] UndoHistory& history() { return editor_.history(); }

    /// Does edits until it has done `edits` of them.
    bool advance_to(std::uint64_t edits) {
        while (done_ < edits)
            if (!script_.step(*this, ++done_)) return false;
        return true;
    }
    /// The world that this is the reference of was closed and opened.
    void begin_run() {
        script_ = EditScript(seed_);
        editor_.end_stroke();
    }
    [[nodiscard]] std::uint64_t edits() const { return done_; }
    [[nodiscard]] StateHash hash() const { return ground_->hash(); }

private:
    template <class T>
    Result<T> applied(Result<T> result) {
        for (const GroundEdit& edit : editor_.take_queue()) apply_edit(*ground_, edit);
        editor_.applied();
        return result;
    }
    std::uint64_t seed_;
    std::unique_ptr<Ground> ground_;
    Editor editor_;
    EditScript script_;
    std::uint64_t done_ = 0;
};

/// Opens the script's world, its shape added.
inline Result<std::unique_ptr<SavedGround>> open_script_world(const ScriptWorld& world, const std::string& folder,
                                                              const WorldOptions& options) {
    auto opened = SavedGround::open(world.ground(), folder, options, world.undo_bytes);
    if (opened) add_script_shape((*opened)->shapes());
    return opened;
}

/// Edits of the script, from where the world stands until it has `edits`.
inline bool advance(SavedGround& world, EditScript& script, std::uint64_t edits) {
    while (world.world().appended() < edits)
        if (!script.step(world, world.world().appended() + 1)) return false;
    return true;
}

/// The messages, a line each.
inline std::string joined(const std::vector<Error>& errors) {
    std::string all;
    for (const Error& error : errors) all += error.message + "\n";
    return all;
}

}  // namespace tilth::test
