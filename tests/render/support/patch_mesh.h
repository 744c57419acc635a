// A grid of triangles through the tessellation stages alone, captured by transform feedback.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <map>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "support/gl_context.h"
#include "tilth/gl/state_guard.h"

namespace tilth::test {

/// What tests/render/shaders/patch_corners.vert reads.
struct PatchCorner {
    std::array<float, 3> position_m{};
    std::array<float, 4> clip{};
    float base_m = 0, alpha = 0;
    std::array<float, 2> slope{};
    std::array<std::int32_t, 4> integers{};  ///< from base x, z; marked; level
    float weight = 0;
};

struct PatchVertex {
    std::array<float, 3> position_m{};
    std::array<float, 4> clip{};
    /// By bits.
    friend bool operator<(const PatchVertex& a, const PatchVertex& b) {
        return std::memcmp(&a, &b, sizeof(PatchVertex)) < 0;
    }
    friend bool operator==(const PatchVertex& a, const PatchVertex& b) {
        return std::memcmp(&a, &b, sizeof(PatchVertex)) == 0;
    }
};
using PatchTriangle = std::array<PatchVertex, 3>;

/// `quads` x `quads` cells about the base post, the eye above it.
struct PatchGrid {
    int quads = 16;
    std::vector<PatchCorner> corners;
    std::vector<std::array<std::uint32_t, 3>> triangles;

    explicit PatchGrid(int cells) : quads(cells), corners(static_cast<std::size_t>((cells + 1) * (cells + 1))) {
        for (int z = 0; z < quads; ++z)
            for (int x = 0; x < quads; ++x) {
                triangles.push_back({at(x, z), at(x, z + 1), at(x + 1, z + 1)});
                triangles.push_back({at(x, z), at(x + 1, z + 1), at(x + 1, z)});
            }
    }
    [[nodiscard]] std::uint32_t at(int x, int z) const { return static_cast<std::uint32_t>(z * (quads + 1) + x); }
    [[nodiscard]] bool on_border(int x, int z) const { return x == 0 || z == 0 || x == quads || z == quads; }
    /// Calls `set(corner, x, z)` for all.
    void each(const std::function<void(PatchCorner&, int, int)>& set) {
        for (int z = 0; z <= quads; ++z)
            for (int x = 0; x <= quads; ++x) set(corners[at(x, z)], x, z);
    }
    /// Any corner first, either winding.
    void shuffle(std::mt19937_64& random) {
        for (auto& t : triangles) {
            std::rotate(t.begin(), t.begin() + static_cast<long>(random() % 3), t.end());
            if (random() % 2 != 0) std::swap(t[0], t[1]);
        }
    }
};

/// Makes an askew clip position of every component of a place.
inline constexpr std::array<float, 16> kAskewClip{1.21f, -0.32f, 0.18f, 0.17f, 0.23f,  1.43f, -0.54f, -0.53f,
                                                  0.37f, 0.61f,  0.84f, 0.83f, -0.01f, 0.02f, -0.2f,  0.03f};

/// The triangles that come out of the program that is bound and set. `per_draw`: patches a draw; the default keeps
/// below 2^16 vertices a draw up to factor 16, beyond which llvmpipe mixes them up (Mesa 22.3: indices of 16 bits).
inline std::vector<PatchTriangle> capture_patches(const PatchGrid& grid, std::size_t most_triangles,
                                                  std::size_t per_draw = 256) {
    gl::Device& device = test::device();
    const gl::Api& gl = device.gl();
    auto vertices = value(gl::Buffer::create(device, "corners", grid.corners.size() * sizeof(PatchCorner),
                                             gl::BufferUsage::Static, grid.corners.data()));
    auto indices = value(gl::Buffer::create(device, "indices", grid.triangles.size() * sizeof(grid.triangles[0]),
                                            gl::BufferUsage::Static, grid.triangles.data()));
    auto array = value(gl::VertexArray::create(device, "patches"));
    array.bind();
    constexpr int stride = sizeof(PatchCorner);
    array.float_attribute(0, vertices, 3, gl::AttributeType::Float, stride, offsetof(PatchCorner, position_m));
    array.float_attribute(1, vertices, 4, gl::AttributeType::Float, stride, offsetof(PatchCorner, clip));
    array.float_attribute(2, vertices, 4, gl::AttributeType::Float, stride, offsetof(PatchCorner, base_m));
    array.int_attribute(3, vertices, 4, gl::AttributeType::Int, stride, offsetof(PatchCorner, integers));
    array.float_attribute(4, vertices, 1, gl::AttributeType::Float, stride, offsetof(PatchCorner, weight));
    array.index_buffer(indices);
    auto feedback = value(
        gl::Buffer::create(device, "feedback", most_triangles * sizeof(PatchTriangle), gl::BufferUsage::ReadBack));
    auto generated = value(gl::Query::create(device, "generated", gl::QueryKind::PrimitivesGenerated));
    gl.BindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, feedback.id());
    gl.PatchParameteri(GL_PATCH_VERTICES, 3);
    gl.Enable(GL_RASTERIZER_DISCARD);
    generated.begin();
    gl.BeginTransformFeedback(GL_TRIANGLES);
    for (std::size_t first = 0; first < grid.triangles.size(); first += per_draw) {
        const std::size_t patches = std::min(per_draw, grid.triangles.size() - first);
        gl.DrawElements(GL_PATCHES, static_cast<GLsizei>(patches * 3), GL_UNSIGNED_INT,
                        reinterpret_cast<const void*>(first * sizeof(grid.triangles[0])));
    }
    gl.EndTransformFeedback();
    generated.end();
    gl.Disable(GL_RASTERIZER_DISCARD);
    gl.BindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, 0);
    EXPECT_LE(generated.result(), most_triangles) << "the feedback buffer was too small";
    std::vector<PatchTriangle> out(std::min<std::size_t>(generated.result(), most_triangles));
    if (!out.empty()) feedback.read(0, std::as_writable_bytes(std::span(out)));
    return out;
}

