// The cases of tests that run on every route with either precision.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "tilth/context/offscreen_context.h"
#include "tilth/world/height_codec.h"

namespace tilth::test {

struct RouteAndPrecision {
    context::Route route;
    HeightPrecision precision;
};

inline auto every_route_and_precision() {
    return ::testing::Values(RouteAndPrecision{context::Route::Egl, HeightPrecision::bits32},
                             RouteAndPrecision{context::Route::Egl, HeightPrecision::bits16},
                             RouteAndPrecision{context::Route::Osmesa, HeightPrecision::bits32},
                             RouteAndPrecision{context::Route::Osmesa, HeightPrecision::bits16});
}

inline std::string name_of(const ::testing::TestParamInfo<RouteAndPrecision>& tested) {
    return std::string(tested.param.route == context::Route::Egl ? "Egl" : "Osmesa") +
           (tested.param.precision == HeightPrecision::bits32 ? "Bits32" : "Bits16");
}

}  // namespace tilth::test
