// Looks after an array without a scene: what is plugged in, how it fares, test patterns, rates, recordings.

#include "device/ArrayDevice.h"
#include "device/DriveEncoder.h"
#include "device/FieldCounters.h"
#include "device/UsbTransferPool.h"
#include "engine-bridge/PressureCap.h"
#include "haptics/Medium.h"
#include "haptics/TransducerArray.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <functional>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <thread>

#include <CLI/CLI.hpp>

namespace
{

using namespace midair;
using device::DriveSignal;

// For scripts.
enum Exit
{
    FINE = 0,
    NOTHING_FOUND = 2,
    CANNOT_OPEN = 3,
    DEVICE_FAILED = 4
};

std::atomic<bool> interrupted{false};

struct Options
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
};

haptics::TransducerArray loadArray(const Options& options)
{
    return haptics::TransducerArray::load(options.array);
}

std::unique_ptr<device::ArrayDevice> open(const Options& options,
                                          const haptics::TransducerArray& array)
{
    return device::openDevice(options.device, {array.size(), array.board});
}

// Where no control point is, there is nothing that a cap of pressure could be held at.
std::unique_ptr<device::ArrayDevice> openWithoutPoints(const Options& options,
                                                       const haptics::TransducerArray& array)
{
    auto device = open(options, array);
    if (device->ability().maxPressure_Pa > 0)
        throw device::DeviceError("device \"" + options.device +
                                  "\": max-pressure can't be held, this pattern has no control "
                                  "points; max-amplitude caps it");
    return device;
}

// Ends at the time, at Ctrl-C and when the device is lost.
bool goesOn(double end_s, const device::ArrayDevice& device)
{
    return !interrupted && device::steadySeconds() < end_s &&
           device.report().state != device::DeviceState::LOST;
}

void pause(double until_s)
{
    const double left_s = until_s - device::steadySeconds();
    if (left_s > 0) std::this_thread::sleep_for(std::chrono::duration<double>(left_s));
}

int finish(device::ArrayDevice& device)
{
    const bool lost = device.report().state == device::DeviceState::LOST;
    device.silence();
    std::cout << device.status() << "\n";
    return lost ? DEVICE_FAILED : FINE;
}

DriveSignal off(int transducers)
{
    DriveSignal signal;
    signal.phase.assign(transducers, 0);
    signal.duty.assign(transducers, 0);
    return signal;
}

std::uint8_t dutyOf(double amplitude)
{
    return static_cast<std::uint8_t>(
        std::lround(510 / M_PI * std::asin(std::clamp(amplitude, 0.0, 1.0))));
}

