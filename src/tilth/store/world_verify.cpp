#include "tilth/store/world_verify.h"

#include <algorithm>
#include <set>
#include <utility>

#include "tilth/ground/shape_library.h"
#include "tilth/store/shape_files.h"
#include "tilth/store/world_blobs.h"
#include "tilth/store/world_identity.h"
#include "tilth/store/world_recovery.h"

namespace tilth {
namespace {

constexpr std::uint64_t kBlockEdits = 1u << 15;

class Verification {
public:
    explicit Verification(const VerifiedWorld& world) : world_(world) {}

    std::vector<Error> run() {
        note(read_identity(*world_.files, world_.folder));
        ShapeLibrary shapes;
        note(read_shapes(*world_.files, world_.folder, world_.salt, shapes));
        journal();
        for (const MapKind map : {MapKind::Coarse, MapKind::Detail})
            for (const PageIndex page : world_.pages->keys(map)) note(world_.pages->read(map, page));
        blobs();
        return std::move(errors_);
    }

private:
    template <class T>
    void note(const Result<T>& result) {
        if (!result) errors_.push_back(result.error());
    }

    void journal() {
        const std::uint64_t last = world_.journal->durable();
        for (std::uint64_t first = world_.journal->first(); first <= last; first += kBlockEdits)
            note(world_.journal->read(first, std::min(last, first + kBlockEdits - 1)));
    }

    void blobs() {
        if (const auto blob = world_.blobs->get(kCountersKey); !blob) {
            note(blob);
        } else if (*blob) {
            const auto counters = decode_counters(**blob, text(world_.folder, ": the world's counters"));
            note(counters);
            if (counters) strokes(*counters);
        } else if (world_.blobs->mark() > 0) {
            errors_.push_back({ErrorCode::FileFormat, text(world_.folder, ": the world's counters are gone")});
        }
        const auto waiting = world_.blobs->keys(BlobKind::Waiting);
        note(waiting);
        if (!waiting) return;
        for (const BlobKey& key : *waiting) {
            const auto blob = world_.blobs->get(key);
            note(blob);
            if (blob && *blob)
                note(decode_waiting(**blob,
                                    text(world_.folder, ": stamps that wait for tile (", key.x, ", ", key.z, ")")));
        }
    }

    void strokes(const WorldCounters& counters) {
        for (const auto* list : {&counters.done, &counters.undone})
            for (const std::uint64_t number : *list) note(read_stroke(*world_.blobs, number, world_.folder));
    }

    const VerifiedWorld& world_;
    std::vector<Error> errors_;
};

}  // namespace

std::vector<Error> verify_world(const VerifiedWorld& world) { return Verification(world).run(); }

}  // namespace tilth
