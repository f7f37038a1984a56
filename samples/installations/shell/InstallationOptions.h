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

/// What the command line of every installation says.
struct InstallationOptions
{
    std::string device;
    std::string array;
    std::string hands; ///< "demo": the installation's own; empty: as OSG_MIDAIR_HANDS says
    Given settings;    ///< other settings of the scene: names and texts
    std::vector<std::string> overlays;
    std::vector<std::pair<std::string, double>> numbers; ///< of overlays
    bool plain = false;    ///< no overlays, no keys but F8 and its own
    bool muted = false;    ///< begins muted
    double linger_s = 3.0; ///< how long the array goes on after the last hand was seen
    std::string state;     ///< file that keeps a mute; empty: none
    std::uint32_t seed = 1;
    std::string display; ///< file of a display, or "sim:" before it; empty: a window as any
    int screen = 0;
    std::pair<int, int> size = {0, 0}; ///< of window or pictures; 0: full screen
    bool headless = false;
    int frames = 0;       ///< 0: 240 without a display, else until it is closed
    double minutes = 0.0; ///< in place of frames, in real time
    int pictures = 6;
    std::string out = "build/out";
    MonitorOptions monitor;
};

/// Parses the command line. Returns false if the program should end, as help was requested or an
/// option is wrong; \a status is then its exit status.
bool parseInstallationOptions(
    Installation& installation, int argc, char** argv, InstallationOptions& options, int& status);

/// Returns the device of \a uri, or each of a list, with a limit of its own: silence once no frame
/// came for a second, so that a program that hangs is felt no longer than that. A device with
/// another `hold` stays as it is. Throws device::DeviceError for what is too long to be a list.
std::string withHold(const std::string& uri);

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
