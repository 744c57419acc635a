// Puts the host's GL state back as it was.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "tilth/gl/device.h"

namespace tilth::gl {

/// Texture units and indexed uniform bindings that the library may use; those above are never touched.
inline constexpr int kTouchedTextureUnits = 16;
inline constexpr int kTouchedUniformBindings = 8;
inline constexpr int kTouchedDrawBuffers = 8;

/// One value of saved state. Each entry knows which member it uses.
union StateSlot {
    std::int64_t integer;
    double real;
};

/// One piece of GL state that the library may change. `save` fills `slots` slots, `restore` puts them back.
struct TouchedState {
    std::string_view name;
    int slots;
    void (*save)(const Device& device, StateSlot* slots);
    void (*restore)(const Device& device, const StateSlot* slots);
};

/// Everything that any class of the library may change, in the order in which it is restored. Read by the guard and
/// by its test. What is not in this list must not be touched. Not covered, and not touched: textures of other
/// targets, draw and read buffers of the host's framebuffers, stencil functions, hints, queries and transform
/// feedback in progress (end them, or pause them, before calling the library).
std::span<const TouchedState> touched_state();

/// Slots of the whole table, at most.
inline constexpr std::size_t kMaxStateSlots = 512;

/// Saves `touched_state()` on construction and restores it on destruction. One stands in each public function that
/// talks to GL under `StatePolicy::preserve`. Measured on llvmpipe: see tests/gl; a driver that runs GL on another
/// thread has to wait for it here, which `StatePolicy::invalidate` avoids.
class StateGuard {
public:
    explicit StateGuard(const Device& device) : StateGuard(device, touched_state()) {}
    /// Guards only `entries`; for the guard's own test.
    StateGuard(const Device& device, std::span<const TouchedState> entries);
    ~StateGuard();
    StateGuard(const StateGuard&) = delete;
    StateGuard& operator=(const StateGuard&) = delete;

private:
    const Device& device_;
    std::span<const TouchedState> entries_;
    std::array<StateSlot, kMaxStateSlots> slots_;
};

}  // namespace tilth::gl
