#pragma once

#include "device/drive/DriveSignal.h"
#include "haptics/base/threads/Mutex.h"

#include <complex>
#include <vector>

namespace midair::device
{

/// The field that a device holds between two sends; starts silent. All members may be called from
/// any thread.
class HeldField
{
public:
    explicit HeldField(int transducers);

    int transducers() const { return _transducers; }
    void replace(const DriveSignal& signal); ///< \a signal has transducers() entries
    void clear();                            ///< sets all duties to 0
    bool silent() const;                     ///< true if all duties are 0
    std::vector<std::complex<float>> activations() const;

private:
    const int _transducers;
    mutable base::Mutex _mutex;
    DriveSignal _signal MIDAIR_GUARDED_BY(_mutex);
};

} // namespace midair::device
