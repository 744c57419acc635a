#include "tilth/store/world_recovery.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace tilth {
namespace {

// Strokes that are made again where nobody knows any more how many there were.
constexpr std::size_t kLeastStrokes = 16;

/// How many strokes below the ones it brings itself a tail undoes.
std::size_t depth_of_undo(std::span<const Edit> tail) {
    std::size_t depth = 0, done = 0;
    for (const Edit& edit : tail) {
        if (edit.kind == EditKind::Undo) {
            if (done > 0)
                --done;
            else
                ++depth;
        } else if (edit.kind == EditKind::Redo || edit.begins_stroke) {
            ++done;
        }
    }
    return depth;
}

}  // namespace

Result<StrokePtr> read_stroke(BlobStore& blobs, std::uint64_t number, const std::string& name) {
    const std::string where = text(name, ": stroke ", number, " of the undo history");
    std::vector<std::vector<std::byte>> content;
    for (std::uint32_t parts = 1; content.size() < parts;) {
        auto blob = get_blob(blobs, key_of_stroke(number, static_cast<std::uint32_t>(content.size())));
        if (!blob) return blob.error();
        if (!*blob) return Error{ErrorCode::FileFormat, text(where, ": part ", content.size(), " is gone")};
        content.push_back(std::move(**blob));
        if (content.size() > 1) continue;
        const auto all = parts_of_stroke(content.front(), where);
        if (!all) return all.error();
        parts = *all;
    }
    return decode_stroke(content, number, where);
}

Result<void> WorldRecovery::run(const std::vector<Error>& lost_blobs, RecoveredWorld& recovered) {
    out_ = &recovered;
    mark_ = blobs_.mark();
    if (const Result<void> read = read_counters(!lost_blobs.empty()); !read) return read;
    if (const Result<void> read = read_waiting(); !read) return read;
    if (const Result<void> read = read_coarse(); !read) return read;
    if (const Result<void> read = read_strokes(); !read) return read;
    if (!lost_blobs.empty())
        if (const Result<void> checked = check_everything(lost_blobs); !checked) return checked;
    recovered.next_sequence = counters_.next_sequence;
    recovered.next_stroke = counters_.next_stroke;
    if (history_is_cut_) drop_lost_turns();
    return {};
}

void WorldRecovery::report(const Error& damage, const std::string& outcome) {
    out_->reports.push_back({damage.code, text(damage.message, "; ", outcome)});
}

// ---------------------------------------------------------------------------------------------------- counters

Result<void> WorldRecovery::read_counters(bool may_be_old) {
    if (mark_ == 0) return {};
    const auto blob = get_blob(blobs_, kCountersKey);
    if (!blob && !is_damage(blob.error())) return blob.error();
    Error damage{ErrorCode::FileFormat, text(name_, ": the world's counters are gone from the store")};
    if (!blob) {
        damage = blob.error();
    } else if (*blob) {
        auto counters = decode_counters(**blob, text(name_, ": the world's counters"));
        if (counters && !may_be_old) {
            counters_ = std::move(*counters);
            return {};
        }
        damage = counters ? Error{ErrorCode::FileFormat, text(name_, ": the world's counters may be old ones")}
                          : counters.error();
        if (counters) {
            counters_.next_sequence = counters->next_sequence;
            counters_.next_stroke = counters->next_stroke;
        }
    }
    has_counters_ = false;
    const auto last = repair_.last_sequence(mark_);
    if (!last && !is_beyond_repair(last.error())) return last.error();
    if (last)
        counters_.next_sequence = std::max(counters_.next_sequence, *last + 1);
    else
        history_is_cut_ = true;
    report(damage, last ? "counted again from the journal; the undo history is shortened"
                        : "nothing from before the last save can be undone: " + last.error().message);
    return {};
}

