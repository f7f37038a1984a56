#pragma once

#include "samples/shared/monitor/MonitorOptions.h"

#include <string>
#include <utility>
#include <vector>

namespace midair::samples
{

/// Options of the main sample.
struct DemoOptions
{
    std::string model; ///< a file that OSG reads; empty: the paper's star
    double size_m = 0.12;
    /// Settings of the scene and of the object's property: names and texts for
    /// HapticSettings::set() and HapticProperty::set(), in the order given. All others are those of
    /// the scene file or the defaults. Hands that are given as a file's name, FILE.csv, are here
    /// recorded:FILE.csv?loop.
    std::vector<std::pair<std::string, std::string>> scene;
    std::vector<std::pair<std::string, std::string>> object;
    /// wanted peak pressure of the object; 0: as loud as the field stays accurate
    double pressure_Pa = 0.0;
    /// numbers of overlays, by the names that HapticOverlays::setNumber() takes
    std::vector<std::pair<std::string, double>> numbers;
    std::vector<std::string> overlays; ///< words of the overlays to show; empty: all
    bool still = false;                ///< the object stays in the middle; so under recorded hands
    int frames = 0; ///< 0: 240 without a display; with one, until the window is closed
    std::string out = "build/out";
    bool headless = false;
    bool benchmark = false;
    double zoom = 1.0; ///< of pictures and window, towards the middle
    int width = 1200;
    int height = 800;
    MonitorOptions monitor;
};

/// Parses the command line. Returns false if the program should end, as help was requested or an
/// option is wrong; \a status is then its exit status.
bool parseDemoOptions(int argc, char** argv, DemoOptions& options, int& status);

} // namespace midair::samples
