#pragma once

#include "samples/installations/shell/Installation.h"
#include "samples/shared/SettingOptions.h"
#include "samples/shared/monitor/Monitor.h"

#include <osgMidair/HapticSettings>

#include <complex>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace midair::samples
{

/// Command-line options of all installations.
struct InstallationOptions
{
    std::string device;
    std::string array;
    std::string hands; ///< "demo": the simulated visitor; empty: OSG_MIDAIR_HANDS
    Given settings;    ///< names and texts of other settings of the scene
    std::vector<std::string> overlays;
    std::vector<std::pair<std::string, double>> numbers; ///< of overlays
    bool plain = false;    ///< no overlays, no keys except F8 and the installation's own
    bool muted = false;    ///< start muted
    double linger_s = 3.0; ///< how long the array plays on after the last hand
    std::string state;     ///< file that stores the mute; empty: none
    std::uint32_t seed = 1;
    std::string display; ///< display file, optionally with the prefix "sim:"; empty: an ordinary
                         ///< window
    int screen = 0;
    std::pair<int, int> size = {0, 0}; ///< of window or pictures; 0: full screen
    bool headless = false;
    int frames = 0;       ///< 0: 240 without a display, else until closed
    double minutes = 0.0; ///< alternative to frames, in real time
    int pictures = 6;
    std::string out = "build/out";
    MonitorOptions monitor;
};

/// Parses the command line. Returns false after --help or a wrong option; the program then exits
/// with \a status.
bool parseInstallationOptions(
    Installation& installation, int argc, char** argv, InstallationOptions& options, int& status);

/// Returns \a uri with hold=1s added to each device: it falls silent if no frame comes for a
/// second, e.g. when the program hangs. A device with its own `hold` stays unchanged. Throws
/// device::DeviceError if the list is too long.
std::string withHold(const std::string& uri);

/// Returns why an installation with \a settings may not start: the device is not a simulator, and
/// nobody has chosen an ear limit (or none) in \a options or OSG_MIDAIR_EAR_LIMIT. Returns an empty
/// text if it may.
std::string whyEarLimitIsMissing(const osgMidair::HapticSettings& settings,
                                 const InstallationOptions& options);

/// Returns true if all devices of the list \a device are simulated: `sim:`, `null:`.
bool isSimulated(const std::string& device);

/// The effect of ear limits on fields, from a sample of fields.
struct EarNeed
{
    double radius_m = 0.0; ///< distance of the listening places
    double level_dB = 0.0; ///< loudest field at the loudest place; 0: no field
    /// true if there were no fields; the figures are of all transducers at full drive with random
    /// phases
    bool isFullDrive = false;
    /// For the field that is lowered most: the remaining share of the pressure under the limits for
    /// the public and for workers, 0 .. 1.
    double publicShare = 1.0;
    double workersShare = 1.0;
};

/// Measures the effect of ear limits on an array's fields.
class EarNeedMeter
{
public:
    /// Uses the array and the listening places of \a settings. Throws base::InputError.
    explicit EarNeedMeter(const osgMidair::HapticSettings& settings);
    ~EarNeedMeter();

    /// Adds \a fields that are played in turn; each has m activations.
    void add(const std::vector<std::vector<std::complex<float>>>& fields);
    /// Returns the result, for full drive if there were no fields.
    EarNeed need();

private:
    struct Listener;
    const std::unique_ptr<Listener> _listener;
    EarNeed _need;
};

/// Returns a text for the operator: the limits and the remaining pressure under each.
std::string describe(const EarNeed& need, const std::string& array);

} // namespace midair::samples
