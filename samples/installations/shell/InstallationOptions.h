#pragma once

#include "samples/installations/shell/Installation.h"
#include "samples/shared/SettingOptions.h"
#include "samples/shared/monitor/MonitorOptions.h"

#include <cstdint>
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

} // namespace midair::samples
