// Tool for an array without a scene: lists devices, shows their status, plays test patterns and
// recordings, measures rates.

#include "device/ArrayDevice.h"
#include "device/DeviceUri.h"
#include "device/autd3/UdpLink.h"
#include "device/autd3/emulator/RehearsedAutd3.h"
#include "device/autd3/emulator/UdpUnits.h"
#include "device/drive/DriveEncoder.h"
#include "device/recording/PlayingDevice.h"
#include "device/usb/UsbTransferPool.h"
#include "engine-bridge/playing/PressureCap.h"
#include "engine-bridge/playing/unaided/UserDevice.h"
#include "haptics/array/Medium.h"
#include "haptics/array/PatFile.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/base/DutyLaw.h"
#include "haptics/base/Percentile.h"
#include "haptics/base/RegularFile.h"
#include "haptics/base/threads/SteadyClock.h"
#include "samples/shared/ToolOptions.h"
#include "samples/tools/device/UltrainoSimulation.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <exception>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

namespace
{

using namespace midair;
using namespace midair::samples;

/// Options of midair-device.
struct DeviceOptions
{
    std::string array = "octagon";
    std::string device; ///< empty: usb:, or sim: for a recording
    double seconds = 5;
    double rate_Hz = 500;
    double amplitude = 0.2;
    int board = -1;
    double radius_m = 0.02;
    double turnsPerSecond = 2;
    std::string file;
    std::string out;
    bool hasSeconds = false; ///< --seconds was given
    int units = 16;          ///< emulated units
    int port = 44336;        ///< of ::1, in place of the units' group
    std::string kind;        ///< what to emulate
    std::string faults;      ///< of emulated units, as in a URI
};

/// Set by Ctrl-C; ends all commands.
std::atomic<bool> interrupted{false};

constexpr double kPoll_s = 0.05;
constexpr double kNever_s = 1e300;
constexpr double kSettle_s = 0.5; // for fields still in transit at the end
constexpr std::size_t kMostPatBytes = std::size_t(1) << 20;

bool isLost(const device::ArrayDevice& device)
{
    return device.report().state == device::DeviceState::LOST;
}

void pause(double until_s)
{
    const double left_s = until_s - base::steadySeconds();
    if (left_s > 0) std::this_thread::sleep_for(std::chrono::duration<double>(left_s));
}

void waitForArray(const DeviceOptions& options, const device::ArrayDevice& device)
{
    if (!isLost(device)) return;
    const std::string why = device.report().message;
    std::cerr << "midair-device: waiting for \"" << options.device << "\", at most "
              << options.seconds << " s" << (why.empty() ? "" : ": ") << why << std::endl;
    const double end_s = base::steadySeconds() + options.seconds;
    while (!interrupted && isLost(device) && base::steadySeconds() < end_s)
        pause(std::min(end_s, base::steadySeconds() + kPoll_s));
}

/// A device that plays by itself doesn't know the array's dead transducers.
void refuseToDriveDead(const DeviceOptions& options, const haptics::TransducerArray& array)
{
    if (array.dead.empty() || !device::playsByItself(options.device)) return;
    throw device::DeviceError(
        fmt::format("device \"{}\": plays a recording, which would drive the {} dead transducers "
                    "of array \"{}\"; \"midair-device play\" leaves them out",
                    options.device,
                    array.dead.size(),
                    array.name));
}

using device::DriveSignal;

std::uint8_t dutyOf(double amplitude)
{
    return static_cast<std::uint8_t>(std::lround(base::dutyLevel(std::clamp(amplitude, 0.0, 1.0))));
}

// Test patterns don't drive dead transducers either.
void silenceDead(const haptics::TransducerArray& array, DriveSignal& signal)
{
    for (const int i : array.dead)
        signal.duty[static_cast<std::size_t>(i)] = 0;
}

// Focus: q_i = e^{+jk |r - r_i|}, so that all waves arrive at r with the same phase.
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
    silenceDead(array, signal);
}

Eigen::VectorXcf wouldPlay(const device::ArrayDevice& device, const DriveSignal& signal)
{
    const std::vector<std::complex<float>> q = device.wouldPlay(signal);
    return Eigen::Map<const Eigen::VectorXcf>(q.data(), static_cast<Eigen::Index>(q.size()));
}

using device::emulation::ChainReport;
using device::emulation::Time_ns;
using device::emulation::UdpUnits;

constexpr Time_ns kSecond_ns = 1'000'000'000;

