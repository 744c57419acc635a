// The step `expect`: whether what is, is what should be. Pure.
#pragma once

#include <optional>
#include <string>

#include "demo/scenario/scenario.h"
#include "demo/stats/run_report.h"

namespace tilth::demo {

/// Empty if met; otherwise what differs, with both values. The border of a tolerance is inside it.
std::optional<std::string> unmet(const ExpectHeight& expected, double height_m);
std::optional<std::string> unmet(const ExpectHash& expected, const StateHash& hash);
std::optional<std::string> unmet(const ExpectStat& expected, const Json& statistics);

}  // namespace tilth::demo
