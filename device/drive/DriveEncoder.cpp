#include "device/drive/DriveEncoder.h"

#include "device/drive/EncoderKernels.h"
#include "haptics/base/DutyLaw.h"
#include "haptics/base/Units.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace midair::device
{

MIDAIR_KERNEL(encodeLevels);
MIDAIR_KERNEL(allFinite);
MIDAIR_KERNEL(addDuties);

namespace
{

std::array<std::complex<float>, 256> makePhasors()
{
    std::array<std::complex<float>, 256> phasors;
    for (int level = 0; level < 256; ++level)
        phasors[level] = std::complex<float>(std::polar(1.0, base::kTwoPi * level / 256.0));
    return phasors;
}

} // namespace

bool encode(const std::complex<float>* q, int m, DriveSignal& signal)
{
    signal.phase.resize(m);
    signal.duty.resize(m);
    const auto* values =
        reinterpret_cast<const float*>(q); // complex<float> is two floats: [complex.numbers]
    if (!allFinite(values, 2 * m))
    {
        std::fill(signal.phase.begin(), signal.phase.end(), std::uint8_t(0));
        std::fill(signal.duty.begin(), signal.duty.end(), std::uint8_t(0));
        return false;
    }
    encodeLevels(values, m, signal.phase.data(), signal.duty.data());
    return true;
}

void decode(const DriveSignal& signal, std::vector<std::complex<float>>& q)
{
    static const auto kPhasors = makePhasors();
    const std::vector<float>& amplitudes = amplitudeLevels();
    q.resize(signal.phase.size());
    for (std::size_t i = 0; i < q.size(); ++i)
        q[i] = amplitudes[signal.duty[i]] * kPhasors[signal.phase[i]];
}

const std::vector<float>& amplitudeLevels()
{
    static const std::vector<float> kLevels = []
    {
        std::vector<float> levels(256);
        for (int level = 0; level < 256; ++level)
            levels[level] = static_cast<float>(base::dutyAmplitude(level));
        return levels;
    }();
    return kLevels;
}

void scaleDuties(const DriveSignal& signal, double gain, DriveSignal& scaled)
{
    scaled = signal;
    if (gain >= 1) return;
    std::array<std::uint8_t, 256> table{};
    for (int level = 1; level < 256; ++level)
    {
        const double exact = base::dutyLevel(std::max(0.0, gain) * base::dutyAmplitude(level));
        table[level] = static_cast<std::uint8_t>(exact + 1e-9);
    }
    for (std::uint8_t& duty : scaled.duty)
        duty = table[duty];
}

} // namespace midair::device
