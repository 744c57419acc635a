#include <algorithm>
#include <cmath>

#include "demo/scenario/names.h"
#include "demo/scenario/read_parts.h"

namespace tilth::demo {

namespace {

const std::vector<std::string> kStepKeys{"camera", "walk",   "stamp",  "path",     "random",  "wait", "screenshot",
                                         "dump",   "query",  "expect", "teleport", "viewers", "wave", "shock",
                                         "save",   "reopen", "crash",  "undo",     "redo",    "show"};

/// Viewers beside the camera's own: each asks for up to nine tiles.
constexpr std::size_t kMostViewers = 64;

/// Steps of the form that later builds will have.
struct Later {
    const char* key;
    const char* what;
};
constexpr Later kLater[] = {{"wave", "effects"}, {"shock", "effects"}};

/// More strokes than anybody lays in a session.
constexpr std::int64_t kMostStrokes = 1'000'000'000;

constexpr Range kSeconds{0, 1e6, false, "seconds from 0 to 1e6"};
constexpr Range kFrameSeconds{0, 1e6, true, "seconds above 0, at most 1e6"};

std::optional<Vec3d> read_point(TableReader& reader, const char* key) {
    const auto v = reader.numbers(key, 3, 3, kCoordinate);
    if (!v) return {};
    return Vec3d{(*v)[0], (*v)[1], (*v)[2]};
}

CameraStep read_camera(TableReader& reader) {
    CameraStep step;
    step.above_ground_m = reader.number("above_ground", {0, 1e7, false, "metres from 0 to 1e7"});
    const bool plane = step.above_ground_m.has_value();
    const char* const eye_text = plane ? "[x, z] in metres" : "[x, y, z] in metres, or [x, z] with above_ground";
    if (!reader.has("eye")) reader.missing("eye", eye_text);
    if (!reader.has("look_at")) reader.missing("look_at", "[x, y, z] in metres");
    if (const auto eye = reader.numbers("eye", plane ? 2 : 3, 3, kCoordinate))
        step.eye = {eye->front(), eye->size() == 3 ? (*eye)[1] : 0, eye->back()};
    if (const auto at = read_point(reader, "look_at")) {
        step.look_at = *at;
        if (step.eye == step.look_at && !plane) reader.wrong("look_at", "is the eye itself; allowed: any other point");
    }
    return step;
}

PathStep read_path(TableReader& reader, const StepRules& rules) {
    PathStep step;
    step.stamp = read_stamp_keys(reader, rules, false);
    if (!reader.has("points")) reader.missing("points", "a list of [x, z] in metres");
    step.points = reader.positions("points", 1, 1'000'000).value_or(std::vector<WorldPos>{});
    step.spacing_m = reader.number("spacing", kPositiveLength).value_or(0.75);
    step.alternate_m = reader.number("alternate", {0, 1e6, false, "metres from 0 to 1e6"}).value_or(0);
    double length_m = 0;
    for (std::size_t i = 1; i < step.points.size(); ++i)
        length_m += std::hypot(step.points[i].x - step.points[i - 1].x, step.points[i].z - step.points[i - 1].z);
    if (length_m / step.spacing_m >= 1e6)
        reader.wrong("spacing", text("asks for ", std::floor(length_m / step.spacing_m),
                                     " stamps; allowed: a spacing that makes fewer than a million"));
    return step;
}

/// [low, high] with low <= high.
std::optional<std::array<double, 2>> read_span(TableReader& reader, const char* key, const Range& range) {
    if (!reader.has(key)) reader.missing(key, text("[low, high], each ", range.text));
    const auto v = reader.numbers(key, 2, 2, range);
    if (!v) return {};
    if ((*v)[0] > (*v)[1]) {
        reader.wrong(key, text("[", (*v)[0], ", ", (*v)[1], "] runs backwards; allowed: [low, high]"));
        return {};
    }
    return std::array<double, 2>{(*v)[0], (*v)[1]};
}

std::array<WorldPos, 2> read_region(TableReader& reader) {
    if (!reader.has("region")) reader.missing("region", "[[x, z], [x, z]], two corners in metres");
    const auto corners = reader.positions("region", 2, 2);
    return corners ? std::array<WorldPos, 2>{(*corners)[0], (*corners)[1]} : std::array<WorldPos, 2>{};
}

RandomStep read_random(TableReader& reader, const StepRules& rules) {
    const GroundSettings& ground = rules.terrain.settings.ground;
    RandomStep step;
    if (!reader.has("seed")) reader.missing("seed", "an integer from 0 to 2^63 - 1");
    step.seed = static_cast<std::uint64_t>(reader.integer("seed", 0, INT64_MAX).value_or(1));
    if (!reader.has("count")) reader.missing("count", "an integer from 0 to 10000000");
    step.count = reader.integer("count", 0, 10'000'000).value_or(0);
    step.region = read_region(reader);
    step.radius_m = read_span(reader, "radius", kPositiveLength).value_or(step.radius_m);
    step.amplitude_m = read_span(reader, "amplitude", kHeight).value_or(step.amplitude_m);
    if (const auto map = reader.choice("map", kMapNames)) step.map = static_cast<MapChoice>(*map);
    step.shapes = rules.context.shapes;
    if (const auto shapes = reader.choices("shapes", rules.context.shapes)) {
        step.shapes.clear();
        for (const std::size_t i : *shapes) step.shapes.push_back(rules.context.shapes[i]);
    }
    if (const auto chosen = reader.choices("rules", kRuleNames))
        for (const std::size_t i : *chosen) step.rules.push_back(static_cast<StampRule>(i));
    else
        step.rules = {StampRule::Add, StampRule::Min, StampRule::Max, StampRule::Set, StampRule::Smooth};

    const bool coarse = goes_to_coarse(step.map, step.radius_m[1], ground);
    const double limit_m = 8192 * (coarse ? ground.spacing_m : ground.spacing_m / ground.texels_per_post);
    if (step.radius_m[1] >= limit_m)
        reader.wrong("radius",
                     text("reaches ", step.radius_m[1], "; allowed: below 8192 texels of the map, ", limit_m, " m"));
    if (coarse && ground.mirror)
        reader.wrong(reader.has("map") ? "map" : "radius",
                     "a mirrored world takes no coarse stamps; allowed: map = \"detail\" or radii below eight posts");
    if (step.map == MapChoice::Detail && !ground.detail)
        reader.wrong("map", "this world has no detail map ([terrain] detail = false); allowed: auto or coarse");
    return step;
}

WalkStep read_walk(TableReader& reader, const StepRules& rules) {
    WalkStep step;
    step.to = reader.required_position("to");
    step.speed_m_per_s = reader.required_number("speed", {0, 1e6, true, "metres per second above 0, at most 1e6"});
    step.above_ground_m = reader.number("above_ground", {0, 1e7, false, "metres from 0 to 1e7"}).value_or(2.0);
    step.dt_s = reader.number("dt", kFrameSeconds).value_or(step.dt_s);
    step.stride_m = reader.number("stride", kPositiveLength).value_or(step.stride_m);
    if (const toml::table* table = reader.table("print", "a table with the keys of a stamp")) {
        TableReader print(*table, "print", reader.line_of("print"), reader.problems());
        step.print = read_stamp_keys(print, rules, false);
        step.alternate_m = print.number("alternate", {0, 1e6, false, "metres from 0 to 1e6"}).value_or(0);
        print.finish();
    }
    return step;
}

WaitStep read_wait(TableReader& reader, const toml::table& table) {
    WaitStep step;
    if (reader.has("frames") == reader.has("seconds"))
        reader.problems().add(reader.line(), "wait",
                              "needs one of frames and seconds; allowed: { frames = 60 } or { seconds = 1.0 }");
    step.frames = reader.integer("frames", 0, 1'000'000'000).value_or(0);
    step.seconds = reader.number("seconds", kSeconds);
    const toml::node* dt = table.get("dt");
    if (dt != nullptr && dt->is_array())
        step.dt_s = reader.numbers("dt", 1, 100'000, kSeconds).value_or(step.dt_s);
    else if (const auto one = reader.number("dt", kSeconds))
        step.dt_s = {*one};
    if (step.seconds && *step.seconds > 0 &&
        std::all_of(step.dt_s.begin(), step.dt_s.end(), [](double s) { return s == 0; }))
        reader.wrong("dt", "is 0, so seconds never pass; allowed: a dt above 0 with seconds");
    return step;
}

bool ends_with_one_of(const std::string& file, const std::vector<std::string>& endings) {
    return std::any_of(endings.begin(), endings.end(),
                       [&](const std::string& e) { return file.ends_with(e) && file.size() > e.size(); });
}

ScreenshotStep read_screenshot(TableReader& step_table) {
    ScreenshotStep step;
    step.file = step_table.required_string("screenshot", "a file name that ends in .png");
    if (!step.file.empty() && !ends_with_one_of(step.file, {".png"}))
        step_table.wrong("screenshot", "does not end in .png; allowed: a file name that ends in .png");
    step.depth_file = step_table.string("depth", "a file name that ends in .exr").value_or("");
    if (!step.depth_file.empty() && !ends_with_one_of(step.depth_file, {".exr"}))
        step_table.wrong("depth", "does not end in .exr; allowed: a file name that ends in .exr");
    step.overlay = step_table.boolean("overlay").value_or(false);
    return step;
}

DumpStep read_dump(TableReader& reader, const StepRules& rules) {
    DumpStep step;
    if (!reader.has("map")) reader.missing("map", "coarse or detail");
    if (const auto map = reader.choice("map", {"coarse", "detail"})) step.map = static_cast<MapKind>(*map);
    if (step.map == MapKind::Detail && !rules.terrain.settings.ground.detail)
        reader.wrong("map", "this world has no detail map ([terrain] detail = false); allowed: coarse");
    step.region = read_region(reader);
    if (const auto what = reader.choice("what", kDumpNames)) step.what = static_cast<DumpWhat>(*what);
    const std::string allowed = "a file name that ends in " + one_of(kDumpEndings);
    step.file = reader.required_string("file", allowed);
    if (!step.file.empty() && !ends_with_one_of(step.file, kDumpEndings))
        reader.wrong("file", "has another ending; allowed: " + allowed);
    const bool raw = ends_with_one_of(step.file, {".r16", ".r32f"}),
               floats = ends_with_one_of(step.file, {".exr", ".r32f"});
    if (step.what == DumpWhat::Code && floats)
        reader.wrong("file", "holds floats, which lose the last bits of a code; allowed for codes: .csv, .tif or .r16");
    if (step.what == DumpWhat::Slope && raw)
        reader.wrong("file", "holds one value a texel, and a slope has two; allowed for slopes: .csv, .exr or .tif");
    return step;
}

QueryStep read_query(TableReader& reader, const StepRules& rules) {
    QueryStep step;
    if (!reader.has("kind")) reader.missing("kind", "height");
    if (const auto kind = reader.choice("kind", {"height", "normal", "ray"}); kind && *kind != 0) {
        reader.wrong("kind", "this build does not have normal and ray queries yet; allowed: height");
        for (const char* key : {"at", "from", "direction", "max", "map"}) reader.known(key);
        return step;
    }
    if (!reader.has("at")) reader.missing("at", "a list of [x, z] in metres");
    step.at = reader.positions("at", 1, 10'000'000).value_or(std::vector<WorldPos>{});
    if (const auto map = reader.choice("map", kSelectNames)) step.map = static_cast<MapSelect>(*map);
    if (step.map == MapSelect::Detail && !rules.terrain.settings.ground.detail)
        reader.wrong("map", "this world has no detail map ([terrain] detail = false); allowed: coarse");
    return step;
}

ShowStep read_show(TableReader& reader) {
    ShowStep step;
    if (const auto backend = reader.choice("backend", kBackendNames))
        step.backend = static_cast<DetailBackend>(*backend);
    if (const auto preset = reader.choice("preset", kPresetNames)) step.preset = static_cast<DetailPreset>(*preset);
    if (const auto debug = reader.choice("debug", kDebugNames)) step.debug = static_cast<DebugView>(*debug);
    step.phong = reader.boolean("phong");
    if (!reader.has("backend") && !reader.has("preset") && !reader.has("debug") && !reader.has("phong"))
        reader.problems().add(reader.line(), "show",
                              "says nothing; allowed: one or more of backend, preset, debug and phong");
    return step;
}

std::optional<std::string> read_hash(TableReader& reader, const char* key) {
    const char* const allowed = "16 lower-case hexadecimal digits in quotes";
    const auto hash = reader.string(key, allowed);
    if (hash && (hash->size() != 16 || hash->find_first_not_of("0123456789abcdef") != std::string::npos))
        reader.wrong(key, text("is not a hash; allowed: ", allowed));
    return hash;
}

ExpectStat read_expected_stat(TableReader& reader, const toml::table& table, const ScenarioContext& context) {
    ExpectStat stat;
    stat.path = reader.required_string("stat", "a path like last_frame.deform.passes");
    if (!stat.path.empty() && context.has_stat && !context.has_stat(stat.path))
        reader.wrong("stat", text("the statistics have no '", stat.path.substr(0, 80),
                                  "'; allowed: a path like last_frame.deform.passes"));
    if (const toml::node* equals = table.get("equals"); equals != nullptr && equals->is_string())
        stat.equals_text = reader.string("equals", "a number or text");
    else
        stat.equals = reader.number("equals", {-1e300, 1e300, false, "a number"});
    stat.at_most = reader.number("at_most", {-1e300, 1e300, false, "a number"});
    stat.at_least = reader.number("at_least", {-1e300, 1e300, false, "a number"});
    if (!reader.has("equals") && !reader.has("at_most") && !reader.has("at_least"))
        reader.missing("equals", "equals, at_most or at_least");
    return stat;
}

ExpectStep read_expect(TableReader& reader, const toml::table& table, const ScenarioContext& context) {
    ExpectStep step;
    const int kinds = int(reader.has("height_at")) + int(reader.has("hash")) + int(reader.has("stat"));
    if (kinds != 1) {
        reader.problems().add(reader.line(), "expect", "needs exactly one of height_at, hash and stat");
        for (const char* key : {"height_at", "hash", "stat", "value", "within", "equals", "at_most", "at_least"})
            reader.known(key);
        return step;
    }
    if (reader.has("hash")) {
        ExpectHash hash;
        if (const toml::table* inner = reader.table("hash", "a table { coarse, detail }")) {
            TableReader hashes(*inner, "hash", reader.line_of("hash"), reader.problems());
            hash.coarse = read_hash(hashes, "coarse");
            hash.detail = read_hash(hashes, "detail");
            if (inner->empty()) hashes.missing("coarse", "coarse, detail or both");
            hashes.finish();
        }
        step.what = hash;
    } else if (reader.has("stat")) {
        step.what = read_expected_stat(reader, table, context);
    } else {
        ExpectHeight height;
        height.at = reader.required_position("height_at");
        height.value_m = reader.required_number("value", kHeight);
        height.within_m = reader.required_number("within", {0, 1e6, false, "metres from 0 to 1e6"});
        step.what = height;
    }
    return step;
}

/// `save = true` and its like: there is nothing that false could mean.
void read_order(TableReader& step_table, const std::string& key) {
    if (step_table.boolean(key) == false) step_table.wrong(key, "is false; allowed: true, or leave the step out");
}

std::int64_t read_strokes(TableReader& step_table, const std::string& key) {
    return step_table.integer(key, 1, kMostStrokes).value_or(1);
}

/// The steps whose key holds no table. False: it is another one.
bool read_plain_step(TableReader& step_table, const std::string& key, Step& step) {
    if (key == "screenshot") {
        step.action = read_screenshot(step_table);
    } else if (key == "teleport") {
        step.action = TeleportStep{step_table.required_position("teleport")};
    } else if (key == "viewers") {
        step.action = ViewersStep{step_table.positions("viewers", 0, kMostViewers).value_or(std::vector<WorldPos>{})};
    } else if (key == "undo") {
        step.action = UndoStep{read_strokes(step_table, key)};
    } else if (key == "redo") {
        step.action = RedoStep{read_strokes(step_table, key)};
    } else if (key == "save" || key == "reopen" || key == "crash") {
        read_order(step_table, key);
        if (key == "save") step.action = SaveStep{};
        if (key == "reopen") step.action = ReopenStep{};
        if (key == "crash") step.action = CrashStep{};
    } else {
        return false;
    }
    step_table.finish();
    return true;
}

std::string joined(const std::vector<std::string>& names) {
    std::string out;
    for (const std::string& name : names) out += (out.empty() ? "" : ", ") + name;
    return out;
}

/// The step's one key; nothing, and a problem, if there is none or more than one.
std::optional<std::string> step_key(TableReader& reader, const toml::table& table) {
    std::vector<std::string> found;
    for (const std::string& key : kStepKeys)
        if (table.contains(key)) found.push_back(key);
    if (found.size() > 1) {
        const auto later = std::max_element(
            found.begin(), found.end(),
            [&](const std::string& a, const std::string& b) { return reader.line_of(a) < reader.line_of(b); });
        reader.wrong(*later, text("a step has exactly one step key, and this one has ", found.size(), ": ",
                                  joined(found), "; start another [[step]]"));
        return {};
    }
    if (!found.empty()) return found.front();
    for (const char* key : {"depth", "overlay"})
        if (table.contains(key)) {
            reader.wrong(key, text("stands only with screenshot; allowed: screenshot = \"a.png\", ", key, " = ",
                                   key == std::string_view("depth") ? "\"a.exr\"" : "true"));
            return {};
        }
    if (table.empty())
        reader.problems().add(reader.line(), "step", text("is empty; allowed: ", one_of(kStepKeys)));
    else
        reader.problems().add(static_cast<int>(table.begin()->first.source().begin.line),
                              std::string(table.begin()->first.str()),
                              text("unknown step; allowed: ", one_of(kStepKeys)));
    return {};
}

}  // namespace

std::optional<Step> read_step(const toml::table& table, int number, int line, const StepRules& rules,
                              Problems& problems) {
    TableReader outer(table, "step " + std::to_string(number), line, problems);
    const auto key = step_key(outer, table);
    if (!key) return {};
    Step step{.number = number, .line = outer.line_of(*key), .action = {}};
    for (const Later& later : kLater)
        if (*key == later.key) {
            outer.wrong(*key, text("this build does not have ", later.what, " yet; leave the step out"));
            return {};
        }
    if (read_plain_step(outer, *key, step)) return step;
    const toml::table* inner = outer.table(*key, "a table");
    outer.finish();
    if (inner == nullptr) return {};
    TableReader reader(*inner, *key, step.line, problems);
    if (*key == "camera") step.action = read_camera(reader);
    if (*key == "stamp") step.action = read_stamp_keys(reader, rules, true);
    if (*key == "path") step.action = read_path(reader, rules);
    if (*key == "random") step.action = read_random(reader, rules);
    if (*key == "walk") step.action = read_walk(reader, rules);
    if (*key == "wait") step.action = read_wait(reader, *inner);
    if (*key == "show") step.action = read_show(reader);
    if (*key == "dump") step.action = read_dump(reader, rules);
    if (*key == "query") step.action = read_query(reader, rules);
    if (*key == "expect") step.action = read_expect(reader, *inner, rules.context);
    reader.finish();
    return step;
}

}  // namespace tilth::demo
