#include "tilth/deform/deformer.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "tilth/pool/shelves.h"

namespace tilth {
namespace {

// Texture units of deform/stamps.frag.
enum Unit { kHigh, kLow, kWeights, kStamps, kOrder };

// Width and depth of the scratch for many small parts; targets larger than that may use as much as one of them has.
constexpr std::int32_t kScratchTexels = 1024;
// Parts start at multiples of this in the scratch: software GL shades blocks of 4 x 4 texels.
constexpr std::int32_t kScratchAlign = 16;
constexpr std::size_t kStampTexels = sizeof(StampParams) / 16;

Result<void> put(std::optional<gl::TextureBuffer>& list, gl::Device& device, std::string_view label, gl::Format format,
                 std::size_t texels, std::span<const std::byte> data) {
    if (list) {
        list->replace(data);
        return {};
    }
    Result<gl::TextureBuffer> made =
        gl::TextureBuffer::create(device, label, format, texels, gl::BufferUsage::Stream, data.data());
    if (!made) return made.error();
    list = std::move(*made);
    return {};
}

}  // namespace

Deformer::Deformer(gl::Device& device, gl::ShaderLibrary& shaders, gl::TextureCopy copy)
    : device_(&device), shaders_(&shaders), copy_(std::move(copy)), atlas_(device) {}

Result<Deformer> Deformer::create(gl::Device& device, gl::ShaderLibrary& shaders) {
    Result<gl::TextureCopy> copy = gl::TextureCopy::create(device);
    if (!copy) return copy.error();
    return Deformer(device, shaders, std::move(*copy));
}

Result<void> Deformer::apply(std::span<const DeformStamp> stamps, std::span<const DeformTarget> targets,
                             gl::StageStats& stats, std::size_t& applied) {
    TexelRect held_by_all;
    for (const DeformTarget& target : targets) {
        held_by_all = bounds_of(held_by_all, target.planes->held());
        TILTH_EXPECTS(target.planes->precision() == targets.front().planes->precision(), "targets differ in precision");
    }
    // A shape that the GPU cannot hold stops the list at its stamp, not at the pass that the stamp would have shared.
    Result<void> held;
    std::vector<StampParams> list;
    std::vector<StampTraits> traits;
    for (const DeformStamp& stamp : stamps) {
        const Result<std::uint32_t> place = atlas_.place(*stamp.prepared.shape, stats.bytes);
        if (!place) {
            held = place.error();
            break;
        }
        list.push_back(stamp.prepared.params);
        list.back().table = *place;
        traits.push_back({intersection(stamp.prepared.rect(), held_by_all),
                          stamp.prepared.reads_own_texel_only() && !stamp.may_saturate});
    }
    applied = 0;
    for (const StampBatch& batch : plan_batches(traits)) {
        applied = batch.first;
        const auto of_batch = std::span(list).subspan(batch.first, batch.count);
        if (const Result<void> ran = run(batch, stamps.subspan(batch.first, batch.count), of_batch, targets, stats);
            !ran)
            return ran.error();
    }
    applied = list.size();
    return held;
}

Result<void> Deformer::reload() {
    Result<void> result;
    for (auto& [variant, pass] : passes_)
        if (Result<void> reloaded = shaders_->reload(pass->program()); !reloaded) result = std::move(reloaded);
    return result;
}

Deformer::ScratchPlan Deformer::plan(const StampBatch& batch, std::span<const DeformTarget> targets, Part part) {
    std::int32_t side = kScratchTexels;
    for (const DeformTarget& target : targets)
        side = std::max({side, target.planes->rect().width(), target.planes->rect().depth()});
    Shelves shelves(side, side, kScratchAlign);
    ScratchPlan plan;
    const HeightPlanes* last = nullptr;
    for (const DeformTarget& target : targets) {
        const TexelRect held =
            part == Part::Whole ? target.planes->held() : intersection(target.counted, target.planes->held());
        for (const StampBlock& block : batch.blocks) {
            const TexelRect rect = intersection(block.rect, held);
            if (rect.empty()) continue;
            const Shelves::Spot spot = shelves.add(rect.width(), rect.depth());
            const auto pass = static_cast<std::size_t>(spot.pass);
            if (pass >= plan.passes.size()) plan.passes.resize(pass + 1), last = nullptr;
            if (last != target.planes) plan.passes[pass].push_back({target.planes, {}}), last = target.planes;
            plan.passes[pass].back().rects.push_back(
                {spot.x,
                 spot.z,
                 spot.x + rect.width(),
                 spot.z + rect.depth(),
                 {rect.min.x - spot.x, rect.min.z - spot.z, static_cast<std::int32_t>(block.first),
                  static_cast<std::int32_t>(block.count)}});
        }
    }
    plan.width = shelves.width(), plan.depth = shelves.depth();
    return plan;
}

Result<void> Deformer::run(const StampBatch& batch, std::span<const DeformStamp> stamps,
                           std::span<const StampParams> list, std::span<const DeformTarget> targets,
                           gl::StageStats& stats) {
    const HeightPlanes& first = *targets.front().planes;
    Variant variant{
        .bits16 = first.precision() == HeightPrecision::bits16, .only_add = true, .one_stamp = stamps.size() == 1};
    for (const DeformStamp& stamp : stamps) {
        (stamp.prepared.shape->is_image ? variant.images : variant.profiles) = true;
        variant.only_add = variant.only_add && stamp.prepared.rule() == StampRule::Add;
        variant.smooth = variant.smooth || !stamp.prepared.reads_own_texel_only();
    }
    const ScratchPlan parts = plan(batch, targets, Part::Whole);
    if (parts.passes.empty()) return {};
    if (const Result<void> reserved = reserve_scratch(parts.width, parts.depth, first.targets().size()); !reserved)
        return reserved.error();
    if (!variant.one_stamp)
        if (const Result<void> uploaded = upload_lists(list, batch, stats); !uploaded) return uploaded.error();
    // Everything that can fail comes before the counting, so that a stamp that is tried again is counted once.
    if (const Result<gl::TexelPass*> pass = pass_for(variant, stats); !pass) return pass.error();
    if (variant.one_stamp && stamps.front().may_saturate)
        if (const Result<void> counted = count_saturated(variant, list, plan(batch, targets, Part::Counted), stats);
            !counted)
            return counted.error();
    for (const ScratchPass& pass : parts.passes) {
        if (const Result<void> drawn = draw(variant, list, pass, stats); !drawn) return drawn.error();
        copy_back(pass);
    }
    return {};
}

void Deformer::copy_back(const ScratchPass& parts) {
    std::vector<gl::CopyRect> copies;
    for (std::size_t p = 0; p < parts.front().planes->targets().size(); ++p)
        for (const TargetDraw& part : parts) {
            const Texel origin = part.planes->origin();
            copies.clear();
            for (const gl::PassRect& r : part.rects)
                copies.push_back({{r.min_x, r.min_z, r.max_x, r.max_z},
                                  r.min_x + r.payload[0] - origin.x,
                                  r.min_z + r.payload[1] - origin.z});
            copy_.run(scratch_[p], *part.planes->targets()[p], copies);
        }
}

Result<void> Deformer::upload_lists(std::span<const StampParams> list, const StampBatch& batch, gl::StageStats& stats) {
    const auto list_bytes = std::as_bytes(list);
    const auto order_bytes = std::as_bytes(std::span(batch.order));
    stats.bytes += list_bytes.size() + order_bytes.size();
    if (const Result<void> ok =
            put(stamps_, *device_, "stamp list", gl::Format::Rgba32UI, list.size() * kStampTexels, list_bytes);
        !ok)
        return ok.error();
    return put(order_, *device_, "stamp order", gl::Format::R32UI, batch.order.size(), order_bytes);
}

Result<void> Deformer::reserve_scratch(std::int32_t width, std::int32_t height, std::size_t planes) {
    const std::size_t wanted = std::max(planes, scratch_.size());
    if (scratch_.size() >= wanted && scratch_.front().width() >= width && scratch_.front().height() >= height)
        return {};
    if (!scratch_.empty()) {
        width = std::max(width, scratch_.front().width());
        height = std::max(height, scratch_.front().height());
    }
    scratch_.clear();
    while (scratch_.size() < wanted) {
        Result<gl::Texture2D> texture = gl::Texture2D::create(
            *device_, "deform scratch", {.format = gl::Format::R16, .width = width, .height = height});
        if (!texture) return texture.error();
        scratch_.push_back(std::move(*texture));
    }
    Result<gl::Framebuffer> framebuffer = gl::Framebuffer::create(*device_, "deform scratch");
    if (!framebuffer) return framebuffer.error();
    std::vector<const gl::Texture2D*> targets;
    for (const gl::Texture2D& texture : scratch_) targets.push_back(&texture);
    framebuffer->attach(targets);
    return framebuffer->check();
}

Result<gl::TexelPass*> Deformer::pass_for(const Variant& variant, gl::StageStats& stats) {
    if (const auto found = passes_.find(variant); found != passes_.end()) return found->second.get();
    gl::Features features;
    const auto add = [&](bool wanted, const char* name) {
        if (wanted) features.emplace_back(name, "1");
    };
    add(variant.bits16, "BITS16");
    add(variant.profiles, "PROFILES");
    add(variant.images, "IMAGES");
    add(variant.only_add, "ONLY_ADD");
    add(variant.one_stamp, "ONE_STAMP");
    add(variant.smooth, "SMOOTH");
    add(variant.count, "COUNT_SATURATED");
    Result<gl::TexelPass> pass = gl::TexelPass::create(*device_, *shaders_, "stamps", "deform/stamps.frag", features);
    if (!pass) return pass.error();
    ++stats.programs;
    gl::Program& program = pass->program();
    program.sampler("u_high", kHigh);
    program.sampler("u_low", kLow);
    program.sampler("u_weights", kWeights);
    program.sampler("u_stamps", kStamps);
    program.sampler("u_order", kOrder);
    return passes_.emplace(variant, std::make_unique<gl::TexelPass>(std::move(*pass))).first->second.get();
}

Result<void> Deformer::draw(const Variant& variant, std::span<const StampParams> list, const ScratchPass& parts,
                            gl::StageStats& stats) {
    Result<gl::TexelPass*> found = pass_for(variant, stats);
    if (!found) return found.error();
    gl::TexelPass& pass = **found;
    std::vector<const gl::Texture2D*> targets;
    for (std::size_t p = 0; p < parts.front().planes->targets().size(); ++p) targets.push_back(&scratch_[p]);
    pass.begin(targets, 0, stats);
    gl::Program& program = pass.program();
    atlas_.texture().bind(kWeights);
    if (variant.one_stamp) {
        std::array<std::int32_t, sizeof(StampParams) / sizeof(std::int32_t)> words;
        std::memcpy(words.data(), list.data(), sizeof(StampParams));
        program.set_ivec4s(program.uniform("u_stamp"), words);
    } else {
        stamps_->bind(kStamps);
        order_->bind(kOrder);
    }
    for (const TargetDraw& part : parts) {
        const TexelRect held = part.planes->held();
        part.planes->high().bind(kHigh);
        part.planes->low().bind(kLow);
        program.set(program.uniform("u_origin"), part.planes->origin().x, part.planes->origin().z);
        program.set(program.uniform("u_first_held"), held.min.x, held.min.z);
        program.set(program.uniform("u_last_held"), held.max.x - 1, held.max.z - 1);
        pass.draw(part.rects, stats);
    }
    return {};
}

Result<void> Deformer::count_saturated(Variant variant, std::span<const StampParams> list, const ScratchPlan& parts,
                                       gl::StageStats& stats) {
    if (parts.passes.empty()) return {};
    variant.count = true;
    Result<gl::Query> query = gl::Query::create(*device_, "saturated texels", gl::QueryKind::SamplesPassed);
    if (!query) return query.error();
    gl::StageStats counting;  // passes that write nothing anybody reads: their texels are not counted as written
    Result<void> drawn;
    query->begin();
    for (const ScratchPass& pass : parts.passes)
        if (drawn) drawn = draw(variant, list, pass, counting);
    query->end();
    if (!drawn) return drawn.error();
    stats.passes += counting.passes, stats.draws += counting.draws, stats.programs += counting.programs;
    counting_.push_back(std::move(*query));
    return {};
}

void Deformer::collect(gl::StageStats& stats) {
    std::erase_if(counting_, [&](const gl::Query& query) {
        if (!query.available()) return false;
        stats.saturated += query.result();
        return true;
    });
}

void Deformer::finish(gl::StageStats& stats) {
    for (const gl::Query& query : counting_) stats.saturated += query.result();
    counting_.clear();
}

std::uint64_t Deformer::bytes() const {
    std::uint64_t sum = 0;
    for (const gl::Texture2D& texture : scratch_) sum += texture.bytes();
    if (stamps_) sum += stamps_->bytes();
    if (order_) sum += order_->bytes();
    return sum;
}

}  // namespace tilth
