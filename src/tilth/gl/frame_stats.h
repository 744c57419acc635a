// What a frame cost, in integers that tests can assert on ("untouched ground runs 0 passes"). No GL header.
#pragma once

#include <cstdint>

namespace tilth::gl {

/// The cost of one stage. Counts are exact and the same on every driver; only the two times depend on the machine.
struct StageStats {
    std::uint64_t passes = 0;      ///< framebuffer bindings that were drawn to
    std::uint64_t draws = 0;       ///< draw calls
    std::uint64_t primitives = 0;  ///< triangles handed to GL, before culling and refinement
    std::uint64_t texels = 0;      ///< texels written (of one target, when a pass writes several)
    std::uint64_t bytes = 0;       ///< bytes written to textures and buffers
    std::uint64_t programs = 0;    ///< GL programs linked
    std::uint64_t saturated = 0;   ///< texels that reached the end of their range
    std::uint64_t fallbacks = 0;   ///< times that a slower way was taken because the faster one was not to be had
    double cpu_ms = 0;             ///< wall time of the calling thread

    StageStats& operator+=(const StageStats& other) {
        passes += other.passes, draws += other.draws, primitives += other.primitives, texels += other.texels;
        bytes += other.bytes, programs += other.programs, saturated += other.saturated, fallbacks += other.fallbacks;
        cpu_ms += other.cpu_ms;
        return *this;
    }
    friend bool operator==(const StageStats&, const StageStats&) = default;
};

/// Bytes that crossed between the CPU and GL.
struct TransferStats {
    std::uint64_t bytes_up = 0, bytes_down = 0;

    TransferStats& operator+=(const TransferStats& other) {
        bytes_up += other.bytes_up, bytes_down += other.bytes_down;
        return *this;
    }
    friend bool operator==(const TransferStats&, const TransferStats&) = default;
};

/// What the tile cache did.
struct CacheStats {
    std::uint64_t loads = 0;           ///< tiles whose codes came from the store
    std::uint64_t saves = 0;           ///< tiles written to the store
    std::uint64_t evictions = 0;       ///< tiles that gave their textures up
    std::uint64_t rescues = 0;         ///< tiles on their way out that were wanted again in time
    std::uint64_t cancelled = 0;       ///< loads given up before the store began with them
    std::uint64_t failures = 0;        ///< requests that the store refused, retries included
    std::uint64_t late_stamps = 0;     ///< stamps applied to a tile that arrived after them
    std::uint64_t missing_active = 0;  ///< tiles that a frame should have sampled and that were not resident, summed
    double transfer_ms = 0;            ///< wall time of the calling thread, spent on filling tiles

    CacheStats& operator+=(const CacheStats& other) {
        loads += other.loads, saves += other.saves, evictions += other.evictions, rescues += other.rescues;
        cancelled += other.cancelled, failures += other.failures, late_stamps += other.late_stamps;
        missing_active += other.missing_active, transfer_ms += other.transfer_ms;
        return *this;
    }
    friend bool operator==(const CacheStats&, const CacheStats&) = default;
};

/// What the world on disk cost the frame.
struct StoreStats {
    std::uint64_t snapshots = 0;    ///< that became durable
    std::uint64_t compactions = 0;  ///< steps
    std::uint64_t failures = 0;     ///< snapshots that could not be written, retries included
    double snapshot_ms = 0;         ///< wall time of the calling thread, spent on taking snapshots

    StoreStats& operator+=(const StoreStats& other) {
        snapshots += other.snapshots, compactions += other.compactions, failures += other.failures;
        snapshot_ms += other.snapshot_ms;
        return *this;
    }
    friend bool operator==(const StoreStats&, const StoreStats&) = default;
};

/// One frame, or the sum of many.
struct FrameStats {
    StageStats deform, derive, mips, render;
    TransferStats transfer;
    CacheStats cache;
    StoreStats store;

    [[nodiscard]] std::uint64_t fallbacks() const {
        return deform.fallbacks + derive.fallbacks + mips.fallbacks + render.fallbacks;
    }
    FrameStats& operator+=(const FrameStats& other) {
        deform += other.deform, derive += other.derive, mips += other.mips, render += other.render;
        transfer += other.transfer, cache += other.cache, store += other.store;
        return *this;
    }
    friend bool operator==(const FrameStats&, const FrameStats&) = default;
};

}  // namespace tilth::gl
