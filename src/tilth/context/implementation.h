// PRIVATE: what a route has to provide.
#pragma once

#include <memory>
#include <string>

#include "tilth/context/offscreen_context.h"

namespace tilth::context {

class OffscreenContext::Implementation {
public:
    virtual ~Implementation() = default;
    virtual Result<void> make_current() = 0;
    virtual void release_current() = 0;
    [[nodiscard]] virtual gl::GetProc get_proc() const = 0;
    [[nodiscard]] virtual Route route() const = 0;
    void read_renderer();  ///< the context must be current

    std::string renderer, platform;
};

Result<std::unique_ptr<OffscreenContext::Implementation>> make_egl(const Options& options);
Result<std::unique_ptr<OffscreenContext::Implementation>> make_osmesa(const Options& options);

}  // namespace tilth::context
