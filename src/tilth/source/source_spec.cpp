#include "tilth/source/source_spec.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "tilth/source/analytic_sources.h"
#include "tilth/source/ridged_source.h"

namespace tilth {
namespace {

constexpr std::string_view kLowerCase = "abcdefghijklmnopqrstuvwxyz";
constexpr double kMaxHeightM = 1e6;

/// The key-value pairs of one specification, taken out one by one. The first mistake is kept, later ones are ignored.
class Keys {
public:
    Keys(std::string_view spec, std::string_view list) : spec_(spec) {
        while (!list.empty() && !error_) {
            const std::size_t comma = std::min(list.find(','), list.size());
            add(list.substr(0, comma));
            if (comma + 1 == list.size()) fail("a comma at the end; write key=value,key=value");
            list.remove_prefix(std::min(comma + 1, list.size()));
        }
    }

    std::int32_t size(std::int32_t preset) {
        const std::uint64_t value = integer("size", static_cast<std::uint64_t>(preset), kMinSpecSize, kMaxSpecSize);
        return static_cast<std::int32_t>(value);
    }
    std::uint64_t seed(std::uint64_t preset) { return integer("seed", preset, 0, ~std::uint64_t{0}); }

    double height(std::string_view key, double preset) { return number(key, preset, -kMaxHeightM, false); }
    double positive(std::string_view key, double preset) { return number(key, preset, 0.0, true); }

    /// To be called when all known keys were asked for: what is left is unknown.
    std::optional<Error> finish(std::string_view allowed) {
        if (!pairs_.empty()) fail(text("unknown key '", pairs_.front().key, "'; allowed are ", allowed));
        return std::move(error_);
    }

private:
    struct Pair {
        std::string_view key, value;
    };

    void fail(const std::string& what) {
        if (!error_) error_ = Error{ErrorCode::InvalidArgument, text("heights \"", spec_, "\": ", what)};
    }

    void add(std::string_view pair) {
        const std::size_t equals = pair.find('=');
        if (equals == std::string_view::npos) return fail(text("'", pair, "' has no '='; write key=value"));
        const Pair made{pair.substr(0, equals), pair.substr(equals + 1)};
        for (const Pair& p : pairs_)
            if (p.key == made.key) return fail(text("key '", made.key, "' is given twice"));
        pairs_.push_back(made);
    }

    std::optional<std::string_view> take(std::string_view key) {
        const auto found = std::find_if(pairs_.begin(), pairs_.end(), [&](const Pair& p) { return p.key == key; });
        if (found == pairs_.end()) return std::nullopt;
        const std::string_view value = found->value;
        pairs_.erase(found);
        return value;
    }

    template <class T>
    static bool parsed(std::string_view digits, T& value) {
        const auto [end, problem] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
        return problem == std::errc{} && end == digits.data() + digits.size();
    }

    std::uint64_t integer(std::string_view key, std::uint64_t preset, std::uint64_t low, std::uint64_t high) {
        const auto given = take(key);
        if (!given) return preset;
        std::uint64_t value = 0;
        if (parsed(*given, value) && value >= low && value <= high) return value;
        fail(text("key '", key, "': '", *given, "' is not allowed; give an integer from ", low, " to ", high));
        return preset;
    }

    double number(std::string_view key, double preset, double low, bool above_low) {
        const auto given = take(key);
        if (!given) return preset;
        double value = 0;
        if (parsed(*given, value) && std::isfinite(value) && value <= kMaxHeightM &&
            (above_low ? value > low : value >= low))
            return value;
        fail(text("key '", key, "': '", *given, "' is not allowed; give a number ", above_low ? "above " : "from ", low,
                  above_low ? ", at most " : " to ", kMaxHeightM));
        return preset;
    }

    std::string_view spec_;
    std::vector<Pair> pairs_;
    std::optional<Error> error_;
};

Result<std::unique_ptr<HeightSource>> ridged(Keys keys) {
    const RidgedSettings settings{
        .seed = keys.seed(1), .size = keys.size(1025), .relief_m = keys.positive("relief", 200)};
    if (auto error = keys.finish("seed, size, relief")) return *error;
    return std::unique_ptr<HeightSource>(make_ridged_source(settings));
}

Result<std::unique_ptr<HeightSource>> flat(Keys keys) {
    const std::int32_t size = keys.size(1025);
    const double height_m = keys.height("height", 0);
    if (auto error = keys.finish("size, height")) return *error;
    return std::unique_ptr<HeightSource>(std::make_unique<FlatSource>(size, height_m));
}

Result<std::unique_ptr<HeightSource>> hill(Keys keys) {
    const std::int32_t size = keys.size(513);
    const double peak_m = keys.height("peak", 4), sigma_posts = keys.positive("sigma", 20);
    if (auto error = keys.finish("size, peak, sigma")) return *error;
    return std::unique_ptr<HeightSource>(std::make_unique<HillSource>(size, peak_m, sigma_posts));
}

}  // namespace

bool is_procedural(std::string_view spec) {
    const std::size_t colon = spec.find(':');
    return colon != std::string_view::npos && colon >= 2 && spec.find_first_not_of(kLowerCase) == colon;
}

Result<std::unique_ptr<HeightSource>> make_source(std::string_view spec) {
    const std::size_t colon = std::min(spec.find(':'), spec.size());
    const std::string_view kind = spec.substr(0, colon);
    const std::string_view list = spec.substr(std::min(colon + 1, spec.size()));
    if (kind == "ridged") return ridged({spec, list});
    if (kind == "flat") return flat({spec, list});
    if (kind == "hill") return hill({spec, list});
    return Error{ErrorCode::InvalidArgument, text("heights \"", spec, "\": unknown kind '", kind,
                                                  "'; allowed are ridged:, flat:, hill: or the path of a file")};
}

}  // namespace tilth
