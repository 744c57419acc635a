// Textures of tiles in plain memory, that act as the GPU's would: late, and now and then not at all.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <map>
#include <set>
#include <vector>

#include "tilth/cache/tile_textures.h"
#include "tilth/ground/cpu_executor.h"
#include "tilth/ground/random_stamps.h"

namespace tilth::test {

/// How the fake GPU misbehaves. Chances are one in so many; 0: never.
struct FakeTrouble {
    std::uint64_t acquire_refused = 0;    ///< no textures are free now
    std::uint64_t fill_refused = 0;       ///< the ring is full now
    std::uint64_t read_back_refused = 0;  ///< the ring is full now
    std::uint64_t read_back_lost = 0;     ///< the driver lost it
    std::uint64_t stamp_fails = 0;        ///< a pass fails behind some of its stamps
    std::uint64_t most_read_back_frames = 3;
};

/// A tile's textures are its stored rectangle, clipped to the map, in codes of its own. A stamp knows nothing beyond
/// the rectangle, so `smooth` is wrong at its outer ring until `exchange`; read-backs hold the codes of the call that
/// began them and arrive frames later.
class FakeTextures final : public TileTextures {
public:
    FakeTextures(const TileGrid& grid, std::uint64_t seed, const FakeTrouble& trouble = {})
        : grid_(grid), trouble_(trouble), random_{seed} {}

    void begin_frame() {
        ++frame_;
        quiet_ = false;
    }
    /// From now on nothing goes wrong or takes long (false: as set).
    void behave(bool well) { well_ = well; }
    /// At most so many tiles; 0: any number.
    void set_most_tiles(std::size_t most) { most_tiles_ = most; }

    [[nodiscard]] bool has(TileIndex tile) const { return sets_.contains(tile); }
    [[nodiscard]] std::size_t count() const { return sets_.size(); }
    [[nodiscard]] std::uint64_t acquired() const { return acquired_; }
    [[nodiscard]] std::uint64_t passes() const { return passes_; }
    [[nodiscard]] std::uint64_t read_backs() const { return read_backs_; }
    [[nodiscard]] TexelRect held(TileIndex tile) const { return intersection(grid_.stored(tile), grid_.map); }
    [[nodiscard]] std::uint32_t code(TileIndex tile, Texel t) const { return sets_.at(tile).codes.code(t); }
    /// Texels of the tile's textures, aprons included, that are not those of `field`.
    [[nodiscard]] std::int64_t differences(TileIndex tile, const DetailField& field) const {
        const TexelRect rect = held(tile);
        std::vector<std::uint32_t> here(static_cast<std::size_t>(rect.count())), there(here.size());
        sets_.at(tile).codes.copy(rect, here.data(), static_cast<std::size_t>(rect.width()));
        field.copy(rect, there.data(), static_cast<std::size_t>(rect.width()));
        std::int64_t different = 0;
        for (std::size_t i = 0; i < here.size(); ++i) different += here[i] != there[i];
        return different;
    }

    bool acquire(TileIndex tile) override {
        EXPECT_TRUE(grid_.exists(tile)) << tile.x << " " << tile.z;
        EXPECT_FALSE(has(tile)) << "acquired twice: " << tile.x << " " << tile.z;
        if (most_tiles_ != 0 && sets_.size() >= most_tiles_) return false;
        if (fails(trouble_.acquire_refused)) return false;
        ++acquired_;
        sets_[tile];
        return true;
    }
    void release(TileIndex tile) override {
        const auto found = sets_.find(tile);
        ASSERT_NE(found, sets_.end()) << "released without textures: " << tile.x << " " << tile.z;
        EXPECT_FALSE(found->second.reading) << "released with a read-back on its way";
        sets_.erase(found);
    }

    bool fill(TileIndex tile, const TexelRect& rect, const DetailField& field, bool paging) override {
        EXPECT_TRUE(has(tile)) << tile.x << " " << tile.z;
        EXPECT_FALSE(rect.empty());
        EXPECT_EQ(intersection(rect, grid_.stored(tile)), rect) << "beyond the textures";
        if (!has(tile) || (paging && fails(trouble_.fill_refused))) return false;
        copy(field, sets_[tile].codes, intersection(rect, grid_.map));
        return true;
    }