device::emulation::ChainOptions optionsOf(const DeviceOptions& options)
{
    device::DeviceUri uri("autd3:?" + options.faults + (options.faults.empty() ? "" : "&") +
                              fmt::format("units={}", options.units),
                          "emulated units");
    auto defaults = device::emulation::ChainOptions::realistic(options.units);
    // This machine's network and CPU add their own delays, so the emulated ones are 0.
    defaults.wirePerByte_ns = 0;
    defaults.perFrame_ns = defaults.perWord_ns = 0;
    defaults.tolerance_ns = device::emulation::kMillisecond_ns;
    auto chain = device::emulation::takeChainOptions(uri, defaults);
    uri.rejectUnknown();
    return chain;
}

void printState(UdpUnits& units, const ChainReport& before, const ChainReport& now, double time_s)
{
    int assigned = 0;
    int locked = 0;
    int gated = 0;
    for (int place = 0; place < units.chain().units(); ++place)
    {
        const auto& unit = units.chain().unit(place);
        assigned += unit.id() != device::emulation::kNoId ? 1 : 0;
        locked += unit.isLocked() ? 1 : 0;
        gated += unit.fpga().gated() ? 1 : 0;
    }
    double power = 0;
    const auto output = units.chain().output(UdpUnits::now_ns());
    for (const std::complex<float>& q : output)
        power += std::norm(q);
    std::cout << fmt::format("{:.0f} s: ids {}, clocks {}, failsafe {} of {} units; {} fields "
                             "changed, {} torn; {} datagrams in, {} out; amplitude {:.3f} rms\n",
                             time_s,
                             assigned,
                             locked,
                             gated,
                             units.chain().units(),
                             now.fields.whole - before.fields.whole,
                             now.fields.torn - before.fields.torn,
                             now.fromHost - before.fromHost,
                             now.toHost - before.toHost,
                             std::sqrt(power / static_cast<double>(output.size())))
              << std::flush;
}

void printReport(const ChainReport& report)
{
    std::cout << fmt::format(
        "fields: {} changed on all units, at most {:.3f} ms apart; {} torn, the longest for {:.3f} "
        "ms\n"
        "writes into a bank that is playing or queued: {}, into the playing slot: {}\n"
        "datagrams: {} in, {} out, {} dropped by faults, {} to unknown ids, {} too many\n"
        "commands: {} done, {} errors, {} out of order, {} repeated, {} with more than 7 pending; "
        "{} of a firmware update\n"
        "failsafe tripped: {} times; clocks resynchronized: {}\n",
        report.fields.whole,
        double(report.fields.worstSkew_ns) / 1e6,
        report.fields.torn,
        double(report.fields.longestTear_ns) / 1e6,
        report.writesIntoBanks,
        report.writesIntoSlots,
        report.fromHost,
        report.toHost,
        report.dropped,
        report.unheard,
        report.tooMany,
        report.telemetry.done,
        report.telemetry.errors,
        report.telemetry.outOfTurn,
        report.telemetry.repeats,
        report.telemetry.queueFull,
        report.updateCommands,
        report.trips,
        report.telemetry.resync);
}

/// Opens the device. If it may be missing (`usb:?wait=yes`) and is, prints that once and waits at
/// most the options' seconds; its state is LOST if it doesn't come.
std::unique_ptr<device::ArrayDevice> open(const DeviceOptions& options,
                                          const haptics::TransducerArray& array)
{
    refuseToDriveDead(options, array);
    auto device =
        bridge::openForUser(options.device, {array.size(), array.board, array.dead}, &array);
    waitForArray(options, *device);
    return device;
}

/// Like open(), but refuses a pressure cap: \a what ("this pattern") has no control points for it.
std::unique_ptr<device::ArrayDevice> openWithoutPoints(const DeviceOptions& options,
                                                       const haptics::TransducerArray& array,
                                                       const std::string& what = "this pattern")
{
    auto device = open(options, array);
    if (device->ability().maxPressure_Pa > 0)
        throw device::DeviceError("device \"" + options.device +
                                  "\": max-pressure can't be enforced, because " + what +
                                  " has no control points; use max-amplitude");
    return device;
}

/// Returns false at the end time, after Ctrl-C or when the device is lost. Each call keeps the
/// device alive.
bool goesOn(double end_s, device::ArrayDevice& device)
{
    device.keepAlive();
    return !interrupted && base::steadySeconds() < end_s && !isLost(device);
}

/// Waits while goesOn().
void stay(double end_s, device::ArrayDevice& device)
{
    while (goesOn(end_s, device))
        pause(std::min(end_s, base::steadySeconds() + kPoll_s));
}

