#include "demo/player/screen.h"

#include <limits>

#include "demo/overlay/paint.h"
#include "tilth/io/png.h"

namespace tilth::demo {

double depth_m(double depth, double near_m, double far_m) {
    if (depth >= 1) return std::numeric_limits<double>::infinity();
    return near_m * far_m / (far_m - depth * (far_m - near_m));
}

Screen::Screen(std::unique_ptr<gl::Device> device, OffscreenTarget target)
    : device_(std::move(device)), target_(std::move(target)) {}

Result<Screen> Screen::create(gl::GetProc get_proc, const ViewPart& part) {
    auto device = gl::Device::create(get_proc);
    if (!device) return device.error();
    auto target = OffscreenTarget::create(**device, part.width, part.height);
    if (!target) return target.error();
    return Screen(std::move(*device), std::move(*target));
}

Result<void> Screen::draw(Terrain& terrain, const View& view, const Shading& shading, const Vec3f& clear,
                          std::span<const ColouredRect> overlay) {
    target_.begin(clear);
    const Result<void> drawn = terrain.draw(view, shading);
    paint(*device_, overlay, target_.height());
    target_.finish();
    return drawn;
}

Result<void> Screen::write_png(const std::string& path) const {
    return io::write_png_rgb8(path, target_.width(), target_.height(), target_.read_rgb8());
}

Result<void> Screen::write_depth(const std::string& path, const View& view) const {
    std::vector<float> depth = target_.read_depth();
    for (float& d : depth) d = float(depth_m(d, view.near_m, view.far_m));
    return io::write_depth_exr(path, target_.width(), target_.height(), depth);
}

}  // namespace tilth::demo
