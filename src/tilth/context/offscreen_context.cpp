#include "tilth/context/offscreen_context.h"

#include <utility>

#include "tilth/context/implementation.h"

namespace tilth::context {
namespace {
/// The context of this library that is current on this thread. Each route's library knows only its own contexts and
/// answers "already current" although the other's has taken its place, so the old one is left first.
thread_local OffscreenContext::Implementation* current = nullptr;
}  // namespace

std::string_view name_of(Route route) { return route == Route::Egl ? "egl" : "osmesa"; }

Result<Route> route_of(std::string_view name) {
    if (name == "egl") return Route::Egl;
    if (name == "osmesa") return Route::Osmesa;
    return Error{ErrorCode::InvalidArgument, text("context route \"", name, "\": allowed are egl and osmesa")};
}

OffscreenContext::OffscreenContext(std::unique_ptr<Implementation> implementation)
    : implementation_(std::move(implementation)) {}
OffscreenContext::~OffscreenContext() {
    if (implementation_) release_current();
}
OffscreenContext::OffscreenContext(OffscreenContext&&) noexcept = default;
OffscreenContext& OffscreenContext::operator=(OffscreenContext&& other) noexcept {
    std::swap(implementation_, other.implementation_);
    return *this;
}

Result<OffscreenContext> OffscreenContext::create(Route route, const Options& options) {
    if (options.width < 1 || options.height < 1)
        return Error{ErrorCode::InvalidArgument,
                     text("context size: is ", options.width, " x ", options.height, ", must be at least 1 x 1")};
    auto created = route == Route::Egl ? make_egl(options) : make_osmesa(options);
    if (!created) return created.error();
    OffscreenContext offscreen(*std::move(created));
    if (Result<void> became = offscreen.make_current(); !became) return became.error();
    offscreen.implementation_->read_renderer();
    return offscreen;
}

Result<void> OffscreenContext::make_current() {
    if (current != nullptr && current != implementation_.get()) current->release_current();
    current = nullptr;
    if (Result<void> made = implementation_->make_current(); !made) return made;
    current = implementation_.get();
    return {};
}

void OffscreenContext::release_current() {
    implementation_->release_current();
    if (current == implementation_.get()) current = nullptr;
}

gl::GetProc OffscreenContext::get_proc() const { return implementation_->get_proc(); }
Route OffscreenContext::route() const { return implementation_->route(); }
const std::string& OffscreenContext::renderer() const { return implementation_->renderer; }
const std::string& OffscreenContext::platform() const { return implementation_->platform; }

void OffscreenContext::Implementation::read_renderer() {
    constexpr unsigned kGlRenderer = 0x1F01;
    using GetString = const unsigned char* (*)(unsigned);
    const auto get_string = reinterpret_cast<GetString>(get_proc()("glGetString"));
    const unsigned char* name = get_string != nullptr ? get_string(kGlRenderer) : nullptr;
    if (name != nullptr) renderer = reinterpret_cast<const char*>(name);
}

}  // namespace tilth::context
