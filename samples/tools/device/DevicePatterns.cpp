#include "device/drive/DriveEncoder.h"
#include "engine-bridge/playing/PressureCap.h"
#include "haptics/array/Medium.h"
#include "haptics/base/DutyLaw.h"
#include "haptics/base/threads/SteadyClock.h"
#include "samples/tools/device/DeviceTool.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <optional>
#include <vector>

namespace midair::samples
{

namespace
{

using device::DriveSignal;

std::uint8_t dutyOf(double amplitude)
{
    return static_cast<std::uint8_t>(std::lround(base::dutyLevel(std::clamp(amplitude, 0.0, 1.0))));
}

// What an array's file calls dead is not driven by tests either.
void silenceDead(const haptics::TransducerArray& array, DriveSignal& signal)
{
    for (const int i : array.dead)
        signal.duty[static_cast<std::size_t>(i)] = 0;
}

// Focus: q_i = e^{+jk |r - r_i|}, so that all waves arrive at r with the same phase.
void focus(const haptics::TransducerArray& array,
           double k,
           const Eigen::Vector3d& r,
           double amplitude,
           DriveSignal& signal)
{
    std::vector<std::complex<float>> q(array.size());
    for (int i = 0; i < array.size(); ++i)
    {
        const double offset = array.phaseOffset_rad.size() > 0 ? array.phaseOffset_rad[i] : 0;
        q[i] = std::complex<float>(
            std::polar(amplitude, k * (r - array.positions.col(i)).norm() - offset));
    }
    device::encode(q.data(), array.size(), signal);
    silenceDead(array, signal);
}

Eigen::VectorXcf wouldPlay(const device::ArrayDevice& device, const DriveSignal& signal)
{
    const std::vector<std::complex<float>> q = device.wouldPlay(signal);
    return Eigen::Map<const Eigen::VectorXcf>(q.data(), static_cast<Eigen::Index>(q.size()));
}

} // namespace

// Plays each board in turn, with all its transducers in phase.
int playBoards(const DeviceOptions& options)
{
    const auto array = loadArray(options);
    const auto device = openWithoutPoints(options, array);
    const int count = array.board.empty() ? 1 : array.board.back() + 1;
    for (int board = 0; board < count && !interrupted; ++board)
    {
        DriveSignal signal = device::silentSignal(array.size());
        for (int i = 0; i < array.size(); ++i)
            if (array.board.empty() || array.board[i] == board)
                signal.duty[i] = dutyOf(options.amplitude);
        silenceDead(array, signal);
        std::cout << "board " << board << " of " << count << std::endl;
        if (!device->send(signal)) return finish(*device);
        stay(base::steadySeconds() + options.seconds / count, *device);
    }
    return finish(*device);
}

// Plays each transducer in turn.
int playTransducers(const DeviceOptions& options)
{
    const auto array = loadArray(options);
    const auto device = openWithoutPoints(options, array);
    const double start_s = base::steadySeconds();
    for (int i = 0; i < array.size() && goesOn(1e300, *device); ++i)
    {
        DriveSignal signal = device::silentSignal(array.size());
        signal.duty[i] = dutyOf(options.amplitude);
        silenceDead(array, signal);
        device->send(signal);
        stay(start_s + (i + 1) * options.seconds / array.size(), *device);
    }
    return finish(*device);
}

// Moves a focus on a circle around the centre, or around a point 150 mm in front of a flat array.
int playCircle(const DeviceOptions& options)
{
    const auto array = loadArray(options);
    const auto device = open(options, array);
    const double k = base::kTwoPi * array.frequency_Hz / haptics::Medium{}.soundSpeed();
    const Eigen::Vector3d axis = array.normals.rowwise().mean();
    const Eigen::Vector3d centre =
        array.positions.rowwise().mean() + (axis.norm() > 0.5 ? 0.15 : 0.0) * axis.normalized();
    const Eigen::Vector3d normal =
        axis.norm() > 0.5 ? axis.normalized() : Eigen::Vector3d(Eigen::Vector3d::UnitY());
    const Eigen::Vector3d a = normal.unitOrthogonal();
    const Eigen::Vector3d b = normal.cross(a);
    const haptics::Medium medium;
    const device::DriveAbility ability = device->ability();
    std::optional<bridge::PressureCap> cap;
    if (ability.maxPressure_Pa > 0)
        cap.emplace(
            ability.maxPressure_Pa,
            [&](const DriveSignal& drive) { return wouldPlay(*device, drive); },
            ability);
    DriveSignal signal;
    const double start_s = base::steadySeconds();
    for (int i = 0; goesOn(start_s + options.seconds, *device); ++i)
    {
        const double angle = base::kTwoPi * options.turnsPerSecond * i / options.rate_Hz;
        const Eigen::Matrix3Xd point =
            centre + options.radius_m * (std::cos(angle) * a + std::sin(angle) * b);
        focus(array, k, point, options.amplitude, signal);
        if (cap) cap->hold({point, {&array}, medium}, signal);
        device->send(signal);
        pause(start_s + (i + 1) / options.rate_Hz);
    }
    return finish(*device);
}

// Sends random phases at the requested rate and prints what the device confirmed and how long
// fields waited before they were handed over.
int measureRates(const DeviceOptions& options)
{
    const auto array = loadArray(options);
    const auto device = openWithoutPoints(options, array);
    DriveSignal signal = device::silentSignal(array.size());
    std::fill(signal.duty.begin(), signal.duty.end(), dutyOf(options.amplitude));
    silenceDead(array, signal);
    std::vector<double> latencies_ms;
    double handedOver_s = 0;
    const double start_s = base::steadySeconds();
    int fields = 0;
    for (int i = 0; goesOn(start_s + options.seconds, *device); ++i, ++fields)
    {
        for (int t = 0; t < array.size(); ++t)
            signal.phase[t] = static_cast<std::uint8_t>(31 * t + 7 * i);
        device->send(signal);
        pause(start_s + (i + 1) / options.rate_Hz);
        const device::DeviceReport report = device->report();
        if (report.lastHandedOver_s != handedOver_s) latencies_ms.push_back(report.latency_s * 1e3);
        handedOver_s = report.lastHandedOver_s;
    }
    const double seconds = base::steadySeconds() - start_s;
    const device::DeviceReport report = device->report();
    std::sort(latencies_ms.begin(), latencies_ms.end());
    const auto at = [&](double share)
    {
        return latencies_ms.empty() ? 0.0
                                    : latencies_ms[static_cast<std::size_t>(
                                          share * static_cast<double>(latencies_ms.size() - 1))];
    };
    // Each of several devices counts its own fields.
    const double devices = std::max(1.0, std::round(double(report.sent) / std::max(1, fields)));
    std::cout << "sent      " << fields / seconds << " fields/s\n"
              << "played    " << static_cast<double>(report.played) / devices / seconds
              << " fields/s\n"
              << "dropped   " << report.dropped << "\nlost      " << report.lost << "\n"
              << "latency   median " << at(0.5) << " ms, 99 % " << at(0.99) << " ms, worst "
              << at(1) << " ms\n";
    if (report.worstSkew_s > 0)
        std::cout << "skew      " << report.skew_s * 1e3 << " ms, worst "
                  << report.worstSkew_s * 1e3 << " ms\n";
    return finish(*device);
}

} // namespace midair::samples
