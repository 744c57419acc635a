#include "demo/scenario/names.h"
#include "demo/scenario/read_parts.h"

namespace tilth::demo {

namespace {

/// Stamps are smaller than this many texels of their map; the library's limit.
constexpr double kMaxRadiusTexels = 8192;

bool reads_level(StampRule rule) { return rule == StampRule::Min || rule == StampRule::Max || rule == StampRule::Set; }

void check_radius(TableReader& reader, double radius_m, bool coarse, const GroundSettings& ground) {
    const double texel_m = coarse ? ground.spacing_m : ground.spacing_m / ground.texels_per_post;
    if (radius_m < kMaxRadiusTexels * texel_m) return;
    reader.wrong("radius", text("is ", radius_m, "; allowed: below 8192 texels of the ", coarse ? "coarse" : "detail",
                                " map, ", kMaxRadiusTexels * texel_m, " m"));
}

}  // namespace

bool goes_to_coarse(MapChoice map, double radius_m, const GroundSettings& ground) {
    if (map == MapChoice::Auto) return !ground.detail || radius_m >= 8 * ground.spacing_m;
    return map == MapChoice::Coarse;
}

StampStep read_stamp_keys(TableReader& reader, const StepRules& rules, bool with_centre) {
    const GroundSettings& ground = rules.terrain.settings.ground;
    StampStep step;
    StampRequest& request = step.request;
    if (!reader.has("shape")) reader.missing("shape", one_of(rules.context.shapes));
    if (const auto shape = reader.choice("shape", rules.context.shapes)) step.shape = rules.context.shapes[*shape];
    if (with_centre) request.centre = reader.required_position("centre");
    request.radius_m = reader.required_number("radius", kPositiveLength);
    if (const auto rule = reader.choice("rule", kRuleNames)) request.rule = static_cast<StampRule>(*rule);
    const Range share{0, 1, false, "a share from 0 to 1 for the rule smooth"};
    const Range& amplitude = request.rule == StampRule::Smooth ? share : kHeight;
    if (!reader.has("amplitude") && !reads_level(request.rule)) reader.missing("amplitude", amplitude.text);
    request.amplitude_m = reader.number("amplitude", amplitude).value_or(0);
    if (const auto map = reader.choice("map", kMapNames)) request.map = static_cast<MapChoice>(*map);
    request.level_m = reader.number("level", kHeight);
    request.rotation_rad = reader.number("rotation", {-1e6, 1e6, false, "radians within 1e6 of zero"}).value_or(0);
    request.mirror = reader.boolean("mirror").value_or(false);
    if (const auto key = reader.integer("key", 0, 0xffff'ffffLL)) request.key = static_cast<std::uint32_t>(*key);
    step.repeat = reader.integer("repeat", 1, 1'000'000'000).value_or(1);

    const bool coarse = goes_to_coarse(request.map, request.radius_m, ground);
    check_radius(reader, request.radius_m, coarse, ground);
    if (coarse && reads_level(request.rule) && !reader.has("level"))
        reader.missing("level", "metres, absolute; min, max and set need it on the coarse map");
    if (coarse && ground.mirror)
        reader.wrong(
            reader.has("map") ? "map" : "radius",
            "a mirrored world takes no coarse stamps; allowed: map = \"detail\" or a radius below eight posts");
    if (!coarse && !ground.detail)
        reader.wrong("map", "this world has no detail map ([terrain] detail = false); allowed: auto or coarse");
    return step;
}

}  // namespace tilth::demo
