#include "samples/tools/device/DeviceTool.h"

#include "device/DeviceUri.h"
#include "device/autd3/UdpLink.h"
#include "device/recording/PlayingDevice.h"
#include "device/usb/UsbTransferPool.h"
#include "engine-bridge/playing/unaided/UserDevice.h"
#include "haptics/array/PatFile.h"
#include "haptics/base/InputError.h"
#include "haptics/base/RegularFile.h"
#include "haptics/base/threads/SteadyClock.h"
#include "samples/tools/device/UltrainoSimulation.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <thread>
#include <utility>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

constexpr double kPoll_s = 0.05;
constexpr double kNever_s = 1e300;
constexpr double kSettle_s = 0.5; // for fields that are still in transit at the end
constexpr std::size_t kMostPatBytes = std::size_t(1) << 20;

bool isLost(const device::ArrayDevice& device)
{
    return device.report().state == device::DeviceState::LOST;
}

void waitForArray(const DeviceOptions& options, const device::ArrayDevice& device)
{
    if (!isLost(device)) return;
    const std::string why = device.report().message;
    std::cerr << "midair-device: waits for \"" << options.device << "\", at most "
              << options.seconds << " s" << (why.empty() ? "" : ": ") << why << std::endl;
    const double end_s = base::steadySeconds() + options.seconds;
    while (!interrupted && isLost(device) && base::steadySeconds() < end_s)
        pause(std::min(end_s, base::steadySeconds() + kPoll_s));
}

/// A device that plays by itself knows nothing of the array's dead transducers.
void refuseToDriveDead(const DeviceOptions& options, const haptics::TransducerArray& array)
{
    if (array.dead.empty() || !device::playsByItself(options.device)) return;
    throw device::DeviceError(fmt::format(
        "device \"{}\": plays by itself and would drive the {} dead transducers of array \"{}\"; "
        "\"midair-device play\" leaves them out",
        options.device,
        array.dead.size(),
        array.name));
}

} // namespace

std::atomic<bool> interrupted{false};

haptics::TransducerArray loadArray(const DeviceOptions& options)
{
    return haptics::TransducerArray::load(options.array);
}

std::unique_ptr<device::ArrayDevice> open(const DeviceOptions& options,
                                          const haptics::TransducerArray& array)
{
    refuseToDriveDead(options, array);
    auto device =
        bridge::openForUser(options.device, {array.size(), array.board, array.dead}, &array);
    waitForArray(options, *device);
    return device;
}

std::unique_ptr<device::ArrayDevice> openWithoutPoints(const DeviceOptions& options,
                                                       const haptics::TransducerArray& array,
                                                       const std::string& what)
{
    auto device = open(options, array);
    if (device->ability().maxPressure_Pa > 0)
        throw device::DeviceError("device \"" + options.device +
                                  "\": max-pressure can't be held, " + what +
                                  " has no control points; max-amplitude caps it");
    return device;
}

bool goesOn(double end_s, device::ArrayDevice& device)
{
    device.keepAlive();
    return !interrupted && base::steadySeconds() < end_s && !isLost(device);
}

void pause(double until_s)
{
    const double left_s = until_s - base::steadySeconds();
    if (left_s > 0) std::this_thread::sleep_for(std::chrono::duration<double>(left_s));
}

void stay(double end_s, device::ArrayDevice& device)
{
    while (goesOn(end_s, device))
        pause(std::min(end_s, base::steadySeconds() + kPoll_s));
}

int finish(device::ArrayDevice& device)
{
    const double end_s = base::steadySeconds() + kSettle_s;
    while (goesOn(end_s, device) && device.report().pending > 0)
        pause(base::steadySeconds() + kPoll_s / 10);
    const device::DeviceReport report = device.report();
    device.silence();
    std::cout << device.status() << std::endl;
    if (!report.shortfall.empty())
        std::cerr << "midair-device: only " << report.shortfall
                  << (report.message.empty() ? "" : ": ") << report.message << "\n";
    return report.state == device::DeviceState::LOST || !report.shortfall.empty() ? DEVICE_FAILED
                                                                                  : FINE;
}