/// Silences the device and prints its status. Returns EXIT_DEVICE, with a message, if it is lost
/// or has played less than half of its fields.
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
    return report.state == device::DeviceState::LOST || !report.shortfall.empty() ? EXIT_DEVICE
                                                                                  : EXIT_DONE;
}

// The commands.

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
                  << (one.firmware.empty() ? "with another protocol" : "firmware " + one.firmware)
                  << "; there may be more units behind it\n";
        ++found;
    }
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator("/dev", error))
    {
        const std::string name = entry.path().filename();
        if (name.rfind("ttyUSB", 0) != 0 && name.rfind("ttyACM", 0) != 0) continue;
        std::cout << entry.path().string()
                  << "\ta serial port, possibly a board: sonicsurface:" << entry.path().string()
                  << " or ultraino:" << entry.path().string() << "\n";
        ++found;
    }
    if (found == 0) std::cout << "no array is plugged in\n";
    return found == 0 ? EXIT_PROBLEM : EXIT_DONE;
}

int showStatus(const DeviceOptions& options)
{
    const auto array = haptics::TransducerArray::load(options.array);
    refuseToDriveDead(options, array);
    // A device that plays by itself does so while its status is shown.
    const auto device =
        device::playsByItself(options.device)
            ? openWithoutPoints(options, array, "a recording")
            : device::openDevice(options.device, {array.size(), array.board, array.dead});
    pause(base::steadySeconds() + 0.4); // time for the device to answer
    const device::DeviceReport report = device->report();
    std::cout << device->status() << "\n";
    std::cout << "firmware " << (report.firmware.empty() ? "unknown" : report.firmware) << "\n";
    return report.state == device::DeviceState::LOST ? EXIT_DEVICE : EXIT_DONE;
}

int identifyBoards(const DeviceOptions& options)
{
    const auto array = haptics::TransducerArray::load(options.array);
    const int last = array.board.empty() ? 0 : array.board.back();
    if (options.board > last)
        throw device::DeviceError(
            fmt::format("there is no board {}: the array has boards 0 to {}", options.board, last));
    const auto device = open(options, array);
    bool lit = false;
    const double end_s = base::steadySeconds() + options.seconds;
    while (goesOn(end_s, *device))
    {
        lit = !lit;
        if (!device->identify(options.board, lit))
        {
            std::cerr << "this device has no lamps\n";
            return EXIT_DEVICE;
        }
        pause(base::steadySeconds() + 0.25);
    }
    device->identify(options.board, false);
    return finish(*device);
}

// Ignores the caps of the user's environment: an invalid one must not prevent a mute.
int muteArray(const DeviceOptions& options)
{
    const auto array = haptics::TransducerArray::load(options.array);
    refuseToDriveDead(options, array);
    auto device = device::openDevice(options.device, {array.size(), array.board, array.dead});
    waitForArray(options, *device);
    device->setMuted(true);
    const int ended = finish(*device);
    device.reset(); // waits for a board that is starting: it is not silent before
    if (ended == EXIT_DONE) std::cout << "muted\n";
    return ended;
}

int playRecording(const DeviceOptions& options)
{
    const auto array = haptics::TransducerArray::load(options.array);
    if (device::playsByItself(options.device))
        throw device::DeviceError("device \"" + options.device +
                                  "\": a recording can only be played on an array");
    // Read before any device is opened, so that none can overwrite it by recording.
    device::recording::Show recording(options.file, array.size());
    device::PlayingDevice show(std::move(recording),
                               {1.0, false, array.dead},
                               openWithoutPoints(options, array, "a recording"));
    while (!show.finished() && goesOn(kNever_s, show))
        pause(base::steadySeconds() + kPoll_s);
    const device::DeviceReport report = show.report();
    const int code = finish(show);
    if (code != EXIT_DONE)
        std::cerr << "midair-device: recording \"" << options.file << "\" was not played to its end"
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
    return EXIT_DONE;
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
    return EXIT_DONE;
}

// Plays each board in turn, with all its transducers in phase.
int playBoards(const DeviceOptions& options)
{
    const auto array = haptics::TransducerArray::load(options.array);
    const auto device = openWithoutPoints(options, array);
    const int count = array.board.empty() ? 1 : array.board.back() + 1;
    for (int board = 0; board < count && !interrupted; ++board)
    {
        DriveSignal signal = device::silentSignal(array.size());
        for (int i = 0; i < array.size(); ++i)
            if (array.board.empty() || array.board[i] == board)
                signal.duty[i] = dutyOf(options.amplitude);
        silenceDead(array, signal);
        std::cout << "board " << board << " of " << count << std::endl;
        if (!device->send(signal)) return finish(*device);
        stay(base::steadySeconds() + options.seconds / count, *device);
    }
    return finish(*device);
}

