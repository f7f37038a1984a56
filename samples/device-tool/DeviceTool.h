#pragma once

#include "device/ArrayDevice.h"
#include "haptics/array/TransducerArray.h"

#include <atomic>
#include <memory>
#include <string>

namespace midair::samples
{

/// How midair-device ends, for scripts.
enum DeviceExit
{
    FINE = 0,
    NOTHING_FOUND = 2,
    CANNOT_OPEN = 3,
    DEVICE_FAILED = 4
};

/// What midair-device was asked for.
struct DeviceOptions
{
    std::string array = "octagon";
    std::string device = "usb:";
    double seconds = 5;
    double rate_Hz = 500;
    double amplitude = 0.2;
    int board = -1;
    double radius_m = 0.02;
    double turnsPerSecond = 2;
    std::string file;
    std::string out;
};

/// Set by Ctrl-C: whatever runs comes to its end.
extern std::atomic<bool> interrupted;

haptics::TransducerArray loadArray(const DeviceOptions& options);

/// The device; where it is opened without being there (`usb:?wait=yes`), says so once and waits for
/// it, at most as long as the options' seconds. What then still isn't there is LOST.
std::unique_ptr<device::ArrayDevice> open(const DeviceOptions& options,
                                          const haptics::TransducerArray& array);

/// As open(); refuses a cap of pressure, which could be held nowhere: \a what ("this pattern") has
/// no control points.
std::unique_ptr<device::ArrayDevice> openWithoutPoints(const DeviceOptions& options,
                                                       const haptics::TransducerArray& array,
                                                       const std::string& what = "this pattern");

/// Ends at the time, at Ctrl-C and when the device is lost.
bool goesOn(double end_s, const device::ArrayDevice& device);
void pause(double until_s);

/// Silences the device and prints its status. DEVICE_FAILED where it is lost, or played none or
/// less than half of what it was sent, which is told.
int finish(device::ArrayDevice& device);

// The commands.
int listDevices(const DeviceOptions& options);
int showStatus(const DeviceOptions& options);
int identifyBoards(const DeviceOptions& options);
int muteArray(const DeviceOptions& options);
int playRecording(const DeviceOptions& options);
int importPat(const DeviceOptions& options);
// DevicePatterns.cpp
int playBoards(const DeviceOptions& options);
int playTransducers(const DeviceOptions& options);
int playCircle(const DeviceOptions& options);
int measureRates(const DeviceOptions& options);

} // namespace midair::samples
