#include "tilth/source/analytic_sources.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tilth/source/portable_exp.h"

namespace tilth {
namespace {

TEST(PortableExp, AgreesWithLibm) {
    EXPECT_EQ(portable_exp(0.0), 1.0);
    EXPECT_EQ(portable_exp(-1e300), 0.0);
    for (double x = 0; x > -708; x -= 0.0317) EXPECT_NEAR(portable_exp(x) / std::exp(x), 1.0, 1e-15) << x;
    for (double x = -1; x < -1e-18; x /= 3) EXPECT_NEAR(portable_exp(x) / std::exp(x), 1.0, 1e-15) << x;
}

TEST(FlatSource, IsFlat) {
    const FlatSource flat(5, 10.25);
    EXPECT_EQ(flat.width(), 5);
    EXPECT_EQ(flat.depth(), 5);
    EXPECT_EQ(flat.min_m(), 10.25);
    EXPECT_EQ(flat.max_m(), 10.25);
    EXPECT_EQ(flat.height_m({4, 0}), 10.25);
}

TEST(HillSource, IsTheFormulaAndItsRangeIsExact) {
    for (const int size : {2, 3, 64, 65})
        for (const double peak : {4.0, -3.5})
            for (const double sigma : {0.3, 5.0, 1e6}) {
                const HillSource hill(size, peak, sigma);
                const double middle = (size - 1) / 2.0;
                double low = 1e9, high = -1e9;
                for (int z = 0; z < size; ++z)
                    for (int x = 0; x < size; ++x) {
                        const double r2 = (x - middle) * (x - middle) + (z - middle) * (z - middle);
                        const double h = hill.height_m({x, z});
                        // Two factors of 1e-15 each, two products; far out the factors end at exp(-708).
                        EXPECT_NEAR(h, peak * std::exp(-r2 / (2 * sigma * sigma)), std::fabs(peak) * 4e-15);
                        low = std::min(low, h);
                        high = std::max(high, h);
                    }
                EXPECT_EQ(hill.min_m(), low);
                EXPECT_EQ(hill.max_m(), high);
            }
    EXPECT_EQ(HillSource(513, 4, 20).max_m(), 4.0);
    EXPECT_EQ(HillSource(513, 4, 20).height_m({256, 256}), 4.0);
}

TEST(HillSource, SlopeIsTheDerivative) {
    const HillSource hill(65, 4, 6);
    // Central difference: truncation step^2 / 6 * max|h'''|, and |h'''| < 1.4 peak / sigma^3; rounding 4e-16 * 4 /
    // step.
    const double step = 1e-4, tolerance = step * step / 6 * 1.4 * 4 / 216 + 4e-15 / step;
    for (const auto& [x, z] : {std::pair{32.0, 32.0}, {26.0, 32.0}, {40.5, 20.25}, {0.0, 64.0}}) {
        const PostSlope slope = hill.slope_at(x, z);
        EXPECT_NEAR(slope.x, (hill.height_at(x + step, z) - hill.height_at(x - step, z)) / (2 * step), tolerance);
        EXPECT_NEAR(slope.z, (hill.height_at(x, z + step) - hill.height_at(x, z - step)) / (2 * step), tolerance);
    }
    // The steepest place is at one sigma: peak / sigma * exp(-1/2).
    EXPECT_NEAR(hill.slope_at(32 - 6, 32).x, 4.0 / 6 * std::exp(-0.5), 1e-14);
}

}  // namespace
}  // namespace tilth
