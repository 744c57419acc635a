// The readers of a scenario's parts: [terrain], [view], stamps and steps. Used by read_scenario only.
#pragma once

#include <toml++/toml.h>

#include "demo/scenario/read_scenario.h"
#include "demo/scenario/table_reader.h"

namespace tilth::demo {

void read_terrain(TableReader& reader, const std::filesystem::path& folder, TerrainPart& terrain);
/// The look, and of `terrain` how it is drawn.
void read_view(TableReader& reader, ViewPart& view, TerrainPart& terrain);

/// What steps are checked against.
struct StepRules {
    const ScenarioContext& context;
    const TerrainPart& terrain;
};

/// The keys that `stamp`, `path` and a walk's `print` share. `centre` is read only `with_centre`.
StampStep read_stamp_keys(TableReader& reader, const StepRules& rules, bool with_centre);

/// Whether a stamp of this radius goes to the coarse map (`auto` is settled by the radius).
bool goes_to_coarse(MapChoice map, double radius_m, const GroundSettings& ground);

/// One [[step]]; nothing if it is wrong.
std::optional<Step> read_step(const toml::table& table, int number, int line, const StepRules& rules,
                              Problems& problems);

}  // namespace tilth::demo
