// Rows of the table of detail backends. All rows of a table are measured in turn, frame by frame, at each place of the
// walk, so that each has a ratio to `none` of the same place and the same minute.
#pragma once

#include <string>

#include "tilth/render/detail_settings.h"

namespace tilth::bench {

/// Which shaders a row is drawn with: the tree's own, or a floor (benchmarks/render/shaders).
enum class RowShaders { Own, PassThrough, PlainFetches };

struct ReliefRow {
    std::string name;
    DetailSettings settings;
    RowShaders shaders = RowShaders::Own;
    bool by_resolution = false;  ///< is in the table by resolution, too
};

/// Adds benchmarks "detail_frame/<dents>/<width>x<height>/<name>". Call it while statics are made. Value: true.
bool add_relief_row(ReliefRow row);

}  // namespace tilth::bench