int list(const Options&)
{
    int found = 0;
    const std::pair<const char*, device::UsbAddress> kinds[] = {
        {"usb:", {}}, {"openmpd:", {0x0403, 0x6014, {}}}}; // any FT232H may be a board's
    for (const auto& kind : kinds)
        for (const device::UsbListing& one : device::listUsbDevices(kind.second))
        {
            std::cout << kind.first << one.serial << "\tbus " << one.bus << " address "
                      << one.address << "\t" << one.condition << "\n";
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

int status(const Options& options)
{
    const auto array = loadArray(options);
    const auto device = open(options, array);
    pause(device::steadySeconds() + 0.4); // until it has answered
    const device::DeviceReport report = device->report();
    std::cout << device->status() << "\n";
    std::cout << "firmware " << (report.firmware.empty() ? "unknown" : report.firmware) << "\n";
    return report.state == device::DeviceState::LOST ? DEVICE_FAILED : FINE;
}

int identify(const Options& options)
{
    const auto array = loadArray(options);
    const int last = array.board.empty() ? 0 : array.board.back();
    if (options.board > last)
        throw device::DeviceError("board " + std::to_string(options.board) +
                                  " isn't there: the array has boards 0 to " +
                                  std::to_string(last));
    const auto device = open(options, array);
    bool lit = false;
    const double end_s = device::steadySeconds() + options.seconds;
    while (goesOn(end_s, *device))
    {
        lit = !lit;
        if (!device->identify(options.board, lit))
        {
            std::cerr << "this device has no lamps\n";
            return DEVICE_FAILED;
        }
        pause(device::steadySeconds() + 0.25);
    }
    device->identify(options.board, false);
    return finish(*device);
}

int mute(const Options& options)
{
    const auto array = loadArray(options);
    const auto device = open(options, array);
    device->setMuted(true);
    std::cout << "muted\n";
    return finish(*device);
}

// Each board in turn, all its transducers in phase.
int boards(const Options& options)
{
    const auto array = loadArray(options);
    const auto device = openWithoutPoints(options, array);
    const int count = array.board.empty() ? 1 : array.board.back() + 1;
    for (int board = 0; board < count && !interrupted; ++board)
    {
        DriveSignal signal = off(array.size());
        for (int i = 0; i < array.size(); ++i)
            if (array.board.empty() || array.board[i] == board)
                signal.duty[i] = dutyOf(options.amplitude);
        std::cout << "board " << board << " of " << count << std::endl;
        if (!device->send(signal)) return finish(*device);
        const double end_s = device::steadySeconds() + options.seconds / count;
        while (goesOn(end_s, *device))
            pause(std::min(end_s, device::steadySeconds() + 0.05));
    }
    return finish(*device);
}

// Each transducer in turn.
int transducers(const Options& options)
{
    const auto array = loadArray(options);
    const auto device = openWithoutPoints(options, array);
    const double start_s = device::steadySeconds();
    for (int i = 0; i < array.size() && goesOn(1e300, *device); ++i)
    {
        DriveSignal signal = off(array.size());
        signal.duty[i] = dutyOf(options.amplitude);
        device->send(signal);
        pause(start_s + (i + 1) * options.seconds / array.size());
    }
    return finish(*device);
}

// All transducers in phase at a point: q_i = e^{+jk |r - r_i|}, so that all arrive with the same phase.
void focus(const haptics::TransducerArray& array,
           double k,
           const Eigen::Vector3d& r,
           double amplitude,
           DriveSignal& signal)
{
    std::vector<std::complex<float>> q(array.size());
    for (int i = 0; i < array.size(); ++i)
    {
        const double offset = array.phaseOffset_rad.size() > 0 ? array.phaseOffset_rad[i] : 0;
        q[i] = std::complex<float>(
            std::polar(amplitude, k * (r - array.positions.col(i)).norm() - offset));
    }
    device::encode(q.data(), array.size(), signal);
}

Eigen::VectorXcf wouldPlay(const device::ArrayDevice& device, const DriveSignal& signal)
{
    const std::vector<std::complex<float>> q = device.wouldPlay(signal);
    return Eigen::Map<const Eigen::VectorXcf>(q.data(), static_cast<Eigen::Index>(q.size()));
}

// A focus on a circle round the centre; for an array in one plane, round a point 150 mm in front of it.
int circle(const Options& options)
{
    const auto array = loadArray(options);
    const auto device = open(options, array);
    const double k = 2 * M_PI * array.frequency_Hz / haptics::Medium{}.soundSpeed();
    const Eigen::Vector3d axis = array.normals.rowwise().mean();
    const Eigen::Vector3d centre =
        array.positions.rowwise().mean() + (axis.norm() > 0.5 ? 0.15 : 0.0) * axis.normalized();
    const Eigen::Vector3d normal =
        axis.norm() > 0.5 ? axis.normalized() : Eigen::Vector3d(Eigen::Vector3d::UnitY());
    const Eigen::Vector3d a = normal.unitOrthogonal();
    const Eigen::Vector3d b = normal.cross(a);
    const haptics::Medium medium;
    const device::DriveAbility ability = device->ability();
    std::optional<bridge::PressureCap> cap;
    if (ability.maxPressure_Pa > 0)
        cap.emplace(
            ability.maxPressure_Pa,
            [&](const DriveSignal& drive) { return wouldPlay(*device, drive); },
            ability);
    DriveSignal signal;
    const double start_s = device::steadySeconds();
    for (int i = 0; goesOn(start_s + options.seconds, *device); ++i)
    {
        const double angle = 2 * M_PI * options.turnsPerSecond * i / options.rate_Hz;
        const Eigen::Matrix3Xd point =
            centre + options.radius_m * (std::cos(angle) * a + std::sin(angle) * b);
        focus(array, k, point, options.amplitude, signal);
        if (cap) cap->hold({point, {&array}, medium}, signal);
        device->send(signal);
        pause(start_s + (i + 1) / options.rate_Hz);
    }
    return finish(*device);
}

// Random phases as fast as asked for; what the device confirmed, and how long a field waited before it was handed over.
int measure(const Options& options)
{
    const auto array = loadArray(options);
    const auto device = openWithoutPoints(options, array);
    DriveSignal signal = off(array.size());
    std::fill(signal.duty.begin(), signal.duty.end(), dutyOf(options.amplitude));
    std::vector<double> latencies_ms;
    double handedOver_s = 0;
    const double start_s = device::steadySeconds();
    int fields = 0;
    for (int i = 0; goesOn(start_s + options.seconds, *device); ++i, ++fields)
    {
        for (int t = 0; t < array.size(); ++t)
            signal.phase[t] = static_cast<std::uint8_t>(31 * t + 7 * i);
        device->send(signal);
        pause(start_s + (i + 1) / options.rate_Hz);
        const device::DeviceReport report = device->report();
        if (report.lastHandedOver_s != handedOver_s) latencies_ms.push_back(report.latency_s * 1e3);
        handedOver_s = report.lastHandedOver_s;
    }
    const double seconds = device::steadySeconds() - start_s;
    const device::DeviceReport report = device->report();
    std::sort(latencies_ms.begin(), latencies_ms.end());
    const auto at = [&](double share)
    {
        return latencies_ms.empty() ? 0.0
                                    : latencies_ms[static_cast<std::size_t>(
                                          share * static_cast<double>(latencies_ms.size() - 1))];
    };
    // Of several devices each counts for itself.
    const double devices = std::max(1.0, std::round(double(report.sent) / std::max(1, fields)));
    std::cout << "sent      " << fields / seconds << " fields/s\n"
              << "played    " << static_cast<double>(report.played) / devices / seconds
              << " fields/s\n"
              << "dropped   " << report.dropped << "\nlost      " << report.lost << "\n"
              << "latency   median " << at(0.5) << " ms, 99 % " << at(0.99) << " ms, worst "
              << at(1) << " ms\n";
    if (report.worstSkew_s > 0)
        std::cout << "skew      " << report.skew_s * 1e3 << " ms, worst "
                  << report.worstSkew_s * 1e3 << " ms\n";
    return finish(*device);
}

int play(const Options& options)
{
    const auto array = loadArray(options);
    const auto show = device::openDevice("play:" + options.file + "?to=" + options.device,
                                         {array.size(), array.board});
    while (!interrupted && show->status().find("at the end") == std::string::npos)
        pause(device::steadySeconds() + 0.05);
    return finish(*show);
}

} // namespace

int main(int argc, char** argv)
{
    Options options;
    CLI::App app(
        "Looks after an ultrasound array. Devices:\n" + device::deviceKinds() +
        "A list with commas opens several as one; "
        "?max-amplitude=0.2&max-pressure=800&ramp=50ms&mean-drive=0.3 limit any of them.\n"
        "Exit codes: 0 fine, 2 nothing found, 3 can't be opened, 4 the device failed, over 100 "
        "called wrongly.");
    app.require_subcommand(1);
    app.add_option(
           "--array", options.array, "octagon, board, a shipped array's name or a JSON file")
        ->capture_default_str();
    app.add_option("--device", options.device, "which device")->capture_default_str();
    app.add_option("--seconds", options.seconds, "how long")
        ->capture_default_str()
        ->check(CLI::Range(0.0, 1e6));
    app.add_option("--rate", options.rate_Hz, "fields a second")
        ->capture_default_str()
        ->check(CLI::Range(0.1, 1e5));
    app.add_option("--amplitude", options.amplitude, "of full drive")
        ->capture_default_str()
        ->check(CLI::Range(0.0, 1.0));
    app.fallthrough();
    int (*chosen)(const Options&) = nullptr;
    const auto command = [&](const char* name, const char* text, int (*run)(const Options&))
    {
        CLI::App* sub = app.add_subcommand(name, text);
        sub->callback([&chosen, run] { chosen = run; });
        return sub;
    };
    command("list", "what is plugged in", list);
    command("status", "how the device fares, and its firmware's version", status);
    command("identify", "blinks the lamp of a board, or of all", identify)
        ->add_option("--board", options.board, "which board")
        ->check(CLI::Range(0, 65534));
    command("mute", "takes all transducers off", mute);
    command("boards", "one board after the other sounds", boards);
    command("transducers", "one transducer after the other sounds", transducers);
    CLI::App* circling = command("circle", "a focus walks on a circle", circle);
    circling->add_option("--radius", options.radius_m, "m")->capture_default_str();
    circling->add_option("--turns", options.turnsPerSecond, "a second")->capture_default_str();
    command("measure", "fields a second and latency", measure);
    command("play", "plays a recording (made with record:FILE) on the device", play)
        ->add_option("FILE", options.file, "the recording")
        ->required();
    CLI11_PARSE(app, argc, argv);
    std::signal(SIGINT, [](int) { interrupted = true; });
    std::signal(SIGTERM, [](int) { interrupted = true; });
    try
    {
        return chosen(options);
    }
    catch (const std::exception& error)
    {
        std::cerr << error.what() << "\n";
        return CANNOT_OPEN;
    }
}
