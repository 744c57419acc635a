// Links every library of the package, with every installed header included before this line (by the compiler's
// -include).
#include <cstdio>
#include <memory>
#include <string>

int main() {
    using namespace tilth;
    int failures = 0;
#ifdef CONSUMER_HAS_IO
    // A file that does not exist is an error with a name, not a crash.
    const auto missing = io::read_file("no-such-file.tif", 1 << 20);
    if (missing.ok() || missing.error().message.find("no-such-file.tif") == std::string::npos) {
        std::printf("io: the error does not name the file\n");
        ++failures;
    }
#endif
    auto source = make_source("flat:size=129,height=10");
    if (!source) return std::printf("%s\n", source.error().message.c_str()), 1;
    const auto shared = std::shared_ptr<const HeightSource>(std::move(*source));
    gl::GetProc get_proc = nullptr;
#ifdef CONSUMER_HAS_CONTEXT
    auto context = context::OffscreenContext::create(context::Route::Egl);
    if (!context) return std::printf("%s\n", context.error().message.c_str()), 1;
    get_proc = context->get_proc();
    std::printf("%s; ", context->renderer().c_str());
#endif
    auto terrain = Terrain::create(shared, {}, get_proc);
    if (!terrain) return std::printf("%s\n", terrain.error().message.c_str()), 1;
    const auto record = (*terrain)->stamp({.shape = {}, .centre = {64, 64}, .radius_m = 16, .amplitude_m = -0.5});
    if (!record) return std::printf("%s\n", record.error().message.c_str()), 1;
    (*terrain)->update(0);
    const double height_m = (*terrain)->height_m({64, 64});
    std::printf("height %.6f m\n", height_m);
    if (height_m < 9.4999 || height_m > 9.5001) ++failures;
    return failures;
}
