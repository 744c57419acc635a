// OSMesa through dlopen. The few names of it that are needed stand here, so no header is needed to build.
#include <dlfcn.h>

#include <array>
#include <cstdint>
#include <vector>

#include "tilth/context/implementation.h"

namespace tilth::context {
namespace {

using Context = void*;

// From GL/osmesa.h (Mesa 11.2 and later have the attributes).
constexpr int kFormat = 0x22;
constexpr int kDepthBits = 0x30;
constexpr int kStencilBits = 0x31;
constexpr int kProfile = 0x33;
constexpr int kCoreProfile = 0x34;
constexpr int kContextMajorVersion = 0x36;
constexpr int kContextMinorVersion = 0x37;
constexpr int kRgba = 0x1908;               // GL_RGBA
constexpr unsigned kUnsignedByte = 0x1401;  // GL_UNSIGNED_BYTE

struct Osmesa {
    void* library = nullptr;
    Context (*CreateContextAttribs)(const int*, Context) = nullptr;
    void (*DestroyContext)(Context) = nullptr;
    unsigned char (*MakeCurrent)(Context, void*, unsigned, int, int) = nullptr;
    Context (*GetCurrentContext)() = nullptr;
    void* (*GetProcAddress)(const char*) = nullptr;
};

template <class Function>
bool find(void* library, const char* name, Function& function) {
    function = reinterpret_cast<Function>(dlsym(library, name));
    return function != nullptr;
}

/// Loaded once and kept: its rasteriser threads and thread-exit handlers outlive a context.
const Osmesa* osmesa() {
    static const Osmesa loaded = [] {
        Osmesa o;
        for (const char* name : {"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"}) {
            // RTLD_LOCAL: the GL entry points of two front ends do not meet.
            o.library = dlopen(name, RTLD_NOW | RTLD_LOCAL);
            if (o.library == nullptr) continue;
            if (find(o.library, "OSMesaCreateContextAttribs", o.CreateContextAttribs) &&
                find(o.library, "OSMesaDestroyContext", o.DestroyContext) &&
                find(o.library, "OSMesaMakeCurrent", o.MakeCurrent) &&
                find(o.library, "OSMesaGetCurrentContext", o.GetCurrentContext) &&
                find(o.library, "OSMesaGetProcAddress", o.GetProcAddress))
                return o;
            o.library = nullptr;
        }
        return o;
    }();
    return loaded.library != nullptr ? &loaded : nullptr;
}

class OsmesaContext final : public OffscreenContext::Implementation {
public:
    OsmesaContext(const Osmesa& osmesa, Context context, int width, int height)
        : osmesa_(osmesa),
          context_(context),
          width_(width),
          height_(height),
          pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 4) {
        platform = "osmesa";
    }
    ~OsmesaContext() override {
        release_current();
        osmesa_.DestroyContext(context_);
    }
    Result<void> make_current() override {
        if (osmesa_.MakeCurrent(context_, pixels_.data(), kUnsignedByte, width_, height_) != 0) return {};
        return Error{ErrorCode::GlContext,
                     text("OSMesa: OSMesaMakeCurrent refused a buffer of ", width_, " x ", height_, " RGBA8 pixels")};
    }
    void release_current() override {
        if (osmesa_.GetCurrentContext() == context_) osmesa_.MakeCurrent(nullptr, nullptr, 0, 0, 0);
    }
    [[nodiscard]] gl::GetProc get_proc() const override { return osmesa_.GetProcAddress; }
    [[nodiscard]] Route route() const override { return Route::Osmesa; }

private:
    const Osmesa& osmesa_;
    Context context_;
    int width_, height_;
    std::vector<unsigned char> pixels_;  ///< the default framebuffer
};

}  // namespace

Result<std::unique_ptr<OffscreenContext::Implementation>> make_osmesa(const Options& options) {
    const Osmesa* o = osmesa();
    if (o == nullptr)
        return Error{ErrorCode::GlContext,
                     "OSMesa: libOSMesa.so.8 cannot be loaded; install it (Debian 12: libosmesa6; Mesa 25.1 and later "
                     "no longer have it) or use the egl route"};
    const std::array<int, 13> attributes{kFormat,  kRgba,        kDepthBits,           24, kStencilBits,         8,
                                         kProfile, kCoreProfile, kContextMajorVersion, 3,  kContextMinorVersion, 3,
                                         0};
    Context context = o->CreateContextAttribs(attributes.data(), nullptr);
    if (context == nullptr)
        return Error{ErrorCode::GlContext, "OSMesa: no GL 3.3 core context; needs Mesa 11.2 or later with llvmpipe"};
    std::unique_ptr<OffscreenContext::Implementation> made =
        std::make_unique<OsmesaContext>(*o, context, options.width, options.height);
    return made;
}

}  // namespace tilth::context
