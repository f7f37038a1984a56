#pragma once

#include "device/drive/DriveSignal.h"

#include <vector>

namespace midair::device::autd3
{

/// A field, or a sequence of fields, for all units.
struct Job
{
    std::vector<DriveSignal> signals; ///< at least one; one: a field that stands
    int divider = 1;                  ///< of a sequence: a field lasts divider x 25 us
    double sentAt_s = 0;              ///< steady clock, at send()

    bool isSequence() const { return signals.size() > 1; }
};

} // namespace midair::device::autd3
