// One frame of a world, drawn off screen; and that frame as files.
#pragma once

#include <memory>
#include <span>

#include "demo/gl/offscreen_target.h"
#include "demo/overlay/residency_map.h"
#include "demo/player/viewer.h"
#include "tilth/terrain.h"

namespace tilth::demo {

/// The picture that a scenario draws into. Keeps its own GL device beside the world's.
class Screen {
public:
    static Result<Screen> create(gl::GetProc get_proc, const ViewPart& part);

    /// Clears and draws, and paints `overlay` over it. Waits for the GPU, so that a frame's time is its own.
    Result<void> draw(Terrain& terrain, const View& view, const Shading& shading, const Vec3f& clear,
                      std::span<const ColouredRect> overlay = {});
    /// 8-bit RGB PNG of what was drawn last.
    Result<void> write_png(const std::string& path) const;
    /// Distance from the eye's plane in metres, as EXR; infinity where nothing was drawn. `view` is the one drawn with.
    Result<void> write_depth(const std::string& path, const View& view) const;

private:
    Screen(std::unique_ptr<gl::Device> device, OffscreenTarget target);
    std::unique_ptr<gl::Device> device_;  ///< before what is made from it
    OffscreenTarget target_;
};

/// Metres before the eye's plane of a standard depth value; infinity at 1.
double depth_m(double depth, double near_m, double far_m);

}  // namespace tilth::demo
