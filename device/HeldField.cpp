#include "device/HeldField.h"

#include "device/drive/DriveEncoder.h"

#include <algorithm>

namespace midair::device
{

HeldField::HeldField(int transducers) : _transducers(transducers)
{
    _signal.phase.assign(transducers, 0);
    _signal.duty.assign(transducers, 0);
}

void HeldField::replace(const DriveSignal& signal)
{
    const base::Lock lock(_mutex);
    _signal = signal;
}

void HeldField::clear()
{
    const base::Lock lock(_mutex);
    std::fill(_signal.duty.begin(), _signal.duty.end(), std::uint8_t(0));
}

bool HeldField::silent() const
{
    const base::Lock lock(_mutex);
    return std::all_of(
        _signal.duty.begin(), _signal.duty.end(), [](std::uint8_t duty) { return duty == 0; });
}

std::vector<std::complex<float>> HeldField::activations() const
{
    std::vector<std::complex<float>> q;
    const base::Lock lock(_mutex);
    decode(_signal, q);
    return q;
}

} // namespace midair::device
