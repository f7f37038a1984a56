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

/// How a source of what is tracked (Source: HandSource, HeadSource) is opened and called.
template<typename Source>
struct SourceKind
{
    /// Opens the source that a text names; null: none. Throws what is wrong with it. Must not wait
    /// for a file.
    std::function<std::shared_ptr<Source>(const std::string& text)> open;
    /// True for a source of the application's, which may be there later.
    bool (*isOwn)(const std::string& text);
    const char* name; ///< "hand source"
    const char* none; ///< what there isn't while it throws: "there are no hands"
};

/// The source in use: the one that the program has set, else the one that a setting names; and what
/// is wrong with it. A source is the application's code: what it throws is told, and isn't thrown
/// out of a frame. For one thread.
template<typename Source>
class NamedSource
{
public:
    explicit NamedSource(SourceKind<Source> kind) : _kind(std::move(kind)) {}

    /// Sets a source of the program's; null: none.
    void set(std::shared_ptr<Source> source)
    {
        if (source != _source) askNoLonger();
        _source = std::move(source);
    }

    /// Opens the source \a text. Returns what is wrong with it, once per change, or an empty text.
    /// One of the application's that can't be made is tried again by tryAgain(), with pauses from
    /// 1 s to 30 s; each try that fails is a message.
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

    /// Calls \a ask with the source, after it was asked for the time \a horizon_s ahead (below 0:
    /// that isn't left to it). Returns false if there is none, or if it has thrown.
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
    bool tellsLater() const { return _later == Later::YES; } ///< by the last ask()
    bool refusesLater() const { return active() && _later == Later::NO; }

    /// Returns what has happened since the last call.
    std::vector<base::Message> takeMessages()
    {
        std::vector<base::Message> messages;
        if (!std::exchange(_retry.isTold, true))
            messages.push_back({base::MessageCode::HANDS_OPEN, _retry.failed}); // once more
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

    /// Returns what is wrong with it now.
    std::vector<base::Message> troubles() const
    {
        std::vector<base::Message> all;
        if (!_source && !_retry.failed.empty())
            all.emplace_back(base::MessageCode::HANDS_OPEN, _retry.failed);
        if (active() && !_thrown.empty()) all.push_back(failure());
        return all;
    }

    /// One line of text; empty: there is none. What it throws is its status.
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
    // Between the tries of a source of the application's that can't be made.
    static constexpr double kLeastPause_s = 1.0;
    static constexpr double kMostPause_s = 30.0;

    /// When a source that could not be made is tried again.
    struct Retry
    {
        double at_s = 0.0;    ///< steady clock
        double pause_s = 0.0; ///< before it; 0: never
        std::string failed;   ///< why the last try has; empty: it has not
        bool isTold = true;   ///< \c failed, of a try after the first
    };
    /// What a source said when it was asked for a later time.
    enum class Later
    {
        NOT_ASKED,
        YES,
        NO
    };

    // Returns what is wrong; empty: nothing. The pauses before the tries to come double.
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

    // Asks the source for a later time if it is to predict, and for now when it isn't any longer.
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

    // Another source follows. What this one throws is of no interest any more.
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
    std::string _thrown; ///< by the source, in words; empty: nothing
};

/// How long it takes from locating what is tracked to the sound that is made for it.
struct TrackedDelay
{
    double tracker_s = 0.0; ///< the tracker's own
    double latency_s = 0.0; ///< from locating to the drive signal

    double total_s() const
    {
        // From the drive signal to the skin: 0.24 m of air, and the time in which a transducer's
        // amplitude comes up.
        constexpr double kSound_s = 0.7e-3 + 0.2e-3;
        return latency_s + tracker_s + kSound_s;
    }
};

} // namespace midair::bridge
