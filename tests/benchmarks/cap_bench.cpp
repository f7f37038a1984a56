// What holding the fields of a cycle under a pressure cap takes: all fields are above it.

#include "device/drive/DriveEncoder.h"
#include "engine-bridge/playing/PressureCap.h"
#include "haptics/base/Percentile.h"
#include "haptics/base/threads/SteadyClock.h"

#include <cstdio>
#include <random>
#include <vector>

using namespace midair;

namespace
{

/// Random phases, amplitudes 0.5 .. 1.
std::vector<Eigen::VectorXcf> speckles(int count, int transducers, std::mt19937& random)
{
    std::uniform_real_distribution<float> phase(0.0f, 6.28f);
    std::uniform_real_distribution<float> amplitude(0.5f, 1.0f);
    std::vector<Eigen::VectorXcf> fields(static_cast<std::size_t>(count));
    for (Eigen::VectorXcf& q : fields)
    {
        q.resize(transducers);
        for (std::complex<float>& one : q)
            one = std::polar(amplitude(random), phase(random));
    }
    return fields;
}

void hold(int fields, int points)
{
    const haptics::TransducerArray array = haptics::TransducerArray::octagonalPrism();
    const haptics::Medium medium;
    std::mt19937 random(1);
    std::uniform_real_distribution<double> place(-0.03, 0.03);
    Eigen::Matrix3Xd where(3, points);
    for (double& one : where.reshaped())
        one = place(random);
    const auto wanted = speckles(fields, array.size(), random);
    const auto play = [](const device::DriveSignal& signal)
    {
        std::vector<std::complex<float>> q;
        device::decode(signal, q);
        return Eigen::VectorXcf(
            Eigen::Map<Eigen::VectorXcf>(q.data(), static_cast<Eigen::Index>(q.size())));
    };
    const bridge::PressureCap cap(500.0, play);
    std::vector<double> times_ms;
    double factor = 1.0;
    for (int round = 0; round < 3; ++round)
    {
        auto held = wanted;
        const double start_s = base::steadySeconds();
        factor = cap.holdAll({where, {&array}, medium}, held);
        times_ms.push_back(1e3 * (base::steadySeconds() - start_s));
    }
    std::printf("%3d fields, %4d points: %8.2f ms (best %.2f), factor %.4f\n",
                fields,
                points,
                base::percentile(times_ms, 0.5),
                base::percentile(times_ms, 0.0),
                factor);
}

} // namespace

int main()
{
    for (const int points : {50, 200})
        for (const int fields : {8, 64})
            hold(fields, points);
    return 0;
}
