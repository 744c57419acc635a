// The contract surface at full texel resolution, in doubles and as a mesh: what every backend's picture is judged by.
// Shares no code with the renderer, its shaders, the tiles' textures or the relief window; reads the ground's codes.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <span>
#include <vector>

#include "support/gl_context.h"
#include "tilth/ground/ground.h"
#include "tilth/render/view.h"

namespace tilth::test {

/// Coarse + detail about a place, as doubles. Each map is linear on cells split along the diagonal from (i, j) to
/// (i + 1, j + 1); texels divide posts, so their sum is linear on the halves of texel cells: nothing is approximated.
class ContractSurface {
public:
    /// Detail is read in the square of `half_m` about `middle`, widened to whole posts and clipped to the map; beyond
    /// it the surface is the coarse one. `ground` must outlive this.
    ContractSurface(const Ground& ground, WorldPos middle, double half_m)
        : ground_(&ground), grid_(ground.map(MapKind::Coarse).grid), per_post_(ground.settings().texels_per_post) {
        const PostPos low = grid_.posts({middle.x - half_m, middle.z - half_m}),
                      high = grid_.posts({middle.x + half_m, middle.z + half_m});
        const auto post = [](double p, std::int32_t count) {
            return std::clamp(static_cast<std::int32_t>(p), 0, count - 1);
        };
        posts_ = {{post(std::floor(low.x), grid_.width), post(std::floor(low.z), grid_.depth)},
                  {post(std::ceil(high.x), grid_.width), post(std::ceil(high.z), grid_.depth)}};
        side_ = (posts_.max.x - posts_.min.x) * per_post_ + 1, rows_ = (posts_.max.z - posts_.min.z) * per_post_ + 1;
        const Texel first{posts_.min.x * per_post_, posts_.min.z * per_post_};
        std::vector<std::uint32_t> codes(static_cast<std::size_t>(side_) * static_cast<std::size_t>(rows_));
        ground.detail().copy({first, {first.x + side_, first.z + rows_}}, codes.data(),
                             static_cast<std::size_t>(side_));
        const HeightCodec& codec = ground.map(MapKind::Detail).codec;
        heights_m_.reserve(codes.size());
        for (std::int32_t j = 0; j < rows_; ++j)
            for (std::int32_t i = 0; i < side_; ++i)
                heights_m_.push_back(codec.height_m(codes[heights_m_.size()]) +
                                     coarse_m(posts_.min.x + i / static_cast<double>(per_post_),
                                              posts_.min.z + j / static_cast<double>(per_post_)));
    }

    /// Height at a place, metres. Beyond the map the border's continues.
    [[nodiscard]] double height_m(double x_m, double z_m) const {
        const PostPos p = grid_.posts({x_m, z_m});
        const double i = (p.x - posts_.min.x) * per_post_, j = (p.z - posts_.min.z) * per_post_;
        if (i < 0 || j < 0 || i > side_ - 1 || j > rows_ - 1) return coarse_m(p.x, p.z);
        return on_cell(i, j, side_, rows_, [&](std::int32_t a, std::int32_t b) { return texel_m(a, b); });
    }

    [[nodiscard]] const GridSpec& grid() const { return grid_; }
    [[nodiscard]] std::int32_t per_post() const { return per_post_; }
    [[nodiscard]] double texel_spacing_m() const { return grid_.spacing_m / per_post_; }
    /// First and last post of the square with detail, both included.
    [[nodiscard]] const TexelRect& posts() const { return posts_; }
    [[nodiscard]] std::int32_t side() const { return side_; }  ///< texels along +x of that square
    [[nodiscard]] std::int32_t rows() const { return rows_; }  ///< along +z
    /// Height at its texel (i, j), metres.
    [[nodiscard]] double texel_m(std::int32_t i, std::int32_t j) const {
        return heights_m_[static_cast<std::size_t>(j) * static_cast<std::size_t>(side_) + static_cast<std::size_t>(i)];
    }
    [[nodiscard]] double post_m(std::int32_t x, std::int32_t z) const {
        return ground_->map(MapKind::Coarse).codec.height_m(ground_->coarse_code({x, z}));
    }
    /// The coarse map alone, at a place in posts.
    [[nodiscard]] double coarse_m(double x, double z) const {
        return on_cell(std::clamp(x, 0.0, grid_.width - 1.0), std::clamp(z, 0.0, grid_.depth - 1.0), grid_.width,
                       grid_.depth, [&](std::int32_t a, std::int32_t b) { return post_m(a, b); });
    }

private:
    template <class At>
    static double on_cell(double x, double z, std::int32_t width, std::int32_t depth, At h) {
        const std::int32_t i = std::min(static_cast<std::int32_t>(x), width - 2),
                           j = std::min(static_cast<std::int32_t>(z), depth - 2);
        const double u = x - i, v = z - j, h00 = h(i, j), h11 = h(i + 1, j + 1);
        if (u >= v) {
            const double h10 = h(i + 1, j);
            return h00 + u * (h10 - h00) + v * (h11 - h10);
        }
        const double h01 = h(i, j + 1);
        return h00 + v * (h01 - h00) + u * (h11 - h01);
    }

