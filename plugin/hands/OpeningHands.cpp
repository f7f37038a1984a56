#include "plugin/hands/OpeningHands.h"

namespace osgMidair
{

OpeningHands::OpeningHands(const std::string& uri) :
    _uri(uri),
    _thread(
        [this]
        {
            std::string error;
            const osg::ref_ptr<HandSource> source = openHandSource(_uri, error);
            const std::lock_guard<std::mutex> lock(_mutex);
            _source = source;
            if (!error.empty()) _messages.push_back(error);
        })
{
}

OpeningHands::~OpeningHands()
{
    _thread.join();
}

bool OpeningHands::getHands(double time, std::vector<Hand>& hands)
{
    if (!_begun) _begin = time;
    _begun = true;
    hands.clear();
    osg::ref_ptr<HandSource> source;
    {
        const std::lock_guard<std::mutex> lock(_mutex);
        source = _source;
    }
    if (!source) return false;
    if (!_opened) source->getHands(_begin, hands);
    _opened = true;
    return source->getHands(time, hands);
}

std::string OpeningHands::getStatus() const
{
    const std::lock_guard<std::mutex> lock(_mutex);
    return _source ? _source->getStatus() : _uri + ": not open";
}

std::vector<std::string> OpeningHands::takeMessages()
{
    const std::lock_guard<std::mutex> lock(_mutex);
    std::vector<std::string> messages;
    messages.swap(_messages);
    return messages;
}

} // namespace osgMidair