/// Where they are lost: beyond everything that is known, so that no number is given twice.
Result<void> WorldRecovery::restore_counters() {
    const auto keys = blobs_.keys(BlobKind::Stroke);
    if (!keys) return keys.error();
    for (const BlobKey& key : *keys) counters_.next_stroke = std::max(counters_.next_stroke, stroke_of_key(key) + 1);
    const auto note = [&](const StampRecord& record) {
        counters_.next_sequence = std::max(counters_.next_sequence, record.sequence + 1);
    };
    for (const auto& [tile, stamps] : out_->waiting)
        for (const WaitingStamp& stamp : stamps) note(stamp.record);
    for (const BlobKey& key : *keys) {
        if (part_of_key(key) != 0) continue;
        const auto stroke = read_stroke(blobs_, stroke_of_key(key), name_);
        if (!stroke && !is_damage(stroke.error())) return stroke.error();
        if (stroke)
            for (const StampRecord& record : (*stroke)->records) note(record);
    }

    const auto strokes = repair_.strokes(mark_);
    if (!strokes) return is_beyond_repair(strokes.error()) ? Result<void>() : strokes.error();
    const std::size_t kept = std::min(strokes->done.size(), std::max(kLeastStrokes, depth_of_undo(out_->tail)));
    for (std::size_t i = 0; i < kept; ++i) counters_.done.push_back(counters_.next_stroke++);
    for (std::size_t i = 0; i < strokes->undone.size(); ++i) counters_.undone.push_back(counters_.next_stroke++);
    std::reverse(counters_.undone.begin(), counters_.undone.end());  // what was undone first was stamped last
    return {};
}

// ---------------------------------------------------------------------------------------------------- pages

Result<void> WorldRecovery::rebuild_tile(TileIndex tile) {
    const auto written = repair_.written(mark_, MapKind::Detail);
    if (!written) return written.error();
    std::set<PageIndex> wanted;
    for (const PageIndex page : *written)
        if (pages_.tile_of(page) == tile) wanted.insert(page);
    for (const PageIndex page : pages_.keys(tile)) wanted.insert(page);
    const auto rebuilt = repair_.pages(mark_, MapKind::Detail, wanted, {});
    if (!rebuilt) return rebuilt.error();
    for (const Page& page : *rebuilt)
        if (const Result<void> put = pages_.replace(MapKind::Detail, page); !put) return put;
    rebuilt_tiles_.insert(tile);
    return {};
}

Result<void> WorldRecovery::read_waiting() {
    const auto keys = blobs_.keys(BlobKind::Waiting);
    if (!keys) return keys.error();
    for (const BlobKey& key : *keys) {
        const TileIndex tile{key.x, key.z};
        const std::string where = text(name_, ": stamps that wait for tile (", tile.x, ", ", tile.z, ")");
        const auto blob = get_blob(blobs_, key);
        if (!blob && !is_damage(blob.error())) return blob.error();
        auto stamps = blob && *blob ? decode_waiting(**blob, where)
                                    : Result<std::vector<WaitingStamp>>(
                                          blob ? Error{ErrorCode::FileFormat, where + ": are gone"} : blob.error());
        // Without the counters their strokes get other numbers: they are better applied than never undone.
        if (stamps && (has_counters_ || history_is_cut_)) {
            out_->waiting.emplace(tile, std::move(*stamps));
            continue;
        }
        const Result<void> rebuilt = rebuild_tile(tile);
        if (!rebuilt && !is_beyond_repair(rebuilt.error())) return rebuilt;
        if (!stamps) {
            report(stamps.error(), rebuilt ? "the tile's pages were rebuilt with them from the journal"
                                           : "they are lost: " + rebuilt.error().message);
            ++(rebuilt ? out_->repaired : out_->lost);
        }
        if (const Result<void> erased = blobs_.erase(key); !erased) return erased;
    }
    return {};
}

Result<void> WorldRecovery::read_coarse() {
    auto found = pages_.load_coarse();
    if (!found) return found.error();
    out_->coarse = std::move(found->pages);
    if (found->damaged.empty()) return {};
    std::set<PageIndex> wanted;
    for (const auto& [page, error] : found->damaged) wanted.insert(page);
    auto rebuilt = repair_.pages(mark_, MapKind::Coarse, wanted, {});
    if (!rebuilt && !is_beyond_repair(rebuilt.error())) return rebuilt.error();
    for (const auto& [page, error] : found->damaged)
        report(error,
               rebuilt ? "rebuilt from the journal" : "lost, it reads as before any stamp: " + rebuilt.error().message);
    if (!rebuilt) {
        out_->lost += wanted.size();
        return {};
    }
    for (Page& page : *rebuilt) {
        if (const Result<void> put = pages_.replace(MapKind::Coarse, page); !put) return put;
        out_->coarse.push_back(std::move(page));
        ++out_->repaired;
    }
    return {};
}

