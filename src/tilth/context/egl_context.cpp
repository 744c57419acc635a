// EGL through dlopen. The few names of EGL that are needed stand here, so no EGL header is needed to build.
#include <dlfcn.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <vector>

#include "tilth/context/implementation.h"

namespace tilth::context {
namespace {

using EglInt = std::int32_t;
using EglBool = unsigned;
using EglEnum = unsigned;
using Handle = void*;  // EGLDisplay, EGLConfig, EGLContext, EGLDeviceEXT

// From the Khronos registry (EGL 1.5).
constexpr EglInt kNone = 0x3038;
constexpr EglInt kSurfaceType = 0x3033;
constexpr EglInt kPbufferBit = 0x0001;
constexpr EglInt kRenderableType = 0x3040;
constexpr EglInt kOpenglBit = 0x0008;
constexpr EglInt kExtensions = 0x3055;
constexpr EglEnum kOpenglApi = 0x30A2;
constexpr EglInt kContextMajorVersion = 0x3098;
constexpr EglInt kContextMinorVersion = 0x30FB;
constexpr EglInt kContextProfileMask = 0x30FD;
constexpr EglInt kContextCoreProfileBit = 0x0001;
constexpr EglInt kContextFlags = 0x30FC;     // EGL_KHR_create_context
constexpr EglInt kContextDebugBit = 0x0001;  // EGL_KHR_create_context
constexpr EglEnum kPlatformSurfacelessMesa = 0x31DD;
constexpr EglEnum kPlatformDevice = 0x313F;

struct Egl {
    void* library = nullptr;
    void* (*GetProcAddress)(const char*) = nullptr;
    const char* (*QueryString)(Handle, EglInt) = nullptr;
    EglInt (*GetError)() = nullptr;
    Handle (*GetDisplay)(void*) = nullptr;
    EglBool (*Initialize)(Handle, EglInt*, EglInt*) = nullptr;
    EglBool (*BindAPI)(EglEnum) = nullptr;
    EglBool (*ChooseConfig)(Handle, const EglInt*, Handle*, EglInt, EglInt*) = nullptr;
    Handle (*CreateContext)(Handle, Handle, Handle, const EglInt*) = nullptr;
    EglBool (*DestroyContext)(Handle, Handle) = nullptr;
    EglBool (*MakeCurrent)(Handle, Handle, Handle, Handle) = nullptr;
    Handle (*GetCurrentContext)() = nullptr;
    Handle (*GetPlatformDisplayEXT)(EglEnum, void*, const EglInt*) = nullptr;  ///< may be null
    EglBool (*QueryDevicesEXT)(EglInt, Handle*, EglInt*) = nullptr;            ///< may be null
};

template <class Function>
bool find(void* library, const char* name, Function& function) {
    function = reinterpret_cast<Function>(dlsym(library, name));
    return function != nullptr;
}

/// Loaded once and kept: EGL installs thread-exit handlers, so its library must not be unloaded.
const Egl* egl() {
    static const Egl loaded = [] {
        Egl e;
        // RTLD_LOCAL: the GL entry points of two front ends do not meet.
        e.library = dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
        if (e.library == nullptr) return e;
        const bool complete =
            find(e.library, "eglGetProcAddress", e.GetProcAddress) &&
            find(e.library, "eglQueryString", e.QueryString) && find(e.library, "eglGetError", e.GetError) &&
            find(e.library, "eglGetDisplay", e.GetDisplay) && find(e.library, "eglInitialize", e.Initialize) &&
            find(e.library, "eglBindAPI", e.BindAPI) && find(e.library, "eglChooseConfig", e.ChooseConfig) &&
            find(e.library, "eglCreateContext", e.CreateContext) &&
            find(e.library, "eglDestroyContext", e.DestroyContext) &&
            find(e.library, "eglMakeCurrent", e.MakeCurrent) &&
            find(e.library, "eglGetCurrentContext", e.GetCurrentContext);
        if (!complete) {
            e.library = nullptr;
            return e;
        }
        const auto extension = [&](const char* name) { return e.GetProcAddress(name); };
        e.GetPlatformDisplayEXT =
            reinterpret_cast<decltype(e.GetPlatformDisplayEXT)>(extension("eglGetPlatformDisplayEXT"));
        e.QueryDevicesEXT = reinterpret_cast<decltype(e.QueryDevicesEXT)>(extension("eglQueryDevicesEXT"));
        return e;
    }();
    return loaded.library != nullptr ? &loaded : nullptr;
}

/// Whether the space-separated `list` holds the whole word `name`.
bool has_word(const char* list, std::string_view name) {
    std::string_view rest = list != nullptr ? list : "";
    while (!rest.empty()) {
        const auto space = rest.find(' ');
        if (rest.substr(0, space) == name) return true;
        rest = space == std::string_view::npos ? std::string_view{} : rest.substr(space + 1);
    }
    return false;
}

std::string hex(EglInt error) {
    constexpr const char* digits = "0123456789abcdef";
    std::string text = "0x0000";
    for (std::size_t i = 0; i < 4; ++i) text[5 - i] = digits[(error >> (4 * i)) & 15];
    return text;
}

struct Attempt {
    const char* platform;
    Handle display;
};

std::vector<Attempt> displays(const Egl& e) {
    std::vector<Attempt> attempts;
    const char* client = e.QueryString(nullptr, kExtensions);
    if (e.GetPlatformDisplayEXT != nullptr && has_word(client, "EGL_MESA_platform_surfaceless"))
        attempts.push_back({"surfaceless", e.GetPlatformDisplayEXT(kPlatformSurfacelessMesa, nullptr, nullptr)});
    if (e.GetPlatformDisplayEXT != nullptr && e.QueryDevicesEXT != nullptr &&
        has_word(client, "EGL_EXT_platform_device")) {
        std::array<Handle, 1> devices{};
        EglInt count = 0;
        if (e.QueryDevicesEXT(1, devices.data(), &count) != 0 && count > 0)
            attempts.push_back({"device", e.GetPlatformDisplayEXT(kPlatformDevice, devices[0], nullptr)});
    }
    attempts.push_back({"default display", e.GetDisplay(nullptr)});
    return attempts;
}

class EglContext final : public OffscreenContext::Implementation {
public:
    EglContext(const Egl& egl, Handle display, Handle context) : egl_(egl), display_(display), context_(context) {}
    ~EglContext() override {
        release_current();
        // The display stays initialised: it may be shared with the host's own use of EGL.
        egl_.DestroyContext(display_, context_);
    }
    Result<void> make_current() override {
        egl_.BindAPI(kOpenglApi);  // is per thread
        if (egl_.MakeCurrent(display_, nullptr, nullptr, context_) != 0) return {};
        return Error{ErrorCode::GlContext, text("EGL: eglMakeCurrent without a surface failed with ",
                                                hex(egl_.GetError()), " on platform ", platform)};
    }
    void release_current() override {
        if (egl_.GetCurrentContext() == context_) egl_.MakeCurrent(display_, nullptr, nullptr, nullptr);
    }
    [[nodiscard]] gl::GetProc get_proc() const override { return egl_.GetProcAddress; }
    [[nodiscard]] Route route() const override { return Route::Egl; }

private:
    const Egl& egl_;
    Handle display_, context_;
};

/// One attempt: initialise the display and create a context. The error names the call that failed.
Result<Handle> context_on(const Egl& e, Handle display, bool debug) {
    const auto failed = [&](const char* call) {
        return Error{ErrorCode::GlContext, text(call, " failed with ", hex(e.GetError()))};
    };
    if (display == nullptr) return failed("getting the display");
    EglInt major = 0, minor = 0;
    if (e.Initialize(display, &major, &minor) == 0) return failed("eglInitialize");
    const char* extensions = e.QueryString(display, kExtensions);
    if (!has_word(extensions, "EGL_KHR_surfaceless_context"))
        return Error{ErrorCode::GlContext, "EGL_KHR_surfaceless_context is missing"};
    if (e.BindAPI(kOpenglApi) == 0) return failed("eglBindAPI(OpenGL)");

    // Without asking for a surface type, the default would be a window, which surfaceless has not.
    const std::array<EglInt, 5> wanted{kSurfaceType, kPbufferBit, kRenderableType, kOpenglBit, kNone};
    Handle config = nullptr;
    EglInt count = 0;
    if (e.ChooseConfig(display, wanted.data(), &config, 1, &count) == 0 || count < 1) {
        if (!has_word(extensions, "EGL_KHR_no_config_context")) return failed("eglChooseConfig");
        config = nullptr;
    }
    std::vector<EglInt> attributes{kContextMajorVersion,  3, kContextMinorVersion, 3, kContextProfileMask,
                                   kContextCoreProfileBit};
    if (debug) attributes.insert(attributes.end(), {kContextFlags, kContextDebugBit});
    attributes.push_back(kNone);
    Handle context = e.CreateContext(display, config, nullptr, attributes.data());
    if (context == nullptr) return failed("eglCreateContext (GL 3.3 core)");
    return context;
}

}  // namespace

Result<std::unique_ptr<OffscreenContext::Implementation>> make_egl(const Options& options) {
    const Egl* e = egl();
    if (e == nullptr)
        return Error{ErrorCode::GlContext,
                     "EGL: libEGL.so.1 cannot be loaded; install it (Debian: libegl1 with libegl-mesa0 or the GPU "
                     "driver's EGL) or use the osmesa route"};
    std::string refused;
    for (const Attempt& attempt : displays(*e)) {
        Result<Handle> context = context_on(*e, attempt.display, options.debug);
        if (context) {
            std::unique_ptr<OffscreenContext::Implementation> made =
                std::make_unique<EglContext>(*e, attempt.display, *context);
            made->platform = attempt.platform;
            return made;
        }
        refused += text("\n  ", attempt.platform, ": ", context.error().message);
    }
    return Error{ErrorCode::GlContext,
                 text("EGL: no GL 3.3 core context without a window; install a driver (Debian: libegl-mesa0 and "
                      "libgl1-mesa-dri). Tried:",
                      refused)};
}

}  // namespace tilth::context
