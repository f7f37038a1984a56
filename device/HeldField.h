#pragma once

#include "device/drive/DriveSignal.h"

#include <complex>
#include <mutex>
#include <vector>

namespace midair::device
{

/// The field that a device holds between two sends, replaced whole under a lock; starts silent. All
/// calls from any thread.
class HeldField
{
public:
    explicit HeldField(int transducers);

    int transducers() const { return _transducers; }
    void replace(const DriveSignal& signal); ///< \a signal has transducers() entries
    void clear();                            ///< silent
    bool silent() const;
    std::vector<std::complex<float>> activations() const;

private:
    const int _transducers;
    mutable std::mutex _mutex;
    DriveSignal _signal;
};

} // namespace midair::device
