// The life of a resident tile. Pure.
//
//              Wanted              Loaded                Filled
//    Absent ------------> Loading ---------> Uploading ----------> Resident
//      ^  ^--- Unwanted -----'  ^               |  |                  |
//      |      (cancelled),      '--LoadFailed   |  | Unwanted         | Unwanted
//      |       LoadFailed                       |  | (unmodified:     | (unmodified: -> Absent)
//      |                             Wanted     |  |  -> Absent)      |
//      '---------- Saved ---------- Saving <----'--'------------------'
//                                   |  ^  '---- Wanted (rescue) ---> Uploading, or Resident while its textures last
//                                   '--'  SaveFailed: again, later
//
// Displaced leads from Resident back to Uploading: its textures went to a nearer tile, its codes stay. A tile that is
// dented for the first time while a viewer is near begins as Uploading, and is Resident at once if there are textures.
#pragma once

#include <cstdint>

namespace tilth {

enum class TileState : std::uint8_t {
    Absent,     ///< its codes lie in the store, if it has any
    Loading,    ///< a request is with the disk worker, or stamps that fell on it meanwhile are being applied
    Uploading,  ///< its codes are in memory, its textures are being filled
    Resident,   ///< its textures hold its codes
    Saving,     ///< on its way out: its codes are in memory until the store has them
};

enum class TileEvent : std::uint8_t {
    Wanted,
    Unwanted,
    Loaded,
    LoadFailed,
    Filled,
    Displaced,  ///< its textures went to a nearer tile; its codes stay in memory
    Saved,
    SaveFailed,
};

/// What else decides.
struct TileFacts {
    bool modified = false;          ///< the codes in memory are not the store's
    bool textures_current = false;  ///< its textures hold its codes
};

/// What the owner has to do on the transition.
enum class TileAction : std::uint8_t {
    None,
    StartLoad,
    CancelLoad,
    StartFill,  ///< give it textures and fill them
    StartSave,
    RetrySave,  ///< after a pause
    Rescue,     ///< keep it; fill textures if `Uploading` follows
    Drop,       ///< release textures and codes
};

struct TileStep {
    TileState next = TileState::Absent;
    TileAction action = TileAction::None;
    friend bool operator==(const TileStep&, const TileStep&) = default;
};

/// An event that means nothing in a state (Wanted of a resident tile, say) leaves it as it is.
constexpr TileStep next_step(TileState state, TileEvent event, TileFacts facts) {
    const TileStep leave{state, TileAction::None};
    const TileStep out = facts.modified ? TileStep{TileState::Saving, TileAction::StartSave}
                                        : TileStep{TileState::Absent, TileAction::Drop};
    switch (state) {
        case TileState::Absent:
            return event == TileEvent::Wanted ? TileStep{TileState::Loading, TileAction::StartLoad} : leave;
        case TileState::Loading:
            if (event == TileEvent::Loaded) return {TileState::Uploading, TileAction::StartFill};
            if (event == TileEvent::Unwanted) return {TileState::Absent, TileAction::CancelLoad};
            if (event == TileEvent::LoadFailed) return {TileState::Absent, TileAction::None};
            return leave;
        case TileState::Uploading:
            if (event == TileEvent::Filled) return {TileState::Resident, TileAction::None};
            return event == TileEvent::Unwanted ? out : leave;
        case TileState::Resident:
            if (event == TileEvent::Displaced) return {TileState::Uploading, TileAction::None};
            return event == TileEvent::Unwanted ? out : leave;
        case TileState::Saving:
            if (event == TileEvent::Wanted)
                return {facts.textures_current ? TileState::Resident : TileState::Uploading, TileAction::Rescue};
            if (event == TileEvent::Saved) return out;  // stamped again while it was written: once more
            if (event == TileEvent::SaveFailed) return {TileState::Saving, TileAction::RetrySave};
            return leave;
    }
    return leave;
}

}  // namespace tilth
