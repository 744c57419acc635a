#include "tilth/gl/timer.h"

#include <ctime>
#include <utility>

#include "tilth/gl/api.h"

namespace tilth::gl {
namespace {
// Frames that a query may take to be ready: three are in flight with the deepest common swap chain; taste.
constexpr std::size_t kQueries = 8;
}  // namespace

double process_cpu_ms() {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

Result<GpuTimer> GpuTimer::create(Device& device, std::string_view label, TimerPolicy policy) {
    GpuTimer timer(device);
    if (device.quirks().timer_queries_lie || device.capabilities().timer_query_bits == 0) {
        timer.mode_ = policy == TimerPolicy::MayFinish ? Mode::CpuTime : Mode::None;
        return timer;
    }
    timer.mode_ = Mode::Queries;
    for (std::size_t i = 0; i < kQueries; ++i) {
        Result<Query> query = Query::create(device, label, QueryKind::TimeElapsed);
        if (!query) return query.error();
        timer.queries_.push_back(*std::move(query));
    }
    return timer;
}

void GpuTimer::begin() {
    TILTH_ASSERT(!open_, "GpuTimer::begin() before the end() of the last stretch");
    if (mode_ == Mode::Queries) {
        if (in_flight_ == queries_.size()) {
            ++dropped_;
            return;
        }
        queries_[(first_ + in_flight_) % queries_.size()].begin();
    } else if (mode_ == Mode::CpuTime) {
        device_->gl().Finish();
        start_ms_ = process_cpu_ms();
    }
    open_ = true;
}

void GpuTimer::end() {
    if (!open_) return;  // the stretch was dropped
    open_ = false;
    if (mode_ == Mode::Queries) {
        queries_[(first_ + in_flight_) % queries_.size()].end();
        ++in_flight_;
    } else if (mode_ == Mode::CpuTime) {
        device_->gl().Finish();
        ready_ms_.push_back(process_cpu_ms() - start_ms_);
    }
}

std::vector<double> GpuTimer::take_samples_ms() {
    while (in_flight_ > 0 && queries_[first_].available()) {
        ready_ms_.push_back(static_cast<double>(queries_[first_].result()) * 1e-6);
        first_ = (first_ + 1) % queries_.size();
        --in_flight_;
    }
    return std::exchange(ready_ms_, {});
}

std::vector<double> GpuTimer::finish_samples_ms() {
    for (std::size_t i = 0; i < in_flight_; ++i) static_cast<void>(queries_[(first_ + i) % queries_.size()].result());
    return take_samples_ms();
}

}  // namespace tilth::gl