// Plays each transducer in turn.
int playTransducers(const DeviceOptions& options)
{
    const auto array = haptics::TransducerArray::load(options.array);
    const auto device = openWithoutPoints(options, array);
    const double start_s = base::steadySeconds();
    for (int i = 0; i < array.size() && goesOn(1e300, *device); ++i)
    {
        DriveSignal signal = device::silentSignal(array.size());
        signal.duty[i] = dutyOf(options.amplitude);
        silenceDead(array, signal);
        device->send(signal);
        stay(start_s + (i + 1) * options.seconds / array.size(), *device);
    }
    return finish(*device);
}

// Moves a focus on a circle around the centre, or around a point 150 mm in front of a flat array.
int playCircle(const DeviceOptions& options)
{
    const auto array = haptics::TransducerArray::load(options.array);
    const auto device = open(options, array);
    const double k = base::kTwoPi * array.frequency_Hz / haptics::Medium{}.soundSpeed();
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
    const double start_s = base::steadySeconds();
    for (int i = 0; goesOn(start_s + options.seconds, *device); ++i)
    {
        const double angle = base::kTwoPi * options.turnsPerSecond * i / options.rate_Hz;
        const Eigen::Matrix3Xd point =
            centre + options.radius_m * (std::cos(angle) * a + std::sin(angle) * b);
        focus(array, k, point, options.amplitude, signal);
        if (cap) cap->hold({point, {&array}, medium}, signal);
        device->send(signal);
        pause(start_s + (i + 1) / options.rate_Hz);
    }
    return finish(*device);
}

