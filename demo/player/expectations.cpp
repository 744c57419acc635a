#include "demo/player/expectations.h"

#include <cmath>

#include "tilth/core/hash.h"
#include "tilth/core/result.h"

namespace tilth::demo {

std::optional<std::string> unmet(const ExpectHeight& expected, double height_m) {
    const double off_m = std::abs(height_m - expected.value_m);
    if (off_m <= expected.within_m) return {};
    return text("expect: height at (", expected.at.x, ", ", expected.at.z, ") is ", height_m, ", expected ",
                expected.value_m, " within ", expected.within_m, "; off by ", off_m);
}

std::optional<std::string> unmet(const ExpectHash& expected, const StateHash& hash) {
    std::string wrong;
    if (expected.coarse && *expected.coarse != hex16(hash.coarse))
        wrong += text(" coarse is ", hex16(hash.coarse), ", expected ", *expected.coarse, ";");
    if (expected.detail && *expected.detail != hex16(hash.detail))
        wrong += text(" detail is ", hex16(hash.detail), ", expected ", *expected.detail, ";");
    if (wrong.empty()) return {};
    wrong.pop_back();
    return "expect: hash" + wrong;
}

std::optional<std::string> unmet(const ExpectStat& expected, const Json& statistics) {
    const std::optional<Json> value = value_at(statistics, expected.path);
    if (!value) return "expect: the statistics have no " + expected.path;
    const std::string is = text("expect: ", expected.path, " is ", value->dump());
    if (expected.equals_text) {
        if (value->is_string() && value->get<std::string>() == *expected.equals_text) return {};
        return text(is, ", expected \"", *expected.equals_text, "\"");
    }
    if (!value->is_number()) return is + ", which is not a number";
    const double number = value->get<double>();
    if (expected.equals && number != *expected.equals) return text(is, ", expected ", *expected.equals);
    if (expected.at_most && number > *expected.at_most) return text(is, ", expected at most ", *expected.at_most);
    if (expected.at_least && number < *expected.at_least) return text(is, ", expected at least ", *expected.at_least);
    return {};
}

}  // namespace tilth::demo