int listDevices(const DeviceOptions&)
{
    int found = 0;
    const std::pair<const char*, device::UsbAddress> kinds[] = {
        {"usb:", {}}, {"openmpd:", device::kFifoAddress}}; // any FT232H may belong to a board
    for (const auto& kind : kinds)
        for (const device::UsbListing& one : device::listUsbDevices(kind.second))
        {
            std::cout << kind.first << one.serial << "\tbus " << one.bus << " address "
                      << one.address << "\t" << one.condition << "\n";
            ++found;
        }
    for (const device::autd3::UnitsListing& one : device::autd3::listUnits())
    {
        std::cout << "autd3:?interface=" << one.interface << "\t" << one.units
                  << (one.units == 1 ? " unit answers" : " units answer") << ", "
                  << (one.firmware.empty() ? "of another protocol" : "firmware " + one.firmware)
                  << "; more may be behind\n";
        ++found;
    }
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator("/dev", error))
    {
        const std::string name = entry.path().filename();
        if (name.rfind("ttyUSB", 0) != 0 && name.rfind("ttyACM", 0) != 0) continue;
        std::cout << entry.path().string()
                  << "\ta serial port, perhaps of a board: sonicsurface:" << entry.path().string()
                  << " or ultraino:" << entry.path().string() << "\n";
        ++found;
    }
    if (found == 0) std::cout << "nothing that could be an array is plugged in\n";
    return found == 0 ? NOTHING_FOUND : FINE;
}

int showStatus(const DeviceOptions& options)
{
    const auto array = loadArray(options);
    refuseToDriveDead(options, array);
    // What plays by itself does so while its status is shown.
    const auto device =
        device::playsByItself(options.device)
            ? openWithoutPoints(options, array, "a recording")
            : device::openDevice(options.device, {array.size(), array.board, array.dead});
    pause(base::steadySeconds() + 0.4); // time for the device to answer
    const device::DeviceReport report = device->report();
    std::cout << device->status() << "\n";
    std::cout << "firmware " << (report.firmware.empty() ? "unknown" : report.firmware) << "\n";
    return report.state == device::DeviceState::LOST ? DEVICE_FAILED : FINE;
}

int identifyBoards(const DeviceOptions& options)
{
    const auto array = loadArray(options);
    const int last = array.board.empty() ? 0 : array.board.back();
    if (options.board > last)
        throw device::DeviceError(
            fmt::format("board {} isn't there: the array has boards 0 to {}", options.board, last));
    const auto device = open(options, array);
    bool lit = false;
    const double end_s = base::steadySeconds() + options.seconds;
    while (goesOn(end_s, *device))
    {
        lit = !lit;
        if (!device->identify(options.board, lit))
        {
            std::cerr << "this device has no lamps\n";
            return DEVICE_FAILED;
        }
        pause(base::steadySeconds() + 0.25);
    }
    device->identify(options.board, false);
    return finish(*device);
}

// A limit that isn't understood is no reason to let an array play on.
int muteArray(const DeviceOptions& options)
{
    const auto array = loadArray(options);
    refuseToDriveDead(options, array);
    auto device = device::openDevice(options.device, {array.size(), array.board, array.dead});
    waitForArray(options, *device);
    device->setMuted(true);
    const int ended = finish(*device);
    device.reset(); // waits for a board that is still starting, which is not silent before
    if (ended == FINE) std::cout << "muted\n";
    return ended;
}

int playRecording(const DeviceOptions& options)
{
    const auto array = loadArray(options);
    if (device::playsByItself(options.device))
        throw device::DeviceError("device \"" + options.device +
                                  "\": a recording plays on an array, not on another recording");
    // Read before any device is opened, so that none can overwrite it by recording.
    device::recording::Show recording(options.file, array.size());
    device::PlayingDevice show(std::move(recording),
                               {1.0, false, array.dead},
                               openWithoutPoints(options, array, "a recording"));
    while (!show.finished() && goesOn(kNever_s, show))
        pause(base::steadySeconds() + kPoll_s);
    const device::DeviceReport report = show.report();
    const int code = finish(show);
    if (code != FINE)
        std::cerr << "midair-device: recording \"" << options.file << "\" was not played whole"
                  << (show.ending().empty() ? ": the device failed" : ": " + show.ending())
                  << (show.ending().empty() && !report.message.empty() ? ": " + report.message : "")
                  << "\n";
    return code;
}

int importPat(const DeviceOptions& options)
{
    const std::string text =
        base::readRegularFile(options.file, kMostPatBytes, options.file + ": ");
    const haptics::PatBoard board = haptics::readPat(text, options.file);
    board.array.save(options.out);
    std::cout << options.out << ": " << board.array.size()
              << " transducers; play on it with --array " << options.out
              << " --device openmpd:" << board.serial << "\n";
    return FINE;
}

int importUltraino(const DeviceOptions& options)
{
    const UltrainoSimulation made = readUltraino(
        base::readRegularFile(options.file, kMostUltrainoBytes, options.file + ": "), options.file);
    made.array.save(options.out);
    for (const std::string& note : made.notes)
        std::cerr << "midair-device: " << options.file << ": " << note << "\n";
    std::cout << options.out << ": " << made.array.size()
              << " transducers; play on it with --array " << options.out << "\n";
    return FINE;
}

} // namespace midair::samples