// Sends random phases at the requested rate and prints the confirmed rate and the time from send()
// to hand-over.
int measureRates(const DeviceOptions& options)
{
    const auto array = haptics::TransducerArray::load(options.array);
    const auto device = openWithoutPoints(options, array);
    DriveSignal signal = device::silentSignal(array.size());
    std::fill(signal.duty.begin(), signal.duty.end(), dutyOf(options.amplitude));
    silenceDead(array, signal);
    std::vector<double> latencies_ms;
    double handedOver_s = 0;
    const double start_s = base::steadySeconds();
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
    const double seconds = base::steadySeconds() - start_s;
    const device::DeviceReport report = device->report();
    const auto at = [&](double share) { return base::percentile(latencies_ms, share); };
    // The report sums up all devices, and each one counts its own fields.
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

int emulateUnits(const DeviceOptions& options)
{
    UdpUnits units(optionsOf(options), static_cast<std::uint16_t>(options.port));
    std::cout << fmt::format("{} emulated units: autd3:?units={}&group=[::1]:{}\n",
                             options.units,
                             options.units,
                             units.port())
              << std::flush;
    const Time_ns began_ns = UdpUnits::now_ns();
    const Time_ns end_ns = options.hasSeconds
                               ? began_ns + static_cast<Time_ns>(options.seconds * 1e9)
                               : device::emulation::kNever_ns;
    ChainReport before;
    for (Time_ns second_ns = began_ns; !interrupted && UdpUnits::now_ns() < end_ns;)
    {
        second_ns = std::min(second_ns + kSecond_ns, end_ns);
        while (!interrupted && UdpUnits::now_ns() < second_ns)
            units.run(second_ns);
        const ChainReport now = units.chain().report(UdpUnits::now_ns());
        printState(units, before, now, double(UdpUnits::now_ns() - began_ns) / 1e9);
        before = now;
    }
    printReport(units.chain().report(UdpUnits::now_ns()));
    return EXIT_DONE;
}

using Run = int (*)(const DeviceOptions&);

void addOptions(CLI::App& app, DeviceOptions& options)
{
    app.require_subcommand(1);
    app.add_option(
           "--array", options.array, "octagon, board, the name of a shipped array or a JSON file")
        ->capture_default_str();
    app.add_option("--device", options.device, "the device (default: usb:, or sim: for play)");
    app.add_option("--seconds", options.seconds, "duration, s")
        ->capture_default_str()
        ->check(CLI::Range(0.0, 1e6));
    app.add_option("--rate", options.rate_Hz, "fields per second")
        ->capture_default_str()
        ->check(CLI::Range(0.1, 1e5));
    app.add_option("--amplitude", options.amplitude, "share of full drive")
        ->capture_default_str()
        ->check(CLI::Range(0.0, 1.0));
    app.fallthrough();
}

/// \a chosen is set to the command on the command line.
void addCommands(CLI::App& app, DeviceOptions& options, Run& chosen)
{
    const auto command = [&](const char* name, const char* text, Run run)
    {
        CLI::App* sub = app.add_subcommand(name, text);
        sub->callback([&chosen, run] { chosen = run; });
        return sub;
    };
    command("list", "lists the devices that are plugged in", listDevices);
    command("status", "prints the device's status and firmware version", showStatus);
    command("identify", "blinks the lamp of one board, or of all", identifyBoards)
        ->add_option("--board", options.board, "number of the board (default: all)")
        ->check(CLI::Range(0, 65534));
    command("mute", "switches all transducers off", muteArray);
    command("boards", "plays one board after the other", playBoards);
    command("transducers", "plays one transducer after the other", playTransducers);
    CLI::App* circling = command("circle", "moves a focus on a circle", playCircle);
    circling->add_option("--radius", options.radius_m, "radius, m")->capture_default_str();
    circling->add_option("--turns", options.turnsPerSecond, "turns per second")
        ->capture_default_str();
    command("measure", "measures fields per second and latency", measureRates);
    command("play", "plays a recording (made with record:FILE) on the device", playRecording)
        ->add_option("FILE", options.file, "the recording")
        ->required();
    CLI::App* importing =
        command("import-pat", "converts an OpenMPD board's .pat file to an array file", importPat);
    importing->add_option("FILE", options.file, "the .pat file")->required();
    importing->add_option("--out", options.out, "the array file")->required();
    CLI::App* simulated = command("import-ultraino",
                                  "converts a simulation saved by Ultraino to an array file",
                                  importUltraino);
    simulated->add_option("FILE", options.file, "the .xml.gz file")->required();
    simulated->add_option("--out", options.out, "the array file")->required();
    CLI::App* emulating = command(
        "emulate", "emulates AUTD3 units on the network, until --seconds or Ctrl-C", emulateUnits);
    emulating->add_option("KIND", options.kind, "autd3")
        ->required()
        ->check(CLI::IsMember({"autd3"}));
    emulating->add_option("--units", options.units, "number of units")
        ->capture_default_str()
        ->check(CLI::Range(1, 64));
    emulating
        ->add_option("--port",
                     options.port,
                     "port of ::1 for the group; 0: any. Unit ids get their own ports")
        ->capture_default_str()
        ->check(CLI::Range(0, 65535));
    emulating->add_option(
        "--faults", options.faults, "faults to emulate, such as \"drop=0.01&reboot_at=5s\"");
}

int run(int argc, char** argv)
{
    device::registerRehearsedAutd3();
    DeviceOptions options;
    CLI::App app(
        "Lists and tests ultrasound arrays, and plays on them.\n"
        "Example: midair-device circle --device usb: --amplitude 0.2 --seconds 5\n"
        "Devices:\n" +
            device::deviceKinds() +
            "A comma-separated list opens several devices as one. "
            "?max-amplitude=0.2&max-pressure=800&ramp=50ms&mean-drive=0.3 limits any of them.\n"
            "Exit code: 0 done, 1 no array is plugged in, 2 a wrong option or file, 3 the device "
            "can't be "
            "opened, failed, or played less than half of the fields.",
        "midair-device");
    addOptions(app, options);
    Run chosen = nullptr;
    addCommands(app, options, chosen);
    int status = EXIT_DONE;
    if (!parseTool(app, argc, argv, status)) return status;
    options.hasSeconds = app.count("--seconds") > 0;
    const bool isSimulated = options.device.empty() && chosen == playRecording;
    if (isSimulated)
        std::cerr << "midair-device: playing on the simulator; choose an array with --device\n";
    if (options.device.empty()) options.device = isSimulated ? "sim:" : "usb:";
    for (const double number : {options.seconds,
                                options.rate_Hz,
                                options.amplitude,
                                options.radius_m,
                                options.turnsPerSecond})
        if (!std::isfinite(number)) // ranges accept nan
            return exitOf(app, CLI::ValidationError("options", "nan and inf are not allowed"));
    std::signal(SIGINT, [](int) { interrupted = true; });
    std::signal(SIGTERM, [](int) { interrupted = true; });
    return chosen(options);
}

} // namespace

int main(int argc, char** argv)
{
    try
    {
        return run(argc, argv);
    }
    catch (const device::DeviceError& error)
    {
        std::cerr << error.what() << "\n";
        return EXIT_DEVICE;
    }
    catch (const std::exception& error)
    {
        std::cerr << error.what() << "\n";
        return EXIT_WRONG;
    }
}