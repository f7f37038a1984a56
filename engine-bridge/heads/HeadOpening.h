#pragma once

#include "engine-bridge/heads/HeadSource.h"

#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace midair::bridge
{

/// A recording of heads that is read on a separate thread, so that no frame waits for a file; until
/// then there is no head. It starts at the time of the first query. For one thread.
class OpeningHead : public HeadSource
{
public:
    /// \a open runs in the thread; its exceptions are reported. \a name: for the status. The
    /// destructor waits for the thread, whose time is bounded by the reader's limits.
    OpeningHead(std::function<std::shared_ptr<HeadSource>()> open, std::string name) :
        _name(std::move(name)),
        _opening(std::async(std::launch::async, std::move(open)))
    {
    }

    /// Plays \a source, an open recording.
    explicit OpeningHead(std::shared_ptr<HeadSource> source) : _source(std::move(source)) {}

    bool headAt(double time_s, Head& head) override;
    std::string status() const override
    {
        return _source ? _source->status() : _name + ": not open";
    }
    std::vector<std::string> takeMessages() override { return std::exchange(_messages, {}); }

private:
    const std::string _name;
    std::future<std::shared_ptr<HeadSource>> _opening; ///< not valid: it has ended
    std::shared_ptr<HeadSource> _source;               ///< null until it is open
    std::optional<double> _begin_s;                    ///< time of the first query; none: never
    std::vector<std::string> _messages;
};

/// Makes a head source of the application from the text after the colon. An exception or null means
/// that there is none.
using HeadSourceMaker = std::function<std::shared_ptr<HeadSource>(const std::string& options)>;

/// Registers \a make for the source "NAME:.." of openHead(). Returns false, with the reason in \a
/// error, unless the name has 1 .. 32 small letters, digits and dashes and is free. Any thread.
bool registerHeads(const std::string& name, HeadSourceMaker make, std::string& error);

/// Returns true if registerHeads() knows the name before the colon of \a text. Any thread.
bool isOwnHead(const std::string& text);
/// The registered names. Any thread.
std::vector<std::string> ownHeadNames();

/// Returns an error if \a text names no kind of head source of this program; empty if it does, or
/// is "" or "none". Opens nothing. \a more: kinds that the caller opens itself, "mouse:".
std::string unknownHead(const std::string& text, const std::vector<std::string>& more = {});

/// Opens the head source \a text: "fixed X Y Z" (metres, the scene's world), "recorded:FILE",
/// "recorded:FILE?loop", "tag:FILE", "openxr:?..", "osc:?..", or "NAME:.." of registerHeads(); null
/// for "" and "none". Throws base::InputError or device::DeviceError, which name the text, if it
/// can't be opened. \a more: see unknownHead(), for the error.
std::shared_ptr<HeadSource> openHead(const std::string& text,
                                     const std::vector<std::string>& more = {});

} // namespace midair::bridge