/// The store lost blobs, nobody knows which. So every page is made again and compared; stamps that wait are applied.
Result<void> WorldRecovery::check_everything(const std::vector<Error>& lost_blobs) {
    const auto coarse = repair_.written(mark_, MapKind::Coarse), detail = repair_.written(mark_, MapKind::Detail);
    for (const auto* written : {&coarse, &detail})
        if (!*written && !is_beyond_repair(written->error())) return written->error();
    for (const Error& damage : lost_blobs)
        report(damage, mark_ == 0 ? "the world is as its original heights and the journal have it"
                       : detail   ? "everything was compared with the journal, and rebuilt where it differed"
                                  : "what lay there is lost and reads as untouched: " + detail.error().message);
    if (!coarse || !detail) {
        out_->lost += lost_blobs.size();
        return {};
    }
    std::map<TileIndex, std::set<PageIndex>> tiles;
    for (const PageIndex page : *detail) tiles[pages_.tile_of(page)].insert(page);
    for (const PageIndex page : pages_.keys(MapKind::Detail)) tiles[pages_.tile_of(page)].insert(page);
    for (const auto& [tile, pages] : tiles)
        if (const Result<void> checked = check_pages(MapKind::Detail, pages); !checked) return checked;
    for (const auto& [tile, stamps] : std::exchange(out_->waiting, {}))
        if (const Result<void> erased = blobs_.erase(key_of_waiting(tile)); !erased) return erased;

    out_->coarse.clear();
    std::set<PageIndex> all = *coarse;
    for (const PageIndex page : pages_.keys(MapKind::Coarse)) all.insert(page);
    return check_pages(MapKind::Coarse, all);
}

Result<void> WorldRecovery::check_pages(MapKind map, const std::set<PageIndex>& pages) {
    auto rebuilt = repair_.pages(mark_, map, pages, {});
    if (!rebuilt) return rebuilt.error();
    for (Page& page : *rebuilt) {
        const auto stored = pages_.has(map, page.index) ? pages_.read(map, page.index) : Result<Page>(Page{});
        if (!stored || stored->codes == nullptr || *stored->codes != *page.codes) {
            const bool had = pages_.has(map, page.index);
            if (const Result<void> put = pages_.replace(map, page); !put) return put;
            if (had || pages_.has(map, page.index)) ++out_->repaired;
        }
        if (map == MapKind::Coarse) out_->coarse.push_back(std::move(page));
    }
    return {};
}

// ---------------------------------------------------------------------------------------------------- strokes

Result<void> WorldRecovery::put_stroke(const Stroke& stroke) {
    const auto parts = encode_stroke(stroke, precision_);
    for (std::uint32_t i = 0; i < parts.size(); ++i)
        if (const Result<void> put = blobs_.put(key_of_stroke(stroke.number, i), parts[i]); !put) return put;
    std::uint32_t& known = stroke_parts_[stroke.number];
    known = std::max(known, static_cast<std::uint32_t>(parts.size()));
    return {};
}

/// From the journal: the stroke that is `from_last` places before the last of its list.
Result<StrokePtr> WorldRecovery::made_again(std::uint64_t number, bool is_done, std::size_t from_last) {
    const auto strokes = repair_.strokes(mark_);
    if (!strokes) return strokes.error();
    const auto& list = is_done ? strokes->done : strokes->undone;
    if (from_last >= list.size())
        return Error{ErrorCode::NotFound, text("the journal has ", list.size(), " strokes, too few")};
    const std::size_t place = list.size() - 1 - from_last;
    auto stroke = std::make_shared<Stroke>();
    stroke->number = number;
    stroke->records = list[place];
    // One that was undone takes its images when it is stamped again.
    if (is_done)
        if (const Result<void> added = repair_.add_images(*strokes, place, *stroke, out_->waiting); !added)
            return added.error();
    if (const Result<void> put = put_stroke(*stroke); !put) return put.error();
    return stroke;
}

