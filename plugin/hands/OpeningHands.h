#pragma once

#include <osgMidair/HandSource>

#include <mutex>
#include <thread>

namespace osgMidair
{

/// A hand source that is opened on a thread of its own, so that no frame waits for a file; until
/// then there are no hands.
class OpeningHands : public HandSource
{
public:
    explicit OpeningHands(const std::string& uri);

    bool getHands(double time, std::vector<Hand>& hands) override;
    std::string getStatus() const override;
    std::vector<std::string> takeMessages() override;

protected:
    ~OpeningHands() override; ///< waits for the reading at hand, which the readers' limits bound

private:
    const std::string _uri;
    double _begin =
        0.0; ///< when hands were first asked for: a recording begins there, not when it was read
    bool _begun = false;
    bool _opened = false; ///< and its beginning told
    mutable std::mutex _mutex;
    osg::ref_ptr<HandSource> _source; ///< null until it is open
    std::vector<std::string> _messages;
    std::thread _thread;
};

} // namespace osgMidair