    Result<void> stamp(std::span<const PreparedStamp> stamps, std::span<const TileIndex> tiles,
                       std::size_t& applied) override {
        ++passes_;
        applied = 0;
        std::set<TileIndex> once(tiles.begin(), tiles.end());
        EXPECT_EQ(once.size(), tiles.size());
        for (const PreparedStamp& stamp : stamps) {
            EXPECT_TRUE(stamp.reads_own_texel_only() || stamps.size() == 1) << "smooth comes alone";
            if (fails(trouble_.stamp_fails)) return Error{ErrorCode::OutOfMemory, "the test lets this pass fail"};
            for (const TileIndex tile : tiles) {
                EXPECT_TRUE(has(tile)) << tile.x << " " << tile.z;
                if (has(tile)) apply_stamp(stamp, sets_[tile].codes, held(tile));
            }
            ++applied;
        }
        return {};
    }
    /// Exactly: by doing it, on a copy.
    [[nodiscard]] std::size_t first_that_may_saturate(std::span<const PreparedStamp> stamps,
                                                      std::span<const TileIndex> tiles) const override {
        std::size_t first = stamps.size();
        for (const TileIndex tile : tiles) {
            const TexelRect inside = intersection(grid_.interior(tile), grid_.map);
            DetailField codes;
            copy(sets_.at(tile).codes, codes, inside);
            for (std::size_t i = 0; i < first; ++i)
                if (apply_stamp(stamps[i], codes, inside).saturated > 0) first = i;
        }
        return first;
    }
    [[nodiscard]] CodeRange bounds(TileIndex tile, const TexelRect& rect) const override {
        return range_in(sets_.at(tile).codes, rect);
    }
    void exchange(TileIndex from, TileIndex to, const TexelRect& rect) override {
        ASSERT_TRUE(has(from) && has(to));
        EXPECT_EQ(intersection(rect, grid_.interior(from)), rect) << "not the owner's";
        EXPECT_EQ(intersection(rect, grid_.stored(to)), rect) << "beyond the textures";
        copy(sets_[from].codes, sets_[to].codes, intersection(rect, grid_.map));
    }

    bool begin_read_back(TileIndex tile, std::span<const TexelRect> rects) override {
        EXPECT_TRUE(has(tile));
        Set& set = sets_[tile];
        EXPECT_FALSE(set.reading) << "one read-back a tile at a time";
        if (fails(trouble_.read_back_refused)) return false;
        ++read_backs_;
        set.reading = true;
        set.ready = frame_ + (well_ ? 0 : random_.next() % (trouble_.most_read_back_frames + 1));
        set.rounds = random_.next() % 3;
        set.rects.assign(rects.begin(), rects.end());
        set.snapshot = DetailField();
        for (const TexelRect& rect : rects) {
            EXPECT_EQ(intersection(rect, held(tile)), rect);
            copy(set.codes, set.snapshot, rect);
        }
        return true;
    }
    ReadBackState poll_read_back(TileIndex tile, DetailField& field) override {
        EXPECT_TRUE(has(tile));
        Set& set = sets_[tile];
        if (!set.reading) return ReadBackState::None;
        if (frame_ < set.ready) return ReadBackState::Pending;
        if (set.rounds > 0) {  // a large one goes through the ring in several parts
            --set.rounds;
            return ReadBackState::Pending;
        }
        set.reading = false;
        if (fails(trouble_.read_back_lost)) return ReadBackState::Failed;
        for (const TexelRect& rect : set.rects) copy(set.snapshot, field, rect);
        return ReadBackState::Done;
    }
    void read_back_now(TileIndex tile, std::span<const TexelRect> rects, DetailField& field) override {
        ASSERT_TRUE(has(tile));
        for (const TexelRect& rect : rects) copy(sets_[tile].codes, field, rect);
    }
    void finish() override {
        for (auto& [tile, set] : sets_) set.ready = frame_;
        quiet_ = true;
    }

private:
    struct Set {
        DetailField codes, snapshot;
        std::vector<TexelRect> rects;
        std::uint64_t ready = 0, rounds = 0;
        bool reading = false;
    };

    bool fails(std::uint64_t one_in) { return !well_ && !quiet_ && one_in != 0 && random_.next() % one_in == 0; }

    static void copy(const DetailField& from, DetailField& to, const TexelRect& rect) {
        const PageRect pages = pages_of(rect);
        for (std::int32_t pz = pages.min.z; pz < pages.max.z; ++pz)
            for (std::int32_t px = pages.min.x; px < pages.max.x; ++px) {
                const TexelRect page = texels_of(PageIndex{px, pz}), part = intersection(page, rect);
                if (from.find({px, pz}) == nullptr && to.find({px, pz}) == nullptr) continue;
                const std::size_t first =
                    static_cast<std::size_t>((part.min.z - page.min.z) * kPageTexels + part.min.x - page.min.x);
                from.copy(part, to.touch({px, pz}).data() + first, kPageTexels);
            }
    }

    const TileGrid grid_;
    const FakeTrouble trouble_;
    SplitMix64 random_;
    std::map<TileIndex, Set> sets_;
    std::uint64_t frame_ = 0, acquired_ = 0, passes_ = 0, read_backs_ = 0;
    std::size_t most_tiles_ = 0;
    bool well_ = false, quiet_ = false;
};

}  // namespace tilth::test
