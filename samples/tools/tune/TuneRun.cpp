#include "samples/tools/tune/TuneRun.h"

#include "device/ArrayDevice.h"
#include "device/drive/DriveEncoder.h"
#include "engine-bridge/playing/unaided/UserDevice.h"
#include "haptics/base/InputError.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/threads/SteadyClock.h"
#include "haptics/tuning/TuningReadings.h"
#include "samples/shared/ToolOptions.h"
#include "samples/shared/shards/LineJournal.h"
#include "samples/shared/shards/Shards.h"
#include "samples/shared/views/Signals.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <complex>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>

namespace midair::samples
{

namespace
{

using base::InputError;

constexpr int kTick_ms = 5;
constexpr std::size_t kMostBuffered = std::size_t(1) << 20;
const std::string kExec = "exec:";

[[noreturn]] void failSystem(const std::string& what)
{
    throw base::InputError(what + ": " + std::generic_category().message(errno));
}

/// Result of waiting for a line.
enum class LineState
{
    LINE,
    END,      ///< end of input
    TIME_OUT, ///< no line in time
    STOPPED   ///< the caller stopped
};

/// Lines from an instrument: stdin, a file, a pipe or a command.
class ReadingSource
{
public:
    /// \a name: "-" for stdin, "exec:COMMAND", or the path of a file or named pipe. Throws
    /// base::InputError.
    explicit ReadingSource(const std::string& name)
    {
        if (name == "-")
        {
            _in = STDIN_FILENO;
            _requests = STDOUT_FILENO;
        }
        else if (name.rfind(kExec, 0) == 0)
            run(name.substr(kExec.size()));
        else
            open(name);
    }

    /// Ends the command.
    ~ReadingSource()
    {
        if (_child > 0)
        {
            closeRequests();
            ::close(_in);
            ::kill(-_child, SIGTERM);
            ::kill(_child, SIGTERM);
            while (::waitpid(_child, nullptr, 0) < 0 && errno == EINTR)
            {
            }
        }
        else if (_in > STDERR_FILENO)
            ::close(_in);
    }

    ReadingSource(const ReadingSource&) = delete;
    ReadingSource& operator=(const ReadingSource&) = delete;

    /// Sends the instrument the row that plays now: to a command's stdin, or to stdout for "-". The
    /// instrument may ignore it.
    void request(const std::string& line)
    {
        const std::string text = line + "\n";
        for (std::size_t done = 0; _requests >= 0 && done < text.size();)
        {
            const ssize_t wrote = ::write(_requests, text.data() + done, text.size() - done);
            if (wrote > 0)
                done += static_cast<std::size_t>(wrote);
            else if (errno != EINTR) // nobody reads requests; readings may still come
                closeRequests();
        }
    }

    /// Waits for a line, at most \a limit_s. Calls \a goesOn every few milliseconds and stops when
    /// it returns false.
    LineState next(std::string& line, double limit_s, const std::function<bool()>& goesOn)
    {
        const double end_s = base::steadySeconds() + limit_s;
        for (;;)
        {
            if (take(line)) return LineState::LINE;
            if (_ended) return LineState::END;
            if (!goesOn()) return LineState::STOPPED;
            if (base::steadySeconds() > end_s) return LineState::TIME_OUT;
            _ended = !fill(kTick_ms);
        }
    }

