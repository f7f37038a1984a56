#include "device/autd3/protocol/Levels.h"

namespace midair::device::autd3
{

std::array<std::uint16_t, 256> dutyWidths()
{
    std::array<std::uint16_t, 256> widths{};
    for (unsigned duty = 0; duty < widths.size(); ++duty)
        widths[duty] = static_cast<std::uint16_t>((512 * duty + 255) / 510);
    return widths;
}

void toUnit(const DriveSignal& signal, int first, UnitPattern& pattern)
{
    for (std::size_t k = 0; k < pattern.phase.size(); ++k)
    {
        const std::size_t i = static_cast<std::size_t>(first) + k;
        pattern.intensity[k] = signal.duty[i];
        const std::uint8_t advance = signal.duty[i] == 0 ? std::uint8_t{0} : signal.phase[i];
        pattern.phase[k] = static_cast<std::uint8_t>(256U - advance);
    }
}

} // namespace midair::device::autd3
