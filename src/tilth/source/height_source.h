// The original heights of a world, before anybody dented it.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/world/texel.h"

namespace tilth {

/// Heights in metres on a grid of posts. Implementations are immutable: const calls from any thread.
class HeightSource {
public:
    virtual ~HeightSource() = default;

    [[nodiscard]] virtual std::int32_t width() const = 0;  ///< posts along +x, >= 2
    [[nodiscard]] virtual std::int32_t depth() const = 0;  ///< posts along +z, >= 2

    /// Lowest and highest height of the whole source, metres. Exact, not a bound.
    [[nodiscard]] virtual double min_m() const = 0;
    [[nodiscard]] virtual double max_m() const = 0;

    /// Height of post `t`, metres, finite. `t` lies inside the source.
    [[nodiscard]] virtual double height_m(Texel t) const = 0;
};

}  // namespace tilth
