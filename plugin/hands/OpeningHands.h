#pragma once

#include <osgMidair/HandSource>

#include <mutex>
#include <thread>

namespace osgMidair
{

/// Hand source that is opened on a separate thread, so that no frame waits for a file; until then
/// there are no hands.
class OpeningHands : public HandSource
{
public:
    explicit OpeningHands(const std::string& uri);

    bool getHands(double time, std::vector<Hand>& hands) override;
    std::string getStatus() const override;
    std::vector<std::string> takeMessages() override;

protected:
    /// waits for the reading thread, whose time the readers' limits bound
    ~OpeningHands() override;

private:
    const std::string _uri;
    /// time of the first getHands(): a recording begins there, not when it was read
    double _begin = 0.0;
    bool _begun = false;
    bool _opened = false; ///< the source has been asked for the hands at _begin
    mutable std::mutex _mutex;
    osg::ref_ptr<HandSource> _source; ///< null until it is open
    std::vector<std::string> _messages;
    std::thread _thread;
};

} // namespace osgMidair
