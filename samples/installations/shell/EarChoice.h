#pragma once

#include "samples/installations/shell/InstallationOptions.h"

#include <osgMidair/HapticSettings>

#include <complex>
#include <memory>
#include <string>
#include <vector>

namespace midair::samples
{

/// Returns why an installation with \a settings may not start yet: what plays is no simulator, and
/// nobody has chosen an ear limit, or none, by a word of \a options or by OSG_MIDAIR_EAR_LIMIT.
/// Empty: it may.
std::string whyEarLimitIsMissing(const osgMidair::HapticSettings& settings,
                                 const InstallationOptions& options);

/// Returns true if \a device, or each of a list, plays in the computer alone: `sim:`, `null:`.
bool isSimulated(const std::string& device);

/// What an ear limit would do to fields, from those that were looked at.
struct EarNeed
{
    double radius_m = 0.0; ///< of the listening places around the array
    double level_dB = 0.0; ///< the loudest field at the loudest place; 0: nothing was heard
    /// No field was looked at, but all transducers at full drive with phases drawn by lot.
    bool isFullDrive = false;
    /// Of the field that a limit leaves least of: the share of the pressure that is left under the
    /// limits for the public and for workers, 0 .. 1.
    double publicShare = 1.0;
    double workersShare = 1.0;
};

/// Looks at fields of an array for what ear limits would leave of them.
class EarNeedMeter
{
public:
    /// The array and the listening places of \a settings. Throws base::InputError.
    explicit EarNeedMeter(const osgMidair::HapticSettings& settings);
    ~EarNeedMeter();

    /// \a fields are played in turn; each has m activations.
    void add(const std::vector<std::vector<std::complex<float>>>& fields);
    /// What was heard; full drive if nothing was.
    EarNeed need();

private:
    struct Listener;
    const std::unique_ptr<Listener> _listener;
    EarNeed _need;
};

/// Returns the lines that tell an operator what the limits are and what each would leave.
std::string describe(const EarNeed& need, const std::string& array);

} // namespace midair::samples
