#pragma once

#include "haptics/base/ThrownBy.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/base/threads/SteadyClock.h"

#include <algorithm>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace midair::bridge
{

/// How a source of tracking data (Source: HandSource, HeadSource) is opened and called.
template<typename Source>
struct SourceKind
{
    /// Opens a source by its text; null: none. Throws on errors. Must not wait for a file.
    std::function<std::shared_ptr<Source>(const std::string& text)> open;
    /// True for a source of the application, which may become available later.
    bool (*isOwn)(const std::string& text);
    const char* name; ///< "hand source"
    const char* none; ///< state while it throws: "there are no hands"
};

/// The source in use (the one set by the program, otherwise the one named by a setting) and its
/// problems. A source may be application code: its exceptions are reported, and don't leave a
/// frame. For one thread.
template<typename Source>
class NamedSource
{
public:
    explicit NamedSource(SourceKind<Source> kind) : _kind(std::move(kind)) {}

    /// Sets a source of the program; null: none.
    void set(std::shared_ptr<Source> source)
    {
        if (source != _source) askNoLonger();
        _source = std::move(source);
    }

    /// Opens the source \a text. Returns its error, once per change, or an empty text. tryAgain()
    /// retries an application's source that can't be made, with pauses from 1 s to 30 s; each
    /// failure is reported.
    std::string setNamed(const std::string& text)
    {
        if (text == _text) return {};
        if (!_source) askNoLonger();
        _text = text;
        _retry = {};
        return open();
    }
    const std::string& named() const { return _text; }

    void tryAgain()
    {
        if (!(_retry.pause_s > 0.0) || _source || base::steadySeconds() < _retry.at_s) return;
        _retry.isTold = open().empty();
    }

    const std::shared_ptr<Source>& active() const { return _source ? _source : _namedSource; }

    /// Calls \a ask with the source, after requesting the time \a horizon_s ahead (below 0: the
    /// source doesn't predict). Returns false if there is none, or if it has thrown.
    template<typename Ask>
    bool ask(double horizon_s, Ask ask)
    {
        const std::shared_ptr<Source> source = active();
        if (!source) return false;
        _thrown = base::thrownBy(
            [&]
            {
                askAhead(*source, horizon_s);
                ask(*source);
            });
        return _thrown.empty();
    }
    bool tellsLater() const { return _later == Later::YES; } ///< of the last ask()
    bool refusesLater() const { return active() && _later == Later::NO; }

    /// Returns new messages.
    std::vector<base::Message> takeMessages()
    {
        std::vector<base::Message> messages;
        if (!std::exchange(_retry.isTold, true))
            messages.push_back({base::MessageCode::HANDS_OPEN, _retry.failed}); // report it again
        const std::shared_ptr<Source> source = active();
        if (!source) return messages;
        const std::string thrown = base::thrownBy(
            [&]
            {
                for (std::string& message : source->takeMessages())
                    messages.push_back({base::MessageCode::HANDS_SOURCE, std::move(message)});
            });
        if (!thrown.empty()) _thrown = thrown;
        return messages;
    }

    /// Returns its present problems.
    std::vector<base::Message> troubles() const
    {
        std::vector<base::Message> all;
        if (!_source && !_retry.failed.empty())
            all.emplace_back(base::MessageCode::HANDS_OPEN, _retry.failed);
        if (active() && !_thrown.empty()) all.push_back(failure());
        return all;
    }

    /// One line of text; empty: there is none. Its exception becomes its status.
    std::string status() const
    {
        const std::shared_ptr<Source> source = active();
        std::string text;
        const std::string thrown = base::thrownBy(
            [&]
            {
                if (source) text = source->status();
            });
        return thrown.empty() ? text : "its status has thrown " + thrown;
    }

private:
    // For retries of an application's source that can't be made.
    static constexpr double kLeastPause_s = 1.0;
    static constexpr double kMostPause_s = 30.0;

    /// Next retry of a source that could not be made.
    struct Retry
    {
        double at_s = 0.0;    ///< steady clock
        double pause_s = 0.0; ///< before the retry; 0: never
        std::string failed;   ///< why the last try failed; empty: it didn't
        bool isTold = true;   ///< \c failed, of a retry, was reported
    };
    /// Answer of a source to the request for a later time.
    enum class Later
    {
        NOT_ASKED,
        YES,
        NO
    };

    // Returns the error, or an empty text. The pauses before retries double.
    std::string open()
    {
        std::string error;
        _namedSource.reset();
        try
        {
            _namedSource = _kind.open(_text);
        }
        catch (const std::runtime_error& wrong) // InputError, DeviceError
        {
            error = wrong.what();
        }
        _retry.failed = error;
        _retry.pause_s = error.empty() || !_kind.isOwn(_text)
                             ? 0.0
                             : std::clamp(2.0 * _retry.pause_s, kLeastPause_s, kMostPause_s);
        _retry.at_s = base::steadySeconds() + _retry.pause_s;
        return error;
    }

    // Requests a later time from the source if it has to predict, and the present time when that
    // ends.
    void askAhead(Source& source, double horizon_s)
    {
        if (horizon_s < 0.0)
        {
            if (_later == Later::YES) source.setHorizon(0.0);
            _later = Later::NOT_ASKED;
            return;
        }
        if (_later == Later::NO) return;
        _later = source.setHorizon(horizon_s) ? Later::YES : Later::NO;
    }

    // Another source follows. Exceptions of this one no longer matter.
    void askNoLonger()
    {
        const std::shared_ptr<Source> source = active();
        if (source && _later == Later::YES) base::thrownBy([&] { source->setHorizon(0.0); });
        _later = Later::NOT_ASKED;
    }

    base::Message failure() const
    {
        const std::string name = _source || _text.empty()
                                     ? std::string("the application's ") + _kind.name
                                     : std::string(_kind.name) + " \"" + _text + "\"";
        return {base::MessageCode::HANDS_THREW,
                name + " has thrown " + _thrown + ": " + _kind.none + " while it does"};
    }

    const SourceKind<Source> _kind;
    std::shared_ptr<Source> _source;      ///< set by the program
    std::shared_ptr<Source> _namedSource; ///< named by the settings
    std::string _text;
    Retry _retry;
    Later _later = Later::NOT_ASKED;
    std::string _thrown; ///< exception of the source, as text; empty: none
};

/// Delay from locating hands or head to the sound made for them.
struct TrackedDelay
{
    double tracker_s = 0.0; ///< the tracker's own
    double latency_s = 0.0; ///< from locating to the drive signal

    /// From the drive signal to the skin: 0.24 m of air, and the rise time of a transducer's
    /// amplitude.
    static constexpr double kSound_s = 0.7e-3 + 0.2e-3;

    double total_s() const { return latency_s + tracker_s + kSound_s; }
};

} // namespace midair::bridge