/// How triangles meet. Edges are pairs of vertices by bits, without direction.
struct Seams {
    int pairs = 0;   ///< edges of exactly two triangles
    int single = 0;  ///< of one: the border, or a crack
    int more = 0;    ///< of three or more
};

inline Seams seams_of(const std::vector<PatchTriangle>& triangles) {
    std::map<std::pair<PatchVertex, PatchVertex>, int> edges;
    for (const PatchTriangle& t : triangles)
        for (std::size_t i = 0; i < 3; ++i) {
            PatchVertex a = t[i], b = t[(i + 1) % 3];
            if (b < a) std::swap(a, b);
            ++edges[{a, b}];
        }
    Seams seams;
    for (const auto& [edge, count] : edges) ++(count == 1 ? seams.single : count == 2 ? seams.pairs : seams.more);
    return seams;
}

/// Calls `see(x, z, y)` for all points (i, j) * step inside the triangles; those on an edge may come twice.
inline void sample(const std::vector<PatchTriangle>& triangles, double step,
                   const std::function<void(double x, double z, double y)>& see) {
    for (const PatchTriangle& t : triangles) {
        const auto x = [&](std::size_t i) { return double{t[i].position_m[0]}; };
        const auto z = [&](std::size_t i) { return double{t[i].position_m[2]}; };
        const auto y = [&](std::size_t i) { return double{t[i].position_m[1]}; };
        const double area = (x(1) - x(0)) * (z(2) - z(0)) - (x(2) - x(0)) * (z(1) - z(0));
        if (std::abs(area) < 1e-12) continue;
        const auto first = [&](double v) { return static_cast<int>(std::ceil(v / step - 1e-4)); };
        const auto last = [&](double v) { return static_cast<int>(std::floor(v / step + 1e-4)); };
        for (int j = first(std::min({z(0), z(1), z(2)})); j <= last(std::max({z(0), z(1), z(2)})); ++j)
            for (int i = first(std::min({x(0), x(1), x(2)})); i <= last(std::max({x(0), x(1), x(2)})); ++i) {
                const double px = i * step, pz = j * step;
                const double b = ((px - x(0)) * (z(2) - z(0)) - (x(2) - x(0)) * (pz - z(0))) / area;
                const double c = ((x(1) - x(0)) * (pz - z(0)) - (px - x(0)) * (z(1) - z(0))) / area;
                if (b < -1e-5 || c < -1e-5 || b + c > 1 + 1e-5) continue;
                see(px, pz, y(0) + b * (y(1) - y(0)) + c * (y(2) - y(0)));
            }
    }
}

}  // namespace tilth::test
