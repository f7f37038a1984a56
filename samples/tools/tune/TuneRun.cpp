#include "samples/tools/tune/TuneRun.h"

#include "haptics/base/InputError.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/threads/SteadyClock.h"
#include "samples/shared/shards/Shards.h"
#include "samples/shared/views/Signals.h"
#include "samples/tools/tune/ReadingJournal.h"
#include "samples/tools/tune/ReadingSource.h"
#include "samples/tools/tune/RowPlayer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <thread>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

using base::InputError;

constexpr double kHeard_s = 0.2;     // until a signal that came is heard
constexpr int kAgain = 8;            // rows of a place begun earlier that are read again
constexpr double kMostChange = 0.25; // of what they then give, relative

/// Plays and reads rows.
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
                return TUNED;
            }
            const int place = placeOf(first);
            if (!isSameAsBefore(place) || !readPlace(place)) return stopped();
            _player.silence();
            const int next = firstOpen();
            if (next == _plan.size() || _options.goesToAllPlaces) continue;
            say(fmt::format(
                "place {} is read. Move the microphone to place {}, {}, and give the same "
                "command again",
                place,
                placeOf(next),
                placeText(placeOf(next))));
            return MORE_TO_DO;
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

    bool isUnclear(int row) const // in this run; the next run tries again
    {
        return std::find(_unclear.begin(), _unclear.end(), row) != _unclear.end();
    }

    int stopped()
    {
        _player.silence();
        say(fmt::format("stopped, the array is silent; the same command goes on with row {}",
                        firstOpen()));
        return MORE_TO_DO;
    }

    // A place begun in an earlier run goes on only if the microphone, its gain and its clock are as
    // they were: a few of its rows are read again.
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
        throw InputError(
            fmt::format("place {} was begun earlier, and {} of its rows are now {:.0f} % off: the "
                        "microphone, its "
                        "gain or its clock isn't as it was; --anew reads this place from its start",
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

    /// Plays a row and takes its reading; returns false after Ctrl-C.
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
            // Ctrl-C reaches a command that reads as well, which may end before it is heard here.
            if (!waits(kHeard_s)) return false;
            throw InputError("the readings ended at row " + number);
        case LineState::TIME_OUT:
            throw InputError(fmt::format(
                "there is no reading of row {} within {:g} s", row, _options.patience_s));
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
        const bool needsPhases = _plan.method == haptics::TuningMethod::SINGLE ||
                                 _plan.method == haptics::TuningMethod::HADAMARD;
        if (needsPhases && isLevel)
            throw InputError(fmt::format(
                "the reading of row {} is a level; the method {} needs re,im against the drive's "
                "clock, levels is the one without",
                row,
                haptics::tuningMethodName(_plan.method)));
        if (_options.clip > 0.0 && std::abs(value) >= 0.99 * _options.clip)
            throw InputError(
                fmt::format("the microphone clips: row {} reads {:g}, its limit is {:g}; "
                            "plan with a lower --duty, or move it away",
                            row,
                            std::abs(value),
                            _options.clip));
        if (_hasRead && isLevel != _isLevel)
            throw InputError(fmt::format("the reading of row {} is {}, those before it are {}; all "
                                         "should be of one kind",
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
    RowPlayer _player; // silent before all else ends
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
