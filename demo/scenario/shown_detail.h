// How fine detail is shown, by the words of scenarios, flags and keys. Pure; no TOML, no GL.
#pragma once

#include "tilth/render/detail_settings.h"

namespace tilth::demo {

struct ShownDetail {
    DetailBackend backend = DetailBackend::None;
    DetailPreset preset = DetailPreset::Medium;
    DebugView debug = DebugView::Off;
    bool phong = false;  ///< coarse triangles curved
    friend bool operator==(const ShownDetail&, const ShownDetail&) = default;
};

inline DetailSettings settings_of(const ShownDetail& shown) {
    DetailSettings settings = detail_preset(shown.backend, shown.preset);
    settings.debug_view = shown.debug;
    settings.phong.on = shown.phong;
    return settings;
}

}  // namespace tilth::demo