Result<void> WorldRecovery::restore_list(const std::vector<std::uint64_t>& numbers, bool are_done,
                                         std::vector<StrokePtr>& out) {
    for (std::size_t i = numbers.size(); i-- > 0;) {  // the last first: damage cuts what is older
        const std::uint64_t number = numbers[i];
        auto stroke =
            has_counters_ ? read_stroke(blobs_, number, name_) : Result<StrokePtr>(Error{ErrorCode::FileFormat, ""});
        bool is_sound = stroke.ok();
        if (is_sound && are_done) {
            // What waited for a tile was stamped there meanwhile, by `rebuild_tile`: the stroke has no images of it.
            const auto lacks_images = repair_.reaches(mark_, **stroke, rebuilt_tiles_);
            if (!lacks_images) return lacks_images.error();
            if (*lacks_images)
                stroke = Error{ErrorCode::FileFormat,
                               text(name_, ": stroke ", number, " of the undo history lacks a tile that was rebuilt")};
        }
        if (stroke) {
            out.push_back(std::move(*stroke));
            continue;
        }
        if (!is_damage(stroke.error())) return stroke.error();
        auto again = made_again(number, are_done, numbers.size() - 1 - i);
        if (!again && !is_beyond_repair(again.error())) return again.error();
        if (has_counters_ && !(is_sound && again))  // that the tile was rebuilt has been told
            report(stroke.error(),
                   again ? "made again from the journal"
                         : text("the ", i + 1, are_done ? " oldest" : " next", " strokes can no longer be ",
                                are_done ? "undone" : "redone", ": ", again.error().message));
        if (!again) {
            history_is_cut_ = true;
            break;
        }
        out.push_back(std::move(*again));
    }
    std::reverse(out.begin(), out.end());
    return {};
}

Result<void> WorldRecovery::read_strokes() {
    const auto keys = blobs_.keys(BlobKind::Stroke);
    if (!keys) return keys.error();
    for (const BlobKey& key : *keys) {
        std::uint32_t& parts = stroke_parts_[stroke_of_key(key)];
        parts = std::max(parts, part_of_key(key) + 1);
    }
    if (!has_counters_)
        if (const Result<void> restored = restore_counters(); !restored) return restored;
    if (const Result<void> restored = restore_list(counters_.done, true, out_->done); !restored) return restored;
    return restore_list(counters_.undone, false, out_->undone);
}

/// Undoing what is not there any more. The same is dropped at every opening, until the next save.
void WorldRecovery::drop_lost_turns() {
    using Stack = std::vector<std::uint64_t>;  // first sequence numbers of strokes
    const auto firsts = [](const std::vector<StrokePtr>& strokes) {
        Stack stack;
        for (const StrokePtr& stroke : strokes) stack.push_back(stroke->records.front().sequence);
        return stack;
    };
    Stack done = firsts(out_->done), undone = firsts(out_->undone);
    std::erase_if(out_->tail, [&](const Edit& edit) {
        if (edit.kind == EditKind::Stamp) {
            undone.clear();
            if (edit.begins_stroke) done.push_back(edit.record.sequence);
            return false;
        }
        Stack& from = edit.kind == EditKind::Undo ? done : undone;
        Stack& to = edit.kind == EditKind::Undo ? undone : done;
        if (!from.empty() && from.back() == edit.record.sequence) {
            to.push_back(from.back());
            from.pop_back();
            return false;
        }
        out_->reports.push_back(
            {ErrorCode::FileFormat, text(name_, ": the stroke that begins with stamp ", edit.record.sequence,
                                         " could not be ", edit.kind == EditKind::Undo ? "undone" : "redone",
                                         " again, for that part of the undo history is lost")});
        return true;
    });
}

}  // namespace tilth