    /// Drops all lines so far, for instruments that write by their own clock.
    void drop()
    {
        for (std::size_t before = 1; !_ended && before != _buffer.size();)
        {
            before = _buffer.size();
            _ended = !fill(0);
            // A fast instrument would refill the buffer forever.
            if (_buffer.size() > kMostBuffered / 2) break;
        }
        const std::size_t last = _buffer.rfind('\n');
        if (last != std::string::npos) _buffer.erase(0, last + 1);
    }

private:
    void open(const std::string& path)
    {
        struct stat about = {};
        if (::stat(path.c_str(), &about) != 0)
            failSystem("readings \"" + path + "\" can't be read");
        if (S_ISDIR(about.st_mode))
            throw base::InputError(
                "readings \"" + path +
                "\" is a folder; it should be a file, a named pipe, - or exec:COMMAND");
        // Opening the pipe for writing as well keeps it from ending when an instrument closes it.
        const bool isPipe = S_ISFIFO(about.st_mode);
        _in =
            ::open(path.c_str(), (isPipe ? O_RDWR : O_RDONLY) | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
        if (_in < 0) failSystem("readings \"" + path + "\" can't be read");
        _grows = S_ISREG(about.st_mode);
    }

    void run(const std::string& command)
    {
        if (command.empty())
            throw base::InputError("readings \"exec:\" has no command: exec:COMMAND");
        std::array<int, 2> to{}, from{};
        if (::pipe2(to.data(), O_CLOEXEC) != 0 || ::pipe2(from.data(), O_CLOEXEC) != 0)
            failSystem("no pipe to \"" + command + "\"");
        _child = ::fork();
        if (_child < 0) failSystem("\"" + command + "\" can't be run");
        if (_child == 0)
        {
            ::setpgid(0,
                      0); // Ctrl-C is the caller's, who ends the command when the array is silent
            ::dup2(to[0], STDIN_FILENO);
            ::dup2(from[1], STDOUT_FILENO);
            std::signal(SIGPIPE, SIG_DFL);
            ::execl("/bin/sh", "sh", "-c", command.c_str(), static_cast<char*>(nullptr));
            ::_exit(127);
        }
        ::close(to[0]);
        ::close(from[1]);
        _requests = to[1];
        _in = from[0];
    }

    void closeRequests()
    {
        if (_requests > STDERR_FILENO) ::close(_requests);
        _requests = -1;
    }

    bool take(std::string& line)
    {
        const std::size_t end = _buffer.find('\n');
        if (end == std::string::npos) return false;
        line = _buffer.substr(0, end);
        _buffer.erase(0, end + 1);
        return true;
    }

    /// Returns false at the end of input, except of a growing file.
    bool fill(int wait_ms)
    {
        pollfd polled{_in, POLLIN, 0};
        const int ready = ::poll(&polled, 1, wait_ms);
        if (ready <= 0) return true;
        std::array<char, 4096> bytes{};
        const ssize_t got = ::read(_in, bytes.data(), bytes.size());
        if (got > 0)
            _buffer.append(bytes.data(), static_cast<std::size_t>(got));
        else if (got == 0 && _grows)
            ::usleep(1000 * static_cast<useconds_t>(wait_ms));
        else if (got == 0 || (errno != EINTR && errno != EAGAIN))
            return false;
        return _buffer.size() < kMostBuffered;
    }

    int _in = -1;
    int _requests = -1;
    bool _grows = false; ///< a regular file, which may still grow
    bool _ended = false;
    pid_t _child = -1;
    std::string _buffer;
};

constexpr double kTick_s = 2e-4;
// Tolerance between played and wanted amplitude; a duty level is up to 0.006 of full drive.
constexpr float kAmplitude = 0.02F;

void sleepFor(double seconds)
{
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

/// Plays rows of a plan on a device and checks that they really play. Silences it on destruction.
class RowPlayer
{
public:
    /// Opens the device. Throws device::DeviceError.
    RowPlayer(const std::string& uri,
              const haptics::TuningPlan& plan,
              const haptics::TransducerArray& array) :
        _uri(uri),
        _plan(plan),
        _array(array),
        _device(device::playsByItself(uri)
                    ? throw device::DeviceError("device \"" + uri +
                                                "\": plays a recording and can't play a plan")
                    : bridge::openForUser(uri, {array.size(), array.board}, &array))
    {
        if (_device->ability().maxPressure_Pa > 0)
            throw device::DeviceError(
                "device \"" + uri +
                "\": max-pressure can't be enforced, because the rows of a plan have no control "
                "points; use max-amplitude or the plan's --duty");
    }

    /// Silences the device.
    ~RowPlayer() { _device->silence(); }

    RowPlayer(const RowPlayer&) = delete;
    RowPlayer& operator=(const RowPlayer&) = delete;

    /// Plays a row and waits, at most \a patience_s, until the device plays it. Returns false if
    /// \a goesOn does. Throws device::DeviceError if the device or its limits change the row.
    bool play(int row, double patience_s, const std::function<bool()>& goesOn)
    {
        const haptics::TuningDrive drive =
            haptics::driveOf(_plan, _plan.rows[static_cast<std::size_t>(row)], &_array);
        const device::DriveSignal signal{drive.phase, drive.duty};
        _wanted = _device->wouldPlay(signal);
        requireThatItCan(row, signal);
        _row = row;
        if (!_device->send(signal))
            throw device::DeviceError(
                fmt::format("device \"{}\": refuses row {}: {}", _uri, row, _device->status()));
        const double end_s = base::steadySeconds() + patience_s;
        while (!sounds())
        {
            if (!goesOn()) return false;
            const device::DeviceReport report = _device->report();
            if (report.state == device::DeviceState::LOST || base::steadySeconds() > end_s)
                throw device::DeviceError(
                    fmt::format("device \"{}\": row {} doesn't play as planned within {:g} s: {}. "
                                "If a limit such as mean-drive lowers it, plan with a lower --duty",
                                _uri,
                                row,
                                patience_s,
                                _device->status()));
            keepAlive();
            sleepFor(kTick_s);
        }
        _silences = _device->report().silences;
        return true;
    }

    /// Throws device::DeviceError if the row doesn't play now, or was interrupted.
    void requireThatItSounds()
    {
        if (sounds() && _device->report().silences == _silences) return;
        throw device::DeviceError(
            fmt::format("device \"{}\": row {} stopped playing before it was read: {}",
                        _uri,
                        _row,
                        _device->status()));
    }

    /// Keeps the row playing on a device with a hold time.
    void keepAlive() { _device->keepAlive(); }
    void silence() { _device->silence(); }

private:
    bool sounds() const
    {
        const device::DeviceReport report = _device->report();
        if (report.state != device::DeviceState::READY || report.pending > 0) return false;
        const std::vector<std::complex<float>> played = _device->played();
        if (played.size() != _wanted.size()) return false;
        for (std::size_t i = 0; i < played.size(); ++i)
            if (!(std::abs(played[i] - _wanted[i]) < kAmplitude)) return false;
        return true;
    }

    // The device must play the row as planned: readings of lowered rows would look like weak
    // transducers. Foci may have rounded phases.
    void requireThatItCan(int row, const device::DriveSignal& signal) const
    {
        std::vector<std::complex<float>> planned;
        device::decode(signal, planned);
        for (std::size_t i = 0; i < planned.size(); ++i)
        {
            const bool isAsPlanned =
                _plan.method == haptics::TuningMethod::FOCUS
                    ? std::abs(std::abs(_wanted[i]) - std::abs(planned[i])) <= kAmplitude
                    : std::abs(_wanted[i] - planned[i]) <= kAmplitude;
            if (isAsPlanned) continue;
            throw device::DeviceError(fmt::format(
                "device \"{}\": row {} has transducer {} at {:.2f} of full drive and phase level "
                "{}; the device's levels or limits change that to {:.2f} and {:.0f} of 256. Plan "
                "with a lower --duty",
                _uri,
                row,
                i,
                std::abs(planned[i]),
                signal.phase[i],
                std::abs(_wanted[i]),
                std::fmod(std::arg(_wanted[i]) / 6.2831853F * 256.0F + 256.0F, 256.0F)));
        }
    }

    const std::string _uri;
    const haptics::TuningPlan& _plan;
    const haptics::TransducerArray& _array;
    const std::unique_ptr<device::ArrayDevice> _device;
    std::vector<std::complex<float>> _wanted;
    int _row = -1;
    std::uint64_t _silences = 0;
};

constexpr double kSync_s = 0.5;

std::string lineOf(int row, std::complex<double> value, bool isLevel)
{
    const auto text = [](double number)
    { return std::isfinite(number) ? base::exactNumber(number) : std::string("nan"); };
    return isLevel ? fmt::format("{},{}\n", row, text(value.real()))
                   : fmt::format("{},{},{}\n", row, text(value.real()), text(value.imag()));
}

/// The file of readings of a run: each reading is appended at once, and the next run continues an
/// interrupted one.
class ReadingJournal
{
public:
    /// Opens or creates \a path. Throws base::InputError if another run uses it, if it belongs to
    /// another plan, or if it can't be read or written.
    ReadingJournal(const std::string& path,
                   const haptics::TuningPlan& plan,
                   const std::string& planSum) :
        _path(path),
        _plan(plan),
        _sum(planSum),
        _file(path, "readings"),
        _found(haptics::readingsFromCsv(_file.text(), _path, _plan))
    {
        if (_found.isTorn) _file.cutTornLine();
        if (_file.text().find('\n') == std::string::npos)
            write(fmt::format("# plan {}\n", _sum));
        else if (_found.planSum != _sum)
            throw base::InputError(fmt::format(
                "readings \"{}\" belong to {}, this plan is {}; choose another file with --out",
                _path,
                _found.planSum.empty() ? "an unknown plan" : "plan " + _found.planSum,
                _sum));
    }

    /// Returns the readings so far; rows without a number are still to be read.
    const haptics::TuningReadings& found() const { return _found; }
    bool isRead(int row) const { return std::isfinite(_found.values[row].real()); }

    /// Appends a reading. It survives a kill at once, and a power failure after half a second.
    /// Throws base::InputError if it can't be written.
    void append(int row, std::complex<double> value, bool isLevel)
    {
        write(lineOf(row, value, isLevel));
        _found.values[row] = value;
        _found.areLevels = isLevel;
    }

    /// Removes the readings of \a place so that it is read anew. The old file is kept as PATH.old.
    void forget(int place)
    {
        std::error_code error;
        std::filesystem::copy_file(
            _path, _path + ".old", std::filesystem::copy_options::overwrite_existing, error);
        if (error)
            throw base::InputError("readings \"" + _path + "\" can't be copied to \"" + _path +
                                   ".old\": " + error.message());
        std::string text = fmt::format("# plan {}\n", _sum);
        for (int row = 0; row < _plan.size(); ++row)
        {
            if (_plan.rows[static_cast<std::size_t>(row)].place == place)
                _found.values[row] = {std::nan(""), 0.0};
            else if (isRead(row))
                text += lineOf(row, _found.values[row], _found.areLevels);
        }
        _file.replace(text);
    }

private:
    void write(const std::string& text)
    {
        _file.append(text);
        const double now_s = base::steadySeconds();
        if (now_s - _synced_s < kSync_s) return;
        _file.sync();
        _synced_s = now_s;
    }

    const std::string _path;
    const haptics::TuningPlan& _plan;
    const std::string _sum;
    LineJournal _file;
    haptics::TuningReadings _found;
    double _synced_s = 0.0;
};

constexpr double kHeard_s = 0.2;     // until a signal is noticed
constexpr int kAgain = 8;            // rows of a place begun earlier to read again
constexpr double kMostChange = 0.25; // largest relative change of these

/// Plays and reads the rows.
class Run
{
public:
    Run(const RunOptions& options,
        const haptics::TuningPlan& plan,
        const std::string& sum,
        const haptics::TransducerArray& array) :
        _options(options),
        _plan(plan),
        _journal(options.out, plan, sum),
        _source(options.readings),
        _player(options.device, plan, array)
    {
        for (int row = 0; row < plan.size() && !_hasRead; ++row)
            _hasRead = _journal.isRead(row);
        _isLevel = _journal.found().areLevels;
        for (const std::string& note : _journal.found().notes())
            if (!_options.isQuiet && note.find("without a reading") == std::string::npos) say(note);
    }

    int run()
    {
        if (_options.begins && firstOpen() < _plan.size()) _journal.forget(placeOf(firstOpen()));
        for (;;)
        {
            const int first = firstOpen();
            if (first == _plan.size())
            {
                say(fmt::format("all {} rows are read: {}", _plan.size(), _options.out));
                return EXIT_DONE;
            }
            const int place = placeOf(first);
            if (!isSameAsBefore(place) || !readPlace(place)) return stopped();
            _player.silence();
            const int next = firstOpen();
            if (next == _plan.size() || _options.goesToAllPlaces) continue;
            say(fmt::format(
                "place {} is done. Move the microphone to place {}, {}, and repeat the command",
                place,
                placeOf(next),
                placeText(placeOf(next))));
            return EXIT_PROBLEM;
        }
    }

private:
    static void say(const std::string& text)
    {
        std::fputs(("midair-tune: " + text + "\n").c_str(), stderr);
    }

    int placeOf(int row) const { return _plan.rows[static_cast<std::size_t>(row)].place; }

    std::string placeText(int place) const
    {
        return fmt::format("({:.4f}, {:.4f}, {:.4f}) m",
                           _plan.places(0, place),
                           _plan.places(1, place),
                           _plan.places(2, place));
    }

    int firstOpen() const
    {
        int row = 0;
        while (row < _plan.size() && (_journal.isRead(row) || isUnclear(row)))
            ++row;
        return row;
    }

    bool isUnclear(int row) const // the next run tries again
    {
        return std::find(_unclear.begin(), _unclear.end(), row) != _unclear.end();
    }

    int stopped()
    {
        _player.silence();
        say(fmt::format("stopped, the array is silent; the same command continues with row {}",
                        firstOpen()));
        return EXIT_PROBLEM;
    }

    // A place begun in an earlier run continues only if microphone, gain and clock are unchanged:
    // some of its rows are read again to check.
    bool isSameAsBefore(int place)
    {
        std::vector<int> known;
        for (int row = 0; row < _plan.size(); ++row)
            if (placeOf(row) == place && _journal.isRead(row) &&
                _plan.rows[static_cast<std::size_t>(row)].dutyLevel > 0)
                known.push_back(row);
        double change = 0.0, all = 0.0;
        const std::size_t count = std::min<std::size_t>(kAgain, known.size());
        for (std::size_t k = 0; k < count; ++k)
        {
            const int row = known[k * known.size() / count];
            std::complex<double> value;
            if (!readRow(row, value)) return false;
            if (!std::isfinite(value.real())) continue;
            change += std::norm(value - _journal.found().values[row]);
            all += std::norm(_journal.found().values[row]);
        }
        if (change <= kMostChange * kMostChange * all) return true;
        throw InputError(fmt::format(
            "place {} was begun earlier, and {} of its rows now differ by {:.0f} %: the "
            "microphone, its gain or its clock has changed; --anew reads this place from the start",
            place,
            count,
            100.0 * std::sqrt(change / all)));
    }

    bool readPlace(int place)
    {
        if (!_options.isQuiet)
            say(fmt::format(
                "place {} of {}: microphone at {}", place, _plan.places.cols(), placeText(place)));
        std::uint64_t done = 0;
        for (int row = 0; row < _plan.size(); ++row)
            done += _journal.isRead(row) ? 1 : 0;
        Progress progress("rows", done, static_cast<std::uint64_t>(_plan.size()), _options.isQuiet);
        for (int row = 0; row < _plan.size(); ++row)
        {
            if (placeOf(row) != place || _journal.isRead(row)) continue;
            std::complex<double> value;
            if (!readRow(row, value)) return false;
            _journal.append(row, value, _isLevel);
            if (!std::isfinite(value.real())) _unclear.push_back(row);
            progress.add(1);
        }
        return true;
    }

    bool waits(double seconds)
    {
        const double end_s = base::steadySeconds() + seconds;
        for (double left_s = seconds; left_s > 0.0; left_s = end_s - base::steadySeconds())
        {
            if (!goesOn()) return false;
            std::this_thread::sleep_for(std::chrono::duration<double>(std::min(left_s, 5e-3)));
        }
        return true;
    }

    bool goesOn()
    {
        _player.keepAlive();
        return !isStopAsked();
    }

    /// Plays a row and takes its reading. Returns false after Ctrl-C.
    bool readRow(int row, std::complex<double>& value)
    {
        const auto on = [this] { return goesOn(); };
        if (!_player.play(row, _options.patience_s, on) || !waits(_options.settle_s)) return false;
        const std::string number = std::to_string(row);
        const Eigen::Vector3d place = _plan.places.col(placeOf(row));
        _source.request(fmt::format("{},{},{},{},{}",
                                    row,
                                    base::exactNumber(place.x()),
                                    base::exactNumber(place.y()),
                                    base::exactNumber(place.z()),
                                    base::exactNumber(_options.integrate_s)));
        if (!waits(_options.integrate_s)) return false;
        if (_options.isFreeRunning) _source.drop();
        std::string line;
        switch (_source.next(line, _options.patience_s, on))
        {
        case LineState::STOPPED:
            return false;
        case LineState::END:
            // Ctrl-C also reaches the command that reads, which may end before the signal is
            // noticed here.
            if (!waits(kHeard_s)) return false;
            throw InputError("the readings ended at row " + number);
        case LineState::TIME_OUT:
            throw InputError(
                fmt::format("no reading of row {} within {:g} s", row, _options.patience_s));
        case LineState::LINE:
            break;
        }
        _player.requireThatItSounds();
        return parse(row, line, value);
    }

    bool parse(int row, const std::string& line, std::complex<double>& value)
    {
        bool isLevel = false;
        if (!haptics::parseReading(line, value, isLevel))
            throw InputError(fmt::format(
                "the reading of row {} is \"{}\"; it should be re,im or a level", row, line));
        if (haptics::needsPhases(_plan.method) && isLevel)
            throw InputError(
                fmt::format("the reading of row {} is a level; the method {} needs re,im relative "
                            "to the drive's clock. Use the method levels for levels",
                            row,
                            haptics::tuningMethodName(_plan.method)));
        if (_options.clip > 0.0 && std::abs(value) >= 0.99 * _options.clip)
            throw InputError(
                fmt::format("the microphone clips: row {} reads {:g}, its limit is {:g}; plan with "
                            "a lower --duty, or move the microphone away",
                            row,
                            std::abs(value),
                            _options.clip));
        if (_hasRead && isLevel != _isLevel)
            throw InputError(fmt::format("the reading of row {} is {}, but earlier ones are {}",
                                         row,
                                         isLevel ? "a level" : "re,im",
                                         isLevel ? "re,im" : "levels"));
        _isLevel = isLevel;
        _hasRead = true;
        return true;
    }

    const RunOptions& _options;
    const haptics::TuningPlan& _plan;
    ReadingJournal _journal;
    ReadingSource _source;
    RowPlayer _player; // silenced before the others are destroyed
    const SilenceAtStop _atStop{[this] { _player.silence(); }};
    std::vector<int> _unclear;
    bool _hasRead = false, _isLevel = false;
};

} // namespace

int runPlan(const RunOptions& options,
            const haptics::TuningPlan& plan,
            const std::string& planSum,
            const haptics::TransducerArray& array)
{
    return Run(options, plan, planSum, array).run();
}

} // namespace midair::samples