    const Ground* ground_;
    GridSpec grid_;
    std::int32_t per_post_, side_ = 0, rows_ = 0;
    TexelRect posts_;
    std::vector<double> heights_m_;
};

/// That surface as triangles: every texel of its square, every post elsewhere, positions computed in double relative to
/// the eye. Where the two meet, detail that is not 0 leaves a crack: keep the square's border out of what is compared.
/// Slow on purpose: 48 bytes of memory a texel and a new mesh for each view.
class DetailMesh {
public:
    /// `surface` must outlive this. `lift_m` moves the mesh up: to check what measures with it.
    explicit DetailMesh(const ContractSurface& surface, double lift_m = 0)
        : surface_(&surface),
          lift_m_(lift_m),
          shaders_(test::device(), gl::ShaderSource::folder(TILTH_SOURCE_DIR "/tests/render/shaders")),
          program_(value(shaders_.program("truth", "reference.vert", "reference.frag"))),
          u_clip_from_relative_(program_.uniform("u_clip_from_relative")),
          array_(value(gl::VertexArray::create(test::device(), "truth"))),
          positions_(
              value(gl::Buffer::create(test::device(), "truth positions", vertices() * 12, gl::BufferUsage::Stream))),
          indices_(value(make_indices())) {
        array_.float_attribute(0, positions_, 3, gl::AttributeType::Float, 12, 0);
        array_.index_buffer(indices_);
    }

    /// Clears `target` to magenta and draws in grey. Depth as `View::depth` Standard says.
    void draw(const Target& target, const View& view) {
        upload(view);
        const glm::dvec3 forward(view.forward.x, view.forward.y, view.forward.z);
        glm::dvec3 up(view.up.x, view.up.y, view.up.z);
        if (glm::length(glm::cross(glm::normalize(forward), up)) <= 1e-6) up = {0, 0, -1};
        const glm::mat4 clip(
            glm::perspective(view.fov_y_rad, double(target.width()) / target.height(), view.near_m, view.far_m) *
            glm::lookAt(glm::dvec3(0), forward, up));
        target.clear(1, 0, 1);
        const gl::Api& gl = test::device().gl();
        for (const GLenum off : {GL_CULL_FACE, GL_BLEND, GL_DITHER, GL_SCISSOR_TEST}) gl.Disable(off);
        if (test::device().capabilities().clip_control) gl.ClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
        gl.Enable(GL_DEPTH_TEST);
        gl.DepthMask(GL_TRUE);
        gl.DepthFunc(GL_LESS);
        program_.bind();
        program_.set_mat4(u_clip_from_relative_, glm::value_ptr(clip));
        array_.bind();
        gl.DrawElements(GL_TRIANGLES, static_cast<int>(index_count_), GL_UNSIGNED_INT, nullptr);
    }

private:
    [[nodiscard]] std::size_t texels() const {
        return static_cast<std::size_t>(surface_->side()) * static_cast<std::size_t>(surface_->rows());
    }
    [[nodiscard]] std::size_t vertices() const {
        return texels() + static_cast<std::size_t>(surface_->grid().rect().count());
    }
    void upload(const View& view) {
        std::vector<float> positions;
        positions.reserve(vertices() * 3);
        const auto add = [&](double x_posts, double z_posts, double height_m) {
            const GridSpec& grid = surface_->grid();
            positions.push_back(static_cast<float>(grid.origin.x + x_posts * grid.spacing_m - view.eye.x));
            positions.push_back(static_cast<float>(height_m + lift_m_ - view.eye.y));
            positions.push_back(static_cast<float>(grid.origin.z + z_posts * grid.spacing_m - view.eye.z));
        };
        const double per_post = surface_->per_post();
        for (std::int32_t j = 0; j < surface_->rows(); ++j)
            for (std::int32_t i = 0; i < surface_->side(); ++i)
                add(surface_->posts().min.x + i / per_post, surface_->posts().min.z + j / per_post,
                    surface_->texel_m(i, j));
        for (std::int32_t z = 0; z < surface_->grid().depth; ++z)
            for (std::int32_t x = 0; x < surface_->grid().width; ++x) add(x, z, surface_->post_m(x, z));
        positions_.replace(std::as_bytes(std::span(positions)));
    }
    Result<gl::Buffer> make_indices() {
        std::vector<std::uint32_t> indices;
        const auto add_cells = [&](std::size_t first, std::int32_t width, std::int32_t depth, auto wanted) {
            const auto add = [&](std::int32_t x, std::int32_t z) {
                indices.push_back(static_cast<std::uint32_t>(first) + static_cast<std::uint32_t>(z * width + x));
            };
            for (std::int32_t z = 0; z + 1 < depth; ++z)
                for (std::int32_t x = 0; x + 1 < width; ++x) {
                    if (!wanted(x, z)) continue;
                    add(x, z), add(x, z + 1), add(x + 1, z + 1);
                    add(x, z), add(x + 1, z + 1), add(x + 1, z);
                }
        };
        add_cells(0, surface_->side(), surface_->rows(), [](std::int32_t, std::int32_t) { return true; });
        const TexelRect& fine = surface_->posts();  // its last post is no cell of the square
        add_cells(texels(), surface_->grid().width, surface_->grid().depth, [&](std::int32_t x, std::int32_t z) {
            return x < fine.min.x || z < fine.min.z || x >= fine.max.x || z >= fine.max.z;
        });
        index_count_ = indices.size();
        return gl::Buffer::create(test::device(), "truth mesh", indices.size() * 4, gl::BufferUsage::Static,
                                  indices.data());
    }

    const ContractSurface* surface_;
    double lift_m_;
    gl::ShaderLibrary shaders_;
    gl::Program program_;
    gl::Uniform u_clip_from_relative_;
    gl::VertexArray array_;
    gl::Buffer positions_;
    std::size_t index_count_ = 0;
    gl::Buffer indices_;
};

}  // namespace tilth::test
