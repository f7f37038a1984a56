#include "tests/benchmarks/hands/Prediction.h"

#include "engine-bridge/hands/HandSource.h"
#include "engine-bridge/hands/prediction/HandPredictor.h"
#include "haptics/array/Medium.h"
#include "haptics/propagation/PressureField.h"
#include "tests/benchmarks/Timing.h"
#include "tests/engine-bridge/hands/prediction/Crossing.h"
#include "tests/engine-bridge/hands/prediction/Reaching.h"

#include <cmath>
#include <cstdio>
#include <functional>
#include <optional>
#include <random>
#include <vector>

namespace midair::bench
{

namespace
{

using namespace bridge;

struct Method
{
    PredictionMethod method;
    const char* name;
};

constexpr Method kMethods[] = {{PredictionMethod::OFF, "none"},
                               {PredictionMethod::ONE_EURO, "one euro + speed"},
                               {PredictionMethod::ALPHA_BETA, "alpha-beta"},
                               {PredictionMethod::KALMAN, "Kalman"}};

void printRow(const char* name, const PredictionErrors& moving, double rest_m)
{
    std::printf("  %-18s %8.1f %8.1f %8.2f %8.1f\n",
                name,
                1e3 * moving.rms_m,
                1e3 * moving.most_m,
                1e3 * rest_m,
                1e3 * moving.sigma_m);
}

void printHeadings(const char* what)
{
    std::printf("%s\n  %-18s %8s %8s %8s %8s\n", what, "mm", "rms", "95 %", "at rest", "expected");
}

void coordinate(double ahead_s)
{
    printHeadings("a coordinate, filters alone");
    for (const Method& method : kMethods)
        printRow(method.name,
                 filterErrors(method.method, ahead_s, true),
                 filterErrors(method.method, ahead_s, false).rms_m);
    printHeadings("the same, predicted less as it comes to rest");
    for (const Method& method : kMethods)
        if (method.method != PredictionMethod::OFF)
            printRow(method.name,
                     trackErrors(method.method, ahead_s, true),
                     trackErrors(method.method, ahead_s, false).rms_m);
}

/// The hand at a time, s; none: there is none.
using HandAt = std::function<std::optional<Hand>(double)>;

/// The errors of the fingertips, and the largest change of a bone's length, as a ratio.
struct HandErrors
{
    PredictionErrors tips;
    double bone = 0.0;
    double cost_us = 0.0; ///< median of a hand
};

double worstBone(const Hand& hand, const Hand& measured)
{
    const auto after = handCapsules({0.0, {hand}, {}});
    const auto before = handCapsules({0.0, {measured}, {}});
    double worst = 0.0;
    for (std::size_t i = 0; i < after.size(); ++i)
    {
        const double length = (before[i].shape.a - before[i].shape.b).norm();
        worst =
            std::max(worst, std::abs((after[i].shape.a - after[i].shape.b).norm() / length - 1.0));
    }
    return worst;
}

HandErrors
errorsOf(PredictionMethod method, const HandAt& at, double end_s, double ahead_s, double noise_m)
{
    std::mt19937_64 random(6);
    HandPredictor predictor;
    predictor.setMethod(method);
    HandErrors result;
    std::vector<double> errors;
    std::vector<double> sigmas;
    std::vector<double> costs_us;
    for (int i = 0; i < static_cast<int>((end_s - ahead_s) * kTracker_Hz); ++i)
    {
        HandFrame frame;
        frame.time_s = i / kTracker_Hz;
        std::optional<Hand> seen = at(frame.time_s);
        const std::optional<Hand> truth = at(frame.time_s + ahead_s);
        if (seen)
        {
            addNoise(random, noise_m, *seen);
            frame.hands.push_back(*seen);
        }
        const double begin_ms = cpu_ms();
        predictor.predict(frame, ahead_s);
        costs_us.push_back(1e3 * (cpu_ms() - begin_ms));
        if (!seen || !truth) continue;
        result.bone = std::max(result.bone, worstBone(frame.hands[0], *seen));
        for (const std::size_t joint : {THUMB_TIP, INDEX_TIP, MIDDLE_TIP, RING_TIP, LITTLE_TIP})
        {
            const HandJoint& tip = frame.hands[0].joints[joint];
            if (!tip.positionValid || !truth->joints[joint].positionValid) continue;
            errors.push_back((tip.position - truth->joints[joint].position).norm());
            sigmas.push_back(tip.sigma_m);
        }
    }
    if (!errors.empty()) result.tips = summed(std::move(errors), sigmas);
    result.cost_us = median(std::move(costs_us));
    return result;
}

void printHands(const HandAt& at, double end_s, double ahead_s, double noise_m)
{
    std::printf(
        "  %-18s %8s %8s %8s %12s %8s\n", "mm", "rms", "95 %", "expected", "bones off/%", "us");
    for (const Method& method : kMethods)
    {
        const HandErrors errors = errorsOf(method.method, at, end_s, ahead_s, noise_m);
        std::printf("  %-18s %8.1f %8.1f %8.1f %12.4f %8.1f\n",
                    method.name,
                    1e3 * errors.tips.rms_m,
                    1e3 * errors.tips.most_m,
                    1e3 * errors.tips.sigma_m,
                    100.0 * errors.bone,
                    errors.cost_us);
    }
}

void plate()
{
    constexpr double kDelay_s = 0.07;
    std::printf("a finger of 14 mm crosses a plate at 0.3 m/s, %.0f ms from the tracker to the "
                "sound: |p|^2 / (2 rho c^2) on its skin, octagon, one focus\n"
                "  %-18s %10s %10s %12s\n",
                1e3 * kDelay_s,
                "",
                "near/Pa",
                "far/Pa",
                "far/near");
    const haptics::Medium medium;
    for (const Method& method : kMethods)
    {
        const CrossedSkin skin = crossPlate(method.method, kDelay_s, 12);
        std::printf("  %-18s %10.0f %10.0f %12.2f\n",
                    method.name,
                    haptics::radiationPressure(std::sqrt(skin.near_Pa2), medium, 1.0),
                    haptics::radiationPressure(std::sqrt(skin.far_Pa2), medium, 1.0),
                    skin.far_Pa2 / skin.near_Pa2);
    }
}

} // namespace

void printPredictions(double ahead_ms)
{
    const double ahead_s = 1e-3 * ahead_ms;
    std::printf("\nprediction: reaches of 0.3 m in 0.6 s to and fro with pauses, 90 Hz, 1 mm of "
                "noise, %.0f ms ahead\n",
                ahead_ms);
    coordinate(ahead_s);
    std::printf("the fingertips of a hand that also turns by 60 and bends its index by 40 degrees "
                "a joint\n");
    const Reaching reaching(60.0);
    printHands([&](double time_s) { return reachingHand(reaching, time_s); },
               59.0,
               ahead_s,
               kTrackerNoise_m);
    plate();
}

void printRecording(const std::string& file, double ahead_ms, double noise_mm)
{
    RecordedHandSource source(file);
    std::printf("\nprediction: fingertips of the first hand of %s at 90 Hz, %.1f mm of noise, "
                "%.0f ms ahead\n",
                file.c_str(),
                noise_mm,
                ahead_ms);
    const HandAt at = [&](double time_s) -> std::optional<Hand>
    {
        HandFrame frame;
        if (!source.frameAt(time_s, frame)) return std::nullopt;
        return frame.hands[0];
    };
    printHands(at, source.duration_s(), 1e-3 * ahead_ms, 1e-3 * noise_mm);
}

} // namespace midair::bench
