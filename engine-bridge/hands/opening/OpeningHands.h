#pragma once

#include "engine-bridge/hands/HandSource.h"
#include "haptics/base/threads/Mutex.h"

#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace midair::bridge
{

/// Hand source that is opened on a separate thread, so that no frame waits for a file; until then
/// there are no hands.
class OpeningHands : public HandSource
{
public:
    /// \a open: runs in the thread; what it throws is told. \a name: for the status.
    OpeningHands(std::function<std::shared_ptr<HandSource>()> open, std::string name);
    ~OpeningHands() override; ///< waits for the thread, whose time the readers' limits bound
    OpeningHands(const OpeningHands&) = delete;
    OpeningHands& operator=(const OpeningHands&) = delete;

    bool frameAt(double time_s, HandFrame& frame) override;
    std::string status() const override;
    std::vector<std::string> takeMessages() override;

private:
    const std::string _name;
    mutable base::Mutex _mutex;
    std::shared_ptr<HandSource> _source MIDAIR_GUARDED_BY(_mutex); ///< null until it is open
    std::vector<std::string> _messages MIDAIR_GUARDED_BY(_mutex);
    std::thread _thread; ///< last: it uses the other members
};

/// A recording begins when it is first asked for hands: of that time, 0 is the recording's.
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

} // namespace midair::bridge
