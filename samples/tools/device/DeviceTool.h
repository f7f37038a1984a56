#pragma once

#include "device/ArrayDevice.h"
#include "haptics/array/TransducerArray.h"

#include <atomic>
#include <memory>
#include <string>

namespace midair::samples
{

/// Exit status of midair-device, for scripts.
enum DeviceExit
{
    FINE = 0,
    NOTHING_FOUND = 2,
    CANNOT_OPEN = 3,
    DEVICE_FAILED = 4
};

/// Options of midair-device.
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
    bool hasSeconds = false; ///< --seconds was given
    int units = 16;          ///< to be emulated
    int port = 44336;        ///< of ::1, which stands for the units' group
    std::string faults;      ///< of emulated units, as in a URI
};

/// Set by Ctrl-C; all commands then end.
extern std::atomic<bool> interrupted;

haptics::TransducerArray loadArray(const DeviceOptions& options);

/// Opens the device. If it may be missing (`usb:?wait=yes`) and is, prints that once and waits for
/// it for at most the options' seconds; after that its state is LOST.
std::unique_ptr<device::ArrayDevice> open(const DeviceOptions& options,
                                          const haptics::TransducerArray& array);

/// Like open(), but refuses a pressure cap, which can't be kept as \a what ("this pattern") has no
/// control points.
std::unique_ptr<device::ArrayDevice> openWithoutPoints(const DeviceOptions& options,
                                                       const haptics::TransducerArray& array,
                                                       const std::string& what = "this pattern");

/// Returns false at the end time, after Ctrl-C and when the device is lost.
/// Each call is a sign of life for the device.
bool goesOn(double end_s, device::ArrayDevice& device);
/// Waits as long as it goes on.
void stay(double end_s, device::ArrayDevice& device);
void pause(double until_s);

/// Silences the device and prints its status. Returns DEVICE_FAILED, with a message, if it is lost
/// or played less than half of the fields that it was sent.
int finish(device::ArrayDevice& device);

// The commands.
int listDevices(const DeviceOptions& options);
int showStatus(const DeviceOptions& options);
int identifyBoards(const DeviceOptions& options);
int muteArray(const DeviceOptions& options);
int playRecording(const DeviceOptions& options);
int importPat(const DeviceOptions& options);
int importUltraino(const DeviceOptions& options);
int emulateUnits(const DeviceOptions& options);
int playBoards(const DeviceOptions& options);
int playTransducers(const DeviceOptions& options);
int playCircle(const DeviceOptions& options);
int measureRates(const DeviceOptions& options);

} // namespace midair::samples
