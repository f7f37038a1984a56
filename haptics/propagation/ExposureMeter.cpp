#include "haptics/propagation/ExposureMeter.h"

#include "haptics/base/threads/Mutex.h"
#include "haptics/propagation/Exposure.h"

#include <algorithm>
#include <limits>

namespace midair::haptics
{

void ExposureMeter::closeBin(State& state)
{
    state.bins[static_cast<std::size_t>(state.next)] = state.bin;
    state.next = (state.next + 1) % kBins;
    state.bin.setZero();
    state.inBin_s = 0.0;
    Eigen::VectorXd second = Eigen::VectorXd::Zero(state.bin.size());
    for (const Eigen::VectorXd& one : state.bins)
        second += one;
    Eigen::Index at = 0;
    if (second.size() == 0) return;
    const double most_Pa2 = second.maxCoeff(&at) / (kBins * kBin_s);
    if (!(most_Pa2 > state.most_Pa2)) return;
    state.most_Pa2 = most_Pa2;
    state.mostAt = state.places.col(at);
}

void ExposureMeter::advance(State& state, double now_s)
{
    double left_s = std::max(0.0, now_s - state.now_s);
    state.now_s = std::max(state.now_s, now_s);
    state.sum += left_s * state.square_Pa2;
    // After a second of the same sound each further one is like it.
    constexpr double kSteady_s = 2.0 * kBins * kBin_s;
    if (left_s > 2.0 * kSteady_s) left_s = kSteady_s;
    while (left_s > 0.0)
    {
        const double step_s = std::min(left_s, kBin_s - state.inBin_s);
        state.bin += step_s * state.square_Pa2;
        state.inBin_s += step_s;
        left_s -= step_s;
        if (state.inBin_s > kBin_s * (1.0 - 1e-9)) closeBin(state);
    }
}

void ExposureMeter::play(double now_s,
                         const Eigen::Matrix3Xd& places,
                         const Eigen::VectorXd& square_Pa2)
{
    const base::Lock lock(_mutex);
    if (_state.places.cols() != places.cols())
    {
        _state = State();
        _state.start_s = _state.now_s = now_s;
        for (Eigen::VectorXd* one : {&_state.square_Pa2, &_state.sum, &_state.bin})
            one->setZero(places.cols());
        for (Eigen::VectorXd& one : _state.bins)
            one.setZero(places.cols());
    }
    advance(_state, now_s);
    _state.places = places;
    _state.square_Pa2 = square_Pa2.unaryExpr(
        [](double one) { return one >= 0.0 ? one : std::numeric_limits<double>::infinity(); });
}

ExposureFigures ExposureMeter::read(double now_s) const
{
    State state;
    {
        const base::Lock lock(_mutex);
        state = _state;
    }
    ExposureFigures figures;
    figures.places = static_cast<int>(state.places.cols());
    if (figures.places == 0) return figures;
    advance(state, now_s);
    figures.time_s = state.now_s - state.start_s;
    figures.level_dB = soundLevel_dB(state.square_Pa2.maxCoeff());
    Eigen::Index at = 0;
    const double mean_Pa2 = figures.time_s > 0.0 ? state.sum.maxCoeff(&at) / figures.time_s : 0.0;
    if (mean_Pa2 > 0.0) figures.eq_dB = soundLevel_dB(mean_Pa2);
    constexpr double kDay_s = 8.0 * 3600.0;
    figures.day_dB = soundLevel_dB(mean_Pa2 * figures.time_s / kDay_s);
    // Before the first second is over, its mean so far is the highest.
    if (figures.time_s < kBins * kBin_s && mean_Pa2 > state.most_Pa2)
    {
        state.most_Pa2 = mean_Pa2;
        state.mostAt = state.places.col(at);
    }
    figures.max_dB = soundLevel_dB(state.most_Pa2);
    figures.x_m = state.mostAt.x();
    figures.y_m = state.mostAt.y();
    figures.z_m = state.mostAt.z();
    return figures;
}

} // namespace midair::haptics
