// A GL context without a window: for servers, tests, benchmarks and the headless demo.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "tilth/core/result.h"
#include "tilth/gl/get_proc.h"

namespace tilth::context {

/// Which system library makes the context. Both are loaded when asked for; neither is needed to link or to start.
enum class Route {
    Egl,     ///< libEGL.so.1: the surfaceless platform, else the first EGL device, else the default display
    Osmesa,  ///< libOSMesa.so.8 (Mesa removed it in 25.1): renders on the CPU into memory
};

/// "egl" or "osmesa", as flags and statistics write it.
std::string_view name_of(Route route);
/// The inverse. Fails with InvalidArgument naming what is allowed.
Result<Route> route_of(std::string_view name);

struct Options {
    int width = 64, height = 64;  ///< of OSMesa's default framebuffer; EGL's has none
    bool debug = false;           ///< asks for a debug context where the route has such a thing (EGL)
};

/// Owns a GL context of at least 3.3 core.
///
/// By EGL there is NO default framebuffer (its status is GL_FRAMEBUFFER_UNDEFINED): every draw needs a bound
/// framebuffer object, also with rasterisation off. Both routes may live in one process. One context is
/// current at a time on a thread: making one current leaves the last one made by this library; a context that the
/// host made otherwise must be left by the host.
/// Threads: current on one thread at a time; create and destroy on one thread.
class OffscreenContext {
public:
    /// Makes the context and makes it current on this thread. Fails with `GlContext`; the message says which library
    /// to install or what the driver refused.
    static Result<OffscreenContext> create(Route route, const Options& options = {});
    ~OffscreenContext();
    OffscreenContext(OffscreenContext&&) noexcept;
    OffscreenContext& operator=(OffscreenContext&&) noexcept;

    Result<void> make_current();
    void release_current();
    /// Looks up GL functions of this route; pass it to `Terrain::create`.
    [[nodiscard]] gl::GetProc get_proc() const;
    [[nodiscard]] Route route() const;
    [[nodiscard]] std::string_view route_name() const { return name_of(route()); }
    [[nodiscard]] const std::string& renderer() const;  ///< GL_RENDERER
    /// Which of the route's attempts worked, e.g. "surfaceless".
    [[nodiscard]] const std::string& platform() const;

    class Implementation;

private:
    explicit OffscreenContext(std::unique_ptr<Implementation> implementation);
    std::unique_ptr<Implementation> implementation_;
};

}  // namespace tilth::context
