// Which blobs a log holds: those that can be got, and those that the last commit has in their place.
#pragma once

#include <map>
#include <optional>

#include "tilth/store/log_format.h"

namespace tilth {

struct LogState {
    std::map<BlobKey, log_format::Entry> blobs;                   ///< what `get` sees
    std::map<BlobKey, std::optional<log_format::Entry>> pending;  ///< keys changed since the last commit: what it has
    std::uint64_t live_bytes = 0;                                 ///< of the payloads in `blobs`

    [[nodiscard]] std::optional<log_format::Entry> seen(const BlobKey& key) const {
        const auto found = blobs.find(key);
        return found == blobs.end() ? std::nullopt : std::optional(found->second);
    }
    [[nodiscard]] std::optional<log_format::Entry> committed(const BlobKey& key) const {
        const auto change = pending.find(key);
        return change == pending.end() ? seen(key) : change->second;
    }
    void set(const BlobKey& key, const std::optional<log_format::Entry>& entry) {
        const std::optional<log_format::Entry> old = seen(key);
        pending.try_emplace(key, old);
        live_bytes += (entry ? entry->length : 0) - (old ? std::uint64_t{old->length} : 0);
        if (entry)
            blobs[key] = *entry;
        else
            blobs.erase(key);
    }
    /// What is seen is committed.
    void settle(std::uint64_t mark) {
        for (const auto& [key, before] : pending)
            if (const auto blob = blobs.find(key); blob != blobs.end()) blob->second.mark = mark;
        pending.clear();
    }
    /// Of a file that holds this and no waste.
    [[nodiscard]] std::uint64_t least_file_bytes() const {
        std::uint64_t committed_blobs = blobs.size();
        std::uint64_t bytes = log_format::kFirstFrame + live_bytes + blobs.size() * log_format::kFrameHeaderBytes;
        for (const auto& [key, before] : pending) {
            const bool is_seen = blobs.contains(key);
            committed_blobs += std::uint64_t{before.has_value()} - std::uint64_t{is_seen};
            bytes += (before ? before->frame_bytes() : 0) + (is_seen ? 0 : log_format::kFrameHeaderBytes);
        }
        return bytes + log_format::index_frame_bytes(committed_blobs);
    }
};

}  // namespace tilth
