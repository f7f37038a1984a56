// A finger that crosses a plate in the octagon, and the side of it that the sound presses on: for
// tests and midair-hands-bench.
#pragma once

#include "engine-bridge/hands/prediction/HandPredictor.h"
#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "tests/engine-bridge/hands/prediction/Reaching.h"

#include <cmath>
#include <random>

namespace midair::bridge
{

/// Mean |p|^2 (Pa^2) on the skin of a finger while it crosses a plate.
struct CrossedSkin
{
    double near_Pa2 = 0.0; ///< on the side that comes to the plate first, which is to be felt
    double far_Pa2 = 0.0;  ///< on the opposite side
};

/// An index finger of 14 mm lies along the axis of the octagon and crosses the plate x = 0 at
/// 0.3 m/s. The tracker sees it 90 times a second with its noise in each joint; \a delay_s later a
/// focus sounds on its near side, where that was seen or is predicted to be. Each side's skin is a
/// quarter of the circle round the tip, in the plane across the axis where the focus is.
inline CrossedSkin crossPlate(PredictionMethod method, double delay_s, int crossings)
{
    using Eigen::Vector3d;
    constexpr double kSpeed_mps = 0.3;
    constexpr double kRadius_m = 0.007;
    constexpr int kPlaces = 9;
    const haptics::TransducerArray array = haptics::TransducerArray::octagonalPrism();
    const haptics::Medium medium;
    // openHand()'s fingers point along -z; this turns them to -y, the octagon's axis.
    const Eigen::Quaterniond along(Eigen::AngleAxisd(-M_PI / 2.0, Vector3d::UnitX()));
    std::mt19937_64 random(5);
    CrossedSkin skin;
    int fields = 0;
    for (int crossing = 0; crossing < crossings; ++crossing)
    {
        HandPredictor predictor;
        predictor.setMethod(method);
        // Crossings fall differently between the tracker's frames.
        const double start_m = -0.2 - 3.7e-4 * crossing;
        const auto tipAt = [&](double time_s)
        { return Vector3d(start_m + kSpeed_mps * time_s, 0.0, 0.0); };
        for (int i = 0; i < static_cast<int>(kTracker_Hz); ++i)
        {
            HandFrame frame;
            frame.time_s = i / kTracker_Hz;
            frame.hands.push_back(openHandWithIndexTipAt(1, tipAt(frame.time_s), along));
            addNoise(random, kTrackerNoise_m, frame.hands[0]);
            predictor.predict(frame, delay_s);
            const Vector3d tip = tipAt(frame.time_s + delay_s);
            if (std::abs(tip.x()) > kRadius_m) continue;
            const Eigen::Matrix3Xd focus =
                frame.hands[0].joints[INDEX_TIP].position + Vector3d(kRadius_m, 0.0, 0.0);
            const Eigen::MatrixXcd G = haptics::referencePropagationMatrix(focus, array, medium);
            const Eigen::VectorXcf q =
                G.row(0).conjugate().cwiseQuotient(G.row(0).cwiseAbs()).cast<std::complex<float>>();
            Eigen::Matrix3Xd places(3, 2 * kPlaces);
            for (int k = 0; k < kPlaces; ++k)
            {
                const double angle = M_PI / 2.0 * (k / (kPlaces - 1.0) - 0.5);
                const Vector3d out(kRadius_m * std::cos(angle), 0.0, kRadius_m * std::sin(angle));
                places.col(k) = tip + out;
                places.col(kPlaces + k) = tip - out;
            }
            const Eigen::VectorXd squares =
                haptics::pressureAt(places, array, medium, q).cwiseAbs2().cast<double>();
            skin.near_Pa2 += squares.head(kPlaces).mean();
            skin.far_Pa2 += squares.tail(kPlaces).mean();
            ++fields;
        }
    }
    return {skin.near_Pa2 / fields, skin.far_Pa2 / fields};
}

} // namespace midair::bridge
