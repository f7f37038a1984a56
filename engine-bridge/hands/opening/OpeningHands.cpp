#include "engine-bridge/hands/opening/OpeningHands.h"

#include "haptics/base/ThrownBy.h"
#include "haptics/base/threads/Mutex.h"

#include <utility>

namespace midair::bridge
{

OpeningHands::OpeningHands(std::function<std::shared_ptr<HandSource>()> open, std::string name) :
    _name(std::move(name)),
    _thread(
        [this, open = std::move(open)]
        {
            std::shared_ptr<HandSource> source;
            std::string error;
            try
            {
                source = open();
            }
            catch (...)
            {
                error = base::whatWasThrown();
            }
            const base::Lock lock(_mutex);
            _source = std::move(source);
            if (!error.empty()) _messages.push_back(error);
        })
{
}

OpeningHands::~OpeningHands()
{
    _thread.join();
}

bool OpeningHands::frameAt(double time_s, HandFrame& frame)
{
    frame.hands.clear();
    std::shared_ptr<HandSource> source;
    {
        const base::Lock lock(_mutex);
        source = _source;
    }
    return source && source->frameAt(time_s, frame);
}

std::string OpeningHands::status() const
{
    const base::Lock lock(_mutex);
    return _source ? _source->status() : _name + ": not open";
}

std::vector<std::string> OpeningHands::takeMessages()
{
    const base::Lock lock(_mutex);
    return std::exchange(_messages, {});
}

} // namespace midair::bridge
