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
/// then there is no head. It begins when it is first asked: of that time, 0 is the recording's. For
/// one thread.
class OpeningHead : public HeadSource
{
public:
    /// \a open: runs in the thread; what it throws is told. \a name: for the status. The destructor
    /// waits for the thread, whose time the reader's limits bound.
    OpeningHead(std::function<std::shared_ptr<HeadSource>()> open, std::string name) :
        _name(std::move(name)),
        _opening(std::async(std::launch::async, std::move(open)))
    {
    }

    /// Plays \a source, a recording that is open.
    explicit OpeningHead(std::shared_ptr<HeadSource> source) : _source(std::move(source)) {}

    bool headAt(double time_s, Head& head) override;
    std::string status() const override
    {
        return _source ? _source->status() : _name + ": not open";
    }
    std::vector<std::string> takeMessages() override { return std::exchange(_messages, {}); }

private:
    const std::string _name;
    std::future<std::shared_ptr<HeadSource>> _opening; ///< not valid: it has come to its end
    std::shared_ptr<HeadSource> _source;               ///< null until it is open
    std::optional<double> _begin_s;                    ///< when it was first asked; none: never
    std::vector<std::string> _messages;
};

/// Makes a head source of the application's from what stands behind the colon of its text. Whatever
/// it throws, and null, mean that there is none.
using HeadSourceMaker = std::function<std::shared_ptr<HeadSource>(const std::string& options)>;

/// From now on openHead() makes the source "NAME:.." by \a make. Returns false, with the reason in
/// \a error, if the name has another form than 1 .. 32 small letters, digits and dashes, or is
/// taken. Any thread.
bool registerHeads(const std::string& name, HeadSourceMaker make, std::string& error);

/// Returns true if registerHeads() knows what stands before the colon of \a text. Any thread.
bool isOwnHead(const std::string& text);
/// The registered names. Any thread.
std::vector<std::string> ownHeadNames();

/// Returns what is wrong with \a text if it names no kind of head source that this program has;
/// empty if it does, or is "" or "none". Opens nothing. \a more: kinds that the caller opens
/// itself, "mouse:".
std::string unknownHead(const std::string& text, const std::vector<std::string>& more = {});

/// Opens the head source that \a text names: "fixed X Y Z" (metres, the scene's world),
/// "recorded:FILE", "recorded:FILE?loop", "openxr:?..", "osc:?..", or "NAME:.." of registerHeads();
/// null for "" and "none". Throws base::InputError or device::DeviceError, which name the text,
/// where it can't be opened. \a more: as of unknownHead(), for the error.
std::shared_ptr<HeadSource> openHead(const std::string& text,
                                     const std::vector<std::string>& more = {});

} // namespace midair::bridge
