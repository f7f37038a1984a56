#pragma once

#include "haptics/base/threads/Mutex.h"

#include <osgMidair/ExposureFigures>

#include <Eigen/Core>

#include <array>

namespace midair::haptics
{

/// Averages over time what listening places hear: L_eq = 10 log10(mean 10^{L/10}) since the first
/// field, and L_max, the highest mean over one second. What is told by play() sounds until the next
/// one. All members from any thread.
class ExposureMeter
{
public:
    /// From \a now_s (steady clock) on the \a places (3 x n) hear \a square_Pa2 (n, mean squares;
    /// all 0: silence). Another number of places begins anew. NaN counts as infinite.
    void play(double now_s, const Eigen::Matrix3Xd& places, const Eigen::VectorXd& square_Pa2);

    /// Returns the figures at \a now_s, but for the limit.
    ExposureFigures read(double now_s) const;

private:
    // Seconds begin every 0.1 s; a shorter sound counts with the silence around it.
    static constexpr int kBins = 10;
    static constexpr double kBin_s = 0.1;

    /// All that changes with time.
    struct State
    {
        Eigen::Matrix3Xd places;
        Eigen::VectorXd square_Pa2;              ///< n, now
        Eigen::VectorXd sum;                     ///< n, Pa^2 s since the start
        std::array<Eigen::VectorXd, kBins> bins; ///< n each, Pa^2 s in the last full tenths
        Eigen::VectorXd bin;                     ///< n, Pa^2 s in the tenth that runs
        int next = 0;                            ///< of bins, the oldest one
        double inBin_s = 0.0;                    ///< how much of it has passed
        double start_s = 0.0;
        double now_s = 0.0;
        double most_Pa2 = 0.0; ///< the highest mean over a second
        Eigen::Vector3d mostAt = Eigen::Vector3d::Zero();
    };

    static void advance(State& state, double now_s);
    static void closeBin(State& state);

    mutable base::Mutex _mutex;
    State _state MIDAIR_GUARDED_BY(_mutex);
};

} // namespace midair::haptics
