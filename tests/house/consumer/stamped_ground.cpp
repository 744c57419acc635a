// A dedicated server in small: one stamp on flat ground, and its inverse. Prints the hash; exit status 0 if all is
// right.
#include <cmath>
#include <cstdio>
#include <memory>

#include "tilth/core/hash.h"
#include "tilth/ground/ground.h"
#include "tilth/source/source_spec.h"

int main() {
    tilth::Result<std::unique_ptr<tilth::HeightSource>> source = tilth::make_source("flat:size=129,height=10");
    if (!source) return std::printf("%s\n", source.error().message.c_str()), 1;
    tilth::Result<std::unique_ptr<tilth::Ground>> ground =
        tilth::Ground::create(std::shared_ptr<const tilth::HeightSource>(std::move(*source)), {});
    if (!ground) return std::printf("%s\n", ground.error().message.c_str()), 1;

    const tilth::StateHash before = (*ground)->hash();
    const tilth::WorldPos centre{64, 64};
    const auto record = (*ground)->issue({.shape = {}, .centre = centre, .radius_m = 16, .amplitude_m = -0.5});
    if (!record) return std::printf("%s\n", record.error().message.c_str()), 1;
    (*ground)->apply(*record);
    const tilth::StateHash dented = (*ground)->hash();
    const double height_m = (*ground)->height_m(centre);
    std::printf("hash %s, height %.6f m\n", tilth::hex16(dented.coarse).c_str(), height_m);

    // Shape 0 is a profile that is 1 at its centre, so the centre sinks by the amplitude, to a code's precision.
    if (std::abs(height_m - 9.5) > 1e-4) return std::printf("expected 9.5 m\n"), 1;
    if (dented == before) return std::printf("the stamp did not change the hash\n"), 1;
    (*ground)->apply(tilth::negated(*record));
    if (!((*ground)->hash() == before)) return std::printf("a stamp and its inverse do not cancel\n"), 1;
    return 0;
}
