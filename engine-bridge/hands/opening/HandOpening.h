#pragma once

#include "device/DeviceUri.h"
#include "engine-bridge/hands/HandSource.h"
#include "engine-bridge/hands/openxr/OpenXrTracker.h"

#include <Eigen/Geometry>

#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace midair::bridge
{

/// Hand source that is opened on a separate thread, so that no frame waits for a file; until then
/// there are no hands. For one thread.
class OpeningHands : public HandSource
{
public:
    /// \a open runs in the thread; its exceptions are reported. \a name: for the status. The
    /// destructor waits for the thread, whose time is bounded by the readers' limits.
    OpeningHands(std::function<std::shared_ptr<HandSource>()> open, std::string name) :
        _name(std::move(name)),
        _opening(std::async(std::launch::async, std::move(open)))
    {
    }

    bool frameAt(double time_s, HandFrame& frame) override;
    std::string status() const override
    {
        return _source ? _source->status() : _name + ": not open";
    }
    std::vector<std::string> takeMessages() override { return std::exchange(_messages, {}); }

private:
    const std::string _name;
    std::future<std::shared_ptr<HandSource>> _opening; ///< not valid: it has ended
    std::shared_ptr<HandSource> _source;               ///< null until it is open
    std::vector<std::string> _messages;
};

/// Starts a recording at the time of the first query.
class FromItsBegin : public HandSource
{
public:
    explicit FromItsBegin(std::shared_ptr<HandSource> source) : _source(std::move(source)) {}

    bool frameAt(double time_s, HandFrame& frame) override
    {
        if (!_begun) _origin_s = time_s;
        _begun = true;
        return _source->frameAt(time_s - _origin_s, frame);
    }
    bool setHorizon(double ahead_s) override { return _source->setHorizon(ahead_s); }
    std::string status() const override { return _source->status(); }
    std::vector<std::string> takeMessages() override { return _source->takeMessages(); }

private:
    std::shared_ptr<HandSource> _source;
    bool _begun = false;
    double _origin_s = 0.0; ///< time of the first call
};

/// URI of a recording of hands: "recorded:FILE" is played once, "recorded:FILE?loop" is repeated.
struct RecordedUri
{
    std::string file;
    bool loops = false;

    /// Returns none if \a uri is another kind of hand source.
    static std::optional<RecordedUri> parse(const std::string& uri);
    std::string text() const;
};

/// \{ Takes parameters shared by sources of hands and heads: matrix=.., a rigid matrix as in
/// scenes, row by row, the translation last (\a otherwise if missing); loader= and space= of
/// "openxr:?..".
Eigen::Isometry3d takePlacement(device::DeviceUri& uri, const Eigen::Isometry3d& otherwise);
OpenXrOptions takeOpenXrOptions(device::DeviceUri& uri);
/// \}

/// Makes a hand source of the application from the text after the colon. An exception or null means
/// that there is none.
using HandSourceMaker = std::function<std::shared_ptr<HandSource>(const std::string& options)>;

/// Registers \a make for the source "NAME:.." of openHands(). Returns false, with the reason in \a
/// error, unless the name has 1 .. 32 small letters, digits and dashes and is free. Any thread.
bool registerHands(const std::string& name, HandSourceMaker make, std::string& error);

/// Returns true if registerHands() knows the name before the colon of \a uri. Any thread.
bool isOwnHands(const std::string& uri);
/// The registered names. Any thread.
std::vector<std::string> ownHandNames();

/// Returns an error if \a uri names no kind of hand source of this program; empty if it does, or is
/// "" or "none". Opens nothing. \a more: kinds that the caller opens itself, "mouse:".
std::string unknownHands(const std::string& uri, const std::vector<std::string>& more = {});

/// Opens the hand source \a uri: "recorded:FILE", "recorded:FILE?loop", "openxr:?..", "osc:?..", or
/// "NAME:.." of registerHands(); null for "" and "none". Throws base::InputError or
/// device::DeviceError, which name the URI, if it can't be opened. \a more: see unknownHands(), for
/// the error.
std::shared_ptr<HandSource> openHands(const std::string& uri,
                                      const std::vector<std::string>& more = {});

} // namespace midair::bridge
